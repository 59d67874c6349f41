//! The rows of the error study, with their tables and charts: run time against error for each reference, and the parts
//! of the error by roughness.

use super::ImageError;
use super::points::{self, FLOOR, Point};
use crate::study::columns::{AsDatum, Datum, columns, figure, part, time, times};
use crate::study::engine::Row;
use crate::study::exhibit::{Chart, Drawing, NamedPoint, Table};
use crate::study::names::cell_name;
use crate::study::record::{Head, Provenance};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use ssct::methods::Prepared;
use ssct_truth::metrics::{HitAgreement, pareto};
use std::collections::BTreeSet;

/// The reference that a record's figures are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename = "Against", rename_all = "lowercase")]
pub enum ErrorReference {
    /// The hits are compared with those of the oracle, in the record's version; mirrors only.
    Oracle,
    /// The image is compared with the screen reference of the record's version of the oracle, in which a miss is black;
    /// not for variants that see more than the screen.
    Screen,
    /// The image is compared with the world reference, in which a ray that leaves the scene brings the environment. The
    /// hits of mirrors are compared with those among the triangles.
    World,
}

impl ErrorReference {
    /// Returns the name in tables and files.
    pub fn name(self) -> &'static str {
        REFERENCES.iter().find(|(reference, ..)| *reference == self).map_or("", |(_, name, _)| name)
    }
}

impl AsDatum for ErrorReference {
    fn datum(&self) -> Datum {
        Datum::Text(self.name().to_owned())
    }
}

columns! {
    /// The run time of a subject, and its errors against one reference. A value without a meaning is null.
    pub struct ErrorRecord {
        /// Subject of the record.
        #[serde(flatten)]
        pub head: Head = part(),
        /// Median of the method's total time in milliseconds; null for a subject that is no method.
        pub time_ms: Option<f64> = time(""),
        /// Lower end of the interval of that median over resamples of the frames; null with fewer than five frames.
        #[serde(default)]
        pub time_low_ms: Option<f64> = time(""),
        /// Upper end of that interval.
        #[serde(default)]
        pub time_high_ms: Option<f64> = time(""),
        /// The reference.
        pub against: ErrorReference = figure(""),
        /// Hits against the oracle's, or (without distances) against the world's.
        #[serde(flatten)]
        pub hits: HitAgreement = part(),
        /// Errors of the image.
        #[serde(flatten)]
        pub image: ImageError = part(),
        /// Against the world: the share of mirror rays that the method ends where they end among the triangles.
        pub place_agreement: Option<f64> = figure(""),
        /// Against the world: the RMSE of the floor of the screen's picture, the same for all methods.
        pub floor: Option<f64> = figure(""),
        /// Time and memory of the data that the method made from the scene before the first frame; null for a subject
        /// that is no method.
        pub prepared: Option<Prepared> = times(),
    }
}

/// The three references, with their names and the vertical axes of their charts.
const REFERENCES: [(ErrorReference, &str, &str); 3] = [
    (ErrorReference::Oracle, "oracle", "share of wrong hits against the oracle (roughness 0)"),
    (ErrorReference::Screen, "screen", "RMSE against the screen reference"),
    (ErrorReference::World, "world", WORLD_AXIS),
];

/// The vertical axis of error against the world.
const WORLD_AXIS: &str = "RMSE against the world reference";

/// The horizontal axis of run time against error.
const TIME_AXIS: &str = "milliseconds, median";

const ABOUT: &str = "The error is the mean over the cells, the time the median. A point is on the front (marked by *, and red in \
    the charts) unless another one has no greater error, is not slower, and is better in one of the two. A time is smaller than \
    another where their intervals lie apart, so that of two copies of a method neither beats the other.";

