//! `ssct stress`: numerical stability.

use super::cli::StressOptions;
use super::run::{Last, Run, command_line};
use super::{progress, resolve};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::methods::{self, METHODS, MethodInfo, Setup};
use crate::report::{files, stress_report};
use crate::scene::{Scene, library};
use crate::study::cell_list::{CellList, CellListHead, PlannedCell};
use crate::study::journal::{self, Journal};
use crate::study::record::DEFINITIONS;
use crate::study::stress::captures::{self, CaptureCase};
use crate::study::stress::lineup::{SceneLineup, ScreenLineup};
use crate::study::stress::motion::{self, MOTIONS, Motion, MotionRecord, MotionSpec};
use crate::study::stress::{self, StressRecord, cases::cases};
use indicatif::ProgressBar;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use std::collections::HashSet;
use std::io::Write;

/// Pixels of the cases with a scene.
const SCENE_SIZE: [u32; 2] = [321, 181];

/// Pixels of the cases with captures, which are drawn anew in each.
const CAPTURE_SIZE: [u32; 2] = [161, 91];

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

    let of_captures: Vec<(&Scene, CaptureCase)> = scenes
        .iter()
        .flat_map(|s| captures::cases(s).into_iter().map(move |c| (s, c)))
        .filter(|(_, c)| chosen(&c.name))
        .collect();
    let following: Vec<_> = methods.iter().copied().filter(|m| m.takes_captures).collect();

    let names: Vec<_> = methods.iter().map(|m| m.name).collect();
    let digest = journal::digest(&gpu, &json!(names));
    let key = |of: &str| format!("stress {digest} {of}");
    let motions = motions(&scenes, options);
    let case_names = cases.iter().map(|c| c.name.clone()).chain(places.iter().map(|(_, p)| p.name.clone()));
    let case_names: Vec<String> = case_names.chain(of_captures.iter().map(|(_, c)| c.name.clone())).collect();
    let motion_names = motions.iter().map(|(scene, spec, motion)| motion_name(scene, spec, *motion));
    let all_names: Vec<String> = case_names.iter().cloned().chain(motion_names).collect();
    let list = list(options, &gpu, &methods, &scenes, all_names.iter().map(|name| (name.clone(), key(name))).collect());
    // No two cases or motions have the same name.
    let own: HashSet<&String> = list.own(&all_names).collect();
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    run.list(&list)?;
    let bar = progress::bar("stress", list.owned());
    let measure = |journal: &mut Journal| -> Result<()> {
        let mut last = Last::default();
        for case in cases.iter().filter(|c| own.contains(&c.name)) {
            kept(journal, key(&case.name), &bar, || {
                let lineup = last.of(case.extent(), || ScreenLineup::new(&gpu, case.extent(), &methods))?;
                stress::run(&gpu, case, lineup)
            })?;
        }
        let mut last = Last::default();
        for (scene, place) in places.iter().filter(|(_, p)| own.contains(&p.name)) {
            kept(journal, key(&place.name), &bar, || {
                let make = || {
                    SceneLineup::with_hits(&gpu, stress::moved(scene, place), &Setup::on_screen(SCENE_SIZE), &methods)
                };
                stress::run_place(&gpu, place, last.of((&scene.name, place.offset), make)?)
            })?;
        }
        let mut last = Last::default();
        for (scene, case) in of_captures.iter().filter(|(_, c)| own.contains(&c.name)) {
            kept(journal, key(&case.name), &bar, || {
                let make = || case.lineup(&gpu, scene, CAPTURE_SIZE, &following);
                captures::run(&gpu, case, last.of((&scene.name, case.key()), make)?)
            })?;
        }
        let mut last = Last::default();
        for (scene, spec, motion) in &motions {
            let name = motion_name(scene, spec, *motion);
            if !own.contains(&name) {
                continue;
            }
            kept(journal, key(&name), &bar, || {
                let make = || SceneLineup::new(&gpu, (*scene).clone(), &Setup::on_screen(spec.extent), &methods);
                motion::run(&gpu, spec, *motion, last.of((&scene.name, spec.extent), make)?)
            })?;
        }
        Ok(())
    };
    let outcome = measure(&mut run.journal);
    bar.finish_and_clear();
    let of_case = |name: &String| run.journal.get::<Vec<StressRecord>>(&key(name)).unwrap_or_default();
    let records: Vec<StressRecord> = case_names.iter().flat_map(of_case).collect();
    let of_motion = |(scene, spec, motion): &(&Scene, MotionSpec, Motion)| {
        run.journal.get::<Vec<MotionRecord>>(&key(&motion_name(scene, spec, *motion))).unwrap_or_default()
    };
    let motions: Vec<MotionRecord> = motions.iter().flat_map(of_motion).collect();

    // Cases that were run are written even after an error, and that error is reported before one of writing.
    let stopped = if outcome.is_ok() { "" } else { ", stopped on the way" };
    let wrote = write(options, &records, &motions, &format!("{}{stopped}", list.command));
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    all_passed(&records)
}

