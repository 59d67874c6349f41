//! Results of rows as plain data that a report writes and draws: tables, charts, clips, and files beside the records.

use super::columns::{Column, Columns};
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::video::Film;

/// A table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Name of the table's heading in links of its page, unique there.
    pub id: &'static str,
    /// Title; empty for a table that is the only one.
    pub title: String,
    /// Description of the table, in a paragraph.
    pub about: String,
    /// Rows of the table, header first.
    pub cells: Vec<Vec<String>>,
    /// Whether the table is too large for a terminal and is shown on the page alone.
    pub is_large: bool,
    /// Whether the cells are sentences: a terminal then shows the table's description above them, and a paragraph for each row.
    pub is_prose: bool,
}

impl Table {
    /// A table that fits a terminal.
    pub fn new(id: &'static str, title: &str, about: &str, cells: Vec<Vec<String>>) -> Self {
        Self { id, title: title.to_owned(), about: about.to_owned(), cells, ..Self::default() }
    }

    /// A table whose cells are sentences.
    pub fn of_sentences(id: &'static str, title: &str, about: &str, cells: Vec<Vec<String>>) -> Self {
        Self { is_prose: true, ..Self::new(id, title, about, cells) }
    }

    /// A table with a line for each of `rows`, and the columns that have a header.
    pub fn of_rows<R: Columns>(id: &'static str, rows: &[R]) -> Self {
        Self::with_columns(id, rows, [])
    }

    /// A table with a line for each of `rows`, the columns that have a header, and some more. Without rows the table has no
    /// header either.
    pub fn with_columns<R: Columns, const N: usize>(id: &'static str, rows: &[R], more: [Column<R>; N]) -> Self {
        let own = R::columns().columns.into_iter().filter(|c| !c.title.is_empty());
        let columns: Vec<_> = own.chain(more).collect();
        let header = columns.iter().map(|c| c.title.clone()).collect();
        let row_cells = |row: &R| columns.iter().map(|c| c.shown(row)).collect();
        let cells = std::iter::once(header).chain(rows.iter().map(row_cells));
        let cells = if rows.is_empty() { Vec::new() } else { cells.collect() };
        Self { id, cells, ..Self::default() }
    }
}

/// Distinct values, in the order in which they first appear.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut all = Vec::new();
    for value in values {
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}

/// A table with a line and a column for each value of two properties of some rows, in the order of the values. `meet` gives the
/// text of a cell from the rows that have both values.
pub fn pivot<R>(
    corner: &str,
    rows: &[R],
    [down, across]: [&dyn Fn(&R) -> String; 2],
    meet: impl Fn(&[&R]) -> Option<String>,
) -> Vec<Vec<String>> {
    let (downs, acrosses) = (distinct(rows.iter().map(down)), distinct(rows.iter().map(across)));
    let header = std::iter::once(corner.to_owned()).chain(acrosses.iter().cloned()).collect();
    let line = |name: String| {
        let here: Vec<&R> = rows.iter().filter(|r| down(r) == name).collect();
        let cell = |title: &String| {
            let there: Vec<&R> = here.iter().copied().filter(|r| across(r) == *title).collect();
            (!there.is_empty()).then(|| meet(&there)).flatten().unwrap_or_else(|| "-".to_owned())
        };
        std::iter::once(name.clone()).chain(acrosses.iter().map(cell)).collect()
    };
    std::iter::once(header).chain(downs.into_iter().map(line)).collect()
}

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// The name of the chart's file, without the ending.
    pub stem: String,
    /// Subject of the chart.
    pub title: String,
    /// The points as rows of a table, if no other table has them.
    pub cells: Vec<Vec<String>>,
    /// The values, and how they are drawn.
    pub drawing: Drawing,
}

impl Chart {
    /// A chart whose values stand in the study's tables.
    pub fn new(stem: impl Into<String>, title: impl Into<String>, drawing: Drawing) -> Self {
        Self { stem: stem.into(), title: title.into(), cells: Vec::new(), drawing }
    }
}

/// The values of a chart. A pair of axes is the names of the horizontal and the vertical one.
#[derive(Debug, Clone)]
pub enum Drawing {
    /// Lines of values over frames.
    Lines([String; 2], Vec<Line>),
    /// Named points of cost against error, on log axes.
    Points([String; 2], Vec<NamedPoint>),
    /// Bars that are divided into the milliseconds of stages.
    Bars(Vec<StageBar>),
}

/// A line of a chart.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Frames and their values, ≥ 0.
    pub points: Vec<(f64, f64)>,
}

/// A point of a chart.
#[derive(Debug, Clone)]
pub struct NamedPoint {
    /// Name of the point.
    pub name: String,
    /// Cost, above 0, and error, at least 0.
    pub position: [f64; 2],
    /// Whether no other point is better in both cost and error.
    pub on_front: bool,
}

/// A bar of stages, one after the other.
#[derive(Debug, Clone)]
pub struct StageBar {
    /// Label above the bar.
    pub label: String,
    /// The stages with their milliseconds.
    pub stages: Vec<(String, f64)>,
}

/// Animated pictures that are shown beside each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClipGroup {
    /// Subject of the pictures.
    pub title: String,
    /// The pictures.
    pub clips: Vec<Clip>,
}

/// An animated picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clip {
    /// File, relative to the page.
    pub file: String,
    /// Name of what is filmed.
    pub name: String,
    /// Caption below the picture.
    pub caption: String,
}

/// Rows of a CSV file beside the records.
pub struct Sheet {
    /// The name of the file.
    pub file: String,
    /// Rows of the file, header first.
    pub cells: Vec<Vec<String>>,
}

/// A file that a measurement makes in addition to its rows.
pub struct ExtraFile {
    /// Path in the folder of the run, with slashes.
    pub path: String,
    /// Contents of the file.
    pub content: Content,
}

/// Contents of a file that a measurement makes.
pub enum Content {
    /// A picture, 3 bytes a pixel.
    Picture([u32; 2], Vec<u8>),
    /// A number for each pixel, and the name of the number.
    Map([u32; 2], Vec<f32>, &'static str),
    /// Finished images, with the number of images a second.
    Film(Film, f32),
}

impl Content {
    /// Picture of each pixel's error in FLIP's colours, where white is 1.
    pub fn heat([width, height]: [u32; 2], errors: &[f32]) -> Self {
        let map = FlipMap { width, height, errors: errors.iter().map(|e| e.clamp(0.0, 1.0)).collect() };
        Self::Picture([width, height], map.picture())
    }
}
