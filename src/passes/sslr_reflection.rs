//! SSLR's third stage: reads the reflection from the blurred chain, by roughness and ray length (thesis §4.3.3).

use super::{GBuffer, RayTraceColor, Reflection};
use crate::error::Result;
use crate::gpu::shader::SslrReflectionBlock;
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};
use ash::vk;

const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pipeline and image of one size.
pub struct SslrReflectionPass {
    pipeline: PixelPipeline<programs::SslrReflection<'static>>,
    image: Image,
}

impl SslrReflectionPass {
    /// Makes the pass and its image of a size in pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [FORMAT], &())?,
            image: Image::target_in(gpu, stage, "reflection", FORMAT, extent)?,
        })
    }

    /// Records pass "reflection". `spreading_factor` is a factor on the level of the chain that a pixel reads.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        traced: RayTraceColor,
        spreading_factor: f32,
    ) -> Result<Reflection<'a>> {
        let sslr = SslrReflectionBlock {
            resolution: self.image.extent().map(|v| v as f32),
            mipCount: traced.color.levels() as f32,
            spreadingFactor: spreading_factor,
        };
        frame.pixels(
            "reflection",
            &self.pipeline,
            [Target::overwrite(self.image.all())],
            &programs::SslrReflection {
                rayTraceColorBuffer: Sampled::trilinear(traced.color.all()),
                maskBuffer: Sampled::nearest(traced.mask.level(0)),
                materialBuffer: Sampled::nearest(gbuffer.material.all()),
                sslr: &sslr,
            },
        )?;
        Ok(Reflection(&self.image))
    }
}
