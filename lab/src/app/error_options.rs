//! The options of `ssct error`, and those that it shares with `ssct video`. What they mean together is decided in `error`
//! and in `resolve`.

use super::cli::{CommonOptions, RunOptions, ShardOptions, size};
use super::parameters::{TypedVariant, typed_variant};
use clap::Args;
use std::path::PathBuf;

/// Which variants of which methods are compared.
#[derive(Debug, Args)]
pub struct VariantOptions {
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// A method with its own options; may be repeated
    ///
    /// Its options count before those outside: "stochastic --history on". Give it once for each variant that is compared,
    /// instead of --method.
    #[arg(
        long,
        value_name = "METHOD OPTIONS",
        value_parser = typed_variant,
        conflicts_with_all = ["method", "captures_sweep", "fallback_sweep"]
    )]
    pub variant: Vec<TypedVariant>,
    /// Compare numbers and sizes of captures
    ///
    /// A method that takes captures is compared without them and with 1, 2, 4 and 8 captures of 128 to 1024 texels a side.
    /// Any other method is run once, as the options set it up.
    #[arg(long)]
    pub captures_sweep: bool,
    /// Compare what shows behind screen-space methods
    ///
    /// A screen-space method is compared with nothing, with the environment and with pccm behind it, and unified also with
    /// the captures that the options name. Any other method is run once, as the options set it up.
    #[arg(long, conflicts_with_all = ["captures_sweep", "fallback"])]
    pub fallback_sweep: bool,
    /// Compare numbers of bounces, up to --bounces
    ///
    /// A screen-space method is compared with one bounce, with two, and so on up to --bounces, all of them against light
    /// that is reflected as often as with the most bounces. Any other method is run once, as the options set it up.
    #[arg(long, requires = "bounces", conflicts_with_all = ["captures_sweep", "fallback_sweep"])]
    pub bounces_sweep: bool,
}

/// Options of `ssct error`.
#[derive(Debug, Args)]
pub struct ErrorOptions {
    #[command(flatten)]
    pub common: CommonOptions,
    #[command(flatten)]
    pub variants: VariantOptions,
    /// Widths and heights in pixels; by default 480x270
    ///
    /// With --quick, the default is 320x180.
    #[arg(long, value_name = "WxH", value_parser = size, value_delimiter = ',')]
    pub size: Vec<[u32; 2]>,
    /// Two views, two roughness values, no sweep
    #[arg(long, conflicts_with_all = ["captures_sweep", "fallback_sweep", "bounces_sweep"])]
    pub quick: bool,
    /// Compare methods only as the options set them up
    ///
    /// Without it, both presets and the values of their parameters are compared.
    #[arg(long, conflicts_with_all = ["variant", "captures_sweep", "fallback_sweep", "bounces_sweep"])]
    pub no_sweep: bool,
    /// Frames that are timed for each variant
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub samples: usize,
    /// Rays a pixel of the references
    ///
    /// The screen reference and the world reference trace as many.
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub rays: u32,
    #[command(flatten)]
    pub shard: ShardOptions,
    /// Folder for records, plots and pictures
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunOptions,
}
