//! Films: variants of methods on every frame of a way of the camera, each beside what the world shows in that frame
//! (docs/definitions.md, "Films").

use super::error::{Variant, display, world_of};
use super::gbuffer;
use super::record::{Head, Of, Stats};
use super::stage::{Globals, Shot, Stage};
use crate::error::{Error, Result};
use crate::gpu::frame::Mode;
use crate::gpu::{Gpu, Pixels};
use crate::methods::Wants;
use crate::metrics::flicker::{self, SamePlace};
use crate::metrics::flip::FlipMap;
use crate::metrics::image::masked_rmse;
use crate::metrics::video::{Film, jod};
use crate::reference::first_hits::FirstHits;
use crate::reference::surface::World;
use crate::reference::world::{Escape, WorldReference};
use crate::scene::{Camera, CameraPath, GBufferData, Material, Scene, View};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How the camera moves through a film.
#[derive(Debug, Clone, PartialEq)]
pub enum Way {
    /// Along a path, from its beginning to its end.
    Path(CameraPath),
    /// From a view towards the point that it looks at, at the pace of a person who walks, or as much slower as to come
    /// half of the way to that point.
    Walk(View),
    /// At rest in a view for a third of the film, then turned quickly to the right, and at rest again.
    Turn(View),
    /// At rest in a view.
    Rest(View),
}

/// Metres a second.
const WALK: f32 = 1.4;
/// Degrees, and seconds that they take.
const TURN: (f32, f32) = (45.0, 0.2);

impl Way {
    /// Its name in records.
    pub fn name(&self) -> &str {
        match self {
            Self::Path(path) => &path.name,
            Self::Walk(_) => "walk",
            Self::Turn(_) => "turn",
            Self::Rest(_) => "rest",
        }
    }

    /// Where it begins; of a path, a view of the path's name.
    pub fn start(&self) -> View {
        match self {
            Self::Path(path) => {
                let (eye, look_at) = path.at(0.0);
                View { name: path.name.clone(), eye, look_at, ..View::default() }
            }
            Self::Walk(view) | Self::Turn(view) | Self::Rest(view) => view.clone(),
        }
    }

    /// The view of a frame, of so many that are shown at so many a second.
    pub fn view(&self, frame: u32, frames: u32, frames_per_second: f32) -> View {
        let last = frames.saturating_sub(1).max(1) as f32;
        let of_second = |n: u32| n as f32 / frames_per_second;
        match self {
            Self::Path(path) => {
                let (eye, look_at) = path.at(frame as f32 / last);
                View { eye, look_at, ..self.start() }
            }
            Self::Walk(view) => {
                let ahead = view.look_at - view.eye;
                let way = (WALK * last / frames_per_second).min(0.5 * ahead.length());
                let step = ahead.normalize_or_zero() * (way * frame as f32 / last);
                View { eye: view.eye + step, look_at: view.look_at + step, ..view.clone() }
            }
            Self::Turn(view) => {
                let (degrees, seconds) = TURN;
                let part = of_second(frame.saturating_sub(frames / 3)) / seconds;
                let turned = Quat::from_rotation_y(degrees.to_radians() * part.min(1.0));
                View { look_at: view.eye + turned * (view.look_at - view.eye), ..view.clone() }
            }
            Self::Rest(view) => view.clone(),
        }
    }
}

/// What is filmed.
pub struct VideoSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene.
    pub scene: &'a Scene,
    /// How the camera moves.
    pub way: &'a Way,
    /// Pixels.
    pub extent: [u32; 2],
    /// Global factors.
    pub globals: Globals,
    /// What is compared.
    pub variants: &'a [Variant],
    /// Frames, ≥ 2.
    pub frames: u32,
    /// Frames that are shown in a second, above 0.
    pub frames_per_second: f32,
    /// Rays a pixel of the world reference, ≥ 2.
    pub rays: u32,
    /// The meshes that move, by name.
    pub moving: &'a [String],
    /// By how much from one frame to the next, in metres along the world's axes.
    pub step_m: Vec3,
}

/// A frame of a film.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VideoFrame {
    /// Milliseconds of the method.
    pub effect_ms: f64,
    /// RMSE of the linear reflection colour against the world of this frame, over reflecting pixels.
    pub rmse: f64,
    /// Mean FLIP of the display image of the reflection colour.
    pub flip: f64,
}

