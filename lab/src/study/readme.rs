//! Compares the numbers that the README quotes with measurements on a device: which numbers are the same there, which
//! differ, and which are not measured.
//!
//! The README's numbers are medians over many views. Some of these views are measured again, and the medians over them
//! are compared with the medians over the same views in the README's own records. `make docs` writes the latter to
//! `readme.csv`.

use super::error::{ErrorRecord, ErrorReference, Variant};
use super::exhibit::Table;
use super::record::{Head, TimeRecord};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use ssct::methods::setup::{BeyondScreen, Stage};
use ssct::methods::{self, EffectParams, Setup};
use ssct_truth::metrics::bootstrap::median_of;

/// The README's numbers on each view, in the file that `make docs` writes.
const QUOTED: &str = include_str!("readme.csv");

/// The size at which the README's times were measured.
pub const TIMED_SIZE: [u32; 2] = [960, 540];
/// The size at which the README's errors and hits were measured.
pub const JUDGED_SIZE: [u32; 2] = [480, 270];
/// The views that are measured again: each a scene and a view.
pub const VIEWS: [[&str; 2]; 4] =
    [["rooms", "corridor"], ["atrium", "hall"], ["museum", "exit-sign"], ["street", "car"]];

/// The scenes among [`VIEWS`] that are in the README's table of the screen, where they have several roughness values.
/// The README's table of the triangles has mirrors alone.
pub const SCREEN_SCENES: [&str; 2] = ["rooms", "atrium"];

/// The greatest relative difference of a ratio of times from the README's that counts as the same.
const TIME_TOLERANCE: f64 = 0.1;
/// The greatest relative difference of a ratio of errors from the README's that counts as the same. The references'
/// rays differ on another device's G-buffer.
const ERROR_TOLERANCE: f64 = 0.05;
/// The greatest absolute difference of a share of rays from the README's that counts as the same.
const SHARE_TOLERANCE: f64 = 0.002;

/// A number of the README, with its value on one view in the README's records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Quoted")]
pub struct QuotedNumber {
    /// Table or text of the README that has the number.
    pub place: String,
    /// Row of the number in the table.
    pub row: String,
    /// Column of the number in the table.
    pub column: String,
    /// The number as the README has it, over all of the README's views.
    pub says: String,
    /// Kind of device that the number was measured on.
    pub measured_on: String,
    /// Kind of figure that the number is.
    pub figure: Figure,
    /// Variant whose figure the number is; empty if another command measures the number.
    pub variant: String,
    /// Variant whose figure is the divisor of a ratio; empty for a share.
    pub over: String,
    /// The other command that measures the number, if the number is not measured here; else empty.
    pub command: String,
    /// The roughness.
    pub roughness: Option<f32>,
    /// The scene.
    pub scene: String,
    /// The view.
    pub view: String,
    /// The number on the view; `None` if it is not measured here.
    pub value: Option<f64>,
}

/// Kind of figure that a number of the README is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Figure {
    /// Ratio of two times.
    Time,
    /// Ratio of two errors.
    Error,
    /// The share of mirror rays that end where they end in the world.
    Ends,
    /// The share of mirror rays that end where the oracle says.
    Hits,
    /// A figure that another command measures.
    Elsewhere,
}

/// Result of comparing a device's number with the README's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The difference is within the tolerance of the [`Figure`].
    Same,
    /// The difference exceeds the tolerance.
    Other,
    /// The number was not measured here.
    NotComparable,
}

impl Verdict {
    /// Returns the name in tables.
    fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Other => "other",
            Self::NotComparable => "not comparable",
        }
    }
}

/// A number of the README beside the number that a device measured.
#[derive(Debug, Clone, Serialize)]
pub struct ReadmeRecord {
    /// Always `readme`.
    pub kind: &'static str,
    /// The number, with its place in the README.
    #[serde(flatten)]
    pub quoted: QuotedNumber,
    /// Median in the README's records, over the views that were measured here.
    pub there: Option<f64>,
    /// Median in the measurements here, over the same views.
    pub here: Option<f64>,
    /// Number of the views that were measured here.
    pub views: usize,
    /// Verdict on the difference.
    pub verdict: Verdict,
}

/// Records that were measured here.
pub struct MeasuredRecords<'a> {
    /// Times of [`variants`].
    pub times: &'a [TimeRecord],
    /// Errors of [`variants`].
    pub errors: &'a [ErrorRecord],
}

/// Makes the variants of the README's tables, for a size in pixels. On a GPU, all run in compute shaders, for a fair
/// comparison. On a CPU, each runs in its default stage, as it did for the README.
///
/// # Errors
/// [`Usage`](ssct::Error::Usage) if a method of the tables does not exist.
pub fn variants(extent: [u32; 2], is_cpu: bool) -> Result<Vec<Variant>> {
    let plain = Setup::new(extent);
    let stage = if is_cpu { plain.effect().stage } else { Stage::Compute };
    let variant = |(method, beyond): (&str, Option<BeyondScreen>)| {
        let setup = plain.with(|p: &mut EffectParams| (p.stage, p.beyond) = (stage, beyond.unwrap_or(p.beyond)));
        Ok(Variant { method: methods::find(method)?, setup })
    };
    let screen = Some(BeyondScreen::None);
    [("ssct", None), ("hzct", None), ("unified", screen), ("unified", None), ("traced", None)]
        .into_iter()
        .map(variant)
        .collect()
}

