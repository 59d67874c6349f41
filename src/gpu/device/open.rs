//! Opening a device: the instance, the choice among what the loader lists, and the logical device.

use super::compile_only::{self, HostMemory};
use super::features::{self, enable_features};
use super::no_driver;
use super::ray_queries::{self, RayQueries};
use super::{Debug, DeviceHandles, DeviceInfo, DeviceListing, DeviceQuery, Shared, text, vulkan};
use crate::error::{Error, Result};
use crate::gpu::executables::Executables;
use crate::gpu::memory::MemorySource;
use crate::gpu::pipelines::Pipelines;
use crate::gpu::sampler::Samplers;
use crate::gpu::testing::watch;
use crate::gpu::validation::{self, ValidationLog};
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::{CStr, c_char};
use std::mem::ManuallyDrop;
use std::sync::atomic::AtomicU64;
use std::sync::{Mutex, OnceLock};

/// Makes an instance. Returns the loader, the instance, and whether the instance takes names and labels. Under
/// validation, the layers write messages about the instance into the log, which must outlive the instance.
pub(super) fn create_instance(query: &DeviceQuery, log: &ValidationLog) -> Result<(ash::Entry, ash::Instance, bool)> {
    // SAFETY: loading the system's Vulkan loader runs its initialisers, which is its purpose.
    let entry = unsafe { ash::Entry::load() }.map_err(|e| {
        let advice = memory_advice().unwrap_or_else(|| "; scripts/setup.sh installs it".to_owned());
        Error::NoDevice(format!("the Vulkan loader cannot be opened ({e}){advice}"))
    })?;
    // SAFETY: enumeration has no preconditions.
    let (layers, extensions) = unsafe {
        (
            entry
                .enumerate_instance_layer_properties()
                .map_err(no_driver::failed("vkEnumerateInstanceLayerProperties"))?,
            entry
                .enumerate_instance_extension_properties(None)
                .map_err(no_driver::failed("vkEnumerateInstanceExtensionProperties"))?,
        )
    };
    let has_layer = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(validation::LAYER));
    if query.validation && !has_layer {
        return Err(Error::Usage(
            "the Khronos validation layers are not installed; scripts/setup.sh installs them".into(),
        ));
    }
    let has_debug =
        query.validation || extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(ash::ext::debug_utils::NAME));

    let mut names: Vec<_> = query.instance_extensions.iter().map(|n| n.as_ptr()).collect();
    if has_debug {
        names.push(ash::ext::debug_utils::NAME.as_ptr());
    }
    let layer_names: Vec<_> = if query.validation { vec![validation::LAYER.as_ptr()] } else { Vec::new() };
    let application = vk::ApplicationInfo::default().application_name(c"ssct").api_version(vk::API_VERSION_1_3);
    use vk::ValidationFeatureEnableEXT as E;
    let mut enables = vec![E::BEST_PRACTICES, E::SYNCHRONIZATION_VALIDATION];
    if query.gpu_assisted {
        enables.extend([E::GPU_ASSISTED, E::GPU_ASSISTED_RESERVE_BINDING_SLOT]);
    }
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enables);
    let mut messenger = validation::messenger(log);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_extension_names(&names)
        .enabled_layer_names(&layer_names);
    if query.validation {
        info = info.push_next(&mut features).push_next(&mut messenger);
    }
    // SAFETY: the names and structures live through the call.
    let instance = unsafe { entry.create_instance(&info, None) }
        .map_err(|result| out_of_memory(result).unwrap_or_else(|| no_driver::failed("vkCreateInstance")(result)))?;
    Ok((entry, instance, has_debug))
}

/// Returns how many bytes of address space this process may take, if the system sets a limit (`ulimit -v`). The loader
/// leaves out a driver that does not fit, and gives no reason.
pub fn memory_limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Returns the end of a sentence, which says that memory may be short; `None` if the system sets no limit.
fn memory_advice() -> Option<String> {
    let mib = memory_limit()? >> 20;
    Some(format!(
        ": memory is short, as this process may take {mib} MiB (ulimit -v); raise the limit, or install a driver"
    ))
}

