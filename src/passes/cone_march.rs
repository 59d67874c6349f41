//! The poster's cone march through the pre-filtered G-buffer.

use super::{FilteredGBuffer, GBuffer, Hits, PosterFilter, Reflection, TracedImages, camera_block};
use crate::error::Result;
use crate::gpu::shader::{
    POSTER_CONE_MARCH_MIP_FRAG, POSTER_CONE_MARCH_MIP_HITS_FRAG, POSTER_CONE_MARCH_VOLUME_FRAG,
    POSTER_CONE_MARCH_VOLUME_HITS_FRAG, PosterBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Resource};
use crate::scene::Camera;

/// Pipeline and images of one size.
pub struct ConeMarchPass {
    pipeline: GraphicsPipeline,
    images: TracedImages,
}

impl ConeMarchPass {
    /// With the hits or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], filter: PosterFilter, with_hits: bool) -> Result<Self> {
        let shader = match (filter, with_hits) {
            (PosterFilter::Mip, false) => &POSTER_CONE_MARCH_MIP_FRAG,
            (PosterFilter::Mip, true) => &POSTER_CONE_MARCH_MIP_HITS_FRAG,
            (PosterFilter::Volume, false) => &POSTER_CONE_MARCH_VOLUME_FRAG,
            (PosterFilter::Volume, true) => &POSTER_CONE_MARCH_VOLUME_HITS_FRAG,
        };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, shader, TracedImages::formats(with_hits))?,
            images: TracedImages::new(gpu, extent, with_hits)?,
        })
    }

    /// Pass "cone march".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        filtered: FilteredGBuffer,
        camera: &Camera,
        parameters: &PosterBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let block = camera_block(camera, self.images.extent());
        frame.fullscreen(
            "cone march",
            &self.pipeline,
            &self.images.targets(),
            &[
                ("camera", Resource::Uniform(bytemuck::bytes_of(&block))),
                ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
                ("material_buffer", Resource::nearest(gbuffer.material.all())),
                ("filtered_depth", Resource::trilinear(filtered.depth.all())),
                ("filtered_normal", Resource::trilinear(filtered.normal.all())),
                ("filtered_color", Resource::trilinear(filtered.color.all())),
            ],
            bytemuck::bytes_of(parameters),
        )?;
        Ok(self.images.traced())
    }
}
