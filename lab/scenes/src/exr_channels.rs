//! Reads and writes channels of 32-bit floats in OpenEXR files without rounding, for G-buffers and captures.

use super::Surface;
use super::exr_window::ImageWindow;
use exr::compression::Compression;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::MetaData;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers, WritableImage, read};
use glam::Vec3;
use ssct_geometry::bounded;
use ssct_ground::{Error, Result};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// The largest side, in pixels, of a G-buffer that can be read.
pub const MAX_SIDE: usize = 16384;

/// Greatest number of bytes that the unpacked channels of a G-buffer may take, and that a file may have.
pub const MAX_BYTES: u64 = 1 << 32;

/// Number of unpacked bytes that a file of any length may claim; for a larger claim, the file must be long enough.
const FREE_BYTES: u64 = 1 << 24;

/// The names of the compressions that keep every value, for messages about refused compressions. All others round some
/// channels, and a depth rounded to 24 bits is a wrong depth.
const LOSSLESS: &str = "ZIP, ZIPS, PIZ, RLE or none";

/// Returns true if a compression rounds the values of a channel of the given name and sample type. PXR24 rounds
/// 32-bit floats to 24 bits. B44 and B44A round 16-bit floats. DWAA and DWAB round floats of channels whose name after
/// the last point is that of a colour. All other values are kept to the bit.
pub(super) fn rounds_values(compression: Compression, channel_name: &str, sample_type: SampleType) -> bool {
    const COLOUR_NAMES: [&str; 11] = ["r", "red", "g", "grn", "green", "b", "blu", "blue", "y", "by", "ry"];
    match compression {
        Compression::PXR24 => sample_type == SampleType::F32,
        Compression::B44 | Compression::B44A => sample_type == SampleType::F16,
        Compression::DWAA(_) | Compression::DWAB(_) => {
            let last_part = channel_name.rsplit('.').next().unwrap_or(channel_name).to_ascii_lowercase();
            COLOUR_NAMES.contains(&last_part.as_str()) && sample_type != SampleType::U32
        }
        _ => false,
    }
}

/// Checks the sizes that the headers of a file claim, before memory for pixels is allocated. Errors name the file by
/// `path` and its content by `content`, as in "the G-buffer". Returns true if the images are so small that threads
/// would cost more time than they save.
///
/// # Errors
/// [`Error::Malformed`] if an image is larger than [`MAX_SIDE`] on a side, or if the channels would unpack to more than
/// [`MAX_BYTES`] or to more than a file of `file_bytes` bytes can hold.
pub fn check_claims(meta: &MetaData, file_bytes: usize, path: &Path, content: &str) -> Result<bool> {
    let malformed = |message: String| Error::malformed(path, None, message);
    // A `layer_size` is width and height.
    if let Some(size) =
        meta.headers.iter().map(|header| header.layer_size).find(|size| size.0 > MAX_SIDE || size.1 > MAX_SIDE)
    {
        return Err(malformed(format!(
            "{content} has {}x{} pixels; at most {MAX_SIDE} on each side are supported",
            size.0, size.1
        )));
    }
    let unpacked_bytes_of_part =
        |header: &Header| header.layer_size.area() as u64 * header.channels.list.len() as u64 * size_of::<f32>() as u64;
    let unpacked_bytes: u64 = meta.headers.iter().map(unpacked_bytes_of_part).fold(0, u64::saturating_add);
    if unpacked_bytes > MAX_BYTES || !bounded::may_unpack(file_bytes, unpacked_bytes, FREE_BYTES) {
        let message =
            format!("the channels would take {unpacked_bytes} bytes, too many for a file of {file_bytes} bytes");
        return Err(malformed(message));
    }
    Ok(unpacked_bytes < FREE_BYTES)
}

/// Makes the error for bytes that the crate exr cannot read as an image. The crate does not know the compressions of
/// newer versions of the format; this function recognises and names them.
pub(super) fn unreadable_error(path: &Path, bytes: &[u8], error: &exr::error::Error) -> Error {
    let message = match compression_number(bytes) {
        Some(number @ (10 | 11)) => unsupported_message(if number == 10 { "HTJ2K256" } else { "HTJ2K32" }),
        Some(12) => unsupported_message("LJ2K"),
        Some(13) => unsupported_message("ZSTD"),
        Some(other) => unsupported_message(&format!("of number {other}")),
        None => format!("cannot be read as an OpenEXR image: {error}"),
    };
    Error::malformed(path, None, message)
}

