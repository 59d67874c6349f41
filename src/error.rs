//! The one error type of the library. Every variant names the file, the pass or the Vulkan call
//! that failed, so that its text is the whole sentence a user reads.

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

    /// No Vulkan device can be used.
    #[error("no Vulkan device: {0}")]
    NoDevice(String),

    /// No window can be opened, or none can be drawn to.
    #[error("no window: {0}")]
    NoWindow(String),

    /// A Vulkan call failed.
    #[error("Vulkan: {what} failed: {}", vulkan_text(*result))]
    Vulkan {
        /// The call, and the object or pass it was for.
        what: String,
        /// What the driver returned.
        result: ash::vk::Result,
    },

    /// Device memory could not be allocated.
    #[error("Vulkan: no memory for {what}: {message}")]
    Memory {
        /// The image or buffer.
        what: String,
        /// The allocator's message.
        message: String,
    },

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

    /// The validation layers found fault with the run.
    #[error(
        "the validation layers reported {} message(s) outside the allow-list: {} (SSCT_LOG=vulkan=warn prints each \
         whole); the first: {first}",
        ids.iter().map(|(_, times)| times).sum::<usize>(),
        ids.iter().map(|(id, times)| format!("{times} of {id}")).collect::<Vec<_>>().join(", ")
    )]
    Validation {
        /// The identifiers of the messages, and how often each came.
        ids: Vec<(String, usize)>,
        /// The text of the first message.
        first: String,
    },
}

/// The library's result.
pub type Result<T> = std::result::Result<T, Error>;

/// The text of a Vulkan result, with its usual cause where there is one.
fn vulkan_text(result: ash::vk::Result) -> String {
    use ash::vk::Result as R;
    match result {
        R::ERROR_DEVICE_LOST => {
            "the device has been lost; a shader that runs too long, or reads where it must not, is the most frequent cause".into()
        }
        R::ERROR_OUT_OF_HOST_MEMORY => "the memory of the host is short (ulimit -v may bound it)".into(),
        R::ERROR_OUT_OF_DEVICE_MEMORY => "the memory of the device is short".into(),
        other => other.to_string(),
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
    /// An I/O error with its path.
    pub fn io(action: &'static str, path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { action, path: path.as_ref().to_path_buf(), source }
    }

    /// Wrong content of a file, at a line where that is known.
    pub fn malformed(path: impl AsRef<Path>, line: Option<usize>, message: impl Into<String>) -> Self {
        Self::Malformed { path: path.as_ref().to_path_buf(), line, message: message.into() }
    }
}
