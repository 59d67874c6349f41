//! Plots as SVG.

use crate::study::engine::Row;
use crate::study::exhibit::{Chart, Drawing, Line, NamedPoint, StageBar, distinct};
use crate::study::library::trends::TrendLine;
use crate::study::names::{is_unsafe_in_lines, with_replacements};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Colours of the stages, in the order in which they first appear.
pub(super) const STAGE_COLORS: [RGBColor; 10] = [
    RGBColor(0x4c, 0x78, 0xa8),
    RGBColor(0x72, 0xb7, 0xb2),
    RGBColor(0x54, 0xa2, 0x4b),
    RGBColor(0xee, 0xca, 0x3b),
    RGBColor(0xe4, 0x57, 0x56),
    RGBColor(0xb2, 0x79, 0xa2),
    RGBColor(0x9d, 0x75, 0x5d),
    RGBColor(0xba, 0xb0, 0xac),
    RGBColor(0xf5, 0x85, 0x18),
    RGBColor(0xff, 0x9d, 0xa6),
];

/// Width of a plot in pixels: small enough that its text can still be read on a phone.
pub(super) const WIDTH: u32 = 640;
/// Size of a plot's text in pixels.
pub(super) const TEXT: u32 = 14;

/// A chart with its drawing.
#[derive(Debug, Clone)]
pub struct DrawnChart {
    /// The chart.
    pub chart: Chart,
    /// The drawing, as SVG.
    pub svg: String,
}

/// Draws the charts of rows that one device measured.
pub fn draw_charts<R: Row>(rows: &[R]) -> Result<Vec<DrawnChart>, String> {
    let draw = |chart: Chart| Ok(DrawnChart { svg: draw(&chart.drawing)?, chart });
    R::charts(rows).into_iter().map(draw).collect()
}

/// Draws the values of a chart as SVG.
pub fn draw(drawing: &Drawing) -> Result<String, String> {
    let svg = match drawing {
        Drawing::Lines([x, y], lines) => draw_lines(lines, [x, y]),
        Drawing::Points([x, y], points) => draw_cost_against_error(points, [x, y]),
        Drawing::Bars(bars) => draw_stage_bars(bars),
    };
    svg.map(|svg| with_replacements(&svg, is_unsafe_in_lines).into_owned())
}

