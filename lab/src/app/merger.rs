//! How the runs of a study become one, whatever the study.

use crate::report::copies;
use crate::report::devices::by_device;
use crate::report::results::{Results, device_folder};
use crate::study::columns::Columns;
use crate::study::engine::{self, Row, Study};
use crate::study::merge::{MergeInput, MergedRun, ResultKind};
use std::path::{Path, PathBuf};

/// How runs of one kind are merged.
pub struct Merger {
    /// The kind.
    pub kind: &'static str,
    /// What their results are.
    pub results: ResultKind,
    /// Writes the files of the whole.
    pub write: fn(&Merging) -> anyhow::Result<()>,
}

/// Runs, and what they are together.
pub struct Merging<'a> {
    /// The runs.
    pub inputs: &'a [MergeInput],
    /// The whole.
    pub merged: &'a MergedRun,
    /// The folder of the whole.
    pub folder: &'a Path,
}

impl Merger {
    /// The merger of a study.
    pub fn of<S: Study>() -> Self {
        let results = ResultKind {
            read: |list, of, journal| {
                let is_whole = S::Row::is_whole(list, of, journal);
                // No two runs must have the same samples.
                is_whole.then(|| journal.value(&of.key).cloned().unwrap_or_default())
            },
            is_time: |name| S::Row::columns().times.contains(name),
        };
        Self { kind: S::Row::KIND, results, write: write_study::<S::Row> }
    }
}

/// Writes the files of a study that was merged.
fn write_study<R: Row>(Merging { inputs, merged, folder }: &Merging) -> anyhow::Result<()> {
    let rows = engine::rows::<R>(&merged.cells, &merged.journal);
    let apart = by_device(&rows, |r| &r.program().device);
    for (n, (device, _)) in apart.iter().enumerate() {
        let to = if apart.len() > 1 { folder.join(device_folder(n)) } else { folder.to_path_buf() };
        let of = |input: &&MergeInput| input.cells.devices.contains(device);
        let of_device: Vec<&MergeInput> = inputs.iter().filter(of).collect();
        for name in R::FOLDERS {
            copies::copy_files(&below(&of_device, name), &to.join(name), false)?;
        }
    }
    Results { rows: &rows, list: &merged.cells, missing: &merged.missing }.write(folder)?;
    passed(&rows)
}

/// The folders of one name in each run and in the folders of its devices.
fn below(inputs: &[&MergeInput], name: &str) -> Vec<PathBuf> {
    let of = |input: &&MergeInput| {
        let devices = (0..input.cells.devices.len()).map(|n| input.folder.join(device_folder(n)).join(name));
        std::iter::once(input.folder.join(name)).chain(devices).collect::<Vec<_>>()
    };
    inputs.iter().flat_map(of).collect()
}

/// Fails if rows have to pass and do not.
pub fn passed<R: Row>(rows: &[R]) -> anyhow::Result<()> {
    R::failure(rows).map_or(Ok(()), |failure| Err(anyhow::anyhow!(failure)))
}
