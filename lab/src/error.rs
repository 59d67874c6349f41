//! The error of the laboratory: those of the packages below it, and what runs, folders and windows add.

use std::path::{Path, PathBuf};

/// What can go wrong. The text of each variant is one sentence that says what and where.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The crate `ssct` reports it, or the packages below it: wrong arguments, plain data or files, or a call of Vulkan that failed.
    #[error(transparent)]
    Ssct(#[from] ssct::Error),

    /// No window can be opened, or none can be drawn to.
    #[error("no window: {0}")]
    NoWindow(String),

    /// Another run is writing into the folder.
    #[error("another run is writing into {}: wait for its end, or take another folder", folder.display())]
    Busy {
        /// The folder.
        folder: PathBuf,
    },

    /// A folder holds a run that was not finished, and what it measured would be lost.
    #[error("{} holds what a run measured that was not finished", folder.display())]
    Unfinished {
        /// The folder.
        folder: PathBuf,
        /// The journal of what was measured.
        journal: PathBuf,
    },

    /// A signal asked the program to stop.
    #[error("stopped by {}{}", signal_name(*signal), kept.as_ref().map(|k| format!(
        ": what was measured is in {}", k.display())).unwrap_or_default())]
    Stopped {
        /// The signal's number.
        signal: u8,
        /// The journal of what was measured, if there is one.
        kept: Option<PathBuf>,
    },
}

/// The laboratory's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<ssct_ground::Error> for Error {
    fn from(error: ssct_ground::Error) -> Self {
        Self::Ssct(error.into())
    }
}

fn signal_name(signal: u8) -> String {
    match signal {
        2 => "SIGINT".to_owned(),
        15 => "SIGTERM".to_owned(),
        n => format!("signal {n}"),
    }
}

impl Error {
    /// Arguments that ask for something that does not exist or cannot be.
    pub fn usage(sentence: String) -> Self {
        ssct::Error::Usage(sentence).into()
    }

    /// An I/O error with its path.
    pub fn io(action: &'static str, path: impl AsRef<Path>, source: std::io::Error) -> Self {
        ssct_ground::Error::io(action, path, source).into()
    }

    /// Wrong content of a file, at a line where that is known.
    pub fn malformed(path: impl AsRef<Path>, line: Option<usize>, message: impl Into<String>) -> Self {
        ssct_ground::Error::malformed(path, line, message).into()
    }
}