/// Draws stacked bars as SVG, one for each record: the median of each stage of the effect, in milliseconds.
fn draw_stage_bars(records: &[StageBar]) -> Result<String, String> {
    let stages: Vec<String> = distinct(records.iter().flat_map(|r| &r.stages).map(|(name, _)| name.clone()));
    let most = records.iter().map(|r| r.stages.iter().map(|(_, ms)| ms).sum::<f64>()).fold(1e-6, f64::max);
    let legend = legend_height(&stages);
    // A row is a line of text and its bar.
    let row_height = 40;
    let height = legend + row_height * records.len().max(1) as u32 + 60;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        let failed = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
        root.fill(&WHITE).map_err(failed)?;
        let rows = records.len().max(1) as f64;
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .margin_top(legend)
            .margin_right(24)
            .x_label_area_size(50)
            .build_cartesian_2d(0.0..most * 1.02, rows..0.0)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc("milliseconds (medians; the scene passes are not counted)")
            .x_label_style(("sans-serif", TEXT))
            .y_labels(0)
            .draw()
            .map_err(failed)?;
        for (row, record) in records.iter().enumerate() {
            let (y, mut x) = (row as f64, 0.0);
            let (left, top) = chart.backend_coord(&(0.0, y));
            root.draw(&Text::new(record.label.clone(), (left + 2, top + 4), ("sans-serif", TEXT))).map_err(failed)?;
            for (name, ms) in &record.stages {
                let bar = Rectangle::new([(x, y + 0.5), (x + ms, y + 0.95)], stage_color(&stages, name).filled());
                chart.draw_series([bar]).map_err(failed)?;
                x += ms;
            }
        }
        for (i, name) in stages.iter().enumerate() {
            draw_legend_entry(&root, legend_place(i), name, stage_color(&stages, name)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

/// Returns the colour of the stage `name`, which depends on its place among all stages.
fn stage_color(stages: &[String], name: &str) -> RGBColor {
    series_color(stages.iter().position(|s| s == name).unwrap_or(0))
}

/// Returns the colour of the line or stage with an index among all of them.
fn series_color(index: usize) -> RGBColor {
    let RGBColor(r, g, b) = STAGE_COLORS[index % STAGE_COLORS.len()];
    // All methods together have more stages than there are colours that can be told apart. So dark shades of the
    // colours come after the colours, and then light shades.
    let shade = |v: u8| match index / STAGE_COLORS.len() {
        0 => v,
        1 => (u16::from(v) * 11 / 20) as u8,
        _ => 255 - (255 - v) / 2,
    };
    RGBColor(shade(r), shade(g), shade(b))
}

/// Number of names in a line of the legend.
const LEGEND_COLUMNS: usize = 5;

/// The place in pixels of the entry with an index in a legend of stages: the left upper corner of its square.
fn legend_place(index: usize) -> (i32, i32) {
    (12 + 124 * (index % LEGEND_COLUMNS) as i32, 10 + 20 * (index / LEGEND_COLUMNS) as i32)
}

/// The height in pixels of a legend of stages.
fn legend_height(stages: &[String]) -> u32 {
    20 + 20 * stages.len().div_ceil(LEGEND_COLUMNS) as u32
}

/// The least and the greatest value that an axis shows.
struct AxisBounds {
    least: f64,
    most: f64,
}

/// Draws cost (x) against error (y) on log axes with the names `axes`. Every point has a name, and the Pareto front is
/// connected. A log axis has no 0, so a point of error 0 is drawn at the axis's foot, at a tick that says 0.
fn draw_cost_against_error(points: &[NamedPoint], axes: [&str; 2]) -> Result<String, String> {
    // An axis shows a third more on both sides than the values above 0 need.
    let bounds = |values: &dyn Fn(&NamedPoint) -> f64| {
        let above_zero = points.iter().map(values).filter(|v| *v > 0.0);
        let (least, most) = above_zero.fold((f64::INFINITY, 0.0_f64), |(l, m), v| (l.min(v), m.max(v)));
        if least <= most {
            AxisBounds { least: least / 1.3, most: most * 1.3 }
        } else {
            AxisBounds { least: 0.1, most: 1.0 }
        }
    };
    let (x, mut y) = (bounds(&|p| p.position[0]), bounds(&|p| p.position[1]));
    let least_tick = y.least;
    let has_zeros = points.iter().any(|p| p.position[1] <= 0.0);
    if has_zeros {
        // The axis grows at its foot by 12 % of its length, for the tick that says 0.
        y.least /= (y.most / y.least).powf(0.12);
    }
    // Names stand in a column of their own, as wide as the longest needs.
    let longest = points.iter().map(|p| p.name.chars().count()).max().unwrap_or(0);
    let name_width = 40 + 8 * longest as i32;
    let plot_width = (WIDTH as i32 - name_width).max(480);
    let width = plot_width + name_width;
    let height = (points.len() as i32 * 17 + 90).max(400);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width as u32, height as u32)).into_drawing_area();
        let failed = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
        root.fill(&WHITE).map_err(failed)?;
        let (left, _names) = root.split_horizontally(plot_width);
        let mut chart = ChartBuilder::on(&left)
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(x.least.log10()..x.most.log10(), y.least.log10()..y.most.log10())
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(0)
            .y_labels(0)
            .x_desc(axes[0])
            .y_desc(axes[1])
            .axis_desc_style(("sans-serif", TEXT))
            .draw()
            .map_err(failed)?;
        let grid = STAGE_COLORS[7].mix(0.35);
        // Ticks of the x axis, each with a line over the height of the plot.
        for tick in log_ticks(x.least, x.most) {
            let (low, high) = (
                chart.backend_coord(&(tick.log10(), y.least.log10())),
                chart.backend_coord(&(tick.log10(), y.most.log10())),
            );
            root.draw(&PathElement::new([low, high], grid)).map_err(failed)?;
            let style = TextStyle::from(("sans-serif", TEXT)).pos(Pos::new(HPos::Center, VPos::Top));
            root.draw(&Text::new(format!("{tick}"), (low.0, low.1 + 5), style)).map_err(failed)?;
        }
        // Ticks of the y axis, each with a line over the width of the plot, and the tick that says 0.
        let zero_tick = has_zeros.then_some((y.least, "0".to_owned()));
        let labelled = |tick| (tick, if tick < 1e-3 { format!("{tick:e}") } else { format!("{tick}") });
        for (tick, label) in log_ticks(least_tick, y.most).into_iter().map(labelled).chain(zero_tick) {
            let (line_start, line_end) = (
                chart.backend_coord(&(x.least.log10(), tick.log10())),
                chart.backend_coord(&(x.most.log10(), tick.log10())),
            );
            root.draw(&PathElement::new([line_start, line_end], grid)).map_err(failed)?;
            let style = TextStyle::from(("sans-serif", TEXT)).pos(Pos::new(HPos::Right, VPos::Center));
            root.draw(&Text::new(label, (line_start.0 - 8, line_start.1), style)).map_err(failed)?;
        }
        let place = |p: &NamedPoint| (p.position[0].log10(), p.position[1].max(y.least).log10());
        let mut front: Vec<_> = points.iter().filter(|p| p.on_front).map(place).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.draw_series(LineSeries::new(front, STAGE_COLORS[4].stroke_width(2))).map_err(failed)?;
        let color = |p: &NamedPoint| if p.on_front { STAGE_COLORS[4] } else { STAGE_COLORS[0] };
        chart.draw_series(points.iter().map(|p| Circle::new(place(p), 4, color(p).filled()))).map_err(failed)?;

        // The names are in the order of the errors, and a line leads from each name to its point.
        let mut order: Vec<&NamedPoint> = points.iter().collect();
        order.sort_by(|a, b| b.position[1].total_cmp(&a.position[1]));
        for (row, p) in order.into_iter().enumerate() {
            let pixel = chart.backend_coord(&place(p));
            let name = (plot_width + 24, 30 + row as i32 * 17);
            let line = [pixel, (name.0 - 4, name.1 + 6)];
            root.draw(&PathElement::new(line, STAGE_COLORS[7].mix(0.6))).map_err(failed)?;
            let style = ("sans-serif", TEXT).into_font().color(&color(p));
            root.draw(&Text::new(p.name.clone(), name, style)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

/// Returns the ticks of a log axis from `least` to `most`: 1, 2 and 5 times powers of ten, or finer steps if fewer than
/// three of these lie inside.
fn log_ticks(least: f64, most: f64) -> Vec<f64> {
    // The products of the steps and powers of ten that lie inside the bounds.
    let inside = |steps: &[f64]| -> Vec<f64> {
        let powers = least.log10().floor() as i32..=most.log10().ceil() as i32;
        // Each product is written as text and read back, so that 3 · 10⁻² is exactly 0.03 and is printed so.
        let tick = |step: &f64, power: i32| format!("{step}e{power}").parse().unwrap_or(f64::NAN);
        powers.flat_map(|p| steps.iter().map(move |s| tick(s, p))).filter(|t| (least..=most).contains(t)).collect()
    };
    let coarse = inside(&[1.0, 2.0, 5.0]);
    if coarse.len() >= 3 { coarse } else { inside(&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]) }
}

/// Most ticks of an axis of frames.
const MOST_FRAME_TICKS: usize = 11;

/// Draws values over frames, from 0 up, with a line for each of `lines` and the given names of the axes.
fn draw_lines(lines: &[Line], [x_axis, y_axis]: [&str; 2]) -> Result<String, String> {
    let names: Vec<&str> = lines.iter().map(|l| l.name.as_str()).collect();
    let legend = line_legend_height(&names);
    let points = || lines.iter().flat_map(|l| &l.points);
    let last = points().map(|(frame, _)| *frame).fold(1.0, f64::max);
    let most = points().map(|(_, value)| *value).fold(1e-6, f64::max);
    // Frames are whole numbers, and with no more ticks than frames each tick stands at one of them.
    let most_ticks = (last as usize).saturating_add(1).min(MOST_FRAME_TICKS);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, 360 + legend)).into_drawing_area();
        let failed = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
        root.fill(&WHITE).map_err(failed)?;
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .margin_top(legend)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..last, 0.0..most * 1.05)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_labels(most_ticks)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .x_desc(x_axis)
            .y_desc(y_axis)
            .label_style(("sans-serif", TEXT))
            .draw()
            .map_err(failed)?;
        for (n, line) in lines.iter().enumerate() {
            let color = STAGE_COLORS[n % STAGE_COLORS.len()];
            chart.draw_series(LineSeries::new(line.points.iter().copied(), color.stroke_width(2))).map_err(failed)?;
            draw_legend_entry(&root, line_legend_place(&names, n), names[n], color).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

/// Most characters of a name in a trend's legend.
const TREND_NAME: usize = 64;

/// Draws values over runs, from 0 up. The runs stand side by side, marked by their numbers `runs`. Each line joins the
/// runs for which it has a value.
pub fn draw_trend(runs: &[usize], lines: &[TrendLine], y_axis: &str) -> Result<String, String> {
    let names: Vec<String> = lines.iter().map(|l| shortened(&l.method, TREND_NAME)).collect();
    let legend_names: Vec<&str> = names.iter().map(String::as_str).collect();
    let legend = line_legend_height(&legend_names);
    let most = lines.iter().flat_map(|l| &l.values).flatten().fold(1e-6_f64, |most, v| most.max(*v));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, 300 + legend)).into_drawing_area();
        let failed = |e: DrawingAreaErrorKind<std::io::Error>| e.to_string();
        root.fill(&WHITE).map_err(failed)?;
        let last = runs.len().saturating_sub(1).max(1) as f64;
        let mut chart = ChartBuilder::on(&root)
            .margin(10)
            .margin_top(legend)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(-0.15..last + 0.15, 0.0..most * 1.05)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .x_labels(0)
            .x_desc("runs, by their numbers")
            .y_desc(y_axis)
            .label_style(("sans-serif", TEXT))
            .draw()
            .map_err(failed)?;
        // Where there are many runs, only every `step`th number has room.
        let step = runs.len().div_ceil(16).max(1);
        for (n, run) in runs.iter().enumerate().filter(|(n, _)| n % step == 0) {
            let pixel = chart.backend_coord(&(n as f64, 0.0));
            let style = TextStyle::from(("sans-serif", TEXT)).pos(Pos::new(HPos::Center, VPos::Top));
            root.draw(&Text::new(run.to_string(), (pixel.0, pixel.1 + 5), style)).map_err(failed)?;
        }
        for (n, line) in lines.iter().enumerate() {
            let color = series_color(n);
            let points: Vec<_> = line.values.iter().enumerate().filter_map(|(n, v)| Some((n as f64, (*v)?))).collect();
            chart.draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(2))).map_err(failed)?;
            chart.draw_series(points.iter().map(|p| Circle::new(*p, 3, color.filled()))).map_err(failed)?;
            draw_legend_entry(&root, line_legend_place(&legend_names, n), legend_names[n], color).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

