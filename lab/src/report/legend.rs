//! Legends that stand beside pictures as SVG.

use super::diagrams::Svg;
use super::images::Color;
use glam::Vec2;

const ROW: f32 = 22.0;
const MARGIN: f32 = 12.0;
const TEXT: f32 = 13.0;
/// Pixels of a text's width for each of its characters: more than any font takes.
const CHARACTER: f32 = 7.5;
const EDGE: &str = r##"stroke="#888""##;

/// The legend of a picture: for each colour what it means, and how many pixels have it.
pub fn legend(picture: &str, entries: &[(Color, &str, usize)]) -> String {
    let all: usize = entries.iter().map(|(.., count)| count).sum();
    let line = |(_, said, count): &(Color, &str, usize)| {
        let share = if all == 0 { 0.0 } else { 100.0 * *count as f64 / all as f64 };
        format!("{said}, {count} pixel{}, {share:.1} %", if *count == 1 { "" } else { "s" })
    };
    let lines: Vec<String> = entries.iter().map(line).collect();
    let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0).max(picture.len());
    let width = 2.0 * MARGIN + ROW + CHARACTER * longest as f32;
    let mut svg = Svg::new(Vec2::new(width, 2.0 * MARGIN + ROW * (lines.len() + 1) as f32));
    svg.text(Vec2::new(MARGIN, MARGIN + TEXT), TEXT, r#"font-weight="bold""#, picture);
    for (n, ((color, ..), line)) in entries.iter().zip(&lines).enumerate() {
        let top = MARGIN + ROW * (n + 1) as f32;
        svg.rect(Vec2::new(MARGIN, top), Vec2::splat(TEXT), &format!(r#"fill="{}" {EDGE}"#, hex(*color)));
        svg.text(Vec2::new(MARGIN + ROW, top + TEXT - 2.0), TEXT, "", line);
    }
    svg.finish()
}

fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
