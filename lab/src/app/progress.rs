//! Progress on standard error: a bar on a terminal.

use super::run::go_on;
use crate::error::Result;
use indicatif::{ProgressBar, ProgressStyle};

/// Makes a bar over `length` steps, with the label `what`. It is hidden where standard error is no terminal.
pub fn bar(what: &str, length: usize) -> ProgressBar {
    let bar = ProgressBar::new(length as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// Says which part of a long command begins: on the bar, and as a line where standard error is no terminal.
pub fn part(bar: &ProgressBar, what: &str) {
    if bar.is_hidden() {
        eprintln!("ssct: {what}");
    }
    bar.set_message(what.to_owned());
}

/// Advances the bar by one step; fails if a signal asked to stop.
pub fn step(bar: &ProgressBar) -> Result<()> {
    bar.inc(1);
    go_on()
}
