//! Summaries of the error study over its cells: a point for each variant, and the parts of the error.

use super::{ErrorRecord, ErrorReference, ImageError};
use crate::study::columns::{Column, Columns};
use crate::study::compare::THRESHOLD;
use crate::study::exhibit::pivot;
use crate::study::names::roughness_name;
use crate::study::record::Stats;
use ssct_truth::metrics::pareto::{self, MeasuredPoint};
use std::collections::BTreeMap;

/// Name of the floor in tables.
pub const FLOOR: &str = "floor of the screen";

/// A variant, summarized over all cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of the variant.
    pub name: String,
    /// Median over the cells of the variant's median time.
    pub time_ms: f64,
    /// Mean over the cells of the variant's error: the share of wrong hits if the reference is the oracle, else the
    /// RMSE.
    pub error: f64,
    /// Mean over the cells of the variant's place agreement; `None` if no cell has one.
    pub place_agreement: Option<f64>,
    /// Medians over the cells of the data that the variant prepared before the first frame: bytes on the device, and
    /// milliseconds. `None` if no record has them.
    pub prepared: Option<(f64, f64)>,
    /// Mean over the cells of each of [`more_columns`]; `None` if no cell has a value.
    pub more: Vec<Option<f64>>,
    /// Uncertainty of the time in either direction, as a share.
    pub noise: f64,
    /// Whether no other variant is better in both time and error.
    pub on_front: bool,
}

/// Returns the columns of [`ImageError`] that have a header, which tables show beside the error itself.
pub fn more_columns() -> Vec<Column<ImageError>> {
    ImageError::columns().columns.into_iter().filter(|c| !c.title.is_empty()).collect()
}

/// Returns the mean of some values; `None` without values.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns the mean of the floor of the screen over the records that have one; `None` if none has.
pub fn floor(records: &[ErrorRecord]) -> Option<f64> {
    // Every method of a cell has the same floor.
    mean(&records.iter().filter_map(|r| r.floor).collect::<Vec<_>>())
}

/// Returns the error of a record that charts show: against the oracle the share of wrong hits, else the RMSE.
fn error(record: &ErrorRecord) -> Option<f64> {
    match record.against {
        ErrorReference::Oracle => record.hits.hit_agreement.map(|a| 1.0 - a),
        ErrorReference::Screen | ErrorReference::World => record.image.rmse,
    }
}

/// Whether a record counts in the mean of a variant's point.
pub fn is_averaged(record: &ErrorRecord) -> bool {
    record.time_ms.is_some() && error(record).is_some()
}

/// The values of a variant, each list with a value for each cell that has one.
#[derive(Default)]
struct VariantValues {
    /// Name of the variant.
    name: String,
    times_ms: Vec<f64>,
    /// Noise of each time, as a share.
    noises: Vec<f64>,
    errors: Vec<f64>,
    place_agreements: Vec<f64>,
    /// Bytes on the device of prepared data.
    prepared_bytes: Vec<f64>,
    /// Milliseconds in which the data was prepared.
    prepared_ms: Vec<f64>,
    /// A list for each of [`more_columns`].
    more: Vec<Vec<f64>>,
}

/// Returns half the width of the interval of a record's time, as a share of the time; `None` if the record has no
/// interval.
fn noise_of(record: &ErrorRecord) -> Option<f64> {
    let half_width_ms = (record.time_high_ms? - record.time_low_ms?) / 2.0;
    Some(half_width_ms / record.time_ms?).filter(|share| share.is_finite())
}

/// Returns the uncertainty of the median time over `cells` cells, as a share: the median of `cell_noises`, the noise of
/// the cells, divided by the square root of `cells`, as independent noise falls. Half the threshold of a verdict is
/// returned if some cells have no noise, because they have few frames or their records are older.
fn noise(cell_noises: &[f64], cells: usize) -> f64 {
    if cell_noises.len() < cells {
        return THRESHOLD / 2.0;
    }
    Stats::from_samples(cell_noises).median_ms / (cells as f64).sqrt()
}

