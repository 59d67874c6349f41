//! Makes normals for rays to be reflected at instead of the shading normals (thesis §4.4, after the game Thief).

use super::{GBuffer, NORMAL, camera_block, stored_target};
use crate::error::Result;
use crate::gpu::programs::{TraceNormals as Program, TraceNormalsConstants};
use crate::gpu::{Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target};
use ssct_ground::math::constants::{TRACE_GEOMETRIC, TRACE_SHADING, TRACE_UP};
use ssct_ground::parameter::choices;
use ssct_ground::scene::{Camera, ProjectionKind};

choices! {
    /// What rays are reflected at.
    pub enum TraceNormals {
        /// The G-buffer's normals, with their bumps.
        Shading(TRACE_SHADING) = "shading",
        /// The geometry's, found from depth: (0, 0, 1) in the space of a normal map.
        Geometric(TRACE_GEOMETRIC) = "geometric",
        /// The world's up for every pixel, right on floors alone: (0, 0, 1) where z is up.
        Up(TRACE_UP) = "up",
    }
}

/// Pipeline and image of one size.
pub struct TraceNormalsPass {
    pipeline: PixelPipeline<Program<'static>>,
    normal: Image,
}

impl TraceNormalsPass {
    /// Makes the pass for a size in pixels, a kind of projection, and a kind of normals.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        projection: ProjectionKind,
        kind: TraceNormals,
    ) -> Result<Self> {
        let constants = TraceNormalsConstants { kind: kind as i32, orthographic: projection.is_orthographic() };
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [NORMAL], &constants)?,
            normal: stored_target(gpu, "trace normal", NORMAL, extent)?,
        })
    }

    /// Records pass "trace normals", and returns the G-buffer with the new normals in place of its own.
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: GBuffer<'a>, camera: &Camera) -> Result<GBuffer<'a>> {
        let camera = camera_block(camera, gbuffer.depth.extent());
        let program = Program { camera: &camera, depth_buffer: Sampled::nearest(gbuffer.depth.all()) };
        frame.pixels("trace normals", &self.pipeline, [Target::overwrite(self.normal.all())], &program)?;
        Ok(GBuffer { normal: &self.normal, ..gbuffer })
    }
}
