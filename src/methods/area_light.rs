//! `area-light`: analytic highlights of spheres, capsules, cylinders, rectangles and cuboids on rough surfaces (thesis
//! §3.1.1). The method reflects a scene's area lights and nothing else, and nothing hides them: "direct lighting only".

use super::needs::Need;
use super::{Input, Method, MethodInfo, MethodOutput, MethodRequest, SceneInput};
use crate::error::Result;
use crate::gpu::{Frame, FrameContext};
use crate::passes::area_light::AreaLightPass;

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    needs: &[Need::AreaLights],
    ..MethodInfo::scene(
        "area-light",
        "analytic area lights (direct highlights)",
        "Hermanns 2015, §3.1.1; Karis 2013",
        |gpu, MethodRequest { setup, .. }| {
            Ok(Box::new(AreaLightMethod(AreaLightPass::new(gpu, setup.stage(), setup.extent)?)))
        },
    )
};

struct AreaLightMethod(AreaLightPass);

impl Method for AreaLightMethod {
    /// Makes nothing, but refuses a scene with more area lights than the pass takes.
    fn prepare(&mut self, _context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        AreaLightPass::check(scene.data)
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        Ok(MethodOutput::new(self.0.record(frame, &input.gbuffer, input.scene()?.data, input.camera)?))
    }
}
