//! A reflection with another behind it, faded in where the first fades out (thesis §4.2.11; Schmidt
//! 2013, section 5.4.2).

use super::{LIT_COLOR, Reflection};
use crate::error::Result;
use crate::gpu::shader::COMMON_FALLBACK_FRAG;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Resource, Target};

/// Pipeline and image of one size.
pub struct FallbackPass {
    pipeline: GraphicsPipeline,
    reflection: Image,
}

impl FallbackPass {
    /// For a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, &COMMON_FALLBACK_FRAG, &[LIT_COLOR])?,
            reflection: Image::target(gpu, "with fallback", LIT_COLOR, extent)?,
        })
    }

    /// Pass "fallback". Fade is 1 wherever the fallback has a colour.
    pub fn record(&self, frame: &mut Frame, reflection: Reflection, behind: Reflection) -> Result<Reflection<'_>> {
        let resources = [
            ("reflection_buffer", Resource::nearest(reflection.0.all())),
            ("fallback_buffer", Resource::nearest(behind.0.all())),
        ];
        frame.fullscreen("fallback", &self.pipeline, &[Target::overwrite(self.reflection.all())], &resources, &[])?;
        Ok(Reflection(&self.reflection))
    }
}
