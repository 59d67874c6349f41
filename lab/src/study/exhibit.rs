//! What rows come to, as plain data that a report writes and draws: tables, charts, clips, and files beside the records.

use super::columns::{Column, Columns};
use crate::metrics::flip::FlipMap;
use crate::metrics::video::Film;

/// A table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Its place on a page, unlike that of any other there.
    pub id: &'static str,
    /// The title; a table that is all there is has none.
    pub title: String,
    /// What it says, in a paragraph.
    pub about: String,
    /// The rows, its header first.
    pub cells: Vec<Vec<String>>,
    /// Whether it is too large for a terminal, and stands on the page alone.
    pub is_large: bool,
    /// Whether its cells are sentences: a terminal shows a paragraph for each row, and what the table says above them.
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

    /// A row for each row, with the columns that have a header.
    pub fn of_rows<R: Columns>(id: &'static str, rows: &[R]) -> Self {
        Self::with_columns(id, rows, [])
    }

    /// A row for each row, with the columns that have a header, and some more. Without rows there is no header either.
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

/// Values without those that came before, in order.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut all = Vec::new();
    for value in values {
        if !all.contains(&value) {
            all.push(value);
        }
    }
    all
}

/// Cells with a row and a column for each value of two properties of some rows, in the order of the values; `meet` says
/// what stands where two of them meet.
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
    /// The name of its file, without the ending.
    pub stem: String,
    /// What it shows.
    pub title: String,
    /// The points as rows of a table, where no other table has them.
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
    /// Values over frames, a line each.
    Lines([String; 2], Vec<Line>),
    /// Cost against error on log axes, each point named.
    Points([String; 2], Vec<NamedPoint>),
    /// Milliseconds of the stages of each bar.
    Bars(Vec<StageBar>),
}

/// A line of a chart.
#[derive(Debug, Clone)]
pub struct Line {
    /// What the legend calls it.
    pub name: String,
    /// Frames and their values, ≥ 0.
    pub points: Vec<(f64, f64)>,
}

/// A point of a chart.
#[derive(Debug, Clone)]
pub struct NamedPoint {
    /// What it is called.
    pub name: String,
    /// Cost, above 0, and error, at least 0.
    pub position: [f64; 2],
    /// Whether nothing beats it in both.
    pub on_front: bool,
}

/// A bar of stages, one behind the other.
#[derive(Debug, Clone)]
pub struct StageBar {
    /// What stands above it.
    pub label: String,
    /// The stages with their milliseconds.
    pub stages: Vec<(String, f64)>,
}

/// Animated pictures that are looked at together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClipGroup {
    /// What they are of.
    pub title: String,
    /// The pictures.
    pub clips: Vec<Clip>,
}

/// An animated picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clip {
    /// File, relative to the page.
    pub file: String,
    /// What is filmed.
    pub name: String,
    /// What is known of it.
    pub caption: String,
}

/// Rows of a CSV file beside the records.
pub struct Sheet {
    /// The name of the file.
    pub file: String,
    /// The rows, its header first.
    pub cells: Vec<Vec<String>>,
}

/// A file that a measurement makes, beside its rows.
pub struct ExtraFile {
    /// Its path in the folder of the run, with slashes.
    pub path: String,
    /// What is in it.
    pub content: Content,
}

/// What is in a file of a measurement.
pub enum Content {
    /// A picture, 3 bytes a pixel.
    Picture([u32; 2], Vec<u8>),
    /// A number for each pixel, and its name.
    Map([u32; 2], Vec<f32>, &'static str),
    /// Finished images that are shown at so many a second.
    Film(Film, f32),
}

impl Content {
    /// An error of each pixel as a picture in FLIP's colours, where white is 1.
    pub fn heat([width, height]: [u32; 2], errors: &[f32]) -> Self {
        let map = FlipMap { width, height, errors: errors.iter().map(|e| e.clamp(0.0, 1.0)).collect() };
        Self::Picture([width, height], map.picture())
    }
}