/// The film of a variant beside the world's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VideoRecord {
    /// What it is of; the view is where the camera begins.
    #[serde(flatten)]
    pub head: Head,
    /// How the camera moves.
    pub way: String,
    /// The meshes that move.
    pub moving: Vec<String>,
    /// By how much from one frame to the next, in metres.
    pub step_m: [f32; 3],
    /// Frames in a second.
    pub frames_per_second: f32,
    /// Rays a pixel of the world reference.
    pub rays: u32,
    /// Median of the method's time over the frames.
    pub time_ms: f64,
    /// Mean over the frames of [`VideoFrame::rmse`].
    pub rmse: f64,
    /// Mean over the frames of [`VideoFrame::flip`].
    pub flip: f64,
    /// Mean absolute change of the linear reflection colour from a pixel to the same surface a frame before.
    pub flicker: f64,
    /// The world reference's own.
    pub reference_flicker: f64,
    /// Mean absolute difference of the variant's change and the reference's.
    pub change_error: f64,
    /// Quality of the finished images beside the world's, in JOD.
    pub jod: f64,
    /// Quality of the reflection colour alone beside the world's, in JOD.
    pub jod_reflection: f64,
    /// Mean over the frames of the world reference's standard error.
    pub standard_error: f64,
    /// Every frame in order.
    pub frames: Vec<VideoFrame>,
}

/// The films of a measurement: the finished images.
pub struct Films {
    /// The world's.
    pub world: Film,
    /// The films of the variants, in their order.
    pub variants: Vec<Film>,
}

/// What is known of a variant while its film is made.
struct Filmed {
    shot: Shot,
    /// A second shot that makes an image of the reflection; `None` if the timed one does.
    seen: Option<Shot>,
    before: Vec<Vec3>,
    frames: Vec<VideoFrame>,
    change: Change,
    images: Film,
    reflections: Film,
}

/// Sums over pairs of a pixel and the same surface a frame before.
#[derive(Default)]
struct Change {
    pairs: usize,
    flicker: f64,
    error: f64,
}

impl Change {
    fn add(&mut self, pairs: usize, flicker: f64, error: f64) {
        self.pairs += pairs;
        self.flicker += flicker * pairs as f64;
        self.error += error * pairs as f64;
    }

    fn mean(&self, sum: f64) -> f64 {
        if self.pairs == 0 { 0.0 } else { sum / self.pairs as f64 }
    }
}

/// Films every variant, frame by frame in turn. `go_on` is called between two steps, and its error ends it.
///
/// # Errors
/// [`Error::Usage`] if there are too few frames or rays, or a variant is of other definitions; those of the device and of
/// `go_on`.
pub fn measure(spec: &VideoSpec, go_on: &mut dyn FnMut() -> Result<()>) -> Result<(Vec<VideoRecord>, Films)> {
    if spec.frames < 2 || spec.rays < 2 {
        return Err(Error::Usage("a film needs at least two frames, and its reference two rays a pixel".into()));
    }
    let start = spec.way.start();
    let materials = spec.globals.materials(spec.scene, &start);
    let mut stage = Stage::new(spec.gpu, spec.scene)?;
    let first = start.camera(spec.scene, spec.extent);
    let mut all =
        spec.variants.iter().map(|v| filmed(spec, &mut stage, v, first, &materials)).collect::<Result<Vec<_>>>()?;
    for filmed in &all {
        // A film begins with what was there before it.
        stage.settle(&filmed.shot)?;
    }
    let mut world = Truth::default();
    let mut moved = spec.scene.clone();
    for frame in 0..spec.frames {
        if frame > 0 {
            for name in spec.moving {
                stage.scene_mut().place_meshes(name, frame as f32 * spec.step_m)?;
            }
            for mesh in moved.meshes.iter_mut().filter(|m| spec.moving.contains(&m.name)) {
                mesh.translate(spec.step_m);
            }
        }
        let camera = spec.way.view(frame, spec.frames, spec.frames_per_second).camera(spec.scene, spec.extent);
        let mut made = Vec::new();
        // They begin in turn, since the first of a frame may find colder caches.
        let count = all.len();
        for turn in 0..count {
            go_on()?;
            let n = (frame as usize + turn) % count;
            made.push((n, shoot(&mut stage, &mut all[n], camera)?));
        }
        let Some(screen) = all.first().map(|f| gbuffer::read(&mut stage.context, &f.shot)).transpose()? else { break };
        world.see(spec, screen, &moved, &materials, go_on)?;
        for (n, (effect_ms, reflection, image)) in made {
            all[n].add(&world, effect_ms, &reflection, &image);
        }
    }
    let films = Films { world: world.images.clone(), variants: all.iter().map(|f| f.images.clone()).collect() };
    let records = spec.variants.iter().zip(all).map(|(variant, filmed)| {
        go_on()?;
        record(spec, &start, variant, filmed, &world)
    });
    Ok((records.collect::<Result<_>>()?, films))
}

