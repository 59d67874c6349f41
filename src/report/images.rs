//! Images: PNG to look at, EXR to compute with.

use super::files::write;
use crate::error::{Error, Result};
use crate::gpu::Pixels;
use crate::math::{display_byte, linear_to_srgb};
use crate::passes::PathCode;
use crate::scene::Lens;
use crate::study::{Dump, Intermediates};
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
    /// One colour a texel, by a function of its channels.
    pub fn from_pixels(pixels: &Pixels, color: impl Fn(&[f32]) -> [u8; 3]) -> Self {
        Self { width: pixels.width, height: pixels.height, bytes: pixels.texels().flat_map(color).collect() }
    }

    /// Writes a PNG.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_png(path, [self.width, self.height], &self.bytes, image::ExtendedColorType::Rgb8)
    }
}

/// Writes 8-bit RGBA, rows from the top, as it stands.
pub fn write_rgba_png(path: &Path, extent: [u32; 2], rgba: &[u8]) -> Result<()> {
    write_png(path, extent, rgba, image::ExtendedColorType::Rgba8)
}

fn write_png(path: &Path, [width, height]: [u32; 2], bytes: &[u8], kind: image::ExtendedColorType) -> Result<()> {
    let mut encoded = Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut encoded, bytes, width, height, kind, image::ImageFormat::Png)
        .map_err(|e| Error::io("encode", path, std::io::Error::other(e)))?;
    write(path, encoded.get_ref())
}

/// The display image: clamped, sRGB-encoded, no tone mapping.
pub fn display(pixels: &Pixels) -> Rgb {
    Rgb::from_pixels(pixels, |c| [display_byte(c[0]), display_byte(c[1]), display_byte(c[2])])
}

/// An error unless a path ends as an image does that [`write_image`] writes: before the work, not after.
pub fn check_extension(path: &Path) -> Result<()> {
    if is(path, "png") || is(path, "exr") {
        return Ok(());
    }
    Err(Error::Usage(format!("{}: an image is written as .png or .exr", path.display())))
}

/// Writes a linear image by its extension: `.png` (the display image) or `.exr` (32-bit floats).
pub fn write_image(path: &Path, pixels: &Pixels) -> Result<()> {
    check_extension(path)?;
    if is(path, "exr") { write_exr(path, pixels, &["R", "G", "B", "A"]) } else { display(pixels).write_png(path) }
}

fn is(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Writes every channel as 32-bit floats, under the names given.
pub fn write_exr(path: &Path, pixels: &Pixels, names: &[&str]) -> Result<()> {
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
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        // In order, so that equal images are equal files.
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::io("encode", path, std::io::Error::other(e.to_string())))?;
    write(path, bytes.get_ref())
}

/// Writes intermediates, each as PNG and EXR.
pub fn write_intermediates(folder: &Path, all: &Intermediates, lens: &Lens) -> Result<()> {
    for (stem, kind, pixels) in all {
        picture(*kind, pixels, lens).write_png(&folder.join(format!("{stem}.png")))?;
        let names: &[&str] = match kind {
            Dump::Color => &["R", "G", "B", "A"],
            Dump::Normal => &["N.X", "N.Y", "N.Z", "N.W"],
            Dump::ReversedDepth => &["depth"],
            Dump::StandardDepth => &["min", "max"],
            Dump::Share => &["share"],
            Dump::Material => &["reflectivity", "roughness"],
            Dump::Hits => &["u", "v", "depth", "path"],
        };
        write_exr(&folder.join(format!("{stem}.exr")), pixels, names)?;
        if *kind == Dump::Hits {
            paths(pixels).write_png(&folder.join("paths.png"))?;
        }
    }
    Ok(())
}

/// An intermediate as a picture.
pub fn picture(kind: Dump, pixels: &Pixels, lens: &Lens) -> Rgb {
    let unit = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    match kind {
        Dump::Color => display(pixels),
        Dump::Normal => {
            Rgb::from_pixels(pixels, |c| [0, 1, 2].map(|i| if c[..3] == [0.0; 3] { 0 } else { unit(c[i] * 0.5 + 0.5) }))
        }
        Dump::ReversedDepth => Rgb::from_pixels(pixels, |c| [depth_shade(c[0], lens); 3]),
        Dump::StandardDepth => {
            Rgb::from_pixels(pixels, |c| [depth_shade(1.0 - c[0], lens), depth_shade(1.0 - c[1], lens), 0])
        }
        Dump::Share => Rgb::from_pixels(pixels, |c| [unit(c[0]); 3]),
        Dump::Material => Rgb::from_pixels(pixels, |c| [unit(c[0]), unit(c[1]), 0]),
        Dump::Hits => Rgb::from_pixels(pixels, |c| {
            if PathCode::from_channel(c[3]).is_some_and(PathCode::is_hit) {
                [unit(c[0]), unit(c[1]), 0]
            } else {
                [0; 3]
            }
        }),
    }
}

/// The figure 4.5 colouring of which path each ray took: Hi-Z green, linear march red; misses and
/// rays out of iterations darker; what does not reflect black.
pub fn paths(hits: &Pixels) -> Rgb {
    Rgb::from_pixels(hits, |c| match PathCode::from_channel(c[3]) {
        Some(PathCode::HiZ) => [0, 200, 0],
        Some(PathCode::Miss) => [0, 90, 0],
        Some(PathCode::Exhausted) => [160, 160, 0],
        Some(PathCode::Linear) => [220, 0, 0],
        Some(PathCode::LinearMiss | PathCode::Untraced) => [100, 0, 0],
        Some(PathCode::None) | None => [0; 3],
    })
}

/// Brightness of a reversed depth: near is bright. The logarithm spreads what depth compresses; a
/// hundred times the near distance is mid-grey.
fn depth_shade(reversed: f32, lens: &Lens) -> u8 {
    if reversed <= 0.0 {
        return 0;
    }
    let z = lens.near_m * lens.far_m / (lens.near_m + reversed * (lens.far_m - lens.near_m));
    let share = (z / lens.near_m).ln() / (1e4_f32).ln();
    (linear_to_srgb((1.0 - share).clamp(0.0, 1.0)) * 255.0 + 0.5) as u8
}
