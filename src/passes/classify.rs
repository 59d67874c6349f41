//! Classification (NUMERICS, "What a robust method does", item 7): which tiles of an image hold mirrors,
//! narrow lobes and wide ones, so that each is traced where it is and by what it needs.

use super::GBuffer;
use super::tiles::{self, LISTS, Tiles};
use crate::error::Result;
use crate::gpu::memory::Place;
use crate::gpu::shader::{UNIFIED_CLASSIFY_COMP, UnifiedBlock};
use crate::gpu::{Buffer, ComputePipeline, Frame, Gpu, Image, ImageDesc, Resource};
use ash::vk;

/// Pipeline and lists of one size.
pub struct ClassifyPass {
    pipeline: ComputePipeline,
    lists: Buffer,
    listed: Image,
    arguments: Buffer,
}

impl ClassifyPass {
    /// For images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let tiles = tiles::count(extent);
        let [x, y] = tiles.map(u64::from);
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, &UNIFIED_CLASSIFY_COMP)?,
            lists: Buffer::new(gpu, "tiles", LISTS * 4 * x * y, U::STORAGE_BUFFER, Place::Device)?,
            listed: Image::new(
                gpu,
                &ImageDesc {
                    name: "listed tiles",
                    format: vk::Format::R32_UINT,
                    extent: tiles,
                    levels: 1,
                    layers: 1,
                    usage: vk::ImageUsageFlags::STORAGE,
                },
            )?,
            arguments: Buffer::new(
                gpu,
                "tile counts",
                LISTS * 16,
                U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST,
                Place::Device,
            )?,
        })
    }

    /// Passes "classify/clear" and "classify/tiles".
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer, parameters: &UnifiedBlock) -> Result<Tiles<'a>> {
        let [x, y] = tiles::count(gbuffer.material.extent());
        frame.fill("classify/clear", &self.arguments, 0)?;
        frame.compute(
            "classify/tiles",
            &self.pipeline,
            &[
                ("unified", Resource::Uniform(bytemuck::bytes_of(parameters))),
                ("material_buffer", Resource::Loaded(gbuffer.material.all())),
                ("Counts", Resource::Buffer(&self.arguments)),
                ("Tiles", Resource::Buffer(&self.lists)),
                ("listed_image", Resource::Storage(self.listed.all())),
            ],
            &[],
            [x, y, 1],
        )?;
        Ok(Tiles { lists: &self.lists, listed: &self.listed, arguments: &self.arguments })
    }
}
