//! Stability in motion: how much a reflection changes from frame to frame at the same places of a surface, while the
//! camera moves.

use super::lineup::SceneMethods;
use crate::error::Result;
use crate::stage::Globals;
use crate::study::columns::{AsDatum, Datum, columns, figure, nested};
use crate::study::engine::{Bench, Planned, Row, Study};
use crate::study::exhibit::{Table, pivot};
use crate::study::journal::scene_digest;
use crate::study::record::{Provenance, RecordedSetup, recorded_setup, setting_text};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use ssct::gpu::Gpu;
use ssct::methods::{EffectParams, MethodInfo, Setup};
use ssct_scenes::{Camera, GBufferData, Scene, View};
use ssct_truth::metrics::bootstrap::median_of;
use ssct_truth::metrics::flicker::{SamePlace, changes, finite_or_black, mean, pairs};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::screen::{Sampling, ScreenReference};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;

/// How the camera moves from one frame to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// The camera moves sideways, by an eighth of a pixel at the distance of the point that it looks at.
    SubPixel,
    /// The camera turns by a quarter of a pixel.
    SlowPan,
}

/// The seed of both references, equal for all frames, so that the noise of a pixel cancels in the difference of two
/// frames, except where its reflection changes.
const SEED: u64 = 3;

/// All motions.
pub const MOTIONS: [Motion; 2] = [Motion::SubPixel, Motion::SlowPan];

impl Motion {
    /// Returns the name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::SubPixel => "sub-pixel",
            Self::SlowPan => "slow-pan",
        }
    }

    /// Returns the view of a frame, counted from 0. `view` is that of the first frame, and `rows` is the height of the
    /// image in pixels.
    fn view(self, scene: &Scene, view: &View, frame: u32, rows: u32) -> View {
        let lens = view.lens.unwrap_or(scene.lens);
        // The height of a pixel in the middle of the image, in metres for each metre of distance.
        let pixel_slope = lens.height_at_m(1.0) / rows as f32;
        let ahead = view.look_at - view.eye;
        // To the right, and as long as the distance of the point looked at.
        let right = Vec3::Y.cross(ahead).normalize_or(Vec3::X) * ahead.length();
        let n = frame as f32;
        match self {
            Self::SubPixel => {
                let step = right * (n * pixel_slope / 8.0);
                View { eye: view.eye + step, look_at: view.look_at + step, ..view.clone() }
            }
            Self::SlowPan => View { look_at: view.look_at + right * (n * pixel_slope / 4.0), ..view.clone() },
        }
    }
}

columns! {
    /// How a method's reflection changed over some frames.
    pub struct MotionRecord {
        /// Kind of the record, which is always `motion`.
        pub kind: String,
        /// Program and device that measured.
        #[serde(flatten)]
        pub program: Provenance,
        /// Name of the scene.
        pub scene: String = figure(""),
        /// Name of the view that the camera starts from.
        pub view: String = figure(""),
        /// How the camera moves.
        pub motion: Motion = figure(""),
        /// Name of the method.
        pub method: String = figure(""),
        /// Width in pixels.
        pub width: u32 = figure(""),
        /// Height in pixels.
        pub height: u32 = figure(""),
        /// Global roughness.
        pub roughness: f32 = figure(""),
        /// Everything that was set for the measurement, by name.
        pub setup: RecordedSetup,
        /// Number of pairs of a pixel and the pixel that showed the same surface a frame before.
        pub pairs: usize = figure(""),
        /// Mean absolute difference of the linear reflection colour over the pairs and channels; null without pairs.
        pub flicker: Option<f64> = figure(""),
        /// Flicker of the screen reference over these pairs.
        pub reference_flicker: Option<f64> = figure(""),
        /// Flicker of the method divided by that of the screen reference; null if the reference does not change. A
        /// method that shows nothing has 0, so that the ratio alone says nothing.
        pub ratio: Option<f64> = figure(""),
        /// Mean absolute difference between the method's changes and the reference's, divided by the flicker of the
        /// reference: 0 for the reference, 1 for a method that shows nothing.
        pub deviation: Option<f64> = figure(""),
        /// Comparison of the method's changes with those of the world reference; null if it was not asked for.
        pub world: Option<ReferenceComparison> = nested(""),
    }
}