fn filmed(spec: &VideoSpec, stage: &mut Stage, of: &Variant, camera: Camera, materials: &[Material]) -> Result<Filmed> {
    let setup = of.setup.at(spec.extent);
    let mut shot = |wants| Shot::new(stage, of.method, &setup, wants, camera, materials.to_vec());
    // Timed without a reflection of its own, as the time study does.
    let (timed, seen) = (shot(Wants::IMAGE)?, shot(Wants::REFLECTION)?);
    let makes = stage.output(&timed)?.2.traced.reflection.is_some();
    let film = || Film { width: spec.extent[0], height: spec.extent[1], frames: Vec::new() };
    Ok(Filmed {
        shot: timed,
        seen: (!makes).then_some(seen),
        before: Vec::new(),
        frames: Vec::new(),
        change: Change::default(),
        images: film(),
        reflections: film(),
    })
}

/// A frame: its milliseconds, its reflection and the finished image.
fn shoot(stage: &mut Stage, filmed: &mut Filmed, camera: Camera) -> Result<(f64, Pixels, Pixels)> {
    filmed.shot.camera = camera;
    let (report, _, output) = stage.output_in(Mode::Timed, &filmed.shot)?;
    let effect_ms = report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum();
    let image = stage.context.read(output.composite.level(0))?;
    let reflection = match &mut filmed.seen {
        None => gbuffer::reflection(&mut stage.context, &output)?,
        Some(seen) => {
            seen.camera = camera;
            let (_, _, output) = stage.output(seen)?;
            gbuffer::reflection(&mut stage.context, &output)?
        }
    };
    Ok((effect_ms, reflection, image))
}

/// The world's film, and its last frame.
#[derive(Default)]
struct Truth {
    screen: Option<GBufferData>,
    mask: Vec<bool>,
    /// Linear reflection colour of this frame, and of the frame before.
    color: Vec<Vec3>,
    pairs: Vec<SamePlace>,
    changes: Vec<Vec3>,
    change: Change,
    standard_error: f64,
    images: Film,
    reflections: Film,
}

