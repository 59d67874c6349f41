//! The engine of studies: everything that all studies have in common. A study says which cells it has and how one cell is
//! measured. The engine makes the list of cells, the journal and its keys, shards, what is left to measure, and the rows of a
//! journal. `report::results` makes tables, files and pages of the rows, and `app::measure` runs the engine from flags.

use super::cell_list::{CellList, CellListHead, ListedResult, PlannedCell};
use super::columns::Columns;
use super::exhibit::{Chart, ClipGroup, ExtraFile, Sheet, Table};
use super::interleave;
use super::journal::{self, Journal, digest, scene_digest};
use super::merge::MergeInput;
use super::record::{DEFINITIONS, Provenance};
use super::shard::Shard;
use super::sound;
use crate::error::Result;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use ssct::gpu::Gpu;
use ssct_scenes::Scene;
use std::collections::HashSet;

/// A study: cells that are measured one after the other.
pub trait Study {
    /// The type of a cell; cells are measured one after the other.
    type Cell;
    /// The type of a row, which is the result of a measurement.
    type Row: Row;

    /// Every cell, in the order of its rows.
    fn cells(&self) -> Vec<Planned<Self::Cell>>;

    /// The scenes, whose digests tell studies apart.
    fn scenes(&self) -> Vec<&Scene>;

    /// Settings that tables depend on, and that are not part of any cell.
    fn settings(&self) -> Value {
        Value::Null
    }

    /// The keys of the cell's results in the journal, each with the fields of its row that are missing in the journal.
    fn results(&self, gpu: &Gpu, cell: &Planned<Self::Cell>) -> Vec<(String, Value)> {
        vec![(cell.key::<Self::Row>(gpu), Value::Null)]
    }

    /// Number of steps of the progress bar that a cell takes. The engine advances the bar for a cell of one step; a
    /// cell of more steps advances the bar itself.
    fn steps(&self, _cell: &Self::Cell) -> usize {
        1
    }

    /// Measures a cell.
    ///
    /// # Errors
    /// Errors of the device, and those of [`Bench::go_on`], which end the study.
    fn measure(&mut self, cell: &Self::Cell, bench: &mut Bench) -> Result<Vec<Self::Row>>;
}

/// A cell, before the study is divided.
pub struct Planned<C> {
    /// The name, for people.
    pub name: String,
    /// Everything, except the device and the program, that the result depends on.
    pub setup: Value,
    /// The cell as the study measures it.
    pub cell: C,
}

impl<C> Planned<C> {
    /// The key under which the journal keeps the result that a device measures.
    pub fn key<R: Row>(&self, gpu: &Gpu) -> String {
        format!("{} {} {}", R::KIND, self.name, digest(gpu, &self.setup))
    }
}

/// The result of a study: a JSON record whose fields are columns.
pub trait Row: Columns + Serialize + DeserializeOwned + Clone {
    /// The kind of study, which names its files and, if the study has no other kinds of records, its records.
    const KIND: &'static str;
    /// The title of the study's page.
    const TITLE: &'static str;
    /// Folders of files that measurements make in addition to rows.
    const FOLDERS: &'static [&'static str] = &[];
    /// Whether measurements return no rows, but keep samples in the journal, from which [`Row::read`] makes rows.
    const IS_SAMPLED: bool = false;

    /// The program and the device that measured the row.
    fn program(&self) -> &Provenance;

    /// Tables of rows that one device measured.
    fn tables(rows: &[Self], _settings: &Value) -> Vec<Table> {
        vec![Table::of_rows("table", rows)]
    }

    /// Tables of figures alone, over the rows of all devices.
    fn common_tables(_rows: &[Self]) -> Vec<Table> {
        Vec::new()
    }

    /// Charts of rows that one device measured.
    fn charts(_rows: &[Self]) -> Vec<Chart> {
        Vec::new()
    }

    /// Animated pictures that measurements made.
    fn clips(_rows: &[Self]) -> Vec<ClipGroup> {
        Vec::new()
    }

    /// Further CSV files, beside the file of the rows and the file of their series.
    fn sheets(_rows: &[Self]) -> Vec<Sheet> {
        Vec::new()
    }

    /// The files of records, without their ending, with the rows of each.
    fn files(rows: &[Self]) -> Vec<(&'static str, Vec<Self>)> {
        vec![(Self::KIND, rows.to_vec())]
    }

    /// Says what is wrong, if rows have to pass a test and fail it.
    fn failure(_rows: &[Self]) -> Option<String> {
        None
    }

    /// Whether a journal has a complete result in a readable form.
    fn is_whole(_list: &CellList, result: &ListedResult, journal: &Journal) -> bool {
        kept::<Self>(journal, &result.key).is_some()
    }

    /// The rows of a result that a journal has, which may be incomplete.
    fn read(_list: &CellList, result: &ListedResult, journal: &Journal) -> Vec<Self> {
        kept(journal, &result.key).unwrap_or_default()
    }
}

