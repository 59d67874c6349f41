//! The whole effect: a method and what every method has around it, down to the composite.

use super::{Input, Method, MethodInfo, SceneInput, Setup, Traced};
use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::composite::CompositePass;
use crate::passes::resolution::{self, DownsamplePass, UpsamplePass};

/// What an effect made in a frame.
#[derive(Clone)]
pub struct Output<'a> {
    /// The method's intermediates, and the reflection that was composited.
    pub traced: Traced<'a>,
    /// The finished image, linear.
    pub composite: &'a Image,
}

/// A method of one size on one device, with what surrounds it.
pub struct Effect {
    method: Box<dyn Method>,
    scaled: Option<(DownsamplePass, UpsamplePass)>,
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
        let name = info.name;
        if scene.is_none() && !info.is_screen_space() {
            return Err(Error::Usage(format!("--method {name} needs the scene; a G-buffer alone does not show it")));
        }
        if setup.divisor != 1 && !info.is_screen_space() {
            return Err(Error::Usage(format!("--resolution-scale is for screen-space methods; {name} is none")));
        }
        let gpu: Gpu = context.gpu().clone();
        let (extent, divisor) = (setup.extent, setup.divisor);
        let mut inner = *setup;
        let mut scaled = None;
        if divisor != 1 {
            inner = Setup { extent: resolution::divided(extent, divisor), composite: false, ..inner };
            scaled = Some((DownsamplePass::new(&gpu, extent, divisor)?, UpsamplePass::new(&gpu, extent, divisor)?));
        }
        let method = (info.create)(&gpu, &inner)?;
        let mut effect = Self { method, scaled, composite: CompositePass::new(&gpu, extent)? };
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
        let traced = match &self.scaled {
            None => self.method.record(frame, input)?,
            Some((downsample, upsample)) => {
                let gbuffer = downsample.record(frame, &input.gbuffer)?;
                let small = self.method.record(frame, &Input { gbuffer, ..*input })?;
                let mut full = |small| upsample.record(frame, &input.gbuffer, input.camera, small);
                let reflection = small.reflection.map(&mut full).transpose()?;
                // The hits are of the smaller pixels; nothing at full size compares with them.
                Traced { reflection, hits: None, ..small }
            }
        };
        let composite = match (traced.composite, traced.reflection) {
            (Some(made), _) => made,
            (None, Some(reflection)) => self.composite.record(frame, &input.gbuffer, reflection)?,
            // Where nothing reflects, the lit colour is the image.
            (None, None) => input.gbuffer.color,
        };
        Ok(Output { traced, composite })
    }
}