impl Truth {
    /// The next frame, from where the variants see it.
    fn see(
        &mut self,
        spec: &VideoSpec,
        screen: GBufferData,
        scene: &Scene,
        materials: &[Material],
        go_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<()> {
        let (definitions, bounces) = world_of(spec.variants)?;
        let world = World::new(scene, materials);
        let first_hits = FirstHits::shown(&world, &screen);
        // One seed for all frames: what is left of a pixel's noise in the difference of two is its change.
        let reference = WorldReference::by(definitions, &world, &first_hits, &screen.camera, Escape::Environment, 2)
            .with_bounces(bounces);
        let mut state = reference.start();
        for begun in (0..spec.rays).step_by(RAYS_AT_ONCE as usize) {
            go_on()?;
            reference.add(&mut state, RAYS_AT_ONCE.min(spec.rays - begun));
        }
        let image = reference.image(&state);
        let before = std::mem::replace(&mut self.color, image.reflection);
        if let Some(last) = &self.screen {
            self.pairs = flicker::pairs(last, &screen);
            self.changes = flicker::changes(&self.pairs, &before, &self.color, screen.width);
            self.change.add(self.pairs.len(), flicker::mean(&self.changes, |_, change| change), 0.0);
        }
        self.mask = screen.reflecting();
        self.standard_error += state.overall_standard_error() / f64::from(spec.frames);
        for (film, colors) in [(&mut self.images, &image.composite), (&mut self.reflections, &self.color)] {
            (film.width, film.height) = (screen.width, screen.height);
            film.frames.push(bytes(colors));
        }
        self.screen = Some(screen);
        Ok(())
    }
}

/// Rays a pixel between two chances to stop.
const RAYS_AT_ONCE: u32 = 16;

fn bytes(colors: &[Vec3]) -> Vec<u8> {
    display(&colors.iter().map(Vec3::to_array).collect::<Vec<_>>())
}

impl Filmed {
    fn add(&mut self, world: &Truth, effect_ms: f64, reflection: &Pixels, image: &Pixels) {
        let colors = |pixels: &Pixels| -> Vec<Vec3> { pixels.texels().map(Vec3::from_slice).collect() };
        let made = colors(reflection);
        let color: Vec<Vec3> = made.iter().copied().map(flicker::sound).collect();
        if !world.pairs.is_empty() && !self.before.is_empty() {
            let changes = flicker::changes(&world.pairs, &self.before, &color, image.width);
            let flicker = flicker::mean(&changes, |_, change| change);
            let error = flicker::mean(&changes, |n, change| change - world.changes[n]);
            self.change.add(changes.len(), flicker, error);
        }
        let arrays = |colors: &[Vec3]| colors.iter().map(Vec3::to_array).collect::<Vec<_>>();
        self.images.frames.push(bytes(&colors(image)));
        self.reflections.frames.push(bytes(&color));
        // FLIP is of all films and frames at once, at the end.
        let rmse = masked_rmse(&arrays(&world.color), &arrays(&made), &world.mask);
        self.frames.push(VideoFrame { effect_ms, rmse, flip: 0.0 });
        self.before = color;
    }
}

fn record(spec: &VideoSpec, start: &View, of: &Variant, mut filmed: Filmed, world: &Truth) -> Result<VideoRecord> {
    let [width, height] = spec.extent;
    let pairs: Vec<_> = world.reflections.frames.iter().zip(&filmed.reflections.frames).collect();
    let flip: Vec<f64> =
        pairs.into_par_iter().map(|(truth, made)| FlipMap::new(truth, made, width, height).mean()).collect();
    filmed.frames.iter_mut().zip(&flip).for_each(|(frame, flip)| frame.flip = *flip);
    let mean = |of: fn(&VideoFrame) -> f64| filmed.frames.iter().map(of).sum::<f64>() / filmed.frames.len() as f64;
    let times: Vec<f64> = filmed.frames.iter().map(|f| f.effect_ms).collect();
    let (setup, place) = (of.setup.at(spec.extent), (spec.scene, start));
    Ok(VideoRecord {
        head: Head::new("video", spec.gpu, place, Of::Method(of.method), &setup, &spec.globals),
        way: spec.way.name().to_owned(),
        moving: spec.moving.to_vec(),
        step_m: spec.step_m.to_array(),
        frames_per_second: spec.frames_per_second,
        rays: spec.rays,
        time_ms: Stats::of(&times).median_ms,
        rmse: mean(|f| f.rmse),
        flip: mean(|f| f.flip),
        flicker: filmed.change.mean(filmed.change.flicker),
        reference_flicker: world.change.mean(world.change.flicker),
        change_error: filmed.change.mean(filmed.change.error),
        jod: jod(&filmed.images, &world.images, spec.frames_per_second)?,
        jod_reflection: jod(&filmed.reflections, &world.reflections, spec.frames_per_second)?,
        standard_error: world.standard_error,
        frames: filmed.frames,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View { eye: Vec3::new(1.0, 1.5, 0.0), look_at: Vec3::new(1.0, 1.5, 2.0), ..View::default() }
    }

    #[test]
    fn who_walks_goes_ahead_and_no_farther_than_half_of_the_way() {
        let far = View { look_at: Vec3::new(1.0, 1.5, 100.0), ..view() };
        let last = |way: Way| way.view(59, 60, 30.0);
        let walked = last(Way::Walk(far.clone())).eye - far.eye;
        assert!((walked - Vec3::Z * WALK * 59.0 / 30.0).length() < 1e-4, "{walked}");
        let near = last(Way::Walk(view()));
        assert!((near.eye - Vec3::new(1.0, 1.5, 1.0)).length() < 1e-5 && near.look_at.z == 3.0, "{near:?}");
        assert_eq!(Way::Walk(view()).view(0, 60, 30.0), view());
    }

    #[test]
    fn who_turns_rests_turns_to_the_right_and_rests() {
        let way = Way::Turn(view());
        let ahead = |frame| (way.view(frame, 60, 30.0).look_at - view().eye).normalize();
        assert_eq!(ahead(20), ahead(0));
        // Three frames at 30 a second are half of the turn.
        let half = ahead(23);
        assert!((half.angle_between(Vec3::Z).to_degrees() - 22.5).abs() < 0.01 && half.x > 0.0, "{half}");
        assert!((ahead(26).angle_between(Vec3::Z).to_degrees() - 45.0).abs() < 0.01);
        assert_eq!(ahead(26), ahead(59));
    }
}
