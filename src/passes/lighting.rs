//! Makes the lit colour of the G-buffer: direct light without shadows, and the sky. A scene pass.

use super::scene_data::SceneData;
use super::{GBuffer, LIT_COLOR, PerProjection, camera_block};
use crate::error::Result;
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target, programs};
use ssct_ground::scene::{Camera, ProjectionKind};

/// The pipelines.
pub struct LightingPass {
    gpu: Gpu,
    stage: ShaderStage,
    /// Whether pixels that show the sky become black.
    sky_apart: bool,
    pipelines: PerProjection<PixelPipeline<programs::Lighting<'static>>>,
    label: &'static str,
}

impl LightingPass {
    /// Makes the pass for fragment shaders, and compiles the pipeline for perspectives.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Self::in_stage(gpu, ShaderStage::Fragment)
    }

    /// Makes the pass for a shader stage, and compiles the pipeline for perspectives.
    pub fn in_stage(gpu: &Gpu, stage: ShaderStage) -> Result<Self> {
        Self::make(gpu, stage, false)
    }

    /// Makes a pass that writes black for the sky. Every lighting pass writes alpha 1 for lit surfaces and 0 for sky.
    pub fn without_sky(gpu: &Gpu) -> Result<Self> {
        Self::make(gpu, ShaderStage::Fragment, true)
    }

    /// Makes the pass; if `sky_apart` is true, pixels that show the sky become black.
    fn make(gpu: &Gpu, stage: ShaderStage, sky_apart: bool) -> Result<Self> {
        let pass = Self { gpu: gpu.clone(), stage, sky_apart, pipelines: PerProjection::new(), label: "lighting" };
        pass.pipeline(ProjectionKind::Perspective)?;
        Ok(pass)
    }

    fn pipeline(&self, kind: ProjectionKind) -> Result<&PixelPipeline<programs::Lighting<'static>>> {
        let constants = programs::LightingConstants { sky_apart: self.sky_apart, orthographic: kind.is_orthographic() };
        self.pipelines.get(kind, || PixelPipeline::new(&self.gpu, self.stage, [LIT_COLOR], &constants))
    }

    /// Returns the pass with another label, for a scene that a method draws for itself.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Records pass "lighting", or the pass of its label, which writes level 0 of the G-buffer's colour.
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
        frame.pixels(
            self.label,
            self.pipeline(camera.kind())?,
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
