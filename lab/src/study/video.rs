//! The study of films: a camera moves through a scene, every frame is drawn by all variants of methods, and each
//! variant's frames are compared with the world reference of these frames (docs/definitions.md, "Films").

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
    /// How the camera moves.
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
    /// Names of the meshes that move in steps, in addition to `play`.
    pub moving: Vec<String>,
    /// Motion of the meshes `moving` from one frame to the next, in metres along the world's axes.
    pub step_m: Vec3,
    /// Number of frames after which the meshes `moving` rest; `None` if they never do.
    pub step_frames: Option<u32>,
    /// Names of the meshes that move with the camera, such as a hand in front of it.
    pub held: Vec<String>,
    /// Whether each frame is shifted by another part of a pixel, as in renderers that average frames for antialiasing.
    pub jitter: bool,
}

/// The inputs of a cell's measurement: the study at one size with one set of factors.
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

    /// Lists a cell for each size and set of factors.
    fn cells(&self) -> Vec<Planned<Self::Cell>> {
        let digest = scene_digest(&self.scene);
        let Self { way, moving, frames, frames_per_second, rays, play, .. } = self;
        let step = (self.step_m.to_array(), self.step_frames);
        let played = play.as_ref().map(|motion| &motion.name);
        let carried = (&self.held, self.jitter);
        let motion = json!([format!("{way:?}"), moving, step, frames, frames_per_second, rays, played, carried]);
        let planned = |(extent, globals): ([u32; 2], Globals)| {
            let set: Vec<_> = self.variants.iter().map(|v| v.settings(extent)).collect();
            Planned {
                name: cell_name(&self.scene.name, way.name(), extent, globals.roughness),
                setup: json!([digest, set, globals, motion]),
                cell: (extent, globals),
            }
        };
        let cells = self.sizes.iter().flat_map(|size| self.globals.iter().map(move |globals| (*size, *globals)));
        cells.map(planned).collect()
    }

    /// Films all variants, keeps their films and the film of the world reference as animated pictures, and returns a
    /// record of each variant.
    fn measure(&mut self, &(extent, globals): &Self::Cell, bench: &mut Bench) -> Result<Vec<VideoRecord>> {
        let spec = VideoSpec { gpu: bench.gpu, study: self, extent, globals };
        let (records, films) = measure(&spec, bench.go_on)?;
        let Some(first) = records.first() else { return Ok(records) };
        let variant_films = records.iter().map(|r| r.clip_file(&r.head.variant())).zip(films.variants);
        for (path, film) in variant_films.chain([(first.clip_file(WORLD), films.world)]) {
            (bench.keep)(&ExtraFile { path, content: Content::Film(film, self.frames_per_second) })?;
        }
        Ok(records)
    }
}

/// The films of a cell, which show the finished images.
struct Films {
    /// Film of the world reference.
    world: Film,
    /// The films of the variants, in their order.
    variants: Vec<Film>,
}

/// The state of a variant while its film is made.
struct VariantFilm {
    /// The shot that is timed.
    timed_shot: Shot,
    /// A second shot that makes an image of the reflection; `None` if the timed shot makes one.
    reflection_shot: Option<Shot>,
    /// Linear reflection colour of the last frame; empty before the first.
    last_color: Vec<Vec3>,
    /// Figures and times of each frame.
    frames: Vec<VideoFrame>,
    /// Changes of the reflection from frame to frame.
    change_sums: ChangeSums,
    /// The finished images.
    images: Film,
    /// The images of the reflection alone.
    reflections: Film,
}

/// Sums over pairs of a pixel and the pixel that showed the same surface a frame before.
#[derive(Default)]
struct ChangeSums {
    /// Number of pairs.
    pairs: usize,
    /// Sum of the absolute changes of colour.
    flicker: f64,
    /// Sum of the absolute differences between these changes and those of the world reference.
    error: f64,
}

impl ChangeSums {
    /// Adds a frame, by its number of pairs, and the means of the flicker and of the error over these pairs.
    fn add(&mut self, pairs: usize, flicker: f64, error: f64) {
        self.pairs += pairs;
        self.flicker += flicker * pairs as f64;
        self.error += error * pairs as f64;
    }

    /// Returns the mean over all pairs of `sum`, which is one of the sums; `None` without pairs.
    fn mean(&self, sum: f64) -> Option<f64> {
        (self.pairs > 0).then(|| sum / self.pairs as f64)
    }
}

