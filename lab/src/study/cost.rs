//! The cost of measured cells of the error study: how long each part of a cell took (docs/many-machines.md, "Costs").

use super::error::ErrorSpec;
use super::interleave::shot_at;
use crate::gpu::{DeviceInfo, Gpu};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// How long the parts of a cell took, in seconds of wall time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellCost {
    /// The name of the scene.
    pub scene: String,
    /// The name of the view.
    pub view: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Global roughness; null where the materials keep theirs.
    pub roughness: Option<f32>,
    /// Rays a pixel of the references.
    pub rays: u32,
    /// Frames of each variant, including those that warm up.
    pub frames: usize,
    /// The device.
    pub device: DeviceInfo,
    /// The number of threads of the host.
    pub threads: usize,
    /// Whether an earlier run measured some of the frames, so that the seconds do not include them.
    pub partial: bool,
    /// The most memory that the process held until the cell's end, in bytes, where the system says it.
    #[serde(default)]
    pub peak_bytes: Option<u64>,
    /// The variants, in the order of the study.
    pub variants: Vec<VariantCost>,
    /// Seconds for the references of the screen.
    pub screen_s: f64,
    /// Seconds for the references of the world.
    pub world_s: f64,
    /// Seconds for the rest: the G-buffer, the first hits, the thesis's cone at exact hits.
    pub rest_s: f64,
}

/// How long the parts of a variant took, in seconds of wall time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct VariantCost {
    /// The name of the method.
    pub method: String,
    /// Seconds for what the method makes before its first frame.
    pub setup_s: f64,
    /// Seconds for all frames.
    pub frames_s: f64,
    /// Seconds for comparing the image and the hits with the references.
    pub judged_s: f64,
}

impl CellCost {
    /// The cost of a cell that is about to be measured: 0 seconds.
    pub(super) fn of(gpu: &Gpu, spec: &ErrorSpec) -> Self {
        let variant = |method: &str| VariantCost { method: method.to_owned(), ..VariantCost::default() };
        Self {
            scene: spec.scene.name.clone(),
            view: spec.view.name.clone(),
            size: spec.extent,
            roughness: spec.globals.roughness,
            rays: spec.rays,
            frames: spec.warmup + spec.samples,
            device: gpu.info().clone(),
            threads: rayon::current_num_threads(),
            partial: false,
            peak_bytes: None,
            variants: spec.variants.iter().map(|v| variant(v.method.name)).collect(),
            screen_s: 0.0,
            world_s: 0.0,
            rest_s: 0.0,
        }
    }

    /// Seconds of the whole cell.
    pub fn total_s(&self) -> f64 {
        let variants = self.variants.iter().map(|v| v.setup_s + v.frames_s + v.judged_s).sum::<f64>();
        variants + self.screen_s + self.world_s + self.rest_s
    }

    /// Begins to measure how long the frames of each variant take in the timing loop.
    pub(super) fn turns(&mut self) -> Turns<'_> {
        Turns { laps: Laps::begin(), turn: 0, variants: &mut self.variants }
    }
}

/// The most memory that this process has held, in bytes, where the system says it (Linux: `VmHWM`).
pub(super) fn peak_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

/// Adds the time of each frame of the timing loop to its variant. The loop draws the shots in the order of
/// [`super::interleave::shot_at`].
pub(super) struct Turns<'a> {
    laps: Laps,
    turn: usize,
    variants: &'a mut [VariantCost],
}

impl Turns<'_> {
    /// To be called at the end of each frame.
    pub(super) fn next(&mut self) {
        let count = self.variants.len().max(1);
        let shot = shot_at(self.turn / count, self.turn % count, count);
        if let Some(variant) = self.variants.get_mut(shot) {
            variant.frames_s += self.laps.lap();
        }
        self.turn += 1;
    }
}

/// A clock that is read lap by lap.
pub(super) struct Laps(Instant);

impl Laps {
    /// Begins the first lap.
    pub(super) fn begin() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the last lap ended.
    pub(super) fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let seconds = now.duration_since(self.0).as_secs_f64();
        self.0 = now;
        seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_that_was_held_once_is_known() {
        let held = vec![1_u8; 64 << 20];
        assert!(peak_bytes().is_some_and(|bytes| bytes > held.len() as u64));
    }

    #[test]
    fn a_frame_counts_for_the_shot_whose_turn_it_was() {
        let of = |method: &str| VariantCost { method: method.into(), ..VariantCost::default() };
        let mut variants = ["a", "b", "c"].map(of);
        let mut turns = Turns { laps: Laps::begin(), turn: 0, variants: &mut variants };
        // The second round begins with the second shot: its first frame is the fourth of all.
        let sleep = || std::thread::sleep(std::time::Duration::from_millis(20));
        for frame in 0..6 {
            if frame == 3 {
                sleep();
            }
            turns.next();
        }
        let [a, b, c] = variants.map(|v| v.frames_s);
        assert!(b >= 0.02 && b > a && b > c, "{a} {b} {c}");
    }
}
