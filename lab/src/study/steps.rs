//! How many cells the rays of `unified` look at. The plain twin of its traversal counts them, since it takes the same steps.

use super::record::Provenance;
use crate::gpu::Gpu;
use crate::reference::unified::Traversal;
use crate::scene::GBufferData;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The steps of the mirror rays of a view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepsRecord {
    /// Always `steps`.
    pub kind: String,
    /// Definitions, version, commit and device.
    #[serde(flatten)]
    pub program: Provenance,
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Rays: one for each pixel that reflects.
    pub rays: usize,
    /// Mean of their steps.
    pub mean: f64,
    /// Median.
    pub median: u32,
    /// 99th percentile.
    pub p99: u32,
    /// The most.
    pub most: u32,
}

/// Counts the steps on a G-buffer.
pub fn count(gpu: &Gpu, [scene, view]: [&str; 2], data: &GBufferData) -> StepsRecord {
    let traversal = Traversal::new(data);
    let steps = |i: u32| traversal.mirror_steps(i % data.width, i / data.width);
    let mut all: Vec<u32> = (0..data.depth.len() as u32).into_par_iter().filter_map(steps).collect();
    all.sort_unstable();
    let rank = |share: f64| all.get(((all.len() as f64 * share) as usize).min(all.len().saturating_sub(1)));
    StepsRecord {
        kind: "steps".into(),
        program: Provenance::on(gpu),
        scene: scene.to_owned(),
        view: view.to_owned(),
        width: data.width,
        height: data.height,
        rays: all.len(),
        mean: all.iter().map(|n| f64::from(*n)).sum::<f64>() / all.len().max(1) as f64,
        median: rank(0.5).copied().unwrap_or(0),
        p99: rank(0.99).copied().unwrap_or(0),
        most: all.last().copied().unwrap_or(0),
    }
}
