//! The uniform blocks of one frame, in memory that the host writes. The memory grows with the number of blocks that a
//! frame binds: two for each material of a scene, and again for every mirror and probe that the scene is drawn for.

use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::memory::{Buffer, MemoryPlace};
use ash::vk;

/// Bytes of a chunk. The first one is enough for every built-in scene.
const CHUNK_BYTES: u64 = 1 << 20;

/// Chunks of host-visible memory for one frame at a time; later frames use them again.
pub(super) struct Uniforms {
    gpu: Gpu,
    chunks: Vec<Buffer>,
    /// The chunk that the next block goes to, if it fits there.
    current: usize,
    /// Bytes of that chunk that are taken.
    used: u64,
}

impl Uniforms {
    /// Makes one chunk, which is empty.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self { gpu: gpu.clone(), chunks: vec![new_chunk(gpu, CHUNK_BYTES)?], current: 0, used: 0 })
    }

    /// Forgets every block. Call this function only while no submission that reads a block is under way.
    pub fn reset(&mut self) {
        (self.current, self.used) = (0, 0);
    }

    /// Appends a block, and returns where it lies until [`Self::reset`].
    ///
    /// # Errors
    /// [`Error::Memory`](crate::error::Error::Memory) or [`Error::Vulkan`](crate::error::Error::Vulkan) where
    /// another chunk is needed and cannot be had.
    pub fn put(&mut self, bytes: &[u8]) -> Result<vk::DescriptorBufferInfo> {
        let size = bytes.len() as u64;
        let alignment = self.gpu.shared().limits.min_uniform_buffer_offset_alignment.max(16);
        let mut offset = self.used.next_multiple_of(alignment);
        while self.chunks.get(self.current).is_some_and(|chunk| offset + size > chunk.size()) {
            (self.current, offset) = (self.current + 1, 0);
        }
        if self.current == self.chunks.len() {
            self.chunks.push(new_chunk(&self.gpu, size.max(CHUNK_BYTES))?);
        }
        self.used = offset + size;
        let chunk = &mut self.chunks[self.current];
        chunk.bytes_mut()?[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(vk::DescriptorBufferInfo::default().buffer(chunk.handle()).offset(offset).range(size))
    }
}

fn new_chunk(gpu: &Gpu, size: u64) -> Result<Buffer> {
    Buffer::new(gpu, "frame uniforms", size, vk::BufferUsageFlags::UNIFORM_BUFFER, MemoryPlace::Upload)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::device::DeviceQuery;

    #[test]
    fn blocks_that_outgrow_a_chunk_lie_apart_and_hold_what_was_put() {
        let gpu = Gpu::open(&DeviceQuery::default()).expect("a device");
        let mut uniforms = Uniforms::new(&gpu).expect("memory");
        let sizes = [100, CHUNK_BYTES - 300, 400, CHUNK_BYTES, 3 * CHUNK_BYTES, 16];
        let mut chunks = Vec::new();
        for round in 0..2 {
            uniforms.reset();
            let mut put = Vec::new();
            for (n, size) in sizes.into_iter().enumerate() {
                let content = vec![(16 * round + n) as u8; size as usize];
                put.push((uniforms.put(&content).expect("memory"), content));
            }
            for (place, content) in put {
                let chunk = uniforms.chunks.iter().find(|c| c.handle() == place.buffer).expect("a chunk");
                let held = &chunk.bytes().expect("mapped")[place.offset as usize..][..place.range as usize];
                assert!(held == content, "{place:?}");
            }
            chunks.push(uniforms.chunks.iter().map(Buffer::handle).collect::<Vec<_>>());
        }
        assert!(chunks[0].len() > 3, "{chunks:?}");
        assert_eq!(chunks[0], chunks[1], "the second frame uses the first one's memory again");
    }
}
