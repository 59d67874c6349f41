//! Counts the cells that the rays of `unified` look at, which are their steps. The twin of its walk counts on the CPU,
//! since both take the same steps.

use super::columns::{AsDatum, Datum, columns, figure};
use super::exhibit::Table;
use super::record::Provenance;
use crate::error::Result;
use crate::stage::gbuffer;
use crate::stage::{Globals, Stage};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use ssct::gpu::Gpu;
use ssct_geometry::placement::{self, WantedCaptures};
use ssct_scenes::{Aabb, GBufferData, Scene, View};
use ssct_truth::reference::CaptureData;
use ssct_truth::reference::unified::{CaptureTraversal, ScreenRayEnd, Traversal};

/// Number of lanes of a CPU device whose rays walk together, so that all of them wait for the longest walk.
const LANES: usize = 8;

/// The images in which steps are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StepsIn {
    /// On the screen, which is the only image.
    Screen,
    /// On the screen, for rays that go on in captures: a walk ends where the screen loses the ray.
    ScreenBeforeCaptures,
    /// In captures, for rays that the screen lost.
    Captures,
}

impl StepsIn {
    /// Returns the name of the images on a page.
    fn label(self) -> &'static str {
        match self {
            Self::Screen => "the screen alone",
            Self::ScreenBeforeCaptures => "the screen, before captures",
            Self::Captures => "four captures",
        }
    }
}

impl AsDatum for StepsIn {
    fn datum(&self) -> Datum {
        Datum::Text(self.label().to_owned())
    }
}

columns! {
    /// The steps of the mirror rays of a view.
    pub struct StepsRecord {
        /// Kind of the record, which is always `steps`.
        pub kind: String,
        /// Definitions, version, commit and device.
        #[serde(flatten)]
        pub program: Provenance,
        /// Scene name.
        pub scene: String = figure("scene"),
        /// View name.
        pub view: String = figure("view"),
        /// Width in pixels.
        pub width: u32 = figure("width"),
        /// Height in pixels.
        pub height: u32 = figure("height"),
        /// Images in which the steps are counted.
        pub images: StepsIn = figure("in"),
        /// Number of rays: one for each pixel that reflects, or for each of these pixels whose ray the screen lost.
        pub rays: usize = figure("rays"),
        /// Mean number of steps of a ray.
        pub mean: f64 = figure("mean").digits(1),
        /// Mean, over groups of eight rays of pixels beside each other, of the most steps in a group: what eight threads take
        /// that wait for each other.
        pub mean_of_eight: f64 = figure("mean of eight").digits(1),
        /// Median number of steps of a ray.
        pub median: u32 = figure("median"),
        /// Number of steps that 99 % of the rays do not exceed.
        pub p99: u32 = figure("p99"),
        /// Greatest number of steps of a ray.
        pub most: u32 = figure("most"),
    }
}

const ABOUT: &str = "How many cells a mirror ray of unified looks at, counted by its twin on the CPU, which takes the same steps. \
    Mean of eight: the mean of the most among eight rays beside each other, as threads wait that walk together.";

impl StepsRecord {
    /// Makes a table of the steps.
    pub fn table(rows: &[Self]) -> Table {
        Table { title: "Steps".to_owned(), about: ABOUT.to_owned(), ..Table::of_rows("steps", rows) }
    }
}

