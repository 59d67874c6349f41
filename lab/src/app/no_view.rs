//! `ssct view` in a build without the feature `window`: takes any arguments and says so.

use crate::error::Error;
use clap::Args;
use std::ffi::OsString;

/// Options of `ssct view`, which this build has no use for.
#[derive(Debug, Args)]
pub struct ViewOptions {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _any: Vec<OsString>,
}

/// Fails with a sentence.
pub fn run(_: &ViewOptions) -> anyhow::Result<()> {
    Err(Error::NoWindow("this build of ssct leaves it out; build it with the Cargo feature `window`".into()).into())
}
