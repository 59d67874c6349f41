//! The handle of a device, and the state that clones of the handle share.

mod compile_only;
mod features;
mod no_driver;
mod open;
mod ray_queries;

use super::executables::Executables;
use super::image::Loan;
use super::memory::{DeviceMemory, MemorySource};
use super::pipelines::Pipelines;
use super::sampler::{Sampler, Samplers};
use super::testing::watch::Watch;
use super::validation::{self, ValidationLog};
use crate::error::{Error, Result};
use ash::vk;
pub use features::enable_features;
pub use open::memory_limit;
use open::{create_instance, list_devices, open_device};
pub(super) use ray_queries::RayQueries;
use std::ffi::{CStr, CString};
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};
use std::time::Duration;

/// Which device to open, and how.
#[derive(Debug, Clone, Default)]
pub struct DeviceQuery {
    /// Index in the list of `ssct devices`, or part of a name; `None` for that of `SSCT_DEVICE`, or the best by type.
    pub device: Option<String>,
    /// Whether to load the validation layers (core, synchronization, best practices).
    pub validation: bool,
    /// Whether the layers also instrument the shaders (GPU-assisted validation). This flag needs `validation`.
    pub gpu_assisted: bool,
    /// Whether material maps are sampled without anisotropy. Drivers place the samples of an anisotropic filter differently, so that
    /// their images differ less without such a filter.
    pub isotropic: bool,
    /// Counts what lives on the device and makes calls fail, for tests.
    pub watch: Option<Arc<Watch>>,
    /// Whether the device only compiles pipelines. It then has no memory and runs no work, images that are read back
    /// are zero, and [`Gpu::take_programs`] returns the compiled code. Such a device needs no hardware.
    pub compiles_only: bool,
    /// Instance extensions that a window needs.
    pub instance_extensions: Vec<&'static CStr>,
}

/// Name, driver, Vulkan version and type of a device.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize, PartialEq)]
pub struct DeviceInfo {
    /// Marketing name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// Highest Vulkan version, such as "1.3.230".
    pub api: String,
    /// "discrete GPU", "integrated GPU", "virtual GPU", "CPU" or "other".
    #[serde(rename = "type")]
    pub kind: String,
}

impl DeviceInfo {
    /// Whether the device is a driver that computes on the CPU.
    pub fn is_cpu(&self) -> bool {
        self.kind == "CPU"
    }
}

/// Precision of a device's rasteriser and filters: the fractional bits of their fixed-point numbers, as the device states them.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize, PartialEq, Eq)]
pub struct Precision {
    /// Bits of a vertex's position within a pixel.
    pub sub_pixel_bits: u32,
    /// Bits of a sample's place between two texels.
    pub sub_texel_bits: u32,
    /// Bits of a sample's place between two levels.
    pub mipmap_bits: u32,
}

/// One line of `ssct devices`.
#[derive(Debug, Clone, serde::Serialize)]
pub struct DeviceListing {
    /// Index of the device, by which [`DeviceQuery::device`] names it.
    pub index: usize,
    /// The device.
    #[serde(flatten)]
    pub info: DeviceInfo,
    /// Reason why the device can't be used; `None` if it can.
    pub unsuitable: Option<String>,
}

/// The features that were on when a device was made.
#[derive(Clone, Default)]
pub struct EnabledFeatures {
    /// Features of Vulkan 1.0.
    pub core: vk::PhysicalDeviceFeatures,
    /// Features of Vulkan 1.2; structures that are chained to it are ignored.
    pub vulkan12: vk::PhysicalDeviceVulkan12Features<'static>,
    /// Features of Vulkan 1.3; structures that are chained to it are ignored.
    pub vulkan13: vk::PhysicalDeviceVulkan13Features<'static>,
}

/// The handles of a device that the caller made.
pub struct DeviceHandles {
    /// The loader.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// The family of the queues that command buffers are submitted to.
    pub queue_family: u32,
    /// Features that were on when the device was made.
    pub enabled: EnabledFeatures,
    /// Whether the instance has VK_EXT_debug_utils on, which gives passes and objects names.
    pub debug_utils: bool,
    /// The caller's allocator; `None` for the crate's own.
    pub memory: Option<Box<dyn DeviceMemory>>,
}

/// A handle to an open device. Clones share the device, and the last clone destroys it.
#[derive(Clone)]
pub struct Gpu {
    shared: Arc<Shared>,
    /// The pool that this handle takes its images from; `None` for a handle that makes every image anew.
    pub(super) loan: Option<Loan>,
}

