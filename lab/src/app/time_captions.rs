//! `ssct time --table captions`: the times under the thesis's figures, each measured on the view that
//! stands for it.

use super::cli::TimeOptions;
use super::run::{Run, go_on};
use super::time_output::{TimeOutput, device_line};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::methods::{self, MethodInfo};
use crate::report::{files, plot, tables};
use crate::scene::{Scene, library};
use crate::study::captions::{CAPTIONS, Caption, REFERENCE, ReferenceTime, compare, time_reference};
use crate::study::error::Variant;
use crate::study::journal::{digest, scene_digest};
use crate::study::timing::{self, TimeSpec};
use crate::study::{Globals, TimeRecord};
use serde_json::json;

/// Roughness and normal deviation unless flags say otherwise: table 5.8's rougher rows. The captions
/// give none.
const ROUGHNESS: f32 = 0.1;

/// Measures, prints and writes.
pub fn run(options: &TimeOptions) -> anyhow::Result<()> {
    let place = &options.common.place;
    if !options.method.is_empty() || !options.size.is_empty() {
        let message = "--table captions takes methods and sizes from the captions, without --method and --size";
        return Err(Error::Usage(message.into()).into());
    }
    if options.samples == 0 {
        return Err(Error::Usage("--samples 0: at least one is needed".into()).into());
    }
    let scenes = scenes(options)?;
    let wanted = wanted(options, &scenes)?;
    let globals = globals(options)?;
    let gpu = resolve::gpu(&options.common.device)?;

    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    let bar = progress::bar("captions", 0);
    let (mut records, mut references, mut missing) = (Vec::<TimeRecord>::new(), Vec::<ReferenceTime>::new(), vec![]);
    let mut outcome = Ok(());
    for (caption, scene) in &wanted {
        // What ended the measurement does not end the report of what the journal has.
        let view = resolve::with_lens(scene, scene.view(caption.view)?.clone(), place)?;
        let mut compared: Vec<&'static MethodInfo> = vec![methods::find("ssct")?];
        match methods::find(caption.other) {
            Ok(method) => compared.push(method),
            Err(_) if caption.other == REFERENCE => {}
            Err(e) => missing.push(format!("figure {}: {e}\n", caption.figure)),
        }
        let spec = TimeSpec {
            only: None,
            a_a: options.a_a,
            gpu: &gpu,
            scene,
            view: &view,
            variants: Variant::of(&compared, &options.common.method_options.setup(caption.size)),
            sizes: vec![caption.size],
            globals: globals.clone(),
            warmup: options.warmup,
            samples: options.samples,
        };
        bar.inc_length(spec.frames() as u64);
        if outcome.is_ok() {
            outcome = timing::measure(&spec, &mut run.journal, &mut || progress::step(&bar));
        }
        records.extend(timing::records(&spec, &run.journal));
        for of in globals.iter().filter(|_| caption.other == REFERENCE) {
            let rays = options.reference_rays;
            let settings = json!([scene_digest(scene), format!("{view:?} {of:?}"), caption.size, rays]);
            let key = format!("reference {} {}", scene.name, digest(&gpu, &settings));
            if outcome.is_ok() && !run.journal.has(&key) {
                let timed = time_reference(&gpu, scene, &view, caption.size, of, rays);
                outcome = run.journal.put(key.clone(), &timed).and_then(|()| go_on());
            }
            references.extend(run.journal.get::<ReferenceTime>(&key));
        }
    }
    bar.finish_and_clear();

    let mut text = device_line(gpu.info());
    text += &tables::captions(&compare(&records, &references));
    text.extend(missing);
    for r in &references {
        let h = &r.head;
        text += &format!(
            "In the place of Mitsuba: this program's world reference on the CPU ({} threads), first hits and {} rays a \
             pixel of the lobe, one bounce, {} x {}. It grows with the rays; the thesis does not say its number.\n",
            r.threads, r.rays, h.width, h.height
        );
    }
    text += "\n";
    text += &tables::times(&records);
    let json = |v: serde_json::Result<serde_json::Value>| v.map_err(anyhow::Error::from);
    let mut all = records.iter().map(|r| json(serde_json::to_value(r))).collect::<anyhow::Result<Vec<_>>>()?;
    for r in &references {
        all.push(json(serde_json::to_value(r))?);
    }
    let written = TimeOutput {
        stem: "time",
        json: files::json(&all),
        samples: ("time-samples.csv", files::samples_csv(&records)),
        plot: plot::stage_bars(&records).map_err(anyhow::Error::msg)?,
        text,
    };
    written.conclude((options.output.as_deref(), options.run.json), run, outcome, &gpu)
}

/// The scene of the flags, or the built-in ones that stand for the figures.
fn scenes(options: &TimeOptions) -> Result<Vec<Scene>> {
    let place = &options.common.place;
    if place.scene.is_empty() {
        let mut names: Vec<&str> = CAPTIONS.iter().map(|c| c.scene).collect();
        names.sort_unstable();
        names.dedup();
        return Ok(names.into_iter().filter_map(library::scene).collect());
    }
    Ok(vec![resolve::scene(place, "")?])
}

/// The captions whose view a scene has, and that the flags ask for.
fn wanted<'a>(options: &TimeOptions, scenes: &'a [Scene]) -> Result<Vec<(Caption, &'a Scene)>> {
    let asked = options.common.place.view.as_deref();
    let of = |c: &Caption| {
        let scene = scenes.iter().find(|s| s.views.iter().any(|v| v.name == c.view))?;
        asked.is_none_or(|view| view == c.view).then_some((*c, scene))
    };
    let wanted: Vec<_> = CAPTIONS.iter().filter_map(of).collect();
    if wanted.is_empty() {
        let views: Vec<&str> = CAPTIONS.iter().map(|c| c.view).collect();
        let views = views.join(", ");
        return Err(Error::Usage(format!("no caption with times is of such a view; they are of: {views}")));
    }
    Ok(wanted)
}

/// The flags' factors, else [`ROUGHNESS`]; the normal deviation is the roughness unless a flag gives it.
fn globals(options: &TimeOptions) -> Result<Vec<Globals>> {
    let mut globals = resolve::globals(&options.common.place)?;
    for g in &mut globals {
        g.roughness = g.roughness.or(Some(ROUGHNESS));
        g.normal_deviation = g.normal_deviation.or(g.roughness);
    }
    Ok(globals)
}
