//! The thesis's table 5.8: its printed times, and rows that compare them with measured times.

use super::compare::{SEED, shown_drift};
use super::drift::drift;
use super::record::TimeRecord;
use crate::stage::Globals;
use crate::study::exhibit::distinct;
use serde::Serialize;
use ssct::methods::{METHODS, MethodInfo};
use ssct_truth::metrics::bootstrap::{CONFIDENCE, MIN_SAMPLES, Ratio, median_of_ratios};

/// A row of table 5.8 (thesis ch. 5, below figure 5.8; NVIDIA GeForce GTX 670), milliseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Roughness, which is also the normal deviation.
    pub roughness: f32,
    /// Time of SSCT in milliseconds.
    pub ssct: f64,
    /// Time of HZCT in milliseconds.
    pub hzct: f64,
    /// Time of SSLR in milliseconds.
    pub sslr: f64,
}

/// Makes a row of the table; the last three values are times in milliseconds.
const fn row(width: u32, height: u32, roughness: f32, ssct: f64, hzct: f64, sslr: f64) -> Published {
    Published { size: [width, height], roughness, ssct, hzct, sslr }
}

/// The rows of table 5.8, in the order of print.
pub const TABLE_5_8: [Published; 10] = [
    row(640, 480, 0.0, 0.76, 0.69, 1.14),
    row(640, 480, 0.1, 0.81, 0.74, 0.68),
    row(800, 600, 0.0, 1.12, 1.02, 1.69),
    row(800, 600, 0.1, 1.17, 1.10, 0.99),
    row(960, 540, 0.0, 1.50, 1.10, 1.86),
    row(960, 540, 0.1, 1.54, 1.19, 1.09),
    row(1280, 768, 0.0, 2.45, 1.92, 3.31),
    row(1280, 768, 0.1, 2.66, 2.07, 1.95),
    row(1920, 1080, 0.0, 4.92, 4.07, 6.09),
    row(1920, 1080, 0.1, 5.30, 4.49, 4.02),
];

impl Published {
    /// The time of a method in milliseconds; `None` for a method that is not in the table.
    pub fn time_ms(&self, method: &str) -> Option<f64> {
        match method {
            "ssct" => Some(self.ssct),
            "hzct" => Some(self.hzct),
            "sslr" => Some(self.sslr),
            _ => None,
        }
    }
}

/// Returns the table's sizes in pixels, each once.
pub fn sizes() -> Vec<[u32; 2]> {
    let mut sizes: Vec<_> = TABLE_5_8.iter().map(|row| row.size).collect();
    sizes.dedup();
    sizes
}

/// Seconds that the measurement of each size took on two cores of a CPU, with the command's default numbers of frames.
/// The records are in benches/runs/2026-11-28-lavapipe/table-5.8-atrium (`tests/suite/time_files.rs` checks them).
pub const SECONDS: [u32; 5] = [15, 22, 22, 37, 80];

/// Lists the sizes of the table with the seconds that each takes, as the end of a sentence.
pub fn rows_and_seconds() -> String {
    let size = |([width, height], seconds): ([u32; 2], u32)| format!("{width}x{height} ({seconds} s)");
    let sizes: Vec<String> = sizes().into_iter().zip(SECONDS).map(size).collect();
    let roughness = ROUGHNESS.map(|r| r.to_string()).join(" and ");
    format!(
        "its sizes are {}, each with rows of roughness {roughness}; the seconds are those of two cores of a CPU without a GPU",
        sizes.join(", ")
    )
}

/// The table's roughness values.
pub const ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Returns the global factors of a row; the normal deviation is equal to the roughness, as in the thesis.
pub const fn factors(roughness: f32, reflectivity: f32) -> Globals {
    Globals { roughness: Some(roughness), reflectivity, normal_deviation: Some(roughness) }
}

/// Returns the methods of which the table has times.
pub fn methods() -> Vec<&'static MethodInfo> {
    METHODS.iter().filter(|m| TABLE_5_8[0].time_ms(m.name).is_some()).collect()
}

/// A row with printed and measured times and ratios. Ratios can be compared between machines; times cannot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedRow {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Roughness, which is also the normal deviation.
    pub roughness: f32,
    /// How much longer the scene passes took than in the first row of this size, as a share, if there are several rows of the
    /// size.
    pub drift: Option<f64>,
    /// Per method: name, published and measured milliseconds, and their ratios to the times of `ssct`.
    pub columns: Vec<Column>,
}

/// A method in a row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Column {
    /// Name of the method.
    pub method: String,
    /// Milliseconds in print; null for a size that is not in print.
    pub published_ms: Option<f64>,
    /// Median milliseconds here.
    pub measured_ms: f64,
    /// Ratio of the published time to SSCT's; null for SSCT itself, and for a size that is not in print.
    pub published_ratio: Option<f64>,
    /// Ratio of the measured time to SSCT's, the median over the turns in which both were timed; null for SSCT itself, or if
    /// SSCT was not measured.
    pub measured_ratio: Option<f64>,
    /// Ends of the interval of `measured_ratio`; null with fewer than [`MIN_SAMPLES`] turns.
    pub interval: Option<[f64; 2]>,
}

