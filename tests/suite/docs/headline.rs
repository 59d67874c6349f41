//! The plot beside the README's table: time and error of `unified` and `hzct` over those of `ssct`, a dot for each view
//! and roughness. Drawn by hand, as it has two axes and dots alone.

use super::figures::ROUGHNESS;
use super::records::{bars_errors, bars_times};
use std::fmt::Write;
use std::path::Path;

/// Width and height of the picture, and the margins left, top, right and below the plot.
const SIZE: [f64; 2] = [720.0, 400.0];
const MARGIN: [f64; 4] = [70.0, 16.0, 170.0, 50.0];

/// What is shown of the ratios of times, evenly, and of errors, by their logarithm.
const TIMES: [f64; 2] = [0.2, 1.1];
const ERRORS: [f64; 2] = [0.0005, 3.0];

/// A colour for each roughness, from mirrors to rough.
const COLORS: [&str; 5] = ["#000000", "#3b528b", "#21918c", "#5ec962", "#e8b000"];

fn x(time: f64) -> f64 {
    let width = SIZE[0] - MARGIN[0] - MARGIN[2];
    MARGIN[0] + width * (time - TIMES[0]) / (TIMES[1] - TIMES[0])
}

fn y(error: f64) -> f64 {
    let height = SIZE[1] - MARGIN[1] - MARGIN[3];
    let [low, high] = ERRORS.map(f64::ln);
    MARGIN[1] + height * (high - error.clamp(ERRORS[0], ERRORS[1]).ln()) / (high - low)
}

/// The plot of the records of `scripts/bars.sh`, as SVG: times of one folder, and errors of the other.
pub fn plot(timed: &Path, judged: &Path) -> Result<String, String> {
    let (times, errors) = (bars_times(timed, "960x540")?, bars_errors(judged)?);
    let mut svg = String::new();
    let [width, height] = SIZE;
    let mut line = |text: String| {
        let _ = writeln!(svg, "{text}");
    };
    line(format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">"#
    ));
    line(format!(r#"<rect width="{width}" height="{height}" fill="white"/>"#));
    let [left, right] = TIMES.map(x);
    let [bottom, top] = ERRORS.map(y);
    for tick in [0.2, 0.4, 0.6, 0.8, 1.0] {
        let tick_x = x(tick);
        line(format!(r##"<path d="M{tick_x:.1} {top:.1}V{bottom:.1}" stroke="#ddd"/>"##));
        line(format!(r#"<text x="{tick_x:.1}" y="{:.1}" text-anchor="middle">{tick}</text>"#, bottom + 16.0));
    }
    for tick in [0.001, 0.01, 0.1, 1.0] {
        let tick_y = y(tick);
        line(format!(r##"<path d="M{left:.1} {tick_y:.1}H{right:.1}" stroke="#ddd"/>"##));
        line(format!(r#"<text x="{:.1}" y="{:.1}" text-anchor="end">{tick}</text>"#, left - 6.0, tick_y + 4.0));
    }
    line(format!(
        r#"<text x="{:.1}" y="{:.1}" text-anchor="middle">time / ssct's</text>"#,
        (left + right) / 2.0,
        bottom + 38.0
    ));
    let middle = (top + bottom) / 2.0;
    line(format!(
        r#"<text x="16" y="{middle:.1}" text-anchor="middle" transform="rotate(270 16 {middle:.1})">error / ssct's</text>"#
    ));
    for method in ["hzct", "unified"] {
        for (roughness, color) in ROUGHNESS.iter().zip(COLORS) {
            for (cell, times) in times.iter().filter(|((.., r), _)| r == roughness) {
                let time = |m: &str| times.get(m).copied().ok_or_else(|| format!("no time of {m}"));
                let error = |m: &str| {
                    let key = (m.to_owned(), "screen".to_owned());
                    errors.get(cell).and_then(|e| e.get(&key)).copied().ok_or_else(|| format!("no error of {m}"))
                };
                let (time, error) = (time(method)? / time("ssct")?, error(method)? / error("ssct")?);
                if !(TIMES[0]..=TIMES[1]).contains(&time) || error > ERRORS[1] {
                    return Err(format!("{cell:?}: {method} at {time:.2}, {error:.3} lies outside the plot"));
                }
                line(dot(method, x(time), y(error), color));
            }
        }
    }
    let (one_x, one_y) = (x(1.0), y(1.0));
    line(format!(
        r#"<path d="M{:.1} {one_y:.1}h12M{one_x:.1} {:.1}v12" stroke="red" stroke-width="3"/>"#,
        one_x - 6.0,
        one_y - 6.0
    ));
    let legend = right + 20.0;
    line(format!(r#"<path d="M{:.1} 26h12M{legend:.1} 20v12" stroke="red" stroke-width="3"/>"#, legend - 6.0));
    line(format!(r#"<text x="{:.1}" y="30">ssct</text>"#, legend + 12.0));
    line(dot("hzct", legend, 48.0, COLORS[1]));
    line(format!(r#"<text x="{:.1}" y="52">hzct</text>"#, legend + 12.0));
    line(dot("unified", legend, 70.0, COLORS[1]));
    line(format!(r#"<text x="{:.1}" y="74">unified</text>"#, legend + 12.0));
    line(format!(r#"<text x="{:.1}" y="104">roughness</text>"#, legend - 6.0));
    for (n, (roughness, color)) in ROUGHNESS.iter().zip(COLORS).enumerate() {
        let row_y = 122.0 + 20.0 * n as f64;
        line(dot("unified", legend, row_y, color));
        line(format!(
            r#"<text x="{:.1}" y="{:.1}">{}</text>"#,
            legend + 12.0,
            row_y + 4.0,
            roughness.trim_end_matches(".0")
        ));
    }
    line("</svg>".to_owned());
    Ok(svg)
}

/// A filled dot of `unified`, or a ring.
fn dot(method: &str, x: f64, y: f64, color: &str) -> String {
    let style =
        if method == "unified" { format!(r#"fill="{color}""#) } else { format!(r#"fill="none" stroke="{color}""#) };
    format!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="3.5" {style}/>"#)
}
