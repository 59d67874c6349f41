//! `ssct error --video`: films of methods beside the world's.

use super::cli::ErrorOptions;
use super::run::{Run, go_on};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::{files, video_report};
use crate::scene::Scene;
use crate::study::journal::{digest, scene_digest};
use crate::study::video::{VideoRecord, VideoSpec, Way, measure};
use glam::Vec3;
use serde_json::json;
use std::io::Write;
use std::path::Path;

/// Films for every size and roughness what the journal lacks, writes and prints.
pub fn run(options: &ErrorOptions, way: &Path) -> anyhow::Result<()> {
    let common = &options.common;
    if !(options.fps.is_finite() && (1.0..=1000.0).contains(&options.fps)) {
        return Err(Error::Usage(format!("--fps {}: must lie between 1 and 1000", options.fps)).into());
    }
    if options.rays < 2 {
        return Err(Error::Usage("--rays must be at least 2".into()).into());
    }
    let scene = resolve::scene(&common.place, "rooms")?;
    let way = named(options, &scene, way)?;
    let globals = resolve::globals(&common.place)?;
    let sizes = if options.size.is_empty() { vec![[320, 180]] } else { options.size.clone() };
    let base = common.method_options.setup(sizes[0]);
    let variants = resolve::variants(options, &base, false)?;
    resolve::moving(&scene, &options.moving)?;
    let step_m = options.step.unwrap_or(Vec3::ZERO);
    let gpu = resolve::gpu(&common.device)?;
    let cells: Vec<_> = sizes.iter().flat_map(|&size| globals.iter().map(move |&g| (size, g))).collect();
    let mut run = Run::begin(options.output.as_deref(), options.resume)?;
    let bar = progress::bar("video", cells.len());
    let mut records: Vec<VideoRecord> = Vec::new();
    let mut outcome = Ok(());
    let scene_digest = scene_digest(&scene);
    for (extent, globals) in cells {
        let (moving, variants, way) = (&options.moving[..], &variants[..], &way);
        let (frames, frames_per_second, rays, gpu, scene) = (options.frames, options.fps, options.rays, &gpu, &scene);
        let spec =
            VideoSpec { gpu, scene, way, extent, globals, variants, frames, frames_per_second, rays, moving, step_m };
        let set: Vec<_> =
            variants.iter().map(|v| json!([v.method.name, v.setup.at(extent).recorded(Some(v.method))])).collect();
        let moves = json!([format!("{way:?}"), moving, step_m.to_array(), frames, frames_per_second, rays]);
        let digest = digest(gpu, &json!([scene_digest, set, globals, moves]));
        let key = format!("video {} {} {digest}", scene.name, way.name());
        // What ended the measurement does not end the report of what the journal has.
        if outcome.is_ok() {
            let filmed = run.journal.get_or(&key, |_| {
                let (records, films) = measure(&spec, &mut go_on)?;
                if let Some(folder) = &options.output {
                    video_report::write_clips(folder, &records, &films)?;
                }
                Ok::<_, Error>(records)
            });
            outcome = filmed.map(drop).and_then(|()| progress::step(&bar));
        }
        records.extend(run.journal.get::<Vec<VideoRecord>>(&key).into_iter().flatten());
    }
    bar.finish_and_clear();
    let wrote = write(options, &records);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

/// The way that a flag names.
fn named(options: &ErrorOptions, scene: &Scene, name: &Path) -> Result<Way> {
    let place = &options.common.place;
    let of_view: fn(_) -> Way = match name.to_string_lossy().as_ref() {
        "walk" => Way::Walk,
        "turn" => Way::Turn,
        "rest" => Way::Rest,
        _ => {
            let path = resolve::path(scene, name, "--video")?;
            if place.view.is_some() || place.eye.is_some() {
                let message = "--video: a path says where the camera is; leave out --view and --eye";
                return Err(Error::Usage(message.into()));
            }
            return Ok(Way::Path(path));
        }
    };
    resolve::view(scene, place, None).map(of_view)
}

fn write(options: &ErrorOptions, records: &[VideoRecord]) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        let of = |r: &VideoRecord| {
            let (way, frames, fps, rays) = (&r.way, r.frames.len(), r.frames_per_second, r.rays);
            format!("ssct error --video {way} --frames {frames} --fps {fps} --rays {rays}")
        };
        video_report::write(folder, records, &records.first().map(of).unwrap_or_default())?;
    }
    let shown = if options.json { files::json(records) } else { video_report::text(records) };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}
