//! Diagrams of the thesis, drawn as SVG from what the passes really made.

mod chain;
mod cone;
mod ray;

pub use chain::{Fetches, chain, undersized};
pub use cone::cone;
pub use ray::ray;

use glam::Vec2;
use std::fmt::{Display, Write};

/// Colours that tell cells and levels apart.
pub(super) const COLORS: [&str; 9] =
    ["#4c78a8", "#f58518", "#54a24b", "#e45756", "#72b7b2", "#b279a2", "#eeca3b", "#9d755d", "#ff9da6"];

/// A drawing that grows by shapes; lengths are pixels.
pub(super) struct Svg {
    size: Vec2,
    body: String,
}

impl Svg {
    pub(super) fn new(size: Vec2) -> Self {
        Self { size, body: String::new() }
    }

    /// Writing to a string can't fail.
    fn add(&mut self, shape: impl Display) {
        let _ = writeln!(self.body, "{shape}");
    }

    /// A rectangle with attributes of its own.
    pub(super) fn rect(&mut self, at: Vec2, size: Vec2, attributes: &str) {
        self.add(format_args!(
            r#"<rect x="{:.2}" y="{:.2}" width="{:.2}" height="{:.2}" {attributes}/>"#,
            at.x, at.y, size.x, size.y
        ));
    }

    pub(super) fn line(&mut self, a: Vec2, b: Vec2, attributes: &str) {
        self.add(format_args!(
            r#"<line x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" {attributes}/>"#,
            a.x, a.y, b.x, b.y
        ));
    }

    pub(super) fn circle(&mut self, at: Vec2, radius: Vec2, attributes: &str) {
        self.add(format_args!(
            r#"<ellipse cx="{:.2}" cy="{:.2}" rx="{:.2}" ry="{:.2}" {attributes}/>"#,
            at.x, at.y, radius.x, radius.y
        ));
    }

    fn polyline(&mut self, points: impl Iterator<Item = Vec2>, attributes: &str) {
        let points: Vec<String> = points.map(|p| format!("{:.2},{:.2}", p.x, p.y)).collect();
        self.add(format_args!(r#"<polyline points="{}" {attributes}/>"#, points.join(" ")));
    }

    /// Text at the left of a point on its base line, unless an anchor says otherwise.
    pub(super) fn text(&mut self, at: Vec2, size: f32, attributes: &str, text: &str) {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.add(format_args!(
            r#"<text x="{:.2}" y="{:.2}" font-size="{size}" {attributes}>{text}</text>"#,
            at.x, at.y
        ));
    }

    pub(super) fn finish(self) -> String {
        let [w, h] = self.size.to_array();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w:.0}\" height=\"{h:.0}\" viewBox=\"0 0 {w:.0} {h:.0}\" \
             font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// A depth below 1 as it stands in a cell: three digits.
fn depth_text(z: f32) -> String {
    let text = format!("{z:.3}");
    text.strip_prefix('0').unwrap_or(&text).to_owned()
}
