//! Images: PNG to look at, EXR to compute with.

use crate::study::compare::LinearImage;
use ssct::gpu::Pixels;
use ssct::passes::Content;
use ssct::passes::PathCode;
use ssct_geometry::bounded;
use ssct_geometry::texture::{self, Encoding, MAX_EXTENT, Texture};
use ssct_ground::math::{display_byte, linear_to_srgb, srgb_to_linear};
use ssct_ground::{Error, Result};
use ssct_scenes::Lens;
use ssct_scenes::gbuffer_file::{MAX_BYTES, check_claims};
use ssct_scenes::inside::PathInFolder;
use std::io::Cursor;
use std::path::Path;

/// An 8-bit RGB image, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rgb {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 3 · width · height bytes.
    pub bytes: Vec<u8>,
}

impl Rgb {
    /// Makes an image in which each texel has the colour that `color` makes out of the texel's channels.
    pub fn from_pixels(pixels: &Pixels, color: impl Fn(&[f32]) -> [u8; 3]) -> Self {
        Self { width: pixels.width, height: pixels.height, bytes: pixels.texels().flat_map(color).collect() }
    }

    /// Writes a PNG.
    pub fn write_png(&self, to: impl Into<PathInFolder>) -> Result<()> {
        write_png(&to.into(), [self.width, self.height], &self.bytes, image::ExtendedColorType::Rgb8)
    }
}

/// Writes an 8-bit RGBA image as a PNG, without any conversion, rows from the top.
pub fn write_rgba_png(to: impl Into<PathInFolder>, extent: [u32; 2], rgba: &[u8]) -> Result<()> {
    write_png(&to.into(), extent, rgba, image::ExtendedColorType::Rgba8)
}

/// Writes the bytes of an image as a PNG; `channels` says which channels a pixel has, and how many bits each.
fn write_png(to: &PathInFolder, extent: [u32; 2], bytes: &[u8], channels: image::ExtendedColorType) -> Result<()> {
    let [width, height] = extent;
    let mut encoded = Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut encoded, bytes, width, height, channels, image::ImageFormat::Png)
        .map_err(|e| Error::io("encode", to.path(), std::io::Error::other(e)))?;
    to.write(encoded.get_ref())
}

/// Returns the display image of linear colours: clamped to 0…1, sRGB-encoded, without tone mapping.
pub fn display(pixels: &Pixels) -> Rgb {
    Rgb::from_pixels(pixels, |c| [display_byte(c[0]), display_byte(c[1]), display_byte(c[2])])
}

/// Fails unless a path has an extension that [`write_image`] writes. Commands call it before their work, so that no
/// work is lost.
pub fn check_extension(path: &Path) -> Result<()> {
    if has_extension(path, "png") || has_extension(path, "exr") {
        return Ok(());
    }
    Err(Error::Usage(format!("{}: an image is written as .png or .exr", path.display())))
}

/// Writes a linear image by its extension: `.png` (the display image) or `.exr` (32-bit floats).
pub fn write_image(to: impl Into<PathInFolder>, pixels: &Pixels) -> Result<()> {
    let to = to.into();
    check_extension(&to.path())?;
    if has_extension(&to.path(), "exr") {
        write_exr(to, pixels, &["R", "G", "B", "A"])
    } else {
        display(pixels).write_png(&to)
    }
}

/// True if the path has the extension, in small or in capital letters.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Writes an image as OpenEXR, with every channel as 32-bit floats. `names` are the channels' names, in their order.
pub fn write_exr(to: impl Into<PathInFolder>, pixels: &Pixels, names: &[&str]) -> Result<()> {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
    };
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = (0..pixels.channels)
        .map(|c| AnyChannel::new(names[c], FlatSamples::F32(pixels.texels().map(|t| t[c]).collect())))
        .collect();
    let layer = Layer::new(
        (pixels.width as usize, pixels.height as usize),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let to = to.into();
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        // Blocks are written in order, so that equal images are equal files.
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::io("encode", to.path(), std::io::Error::other(e.to_string())))?;
    to.write(bytes.get_ref())
}

/// The most pixels of an image that is compared. For a larger image, the differences alone would take gigabytes.
const MOST_PIXELS: u64 = 1 << 26;

/// Reads an image as linear colours. An `.exr` gives the channels R, G and B without a change; any other image is decoded from sRGB to
/// linear, 8 bits a channel. Alpha is left out.
///
/// # Errors
/// [`Malformed`](ssct_ground::Error::Malformed) for a file that is no such image, or has more than [`MAX_EXTENT`] pixels on a side or more
/// than 2²⁶ in all. For an `.exr`, the size is checked before memory is taken for the pixels.
pub fn read_image(path: &Path) -> Result<LinearImage> {
    if has_extension(path, "exr") {
        return read_exr(path);
    }
    let Texture { width, height, rgba, .. } = texture::decode(path, Encoding::Srgb)?;
    check_pixels([width, height], path)?;
    let linear = |byte: u8| srgb_to_linear(f32::from(byte) / 255.0);
    let rgb = rgba.chunks_exact(4).map(|t| [linear(t[0]), linear(t[1]), linear(t[2])]).collect();
    Ok(LinearImage { width, height, rgb })
}

