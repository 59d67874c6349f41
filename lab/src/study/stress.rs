//! The stress study of numerical stability: methods run on adversarial G-buffers, cameras, captures and triangles. The
//! bits of their pixels are checked on the host, and their hits are compared with the oracle's or the world's.

pub mod captures;
pub mod cases;
pub mod lineup;
pub mod motion;
mod row;
pub mod suite;
pub mod trees;

pub use row::StressRow;
pub use suite::StressStudy;

use super::columns::{columns, figure, time};
use super::record::{Provenance, RecordedSetup, recorded_setup};
use super::ties::is_tie;
use crate::error::Result;
use crate::stage::Globals;
use crate::stage::gbuffer::hit_positions;
use cases::Case;
use glam::Vec3;
use lineup::{FrameImages, SceneMethods, ScreenMethods};
use rayon::prelude::*;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::{MethodInfo, Setup};
use ssct::passes::PathCode;
use ssct::passes::gbuffer::GBufferImages;
use ssct_ground::math::random::Stream;
use ssct_scenes::{GBufferData, Lens, Scene, View};
use ssct_truth::metrics::hits::HitVerdict;
use ssct_truth::reference::hierarchy::Hierarchy;

/// The method that must pass every case. Published methods must only finish.
pub const JUDGED: &str = "unified";

/// Greatest number of reflecting pixels of a case whose hits are compared; if there are more, a random sample is
/// compared.
pub const COMPARED_PIXELS: usize = 8192;

/// Share of the compared pixels whose hits must agree with the oracle's; ties count as agreeing.
pub const AGREEMENT: f64 = 0.9999;

/// A frame counts as slow if it takes more milliseconds than this, with [`SLOW_MS_PER_PIXEL`] added for each pixel. No
/// method is nearly as slow on an idle device; an endless loop is slower, and so may be a frame on a busy machine.
const SLOW_MS: f64 = 5_000.0;
/// Milliseconds for each pixel (see [`SLOW_MS`]).
const SLOW_MS_PER_PIXEL: f64 = 0.02;

columns! {
    /// The result of a method on a case.
    pub struct StressRecord {
        /// Kind of the record, which is always `stress`.
        pub kind: String,
        /// Program and device that measured.
        #[serde(flatten)]
        pub program: Provenance,
        /// Name of the case.
        pub case: String = figure(""),
        /// Method name.
        pub method: String = figure(""),
        /// Width in pixels.
        pub width: u32 = figure(""),
        /// Height in pixels.
        pub height: u32 = figure(""),
        /// Everything that was set for the measurement, by name.
        pub setup: RecordedSetup,
        /// Number of pixels of the image.
        pub pixels: usize = figure(""),
        /// Number of pixels with a NaN in the reflection, or in the image where the lit colour is finite and not
        /// negative.
        pub nan: usize = figure(""),
        /// Number of pixels with an infinity in the reflection, or in the image where the lit colour is finite and not
        /// negative.
        pub inf: usize = figure(""),
        /// Number of pixels with a negative number in the reflection, or in the image where the lit colour is finite
        /// and not negative.
        pub negative: usize = figure(""),
        /// Number of pixels whose ray ran out of steps or has no known path code; null if the method writes no hits.
        pub exhausted: Option<usize> = figure(""),
        /// Number of reflecting pixels whose hits were compared with the oracle's, or in scenes of hard triangles with
        /// the world's; null if the truth is not known or the method has no hits.
        pub compared: Option<usize> = figure(""),
        /// Share of the compared pixels whose hits agree.
        pub hit_agreement: Option<f64> = figure(""),
        /// Number of compared pixels that disagree, but would agree for a ray that differs by rounding alone; null if
        /// ties were not counted.
        pub ties: Option<usize> = figure(""),
        /// Time of the method in milliseconds.
        pub time_ms: f64 = time(""),
        /// Whether the frame took far longer than any method takes. A busy machine is enough for that, so that a slow
        /// frame fails nothing.
        #[serde(default)]
        pub slow: bool = time(""),
        /// Whether the method must pass: [`JUDGED`] must pass every case, and methods that follow rays in captures or
        /// among triangles must pass the cases that try these. Other methods need only finish.
        #[serde(default)]
        pub judged: bool = figure(""),
        /// Whether no pixel is NaN, infinite, negative or exhausted, and enough compared pixels agree, with ties
        /// counted as agreeing: a share of [`AGREEMENT`], or among hard triangles the share that [`trees`] asks for.
        pub pass: bool = figure(""),
    }
}

