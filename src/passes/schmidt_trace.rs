//! The screen-space march of `ssr` and `ssr-fast` (Schmidt 2013, section 5.4.1, listings 4 and 5).

use super::traced::TracedPass;
use super::{GBuffer, Hits, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::programs::{ScreenSpaceReflections, ScreenSpaceReflectionsConstants};
use crate::gpu::shader::SchmidtBlock;
use crate::gpu::{Frame, Gpu, Sampled, ShaderStage};
use ssct_ground::scene::Camera;

/// The listing whose march is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SchmidtMarch {
    /// Listing 4: one sample for each pixel on the way.
    PerPixel,
    /// Listing 5: ten steps forward, a tenth of a step back.
    Optimized,
}

/// Pipeline and images of one size.
pub struct SchmidtTracePass(TracedPass<ScreenSpaceReflections<'static>>);

impl SchmidtTracePass {
    /// Makes the pass. `hits` asks for an image of the hits, and `layers` for a march through two layers of depth.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        march: SchmidtMarch,
        hits: bool,
        layers: bool,
    ) -> Result<Self> {
        let constants = ScreenSpaceReflectionsConstants { optimized: march == SchmidtMarch::Optimized, hits, layers };
        Ok(Self(TracedPass::new(gpu, stage, extent, &constants, hits)?))
    }

    /// Records pass "ray march". `diffuse` is the lit colour, of which the blur reads level 7. A second layer is given with
    /// its lit colour.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        diffuse: ImageSlice,
        second_layer: Option<(&GBuffer, ImageSlice)>,
        camera: &Camera,
        parameters: &SchmidtBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let camera = camera_block(camera, gbuffer.depth.extent());
        // A program for one layer does not read the bindings of the second.
        let (behind, behind_diffuse) = second_layer.unwrap_or((gbuffer, diffuse));
        let program = ScreenSpaceReflections {
            camera: &camera,
            DepthTex: Sampled::nearest(gbuffer.depth.all()),
            normalBuffer: Sampled::nearest(gbuffer.normal.all()),
            materialBuffer: Sampled::nearest(gbuffer.material.all()),
            DiffuseTex: Sampled::trilinear(diffuse),
            BehindDepthTex: Sampled::nearest(behind.depth.all()),
            BehindDiffuseTex: Sampled::trilinear(behind_diffuse),
            schmidt: parameters,
        };
        self.0.draw(frame, "ray march", &program)?;
        Ok(self.0.traced())
    }
}
