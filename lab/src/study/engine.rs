//! The engine of studies: everything that all studies have in common. A study says which cells it has and how one cell
//! is measured. The engine lists the cells, divides them into shards, finds what is left to measure, measures it, keeps
//! results in the journal, and makes rows of the journal. `report::results` makes tables, files and pages of the rows,
//! and `app::measure` runs the engine from flags.

use super::cell_list::{CellList, CellListHead, ListedCell, ListedResult, PlannedCell};
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
    /// The type of a cell.
    type Cell;
    /// The type of a row, which is the result of a measurement.
    type Row: Row;

    /// Returns every cell, in the order in which the results list the cells' rows.
    fn cells(&self) -> Vec<Planned<Self::Cell>>;

    /// Returns the scenes; runs whose scenes have different digests belong to different studies.
    fn scenes(&self) -> Vec<&Scene>;

    /// Returns settings that tables depend on, and that are not part of any cell.
    fn settings(&self) -> Value {
        Value::Null
    }

    /// Returns the key in the journal of each of the cell's results, each with the first fields of the result's record
    /// ([`ListedResult::record_head`]).
    fn results(&self, gpu: &Gpu, cell: &Planned<Self::Cell>) -> Vec<(String, Value)> {
        vec![(cell.key::<Self::Row>(gpu), Value::Null)]
    }

    /// Returns the number of steps of the progress bar that a cell takes. For a cell of one step, the engine advances
    /// the bar; for a cell of more steps, [`Study::measure`] does.
    fn steps(&self, _cell: &Self::Cell) -> usize {
        1
    }

    /// Measures a cell, and returns its rows; no rows if [`Row::IS_SAMPLED`] and its samples are in the journal.
    ///
    /// # Errors
    /// Errors of the device, and those of [`Bench::go_on`], which end the study.
    fn measure(&mut self, cell: &Self::Cell, bench: &mut Bench) -> Result<Vec<Self::Row>>;
}

/// A cell of the whole study, before the study is divided into shards.
pub struct Planned<C> {
    /// The name, for people.
    pub name: String,
    /// Everything, except the device and the program, that the result depends on.
    pub setup: Value,
    /// The cell as the study measures it.
    pub cell: C,
}

impl<C> Planned<C> {
    /// Returns the key under which the journal keeps the result of the cell on a device.
    pub fn key<R: Row>(&self, gpu: &Gpu) -> String {
        format!("{} {} {}", R::KIND, self.name, digest(gpu, &self.setup))
    }
}

/// The result of a study: a JSON record whose fields are columns.
pub trait Row: Columns + Serialize + DeserializeOwned + Clone {
    /// The kind of study, by which its files are named. It is also the kind of its records, unless they have several
    /// kinds.
    const KIND: &'static str;
    /// The title of the study's page.
    const TITLE: &'static str;
    /// Folders of files that measurements make in addition to rows.
    const FOLDERS: &'static [&'static str] = &[];
    /// Whether measurements return no rows, but keep samples in the journal, from which [`Row::read`] makes rows.
    const IS_SAMPLED: bool = false;

    /// Returns the program and the device that measured the row.
    fn program(&self) -> &Provenance;

    /// Makes tables of rows that one device measured. The settings are those of [`Study::settings`].
    fn tables(rows: &[Self], _settings: &Value) -> Vec<Table> {
        vec![Table::of_rows("table", rows)]
    }

    /// Makes tables over the rows of all devices, which show figures and no times.
    fn common_tables(_rows: &[Self]) -> Vec<Table> {
        Vec::new()
    }

    /// Makes charts of rows that one device measured.
    fn charts(_rows: &[Self]) -> Vec<Chart> {
        Vec::new()
    }

    /// Returns the pictures, animated or not, that measurements made and that pages show.
    fn clips(_rows: &[Self]) -> Vec<ClipGroup> {
        Vec::new()
    }

    /// Makes further CSV files, beside the file of the rows and the file of their series.
    fn sheets(_rows: &[Self]) -> Vec<Sheet> {
        Vec::new()
    }

    /// Returns the name of each file of records, without its ending, with the rows that it has.
    fn files(rows: &[Self]) -> Vec<(&'static str, Vec<Self>)> {
        vec![(Self::KIND, rows.to_vec())]
    }

    /// Says what is wrong if the rows fail a test that they have to pass; else `None`.
    fn failure(_rows: &[Self]) -> Option<String> {
        None
    }

    /// Whether a journal has all of a result, in a readable form.
    fn is_whole(_list: &CellList, result: &ListedResult, journal: &Journal) -> bool {
        rows_in_journal::<Self>(journal, &result.key).is_some()
    }

    /// Makes the rows of a result from what a journal has of it, which may be a part.
    fn read(_list: &CellList, result: &ListedResult, journal: &Journal) -> Vec<Self> {
        rows_in_journal(journal, &result.key).unwrap_or_default()
    }
}

