//! `ssct error`: run time against error, cell by cell; a cell that was measured is kept.

use super::cli::ErrorOptions;
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::{self, METHODS, MethodInfo, Setup};
use crate::report::{error_report, files};
use crate::scene::{View, library};
use crate::study::error::{ErrorRecord, ErrorSpec, Variant, measure};
use crate::study::record::{DEFINITIONS, Head};
use crate::study::{Globals, Stage, sweep};
use std::io::Write;
use std::path::Path;

/// Measures what is missing, writes and prints everything.
pub fn run(options: &ErrorOptions) -> anyhow::Result<()> {
    let gpu = resolve::gpu(&options.common.device)?;
    let records = study(options, &gpu)?;
    let mut out = std::io::stdout().lock();
    if let Some(folder) = &options.output {
        error_report::write(folder, &records)?;
    }
    if options.json {
        out.write_all(files::json(&records).as_bytes())?;
    } else {
        out.write_all(error_report::text(&records).as_bytes())?;
    }
    gpu.check_validation()?;
    Ok(())
}

/// The records of every cell.
pub fn study(options: &ErrorOptions, gpu: &Gpu) -> anyhow::Result<Vec<ErrorRecord>> {
    let common = &options.common;
    let methods: Vec<&'static MethodInfo> = match &options.method[..] {
        [] => METHODS.iter().collect(),
        names => names.iter().map(|n| methods::find(n)).collect::<Result<_>>()?,
    };
    let scenes = match (&common.scene[..], options.quick) {
        ([], false) => library::names().iter().filter_map(|n| library::scene(n)).collect(),
        _ => vec![resolve::scene(common, "rooms")?],
    };
    let globals = match &common.roughness[..] {
        [] if options.quick => roughness_values(common, &[0.0, 0.1])?,
        [] => roughness_values(common, &sweep::ROUGHNESS)?,
        _ => resolve::globals(common)?,
    };
    let quick = options.quick && options.size.is_empty();
    let sizes = match &options.size[..] {
        [] if quick => vec![[320, 180]],
        [] => vec![[480, 270]],
        sizes => sizes.to_vec(),
    };
    let base = resolve::setup(&common.method_options, sizes[0]);
    let variants = if options.quick || options.no_sweep {
        methods.iter().map(|method| Variant { method, setup: base }).collect()
    } else {
        sweep::variants(&methods, base)
    };
    if options.samples == 0 || options.rays < 2 {
        return Err(Error::Usage("--samples must be at least 1, and --rays at least 2".into()).into());
    }

    let mut jobs = Vec::new();
    for scene in &scenes {
        let views: Vec<View> = if common.view.is_some() || common.eye.is_some() {
            vec![resolve::view(scene, common, None)?]
        } else {
            let count = if options.quick { 2 } else { usize::MAX };
            scene.views.iter().take(count).cloned().collect()
        };
        jobs.push((scene, views));
    }
    let cells = jobs.iter().map(|(_, views)| views.len()).sum::<usize>() * sizes.len() * globals.len();
    let bar = progress::bar("error", cells);
    let mut records = Vec::new();
    for (scene, views) in &jobs {
        let mut stage = None;
        for view in views {
            for &extent in &sizes {
                for &globals in &globals {
                    let (warmup, samples, rays) = (1, options.samples, options.rays);
                    let variants = &variants[..];
                    let spec = ErrorSpec { gpu, scene, view, extent, globals, variants, warmup, samples, rays };
                    records.extend(cell(&spec, &mut stage, options.output.as_deref())?);
                    bar.inc(1);
                }
            }
        }
    }
    bar.finish_and_clear();
    Ok(records)
}

fn roughness_values(common: &super::cli::CommonOptions, values: &[f32]) -> Result<Vec<Globals>> {
    let one = resolve::one_globals(common, "no roughness was given")?;
    Ok(values.iter().map(|r| Globals { roughness: Some(*r), ..one }).collect())
}

/// A cell from its file if it was measured with the same settings, else measured and kept.
fn cell<'s>(
    spec: &ErrorSpec<'s>,
    stage: &mut Option<Stage>,
    folder: Option<&Path>,
) -> anyhow::Result<Vec<ErrorRecord>> {
    let [width, height] = spec.extent;
    let roughness = crate::report::tables::roughness(spec.globals.roughness);
    let stem = format!("{}-{}-{width}x{height}-r{roughness}", spec.scene.name, spec.view.name);
    let key = key(spec);
    let path = folder.map(|f| f.join("cells").join(format!("{stem}.json")));
    if let Some(kept) = path.as_ref().and_then(|p| kept(p, &key)) {
        return Ok(kept);
    }
    if stage.is_none() {
        *stage = Some(Stage::new(spec.gpu, spec.scene)?);
    }
    let Some(stage) = stage else { return Ok(Vec::new()) };
    let measured = measure(spec, stage)?;
    if let (Some(folder), Some(path)) = (folder, &path) {
        error_report::write_strips(&folder.join("images"), &stem, &measured)?;
        let content = serde_json::json!({ "key": key, "records": measured.records });
        files::write(path, serde_json::to_string(&content)?.as_bytes())?;
    }
    Ok(measured.records)
}

/// Everything that a cell depends on.
fn key(spec: &ErrorSpec) -> serde_json::Value {
    let setup = |s: &Setup| serde_json::json!([s.preset, s.tuning, s.chain_filter, s.fade]);
    let variants: Vec<_> = spec.variants.iter().map(|v| (v.method.name, setup(&v.setup))).collect();
    let g = spec.globals;
    let view = spec.view;
    serde_json::json!({
        "definitions": DEFINITIONS, "version": Head::VERSION, "commit": Head::COMMIT, "device": spec.gpu.info(),
        "scene": spec.scene.name, "triangles": spec.scene.triangle_count(),
        "view": format!("{view:?}"), "lens": format!("{:?}", spec.scene.lens),
        "globals": [g.roughness, Some(g.reflectivity), g.normal_deviation],
        "extent": spec.extent, "variants": variants, "samples": [spec.warmup, spec.samples], "rays": spec.rays,
    })
}

fn kept(path: &Path, key: &serde_json::Value) -> Option<Vec<ErrorRecord>> {
    let mut content: serde_json::Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    if content.get("key") != Some(key) {
        return None;
    }
    serde_json::from_value(content.get_mut("records")?.take()).ok()
}
