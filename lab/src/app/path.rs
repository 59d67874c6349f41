//! `ssct path`: frames per second while the camera moves.

use super::cli::{CommonOptions, RunOptions, size};
use super::run::Run;
use super::time_output::{TimeOutput, device_line};
use super::{progress, resolve};
use crate::error::Error;
use crate::methods;
use crate::report::{files, path_report};
use crate::study::path::{PathSpec, measure, records};
use clap::Args;
use std::path::PathBuf;

/// Options of `ssct path`.
#[derive(Debug, Args)]
pub struct PathOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// Widths and heights in pixels; by default 960x540
    #[arg(long, value_name = "WxH", value_parser = size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Path of the camera, by name or file
    ///
    /// `views` leads through the views of the scene; a name is that of a path of the scene file; a path file ends in .toml
    /// (docs/window.md).
    #[arg(long, value_name = "NAME|FILE", default_value = "views")]
    pub path: PathBuf,
    /// Frames from one end to the other
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: u32,
    /// Frames that are drawn before the first that is timed.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub warmup: usize,
    /// Folder for records, frames, a plot and a table
    ///
    /// Its files are path.json, path-frames.csv, path.svg and path.txt.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Measures, prints and writes.
pub fn run(options: &PathOptions) -> anyhow::Result<()> {
    let common = &options.common;
    if common.place.view.is_some() || common.place.eye.is_some() {
        let message = "a path says where the camera is; leave out --view and --eye";
        return Err(Error::Usage(message.into()).into());
    }
    let mut scene = resolve::scene(&common.place, "rooms")?;
    let path = resolve::path(&scene, &options.path, "--path")?;
    let sizes = if options.size.is_empty() { vec![[960, 540]] } else { options.size.clone() };
    let setup = common.method_options.setup(sizes[0]);
    let methods = methods::choose(&options.method, &setup)?;
    scene.lens = resolve::lens(&common.place, scene.lens)?;
    let gpu = resolve::gpu(&common.device)?;
    let spec = PathSpec {
        gpu: &gpu,
        scene: &scene,
        path: &path,
        methods,
        globals: resolve::one_globals(&common.place, "a path is walked with one roughness")?,
        setup,
        sizes,
        warmup: options.warmup,
        frames: options.frames as usize,
    };
    let mut run = Run::begin(options.output.as_deref(), options.run.resume)?;
    let bar = progress::bar("path", spec.submissions());
    let outcome = measure(&spec, &mut run.journal, &mut || progress::step(&bar));
    bar.finish_and_clear();
    let records = records(&spec, &run.journal);

    let written = TimeOutput {
        stem: "path",
        json: files::json(&records),
        samples: ("path-frames.csv", path_report::frames_csv(&records)),
        plot: path_report::plot(&records).map_err(anyhow::Error::msg)?,
        text: device_line(gpu.info()) + &path_report::text(&records),
    };
    written.conclude((options.output.as_deref(), options.run.json), run, outcome, &gpu)
}
