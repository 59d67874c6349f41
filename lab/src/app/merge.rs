//! `ssct merge`: makes the run of the whole study from its shards.

use super::cli::MergeOptions;
use super::merger::{Merger, Merging};
use super::run::Run;
use super::{figures, reference_part, studies};
use crate::error::{Error, Result};
use crate::gpu::DeviceInfo;
use crate::report::devices::{by_device, device_name};
use crate::report::html::{self, DeviceText, Entry};
use crate::report::results::{PAGE, device_folder};
use crate::report::run_folder::{self, CELLS};
use crate::report::{copies, files};
use crate::study::cell_list::CellList;
use crate::study::merge::{MergeInput, MergedResult, MergedRun, ResultKind, merge};
use crate::study::record::Provenance;
use serde::{Deserialize, Serialize};
use serde_json::json;
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
    let kind = inputs[0].cells.kind.as_str();
    let Some(merger) = studies::mergers().into_iter().chain([of_figures()]).find(|m| m.kind == kind) else {
        let message = format!("is a run of a kind that is not known: {kind}");
        return Err(Error::malformed(&inputs[0].folder, None, message).into());
    };
    let merged = merge(&inputs, merger.results)?;
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
    let wrote = (merger.write)(&Merging { inputs: &inputs, merged: &merged, folder: &options.output });
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

/// The merger of figures, which are no study.
fn of_figures() -> Merger {
    let results = ResultKind { read: |_, of, journal| journal.value(&of.key).cloned(), is_time: |_| false };
    Merger { kind: "figures", results, write: write_figures }
}

/// A figure with the device that drew it.
#[derive(Clone, Serialize)]
struct Drawn {
    device: DeviceInfo,
    #[serde(flatten)]
    entry: Entry,
}

fn unreadable(e: serde_json::Error) -> Error {
    Error::malformed(run_folder::JOURNAL, None, format!("holds a result that cannot be read: {e}"))
}

/// Writes the figures of each device, and their pages.
fn write_figures(Merging { inputs, merged, folder }: &Merging) -> anyhow::Result<()> {
    let drawn = |of: &MergedResult| {
        let entry = Entry::deserialize(&of.value).map_err(unreadable)?;
        Ok(Drawn { device: merged.cells.devices[of.device].clone(), entry })
    };
    let all = merged.results.iter().map(drawn).collect::<Result<Vec<_>>>()?;
    let CellList { command, definitions, devices, .. } = &merged.cells;
    // Runs on one device must draw equal files.
    let same = devices.len() == 1;
    let apart = by_device(&all, |r| &r.device);
    let mut parts = Vec::new();
    for (n, (device, drawn)) in apart.iter().enumerate() {
        let to = if apart.len() > 1 { folder.join(device_folder(n)) } else { folder.to_path_buf() };
        for file in drawn.iter().filter_map(|r| r.entry.file.as_ref().ok()) {
            copies::copy_file(&pictures_of(inputs, device, file), &to.join(file), same)?;
        }
        let entries: Vec<Entry> = drawn.iter().map(|r| r.entry.clone()).collect();
        figures::write_page(&to, &entries, device, command)?;
        let text = drawn.iter().map(|r| format!("{}\n", r.entry.title)).collect();
        parts.push(DeviceText { title: device_name(device), text, folder: device_folder(n) });
    }
    let page = folder.join(PAGE);
    if apart.len() > 1 {
        files::write(&folder.join("figures.json"), files::json(&all).as_bytes())?;
        let text = html::devices_page("Merged: figures", *definitions, command, &parts, &merged.missing);
        files::write(&page, text.as_bytes())?;
    } else if !merged.missing.is_empty() {
        let text = std::fs::read_to_string(&page).map_err(|e| Error::io("read", &page, e))?;
        files::write(&page, html::with_missing_cells(&text, &merged.missing).as_bytes())?;
    }
    Ok(())
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
