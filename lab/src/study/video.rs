//! Films: draws variants of methods on every frame of a camera's way, and compares each with the world reference of that frame
//! (docs/definitions.md, "Films").

mod placed;
mod record;
mod way;

pub use record::{VideoFrame, VideoRecord};
pub use way::CameraWay;

use super::compare::display;
use super::engine::{Bench, Planned, Study};
use super::error::{Variant, greatest_bounces};
use super::exhibit::{Content, ExtraFile};
use super::journal::scene_digest;
use super::names::cell_name;
use super::record::{Head, RecordSubject, Stats};
use crate::error::{Error, Result};
use crate::stage::gbuffer;
use crate::stage::{Globals, Shot, Stage};
use glam::Vec3;
use rayon::prelude::*;
use record::WORLD;
use serde_json::json;
use ssct::gpu::frame::Mode;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::Wants;
use ssct_scenes::{Camera, GBufferData, Material, Motion, Scene, View};
use ssct_truth::metrics::flicker::{self, SamePlace};
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::metrics::video::{Film, jod};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;

/// Scene, motion and variants of a film.
pub struct VideoStudy {
    /// Scene.
    pub scene: Scene,
    /// Way of the camera.
    pub way: CameraWay,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Vec<Globals>,
    /// Variants that are compared.
    pub variants: Vec<Variant>,
    /// Frames, ≥ 2.
    pub frames: u32,
    /// Frames shown per second, above 0.
    pub frames_per_second: f32,
    /// Rays a pixel of the world reference, ≥ 2.
    pub rays: u32,
    /// Motion of the scene that is played, if any.
    pub play: Option<Motion>,
    /// Names of the meshes that move in addition.
    pub moving: Vec<String>,
    /// Motion of these meshes from one frame to the next, in metres along the world's axes.
    pub step_m: Vec3,
    /// Number of frames after which these meshes rest; `None` if they never do.
    pub step_frames: Option<u32>,
    /// Names of the meshes that move with the camera, such as a hand in front of it.
    pub held: Vec<String>,
    /// Whether each frame is shifted by another part of a pixel, as in renderers that average frames for antialiasing.
    pub jitter: bool,
}

/// The inputs of a film's measurement: one size with one set of factors.
struct VideoSpec<'a> {
    gpu: &'a Gpu,
    study: &'a VideoStudy,
    extent: [u32; 2],
    globals: Globals,
}

impl Study for VideoStudy {
    type Cell = ([u32; 2], Globals);
    type Row = VideoRecord;

    fn scenes(&self) -> Vec<&Scene> {
        vec![&self.scene]
    }

    /// A cell is a size with a set of factors.
    fn cells(&self) -> Vec<Planned<Self::Cell>> {
        let digest = scene_digest(&self.scene);
        let Self { way, moving, frames, frames_per_second, rays, play, .. } = self;
        let step = (self.step_m.to_array(), self.step_frames);
        let played = play.as_ref().map(|motion| &motion.name);
        let carried = (&self.held, self.jitter);
        let moves = json!([format!("{way:?}"), moving, step, frames, frames_per_second, rays, played, carried]);
        let cell = |extent: [u32; 2], globals: Globals| {
            let set: Vec<_> = self.variants.iter().map(|v| v.settings(extent)).collect();
            Planned {
                name: cell_name(&self.scene.name, way.name(), extent, globals.roughness),
                setup: json!([digest, set, globals, moves]),
                cell: (extent, globals),
            }
        };
        self.sizes
            .iter()
            .flat_map(|size| self.globals.iter().map(move |g| (*size, *g)))
            .map(|(s, g)| cell(s, g))
            .collect()
    }

    /// Films all variants, and keeps the films and that of the world as animated pictures.
    fn measure(&mut self, &(extent, globals): &Self::Cell, bench: &mut Bench) -> Result<Vec<VideoRecord>> {
        let spec = VideoSpec { gpu: bench.gpu, study: self, extent, globals };
        let (records, films) = measure(&spec, bench.go_on)?;
        let Some(first) = records.first() else { return Ok(records) };
        let made = records.iter().map(|r| r.clip_file(&r.head.variant())).zip(films.variants);
        for (path, film) in made.chain([(first.clip_file(WORLD), films.world)]) {
            (bench.keep)(&ExtraFile { path, content: Content::Film(film, self.frames_per_second) })?;
        }
        Ok(records)
    }
}

/// The films of a measurement: the finished images.
struct Films {
    /// Film of the world reference.
    world: Film,
    /// The films of the variants, in their order.
    variants: Vec<Film>,
}

/// State of a variant while its film is made.
struct VariantFilm {
    shot: Shot,
    /// A second shot that makes an image of the reflection; `None` if the timed shot makes one.
    seen: Option<Shot>,
    /// Linear reflection colour of the last frame.
    before: Vec<Vec3>,
    frames: Vec<VideoFrame>,
    change: Change,
    images: Film,
    reflections: Film,
}

