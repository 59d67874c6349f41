//! Bump mapping after the tracing (thesis §4.4, after the game Thief): each reflection is displaced by how far the
//! shading normal deviates from the normal that rays were reflected at.

use super::{GBuffer, LIT_COLOR, Reflection};
use crate::error::Result;
use crate::gpu::shader::BumpBlock;
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};

/// Pipeline and image of one size.
pub struct BumpPass {
    pipeline: PixelPipeline<programs::Bump<'static>>,
    reflection: Image,
    strength: f32,
}

impl BumpPass {
    /// Makes the pass for a size in pixels. `strength` is the displacement for a deviation of 1, in screen heights.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], strength: f32) -> Result<Self> {
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &())?,
            reflection: Image::target_in(gpu, stage, "bumped reflection", LIT_COLOR, extent)?,
            strength,
        })
    }

    /// Records pass "bump". `shading` has the shading normals, and `traced` the normals that rays were reflected at.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        shading: &GBuffer,
        traced: &GBuffer,
        reflection: Reflection,
    ) -> Result<Reflection<'a>> {
        let program = programs::Bump {
            reflection_buffer: Sampled::nearest(reflection.0.all()),
            normal_buffer: Sampled::nearest(shading.normal.all()),
            trace_normal_buffer: Sampled::nearest(traced.normal.all()),
            material_buffer: Sampled::nearest(shading.material.all()),
            bump: &BumpBlock { strength: self.strength },
        };
        frame.pixels("bump", &self.pipeline, [Target::overwrite(self.reflection.all())], &program)?;
        Ok(Reflection(&self.reflection))
    }
}
