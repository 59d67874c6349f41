//! `ssct merge`: makes the run of the whole study from its shards.

use super::cli::MergeOptions;
use super::figures;
use super::reference_part;
use super::run::Run;
use super::stress::all_passed;
use super::time::{self, TimeSettings};
use crate::error::{Error, Result};
use crate::gpu::DeviceInfo;
use crate::report::error_report::{self, IMAGES};
use crate::report::html::Entry;
use crate::report::merged::{MergedReport, copy_file, copy_files, device_folder};
use crate::report::run_folder::{self, CELLS};
use crate::report::video_report::{self, CLIPS};
use crate::report::{age_report, precision_report, stress_report};
use crate::study::age::AgeRecord;
use crate::study::cell_list::{CellList, ListedResult};
use crate::study::error::ErrorRecord;
use crate::study::journal::Journal;
use crate::study::merge::{MergeInput, MergedResult, MergedRun, merge};
use crate::study::precision::PrecisionRecord;
use crate::study::record::{Head, Provenance};
use crate::study::stress::StressRecord;
use crate::study::stress::motion::MotionRecord;
use crate::study::video::VideoRecord;
use crate::study::{TimeRecord, timing};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Merges the runs, writes the files of the whole study, and says which cells are missing.
pub fn run(options: &MergeOptions) -> anyhow::Result<()> {
    let is_run = |folder: &PathBuf| folder.join(CELLS).exists();
    if !options.folders.iter().any(is_run) && options.folders.iter().any(|folder| reference_part::has_parts(folder)) {
        return reference_part::merge(options);
    }
    let inputs = options.folders.iter().map(|folder| run_folder::read(folder)).collect::<Result<Vec<_>>>()?;
    let own = |input: &MergeInput| same_folder(&input.folder, &options.output);
    if let Some(input) = inputs.iter().find(|input| own(input)) {
        let message = format!("-o {}: the result must lie beside what is merged", input.folder.display());
        return Err(Error::Usage(message).into());
    }
    let merged = merge(&inputs, &read)?;
    check_program(&inputs[0].folder, &merged.cells)?;
    let count = merged.cells.cells.len();
    if !merged.missing.is_empty() && !options.partial {
        anyhow::bail!(
            "{} of the {count} cells are missing: {}; name the folders of the shards that have them, or give --partial",
            merged.missing.len(),
            merged.missing.join(", ")
        );
    }
    let mut run = Run::begin(Some(&options.output), false)?;
    run.list(&merged.cells)?;
    for line in &merged.lines {
        run.journal.keep_line(line)?;
    }
    // Cases of the stress study that are not passed are reported last, once everything is written.
    let wrote = write(&inputs, &merged, &options.output);
    if wrote.as_ref().is_err_and(|e| e.is::<Error>()) {
        return wrote;
    }
    run.finish()?;
    report(options, &merged)?;
    wrote
}

/// Refuses runs of another program than this one, which the page names as theirs. Merged runs are all of one program.
fn check_program(folder: &Path, cells: &CellList) -> Result<()> {
    let (version, commit) = (Provenance::VERSION, Provenance::COMMIT);
    if cells.version == version && cells.commit == commit {
        return Ok(());
    }
    let of = format!("version {}, commit {}", cells.version, cells.commit);
    let message = format!("was measured by {of}; this program is version {version}, commit {commit}");
    Err(Error::malformed(folder, None, message))
}

