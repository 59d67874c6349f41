//! What a long run has around it: its folder and journal, and a way to stop it.

use crate::error::{Error, Result};
use crate::report::run_folder::{Claim, JOURNAL};
use crate::study::journal::Journal;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

/// The signal that asked to stop, or 0.
static ASKED: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// A run that keeps what it measures, where it has a folder.
pub struct Run {
    /// What was measured, and where it is kept.
    pub journal: Journal,
    claim: Option<(Claim, PathBuf)>,
}

impl Run {
    /// Claims the folder, if there is one, and from now on stops at SIGINT and SIGTERM only between two
    /// samples; at the second signal, at once.
    ///
    /// # Errors
    /// As for [`Claim::new`] and [`Claim::journal`].
    pub fn begin(folder: Option<&Path>, resume: bool) -> Result<Self> {
        let claim = folder.map(|f| Ok::<_, Error>((Claim::new(f)?, f.to_owned()))).transpose()?;
        let journal = claim.as_ref().map(|(claim, _)| claim.journal(resume)).transpose()?.unwrap_or_default();
        let again = Arc::<AtomicBool>::default();
        for signal in [SIGINT, SIGTERM] {
            let listening = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))
                .and_then(|_| flag::register(signal, Arc::clone(&again)))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&ASKED), signal as usize));
            listening.map_err(|e| Error::io("listen for signals of", "this process", e))?;
        }
        Ok(Self { journal, claim })
    }

    /// Notes that all is measured and written.
    pub fn finish(self) -> Result<()> {
        self.claim.map_or(Ok(()), |(claim, _)| claim.finish())
    }

    /// What ended the measurement, if it did not end by itself, with where what it has is kept.
    pub fn ended<T, E: Into<anyhow::Error>>(&self, outcome: std::result::Result<T, E>) -> anyhow::Result<T> {
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

/// To be called between two samples.
///
/// # Errors
/// [`Error::Stopped`] once a signal asked for it.
pub fn go_on() -> Result<()> {
    match ASKED.load(Ordering::Relaxed) {
        0 => Ok(()),
        signal => Err(Error::Stopped { signal: signal as u8, kept: None }),
    }
}
