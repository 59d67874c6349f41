//! Limits on the cost of a file: the number of bytes that are read, and the size that it may claim to unpack to.

use indicatif::{ProgressBar, ProgressStyle};
use ssct_ground::{Error, Result};
use std::io::Read;
use std::path::Path;

/// Greatest number of bytes that one byte of a compressed image may unpack to. Deflate compresses by at most 1032 to 1,
/// and a PNG with one bit per texel unpacks to eight times as much. A file that claims more is a decompression bomb.
pub const MOST_UNPACKED_PER_BYTE: u64 = 8 * 1040;

/// Reads a regular file of at most `most_bytes` bytes, and returns its content. `content_name` names the expected
/// content in errors, as in "a scene file". The call fails for a larger file, and for all but regular files.
pub fn read(path: &Path, content_name: &str, most_bytes: u64) -> Result<Vec<u8>> {
    let unreadable = |error| Error::io("read", path, error);
    // Reading a device may never end, and opening a named pipe waits for a writer.
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(Error::malformed(
            path,
            None,
            format!("is no file; {content_name} is read from a regular file alone"),
        ));
    }
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let length = metadata.len();
    let mut bytes = Vec::new();
    if length <= most_bytes {
        // One byte more than allowed is read, so that a file that grew after its length was taken is noticed.
        file.take(most_bytes + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    let length = length.max(bytes.len() as u64);
    if length > most_bytes {
        let message = format!("{content_name} of {length} bytes is too large; at most {most_bytes} bytes are read");
        return Err(Error::malformed(path, None, message));
    }
    Ok(bytes)
}

/// Returns a name from a file in the form for messages: at most 80 characters of it, with � for each control character,
/// which a terminal might obey.
pub fn printable_name(name: &str) -> String {
    const MOST_CHARACTERS: usize = 80;
    let without_control = |letter: char| if letter.is_control() { '\u{fffd}' } else { letter };
    let mut shown: String = name.chars().take(MOST_CHARACTERS).map(without_control).collect();
    if name.chars().nth(MOST_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

/// Returns true if a file of `length` bytes may hold an image that unpacks to `unpacked` bytes. Any file, however
/// short, may unpack to `always_allowed` bytes.
pub fn may_unpack(length: usize, unpacked: u64, always_allowed: u64) -> bool {
    unpacked <= always_allowed.saturating_add(MOST_UNPACKED_PER_BYTE.saturating_mul(length as u64))
}

/// Makes a progress bar over the images of a scene, of which `images` is the number. The bar is hidden for few images,
/// and if standard error is no terminal.
pub fn image_bar(images: usize) -> ProgressBar {
    /// Fewer images than this are decoded so soon that no bar is needed.
    const FEW: usize = 16;
    if images < FEW {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(images as u64).with_message("images");
    match ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