impl AsDatum for Motion {
    fn datum(&self) -> Datum {
        Datum::Text(self.name().to_owned())
    }
}

columns! {
    /// A method's changes compared with those of a reference.
    #[derive(Copy)]
    pub struct ReferenceComparison {
        /// Flicker of the reference over the pairs; null without pairs.
        pub reference_flicker: Option<f64> = figure(""),
        /// Ratio of the method's flicker to the reference's; null where the reference stands still.
        pub ratio: Option<f64> = figure(""),
        /// Deviation of the method's changes from those of this reference; null where the reference stands still.
        pub deviation: Option<f64> = figure(""),
    }
}

impl ReferenceComparison {
    /// Compares the changes of a method's reflection with those of a reference over the same pairs of pixels.
    fn new(changes: &[Vec3], reference_changes: &[Vec3]) -> Self {
        let reference_flicker = flicker(reference_changes);
        let difference = mean(changes, |n, change| change - reference_changes[n]);
        let relative = |v: f64| reference_flicker.filter(|flicker| *flicker > 0.0).map(|flicker| v / flicker);
        let ratio = flicker(changes).and_then(relative);
        Self { reference_flicker, ratio, deviation: relative(difference) }
    }
}

/// Returns the mean absolute value of some changes of colour over their channels; `None` without changes.
fn flicker(changes: &[Vec3]) -> Option<f64> {
    (!changes.is_empty()).then(|| mean(changes, |_, change| change))
}

const ABOUT: &str = "Mean absolute change of the reflection from frame to frame, each pixel beside the same \
    surface a frame before, over the reference's own on the same frames: the median over the views. Columns name \
    the camera's motion and the roughness; 1 is as still as the truth. Behind it, how far the change itself is off the \
    reference's, in the same unit: 0 is the truth, 1 shows nothing.";

impl Row for MotionRecord {
    const KIND: &'static str = "motion";
    const TITLE: &'static str = "Stability in motion";

    fn program(&self) -> &Provenance {
        &self.program
    }

    /// Makes the table of flicker against the screen reference, and that against the world reference, if it was
    /// measured.
    fn tables(rows: &[Self], _: &Value) -> Vec<Table> {
        let screen = medians(rows, |r| r.ratio.zip(r.deviation));
        let mut tables = vec![Table::new("motion", "Flicker over the screen reference's own", ABOUT, screen)];
        if rows.iter().any(|r| r.world.is_some()) {
            let world = medians(rows, |r| r.world.and_then(|w| w.ratio.zip(w.deviation)));
            tables.push(Table::new("motion-world", "Flicker over the world reference's own", ABOUT, world));
        }
        tables
    }
}

/// Makes the cells of a table with a line for each method and a column for each motion and roughness. A cell has the
/// medians over the views of the two figures that `figures` returns: the flicker divided by the reference's, and the
/// deviation.
fn medians(records: &[MotionRecord], figures: impl Fn(&MotionRecord) -> Option<(f64, f64)>) -> Vec<Vec<String>> {
    let motion = |r: &MotionRecord| format!("{} {}", r.motion.name(), r.roughness);
    pivot("method", records, [&MotionRecord::variant, &motion], |here| {
        let (ratios, deviations): (Vec<f64>, Vec<f64>) = here.iter().filter_map(|r| figures(r)).unzip();
        (!ratios.is_empty()).then(|| format!("{:.2} off {:.2}", median_of(ratios), median_of(deviations)))
    })
}

impl MotionRecord {
    /// Returns the name of the method, with its fallback and captures, if it has any.
    pub fn variant(&self) -> String {
        let setting = |name: &str| self.setup.get(name).map(setting_text).unwrap_or_default();
        let addition = |name: &str, words: &str| match setting(name).as_str() {
            "" | "none" => String::new(),
            value => format!(" + {words}{value}"),
        };
        format!("{}{}{}", self.method, addition("fallback", ""), addition("captures", "captures "))
    }
}