/// Numbers of pixels with a NaN, with an infinity, and with a negative number; a pixel may count in several.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct WrongPixels {
    nan: usize,
    inf: usize,
    negative: usize,
}

impl WrongPixels {
    /// Counts pixels by the bits of their channels in some images of one size. `is_checked` says whether a pixel is
    /// checked in an image, by the index of the image and of the pixel.
    fn count(images: &[&Pixels], is_checked: impl Fn(usize, usize) -> bool) -> Self {
        let mut wrong = Self::default();
        let pixels = images.first().map_or(0, |p| p.values.len() / p.channels);
        for pixel in 0..pixels {
            let mut has = [false; 3];
            for (n, image) in images.iter().enumerate() {
                if !is_checked(n, pixel) {
                    continue;
                }
                for value in &image.values[pixel * image.channels..][..image.channels] {
                    if let Some(kind) = wrong_kind(*value) {
                        has[kind as usize] = true;
                    }
                }
            }
            wrong.nan += usize::from(has[WrongKind::Nan as usize]);
            wrong.inf += usize::from(has[WrongKind::Infinite as usize]);
            wrong.negative += usize::from(has[WrongKind::Negative as usize]);
        }
        wrong
    }
}

/// A kind of number that no pixel may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WrongKind {
    Nan,
    Infinite,
    Negative,
}

/// Returns the kind of a wrong number, by its bits; `None` for any other number, including minus zero.
fn wrong_kind(number: f32) -> Option<WrongKind> {
    let bits = number.to_bits();
    let (exponent, mantissa) = (bits >> 23 & 0xff, bits & 0x7f_ffff);
    match (exponent, mantissa) {
        (0xff, 0) => Some(WrongKind::Infinite),
        (0xff, _) => Some(WrongKind::Nan),
        // The sign is set, and another bit is, too.
        _ if bits >> 31 == 1 && bits << 1 != 0 => Some(WrongKind::Negative),
        _ => None,
    }
}

/// Runs the screen-space methods of `lineup`, which are made for the case's size, on the G-buffer of a case, and makes
/// a record of each.
pub fn run(gpu: &Gpu, case: &Case, lineup: &mut ScreenMethods) -> Result<Vec<StressRecord>> {
    if lineup.len() == 0 {
        return Ok(Vec::new());
    }
    let data = case.gbuffer();
    let images = GBufferImages::upload_unsound(&mut lineup.context, &data)?;
    let truth = case.comparable.then(|| Truth::new(&data));
    let mut records = Vec::new();
    for n in 0..lineup.len() {
        let (method, frame) = lineup.reflect(n, &images.gbuffer(), &data.camera)?;
        let setup = Setup::on_screen(case.extent());
        let judged = JudgedFrame { case: &case.name, setup: &setup, globals: &Globals::default(), must_pass: false };
        let compared = truth.as_ref().and_then(|truth| truth.compare(&frame, method));
        records.push(frame.judge(gpu, &judged, method, &data, compared));
    }
    Ok(records)
}

/// The oracle's hits of the reflecting pixels that are compared.
struct Truth<'a> {
    hierarchy: Hierarchy<'a>,
    /// Indices of the compared pixels.
    pixels: Vec<u32>,
    /// The hit of each of `pixels`, in pixels; `None` for a miss.
    hits: Vec<Option<[f64; 2]>>,
}

impl<'a> Truth<'a> {
    /// Traces the mirror rays of the reflecting pixels of a G-buffer, or of [`COMPARED_PIXELS`] of them drawn at random
    /// if there are more.
    fn new(data: &'a GBufferData) -> Self {
        let hierarchy = Hierarchy::new(data);
        let mut pixels: Vec<u32> = (0..data.depth.len() as u32).filter(|i| data.reflects(*i as usize)).collect();
        if pixels.len() > COMPARED_PIXELS {
            let random = Stream::new(11, 0);
            let total = pixels.len() as f64;
            pixels = (0..COMPARED_PIXELS as u64).map(|n| pixels[(random.uniform(n) * total) as usize]).collect();
        }
        let trace = |i: &u32| hierarchy.trace(i % data.width, i / data.width).position_px();
        let hits = pixels.par_iter().map(trace).collect();
        Self { hierarchy, pixels, hits }
    }

