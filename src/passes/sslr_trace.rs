//! SSLR's first stage: marches each ray in uniform steps, and looks up the colour where it ends (thesis §4.3.1).

use super::{GBuffer, HITS, HiZ, Hits, RayTraceColor, UNENCODED_COLOR};
use crate::error::Result;
use crate::gpu::programs::{SslrRayTrace, SslrRayTraceConstants};
use crate::gpu::shader::ThesisBlock;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, PixelPipeline, Sampled, Sampler, ShaderStage, Target, image};
use ash::vk;

// The colour is linear here, but was a display colour in the author's program. The encoding makes 8 bits as fine in the
// dark as they were there.
const COLOR: vk::Format = vk::Format::R8G8B8A8_SRGB;
const MASK: vk::Format = vk::Format::R8_UNORM;

/// Pipeline and images of one size; the images have room for their chains.
pub struct SslrTracePass {
    pipeline: PixelPipeline<SslrRayTrace<'static>>,
    color: Image,
    mask: Image,
    hits: Option<Image>,
    /// The colour before it is encoded, for compute programs, since these cannot store to an sRGB format.
    unencoded: Option<Image>,
}

impl SslrTracePass {
    /// Makes the pass with at most `steps` steps, and with an image of the hits or without. Compute shaders cannot
    /// store to the sRGB format of the colour: they write an image without encoding, which a second pass then encodes.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], steps: u32, hits: bool) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let read = U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let image = |name, format, levels, usage| {
            Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage: usage | read })
        };
        let (levels, stored) = (image::full_chain(extent), stage.target_usage());
        let encodes_later = stage == ShaderStage::Compute;
        let color = if encodes_later { UNENCODED_COLOR } else { COLOR };
        let formats = [color, MASK, if hits { HITS } else { vk::Format::UNDEFINED }];
        let constants = SslrRayTraceConstants { hits, linear_march_count: steps as i32, ..Default::default() };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, formats, &constants)?,
            color: image("ray trace color", COLOR, levels, U::COLOR_ATTACHMENT)?,
            mask: image("mask", MASK, levels, stored)?,
            hits: hits.then(|| image("hits", HITS, 1, stored)).transpose()?,
            unencoded: encodes_later.then(|| image("unencoded color", UNENCODED_COLOR, levels, stored)).transpose()?,
        })
    }

    /// Returns the formats of the colour and of the mask.
    pub fn formats(&self) -> [vk::Format; 2] {
        [self.color.format(), self.mask.format()]
    }

    /// Records pass "ray trace", which writes level 0 of both chains. In compute shaders the pass "ray trace/encode" follows.
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
            Target::overwrite(self.unencoded.as_ref().unwrap_or(&self.color).level(0)),
            Target::overwrite(self.mask.level(0)),
            hits.map_or(Target::unwanted(), |image| Target::overwrite(image.all())),
        ];
        frame.pixels(
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
        let traced = RayTraceColor { color: &self.color, mask: &self.mask, unencoded: self.unencoded.as_ref() };
        traced.encode(frame, "ray trace", self.color.level(0))?;
        Ok((traced, hits.map(Hits)))
    }
}
