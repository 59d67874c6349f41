//! The path study: the camera moves along a path, and each frame is drawn by all methods in turn. The result is each
//! method's frames per second, as Schmidt's figures 42 and 52 plot them (2013, sections 5.3.2 and 5.4.2).

use super::cell_list::{CellList, ListedResult};
use super::columns::{columns, nested, part, series, time};
use super::engine::{Bench, Planned, Row, Study};
use super::exhibit::{Chart, Drawing, Line};
use super::interleave::{Round, interleave, sample_in_journal};
use super::journal::{Journal, scene_digest};
use super::names::cell_name;
use super::record::{Head, Provenance, RecordSubject, Stats};
use crate::error::Result;
use crate::stage::{Globals, SharedImages, Stage};
use serde::Deserialize;
use serde_json::{Value, json};
use ssct::gpu::Gpu;
use ssct::gpu::frame::Mode;
use ssct::methods::{MethodInfo, Setup, Wants};
use ssct_scenes::{CameraPath, Scene, View};

/// Methods and settings of the study, with the path of the camera.
pub struct PathStudy {
    /// Scene, whose own lens and materials are used along the whole path.
    pub scene: Scene,
    /// Path of the camera.
    pub path: CameraPath,
    /// Methods; each frame is drawn by all of them in turn.
    pub methods: Vec<&'static MethodInfo>,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Globals,
    /// Setup of the methods; each of `sizes` replaces its size.
    pub setup: Setup,
    /// Number of frames at the beginning of the path that warm up and do not count.
    pub warmup: usize,
    /// Number of frames from the first key frame of the path to the last, ≥ 1.
    pub frames: usize,
}

columns! {
    /// A frame along the path.
    #[derive(Copy)]
    pub struct PathFrame {
        /// Milliseconds on the device from the frame's first timestamp to its last, scene passes included.
        pub frame_ms: f64 = time(""),
        /// Milliseconds of the passes that count, which are those of the method.
        pub effect_ms: f64 = time(""),
        /// 1000 / `frame_ms`.
        pub fps: f64 = time(""),
    }
}

columns! {
    /// Frames per second over a whole path.
    #[derive(Copy)]
    pub struct Fps {
        /// Frames per second at the median time of a frame.
        pub median: f64 = time("median").digits(2),
        /// Frames per second that 95 % of the frames reach: at the 95th percentile of the frames' times.
        pub p95: f64 = time("p95").digits(2),
        /// Frames per second of the slowest 1 % of the frames, at least one: the number of these frames divided by
        /// their time.
        pub low_1_percent: f64 = time("1 % low").digits(2),
    }
}

columns! {
    /// One method at one size on one path.
    pub struct PathRecord {
        /// Subject of the record; the view is the path.
        #[serde(flatten)]
        pub head: Head = part(),
        /// Times of whole frames.
        pub frame: Stats = nested("frame ms"),
        /// Times of the method.
        pub effect: Stats = nested("effect ms"),
        /// Frames per second.
        pub fps: Fps = nested("fps"),
        /// Every frame in order.
        pub frames: Vec<PathFrame> = series(),
    }
}

impl Row for PathRecord {
    const KIND: &'static str = "path";
    const TITLE: &'static str = "Frames per second along a path";
    const IS_SAMPLED: bool = true;

    fn program(&self) -> &Provenance {
        &self.head.program
    }

    /// Draws a line for each record: frames per second over the frames.
    fn charts(rows: &[Self]) -> Vec<Chart> {
        let heads: Vec<&Head> = rows.iter().map(|r| &r.head).collect();
        let line = |r: &Self| {
            let points = r.frames.iter().enumerate().map(|(n, frame)| (n as f64, frame.fps));
            Line { name: r.head.line_name(&heads, &r.head.method_and_fallback()), points: points.collect() }
        };
        let axes = ["frame along the path", "frames per second, whole frame on the device"].map(str::to_owned);
        let lines = Drawing::Lines(axes, rows.iter().map(line).collect());
        vec![Chart::new("path", "Frames per second, frame by frame", lines)]
    }

    fn is_whole(list: &CellList, result: &ListedResult, journal: &Journal) -> bool {
        (0..frames_of(list)).all(|n| sample_in_journal(journal, &key(&result.key, n)).is_some())
    }

    /// Makes the record of a method from its frames in the journal, of which a run that was ended early has fewer. No
    /// record is made without frames.
    fn read(list: &CellList, result: &ListedResult, journal: &Journal) -> Vec<Self> {
        let frame = |n: usize| {
            let sample = sample_in_journal(journal, &key(&result.key, n))?;
            let frame_ms = sample.report.frame_ms;
            Some(PathFrame { frame_ms, effect_ms: sample.effect_ms(), fps: 1000.0 / frame_ms.max(1e-6) })
        };
        let frames: Vec<PathFrame> = (0..frames_of(list)).filter_map(frame).collect();
        let head = Head::deserialize(&result.record_head).ok().filter(|_| !frames.is_empty());
        let record = |head| {
            let frame_ms: Vec<f64> = frames.iter().map(|f| f.frame_ms).collect();
            let effect_ms: Vec<f64> = frames.iter().map(|f| f.effect_ms).collect();
            let fps = Fps::from_frame_times(&frame_ms);
            Self { head, frame: Stats::from_samples(&frame_ms), effect: Stats::from_samples(&effect_ms), fps, frames }
        };
        head.map(record).into_iter().collect()
    }
}

/// Returns the number of frames along the path, which the settings of the list have.
fn frames_of(list: &CellList) -> usize {
    list.settings["frames"].as_u64().unwrap_or(0) as usize
}

/// Returns the key of a frame in the journal; `prefix` is the beginning of the keys of all frames of a method.
fn key(prefix: &str, frame: usize) -> String {
    format!("{prefix} {frame}")
}

