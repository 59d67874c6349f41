//! Writes the images that the reflections of a frame read and made as 32-bit floats, for tests and to look for faults.

use crate::device::Result;
use crate::reflect::Reflecting;
use bevy::prelude::*;
use bevy::render::renderer::RenderDevice;
use embed_wgpu::{bytes_of, copy_out, floats};
use std::path::{Path, PathBuf};
use wgpu::TextureFormat;

/// Makes the app write files of 32-bit floats to this folder after each frame of the camera: the images `depth`,
/// `normal`, `material`, `color` and `reflection`, and the matrices `camera` (view to clip, and world to view).
#[derive(Component, Clone)]
pub struct KeepImages(pub PathBuf);

/// Copies of a frame's images in buffers, which can be read once the device is done with the frame.
pub struct Pending {
    pub folder: PathBuf,
    /// View to clip, and world to view, by columns.
    pub camera: [[f32; 16]; 2],
    copies: Vec<Copy>,
}

/// A buffer with the texels of an image; `row` is the bytes from one row of texels to the next.
struct Copy {
    name: &'static str,
    buffer: wgpu::Buffer,
    format: TextureFormat,
    width: u32,
    row: u32,
}

impl Pending {
    /// Records copies of the named textures to buffers, and leaves the textures in the state `RESOURCE`.
    pub fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        folder: &Path,
        camera: [[f32; 16]; 2],
        images: &[(&'static str, &wgpu::Texture)],
    ) -> Self {
        let copy = |(name, texture): &(&'static str, &wgpu::Texture)| {
            let (buffer, row) = copy_out(device, encoder, texture);
            Copy { name, buffer, format: texture.format(), width: texture.width(), row }
        };
        let copies = images.iter().map(copy).collect();
        let state = wgpu::TextureUses::RESOURCE;
        let transitions =
            images.iter().map(|(_, texture)| wgpu::TextureTransition { texture: *texture, selector: None, state });
        encoder.transition_resources(std::iter::empty(), transitions);
        Self { folder: folder.into(), camera, copies }
    }

    /// Waits for the device, and writes `camera.f32` and one file for each image to the folder.
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

/// Waits for the copies of this frame's images that [`KeepImages`] asked for, and writes them.
pub fn write(reflecting: Option<Res<Reflecting>>, device: Res<RenderDevice>) {
    for pending in reflecting.iter().flat_map(|reflecting| reflecting.take_pending()) {
        if let Err(why) = pending.write(device.wgpu_device()) {
            error!("the images of {} were not written: {why}", pending.folder.display());
        }
    }
}
