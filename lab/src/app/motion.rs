//! `ssct motion`: how much reflections change while the camera moves, beside how much they should.

use super::cli::MotionOptions;
use super::run::Run;
use super::stress::motion_name;
use super::{progress, resolve};
use crate::error::Error;
use crate::methods;
use crate::report::{files, stress_report};
use crate::scene::View;
use crate::study::journal::{digest, scene_digest};
use crate::study::stress::lineup::SceneLineup;
use crate::study::stress::motion::{self, MOTIONS, Motion, MotionRecord, MotionSpec};
use serde_json::json;
use std::io::Write;

/// Roughness values where none are given.
const ROUGHNESS: [f32; 3] = [0.05, 0.1, 0.4];

/// Measures what is missing, writes and prints everything.
pub fn run(options: &MotionOptions) -> anyhow::Result<()> {
    let common = &options.common;
    let place = &common.place;
    if place.reflectivity != 1.0 || place.normal_deviation.is_some() {
        let message = "motion is measured with the reflectivity and the normals of the materials";
        return Err(Error::Usage(message.into()).into());
    }
    let scene = resolve::scene(place, "rooms")?;
    let views = match (&place.view, place.eye) {
        (None, None) => scene.views.iter().map(|v| resolve::with_lens(&scene, v.clone(), place)).collect(),
        _ => resolve::view(&scene, place, None).map(|v| vec![v]),
    }?;
    let roughness: Vec<f32> = match &place.roughness[..] {
        [] => ROUGHNESS.to_vec(),
        _ => resolve::globals(place)?.iter().filter_map(|g| g.roughness).collect(),
    };
    let setup = common.method_options.setup(options.size);
    let methods = methods::choose(&options.method, &setup)?;
    let gpu = resolve::gpu(&common.device)?;
    let (extent, frames, rays) = (options.size, options.frames, options.rays);
    let spec = |view, roughness| MotionSpec { view, extent, roughness, frames, rays, against_world: true };
    let of_view = |view| roughness.iter().flat_map(move |r| MOTIONS.map(|motion| (spec(view, *r), motion)));
    let all: Vec<(MotionSpec, Motion)> = views.iter().flat_map(of_view).collect();

    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    let bar = progress::bar("motion", all.len());
    let set: Vec<_> = methods.iter().map(|m| (m.name, setup.recorded(Some(m)))).collect();
    let looks = |view: &View| format!("{view:?}");
    let views_digest: Vec<_> = views.iter().map(looks).collect();
    let digest = digest(&gpu, &json!([scene_digest(&scene), set, views_digest]));
    let key = |(spec, motion): &(MotionSpec, Motion)| format!("motion {digest} {}", motion_name(&scene, spec, *motion));
    let mut lineup: Option<SceneLineup> = None;
    let mut outcome = Ok(());
    for one in &all {
        // What ended the measurement does not end the report of what the journal has.
        if outcome.is_ok() {
            let measured = run.journal.get_or(&key(one), |_| {
                let lineup = match &mut lineup {
                    Some(made) => made,
                    none => none.insert(SceneLineup::new(&gpu, scene.clone(), &setup, &methods)?),
                };
                motion::run(&gpu, &one.0, one.1, lineup)
            });
            outcome = measured.map(drop).and_then(|()| progress::step(&bar));
        }
    }
    bar.finish_and_clear();
    let of = |one| run.journal.get::<Vec<MotionRecord>>(&key(one)).unwrap_or_default();
    let records: Vec<MotionRecord> = all.iter().flat_map(of).collect();
    let wrote = write(options, &records);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

fn write(options: &MotionOptions, records: &[MotionRecord]) -> anyhow::Result<()> {
    let text = stress_report::motion_text(records);
    if let Some(folder) = &options.output {
        files::write(&folder.join("motion.json"), files::json(records).as_bytes())?;
        files::write(&folder.join("motion.txt"), text.as_bytes())?;
    }
    let shown = if options.run.json { files::json(records) } else { text };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}
