//! Lit colour from the G-buffer: direct light without shadows, and the sky. A scene pass.

use super::scene_data::SceneData;
use super::{GBuffer, LIT_COLOR, camera_block};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Sampled, Target, programs};
use crate::scene::Camera;

/// The pipeline.
pub struct LightingPass {
    pipeline: GraphicsPipeline<programs::Lighting<'static>>,
    label: &'static str,
}

impl LightingPass {
    /// Compiles the pipeline.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Self::with(gpu, false)
    }

    /// Makes a lighting pass that is black where the sky is seen. In both passes, a is 1 for what is lit and 0 for sky.
    pub fn without_sky(gpu: &Gpu) -> Result<Self> {
        Self::with(gpu, true)
    }

    fn with(gpu: &Gpu, sky_apart: bool) -> Result<Self> {
        let constants = programs::LightingConstants { sky_apart };
        let pipeline = GraphicsPipeline::fullscreen_with(gpu, [LIT_COLOR], &constants)?;
        Ok(Self { pipeline, label: "lighting" })
    }

    /// Under another name, for a scene that a method draws for itself.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Writes level 0 of the G-buffer's colour.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        albedo: &Image,
        scene: &SceneData,
        camera: &Camera,
    ) -> Result<()> {
        let camera_data = camera_block(camera, gbuffer.depth.extent());
        let lights = scene.light_block(camera.world_to_view);
        frame.fullscreen(
            self.label,
            &self.pipeline,
            [Target::overwrite(gbuffer.color.level(0))],
            &programs::Lighting {
                camera: &camera_data,
                scene: &lights,
                depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                albedo_buffer: Sampled::nearest(albedo.all()),
                normal_buffer: Sampled::nearest(gbuffer.normal.all()),
                environment: Sampled::trilinear(scene.sky.all()),
            },
        )
    }
}
