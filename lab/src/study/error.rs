//! The error study, which sets run time against error. In a cell, which is one view, size and set of factors, variants
//! of methods are timed in turn, and compared with three references on the same G-buffer (docs/definitions.md,
//! "Oracle", "Image error").

mod judged;
mod pictures;
pub mod points;
mod row;
mod suite;
mod truth;

pub use self::judged::ImageError;
use self::judged::{MethodHits, RecordTemplate};
pub use self::pictures::{flip_file, picture_file};
pub use self::row::{ErrorRecord, ErrorReference, source_table};
pub use self::suite::ErrorStudy;
use self::truth::{Truth, truth};
use super::compare::{SEED, display, rgb};
use super::engine::LastMade;
use super::interleave::{self, Round, interleave};
use super::journal::{Journal, digest};
pub use super::names::{EXACT_HITS, SCREEN_REFERENCE};
use super::record::{RecordSubject, Stats};
use crate::error::{Error, Result};
use crate::stage::gbuffer;
use crate::stage::{Globals, SharedImages, Shot, Stage};
use ::ssct::gpu::frame::Mode;
use ::ssct::gpu::{FrameContext, Gpu, Image};
use ::ssct::methods::setup::BeyondScreen;
use ::ssct::methods::ssct::{self, ThesisMethod};
use ::ssct::methods::{EffectParams, Fallback, MethodInfo, Setup, Wants};
use ::ssct::passes::Hits;
use ::ssct::passes::gbuffer::GBufferImages;
use glam::Vec3;
use serde_json::{Value, json};
use ssct_ground::math::OracleVersion;
use ssct_scenes::{Camera, GBufferData, Material, ProjectionKind, Scene, View};
use ssct_truth::metrics::bootstrap::interval_of_median;
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::image::error_map;

/// A method with its parameters.
#[derive(Clone)]
pub struct Variant {
    /// The method.
    pub method: &'static MethodInfo,
    /// Parameters of the method; each cell replaces the size.
    pub setup: Setup,
}

impl Variant {
    /// Makes a variant of each method, all with one setup.
    pub fn for_methods(methods: &[&'static MethodInfo], setup: &Setup) -> Vec<Self> {
        methods.iter().map(|method| Self { method, setup: setup.clone() }).collect()
    }

    /// Whether the variant sees the screen alone: a screen-space method without a fallback, whose rays go on neither among
    /// triangles nor in captures.
    pub fn is_on_screen(&self) -> bool {
        let effect = self.setup.effect();
        let in_captures = self.method.takes_captures && effect.beyond(true) == BeyondScreen::Captures;
        let rays_stay = self.method.is_screen_space() && !effect.is_among_triangles(self.method, true) && !in_captures;
        rays_stay && effect.fallback == Fallback::None
    }

    /// Returns everything that the variant's results at a size in pixels depend on: the method's name and its setup.
    pub fn settings(&self, extent: [u32; 2]) -> Value {
        json!([self.method.name, self.setup.with_extent(extent).recorded(Some(self.method))])
    }
}

/// Returns the greatest number of bounces among some variants; the references of these variants have as many.
pub(super) fn greatest_bounces(variants: &[Variant]) -> u32 {
    variants.iter().map(|v| v.setup.effect().bounces).max().unwrap_or(1)
}

/// A picture of a cell: the linear reflection colour, before fade, by a reference or by a variant.
struct Picture {
    /// Name of the reference or of the variant, for names of files.
    name: String,
    /// Red, green and blue of each pixel.
    color: Vec<[f32; 3]>,
    /// Errors of a variant: against the screen reference, or against the world reference if the variant sees more than
    /// the screen. `None` for references.
    error: Option<ErrorMaps>,
}

/// Errors of each pixel, rows from the top.
struct ErrorMaps {
    /// Root mean square over the three channels of the linear colour.
    rmse: Vec<f32>,
    /// FLIP of the display image.
    flip: FlipMap,
}

/// The results of a cell.
struct MeasuredCell {
    /// Width and height in pixels.
    extent: [u32; 2],
    /// Records of every variant against every reference that it is compared with.
    records: Vec<ErrorRecord>,
    /// Pictures of the references and of the variants.
    pictures: Vec<Picture>,
}

/// Inputs of a cell's measurement, except the device.
struct ErrorSpec<'a> {
    scene: &'a Scene,
    view: &'a View,
    /// Width and height in pixels.
    extent: [u32; 2],
    globals: Globals,
    variants: &'a [Variant],
    /// Frames that warm up before the first timed one.
    warmup: usize,
    /// Number of timed frames.
    samples: usize,
    /// Rays a pixel of the references.
    rays: u32,
    /// [`scene_digest`](super::journal::scene_digest) of the scene.
    scene_digest: String,
}