/// The device, journal and callbacks that a study measures with.
pub struct Bench<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The results that were measured so far.
    pub journal: &'a mut Journal,
    /// Fails once a signal asked to stop. Measurements call it between two steps of a measurement.
    pub go_on: fn() -> Result<()>,
    /// Advances the progress bar by a number of steps.
    pub advance: &'a mut dyn FnMut(usize),
    /// Writes a file that a measurement makes in addition to its rows.
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

/// Keeps the value that was made last, with its key, until a value with another key is asked for.
pub struct LastMade<K, T>(Option<(K, T)>);

impl<K, T> Default for LastMade<K, T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, T> LastMade<K, T> {
    /// Returns the last value, if it was made for this key. Otherwise drops the last value first, to free its memory,
    /// and makes a new one.
    ///
    /// # Errors
    /// Errors of `make`.
    pub fn get_or_make<E>(&mut self, key: K, make: impl FnOnce() -> Result<T, E>) -> Result<&mut T, E> {
        let last = self.0.take().filter(|(last_key, _)| *last_key == key);
        let (key, made) = match last {
            Some(last) => last,
            None => (key, make()?),
        };
        Ok(&mut self.0.insert((key, made)).1)
    }

    /// Drops the last value, to free its memory.
    pub fn forget(&mut self) {
        self.0 = None;
    }
}

/// Makes the list of a study's cells for a run on a device. `command` is the command of the whole study; the run owns
/// the cells of its `shard`, or all cells without a shard.
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

/// Returns the number of steps of the progress bar over all cells that a run owns.
pub fn steps<S: Study>(study: &S, list: &CellList) -> usize {
    list.select_own(&study.cells()).map(|planned| study.steps(&planned.cell)).sum()
}

/// Measures every cell of a list that the run owns and that the journal lacks.
///
/// # Errors
/// Errors of a measurement, of the journal, and of [`Bench::go_on`].
pub fn measure<S: Study>(study: &mut S, list: &CellList, bench: &mut Bench) -> Result<()> {
    for (planned, listed) in study.cells().iter().zip(&list.cells).filter(|(_, listed)| listed.is_own) {
        let steps = study.steps(&planned.cell);
        if listed.results.iter().all(|result| S::Row::is_whole(list, result, bench.journal)) {
            (bench.advance)(steps);
            continue;
        }
        let rows = study.measure(&planned.cell, bench)?;
        // Without rows, the study has put samples into the journal itself.
        let is_in_journal = S::Row::IS_SAMPLED && rows.is_empty();
        if let Some(result) = listed.results.first().filter(|_| !is_in_journal) {
            bench.journal.put(result.key.clone(), &rows)?;
        }
        if steps == 1 {
            bench.step()?;
        }
    }
    Ok(())
}

/// Returns the rows that a journal keeps under a key; `None` if the journal has no entry with the key, or an unreadable
/// one.
pub fn rows_in_journal<R: Row>(journal: &Journal, key: &str) -> Option<Vec<R>> {
    journal.value(key).and_then(|value| parse_rows(value).ok())
}