/// The README's name of `unified` on the screen alone.
pub const ON_SCREEN: &str = "unified on the screen";

/// Returns the README's name of the variant that a record is about.
fn variant_name(head: &Head) -> String {
    let is_on_screen = head.method == "unified" && head.setting("beyond") == "none";
    if is_on_screen { ON_SCREEN.to_owned() } else { head.method.clone() }
}

impl MeasuredRecords<'_> {
    /// Returns the measured value of a number of the README, on its view; `None` if it was not measured.
    fn value(&self, quoted: &QuotedNumber) -> Option<f64> {
        let figure_of = |variant: &str| match quoted.figure {
            Figure::Time => {
                let mut records = self.times.iter().filter(|r| is_record_of(&r.head, quoted, variant));
                records.next().map(|r| r.total.median_ms)
            }
            Figure::Error => {
                let against = if quoted.variant == ON_SCREEN { ErrorReference::Screen } else { ErrorReference::World };
                let record = self.error_record(quoted, variant, against)?;
                // The variance of the reference is subtracted, since it is no error of the method.
                let noise = record.image.standard_error.unwrap_or_default();
                record.image.rmse.map(|rmse| (rmse * rmse - noise * noise).max(0.0).sqrt())
            }
            Figure::Ends => self.error_record(quoted, variant, ErrorReference::World)?.place_agreement,
            Figure::Hits => self.error_record(quoted, variant, ErrorReference::Oracle)?.hits.hit_agreement,
            Figure::Elsewhere => None,
        };
        let value = figure_of(&quoted.variant)?;
        if quoted.over.is_empty() {
            Some(value)
        } else {
            figure_of(&quoted.over).filter(|divisor| *divisor > 0.0).map(|divisor| value / divisor)
        }
    }

    /// Finds the record of a variant's error against a reference, on the view of a number of the README.
    fn error_record(&self, quoted: &QuotedNumber, variant: &str, against: ErrorReference) -> Option<&ErrorRecord> {
        self.errors.iter().find(|r| r.against == against && is_record_of(&r.head, quoted, variant))
    }
}

/// Whether a record is about the variant, and has the scene, view and roughness for which the README quotes the number.
fn is_record_of(head: &Head, quoted: &QuotedNumber, variant: &str) -> bool {
    let is_of_variant_on_view = head.scene == quoted.scene && head.view == quoted.view && variant_name(head) == variant;
    is_of_variant_on_view && head.roughness.zip(quoted.roughness).is_some_and(|(a, b)| (a - b).abs() < 1e-6)
}

/// Reads the README's numbers: for each number, its value on each of its views.
///
/// # Errors
/// [`Usage`](ssct::Error::Usage) if the file cannot be read, which a test excludes.
pub fn quoted_numbers() -> Result<Vec<QuotedNumber>> {
    let read = csv::Reader::from_reader(QUOTED.as_bytes()).into_deserialize().collect::<csv::Result<_>>();
    read.map_err(|e| Error::usage(format!("the README's numbers: {e}")))
}

/// Compares every number of the README with the measurements, and makes a record of each. A record has two medians over
/// the views that were measured: one of the README's own values, and one of the measured values.
///
/// # Errors
/// Errors of [`quoted_numbers`].
pub fn compare(measured: &MeasuredRecords) -> Result<Vec<ReadmeRecord>> {
    let mut records: Vec<ReadmeRecord> = Vec::new();
    let all = quoted_numbers()?;
    let is_same_cell =
        |a: &QuotedNumber, b: &QuotedNumber| (&a.place, &a.row, &a.column) == (&b.place, &b.row, &b.column);
    for views in all.chunk_by(is_same_cell) {
        // The README's value and the measured value on each view that was measured.
        let pairs: Vec<_> = views.iter().filter_map(|q| q.value.zip(measured.value(q))).collect();
        let medians =
            || (median_of(pairs.iter().map(|(there, _)| *there)), median_of(pairs.iter().map(|(_, here)| *here)));
        let both = (!pairs.is_empty()).then(medians);
        let verdict = both.map_or(Verdict::NotComparable, |both| verdict(views[0].figure, both));
        let (there, here) = both.unzip();
        let quoted = views[0].clone();
        records.push(ReadmeRecord { kind: "readme", quoted, there, here, views: pairs.len(), verdict });
    }
    Ok(records)
}