/// View and settings of a cell of motion; the scene and the methods are those of a line-up.
pub struct MotionSpec<'a> {
    /// View that the camera starts from.
    pub view: &'a View,
    /// Motion of the camera.
    pub motion: Motion,
    /// Size in pixels, which is the line-up's.
    pub extent: [u32; 2],
    /// Roughness of every surface.
    pub roughness: f32,
    /// Frames, ≥ 2.
    pub frames: u32,
    /// Rays a pixel of the references.
    pub rays: u32,
    /// Whether the changes are also compared with those of the world reference.
    pub against_world: bool,
}

impl MotionSpec<'_> {
    /// Returns the name of the cell in a scene.
    pub fn name(&self, scene: &Scene) -> String {
        let [width, height] = self.extent;
        let Self { roughness, frames, rays, .. } = self;
        let motion = self.motion.name();
        format!("{} {} {width}x{height} {roughness} {motion} {frames} frames {rays} rays", scene.name, self.view.name)
    }
}

/// The study of stability in motion: each view of a scene, at each roughness, with each motion of the camera.
pub struct MotionStudy {
    /// Scene.
    pub scene: Scene,
    /// Views that the camera starts from.
    pub views: Vec<View>,
    /// Methods.
    pub methods: Vec<&'static MethodInfo>,
    /// Parameters of the methods, with the size.
    pub setup: Setup,
    /// Roughness values, each of which every surface gets in turn.
    pub roughness: Vec<f32>,
    /// Frames of each motion, ≥ 2.
    pub frames: u32,
    /// Rays a pixel of the references.
    pub rays: u32,
    /// The methods on the scene, once they are made.
    pub lineup: Option<SceneMethods>,
}

/// A cell of motion.
#[derive(Debug, Clone, Copy)]
pub struct MotionCell {
    /// Index of the view in the study.
    pub view: usize,
    /// Roughness of every surface.
    pub roughness: f32,
    /// Motion of the camera.
    pub motion: Motion,
}

impl MotionStudy {
    /// Returns the view and the settings of a cell.
    fn spec(&self, &MotionCell { view, roughness, motion }: &MotionCell) -> MotionSpec<'_> {
        let (extent, frames, rays) = (self.setup.extent, self.frames, self.rays);
        MotionSpec { view: &self.views[view], motion, extent, roughness, frames, rays, against_world: true }
    }
}

impl Study for MotionStudy {
    type Cell = MotionCell;
    type Row = MotionRecord;

    fn scenes(&self) -> Vec<&Scene> {
        vec![&self.scene]
    }

    /// Lists a cell for each view, roughness and motion.
    fn cells(&self) -> Vec<Planned<MotionCell>> {
        let (digest, mut cells) = (scene_digest(&self.scene), Vec::new());
        let set: Vec<_> = self.methods.iter().map(|m| (m.name, self.setup.recorded(Some(m)))).collect();
        for (n, view) in self.views.iter().enumerate() {
            for &roughness in &self.roughness {
                cells.extend(MOTIONS.map(|motion| {
                    let cell = MotionCell { view: n, roughness, motion };
                    let name = self.spec(&cell).name(&self.scene);
                    Planned { setup: json!([name, digest, set, format!("{view:?}")]), name, cell }
                }));
            }
        }
        cells
    }

    /// Runs the motion of a cell. The methods of the last cell are used again if the view has the same kind of
    /// projection.
    fn measure(&mut self, cell: &MotionCell, bench: &mut Bench) -> Result<Vec<MotionRecord>> {
        let view = &self.views[cell.view];
        let kind = view.lens.unwrap_or(self.scene.lens).kind();
        let mut lineup = match self.lineup.take().filter(|lineup| lineup.kind == kind) {
            Some(lineup) => lineup,
            None => {
                let scene = Scene { views: vec![view.clone()], ..self.scene.clone() };
                SceneMethods::new(bench.gpu, scene, &self.setup, &self.methods)?
            }
        };
        let rows = run(bench.gpu, &self.spec(cell), &mut lineup, &mut bench.go_on);
        self.lineup = Some(lineup);
        rows
    }
}

