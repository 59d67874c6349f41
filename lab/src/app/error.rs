//! `ssct error`: run time against error.

use super::error_cells::{Plan, QUICK_ROUGHNESS, QUICK_SIZE, QUICK_VIEWS};
use super::error_options::ErrorOptions;
use super::run::{Run, command_line};
use super::{progress, resolve};
use crate::error::Result;
use crate::report::error_report::{self, IMAGES};
use crate::report::files;
use crate::scene::{Scene, View, library};
use crate::study::error::ErrorRecord;
use crate::study::{Globals, sweep};
use std::io::Write;

/// Measures what is missing, writes and prints everything.
pub fn run(options: &ErrorOptions) -> anyhow::Result<()> {
    let plan = plan(options)?;
    let gpu = resolve::gpu(&options.common.device)?;
    let list = plan.list(&gpu, options.shard.shard, command_line())?;
    let bar = progress::bar("error", list.owned());
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    run.list(&list)?;
    let pictures = options.output.as_ref().map(|folder| folder.join(IMAGES));
    let outcome = plan.measure(&gpu, &mut run.journal, Some(&list), pictures.as_deref(), &mut || bar.inc(1));
    bar.finish_and_clear();
    let records = plan.records(&gpu, &run.journal);
    // Cells that were measured are written even after an error, and that error is reported before one of writing.
    let wrote = write(options, &records, &list.command);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

fn write(options: &ErrorOptions, records: &[ErrorRecord], command: &str) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        error_report::write(folder, records, command, &[])?;
    }
    let shown = if options.run.json { files::json(records) } else { error_report::text(records) };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}

/// What the flags ask for.
fn plan(options: &ErrorOptions) -> Result<Plan> {
    let common = &options.common;
    let scenes = match (&common.place.scene[..], options.quick) {
        ([], false) => library::names().iter().filter_map(|n| library::scene(n)).collect(),
        _ => vec![resolve::scene(&common.place, "rooms")?],
    };
    let globals = match &common.place.roughness[..] {
        [] if options.quick => roughness_values(common, &QUICK_ROUGHNESS)?,
        [] => roughness_values(common, &sweep::ROUGHNESS)?,
        _ => resolve::globals(&common.place)?,
    };
    let sizes = match &options.size[..] {
        [] if options.quick => vec![QUICK_SIZE],
        [] => vec![[480, 270]],
        sizes => sizes.to_vec(),
    };
    let base = common.method_options.setup(sizes[0]);
    let variants = resolve::variants(&options.variants, &base, !options.quick && !options.no_sweep)?;
    let views = |scene: &Scene| -> Result<Vec<View>> {
        if common.place.view.is_some() || common.place.eye.is_some() {
            return Ok(vec![resolve::view(scene, &common.place, None)?]);
        }
        let count = if options.quick { QUICK_VIEWS } else { usize::MAX };
        Ok(scene.views.iter().take(count).cloned().collect())
    };
    let mut jobs = Vec::new();
    for scene in scenes {
        let views = views(&scene)?;
        jobs.push((scene, views));
    }
    Ok(Plan { scenes: jobs, sizes, globals, variants, samples: options.samples, rays: options.rays })
}

fn roughness_values(common: &super::cli::CommonOptions, values: &[f32]) -> Result<Vec<Globals>> {
    let one = resolve::one_globals(&common.place, "no roughness was given")?;
    Ok(values.iter().map(|r| Globals { roughness: Some(*r), ..one }).collect())
}
