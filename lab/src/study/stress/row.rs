//! The rows of the stress study, and their tables: method × failure, violations, motions, and all cases.

use super::motion::MotionRecord;
use super::{AGREEMENT, COMPARED_PIXELS, JUDGED, StressRecord};
use crate::study::columns::{Column, ColumnSet, Columns};
use crate::study::engine::Row;
use crate::study::exhibit::{Table, distinct, pivot};
use crate::study::record::Provenance;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A row of the stress study: the record of a case, or of a motion of the camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StressRow {
    /// A case.
    Case(Box<StressRecord>),
    /// A motion.
    Motion(Box<MotionRecord>),
}

impl StressRow {
    /// Returns the record of a case; `None` for a motion.
    fn case(&self) -> Option<&StressRecord> {
        if let Self::Case(record) = self { Some(record) } else { None }
    }

    /// Returns the record of a motion; `None` for a case.
    fn motion(&self) -> Option<&MotionRecord> {
        if let Self::Motion(record) = self { Some(record) } else { None }
    }
}

/// Returns the records of cases among some rows.
fn case_records(rows: &[StressRow]) -> Vec<StressRecord> {
    rows.iter().filter_map(StressRow::case).cloned().collect()
}

/// The columns are those of cases, and are empty for motions; the times and ranges are those of both.
impl Columns for StressRow {
    fn columns() -> ColumnSet<Self> {
        let case_columns = StressRecord::columns();
        let row_column = |case_column: Column<StressRecord>| {
            let name = case_column.name.clone();
            Column::named(&name, move |row: &Self| row.case().map(|case| case_column.written(case)))
        };
        let columns = case_columns.columns.into_iter().map(row_column).collect();
        let motion_columns = MotionRecord::columns();
        let times = case_columns.times.into_iter().chain(motion_columns.times).collect();
        let ranges = case_columns.ranges.into_iter().chain(motion_columns.ranges).collect();
        ColumnSet { columns, times, ranges, series: None }
    }
}

const ABOUT_CASES: &str = "What each method made of it: the share of the compared hits that are the oracle's, before it \
    the shares of the image's pixels that are NaN, infinite (inf), negative (neg) or of exhausted rays (exh). Where no hits \
    are compared and no such pixel is, it is sound.";

const ABOUT_VIOLATIONS: &str = "Cases that are not passed and must be, and those that only took long: by the clock alone, which a \
    busy machine is enough for, and which fails nothing.";

impl Row for StressRow {
    const KIND: &'static str = "stress";
    const TITLE: &'static str = "Numerical stress";

    fn program(&self) -> &Provenance {
        match self {
            Self::Case(record) => &record.program,
            Self::Motion(record) => &record.program,
        }
    }

    /// Makes the tables of methods, of violations, of motions and of all cases.
    fn tables(rows: &[Self], settings: &Value) -> Vec<Table> {
        let rule = format!(
            "Pixels are counted on the host's bits, in the reflection and, where the lit colour is sound, in the image. Hits \
             are compared with oracle 1 where rays are defined, in {COMPARED_PIXELS} reflecting pixels drawn at random where \
             there are more. {JUDGED} passes a case with no such pixel and {} % of the hits \
             (disagreements that vanish when the ray's direction, its first depth or where it crosses the sides of pixels \
             changes by up to 16 units in the last place of an f32 are ties; each corner that it then passes is a choice of \
             its own); so do the methods that follow rays in captures, where captures stand in hard places, and those that \
             follow rays among triangles, whose mirror rays are held against the world's; the published methods need \
             only survive, and their counts are findings.",
            100.0 * AGREEMENT
        );
        let records = case_records(rows);
        let violated = Table::new("violations", "Violations", ABOUT_VIOLATIONS, violation_cells(&records));
        let motions: Vec<MotionRecord> = rows.iter().filter_map(Self::motion).cloned().collect();
        let motion_tables = if motions.is_empty() { Vec::new() } else { MotionRecord::tables(&motions, settings) };
        let every = Table::new("cases", "Every case", ABOUT_CASES, case_cells(&records));
        let mut all = vec![Table::new("methods", "Method × failure", &rule, method_cells(&records)), violated];
        all.extend(motion_tables);
        all.push(Table { is_large: true, ..every });
        all
    }

    /// Returns the file of the records of cases, and the file of the records of motions.
    fn files(rows: &[Self]) -> Vec<(&'static str, Vec<Self>)> {
        let (cases, motions) = rows.iter().cloned().partition(|row| row.case().is_some());
        vec![("stress", cases), ("motion", motions)]
    }

    /// Counts the cases that must pass and do not, and names the first, in a sentence; `None` if there is no such case.
    fn failure(rows: &[Self]) -> Option<String> {
        let violated: Vec<_> = rows.iter().filter_map(Self::case).filter(|r| r.judged && !r.pass).collect();
        let first = violated.first()?;
        let (count, method, case) = (violated.len(), &first.method, &first.case);
        Some(format!("{count} case(s) are not passed and must be, the first by {method}: {case}"))
    }
}

