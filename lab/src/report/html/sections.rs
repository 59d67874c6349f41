//! The page's tables and plots.

use super::{Errors, Times};
use crate::report::plot::DrawnChart;
use crate::study::engine::Row;
use crate::study::error::{ErrorRecord, source_table};
use crate::study::exhibit::Table;
use crate::study::names::roughness_name;
use crate::study::{TimeRecord, table};
use maud::{Markup, PreEscaped, html};

/// Returns the part of the page with the times of the thesis's table 5.8 beside the times of this device.
pub fn table_5_8(times: &Times) -> Markup {
    html! {
        p {
            "The thesis's milliseconds (NVIDIA GeForce GTX 670, Sponza) beside this device's, for the effect "
            "without the scene passes. What carries over between machines is the ratio. The normal deviation is the "
            "roughness, as in the thesis. Drift is how much longer the passes of the scene, the same work in each row of a size, "
            "took than in the first row: by as much the machine had changed meanwhile."
        }
        (grid(&table::cells(times.table)))
        @if let Some((least, greatest)) = sum_over_frame(times.table_records) {
            p {
                "Check of the timer: the sum of all passes' medians over the frame's own median is "
                (format!("{least:.3} to {greatest:.3}")) "."
            }
        }
    }
}

/// Returns the least and the greatest ratio, over the records, of the sum of all passes' medians to the frame's median;
/// `None` without records.
fn sum_over_frame(records: &[TimeRecord]) -> Option<(f64, f64)> {
    let ratios: Vec<f64> = records.iter().map(TimeRecord::sum_over_frame).collect();
    let least = ratios.iter().copied().reduce(f64::min)?;
    Some((least, ratios.iter().copied().fold(least, f64::max)))
}

/// Returns the part of the page on run time against error: plots, tables, and a table of what the error consists of.
pub fn errors(errors: &Errors) -> Markup {
    html! {
        p { (errors.settings) }
        @for chart in &errors.plots { (drawn_chart(chart)) }
        @for table in ErrorRecord::tables(errors.records, &serde_json::Value::Null) {
            h3 { (table.title) }
            (table_with_text(&table))
        }
        @let sources = source_table(errors.records);
        h3 { (sources.title) }
        (table_with_text(&sources))
    }
}

/// Puts a plot into the page, with `label` as the text for readers who cannot see the plot.
pub fn inline_svg(svg: &str, label: &str) -> Markup {
    // HTML knows the namespace of an svg element, so the attribute is left out.
    let svg = svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1);
    let body = svg.strip_prefix("<svg").unwrap_or(&svg);
    html! {
        div.plot {
            (PreEscaped("<svg role=\"img\" aria-label=\""))
            (label)
            (PreEscaped("\""))
            (PreEscaped(body))
        }
    }
}

/// A table of cells: the first row is the header, and the first cell of each row is its name.
pub fn grid(cells: &[Vec<String>]) -> Markup {
    let Some((header, rows)) = cells.split_first() else { return html! { p { "Not measured." } } };
    html! {
        div.scroll {
            table {
                thead { tr { @for c in header { th scope="col" { (c) } } } }
                tbody {
                    @for row in rows {
                        tr {
                            @for (n, c) in row.iter().enumerate() {
                                @if n == 0 { th scope="row" { (c) } } @else { td { (unbroken(c)) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A chart under its title, with its points as a table where it has them.
pub fn drawn_chart(DrawnChart { chart, svg }: &DrawnChart) -> Markup {
    html! {
        h3 { (chart.title) }
        (inline_svg(svg, &format!("{}; a table has the same values", chart.title)))
        @if !chart.cells.is_empty() { (grid(&chart.cells)) }
    }
}

/// A table below the text about it.
pub fn table_with_text(table: &Table) -> Markup {
    html! {
        @if !table.about.is_empty() { p { (table.about) } }
        (grid(&table.cells))
    }
}

/// Returns the text of a cell so that a browser breaks its lines only after commas, and every number stays with its
/// unit.
fn unbroken(cell: &str) -> String {
    cell.replace(' ', "\u{a0}").replace(",\u{a0}", ", ")
}

/// Returns a table for each record, with a row for each of its passes.
pub fn passes(records: &[TimeRecord]) -> Markup {
    html! {
        @for r in records {
            details {
                summary { (title(r)) ": " (format!("{:.3}", r.total.median_ms)) " ms" }
                (grid(&pass_cells(r)))
            }
        }
    }
}

/// The title of a record's table: scene, view, size in pixels, roughness and method.
fn title(record: &TimeRecord) -> String {
    let head = &record.head;
    let roughness_text = roughness_name(head.roughness);
    format!(
        "{}, {}, {} × {}, roughness {roughness_text}, {}",
        head.scene, head.view, head.width, head.height, head.method
    )
}

/// Returns a table of a record's passes: median, minimum and 95th percentile in milliseconds, the number of samples,
/// and the number of fragment invocations.
fn pass_cells(record: &TimeRecord) -> Vec<Vec<String>> {
    let mut cells = vec![["pass", "median ms", "min ms", "p95 ms", "samples", "fragments"].map(str::to_owned).to_vec()];
    for p in &record.passes {
        let s = p.stats;
        let mut row = vec![p.name.clone()];
        row.extend([s.median_ms, s.min_ms, s.p95_ms].map(|ms| format!("{ms:.3}")));
        row.extend([s.samples.to_string(), p.work.map_or_else(|| "-".into(), |w| w.fragment_invocations.to_string())]);
        cells.push(row);
    }
    cells
}