/// Makes the message about a compression that cannot be decoded. It advises users of Blender, which offers such
/// compressions.
fn unsupported_message(compression: &str) -> String {
    format!("its compression {compression} is not supported; save it with {LOSSLESS} (in Blender, Output, Codec: ZIP)")
}

/// Finds the number of the compression in the first 64 KiB of a file, if the crate does not know this compression;
/// `None` for any other file.
fn compression_number(bytes: &[u8]) -> Option<u8> {
    /// The greatest number of a compression that the crate knows.
    const LAST_KNOWN: u8 = 9;
    // An attribute consists of its name, its type, the length of its value (here 1 byte), and the value.
    const ATTRIBUTE: &[u8] = b"compression\0compression\0\x01\0\0\0";
    let header = &bytes[..bytes.len().min(1 << 16)];
    let offset = header.windows(ATTRIBUTE.len()).position(|window| window == ATTRIBUTE)?;
    header.get(offset + ATTRIBUTE.len()).copied().filter(|number| *number > LAST_KNOWN)
}

/// Checks that the crate can decode the compression of a part.
///
/// # Errors
/// A message about a compression that the crate can name and cannot decode.
pub(super) fn check_compression(header: &Header) -> std::result::Result<(), String> {
    match header.compression {
        Compression::HTJ2K32 => Err(unsupported_message("HTJ2K32")),
        Compression::HTJ2K256 => Err(unsupported_message("HTJ2K256")),
        _ => Ok(()),
    }
}

/// Checks that the compression of a part rounds none of its channels.
///
/// # Errors
/// A message that names the first rounded channel.
fn check_exact(header: &Header) -> std::result::Result<(), String> {
    let is_rounded = |channel: &&ChannelDescription| {
        rounds_values(header.compression, &channel.name.to_string(), channel.sample_type)
    };
    match header.channels.list.iter().find(is_rounded) {
        Some(channel) => Err(format!(
            "the compression {} loses precision in channel {}; save it with {LOSSLESS}",
            header.compression, channel.name
        )),
        None => Ok(()),
    }
}

/// Checks each value of a channel with `is_allowed`. The image is `width` pixels wide. In the message of the error,
/// `pixel_word` is "pixel" or "texel", and `allowed` says which values are allowed.
///
/// # Errors
/// [`Error::Malformed`] with the first pixel whose value is not allowed.
pub(super) fn check_values(
    path: &Path,
    (width, pixel_word): (u32, &str),
    channel: &str,
    allowed: &str,
    values: &[f32],
    is_allowed: impl Fn(f32) -> bool,
) -> Result<()> {
    let Some(index) = values.iter().position(|value| !is_allowed(*value)) else { return Ok(()) };
    let (x, y, value) = (index % width as usize, index / width as usize, values[index]);
    let message = format!("channel {channel} is {value} at {pixel_word} {x}, {y}; it must be {allowed}");
    Err(Error::malformed(path, None, message))
}

/// The channels of a file.
pub(super) struct ExrChannels<'a> {
    path: &'a Path,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The width of a pixel over its height (`pixelAspectRatio`).
    pub pixel_aspect: f32,
    /// Attributes of the file, beside its channels.
    pub attributes: LayerAttributes,
    channels: HashMap<String, Vec<f32>>,
}