/// Draws the frames of a film, each by every variant in turn, and returns a record of each variant, and the films.
/// `go_on` is called between two steps, and its error ends the measurement.
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
    let first_camera = spec.study.camera(0, spec.extent);
    let mut films = Vec::new();
    for variant in &spec.study.variants {
        films.push(start_film(spec, &mut stage, variant, first_camera, &materials)?);
    }
    for film in &films {
        // The history of each shot settles on the first frame before the film begins.
        stage.settle(&film.timed_shot)?;
    }
    let mut world = Truth::default();
    // The scene of the world reference, in which the meshes that move stand at their places in the frame.
    let mut moved_scene = spec.study.scene.clone();
    for frame in 0..spec.study.frames {
        let placements = spec.study.placements(frame);
        for (name, placement) in &placements {
            stage.scene_mut().place_meshes(name, *placement)?;
        }
        if frame > 0 && !placements.is_empty() {
            moved_scene.meshes.clone_from(&spec.study.scene.meshes);
            moved_scene.place_meshes(&placements);
        }
        let camera = spec.study.camera(frame, spec.extent);
        let mut drawn = Vec::new();
        // Each frame begins with another variant, since the first shot of a frame may find colder caches.
        for turn in 0..films.len() {
            go_on()?;
            let n = (frame as usize + turn) % films.len();
            drawn.push((n, shoot(&mut stage, &mut films[n], camera)?));
        }
        // All variants draw one G-buffer; without variants there is no film.
        let Some(first) = films.first() else { break };
        let screen = gbuffer::read(&mut stage.context, &first.timed_shot)?;
        world.trace_frame(spec, screen, &moved_scene, &materials, go_on)?;
        for (n, (effect_ms, reflection, image)) in drawn {
            films[n].add(&world, effect_ms, &reflection, &image);
        }
    }
    let images = Films { world: world.images.clone(), variants: films.iter().map(|f| f.images.clone()).collect() };
    let mut records = Vec::new();
    for (variant, film) in spec.study.variants.iter().zip(films) {
        go_on()?;
        records.push(record(spec, &start, variant, film, &world)?);
    }
    Ok((records, images))
}

/// Makes the shots of a variant, and its films without frames. The second shot is kept only if the timed shot makes no
/// image of the reflection.
fn start_film(
    spec: &VideoSpec,
    stage: &mut Stage,
    variant: &Variant,
    camera: Camera,
    materials: &[Material],
) -> Result<VariantFilm> {
    let setup = variant.setup.with_extent(spec.extent);
    let mut shot = |wants| Shot::new(stage, variant.method, &setup, wants, camera, materials.to_vec());
    // The timed shot is not asked for an image of the reflection, as in the time study; some methods make one
    // nevertheless.
    let (timed_shot, reflection_shot) = (shot(Wants::IMAGE)?, shot(Wants::REFLECTION)?);
    let (_, _, output) = stage.output(&timed_shot)?;
    let makes_reflection = output.traced.reflection.is_some();
    let film = || Film { width: spec.extent[0], height: spec.extent[1], frames: Vec::new() };
    Ok(VariantFilm {
        timed_shot,
        reflection_shot: (!makes_reflection).then_some(reflection_shot),
        last_color: Vec::new(),
        frames: Vec::new(),
        change_sums: ChangeSums::default(),
        images: film(),
        reflections: film(),
    })
}

/// Draws a frame, and returns the milliseconds of the method, the image of the reflection and the finished image.
/// If the timed shot makes no image of the reflection, the second shot draws one, which is not timed.
fn shoot(stage: &mut Stage, film: &mut VariantFilm, camera: Camera) -> Result<(f64, Pixels, Pixels)> {
    film.timed_shot.camera = camera;
    let (report, _, output) = stage.output_in(Mode::Timed, &film.timed_shot)?;
    let effect_ms = report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum();
    let image = stage.context.read(output.composite.level(0))?;
    let reflection = match &mut film.reflection_shot {
        None => gbuffer::reflection(&mut stage.context, &output)?,
        Some(shot) => {
            shot.camera = camera;
            let (_, _, output) = stage.output(shot)?;
            gbuffer::reflection(&mut stage.context, &output)?
        }
    };
    Ok((effect_ms, reflection, image))
}

/// The film of the world reference, with data of its current frame.
#[derive(Default)]
struct Truth {
    /// G-buffer of the current frame; `None` before the first.
    screen: Option<GBufferData>,
    /// Whether each pixel of the current frame reflects.
    mask: Vec<bool>,
    /// Linear reflection colour of the current frame.
    color: Vec<Vec3>,
    /// Pairs of a pixel of the current frame and the pixel that showed the same surface a frame before.
    pairs: Vec<SamePlace>,
    /// ChangeSums of the reflection colour over each of `pairs`.
    changes: Vec<Vec3>,
    /// Sums over the pairs of all frames.
    change_sums: ChangeSums,
    /// Mean over the frames of the standard error, to which each frame adds its share.
    standard_error: f64,
    /// The finished images.
    images: Film,
    /// The images of the reflection alone.
    reflections: Film,
}