/// Says whether a number of the README's records and the number that was measured here are the same within the figure's
/// tolerance.
fn verdict(figure: Figure, (quoted, measured): (f64, f64)) -> Verdict {
    let is_same = match figure {
        Figure::Time => (measured / quoted - 1.0).abs() <= TIME_TOLERANCE,
        Figure::Error => (measured / quoted - 1.0).abs() <= ERROR_TOLERANCE,
        Figure::Ends | Figure::Hits => (measured - quoted).abs() <= SHARE_TOLERANCE,
        Figure::Elsewhere => return Verdict::NotComparable,
    };
    if is_same { Verdict::Same } else { Verdict::Other }
}

/// Makes the table of the comparison, in which numbers that can be compared come first.
pub fn table(records: &[ReadmeRecord]) -> Table {
    let about = format!(
        "A row has a number as the README says it, over all the README's views. Beside it stand two medians over the views that were \
         measured here: one by the README's records, and one of this device. Times are of {} x {} pixels, errors and rays of {} x \
         {}. Quotients of times are the same within {:.0} %, quotients of errors within {:.0} %, and shares of rays within {:.1} \
         points. Hits and errors carry over to other devices. Times and their quotients need not: what a stage costs beside \
         another depends on the device. In a \
         quick study, an error may be other because its references have few rays. A number is not comparable where no view here has it, \
         or where another command measures it, which the last column names.",
        TIMED_SIZE[0],
        TIMED_SIZE[1],
        JUDGED_SIZE[0],
        JUDGED_SIZE[1],
        100.0 * TIME_TOLERANCE,
        100.0 * ERROR_TOLERANCE,
        100.0 * SHARE_TOLERANCE,
    );
    let header = [
        "verdict",
        "where",
        "row",
        "what",
        "README",
        "README, these views",
        "here",
        "here / README",
        "views",
        "README measured on",
        "measured by",
    ];
    let mut cells = vec![header.map(str::to_owned).to_vec()];
    let (not_comparable, compared): (Vec<_>, Vec<_>) =
        records.iter().partition(|r| r.verdict == Verdict::NotComparable);
    for r in compared.into_iter().chain(not_comparable) {
        let is_share = matches!(r.quoted.figure, Figure::Ends | Figure::Hits);
        let shown = |value: Option<f64>| match value {
            None => "-".to_owned(),
            Some(share) if is_share => format!("{:.2} %", 100.0 * share),
            Some(ratio) => format!("{ratio:.2}"),
        };
        let quotient = r.here.zip(r.there).filter(|_| !is_share).map(|(here, there)| here / there);
        let q = &r.quoted;
        let mut row = vec![r.verdict.name().to_owned()];
        row.extend([&q.place, &q.row, &q.column, &q.says].map(Clone::clone));
        row.extend([shown(r.there), shown(r.here), shown(quotient), r.views.to_string(), q.measured_on.clone()]);
        row.push(match (q.command.is_empty(), r.views) {
            (true, 0) => "a whole study, not a quick one".to_owned(),
            (true, _) => "this study".to_owned(),
            _ => q.command.clone(),
        });
        cells.push(row);
    }
    Table::new("readme", "The README's numbers here", &about, cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_measured_on_the_views_here_or_names_another_command() {
        let all = quoted_numbers().unwrap();
        let names = ["ssct", "hzct", ON_SCREEN, "unified", "traced"];
        for q in &all {
            let is_elsewhere = q.figure == Figure::Elsewhere;
            assert_eq!([q.value.is_none(), !q.command.is_empty(), q.variant.is_empty()], [is_elsewhere; 3], "{q:?}");
            assert!(is_elsewhere || names.contains(&q.variant.as_str()), "{q:?}");
            assert!(q.over.is_empty() || names.contains(&q.over.as_str()), "{q:?}");
            assert!(is_elsewhere || VIEWS.contains(&[q.scene.as_str(), q.view.as_str()]), "{q:?}");
        }
        assert!(all.iter().filter(|q| q.figure == Figure::Time).count() > 20);
        assert!(all.iter().filter(|q| q.figure == Figure::Error).count() > 10);
    }

    #[test]
    fn a_number_is_the_same_within_the_tolerance_of_its_figure() {
        assert_eq!(verdict(Figure::Time, (0.40, 0.43)), Verdict::Same);
        assert_eq!(verdict(Figure::Time, (0.40, 0.45)), Verdict::Other);
        assert_eq!(verdict(Figure::Error, (0.40, 0.43)), Verdict::Other);
        assert_eq!(verdict(Figure::Ends, (0.999, 0.9975)), Verdict::Same);
        assert_eq!(verdict(Figure::Ends, (0.999, 0.99)), Verdict::Other);
    }

    #[test]
    fn without_measurements_no_number_is_comparable() {
        let records = compare(&MeasuredRecords { times: &[], errors: &[] }).unwrap();
        assert!(records.len() > 20 && records.iter().all(|r| r.verdict == Verdict::NotComparable && r.views == 0));
        let table = table(&records);
        assert_eq!(table.cells.len(), records.len() + 1);
        assert_eq!(table.cells[1][0], "not comparable");
    }
}
