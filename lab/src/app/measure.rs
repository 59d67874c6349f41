//! Runs a study from its flags: folder, journal, signals, progress, shard, files and printed text.

use super::cli::{DeviceOptions, RunOptions};
use super::merger::{Merger, check_rows};
use super::printed;
use super::run::{Run, command_line, go_on};
use super::{progress, resolve};
use crate::error::Result;
use crate::report::results::{self, Results};
use crate::study::cell_list::CellList;
use crate::study::engine::{self, Bench, Row, Study};
use crate::study::exhibit::ExtraFile;
use crate::study::journal::Journal;
use clap::Args;
use ssct::gpu::Gpu;
use ssct_scenes::inside::PathInFolder;
use std::io::Write;

/// The flags of a study.
pub trait StudyOptions: Sized {
    /// The study.
    type Study: Study;

    /// Makes the study that the flags ask for.
    fn study(&self) -> Result<Self::Study>;

    /// The device.
    fn device(&self) -> &DeviceOptions;

    /// Opens the device that is measured.
    fn open(&self) -> Result<Gpu> {
        resolve::gpu(self.device())
    }

    /// Measures what the flags ask for.
    fn run(&self, run_options: &RunOptions) -> anyhow::Result<()> {
        run(self, run_options)
    }

    /// The mergers for shards of every study that the flags can ask for.
    fn mergers() -> Vec<Merger> {
        vec![Merger::for_study::<Self::Study>()]
    }

    /// Writes further files that the flags ask for, next to the study's own files.
    fn write_more(&self, _list: &CellList, _journal: &Journal) -> Result<()> {
        Ok(())
    }
}

/// The flags of a study, and the flags that every study has.
#[derive(Debug, Args)]
pub struct Measured<O: Args> {
    /// What is measured.
    #[command(flatten)]
    pub options: O,
    /// Which part of it, and where the results go.
    #[command(flatten)]
    pub run: RunOptions,
}

/// Measures the cells of the study that the journal of its folder lacks, then writes and prints the results. `options`
/// says what is measured, and `run_options` which shard of it, and where the results go.
///
/// # Errors
/// Errors of the flags, of the measurement and of files, and an error for a row that has to pass and does not.
pub fn run<O: StudyOptions>(options: &O, run_options: &RunOptions) -> anyhow::Result<()> {
    let mut study = options.study()?;
    let gpu = options.open()?;
    let list = engine::list(&study, &gpu, command_line(), run_options.shard);
    let mut run = Run::begin(run_options.output.as_deref(), run_options.resume)?;
    run.write_list(&list)?;
    let unreadable = engine::unreadable::<<O::Study as Study>::Row>(&list, &run.journal);
    if let [first, ..] = &unreadable[..] {
        let (count, first) = (unreadable.len(), super::printable(first));
        eprintln!(
            "ssct: warning: {count} result(s) of the journal cannot be read and are measured again, the first {first}"
        );
    }
    let bar = progress::bar(<O::Study as Study>::Row::KIND, engine::steps(&study, &list));
    let keep = &mut |file: &ExtraFile| {
        let Some(folder) = &run_options.output else { return Ok(()) };
        Ok(results::write_extra_file(&PathInFolder::folder(folder), file)?)
    };
    let advance = &mut |steps: usize| bar.inc(steps as u64);
    let outcome =
        engine::measure(&mut study, &list, &mut Bench { gpu: &gpu, journal: &mut run.journal, go_on, advance, keep });
    bar.finish_and_clear();
    drop(study);
    // Results that cannot be read in the journal may still be in the run's files, which are not overwritten with fewer
    // results.
    if outcome.is_err() && !unreadable.is_empty() {
        return run.outcome_with_journal(outcome);
    }
    // Measured rows are written even after an error; that error is reported before an error of writing.
    let rows = engine::rows::<<O::Study as Study>::Row>(&list, &run.journal);
    let missing = engine::missing::<<O::Study as Study>::Row>(&list, &run.journal);
    let results = Results { rows: &rows, list: &list, missing: &missing };
    let written = write(run_options, &results).and_then(|()| options.write_more(&list, &run.journal));
    let measured = run.outcome_with_journal(outcome);
    let is_whole = measured.is_ok() && written.is_ok();
    let finished = if is_whole { run.finish() } else { Ok(()) };
    // Printing comes last, so that a reader who closes the pipe early loses no file.
    let shown = if run_options.json { results.json() } else { results.text() };
    let printed = printed::out().write_all(shown.as_bytes());
    measured?;
    written?;
    finished?;
    gpu.check_validation()?;
    check_rows(&rows)?;
    Ok(printed?)
}

/// Writes the results into the folder of the run, if the run has a folder.
fn write<R: Row>(run_options: &RunOptions, results: &Results<R>) -> Result<()> {
    run_options.output.as_ref().map_or(Ok(()), |folder| Ok(results.write(&PathInFolder::folder(folder))?))
}