impl<'a> ExrChannels<'a> {
    /// Decodes the bytes of a file. Errors name the file by `path` and its content by `content`, as in "the G-buffer".
    ///
    /// # Errors
    /// [`Error::Malformed`] if the bytes are not an OpenEXR image, or if the image is larger than [`MAX_SIDE`] or
    /// [`MAX_BYTES`]. This error is also returned if the file claims more pixels than its bytes can hold, has only a
    /// piece of an image, or uses a lossy compression.
    pub fn decode(bytes: &[u8], path: &'a Path, content: &str) -> Result<Self> {
        let malformed = |message: String| Error::malformed(path, None, message);
        let unreadable = |e: exr::error::Error| unreadable_error(path, bytes, &e);
        // The header is checked before any memory for pixels is allocated.
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
        meta.headers.iter().try_for_each(check_compression).map_err(malformed)?;
        meta.headers.iter().try_for_each(check_exact).map_err(malformed)?;
        meta.headers.iter().try_for_each(|header| ImageWindow::of_header(header).map(drop)).map_err(malformed)?;
        let is_small = check_claims(&meta, bytes.len(), path, content)?;
        let reader =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let reader = if is_small { reader.non_parallel() } else { reader };
        let image = reader.from_buffered(Cursor::new(bytes)).map_err(unreadable)?;
        let layer = image.layer_data;
        let window = ImageWindow::new(layer.attributes.layer_position, layer.size, image.attributes.display_window);
        let window = window.map_err(malformed)?;
        let named_values = |channel: AnyChannel<FlatSamples>| {
            (channel.name.to_string(), window.crop(channel.sample_data.values_as_f32().collect()))
        };
        Ok(Self {
            path,
            width: window.size[0] as u32,
            height: window.size[1] as u32,
            pixel_aspect: image.attributes.pixel_aspect,
            attributes: layer.attributes,
            channels: layer.channel_data.list.into_iter().map(named_values).collect(),
        })
    }

    /// Removes a channel and returns its values, with rows from the top. The result is `None` if no channel has this
    /// name and the image's size.
    pub fn take(&mut self, name: &str) -> Option<Vec<f32>> {
        let count = self.width as usize * self.height as usize;
        self.channels.remove(name).filter(|values| values.len() == count)
    }

    /// Removes the channel `sky` and returns the surface of each pixel: sky where the channel is above ½. Without the
    /// channel, every surface is lit.
    pub fn take_surfaces(&mut self) -> Vec<Surface> {
        let surface_of = |sky: f32| if sky > 0.5 { Surface::Sky } else { Surface::Lit };
        let count = self.width as usize * self.height as usize;
        self.take("sky").map_or(vec![Surface::Lit; count], |values| values.into_iter().map(surface_of).collect())
    }

    /// Removes a channel and returns its values, or an error if it is missing.
    pub fn required(&mut self, name: &str) -> Result<Vec<f32>> {
        self.take(name).ok_or_else(|| Error::malformed(self.path, None, format!("channel {name} is missing")))
    }

    /// Removes three channels and returns them as one vector for each pixel, or an error if one is missing.
    pub fn vectors(&mut self, names: [&str; 3]) -> Result<Vec<Vec3>> {
        let [x, y, z] = names.map(|name| self.required(name));
        Ok(x?.into_iter().zip(y?).zip(z?).map(|((x, y), z)| Vec3::new(x, y, z)).collect())
    }
}

/// Encodes channels as the bytes of a file. Each channel is a name with `width` × `height` values, row by row. Equal
/// channels give equal files.
///
/// # Errors
/// [`Error::Malformed`] if the format cannot hold the channels. `path` is only used to name the file in the error.
pub(super) fn encode(
    [width, height]: [u32; 2],
    attributes: LayerAttributes,
    channels: Vec<(&str, Vec<f32>)>,
    path: &Path,
) -> Result<Vec<u8>> {
    let to_any_channel = |(name, samples)| AnyChannel::new(name, FlatSamples::F32(samples));
    let channels = AnyChannels::sort(channels.into_iter().map(to_any_channel).collect());
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

/// Returns the channel `sky`, which is 1 where a surface shows the sky and 0 elsewhere; `None` if no surface shows it.
pub(super) fn sky_channel(surfaces: &[Surface]) -> Option<(&'static str, Vec<f32>)> {
    let value = |surface: &Surface| if *surface == Surface::Sky { 1.0 } else { 0.0 };
    surfaces.contains(&Surface::Sky).then(|| ("sky", surfaces.iter().map(value).collect()))
}

/// Returns the channels of the components of vectors, with the given names.
pub(super) fn vector_channels(names: [&'static str; 3], vectors: &[Vec3]) -> [(&'static str, Vec<f32>); 3] {
    [0, 1, 2].map(|component| (names[component], components(vectors, component)))
}

/// Returns one component (0 to 2) of each vector, as a channel.
pub(super) fn components(vectors: &[Vec3], component: usize) -> Vec<f32> {
    vectors.iter().map(|v| v[component]).collect()
}
