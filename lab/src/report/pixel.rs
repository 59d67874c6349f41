//! Explains one pixel as text that fits a screen.

use super::tables::wrapped;
use crate::study::names::count_text;
use crate::study::pixel::{LastCell, PixelReport, WalkReport, WorldEnd};

/// Columns before a line's text.
const INDENT: usize = 12;

/// Returns the report of a pixel as text: sentences that explain its verdict, and then its data line by line.
pub fn text(report: &PixelReport) -> String {
    let [x, y] = report.pixel;
    let mut text = format!("pixel {x}, {y} of {}: {}\n", report.method, report.verdict.name());
    text.extend(report.why.iter().map(|sentence| wrapped("", 0, sentence)));
    text.push('\n');
    text.extend(lines(report).iter().map(|(name, content)| wrapped(name, INDENT, content)));
    text
}

/// Returns the data of a pixel as lines, each with its name and its text.
pub fn lines(report: &PixelReport) -> Vec<(&'static str, String)> {
    let mut lines = vec![("surface", surface_text(report)), ("lit", color_text(&report.colors.lit))];
    if report.surface.reflects {
        lines.extend(reflection_lines(report));
    }
    lines.push(("image", image_text(report)));
    if let Some(end) = &report.method_end {
        let pixel = where_seen(end.pixel);
        let capture = end.capture.map(|k| format!(", number {k}")).unwrap_or_default();
        let place =
            end.place_m.map(|p| format!(", {} m in the world", point_text(p.map(f64::from)))).unwrap_or_default();
        lines.push(("method", format!("{}{capture}{pixel}{place} (path {})", end.end, end.path)));
    } else if report.surface.reflects {
        lines.push(("method", "does not tell where its rays end".to_owned()));
    }
    if let Some(end) = &report.oracle_end {
        let pixel = where_seen(end.pixel);
        let looked_at = count_text(end.pixels as usize, "pixel");
        lines.push(("oracle", format!("{}{pixel}, after {looked_at} (version {})", end.end, end.version)));
    }
    lines.extend(report.world_end.as_ref().map(|end| ("world", world_text(end))));
    match &report.walk {
        Some(walk) => lines.extend([
            ("walk", walk_text(walk)),
            ("last cell", walk.last.as_ref().map_or_else(|| "none".to_owned(), cell_text)),
        ]),
        None if report.surface.reflects => {
            lines.push(("walk", "no walk over the Hi-Z that a twin could follow".to_owned()))
        }
        None => {}
    }
    lines
}

/// The surface that the pixel shows.
fn surface_text(report: &PixelReport) -> String {
    let surface = &report.surface;
    let (Some(mesh), Some(z)) = (&surface.mesh, surface.view_z_m) else { return "sky".to_owned() };
    let (reflectivity, roughness) = (surface.reflectivity, surface.roughness);
    format!("{mesh}, {z:.2} m of view depth, reflectivity {reflectivity:.3}, roughness {roughness:.3}")
}

/// Returns lines on the reflection: that of the method, and that of each reference with the method's difference from
/// it.
fn reflection_lines(report: &PixelReport) -> Vec<(&'static str, String)> {
    let colors = &report.colors;
    let mut lines = vec![("reflection", format!("{}, fade {:.3}", color_text(&colors.reflection), colors.fade))];
    for (name, reference) in [("by screen", &colors.screen), ("by world", &colors.world)] {
        lines.extend(reference.as_ref().map(|found| {
            let error = found.standard_error.into_iter().fold(0.0, f32::max);
            let difference = 100.0 * found.difference;
            (
                name,
                format!(
                    "{} ± {error:.4} ({} rays); the method is off by {difference:.0} % of white",
                    color_text(&found.color),
                    found.rays
                ),
            )
        }));
    }
    lines
}

/// Returns the image's colour as text, with the numbers by which it was mixed, and as the bytes of a PNG.
fn image_text(report: &PixelReport) -> String {
    let colors = &report.colors;
    let [r, g, b] = colors.display;
    let mixed = if report.surface.reflects {
        format!(" = lit + {:.3} · {:.3} · reflection", colors.reflectivity, colors.fade)
    } else {
        " = lit".to_owned()
    };
    format!("{}{mixed}; in a PNG {r} {g} {b}", color_text(&colors.image))
}

/// The end of the pixel's ray among the triangles, and whether the screen shows it.
fn world_text(end: &WorldEnd) -> String {
    let (Some(mesh), Some(place), Some(length)) = (&end.mesh, end.place_m, end.length_m) else {
        return "the sky".into();
    };
    let shown = if end.shown { "shown" } else { "not shown" };
    let pixel = end.pixel.map_or_else(|| "behind the eye".to_owned(), |[x, y]| format!("at {x:.1}, {y:.1}"));
    format!("{mesh}, {length:.2} m away, {} m, {shown} {pixel}", point_text(place))
}

/// The pixel in which a place is seen, as a part of a line; empty if the screen does not show the place.
fn where_seen(pixel: Option<[impl std::fmt::Display; 2]>) -> String {
    pixel.map(|[x, y]| format!(", at {x:.1}, {y:.1}")).unwrap_or_default()
}

/// How many steps the walk took, and how it ended.
fn walk_text(walk: &WalkReport) -> String {
    format!("{}; it {}", count_text(walk.steps, "step"), walk.end)
}

/// The last cell at which the walk looked: its level and place, its nearest depth, and the depth of the ray.
fn cell_text(last: &LastCell) -> String {
    let [column, row] = last.cell;
    let met = if last.crossed { "left" } else { "met" };
    let (level, nearest, ray) = (last.level, last.nearest, last.ray);
    format!("level {level}, cell {column}, {row}: nearest {nearest:.6}, ray {ray:.6}; the ray {met} it")
}

/// Returns a linear colour as text: red, green and blue.
fn color_text(color: &[f32; 3]) -> String {
    color.map(|v| format!("{v:.4}")).join(" ")
}

/// Returns the coordinates of a point in metres as text.
fn point_text(place: [f64; 3]) -> String {
    place.map(|v| format!("{v:.2}")).join(", ")
}
