//! Composite: lit colour + reflectivity · fade · reflection (docs/definitions.md, "Surfaces").

use super::{GBuffer, LIT_COLOR, Reflection};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, PixelPipeline, Sampled, ShaderStage, Target, image, programs};
use ash::vk;

/// Pipeline and image of one size.
pub struct CompositePass {
    pipeline: PixelPipeline<programs::Composite<'static>>,
    image: Image,
}

impl CompositePass {
    /// Makes the pass and its image of a size in pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &programs::CompositeConstants { lit: false })?,
            image: Image::target_in(gpu, stage, "composite", LIT_COLOR, extent)?,
        })
    }

    /// Makes the pass whose image is the lit colour of the next bounce, with room for the levels of a colour chain.
    pub fn for_bounces(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let usage = stage.target_usage() | U::SAMPLED | U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST;
        let levels = image::full_chain(extent);
        let described = ImageDesc { name: "bounce", format: LIT_COLOR, extent, levels, layers: 1, usage };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &programs::CompositeConstants { lit: true })?,
            image: Image::new(gpu, &described)?,
        })
    }

    /// Records pass "composite", and returns the finished image, linear, in level 0.
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer, reflection: Reflection) -> Result<&'a Image> {
        frame.pixels(
            "composite",
            &self.pipeline,
            [Target::overwrite(self.image.level(0))],
            &programs::Composite {
                color_buffer: Sampled::nearest(gbuffer.color.level(0)),
                reflection_buffer: Sampled::nearest(reflection.0.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
            },
        )?;
        Ok(&self.image)
    }
}