impl Fps {
    /// Computes frame rates from the times of frames in milliseconds; all are 0 without frames.
    fn from_frame_times(frame_ms: &[f64]) -> Self {
        let fps = |ms: f64| if ms > 0.0 { 1000.0 / ms } else { 0.0 };
        let stats = Stats::from_samples(frame_ms);
        // The slowest hundredth of the frames, at least one.
        let mut slowest = frame_ms.to_vec();
        slowest.sort_by(|a, b| b.total_cmp(a));
        slowest.truncate(frame_ms.len().div_ceil(100));
        let slowest_mean_ms = slowest.iter().sum::<f64>() / slowest.len().max(1) as f64;
        Self { median: fps(stats.median_ms), p95: fps(stats.p95_ms), low_1_percent: fps(slowest_mean_ms) }
    }
}

impl PathStudy {
    /// Returns the view of a frame, counted from 0; the first frame is at the path's beginning, and the last at its
    /// end.
    fn view(&self, frame: usize) -> View {
        let (eye, look_at) = self.path.eye_and_look_at(frame as f32 / (self.frames - 1).max(1) as f32);
        View { name: self.path.name.clone(), eye, look_at, ..View::default() }
    }

    /// Returns for each method the beginning of its frames' keys in the journal, at a size in pixels.
    fn key_prefixes(&self, gpu: &Gpu, extent: [u32; 2]) -> Vec<String> {
        let key = self.planned_cell(extent).key::<PathRecord>(gpu);
        self.methods.iter().map(|method| format!("{key} {}", method.name)).collect()
    }

    /// Returns the cell of a size.
    fn planned_cell(&self, extent: [u32; 2]) -> Planned<[u32; 2]> {
        let setup = self.setup.with_extent(extent);
        let methods: Vec<_> = self.methods.iter().map(|m| (m.name, setup.recorded(Some(m)))).collect();
        let (scene, path) = (scene_digest(&self.scene), format!("{:?}", self.path));
        Planned {
            name: cell_name(&self.scene.name, &self.path.name, extent, self.globals.roughness),
            setup: json!([scene, path, self.globals, methods, self.warmup, self.frames]),
            cell: extent,
        }
    }
}

/// A cell is a size, at which the frames of all methods are timed in turn.
impl Study for PathStudy {
    type Cell = [u32; 2];
    type Row = PathRecord;

    fn scenes(&self) -> Vec<&Scene> {
        vec![&self.scene]
    }

    fn settings(&self) -> Value {
        json!({ "frames": self.frames })
    }

    fn cells(&self) -> Vec<Planned<[u32; 2]>> {
        self.sizes.iter().map(|extent| self.planned_cell(*extent)).collect()
    }

    /// Returns for each method of a cell the beginning of its frames' keys in the journal, and the head of its record.
    fn results(&self, gpu: &Gpu, planned: &Planned<[u32; 2]>) -> Vec<(String, Value)> {
        let (start, setup) = (self.view(0), self.setup.with_extent(planned.cell));
        let head = |m| Head::new("path", gpu, (&self.scene, &start), RecordSubject::Method(m), &setup, &self.globals);
        let heads = self.methods.iter().map(|m| json!(head(m)));
        self.key_prefixes(gpu, planned.cell).into_iter().zip(heads).collect()
    }

    fn steps(&self, _: &[u32; 2]) -> usize {
        self.methods.len() * (self.warmup + self.frames)
    }

    /// Times every frame that the journal lacks. No rows are returned, since [`PathRecord::read`] makes them of the
    /// journal.
    fn measure(&mut self, extent: &[u32; 2], bench: &mut Bench) -> Result<Vec<PathRecord>> {
        let mut stage = Stage::new(bench.gpu, &self.scene)?;
        let start = self.view(0);
        let materials = self.globals.materials(&self.scene, &start);
        let prefixes = self.key_prefixes(bench.gpu, *extent);
        let (setup, first_camera) = (self.setup.with_extent(*extent), start.camera(&self.scene, *extent));
        let methods = self.methods.iter().map(|method| (*method, setup.clone()));
        let mut shared = SharedImages::default();
        let mut shots = shared.shots(&mut stage, methods, Wants::IMAGE, first_camera, &materials)?;
        let round = |n: usize| {
            // The number of a frame that counts; `None` for a frame that warms up, at the beginning of the path.
            let frame = n.checked_sub(self.warmup);
            let camera = self.view(frame.unwrap_or(0)).camera(&self.scene, *extent);
            Round { label: frame.map(|frame| frame.to_string()), mode: Mode::Timed, camera: Some(camera) }
        };
        let rounds: Vec<Round> = (0..self.warmup + self.frames).map(round).collect();
        let Bench { journal, go_on, advance, .. } = bench;
        let key = |method: usize, frame: &str| format!("{} {frame}", prefixes[method]);
        interleave(&mut stage, (&mut shared, &mut shots), &rounds, &key, journal, &mut || {
            advance(1);
            go_on()
        })?;
        Ok(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_per_second_are_those_of_a_hand_computation() {
        // 198 frames of 10 ms, one of 20 and one of 40: the slowest 1 % are the last two.
        let mut ms = vec![10.0; 198];
        ms.extend([40.0, 20.0]);
        let fps = Fps::from_frame_times(&ms);
        assert_eq!((fps.median, fps.p95), (100.0, 100.0));
        assert!((fps.low_1_percent - 2.0 / 0.060).abs() < 1e-9);
        assert_eq!(Fps::from_frame_times(&[50.0]).low_1_percent, 20.0);
        assert_eq!(Fps::from_frame_times(&[]), Fps { median: 0.0, p95: 0.0, low_1_percent: 0.0 });
    }
}
