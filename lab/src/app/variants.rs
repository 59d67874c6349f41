//! The flags that say which variants of methods are compared, which `ssct error` and `ssct video` share.

use super::parameters::{TypedVariant, parse_variant};
use clap::Args;

/// Which variants of which methods are compared.
#[derive(Debug, Args)]
pub struct VariantOptions {
    /// Methods, such as ssct,hzct; by default all of them
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub method: Vec<String>,
    /// A method with its own options; may be repeated
    ///
    /// An example is "stochastic --history on". Options within the quotes override the same options outside them. Give it once for each
    /// variant that is compared, instead of --method. A folder whose path has blanks stands in quotes of its own:
    /// "'my methods/m' --fade off".
    #[arg(
        long,
        value_name = "METHOD OPTIONS",
        value_parser = parse_variant,
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
