//! SSLR's third stage: the reflection from the blurred chain, by roughness and ray length (thesis §4.3.3).

use super::{GBuffer, RayTraceColor, Reflection};
use crate::error::Result;
use crate::gpu::shader::{SslrReflectionBlock, THESIS_SSLR_REFLECTION_FRAG};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Resource, Target};
use ash::vk;

const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pipeline and image of one size.
pub struct SslrReflectionPass {
    pipeline: GraphicsPipeline,
    image: Image,
}

impl SslrReflectionPass {
    /// An image of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, &THESIS_SSLR_REFLECTION_FRAG, &[FORMAT])?,
            image: Image::target(gpu, "reflection", FORMAT, extent)?,
        })
    }

    /// Pass "reflection". `spreading_factor` scales the ray's length.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        traced: RayTraceColor,
        spreading_factor: f32,
    ) -> Result<Reflection<'a>> {
        let push = SslrReflectionBlock {
            resolution: self.image.extent().map(|v| v as f32),
            mipCount: traced.color.levels() as f32,
            spreadingFactor: spreading_factor,
        };
        frame.fullscreen(
            "reflection",
            &self.pipeline,
            &[Target::overwrite(self.image.all())],
            &[
                ("rayTraceColorBuffer", Resource::trilinear(traced.color.all())),
                ("maskBuffer", Resource::nearest(traced.mask.level(0))),
                ("materialBuffer", Resource::nearest(gbuffer.material.all())),
            ],
            bytemuck::bytes_of(&push),
        )?;
        Ok(Reflection(&self.image))
    }
}
