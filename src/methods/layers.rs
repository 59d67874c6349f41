//! Draws a second layer of depth, the nearest surfaces behind the first ones, by depth peeling (Everitt 2001; Schmidt
//! 2013, §6; Hermanns and Franke 2014, Conclusion). Some methods march through both layers.

use super::SceneInput;
use crate::error::Result;
use crate::gpu::{Frame, Gpu, ShaderStage};
use crate::passes::GBuffer;
use crate::passes::gbuffer::{GBufferPass, Peel};
use crate::passes::lighting::LightingPass;
use crate::passes::resolution::DownsamplePass;
use ssct_ground::parameter::{Parameter, parameters};
use ssct_ground::scene::Camera;

parameters! {
    /// Parameters of methods that march through layers of depth.
    pub struct LayerParams {
        /// Layers of depth that rays are held against. With 2, each frame draws and lights what lies behind the first
        /// surfaces, too: passes of the frame, which count. It takes a scene.
        layers: u32 = Parameter::new(1)
            .within(1, 2)
            .unit("layers")
            .source("Hermanns and Franke 2014, Conclusion; Schmidt 2013, §6"),
        /// By how much what is in the second layer lies at least behind the first one, in view depth.
        layer_separation: f32 = Parameter::new(0.1)
            .between(0.0, 1e6)
            .unit("m")
            .source("Hermanns and Franke 2014 and Schmidt 2013 leave it open"),
    }
}

impl LayerParams {
    /// Whether rays are tested against two layers of depth.
    pub fn has_second(&self) -> bool {
        self.layers > 1
    }
}

/// The scene passes of the second layer, and a pass that scales it down if rays are traced at a lower resolution.
pub struct SecondLayer {
    gbuffer: GBufferPass,
    lighting: LightingPass,
    downsample: Option<DownsamplePass>,
    separation_m: f32,
}

impl SecondLayer {
    /// Makes the passes for G-buffers of a size in pixels. One ray is traced for `divisor` × `divisor` pixels.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], divisor: u32, parameters: LayerParams) -> Result<Self> {
        let downsample = (divisor != 1).then(|| DownsamplePass::new(gpu, stage, extent, divisor)).transpose()?;
        Ok(Self {
            gbuffer: GBufferPass::behind(gpu, extent)?.labelled("layer/g-buffer"),
            lighting: LightingPass::in_stage(gpu, stage)?.labelled("layer/lighting"),
            downsample: downsample.map(|pass| pass.labelled("layer/downsample")),
            separation_m: parameters.layer_separation,
        })
    }

    /// Records passes "layer/g-buffer" and "layer/lighting", which draw the nearest surfaces behind those of `first`.
    /// The result has the size at which rays are traced; pass "layer/downsample" makes it if that size is smaller.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn record(
        &self,
        frame: &mut Frame,
        scene: SceneInput,
        first: &GBuffer,
        camera: &Camera,
    ) -> Result<GBuffer<'_>> {
        let peel = Peel { depth: first.depth, separation_m: self.separation_m };
        self.gbuffer.record_behind(frame, scene.data, scene.materials, camera, peel)?;
        let layer = self.gbuffer.gbuffer();
        self.lighting.record(frame, &layer, self.gbuffer.albedo(), scene.data, camera)?;
        match &self.downsample {
            Some(pass) => pass.record(frame, &layer),
            None => Ok(layer),
        }
    }
}
