//! The pass of `environment`, which looks up a filtered cube map by the direction of the reflection (thesis §3.1.3).

use super::{CubeMap, GBuffer, LIT_COLOR, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};
use ssct_ground::scene::{Camera, ProjectionKind};

/// Pipeline and image of one size.
pub struct EnvironmentPass {
    pipeline: PixelPipeline<programs::Environment<'static>>,
    reflection: Image,
}

impl EnvironmentPass {
    /// Makes the pass for a size in pixels and a kind of projection.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], kind: ProjectionKind) -> Result<Self> {
        let constants = programs::EnvironmentConstants { orthographic: kind.is_orthographic() };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [LIT_COLOR], &constants)?,
            reflection: Image::target_in(gpu, stage, "environment", LIT_COLOR, extent)?,
        })
    }

    /// Records pass "environment", which looks up `map`. The reflection does not fade.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        camera: &Camera,
        map: CubeMap,
    ) -> Result<Reflection<'_>> {
        let camera = camera_block(camera, gbuffer.depth.extent());
        let program = programs::Environment {
            camera: &camera,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            environment: Sampled::trilinear(map.0.all()),
        };
        frame.pixels("environment", &self.pipeline, [Target::overwrite(self.reflection.all())], &program)?;
        Ok(Reflection(&self.reflection))
    }
}
