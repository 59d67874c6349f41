//! The README's plots, drawn by hand, as they have two axes and dots alone: time and error of methods over those of `ssct`.

use crate::queries::Queries;
use std::path::{Path, PathBuf};

/// A picture, or a sentence about why there is none.
type Result<T> = std::result::Result<T, String>;

/// Where the margins left, top, right and below a plot end, and what it shows of the ratios: its axes' ends.
struct Plot {
    svg: String,
    margins: [f64; 4],
    size: [f64; 2],
    times: [f64; 2],
    errors: [f64; 2],
    has_even_times: bool,
}

impl Plot {
    fn x(&self, time: f64) -> f64 {
        let width = self.size[0] - self.margins[0] - self.margins[2];
        self.margins[0] + width * along(time, self.times, self.has_even_times)
    }

    fn y(&self, error: f64) -> f64 {
        let height = self.size[1] - self.margins[1] - self.margins[3];
        let error = error.clamp(self.errors[0], self.errors[1]);
        self.margins[1] + height * (1.0 - along(error, self.errors, false))
    }

    fn line(&mut self, text: &str) {
        self.svg += text;
        self.svg += "\n";
    }

    fn words(&mut self, [x, y]: [f64; 2], more: &str, words: &str) {
        self.line(&format!(r#"<text x="{x:.1}" y="{y:.1}"{more}>{words}</text>"#));
    }

    fn dot(&mut self, [x, y]: [f64; 2], radius: &str, style: &str) {
        let style = if style.is_empty() { String::new() } else { format!(" {style}") };
        self.line(&format!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius}"{style}/>"#));
    }

    /// The frame: white ground, a line for each number on the axes, and what the axes show.
    fn frame(&mut self, times: &[f64], errors: &[f64], error: &str) {
        let [width, height] = self.size;
        let view = format!(r#"viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12""#);
        self.line(&format!(r#"<svg xmlns="http://www.w3.org/2000/svg" {view}>"#));
        self.line(&format!(r#"<rect width="{width}" height="{height}" fill="white"/>"#));
        let ([left, right], [bottom, top]) = (self.times.map(|t| self.x(t)), self.errors.map(|e| self.y(e)));
        for tick in times {
            let x = self.x(*tick);
            self.line(&format!(r##"<path d="M{x:.1} {top:.1}V{bottom:.1}" stroke="#ddd"/>"##));
            self.words([x, bottom + 16.0], r#" text-anchor="middle""#, &tick.to_string());
        }
        for tick in errors {
            let y = self.y(*tick);
            self.line(&format!(r##"<path d="M{left:.1} {y:.1}H{right:.1}" stroke="#ddd"/>"##));
            self.words([left - 6.0, y + 4.0], r#" text-anchor="end""#, &tick.to_string());
        }
        self.words([(left + right) / 2.0, bottom + 38.0], r#" text-anchor="middle""#, "time / ssct's");
        let middle = (top + bottom) / 2.0;
        let turned = format!(r#"y="{middle:.1}" text-anchor="middle" transform="rotate(270 16 {middle:.1})""#);
        self.line(&format!(r#"<text x="16" {turned}>{error} / ssct's</text>"#));
    }

    /// The picture, whose dots all lie inside.
    fn finished(mut self) -> String {
        self.line("</svg>");
        self.svg
    }

    fn check(&self, what: &str, [time, error]: [f64; 2], least_error: f64) -> Result<()> {
        let is_inside =
            (self.times[0]..=self.times[1]).contains(&time) && (least_error..=self.errors[1]).contains(&error);
        if is_inside { Ok(()) } else { Err(format!("{what} at {time:.2}, {error:.3} lies outside the plot")) }
    }
}

/// Where a value lies between two others, evenly or by its logarithm.
fn along(value: f64, [least, most]: [f64; 2], is_even: bool) -> f64 {
    if is_even { (value - least) / (most - least) } else { (value / least).ln() / (most / least).ln() }
}

fn numbers(cells: &[String]) -> Result<Vec<f64>> {
    cells.iter().map(|cell| cell.parse().map_err(|_| format!("{cell:?} is no number"))).collect()
}

/// A colour for each roughness, from mirrors to rough.
const BY_ROUGHNESS: [(&str, &str); 5] =
    [("0", "#000000"), ("0.05", "#3b528b"), ("0.1", "#21918c"), ("0.3", "#5ec962"), ("0.6", "#e8b000")];

/// The plot beside the README's table: `unified` and `hzct` on the screen, a dot for each view and roughness. Times are of one folder,
/// and errors of the other.
pub(crate) fn headline(queries: &Queries, timed: &Path, judged: &Path) -> Result<String> {
    let mut plot = Plot {
        svg: String::new(),
        margins: [70.0, 16.0, 170.0, 50.0],
        size: [720.0, 400.0],
        times: [0.2, 1.1],
        errors: [0.0005, 3.0],
        has_even_times: true,
    };
    plot.frame(&[0.2, 0.4, 0.6, 0.8, 1.0], &[0.001, 0.01, 0.1, 1.0], "error");
    // A filled dot of `unified`, or a ring.
    let style = |method: &str, color: &str| match method {
        "unified" => format!(r#"fill="{color}""#),
        _ => format!(r#"fill="none" stroke="{color}""#),
    };
    for row in queries.rows("headline plot", &[timed.to_owned(), judged.to_owned()])? {
        let [method, roughness, figures @ ..] = &row[..] else { return Err("a dot lacks its method".to_owned()) };
        let [time, error] = numbers(figures)?[..] else { return Err("a dot has two figures".to_owned()) };
        plot.check(method, [time, error], 0.0)?;
        let color = BY_ROUGHNESS.iter().find(|(known, _)| known == roughness).map_or("", |(_, color)| color);
        plot.dot([plot.x(time), plot.y(error)], "3.5", &style(method, color));
    }
    let [x, y] = [plot.x(1.0), plot.y(1.0)];
    let red = r#"stroke="red" stroke-width="3"/>"#;
    plot.line(&format!(r#"<path d="M{:.1} {y:.1}h12M{x:.1} {:.1}v12" {red}"#, x - 6.0, y - 6.0));
    let legend = plot.x(plot.times[1]) + 20.0;
    plot.line(&format!(r#"<path d="M{:.1} 26h12M{legend:.1} 20v12" {red}"#, legend - 6.0));
    let named = |plot: &mut Plot, y: &str, name: &str| {
        plot.line(&format!(r#"<text x="{:.1}" y="{y}">{name}</text>"#, legend + 12.0));
    };
    named(&mut plot, "30", "ssct");
    plot.dot([legend, 48.0], "3.5", &style("hzct", BY_ROUGHNESS[1].1));
    named(&mut plot, "52", "hzct");
    plot.dot([legend, 70.0], "3.5", &style("unified", BY_ROUGHNESS[1].1));
    named(&mut plot, "74", "unified");
    plot.line(&format!(r#"<text x="{:.1}" y="104">roughness</text>"#, legend - 6.0));
    for (n, (roughness, color)) in BY_ROUGHNESS.iter().enumerate() {
        let y = 122.0 + 20.0 * n as f64;
        plot.dot([legend, y], "3.5", &style("unified", color));
        plot.words([legend + 12.0, y + 4.0], "", roughness);
    }
    Ok(plot.finished())
}

/// The colour of a method, by what its rays go on in: triangles, captures or nothing.
fn color(name: &str) -> &'static str {
    match name {
        "unified" | "traced" => "#1a7f37",
        name if name.ends_with(" captures") => "#d62728",
        _ => "#3b528b",
    }
}

/// Places that no other beats in both, in the order of their times.
fn front(all: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let is_beaten = |p: &[f64; 2]| all.iter().any(|o| o != p && o[0] <= p[0] && o[1] <= p[1]);
    let mut front: Vec<_> = all.iter().copied().filter(|p| !is_beaten(p)).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    front
}

/// The README's first plot: every method against the world, mirrors and a roughness.
pub(crate) fn world(queries: &Queries, folder: PathBuf) -> Result<String> {
    let mut plot = Plot {
        svg: String::new(),
        margins: [70.0, 16.0, 250.0, 50.0],
        size: [760.0, 400.0],
        times: [0.03, 4.0],
        errors: [0.08, 3.0],
        has_even_times: false,
    };
    plot.frame(&[0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0], &[0.1, 0.2, 0.5, 1.0, 2.0], "error against the world");
    let mut methods = Vec::new();
    for row in queries.rows("world plot", &[folder])? {
        let [time, error, rough_time, rough_error] = numbers(&row[1..])?[..] else {
            return Err("four figures".to_owned());
        };
        methods.push((row[0].clone(), [[time, error], [rough_time, rough_error]]));
    }
    for (n, dashes) in ["", r#" stroke-dasharray="4 3""#].into_iter().enumerate() {
        let all: Vec<_> = methods.iter().map(|(_, points)| points[n]).collect();
        let path: Vec<_> = front(&all).into_iter().map(|[t, e]| format!("{:.1} {:.1}", plot.x(t), plot.y(e))).collect();
        plot.line(&format!(r##"<path d="M{}" fill="none" stroke="#999"{dashes}/>"##, path.join("L")));
    }
    let (right, top, bottom) = (plot.x(plot.times[1]), plot.y(plot.errors[1]), plot.y(plot.errors[0]));
    // In the order of the mirrors' errors, each name led to its dot.
    for (n, (name, points)) in methods.iter().enumerate() {
        points.iter().try_for_each(|point| plot.check(name, *point, plot.errors[0]))?;
        let color = color(name);
        let [[x, y], [rough_x, rough_y]] = points.map(|[time, error]| [plot.x(time), plot.y(error)]);
        let (name_x, name_y) = (right + 28.0, top + 30.0 + 20.0 * n as f64);
        let lead = format!(r#"<path d="M{x:.1} {y:.1}L{:.1} {name_y:.1}" stroke="{color}""#, name_x - 6.0);
        plot.line(&format!(r#"{lead} stroke-opacity="0.3"/>"#));
        let pair = format!(r#"<path d="M{x:.1} {y:.1}L{rough_x:.1} {rough_y:.1}" stroke="{color}""#);
        plot.line(&format!(r#"{pair} stroke-dasharray="1 2"/>"#));
        plot.dot([x, y], "4", &format!(r#"fill="{color}""#));
        plot.dot([rough_x, rough_y], "4", &format!(r#"fill="none" stroke="{color}""#));
        plot.words([name_x, name_y + 4.0], &format!(r#" fill="{color}""#), name);
    }
    let legend = bottom - 14.0;
    let (dot, ring) = (right + 28.0, right + 128.0);
    plot.dot([dot, legend - 4.0], "4", "");
    plot.words([dot + 10.0, legend], "", "mirrors");
    plot.dot([ring, legend - 4.0], "4", r#"fill="none" stroke="black""#);
    plot.words([ring + 10.0, legend], "", "roughness 0.1");
    Ok(plot.finished())
}
