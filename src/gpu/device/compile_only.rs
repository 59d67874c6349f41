//! A device that compiles pipelines and does nothing else, for the statistics of compilers (`gpu/executables.rs`).
//!
//! A driver may offer a device whose hardware is absent: Mesa's RADV does if `RADV_FORCE_FAMILY` names a family. Such a
//! device has no memory and takes no work. This file therefore replaces every function that makes, fills or submits
//! something else than shader modules, layouts, samplers and pipelines, so that the driver never sees these calls. The
//! usual code can then record a frame, and the device compiles what the frame needs. Uploads go to memory of the host,
//! and read-backs give zeros.

use crate::gpu::memory::{DeviceMemory, MemoryBlock, MemoryPlace};
use ash::vk::{self, Handle};
use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::NonNull;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// The loader's own `vkGetDeviceProcAddr`, for all functions that this file does not replace.
static LOADER: OnceLock<vk::PFN_vkGetDeviceProcAddr> = OnceLock::new();

/// Wraps an instance, so that its devices compile pipelines and do nothing else.
pub fn instance(instance: &ash::Instance) -> ash::Instance {
    let v1_0 = instance.fp_v1_0().clone();
    LOADER.get_or_init(|| v1_0.get_device_proc_addr);
    let v1_0 = ash::InstanceFnV1_0 { get_device_proc_addr, ..v1_0 };
    ash::Instance::from_parts_1_3(instance.handle(), v1_0, instance.fp_v1_1().clone(), instance.fp_v1_3().clone())
}

/// Finds the function of this file that replaces the driver's function `name`, or else the driver's function.
unsafe extern "system" fn get_device_proc_addr(device: vk::Device, name: *const c_char) -> vk::PFN_vkVoidFunction {
    // SAFETY: the caller gives a name that ends with zero.
    let replaced = replacement(unsafe { CStr::from_ptr(name) });
    // SAFETY: the caller's arguments go unchanged to the loader's own call.
    replaced.or_else(|| LOADER.get().and_then(|loader| unsafe { loader(device, name) }))
}

/// Makes up a new handle, which stands for no object of the driver.
fn handle<H: Handle>() -> H {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    H::from_raw(NEXT.fetch_add(1, Ordering::Relaxed))
}