/// Makes the error about a driver or device that was not found, if the memory limit of this process may be the reason.
/// Under such a limit, the loader leaves out a driver that needs more memory, or the driver starts and finds no device.
fn out_of_memory(result: vk::Result) -> Option<Error> {
    use vk::Result as R;
    let causes = [R::ERROR_INCOMPATIBLE_DRIVER, R::ERROR_OUT_OF_HOST_MEMORY, R::ERROR_INITIALIZATION_FAILED];
    let advice = memory_advice().filter(|_| causes.contains(&result))?;
    Some(Error::NoDevice(format!("the loader finds no driver that fits{advice}")))
}

/// Lists every device of an instance, and why one cannot be used. With `compiles_only`, a device needs no memory.
pub(super) fn list_devices(
    instance: &ash::Instance,
    compiles_only: bool,
) -> Result<Vec<(vk::PhysicalDevice, DeviceListing)>> {
    // SAFETY: the instance is alive.
    let devices = unsafe { instance.enumerate_physical_devices() }.map_err(|result| {
        out_of_memory(result).unwrap_or_else(|| no_driver::failed("vkEnumeratePhysicalDevices")(result))
    })?;
    if devices.is_empty() {
        let nothing = vk::Result::ERROR_INITIALIZATION_FAILED;
        return Err(out_of_memory(nothing).unwrap_or_else(|| no_driver::no_device(nothing)));
    }
    let listing = |(index, physical): (usize, vk::PhysicalDevice)| {
        let absent_hardware = || absent_hardware(instance, physical).filter(|_| !compiles_only);
        let unsuitable = why_unsuitable(instance, physical).or_else(absent_hardware);
        (physical, DeviceListing { index, info: describe(instance, physical), unsuitable })
    };
    Ok(devices.into_iter().enumerate().map(listing).collect())
}

/// Returns the sentence that a device has no memory, because its hardware is absent; `None` if it has memory.
fn absent_hardware(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Option<String> {
    // SAFETY: the physical device belongs to the instance.
    let memory = unsafe { instance.get_physical_device_memory_properties(physical) };
    (memory.memory_type_count == 0)
        .then(|| "it has no memory, since its hardware is not there; ssct shaders can use it".into())
}

/// Reads name, driver, version and type of a device.
fn describe(instance: &ash::Instance, physical: vk::PhysicalDevice) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: the physical device belongs to the instance.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let device = properties.properties;
    let api = device.api_version;
    DeviceInfo {
        name: text(device.device_name_as_c_str()),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()))
            .trim()
            .to_owned(),
        api: format!("{}.{}.{}", vk::api_version_major(api), vk::api_version_minor(api), vk::api_version_patch(api)),
        kind: match device.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete GPU",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated GPU",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual GPU",
            vk::PhysicalDeviceType::CPU => "CPU",
            _ => "other",
        }
        .to_owned(),
    }
}

/// Returns the reason why a device cannot be used; `None` if it can.
fn why_unsuitable(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Option<String> {
    // SAFETY: the physical device belongs to the instance.
    let (properties, families) = unsafe {
        (
            instance.get_physical_device_properties(physical),
            instance.get_physical_device_queue_family_properties(physical),
        )
    };
    if properties.api_version < vk::API_VERSION_1_3 {
        return Some("it has no Vulkan 1.3".into());
    }
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12).push_next(&mut v13);
    // SAFETY: the physical device belongs to the instance.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    if let Some(name) = features::missing(features.features, v12, v13) {
        return Some(format!("it lacks the feature {name}"));
    }
    match families.iter().find(|f| has_graphics_and_compute(f)) {
        None => Some("it has no queue for graphics and compute".into()),
        Some(f) if f.timestamp_valid_bits == 0 => Some("its queue has no timestamps".into()),
        Some(_) => None,
    }
}

fn has_graphics_and_compute(family: &vk::QueueFamilyProperties) -> bool {
    family.queue_flags.contains(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE)
}