/// Lists the rows of the comparison: first the printed rows, in their order, and then measured rows whose size is not
/// in print. Each has a size in pixels, a roughness, and the printed row, if any.
fn rows_to_compare(records: &[TimeRecord]) -> Vec<([u32; 2], f32, Option<&'static Published>)> {
    let printed = TABLE_5_8.iter().map(|row| (row.size, row.roughness, Some(row)));
    let printed_sizes = sizes();
    let unprinted = |r: &TimeRecord| {
        let (size, roughness) = ([r.head.width, r.head.height], r.head.roughness?);
        (!printed_sizes.contains(&size) && ROUGHNESS.contains(&roughness)).then_some((size, roughness, None))
    };
    printed.chain(distinct(records.iter().filter_map(unprinted))).collect()
}

impl Column {
    /// Whether the column has ratios to SSCT; SSCT itself has none.
    fn has_ratio(&self) -> bool {
        self.method != "ssct"
    }
}

/// Compares measured records with the table's rows. Rows that were not measured are left out, and so are roughness values that
/// are not in print. A size that is not in print gets rows without printed figures.
pub fn compare(records: &[TimeRecord]) -> Vec<ComparedRow> {
    let drifts = drift(records);
    let rows = rows_to_compare(records).into_iter().filter_map(|(size, roughness, published)| {
        let is_of_row = |r: &TimeRecord| [r.head.width, r.head.height] == size && r.head.roughness == Some(roughness);
        let of_row: Vec<_> = records.iter().filter(|r| is_of_row(r)).collect();
        let drift = records.iter().zip(&drifts).find(|(r, _)| is_of_row(r)).and_then(|(_, drift)| *drift);
        let ssct = of_row.iter().copied().find(|r| r.head.method == "ssct");
        let columns: Vec<_> = of_row.iter().filter_map(|r| column(r, published, ssct)).collect();
        let [width, height] = size;
        (!columns.is_empty()).then_some(ComparedRow { width, height, roughness, drift, columns })
    });
    rows.collect()
}

/// Makes the column of a record from the printed row and from the record of SSCT in the same row, as far as they exist.
/// `None` for a method that is not in the table.
fn column(record: &TimeRecord, published: Option<&Published>, ssct: Option<&TimeRecord>) -> Option<Column> {
    let method = &record.head.method;
    TABLE_5_8[0].time_ms(method)?;
    let published_ms = published.and_then(|row| row.time_ms(method));
    let has_ratio = method != "ssct";
    let measured = ssct.filter(|_| has_ratio).and_then(|ssct| time_ratio(record, ssct));
    Some(Column {
        method: method.clone(),
        published_ms,
        measured_ms: record.total.median_ms,
        published_ratio: published_ms.zip(published).filter(|_| has_ratio).map(|(ms, row)| ms / row.ssct),
        measured_ratio: measured.map(|(ratio, _)| ratio),
        interval: measured.and_then(|(_, interval)| interval),
    })
}

/// Returns the ratio of a record's time to the time of `base`, with which the record was timed in turn, and the ends of
/// the ratio's interval, if there are enough turns. Records without samples have the ratio of their medians, without an
/// interval.
fn time_ratio(record: &TimeRecord, base: &TimeRecord) -> Option<(f64, Option<[f64; 2]>)> {
    let pairs: Vec<_> = base.totals().into_iter().zip(record.totals()).map(<[f64; 2]>::from).collect();
    if pairs.is_empty() {
        return Some((record.total.median_ms / base.total.median_ms, None));
    }
    let Ratio { ratio, low, high } = median_of_ratios(&pairs, SEED)?;
    Some((ratio, (pairs.len() >= MIN_SAMPLES).then_some([low, high])))
}

/// The title of the table beside our times.
pub const TITLE: &str = "Table 5.8 of the thesis, and the same here";

/// Returns the description of the table.
pub fn about() -> String {
    format!(
        "Medians of the effect without the scene passes. A quotient measured here is the median over the turns in which both methods \
         were timed, with the {} % interval in brackets; fewer than {MIN_SAMPLES} samples have none. Drift is how much longer the \
         passes of the scene, the same work in each row of a size, took than in the first row: by as much the machine had changed \
         between the two moments.",
        100.0 * CONFIDENCE
    )
}

/// Makes the cells of the comparison, header first: the printed and the measured time of each method, and both ratios
/// to SSCT of each other method.
pub fn cells(rows: &[ComparedRow]) -> Vec<Vec<String>> {
    let Some(first) = rows.first() else { return Vec::new() };
    let mut header = vec!["resolution".to_owned(), "roughness".to_owned()];
    for c in &first.columns {
        let name = c.method.to_uppercase();
        header.extend([format!("{name} thesis ms"), format!("{name} here ms")]);
    }
    for c in first.columns.iter().filter(|c| c.has_ratio()) {
        let name = c.method.to_uppercase();
        header.extend([format!("{name}/SSCT thesis"), format!("{name}/SSCT here")]);
    }
    let has_drift = rows.iter().any(|row| row.drift.is_some());
    header.extend(has_drift.then(|| "drift".to_owned()));
    let mut cells = vec![header];
    let number = |v: Option<f64>| v.map_or_else(|| "-".into(), |v| format!("{v:.2}"));
    for row in rows {
        let mut line = vec![format!("{} x {}", row.width, row.height), format!("{:.1}", row.roughness)];
        for c in &row.columns {
            line.extend([number(c.published_ms), number(Some(c.measured_ms))]);
        }
        for c in row.columns.iter().filter(|c| c.has_ratio()) {
            let interval = c.interval.map_or_else(String::new, |[low, high]| format!(" [{low:.2}, {high:.2}]"));
            line.extend([number(c.published_ratio), number(c.measured_ratio) + &interval]);
        }
        line.extend(has_drift.then(|| shown_drift(row.drift)));
        cells.push(line);
    }
    cells
}
