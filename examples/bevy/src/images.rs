//! Writes what the reflections read and made of a frame as 32-bit floats, for tests and for whoever looks for a fault.

use crate::device::Result;
use crate::passes::DEPTH;
use crate::reflect::Reflecting;
use bevy::prelude::*;
use bevy::render::renderer::RenderDevice;
use std::path::{Path, PathBuf};
use wgpu::TextureFormat;

/// Writes, after each frame of the camera, the images `depth`, `normal`, `material`, `color` and `reflection`, and the matrices
/// `camera` (view to clip, and world to view) to this folder, each as a file of 32-bit floats.
#[derive(Component, Clone)]
pub struct KeepImages(pub PathBuf);

/// Images on their way from the device.
pub struct Pending {
    pub folder: PathBuf,
    pub camera: [[f32; 16]; 2],
    copies: Vec<Copy>,
}

struct Copy {
    name: &'static str,
    buffer: wgpu::Buffer,
    format: TextureFormat,
    width: u32,
    row: u32,
}

impl Pending {
    /// Records copying textures, and leaves them in the state `RESOURCE`.
    pub fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        folder: &Path,
        camera: [[f32; 16]; 2],
        images: &[(&'static str, &wgpu::Texture)],
    ) -> Self {
        let copies = images.iter().map(|(name, texture)| Copy::record(device, encoder, name, texture)).collect();
        let state = wgpu::TextureUses::RESOURCE;
        let back =
            images.iter().map(|(_, texture)| wgpu::TextureTransition { texture: *texture, selector: None, state });
        encoder.transition_resources(std::iter::empty(), back);
        Self { folder: folder.into(), camera, copies }
    }

    fn write(&self, device: &wgpu::Device) -> Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        let numbers: Vec<u8> = self.camera.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(self.folder.join("camera.f32"), numbers)?;
        self.copies.iter().for_each(|copy| copy.buffer.map_async(wgpu::MapMode::Read, .., |_| ()));
        device.poll(wgpu::PollType::wait_indefinitely())?;
        for copy in &self.copies {
            let bytes = copy.buffer.get_mapped_range(..)?;
            let texel = bytes_of(copy.format);
            let rows = bytes.chunks_exact(copy.row as usize).map(|row| &row[..(copy.width * texel) as usize]);
            let floats: Vec<u8> = rows.flat_map(|row| floats(row, copy.format)).collect();
            std::fs::write(self.folder.join(copy.name).with_extension("f32"), floats)?;
        }
        Ok(())
    }
}

impl Copy {
    fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        name: &'static str,
        texture: &wgpu::Texture,
    ) -> Self {
        let (width, format) = (texture.width(), texture.format());
        let row = (width * bytes_of(format)).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: u64::from(row) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        Self { name, buffer, format, width, row }
    }
}

/// Bytes of a texel of the formats of passes.rs.
fn bytes_of(format: TextureFormat) -> u32 {
    format.block_copy_size(None).unwrap_or_default()
}

/// Texels of an image as 32-bit floats.
fn floats(bytes: &[u8], format: TextureFormat) -> Vec<u8> {
    if format == DEPTH {
        return bytes.to_vec();
    }
    let halves = bytes.as_chunks::<2>().0.iter();
    halves.flat_map(|half| half::f16::from_ne_bytes(*half).to_f32().to_le_bytes()).collect()
}

/// Waits for the images that were kept of a frame, and writes them.
pub fn write(reflecting: Option<Res<Reflecting>>, device: Res<RenderDevice>) {
    for pending in reflecting.iter().flat_map(|reflecting| reflecting.take_pending()) {
        if let Err(why) = pending.write(device.wgpu_device()) {
            error!("the images of {} were not written: {why}", pending.folder.display());
        }
    }
}
