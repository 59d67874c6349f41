//! `ssct age`: error over the age of captures, while things move.

use super::cli::{CommonOptions, RunOptions, ShardOptions, point, size};
use super::run::{Run, go_on, list_head};
use super::{progress, resolve};
use crate::error::Error;
use crate::methods::{self, MethodInfo};
use crate::report::{age_report, error_report, files};
use crate::scene::capture::MAX_CAPTURES;
use crate::study::Globals;
use crate::study::age::{AgeRecord, AgeSpec, measure};
use crate::study::cell_list::{CellList, PlannedCell};
use crate::study::journal::{digest, scene_digest};
use crate::study::stress::JUDGED;
use clap::Args;
use glam::Vec3;
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;

/// Options of `ssct age`.
#[derive(Debug, Args)]
pub struct AgeOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods that follow rays in captures
    ///
    /// Without it, the method unified is measured.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Widths and heights in pixels; by default 480x270
    #[arg(long, value_name = "WxH", value_parser = size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Frames of the measurement
    ///
    /// Each of them is held against the world as it then is.
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Meshes that move, by name
    #[arg(long, value_name = "MESH", value_delimiter = ',', required = true)]
    pub moving: Vec<String>,
    /// How far they move from frame to frame, in metres
    ///
    /// The three numbers are along the axes of the world.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub step: Vec3,
    /// Faces renewed in each frame
    ///
    /// Each of these numbers of faces of captures is measured.
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        default_values_t = [0, 1, 2, 6, 24],
        value_parser = clap::value_parser!(u32).range(0..=6 * MAX_CAPTURES as i64)
    )]
    pub faces: Vec<u32>,
    /// Rays a pixel of the references
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..))]
    pub rays: u32,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Folder for records, a plot and a table
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Measures for every size and roughness what the journal lacks, writes and prints.
pub fn run(options: &AgeOptions) -> anyhow::Result<()> {
    let common = &options.common;
    let scene = resolve::scene(&common.place, "museum")?;
    let view = resolve::view(&scene, &common.place, None)?;
    let globals = resolve::globals(&common.place)?;
    let sizes = if options.size.is_empty() { vec![[480, 270]] } else { options.size.clone() };
    let setup = common.method_options.setup(sizes[0]);
    let names = if options.method.is_empty() { vec![JUDGED.to_owned()] } else { options.method.clone() };
    let methods = methods::choose(&names, &setup)?;
    if setup.values.given().any(|name| name == "captures_per_frame") {
        let message = "age compares several numbers of faces a frame: give --faces instead of --captures-per-frame";
        return Err(Error::Usage(message.into()).into());
    }
    let (step_m, frames) = (options.step, options.frames);
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
        PlannedCell::new(format!("{stem}-{}", spec.method.name), settings(spec), key(spec))
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

fn write(options: &AgeOptions, records: &[AgeRecord]) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        age_report::write(folder, records)?;
    }
    let shown = if options.run.json { files::json(records) } else { age_report::text(records) };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}