impl ErrorSpec<'_> {
    /// Returns everything that the cell's times depend on, except the device, the program and the number of samples.
    fn settings(&self) -> Value {
        let variants: Vec<_> = self.variants.iter().map(|v| v.settings(self.extent)).collect();
        let view = format!("{:?}", self.view);
        json!([self.scene_digest, view, self.globals, variants, self.warmup])
    }

    /// Returns the digest of everything that the cell's times depend on, except the number of samples.
    fn digest(&self, gpu: &Gpu) -> String {
        digest(gpu, &self.settings())
    }
}

/// A scene on the device, with the shots of the variants.
struct LoadedScene {
    stage: Stage,
    /// Shots of the last cell, by size and projection; the next cell uses them again if it has the same.
    shots: LastMade<([u32; 2], ProjectionKind), (SharedImages, Vec<Shot>)>,
}

impl LoadedScene {
    /// Uploads a scene; no shots are made yet.
    fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        Ok(Self { stage: Stage::new(gpu, scene)?, shots: LastMade::default() })
    }
}

/// Measures a cell: times the variants, traces the references, and compares the variants' images and hits with them.
/// Frames that the journal has are not timed again. `go_on` is called between two steps, and its error ends the cell.
fn measure(
    gpu: &Gpu,
    spec: &ErrorSpec,
    LoadedScene { stage, shots }: &mut LoadedScene,
    journal: &mut Journal,
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<MeasuredCell> {
    let camera = spec.view.camera(spec.scene, spec.extent);
    let materials = spec.globals.materials(spec.scene, spec.view);
    // Times shots that write no separate image of the reflection, as the time study does.
    let (shared, shots) = shots.get_or_make((spec.extent, camera.kind()), || {
        let methods = spec.variants.iter().map(|v| (v.method, v.setup.with_extent(spec.extent)));
        let mut shared = SharedImages::default();
        let shots = shared.shots(stage, methods, Wants::IMAGE, camera, &materials)?;
        Ok::<_, Error>((shared, shots))
    })?;
    shots.iter_mut().try_for_each(|shot| shot.turn_to(stage, camera, materials.clone()))?;
    shared.draw_anew();
    let times = time_variants((gpu, spec), stage, (shared, shots), journal, go_on)?;
    let mut cell = MeasuredCell { extent: spec.extent, records: Vec::new(), pictures: Vec::new() };
    let Some(first) = shots.first() else { return Ok(cell) };
    // If the journal has all times, no frame was drawn yet, and the G-buffer below needs one.
    shared.draw(stage, Mode::Plain, first)?;
    let screen = gbuffer::read(&mut stage.context, first)?;
    let truth = truth(spec, screen, &materials, greatest_bounces(spec.variants), go_on)?;
    for screen in &truth.screens {
        let name = picture_name(SCREEN_REFERENCE, screen.version);
        cell.pictures.push(Picture { name, color: screen.image.color.clone(), error: None });
    }
    cell.pictures.push(Picture { name: WORLD_REFERENCE.into(), color: truth.world.color.clone(), error: None });
    let mut untimed = UntimedShots { spec, stage, shared, camera, materials: &materials };
    for ((variant, timed_shot), time) in spec.variants.iter().zip(&*shots).zip(times) {
        go_on()?;
        let color = untimed.reflection_color(variant, timed_shot)?;
        let hits = untimed.hits(variant, &truth)?;
        let subject = RecordSubject::Method(variant.method);
        let mut template = RecordTemplate::new(gpu, spec, subject, &variant.setup, Some(&time));
        template.record.prepared = Some(timed_shot.prepared().clone());
        cell.records.extend(template.against_all(&truth, variant.is_on_screen(), &color, hits.as_ref()));
        let is_of_method = |other: &&Variant| other.method.name == variant.method.name;
        let is_alone = spec.variants.iter().filter(is_of_method).count() == 1;
        // Several variants of one method get different names for their pictures.
        let name =
            if is_alone { variant.method.name.to_owned() } else { template.record.head.variant().replace(' ', "-") };
        cell.pictures.push(method_picture(&name, &color, &truth, variant, spec.extent));
    }
    if let Some(variant) = spec.variants.first() {
        add_exact_hits_and_screen_reference(&mut cell, gpu, spec, &truth, variant)?;
    }
    Ok(cell)
}

/// Makes and draws the shots of a cell that are not timed.
struct UntimedShots<'a> {
    spec: &'a ErrorSpec<'a>,
    stage: &'a mut Stage,
    shared: &'a mut SharedImages,
    camera: Camera,
    materials: &'a [Material],
}

