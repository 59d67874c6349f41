//! `environment`: looks up a pre-filtered cube map by the reflection's direction (thesis §3.1.3). As the fallback of
//! §4.2.11, it shows the sky behind a screen-space method.
//!
//! The map holds the environment of docs/definitions.md, "Surfaces": the sky, as seen where nothing stands. The sky is
//! the only content for which a lookup by direction is right everywhere. A map captured among objects is right from one
//! point only, except for light from infinitely far away (§3.1.3). `local-map` looks up captured maps by direction
//! nevertheless, and `pccm` corrects the direction. Each level of the map is blurred by the lobe of one roughness.

use super::capture::filtered_sky;
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, SceneInput, Setup};
use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::environment::EnvironmentPass;
use crate::passes::{Content, CubeMap};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    takes_orthographic: true,
    ..MethodInfo::scene(
        "environment",
        "pre-filtered cube map of the sky, looked up by direction",
        "Hermanns 2015, §3.1.3, §4.2.11",
        |gpu, request| Ok(Box::new(EnvironmentMethod::new(gpu, &request.setup)?)),
    )
};

/// The lookup, and the map once there is one.
pub struct EnvironmentMethod {
    pass: EnvironmentPass,
    map: Option<Image>,
}

impl EnvironmentMethod {
    /// Makes the method without a map, which `prepare` makes.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        Ok(Self { pass: EnvironmentPass::new(gpu, setup.stage(), setup.extent, setup.projection)?, map: None })
    }
}

impl Method for EnvironmentMethod {
    fn prepare(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        // The sky does not change with the materials.
        if self.map.is_none() {
            self.map = Some(filtered_sky(context, scene.data)?);
        }
        Ok(())
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let Some(map) = &self.map else { return Err(Error::Usage("environment was not given the scene".into())) };
        let reflection = self.pass.record(frame, &input.gbuffer, input.camera, CubeMap(map))?;
        let intermediates = vec![Intermediate { name: "environment-map", content: Content::Color, image: map }];
        Ok(MethodOutput { intermediates, ..MethodOutput::new(reflection) })
    }
}
