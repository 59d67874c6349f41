//! Legends and scales that stand beside pictures as SVG.

use super::images::Color;
use super::svg::Svg;
use crate::study::names::count_text;
use glam::Vec2;
use ssct_ground::math::display_byte;

/// Height of a row in pixels.
const ROW: f32 = 22.0;
/// Width in pixels of the border around the drawing.
const MARGIN: f32 = 12.0;
/// Height of text in pixels.
const TEXT: f32 = 13.0;
/// Width in pixels that a text gets for each of its characters: more than any font takes.
const CHARACTER: f32 = 7.5;
/// The SVG attribute of the edge of a colour's square.
const EDGE: &str = r##"stroke="#888""##;

/// Returns the legend of a picture as SVG. Each entry is a colour, its meaning, and how many pixels have it.
pub fn legend(picture: &str, entries: &[(Color, &str, usize)]) -> String {
    let total: usize = entries.iter().map(|(.., count)| count).sum();
    let line = |(_, meaning, count): &(Color, &str, usize)| {
        let percent = if total == 0 { 0.0 } else { 100.0 * *count as f64 / total as f64 };
        format!("{meaning}, {}, {percent:.1} %", count_text(*count, "pixel"))
    };
    let lines: Vec<String> = entries.iter().map(line).collect();
    let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0).max(picture.len());
    let width = 2.0 * MARGIN + ROW + CHARACTER * longest as f32;
    let mut svg = Svg::new(Vec2::new(width, 2.0 * MARGIN + ROW * (lines.len() + 1) as f32));
    svg.text(Vec2::new(MARGIN, MARGIN + TEXT), TEXT, r#"font-weight="bold""#, picture);
    for (n, ((color, ..), line)) in entries.iter().zip(&lines).enumerate() {
        // The name of the picture has the first row.
        let top = MARGIN + ROW * (n + 1) as f32;
        svg.rect(Vec2::new(MARGIN, top), Vec2::splat(TEXT), &format!(r#"fill="{}" {EDGE}"#, hex(*color)));
        svg.text(Vec2::new(MARGIN + ROW, top + TEXT - 2.0), TEXT, "", line);
    }
    svg.finish()
}

/// Returns the scale, as SVG, of a picture whose greys are numbers from 0 to 1, encoded as sRGB; `what` names the
/// numbers. A mark shows the greatest number of the picture, and a text below has this number as `shown`.
pub fn scale(picture: &str, what: &str, (greatest, shown): (f32, &str)) -> String {
    const STEPS: u16 = 100;
    const STEP: f32 = 4.0;
    let left = 2.0 * MARGIN;
    // The last label reaches beyond the greys.
    let mut svg = Svg::new(Vec2::new(3.0 * left + STEP * f32::from(STEPS), 5.0 * ROW + MARGIN));
    svg.text(Vec2::new(left, MARGIN + TEXT), TEXT, r#"font-weight="bold""#, &format!("{picture}: {what}"));
    let top = 2.0 * ROW;
    for step in 0..STEPS {
        let grey = [display_byte((f32::from(step) + 0.5) / f32::from(STEPS)); 3];
        let corner = Vec2::new(left + STEP * f32::from(step), top);
        svg.rect(corner, Vec2::new(STEP, ROW), &format!(r#"fill="{}""#, hex(grey)));
    }
    for tick in [0.0, 0.1, 0.25, 0.5, 0.75, 1.0] {
        let label = if tick < 1.0 { tick.to_string() } else { "1 or more".to_owned() };
        let middle = Vec2::new(left + STEP * f32::from(STEPS) * tick, top + ROW + TEXT + 2.0);
        svg.text(middle, TEXT, r#"text-anchor="middle""#, &label);
    }
    let mark = left + STEP * f32::from(STEPS) * greatest.clamp(0.0, 1.0);
    svg.line(Vec2::new(mark, top - 4.0), Vec2::new(mark, top + ROW), r##"stroke="#e33" stroke-width="2""##);
    let line = format!("red: the greatest, {shown}");
    svg.text(Vec2::new(left, top + 2.0 * ROW + TEXT), TEXT, r##"fill="#c00""##, &line);
    svg.finish()
}

/// Returns a colour as SVG writes it, such as `#ee3333`.
fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
