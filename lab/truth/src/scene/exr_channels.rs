//! Channels of 32-bit floats in OpenEXR files that rounds nothing: what files of G-buffers and of captures have in
//! common.

use super::bounded;
use crate::error::{Error, Result};
use exr::compression::Compression;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::MetaData;
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers, WritableImage, read};
use glam::Vec3;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// The largest side, in pixels, of a G-buffer that can be read.
pub const MAX_SIDE: usize = 16384;

/// The largest G-buffer that can be read, in bytes of its unpacked channels; also the largest file.
pub const MAX_BYTES: u64 = 1 << 32;

/// The channels of any file may unpack to this many bytes; for more, the file must be long enough.
const FREE_BYTES: u64 = 1 << 24;

/// The compressions that a file may use. All others round values, and a depth rounded to 24 bits is a
/// different depth. (The decoder of B44 also overflows on files that fuzzing finds.)
const LOSSLESS: [Compression; 5] =
    [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ];

/// Checks what the headers of a file of `length` bytes claim, before any memory for pixels is allocated. Errors call
/// the file `path` and its content `what`, as in "the G-buffer". Returns whether the images are so small that threads
/// cost more time than they save.
///
/// # Errors
/// [`Error::Malformed`] if an image is larger than [`MAX_SIDE`] on a side, or if the channels would unpack to more than
/// [`MAX_BYTES`] or to more than `length` bytes can hold.
pub fn check_claims(meta: &MetaData, length: usize, path: &Path, what: &str) -> Result<bool> {
    let wrong = |message: String| Error::malformed(path, None, message);
    if let Some(size) = meta.headers.iter().map(|h| h.layer_size).find(|s| s.0 > MAX_SIDE || s.1 > MAX_SIDE) {
        return Err(wrong(format!(
            "{what} has {}x{} pixels; at most {MAX_SIDE} on each side are supported",
            size.0, size.1
        )));
    }
    let header_bytes = |h: &Header| h.layer_size.area() as u64 * h.channels.list.len() as u64 * size_of::<f32>() as u64;
    let unpacked: u64 = meta.headers.iter().map(header_bytes).fold(0, u64::saturating_add);
    if unpacked > MAX_BYTES || !bounded::may_unpack(length, unpacked, FREE_BYTES) {
        return Err(wrong(format!("the channels would take {unpacked} bytes, too many for a file of {length} bytes")));
    }
    Ok(unpacked < FREE_BYTES)
}

/// Why bytes cannot be read as an OpenEXR image. The crate knows no compression that is younger than it, and does not name
/// the compression then.
pub(super) fn unreadable(path: &Path, bytes: &[u8], error: &exr::error::Error) -> Error {
    const SUPPORTED: &str = "save it with ZIP, ZIPS, PIZ, RLE or none";
    let number = compression_number(bytes);
    let name = match number {
        Some(10 | 11) => "HTJ2K".to_owned(),
        Some(12 | 13) => "zstd".to_owned(),
        Some(other) => format!("of number {other}"),
        None => return Error::malformed(path, None, format!("cannot be read as an OpenEXR image: {error}")),
    };
    Error::malformed(path, None, format!("its compression {name} is not supported; {SUPPORTED}"))
}

/// The number of a file's compression, if it is one that the crate does not know.
fn compression_number(bytes: &[u8]) -> Option<u8> {
    const KNOWN: u8 = 9;
    // An attribute is its name, its type, the length of its value, and the value.
    const ATTRIBUTE: &[u8] = b"compression\0compression\0\x01\0\0\0";
    let header = &bytes[..bytes.len().min(1 << 16)];
    let at = header.windows(ATTRIBUTE.len()).position(|window| window == ATTRIBUTE)?;
    header.get(at + ATTRIBUTE.len()).copied().filter(|number| *number > KNOWN)
}

/// # Errors
/// A sentence about a part whose compression the crate names and cannot read.
pub(super) fn check_compression(header: &Header) -> std::result::Result<(), String> {
    if matches!(header.compression, Compression::HTJ2K32 | Compression::HTJ2K256) {
        return Err("its compression HTJ2K is not supported; save it with ZIP, ZIPS, PIZ, RLE or none".to_owned());
    }
    Ok(())
}

/// # Errors
/// A sentence about a part that has only a piece of its image.
pub(super) fn check_whole(header: &Header) -> std::result::Result<(), String> {
    let window = header.shared_attributes.display_window;
    let position = header.own_attributes.layer_position;
    if position == window.position && header.layer_size == window.size {
        return Ok(());
    }
    let [part, whole] = [header.layer_size, window.size];
    Err(format!(
        "it has {}x{} pixels from {}, {} on, and its image has {}x{} from {}, {} on; only whole images can be read",
        part.0, part.1, position.0, position.1, whole.0, whole.1, window.position.0, window.position.1
    ))
}

