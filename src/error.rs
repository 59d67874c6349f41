//! The error of the library. A user reads its text alone, so that each names the call, image or pass that failed.

/// What can go wrong. The text of each variant is one sentence that says what and where.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The arguments ask for something that does not exist or cannot be.
    #[error("{0}")]
    Usage(String),

    /// A file is wrong, or cannot be read or written. Only methods that are added read or write files.
    #[error(transparent)]
    File(ssct_ground::Error),

    /// No Vulkan device can be used.
    #[error("no Vulkan device: {0}")]
    NoDevice(String),

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
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<ssct_ground::Error> for Error {
    fn from(error: ssct_ground::Error) -> Self {
        match error {
            ssct_ground::Error::Usage(sentence) => Self::Usage(sentence),
            other => Self::File(other),
        }
    }
}

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