/// Chooses the device that the query asks for by index or by a part of its name, or else the best usable one by type.
fn choose(
    listing: Vec<(vk::PhysicalDevice, DeviceListing)>,
    query: &DeviceQuery,
) -> Result<(vk::PhysicalDevice, DeviceListing)> {
    let wanted = query.device.clone().or_else(|| std::env::var("SSCT_DEVICE").ok()).filter(|w| !w.is_empty());
    let Some(wanted) = wanted else {
        let rank = |device: &DeviceListing| match device.info.kind.as_str() {
            "discrete GPU" => 0,
            "integrated GPU" => 1,
            "virtual GPU" => 2,
            "CPU" => 3,
            _ => 4,
        };
        let reasons: Vec<_> =
            listing.iter().filter_map(|(_, l)| Some(format!("{}: {}", l.info.name, l.unsuitable.as_ref()?))).collect();
        return listing
            .into_iter()
            .filter(|(_, device)| device.unsuitable.is_none())
            .min_by_key(|(_, device)| rank(device))
            .ok_or_else(|| Error::NoDevice(reasons.join("; ")));
    };
    let names: Vec<_> = listing.iter().map(|(_, l)| format!("{} {}", l.index, l.info.name)).collect();
    // A number that is no index may be part of a name, as 4090 is.
    let by_index = wanted.parse::<usize>().ok().filter(|index| listing.iter().any(|(_, l)| l.index == *index));
    let found = listing.into_iter().find(|(_, l)| match by_index {
        Some(index) => l.index == index,
        None => l.info.name.to_lowercase().contains(&wanted.to_lowercase()),
    });
    let (physical, found) =
        found.ok_or_else(|| Error::Usage(format!("no device {wanted:?}; there is: {}", names.join(", "))))?;
    match &found.unsuitable {
        Some(why) => Err(Error::NoDevice(format!("{} cannot be used: {why}", found.info.name))),
        None => Ok((physical, found)),
    }
}

/// Opens the device that the query asks for. After an error, the caller must destroy the instance.
pub(super) fn open_device(
    entry: ash::Entry,
    instance: ash::Instance,
    debug: Option<Debug>,
    query: &DeviceQuery,
) -> Result<Shared> {
    // On an early return the messenger must go before the instance.
    let mut debug = DebugGuard(debug);
    let (physical, listing) = choose(list_devices(&instance, query.compiles_only)?, query)?;
    let instance = if query.compiles_only { compile_only::instance(&instance) } else { instance };
    // SAFETY: the physical device belongs to the instance.
    let (properties, families) = unsafe {
        (
            instance.get_physical_device_properties(physical),
            instance.get_physical_device_queue_family_properties(physical),
        )
    };
    let (queue_family, family) = families
        .iter()
        .enumerate()
        .find(|(_, f)| has_graphics_and_compute(f))
        .ok_or_else(|| Error::NoDevice("no universal queue".into()))?;
    let (extension_names, ray_query_support) = extensions(&instance, physical, &listing.info.name, query)?;
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family as u32).queue_priorities(&[1.0])];
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
    let features = core_features(&instance, physical, query, (&mut v12, &mut v13));
    // The features stand in the pNext chain: with pEnabledFeatures, the layers of 1.4.309 report that the supported features were
    // never queried, even if they were (KhronosGroup/Vulkan-ValidationLayers issue 9900).
    let mut core = vk::PhysicalDeviceFeatures2::default().features(features);
    v12.buffer_device_address = ray_query_support.is_ok().into();
    let (mut structures, mut queries) = ray_queries::features();
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extension_names)
        .push_next(&mut core)
        .push_next(&mut v12)
        .push_next(&mut v13);
    if ray_query_support.is_ok() {
        info = info.push_next(&mut structures).push_next(&mut queries);
    }
    let mut statistics =
        vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
    if query.compiles_only {
        info = info.push_next(&mut statistics);
    }
    // SAFETY: the structures live through the call; features and extensions were found supported.
    let mut device = unsafe { instance.create_device(physical, &info, None) }.map_err(vulkan("vkCreateDevice"))?;
    // SAFETY: the queue was asked for above.
    let queue = unsafe { device.get_device_queue(queue_family as u32, 0) };
    if let Some(watch) = &query.watch {
        device = watch::watch_device(&device, queue, watch);
    }

    let memory = if query.compiles_only {
        Ok(MemorySource::Callers(Mutex::new(Box::new(HostMemory::default()))))
    } else {
        new_allocator(&instance, physical, &device, ray_query_support.is_ok())
    };
    let memory_and_samplers = memory.and_then(|memory| {
        Ok((memory, Samplers::new(&device, features.sampler_anisotropy == vk::TRUE, &properties.limits)?))
    });
    if memory_and_samplers.is_err() {
        // SAFETY: nothing else was created from the device.
        unsafe { device.destroy_device(None) };
    }
    let (memory, samplers) = memory_and_samplers?;
    let debug = debug.0.take();
    // A device that is used only to compile has no real objects, so that there are no handles to name.
    let names_objects = debug.is_some() && !query.compiles_only;
    Ok(Shared {
        executables: query.compiles_only.then(|| Executables::new(&instance, &device)),
        ray_queries: ray_query_support.map(|()| RayQueries::load(&instance, physical, &device)),
        debug_device: names_objects.then(|| ash::ext::debug_utils::Device::new(&instance, &device)),
        queue: Some(Mutex::new(queue)),
        entry,
        instance,
        debug,
        physical,
        device,
        queue_family: queue_family as u32,
        samplers,
        pipelines: Pipelines::default(),
        memory: ManuallyDrop::new(memory),
        owned: true,
        submissions: AtomicU64::new(0),
        frame_timeout: OnceLock::new(),
        #[cfg(feature = "reload")]
        replaced_shaders: crate::gpu::shader::ReplacedShaders::default(),
        index: Some(listing.index),
        info: listing.info,
        limits: properties.limits,
        timestamp_mask: timestamp_mask(family),
        has_pipeline_statistics: features.pipeline_statistics_query == vk::TRUE,
        numbers_triangles: features.geometry_shader == vk::TRUE,
        largest_point: if features.large_points == vk::TRUE { properties.limits.point_size_range[1] } else { 1.0 },
    })
}

