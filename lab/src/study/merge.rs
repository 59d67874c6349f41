//! Merges runs of a study, such as its shards: the results of their journals become the results of one run
//! (docs/many-machines.md, "Merging"). Runs of different studies are refused, and so are runs with different figures of
//! a cell.

use super::cell_list::{CellList, ListedCell, ListedResult};
use super::journal::{Journal, key_of};
use crate::error::{Error, Result};
use serde_json::Value;
use std::collections::HashSet;
use std::path::PathBuf;

/// A run that is merged, as read from its folder.
pub struct MergeInput {
    /// The folder.
    pub folder: PathBuf,
    /// The cells of the run.
    pub cells: CellList,
    /// The journal of the run.
    pub journal: Journal,
    /// The lines of the journal that are entries, in order.
    pub lines: Vec<Line>,
}

/// A line of a journal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Number of the line, counted from 1.
    pub number: usize,
    /// Text of the line, without its line ending.
    pub text: String,
}

/// Several runs merged into one.
pub struct MergedRun {
    /// The cells of the whole study; each that a run measured counts as the merged run's own.
    pub cells: CellList,
    /// The journal of the merged run, made of `lines`.
    pub journal: Journal,
    /// The lines of all journals, one for each key.
    pub lines: Vec<String>,
    /// The results that were measured, in the order of the cells.
    pub results: Vec<MergedResult>,
    /// The names of the cells that no run measured.
    pub missing: Vec<String>,
}

/// A result of a merged run.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedResult {
    /// The device that measured the result, as an index into the merged list of devices.
    pub device: usize,
    /// The result, as [`ResultKind::read`] reads it.
    pub value: Value,
}

/// Functions by which merging handles the results of a kind of study.
#[derive(Clone, Copy)]
pub struct ResultKind {
    /// Reads a result of a cell from a journal; `None` where the result in the journal is incomplete.
    pub read: fn(&CellList, &ListedResult, &Journal) -> Option<Value>,
    /// Whether a field of the kind's records, at whatever depth, is a time, which may differ from run to run.
    pub is_time: fn(&str) -> bool,
}

/// Merges runs into one. If several runs measured a cell on one device, the first of these runs counts.
///
/// # Errors
/// [`Malformed`](ssct_ground::Error::Malformed) with the first folder that does not fit the folders before it: its run
/// is of another study, or has other figures of a cell. [`Usage`](ssct::Error::Usage) without any run.
pub fn merge(inputs: &[MergeInput], kind: ResultKind) -> Result<MergedRun> {
    let Some(first) = inputs.first() else {
        return Err(Error::usage("nothing to merge: name the folders of some shards".into()));
    };
    for input in &inputs[1..] {
        if let Some(difference) = difference_of_studies(&first.cells, &input.cells) {
            let message = format!("is not of the same study as {}: {difference}", first.folder.display());
            return Err(Error::malformed(&input.folder, None, message));
        }
    }
    check_overlaps(inputs, kind)?;
    // Keeps the first of several lines with one key.
    let mut seen_keys = HashSet::new();
    let all = inputs.iter().flat_map(|input| &input.lines).map(|line| &line.text);
    let is_first = |line: &&String| key_of(line).is_some_and(|key| seen_keys.insert(key));
    let lines: Vec<String> = all.filter(is_first).cloned().collect();
    let journal = Journal::resume(lines.iter().map(String::as_str), None);
    let mut cells = CellList { shard: None, devices: Vec::new(), ..first.cells.clone() };
    let (mut results, mut missing) = (Vec::new(), Vec::new());
    for (n, cell) in cells.cells.iter_mut().enumerate() {
        cell.results.clear();
        let listed_results = inputs.iter().flat_map(|input| {
            let results = &input.cells.cells[n].results;
            results.iter().filter_map(|result| Some((result, input.cells.devices.get(result.device)?)))
        });
        for (result, device) in listed_results {
            // Results that the merged journal lacks are left out, and so are devices without any other result: the
            // folders of a run's devices are numbered like its list of devices.
            let Some(value) = (kind.read)(&first.cells, result, &journal) else { continue };
            if cell.results.iter().any(|known| known.key == result.key) {
                continue;
            }
            let device_index = cells.devices.iter().position(|known| known == device).unwrap_or_else(|| {
                cells.devices.push(device.clone());
                cells.devices.len() - 1
            });
            cell.results.push(ListedResult { device: device_index, ..result.clone() });
            results.push(MergedResult { device: device_index, value });
        }
        cell.is_own = !cell.results.is_empty();
        if !cell.is_own {
            missing.push(cell.name.clone());
        }
    }
    Ok(MergedRun { cells, journal, lines, results, missing })
}

