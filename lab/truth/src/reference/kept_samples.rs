//! The files that keep samples of a world reference in a folder: all of them, or the part that one shard took.

use super::world::state::Fingerprint;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The file in a folder that keeps all samples of a reference, by the [`short`] name of its fingerprint.
pub fn whole_file(folder: &Path, short: &str) -> PathBuf {
    folder.join(format!("{short}.world"))
}

/// The file in a folder that keeps some samples of a reference, by the [`short`] name of its fingerprint.
pub fn part_file(folder: &Path, short: &str, samples: &Range<u32>) -> PathBuf {
    folder.join(format!("{short}-{}-{}.world", samples.start, samples.end))
}

/// A short name of a fingerprint, for file names.
pub fn short(fingerprint: &Fingerprint) -> String {
    fingerprint.iter().take(16).map(|b| format!("{b:02x}")).collect()
}
