//! Bounds on what a file may cost: how many bytes of it are read, and how much it may claim to unpack to.

use crate::error::{Error, Result};
use std::io::Read;
use std::path::Path;

/// The most bytes that a byte of a compressed image may become. Deflate ends at 1032 to 1, and a PNG of
/// one bit a texel becomes eight times that; a file that claims more is no image but a bomb.
pub(super) const MOST_UNPACKED_PER_BYTE: u64 = 8 * 1040;

/// The bytes of a file of at most `most`; `what` says in errors what it should be.
pub(super) fn read(path: &Path, what: &str, most: u64) -> Result<Vec<u8>> {
    let unreadable = |e| Error::io("read", path, e);
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut bytes = Vec::new();
    if length <= most {
        // A file may grow, and some have a length of 0 and no end.
        file.take(most + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    let length = length.max(bytes.len() as u64);
    if length > most {
        let message = format!("{what} of {length} bytes is larger than the {most} that are read");
        return Err(Error::malformed(path, None, message));
    }
    Ok(bytes)
}

/// Whether a file of some length may hold an image that takes `unpacked` bytes of memory. `free` are
/// granted to any file, however short.
pub(super) fn may_unpack(length: usize, unpacked: u64, free: u64) -> bool {
    unpacked <= free.saturating_add(MOST_UNPACKED_PER_BYTE.saturating_mul(length as u64))
}