const ABOUT_SOURCES: &str = "RMSE of the reflection colour, median over the views. Against the screen reference, the row \
    exact-hits+cone has every hit right, so what is left there is what the cone gets wrong; what a method has on top of it \
    comes from its wrong hits. The row screen-reference against the world is what screen space itself costs: it traces the \
    G-buffer exactly, and still differs by that much from the triangles. The floor of the screen shows the screen's colour \
    wherever the screen shows what a ray meets, and the truth elsewhere: hits on the screen cannot be nearer to the world \
    than that. A ray ends in the right place if it ends within 2 % of its length and 2 cm of where it ends among the \
    triangles.";

impl Row for ErrorRecord {
    const KIND: &'static str = "error";
    const TITLE: &'static str = "Run time against error";
    const FOLDERS: &'static [&'static str] = &[super::pictures::IMAGES];

    fn program(&self) -> &Provenance {
        &self.head.program
    }

    /// Makes a table of points for each reference that the rows have; the table marks the points on the Pareto front.
    fn tables(rows: &[Self], _: &Value) -> Vec<Table> {
        let table = |(against, id, axis): (ErrorReference, &'static str, &str)| {
            let points = points::points(rows, against);
            // A reference may be that of some cells alone, as the oracle is that of mirrors.
            let averaged = rows.iter().filter(|r| r.against == against && points::is_averaged(r));
            let cell_count = averaged.map(name_of_cell).collect::<BTreeSet<_>>().len();
            let about =
                if cell_count == 1 { format!("One cell. {ABOUT}") } else { format!("{cell_count} cells. {ABOUT}") };
            let title = format!("{axis}, mean over the cells; * is on the Pareto front");
            let floor = points::floor(rows).filter(|_| against == ErrorReference::World);
            let cells = point_cells(&points, floor);
            (!points.is_empty()).then(|| Table::new(id, &title, &about, cells))
        };
        REFERENCES.into_iter().filter_map(table).collect()
    }

    /// Makes the table of the parts of the error. A measurement that several devices made counts once.
    fn common_tables(rows: &[Self]) -> Vec<Table> {
        if rows.is_empty() { Vec::new() } else { vec![source_table(&one_of_each(rows))] }
    }

    /// Makes a chart for each reference that the rows have, and one of error over the bytes of the data that variants
    /// prepare before the first frame (`bytes_against_error`).
    fn charts(rows: &[Self]) -> Vec<Chart> {
        let chart = |(against, name, axis): (ErrorReference, &str, &str)| {
            let points = points::points(rows, against);
            let named_point =
                |p: &Point| NamedPoint { name: p.name.clone(), position: [p.time_ms, p.error], on_front: p.on_front };
            let axes = [TIME_AXIS, axis].map(str::to_owned);
            let drawing = Drawing::Points(axes, points.iter().map(named_point).collect());
            let title = format!("Run time against {axis}");
            (!points.is_empty()).then(|| Chart::new(format!("error-{name}"), title, drawing))
        };
        let bytes_chart = bytes_against_error(&points::points(rows, ErrorReference::World));
        REFERENCES.into_iter().filter_map(chart).chain(bytes_chart).collect()
    }
}

/// Makes the chart of prepared bytes against error, without variants that prepare nothing. `None` if all others prepare
/// equally many bytes, which a column of the table shows, too.
fn bytes_against_error(points: &[Point]) -> Option<Chart> {
    let prepared_mib = |p: &Point| p.prepared.map_or(0.0, |(bytes, _)| bytes / MIB);
    let points: Vec<&Point> = points.iter().filter(|p| prepared_mib(p) > 0.0).collect();
    if points.iter().all(|p| prepared_mib(p) == prepared_mib(points[0])) {
        return None;
    }
    let front = pareto::front(&points.iter().map(|p| (prepared_mib(p), p.error)).collect::<Vec<_>>());
    let named_point = |(index, p): (usize, &&Point)| NamedPoint {
        name: p.name.clone(),
        position: [prepared_mib(p), p.error],
        on_front: front.contains(&index),
    };
    let axes = ["MiB on the device, prepared", WORLD_AXIS].map(str::to_owned);
    let drawing = Drawing::Points(axes, points.iter().enumerate().map(named_point).collect());
    Some(Chart::new("error-world-bytes", format!("Prepared bytes against {WORLD_AXIS}"), drawing))
}