    /// Compares the hits of a method's frame with the oracle's; `None` for a method without hits. Ties are counted for
    /// [`JUDGED`] alone, since each takes hundreds of rays to find.
    fn compare(&self, frame: &FrameImages, method: &MethodInfo) -> Option<ComparedRays> {
        let hits = hit_positions(frame.hits.as_ref()?);
        let verdict = |n: usize| HitVerdict::compare(hits[self.pixels[n] as usize], self.hits[n]);
        let wrong: Vec<usize> = (0..self.pixels.len()).filter(|n| verdict(*n) != HitVerdict::Agrees).collect();
        let width = self.hierarchy.rays().gbuffer.width;
        let is_tied = |n: &&usize| {
            let pixel = self.pixels[**n];
            is_tie(&self.hierarchy, [pixel % width, pixel / width], hits[pixel as usize])
        };
        let ties = (method.name == JUDGED).then(|| wrong.par_iter().filter(is_tied).count());
        Some(ComparedRays { rays: self.pixels.len(), wrong: wrong.len(), ties, required_share: AGREEMENT })
    }
}

/// Counts of the rays of a frame whose ends were compared with the truth.
struct ComparedRays {
    /// Compared rays.
    rays: usize,
    /// Rays whose end differs from the truth.
    wrong: usize,
    /// Wrong rays that differ by rounding alone; `None` if they were not counted.
    ties: Option<usize>,
    /// The share of the rays that must be right; ties count as right.
    required_share: f64,
}

impl ComparedRays {
    /// Returns the share of the rays that are right; `None` without rays.
    fn agreement(&self) -> Option<f64> {
        (self.rays > 0).then(|| (self.rays - self.wrong) as f64 / self.rays as f64)
    }

    /// Whether enough of the rays are right, with ties counted as right.
    fn passes(&self) -> bool {
        (self.rays - self.wrong + self.ties.unwrap_or(0)) as f64 >= self.required_share * self.rays as f64
    }
}

/// The fields of a record that do not follow from the images of a judged frame.
struct JudgedFrame<'a> {
    /// Name of the case.
    case: &'a str,
    setup: &'a Setup,
    globals: &'a Globals,
    /// Whether every method must pass, instead of [`JUDGED`] alone.
    must_pass: bool,
}

impl FrameImages {
    /// Makes the record of a method's frame on the G-buffer `data`: counts its wrong pixels, and says whether it
    /// passes. `compared` has the counts of rays, if ends were compared with a truth.
    fn judge(
        &self,
        gpu: &Gpu,
        &JudgedFrame { case, setup, globals, must_pass }: &JudgedFrame,
        method: &MethodInfo,
        data: &GBufferData,
        compared: Option<ComparedRays>,
    ) -> StressRecord {
        // The composite, which is image 1, includes the lit colour, and is checked where the lit colour is sound.
        let is_lit_soundly = |i: usize| data.color[i].to_array().iter().all(|v| wrong_kind(*v).is_none());
        let wrong =
            WrongPixels::count(&[&self.reflection, &self.composite], |image, i| image == 0 || is_lit_soundly(i));
        let exhausted = self.hits.as_ref().map(|hits| {
            let is_exhausted = |t: &&[f32]| PathCode::from_channel(t[3]).is_none_or(PathCode::is_exhausted);
            hits.texels().filter(is_exhausted).count()
        });
        let pixels = data.depth.len();
        let time_ms = self.report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum();
        StressRecord {
            kind: "stress".to_owned(),
            program: Provenance::on(gpu),
            case: case.to_owned(),
            method: method.name.to_owned(),
            width: data.width,
            height: data.height,
            setup: recorded_setup(setup, Some(method), &data.camera.lens, globals),
            pixels,
            nan: wrong.nan,
            inf: wrong.inf,
            negative: wrong.negative,
            exhausted,
            compared: compared.as_ref().map(|c| c.rays),
            hit_agreement: compared.as_ref().and_then(ComparedRays::agreement),
            ties: compared.as_ref().and_then(|c| c.ties),
            time_ms,
            slow: time_ms > SLOW_MS + SLOW_MS_PER_PIXEL * pixels as f64,
            judged: must_pass || method.name == JUDGED,
            pass: wrong == WrongPixels::default()
                && exhausted.is_none_or(|n| n == 0)
                && compared.is_none_or(|c| c.passes()),
        }
    }
}

/// A camera at an unusual place.
pub struct Place {
    /// Name of the camera's place in records, such as "rooms: camera on the floor".
    pub name: String,
    /// The camera in the scene before the offset moves both.
    view: View,
    /// Offset of the whole scene along each axis, in metres.
    pub offset: f32,
}