impl UntimedShots<'_> {
    /// Makes a shot of a method at the size of the cell.
    fn shot(&mut self, method: &MethodInfo, setup: &Setup, wants: Wants) -> Result<Shot> {
        let setup = setup.with_extent(self.spec.extent);
        Ok(self.shared.shot(self.stage, method, &setup, wants, self.camera, self.materials.to_vec())?)
    }

    /// Draws the linear reflection colour of a variant. Some methods write an image of the reflection even in the timed
    /// shot; others need another shot for it.
    fn reflection_color(&mut self, variant: &Variant, timed_shot: &Shot) -> Result<Vec<[f32; 3]>> {
        let (_, _, output) = self.shared.output_at_rest(self.stage, timed_shot)?;
        if output.traced.reflection.is_some() {
            return Ok(rgb(&gbuffer::reflection(&mut self.stage.context, &output)?));
        }
        let shot = self.shot(variant.method, &variant.setup, Wants::REFLECTION)?;
        let (_, _, output) = self.shared.output_at_rest(self.stage, &shot)?;
        Ok(rgb(&gbuffer::reflection(&mut self.stage.context, &output)?))
    }

    /// Finds where the rays of a variant end; `None` for a method that does not report this. The ends belong to the
    /// method alone, so that its fallback is left out.
    fn hits(&mut self, variant: &Variant, truth: &Truth) -> Result<Option<MethodHits>> {
        let among_triangles = variant.setup.effect().is_among_triangles(variant.method, true);
        if !variant.method.is_screen_space() && !among_triangles {
            return Ok(None);
        }
        let shot = self.shot(variant.method, &without_fallback(&variant.setup), Wants::HITS)?;
        let (_, _, output) = self.shared.output(self.stage, Mode::Plain, &shot)?;
        let hit_image = output.traced.hits.map(|hits| self.stage.context.read(hits.0.all())).transpose()?;
        Ok(hit_image.map(|pixels| MethodHits {
            positions: (!among_triangles).then(|| gbuffer::hit_positions(&pixels)),
            ends: gbuffer::ray_ends(&pixels, &truth.data),
        }))
    }
}

/// Adds the error that is left when every hit is right, and the errors of the screen references against the world.
/// `variant` is the first variant of the cell, whose setup is used.
fn add_exact_hits_and_screen_reference(
    cell: &mut MeasuredCell,
    gpu: &Gpu,
    spec: &ErrorSpec,
    truth: &Truth,
    variant: &Variant,
) -> Result<()> {
    let setup = without_fallback(&variant.setup);
    let color = exact_hits_with_cone(gpu, spec, truth, &setup)?;
    let subject = RecordSubject::Other { name: EXACT_HITS, method: Some(&ssct::INFO) };
    let template = RecordTemplate::new(gpu, spec, subject, &setup, None);
    cell.records.extend(template.against_all(truth, true, &color, None));
    let exact_variant = Variant { setup: setup.clone(), ..variant.clone() };
    cell.pictures.push(method_picture(EXACT_HITS, &color, truth, &exact_variant, spec.extent));
    for screen in &truth.screens {
        let setup = setup.with(|p: &mut EffectParams| p.oracle = screen.version);
        let subject = RecordSubject::Other { name: SCREEN_REFERENCE, method: None };
        let template = RecordTemplate::new(gpu, spec, subject, &setup, None);
        cell.records.push(template.image(ErrorReference::World, truth, &truth.world, &screen.image.color));
    }
    Ok(())
}

/// Name of the world reference's picture.
pub const WORLD_REFERENCE: &str = "world-reference";

/// Returns the name of a picture; with the second version of the oracle, the version is added to `name`.
fn picture_name(name: &str, version: OracleVersion) -> String {
    if version.is_first() { name.to_owned() } else { format!("{name}-oracle-{}", u32::from(version)) }
}

/// Makes the picture of a variant's reflection `color`, with its errors in the reflecting pixels. A variant that sees
/// the screen alone is compared with the screen reference, and any other with the world reference.
fn method_picture(
    name: &str,
    color: &[[f32; 3]],
    truth: &Truth,
    variant: &Variant,
    [width, height]: [u32; 2],
) -> Picture {
    let version = variant.setup.effect().oracle;
    let reference = if variant.is_on_screen() { &truth.screen(version).image } else { &truth.world };
    let error = ErrorMaps {
        rmse: error_map(&reference.color, color, &truth.mask),
        flip: FlipMap::new(&reference.display, &display(color), width, height),
    };
    Picture { name: picture_name(name, version), color: color.to_vec(), error: Some(error) }
}

