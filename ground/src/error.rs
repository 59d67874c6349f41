//! The error of plain data and of files. The text of every variant is the whole sentence that a user reads.

use std::path::{Path, PathBuf};

/// What can go wrong. The text of each variant is one sentence that says what and where.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The arguments ask for something that does not exist or cannot be.
    #[error("{0}")]
    Usage(String),

    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried, as a verb: "read", "write", "create".
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },

    /// A scene, model or image file has wrong content.
    #[error("{}{}: {message}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1, where it is known.
        line: Option<usize>,
        /// A description of the fault.
        message: String,
    },
}

/// The result of plain data and of files.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An I/O error with its path.
    pub fn io(action: &'static str, path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { action, path: path.as_ref().to_path_buf(), source }
    }

    /// Wrong content of a file, at a line where that is known.
    pub fn malformed(path: impl AsRef<Path>, line: Option<usize>, message: impl Into<String>) -> Self {
        Self::Malformed { path: path.as_ref().to_path_buf(), line, message: message.into() }
    }
}