/// Refuses an image of more than [`MOST_PIXELS`] pixels.
fn check_pixels([width, height]: [u32; 2], path: &Path) -> Result<()> {
    if u64::from(width) * u64::from(height) <= MOST_PIXELS {
        return Ok(());
    }
    let message = format!("an image of {width}x{height} pixels; images of at most {MOST_PIXELS} in all are read here");
    Err(Error::malformed(path, None, message))
}

/// Reads the channels R, G and B of the first layer that has them.
fn read_exr(path: &Path) -> Result<LinearImage> {
    let Pixels { width, height, values, .. } = read_exr_channels(path, ["R", "G", "B"], None)?;
    Ok(LinearImage { width, height, rgb: values.chunks_exact(4).map(|t| [t[0], t[1], t[2]]).collect() })
}

/// Reads the first layer that has the three channels `names`, and its channel `fourth` if that is given. The image has
/// four channels, in this order; the last is 0 if `fourth` is `None`.
///
/// # Errors
/// The errors of [`read_image`], and [`Malformed`](ssct_ground::Error::Malformed) for an image that lacks a channel.
pub fn read_exr_channels(path: &Path, names: [&str; 3], fourth: Option<&str>) -> Result<Pixels> {
    decode_exr_channels(&bounded::read(path, "an image", MAX_BYTES)?, path, names, fourth)
}

