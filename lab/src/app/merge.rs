//! `ssct merge`: makes the run of the whole study from its shards.

use super::cli::MergeOptions;
use super::merger::{Merger, Merging, folders_with_files, wrong_journal};
use super::printed;
use super::run::Run;
use super::{figures, reference_part, resolve, studies};
use crate::error::{Error, Result};
use crate::report::devices::{by_device, device_name};
use crate::report::html::{self, DeviceText, Entry};
use crate::report::results::{PAGE, device_folder};
use crate::report::run_folder::{self, CELLS, JOURNAL};
use crate::report::{copies, files};
use crate::study::cell_list::CellList;
use crate::study::engine::keys_of;
use crate::study::journal;
use crate::study::merge::{MergeInput, MergedResult, MergedRun, ResultKind, merge};
use crate::study::names::one_line;
use crate::study::record::Provenance;
use serde::{Deserialize, Serialize};
use serde_json::json;
use ssct::gpu::DeviceInfo;
use ssct_scenes::inside::PathInFolder;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Merges the runs, writes the files of the whole study, and says which cells are missing.
pub fn run(options: &MergeOptions) -> anyhow::Result<()> {
    let is_run = |folder: &&PathBuf| PathInFolder::folder(folder).join(CELLS).is_there();
    let has_rays = |folder: &&PathBuf| !is_run(folder) && reference_part::has_parts(folder);
    match (options.folders.iter().find(has_rays), options.folders.iter().find(is_run)) {
        (Some(rays), Some(run)) => {
            let message = format!("holds rays of a reference, and {} a run: merge each by itself", run.display());
            return Err(Error::malformed(rays, None, message).into());
        }
        (Some(_), None) => return reference_part::merge(options),
        (None, _) => {}
    }
    let inputs = options.folders.iter().map(|folder| run_folder::read(folder)).collect::<Result<Vec<_>>>()?;
    let is_output = |input: &MergeInput| resolve::is_same_place(&input.folder, &options.output);
    if let Some(input) = inputs.iter().find(|input| is_output(input)) {
        let message = format!("-o {}: the result must lie beside what is merged", input.folder.display());
        return Err(Error::usage(message).into());
    }
    let first = &inputs[0];
    let kind = first.cells.kind.as_str();
    if let Some(other) = inputs.iter().find(|input| input.cells.kind != kind) {
        let (other_kind, folder) = (&other.cells.kind, first.folder.display());
        let message = format!("is of the kind {other_kind}, and {folder} of the kind {kind}: merge each by itself");
        return Err(Error::malformed(&other.folder, None, message).into());
    }
    let Some(merger) = studies::mergers().into_iter().chain([figures_merger()]).find(|m| m.kind == kind) else {
        let message = format!("is a run of a kind that is not known: {kind}");
        return Err(Error::malformed(&first.folder, None, message).into());
    };
    inputs.iter().try_for_each(merger.check)?;
    let merged = merge(&inputs, merger.results)?;
    check_program(&first.folder, &merged.cells)?;
    let folder = PathInFolder::folder(&options.output);
    check_nothing_is_lost(&folder, &merged)?;
    let count = merged.cells.cells.len();
    if !merged.missing.is_empty() && !options.partial {
        anyhow::bail!(
            "{} of the {count} cells are missing: {}; name the folders of the shards that have them, or give --partial",
            merged.missing.len(),
            merged.missing.join(", ")
        );
    }
    let mut run = Run::begin_anew(&options.output)?;
    run.write_list(&merged.cells)?;
    for line in &merged.lines {
        run.journal.add_line(line)?;
    }
    (merger.write)(&Merging { inputs: &inputs, merged: &merged, folder: &folder })?;
    run.finish()?;
    print_summary(options, &merged)?;
    // Failed cases of the stress study are reported last.
    (merger.judge)(&merged)
}

/// Refuses merged cells that another version of the program measured, since the page names this program's version.
fn check_program(folder: &Path, cells: &CellList) -> Result<()> {
    let (version, commit) = (Provenance::VERSION, Provenance::commit());
    if cells.version == version && cells.commit == commit {
        return Ok(());
    }
    let other_program = format!("version {}, commit {}", cells.version, cells.commit);
    let message = format!("was measured by {other_program}; this program is version {version}, commit {commit}");
    Err(Error::malformed(folder, None, message))
}

/// Refuses an output folder whose journal has results that are not among the merged ones, since writing would lose
/// them. It does not matter whether the run in this folder was finished.
fn check_nothing_is_lost(folder: &PathInFolder, merged: &MergedRun) -> Result<()> {
    let kept: BTreeSet<String> = merged.lines.iter().filter_map(|line| journal::key_of(line)).collect();
    let lost = run_folder::keys(folder)?.into_iter().filter(|key| !kept.contains(key)).count();
    if lost == 0 {
        return Ok(());
    }
    Err(Error::usage(format!(
        "-o {}: it holds {lost} result(s) that are not among those that are merged; merge it with them into another folder, \
         or remove {}",
        folder.path().display(),
        folder.join(JOURNAL).path().display()
    )))
}

