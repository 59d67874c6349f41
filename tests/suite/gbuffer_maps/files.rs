//! Writes files as other renderers have them: OpenEXR of several parts, tiles and kinds of samples, and PNG.

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::meta::attribute::{AttributeValue, IntegerBounds};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, LineOrder, Vec2, WritableImage};
use half::f16;
use std::path::Path;

/// A part of an OpenEXR file for [`write_exr`].
pub struct Part {
    pub name: Option<String>,
    pub channels: Vec<(String, FlatSamples)>,
    pub compression: Compression,
    /// The side of square tiles in pixels; none for scan lines.
    pub tiles: Option<usize>,
    pub attributes: LayerAttributes,
}

impl Part {
    /// Returns an unnamed part of scan lines with these channels and a lossless compression.
    pub fn new(channels: Vec<(String, FlatSamples)>) -> Self {
        let (compression, attributes) = (Compression::ZIP16, LayerAttributes::default());
        Self { name: None, channels, compression, tiles: None, attributes }
    }

    /// Returns the part with a name.
    pub fn named(self, name: &str) -> Self {
        Self { name: Some(name.to_owned()), ..self }
    }

    /// Returns the part with another compression.
    pub fn compressed(self, compression: Compression) -> Self {
        Self { compression, ..self }
    }

    /// Returns the part in square tiles, whose side is given in pixels.
    pub fn tiled(self, side: usize) -> Self {
        Self { tiles: Some(side), ..self }
    }

    /// Returns the part with one more attribute.
    pub fn with(mut self, name: &str, value: AttributeValue) -> Self {
        self.attributes.other.insert(name.into(), value);
        self
    }
}

/// Returns a channel of 32-bit floats.
pub fn floats(values: impl IntoIterator<Item = f64>) -> FlatSamples {
    FlatSamples::F32(values.into_iter().map(|v| v as f32).collect())
}

/// Returns a channel of 16-bit floats.
pub fn halves(values: impl IntoIterator<Item = f64>) -> FlatSamples {
    FlatSamples::F16(values.into_iter().map(f16::from_f64).collect())
}

/// Returns a channel of 32-bit integers.
pub fn integers(values: impl IntoIterator<Item = u32>) -> FlatSamples {
    FlatSamples::U32(values.into_iter().collect())
}

/// Turns a channel upside down: the lowest row comes first.
pub fn flipped(samples: FlatSamples, width: usize) -> FlatSamples {
    /// Returns a channel of rows of `width` values, with the rows in opposite order.
    fn flip<T: Copy>(values: &[T], width: usize) -> Vec<T> {
        values.chunks(width).rev().flatten().copied().collect()
    }
    match samples {
        FlatSamples::F32(values) => FlatSamples::F32(flip(&values, width)),
        FlatSamples::F16(values) => FlatSamples::F16(flip(&values, width)),
        FlatSamples::U32(values) => FlatSamples::U32(flip(&values, width)),
    }
}

/// Writes an OpenEXR file of a width and height in pixels.
pub fn write_exr(path: &Path, [width, height]: [u32; 2], parts: Vec<Part>) {
    let size = Vec2(width as usize, height as usize);
    let layer = |part: Part| {
        let channels = part.channels.into_iter().map(|(name, samples)| AnyChannel::new(name.as_str(), samples));
        let encoding = Encoding {
            compression: part.compression,
            blocks: part.tiles.map_or(Blocks::ScanLines, |side| Blocks::Tiles(Vec2(side, side))),
            line_order: LineOrder::Increasing,
        };
        let layer_name = part.name.map(|name| name.as_str().into());
        let attributes = LayerAttributes { layer_name, ..part.attributes };
        Layer::new(size, attributes, encoding, AnyChannels::sort(channels.collect()))
    };
    let layers: Vec<_> = parts.into_iter().map(layer).collect();
    let image = Image::from_layers(ImageAttributes::new(IntegerBounds::from_dimensions(size)), layers);
    image.write().non_parallel().to_file(path).unwrap();
}

/// Writes a PNG of 8 bits from values of 0 to 1; `texel` returns those of the pixel with an index. Returns the rounded
/// values that the file holds, from 0 to 1.
pub fn write_png(path: &Path, [width, height]: [u32; 2], texel: impl Fn(usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    let bytes: Vec<[u8; 3]> = (0..width as usize * height as usize)
        .map(|i| texel(i).map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8))
        .collect();
    let image = image::RgbImage::from_raw(width, height, bytes.concat()).unwrap();
    image.save(path).unwrap();
    bytes.into_iter().map(|texel| texel.map(|v| f64::from(v) / 255.0)).collect()
}