/// Decodes the bytes of a file as [`read_exr_channels`] does; `path` names the file in errors.
pub fn decode_exr_channels(bytes: &[u8], path: &Path, names: [&str; 3], fourth: Option<&str>) -> Result<Pixels> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, ReadSpecificChannel, read};
    let wrong = |message: String| Error::malformed(path, None, message);
    let unreadable = |e: exr::error::Error| wrong(format!("no OpenEXR image that can be read: {e}"));
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
    let limit = MAX_EXTENT as usize;
    let layer_sizes = || meta.headers.iter().map(|header| [header.layer_size.0, header.layer_size.1]);
    if let Some([width, height]) = layer_sizes().find(|sides| sides.iter().any(|side| *side > limit)) {
        return Err(wrong(format!("an image of {width}x{height} pixels; at most {limit} a side are read")));
    }
    layer_sizes().try_for_each(|sides| check_pixels(sides.map(|side| side as u32), path))?;
    check_claims(&meta, bytes.len(), path, "the image")?;
    let mut channels = meta.headers.iter().flat_map(|h| &h.channels.list);
    // The decoder of single channels treats every channel as one of full resolution.
    if let Some(c) = channels.clone().find(|c| (c.sampling.0, c.sampling.1) != (1, 1)) {
        return Err(wrong(format!("channel {} is subsampled, which is not read", c.name)));
    }
    if let Some(fourth) = fourth.filter(|name| !channels.any(|c| c.name == **name)) {
        return Err(wrong(format!("channel {fourth} is missing")));
    }
    let layer = read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(names[0])
        .required(names[1])
        .required(names[2])
        .optional(fourth.unwrap_or_default(), 0.0)
        // The reader fills a pair: the width of the image, and the values of all its pixels.
        .collect_pixels(
            |size, _| (size.0, vec![0.0; 4 * size.0 * size.1]),
            |(width, values), position, (r, g, b, a): (f32, f32, f32, f32)| {
                let first = 4 * (position.1 * *width + position.0);
                values[first..first + 4].copy_from_slice(&[r, g, b, a]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(unreadable)?
        .layer_data;
    // Both sides are at most MAX_EXTENT, so they fit in 32 bits.
    let (width, height) = (layer.size.0 as u32, layer.size.1 as u32);
    Ok(Pixels { width, height, channels: 4, values: layer.channel_data.pixels.1 })
}

/// Makes a picture to look at of an image of a frame. `content` says what the numbers of the image mean, and the planes
/// of `lens` decide the shades of depths.
pub fn picture(content: Content, pixels: &Pixels, lens: &Lens) -> Rgb {
    match content {
        Content::Color => display(pixels),
        Content::Normal => Rgb::from_pixels(pixels, |c| {
            [0, 1, 2].map(|i| if c[..3] == [0.0; 3] { 0 } else { unit_byte(c[i] * 0.5 + 0.5) })
        }),
        Content::ReversedDepth => Rgb::from_pixels(pixels, |c| [depth_shade(c[0], lens); 3]),
        Content::StandardDepth => {
            // The minimum alone is grey; with the maximum, the minimum is red and the maximum green.
            let shade = |depth: f32| depth_shade(1.0 - depth, lens);
            Rgb::from_pixels(pixels, |c| if c.len() > 1 { [shade(c[0]), shade(c[1]), 0] } else { [shade(c[0]); 3] })
        }
        Content::LinearDepth => Rgb::from_pixels(pixels, |c| [distance_shade(c[0], lens); 3]),
        Content::Share => Rgb::from_pixels(pixels, |c| [unit_byte(c[0]); 3]),
        // Red is the front of a cell, and green its back. A cell without geometry has a negative front and is black.
        Content::Pyramid(_) => Rgb::from_pixels(pixels, |c| {
            if c[0] < 0.0 { [0; 3] } else { [depth_shade(c[0], lens), depth_shade(c[1], lens), 0] }
        }),
        Content::Numbers => Rgb::from_pixels(pixels, |c| [0, 1, 2].map(|i| c.get(i).map_or(0, |v| unit_byte(*v)))),
        Content::Steps => {
            let most_steps = pixels.texels().map(|c| c[0]).fold(1.0, f32::max);
            Rgb::from_pixels(pixels, |c| [unit_byte(c[0] / most_steps); 3])
        }
        Content::Material => Rgb::from_pixels(pixels, |c| [unit_byte(c[0]), unit_byte(c[1]), 0]),
        Content::Hits => Rgb::from_pixels(pixels, |c| {
            if PathCode::from_channel(c[3]).is_some_and(PathCode::is_hit) {
                [unit_byte(c[0]), unit_byte(c[1]), 0]
            } else {
                [0; 3]
            }
        }),
    }
}

/// Colours, each with the path codes that it stands for and their meaning. Hi-Z is green and the linear march red, as
/// in figure 4.5 of the thesis.
pub const PATH_COLORS: &[(Color, &[PathCode], &str)] = &[
    ([0; 3], &[PathCode::None], "does not reflect"),
    ([0, 200, 0], &[PathCode::HiZ], "hit by the Hi-Z traversal"),
    (
        [0, 90, 0],
        &[PathCode::Miss, PathCode::MissScreen, PathCode::MissNear, PathCode::MissSky],
        "left the picture in the Hi-Z traversal",
    ),
    ([0, 60, 60], &[PathCode::MissBehind], "passed behind a surface"),
    ([160, 160, 0], &[PathCode::Exhausted, PathCode::Unfinished], "ran out of steps in the Hi-Z traversal"),
    ([220, 0, 0], &[PathCode::Linear], "hit by a linear march"),
    ([100, 0, 0], &[PathCode::LinearMiss, PathCode::Untraced], "found nothing in a march, or was not traced"),
    ([110, 80, 0], &[PathCode::LinearExhausted], "ran out of steps in a linear march"),
    ([0, 110, 200], &[PathCode::Capture, PathCode::Triangle], "hit in a capture, or a triangle"),
    ([120, 180, 255], &[PathCode::Sky], "ended in the sky"),
    ([120, 0, 120], &[PathCode::Unknown], "went where no capture sees it"),
];

/// Red, green and blue of a display image.
pub type Color = [u8; 3];

/// Makes a picture of the path codes of all pixels, in the colours of [`PATH_COLORS`].
pub fn paths(hits: &Pixels) -> Rgb {
    let color =
        |code: PathCode| PATH_COLORS.iter().find(|(_, codes, _)| codes.contains(&code)).map(|(color, ..)| *color);
    Rgb::from_pixels(hits, |c| PathCode::from_channel(c[3]).and_then(color).unwrap_or_default())
}

/// Returns the brightness that shows a reversed depth, as a byte; the sky is black.
fn depth_shade(reversed: f32, lens: &Lens) -> u8 {
    if reversed <= 0.0 {
        return 0;
    }
    if lens.kind().is_orthographic() {
        return srgb_byte(reversed);
    }
    // A perspective has the reversed depth d at the view-space z = near · far / (near + d · (far − near)).
    distance_shade(lens.near_m * lens.far_m / (lens.near_m + reversed * (lens.far_m - lens.near_m)), lens)
}

/// Returns the brightness that shows a view-space z in metres, as a byte; near is bright. For a perspective, the
/// logarithm spreads far distances, which its depth compresses; a hundred times the near distance is mid-grey. The
/// depth of an orthographic projection compresses nothing.
fn distance_shade(z: f32, lens: &Lens) -> u8 {
    if lens.kind().is_orthographic() {
        return srgb_byte((lens.far_m - z) / (lens.far_m - lens.near_m));
    }
    srgb_byte(1.0 - (z / lens.near_m).ln() / (1e4_f32).ln())
}

/// Returns a number as a byte: 0 for 0 or less, and 255 for 1 or more. It is not encoded as sRGB.
pub(super) fn unit_byte(number: f32) -> u8 {
    (number.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Encodes a linear share from 0 to 1 as a byte of sRGB; smaller and greater numbers count as 0 and 1.
fn srgb_byte(share: f32) -> u8 {
    (linear_to_srgb(share.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}
