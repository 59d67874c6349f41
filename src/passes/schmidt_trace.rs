//! The screen-space march of `ssr` and `ssr-fast` (Schmidt 2013, section 5.4.1, listings 4 and 5).

use super::{GBuffer, Hits, Reflection, TracedImages, camera_block};
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::shader::{
    SCHMIDT_SSR_FAST_FRAG, SCHMIDT_SSR_FAST_HITS_FRAG, SCHMIDT_SSR_FRAG, SCHMIDT_SSR_HITS_FRAG, SchmidtBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Resource};
use crate::scene::Camera;

/// Which march.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SchmidtMarch {
    /// Listing 4: a sample a pixel.
    PerPixel,
    /// Listing 5: ten steps forward, a tenth back.
    Optimized,
}

/// Pipeline and images of one size.
pub struct SchmidtTracePass {
    pipeline: GraphicsPipeline,
    images: TracedImages,
}

impl SchmidtTracePass {
    /// With an image of the hits, or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], march: SchmidtMarch, hits: bool) -> Result<Self> {
        let shader = match (march, hits) {
            (SchmidtMarch::PerPixel, false) => &SCHMIDT_SSR_FRAG,
            (SchmidtMarch::PerPixel, true) => &SCHMIDT_SSR_HITS_FRAG,
            (SchmidtMarch::Optimized, false) => &SCHMIDT_SSR_FAST_FRAG,
            (SchmidtMarch::Optimized, true) => &SCHMIDT_SSR_FAST_HITS_FRAG,
        };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, shader, TracedImages::formats(hits))?,
            images: TracedImages::new(gpu, extent, hits)?,
        })
    }

    /// Pass "ray march". `diffuse` is the lit colour; its level 7 is read for the blur.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        diffuse: ImageSlice,
        camera: &Camera,
        parameters: &SchmidtBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let camera = camera_block(camera, gbuffer.depth.extent());
        let resources = [
            ("camera", Resource::Uniform(bytemuck::bytes_of(&camera))),
            ("DepthTex", Resource::nearest(gbuffer.depth.all())),
            ("normalBuffer", Resource::nearest(gbuffer.normal.all())),
            ("materialBuffer", Resource::nearest(gbuffer.material.all())),
            ("DiffuseTex", Resource::trilinear(diffuse)),
        ];
        frame.fullscreen(
            "ray march",
            &self.pipeline,
            &self.images.targets(),
            &resources,
            bytemuck::bytes_of(parameters),
        )?;
        Ok(self.images.traced())
    }
}