/// Describes the first of `N` properties, given by names and values, in which `b` differs from `a`, as the end of a
/// sentence about `b`; `None` if all are equal.
pub fn difference_of_properties<const N: usize>(
    a: [(&'static str, String); N],
    b: [(&'static str, String); N],
) -> Option<String> {
    let different = a.into_iter().zip(b).find(|((_, a), (_, b))| a != b);
    different.map(|((name, a), (_, b))| format!("its {name} is {b} and not {a}"))
}

/// Says why the run `b` is not of the same study as the run `a`, as the end of a sentence about `b`; `None` if it is.
fn difference_of_studies(a: &CellList, b: &CellList) -> Option<String> {
    if let Some(difference) = difference_of_properties(a.must_agree(), b.must_agree()) {
        return Some(difference);
    }
    if let Some((a, b)) = a.cells.iter().zip(&b.cells).find(|(a, b)| a.name == b.name && a.setup != b.setup) {
        return Some(format!("the setup of its cell {} has the digest {} and not {}", a.name, b.setup, a.setup));
    }
    let lacks =
        |list: &CellList, cell: &ListedCell| !list.cells.iter().any(|c| c.name == cell.name && c.setup == cell.setup);
    if let Some(cell) = a.cells.iter().find(|cell| lacks(b, cell)) {
        return Some(format!("it has no cell {}", cell.name));
    }
    if let Some(cell) = b.cells.iter().find(|cell| lacks(a, cell)) {
        return Some(format!("it has a cell more, {}", cell.name));
    }
    let same_order = a.cells.len() == b.cells.len() && a.cells.iter().zip(&b.cells).all(|(a, b)| a.setup == b.setup);
    (!same_order).then(|| "its cells are in another order".to_owned())
}

/// Refuses runs of one study that have different figures of a cell: each result of the cell is compared with the first.
fn check_overlaps(inputs: &[MergeInput], kind: ResultKind) -> Result<()> {
    let values = |input: &MergeInput, cell: usize| -> Vec<Value> {
        let results = &input.cells.cells[cell].results;
        results.iter().filter_map(|result| (kind.read)(&input.cells, result, &input.journal)).collect()
    };
    for cell in 0..inputs[0].cells.cells.len() {
        let mut first: Option<(&MergeInput, Value)> = None;
        for input in inputs {
            for value in values(input, cell) {
                let Some((first_input, first_value)) = &first else {
                    first = Some((input, value));
                    continue;
                };
                if let Some(difference) = difference_of_figures(first_value, &value, kind.is_time) {
                    let (name, other) = (&input.cells.cells[cell].name, first_input.folder.display());
                    let difference = format!("{} {}", difference.place.join("."), difference.values);
                    let message = format!("its cell {name} is not as in {other}: {}", difference.trim_start());
                    return Err(Error::malformed(&input.folder, None, message));
                }
            }
        }
    }
    Ok(())
}

/// The field of a record that names its device.
const DEVICE: &str = "device";

/// A difference of two results.
struct Difference {
    /// The names of the fields that lead to the difference, the outermost first.
    place: Vec<String>,
    /// The two values, as the end of a sentence about the second result.
    values: String,
}

/// Finds the first difference of the values `a` and `b` of two results, at whatever depth, ignoring devices and times.
fn difference_of_figures(a: &Value, b: &Value, is_time: fn(&str) -> bool) -> Option<Difference> {
    let difference_within = |name: String, a: &Value, b: &Value| {
        let mut difference = difference_of_figures(a, b, is_time)?;
        difference.place.insert(0, name);
        Some(difference)
    };
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let names = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name)));
            let mut figures = names.filter(|name| *name != DEVICE && !is_time(name));
            figures.find_map(|name| {
                let [a, b] = [a, b].map(|object| object.get(name).unwrap_or(&Value::Null));
                difference_within(name.clone(), a, b)
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(n, (a, b))| {
                // The name of an element is its index, and the method if it is a record of one: "0 (ssct)".
                let method = a.get("method").and_then(Value::as_str).map(|name| format!(" ({name})"));
                difference_within(format!("{n}{}", method.unwrap_or_default()), a, b)
            })
        }
        _ => (a != b).then(|| Difference { place: Vec::new(), values: format!("is {b} and not {a}") }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use ssct::gpu::DeviceInfo;

    /// Makes the list of a study of the cells a, b and c, of a run that measured the cells `measured` on a device.
    fn list(measured: &[&str], device: &str) -> CellList {
        let device = DeviceInfo { name: device.into(), driver: "d".into(), api: "1.3".into(), kind: "CPU".into() };
        let cell = |name: &&str| {
            let result = ListedResult { device: 0, key: format!("{} {name}", device.name), record_head: Value::Null };
            let is_own = measured.contains(name);
            let results = is_own.then_some(result).into_iter().collect();
            ListedCell { name: (*name).into(), setup: format!("digest of {name}"), is_own, results }
        };
        CellList {
            kind: "error".into(),
            definitions: 2,
            version: "1".into(),
            commit: "c".into(),
            command: String::new(),
            shard: None,
            settings: Value::Null,
            scenes: vec![("rooms".into(), "digest".into())],
            cells: ["a", "b", "c"].iter().map(cell).collect(),
            devices: vec![device],
        }
    }

    /// Makes a run that measured some cells on a device; `errors` has their names and errors.
    fn input(folder: &str, device: &str, errors: &[(&str, f64)]) -> MergeInput {
        let names: Vec<&str> = errors.iter().map(|(name, _)| *name).collect();
        let line = |(n, (name, rmse)): (usize, &(&str, f64))| {
            let record = json!([{"method": "ssct", "rmse": rmse, "time_ms": n as f64, "device": device}]);
            json!({"key": format!("{device} {name}"), "value": record}).to_string()
        };
        let lines: Vec<String> = errors.iter().enumerate().map(line).collect();
        let journal = Journal::resume(lines.iter().map(String::as_str), None);
        MergeInput { folder: folder.into(), cells: list(&names, device), journal, lines: numbered(lines) }
    }

    fn numbered(lines: Vec<String>) -> Vec<Line> {
        lines.into_iter().enumerate().map(|(n, text)| Line { number: n + 1, text }).collect()
    }

    const KIND: ResultKind = ResultKind {
        read: |_, result, journal| journal.value(&result.key).cloned(),
        is_time: |name| name == "time_ms",
    };

    fn refusal(inputs: &[MergeInput]) -> String {
        merge(inputs, KIND).err().expect("refused").to_string()
    }

    #[test]
    fn cells_come_in_the_order_of_the_study_and_missing_ones_are_named() {
        let merged = merge(&[input("B", "x", &[("c", 3.0)]), input("A", "x", &[("a", 1.0)])], KIND).expect("one study");
        let errors: Vec<_> = merged.results.iter().map(|r| r.value[0]["rmse"].as_f64()).collect();
        assert_eq!((errors, merged.missing), (vec![Some(1.0), Some(3.0)], vec!["b".to_owned()]));
        assert_eq!(merged.cells.cells.iter().map(|c| c.is_own).collect::<Vec<_>>(), [true, false, true]);
        assert_eq!(merged.cells.devices.len(), 1);
    }

    #[test]
    fn the_first_of_two_results_by_one_device_is_kept_and_results_by_two_devices_are_both_kept() {
        let all = [("a", 1.0), ("b", 2.0), ("c", 3.0)];
        let same = merge(&[input("A", "x", &all), input("B", "x", &all[1..])], KIND).expect("they agree");
        assert_eq!((same.results.len(), same.lines.len()), (3, 3));
        assert_eq!(same.results[1].value[0]["time_ms"], 1.0, "B measured it as its first");
        let two = merge(&[input("A", "x", &all), input("B", "y", &all[1..])], KIND).expect("they agree");
        let devices: Vec<_> = two.results.iter().map(|r| r.value[0]["device"].as_str().map(str::to_owned)).collect();
        assert_eq!(devices, ["x", "x", "y", "x", "y"].map(|d| Some(d.to_owned())));
        // Merging a merged run once more changes nothing.
        let merged = MergeInput {
            folder: "AB".into(),
            journal: Journal::resume(two.lines.iter().map(String::as_str), None),
            cells: two.cells.clone(),
            lines: numbered(two.lines.clone()),
        };
        let both = merge(&[merged, input("B", "y", &all[1..])], KIND).expect("they agree");
        assert_eq!((both.results, both.cells), (two.results, two.cells));
    }

    #[test]
    fn a_device_whose_results_are_in_no_journal_is_not_listed() {
        let mut interrupted = input("A", "x", &[("a", 1.0)]);
        interrupted.journal = Journal::resume(std::iter::empty(), None);
        interrupted.lines.clear();
        let merged = merge(&[interrupted, input("B", "y", &[("b", 2.0)])], KIND).expect("one study");
        let names: Vec<_> = merged.cells.devices.iter().map(|device| device.name.as_str()).collect();
        assert_eq!((names, merged.results.len(), merged.results[0].device), (vec!["y"], 1, 0));
        assert_eq!(merged.missing, ["a", "c"]);
    }

    #[test]
    fn runs_with_other_figures_or_of_another_study_are_refused_with_the_difference() {
        let message = refusal(&[input("A", "x", &[("a", 1.0)]), input("B", "y", &[("a", 1.5)])]);
        assert_eq!(message, "B: its cell a is not as in A: 0 (ssct).rmse is 1.5 and not 1.0");
        let after = |change: fn(&mut CellList)| {
            let mut other = input("B", "x", &[("b", 1.0)]);
            change(&mut other.cells);
            refusal(&[input("A", "x", &[("a", 1.0)]), other])
        };
        assert_eq!(after(|c| c.commit = "e".into()), "B: is not of the same study as A: its commit is e and not c");
        assert!(after(|c| c.version = "2".into()).ends_with("its version is 2 and not 1"));
        assert!(after(|c| c.definitions = 1).ends_with("its version of the definitions is 1 and not 2"));
        assert!(after(|c| c.kind = "time".into()).ends_with("its kind is time and not error"));
        assert!(
            after(|c| c.scenes[0].1 = "other".into())
                .ends_with("its list of scenes is rooms other and not rooms digest")
        );
        assert!(after(|c| c.cells[2].setup = "x".into()).contains("the setup of its cell c has the digest x"));
        assert!(after(|c| drop(c.cells.pop())).ends_with("it has no cell c"));
        assert!(after(|c| c.cells.swap(0, 1)).ends_with("its cells are in another order"));
        assert!(merge(&[], KIND).is_err());
    }
}