/// Makes a point for each variant from the records against one reference, in order of time. Variants whose error is not
/// finite or whose time is 0 are left out.
pub fn points(records: &[ErrorRecord], against: ErrorReference) -> Vec<Point> {
    let columns = more_columns();
    let mut variants: Vec<VariantValues> = Vec::new();
    for r in records.iter().filter(|r| r.against == against) {
        let (Some(time), Some(error)) = (r.time_ms, error(r)) else { continue };
        let name = r.head.variant();
        let index = variants.iter().position(|variant| variant.name == name).unwrap_or_else(|| {
            variants.push(VariantValues { name, more: vec![Vec::new(); columns.len()], ..VariantValues::default() });
            variants.len() - 1
        });
        let values = &mut variants[index];
        values.times_ms.push(time);
        values.noises.extend(noise_of(r));
        values.errors.push(error);
        values.place_agreements.extend(r.place_agreement);
        values.prepared_bytes.extend(r.prepared.as_ref().map(|p| p.device_bytes as f64));
        values.prepared_ms.extend(r.prepared.as_ref().map(|p| p.time_ms));
        for (list, column) in values.more.iter_mut().zip(&columns) {
            list.extend(column.number(&r.image));
        }
    }
    let median = |values: &[f64]| Stats::from_samples(values).median_ms;
    let mut points: Vec<Point> = variants
        .into_iter()
        .map(|values| Point {
            time_ms: median(&values.times_ms),
            noise: noise(&values.noises, values.times_ms.len()),
            error: mean(&values.errors).unwrap_or(f64::NAN),
            place_agreement: mean(&values.place_agreements),
            prepared: (!values.prepared_bytes.is_empty())
                .then(|| (median(&values.prepared_bytes), median(&values.prepared_ms))),
            more: values.more.iter().map(|list| mean(list)).collect(),
            on_front: false,
            name: values.name,
        })
        .filter(|p| p.error.is_finite() && p.error >= 0.0 && p.time_ms > 0.0)
        .collect();
    let with_interval = |p: &Point| {
        let [least, most] = [1.0 - p.noise, 1.0 + p.noise].map(|factor| p.time_ms * factor);
        MeasuredPoint { least, most, error: p.error }
    };
    for index in pareto::front_of_measured(&points.iter().map(with_interval).collect::<Vec<_>>()) {
        points[index].on_front = true;
    }
    points.sort_by(|a, b| a.time_ms.total_cmp(&b.time_ms));
    points
}

/// Makes the cells of the table of the parts of the error. Lines are methods with a reference, and the floor; columns
/// are roughness values; a cell has the median RMSE over the views. The first variant of a method in the records stands
/// for it.
pub fn source_cells(records: &[ErrorRecord]) -> Vec<Vec<String>> {
    let mut first_variants = BTreeMap::new();
    for r in records {
        first_variants.entry(r.head.method_and_fallback()).or_insert_with(|| r.head.variant());
    }
    let is_first = |r: &&ErrorRecord| first_variants.get(&r.head.method_and_fallback()) == Some(&r.head.variant());
    let first_records = || records.iter().filter(is_first);
    let column = |r: &ErrorRecord| format!("r {}", roughness_name(r.head.roughness));
    let label = |r: &ErrorRecord| format!("{}, {}", r.head.method_and_fallback(), r.against.name());
    let errors = first_records().filter_map(|r| Some((label(r), column(r), r.image.rmse?)));
    let floors = first_records().filter_map(|r| Some((format!("{FLOOR}, world"), column(r), r.floor?)));
    // An entry has the label of its line, the header of its column, and a number.
    let entries: Vec<(String, String, f64)> = errors.chain(floors).collect();
    pivot("what, against", &entries, [&|(label, ..)| label.clone(), &|(_, column, _)| column.clone()], |cell_entries| {
        let values: Vec<f64> = cell_entries.iter().map(|(.., value)| *value).collect();
        Some(format!("{:.4}", Stats::from_samples(&values).median_ms))
    })
}
