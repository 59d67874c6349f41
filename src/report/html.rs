//! The page of a study: pictures, tables and plots, in one file beside its images.

use super::tables;
use crate::gpu::DeviceInfo;
use crate::study::TimeRecord;
use crate::study::record::{DEFINITIONS, Head};
use crate::study::table::Compared;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A picture of the page; the path is relative to the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// File, relative to the page.
    pub file: String,
    /// What it shows.
    pub caption: String,
}

/// Pictures of one view side by side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strip {
    /// Scene and view.
    pub title: String,
    /// The pictures.
    pub pictures: Vec<Picture>,
}

/// Everything that the page shows.
pub struct Page<'a> {
    /// Device that everything ran on.
    pub device: &'a DeviceInfo,
    /// The command that made it.
    pub command: String,
    /// Pictures by view.
    pub strips: Vec<Strip>,
    /// Figures of the thesis.
    pub figures: Vec<Picture>,
    /// Rows of table 5.8.
    pub table: Vec<Compared>,
    /// The measurements behind the table.
    pub table_records: &'a [TimeRecord],
    /// The measurements of the views.
    pub view_records: &'a [TimeRecord],
    /// Plot of the views' times, SVG.
    pub plot: String,
}

const STYLE: &str = "
:root { color-scheme: light dark; font: 16px/1.5 system-ui, sans-serif; }
body { max-width: 1200px; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1rem 0; }
th, td { padding: .25rem .7rem; text-align: right; border-bottom: 1px solid #8884; }
th:first-child, td:first-child { text-align: left; }
.strip { display: grid; grid-template-columns: repeat(auto-fit, minmax(360px, 1fr)); gap: .8rem; }
figure { margin: 0; } figcaption { font-size: .9rem; opacity: .8; }
img { max-width: 100%; } .plot { background: #fff; padding: .5rem; overflow-x: auto; }
.scroll { overflow-x: auto; } code { background: #8882; padding: .1rem .3rem; }
";

impl Page<'_> {
    /// The whole page.
    pub fn render(&self) -> String {
        let d = self.device;
        let times = "Times on a CPU device are the host's: compare only ratios within this page.";
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { "ssct study" }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { "Glossy reflections in screen space" }
                    p {
                        "ssct " (Head::VERSION) " (" (Head::COMMIT) ") on " (d.name) " (" (d.kind) ", Vulkan " (d.api) ", "
                        (d.driver) "), definitions " (DEFINITIONS) ". Made by " code { (self.command) } ". "
                        @if d.kind == "CPU" { (times) }
                    }
                    h2 { "Table 5.8" }
                    p {
                        "The thesis's milliseconds (NVIDIA GeForce GTX 670, Sponza) beside this device's, for the effect "
                        "without the scene passes. What carries over between machines is the ratio. The normal deviation is the roughness, "
                        "as in the thesis."
                    }
                    (grid(&tables::table_5_8_cells(&self.table)))
                    @if let Some(worst) = self.worst_sum() {
                        p {
                            "Check of the timer: the sum of all passes' medians over the frame's own median is "
                            (format!("{:.3} to {:.3}", worst.0, worst.1)) "."
                        }
                    }
                    h2 { "Where the time goes" }
                    div.plot { (PreEscaped(&self.plot)) }
                    h2 { "Pictures" }
                    @for strip in &self.strips {
                        h3 { (strip.title) }
                        div.strip { @for p in &strip.pictures { (picture(p)) } }
                    }
                    h2 { "Figures of the thesis" }
                    div.strip { @for p in &self.figures { (picture(p)) } }
                    h2 { "Every pass" }
                    p { "Medians; raw samples stand in " code { "time-samples.csv" } ", records in " code { "time.json" } "." }
                    div.scroll { (passes(self.view_records)) }
                }
            }
        }
        .into_string()
    }

    /// Least and greatest ratio of the passes' sum to the frame.
    fn worst_sum(&self) -> Option<(f64, f64)> {
        let ratios: Vec<f64> = self.table_records.iter().map(TimeRecord::sum_over_frame).collect();
        let least = ratios.iter().copied().reduce(f64::min)?;
        Some((least, ratios.iter().copied().fold(least, f64::max)))
    }
}

fn picture(p: &Picture) -> Markup {
    html! {
        figure {
            a href=(p.file) { img src=(p.file) alt=(p.caption) loading="lazy"; }
            figcaption { (p.caption) }
        }
    }
}

fn grid(cells: &[Vec<String>]) -> Markup {
    let Some((header, rows)) = cells.split_first() else { return html! { p { "Not measured." } } };
    html! {
        div.scroll {
            table {
                thead { tr { @for c in header { th { (c) } } } }
                tbody { @for row in rows { tr { @for c in row { td { (c) } } } } }
            }
        }
    }
}

/// Every pass of each record: median, minimum, p95, and its fragment invocations.
fn passes(records: &[TimeRecord]) -> Markup {
    let mut cells = vec![["pass", "median ms", "min ms", "p95 ms", "samples", "fragments"].map(str::to_owned).to_vec()];
    for r in records {
        let h = &r.head;
        let title = format!(
            "{} {} {}x{}, roughness {}, {}",
            h.scene,
            h.view,
            h.width,
            h.height,
            tables::roughness(h.roughness),
            h.method
        );
        cells.push(vec![title]);
        for p in &r.passes {
            let s = p.stats;
            let mut row = vec![p.name.clone()];
            row.extend([s.median_ms, s.min_ms, s.p95_ms].map(|ms| format!("{ms:.3}")));
            row.extend([
                s.samples.to_string(),
                p.work.map_or_else(|| "-".into(), |w| w.fragment_invocations.to_string()),
            ]);
            cells.push(row);
        }
    }
    grid(&cells)
}