/// The merger of figures, which are no study. A result is the figure's entry in the journal. No field of it is a time,
/// and no figure counts as a failure.
fn figures_merger() -> Merger {
    let results = ResultKind { read: |_, listed, journal| journal.value(&listed.key).cloned(), is_time: |_| false };
    Merger { kind: "figures", results, check: check_figures, write: write_figures, judge: |_| Ok(()) }
}

/// Checks the entries of a run's figures and the files that they name: each must be a picture in the run's folder.
fn check_figures(input: &MergeInput) -> Result<()> {
    let keys = keys_of(&input.cells);
    for line in &input.lines {
        let Some((key, value)) = journal::entry(&line.text).filter(|(key, _)| keys.contains(key.as_str())) else {
            continue;
        };
        let wrong = |why: String| wrong_journal(input, Some(line.number), &format!("the value of {key:?} {why}"));
        let entry = Entry::deserialize(&value).map_err(|e| wrong(format!("is no figure: {e}")))?;
        if let Ok(file) = &entry.file {
            copies::check_name(file).map_err(|why| wrong(format!("has the file {file:?}, which {why}")))?;
            let folders = folders_with_files(std::slice::from_ref(input), None);
            folders.iter().try_for_each(|folder| copies::check_file(&folder.join(file)))?;
        }
    }
    Ok(())
}

/// A figure with the device that drew it.
#[derive(Clone, Serialize)]
struct DrawnFigure {
    device: DeviceInfo,
    #[serde(flatten)]
    entry: Entry,
}

/// Makes the error for a result in the merged journal that is no figure.
fn unreadable_figure(e: serde_json::Error) -> Error {
    Error::malformed(run_folder::JOURNAL, None, format!("holds a result that cannot be read: {e}"))
}

/// Writes the figures of each device with a page. If several devices drew figures, each has a folder of its own, and a
/// further page and `figures.json` are about all of them.
fn write_figures(Merging { inputs, merged, folder }: &Merging) -> anyhow::Result<()> {
    let drawn_figure = |result: &MergedResult| {
        let entry = Entry::deserialize(&result.value).map_err(unreadable_figure)?;
        Ok(DrawnFigure { device: merged.cells.devices[result.device].clone(), entry })
    };
    let drawn_figures = merged.results.iter().map(drawn_figure).collect::<Result<Vec<_>>>()?;
    let CellList { command, definitions, devices, .. } = &merged.cells;
    // Runs on one device must draw equal files.
    let must_be_equal = devices.len() == 1;
    let device_figures = by_device(&drawn_figures, |figure| &figure.device);
    let mut device_texts = Vec::new();
    for (n, (device, drawn)) in device_figures.iter().enumerate() {
        let target = if device_figures.len() > 1 { folder.join(device_folder(n)) } else { (*folder).clone() };
        let device_folders = folders_with_files(inputs, Some(device));
        for file in drawn.iter().filter_map(|figure| figure.entry.file.as_ref().ok()) {
            let candidates: Vec<_> = device_folders.iter().map(|folder| folder.join(file)).collect();
            copies::copy_file(&candidates, &target.join(file), must_be_equal)?;
        }
        let entries: Vec<Entry> = drawn.iter().map(|figure| figure.entry.clone()).collect();
        figures::write_page(&target, &entries, device, command)?;
        let text = drawn.iter().map(|figure| format!("{}\n", figure.entry.title)).collect();
        device_texts.push(DeviceText { title: device_name(device), text, folder: device_folder(n) });
    }
    let page = folder.join(PAGE);
    if device_figures.len() != 1 {
        folder.join("figures.json").write(files::json(&drawn_figures).as_bytes())?;
        let text = html::devices_page("Merged: figures", *definitions, command, &device_texts, &merged.missing);
        page.write(text.as_bytes())?;
    } else if !merged.missing.is_empty() {
        let text = String::from_utf8_lossy(&page.bytes()?).into_owned();
        page.write(html::with_missing_cells(&text, &merged.missing).as_bytes())?;
    }
    Ok(())
}

/// Prints how many cells of how many devices were merged, and which cells are missing.
fn print_summary(options: &MergeOptions, merged: &MergedRun) -> anyhow::Result<()> {
    let mut out = printed::out();
    let (cells, missing) = (merged.cells.cells.len(), &merged.missing);
    if options.json {
        let summary = json!({
            "kind": merged.cells.kind, "folders": options.folders, "output": options.output, "cells": cells,
            "devices": merged.cells.devices, "missing": missing,
        });
        return Ok(printed::json(&summary)?);
    }
    let devices = match merged.cells.devices.len() {
        0 => "no device".to_owned(),
        1 => "one device".to_owned(),
        n => format!("{n} devices, whose times stay apart"),
    };
    writeln!(out, "{}: {} of {cells} cells, of {devices}", options.output.display(), cells - missing.len())?;
    for name in missing {
        writeln!(out, "missing: {}", one_line(name))?;
    }
    Ok(())
}
