//! The whole effect: a method and what every method has around it, down to the composite.

use super::{Input, Method, MethodInfo, SceneInput, Setup, Traced};
use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::composite::CompositePass;

/// What an effect made in a frame.
#[derive(Clone)]
pub struct Output<'a> {
    /// The method's intermediates, and the reflection that was composited.
    pub traced: Traced<'a>,
    /// The finished image, linear.
    pub composite: &'a Image,
}

/// A method of one size on one device, with its composite.
pub struct Effect {
    method: Box<dyn Method>,
    composite: CompositePass,
}

impl Effect {
    /// Makes the method and what surrounds it. `scene` is the scene that it will be shown in; a method
    /// that sees only the screen does without.
    ///
    /// # Errors
    /// [`Error::Usage`] if the method needs a scene and there is none.
    pub fn new(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        scene: Option<&SceneInput>,
    ) -> Result<Self> {
        if scene.is_none() && !info.is_screen_space() {
            let name = info.name;
            return Err(Error::Usage(format!("--method {name} needs the scene; a G-buffer alone does not show it")));
        }
        let gpu: Gpu = context.gpu().clone();
        let mut effect =
            Self { method: (info.create)(&gpu, setup)?, composite: CompositePass::new(&gpu, setup.extent)? };
        if let Some(scene) = scene {
            effect.prepare(context, scene)?;
        }
        Ok(effect)
    }

    /// Makes what outlives frames anew, after the scene's materials changed.
    pub fn prepare(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        self.method.prepare(context, scene)
    }

    /// Records every pass after lighting.
    pub fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Output<'a>> {
        let traced = self.method.record(frame, input)?;
        let composite = match traced.composite {
            Some(made) => made,
            None => self.composite.record(frame, &input.gbuffer, traced.reflection)?,
        };
        Ok(Output { traced, composite })
    }
}
