//! `ssct error`: run time against error.

use super::cli::ErrorOptions;
use super::error_cells::{Plan, QUICK_ROUGHNESS, QUICK_SIZE, QUICK_VIEWS};
use super::run::Run;
use super::{error_age, precision, progress, resolve};
use crate::error::Result;
use crate::methods::{self, MethodInfo};
use crate::report::{error_report, files};
use crate::scene::{Scene, View, library};
use crate::study::error::{ErrorRecord, Variant};
use crate::study::{Globals, sweep};
use std::io::Write;

/// Measures what is missing, writes and prints everything.
pub fn run(options: &ErrorOptions) -> anyhow::Result<()> {
    if options.precision {
        return precision::run(options);
    }
    if let Some(frames) = options.age {
        return error_age::run(options, frames);
    }
    let gpu = resolve::gpu(&options.common.device)?;
    let plan = plan(options)?;
    let bar = progress::bar("error", plan.cells());
    let mut run = Run::begin(options.output.as_deref(), options.resume)?;
    let pictures = options.output.as_ref().map(|folder| folder.join("images"));
    let outcome = plan.measure(&gpu, &mut run.journal, pictures.as_deref(), &mut || bar.inc(1));
    bar.finish_and_clear();
    let records = plan.records(&gpu, &run.journal);
    // What there is, whatever ended the measurement; and what ended it counts for more.
    let wrote = write(options, &records);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

fn write(options: &ErrorOptions, records: &[ErrorRecord]) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        error_report::write(folder, records)?;
    }
    let shown = if options.json { files::json(records) } else { error_report::text(records) };
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
    let methods = methods::choose(&options.method, &base)?;
    let variants = if options.captures_sweep {
        let of = |method: &&'static MethodInfo| match method.takes_captures {
            true => sweep::captures(method, &base),
            false => vec![Variant { method, setup: base.clone() }],
        };
        methods.iter().flat_map(of).collect()
    } else if options.fallback_sweep {
        methods.iter().flat_map(|method| sweep::fallbacks(method, &base)).collect()
    } else if options.bounces_sweep {
        methods.iter().flat_map(|method| sweep::bounces(method, &base)).collect()
    } else if options.quick || options.no_sweep {
        methods.iter().map(|method| Variant { method, setup: base.clone() }).collect()
    } else {
        sweep::variants(&methods, &base)
    };
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