/// Makes the cells of a table with a line for each method: for each kind of wrong pixel, the number of these pixels
/// over all cases, and the number of cases that have some.
fn method_cells(records: &[StressRecord]) -> Vec<Vec<String>> {
    let header = ["method", "cases", "pass", "NaN", "infinite", "negative", "exhausted", "agreement %", "least %"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for name in distinct(records.iter().map(|r| &r.method)) {
        let of_method: Vec<&StressRecord> = records.iter().filter(|r| r.method == *name).collect();
        let counted = |wrong_pixels: fn(&StressRecord) -> usize| {
            let cases = of_method.iter().filter(|r| wrong_pixels(r) > 0).count();
            if cases == 0 {
                "0".into()
            } else {
                format!("{} px in {cases}", of_method.iter().map(|r| wrong_pixels(r)).sum::<usize>())
            }
        };
        let exhausted = if of_method.iter().any(|r| r.exhausted.is_some()) {
            counted(|r| r.exhausted.unwrap_or(0))
        } else {
            "-".into()
        };
        // The number of compared pixels of each case, and the share of them that agree.
        let agreements: Vec<(usize, f64)> = of_method.iter().filter_map(|r| r.compared.zip(r.hit_agreement)).collect();
        let (mut pixels, mut agreeing) = (0, 0.0);
        for &(compared, share) in &agreements {
            pixels += compared;
            agreeing += compared as f64 * share;
        }
        let percent = |v: f64| format!("{:.3}", 100.0 * v);
        let least = agreements.iter().map(|(_, share)| *share).reduce(f64::min);
        rows.push(vec![
            name.clone(),
            of_method.len().to_string(),
            of_method.iter().filter(|r| r.pass).count().to_string(),
            counted(|r| r.nan),
            counted(|r| r.inf),
            counted(|r| r.negative),
            exhausted,
            if pixels > 0 { percent(agreeing / pixels as f64) } else { "-".into() },
            least.map_or("-".into(), percent),
        ]);
    }
    rows
}

/// Makes the cells of a table with a line for each case that must pass and fails, or that took long.
fn violation_cells(records: &[StressRecord]) -> Vec<Vec<String>> {
    let header =
        ["method", "case", "why", "size", "NaN", "infinite", "negative", "exhausted", "agreement %", "ties", "ms"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for r in records.iter().filter(|r| r.judged && (!r.pass || r.slow)) {
        let or_dash = |v: Option<usize>| v.map_or("-".into(), |v| v.to_string());
        rows.push(vec![
            r.method.clone(),
            r.case.clone(),
            if r.pass { "the clock alone".into() } else { "the image".into() },
            format!("{}x{}", r.width, r.height),
            r.nan.to_string(),
            r.inf.to_string(),
            r.negative.to_string(),
            or_dash(r.exhausted),
            r.hit_agreement.map_or("-".into(), |h| format!("{:.3}", 100.0 * h)),
            or_dash(r.ties),
            format!("{:.1}", r.time_ms),
        ]);
    }
    rows
}

/// Makes the cells of a table with a line for each case and a column for each method, which say what was wrong.
fn case_cells(records: &[StressRecord]) -> Vec<Vec<String>> {
    let (case, method) = (|r: &StressRecord| r.case.clone(), |r: &StressRecord| r.method.clone());
    pivot("case", records, [&case, &method], |here| here.first().map(|r| summary(r)))
}

/// Says in a few words what was wrong with the frame of a record, and the share of its hits that agree; "sound" for
/// neither.
fn summary(r: &StressRecord) -> String {
    let share = |n: usize| format!("{:.2} %", 100.0 * n as f64 / r.pixels.max(1) as f64);
    let mut words: Vec<String> =
        [("NaN", r.nan), ("inf", r.inf), ("neg", r.negative), ("exh", r.exhausted.unwrap_or(0))]
            .into_iter()
            .filter(|(_, count)| *count > 0)
            .map(|(kind, count)| format!("{kind} {}", share(count)))
            .collect();
    words.extend(r.hit_agreement.map(|h| format!("{:.2} %", 100.0 * h)));
    words.extend(r.slow.then(|| "slow".to_owned()));
    if words.is_empty() { "sound".into() } else { words.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::gpu::DeviceInfo;

    /// Makes the row of a case that must pass; one that does not has a NaN.
    fn case(pass: bool, slow: bool) -> StressRow {
        let device = DeviceInfo { name: "d".into(), driver: "d".into(), api: "1.3".into(), kind: "CPU".into() };
        let program = Provenance { definitions: 2, version: "1".into(), commit: "c".into(), device };
        StressRow::Case(Box::new(StressRecord {
            kind: "stress".into(),
            program,
            case: "a case".into(),
            method: JUDGED.into(),
            width: 8,
            height: 8,
            setup: serde_json::Map::new(),
            pixels: 64,
            nan: usize::from(!pass),
            inf: 0,
            negative: 0,
            exhausted: None,
            compared: None,
            hit_agreement: None,
            ties: None,
            time_ms: 1e6,
            slow,
            judged: true,
            pass,
        }))
    }

    #[test]
    fn a_case_that_is_only_slow_is_named_so_and_fails_nothing() {
        let rows = [case(true, true), case(false, false), case(true, false)];
        let why: Vec<String> = violation_cells(&case_records(&rows)).iter().map(|row| row[2].clone()).collect();
        assert_eq!(why, ["why", "the clock alone", "the image"]);
        assert_eq!(StressRow::failure(&rows[..1]), None);
        assert!(StressRow::failure(&rows).is_some_and(|message| message.starts_with("1 case(s) are not passed")));
        let summaries: Vec<String> = case_records(&rows).iter().map(summary).collect();
        assert_eq!(summaries, ["slow", "NaN 1.56 %", "sound"]);
    }
}