/// Draws the frames of a motion by the methods of `lineup`, compares the changes of their reflections from frame to
/// frame with those of the references, and makes a record of each method. `go_on` is called between two steps, and its
/// error ends the motion.
///
/// # Errors
/// Errors of the device and of `go_on`.
pub fn run(
    gpu: &Gpu,
    spec: &MotionSpec,
    lineup: &mut SceneMethods,
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<Vec<MotionRecord>> {
    let globals = Globals { roughness: Some(spec.roughness), ..Globals::default() };
    let materials = globals.materials(&lineup.scene, spec.view);
    lineup.set_materials(&materials)?;
    let extent = spec.extent;
    let cameras: Vec<Camera> = (0..spec.frames)
        .map(|n| spec.motion.view(&lineup.scene, spec.view, n, extent[1]).camera(&lineup.scene, extent))
        .collect();
    let methods: Vec<_> = lineup.methods().collect();
    // The G-buffer of each frame, and for each method the reflection colours of each frame.
    let mut screens: Vec<GBufferData> = Vec::new();
    let mut images: Vec<Vec<Vec<Vec3>>> = vec![Vec::new(); methods.len()];
    if let Some(first) = cameras.first() {
        lineup.settle(*first)?;
    }
    for camera in cameras {
        go_on()?;
        screens.extend(lineup.draw(camera)?);
        for (frames, pixels) in images.iter_mut().zip(lineup.reflections()?) {
            frames.push(pixels.texels().map(|t| finite_or_black(Vec3::new(t[0], t[1], t[2]))).collect());
        }
    }
    let EffectParams { oracle, bounces, .. } = lineup.setup.effect();
    let sampling = Sampling { samples: spec.rays, seed: SEED, oracle, bounces };
    let mut reference: Vec<Vec<Vec3>> = Vec::new();
    for screen in &screens {
        reference.push(ScreenReference::render_while(screen, &screen.reflecting(), sampling, go_on)?.color);
    }
    let pairs: Vec<Vec<SamePlace>> = screens.windows(2).map(|w| pairs(&w[0], &w[1])).collect();
    // Returns the changes of colour over the pairs of all frames, frame after frame.
    let changes_of = |images: &[Vec<Vec3>]| -> Vec<Vec3> {
        let frames = pairs.iter().zip(images.windows(2));
        frames.flat_map(|(pairs, two)| changes(pairs, &two[0], &two[1], extent[0])).collect()
    };
    let screen_changes = changes_of(&reference);
    let mut world_changes = None;
    if spec.against_world {
        let world = World::new(&lineup.scene, &materials);
        let mut images = Vec::new();
        for screen in &screens {
            images.push(world_image(&world, screen, (bounces, spec.rays), go_on)?);
        }
        world_changes = Some(changes_of(&images));
    }
    let lens = spec.view.lens.unwrap_or(lineup.scene.lens);
    let record = |(method, images): (&&MethodInfo, &Vec<Vec<Vec3>>)| {
        let changes = changes_of(images);
        let against_screen = ReferenceComparison::new(&changes, &screen_changes);
        MotionRecord {
            kind: "motion".to_owned(),
            program: Provenance::on(gpu),
            scene: lineup.scene.name.clone(),
            view: spec.view.name.clone(),
            motion: spec.motion,
            method: method.name.to_owned(),
            width: extent[0],
            height: extent[1],
            roughness: spec.roughness,
            setup: recorded_setup(&lineup.setup, Some(method), &lens, &globals),
            pairs: changes.len(),
            flicker: flicker(&changes),
            reference_flicker: against_screen.reference_flicker,
            ratio: against_screen.ratio,
            deviation: against_screen.deviation,
            world: world_changes.as_ref().map(|world_changes| ReferenceComparison::new(&changes, world_changes)),
        }
    };
    Ok(methods.iter().zip(&images).map(record).collect())
}

/// Rays a pixel of the world reference that are traced between two calls of `go_on`.
const RAYS_AT_ONCE: u32 = 16;

/// Traces the world reference of a G-buffer with a number of bounces and of rays a pixel, and returns its reflection
/// colours. The error of `go_on` ends the tracing.
fn world_image(
    world: &World,
    screen: &GBufferData,
    (bounces, rays): (u32, u32),
    go_on: &mut dyn FnMut() -> Result<()>,
) -> Result<Vec<Vec3>> {
    let first_hits = FirstHits::shown(world, screen);
    let reference = WorldReference::new(world, &first_hits, &screen.camera, SEED).with_bounces(bounces);
    let mut state = reference.start();
    while state.samples() < rays {
        go_on()?;
        let count = RAYS_AT_ONCE.min(rays - state.samples());
        reference.add(&mut state, count);
    }
    Ok(reference.image(&state).reflection)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::columns::Columns;
    use ssct::gpu::DeviceInfo;

    /// Makes the record of a method in a view, by its comparison with the screen reference and with the world.
    fn record(view: &str, screen: ReferenceComparison, world: Option<ReferenceComparison>) -> MotionRecord {
        let device = DeviceInfo { name: "d".into(), driver: "d".into(), api: "1.3".into(), kind: "CPU".into() };
        MotionRecord {
            kind: "motion".into(),
            program: Provenance { definitions: 3, version: "1".into(), commit: "c".into(), device },
            scene: "rooms".into(),
            view: view.into(),
            motion: Motion::SlowPan,
            method: "ssct".into(),
            width: 8,
            height: 8,
            roughness: 0.0,
            setup: RecordedSetup::new(),
            pairs: 64,
            flicker: Some(0.5),
            reference_flicker: screen.reference_flicker,
            ratio: screen.ratio,
            deviation: screen.deviation,
            world,
        }
    }

    /// Makes a comparison with a reference.
    fn compared(ratio: f64, deviation: f64) -> ReferenceComparison {
        ReferenceComparison { reference_flicker: Some(0.25), ratio: Some(ratio), deviation: Some(deviation) }
    }

    #[test]
    fn the_median_over_two_views_is_the_mean_of_both() {
        let still = ReferenceComparison { ratio: None, deviation: None, ..compared(0.0, 0.0) };
        let mut records = vec![
            record("a", compared(1.0, 0.5), Some(compared(2.0, 1.0))),
            record("b", compared(2.0, 0.25), Some(compared(4.0, 2.0))),
            record("c", still, Some(still)),
        ];
        let cells = |records: &[MotionRecord]| {
            let tables = MotionRecord::tables(records, &Value::Null);
            tables.into_iter().map(|table| table.cells[1][1].clone()).collect::<Vec<_>>()
        };
        assert_eq!(cells(&records), ["1.50 off 0.38", "3.00 off 1.50"]);
        records.push(record("d", compared(8.0, 0.75), None));
        assert_eq!(cells(&records), ["2.00 off 0.50", "3.00 off 1.50"]);
        assert_eq!(cells(&records[2..3]), ["-", "-"]);
    }

    #[test]
    fn without_pairs_of_pixels_nothing_is_known() {
        let nothing = ReferenceComparison { reference_flicker: None, ratio: None, deviation: None };
        assert_eq!((flicker(&[]), ReferenceComparison::new(&[], &[])), (None, nothing));
        let still = ReferenceComparison { reference_flicker: Some(0.0), ..nothing };
        assert_eq!(ReferenceComparison::new(&[Vec3::ONE], &[Vec3::ZERO]), still);
        let found = ReferenceComparison::new(&[Vec3::ONE], &[Vec3::splat(-0.5)]);
        assert_eq!(found, ReferenceComparison { reference_flicker: Some(0.5), ..compared(2.0, 3.0) });
    }

    #[test]
    fn csv_files_have_the_comparison_with_the_world_by_the_names_of_the_records() {
        let written = |record: &MotionRecord| {
            let columns = MotionRecord::columns().columns;
            let of_world = columns.iter().filter(|column| column.name.starts_with("world."));
            of_world.map(|column| (column.name.clone(), column.written(record))).collect::<Vec<_>>()
        };
        let names = ["world.reference_flicker", "world.ratio", "world.deviation"];
        let expected = |values: [&str; 3]| {
            names.into_iter().zip(values).map(|(name, value)| (name.to_owned(), value.to_owned())).collect::<Vec<_>>()
        };
        let with_world = record("a", compared(1.0, 0.5), Some(compared(2.0, 1.5)));
        assert_eq!(written(&with_world), expected(["0.25", "2", "1.5"]));
        assert_eq!(written(&record("a", compared(1.0, 0.5), None)), expected([""; 3]));
        let json = json!(with_world);
        assert!(names.iter().all(|name| json.pointer(&format!("/{}", name.replace('.', "/"))).is_some()), "{json}");
    }
}