/// Returns a name, cut after `most` characters if it is longer.
fn shortened(name: &str, most: usize) -> String {
    match name.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// Draws a coloured square with its left upper corner at `x`, `y` in pixels, and a name beside it.
fn draw_legend_entry<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    (x, y): (i32, i32),
    name: &str,
    color: RGBColor,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    root.draw(&Rectangle::new([(x, y), (x + 14, y + 14)], color.filled()))?;
    root.draw(&Text::new(name, (x + 19, y), ("sans-serif", TEXT)))
}

/// The height in pixels of a legend of lines, which has as many names in a row as there is room for.
fn line_legend_height(names: &[&str]) -> u32 {
    16 + 20 * names.len().div_ceil(legend_columns(names)) as u32
}

/// The place in pixels of the entry of the line `index` in a legend of lines: the left upper corner of its square.
fn line_legend_place(names: &[&str], index: usize) -> (i32, i32) {
    let columns = legend_columns(names);
    (12 + (index % columns) as i32 * legend_width(names), 10 + 20 * (index / columns) as i32)
}

/// The width in pixels of a column of the legend, which has room for the longest name.
fn legend_width(names: &[&str]) -> i32 {
    36 + 8 * names.iter().map(|n| n.chars().count()).max().unwrap_or(0) as i32
}

