//! Device memory, from the crate's allocator or the caller's, and buffers with their memory.

use super::device::{Gpu, vulkan};
use super::sync::TrackedState;
use crate::error::{Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{AllocationCreateDesc, AllocationScheme, Allocator};
use std::ptr::NonNull;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A buffer that owns its memory and destroys itself.
pub struct Buffer {
    gpu: Gpu,
    handle: vk::Buffer,
    allocation: Option<Allocation>,
    size: u64,
    state: TrackedState,
    name: String,
}

/// What kind of memory a buffer or an image lives in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MemoryPlace {
    /// Device memory.
    Device,
    /// Memory that the host writes and the device reads.
    Upload,
    /// Memory that the device writes and the host reads.
    Readback,
}

/// An allocator that the caller gives, in place of the crate's own.
///
/// # Safety
/// A block that [`allocate`](Self::allocate) gives fits the requirements, is of the context's device, has no second
/// owner until it is [freed](Self::free), and is mapped as [`MemoryBlock::mapped`] says.
pub unsafe trait DeviceMemory: Send {
    /// Memory for an image or a buffer; `linear` is false for images of optimal tiling.
    ///
    /// # Errors
    /// A clause that says why there is no such memory.
    fn allocate(
        &mut self,
        name: &str,
        requirements: &vk::MemoryRequirements,
        place: MemoryPlace,
        linear: bool,
    ) -> std::result::Result<MemoryBlock, String>;

    /// Takes back a block whose image or buffer is already destroyed.
    fn free(&mut self, block: MemoryBlock);
}

/// A part of a memory object.
#[derive(Debug)]
pub struct MemoryBlock {
    /// The memory object.
    pub memory: vk::DeviceMemory,
    /// Where the part begins, in bytes.
    pub offset: u64,
    /// Address of the part on the host, in coherent memory, for [`MemoryPlace::Upload`] and [`MemoryPlace::Readback`].
    pub mapped: Option<NonNull<u8>>,
    /// A number of the allocator's choice, which the allocator gets back with the block.
    pub key: u64,
}

// SAFETY: the pointer is into mapped memory that is this block's alone (`DeviceMemory`).
unsafe impl Send for MemoryBlock {}
// SAFETY: through a shared block, its mapped memory is only read.
unsafe impl Sync for MemoryBlock {}

/// The allocator of a device's memory.
pub(super) enum MemorySource {
    /// The crate's own allocator.
    Ours(Box<Mutex<Allocator>>),
    /// The caller's allocator.
    Callers(Mutex<Box<dyn DeviceMemory>>),
}

/// Memory of an image or a buffer.
pub(super) enum Allocation {
    /// Memory from the crate's own allocator.
    Ours(gpu_allocator::vulkan::Allocation),
    /// A block of the caller's allocator, and its size in bytes.
    Callers(MemoryBlock, u64),
}

impl MemorySource {
    /// Bytes that are allocated, and bytes of the blocks that hold them; both are 0 for a caller's allocator.
    pub fn bytes(&self) -> (u64, u64) {
        let Self::Ours(allocator) = self else { return (0, 0) };
        let report = locked(allocator).generate_report();
        (report.total_allocated_bytes, report.total_capacity_bytes)
    }

    /// Allocates memory; an error is a clause that says why there is none.
    fn allocate(
        &self,
        name: &str,
        requirements: vk::MemoryRequirements,
        place: MemoryPlace,
        linear: bool,
    ) -> std::result::Result<Allocation, String> {
        match self {
            Self::Ours(allocator) => locked(allocator)
                .allocate(&AllocationCreateDesc {
                    name,
                    requirements,
                    location: match place {
                        MemoryPlace::Device => MemoryLocation::GpuOnly,
                        MemoryPlace::Upload => MemoryLocation::CpuToGpu,
                        MemoryPlace::Readback => MemoryLocation::GpuToCpu,
                    },
                    linear,
                    allocation_scheme: AllocationScheme::GpuAllocatorManaged,
                })
                .map(Allocation::Ours)
                .map_err(|e| e.to_string()),
            Self::Callers(allocator) => {
                let block = locked(allocator).allocate(name, &requirements, place, linear)?;
                Ok(Allocation::Callers(block, requirements.size))
            }
        }
    }

