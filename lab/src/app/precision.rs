//! `ssct error --precision`: error against the bytes of a G-buffer's pixel.

use super::error_cells::{QUICK_SIZE, QUICK_VIEWS};
use super::error_options::ErrorOptions;
use super::run::{Run, list_head};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::methods;
use crate::report::{error_report, files, precision_report};
use crate::study::cell_list::{CellList, PlannedCell};
use crate::study::precision::{PrecisionRecord, PrecisionSpec, measure};
use crate::study::{Globals, stress};
use std::io::Write;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Methods where none are given, beside the judged one.
const BESIDE: &str = "ssct";

/// The method that copies the G-buffer's bits, and so has to know their formats.
const COPIES: &str = "poster";

/// Measures every rung for every view, writes and prints.
pub fn run(options: &ErrorOptions) -> anyhow::Result<()> {
    let place = &options.common.place;
    let scene = resolve::scene(place, "rooms")?;
    let views = match (&place.view, place.eye) {
        (None, None) => {
            scene.views.iter().take(if options.quick { QUICK_VIEWS } else { usize::MAX }).cloned().collect()
        }
        _ => vec![resolve::view(&scene, place, None)?],
    };
    let globals = match &place.roughness[..] {
        [] => {
            let one = resolve::one_globals(place, "no roughness was given")?;
            ROUGHNESS.iter().map(|r| Globals { roughness: Some(*r), ..one }).collect()
        }
        _ => resolve::globals(place)?,
    };
    let size = match options.size[..] {
        [] if options.quick => QUICK_SIZE,
        [] => [480, 270],
        [size] => size,
        _ => return Err(Error::Usage("--precision is measured at one --size".into()).into()),
    };
    if options.rays < 2 {
        return Err(Error::Usage("--rays must be at least 2".into()).into());
    }
    let methods = match &options.method[..] {
        [] => [stress::JUDGED, BESIDE].iter().map(|n| methods::find(n)).collect::<Result<Vec<_>>>()?,
        names => names.iter().map(|n| methods::find(n)).collect::<Result<Vec<_>>>()?,
    };
    if let Some(method) = methods.iter().find(|m| !m.is_screen_space() || m.name == COPIES) {
        let message =
            format!("--precision is for methods that sample a G-buffer of any format; {} does not", method.name);
        return Err(Error::Usage(message).into());
    }
    let gpu = resolve::gpu(&options.common.device)?;
    let setup = options.common.method_options.setup(size);
    methods::check_read(&methods, &setup)?;
    let of_view = |(view, globals)| {
        let (gpu, scene, methods, setup, rays) = (&gpu, &scene, &methods[..], setup.clone(), options.rays);
        PrecisionSpec { gpu, scene, view, globals, methods, setup, rays }
    };
    let specs: Vec<_> = views.iter().flat_map(|view| globals.iter().map(move |g| (view, *g))).map(of_view).collect();
    let key = |spec: &PrecisionSpec| format!("precision {} {} {}", scene.name, spec.view.name, spec.digest());
    let planned = |spec: &PrecisionSpec| {
        let name = error_report::stem(&scene.name, &spec.view.name, size, spec.globals.roughness);
        PlannedCell::new(name, spec.settings(), 1.0, key(spec))
    };
    let cells = specs.iter().map(planned).collect();
    let list = CellList::new(list_head("precision", options.shard.shard, &setup, &scene), gpu.info(), cells);
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    run.list(&list)?;
    let bar = progress::bar("precision", list.owned());
    let mut records: Vec<PrecisionRecord> = Vec::new();
    let mut outcome = Ok(());
    for spec in list.own(&specs) {
        let key = key(spec);
        // What ended the measurement does not end the report of what the journal has.
        if outcome.is_ok() {
            let measured = run.journal.get_or(&key, |_| measure(spec));
            outcome = measured.map(drop).and_then(|()| progress::step(&bar));
        }
        records.extend(run.journal.get::<Vec<PrecisionRecord>>(&key).into_iter().flatten());
    }
    bar.finish_and_clear();
    let wrote = write(options, &records, &list.command);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

/// Writes the files, if a folder is asked for, and prints the records or the text.
fn write(options: &ErrorOptions, records: &[PrecisionRecord], command: &str) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        precision_report::write(folder, records, command)?;
    }
    let mut out = std::io::stdout().lock();
    let text = if options.run.json { files::json(records) } else { precision_report::text(records) };
    out.write_all(text.as_bytes())?;
    Ok(())
}
