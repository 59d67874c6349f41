//! Puts a fallback behind a reflection: a second reflection that fades in where the first fades out (thesis §4.2.11;
//! Schmidt 2013, section 5.4.2).

use super::{LIT_COLOR, Reflection};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};

/// Pipeline and image of one size.
pub struct FallbackPass {
    pipeline: PixelPipeline<programs::Fallback<'static>>,
    reflection: Image,
}

impl FallbackPass {
    /// Makes the pass for a size in pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &())?,
            reflection: Image::target_in(gpu, stage, "with fallback", LIT_COLOR, extent)?,
        })
    }

    /// Records pass "fallback". The fade becomes 1 where the fallback has a colour, and stays elsewhere.
    pub fn record(&self, frame: &mut Frame, reflection: Reflection, fallback: Reflection) -> Result<Reflection<'_>> {
        let program = programs::Fallback {
            reflection_buffer: Sampled::nearest(reflection.0.all()),
            fallback_buffer: Sampled::nearest(fallback.0.all()),
        };
        frame.pixels("fallback", &self.pipeline, [Target::overwrite(self.reflection.all())], &program)?;
        Ok(Reflection(&self.reflection))
    }
}
