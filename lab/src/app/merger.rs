//! Merging of the runs of any study into one run.

use crate::error::{Error, Result};
use crate::report::copies;
use crate::report::devices::by_device;
use crate::report::results::{Results, device_folder};
use crate::report::run_folder::JOURNAL;
use crate::study::columns::Columns;
use crate::study::engine::{self, Row, Study};
use crate::study::merge::{MergeInput, MergedRun, ResultKind};
use ssct::gpu::DeviceInfo;
use ssct_scenes::inside::PathInFolder;

/// How runs of one kind are merged.
pub struct Merger {
    /// The kind of the runs.
    pub kind: &'static str,
    /// How results of the runs are read, and which columns are times.
    pub results: ResultKind,
    /// Checks a run before any of it is written. The error says which line of the journal is at fault, if that is
    /// known, and why.
    pub check: fn(&MergeInput) -> Result<()>,
    /// Writes the files of the merged run.
    pub write: fn(&Merging) -> anyhow::Result<()>,
    /// Returns an error if the merged results show a failure, such as a failed case of the stress study.
    pub judge: fn(&MergedRun) -> anyhow::Result<()>,
}

/// Runs, and the one run into which they are merged.
pub struct Merging<'a> {
    /// The runs.
    pub inputs: &'a [MergeInput],
    /// The merged run.
    pub merged: &'a MergedRun,
    /// The folder of the merged run.
    pub folder: &'a PathInFolder,
}

impl Merger {
    /// The merger of a study.
    pub fn for_study<S: Study>() -> Self {
        let results = ResultKind {
            read: |list, listed, journal| {
                let is_whole = S::Row::is_whole(list, listed, journal);
                // Samples of times have keys of their own and are not compared, since they differ from run to run.
                is_whole.then(|| journal.value(&listed.key).cloned().unwrap_or_default())
            },
            is_time: |name| S::Row::columns().times.contains(name),
        };
        Self {
            kind: S::Row::KIND,
            results,
            check: check_study::<S::Row>,
            write: write_study::<S::Row>,
            judge: |merged| check_rows(&engine::rows::<S::Row>(&merged.cells, &merged.journal)),
        }
    }
}

/// Writes the files of the merged run of a study: copies of the files that lie beside the runs' journals, and the
/// results. If rows are from several devices, each device's copies go into a folder of its own.
fn write_study<R: Row>(Merging { inputs, merged, folder }: &Merging) -> anyhow::Result<()> {
    let rows = engine::rows::<R>(&merged.cells, &merged.journal);
    let device_rows = by_device(&rows, |r| &r.program().device);
    for (n, (device, _)) in device_rows.iter().enumerate() {
        let target = if device_rows.len() > 1 { folder.join(device_folder(n)) } else { (*folder).clone() };
        let device_folders = folders_with_files(inputs, Some(device));
        for name in R::FOLDERS {
            let named_folders: Vec<_> = device_folders.iter().map(|folder| folder.join(name)).collect();
            copies::copy_files(&named_folders, &target.join(name), false)?;
        }
    }
    Results { rows: &rows, list: &merged.cells, missing: &merged.missing }.write(folder)?;
    Ok(())
}

/// Checks the journal of a run, and the files beside it that merging copies.
fn check_study<R: Row>(input: &MergeInput) -> Result<()> {
    engine::check::<R>(input).map_err(|(line, why)| wrong_journal(input, line, &why))?;
    let folders = folders_with_files(std::slice::from_ref(input), None);
    let mut named_folders = R::FOLDERS.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    Ok(named_folders.try_for_each(|folder| copies::check_files(&folder))?)
}

/// Makes the error for a journal with a result that cannot be right, in the given line if it is known.
pub fn wrong_journal(input: &MergeInput, line: Option<usize>, why: &str) -> Error {
    Error::malformed(input.folder.join(JOURNAL), line, why)
}

/// Returns the folders where some runs have files that were made on `device`, or on any device if it is `None`.
pub fn folders_with_files(inputs: &[MergeInput], device: Option<&DeviceInfo>) -> Vec<PathInFolder> {
    let folders_of_run = |input: &MergeInput| {
        let run = PathInFolder::folder(&input.folder);
        // A run of several devices has a folder for each of them.
        let has_device_folders = input.cells.devices.len() > 1;
        let devices = input.cells.devices.iter().enumerate().filter(|(_, d)| device.is_none_or(|device| *d == device));
        let folder = |(n, _): (usize, _)| if has_device_folders { run.join(device_folder(n)) } else { run.clone() };
        devices.map(folder).collect::<Vec<_>>()
    };
    inputs.iter().flat_map(folders_of_run).collect()
}

/// Returns an error if a row fails that has to pass.
pub fn check_rows<R: Row>(rows: &[R]) -> anyhow::Result<()> {
    R::failure(rows).map_or(Ok(()), |failure| Err(anyhow::anyhow!(failure)))
}
