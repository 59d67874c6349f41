//! `ssct merge`: the shards of a study become the run of the whole study.

use super::run::Run;
use crate::error::{Error, Result};
use crate::report::error_report::{self, IMAGES};
use crate::report::merged::copy_files;
use crate::report::run_folder::{self, RunRead};
use crate::study::cell_list::{CellList, ListedResult};
use crate::study::error::ErrorRecord;
use crate::study::journal::Journal;
use crate::study::merge::{MergeInput, MergedRun, merge};
use clap::Args;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options of `ssct merge`.
#[derive(Debug, Args)]
pub struct MergeOptions {
    /// The folders of the shards, or of runs that were merged before.
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// The folder of the whole study, with the files of a run that was never divided.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Merge although cells are missing; the page names them.
    #[arg(long)]
    pub partial: bool,
    /// Print what was merged as JSON: how many cells there are, on which devices, and which are missing.
    #[arg(long)]
    pub json: bool,
}

/// Merges, writes, and says what is missing.
pub fn run(options: &MergeOptions) -> anyhow::Result<()> {
    let inputs = options.folders.iter().map(|folder| input(folder)).collect::<Result<Vec<_>>>()?;
    let own = |input: &MergeInput| same_folder(&input.folder, &options.output);
    if let Some(input) = inputs.iter().find(|input| own(input)) {
        let message = format!("-o {}: the result must lie beside what is merged", input.folder.display());
        return Err(Error::Usage(message).into());
    }
    let merged = merge(&inputs, &read)?;
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
    write(&inputs, &merged, &options.output)?;
    run.finish()?;
    report(options, &merged)
}

/// Reads a folder.
fn input(folder: &Path) -> Result<MergeInput> {
    let RunRead { cells, journal, lines } = run_folder::read(folder)?;
    Ok(MergeInput { folder: folder.to_owned(), cells, journal, lines })
}

fn same_folder(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

/// The result of a cell, as its kind of run keeps it.
fn read(_: &CellList, of: &ListedResult, journal: &Journal) -> Option<Value> {
    journal.value(&of.key).cloned()
}

/// The records of all results of a kind whose results are lists of them.
fn records<T: DeserializeOwned>(merged: &MergedRun) -> Result<Vec<T>> {
    let read = |value: &Value| {
        let wrong = |e| Error::malformed(run_folder::JOURNAL, None, format!("holds a result that is none: {e}"));
        Vec::<T>::deserialize(value).map_err(wrong)
    };
    Ok(merged.results.iter().map(read).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// Writes the files of the run of the whole study.
fn write(inputs: &[MergeInput], merged: &MergedRun, folder: &Path) -> Result<()> {
    let MergedRun { cells, missing, .. } = merged;
    match cells.kind.as_str() {
        "error" => {
            copy_files(&below(inputs, IMAGES), &folder.join(IMAGES), false)?;
            error_report::write(folder, &records::<ErrorRecord>(merged)?, &cells.command, missing)
        }
        kind => Err(Error::malformed(&inputs[0].folder, None, format!("is a run of a kind that is not known: {kind}"))),
    }
}

/// A folder of each run.
fn below(inputs: &[MergeInput], name: &str) -> Vec<PathBuf> {
    inputs.iter().map(|input| input.folder.join(name)).collect()
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
