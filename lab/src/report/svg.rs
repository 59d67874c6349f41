//! Drawings as SVG.

use glam::Vec2;
use std::fmt::{Display, Write};

/// A drawing that grows by shapes; lengths are pixels.
pub(super) struct Svg {
    size: Vec2,
    body: String,
}

impl Svg {
    /// Begins an empty drawing of the given width and height.
    pub(super) fn new(size: Vec2) -> Self {
        Self { size, body: String::new() }
    }

    /// Adds a shape, which is the text of an SVG element.
    pub(super) fn add(&mut self, shape: impl Display) {
        // Writing to a string can't fail.
        let _ = writeln!(self.body, "{shape}");
    }

    /// Adds a rectangle with its left upper corner at `corner`; `attributes` are written into the element as they are.
    pub(super) fn rect(&mut self, corner: Vec2, size: Vec2, attributes: &str) {
        self.add(format_args!(
            r#"<rect x="{:.2}" y="{:.2}" width="{:.2}" height="{:.2}" {attributes}/>"#,
            corner.x, corner.y, size.x, size.y
        ));
    }

    /// Adds a line between two points.
    pub(super) fn line(&mut self, start: Vec2, end: Vec2, attributes: &str) {
        self.add(format_args!(
            r#"<line x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}" {attributes}/>"#,
            start.x, start.y, end.x, end.y
        ));
    }

    /// Adds an ellipse with a radius for each axis.
    pub(super) fn circle(&mut self, centre: Vec2, radius: Vec2, attributes: &str) {
        self.add(format_args!(
            r#"<ellipse cx="{:.2}" cy="{:.2}" rx="{:.2}" ry="{:.2}" {attributes}/>"#,
            centre.x, centre.y, radius.x, radius.y
        ));
    }

    /// Adds lines that join points in their order.
    pub(super) fn polyline(&mut self, points: impl Iterator<Item = Vec2>, attributes: &str) {
        let points: Vec<String> = points.map(|p| format!("{:.2},{:.2}", p.x, p.y)).collect();
        self.add(format_args!(r#"<polyline points="{}" {attributes}/>"#, points.join(" ")));
    }

    /// Adds text of a height of `size` pixels that begins at a point on its base line, unless an attribute
    /// `text-anchor` says otherwise.
    pub(super) fn text(&mut self, place: Vec2, size: f32, attributes: &str, text: &str) {
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.add(format_args!(
            r#"<text x="{:.2}" y="{:.2}" font-size="{size}" {attributes}>{text}</text>"#,
            place.x, place.y
        ));
    }

    /// Returns the drawing on white as the text of an SVG file.
    pub(super) fn finish(self) -> String {
        let [w, h] = self.size.to_array();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w:.0}\" height=\"{h:.0}\" viewBox=\"0 0 {w:.0} {h:.0}\" \
             font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        )
    }
}