/// Makes unusual places of the camera from the scene's first view: inside geometry, on a reflector, at a grazing angle,
/// and far from the origin. No places without a view.
pub fn places(scene: &Scene) -> Vec<Place> {
    let Some(view) = scene.views.first() else { return Vec::new() };
    let bounds = scene.bounds();
    let place = |name: &str, eye: Vec3, look_at: Vec3, offset: f32| Place {
        name: format!("{}: camera {name}", scene.name),
        view: View { name: "stress".into(), eye, look_at, ..view.clone() },
        offset,
    };
    let floor = Vec3::new(view.eye.x, bounds.min.y, view.eye.z);
    let ahead = view.look_at - view.eye;
    let level_ahead = Vec3::new(ahead.x, 0.0, ahead.z).normalize_or(Vec3::Z);
    let wide_range = Lens { near_m: 1e-3, far_m: 1e4, ..view.lens.unwrap_or(scene.lens) };
    let mut all = vec![
        place("where it belongs", view.eye, view.look_at, 0.0),
        place("on the floor", floor, floor + level_ahead, 0.0),
        place("a millimetre above the floor", floor + 1e-3 * Vec3::Y, floor + level_ahead, 0.0),
        place("a hand below the floor", floor - 0.1 * Vec3::Y, floor + level_ahead, 0.0),
        place("straight down", view.eye, view.eye - Vec3::Y, 0.0),
        place("straight up", view.eye, view.eye + Vec3::Y, 0.0),
        place("in a corner of the bounds", bounds.min, bounds.max, 0.0),
        place("outside, looking away", bounds.max + 10.0, bounds.max + 20.0, 0.0),
    ];
    let mut with_wide_range = place("with a range of 1 to 10 million", view.eye, view.look_at, 0.0);
    with_wide_range.view.lens = Some(wide_range);
    all.push(with_wide_range);
    // Places that move the scene come last, so that those before them can share one scene.
    all.push(place("a kilometre from the origin", view.eye, view.look_at, 1e3));
    all.push(place("1000 km from the origin", view.eye, view.look_at, 1e6));
    all
}

/// Returns a copy of the scene, moved by the offset of a place.
pub fn moved(scene: &Scene, place: &Place) -> Scene {
    let mut scene = scene.clone();
    scene.translate(Vec3::splat(place.offset));
    scene
}

/// Runs the methods of `lineup` at an unusual place of the camera, with every surface as a mirror and as a glossy one,
/// and makes a record of each run. The methods were made with their hits for the [`moved`] scene. Hits of mirrors are
/// compared with the oracle's on the G-buffer that the device drew.
pub fn run_place(gpu: &Gpu, place: &Place, lineup: &mut SceneMethods) -> Result<Vec<StressRecord>> {
    let mut view = place.view.clone();
    view.eye += place.offset;
    view.look_at += place.offset;
    let camera = view.camera(&lineup.scene, lineup.extent);
    let mut records = Vec::new();
    for roughness in [0.0, 0.3] {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        lineup.set_materials(&globals.materials(&lineup.scene, &view))?;
        let name = format!("{}, roughness {roughness}", place.name);
        let Some(data) = lineup.draw(camera)? else { continue };
        let frames = lineup.read_images()?;
        let is_compared = roughness == 0.0 && lineup.methods().any(MethodInfo::is_screen_space);
        let truth = is_compared.then(|| Truth::new(&data));
        let judged = JudgedFrame { case: &name, setup: &lineup.setup, globals: &globals, must_pass: false };
        records.extend(lineup.methods().zip(&frames).map(|(m, frame)| {
            // The screen's oracle does not know hits in captures.
            let truth = truth.as_ref().filter(|_| m.is_screen_space());
            frame.judge(gpu, &judged, m, &data, truth.and_then(|truth| truth.compare(frame, m)))
        }));
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_apart_by_their_bits() {
        for sound in [0.0, -0.0, 1.0, 1e-45, f32::MAX] {
            assert_eq!(wrong_kind(sound), None, "{sound}");
        }
        assert_eq!([f32::NAN, -f32::NAN].map(wrong_kind), [Some(WrongKind::Nan); 2]);
        assert_eq!([f32::INFINITY, f32::NEG_INFINITY].map(wrong_kind), [Some(WrongKind::Infinite); 2]);
        assert_eq!([-1.0, -1e-45, f32::MIN].map(wrong_kind), [Some(WrongKind::Negative); 3]);
    }
}