/// Sums over pairs of a pixel and the pixel that showed the same surface a frame before.
#[derive(Default)]
struct Change {
    pairs: usize,
    flicker: f64,
    error: f64,
}

impl Change {
    /// Adds one frame: its number of pairs, and the means of the flicker and of the error over these pairs.
    fn add(&mut self, pairs: usize, flicker: f64, error: f64) {
        self.pairs += pairs;
        self.flicker += flicker * pairs as f64;
        self.error += error * pairs as f64;
    }

    /// The mean over all pairs, from one of the sums; 0 without pairs.
    fn mean(&self, sum: f64) -> f64 {
        if self.pairs == 0 { 0.0 } else { sum / self.pairs as f64 }
    }
}

/// Films every variant, frame by frame in turn. `go_on` is called between two steps, and its error ends the filming.
///
/// # Errors
/// [`Usage`](ssct::Error::Usage) if there are too few frames or rays; errors of the device and of `go_on`.
fn measure(spec: &VideoSpec, go_on: fn() -> Result<()>) -> Result<(Vec<VideoRecord>, Films)> {
    if spec.study.frames < 2 || spec.study.rays < 2 {
        return Err(Error::usage("a film needs at least two frames, and its reference two rays a pixel".into()));
    }
    let start = spec.study.way.start();
    let materials = spec.globals.materials(&spec.study.scene, &start);
    let mut stage = Stage::new(spec.gpu, &spec.study.scene)?;
    let first = spec.study.camera(0, spec.extent);
    let mut all = spec
        .study
        .variants
        .iter()
        .map(|v| start_film(spec, &mut stage, v, first, &materials))
        .collect::<Result<Vec<_>>>()?;
    for filmed in &all {
        // The history of each shot settles on the first frame before the film begins.
        stage.settle(&filmed.shot)?;
    }
    let mut world = Truth::default();
    let mut moved = spec.study.scene.clone();
    for frame in 0..spec.study.frames {
        let placed = spec.study.placed(frame);
        for (name, placement) in &placed {
            stage.scene_mut().place_meshes(name, *placement)?;
        }
        if frame > 0 && !placed.is_empty() {
            moved.meshes.clone_from(&spec.study.scene.meshes);
            moved.place_meshes(&placed);
        }
        let camera = spec.study.camera(frame, spec.extent);
        let mut made = Vec::new();
        // Variants begin in turn, since the first shot of a frame may find colder caches.
        let count = all.len();
        for turn in 0..count {
            go_on()?;
            let n = (frame as usize + turn) % count;
            made.push((n, shoot(&mut stage, &mut all[n], camera)?));
        }
        let Some(screen) = all.first().map(|f| gbuffer::read(&mut stage.context, &f.shot)).transpose()? else { break };
        world.trace_frame(spec, screen, &moved, &materials, go_on)?;
        for (n, (effect_ms, reflection, image)) in made {
            all[n].add(&world, effect_ms, &reflection, &image);
        }
    }
    let films = Films { world: world.images.clone(), variants: all.iter().map(|f| f.images.clone()).collect() };
    let records = spec.study.variants.iter().zip(all).map(|(variant, filmed)| {
        go_on()?;
        record(spec, &start, variant, filmed, &world)
    });
    Ok((records.collect::<Result<_>>()?, films))
}

/// Makes the shots of a variant, and a film without frames. The second shot is kept only if the timed one makes no
/// separate image of the reflection.
fn start_film(
    spec: &VideoSpec,
    stage: &mut Stage,
    variant: &Variant,
    camera: Camera,
    materials: &[Material],
) -> Result<VariantFilm> {
    let setup = variant.setup.with_extent(spec.extent);
    let mut shot = |wants| Shot::new(stage, variant.method, &setup, wants, camera, materials.to_vec());
    // The timed shot makes no separate image of the reflection, as in the time study.
    let (timed, seen) = (shot(Wants::IMAGE)?, shot(Wants::REFLECTION)?);
    let makes = stage.output(&timed)?.2.traced.reflection.is_some();
    let film = || Film { width: spec.extent[0], height: spec.extent[1], frames: Vec::new() };
    Ok(VariantFilm {
        shot: timed,
        seen: (!makes).then_some(seen),
        before: Vec::new(),
        frames: Vec::new(),
        change: Change::default(),
        images: film(),
        reflections: film(),
    })
}

