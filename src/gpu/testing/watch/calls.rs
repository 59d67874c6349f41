//! Functions that ask a [`Watch`] before they call the driver, and replace the driver's functions in a device's table.

use super::{Submission, Watch};
use ash::vk;
use ash::vk::Handle;
use std::ffi::c_void;
use std::sync::{Arc, PoisonError, RwLock};

/// A device that is watched: the raw handles of the device and its queue, the watch, and the driver's own functions.
struct WatchedDevice {
    device: u64,
    queue: u64,
    watch: Arc<Watch>,
    v1_0: ash::DeviceFnV1_0,
    v1_3: ash::DeviceFnV1_3,
}

/// The devices that are watched. The functions of this file are given only a handle, and find its device here.
static WATCHED: RwLock<Vec<Arc<WatchedDevice>>> = RwLock::new(Vec::new());

fn find_watched(matches: impl Fn(&WatchedDevice) -> bool) -> Option<Arc<WatchedDevice>> {
    let devices = WATCHED.read().unwrap_or_else(PoisonError::into_inner);
    devices.iter().find(|device| matches(device)).cloned()
}

fn watched_device(device: vk::Device) -> Option<Arc<WatchedDevice>> {
    find_watched(|watched| watched.device == device.as_raw())
}

/// Returns the device with its calls watched; `queue` is the queue that the device submits to.
pub fn watch_device(device: &ash::Device, queue: vk::Queue, watch: &Arc<Watch>) -> ash::Device {
    let (v1_0, v1_3) = (device.fp_v1_0().clone(), device.fp_v1_3().clone());
    let watched = WatchedDevice {
        device: device.handle().as_raw(),
        queue: queue.as_raw(),
        watch: Arc::clone(watch),
        v1_0: v1_0.clone(),
        v1_3: v1_3.clone(),
    };
    WATCHED.write().unwrap_or_else(PoisonError::into_inner).push(Arc::new(watched));
    let v1_0 = ash::DeviceFnV1_0 {
        destroy_device,
        device_wait_idle,
        allocate_memory,
        free_memory,
        map_memory,
        bind_buffer_memory,
        bind_image_memory,
        create_buffer,
        destroy_buffer,
        create_image,
        destroy_image,
        create_image_view,
        destroy_image_view,
        create_shader_module,
        destroy_shader_module,
        create_graphics_pipelines,
        create_compute_pipelines,
        destroy_pipeline,
        create_pipeline_layout,
        destroy_pipeline_layout,
        create_descriptor_set_layout,
        destroy_descriptor_set_layout,
        create_descriptor_pool,
        destroy_descriptor_pool,
        create_sampler,
        destroy_sampler,
        create_query_pool,
        destroy_query_pool,
        get_query_pool_results,
        create_command_pool,
        destroy_command_pool,
        allocate_command_buffers,
        create_fence,
        destroy_fence,
        wait_for_fences,
        create_semaphore,
        destroy_semaphore,
        ..v1_0
    };
    let v1_3 = ash::DeviceFnV1_3 { queue_submit2, ..v1_3 };
    let (v1_1, v1_2) = (device.fp_v1_1().clone(), device.fp_v1_2().clone());
    ash::Device::from_parts_1_3(device.handle(), v1_0, v1_1, v1_2, v1_3)
}

/// Declares a call that makes one object, and the call that destroys the object.
macro_rules! object {
    ($create:ident, $info:ty, $destroy:ident, $handle:ty, $kind:literal) => {
        unsafe extern "system" fn $create(
            device: vk::Device,
            info: *const $info,
            callbacks: *const vk::AllocationCallbacks<'_>,
            room: *mut $handle,
        ) -> vk::Result {
            let Some(watched) = watched_device(device) else { return vk::Result::ERROR_UNKNOWN };
            if let Err(result) = watched.watch.allocation() {
                return result;
            }
            // SAFETY: the caller's arguments go unchanged to the driver's own call.
            watched.watch.count_made($kind, 1, unsafe { (watched.v1_0.$create)(device, info, callbacks, room) })
        }

        unsafe extern "system" fn $destroy(
            device: vk::Device,
            handle: $handle,
            callbacks: *const vk::AllocationCallbacks<'_>,
        ) {
            let Some(watched) = watched_device(device) else { return };
            watched.watch.add_living($kind, -i64::from(!handle.is_null()));
            // SAFETY: the caller's arguments go unchanged to the driver's own call.
            unsafe { (watched.v1_0.$destroy)(device, handle, callbacks) };
        }
    };
}