/// Returns the name of the cell in which a record was measured.
fn name_of_cell(r: &ErrorRecord) -> String {
    cell_name(&r.head.scene, &r.head.view, [r.head.width, r.head.height], r.head.roughness)
}

/// Keeps the first of the records that several devices made of one measurement, since an error is the same on all
/// devices.
fn one_of_each(records: &[ErrorRecord]) -> Vec<ErrorRecord> {
    let mut seen = BTreeSet::new();
    let is_first = |r: &&ErrorRecord| {
        let setup = serde_json::to_string(&r.head.setup).unwrap_or_default();
        seen.insert(format!("{} {} {:?} {:?} {setup}", name_of_cell(r), r.head.method, r.head.preset, r.against))
    };
    records.iter().filter(is_first).cloned().collect()
}

/// Bytes in a mebibyte.
const MIB: f64 = (1 << 20) as f64;

/// Makes the cells of a table with a row for each point, and a last row for the floor, if given. Place agreement,
/// prepared data and further figures have columns if a point has any.
fn point_cells(points: &[Point], floor: Option<f64>) -> Vec<Vec<String>> {
    let has_places = points.iter().any(|p| p.place_agreement.is_some());
    let has_prepared = points.iter().any(|p| p.prepared.is_some_and(|(bytes, _)| bytes > 0.0));
    // Makes a row of seven cells, without those that no point has, and of the cells `more` of further figures.
    let make_row = |[name, time, error, front, place, bytes, prepared_ms]: [String; 7], more: Vec<String>| {
        let leading = [name, time, error, front].into_iter().chain(has_places.then_some(place));
        leading.chain([bytes, prepared_ms].into_iter().filter(|_| has_prepared)).chain(more).collect::<Vec<_>>()
    };
    // Further figures that some point has, with their places in a point's list.
    let columns: Vec<_> = points::more_columns()
        .into_iter()
        .enumerate()
        .filter(|(index, _)| points.iter().any(|p| p.more.get(*index).is_some_and(Option::is_some)))
        .collect();
    let point_row = |p: &Point| {
        let front = if p.on_front { "*" } else { "" };
        let place = p.place_agreement.map_or_else(|| "-".into(), |share| format!("{:.1} %", 100.0 * share));
        let (bytes, prepared_ms) = p.prepared.unwrap_or_default();
        let [time, error] = [format!("{:.3}", p.time_ms), format!("{:.4}", p.error)];
        let [mib, prepared_ms] = [format!("{:.1}", bytes / MIB), format!("{prepared_ms:.0}")];
        let more = columns.iter().map(|(index, column)| column.shown_number(p.more[*index])).collect();
        make_row([p.name.clone(), time, error, front.to_owned(), place, mib, prepared_ms], more)
    };
    let headers = ["variant", "median ms", "mean error", "front", "right places, r 0", "prepared MiB", "prepared ms"];
    let dash = || "-".to_owned();
    let floor_row = floor.map(|error| {
        let cells = [FLOOR.into(), dash(), format!("{error:.4}"), String::new(), dash(), dash(), dash()];
        make_row(cells, vec![dash(); columns.len()])
    });
    let header = make_row(headers.map(str::to_owned), columns.iter().map(|(_, column)| column.title.clone()).collect());
    std::iter::once(header).chain(points.iter().map(point_row)).chain(floor_row).collect()
}

/// Makes the table of the parts of the error, with its description.
pub fn source_table(records: &[ErrorRecord]) -> Table {
    Table::new(
        "sources",
        "Where the error comes from: the median over the views",
        ABOUT_SOURCES,
        points::source_cells(records),
    )
}
