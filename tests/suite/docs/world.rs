//! The README's first plot: time and error against the world of every method over those of `ssct`, mirrors and a roughness.

use super::against_world::{Beyond, Point, points};
use std::fmt::Write;
use std::path::Path;

/// Width and height of the picture, and the margins left, top, right and below the plot.
const SIZE: [f64; 2] = [760.0, 400.0];
const MARGIN: [f64; 4] = [70.0, 16.0, 250.0, 50.0];

/// What is shown of the ratios, by their logarithm.
const TIMES: [f64; 2] = [0.03, 4.0];
const ERRORS: [f64; 2] = [0.08, 3.0];

/// The roughness values, of dots and of rings.
const ROUGHNESS: [&str; 2] = ["0.0", "0.1"];

/// Numbers on the axes.
const TICKS: [f64; 7] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0];

/// The colour of a method, by what its rays go on in.
fn color(beyond: Beyond) -> &'static str {
    match beyond {
        Beyond::Nothing => "#3b528b",
        Beyond::Captures => "#d62728",
        Beyond::Triangles => "#1a7f37",
    }
}

fn along(value: f64, [least, most]: [f64; 2]) -> f64 {
    (value / least).ln() / (most / least).ln()
}

fn place(ratios: [f64; 2]) -> [f64; 2] {
    let (width, height) = (SIZE[0] - MARGIN[0] - MARGIN[2], SIZE[1] - MARGIN[1] - MARGIN[3]);
    [MARGIN[0] + width * along(ratios[0], TIMES), MARGIN[1] + height * (1.0 - along(ratios[1], ERRORS))]
}

/// Points that no other beats in both, in the order of their times.
fn front(points: &[Point]) -> Vec<[f64; 2]> {
    let beaten = |p: &[f64; 2]| points.iter().any(|o| o.ratios != *p && o.ratios[0] <= p[0] && o.ratios[1] <= p[1]);
    let mut front: Vec<_> = points.iter().map(|p| p.ratios).filter(|p| !beaten(p)).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    front
}

/// The plot of a folder's records, as SVG.
pub fn plot(folder: &Path) -> Result<String, String> {
    let [mirrors, rough] = [points(folder, ROUGHNESS[0])?, points(folder, ROUGHNESS[1])?];
    let mut svg = String::new();
    let [width, height] = SIZE;
    let mut line = |text: String| {
        let _ = writeln!(svg, "{text}");
    };
    line(format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">"#
    ));
    line(format!(r#"<rect width="{width}" height="{height}" fill="white"/>"#));
    let ([left, bottom], [right, top]) = (place([TIMES[0], ERRORS[0]]), place([TIMES[1], ERRORS[1]]));
    for tick in TICKS.into_iter().filter(|tick| (TIMES[0]..=TIMES[1]).contains(tick)) {
        let [tick_x, _] = place([tick, 1.0]);
        line(format!(r##"<path d="M{tick_x:.1} {top:.1}V{bottom:.1}" stroke="#ddd"/>"##));
        line(format!(r#"<text x="{tick_x:.1}" y="{:.1}" text-anchor="middle">{tick}</text>"#, bottom + 16.0));
    }
    for tick in TICKS.into_iter().filter(|tick| (ERRORS[0]..=ERRORS[1]).contains(tick)) {
        let [_, tick_y] = place([1.0, tick]);
        line(format!(r##"<path d="M{left:.1} {tick_y:.1}H{right:.1}" stroke="#ddd"/>"##));
        line(format!(r#"<text x="{:.1}" y="{:.1}" text-anchor="end">{tick}</text>"#, left - 6.0, tick_y + 4.0));
    }
    let (middle_x, middle_y) = ((left + right) / 2.0, (top + bottom) / 2.0);
    let axis = "time / ssct's";
    line(format!(r#"<text x="{middle_x:.1}" y="{:.1}" text-anchor="middle">{axis}</text>"#, bottom + 38.0));
    let axis = "error against the world / ssct's";
    line(format!(
        r#"<text x="16" y="{middle_y:.1}" text-anchor="middle" transform="rotate(270 16 {middle_y:.1})">{axis}</text>"#
    ));
    for (points, dashes) in [(&mirrors, ""), (&rough, r#" stroke-dasharray="4 3""#)] {
        let path: Vec<String> = front(points).into_iter().map(place).map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        line(format!(r##"<path d="M{}" fill="none" stroke="#999"{dashes}/>"##, path.join("L")));
    }
    // In the order of the mirrors' errors, each name led to its dot.
    let mut order: Vec<_> = mirrors.iter().zip(&rough).collect();
    order.sort_by(|a, b| b.0.ratios[1].total_cmp(&a.0.ratios[1]));
    for (n, (mirror, rough)) in order.into_iter().enumerate() {
        for point in [mirror, rough] {
            let is_inside = |value: f64, [least, most]: [f64; 2]| (least..=most).contains(&value);
            if !is_inside(point.ratios[0], TIMES) || !is_inside(point.ratios[1], ERRORS) {
                return Err(format!("{point:?} lies outside the plot"));
            }
        }
        let color = color(mirror.beyond);
        let ([x, y], [rough_x, rough_y]) = (place(mirror.ratios), place(rough.ratios));
        let (name_x, name_y) = (right + 28.0, top + 30.0 + 20.0 * n as f64);
        line(format!(
            r#"<path d="M{x:.1} {y:.1}L{:.1} {name_y:.1}" stroke="{color}" stroke-opacity="0.3"/>"#,
            name_x - 6.0
        ));
        line(format!(
            r#"<path d="M{x:.1} {y:.1}L{rough_x:.1} {rough_y:.1}" stroke="{color}" stroke-dasharray="1 2"/>"#
        ));
        line(format!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="4" fill="{color}"/>"#));
        line(format!(r#"<circle cx="{rough_x:.1}" cy="{rough_y:.1}" r="4" fill="none" stroke="{color}"/>"#));
        let text = &mirror.name;
        line(format!(r#"<text x="{name_x:.1}" y="{:.1}" fill="{color}">{text}</text>"#, name_y + 4.0));
    }
    let legend = bottom - 14.0;
    let (dot, ring) = (right + 28.0, right + 128.0);
    line(format!(r#"<circle cx="{dot:.1}" cy="{:.1}" r="4"/>"#, legend - 4.0));
    line(format!(r#"<text x="{:.1}" y="{legend:.1}">mirrors</text>"#, dot + 10.0));
    line(format!(r#"<circle cx="{ring:.1}" cy="{:.1}" r="4" fill="none" stroke="black"/>"#, legend - 4.0));
    line(format!(r#"<text x="{:.1}" y="{legend:.1}">roughness 0.1</text>"#, ring + 10.0));
    line("</svg>".to_owned());
    Ok(svg)
}