/// Returns the names of the extensions that a device called `name` gets, and whether ray queries are among them; if
/// not, a sentence says why. Fails if the device lacks an extension that the query needs.
fn extensions(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    name: &str,
    query: &DeviceQuery,
) -> Result<(Vec<*const c_char>, std::result::Result<(), String>)> {
    // SAFETY: the physical device belongs to the instance.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    let offers = |name: &CStr| offered.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    let mut names = Vec::new();
    if !query.instance_extensions.is_empty() {
        if !offers(ash::khr::swapchain::NAME) {
            return Err(Error::NoDevice(format!("{name} cannot present to a window")));
        }
        names.push(ash::khr::swapchain::NAME.as_ptr());
    }
    let ray_query_support = ray_queries::check_support(instance, physical, offers)
        .map_err(|lacked| format!("{name} has no ray queries: it lacks {lacked}; the tracer tree needs none"));
    if ray_query_support.is_ok() {
        names.extend(ray_queries::EXTENSIONS.map(CStr::as_ptr));
    }
    if query.compiles_only {
        if !offers(Executables::EXTENSION) {
            let lacked = Executables::EXTENSION.to_string_lossy();
            return Err(Error::NoDevice(format!("{name} does not tell what its compiler made: it lacks {lacked}")));
        }
        names.push(Executables::EXTENSION.as_ptr());
    }
    Ok((names, ray_query_support))
}

/// Returns the features of Vulkan 1.0 that a device gets, and turns on those of later versions that this crate needs.
fn core_features(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    query: &DeviceQuery,
    (v12, v13): (&mut vk::PhysicalDeviceVulkan12Features<'_>, &mut vk::PhysicalDeviceVulkan13Features<'_>),
) -> vk::PhysicalDeviceFeatures {
    // SAFETY: the physical device belongs to the instance.
    let supported = unsafe { instance.get_physical_device_features(physical) };
    let mut features = vk::PhysicalDeviceFeatures::default()
        .full_draw_index_uint32(supported.full_draw_index_uint32 == vk::TRUE)
        .sampler_anisotropy(supported.sampler_anisotropy == vk::TRUE && !query.isotropic)
        .pipeline_statistics_query(supported.pipeline_statistics_query == vk::TRUE)
        // Shaders of users store to images without naming the images' formats, as OpenGL allows.
        .shader_storage_image_write_without_format(supported.shader_storage_image_write_without_format == vk::TRUE)
        .shader_storage_image_read_without_format(supported.shader_storage_image_read_without_format == vk::TRUE)
        .shader_image_gather_extended(supported.shader_image_gather_extended == vk::TRUE);
    enable_features(&mut features, v12, v13);
    features.large_points = supported.large_points;
    features.geometry_shader = supported.geometry_shader;
    features
}