/// Returns an error if a mandatory case failed.
pub fn all_passed(records: &[StressRecord]) -> anyhow::Result<()> {
    let violated: Vec<_> = records.iter().filter(|r| r.judged && !r.pass).collect();
    if let Some(first) = violated.first() {
        anyhow::bail!(
            "{} case(s) are not passed and must be, the first by {}: {}",
            violated.len(),
            first.method,
            first.case
        );
    }
    Ok(())
}

/// Writes the files, if a folder is asked for, and prints the records or the text.
fn write(
    options: &StressOptions,
    records: &[StressRecord],
    motions: &[MotionRecord],
    command: &str,
) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        stress_report::write(folder, records, motions, command)?;
    }
    let mut out = std::io::stdout().lock();
    if options.run.json {
        let all = records.iter().map(serde_json::to_value).chain(motions.iter().map(serde_json::to_value));
        out.write_all(files::json(&all.collect::<std::result::Result<Vec<_>, _>>()?).as_bytes())?;
    } else {
        out.write_all(stress_report::text(records, motions).as_bytes())?;
    }
    Ok(())
}

/// The list of cells, each a case or a motion with its name and its key. The program's version and the digests of the
/// scenes stand for everything that a case consists of.
fn list(
    options: &StressOptions,
    gpu: &Gpu,
    methods: &[&'static MethodInfo],
    scenes: &[Scene],
    cases: Vec<(String, String)>,
) -> CellList {
    let setup = Setup::on_screen(SCENE_SIZE);
    let set: Vec<_> = methods.iter().map(|m| (m.name, setup.recorded(Some(m)))).collect();
    let scenes: Vec<(String, String)> = scenes.iter().map(|s| (s.name.clone(), journal::scene_digest(s))).collect();
    let digests: Vec<&String> = scenes.iter().map(|(_, digest)| digest).collect();
    let planned = |(name, key): (String, String)| {
        let setup = json!([name, set, digests]);
        PlannedCell::new(name, setup, key)
    };
    let cells = cases.into_iter().map(planned).collect();
    let head = CellListHead {
        kind: "stress",
        definitions: DEFINITIONS,
        command: command_line(),
        shard: options.shard.shard,
        settings: json!({ "quick": options.quick }),
        scenes,
    };
    CellList::new(head, gpu.info(), cells)
}

/// Measures what the journal lacks, and keeps it there.
fn kept<T: Serialize + DeserializeOwned>(
    journal: &mut Journal,
    key: String,
    bar: &ProgressBar,
    measure: impl FnOnce() -> Result<Vec<T>>,
) -> Result<()> {
    journal.get_or(&key, |_| measure())?;
    progress::step(bar)
}

/// The camera's motions on the views of the first scene (one view if quick), for a mirror and for gloss.
fn motions<'a>(scenes: &'a [Scene], options: &StressOptions) -> Vec<(&'a Scene, MotionSpec<'a>, Motion)> {
    let Some(scene) = scenes.first().filter(|_| options.case.is_none()) else { return Vec::new() };
    let (extent, frames, rays, views) =
        if options.quick { ([160, 90], 3, 16, 1) } else { ([320, 180], 6, 64, scene.views.len()) };
    let mut all = Vec::new();
    for view in &scene.views[..views] {
        for roughness in MOTION_ROUGHNESS {
            for motion in MOTIONS {
                all.push((scene, MotionSpec { view, extent, roughness, frames, rays, against_world: false }, motion));
            }
        }
    }
    all
}

/// Where the journal keeps a motion.
pub fn motion_name(scene: &Scene, spec: &MotionSpec, motion: Motion) -> String {
    let [width, height] = spec.extent;
    let (view, roughness) = (&spec.view.name, spec.roughness);
    format!(
        "{} {view} {width}x{height} {roughness} {} {} frames {} rays",
        scene.name,
        motion.name(),
        spec.frames,
        spec.rays
    )
}