    fn free(&self, allocation: Allocation) {
        match (self, allocation) {
            (Self::Ours(allocator), Allocation::Ours(allocation)) => {
                // A drop cannot return the error.
                if let Err(e) = locked(allocator).free(allocation) {
                    tracing::error!("device memory could not be freed: {e}");
                }
            }
            (Self::Callers(allocator), Allocation::Callers(block, _)) => locked(allocator).free(block),
            _ => unreachable!("a device has one source of memory"),
        }
    }
}

fn locked<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Allocation {
    pub fn memory(&self) -> vk::DeviceMemory {
        match self {
            // SAFETY: the memory is bound, and freed through this allocation alone.
            Self::Ours(allocation) => unsafe { allocation.memory() },
            Self::Callers(block, _) => block.memory,
        }
    }

    pub fn offset(&self) -> u64 {
        match self {
            Self::Ours(allocation) => allocation.offset(),
            Self::Callers(block, _) => block.offset,
        }
    }

    /// The memory as the host sees it; `None` if the memory is not mapped.
    fn bytes(&self) -> Option<&[u8]> {
        match self {
            Self::Ours(allocation) => allocation.mapped_slice(),
            Self::Callers(block, size) => {
                let size = *size as usize;
                // SAFETY: the block is mapped, this allocation's alone, and of that size (`DeviceMemory`).
                block.mapped.map(|pointer| unsafe { std::slice::from_raw_parts(pointer.as_ptr(), size) })
            }
        }
    }

    /// The memory for the host to write; `None` if the memory is not mapped.
    fn bytes_mut(&mut self) -> Option<&mut [u8]> {
        match self {
            Self::Ours(allocation) => allocation.mapped_slice_mut(),
            Self::Callers(block, size) => {
                let size = *size as usize;
                // SAFETY: the block is mapped, this allocation's alone, and of that size (`DeviceMemory`).
                block.mapped.map(|pointer| unsafe { std::slice::from_raw_parts_mut(pointer.as_ptr(), size) })
            }
        }
    }
}

impl Buffer {
    /// Makes a buffer of `size` bytes (at least 4).
    pub fn new(gpu: &Gpu, name: &str, size: u64, usage: vk::BufferUsageFlags, place: MemoryPlace) -> Result<Self> {
        let size = size.max(4);
        let info = vk::BufferCreateInfo::default().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the create info is complete; the handle is destroyed in `drop`.
        let handle =
            unsafe { gpu.raw().create_buffer(&info, None) }.map_err(vulkan(format!("vkCreateBuffer for {name}")))?;
        let mut buffer = Self {
            gpu: gpu.clone(),
            handle,
            allocation: None,
            size,
            state: TrackedState::default(),
            name: name.to_owned(),
        };
        gpu.name(handle, name);
        // SAFETY: the handle was just made.
        let requirements = unsafe { gpu.raw().get_buffer_memory_requirements(handle) };
        let allocation = allocate(gpu, name, requirements, place, true)?;
        // SAFETY: the memory fits the requirements and is freed after the buffer.
        let bound = unsafe { gpu.raw().bind_buffer_memory(handle, allocation.memory(), allocation.offset()) };
        // The buffer frees its memory even if the binding failed.
        buffer.allocation = Some(allocation);
        bound.map_err(vulkan(format!("vkBindBufferMemory for {name}")))?;
        Ok(buffer)
    }

    /// Makes a buffer in upload memory, with a copy of the given bytes.
    pub fn upload(gpu: &Gpu, name: &str, bytes: &[u8], usage: vk::BufferUsageFlags) -> Result<Self> {
        let mut buffer = Self::new(gpu, name, bytes.len() as u64, usage, MemoryPlace::Upload)?;
        buffer.bytes_mut()?[..bytes.len()].copy_from_slice(bytes);
        Ok(buffer)
    }

