//! Error over age: things move a step each frame, captures are renewed by so many faces a frame, and each frame is held
//! against the world as it then is (docs/definitions.md, "Captures in time").

use super::gbuffer;
use super::record::{Head, Of};
use super::stage::{Globals, Shot, Stage};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::frame::Mode;
use crate::methods::{EffectParams, Fallback, MethodInfo, Setup, Wants};
use crate::metrics::image::masked_rmse;
use crate::reference::first_hits::FirstHits;
use crate::reference::surface::World;
use crate::reference::world::{Escape, WorldReference};
use crate::scene::{GBufferData, Material, Scene, View};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What moves, and how captures follow.
pub struct AgeSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene, with its captures or without; those that are found are of the scene before it moves.
    pub scene: &'a Scene,
    /// View, which stands still.
    pub view: &'a View,
    /// Global factors.
    pub globals: Globals,
    /// A method that looks into captures, or has them behind it.
    pub method: &'static MethodInfo,
    /// Its parameters, with captures, and the size.
    pub setup: Setup,
    /// The meshes that move, by name.
    pub moving: &'a [String],
    /// By how much from one frame to the next, in metres along the world's axes.
    pub step_m: Vec3,
    /// Faces that are renewed in each frame: a row of the study each.
    pub faces: &'a [u32],
    /// Frames, ≥ 1, the first of which shows the scene as it was captured.
    pub frames: u32,
    /// Rays a pixel of the world reference, ≥ 1.
    pub rays: u32,
}

/// A frame of a row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AgeFrame {
    /// How far the things that move are from where they began, in metres.
    pub moved_m: f32,
    /// Mean over the faces of how many frames ago they were drawn.
    pub age_frames: f64,
    /// RMSE of the linear reflection colour against the world of this frame, over reflecting pixels.
    pub rmse: f64,
    /// Share of the reflecting pixels whose rays meet what moved, where it is or where it was.
    pub touched: f64,
    /// The RMSE over these alone, the only ones that age; null where there are none, as in the first frame.
    pub touched_rmse: Option<f64>,
    /// Standard error of that world reference.
    pub standard_error: f64,
    /// The method's time, the renewal of captures with it, in milliseconds.
    pub effect_ms: f64,
    /// The renewal's part of it.
    pub capture_ms: f64,
}

/// How the error grows with one number of faces a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AgeRecord {
    /// What it is of; `captures_per_frame` stands in its setup.
    #[serde(flatten)]
    pub head: Head,
    /// The meshes that move.
    pub moving: Vec<String>,
    /// By how much from one frame to the next, in metres.
    pub step_m: [f32; 3],
    /// Faces renewed in each frame.
    pub faces_per_frame: u32,
    /// Faces of all captures.
    pub faces: u32,
    /// Rays a pixel of the world reference.
    pub rays: u32,
    /// Every frame in order.
    pub frames: Vec<AgeFrame>,
}

/// The mean age in frames of so many faces at a frame, counted from 0, of which some are renewed in turn in each frame
/// before it is shown: a face that was never renewed is as old as the frame's number.
pub fn mean_age(faces: u32, per_frame: u32, frame: u32) -> f64 {
    let renewed = per_frame.min(faces);
    let age = |place: u32| (place / renewed.max(1)).min(frame);
    let ages: u32 = if renewed == 0 { faces * frame } else { (0..faces).map(age).sum() };
    if faces == 0 { 0.0 } else { f64::from(ages) / f64::from(faces) }
}

