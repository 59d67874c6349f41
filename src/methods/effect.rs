//! The whole effect: a method and what every method has around it, down to the composite.

use super::capture::{CaptureImages, Renewal, captured_of};
use super::{EffectParams, Input, Making, Method, MethodInfo, SceneInput, Setup, Traced, Wants};
use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::composite::CompositePass;
use crate::passes::fallback::FallbackPass;
use crate::passes::resolution::{self, DownsamplePass, UpsamplePass};
use crate::scene::placement::Wanted;
use crate::scene::{Capture, Material};
use glam::Vec3;

/// What an effect made in a frame.
#[derive(Clone)]
pub struct Output<'a> {
    /// The method's intermediates and hits, and the reflection that was composited.
    pub traced: Traced<'a>,
    /// The finished image, linear.
    pub composite: &'a Image,
}

/// A method of one size on one device, with what surrounds it.
pub struct Effect {
    method: Box<dyn Method>,
    scaled: Option<(DownsamplePass, UpsamplePass)>,
    fallback: Option<(Box<dyn Method>, FallbackPass)>,
    composite: CompositePass,
    captures: Option<Captured>,
}

/// The captures of a scene, once they are made, and of what they were made.
struct Captured {
    places: Vec<Capture>,
    images: Option<CaptureImages>,
    of: Vec<Material>,
    /// `None` where the captures stay as and where they are.
    renewal: Option<Renewal>,
}

impl Effect {
    /// Makes the method and what surrounds it. `scene` is the scene that it will be shown in; a method
    /// that sees only the screen does without.
    ///
    /// # Errors
    /// [`Error::Usage`] if the method or its fallback needs a scene and there is none, or if there is a
    /// fallback behind a method that is no screen-space method.
    pub fn new(
        context: &mut FrameContext,
        info: &MethodInfo,
        setup: &Setup,
        wants: Wants,
        scene: Option<&SceneInput>,
    ) -> Result<Self> {
        let (name, extent, effect) = (info.name, setup.extent, setup.effect());
        let divisor = effect.divisor();
        if scene.is_none() && !info.is_screen_space() {
            return Err(Error::Usage(format!("the method {name} needs the scene; a G-buffer alone does not show it")));
        }
        if divisor != 1 && !info.is_screen_space() {
            let message = format!("a lower resolution scale is for screen-space methods, and {name} is none");
            return Err(Error::Usage(message));
        }
        let gpu: Gpu = context.gpu().clone();
        let captured = taken(info, &effect, scene)?;
        let face = captured.first().map(|c| [c.resolution; 2]);
        let fallback = effect.fallback.method().map(|behind| -> Result<_> {
            let behind_name = behind.name;
            if !info.is_screen_space() {
                return Err(Error::Usage(format!(
                    "the fallback {behind_name}: only screen-space methods have a fallback, and {name} is none"
                )));
            }
            if scene.is_none() {
                return Err(Error::Usage(format!(
                    "the fallback {behind_name} needs the scene; a G-buffer alone does not show it"
                )));
            }
            let making = Making {
                setup: setup.clone(),
                hits: false,
                reflection: true,
                composite: false,
                captures: face,
                behind: true,
            };
            Ok(((behind.create)(&gpu, &making)?, FallbackPass::new(&gpu, extent)?))
        });
        let composite = fallback.is_none() && divisor == 1;
        let mut scaled = None;
        let mut inner = Making {
            setup: setup.clone(),
            // The hits of smaller pixels compare with nothing at full size.
            hits: wants.hits && divisor == 1,
            reflection: wants.reflection || !composite,
            composite,
            captures: face,
            behind: false,
        };
        if divisor != 1 {
            inner.setup.extent = resolution::divided(extent, divisor);
            scaled = Some((DownsamplePass::new(&gpu, extent, divisor)?, UpsamplePass::new(&gpu, extent, divisor)?));
        }
        let renewed = (effect.captures_per_frame > 0 && !captured.is_empty())
            .then(|| Renewal::new(&gpu, &captured, effect.captures_per_frame))
            .transpose()?;
        let mut effect = Self {
            method: (info.create)(&gpu, &inner)?,
            scaled,
            fallback: fallback.transpose()?,
            composite: CompositePass::new(&gpu, extent)?,
            captures: face.map(|_| Captured { places: captured, images: None, of: Vec::new(), renewal: renewed }),
        };
        if let Some(scene) = scene {
            effect.prepare(context, scene)?;
        }
        Ok(effect)
    }

