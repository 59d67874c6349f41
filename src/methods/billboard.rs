//! `billboard`: each pixel's mirror ray is tested against impostors, quads that stand for bright or relevant objects
//! (Schmidt 2013, section 5.3). The method reflects the impostors of a scene and nothing else. The listings have no
//! roughness; the parameter `billboard_blur` adds it. An impostor is not lit, and does not move with any mesh.

use super::needs::Need;
use super::{Input, Method, MethodInfo, MethodOutput, SceneInput};
use crate::error::Result;
use crate::gpu::{Frame, FrameContext};
use crate::passes::billboard::{BillboardPass, Blur, Drawing, Occlusion, Order};
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    needs: &[Need::Impostors],
    parameters: BillboardParams::table,
    ..MethodInfo::scene(
        "billboard",
        "ray-traced impostor quads",
        "Schmidt 2013, §5.3, listings 2 and 3",
        |gpu, request| {
            let parameters: BillboardParams = request.setup.parameters();
            let pass =
                BillboardPass::new(gpu, request.setup.stage(), request.setup.extent, parameters.billboard_glow > 0.0)?;
            Ok(Box::new(BillboardMethod { pass, parameters }))
        },
    )
};

parameters! {
    /// Parameters of `billboard`.
    pub struct BillboardParams {
        /// Which of several billboards on a ray shows: as the listing has it, or the nearest.
        billboard_order: Order = Parameter::new(Order::Printed)
            .sweep(Preset::Published, &[Order::Unbroken, Order::Nearest])
            .source("Schmidt 2013, listing 2"),
        /// What hides a billboard: nothing, as published, or what the depth buffer shows.
        billboard_occlusion: Occlusion = Parameter::new(Occlusion::None)
            .sweep(Preset::Published, &[Occlusion::Depth])
            .source("Schmidt 2013, figure 41"),
        /// How wide a ray is at a billboard: as a mirror's, as published, or as the cone of the roughness, from the
        /// surface or from the viewer on.
        billboard_blur: Blur = Parameter::new(Blur::None)
            .sweep(Preset::Published, &[Blur::Roughness, Blur::Distance])
            .source("Schmidt 2013, §6"),
        /// A glow around billboards, as light sources have it: how bright it is beside an edge, as a share of the
        /// image's colour there. With 0 there is none.
        billboard_glow: f32 = Parameter::new(0.0).between(0.0, 4.0).source("Schmidt 2013, §6; no number there"),
        /// How far the glow reaches beyond the edges of a billboard.
        billboard_glow_width: f32 =
            Parameter::new(0.5).above(0.0, 100.0).unit("m").source("Schmidt 2013, §6; no number there"),
    }
}

/// The pass and how it traces.
struct BillboardMethod {
    pass: BillboardPass,
    parameters: BillboardParams,
}

impl Method for BillboardMethod {
    /// Makes nothing, but refuses a scene with more impostors than the pass takes.
    fn prepare(&mut self, _context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        BillboardPass::check(scene.data, INFO.name)
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        // No images in place of those that the impostors have.
        let (data, images) = (input.scene()?.data, None);
        let p = self.parameters;
        let drawing = Drawing {
            order: p.billboard_order,
            occlusion: p.billboard_occlusion,
            blur: p.billboard_blur,
            glow: (p.billboard_glow, p.billboard_glow_width),
            premultiplied: false,
        };
        Ok(MethodOutput::new(self.pass.record(frame, &input.gbuffer, data, input.camera, images, drawing)?))
    }
}
