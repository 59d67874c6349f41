//! Parts that the commands with long runs share: a run's folder, its journal, a way to stop it, and the command line that pages show.

use super::printed::quote_word;
use crate::error::{Error, Result};
use crate::report::run_folder::{FolderClaim, JOURNAL};
use crate::study::cell_list::CellList;
use crate::study::journal::Journal;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

/// The signal that asked to stop, or 0.
static STOP_SIGNAL: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// A run, which keeps its measurements if it has a folder.
pub struct Run {
    /// The measurements, and the file that keeps them.
    pub journal: Journal,
    /// The claim on the run's folder, and the path of the folder.
    claim: Option<(FolderClaim, PathBuf)>,
}

impl Run {
    /// Claims the folder, if there is one. From now on, SIGINT and SIGTERM stop the run only between two samples; the second signal stops
    /// it at once.
    pub fn begin(folder: Option<&Path>, resume: bool) -> Result<Self> {
        let Some(folder) = folder else { return Self::with_signals(Journal::default(), None) };
        let claim = FolderClaim::new(folder)?;
        let journal = claim.journal(resume)?;
        Self::with_signals(journal, Some((claim, folder.to_owned())))
    }

    /// Claims the folder as [`Run::begin`] does, but begins a new journal: the caller knows all results in the folder and writes them
    /// again.
    pub fn begin_anew(folder: &Path) -> Result<Self> {
        let claim = FolderClaim::new(folder)?;
        let journal = claim.new_journal()?;
        Self::with_signals(journal, Some((claim, folder.to_owned())))
    }

    /// Makes a run that listens for signals: the first asks the run to stop, and the second ends the process at once.
    fn with_signals(journal: Journal, claim: Option<(FolderClaim, PathBuf)>) -> Result<Self> {
        // True once a signal came. Of the actions on a signal, the first ends the process if the flag is true already,
        // the second sets the flag, and the third stores the signal's number, for which `go_on` looks.
        let was_asked = Arc::<AtomicBool>::default();
        for signal in [SIGINT, SIGTERM] {
            let registered = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&was_asked))
                .and_then(|_| flag::register(signal, Arc::clone(&was_asked)))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&STOP_SIGNAL), signal as usize));
            registered.map_err(|e| Error::io("listen for signals of", "this process", e))?;
        }
        Ok(Self { journal, claim })
    }

    /// Writes the list of the run's cells into its folder, if there is one.
    pub fn write_list(&self, cells: &CellList) -> Result<()> {
        self.claim.as_ref().map_or(Ok(()), |(claim, _)| claim.write_list(cells))
    }

    /// Notes in the folder that all is measured and written, so that the next run may begin anew there.
    pub fn finish(self) -> Result<()> {
        self.claim.map_or(Ok(()), |(claim, _)| claim.finish())
    }

    /// Returns the outcome of a measurement; if a signal stopped it, the error also says where the results so far are kept.
    pub fn outcome_with_journal<T, E: Into<anyhow::Error>>(
        &self,
        outcome: std::result::Result<T, E>,
    ) -> anyhow::Result<T> {
        outcome.map_err(|e| {
            let e = e.into();
            match (e.downcast_ref(), &self.claim) {
                (Some(&Error::Stopped { signal, .. }), Some((_, folder))) => {
                    Error::Stopped { signal, kept: Some(folder.join(JOURNAL)) }.into()
                }
                _ => e,
            }
        })
    }
}

/// Flags without a value that change this run and not the whole study.
const RUN_FLAGS: [&str; 2] = ["--resume", "--json"];
/// Flags with one value that change this run and not the whole study.
const RUN_FLAGS_WITH_VALUE: [&str; 5] = ["--shard", "--output", "-o", "--device", "--cache"];

/// Returns the command of this process as a page shows it, without the flags that differ from machine to machine and
/// from shard to shard.
pub fn command_line() -> String {
    study_command(std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()))
}

/// Returns the command of the whole study, made of a run's arguments after the program's name.
fn study_command(arguments: impl Iterator<Item = String>) -> String {
    let mut words = vec!["ssct".to_owned()];
    // Whether the next argument is the value of a flag that is left out.
    let mut skips_value = false;
    for argument in arguments {
        let flag = argument.split('=').next().unwrap_or_default();
        if std::mem::take(&mut skips_value) || RUN_FLAGS.contains(&flag) {
            continue;
        }
        if RUN_FLAGS_WITH_VALUE.contains(&flag) {
            skips_value = !argument.contains('=');
            continue;
        }
        // The value may follow -o without a blank.
        if argument.starts_with("-o") {
            continue;
        }
        words.push(quote_word(&argument));
    }
    words.join(" ")
}

/// Fails if a signal asked the run to stop. Measurements call it between two samples.
pub fn go_on() -> Result<()> {
    match STOP_SIGNAL.load(Ordering::Relaxed) {
        0 => Ok(()),
        signal => Err(Error::Stopped { signal: signal as u8, kept: None }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_of_a_study_have_one_command() {
        let command = |text: &str| study_command(text.split_whitespace().map(str::to_owned));
        let study = "ssct error --quick --rays 4";
        for run_flags in ["--shard 2/3 -o a", "--shard=2/3 --output=b --resume", "-oc --json --device 1", ""] {
            assert_eq!(command(&format!("error --quick {run_flags} --rays 4")), study);
        }
        let quoted = study_command(["error", "--variant", "stochastic --history on"].map(str::to_owned).into_iter());
        assert_eq!(quoted, "ssct error --variant \"stochastic --history on\"");
        let folder = study_command(["error", "--variant", "\"my m\" --fade off"].map(str::to_owned).into_iter());
        assert_eq!(folder, "ssct error --variant '\"my m\" --fade off'");
    }
}
