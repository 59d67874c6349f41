//! SSLR's first stage: a uniform march, and the colour where it ends (thesis §4.3.1).

use super::{GBuffer, HITS, HiZ, Hits, RayTraceColor};
use crate::error::Result;
use crate::gpu::programs::{SslrRayTrace, SslrRayTraceConstants};
use crate::gpu::shader::ThesisBlock;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Sampled, Sampler, Target, image};
use ash::vk;

// The colour is linear here and was a display colour in the author's program: encoded, 8 bits are as
// fine in the dark as they were there.
const COLOR: vk::Format = vk::Format::R8G8B8A8_SRGB;
const MASK: vk::Format = vk::Format::R8_UNORM;

/// Pipeline and images of one size; the images have room for their chains.
pub struct SslrTracePass {
    pipeline: GraphicsPipeline<SslrRayTrace<'static>>,
    color: Image,
    mask: Image,
    hits: Option<Image>,
}

impl SslrTracePass {
    /// With so many steps at most, and with an image of the hits, or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], steps: u32, hits: bool) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let image =
            |name, format, levels| Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage });
        let levels = image::full_chain(extent);
        let formats = [COLOR, MASK, if hits { HITS } else { vk::Format::UNDEFINED }];
        let constants = SslrRayTraceConstants { hits, linear_march_count: steps as i32, ..Default::default() };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen_with(gpu, formats, &constants)?,
            color: image("ray trace color", COLOR, levels)?,
            mask: image("mask", MASK, levels)?,
            hits: hits.then(|| image("hits", HITS, 1)).transpose()?,
        })
    }

    /// Formats of colour and mask.
    pub fn formats(&self) -> [vk::Format; 2] {
        [self.color.format(), self.mask.format()]
    }

    /// Pass "ray trace": level 0 of both chains.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        depth: HiZ,
        depth_sampler: Sampler,
        parameters: &ThesisBlock,
    ) -> Result<(RayTraceColor<'a>, Option<Hits<'a>>)> {
        let hits = self.hits.as_ref();
        let targets = [
            Target::overwrite(self.color.level(0)),
            Target::overwrite(self.mask.level(0)),
            hits.map_or(Target::unwanted(), |image| Target::overwrite(image.all())),
        ];
        frame.fullscreen(
            "ray trace",
            &self.pipeline,
            targets,
            &SslrRayTrace {
                thesis: parameters,
                hiZBuffer: Sampled(depth.0.level(0), depth_sampler),
                normalBuffer: Sampled::nearest(gbuffer.normal.all()),
                materialBuffer: Sampled::nearest(gbuffer.material.all()),
                colorBuffer: Sampled::trilinear(gbuffer.color.level(0)),
            },
        )?;
        Ok((RayTraceColor { color: &self.color, mask: &self.mask }, hits.map(Hits)))
    }
}
