//! Copies of images between device and host, as 32-bit floats.

use super::frame::FrameContext;
use super::image::{Image, ImageDesc, ImageSlice};
use super::memory::{Buffer, MemoryPlace};
use crate::error::{Error, Result};
use ash::vk;

/// Texels on the host, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Pixels {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Number of channels: 1, 2 or 4.
    pub channels: usize,
    /// `channels · width · height` values; sRGB is decoded to linear, and 32-bit whole numbers are the bits of floats.
    pub values: Vec<f32>,
}

impl Pixels {
    /// Texels of zeros.
    pub fn zeros([width, height]: [u32; 2], channels: usize) -> Self {
        Self { width, height, channels, values: vec![0.0; width as usize * height as usize * channels] }
    }

    /// The channels of a texel.
    pub fn texel(&self, x: u32, y: u32) -> &[f32] {
        let i = (y as usize * self.width as usize + x as usize) * self.channels;
        &self.values[i..i + self.channels]
    }

    /// The texels, in rows from the top.
    pub fn texels(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.channels)
    }
}

impl Image {
    /// Makes a 32-bit float RGBA image of the given texels, rows from the top, for shaders to sample.
    pub fn from_texels(context: &mut FrameContext, name: &str, extent: [u32; 2], texels: &[[f32; 4]]) -> Result<Self> {
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let format = vk::Format::R32G32B32A32_SFLOAT;
        let image = Self::new(context.gpu(), &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })?;
        let bytes = bytemuck::cast_slice(texels);
        let staging = Buffer::upload(context.gpu(), "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
        context.once(|frame| frame.upload("upload", &staging, image.level(0)))?;
        Ok(image)
    }
}

impl FrameContext {
    /// Reads back a mip level, or a slice of a volume. The layers of an array stand one below the other.
    ///
    /// # Errors
    /// [`Error::Usage`] for a format without a decoder.
    ///
    /// # Panics
    /// If `slice` covers more than one depth slice of a volume, since these are read one by one.
    pub fn read(&mut self, slice: ImageSlice) -> Result<Pixels> {
        assert_eq!(slice.slices().len(), 1, "{}: a volume is read slice by slice", slice.image().name());
        let format = slice.image().format();
        let (channels, texel_bytes, decode) = decoder(format)
            .ok_or_else(|| Error::Usage(format!("{}: {format:?} cannot be read back", slice.image().name())))?;
        let [width, height] = slice.extent();
        let height = height * slice.image().layers();
        let bytes = u64::from(width) * u64::from(height) * texel_bytes as u64;
        let buffer =
            Buffer::new(self.gpu(), "readback", bytes, vk::BufferUsageFlags::TRANSFER_DST, MemoryPlace::Readback)?;
        self.once(|frame| frame.download("readback", slice, &buffer))?;
        let values = decode(&buffer.bytes()?[..bytes as usize]);
        Ok(Pixels { width, height, channels, values })
    }
}

type Decode = fn(&[u8]) -> Vec<f32>;

/// Returns how many channels and bytes a format's texel has, and the function that decodes texels; `None` without one.
fn decoder(format: vk::Format) -> Option<(usize, usize, Decode)> {
    let f32s: Decode = |b| b.chunks_exact(4).map(|c| f32::from_ne_bytes([c[0], c[1], c[2], c[3]])).collect();
    let f16s: Decode = |b| b.chunks_exact(2).map(|c| half::f16::from_ne_bytes([c[0], c[1]]).to_f32()).collect();
    let unorm: Decode = |b| b.iter().map(|v| f32::from(*v) / 255.0).collect();
    let snorm: Decode = |b| b.iter().map(|v| (f32::from(v.cast_signed()) / 127.0).max(-1.0)).collect();
    let srgb: Decode = srgb_decoded;
    let bgra: Decode = |b| srgb_decoded(&b.chunks_exact(4).flat_map(|c| [c[2], c[1], c[0], c[3]]).collect::<Vec<u8>>());
    Some(match format {
        vk::Format::D32_SFLOAT | vk::Format::R32_SFLOAT => (1, 4, f32s),
        vk::Format::R32G32_SFLOAT => (2, 8, f32s),
        // Words of whole numbers are handed over as the bits of floats.
        vk::Format::R32G32B32A32_SFLOAT | vk::Format::R32G32B32A32_UINT => (4, 16, f32s),
        vk::Format::R16G16_SFLOAT => (2, 4, f16s),
        vk::Format::R16G16B16A16_SFLOAT => (4, 8, f16s),
        vk::Format::R8_UNORM => (1, 1, unorm),
        vk::Format::R8G8B8A8_UNORM => (4, 4, unorm),
        vk::Format::R8G8B8A8_SNORM => (4, 4, snorm),
        vk::Format::R8G8B8A8_SRGB => (4, 4, srgb),
        vk::Format::B8G8R8A8_SRGB => (4, 4, bgra),
        _ => return None,
    })
}

/// Decodes RGBA bytes in sRGB to linear values; alpha is linear already.
fn srgb_decoded(rgba: &[u8]) -> Vec<f32> {
    let unit = |v: u8| f32::from(v) / 255.0;
    let channel =
        |(i, v): (usize, &u8)| if i % 4 == 3 { unit(*v) } else { ssct_ground::math::srgb_to_linear(unit(*v)) };
    rgba.iter().enumerate().map(channel).collect()
}