/// Declares the functions that replace the driver's, and their look-up by name. The list `made` has pairs that make and drop
/// handles, `succeeds` calls that return success, `ignored` commands that do nothing, and `written` functions of this file.
macro_rules! replacements {
    (
        made { $( $create:ident $create_name:literal $Info:ty, $destroy:ident $destroy_name:literal $Handle:ty; )* }
        succeeds { $( $call:ident $call_name:literal ($($argument:ty),*) as $Call:ty; )* }
        ignored { $( $command:ident $command_name:literal ($($value:ty),*) as $Command:ty; )* }
        written { $( $function:ident $function_name:literal as $Function:ty; )* }
    ) => {
        $(
            unsafe extern "system" fn $create(
                _: vk::Device,
                _: *const $Info,
                _: *const vk::AllocationCallbacks<'_>,
                room: *mut $Handle,
            ) -> vk::Result {
                // SAFETY: the caller gives room for a handle.
                unsafe { room.write(handle()) };
                vk::Result::SUCCESS
            }

            unsafe extern "system" fn $destroy(_: vk::Device, _: $Handle, _: *const vk::AllocationCallbacks<'_>) {}
        )*
        $( unsafe extern "system" fn $call($(_: $argument),*) -> vk::Result { vk::Result::SUCCESS } )*
        $( unsafe extern "system" fn $command($(_: $value),*) {} )*

        /// Finds the function of this file that replaces the driver's function `name`.
        fn replacement(name: &CStr) -> vk::PFN_vkVoidFunction {
            type Void = unsafe extern "system" fn();
            let found: Void = match name.to_bytes() {
                $(
                    $create_name => {
                        type Create = unsafe extern "system" fn(
                            vk::Device,
                            *const $Info,
                            *const vk::AllocationCallbacks<'_>,
                            *mut $Handle,
                        ) -> vk::Result;
                        // SAFETY: a function that was looked up by name has no type until the caller casts it.
                        unsafe { std::mem::transmute::<Create, Void>($create) }
                    }
                    $destroy_name => {
                        type Destroy =
                            unsafe extern "system" fn(vk::Device, $Handle, *const vk::AllocationCallbacks<'_>);
                        // SAFETY: the caller casts the function back to its type.
                        unsafe { std::mem::transmute::<Destroy, Void>($destroy) }
                    }
                )*
                // SAFETY: the caller casts each function back to its type.
                $( $call_name => unsafe { std::mem::transmute::<$Call, Void>($call) }, )*
                // SAFETY: the caller casts each function back to its type.
                $( $command_name => unsafe { std::mem::transmute::<$Command, Void>($command) }, )*
                // SAFETY: the caller casts each function back to its type.
                $( $function_name => unsafe { std::mem::transmute::<$Function, Void>($function) }, )*
                _ => return None,
            };
            Some(found)
        }
    };
}

type Commands = vk::CommandBuffer;

replacements! {
    made {
        create_image b"vkCreateImage" vk::ImageCreateInfo<'_>, destroy_image b"vkDestroyImage" vk::Image;
        create_image_view b"vkCreateImageView" vk::ImageViewCreateInfo<'_>,
            destroy_image_view b"vkDestroyImageView" vk::ImageView;
        create_buffer_view b"vkCreateBufferView" vk::BufferViewCreateInfo<'_>,
            destroy_buffer_view b"vkDestroyBufferView" vk::BufferView;
        create_descriptor_pool b"vkCreateDescriptorPool" vk::DescriptorPoolCreateInfo<'_>,
            destroy_descriptor_pool b"vkDestroyDescriptorPool" vk::DescriptorPool;
        create_query_pool b"vkCreateQueryPool" vk::QueryPoolCreateInfo<'_>,
            destroy_query_pool b"vkDestroyQueryPool" vk::QueryPool;
        create_command_pool b"vkCreateCommandPool" vk::CommandPoolCreateInfo<'_>,
            destroy_command_pool b"vkDestroyCommandPool" vk::CommandPool;
        create_fence b"vkCreateFence" vk::FenceCreateInfo<'_>, destroy_fence b"vkDestroyFence" vk::Fence;
        create_acceleration_structure b"vkCreateAccelerationStructureKHR" vk::AccelerationStructureCreateInfoKHR<'_>,
            destroy_acceleration_structure b"vkDestroyAccelerationStructureKHR" vk::AccelerationStructureKHR;
    }
    succeeds {
        device_wait_idle b"vkDeviceWaitIdle" (vk::Device) as vk::PFN_vkDeviceWaitIdle;
        bind_buffer_memory b"vkBindBufferMemory" (vk::Device, vk::Buffer, vk::DeviceMemory, vk::DeviceSize)
            as vk::PFN_vkBindBufferMemory;
        bind_image_memory b"vkBindImageMemory" (vk::Device, vk::Image, vk::DeviceMemory, vk::DeviceSize)
            as vk::PFN_vkBindImageMemory;
        reset_command_pool b"vkResetCommandPool" (vk::Device, vk::CommandPool, vk::CommandPoolResetFlags)
            as vk::PFN_vkResetCommandPool;
        begin_command_buffer b"vkBeginCommandBuffer" (Commands, *const vk::CommandBufferBeginInfo<'_>)
            as vk::PFN_vkBeginCommandBuffer;
        end_command_buffer b"vkEndCommandBuffer" (Commands) as vk::PFN_vkEndCommandBuffer;
        reset_descriptor_pool b"vkResetDescriptorPool" (vk::Device, vk::DescriptorPool, vk::DescriptorPoolResetFlags)
            as vk::PFN_vkResetDescriptorPool;
        reset_fences b"vkResetFences" (vk::Device, u32, *const vk::Fence) as vk::PFN_vkResetFences;
        wait_for_fences b"vkWaitForFences" (vk::Device, u32, *const vk::Fence, vk::Bool32, u64)
            as vk::PFN_vkWaitForFences;
        queue_submit2 b"vkQueueSubmit2" (vk::Queue, u32, *const vk::SubmitInfo2<'_>, vk::Fence)
            as vk::PFN_vkQueueSubmit2;
    }
    ignored {
        reset_query_pool b"vkResetQueryPool" (vk::Device, vk::QueryPool, u32, u32) as vk::PFN_vkResetQueryPool;
        update_descriptor_sets b"vkUpdateDescriptorSets"
            (vk::Device, u32, *const vk::WriteDescriptorSet<'_>, u32, *const vk::CopyDescriptorSet<'_>)
            as vk::PFN_vkUpdateDescriptorSets;
        cmd_pipeline_barrier2 b"vkCmdPipelineBarrier2" (Commands, *const vk::DependencyInfo<'_>)
            as vk::PFN_vkCmdPipelineBarrier2;
        cmd_write_timestamp2 b"vkCmdWriteTimestamp2" (Commands, vk::PipelineStageFlags2, vk::QueryPool, u32)
            as vk::PFN_vkCmdWriteTimestamp2;
        cmd_begin_query b"vkCmdBeginQuery" (Commands, vk::QueryPool, u32, vk::QueryControlFlags)
            as vk::PFN_vkCmdBeginQuery;
        cmd_end_query b"vkCmdEndQuery" (Commands, vk::QueryPool, u32) as vk::PFN_vkCmdEndQuery;
        cmd_begin_rendering b"vkCmdBeginRendering" (Commands, *const vk::RenderingInfo<'_>)
            as vk::PFN_vkCmdBeginRendering;
        cmd_end_rendering b"vkCmdEndRendering" (Commands) as vk::PFN_vkCmdEndRendering;
        cmd_set_viewport b"vkCmdSetViewport" (Commands, u32, u32, *const vk::Viewport) as vk::PFN_vkCmdSetViewport;
        cmd_set_scissor b"vkCmdSetScissor" (Commands, u32, u32, *const vk::Rect2D) as vk::PFN_vkCmdSetScissor;
        cmd_bind_pipeline b"vkCmdBindPipeline" (Commands, vk::PipelineBindPoint, vk::Pipeline)
            as vk::PFN_vkCmdBindPipeline;
        cmd_bind_descriptor_sets b"vkCmdBindDescriptorSets"
            (Commands, vk::PipelineBindPoint, vk::PipelineLayout, u32, u32, *const vk::DescriptorSet, u32, *const u32)
            as vk::PFN_vkCmdBindDescriptorSets;
        cmd_bind_vertex_buffers b"vkCmdBindVertexBuffers"
            (Commands, u32, u32, *const vk::Buffer, *const vk::DeviceSize) as vk::PFN_vkCmdBindVertexBuffers;
        cmd_bind_index_buffer b"vkCmdBindIndexBuffer" (Commands, vk::Buffer, vk::DeviceSize, vk::IndexType)
            as vk::PFN_vkCmdBindIndexBuffer;
        cmd_push_constants b"vkCmdPushConstants"
            (Commands, vk::PipelineLayout, vk::ShaderStageFlags, u32, u32, *const c_void)
            as vk::PFN_vkCmdPushConstants;
        cmd_draw b"vkCmdDraw" (Commands, u32, u32, u32, u32) as vk::PFN_vkCmdDraw;
        cmd_draw_indexed b"vkCmdDrawIndexed" (Commands, u32, u32, u32, i32, u32) as vk::PFN_vkCmdDrawIndexed;
        cmd_draw_indirect b"vkCmdDrawIndirect" (Commands, vk::Buffer, vk::DeviceSize, u32, u32)
            as vk::PFN_vkCmdDrawIndirect;
        cmd_dispatch b"vkCmdDispatch" (Commands, u32, u32, u32) as vk::PFN_vkCmdDispatch;
        cmd_dispatch_indirect b"vkCmdDispatchIndirect" (Commands, vk::Buffer, vk::DeviceSize)
            as vk::PFN_vkCmdDispatchIndirect;
        cmd_copy_buffer b"vkCmdCopyBuffer" (Commands, vk::Buffer, vk::Buffer, u32, *const vk::BufferCopy)
            as vk::PFN_vkCmdCopyBuffer;
        cmd_copy_buffer_to_image b"vkCmdCopyBufferToImage"
            (Commands, vk::Buffer, vk::Image, vk::ImageLayout, u32, *const vk::BufferImageCopy)
            as vk::PFN_vkCmdCopyBufferToImage;
        cmd_copy_image_to_buffer b"vkCmdCopyImageToBuffer"
            (Commands, vk::Image, vk::ImageLayout, vk::Buffer, u32, *const vk::BufferImageCopy)
            as vk::PFN_vkCmdCopyImageToBuffer;
        cmd_copy_image2 b"vkCmdCopyImage2" (Commands, *const vk::CopyImageInfo2<'_>) as vk::PFN_vkCmdCopyImage2;
        cmd_blit_image2 b"vkCmdBlitImage2" (Commands, *const vk::BlitImageInfo2<'_>) as vk::PFN_vkCmdBlitImage2;
        cmd_fill_buffer b"vkCmdFillBuffer" (Commands, vk::Buffer, vk::DeviceSize, vk::DeviceSize, u32)
            as vk::PFN_vkCmdFillBuffer;
        cmd_clear_color_image b"vkCmdClearColorImage"
            (Commands, vk::Image, vk::ImageLayout, *const vk::ClearColorValue, u32, *const vk::ImageSubresourceRange)
            as vk::PFN_vkCmdClearColorImage;
        cmd_build_acceleration_structures b"vkCmdBuildAccelerationStructuresKHR"
            (
                Commands,
                u32,
                *const vk::AccelerationStructureBuildGeometryInfoKHR<'_>,
                *const *const vk::AccelerationStructureBuildRangeInfoKHR
            ) as vk::PFN_vkCmdBuildAccelerationStructuresKHR;
    }
    written {
        create_buffer b"vkCreateBuffer" as vk::PFN_vkCreateBuffer;
        destroy_buffer b"vkDestroyBuffer" as vk::PFN_vkDestroyBuffer;
        get_buffer_memory_requirements b"vkGetBufferMemoryRequirements" as vk::PFN_vkGetBufferMemoryRequirements;
        get_image_memory_requirements b"vkGetImageMemoryRequirements" as vk::PFN_vkGetImageMemoryRequirements;
        allocate_command_buffers b"vkAllocateCommandBuffers" as vk::PFN_vkAllocateCommandBuffers;
        allocate_descriptor_sets b"vkAllocateDescriptorSets" as vk::PFN_vkAllocateDescriptorSets;
        get_query_pool_results b"vkGetQueryPoolResults" as vk::PFN_vkGetQueryPoolResults;
        get_buffer_device_address b"vkGetBufferDeviceAddress" as vk::PFN_vkGetBufferDeviceAddress;
        get_acceleration_structure_device_address b"vkGetAccelerationStructureDeviceAddressKHR"
            as vk::PFN_vkGetAccelerationStructureDeviceAddressKHR;
        get_acceleration_structure_build_sizes b"vkGetAccelerationStructureBuildSizesKHR"
            as vk::PFN_vkGetAccelerationStructureBuildSizesKHR;
    }
}

/// Makes a buffer's handle, which points to the buffer's size in bytes.
unsafe extern "system" fn create_buffer(
    _: vk::Device,
    info: *const vk::BufferCreateInfo<'_>,
    _: *const vk::AllocationCallbacks<'_>,
    room: *mut vk::Buffer,
) -> vk::Result {
    // SAFETY: the caller gives a complete create info, and room for a handle.
    unsafe { room.write(vk::Buffer::from_raw(Box::into_raw(Box::new((*info).size)) as u64)) };
    vk::Result::SUCCESS
}

/// Frees the size to which the handle of a buffer points.
unsafe extern "system" fn destroy_buffer(_: vk::Device, buffer: vk::Buffer, _: *const vk::AllocationCallbacks<'_>) {
    if !buffer.is_null() {
        // SAFETY: the handle is that of `create_buffer`, and is destroyed once.
        drop(unsafe { Box::from_raw(buffer.as_raw() as *mut vk::DeviceSize) });
    }
}

/// Returns memory requirements for an object of a size in bytes, which [`HostMemory`] can meet.
fn requirements(size: vk::DeviceSize) -> vk::MemoryRequirements {
    vk::MemoryRequirements { size, alignment: 16, memory_type_bits: 1 }
}

/// Reads the size of a buffer from its handle.
unsafe extern "system" fn get_buffer_memory_requirements(
    _: vk::Device,
    buffer: vk::Buffer,
    room: *mut vk::MemoryRequirements,
) {
    // SAFETY: the handle is that of a living buffer of `create_buffer`; the caller gives room for the answer.
    unsafe { room.write(requirements(*(buffer.as_raw() as *const vk::DeviceSize))) };
}

/// Writes the same requirements for every image. Any size serves, since the host never maps an image's memory.
unsafe extern "system" fn get_image_memory_requirements(
    _: vk::Device,
    _: vk::Image,
    room: *mut vk::MemoryRequirements,
) {
    // SAFETY: the caller gives room for the answer.
    unsafe { room.write(requirements(16)) };
}

/// Makes up a handle for each command buffer.
unsafe extern "system" fn allocate_command_buffers(
    _: vk::Device,
    info: *const vk::CommandBufferAllocateInfo<'_>,
    room: *mut vk::CommandBuffer,
) -> vk::Result {
    // SAFETY: the caller gives room for as many handles as its info counts.
    unsafe { (0..(*info).command_buffer_count as usize).for_each(|n| room.add(n).write(handle())) };
    vk::Result::SUCCESS
}

/// Makes up a handle for each descriptor set.
unsafe extern "system" fn allocate_descriptor_sets(
    _: vk::Device,
    info: *const vk::DescriptorSetAllocateInfo<'_>,
    room: *mut vk::DescriptorSet,
) -> vk::Result {
    // SAFETY: the caller gives room for as many handles as its info counts.
    unsafe { (0..(*info).descriptor_set_count as usize).for_each(|n| room.add(n).write(handle())) };
    vk::Result::SUCCESS
}

/// Writes zeros as the results of all queries.
unsafe extern "system" fn get_query_pool_results(
    _: vk::Device,
    _: vk::QueryPool,
    _: u32,
    _: u32,
    size: usize,
    data: *mut c_void,
    _: vk::DeviceSize,
    _: vk::QueryResultFlags,
) -> vk::Result {
    // SAFETY: the caller gives room for `size` bytes.
    unsafe { data.cast::<u8>().write_bytes(0, size) };
    vk::Result::SUCCESS
}

/// The address of every buffer and acceleration structure: a multiple of every alignment, which is never read.
const ADDRESS: vk::DeviceAddress = 1 << 32;

unsafe extern "system" fn get_buffer_device_address(
    _: vk::Device,
    _: *const vk::BufferDeviceAddressInfo<'_>,
) -> vk::DeviceAddress {
    ADDRESS
}

unsafe extern "system" fn get_acceleration_structure_device_address(
    _: vk::Device,
    _: *const vk::AccelerationStructureDeviceAddressInfoKHR<'_>,
) -> vk::DeviceAddress {
    ADDRESS
}

unsafe extern "system" fn get_acceleration_structure_build_sizes(
    _: vk::Device,
    _: vk::AccelerationStructureBuildTypeKHR,
    _: *const vk::AccelerationStructureBuildGeometryInfoKHR<'_>,
    _: *const u32,
    sizes: *mut vk::AccelerationStructureBuildSizesInfoKHR<'_>,
) {
    // SAFETY: the caller gives a structure for the answer.
    unsafe {
        (*sizes).acceleration_structure_size = 256;
        (*sizes).build_scratch_size = 256; // Any sizes serve, since nothing is built.
    }
}

/// Allocates host memory for buffers that the host writes or reads, and no memory for anything else.
#[derive(Default)]
pub struct HostMemory {
    /// Blocks by key. Blocks have words of 16 bytes, so that a block is aligned for any value.
    blocks: HashMap<u64, Box<[u128]>>,
    /// The key of the block that was made last; keys count from 1.
    last_key: u64,
}

// SAFETY: a block is as large as is asked for, has no second owner until it is freed, and is mapped if the host writes
// or reads it.
unsafe impl DeviceMemory for HostMemory {
    fn allocate(
        &mut self,
        _: &str,
        requirements: &vk::MemoryRequirements,
        place: MemoryPlace,
        _: bool,
    ) -> Result<MemoryBlock, String> {
        self.last_key += 1;
        let (key, memory) = (self.last_key, vk::DeviceMemory::from_raw(self.last_key));
        if place == MemoryPlace::Device {
            return Ok(MemoryBlock { memory, offset: 0, mapped: None, key });
        }
        let words = usize::try_from(requirements.size.div_ceil(16)).map_err(|e| e.to_string())?;
        let mut block = vec![0_u128; words].into_boxed_slice();
        let mapped = NonNull::new(block.as_mut_ptr().cast::<u8>());
        self.blocks.insert(key, block);
        Ok(MemoryBlock { memory, offset: 0, mapped, key })
    }

    fn free(&mut self, block: MemoryBlock) {
        self.blocks.remove(&block.key);
    }
}
