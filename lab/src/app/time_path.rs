//! `ssct time --path`: frames per second while the camera moves.

use super::cli::TimeOptions;
use super::run::Run;
use super::time_output::{TimeOutput, device_line};
use super::{progress, resolve};
use crate::methods;
use crate::report::{files, path_report};
use crate::study::path::{PathSpec, measure, records};
use std::path::Path;

/// Measures, prints and writes.
pub fn run(options: &TimeOptions, path: &Path) -> anyhow::Result<()> {
    let common = &options.common;
    let mut scene = resolve::scene(&common.place, "rooms")?;
    let path = resolve::path(&scene, path, "--path")?;
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
    written.conclude(options, run, outcome, &gpu)
}