/// Counts the steps of the mirror rays of a view, whose G-buffer is `data`: without captures, and with four captures
/// that the program places. Returns a record for each of [`StepsIn`], in that order.
///
/// # Errors
/// Errors of the device.
pub fn count(gpu: &Gpu, scene: &Scene, view: &View, globals: &Globals, data: &GBufferData) -> Result<[StepsRecord; 3]> {
    let screen_alone = Traversal::new(data);
    let pixels = blocks(data);
    let steps_alone = |(x, y): &(u32, u32)| screen_alone.mirror_steps(*x, *y);
    let steps_alone: Vec<u32> = pixels.par_iter().filter_map(steps_alone).collect();

    let (captures, bounds) = draw_captures(gpu, scene, view, globals)?;
    let screen_before = screen_alone.followed();
    let beyond = CaptureTraversal::new(&data.camera, &captures).with_bounds(bounds);
    let steps_before = |(x, y): &(u32, u32)| screen_before.mirror_steps(*x, *y);
    let steps_before: Vec<u32> = pixels.par_iter().filter_map(steps_before).collect();
    let steps_in_captures = |(x, y): &(u32, u32)| match beyond.trace_screen(&screen_before, *x, *y) {
        ScreenRayEnd::Lost(ray) if data.reflects(data.index(*x, *y)) => {
            Some(beyond.trace_captures(&ray).steps.max(0) as u32)
        }
        _ => None,
    };
    let steps_in_captures: Vec<u32> = pixels.par_iter().filter_map(steps_in_captures).collect();

    let record = |images, steps: Vec<u32>| StepsRecord::from_steps(gpu, [&scene.name, &view.name], data, images, steps);
    Ok([
        record(StepsIn::Screen, steps_alone),
        record(StepsIn::ScreenBeforeCaptures, steps_before),
        record(StepsIn::Captures, steps_in_captures),
    ])
}

/// Returns the column and row of every pixel, block by block of 4 × 2 pixels, so that neighbours stand together in the
/// list.
fn blocks(data: &GBufferData) -> Vec<(u32, u32)> {
    let row_of_corners = |row: u32| (0..data.width.div_ceil(4)).map(move |column| (4 * column, 2 * row));
    let corners = (0..data.height.div_ceil(2)).flat_map(row_of_corners);
    let all = corners.flat_map(|(x, y)| (0..8).map(move |i| (x + i % 4, y + i / 4)));
    all.filter(|(x, y)| *x < data.width && *y < data.height).collect()
}

/// Places four captures in the scene, as the program does, and draws them on the device. Returns the captures, and the
/// scene's bounds.
fn draw_captures(gpu: &Gpu, scene: &Scene, view: &View, globals: &Globals) -> Result<(Vec<CaptureData>, Aabb)> {
    let mut scene = scene.clone();
    placement::with_captures(&mut scene, WantedCaptures::Count(4));
    let materials = globals.materials(&scene, view);
    let mut drawn: Vec<CaptureData> =
        scene.captures.iter().map(|c| CaptureData { place: c.position, faces: Vec::new() }).collect();
    let mut stage = Stage::new(gpu, &scene)?;
    gbuffer::draw_captures(&mut stage, &materials, &scene.captures, |capture, _, face| {
        drawn[capture].faces.push(face);
        Ok(())
    })?;
    Ok((drawn, stage.scene().bounds()))
}

impl StepsRecord {
    /// Makes the record from the number of steps of each ray. The rays are in the order of [`blocks`], so that each
    /// [`LANES`] consecutive rays form a group of threads that wait for each other.
    fn from_steps(
        gpu: &Gpu,
        [scene, view]: [&str; 2],
        data: &GBufferData,
        images: StepsIn,
        mut steps: Vec<u32>,
    ) -> Self {
        let groups = steps.chunks(LANES);
        let group_count = groups.len();
        let most_in_groups = groups.map(|group| f64::from(group.iter().copied().max().unwrap_or(0)));
        let mean_of_eight = most_in_groups.sum::<f64>() / group_count.max(1) as f64;
        steps.sort_unstable();
        // The number of steps that a share of the rays does not exceed.
        let rank = |share: f64| steps.get(((steps.len() as f64 * share) as usize).min(steps.len().saturating_sub(1)));
        Self {
            kind: "steps".into(),
            program: Provenance::on(gpu),
            scene: scene.to_owned(),
            view: view.to_owned(),
            width: data.width,
            height: data.height,
            images,
            rays: steps.len(),
            mean: steps.iter().map(|n| f64::from(*n)).sum::<f64>() / steps.len().max(1) as f64,
            mean_of_eight,
            median: rank(0.5).copied().unwrap_or(0),
            p99: rank(0.99).copied().unwrap_or(0),
            most: steps.last().copied().unwrap_or(0),
        }
    }
}