/// The number of columns for which a legend of lines with these names has room; at least 1.
fn legend_columns(names: &[&str]) -> usize {
    (((WIDTH - 20) as i32 / legend_width(names)) as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_a_log_axis_are_round_numbers_within_its_bounds() {
        assert_eq!(log_ticks(0.8, 60.0), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]);
        assert_eq!(log_ticks(0.025, 0.045), [0.03, 0.04]);
    }

    #[test]
    fn a_point_without_an_error_stands_at_the_foot() {
        let point = |name: &str, position, on_front| NamedPoint { name: name.into(), position, on_front };
        let points = [point("exact", [5.0, 0.0], true), point("wrong", [9.0, 0.2], false)];
        let svg = draw_cost_against_error(&points, ["ms", "error"]).unwrap_or_default();
        let circles: Vec<_> =
            svg.split("<circle").skip(1).filter_map(|c| c.split("cy=\"").nth(1)?.split('"').next()).collect();
        let lowest = |n: usize| circles[n].parse::<i32>().unwrap_or_default();
        assert!(circles.len() == 2 && lowest(0) > lowest(1), "{circles:?}");
        assert!(svg.contains(">\n0\n<"), "a tick says 0");
        assert!(!draw_cost_against_error(&points[1..], ["ms", "error"]).unwrap_or_default().contains(">\n0\n<"));
        assert!(draw_cost_against_error(&points[..1], ["ms", "error"]).is_ok());
    }

    #[test]
    fn ticks_of_few_frames_are_whole_numbers_without_repeats() {
        for (frames, expected) in [
            (2, vec!["0", "1"]),
            (4, vec!["0", "1", "2", "3"]),
            (11, vec!["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10"]),
            (25, vec!["0", "5", "10", "15", "20"]),
        ] {
            let points = (0..frames).map(|n| (f64::from(n), 0.05)).collect();
            let svg = draw_lines(&[Line { name: "line".into(), points }], ["x", "y"]).unwrap_or_default();
            // Only the axis of frames has numbers without a point.
            let is_whole = |line: &&str| !line.is_empty() && line.chars().all(|c| c.is_ascii_digit());
            let mut found: Vec<&str> = svg.lines().filter(is_whole).collect();
            found.sort_by_key(|tick| tick.parse::<u32>().unwrap_or_default());
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn stages_of_one_method_and_of_thirty_differ_in_colour() {
        let names: Vec<String> = (0..30).map(|n| n.to_string()).collect();
        let mut colors: Vec<_> = names.iter().map(|n| stage_color(&names, n)).map(|c| (c.0, c.1, c.2)).collect();
        colors.sort();
        colors.dedup();
        assert_eq!(colors.len(), 30);
    }
}
