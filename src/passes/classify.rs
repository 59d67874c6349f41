//! Classification (docs/numerics.md, "What a robust method does", item 7): lists the tiles that hold mirrors, narrow
//! lobes and wide lobes, so that each kind has its own passes, over its tiles alone.

use super::GBuffer;
use super::tiles::{self, Tiles};
use crate::error::Result;
use crate::gpu::memory::MemoryPlace;
use crate::gpu::programs::Classify;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Buffer, ComputePipeline, Frame, Gpu, Image, ImageDesc};
use ash::vk;
use ssct_ground::math::constants::LISTS;

/// Pipeline and lists of one size.
pub struct ClassifyPass {
    pipeline: ComputePipeline<Classify<'static>>,
    lists: Buffer,
    listed: Image,
    arguments: Buffer,
}

impl ClassifyPass {
    /// Makes the pass for images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let tiles = tiles::count(extent);
        let [x, y] = tiles.map(u64::from);
        let listed = ImageDesc::one_level("listed tiles", vk::Format::R32_UINT, tiles, vk::ImageUsageFlags::STORAGE);
        Ok(Self {
            pipeline: ComputePipeline::new(gpu)?,
            lists: Buffer::new(gpu, "tiles", 4 * LISTS as u64 * x * y, U::STORAGE_BUFFER, MemoryPlace::Device)?,
            listed: Image::new(gpu, &listed)?,
            arguments: Buffer::new(
                gpu,
                "tile counts",
                tiles::ARGUMENT_BYTES,
                U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST,
                MemoryPlace::Device,
            )?,
        })
    }

    /// Records passes "classify/clear" and "classify/tiles", and returns the lists that they write.
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer, parameters: &UnifiedBlock) -> Result<Tiles<'a>> {
        let [x, y] = tiles::count(gbuffer.material.extent());
        frame.fill("classify/clear", &self.arguments, 0)?;
        let classify = Classify {
            unified: parameters,
            material_buffer: gbuffer.material.all(),
            Counts: &self.arguments,
            Tiles: &self.lists,
            listed_image: self.listed.all(),
        };
        frame.compute("classify/tiles", &self.pipeline, &classify, [x, y, 1])?;
        Ok(self.recorded())
    }

    /// Returns the lists as they were recorded last.
    pub fn recorded(&self) -> Tiles<'_> {
        self.tiles(false)
    }

    /// Returns the tiles of an image that needs no classification, since all its reflecting pixels are of one kind.
    pub fn whole(&self) -> Tiles<'_> {
        self.tiles(true)
    }

    fn tiles(&self, whole: bool) -> Tiles<'_> {
        Tiles { whole, lists: &self.lists, listed: &self.listed, arguments: &self.arguments }
    }
}