/// Wraps a caller's device, with the state that its handles share.
///
/// # Safety
/// The contract is that of [`Gpu::from_handles`](super::Gpu::from_handles).
pub(super) unsafe fn from_handles(device: DeviceHandles) -> Result<Shared> {
    let DeviceHandles { entry, instance, physical, device, queue_family, enabled, debug_utils, memory } = device;
    // SAFETY: by the contract, the physical device belongs to the instance.
    let (properties, families) = unsafe {
        (
            instance.get_physical_device_properties(physical),
            instance.get_physical_device_queue_family_properties(physical),
        )
    };
    let info = describe(&instance, physical);
    let refused = |why: String| Error::NoDevice(format!("{} cannot be used: {why}", info.name));
    if properties.api_version < vk::API_VERSION_1_3 {
        return Err(refused("it has no Vulkan 1.3".into()));
    }
    // The loader knows the version that the instance was made for, and hands out no later functions.
    // SAFETY: by the contract, the device is alive and of this instance.
    let function_of_1_3 =
        unsafe { (instance.fp_v1_0().get_device_proc_addr)(device.handle(), c"vkCmdPipelineBarrier2".as_ptr()) };
    if function_of_1_3.is_none() {
        let why = "the instance was not made for Vulkan 1.3 (VkApplicationInfo::apiVersion)";
        return Err(refused(why.into()));
    }
    if let Some(name) = features::missing(enabled.core, enabled.vulkan12, enabled.vulkan13) {
        return Err(refused(format!("the feature {name} was not enabled when the device was made")));
    }
    let family =
        families.get(queue_family as usize).ok_or_else(|| refused(format!("it has no queue family {queue_family}")))?;
    if !has_graphics_and_compute(family) {
        return Err(refused(format!("queues of family {queue_family} do not take both graphics and compute")));
    }
    let features = &enabled.core;
    let samplers = Samplers::new(&device, features.sampler_anisotropy == vk::TRUE, &properties.limits)?;
    let memory = match memory {
        Some(allocator) => MemorySource::Callers(Mutex::new(allocator)),
        None => match new_allocator(&instance, physical, &device, false) {
            Ok(memory) => memory,
            Err(e) => {
                // SAFETY: nothing uses the samplers yet.
                unsafe { samplers.destroy(&device) };
                return Err(e);
            }
        },
    };
    Ok(Shared {
        executables: None,
        ray_queries: Err(format!("{} is the caller's device, on which no ray queries are used", info.name)),
        debug_device: debug_utils.then(|| ash::ext::debug_utils::Device::new(&instance, &device)),
        queue: None,
        entry,
        debug: None,
        physical,
        queue_family,
        samplers,
        pipelines: Pipelines::default(),
        memory: ManuallyDrop::new(memory),
        owned: false,
        submissions: AtomicU64::new(0),
        frame_timeout: OnceLock::new(),
        #[cfg(feature = "reload")]
        replaced_shaders: crate::gpu::shader::ReplacedShaders::default(),
        info,
        index: None,
        limits: properties.limits,
        timestamp_mask: timestamp_mask(family),
        has_pipeline_statistics: false,
        numbers_triangles: features.geometry_shader == vk::TRUE,
        largest_point: if features.large_points == vk::TRUE { properties.limits.point_size_range[1] } else { 1.0 },
        instance,
        device,
    })
}

/// Returns the mask of the valid bits of a queue family's timestamps; 0 if the family has no timestamps.
fn timestamp_mask(family: &vk::QueueFamilyProperties) -> u64 {
    match family.timestamp_valid_bits {
        bits @ 0..64 => (1 << bits) - 1,
        _ => u64::MAX,
    }
}

/// Makes the crate's own allocator; `has_addresses` says whether buffers may have device addresses.
fn new_allocator(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    device: &ash::Device,
    has_addresses: bool,
) -> Result<MemorySource> {
    let allocator = Allocator::new(&AllocatorCreateDesc {
        instance: instance.clone(),
        device: device.clone(),
        physical_device: physical,
        debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
        buffer_device_address: has_addresses,
        allocation_sizes: gpu_allocator::AllocationSizes::default(),
    })
    .map_err(|e| Error::Memory { what: "the allocator".into(), message: e.to_string() })?;
    Ok(MemorySource::Ours(Box::new(Mutex::new(allocator))))
}

/// A guard that destroys the messenger that it holds when the guard is dropped.
struct DebugGuard(Option<Debug>);

impl Drop for DebugGuard {
    fn drop(&mut self) {
        if let Some(debug) = self.0.take() {
            // SAFETY: dropped only on the way out of a failed `open_device`, before the instance.
            unsafe { debug.destroy() };
        }
    }
}
