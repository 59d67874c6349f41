//! Names of the files that keep samples of a world reference in a folder: all samples, or those that one shard took.

use super::world::state::Fingerprint;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Returns the path of the file in `folder` that keeps all samples of the reference with the given [`short_name`].
pub fn whole_file(folder: &Path, short_name: &str) -> PathBuf {
    folder.join(format!("{short_name}.world"))
}

/// Returns the path of the file in `folder` that keeps the given range of samples of the reference with the given
/// [`short_name`].
pub fn part_file(folder: &Path, short_name: &str, samples: &Range<u32>) -> PathBuf {
    folder.join(format!("{short_name}-{}-{}.world", samples.start, samples.end))
}

/// Returns a short name of a reference's fingerprint, for file names: its first 16 bytes as hexadecimal digits.
pub fn short_name(fingerprint: &Fingerprint) -> String {
    fingerprint.iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}