/// The device, journal and callbacks that a study measures with.
pub struct Bench<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The results that were measured until now.
    pub journal: &'a mut Journal,
    /// Fails once a signal asked to stop. Measurements call it between two steps of a measurement.
    pub go_on: fn() -> Result<()>,
    /// Moves the progress bar on by some steps.
    pub advance: &'a mut dyn FnMut(usize),
    /// Keeps a file that a measurement makes in addition to its rows.
    pub keep: &'a mut dyn FnMut(&ExtraFile) -> Result<()>,
}

impl Bench<'_> {
    /// Advances the progress bar by one step, and fails if a signal asked to stop.
    ///
    /// # Errors
    /// Errors of [`Bench::go_on`].
    pub fn step(&mut self) -> Result<()> {
        (self.advance)(1);
        (self.go_on)()
    }
}

/// The value that was made last, which is kept until another key is asked for.
pub struct LastMade<K, T>(Option<(K, T)>);

impl<K, T> Default for LastMade<K, T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, T> LastMade<K, T> {
    /// The last value, if it was made for this key. Otherwise the last value is dropped first, to free its memory, and a new
    /// one is made.
    ///
    /// # Errors
    /// Errors of `make`.
    pub fn get_or_make<E>(&mut self, key: K, make: impl FnOnce() -> Result<T, E>) -> Result<&mut T, E> {
        let kept = self.0.take().filter(|(known, _)| *known == key);
        let (key, made) = match kept {
            Some(same) => same,
            None => (key, make()?),
        };
        Ok(&mut self.0.insert((key, made)).1)
    }

    /// Drops the last value, to free its memory.
    pub fn forget(&mut self) {
        self.0 = None;
    }
}

/// Lists a study's cells for a run on a device; `shard` says which of them the run owns, and `command` is the command of the
/// whole study.
pub fn list<S: Study>(study: &S, gpu: &Gpu, command: String, shard: Option<Shard>) -> CellList {
    let planned = |cell: Planned<S::Cell>| {
        let results = study.results(gpu, &cell);
        PlannedCell { name: cell.name, setup: cell.setup, results }
    };
    let head = CellListHead {
        kind: S::Row::KIND,
        definitions: DEFINITIONS,
        command,
        shard,
        settings: study.settings(),
        scenes: study.scenes().into_iter().map(|scene| (scene.name.clone(), scene_digest(scene))).collect(),
    };
    CellList::new(head, gpu.info(), study.cells().into_iter().map(planned).collect())
}

/// Steps of the progress bar over the cells that a run owns.
pub fn steps<S: Study>(study: &S, list: &CellList) -> usize {
    list.own(&study.cells()).map(|planned| study.steps(&planned.cell)).sum()
}

/// Measures every cell of a list that the run owns and that the journal lacks.
///
/// # Errors
/// Errors of a measurement, of the journal, and of [`Bench::go_on`].
pub fn measure<S: Study>(study: &mut S, list: &CellList, bench: &mut Bench) -> Result<()> {
    for (planned, listed) in study.cells().iter().zip(&list.cells).filter(|(_, listed)| listed.own) {
        let steps = study.steps(&planned.cell);
        if listed.results.iter().all(|result| S::Row::is_whole(list, result, bench.journal)) {
            (bench.advance)(steps);
            continue;
        }
        let rows = study.measure(&planned.cell, bench)?;
        if let Some(result) = listed.results.first().filter(|_| !(S::Row::IS_SAMPLED && rows.is_empty())) {
            bench.journal.put(result.key.clone(), &rows)?;
        }
        if steps == 1 {
            bench.step()?;
        }
    }
    Ok(())
}

