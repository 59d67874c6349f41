//! Traces every ray by the march over pixels of McGuire and Mara 2014, and looks up the mirror's colour where it ends.

use super::traced::TracedPass;
use super::{GBuffer, Hits, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::programs::{Dda, DdaConstants};
use crate::gpu::shader::DdaBlock;
use crate::gpu::{Frame, Gpu, Sampled, ShaderStage};
use ssct_ground::scene::Camera;

/// Pipeline and images of one size.
pub struct DdaTracePass(TracedPass<Dda<'static>>);

impl DdaTracePass {
    /// Makes the pass. `jitter` shifts the samples from pixel to pixel, and `refine` searches for each hit within its
    /// step. `layers` is the number of layers of depth (1 or 2), and `hits` asks for an image of the hits.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        [jitter, refine]: [bool; 2],
        layers: u32,
        hits: bool,
    ) -> Result<Self> {
        let constants = DdaConstants { jitter, refine, hits, layers: layers as i32 };
        Ok(Self(TracedPass::new(gpu, stage, extent, &constants, hits)?))
    }

    /// Records pass "ray march".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        second_layer: Option<&GBuffer>,
        camera: &Camera,
        parameters: &DdaBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let camera = camera_block(camera, gbuffer.depth.extent());
        // A program for one layer does not read the bindings of the second.
        let behind = second_layer.unwrap_or(gbuffer);
        let program = Dda {
            camera: &camera,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            color_buffer: Sampled::trilinear(gbuffer.color.level(0)),
            behind_depth: Sampled::nearest(behind.depth.all()),
            behind_color: Sampled::trilinear(behind.color.level(0)),
            dda: parameters,
        };
        self.0.draw(frame, "ray march", &program)?;
        Ok(self.0.traced())
    }
}