/// The state that all handles of a device share; its fields stand in the order in which they are made.
pub struct Shared {
    /// The loader.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    debug: Option<Debug>,
    /// The physical device.
    pub physical: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    debug_device: Option<ash::ext::debug_utils::Device>,
    /// The family of the queue.
    pub queue_family: u32,
    /// The queue that frames are submitted to; `None` on a caller's device, where the caller submits.
    queue: Option<Mutex<vk::Queue>>,
    samplers: Samplers,
    pub(crate) pipelines: Pipelines,
    memory: ManuallyDrop<MemorySource>,
    /// Whether the last handle destroys the instance and the device; false if they are the caller's.
    owned: bool,
    submissions: AtomicU64,
    /// The longest time that a frame may take, and the function to call if one takes longer.
    pub(crate) frame_timeout: OnceLock<FrameTimeout>,
    /// New code for shaders that changed while the program runs.
    #[cfg(feature = "reload")]
    pub replaced_shaders: super::shader::ReplacedShaders,
    info: DeviceInfo,
    /// The device's place in the loader's list; `None` for a caller's device.
    index: Option<usize>,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) timestamp_mask: u64,
    pub(crate) has_pipeline_statistics: bool,
    /// Pixels along a side of the largest point that the device draws.
    pub(crate) largest_point: f32,
    pub(crate) numbers_triangles: bool,
    /// The functions that ask about compiled pipelines, on a device that compiles only.
    pub(super) executables: Option<Executables>,
    /// Ray queries, or a sentence that says why there are none.
    ray_queries: std::result::Result<RayQueries, String>,
}

/// The longest time that a frame may take, and a function that is called with a sentence if one takes longer.
pub(crate) type FrameTimeout = (Duration, fn(&str));

/// The functions of VK_EXT_debug_utils, and the messenger that writes messages of the layers into the log.
struct Debug {
    loader: ash::ext::debug_utils::Instance,
    messenger: Option<vk::DebugUtilsMessengerEXT>,
    log: Arc<ValidationLog>,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Gpu({})", self.shared.info.name)
    }
}

/// Returns a function that turns the result of a failed call into an error with the call's name.
pub fn vulkan(what: impl Into<String>) -> impl FnOnce(vk::Result) -> Error {
    move |result| Error::Vulkan { what: what.into(), result }
}