/// The rows that a journal keeps under a key; `None` if the journal has no entry there, or an unreadable one.
pub fn kept<R: Row>(journal: &Journal, key: &str) -> Option<Vec<R>> {
    journal.value(key).and_then(|value| rows_of(value).ok())
}

/// Reads rows from a value of a journal.
///
/// # Errors
/// Why the value is no list of rows, as the end of a sentence about it.
pub fn rows_of<R: Row>(value: &Value) -> std::result::Result<Vec<R>, String> {
    let rows = Vec::deserialize(value).map_err(|e| format!("is no list of records of this study: {e}"))?;
    value.as_array().into_iter().flatten().find_map(sound::fault::<R>).map_or(Ok(rows), Err)
}

/// The keys of a list's results.
pub fn keys_of(list: &CellList) -> HashSet<&str> {
    list.cells.iter().flat_map(|cell| &cell.results).map(|result| result.key.as_str()).collect()
}

/// Whether a key is that of a sample: the key of one of the results, followed by one or two words.
fn is_sample(results: &HashSet<&str>, key: &str) -> bool {
    key.rmatch_indices(' ').take(2).any(|(end, _)| results.contains(&key[..end]))
}

/// The keys of a list whose entries in the journal cannot be read, so that the results are measured again.
pub fn unreadable<R: Row>(list: &CellList, journal: &Journal) -> Vec<String> {
    let keys = keys_of(list);
    let is_unread = |key: &&str| match journal.value(key) {
        Some(value) if keys.contains(key) => rows_of::<R>(value).is_err(),
        Some(value) if R::IS_SAMPLED && is_sample(&keys, key) => interleave::sample_of(value).is_err(),
        _ => false,
    };
    let mut found: Vec<String> = journal.keys().filter(is_unread).map(str::to_owned).collect();
    found.sort_unstable();
    found
}

/// Checks every entry of a run's journal that belongs to its results, and the rows that follow from the entries.
///
/// # Errors
/// The line, if known, and what is wrong with it, as the end of a sentence about it.
pub fn check<R: Row>(input: &MergeInput) -> std::result::Result<(), (Option<usize>, String)> {
    let keys = keys_of(&input.cells);
    for line in &input.lines {
        let Some((key, value)) = journal::entry(&line.text) else { continue };
        let wrong = |why: String| (Some(line.number), format!("the value of {key:?} {why}"));
        if keys.contains(key.as_str()) {
            rows_of::<R>(&value).map_err(wrong)?;
        } else if R::IS_SAMPLED && is_sample(&keys, &key) {
            interleave::sample_of(&value).map_err(wrong)?;
        }
    }
    // Rows made of samples also take fields from the list of cells, which are checked here.
    let results = input.cells.cells.iter().flat_map(|cell| &cell.results);
    let rows = results.flat_map(|result| R::read(&input.cells, result, &input.journal));
    let fault = rows.map(|row| json!(row)).find_map(|row| sound::fault::<R>(&row));
    fault.map_or(Ok(()), |why| Err((None, format!("a record that follows from its cells {why}"))))
}

/// The rows of all results that a journal has of a run, in the order of the list.
pub fn rows<R: Row>(list: &CellList, journal: &Journal) -> Vec<R> {
    let results = list.cells.iter().filter(|cell| cell.own).flat_map(|cell| &cell.results);
    results.flat_map(|result| R::read(list, result, journal)).collect()
}

/// The names of the cells that a run owns and has not measured.
pub fn missing<R: Row>(list: &CellList, journal: &Journal) -> Vec<String> {
    let own = list.cells.iter().filter(|cell| cell.own);
    let lacks = own.filter(|cell| !cell.results.iter().all(|result| R::is_whole(list, result, journal)));
    lacks.map(|cell| cell.name.clone()).collect()
}
