//! `billboard`: impostor quads that stand for what is bright or relevant, traced per pixel (Schmidt 2013,
//! section 5.3). It reflects the impostors of a scene and nothing else, as mirrors do: the listings know
//! no roughness. An impostor is not lit and moves with nothing.

use super::{Input, Method, MethodInfo, SceneInput, Sees, Setup, Traced};
use crate::error::Result;
use crate::gpu::{Frame, FrameContext, Gpu};
use crate::passes::billboard::{BillboardPass, Billboards, Occlusion, Order};

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "billboard",
    summary: "ray-traced impostor quads",
    source: "Schmidt 2013, §5.3, listings 2 and 3",
    sees: Sees::Scene,
    settings,
    create: |gpu, setup| Ok(Box::new(BillboardMethod::new(gpu, setup)?)),
};

/// The pass and how it traces.
struct BillboardMethod {
    pass: BillboardPass,
    billboards: Billboards,
}

/// As printed, each repair of the listing's order, and both orders with the occlusion that it lacks.
fn settings(base: Setup) -> Vec<Setup> {
    let of = |order, occlusion| Setup { billboards: Billboards { order, occlusion }, ..base };
    vec![
        of(Order::Printed, Occlusion::None),
        of(Order::Unbroken, Occlusion::None),
        of(Order::Nearest, Occlusion::None),
        of(Order::Printed, Occlusion::Depth),
        of(Order::Nearest, Occlusion::Depth),
    ]
}

impl BillboardMethod {
    fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        Ok(Self { pass: BillboardPass::new(gpu, setup.extent)?, billboards: setup.billboards })
    }
}

impl Method for BillboardMethod {
    fn prepare(&mut self, _context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        BillboardPass::check(scene.data)
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let data = input.scene()?.data;
        Ok(Traced::new(self.pass.record(frame, &input.gbuffer, data, input.camera, self.billboards)?))
    }
}
