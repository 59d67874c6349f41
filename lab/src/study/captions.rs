//! The times in the captions of the thesis's figures 5.2 to 5.9, beside times measured here. Only the ratio of a figure's two
//! times can be compared between machines.

use super::TimeRecord;
use super::exhibit::Table;
use super::names::roughness_name;
use super::record::{Head, RecordSubject};
use crate::stage::Globals;
use serde::Serialize;
use ssct::gpu::Gpu;
use ssct::methods::Setup;
use ssct_scenes::{Scene, View};
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use std::time::Instant;

/// The name of the ground truth among the methods: Mitsuba in print, the world reference here.
pub const REFERENCE: &str = "reference";

/// The two times under a figure (thesis ch. 5; NVIDIA GeForce GTX 670, the effect without the scene).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Caption {
    /// Number of the figure.
    pub figure: &'static str,
    /// Built-in scene that stands for the figure.
    pub scene: &'static str,
    /// View that stands for the figure, in the built-in scene and in the scene files of the originals.
    pub view: &'static str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Milliseconds of SSCT.
    pub ssct_ms: f64,
    /// Method or reference that SSCT is compared with: a method, or [`REFERENCE`].
    pub other: &'static str,
    /// Milliseconds of the method or reference that SSCT is compared with.
    pub other_ms: f64,
}

/// Makes a caption from its fields, in their order; the pair has the scene and the view that stand for the figure.
const fn caption(
    figure: &'static str,
    [scene, view]: [&'static str; 2],
    size: [u32; 2],
    ssct_ms: f64,
    other: &'static str,
    other_ms: f64,
) -> Caption {
    Caption { figure, scene, view, size, ssct_ms, other, other_ms }
}

/// Every figure of the thesis with times.
pub const CAPTIONS: [Caption; 6] = [
    caption("5.2", ["rooms", "window-floor"], [960, 540], 2.25, "hzct", 1.12),
    caption("5.4", ["rooms", "two-cylinders"], [960, 540], 3.94, "sslr", 1.30),
    caption("5.5", ["rooms", "window"], [1920, 1080], 6.83, "sslr", 9.08),
    caption("5.6", ["atrium", "atrium"], [960, 540], 1.20, "sslr", 1.20),
    caption("5.7", ["atrium", "lion"], [960, 540], 0.74, "sslr", 0.83),
    // The caption gives Mitsuba's time as 04:05 min.
    caption("5.9", ["rooms", "corridor"], [1280, 720], 2.87, REFERENCE, 245e3),
];

/// Wall time of the world reference on the CPU.
#[derive(Debug, Clone, PartialEq, Serialize, serde::Deserialize)]
pub struct ReferenceTime {
    /// Scene, view and size of the measurement; the method is [`REFERENCE`].
    #[serde(flatten)]
    pub head: Head,
    /// Rays a pixel.
    pub rays: u32,
    /// Threads that traced the rays.
    pub threads: usize,
    /// Milliseconds for the first hits and all rays; building the hierarchy of the triangles is not included.
    pub wall_ms: f64,
}

/// Traces the world reference of a view once, on the CPU, and measures the time. `extent` is the size in pixels, and
/// `rays` the number of rays a pixel.
pub fn time_reference(
    gpu: &Gpu,
    scene: &Scene,
    view: &View,
    extent: [u32; 2],
    globals: &Globals,
    rays: u32,
) -> ReferenceTime {
    let materials = globals.materials(scene, view);
    let world = World::new(scene, &materials);
    let camera = view.camera(scene, extent);
    let start = Instant::now();
    let first_hits = FirstHits::trace(&world, &camera, extent);
    let setup = Setup::new(extent);
    let seed = 1;
    let reference = WorldReference::new(&world, &first_hits, &camera, seed);
    let mut state = reference.start();
    reference.add(&mut state, rays);
    let subject = RecordSubject::Other { name: REFERENCE, method: None };
    let wall_ms = start.elapsed().as_secs_f64() * 1e3;
    let head = Head::new("reference", gpu, (scene, view), subject, &setup, globals);
    ReferenceTime { head, rays, threads: rayon::current_num_threads(), wall_ms }
}

/// The time of SSCT, the other time of the caption, and their ratio.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TimePair {
    /// Milliseconds of SSCT.
    pub ssct_ms: f64,
    /// Milliseconds of the other method or of the reference.
    pub other_ms: f64,
    /// `other_ms` over `ssct_ms`.
    pub ratio: f64,
}