/// Converts a text that Vulkan returned. A text without a zero byte at its end becomes empty.
pub(super) fn text(returned: std::result::Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    returned.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Lists every device that the loader sees, suitable or not.
pub fn devices() -> Result<Vec<DeviceListing>> {
    let (_loader, instance, _) = create_instance(&DeviceQuery::default(), &ValidationLog::default())?;
    let listing = list_devices(&instance, false);
    // SAFETY: nothing was created from the instance.
    unsafe { instance.destroy_instance(None) };
    Ok(listing?.into_iter().map(|(_, listing)| listing).collect())
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// [`Error::NoDevice`] without a loader or suitable device, [`Error::Usage`] for a device that
    /// does not exist or validation layers that are not installed.
    pub fn open(query: &DeviceQuery) -> Result<Self> {
        // This handle keeps the log until a failed opening has destroyed the instance, which writes into it.
        let log = Arc::<ValidationLog>::default();
        let (entry, instance, has_debug) = create_instance(query, &log)?;
        // Once `Shared` exists, it destroys all that was made. If opening fails, this function destroys the instance.
        let debug = has_debug.then(|| Debug::new(&entry, &instance, query.validation, &log)).transpose();
        let opened = debug.and_then(|debug| open_device(entry.clone(), instance.clone(), debug, query));
        if opened.is_err() {
            // SAFETY: opening failed before a device was created from the instance, or destroyed that device.
            unsafe { instance.destroy_instance(None) };
        }
        Ok(Self { shared: Arc::new(opened?), loan: None })
    }

    /// Wraps a device that the caller made and destroys.
    ///
    /// # Errors
    /// [`Error::NoDevice`] with what the device lacks, or with the feature that was not enabled on it.
    ///
    /// # Safety
    /// The handles belong together, and outlive every clone of this handle and all that is made from it. The features
    /// in `device` are on. When the last clone is dropped, the device is done with everything that was recorded.
    pub unsafe fn from_handles(device: DeviceHandles) -> Result<Self> {
        // SAFETY: `open::from_handles` has the contract of this function.
        Ok(Self { shared: Arc::new(unsafe { open::from_handles(device) }?), loan: None })
    }

    /// Whether the queues have timestamps.
    pub fn has_timestamps(&self) -> bool {
        self.shared.timestamp_mask != 0
    }

    /// The precision of the device's rasteriser and filters.
    pub fn precision(&self) -> Precision {
        let limits = &self.shared.limits;
        Precision {
            sub_pixel_bits: limits.sub_pixel_precision_bits,
            sub_texel_bits: limits.sub_texel_precision_bits,
            mipmap_bits: limits.mipmap_precision_bits,
        }
    }

    /// The number of the device in `ssct devices`; `None` for a caller's device.
    pub fn index(&self) -> Option<usize> {
        self.shared.index
    }

    /// Name, driver, Vulkan version and type of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.shared.info
    }

    /// The messages of the validation layers so far; none without [`DeviceQuery::validation`].
    pub fn validation(&self) -> Vec<validation::Message> {
        self.shared.debug.as_ref().map(|d| d.log.messages()).unwrap_or_default()
    }

    /// The log of the validation messages. The log outlives the device, since layers report leaked objects at its end.
    pub fn validation_log(&self) -> Option<Arc<ValidationLog>> {
        self.shared.debug.as_ref().map(|d| Arc::clone(&d.log))
    }

    /// Returns the validation messages that the allow-list does not excuse.
    pub fn violations(&self) -> Vec<validation::Message> {
        self.shared.debug.as_ref().map(|d| d.log.violations()).unwrap_or_default()
    }

    /// Fails if there are messages of the validation layers that the allow-list does not excuse.
    pub fn check_validation(&self) -> Result<()> {
        validation::check(&self.violations())
    }

    /// The raw device, for `gpu/` and the window.
    pub fn raw(&self) -> &ash::Device {
        &self.shared.device
    }

    /// The state that all handles of the device share.
    pub fn shared(&self) -> &Shared {
        &self.shared
    }

    /// Submissions to the device's queue so far. An idle window makes none.
    pub fn submissions(&self) -> u64 {
        self.shared.submissions.load(Ordering::Relaxed)
    }

    /// Counts a submission. Whoever submits must call this function.
    pub fn count_submission(&self) {
        self.shared.submissions.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn memory(&self) -> &MemorySource {
        &self.shared.memory
    }

    /// Locks the queue that frames are submitted to.
    ///
    /// # Errors
    /// [`Error::Usage`] if the device belongs to the caller, who must submit the work.
    pub fn queue(&self) -> Result<MutexGuard<'_, vk::Queue>> {
        let queue = self.shared.queue.as_ref();
        let queue =
            queue.ok_or_else(|| Error::Usage("this device belongs to the caller, who must submit the work".into()))?;
        Ok(queue.lock().unwrap_or_else(|e| e.into_inner()))
    }

    pub(crate) fn sampler(&self, sampler: Sampler) -> vk::Sampler {
        self.shared.samplers.get(sampler)
    }

    /// Calls `give_up` with a sentence if a frame is not done within `limit`, since a shader may run forever. `give_up`
    /// must end the program, since what the device works on cannot be freed. Only the first call counts.
    pub fn wait_at_most(&self, limit: Duration, give_up: fn(&str)) {
        self.shared.frame_timeout.get_or_init(|| (limit, give_up));
    }

    /// Bytes of device memory that resources take; 0 if a caller's allocator gives the memory.
    pub fn allocated_bytes(&self) -> u64 {
        self.memory().bytes().0
    }

    /// Bytes of the blocks of device memory that the allocator holds; 0 for a caller's allocator.
    pub fn reserved_bytes(&self) -> u64 {
        self.memory().bytes().1
    }

    /// The number of invocations in a subgroup.
    pub fn subgroup_size(&self) -> u32 {
        let mut v11 = vk::PhysicalDeviceVulkan11Properties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut v11);
        // SAFETY: the physical device is the one that this device was made from, and has Vulkan 1.3.
        unsafe { self.shared.instance.get_physical_device_properties2(self.shared.physical, &mut properties) };
        v11.subgroup_size
    }

    /// Pixels along a side of the largest point that the device draws.
    pub fn largest_point(&self) -> f32 {
        self.shared.largest_point
    }

    /// Whether fragment shaders know their triangle's number (`gl_PrimitiveID`), by the feature `geometryShader`.
    pub fn numbers_triangles(&self) -> bool {
        self.shared.numbers_triangles
    }

    /// The functions for ray queries, with which the device itself finds the triangles that rays meet.
    ///
    /// # Errors
    /// [`Error::Usage`] if the device has no ray queries, and on a caller's device.
    pub(crate) fn ray_queries(&self) -> Result<&RayQueries> {
        self.shared.ray_queries.as_ref().map_err(|why| Error::Usage(why.clone()))
    }

    /// Whether ray queries are on.
    pub fn has_ray_queries(&self) -> bool {
        self.shared.ray_queries.is_ok()
    }

    /// The largest width and height of an image that is drawn into. Viewports are up to twice as large as the image.
    pub fn max_image_size(&self) -> u32 {
        let limits = &self.shared.limits;
        let [width, height] = limits.max_viewport_dimensions;
        [limits.max_framebuffer_width, limits.max_framebuffer_height, width / 2, height / 2]
            .into_iter()
            .fold(limits.max_image_dimension2_d, u32::min)
    }

    /// The most layers of an array of images.
    pub fn max_image_layers(&self) -> u32 {
        self.shared.limits.max_image_array_layers
    }

    /// The most vertices that the indices of one draw can tell apart.
    pub fn max_vertices(&self) -> u64 {
        u64::from(self.shared.limits.max_draw_indexed_index_value) + 1
    }

    /// The largest width, height and depth of a volume.
    pub fn max_volume_size(&self) -> u32 {
        self.shared.limits.max_image_dimension3_d
    }

    /// Fails unless images of a format can be filtered linearly. Vulkan promises this for no format of 32-bit channels.
    pub fn require_linear_filter(&self, format: vk::Format) -> Result<()> {
        // SAFETY: the physical device is the one that this device was made from.
        let properties =
            unsafe { self.shared.instance.get_physical_device_format_properties(self.shared.physical, format) };
        if properties.optimal_tiling_features.contains(vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR) {
            return Ok(());
        }
        Err(Error::Usage(format!("{} cannot filter {format:?} images linearly", self.info().name)))
    }

    /// Names an object for RenderDoc, Nsight and the validation layers.
    pub fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        let Some(debug) = &self.shared.debug_device else { return };
        let name = CString::new(name.replace('\0', " ")).unwrap_or_default();
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle belongs to this device. A name that can't be set is no loss.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// Begins a labelled region of commands, which debuggers show.
    pub(crate) fn begin_label(&self, commands: vk::CommandBuffer, name: &str) {
        if let Some(debug) = &self.shared.debug_device {
            let name = CString::new(name.replace('\0', " ")).unwrap_or_default();
            let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
            // SAFETY: the command buffer is recording.
            unsafe { debug.cmd_begin_debug_utils_label(commands, &label) };
        }
    }

    pub(crate) fn end_label(&self, commands: vk::CommandBuffer) {
        if let Some(debug) = &self.shared.debug_device {
            // SAFETY: the command buffer is recording, inside a label of `begin_label`.
            unsafe { debug.cmd_end_debug_utils_label(commands) };
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: the last handle is gone, and so is every resource, since each keeps a handle. The device is idle before anything is
        // destroyed; on a caller's device, the caller promises this (`Gpu::from_handles`).
        unsafe {
            if self.owned {
                let _ = self.device.device_wait_idle();
            }
            self.executables = None;
            self.pipelines.clear();
            self.samplers.destroy(&self.device);
            ManuallyDrop::drop(&mut self.memory);
            if !self.owned {
                return;
            }
            self.device.destroy_device(None);
            // Keeps the log, into which the instance writes until it is destroyed.
            let _log = self.debug.as_ref().map(|debug| Arc::clone(&debug.log));
            if let Some(debug) = self.debug.take() {
                debug.destroy();
            }
            self.instance.destroy_instance(None);
        }
    }
}

impl Debug {
    /// Loads the functions of VK_EXT_debug_utils. With `listen`, the messages of the validation layers go into the log.
    fn new(entry: &ash::Entry, instance: &ash::Instance, listen: bool, log: &Arc<ValidationLog>) -> Result<Self> {
        let loader = ash::ext::debug_utils::Instance::new(entry, instance);
        let messenger = if listen {
            // SAFETY: this handle of the log is dropped after the messenger (`destroy`).
            Some(
                unsafe { loader.create_debug_utils_messenger(&validation::messenger(log), None) }
                    .map_err(vulkan("vkCreateDebugUtilsMessengerEXT"))?,
            )
        } else {
            None
        };
        Ok(Self { loader, messenger, log: Arc::clone(log) })
    }

    /// # Safety
    /// The instance is alive and no longer used.
    unsafe fn destroy(self) {
        if let Some(messenger) = self.messenger {
            // SAFETY: the messenger belongs to the instance, which is alive by the contract.
            unsafe { self.loader.destroy_debug_utils_messenger(messenger, None) };
        }
    }
}
