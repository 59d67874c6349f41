//! The caller's allocator.

use crate::border::{Failure, Outcome, read_text, sized_structs, to_c_text};
use crate::vulkan::{VkDeviceMemory, VkMemoryRequirements};
use ash::vk;
use ssct::{DeviceMemory, MemoryBlock, MemoryPlace};
use std::ffi::{c_char, c_void};
use std::ptr::NonNull;

/// The kind of memory that a buffer or an image lives in: one of SSCT_MEMORY_PLACE_*.
pub type SsctMemoryPlace = u32;

/// Memory on the device.
pub const SSCT_MEMORY_PLACE_DEVICE: SsctMemoryPlace = 0;
/// Memory that the host writes and the device reads; mapped and coherent.
pub const SSCT_MEMORY_PLACE_UPLOAD: SsctMemoryPlace = 1;
/// Memory that the device writes and the host reads; mapped and coherent.
pub const SSCT_MEMORY_PLACE_READBACK: SsctMemoryPlace = 2;

/// A part of a memory object. No one else uses the part until the library releases it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctMemoryBlock {
    /// The memory object.
    pub memory: VkDeviceMemory,
    /// Where the part begins, in bytes.
    pub offset: u64,
    /// The address at which the host sees the part; NULL for SSCT_MEMORY_PLACE_DEVICE.
    pub mapped: *mut c_void,
    /// A number of your choice, which you get back with the block.
    pub key: u64,
}

/// An allocator of your own, in place of the library's. The threads that call the library call the allocator's
/// functions, but never two threads at once for one context.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctMemory {
    /// sizeof(SsctMemory).
    pub struct_size: usize,
    /// A pointer of your choice, which the library passes to both functions.
    pub user_data: *mut c_void,
    /// Writes to `block` a part of memory that fits the requirements, and returns NULL. If there is no such memory,
    /// returns a clause that says why; the text must stay until the next call. `name` is the name of the image or
    /// buffer. `linear` is false for images of optimal tiling.
    pub allocate: Option<
        unsafe extern "C" fn(
            user_data: *mut c_void,
            name: *const c_char,
            requirements: *const VkMemoryRequirements,
            place: SsctMemoryPlace,
            linear: bool,
            block: *mut SsctMemoryBlock,
        ) -> *const c_char,
    >,
    /// Takes back a block whose image or buffer is already destroyed.
    pub release: Option<unsafe extern "C" fn(user_data: *mut c_void, block: *const SsctMemoryBlock)>,
}

sized_structs!(SsctMemory);

type Allocate = unsafe extern "C" fn(
    *mut c_void,
    *const c_char,
    *const VkMemoryRequirements,
    SsctMemoryPlace,
    bool,
    *mut SsctMemoryBlock,
) -> *const c_char;

/// An [`SsctMemory`] with both of its functions.
pub struct CallersMemory {
    user_data: *mut c_void,
    allocate: Allocate,
    release: unsafe extern "C" fn(*mut c_void, *const SsctMemoryBlock),
}

impl CallersMemory {
    /// Copies the caller's allocator. Fails if one of its two functions is NULL.
    pub fn new(memory: &SsctMemory) -> Outcome<Self> {
        let missing = |field| Failure::usage(format!("the field {field} of SsctMemory is NULL"));
        Ok(Self {
            user_data: memory.user_data,
            allocate: memory.allocate.ok_or_else(|| missing("allocate"))?,
            release: memory.release.ok_or_else(|| missing("release"))?,
        })
    }
}

// SAFETY: the header says that any thread may call the two functions.
unsafe impl Send for CallersMemory {}

// SAFETY: the header asks of the caller's blocks what this trait asks of blocks.
unsafe impl DeviceMemory for CallersMemory {
    fn allocate(
        &mut self,
        name: &str,
        requirements: &vk::MemoryRequirements,
        place: MemoryPlace,
        linear: bool,
    ) -> Result<MemoryBlock, String> {
        let place = match place {
            MemoryPlace::Device => SSCT_MEMORY_PLACE_DEVICE,
            MemoryPlace::Upload => SSCT_MEMORY_PLACE_UPLOAD,
            MemoryPlace::Readback => SSCT_MEMORY_PLACE_READBACK,
        };
        let mut block =
            SsctMemoryBlock { memory: vk::DeviceMemory::null(), offset: 0, mapped: std::ptr::null_mut(), key: 0 };
        let name = to_c_text(name);
        // SAFETY: the caller gave the function for these arguments, which live through the call. The function returns
        // NULL or a text.
        let failure = unsafe {
            let why = (self.allocate)(self.user_data, name.as_ptr(), requirements, place, linear, &mut block);
            if why.is_null() {
                None
            } else {
                Some(read_text("allocate", why).unwrap_or("it does not say why").to_owned())
            }
        };
        if let Some(why) = failure {
            return Err(why);
        }
        let mapped = NonNull::new(block.mapped.cast::<u8>());
        if place != SSCT_MEMORY_PLACE_DEVICE && mapped.is_none() {
            // SAFETY: the block is the one that `allocate` gave.
            unsafe { (self.release)(self.user_data, &block) };
            return Err("SsctMemory.allocate left `mapped` NULL for memory that the host uses".into());
        }
        Ok(MemoryBlock { memory: block.memory, offset: block.offset, mapped, key: block.key })
    }

    fn free(&mut self, block: MemoryBlock) {
        let MemoryBlock { memory, offset, mapped, key } = block;
        let mapped = mapped.map_or(std::ptr::null_mut(), |pointer| pointer.as_ptr().cast());
        let block = SsctMemoryBlock { memory, offset, mapped, key };
        // SAFETY: the block is one that the caller gave.
        unsafe { (self.release)(self.user_data, &block) };
    }
}
