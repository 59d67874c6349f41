//! `ssct video`: films of methods beside the world's.

use super::cli::{CommonOptions, RunOptions, ShardOptions, point, size};
use super::error_options::VariantOptions;
use super::run::{Run, go_on, list_head};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::{error_report, files, video_report};
use crate::scene::Scene;
use crate::study::Globals;
use crate::study::cell_list::{CellList, PlannedCell};
use crate::study::journal::{digest, scene_digest};
use crate::study::video::{VideoRecord, VideoSpec, Way, measure};
use clap::Args;
use glam::Vec3;
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;

/// Options of `ssct video`.
#[derive(Debug, Args)]
pub struct VideoOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    #[command(flatten)]
    pub variants: VariantOptions,
    /// Widths and heights in pixels; by default 320x180
    #[arg(long, value_name = "WxH", value_parser = size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Way of the camera, such as turn
    ///
    /// - walk: from the view towards what it looks at
    /// - turn: at rest, turned quickly, and at rest again
    /// - rest: the camera stays where the view is
    /// - views: through the views of the scene
    /// - the name of a path of the scene file, or a path file (.toml)
    #[arg(long, value_name = "NAME|FILE", default_value = "walk", verbatim_doc_comment)]
    pub way: PathBuf,
    /// Frames of the film
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub frames: u32,
    /// Frames that are shown in a second.
    #[arg(long, value_name = "N", default_value_t = 30.0)]
    pub fps: f32,
    /// Meshes that move, by name; with --step
    #[arg(long, value_name = "MESH", value_delimiter = ',', requires = "step")]
    pub moving: Vec<String>,
    /// How far they move from frame to frame, in metres
    ///
    /// The three numbers are along the axes of the world.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "moving")]
    pub step: Option<Vec3>,
    /// Rays a pixel of the world reference
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..))]
    pub rays: u32,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Folder for records, films and a page
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Films for every size and roughness what the journal lacks, writes and prints.
pub fn run(options: &VideoOptions) -> anyhow::Result<()> {
    let common = &options.common;
    if !(options.fps.is_finite() && (1.0..=1000.0).contains(&options.fps)) {
        return Err(Error::Usage(format!("--fps {}: must lie between 1 and 1000", options.fps)).into());
    }
    let scene = resolve::scene(&common.place, "rooms")?;
    let way = named(options, &scene)?;
    let globals = resolve::globals(&common.place)?;
    let sizes = if options.size.is_empty() { vec![[320, 180]] } else { options.size.clone() };
    let base = common.method_options.setup(sizes[0]);
    let variants = resolve::variants(&options.variants, &base, false)?;
    resolve::moving(&scene, &options.moving)?;
    let step_m = options.step.unwrap_or(Vec3::ZERO);
    let gpu = resolve::gpu(&common.device)?;
    let cells: Vec<_> = sizes.iter().flat_map(|&size| globals.iter().map(move |&g| (size, g))).collect();
    let scene_digest = scene_digest(&scene);
    let (moving, variants, way) = (&options.moving[..], &variants[..], &way);
    let (frames, frames_per_second, rays) = (options.frames, options.fps, options.rays);
    let spec = |&(extent, globals): &([u32; 2], Globals)| {
        let (gpu, scene) = (&gpu, &scene);
        VideoSpec { gpu, scene, way, extent, globals, variants, frames, frames_per_second, rays, moving, step_m }
    };
    let settings = |spec: &VideoSpec| {
        let set: Vec<_> = variants.iter().map(|v| v.settings(spec.extent)).collect();
        let moves = json!([format!("{way:?}"), moving, step_m.to_array(), frames, frames_per_second, rays]);
        json!([scene_digest, set, spec.globals, moves])
    };
    let key = |spec: &VideoSpec| format!("video {} {} {}", scene.name, way.name(), digest(&gpu, &settings(spec)));
    let planned = |spec: &VideoSpec| {
        let name = error_report::stem(&scene.name, way.name(), spec.extent, spec.globals.roughness);
        PlannedCell::new(name, settings(spec), key(spec))
    };
    let specs: Vec<VideoSpec> = cells.iter().map(spec).collect();
    let planned = specs.iter().map(planned).collect();
    let list = CellList::new(list_head("video", options.shard.shard, &base, &scene), gpu.info(), planned);
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    run.list(&list)?;
    let bar = progress::bar("video", list.owned());
    let mut records: Vec<VideoRecord> = Vec::new();
    let mut outcome = Ok(());
    for spec in list.own(&specs) {
        let key = key(spec);
        // What ended the measurement does not end the report of what the journal has.
        if outcome.is_ok() {
            let filmed = run.journal.get_or(&key, |_| {
                let (records, films) = measure(spec, &mut go_on)?;
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
    let wrote = write(options, &records, &list.command);
    run.ended(outcome)?;
    wrote?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

/// The way that a flag names.
fn named(options: &VideoOptions, scene: &Scene) -> Result<Way> {
    let place = &options.common.place;
    let name = options.way.as_path();
    let of_view: fn(_) -> Way = match name.to_string_lossy().as_ref() {
        "walk" => Way::Walk,
        "turn" => Way::Turn,
        "rest" => Way::Rest,
        _ => {
            let path = resolve::path(scene, name, "--way")?;
            if place.view.is_some() || place.eye.is_some() {
                let message = "--way: a path says where the camera is; leave out --view and --eye";
                return Err(Error::Usage(message.into()));
            }
            return Ok(Way::Path(path));
        }
    };
    resolve::view(scene, place, None).map(of_view)
}

fn write(options: &VideoOptions, records: &[VideoRecord], command: &str) -> anyhow::Result<()> {
    if let Some(folder) = &options.output {
        video_report::write(folder, records, command)?;
    }
    let shown = if options.run.json { files::json(records) } else { video_report::text(records) };
    std::io::stdout().lock().write_all(shown.as_bytes())?;
    Ok(())
}
