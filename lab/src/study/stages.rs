//! Settings of one method beside each other, pass by pass: frames in turn, so that what changes on the machine meanwhile
//! changes all of them alike.

use super::error::Variant;
use super::interleave::{Round, Sample, interleave};
use super::journal::{Journal, digest, scene_digest};
use super::record::{Head, Of, Stats};
use super::stage::{Globals, Shot, Stage};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::methods::Wants;
use crate::scene::{Scene, View};
use serde::Serialize;
use serde_json::json;

/// What is timed.
pub struct StagesSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene.
    pub scene: &'a Scene,
    /// View of the scene.
    pub view: &'a View,
    /// Global factors.
    pub globals: Globals,
    /// The settings, with the size.
    pub variants: Vec<Variant>,
    /// Frames that count, of each.
    pub samples: usize,
}

/// The times of a setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageRecord {
    /// What it is of.
    #[serde(flatten)]
    pub head: Head,
    /// Each pass that counts, in order: its label and its times.
    pub passes: Vec<(String, Stats)>,
    /// Their sum, sample by sample.
    pub total: Stats,
}

/// Times every setting.
///
/// # Errors
/// Those of the device and of `progress`, which is called after each frame.
pub fn measure(
    spec: &StagesSpec,
    journal: &mut Journal,
    progress: &mut dyn FnMut() -> Result<()>,
) -> Result<Vec<StageRecord>> {
    let mut stage = Stage::new(spec.gpu, spec.scene)?;
    let materials = spec.globals.materials(spec.scene, spec.view);
    let mut shots = Vec::new();
    for Variant { method, setup } in &spec.variants {
        let camera = spec.view.camera(spec.scene, setup.extent);
        shots.push(Shot::new(&mut stage, method, setup, Wants::IMAGE, camera, materials.clone())?);
    }
    let set: Vec<_> = spec.variants.iter().map(|v| json!([v.method.name, v.setup.recorded(Some(v.method))])).collect();
    let of = json!([scene_digest(spec.scene), format!("{:?}", spec.view), spec.globals, set]);
    let cell = digest(spec.gpu, &of);
    let key = |shot: usize, sample: &str| format!("stages {cell} {shot} {sample}");
    interleave(&mut stage, &mut shots, &Round::timed(2, spec.samples), &key, journal, progress)?;
    let records = spec.variants.iter().enumerate().map(|(n, variant)| {
        let samples: Vec<Sample> =
            (0..spec.samples).filter_map(|sample| journal.get(&key(n, &sample.to_string()))).collect();
        record(spec, variant, &samples)
    });
    Ok(records.collect())
}

fn record(spec: &StagesSpec, variant: &Variant, samples: &[Sample]) -> StageRecord {
    let counted = |s: &Sample| s.report.passes.iter().filter(|p| p.counted).cloned().collect::<Vec<_>>();
    let names: Vec<String> = samples.first().map(counted).unwrap_or_default().into_iter().map(|p| p.name).collect();
    let times: Vec<Vec<f64>> = samples.iter().map(|s| counted(s).iter().map(|p| p.ms).collect()).collect();
    let of_pass = |n: usize| Stats::of(&times.iter().filter_map(|t| t.get(n).copied()).collect::<Vec<_>>());
    let place = (spec.scene, spec.view);
    StageRecord {
        head: Head::new("stage", spec.gpu, place, Of::Method(variant.method), &variant.setup, &spec.globals),
        passes: names.into_iter().enumerate().map(|(n, name)| (name, of_pass(n))).collect(),
        total: Stats::of(&samples.iter().map(Sample::effect_ms).collect::<Vec<_>>()),
    }
}
