//! Progress on standard error, and only on a terminal.

use super::run::go_on;
use crate::error::Result;
use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `length` steps; silent where standard error is no terminal.
pub fn bar(what: &str, length: usize) -> ProgressBar {
    let bar = ProgressBar::new(length as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// One step further, unless a signal asked to stop.
pub fn step(bar: &ProgressBar) -> Result<()> {
    bar.inc(1);
    go_on()
}
