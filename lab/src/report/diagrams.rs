//! Diagrams of the thesis, drawn as SVG from images that the passes made.

mod chain;
mod cone;
mod ray;

pub use chain::{Fetches, chain, undersized};
pub use cone::cone;
pub use ray::ray;

use super::svg::Svg;

/// Colours that tell cells and levels apart.
pub(super) const COLORS: [&str; 9] =
    ["#4c78a8", "#f58518", "#54a24b", "#e45756", "#72b7b2", "#b279a2", "#eeca3b", "#9d755d", "#ff9da6"];

/// Returns a depth below 1 as the text of a cell, with three digits behind the point and no 0 before it.
fn depth_text(z: f32) -> String {
    let text = format!("{z:.3}");
    text.strip_prefix('0').unwrap_or(&text).to_owned()
}