/// # Errors
/// [`Error::Malformed`] with the first pixel of a channel that is not as it should be. `pixel` is what messages call one.
pub(super) fn check(
    path: &Path,
    (width, pixel): (u32, &str),
    channel: &str,
    allowed: &str,
    values: &[f32],
    is_right: impl Fn(f32) -> bool,
) -> Result<()> {
    let Some(at) = values.iter().position(|v| !is_right(*v)) else { return Ok(()) };
    let (x, y, value) = (at % width as usize, at / width as usize, values[at]);
    Err(Error::malformed(path, None, format!("channel {channel} is {value} at {pixel} {x}, {y}; it must be {allowed}")))
}

/// The channels of a file.
pub(super) struct ExrChannels<'a> {
    path: &'a Path,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// What the file says beside its channels.
    pub attributes: LayerAttributes,
    channels: HashMap<String, Vec<f32>>,
}

impl<'a> ExrChannels<'a> {
    /// Decodes the bytes of a file. Errors call the file `path` and what it should be `what`, as in "the G-buffer".
    ///
    /// # Errors
    /// [`Error::Malformed`] if the bytes are not an OpenEXR image, if the image is larger than [`MAX_SIDE`] or
    /// [`MAX_BYTES`], claims more pixels than that many bytes can hold, is only a piece of an image, or uses a lossy
    /// compression.
    pub fn decode(bytes: &[u8], path: &'a Path, what: &str) -> Result<Self> {
        let wrong = |message: String| Error::malformed(path, None, message);
        let unreadable = |e: exr::error::Error| unreadable(path, bytes, &e);
        // The header is checked before any memory for pixels is allocated.
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
        meta.headers.iter().try_for_each(check_compression).map_err(wrong)?;
        if let Some(lossy) = meta.headers.iter().map(|h| h.compression).find(|c| !LOSSLESS.contains(c)) {
            return Err(wrong(format!(
                "the compression {lossy} loses precision; supported are none, RLE, ZIP, ZIPS and PIZ"
            )));
        }
        meta.headers.iter().try_for_each(check_whole).map_err(wrong)?;
        let is_small = check_claims(&meta, bytes.len(), path, what)?;
        let read = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let read = if is_small { read.non_parallel() } else { read };
        let layer = read.from_buffered(Cursor::new(bytes)).map_err(unreadable)?.layer_data;
        let samples = |c: AnyChannel<FlatSamples>| (c.name.to_string(), c.sample_data.values_as_f32().collect());
        Ok(Self {
            path,
            width: layer.size.0 as u32,
            height: layer.size.1 as u32,
            attributes: layer.attributes,
            channels: layer.channel_data.list.into_iter().map(samples).collect(),
        })
    }

    /// Takes a channel, rows from the top; `None` if the file has none of this name and of the image's size.
    pub fn take(&mut self, name: &str) -> Option<Vec<f32>> {
        let count = self.width as usize * self.height as usize;
        self.channels.remove(name).filter(|v| v.len() == count)
    }

    /// Takes a channel that must be there.
    pub fn required(&mut self, name: &str) -> Result<Vec<f32>> {
        self.take(name).ok_or_else(|| Error::malformed(self.path, None, format!("channel {name} is missing")))
    }

    /// Takes three channels that must be there.
    pub fn vectors(&mut self, names: [&str; 3]) -> Result<Vec<Vec3>> {
        let [x, y, z] = names.map(|n| self.required(n));
        Ok(x?.into_iter().zip(y?).zip(z?).map(|((x, y), z)| Vec3::new(x, y, z)).collect())
    }
}

/// Encodes channels of one size as the bytes of a file. Equal channels give equal files.
///
/// # Errors
/// [`Error::Malformed`] if the format cannot hold them. `path` is only used to name the file in the error.
pub(super) fn encode(
    [width, height]: [u32; 2],
    attributes: LayerAttributes,
    channels: Vec<(&str, Vec<f32>)>,
    path: &Path,
) -> Result<Vec<u8>> {
    let channel = |(name, samples)| AnyChannel::new(name, FlatSamples::F32(samples));
    let channels = AnyChannels::sort(channels.into_iter().map(channel).collect());
    let layer = Layer::new((width as usize, height as usize), attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        // Blocks are written in order, so that equal images give equal files.
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::malformed(path, None, format!("cannot be encoded as OpenEXR: {e}")))?;
    Ok(bytes.into_inner())
}

/// A component of vectors as a channel.
pub(super) fn axis(vectors: &[Vec3], component: usize) -> Vec<f32> {
    vectors.iter().map(|v| v[component]).collect()
}