impl Truth {
    /// Traces the world reference of the next frame, for the G-buffer `screen` that the variants see. `scene` has the
    /// meshes at their places in this frame.
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
        for traced in (0..spec.study.rays).step_by(RAYS_AT_ONCE as usize) {
            go_on()?;
            reference.add(&mut state, RAYS_AT_ONCE.min(spec.study.rays - traced));
        }
        let image = reference.image(&state);
        let last_color = std::mem::replace(&mut self.color, image.reflection);
        if let Some(last_screen) = &self.screen {
            self.pairs = flicker::pairs(last_screen, &screen);
            self.changes = flicker::changes(&self.pairs, &last_color, &self.color, screen.width);
            self.change_sums.add(self.pairs.len(), flicker::mean(&self.changes, |_, change| change), 0.0);
        }
        self.mask = screen.reflecting();
        self.standard_error += state.overall_standard_error() / f64::from(spec.study.frames);
        for (film, colors) in [(&mut self.images, &image.composite), (&mut self.reflections, &self.color)] {
            (film.width, film.height) = (screen.width, screen.height);
            film.frames.push(display_bytes(colors));
        }
        self.screen = Some(screen);
        Ok(())
    }
}

/// Rays a pixel that are traced between two calls of `go_on`.
const RAYS_AT_ONCE: u32 = 16;

/// Converts linear colours to a display image, 3 bytes a pixel.
fn display_bytes(colors: &[Vec3]) -> Vec<u8> {
    display(&colors.iter().map(Vec3::to_array).collect::<Vec<_>>())
}

impl VariantFilm {
    /// Adds a frame: its images `reflection` and `image`, its time, its error, and its changes from the last frame.
    /// `world` has the world reference of the frame.
    fn add(&mut self, world: &Truth, effect_ms: f64, reflection: &Pixels, image: &Pixels) {
        let colors = |pixels: &Pixels| -> Vec<Vec3> { pixels.texels().map(Vec3::from_slice).collect() };
        let raw_color = colors(reflection);
        let color: Vec<Vec3> = raw_color.iter().copied().map(flicker::finite_or_black).collect();
        if !world.pairs.is_empty() && !self.last_color.is_empty() {
            let changes = flicker::changes(&world.pairs, &self.last_color, &color, image.width);
            let flicker = flicker::mean(&changes, |_, change| change);
            let error = flicker::mean(&changes, |n, change| change - world.changes[n]);
            self.change_sums.add(changes.len(), flicker, error);
        }
        let arrays = |colors: &[Vec3]| colors.iter().map(Vec3::to_array).collect::<Vec<_>>();
        self.images.frames.push(display_bytes(&colors(image)));
        self.reflections.frames.push(display_bytes(&color));
        // FLIP is computed at the end, for all films and frames at once.
        let rmse = masked_rmse(&arrays(&world.color), &arrays(&raw_color), &world.mask);
        self.frames.push(VideoFrame { effect_ms, rmse, flip: 0.0 });
        self.last_color = color;
    }
}

/// Makes the record of a variant's film: means over its frames, and its quality beside the film of the world reference.
/// `start` is the view from which the camera begins.
fn record(
    spec: &VideoSpec,
    start: &View,
    variant: &Variant,
    mut film: VariantFilm,
    world: &Truth,
) -> Result<VideoRecord> {
    let [width, height] = spec.extent;
    let image_pairs: Vec<_> = world.reflections.frames.iter().zip(&film.reflections.frames).collect();
    let flip: Vec<f64> =
        image_pairs.into_par_iter().map(|(truth, made)| FlipMap::new(truth, made, width, height).mean()).collect();
    film.frames.iter_mut().zip(&flip).for_each(|(frame, flip)| frame.flip = *flip);
    let mean = |value: fn(&VideoFrame) -> f64| film.frames.iter().map(value).sum::<f64>() / film.frames.len() as f64;
    let times: Vec<f64> = film.frames.iter().map(|f| f.effect_ms).collect();
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
        flicker: film.change_sums.mean(film.change_sums.flicker),
        reference_flicker: world.change_sums.mean(world.change_sums.flicker),
        change_error: film.change_sums.mean(film.change_sums.error),
        jod: jod(&film.images, &world.images, spec.study.frames_per_second)?,
        jod_reflection: jod(&film.reflections, &world.reflections, spec.study.frames_per_second)?,
        standard_error: world.standard_error,
        frames: film.frames,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_no_pairs_have_no_mean_and_others_weigh_frames_by_their_pairs() {
        let mut sums = ChangeSums::default();
        sums.add(0, 0.0, 0.0);
        assert_eq!((sums.mean(sums.flicker), sums.mean(sums.error)), (None, None));
        sums.add(1, 0.5, 0.0);
        sums.add(3, 0.25, 0.5);
        assert_eq!((sums.mean(sums.flicker), sums.mean(sums.error)), (Some(0.3125), Some(0.375)));
    }
}