/// Draws a frame, and returns the milliseconds of the method, the image of the reflection and the finished image.
fn shoot(stage: &mut Stage, filmed: &mut VariantFilm, camera: Camera) -> Result<(f64, Pixels, Pixels)> {
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

/// The world reference of the film, with its last frame.
#[derive(Default)]
struct Truth {
    screen: Option<GBufferData>,
    mask: Vec<bool>,
    /// Linear reflection colour of the current frame.
    color: Vec<Vec3>,
    /// Pairs of pixels that show the same surface in the last frame and in this one.
    pairs: Vec<SamePlace>,
    /// Change of the reflection colour over each pair.
    changes: Vec<Vec3>,
    change: Change,
    standard_error: f64,
    images: Film,
    reflections: Film,
}

impl Truth {
    /// Traces the world reference of the next frame, for the G-buffer that the variants see.
    fn trace_frame(
        &mut self,
        spec: &VideoSpec,
        screen: GBufferData,
        scene: &Scene,
        materials: &[Material],
        go_on: fn() -> Result<()>,
    ) -> Result<()> {
        let bounces = greatest_bounces(&spec.study.variants);
        let world = World::new(scene, materials);
        let first_hits = FirstHits::shown(&world, &screen);
        // All frames share one seed, so that the noise of a pixel cancels in the difference of two frames, except where its
        // reflection changes.
        let reference = WorldReference::new(&world, &first_hits, &screen.camera, 2).with_bounces(bounces);
        let mut state = reference.start();
        for begun in (0..spec.study.rays).step_by(RAYS_AT_ONCE as usize) {
            go_on()?;
            reference.add(&mut state, RAYS_AT_ONCE.min(spec.study.rays - begun));
        }
        let image = reference.image(&state);
        let before = std::mem::replace(&mut self.color, image.reflection);
        if let Some(last) = &self.screen {
            self.pairs = flicker::pairs(last, &screen);
            self.changes = flicker::changes(&self.pairs, &before, &self.color, screen.width);
            self.change.add(self.pairs.len(), flicker::mean(&self.changes, |_, change| change), 0.0);
        }
        self.mask = screen.reflecting();
        self.standard_error += state.overall_standard_error() / f64::from(spec.study.frames);
        for (film, colors) in [(&mut self.images, &image.composite), (&mut self.reflections, &self.color)] {
            (film.width, film.height) = (screen.width, screen.height);
            film.frames.push(bytes(colors));
        }
        self.screen = Some(screen);
        Ok(())
    }
}

/// Rays a pixel that are traced between two calls of `go_on`.
const RAYS_AT_ONCE: u32 = 16;

/// The display image of linear colours, 3 bytes a pixel.
fn bytes(colors: &[Vec3]) -> Vec<u8> {
    display(&colors.iter().map(Vec3::to_array).collect::<Vec<_>>())
}

impl VariantFilm {
    /// Adds a frame to the film: its time, its error, and its change from the last frame beside that of the world
    /// reference.
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
        // FLIP is computed at the end, for all films and frames at once.
        let rmse = masked_rmse(&arrays(&world.color), &arrays(&made), &world.mask);
        self.frames.push(VideoFrame { effect_ms, rmse, flip: 0.0 });
        self.before = color;
    }
}

/// The record of a variant's film: means over its frames, and its quality beside the film of the world reference.
fn record(
    spec: &VideoSpec,
    start: &View,
    variant: &Variant,
    mut filmed: VariantFilm,
    world: &Truth,
) -> Result<VideoRecord> {
    let [width, height] = spec.extent;
    let pairs: Vec<_> = world.reflections.frames.iter().zip(&filmed.reflections.frames).collect();
    let flip: Vec<f64> =
        pairs.into_par_iter().map(|(truth, made)| FlipMap::new(truth, made, width, height).mean()).collect();
    filmed.frames.iter_mut().zip(&flip).for_each(|(frame, flip)| frame.flip = *flip);
    let mean =
        |value: fn(&VideoFrame) -> f64| filmed.frames.iter().map(value).sum::<f64>() / filmed.frames.len() as f64;
    let times: Vec<f64> = filmed.frames.iter().map(|f| f.effect_ms).collect();
    let (setup, place) = (variant.setup.with_extent(spec.extent), (&spec.study.scene, start));
    Ok(VideoRecord {
        head: Head::new("video", spec.gpu, place, RecordSubject::Method(variant.method), &setup, &spec.globals),
        way: spec.study.way.name().to_owned(),
        play: spec.study.play.as_ref().map(|motion| motion.name.clone()),
        moving: spec.study.moving.clone(),
        step_m: spec.study.step_m.to_array(),
        step_frames: spec.study.step_frames,
        held: spec.study.held.clone(),
        jitter: spec.study.jitter,
        frames_per_second: spec.study.frames_per_second,
        rays: spec.study.rays,
        time_ms: Stats::from_samples(&times).median_ms,
        rmse: mean(|f| f.rmse),
        flip: mean(|f| f.flip),
        flicker: filmed.change.mean(filmed.change.flicker),
        reference_flicker: world.change.mean(world.change.flicker),
        change_error: filmed.change.mean(filmed.change.error),
        jod: jod(&filmed.images, &world.images, spec.study.frames_per_second)?,
        jod_reflection: jod(&filmed.reflections, &world.reflections, spec.study.frames_per_second)?,
        standard_error: world.standard_error,
        frames: filmed.frames,
    })
}