/// Computes the reflection colour of each pixel by the thesis's cone trace from the oracle's hits, which shows the
/// error of the cone without that of the ray trace. Each bounce reflects the image that includes the bounce before, as
/// in methods.
fn exact_hits_with_cone(gpu: &Gpu, spec: &ErrorSpec, truth: &Truth, setup: &Setup) -> Result<Vec<[f32; 3]>> {
    let [width, height] = spec.extent;
    let mut context = FrameContext::new(gpu)?;
    // Each texel has texture coordinates, standard depth and a path code: 1 for a hit, 3 for a miss.
    let texels: Vec<[f32; 4]> = truth
        .screen(setup.effect().oracle)
        .hits
        .iter()
        .map(|hit| match hit {
            Some(hit) => [hit.x / f64::from(width), hit.y / f64::from(height), 1.0 - hit.z, 1.0].map(|v| v as f32),
            None => [-1.0, -1.0, -1.0, 3.0],
        })
        .collect();
    let hits = Image::from_texels(&mut context, "exact hits", [width, height], &texels)?;
    let method = ThesisMethod::cone_alone(gpu, &setup.with_extent(spec.extent))?;
    let mut data = truth.data.clone();
    // The reflection of the last bounce: red, green, blue and fade of each pixel.
    let mut reflected = Vec::new();
    for bounce in 0..setup.effect().bounces {
        if bounce > 0 {
            data.color = composite(&truth.data, &reflected);
        }
        let images = GBufferImages::upload(&mut context, &data)?;
        let mut frame = context.begin(Mode::Plain)?;
        let reflection = method.record_cone(&mut frame, &images.gbuffer(), &data.camera, Hits(&hits))?;
        frame.finish()?;
        reflected = context.read(reflection.0.all())?.texels().map(|t| [t[0], t[1], t[2], t[3]]).collect();
    }
    Ok(reflected.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect())
}

/// Returns the lit colour of each pixel of a G-buffer plus its reflection, times reflectivity and fade
/// (docs/definitions.md, "Surfaces"). A reflection is red, green, blue and fade.
fn composite(data: &GBufferData, reflection: &[[f32; 4]]) -> Vec<Vec3> {
    let reflectivity = |i: usize| if data.reflects(i) { data.reflectivity[i] } else { 0.0 };
    let pixels = data.color.iter().zip(reflection).enumerate();
    pixels.map(|(i, (lit, [r, g, b, fade]))| *lit + reflectivity(i) * fade * Vec3::new(*r, *g, *b)).collect()
}

/// The time of a variant in a cell.
struct VariantTime {
    /// Median over the frames, in milliseconds.
    median_ms: f64,
    /// Ends in milliseconds of the interval of the median over resamples of the frames; `None` with too few frames.
    interval: Option<[f64; 2]>,
}

/// Times the shots of the variants in turn, except frames that the journal has, and returns the total time of each
/// variant.
fn time_variants(
    (gpu, spec): (&Gpu, &ErrorSpec),
    stage: &mut Stage,
    (shared, shots): (&mut SharedImages, &mut [Shot]),
    journal: &mut Journal,
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<Vec<VariantTime>> {
    let cell_digest = spec.digest(gpu);
    let key = |shot: usize, sample: &str| format!("total {cell_digest} {shot} {sample}");
    let rounds = Round::timed(spec.warmup, spec.samples);
    interleave(stage, (shared, shots), &rounds, &key, journal, go_on)?;
    let total_ms = |shot: usize, sample: usize| {
        interleave::sample_in_journal(journal, &key(shot, &sample.to_string())).map(|s| s.effect_ms())
    };
    let samples_ms = |shot: usize| (0..spec.samples).filter_map(|sample| total_ms(shot, sample)).collect::<Vec<_>>();
    let variant_time = |samples: Vec<f64>| VariantTime {
        median_ms: Stats::from_samples(&samples).median_ms,
        interval: interval_of_median(&samples, SEED),
    };
    Ok((0..shots.len()).map(|shot| variant_time(samples_ms(shot))).collect())
}

/// Returns a setup without its fallback. The setup names where rays go on beyond the screen, so that this does not
/// change.
fn without_fallback(setup: &Setup) -> Setup {
    let beyond = setup.effect().beyond(true);
    setup.with(|p: &mut EffectParams| (p.fallback, p.beyond) = (Fallback::None, beyond))
}
