//! `ssct stress`: numerical stability.

use super::cli::StressOptions;
use super::{progress, resolve};
use crate::error::Result;
use crate::methods::{self, METHODS, MethodInfo};
use crate::report::{files, stress_report};
use crate::scene::library;
use crate::study::stress::{self, JUDGED, StressRecord, cases::cases};
use std::io::Write;

/// Pixels of the cases with a scene.
const SCENE_SIZE: [u32; 2] = [321, 181];

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
    bar.finish_and_clear();

    if let Some(folder) = &options.output {
        let command = if options.quick { "ssct stress --quick" } else { "ssct stress" };
        stress_report::write(folder, &records, command)?;
    }
    let mut out = std::io::stdout().lock();
    if options.json {
        out.write_all(files::json(&records).as_bytes())?;
    } else {
        out.write_all(stress_report::text(&records).as_bytes())?;
    }
    gpu.check_validation()?;
    let violated = records.iter().filter(|r| r.method == JUDGED && !r.pass).count();
    anyhow::ensure!(violated == 0, "{JUDGED} violates {violated} case(s)");
    Ok(())
}
