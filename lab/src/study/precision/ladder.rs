//! Summaries of the precision ladder over the views: each method's errors on each rung, a table of all rungs, and
//! charts of bytes against error.

use super::{PrecisionRecord, Storage};
use crate::study::columns::{AsDatum, Datum};
use crate::study::engine::Row;
use crate::study::exhibit::{Chart, Drawing, NamedPoint, Table, distinct};
use crate::study::names::{roughness_name, safe_word};
use crate::study::record::Provenance;
use serde_json::Value;
use ssct_truth::metrics::pareto;

/// The results of a method on a rung, over the views.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// The formats.
    pub storage: Storage,
    /// Mean share of wrong hits of mirrors; `None` if no hits were compared.
    pub wrong_hits: Option<f64>,
    /// Greatest share of wrong hits of mirrors in a view.
    pub wrong_hits_worst: Option<f64>,
    /// Mean RMSE of each roughness that has records, in the order of [`roughness_values`].
    pub rmse: Vec<f64>,
}

/// Returns the roughness values of some records, in the order in which they first appear.
pub fn roughness_values(records: &[PrecisionRecord]) -> Vec<Option<f32>> {
    distinct(records.iter().map(|r| r.head.roughness))
}

/// Returns the results of a method on each rung that has records, in the ladder's order.
pub fn rungs(records: &[PrecisionRecord], method: &str) -> Vec<Rung> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let rung = |storage: Storage| {
        let on_rung = || records.iter().filter(move |r| r.head.method == method && r.storage == storage);
        let wrong_hits: Vec<f64> = on_rung().filter_map(|r| r.hits.hit_agreement).map(|right| 1.0 - right).collect();
        let mean_rmse = |roughness: Option<f32>| {
            let values: Vec<f64> = on_rung().filter(|r| r.head.roughness == roughness).map(|r| r.rmse).collect();
            (!values.is_empty()).then(|| mean(&values))
        };
        let rmse: Vec<f64> = roughness_values(records).into_iter().filter_map(mean_rmse).collect();
        (!rmse.is_empty()).then(|| Rung {
            storage,
            wrong_hits: (!wrong_hits.is_empty()).then(|| mean(&wrong_hits)),
            wrong_hits_worst: wrong_hits.iter().copied().reduce(f64::max),
            rmse,
        })
    };
    Storage::ladder().into_iter().filter_map(rung).collect()
}

impl AsDatum for Storage {
    fn datum(&self) -> Datum {
        Datum::Text(self.name())
    }
}

impl Row for PrecisionRecord {
    const KIND: &'static str = "precision";
    const TITLE: &'static str = "Precision ladder";

    fn program(&self) -> &Provenance {
        &self.head.program
    }

    /// Makes one table with a line for each rung.
    fn tables(rows: &[Self], _: &Value) -> Vec<Table> {
        vec![Table { id: "table", about: ABOUT.to_owned(), cells: cells(rows), ..Table::default() }]
    }

    /// Makes charts for each method: of wrong hits, and of the RMSE at each roughness, against the bytes of a pixel.
    fn charts(rows: &[Self]) -> Vec<Chart> {
        let mut charts = Vec::new();
        let mut add_if_several_points = |stem: String, title: String, points: Vec<(Storage, f64)>| {
            if points.len() > 1 {
                let axes = ["bytes per pixel".to_owned(), title.clone()];
                charts.push(Chart::new(stem, title, Drawing::Points(axes, chart_points(&points))));
            }
        };
        for method in methods(rows) {
            let rungs = rungs(rows, method);
            let wrong_hits = rungs.iter().filter_map(|rung| Some((rung.storage, rung.wrong_hits?)));
            let title = format!("{method}: share of wrong hits against the oracle (roughness 0)");
            add_if_several_points(format!("precision-hits-{}", safe_word(method)), title, wrong_hits.collect());
            for (n, roughness) in roughness_values(rows).into_iter().enumerate() {
                let roughness = roughness_name(roughness);
                let rmse = rungs.iter().filter_map(|rung| Some((rung.storage, rung.rmse.get(n).copied()?)));
                let title = format!("{method}: RMSE of the reflection colour, roughness {roughness}");
                add_if_several_points(
                    format!("precision-rmse-{}-r{roughness}", safe_word(method)),
                    title,
                    rmse.collect(),
                );
            }
        }
        charts
    }
}

const ABOUT: &str = "The G-buffer is traced in f64 through the pixels' centres, stored in each set of formats, and handed \
    to the methods with what was read again. Hits are held against oracle 1 on the unrounded G-buffer, colours against the \
    screen reference there; oracle is the oracle itself on what was stored: what storage costs, whatever the arithmetic. \
    Bytes are depth, normal, lit colour and 4 of reflectivity and roughness. Means over the views.";

/// Makes the points of a chart, bytes of a pixel against the error, with the Pareto front marked. Each element of
/// `points` has the formats of a rung and the error there.
fn chart_points(points: &[(Storage, f64)]) -> Vec<NamedPoint> {
    let costs: Vec<_> = points.iter().map(|(storage, error)| (f64::from(storage.bytes_per_pixel()), *error)).collect();
    let on_front = pareto::front(&costs);
    let point = |index: usize| {
        let ((storage, error), (bytes, _)) = (points[index], costs[index]);
        NamedPoint { name: storage.name(), position: [bytes, error], on_front: on_front.contains(&index) }
    };
    (0..points.len()).map(point).collect()
}

/// Returns the names of the methods in some records, each once.
fn methods(records: &[PrecisionRecord]) -> Vec<&str> {
    distinct(records.iter().map(|r| r.head.method.as_str()))
}

/// Makes the cells of a table with a line for each rung. For each method it has the wrong hits, as a mean and in the
/// worst view, and the RMSE at each roughness.
fn cells(records: &[PrecisionRecord]) -> Vec<Vec<String>> {
    let methods: Vec<(&str, Vec<Rung>)> = methods(records).into_iter().map(|m| (m, rungs(records, m))).collect();
    let roughness = roughness_values(records);
    let mut header = vec!["storage".to_owned(), "bytes".to_owned()];
    for (method, rungs) in &methods {
        header.extend([format!("{method} wrong %"), "worst %".to_owned()]);
        let columns = rungs.iter().map(|r| r.rmse.len()).max().unwrap_or(0);
        header.extend(roughness.iter().take(columns).map(|r| format!("RMSE r {}", roughness_name(*r))));
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