    /// Size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// The bytes of a readback buffer, for the host to read.
    pub fn bytes(&self) -> Result<&[u8]> {
        self.allocation
            .as_ref()
            .and_then(|allocation| allocation.bytes())
            .map(|bytes| &bytes[..self.size as usize])
            .ok_or_else(|| self.unmapped_error())
    }

    /// The bytes of an upload buffer, for the host to write.
    pub fn bytes_mut(&mut self) -> Result<&mut [u8]> {
        let (size, error) = (self.size as usize, self.unmapped_error());
        self.allocation.as_mut().and_then(|a| a.bytes_mut()).map(|s| &mut s[..size]).ok_or(error)
    }

    fn unmapped_error(&self) -> Error {
        Error::Memory { what: self.name.clone(), message: "the buffer is not visible to the host".into() }
    }

    /// Returns the device address of a buffer, for builds of ray structures; the buffer's usage must allow addresses.
    pub(super) fn address(&self) -> u64 {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.handle);
        // SAFETY: the buffer is alive, and where ray queries are on, the memory of all buffers is made for addresses.
        unsafe { self.gpu.raw().get_buffer_device_address(&info) }
    }

    /// The handle.
    pub fn handle(&self) -> vk::Buffer {
        self.handle
    }

    pub(crate) fn state(&self) -> &TrackedState {
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

/// A buffer that shaders read as texels of a format, which is faster on some devices than a storage block. A buffer
/// with more texels than the device can address is read as a storage block.
pub struct TexelBuffer {
    view: vk::BufferView,
    buffer: Buffer,
    is_whole: bool,
}

impl TexelBuffer {
    /// Takes over a buffer that was made with [`Self::USAGE`], and makes a view of its texels of `texel_bytes` bytes
    /// each. The view has all texels, or as many as the device can address.
    ///
    /// # Errors
    /// [`Error::Vulkan`] without memory.
    pub fn new(buffer: Buffer, format: vk::Format, texel_bytes: u64) -> Result<Self> {
        let limit = texel_bytes * u64::from(buffer.gpu.shared().limits.max_texel_buffer_elements);
        let bytes = buffer.size / texel_bytes * texel_bytes;
        let info = vk::BufferViewCreateInfo::default().buffer(buffer.handle).format(format).range(bytes.min(limit));
        // SAFETY: the buffer has the usage, by the contract of this function; the view is destroyed in `drop`.
        let view = unsafe { buffer.gpu.raw().create_buffer_view(&info, None) }
            .map_err(vulkan(format!("vkCreateBufferView for {}", buffer.name)))?;
        buffer.gpu.name(view, &buffer.name);
        Ok(Self { view, is_whole: bytes <= limit, buffer })
    }

    /// The usage that a buffer needs to become a texel buffer.
    pub const USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
        vk::BufferUsageFlags::STORAGE_TEXEL_BUFFER.as_raw() | vk::BufferUsageFlags::STORAGE_BUFFER.as_raw(),
    );

    /// Whether the view shows all texels, so that shaders can read them through the view.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// The buffer, to be read as a storage block.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    pub(super) fn view(&self) -> vk::BufferView {
        self.view
    }
}

impl Drop for TexelBuffer {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for before resources go (`FrameContext`).
        unsafe { self.buffer.gpu.raw().destroy_buffer_view(self.view, None) };
    }
}

/// Allocates memory for the image or the buffer `name`; `linear` is false for an image of optimal tiling.
pub(super) fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    place: MemoryPlace,
    linear: bool,
) -> Result<Allocation> {
    gpu.memory()
        .allocate(name, requirements, place, linear)
        .map_err(|message| Error::Memory { what: name.to_owned(), message })
}

/// Frees the memory of an image or a buffer that is destroyed, if it has any.
pub(super) fn release(gpu: &Gpu, allocation: Option<Allocation>) {
    if let Some(allocation) = allocation {
        gpu.memory().free(allocation);
    }
}