impl TimePair {
    /// Makes a pair of two times in milliseconds.
    fn new(ssct_ms: f64, other_ms: f64) -> Self {
        Self { ssct_ms, other_ms, ratio: other_ms / ssct_ms }
    }
}

/// A caption beside its measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedCaption {
    /// The caption.
    pub caption: Caption,
    /// Roughness of the measurement; the captions give none.
    pub roughness: Option<f32>,
    /// Times in print.
    pub published: TimePair,
    /// Times measured here; `None` where one of the two is missing.
    pub measured: Option<TimePair>,
}

/// Compares captions with measurements of the same view and size. The result has a row for each caption and each record
/// of SSCT, of which there is one for each roughness.
pub fn compare(records: &[TimeRecord], references: &[ReferenceTime]) -> Vec<ComparedCaption> {
    let mut rows = Vec::new();
    for caption in CAPTIONS {
        let is_of_caption = |head: &Head| head.view == caption.view && [head.width, head.height] == caption.size;
        for ssct in records.iter().filter(|r| is_of_caption(&r.head) && r.head.method == "ssct") {
            let is_other = |head: &Head| {
                is_of_caption(head) && head.method == caption.other && head.roughness == ssct.head.roughness
            };
            let method_ms = records.iter().find(|r| is_other(&r.head)).map(|r| r.total.median_ms);
            let reference_ms = references.iter().find(|r| is_other(&r.head)).map(|r| r.wall_ms);
            let other_ms = method_ms.or(reference_ms);
            rows.push(ComparedCaption {
                caption,
                roughness: ssct.head.roughness,
                published: TimePair::new(caption.ssct_ms, caption.other_ms),
                measured: other_ms.map(|other_ms| TimePair::new(ssct.total.median_ms, other_ms)),
            });
        }
    }
    rows
}

/// The table of the captions beside times measured here, with a note on the reference that stands in for Mitsuba.
pub fn table(records: &[TimeRecord], references: &[ReferenceTime]) -> Table {
    let note = |r: &ReferenceTime| {
        format!(
            "In the place of Mitsuba: this program's world reference on the CPU ({} threads), first hits and {} rays a \
             pixel of the lobe, one bounce, {} x {}. It grows with the rays; the thesis does not say its number.",
            r.threads, r.rays, r.head.width, r.head.height
        )
    };
    let about = references.iter().map(note).collect::<Vec<_>>().join(" ");
    let title = "Times in the captions of the thesis, and the same here".to_owned();
    Table { id: "captions", title, about, cells: cells(&compare(records, references)), ..Table::default() }
}

/// The cells of the table, header first: for each compared caption, the printed and the measured milliseconds, and the
/// ratios of the other method's time to that of SSCT.
fn cells(rows: &[ComparedCaption]) -> Vec<Vec<String>> {
    let header = [
        "figure",
        "view",
        "size",
        "roughness",
        "against SSCT",
        "SSCT thesis ms",
        "other thesis ms",
        "SSCT here ms",
        "other here ms",
        "other/SSCT thesis",
        "other/SSCT here",
    ];
    let mut cells = vec![header.map(str::to_owned).to_vec()];
    for row in rows {
        let caption = row.caption;
        let other_name = if caption.other == REFERENCE { "Mitsuba".into() } else { caption.other.to_uppercase() };
        let number = |pair: Option<TimePair>, value: fn(&TimePair) -> f64| match pair {
            Some(pair) => format!("{:.2}", value(&pair)),
            None => "-".into(),
        };
        cells.push(vec![
            caption.figure.to_owned(),
            caption.view.to_owned(),
            format!("{} x {}", caption.size[0], caption.size[1]),
            roughness_name(row.roughness),
            other_name,
            number(Some(row.published), |p| p.ssct_ms),
            number(Some(row.published), |p| p.other_ms),
            number(row.measured, |p| p.ssct_ms),
            number(row.measured, |p| p.other_ms),
            number(Some(row.published), |p| p.ratio),
            number(row.measured, |p| p.ratio),
        ]);
    }
    cells
}
