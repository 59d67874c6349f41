//! Buffers with their memory.

use super::device::{Gpu, vulkan};
use super::sync::State;
use crate::error::{Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::cell::Cell;
use std::rc::Rc;

/// A buffer that owns its memory and destroys itself.
pub struct Buffer {
    gpu: Gpu,
    handle: vk::Buffer,
    allocation: Option<Allocation>,
    size: u64,
    state: Rc<Cell<State>>,
    name: String,
}

/// Where a buffer lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Device memory.
    Device,
    /// Memory that the host writes and the device reads.
    Upload,
    /// Memory that the device writes and the host reads.
    Readback,
}

impl Buffer {
    /// Makes a buffer of `size` bytes (at least 4).
    pub fn new(gpu: &Gpu, name: &str, size: u64, usage: vk::BufferUsageFlags, place: Place) -> Result<Self> {
        let size = size.max(4);
        let info = vk::BufferCreateInfo::default().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the create info is complete; the handle is destroyed in `drop`.
        let handle =
            unsafe { gpu.raw().create_buffer(&info, None) }.map_err(vulkan(format!("vkCreateBuffer for {name}")))?;
        let mut buffer =
            Self { gpu: gpu.clone(), handle, allocation: None, size, state: Rc::default(), name: name.to_owned() };
        gpu.name(handle, name);
        // SAFETY: the handle was just made.
        let requirements = unsafe { gpu.raw().get_buffer_memory_requirements(handle) };
        let location = match place {
            Place::Device => MemoryLocation::GpuOnly,
            Place::Upload => MemoryLocation::CpuToGpu,
            Place::Readback => MemoryLocation::GpuToCpu,
        };
        let allocation = allocate(gpu, name, requirements, location, true)?;
        // SAFETY: the memory fits the requirements and is freed after the buffer.
        let bound = unsafe { gpu.raw().bind_buffer_memory(handle, allocation.memory(), allocation.offset()) };
        // Whatever came of it, the memory goes with what it was for.
        buffer.allocation = Some(allocation);
        bound.map_err(vulkan(format!("vkBindBufferMemory for {name}")))?;
        Ok(buffer)
    }

    /// A buffer in upload memory that holds some bytes.
    pub fn upload(gpu: &Gpu, name: &str, bytes: &[u8], usage: vk::BufferUsageFlags) -> Result<Self> {
        let mut buffer = Self::new(gpu, name, bytes.len() as u64, usage, Place::Upload)?;
        buffer.bytes_mut()?[..bytes.len()].copy_from_slice(bytes);
        Ok(buffer)
    }

    /// Size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// What the host sees of a readback buffer.
    pub fn bytes(&self) -> Result<&[u8]> {
        self.allocation
            .as_ref()
            .and_then(|a| a.mapped_slice())
            .map(|s| &s[..self.size as usize])
            .ok_or_else(|| self.unmapped())
    }

    /// What the host may write of an upload buffer.
    pub fn bytes_mut(&mut self) -> Result<&mut [u8]> {
        let (size, error) = (self.size as usize, self.unmapped());
        self.allocation.as_mut().and_then(|a| a.mapped_slice_mut()).map(|s| &mut s[..size]).ok_or(error)
    }

    fn unmapped(&self) -> Error {
        Error::Memory { what: self.name.clone(), message: "the buffer is not visible to the host".into() }
    }

    /// The handle.
    pub fn handle(&self) -> vk::Buffer {
        self.handle
    }

    pub(crate) fn state(&self) -> &Rc<Cell<State>> {
        &self.state
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for before resources go (`FrameContext`).
        unsafe { self.gpu.raw().destroy_buffer(self.handle, None) };
        release(&self.gpu, self.allocation.take());
    }
}

/// Memory for a resource, named after it.
pub(super) fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation> {
    gpu.allocator()
        .allocate(&AllocationCreateDesc {
            name,
            requirements,
            location,
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })
        .map_err(|e| Error::Memory { what: name.to_owned(), message: e.to_string() })
}

/// Gives memory back; what can't be freed is reported, since a drop has no other way.
pub(super) fn release(gpu: &Gpu, allocation: Option<Allocation>) {
    if let Some(Err(e)) = allocation.map(|a| gpu.allocator().free(a)) {
        tracing::error!("device memory could not be freed: {e}");
    }
}
