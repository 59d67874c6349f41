//! Records: what a measurement was of, and what it found. One is one JSON object (DESIGN,
//! "Command line").

use super::stage::Globals;
use crate::gpu::timing::PassWork;
use crate::gpu::{DeviceInfo, Gpu, Skipped};
use crate::math::OracleVersion;
use crate::methods::{Fallback, Preset, Setup};
use crate::passes::gbuffer::Drawn;
use crate::scene::{Scene, View};
use serde::{Deserialize, Serialize};

/// The version of DEFINITIONS that the figures are of.
pub const DEFINITIONS: u32 = 1;

/// Median, minimum, 95th percentile and number of some samples, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stats {
    /// Median; of an even number, the mean of the middle two.
    pub median_ms: f64,
    /// Least.
    pub min_ms: f64,
    /// The least sample that 95 % of the samples don't exceed.
    pub p95_ms: f64,
    /// How many.
    pub samples: usize,
}

impl Stats {
    /// Of any number of samples; all zero for none.
    pub fn of(samples: &[f64]) -> Self {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        if n == 0 {
            return Self { median_ms: 0.0, min_ms: 0.0, p95_ms: 0.0, samples: 0 };
        }
        let p95 = (0.95 * n as f64).ceil() as usize - 1;
        Self {
            median_ms: (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0,
            min_ms: sorted[0],
            p95_ms: sorted[p95],
            samples: n,
        }
    }
}

/// A pass's times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PassRecord {
    /// Label; a level of a chain follows a slash.
    pub name: String,
    /// Whether it counts towards the total (scene passes don't).
    pub counted: bool,
    /// Its times.
    #[serde(flatten)]
    pub stats: Stats,
    /// Its work, counted in a frame of its own, where the device counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work: Option<PassWork>,
}

/// What every record begins with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// "time", "error", …
    pub kind: String,
    /// [`DEFINITIONS`].
    pub definitions: u32,
    /// Of this program.
    pub version: String,
    /// Of its source; "unknown" outside a repository.
    pub commit: String,
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Method name.
    pub method: String,
    /// Preset.
    pub preset: Preset,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Traced pixels a side over pixels.
    #[serde(default = "full_resolution")]
    pub resolution_scale: f32,
    /// What `unified` hits, and what hits and the screen reference are of; left out where it is 1.
    #[serde(default, skip_serializing_if = "OracleVersion::is_first")]
    pub oracle: OracleVersion,
    /// Global roughness; null where the materials keep theirs.
    pub roughness: Option<f32>,
    /// Global normal deviation; null where the materials keep theirs.
    pub normal_deviation: Option<f32>,
    /// Device.
    pub device: DeviceInfo,
}

/// What records from before there was a choice were made at.
fn full_resolution() -> f32 {
    1.0
}

impl Head {
    /// The head of a measurement by this program. Method, size and factors are the caller's.
    pub fn new(
        kind: &str,
        scene: &Scene,
        view: &View,
        method: &str,
        setup: &Setup,
        globals: &Globals,
        gpu: &Gpu,
    ) -> Self {
        Self {
            kind: kind.to_owned(),
            definitions: DEFINITIONS,
            version: Self::VERSION.to_owned(),
            commit: Self::COMMIT.to_owned(),
            scene: scene.name.clone(),
            view: view.name.clone(),
            method: method.to_owned(),
            preset: setup.preset,
            width: setup.extent[0],
            height: setup.extent[1],
            resolution_scale: setup.resolution_scale(),
            oracle: setup.oracle,
            roughness: globals.roughness,
            normal_deviation: globals.normal_deviation,
            device: gpu.info().clone(),
        }
    }

    /// This program's version.
    pub const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    /// The commit it was built from.
    pub const COMMIT: &'static str = env!("SSCT_COMMIT");
}

/// Times of one method on one view, size and roughness.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeRecord {
    /// What it is of.
    #[serde(flatten)]
    pub head: Head,
    /// Whether ray trace and cone trace were two passes.
    pub split: bool,
    /// What is behind the method, if anything is.
    #[serde(skip_serializing_if = "Fallback::is_none")]
    pub fallback: Fallback,
    /// Every pass of the frame, in order.
    pub passes: Vec<PassRecord>,
    /// Sum of the counted passes, sample by sample.
    pub total: Stats,
    /// From the frame's first timestamp to its last, scene passes included.
    pub frame: Stats,
    /// Meshes and triangles drawn.
    pub drawn: Drawn,
    /// Labels of the passes recorded.
    pub recorded: Vec<String>,
    /// Passes that the frame did not need.
    pub skipped: Vec<Skipped>,
    /// Raw samples, one row a sample: milliseconds of each pass, in order. Kept beside, as CSV.
    #[serde(skip)]
    pub samples: Vec<Vec<f64>>,
}

impl TimeRecord {
    /// Sum of the medians of all passes over the median of the frame: 1 if nothing lies between.
    pub fn sum_over_frame(&self) -> f64 {
        self.passes.iter().map(|p| p.stats.median_ms).sum::<f64>() / self.frame.median_ms
    }

    /// Medians of the counted passes with the levels of a chain added up, in order.
    pub fn stages(&self) -> Vec<(String, f64)> {
        let mut stages: Vec<(String, f64)> = Vec::new();
        for pass in self.passes.iter().filter(|p| p.counted) {
            let name = pass.name.split('/').next().unwrap_or(&pass.name);
            match stages.iter_mut().find(|(n, _)| n == name) {
                Some((_, ms)) => *ms += pass.stats.median_ms,
                None => stages.push((name.to_owned(), pass.stats.median_ms)),
            }
        }
        stages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stats_are_those_of_a_hand_computation() {
        let s = Stats::of(&[4.0, 1.0, 3.0, 2.0]);
        assert_eq!((s.median_ms, s.min_ms, s.p95_ms, s.samples), (2.5, 1.0, 4.0, 4));
        let twenty: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(Stats::of(&twenty).p95_ms, 19.0);
        assert_eq!(Stats::of(&[]).samples, 0);
    }
}
