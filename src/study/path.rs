//! The camera on its way: methods interleaved frame by frame along a path, and the frames per second of
//! each (what Schmidt's figures 42 and 52 plot, 2013, sections 5.3.2 and 5.4.2).

use super::record::{Head, Stats};
use super::stage::{Globals, Shot, Stage};
use super::timing::camera;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::frame::Mode;
use crate::methods::{MethodInfo, Setup};
use crate::scene::{CameraPath, Scene, View};
use serde::Serialize;

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
    /// Preset and options; the size is each of `sizes`.
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
    /// Of the median frame.
    pub median: f64,
    /// What 95 % of the frames reach: that of the 95th percentile of the frames' times.
    pub p95: f64,
    /// Of the slowest 1 % of the frames (at least one) together: their number over their time.
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
    /// Of some frames' times in milliseconds; all 0 for none.
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
    /// Frames that [`run`] will submit.
    pub fn submissions(&self) -> usize {
        self.methods.len() * self.sizes.len() * (self.warmup + self.frames)
    }

    /// The place of a frame as a view.
    fn view(&self, frame: usize) -> View {
        let (eye, look_at) = self.path.at(frame as f32 / (self.frames - 1).max(1) as f32);
        View { name: self.path.name.clone(), eye, look_at, ..View::default() }
    }
}

/// Runs the study. `progress` is called after each frame.
pub fn run(spec: &PathSpec, progress: &mut dyn FnMut()) -> Result<Vec<PathRecord>> {
    let mut stage = Stage::new(spec.gpu, spec.scene)?;
    let start = spec.view(0);
    let materials = spec.globals.materials(spec.scene, &start);
    let mut records = Vec::new();
    for &extent in &spec.sizes {
        let setup = Setup { extent, ..spec.setup };
        let first = camera(spec.scene, &start, extent);
        let made = spec.methods.iter().map(|m| Shot::new(&mut stage, m, &setup, first, materials.clone()));
        let mut shots = made.collect::<Result<Vec<_>>>()?;
        let mut frames = vec![Vec::with_capacity(spec.frames); shots.len()];
        for n in 0..spec.warmup + spec.frames {
            let counts = n.checked_sub(spec.warmup);
            let camera = camera(spec.scene, &spec.view(counts.unwrap_or(0)), extent);
            // Whoever comes first at a new place may find colder caches: each method does in its turn.
            for turn in 0..shots.len() {
                let m = (n + turn) % shots.len();
                shots[m].camera = camera;
                let (report, _) = stage.run(&shots[m], Mode::Timed)?;
                if counts.is_some() {
                    let effect_ms = report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum();
                    frames[m].push(PathFrame {
                        frame_ms: report.frame_ms,
                        effect_ms,
                        fps: 1000.0 / report.frame_ms.max(1e-6),
                    });
                }
                progress();
            }
        }
        for (method, frames) in spec.methods.iter().zip(frames) {
            let head = Head::new("path", spec.scene, &start, method.name, &setup, &spec.globals, spec.gpu);
            let whole: Vec<f64> = frames.iter().map(|f| f.frame_ms).collect();
            let effect: Vec<f64> = frames.iter().map(|f| f.effect_ms).collect();
            let fps = Fps::of(&whole);
            records.push(PathRecord { head, frame: Stats::of(&whole), effect: Stats::of(&effect), fps, frames });
        }
    }
    Ok(records)
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
