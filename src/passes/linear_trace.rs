//! The linear marches of thesis §4.2.2 for every ray, and a mirror lookup where they end.

use super::{GBuffer, HiZ, Hits, Reflection, TracedImages};
use crate::error::Result;
use crate::gpu::shader::{
    THESIS_LINEAR_FIXED_FRAG, THESIS_LINEAR_FIXED_HITS_FRAG, THESIS_LINEAR_GROWING_FRAG,
    THESIS_LINEAR_GROWING_HITS_FRAG, ThesisBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Resource};
use crate::parameter::choices;

choices! {
    /// Which of the two listings marches.
    pub enum LinearMarch {
        /// The second: a stride that grows, and a binary search.
        Growing = "growing",
        /// The first: a constant stride, and nothing after it.
        Fixed = "fixed",
    }
}

/// Pipeline and images of one size.
pub struct LinearTracePass {
    pipeline: GraphicsPipeline,
    images: TracedImages,
}

impl LinearTracePass {
    /// With the hits or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], march: LinearMarch, with_hits: bool) -> Result<Self> {
        let shader = match (march, with_hits) {
            (LinearMarch::Growing, false) => &THESIS_LINEAR_GROWING_FRAG,
            (LinearMarch::Growing, true) => &THESIS_LINEAR_GROWING_HITS_FRAG,
            (LinearMarch::Fixed, false) => &THESIS_LINEAR_FIXED_FRAG,
            (LinearMarch::Fixed, true) => &THESIS_LINEAR_FIXED_HITS_FRAG,
        };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, shader, TracedImages::formats(with_hits))?,
            images: TracedImages::new(gpu, extent, with_hits)?,
        })
    }

    /// Pass "ray trace".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        depth: HiZ,
        parameters: &ThesisBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        frame.fullscreen(
            "ray trace",
            &self.pipeline,
            &self.images.targets(),
            &[
                ("thesis", Resource::Uniform(bytemuck::bytes_of(parameters))),
                ("hiZBuffer", Resource::trilinear(depth.0.level(0))),
                ("normalBuffer", Resource::nearest(gbuffer.normal.all())),
                ("materialBuffer", Resource::nearest(gbuffer.material.all())),
                ("colorBuffer", Resource::trilinear(gbuffer.color.level(0))),
            ],
            &[],
        )?;
        Ok(self.images.traced())
    }
}