    /// Makes what outlives frames anew, after the scene's materials changed.
    pub fn prepare(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        if let Some(captured) = &mut self.captures {
            let of = captured_of(scene.materials);
            if captured.images.is_none() || captured.of != of {
                captured.images = Some(CaptureImages::new(context, scene, &captured.places)?);
                captured.of = of;
            }
        }
        if let Some((behind, _)) = &mut self.fallback {
            behind.prepare(context, scene)?;
        }
        self.method.prepare(context, scene)
    }

    /// Faces of the captures that the method looks into; 0 without captures.
    pub fn capture_faces(&self) -> u32 {
        let images = self.captures.as_ref().and_then(|c| c.images.as_ref());
        images.map_or(0, CaptureImages::faces)
    }

    /// Moves the captures, in their order, to other places, and draws the scene around these; places beyond the number of
    /// captures are left out, and captures without a place stay. Not part of any frame's time.
    pub fn move_captures(&mut self, context: &mut FrameContext, scene: &SceneInput, places: &[Vec3]) -> Result<()> {
        let Some(captured) = &mut self.captures else { return Ok(()) };
        for (capture, place) in captured.places.iter_mut().zip(places) {
            capture.position = *place;
        }
        let Some(images) = &mut captured.images else { return self.prepare(context, scene) };
        // Who moves captures once does so again: what draws them is kept.
        let renewal = match &mut captured.renewal {
            Some(kept) => kept,
            none => none.insert(Renewal::new(context.gpu(), &captured.places, 0)?),
        };
        let places: Vec<Vec3> = captured.places.iter().map(|c| c.position).collect();
        renewal.move_to(context, scene, images, &places)?;
        captured.of = captured_of(scene.materials);
        Ok(())
    }

    /// Records every pass after lighting; first of them those that renew captures, if some are renewed in each frame.
    ///
    /// # Errors
    /// [`Error::Usage`] if the method needs the scene, or captures are renewed, and the input has none.
    pub fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Output<'a>> {
        let images = self.captures.as_ref().and_then(|c| c.images.as_ref());
        if let (Some(Captured { renewal: Some(renewal), .. }), Some(images)) = (&self.captures, images) {
            renewal.record(frame, &input.scene()?, images)?;
        }
        let captures = images.map(CaptureImages::captures);
        let input = &Input { captures, ..*input };
        let mut traced = match &self.scaled {
            None => self.method.record(frame, input)?,
            Some((downsample, upsample)) => {
                let gbuffer = downsample.record(frame, &input.gbuffer)?;
                let small = self.method.record(frame, &Input { gbuffer, ..*input })?;
                let reflection =
                    small.reflection.map(|r| upsample.record(frame, &input.gbuffer, input.camera, r)).transpose()?;
                Traced { reflection, composite: None, ..small }
            }
        };
        if let (Some((behind, pass)), Some(reflection)) = (&self.fallback, traced.reflection) {
            let behind = behind.record(frame, &Input { in_front: Some(reflection), ..*input })?;
            if let Some(far) = behind.reflection {
                traced.reflection = Some(pass.record(frame, reflection, far)?);
                traced.composite = None;
            }
            traced.intermediates.extend(behind.intermediates);
        }
        let composite = match (traced.composite, traced.reflection) {
            (Some(made), _) => made,
            (None, Some(reflection)) => self.composite.record(frame, &input.gbuffer, reflection)?,
            (None, None) => input.gbuffer.color,
        };
        Ok(Output { traced, composite })
    }
}

/// The captures of a scene that a method and what is behind it take; none if they take none, or the scene has no place
/// for one.
///
/// # Errors
/// [`Error::Usage`] if captures are wanted and there is no scene.
fn taken(info: &MethodInfo, effect: &EffectParams, scene: Option<&SceneInput>) -> Result<Vec<Capture>> {
    let behind = effect.fallback.method().is_some_and(|m| m.takes_captures);
    let is_all = !info.is_screen_space() && info.takes_captures;
    let wanted = match effect.captures.wanted() {
        // Where captures are all that is looked into, they are taken without being asked for.
        None if behind || is_all => Wanted::Auto,
        Some(wanted) if behind || info.takes_captures => wanted,
        _ => return Ok(Vec::new()),
    };
    let Some(scene) = scene else {
        return Err(Error::Usage("captures need the scene; a G-buffer alone does not show it".into()));
    };
    let side = effect.capture_side.texels();
    let sized = |c: &Capture| Capture { resolution: side.unwrap_or(c.resolution), ..*c };
    Ok(scene.data.captures(wanted).iter().map(sized).collect())
}
