//! The camera on its way: methods interleaved frame by frame along a path, and the frames per second of
//! each (what Schmidt's figures 42 and 52 plot, 2013, sections 5.3.2 and 5.4.2).

use super::interleave::{Round, Sample, interleave};
use super::journal::{Journal, digest, scene_digest};
use super::record::{Head, Of, Stats};
use super::stage::{Globals, Shot, Stage};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::frame::Mode;
use crate::methods::{MethodInfo, Setup, Wants};
use crate::scene::{CameraPath, Scene, View};
use serde::Serialize;
use serde_json::json;

/// What runs along which path.
pub struct PathSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene; its own lens and materials hold on the whole way.
    pub scene: &'a Scene,
    /// The way.
    pub path: &'a CameraPath,
    /// Methods, taken in turn at every frame.
    pub methods: Vec<&'static MethodInfo>,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors.
    pub globals: Globals,
    /// How the methods are set up; the size is each of `sizes`.
    pub setup: Setup,
    /// Frames at the first place that don't count.
    pub warmup: usize,
    /// Frames from the first key frame to the last, ≥ 1.
    pub frames: usize,
}

/// A frame on the way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathFrame {
    /// Milliseconds on the device from the frame's first timestamp to its last, scene passes included.
    pub frame_ms: f64,
    /// Milliseconds of the passes that count: the method's.
    pub effect_ms: f64,
    /// 1000 / `frame_ms`.
    pub fps: f64,
}

/// Frames per second of a whole way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fps {
    /// Frames per second at the median time of a frame.
    pub median: f64,
    /// Frames per second that 95 % of the frames reach: at the 95th percentile of the frames' times.
    pub p95: f64,
    /// Frames per second of the slowest 1 % of the frames, at least one: their number over their time.
    pub low_1_percent: f64,
}

/// One method at one size on one path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathRecord {
    /// What it is of; the view is the path.
    #[serde(flatten)]
    pub head: Head,
    /// Times of whole frames.
    pub frame: Stats,
    /// Times of the method.
    pub effect: Stats,
    /// Frames per second.
    pub fps: Fps,
    /// Every frame in order.
    pub frames: Vec<PathFrame>,
}

impl Fps {
    /// The rates of frames whose times are given in milliseconds; all 0 for none.
    fn of(frame_ms: &[f64]) -> Self {
        let fps = |ms: f64| if ms > 0.0 { 1000.0 / ms } else { 0.0 };
        let stats = Stats::of(frame_ms);
        let mut slowest = frame_ms.to_vec();
        slowest.sort_by(|a, b| b.total_cmp(a));
        slowest.truncate(frame_ms.len().div_ceil(100));
        let mean = slowest.iter().sum::<f64>() / slowest.len().max(1) as f64;
        Self { median: fps(stats.median_ms), p95: fps(stats.p95_ms), low_1_percent: fps(mean) }
    }
}

impl PathSpec<'_> {
    /// Frames that [`measure`] submits if the journal has none.
    pub fn submissions(&self) -> usize {
        self.methods.len() * self.sizes.len() * (self.warmup + self.frames)
    }

    /// What every frame depends on.
    fn digest(&self) -> String {
        let methods: Vec<_> = self.methods.iter().map(|m| (m.name, self.setup.recorded(Some(m)))).collect();
        let (scene, path) = (scene_digest(self.scene), format!("{:?}", self.path));
        digest(self.gpu, &json!([scene, path, self.globals, methods, self.warmup, self.frames]))
    }

    /// Where the journal keeps a frame.
    fn key(&self, digest: &str, method: &MethodInfo, [width, height]: [u32; 2], frame: &str) -> String {
        let (scene, path) = (&self.scene.name, &self.path.name);
        format!("path {scene} {path} {width}x{height} {digest} {} {frame}", method.name)
    }

    /// The place of a frame as a view.
    fn view(&self, frame: usize) -> View {
        let (eye, look_at) = self.path.at(frame as f32 / (self.frames - 1).max(1) as f32);
        View { name: self.path.name.clone(), eye, look_at, ..View::default() }
    }
}

/// Runs what the journal lacks. `progress` is called after each frame; its error ends the study.
pub fn measure(spec: &PathSpec, journal: &mut Journal, progress: &mut dyn FnMut() -> Result<()>) -> Result<()> {
    let mut stage = Stage::new(spec.gpu, spec.scene)?;
    let start = spec.view(0);
    let materials = spec.globals.materials(spec.scene, &start);
    let digest = spec.digest();
    for &extent in &spec.sizes {
        let key = |method: usize, frame: &str| spec.key(&digest, spec.methods[method], extent, frame);
        let all = (0..spec.frames).flat_map(|n| (0..spec.methods.len()).map(move |m| (m, n)));
        if all.into_iter().all(|(m, n)| journal.has(&key(m, &n.to_string()))) {
            continue;
        }
        let (setup, first) = (spec.setup.at(extent), start.camera(spec.scene, extent));
        let made =
            spec.methods.iter().map(|m| Shot::new(&mut stage, m, &setup, Wants::IMAGE, first, materials.clone()));
        let mut shots = made.collect::<Result<Vec<_>>>()?;
        let rounds: Vec<Round> = (0..spec.warmup + spec.frames)
            .map(|n| {
                let counts = n.checked_sub(spec.warmup);
                let camera = spec.view(counts.unwrap_or(0)).camera(spec.scene, extent);
                Round { label: counts.map(|n| n.to_string()), mode: Mode::Timed, camera: Some(camera) }
            })
            .collect();
        interleave(&mut stage, &mut shots, &rounds, &key, journal, progress)?;
    }
    Ok(())
}

/// The records of what the journal has: a way that was not walked to its end has fewer frames.
pub fn records(spec: &PathSpec, journal: &Journal) -> Vec<PathRecord> {
    let (start, digest) = (spec.view(0), spec.digest());
    let mut records = Vec::new();
    for &extent in &spec.sizes {
        let setup = spec.setup.at(extent);
        for method in &spec.methods {
            let frame = |n: usize| {
                let sample: Sample = journal.get(&spec.key(&digest, method, extent, &n.to_string()))?;
                let frame_ms = sample.report.frame_ms;
                Some(PathFrame { frame_ms, effect_ms: sample.effect_ms(), fps: 1000.0 / frame_ms.max(1e-6) })
            };
            let frames: Vec<PathFrame> = (0..spec.frames).filter_map(frame).collect();
            if frames.is_empty() {
                continue;
            }
            let head = Head::new("path", spec.gpu, (spec.scene, &start), Of::Method(method), &setup, &spec.globals);
            let whole: Vec<f64> = frames.iter().map(|f| f.frame_ms).collect();
            let effect: Vec<f64> = frames.iter().map(|f| f.effect_ms).collect();
            let fps = Fps::of(&whole);
            records.push(PathRecord { head, frame: Stats::of(&whole), effect: Stats::of(&effect), fps, frames });
        }
    }
    records
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_per_second_are_those_of_a_hand_computation() {
        // 198 frames of 10 ms, one of 20 and one of 40: the slowest 1 % are the last two.
        let mut ms = vec![10.0; 198];
        ms.extend([40.0, 20.0]);
        let fps = Fps::of(&ms);
        assert_eq!((fps.median, fps.p95), (100.0, 100.0));
        assert!((fps.low_1_percent - 2.0 / 0.060).abs() < 1e-9);
        assert_eq!(Fps::of(&[50.0]).low_1_percent, 20.0);
        assert_eq!(Fps::of(&[]), Fps { median: 0.0, p95: 0.0, low_1_percent: 0.0 });
    }
}
