//! `ssct truth`: the world reference, for others to check.

use super::cli::{SceneOptions, parse_size};
use super::printed;
use super::resolve;
use crate::error::Error;
use crate::report::mitsuba::{Export, export};
use clap::{Args, Subcommand};
use ssct_scenes::inside::PathInFolder;
use std::io::Write;
use std::path::PathBuf;

/// Options of `ssct truth`.
#[derive(Debug, Args)]
pub struct TruthOptions {
    #[command(subcommand)]
    command: TruthCommand,
}

#[derive(Debug, Subcommand)]
enum TruthCommand {
    /// Write scene, camera and reflections into a folder.
    ///
    /// scripts/mitsuba_compare.py holds them against Mitsuba 3.
    Export(ExportOptions),
}

#[derive(Debug, Args)]
struct ExportOptions {
    #[command(flatten)]
    place: SceneOptions,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "160x90")]
    size: [u32; 2],
    /// Rays of a glossy pixel
    #[arg(long, value_name = "N", default_value_t = 256)]
    samples: u32,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs `ssct truth export`: writes scene, camera and world reference for another renderer, and prints how many
/// triangles and reflecting pixels they have.
pub fn run(options: &TruthOptions) -> anyhow::Result<()> {
    let TruthCommand::Export(options) = &options.command;
    let globals = resolve::one_globals(&options.place, "truth export makes one image")?;
    if options.samples < 2 {
        return Err(Error::usage("--samples: a standard error needs at least two".into()).into());
    }
    let scene = resolve::scene(&options.place, "rooms")?;
    let view = resolve::view(&scene, &options.place, None)?;
    let materials = globals.materials(&scene, &view);
    let exported = export(
        &PathInFolder::folder(&options.output),
        &Export {
            scene: &scene,
            materials: &materials,
            camera: view.camera(&scene, options.size),
            extent: options.size,
            samples: options.samples,
            seed: options.seed,
        },
    )?;
    writeln!(
        printed::out(),
        "{}: {} triangles, {} reflecting pixels, standard error {:.5}",
        options.output.display(),
        exported.triangles,
        exported.receivers,
        exported.standard_error
    )?;
    Ok(())
}
