//! Composite: lit colour + reflectivity · fade · reflection (docs/definitions.md, "Surfaces").

use super::{GBuffer, Reflection};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Sampled, Target, programs};
use ash::vk;

const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pipeline and image of one size.
pub struct CompositePass {
    pipeline: GraphicsPipeline<programs::Composite<'static>>,
    image: Image,
}

impl CompositePass {
    /// An image of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, [FORMAT])?,
            image: Image::target(gpu, "composite", FORMAT, extent)?,
        })
    }

    /// Pass "composite"; the image is linear.
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer, reflection: Reflection) -> Result<&'a Image> {
        frame.fullscreen(
            "composite",
            &self.pipeline,
            [Target::overwrite(self.image.all())],
            &programs::Composite {
                color_buffer: Sampled::nearest(gbuffer.color.level(0)),
                reflection_buffer: Sampled::nearest(reflection.0.all()),
                material_buffer: Sampled::nearest(gbuffer.material.all()),
            },
        )?;
        Ok(&self.image)
    }
}
