//! The error type of the laboratory: the errors of the packages below it, and those of runs, folders and windows.

use std::path::{Path, PathBuf};

/// An error of the laboratory. The text of each variant is one sentence that says what went wrong, and where.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An error of the crate `ssct` or of a package below it: wrong arguments, data or files, or a call of Vulkan that
    /// failed.
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

    /// A folder holds a run that was not finished, whose measurements would be lost if another run began there.
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

/// The result of a function of the laboratory that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<ssct_ground::Error> for Error {
    fn from(error: ssct_ground::Error) -> Self {
        Self::Ssct(error.into())
    }
}

/// The name of a signal, by its number.
fn signal_name(signal: u8) -> String {
    match signal {
        2 => "SIGINT".to_owned(),
        15 => "SIGTERM".to_owned(),
        n => format!("signal {n}"),
    }
}

impl Error {
    /// An error of arguments that ask for something that does not exist or cannot be done.
    pub fn usage(sentence: String) -> Self {
        ssct::Error::Usage(sentence).into()
    }

    /// An I/O error with its path.
    pub fn io(action: &'static str, path: impl AsRef<Path>, source: std::io::Error) -> Self {
        ssct_ground::Error::io(action, path, source).into()
    }

    /// An error of a file's content, with the line if it is known.
    pub fn malformed(path: impl AsRef<Path>, line: Option<usize>, message: impl Into<String>) -> Self {
        ssct_ground::Error::malformed(path, line, message).into()
    }
}