object!(allocate_memory, vk::MemoryAllocateInfo<'_>, free_memory, vk::DeviceMemory, "device memory");
object!(create_buffer, vk::BufferCreateInfo<'_>, destroy_buffer, vk::Buffer, "buffers");
object!(create_image, vk::ImageCreateInfo<'_>, destroy_image, vk::Image, "images");
object!(create_image_view, vk::ImageViewCreateInfo<'_>, destroy_image_view, vk::ImageView, "image views");
object!(
    create_shader_module,
    vk::ShaderModuleCreateInfo<'_>,
    destroy_shader_module,
    vk::ShaderModule,
    "shader modules"
);
object!(
    create_pipeline_layout,
    vk::PipelineLayoutCreateInfo<'_>,
    destroy_pipeline_layout,
    vk::PipelineLayout,
    "pipeline layouts"
);
object!(
    create_descriptor_set_layout,
    vk::DescriptorSetLayoutCreateInfo<'_>,
    destroy_descriptor_set_layout,
    vk::DescriptorSetLayout,
    "descriptor set layouts"
);
object!(
    create_descriptor_pool,
    vk::DescriptorPoolCreateInfo<'_>,
    destroy_descriptor_pool,
    vk::DescriptorPool,
    "descriptor pools"
);
object!(create_sampler, vk::SamplerCreateInfo<'_>, destroy_sampler, vk::Sampler, "samplers");
object!(create_query_pool, vk::QueryPoolCreateInfo<'_>, destroy_query_pool, vk::QueryPool, "query pools");
object!(create_command_pool, vk::CommandPoolCreateInfo<'_>, destroy_command_pool, vk::CommandPool, "command pools");
object!(create_fence, vk::FenceCreateInfo<'_>, destroy_fence, vk::Fence, "fences");
object!(create_semaphore, vk::SemaphoreCreateInfo<'_>, destroy_semaphore, vk::Semaphore, "semaphores");

/// Declares a call that makes some pipelines.
macro_rules! pipelines {
    ($create:ident, $info:ty) => {
        unsafe extern "system" fn $create(
            device: vk::Device,
            cache: vk::PipelineCache,
            count: u32,
            infos: *const $info,
            callbacks: *const vk::AllocationCallbacks<'_>,
            handles: *mut vk::Pipeline,
        ) -> vk::Result {
            let Some(watched) = watched_device(device) else { return vk::Result::ERROR_UNKNOWN };
            if let Err(result) = watched.watch.allocation() {
                // SAFETY: the caller gives room for `count` handles; a pipeline that failed is null.
                unsafe { std::slice::from_raw_parts_mut(handles, count as usize) }.fill(vk::Pipeline::null());
                return result;
            }
            // SAFETY: the caller's arguments go unchanged to the driver's own call.
            let result = unsafe { (watched.v1_0.$create)(device, cache, count, infos, callbacks, handles) };
            watched.watch.count_made("pipelines", count, result)
        }
    };
}

pipelines!(create_graphics_pipelines, vk::GraphicsPipelineCreateInfo<'_>);
pipelines!(create_compute_pipelines, vk::ComputePipelineCreateInfo<'_>);

unsafe extern "system" fn destroy_pipeline(
    device: vk::Device,
    handle: vk::Pipeline,
    callbacks: *const vk::AllocationCallbacks<'_>,
) {
    let Some(watched) = watched_device(device) else { return };
    watched.watch.add_living("pipelines", -i64::from(!handle.is_null()));
    // SAFETY: the caller's arguments go unchanged to the driver's own call.
    unsafe { (watched.v1_0.destroy_pipeline)(device, handle, callbacks) };
}

/// Declares a call that counts as an allocation but makes no object that is counted.
macro_rules! allocation {
    ($call:ident, $($argument:ident: $type:ty),*) => {
        unsafe extern "system" fn $call(device: vk::Device, $($argument: $type),*) -> vk::Result {
            let Some(watched) = watched_device(device) else { return vk::Result::ERROR_UNKNOWN };
            if let Err(result) = watched.watch.allocation() {
                return result;
            }
            // SAFETY: the caller's arguments go unchanged to the driver's own call.
            unsafe { (watched.v1_0.$call)(device, $($argument),*) }
        }
    };
}

allocation!(bind_buffer_memory, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: vk::DeviceSize);
allocation!(bind_image_memory, image: vk::Image, memory: vk::DeviceMemory, offset: vk::DeviceSize);
allocation!(
    map_memory,
    memory: vk::DeviceMemory,
    offset: vk::DeviceSize,
    size: vk::DeviceSize,
    flags: vk::MemoryMapFlags,
    data: *mut *mut c_void
);
allocation!(
    allocate_command_buffers,
    info: *const vk::CommandBufferAllocateInfo<'_>,
    buffers: *mut vk::CommandBuffer
);

/// Submits to the driver, or returns that the device is lost.
unsafe extern "system" fn queue_submit2(
    queue: vk::Queue,
    count: u32,
    submits: *const vk::SubmitInfo2<'_>,
    fence: vk::Fence,
) -> vk::Result {
    let found = find_watched(|watched| watched.queue == queue.as_raw());
    let Some(watched) = found else { return vk::Result::ERROR_UNKNOWN };
    match watched.watch.submission() {
        // SAFETY: the caller's arguments go unchanged to the driver's own call.
        Submission::Works => unsafe { (watched.v1_3.queue_submit2)(queue, count, submits, fence) },
        _ => vk::Result::ERROR_DEVICE_LOST,
    }
}

/// Waits in the driver, unless the device is lost already. A wait that is to fail returns that the device is lost.
unsafe extern "system" fn wait_for_fences(
    device: vk::Device,
    count: u32,
    fences: *const vk::Fence,
    wait_all: vk::Bool32,
    timeout: u64,
) -> vk::Result {
    let Some(watched) = watched_device(device) else { return vk::Result::ERROR_UNKNOWN };
    let submission = watched.watch.submission();
    if submission == Submission::Lost {
        // Nothing was submitted since the device was lost, so that a wait would not end.
        return vk::Result::ERROR_DEVICE_LOST;
    }
    // SAFETY: the caller's arguments go unchanged to the driver's own call.
    let result = unsafe { (watched.v1_0.wait_for_fences)(device, count, fences, wait_all, timeout) };
    if submission == Submission::Works { result } else { vk::Result::ERROR_DEVICE_LOST }
}

/// Fetches results from the driver, or returns that the device is lost.
unsafe extern "system" fn get_query_pool_results(
    device: vk::Device,
    pool: vk::QueryPool,
    first: u32,
    count: u32,
    size: usize,
    data: *mut c_void,
    stride: vk::DeviceSize,
    flags: vk::QueryResultFlags,
) -> vk::Result {
    let Some(watched) = watched_device(device) else { return vk::Result::ERROR_UNKNOWN };
    match watched.watch.submission() {
        // SAFETY: the caller's arguments go unchanged to the driver's own call.
        Submission::Works => unsafe {
            (watched.v1_0.get_query_pool_results)(device, pool, first, count, size, data, stride, flags)
        },
        _ => vk::Result::ERROR_DEVICE_LOST,
    }
}

/// Waits in the driver, even if the device is lost, and returns whether it is.
unsafe extern "system" fn device_wait_idle(device: vk::Device) -> vk::Result {
    let Some(watched) = watched_device(device) else { return vk::Result::ERROR_UNKNOWN };
    // SAFETY: the caller's argument goes unchanged to the driver's own call.
    let result = unsafe { (watched.v1_0.device_wait_idle)(device) };
    if watched.watch.lost.load(std::sync::atomic::Ordering::SeqCst) { vk::Result::ERROR_DEVICE_LOST } else { result }
}

unsafe extern "system" fn destroy_device(device: vk::Device, callbacks: *const vk::AllocationCallbacks<'_>) {
    let Some(watched) = watched_device(device) else { return };
    // Removed before the call, because the driver may give the handle to the next device.
    WATCHED.write().unwrap_or_else(PoisonError::into_inner).retain(|other| other.device != device.as_raw());
    // SAFETY: the caller's arguments go unchanged to the driver's own call.
    unsafe { (watched.v1_0.destroy_device)(device, callbacks) };
}