/// Reads rows from a value of a journal.
///
/// # Errors
/// Why the value is no list of possible rows, as the end of a sentence that begins with the value.
pub fn parse_rows<R: Row>(value: &Value) -> std::result::Result<Vec<R>, String> {
    let rows = Vec::deserialize(value).map_err(|e| format!("is no list of records of this study: {e}"))?;
    let fault = value.as_array().into_iter().flatten().find_map(sound::fault::<R>);
    fault.map_or(Ok(rows), Err)
}

/// Returns the keys in the journal of all results of a list of cells.
pub fn keys_of(list: &CellList) -> HashSet<&str> {
    list.cells.iter().flat_map(|cell| &cell.results).map(|result| result.key.as_str()).collect()
}

/// Whether a key is that of a sample: the key of one of `results`, followed by one or two words.
fn is_sample(results: &HashSet<&str>, key: &str) -> bool {
    key.rmatch_indices(' ').take(2).any(|(end, _)| results.contains(&key[..end]))
}

/// Returns the keys of a journal's entries that belong to results of a list and cannot be read, in order. Their results
/// are measured again.
pub fn unreadable<R: Row>(list: &CellList, journal: &Journal) -> Vec<String> {
    let keys = keys_of(list);
    let is_unreadable = |key: &&str| match journal.value(key) {
        Some(value) if keys.contains(key) => parse_rows::<R>(value).is_err(),
        Some(value) if R::IS_SAMPLED && is_sample(&keys, key) => interleave::parse_sample(value).is_err(),
        _ => false,
    };
    let mut unreadable: Vec<String> = journal.keys().filter(is_unreadable).map(str::to_owned).collect();
    unreadable.sort_unstable();
    unreadable
}

/// Checks every entry of a run's journal that belongs to its results, and the rows that follow from the entries.
///
/// # Errors
/// The number of the line, if the fault lies in one, and what is wrong, as a text that can follow the name of the
/// journal.
pub fn check<R: Row>(input: &MergeInput) -> std::result::Result<(), (Option<usize>, String)> {
    let keys = keys_of(&input.cells);
    for line in &input.lines {
        let Some((key, value)) = journal::entry(&line.text) else { continue };
        let fault_in_line = |why: String| (Some(line.number), format!("the value of {key:?} {why}"));
        if keys.contains(key.as_str()) {
            parse_rows::<R>(&value).map_err(fault_in_line)?;
        } else if R::IS_SAMPLED && is_sample(&keys, &key) {
            interleave::parse_sample(&value).map_err(fault_in_line)?;
        }
    }
    // Rows made of samples also take fields from the list of cells, which are checked here.
    let results = input.cells.cells.iter().flat_map(|cell| &cell.results);
    let rows = results.flat_map(|result| R::read(&input.cells, result, &input.journal));
    match rows.map(|row| json!(row)).find_map(|row| sound::fault::<R>(&row)) {
        Some(why) => Err((None, format!("a record that follows from its cells {why}"))),
        None => Ok(()),
    }
}

/// Makes the rows of a run from its journal, in the order of the list of cells.
pub fn rows<R: Row>(list: &CellList, journal: &Journal) -> Vec<R> {
    let results = list.cells.iter().filter(|cell| cell.is_own).flat_map(|cell| &cell.results);
    results.flat_map(|result| R::read(list, result, journal)).collect()
}

/// Returns the names of the cells that a run owns and of which its journal lacks a result.
pub fn missing<R: Row>(list: &CellList, journal: &Journal) -> Vec<String> {
    let is_measured = |cell: &ListedCell| cell.results.iter().all(|result| R::is_whole(list, result, journal));
    let missing = list.cells.iter().filter(|cell| cell.is_own && !is_measured(cell));
    missing.map(|cell| cell.name.clone()).collect()
}
