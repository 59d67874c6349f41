//! Plain data that studies show of their rows, and that reports write and draw: tables, charts, clips, and files beside
//! the records.

use super::columns::{Column, Columns};
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::video::Film;

/// A table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Name by which links find the table's heading on its page; each table of a page has another.
    pub id: &'static str,
    /// Title; empty for a table that is the only one of its page.
    pub title: String,
    /// Description of the table, in a paragraph.
    pub about: String,
    /// Rows of the table, header first.
    pub cells: Vec<Vec<String>>,
    /// Whether the table is too large for a terminal and is shown on the page alone.
    pub is_large: bool,
    /// Whether the cells are sentences. A terminal then shows the description, and below it a paragraph for each row.
    pub is_prose: bool,
}

impl Table {
    /// Makes a table that fits a terminal, from its cells, header first.
    pub fn new(id: &'static str, title: &str, about: &str, cells: Vec<Vec<String>>) -> Self {
        Self { id, title: title.to_owned(), about: about.to_owned(), cells, ..Self::default() }
    }

    /// Makes a table whose cells are sentences.
    pub fn of_sentences(id: &'static str, title: &str, about: &str, cells: Vec<Vec<String>>) -> Self {
        Self { is_prose: true, ..Self::new(id, title, about, cells) }
    }

    /// Makes a table with a line for each of `rows`, and with those of their columns that have a header.
    pub fn of_rows<R: Columns>(id: &'static str, rows: &[R]) -> Self {
        Self::with_columns(id, rows, [])
    }

    /// Makes a table with a line for each of `rows`, with those of their columns that have a header, and with the
    /// columns `further` behind them. Without rows the table has no header either.
    pub fn with_columns<R: Columns, const N: usize>(id: &'static str, rows: &[R], further: [Column<R>; N]) -> Self {
        let titled = R::columns().columns.into_iter().filter(|c| !c.title.is_empty());
        let columns: Vec<_> = titled.chain(further).collect();
        let header = columns.iter().map(|c| c.title.clone()).collect();
        let row_cells = |row: &R| columns.iter().map(|c| c.shown(row)).collect();
        let cells = std::iter::once(header).chain(rows.iter().map(row_cells));
        let cells = if rows.is_empty() { Vec::new() } else { cells.collect() };
        Self { id, cells, ..Self::default() }
    }
}

/// Returns the distinct values, in the order in which they first appear.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// Makes the cells of a table from two properties of rows. The table has a line for each value of the first property,
/// and a column for each value of the second, in the order in which they first appear. `cell_text` returns the text of
/// a cell from the rows that have both values; a cell without such rows or without a text is a dash. `corner` is the
/// header of the first column.
pub fn pivot<R>(
    corner: &str,
    rows: &[R],
    [line_property, column_property]: [&dyn Fn(&R) -> String; 2],
    cell_text: impl Fn(&[&R]) -> Option<String>,
) -> Vec<Vec<String>> {
    let line_names = distinct(rows.iter().map(line_property));
    let column_names = distinct(rows.iter().map(column_property));
    let header = std::iter::once(corner.to_owned()).chain(column_names.iter().cloned()).collect();
    let line = |line_name: String| {
        let line_rows: Vec<&R> = rows.iter().filter(|row| line_property(row) == line_name).collect();
        let cell = |column_name: &String| {
            let cell_rows: Vec<&R> =
                line_rows.iter().copied().filter(|row| column_property(row) == *column_name).collect();
            let text = if cell_rows.is_empty() { None } else { cell_text(&cell_rows) };
            text.unwrap_or_else(|| "-".to_owned())
        };
        std::iter::once(line_name.clone()).chain(column_names.iter().map(cell)).collect()
    };
    std::iter::once(header).chain(line_names.into_iter().map(line)).collect()
}

/// A chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// The name of the chart's file, without the ending.
    pub stem: String,
    /// Subject of the chart.
    pub title: String,
    /// Cells of a table of the points, header first; empty if the study's tables have them.
    pub cells: Vec<Vec<String>>,
    /// The values, and how they are drawn.
    pub drawing: Drawing,
}

impl Chart {
    /// Makes a chart whose values stand in the study's tables, too.
    pub fn new(stem: impl Into<String>, title: impl Into<String>, drawing: Drawing) -> Self {
        Self { stem: stem.into(), title: title.into(), cells: Vec::new(), drawing }
    }
}

/// The values of a chart. A pair of texts names the horizontal and the vertical axis.
#[derive(Debug, Clone)]
pub enum Drawing {
    /// Lines of values over frames.
    Lines([String; 2], Vec<Line>),
    /// Named points of cost against error, on log axes.
    Points([String; 2], Vec<NamedPoint>),
    /// Bars, each divided into the milliseconds of stages.
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

/// A bar that is made of stages, one behind the other.
#[derive(Debug, Clone)]
pub struct StageBar {
    /// Label above the bar.
    pub label: String,
    /// The stages with their milliseconds.
    pub stages: Vec<(String, f64)>,
}

/// Pictures, mostly animated, that a page shows beside each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClipGroup {
    /// Subject of the pictures.
    pub title: String,
    /// The pictures.
    pub clips: Vec<Clip>,
}

/// A picture, mostly animated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clip {
    /// File, relative to the page.
    pub file: String,
    /// Name of what is filmed.
    pub name: String,
    /// Caption below the picture.
    pub caption: String,
}

/// A CSV file beside the records.
pub struct Sheet {
    /// The name of the file.
    pub file: String,
    /// Subject of a row, as words that follow the name of the file.
    pub about: String,
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
    /// A picture: its width and height, and 3 bytes a pixel.
    Picture([u32; 2], Vec<u8>),
    /// A map: its width and height, a number for each pixel, and the name of the number.
    Map([u32; 2], Vec<f32>, &'static str),
    /// A film, and the number of its images that are shown each second.
    Film(Film, f32),
}

impl Content {
    /// Makes a picture of each pixel's error, 0 to 1, in the colours of FLIP; greater errors are shown as 1.
    pub fn heat([width, height]: [u32; 2], errors: &[f32]) -> Self {
        let map = FlipMap { width, height, errors: errors.iter().map(|e| e.clamp(0.0, 1.0)).collect() };
        Self::Picture([width, height], map.picture())
    }
}
