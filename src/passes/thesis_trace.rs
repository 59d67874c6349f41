//! Ray tracing and cone tracing of `ssct` and `hzct` (thesis §4.2.2, 4.2.7–4.2.10), in one shader
//! as the thesis combined them, or split in two.

use super::{ColorChain, GBuffer, HITS, HiZ, Hits, Reflection, Visibility};
use crate::error::Result;
use crate::gpu::shader::{
    THESIS_CONE_TRACE_FRAG, THESIS_HZCT_FRAG, THESIS_HZCT_RAY_TRACE_FRAG, THESIS_SSCT_FRAG, THESIS_SSCT_RAY_TRACE_FRAG,
    ThesisBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Resource, Target};
use ash::vk;

const REFLECTION: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pipelines and images of one size.
pub struct ThesisTracePass {
    stages: Stages,
    reflection: Image,
}

enum Stages {
    Combined(GraphicsPipeline),
    Split { trace: GraphicsPipeline, cone: GraphicsPipeline, hits: Box<Image> },
}

/// What the pass reads.
#[derive(Clone, Copy)]
pub struct TraceInput<'a> {
    /// Normals and materials.
    pub gbuffer: GBuffer<'a>,
    /// Depth chain.
    pub hi_z: HiZ<'a>,
    /// Visibility chain.
    pub visibility: Visibility<'a>,
    /// Colour chain.
    pub color: ColorChain<'a>,
}

impl ThesisTracePass {
    /// With or without the linear fallback; combined or split.
    pub fn new(gpu: &Gpu, extent: [u32; 2], fallback: bool, split: bool) -> Result<Self> {
        let image = |name, format| Image::target(gpu, name, format, extent);
        let stages = if split {
            let trace = if fallback { &THESIS_SSCT_RAY_TRACE_FRAG } else { &THESIS_HZCT_RAY_TRACE_FRAG };
            Stages::Split {
                trace: GraphicsPipeline::fullscreen(gpu, trace, &[HITS])?,
                cone: GraphicsPipeline::fullscreen(gpu, &THESIS_CONE_TRACE_FRAG, &[REFLECTION])?,
                hits: Box::new(image("hits", HITS)?),
            }
        } else {
            let shader = if fallback { &THESIS_SSCT_FRAG } else { &THESIS_HZCT_FRAG };
            Stages::Combined(GraphicsPipeline::fullscreen(gpu, shader, &[REFLECTION])?)
        };
        Ok(Self { stages, reflection: image("reflection", REFLECTION)? })
    }

    /// Pass "trace+cone", or passes "ray trace" and "cone trace", which also give the hits.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        input: &TraceInput,
        parameters: &ThesisBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let block = Resource::Uniform(bytemuck::bytes_of(parameters));
        let traced = [
            ("thesis", block),
            ("hiZBuffer", Resource::nearest(input.hi_z.0.all())),
            ("normalBuffer", Resource::nearest(input.gbuffer.normal.all())),
            ("materialBuffer", Resource::nearest(input.gbuffer.material.all())),
        ];
        let coned = [
            ("colorBuffer", Resource::trilinear(input.color.0.all())),
            ("visibilityBuffer", Resource::trilinear(input.visibility.0.all())),
        ];
        let hits = match &self.stages {
            Stages::Combined(pipeline) => {
                let target = [Target::overwrite(self.reflection.all())];
                let resources = [&traced[..], &coned[..]].concat();
                frame.fullscreen("trace+cone", pipeline, &target, &resources, &[])?;
                None
            }
            Stages::Split { trace, hits, .. } => {
                frame.fullscreen("ray trace", trace, &[Target::overwrite(hits.all())], &traced, &[])?;
                self.record_cone(frame, input, parameters, Hits(hits))?;
                Some(Hits(hits))
            }
        };
        Ok((Reflection(&self.reflection), hits))
    }

    /// Pass "cone trace" alone, from hits of any origin.
    ///
    /// # Panics
    /// If the pass was made combined.
    pub fn record_cone<'a>(
        &'a self,
        frame: &mut Frame,
        input: &TraceInput,
        parameters: &ThesisBlock,
        hits: Hits,
    ) -> Result<Reflection<'a>> {
        let Stages::Split { cone, .. } = &self.stages else { panic!("the cone alone needs the split pass") };
        let resources = [
            ("thesis", Resource::Uniform(bytemuck::bytes_of(parameters))),
            ("hiZBuffer", Resource::nearest(input.hi_z.0.all())),
            ("normalBuffer", Resource::nearest(input.gbuffer.normal.all())),
            ("materialBuffer", Resource::nearest(input.gbuffer.material.all())),
            ("colorBuffer", Resource::trilinear(input.color.0.all())),
            ("visibilityBuffer", Resource::trilinear(input.visibility.0.all())),
            ("hitBuffer", Resource::nearest(hits.0.all())),
        ];
        frame.fullscreen("cone trace", cone, &[Target::overwrite(self.reflection.all())], &resources, &[])?;
        Ok(Reflection(&self.reflection))
    }
}