fn same_folder(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

/// The result of a cell, as its kind of study keeps it.
fn read(cells: &CellList, of: &ListedResult, journal: &Journal) -> Option<Value> {
    if cells.kind != "time" {
        return journal.value(&of.key).cloned();
    }
    let TimeSettings { samples, a_a, .. } = TimeSettings::deserialize(&cells.settings).ok()?;
    // A cell of times has its result once all samples are there. No two runs must have the same times.
    timing::is_whole(&of.key, samples, a_a, journal).then_some(Value::Null)
}

/// The records of all results of a kind whose results are lists of them.
fn records<T: DeserializeOwned>(merged: &MergedRun) -> Result<Vec<T>> {
    let read = |of: &MergedResult| Vec::<T>::deserialize(&of.value).map_err(unreadable);
    Ok(merged.results.iter().map(read).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

fn unreadable(e: serde_json::Error) -> Error {
    Error::malformed(run_folder::JOURNAL, None, format!("holds a result that cannot be read: {e}"))
}

/// Writes the files of the run of the whole study.
fn write(inputs: &[MergeInput], merged: &MergedRun, folder: &Path) -> anyhow::Result<()> {
    let MergedRun { cells, missing, .. } = merged;
    let command = cells.command.as_str();
    match cells.kind.as_str() {
        "error" => {
            copy_files(&below(inputs, IMAGES), &folder.join(IMAGES), false)?;
            error_report::write(folder, &records::<ErrorRecord>(merged)?, command, missing)?;
        }
        "age" => {
            let (write, text) = (age_report::write, age_report::text);
            let all = records::<AgeRecord>(merged)?;
            report_of(merged, &all, |r| &r.head.program.device, &write, &text).write(folder)?;
        }
        "precision" => {
            let write = |folder: &Path, records: &[_]| precision_report::write(folder, records, command);
            let (all, text) = (records::<PrecisionRecord>(merged)?, precision_report::text);
            report_of(merged, &all, |r| &r.head.program.device, &write, &text).write(folder)?;
        }
        "video" => {
            let write = |folder: &Path, records: &[_]| {
                copy_files(&below(inputs, CLIPS), &folder.join(CLIPS), false)?;
                video_report::write(folder, records, command)
            };
            let (all, text) = (records::<VideoRecord>(merged)?, video_report::text);
            report_of(merged, &all, |r| &r.head.program.device, &write, &text).write(folder)?;
        }
        "stress" => return stress(merged, folder),
        "time" => times(merged, folder)?,
        "figures" => figures(inputs, merged, folder)?,
        kind => {
            let message = format!("is a run of a kind that is not known: {kind}");
            return Err(Error::malformed(&inputs[0].folder, None, message).into());
        }
    }
    Ok(())
}

/// The report of the records, device by device.
fn report_of<'a, T>(
    merged: &'a MergedRun,
    records: &'a [T],
    device: fn(&T) -> &DeviceInfo,
    write: &'a dyn Fn(&Path, &[T]) -> Result<()>,
    text: &'a dyn Fn(&[T]) -> String,
) -> MergedReport<'a, T> {
    let CellList { kind, command, definitions, .. } = &merged.cells;
    MergedReport { kind, records, device, write, text, command, definitions: *definitions, missing: &merged.missing }
}

/// A record of the stress study, of which there are two kinds.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged)]
enum Stress {
    Case(StressRecord),
    Motion(MotionRecord),
}

impl Stress {
    fn device(&self) -> &DeviceInfo {
        match self {
            Self::Case(record) => &record.program.device,
            Self::Motion(record) => &record.program.device,
        }
    }

    fn apart(all: &[Self]) -> (Vec<StressRecord>, Vec<MotionRecord>) {
        let (mut cases, mut motions) = (Vec::new(), Vec::new());
        for record in all {
            match record {
                Self::Case(record) => cases.push(record.clone()),
                Self::Motion(record) => motions.push(record.clone()),
            }
        }
        (cases, motions)
    }
}

fn stress(merged: &MergedRun, folder: &Path) -> anyhow::Result<()> {
    let all = records::<Stress>(merged)?;
    let write = |folder: &Path, records: &[Stress]| {
        let (cases, motions) = Stress::apart(records);
        stress_report::write(folder, &cases, &motions, &merged.cells.command)
    };
    let text = |records: &[Stress]| {
        let (cases, motions) = Stress::apart(records);
        stress_report::text(&cases, &motions)
    };
    report_of(merged, &all, Stress::device, &write, &text).write(folder)?;
    all_passed(&Stress::apart(&all).0)
}

fn times(merged: &MergedRun, folder: &Path) -> Result<()> {
    let TimeSettings { samples, table, .. } = TimeSettings::deserialize(&merged.cells.settings).map_err(unreadable)?;
    let results = merged.cells.cells.iter().flat_map(|cell| &cell.results);
    let record = |of: &ListedResult| {
        let head = Head::deserialize(&of.of).map_err(unreadable)?;
        Ok(timing::record_of(head, &of.key, samples, &merged.journal))
    };
    let records: Vec<TimeRecord> = results.map(record).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    let output = |folder: &Path, records: &[TimeRecord]| {
        time::output(records, table).map_err(|e| Error::io("draw the plot of", folder, std::io::Error::other(e)))
    };
    let write = |folder: &Path, records: &[TimeRecord]| output(folder, records)?.write(folder);
    let text = |records: &[TimeRecord]| time::text(records, table);
    report_of(merged, &records, |r| &r.head.program.device, &write, &text).write(folder)
}

/// A figure with the device that drew it.
#[derive(Clone, Serialize)]
struct Drawn {
    device: DeviceInfo,
    #[serde(flatten)]
    entry: Entry,
}

fn figures(inputs: &[MergeInput], merged: &MergedRun, folder: &Path) -> Result<()> {
    let drawn = |of: &MergedResult| {
        let entry = Entry::deserialize(&of.value).map_err(unreadable)?;
        Ok(Drawn { device: merged.cells.devices[of.device].clone(), entry })
    };
    let all = merged.results.iter().map(drawn).collect::<Result<Vec<_>>>()?;
    // Runs on one device must draw equal files.
    let same = merged.cells.devices.len() == 1;
    let write = |folder: &Path, records: &[Drawn]| {
        let Some(first) = records.first() else { return Ok(()) };
        for file in records.iter().filter_map(|r| r.entry.file.as_ref().ok()) {
            copy_file(&pictures_of(inputs, &first.device, file), &folder.join(file), same)?;
        }
        let entries: Vec<Entry> = records.iter().map(|r| r.entry.clone()).collect();
        figures::write_page(folder, &entries, &first.device, &merged.cells.command)
    };
    let text = |records: &[Drawn]| records.iter().map(|r| format!("{}\n", r.entry.title)).collect();
    report_of(merged, &all, |r| &r.device, &write, &text).write(folder)
}

/// The paths where the runs on a device may have one of its figures.
fn pictures_of(inputs: &[MergeInput], device: &DeviceInfo, file: &str) -> Vec<PathBuf> {
    let of = |input: &MergeInput| {
        let place = input.cells.devices.iter().position(|d| d == device)?;
        let apart = input.cells.devices.len() > 1;
        let folder = if apart { input.folder.join(device_folder(place)) } else { input.folder.clone() };
        Some(folder.join(file))
    };
    inputs.iter().filter_map(of).collect()
}

/// The folders of one name in each run and in the folders of its devices.
fn below(inputs: &[MergeInput], name: &str) -> Vec<PathBuf> {
    let of = |input: &MergeInput| {
        let devices = (0..input.cells.devices.len()).map(|n| input.folder.join(device_folder(n)).join(name));
        std::iter::once(input.folder.join(name)).chain(devices).collect::<Vec<_>>()
    };
    inputs.iter().flat_map(of).collect()
}

fn report(options: &MergeOptions, merged: &MergedRun) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    let (cells, missing) = (merged.cells.cells.len(), &merged.missing);
    if options.json {
        let summary = json!({
            "kind": merged.cells.kind, "folders": options.folders, "output": options.output, "cells": cells,
            "devices": merged.cells.devices, "missing": missing,
        });
        writeln!(out, "{summary}")?;
        return Ok(());
    }
    let devices = match merged.cells.devices.len() {
        1 => "one device".to_owned(),
        n => format!("{n} devices, whose times stay apart"),
    };
    writeln!(out, "{}: {} of {cells} cells, of {devices}", options.output.display(), cells - missing.len())?;
    for name in missing {
        writeln!(out, "missing: {name}")?;
    }
    Ok(())
}