/// Measures every row, frame by frame in turn. `go_on` is called between two steps, and its error ends it.
///
/// # Errors
/// [`Error::Usage`] if the method has no captures, or no mesh has one of the names; those of the device and of `go_on`.
pub fn measure(spec: &AgeSpec, go_on: &mut dyn FnMut() -> Result<()>) -> Result<Vec<AgeRecord>> {
    let effect = spec.setup.effect();
    let takes = effect.fallback == Fallback::Captures
        || spec.method.takes_captures && (effect.captures.wanted().is_some() || !spec.method.is_screen_space());
    if !takes {
        let message = format!("the method {} has no captures whose age could be measured", spec.method.name);
        return Err(Error::Usage(message));
    }
    let camera = spec.view.camera(spec.scene, spec.setup.extent);
    let materials = spec.globals.materials(spec.scene, spec.view);
    let mut stage = Stage::new(spec.gpu, spec.scene)?;
    let mut rows = Vec::new();
    for &faces in spec.faces {
        let setup = spec.setup.with(|p: &mut EffectParams| p.captures_per_frame = faces);
        let shot = Shot::new(&mut stage, spec.method, &setup, Wants::REFLECTION, camera, materials.clone())?;
        let head = Head::new("age", spec.gpu, (spec.scene, spec.view), Of::Method(spec.method), &setup, &spec.globals);
        let record = AgeRecord {
            head,
            moving: spec.moving.to_vec(),
            step_m: spec.step_m.to_array(),
            faces_per_frame: faces,
            faces: shot.capture_faces(),
            rays: spec.rays,
            frames: Vec::new(),
        };
        rows.push((shot, record));
    }
    for frame in 0..spec.frames {
        let offset = frame as f32 * spec.step_m;
        for name in spec.moving {
            stage.scene_mut().place_meshes(name, offset)?;
        }
        let mut truth = None;
        for (shot, record) in &mut rows {
            go_on()?;
            let (report, _, output) = stage.output_in(Mode::Timed, shot)?;
            let made = gbuffer::reflection(&mut stage.context, &output)?;
            let made: Vec<[f32; 3]> = made.texels().map(|t| [t[0], t[1], t[2]]).collect();
            let truth = match &mut truth {
                Some(truth) => truth,
                // Every row draws the same G-buffer.
                none => none.insert(Truth::new(spec, gbuffer::read(&mut stage.context, shot)?, &materials, offset)),
            };
            let sum = |counts: &dyn Fn(&str) -> bool| {
                // `fold` makes the sum of no passes 0; `sum` would make it -0.
                report.passes.iter().filter(|p| p.counted && counts(&p.name)).fold(0.0, |sum, p| sum + p.ms)
            };
            record.frames.push(AgeFrame {
                moved_m: offset.length(),
                age_frames: mean_age(record.faces, record.faces_per_frame, frame),
                rmse: masked_rmse(&truth.color, &made, &truth.mask),
                touched: truth.touched_share(),
                touched_rmse: truth.touched_rmse(&made),
                standard_error: truth.standard_error,
                effect_ms: sum(&|_| true),
                capture_ms: sum(&|name| name.starts_with("capture/")),
            });
        }
    }
    Ok(rows.into_iter().map(|(_, record)| record).collect())
}

/// The world of a frame.
struct Truth {
    color: Vec<[f32; 3]>,
    mask: Vec<bool>,
    /// Reflecting pixels that something moved for.
    touched: Vec<bool>,
    standard_error: f64,
}

impl Truth {
    fn new(spec: &AgeSpec, screen: GBufferData, materials: &[Material], offset: Vec3) -> Self {
        let mut scene = spec.scene.clone();
        for mesh in scene.meshes.iter_mut().filter(|m| spec.moving.contains(&m.name)) {
            mesh.translate(offset);
        }
        let world = World::new(&scene, materials);
        let first_hits = FirstHits::shown(&world, &screen);
        let definitions = spec.setup.effect().definitions;
        let seen = |world: &World| {
            let reference = WorldReference::by(definitions, world, &first_hits, &screen.camera, Escape::Environment, 2)
                .with_bounces(spec.setup.effect().bounces);
            let mut state = reference.start();
            reference.add(&mut state, spec.rays);
            let color: Vec<[f32; 3]> = reference.image(&state).reflection.iter().map(Vec3::to_array).collect();
            (color, state.overall_standard_error())
        };
        let (color, standard_error) = seen(&world);
        // One seed traces the same rays in both scenes, so that colours are equal to the bit unless a ray meets what moved.
        let (before, _) = seen(&World::new(spec.scene, materials));
        let mask = screen.reflecting();
        let touched = color.iter().zip(&before).zip(&mask).map(|((now, then), m)| *m && now != then).collect();
        Self { color, mask, touched, standard_error }
    }

    fn touched_share(&self) -> f64 {
        let count = |mask: &[bool]| mask.iter().filter(|m| **m).count() as f64;
        if count(&self.mask) > 0.0 { count(&self.touched) / count(&self.mask) } else { 0.0 }
    }

    fn touched_rmse(&self, made: &[[f32; 3]]) -> Option<f64> {
        self.touched.contains(&true).then(|| masked_rmse(&self.color, made, &self.touched))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a plain count: faces that are drawn in turn, one by one.
    #[test]
    fn the_mean_age_is_that_of_faces_renewed_in_turn() {
        for (faces, per_frame) in [(6, 0), (6, 1), (12, 5), (24, 2), (24, 24), (12, 30)] {
            let mut drawn = vec![0_u32; faces as usize];
            let mut next = 0;
            for frame in 0..40 {
                for _ in 0..per_frame.min(faces) {
                    drawn[next as usize] = frame;
                    next = (next + 1) % faces;
                }
                let mean = drawn.iter().map(|d| f64::from(frame - d)).sum::<f64>() / f64::from(faces);
                assert_eq!(mean_age(faces, per_frame, frame), mean, "{faces}, {per_frame}, {frame}");
            }
        }
    }
}
