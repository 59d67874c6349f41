//! The flags of `ssct error`, each declared once. What they mean together is decided in `error`, in `resolve`, and by the
//! kinds of study that some of them choose.

use super::cli::{CommonOptions, RunOptions, ShardOptions, point, size};
use super::parameters::{TypedVariant, typed_variant};
use crate::scene::capture::MAX_CAPTURES;
use clap::Args;
use glam::Vec3;
use std::path::PathBuf;

/// Options of `ssct error`.
#[derive(Debug, Args)]
pub struct ErrorOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    /// The methods; without it, all of them.
    #[arg(long, value_delimiter = ',')]
    pub method: Vec<String>,
    /// A method with flags of its own, which count before those outside, as "stochastic --history on"; give it once for
    /// each that is compared, instead of --method.
    #[arg(
        long,
        value_name = "METHOD FLAGS",
        value_parser = typed_variant,
        conflicts_with_all = ["method", "no_sweep", "captures_sweep", "fallback_sweep", "precision", "age"]
    )]
    pub variant: Vec<TypedVariant>,
    /// Widths and heights in pixels; without it, 480x270 (320x180 with --quick).
    #[arg(long, value_name = "WxH", value_parser = size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Two views, two roughness values, no sweep.
    #[arg(long)]
    pub quick: bool,
    /// Only the variant that the flags name, instead of both presets and their parameters.
    #[arg(long)]
    pub no_sweep: bool,
    /// Of methods that take captures, the variants without them and with 1, 2, 4 and 8 of 128 to 1024 texels a side; of
    /// the others only the variant that the flags name.
    #[arg(long, conflicts_with_all = ["no_sweep", "precision", "quick"])]
    pub captures_sweep: bool,
    /// Of screen-space methods, the variants with nothing, with the environment and with pccm behind them; of unified
    /// also the one with the captures that the flags name; of the others only the variant that the flags name.
    #[arg(long, conflicts_with_all = ["no_sweep", "precision", "quick", "captures_sweep", "fallback"])]
    pub fallback_sweep: bool,
    /// Of screen-space methods, the variants with one bounce, with two, and so on up to --bounces, all held against light
    /// that is reflected as often as with the most; of the others only the variant that the flags name.
    #[arg(
        long,
        requires = "bounces",
        conflicts_with_all = ["no_sweep", "precision", "quick", "captures_sweep", "fallback_sweep"]
    )]
    pub bounces_sweep: bool,
    /// Error against the bytes of a G-buffer's pixel instead of run time: depth, normals and colour in one
    /// format after another.
    #[arg(long, conflicts_with = "no_sweep")]
    pub precision: bool,
    /// Error over the age of captures instead of run time: meshes move a step each frame, captures are renewed by so
    /// many faces a frame, and each of FRAMES is held against the world as it then is.
    #[arg(
        long,
        value_name = "FRAMES",
        group = "in_time",
        value_parser = clap::value_parser!(u32).range(1..=100_000),
        requires_all = ["moving", "step"],
        conflicts_with_all = ["precision", "no_sweep", "quick", "samples"]
    )]
    pub age: Option<u32>,
    /// Films instead of still images: every variant on each frame of a way of the camera, beside what the world shows in
    /// that frame. WAY is walk (from the view towards what it looks at), turn (at rest, turned quickly, at rest), rest,
    /// views (through the scene's views), a path of the scene file, or a path file (.toml).
    #[arg(long, value_name = "WAY", group = "in_time", conflicts_with_all = ["precision", "quick", "samples"])]
    pub video: Option<PathBuf>,
    /// For --video: frames.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 60,
        requires = "video",
        value_parser = clap::value_parser!(u32).range(2..=100_000)
    )]
    pub frames: u32,
    /// For --video: frames that are shown in a second.
    #[arg(long, value_name = "N", default_value_t = 30.0, requires = "video")]
    pub fps: f32,
    /// For --age and --video: the meshes that move, by name.
    #[arg(long, value_name = "MESH", value_delimiter = ',', requires_all = ["in_time", "step"])]
    pub moving: Vec<String>,
    /// For --age and --video: by how much they move from one frame to the next, in metres along the world's axes.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = point,
        allow_hyphen_values = true,
        requires_all = ["in_time", "moving"]
    )]
    pub step: Option<Vec3>,
    /// For --age: faces of captures that are renewed in each frame.
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        default_values_t = [0, 1, 2, 6, 24],
        requires = "age",
        value_parser = clap::value_parser!(u32).range(0..=6 * MAX_CAPTURES as i64)
    )]
    pub faces: Vec<u32>,
    /// Frames that count, for each variant.
    #[arg(long, default_value_t = 5)]
    pub samples: usize,
    /// Rays a pixel of the screen and the world reference.
    #[arg(long, default_value_t = 64)]
    pub rays: u32,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Only take the rays of the world references, and keep them in the folder, for --references. A shard takes its
    /// share of all rays, which may be a part of a cell's.
    #[arg(long, requires = "output", conflicts_with_all = ["precision", "in_time", "json", "plan"])]
    pub only_references: bool,
    /// Folders of runs with --only-references, on devices of the same kind: their rays are not taken again.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["precision", "in_time", "only_references"])]
    pub references: Vec<PathBuf>,
    /// Measure nothing, and print how long the study is predicted to take on so many machines (docs/many-machines.md).
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(1..=1_000_000),
        conflicts_with_all = ["shard", "output", "resume", "precision", "in_time"]
    )]
    pub plan: Vec<u32>,
    /// For --plan: also the median and the 95th percentile of simulated runs in which some machines are slow and some
    /// attempts fail.
    #[arg(long, requires = "plan")]
    pub simulate: bool,
    /// For --plan: the folder of a run of `ssct error` on the machines in question, whose costs are taken instead of those
    /// that are part of the program.
    #[arg(long, value_name = "DIR", requires = "plan")]
    pub costs: Option<PathBuf>,
    /// Write records, plots and pictures into a folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}
