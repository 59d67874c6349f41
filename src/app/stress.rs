//! `ssct stress`: numerical stability.

use super::cli::StressOptions;
use super::{progress, resolve};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::methods::{self, METHODS, MethodInfo};
use crate::report::{files, stress_report};
use crate::scene::{Scene, library};
use crate::study::stress::motion::{self, MOTIONS, MotionRecord, MotionSpec};
use crate::study::stress::{self, JUDGED, StressRecord, cases::cases};
use indicatif::ProgressBar;
use std::io::Write;

/// Pixels of the cases with a scene.
const SCENE_SIZE: [u32; 2] = [321, 181];

/// Roughness values of the camera's motions.
const MOTION_ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Runs every case; fails if the judged method violates any.
pub fn run(options: &StressOptions) -> anyhow::Result<()> {
    let methods: Vec<&'static MethodInfo> = match &options.method[..] {
        [] => METHODS.iter().collect(),
        names => names.iter().map(|n| methods::find(n)).collect::<Result<_>>()?,
    };
    let gpu = resolve::gpu(&options.device)?;
    let chosen = |name: &str| options.case.as_ref().is_none_or(|part| name.contains(part.as_str()));
    let cases: Vec<_> = cases(options.quick).into_iter().filter(|c| chosen(&c.name)).collect();
    let names = if options.quick { &library::names()[..1] } else { library::names() };
    let scenes: Vec<_> = names.iter().filter_map(|n| library::scene(n)).collect();
    let places: Vec<_> = scenes
        .iter()
        .flat_map(|s| stress::places(s).into_iter().map(move |p| (s, p)))
        .filter(|(_, p)| chosen(&p.name))
        .collect();

    let bar = progress::bar("stress", cases.len() + places.len());
    let mut records: Vec<StressRecord> = Vec::new();
    for case in &cases {
        records.extend(stress::run(&gpu, case, &methods)?);
        bar.inc(1);
    }
    for (scene, place) in &places {
        records.extend(stress::run_place(&gpu, scene, place, SCENE_SIZE, &methods)?);
        bar.inc(1);
    }
    let motions = motions(&gpu, &scenes, options, &methods, &bar)?;
    bar.finish_and_clear();

    if let Some(folder) = &options.output {
        let command = if options.quick { "ssct stress --quick" } else { "ssct stress" };
        stress_report::write(folder, &records, &motions, command)?;
    }
    let mut out = std::io::stdout().lock();
    if options.json {
        let all: Vec<_> = records
            .iter()
            .map(serde_json::to_value)
            .chain(motions.iter().map(serde_json::to_value))
            .collect::<std::result::Result<_, _>>()?;
        out.write_all(files::json(&all).as_bytes())?;
    } else {
        out.write_all(stress_report::text(&records, &motions).as_bytes())?;
    }
    gpu.check_validation()?;
    let violated = records.iter().filter(|r| r.method == JUDGED && !r.pass).count();
    anyhow::ensure!(violated == 0, "{JUDGED} violates {violated} case(s)");
    Ok(())
}

/// The camera's motions on the first view of the first scene, for a mirror and for gloss.
fn motions(
    gpu: &Gpu,
    scenes: &[Scene],
    options: &StressOptions,
    methods: &[&'static MethodInfo],
    bar: &ProgressBar,
) -> Result<Vec<MotionRecord>> {
    let mut records = Vec::new();
    let Some(scene) = scenes.first().filter(|_| options.case.is_none()) else { return Ok(records) };
    let (extent, frames, rays, views) =
        if options.quick { ([160, 90], 3, 16, 1) } else { ([320, 180], 6, 64, scene.views.len()) };
    bar.inc_length((views * MOTIONS.len() * MOTION_ROUGHNESS.len()) as u64);
    for view in &scene.views[..views] {
        for roughness in MOTION_ROUGHNESS {
            let spec = MotionSpec { gpu, scene, view, extent, roughness, frames, rays };
            for motion in MOTIONS {
                records.extend(motion::run(&spec, motion, methods)?);
                bar.inc(1);
            }
        }
    }
    Ok(records)
}
