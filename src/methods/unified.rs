//! `unified`: this project's own method.

use super::{Input, Method, MethodInfo, SceneInput, Sees, Setup, Traced};
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::unified_gloss::{Lobes, UnifiedGlossPass};
use crate::passes::unified_trace::UnifiedTracePass;
use crate::scene::Camera;

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "unified",
    summary: "one exact Hi-Z traversal for every direction; only what the scene needs",
    source: "this project",
    sees: Sees::Screen,
    settings: |base| vec![base],
    create: |gpu, setup| Ok(Box::new(UnifiedMethod::new(gpu, setup)?)),
};

/// The passes in their order.
pub struct UnifiedMethod {
    pyramid: PyramidPass,
    trace: UnifiedTracePass,
    gloss: UnifiedGlossPass,
    fade: bool,
    composite: bool,
}

impl UnifiedMethod {
    /// Makes pipelines and images.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        Ok(Self {
            pyramid: PyramidPass::new(gpu, setup.extent)?,
            trace: UnifiedTracePass::new(gpu, setup.extent, setup.split)?,
            gloss: UnifiedGlossPass::new(gpu, setup.extent)?,
            fade: setup.fade,
            composite: setup.composite,
        })
    }
}

impl Method for UnifiedMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let gbuffer = &input.gbuffer;
        let parameters = parameters(input.camera, gbuffer.depth.extent(), self.fade);
        let pyramid = self.pyramid.record(frame, gbuffer, &parameters)?;
        let roughness = |scene: SceneInput| scene.materials.iter().map(|m| m.roughness).collect::<Vec<_>>();
        // Without a scene only the G-buffer knows what there is.
        let roughness = input.scene.map_or(vec![0.0, 1.0], roughness);
        if roughness.iter().any(|r| *r > 0.0) {
            let lobes = Lobes::of(roughness);
            let glossy = self.gloss.record(frame, gbuffer, pyramid, &parameters, lobes)?;
            let composite = self.composite.then_some(glossy.composite);
            return Ok(Traced { composite, ..Traced::new(glossy.reflection) });
        }
        let traced = self.trace.record(frame, gbuffer, pyramid, &parameters)?;
        let composite = self.composite.then_some(traced.composite);
        Ok(Traced { composite, hits: traced.hits, ..Traced::new(traced.reflection) })
    }
}

/// The parameters of a camera for a size in pixels. What of the projection is needed is computed in
/// f64 and rounded once.
pub fn parameters(camera: &Camera, extent: [u32; 2], fade: bool) -> UnifiedBlock {
    let projection = camera.view_to_clip_reversed().as_dmat4();
    let to_clip = [projection.x_axis.x, projection.y_axis.y];
    let side = extent.map(f64::from);
    UnifiedBlock {
        view_to_clip: to_clip.map(|v| v as f32),
        pixel_to_clip: side.map(|n| (1.0 / n) as f32),
        pixel_to_view: [0, 1].map(|i| (1.0 / (side[i] * to_clip[i])) as f32),
        size: extent.map(|v| v as i32),
        padded: pyramid::padded(extent).map(|v| v as i32),
        top_level: pyramid::top_level(extent) as i32,
        depth_offset: -projection.z_axis.z as f32,
        fade_start: 0.8,
        fade_end: 1.0,
        fade: i32::from(fade),
        ..UnifiedBlock::default()
    }
}
