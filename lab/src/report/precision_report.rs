//! The precision ladder as files and text: records, a table, a plot a method and error, a page.

use super::plot::{self, NamedPoint};
use super::{files, html, tables};
use crate::error::{Error, Result};
use crate::metrics::pareto;
use crate::study::precision::{PrecisionRecord, Rung, Storage, roughness_values, rungs};
use crate::study::record::DEFINITIONS;
use std::path::Path;

/// Writes precision.json, precision.txt, the plots and index.html.
pub fn write(folder: &Path, records: &[PrecisionRecord], command: &str) -> Result<()> {
    files::write(&folder.join("precision.json"), files::json(records).as_bytes())?;
    files::write(&folder.join("precision.txt"), text(records).as_bytes())?;
    let plots = plots(records).map_err(|e| Error::io("draw the plots of", folder, std::io::Error::other(e)))?;
    for plot in &plots {
        files::write(&folder.join(format!("{}.svg", plot.stem)), plot.svg.as_bytes())?;
    }
    files::write(&folder.join("index.html"), page(records, &plots, command).as_bytes())
}

/// One plot of bytes against error.
struct Plot {
    /// File name without its ending.
    stem: String,
    title: String,
    svg: String,
}

/// For each method: wrong hits, and the RMSE of each roughness.
fn plots(records: &[PrecisionRecord]) -> std::result::Result<Vec<Plot>, String> {
    let mut plots = Vec::new();
    let mut add = |stem: String, title: String, points: Vec<(Storage, f64)>| {
        if points.len() > 1 {
            let svg = plot::against(&named(&points), ["bytes per pixel", &title])?;
            plots.push(Plot { stem, title, svg });
        }
        Ok::<(), String>(())
    };
    for method in methods(records) {
        let rungs = rungs(records, method);
        let wrong = rungs.iter().filter_map(|r| Some((r.storage, r.wrong_hits?)));
        let title = format!("{method}: share of wrong hits against the oracle (roughness 0)");
        add(format!("precision-hits-{method}"), title, wrong.collect())?;
        for (n, roughness) in roughness_values(records).into_iter().enumerate() {
            let roughness = tables::roughness(roughness);
            let rmse = rungs.iter().filter_map(|r| Some((r.storage, r.rmse.get(n).copied()?)));
            let title = format!("{method}: RMSE of the reflection colour, roughness {roughness}");
            add(format!("precision-rmse-{method}-r{roughness}"), title, rmse.collect())?;
        }
    }
    Ok(plots)
}

fn named(points: &[(Storage, f64)]) -> Vec<NamedPoint> {
    let costs: Vec<_> = points.iter().map(|(s, e)| (f64::from(s.bytes_per_pixel()), *e)).collect();
    let on_front = pareto::front(&costs);
    points
        .iter()
        .zip(&costs)
        .enumerate()
        .map(|(n, ((storage, _), (x, y)))| NamedPoint {
            name: storage.name(),
            at: [*x, *y],
            on_front: on_front.contains(&n),
        })
        .collect()
}

fn methods(records: &[PrecisionRecord]) -> Vec<&str> {
    let mut methods: Vec<&str> = Vec::new();
    for record in records {
        if !methods.contains(&record.head.method.as_str()) {
            methods.push(&record.head.method);
        }
    }
    methods
}

/// The table for a terminal.
pub fn text(records: &[PrecisionRecord]) -> String {
    tables::aligned(&cells(records))
}

/// One row a rung; for each method its wrong hits (mean and worst view) and its RMSE by roughness.
fn cells(records: &[PrecisionRecord]) -> Vec<Vec<String>> {
    let methods: Vec<(&str, Vec<Rung>)> = methods(records).into_iter().map(|m| (m, rungs(records, m))).collect();
    let roughness = roughness_values(records);
    let mut header = vec!["storage".to_owned(), "bytes".to_owned()];
    for (method, rungs) in &methods {
        header.extend([format!("{method} wrong %"), "worst %".to_owned()]);
        let columns = rungs.iter().map(|r| r.rmse.len()).max().unwrap_or(0);
        header.extend(roughness.iter().take(columns).map(|r| format!("RMSE r {}", tables::roughness(*r))));
    }
    let mut rows = vec![header];
    for storage in Storage::ladder() {
        let mut row = vec![storage.name(), storage.bytes_per_pixel().to_string()];
        for (_, rungs) in &methods {
            let Some(rung) = rungs.iter().find(|r| r.storage == storage) else { continue };
            let percent = |v: Option<f64>| v.map_or_else(|| "-".into(), |v| format!("{:.3}", 100.0 * v));
            row.extend([percent(rung.wrong_hits), percent(rung.wrong_hits_worst)]);
            row.extend(rung.rmse.iter().map(|e| format!("{e:.5}")));
        }
        rows.push(row);
    }
    rows
}

const RULE: &str = "The G-buffer is traced in f64 through the pixels' centres, stored in each set of formats, and handed \
    to the methods with what was read again. Hits are held against oracle 1 on the unrounded G-buffer, colours against the \
    screen reference there; oracle is the oracle itself on what was stored: what storage costs, whatever the arithmetic. \
    Bytes are depth, normal, lit colour and 4 of reflectivity and roughness. Means over the views.";

fn page(records: &[PrecisionRecord], plots: &[Plot], command: &str) -> String {
    let plots: Vec<_> = plots.iter().map(|p| (p.title.as_str(), p.svg.as_str())).collect();
    let program = records.first().map(|r| &r.head.program);
    let definitions = program.map_or(DEFINITIONS, |p| p.definitions);
    html::plots_page(
        "Precision ladder",
        program.map(|p| &p.device),
        definitions,
        command,
        &plots,
        (RULE, &cells(records)),
    )
}
