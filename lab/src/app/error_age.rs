//! `ssct error --age`: error over the age of captures, while things move.

use super::error_options::ErrorOptions;
use super::run::{Run, go_on, list_head};
use super::{progress, resolve};
use crate::error::Error;
use crate::methods::{self, MethodInfo};
use crate::report::{age_report, error_report, files};
use crate::study::Globals;
use crate::study::age::{AgeRecord, AgeSpec, measure};
use crate::study::cell_list::{CellList, PlannedCell};
use crate::study::journal::{digest, scene_digest};
use crate::study::stress::JUDGED;
use glam::Vec3;
use serde_json::json;
use std::io::Write;

/// Measures for every size and roughness what the journal lacks, writes and prints.
pub fn run(options: &ErrorOptions, frames: u32) -> anyhow::Result<()> {
    let common = &options.common;
    let scene = resolve::scene(&common.place, "museum")?;
    let view = resolve::view(&scene, &common.place, None)?;
    let globals = resolve::globals(&common.place)?;
    let sizes = if options.size.is_empty() { vec![[480, 270]] } else { options.size.clone() };
    let setup = common.method_options.setup(sizes[0]);
    let names = if options.method.is_empty() { vec![JUDGED.to_owned()] } else { options.method.clone() };
    let methods = methods::choose(&names, &setup)?;
    if setup.values.given().any(|name| name == "captures_per_frame") {
        let message = "--age compares several numbers of faces a frame: give --faces instead of --captures-per-frame";
        return Err(Error::Usage(message.into()).into());
    }
    if options.rays < 2 {
        return Err(Error::Usage("--rays must be at least 2".into()).into());
    }
    let step_m = options.step.unwrap_or(Vec3::ZERO);
    resolve::moving(&scene, &options.moving)?;
    let gpu = resolve::gpu(&common.device)?;
    let mut cells = Vec::new();
    for &method in &methods {
        for &size in &sizes {
            cells.extend(globals.iter().map(|&g| (method, size, g)));
        }
    }
    let scene_digest = scene_digest(&scene);
    let (moving, faces) = (&options.moving[..], &options.faces[..]);
    let spec = |&(method, size, globals): &(&'static MethodInfo, [u32; 2], Globals)| {
        let (setup, rays, gpu, scene, view) = (setup.at(size), options.rays, &gpu, &scene, &view);
        AgeSpec { gpu, scene, view, globals, method, setup, moving, step_m, faces, frames, rays }
    };
    let settings = |spec: &AgeSpec| {
        let set = spec.setup.recorded(Some(spec.method));
        let set = json!([spec.method.name, set, spec.globals, format!("{:?}", spec.view)]);
        json!([scene_digest, set, json!([moving, step_m.to_array(), faces, frames, spec.rays])])
    };
    let key = |spec: &AgeSpec| format!("age {} {} {}", scene.name, view.name, digest(&gpu, &settings(spec)));
    let planned = |spec: &AgeSpec| {
        let stem = error_report::stem(&scene.name, &view.name, spec.setup.extent, spec.globals.roughness);
        PlannedCell::new(format!("{stem}-{}", spec.method.name), settings(spec), 1.0, key(spec))
    };
    let specs: Vec<AgeSpec> = cells.iter().map(spec).collect();
    let planned = specs.iter().map(planned).collect();
    let list = CellList::new(list_head("age", options.shard.shard, &setup, &scene), gpu.info(), planned);
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    run.list(&list)?;
    let bar = progress::bar("age", list.owned());
    let mut records: Vec<AgeRecord> = Vec::new();
    let mut outcome = Ok(());
    for spec in list.own(&specs) {
        let key = key(spec);
        // What ended the measurement does not end the report of what the journal has.
        if outcome.is_ok() {
            let measured = run.journal.get_or(&key, |_| measure(spec, &mut go_on));
            outcome = measured.map(drop).and_then(|()| progress::step(&bar));
        }
        records.extend(run.journal.get::<Vec<AgeRecord>>(&key).into_iter().flatten());
    }
    bar.finish_and_clear();
    let wrote = write(options, &records);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

fn write(options: &ErrorOptions, records: &[AgeRecord]) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        age_report::write(folder, records)?;
    }
    let shown = if options.run.json { files::json(records) } else { age_report::text(records) };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}
