//! `ssct precision`: error against the bytes of a G-buffer's pixel.

use super::cli::{CommonOptions, RunOptions, ShardOptions, size};
use super::error_cells::{QUICK_SIZE, QUICK_VIEWS};
use super::run::{Run, list_head};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::methods;
use crate::report::{error_report, files, precision_report};
use crate::study::cell_list::{CellList, PlannedCell};
use crate::study::precision::{PrecisionRecord, PrecisionSpec, measure};
use crate::study::{Globals, stress};
use clap::Args;
use std::io::Write;
use std::path::PathBuf;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Methods where none are given, beside the judged one.
const BESIDE: &str = "ssct";

/// The method that copies the G-buffer's bits, and so has to know their formats.
const COPIES: &str = "poster";

/// Options of `ssct precision`.
#[derive(Debug, Args)]
pub struct PrecisionOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default unified,ssct
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Width and height in pixels; by default 480x270
    ///
    /// With --quick, the default is 320x180.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Two views, small images
    #[arg(long)]
    pub quick: bool,
    /// Rays a pixel of the reference
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..))]
    pub rays: u32,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Folder for records, plots and a table
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Measures every rung for every view, writes and prints.
pub fn run(options: &PrecisionOptions) -> anyhow::Result<()> {
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
    let size = options.size.unwrap_or(if options.quick { QUICK_SIZE } else { [480, 270] });
    let methods = match &options.method[..] {
        [] => [stress::JUDGED, BESIDE].iter().map(|n| methods::find(n)).collect::<Result<Vec<_>>>()?,
        names => names.iter().map(|n| methods::find(n)).collect::<Result<Vec<_>>>()?,
    };
    if let Some(method) = methods.iter().find(|m| !m.is_screen_space() || m.name == COPIES) {
        let message =
            format!("precision is for methods that sample a G-buffer of any format; {} does not", method.name);
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
        PlannedCell::new(name, spec.settings(), key(spec))
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
fn write(options: &PrecisionOptions, records: &[PrecisionRecord], command: &str) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        precision_report::write(folder, records, command)?;
    }
    let mut out = std::io::stdout().lock();
    let text = if options.run.json { files::json(records) } else { precision_report::text(records) };
    out.write_all(text.as_bytes())?;
    Ok(())
}
