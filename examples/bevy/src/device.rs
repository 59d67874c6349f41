//! Opens a device with what Bevy asks for and what `ssct` needs.

use ash::vk;
use bevy::render::renderer::raw_vulkan_init::AdditionalVulkanFeatures;
use bevy::render::renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice, RenderInstance, RenderQueue};
use bevy::render::settings::RenderCreation;
use std::error::Error;
use wgpu::hal::api::Vulkan;

pub const NO_VULKAN: &str = "wgpu runs on something else than Vulkan";

pub type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Marks a device that has on what `ssct` needs, among Bevy's additional features.
pub struct SsctFeatures;

/// What Bevy's `RenderPlugin` draws with: the fastest device on Vulkan, with all that it can but what wgpu calls
/// experimental, and with what `ssct` needs. `WGPU_VALIDATION=1` turns the validation layer on.
///
/// # Errors
/// Says what failed: there is no device, or it lacks a feature.
pub fn render_creation() -> Result<RenderCreation> {
    let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
    description.backends = wgpu::Backends::VULKAN;
    // wgpu's usual flags for debugging also name WGSL in the shaders as their source, which the layer of Vulkan 1.3.239 takes
    // for an error.
    description.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(description);
    let power_preference = wgpu::PowerPreference::HighPerformance;
    let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
    let adapter = bevy::tasks::block_on(instance.request_adapter(&options))?;
    let required_features = features(&adapter);
    let open = open(&adapter, required_features)?;
    let description =
        wgpu::DeviceDescriptor { required_features, required_limits: adapter.limits(), ..Default::default() };
    // SAFETY: the device is of this adapter, and has these features and limits.
    let (device, queue) = unsafe { adapter.create_device_from_hal(open, &description) }?;
    let mut additional = AdditionalVulkanFeatures::default();
    additional.insert::<SsctFeatures>();
    Ok(RenderCreation::manual(
        RenderDevice::from(device),
        RenderQueue::new(queue),
        RenderAdapterInfo::new(adapter.get_info()),
        RenderAdapter::new(adapter),
        RenderInstance::new(instance),
        additional,
    ))
}

/// What Bevy turns on by itself, less what wgpu calls experimental.
fn features(adapter: &wgpu::Adapter) -> wgpu::Features {
    let mut features = adapter.features() - wgpu::Features::all_experimental_mask();
    if adapter.get_info().device_type == wgpu::DeviceType::DiscreteGpu {
        features.remove(wgpu::Features::MAPPABLE_PRIMARY_BUFFERS);
    }
    features
}

/// Opens a device as wgpu does. Bevy's and wgpu's callbacks would do for what is chained, but neither for the features of
/// Vulkan 1.0, which wgpu sets itself and hides, nor for `maintenance4`, which it chains as off.
fn open(adapter: &wgpu::Adapter, features: wgpu::Features) -> Result<wgpu::hal::OpenDevice<Vulkan>> {
    let limits = adapter.limits();
    // SAFETY: the structures live through the call that reads them, each in the chain once, and wgpu owns what is made.
    unsafe {
        let adapter = adapter.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let extensions = adapter.required_device_extensions(features);
        let mut of_wgpu = adapter.physical_device_features(&extensions, features);
        let enabled = enabled_features(of_wgpu.get_core());
        // wgpu chains features one by one, which excludes the structures of whole versions.
        let mut host_query_reset = vk::PhysicalDeviceHostQueryResetFeatures::default().host_query_reset(true);
        let mut dynamic_rendering = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut synchronization2 = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
        let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&names);
        let info = of_wgpu
            .add_to_device_create(info)
            .enabled_features(&enabled.core)
            .push_next(&mut host_query_reset)
            .push_next(&mut dynamic_rendering)
            .push_next(&mut synchronization2);
        let mut next = info.p_next.cast_mut().cast::<vk::BaseOutStructure>();
        while !next.is_null() {
            if (*next).s_type == vk::StructureType::PHYSICAL_DEVICE_MAINTENANCE_4_FEATURES {
                (*next.cast::<vk::PhysicalDeviceMaintenance4Features>()).maintenance4 = vk::TRUE;
            }
            next = (*next).p_next;
        }
        let instance = adapter.shared_instance().raw_instance();
        let device = instance.create_device(adapter.raw_physical_device(), &info, None)?;
        let hints = wgpu::MemoryHints::default();
        Ok(adapter.device_from_raw(device, None, &extensions, features, &limits, &hints, 0, 0)?)
    }
}

/// What [`open`] turns on, given wgpu's features of Vulkan 1.0, and no more: `Context::new` compares it with what it needs.
fn enabled_features(of_wgpu: vk::PhysicalDeviceFeatures) -> ssct::EnabledFeatures {
    let mut wanted = ssct::EnabledFeatures { core: of_wgpu, ..Default::default() };
    ssct::enable_features(&mut wanted.core, &mut wanted.vulkan12, &mut wanted.vulkan13);
    ssct::EnabledFeatures {
        core: wanted.core,
        vulkan12: vk::PhysicalDeviceVulkan12Features::default().host_query_reset(true),
        vulkan13: vk::PhysicalDeviceVulkan13Features::default()
            .dynamic_rendering(true)
            .synchronization2(true)
            .maintenance4(true),
    }
}

/// The device of [`render_creation`] as `ssct` takes it.
///
/// # Errors
/// Says what the device lacks.
pub fn context(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Result<ssct::Context> {
    // SAFETY: nothing is destroyed, and the handles outlive the context, which the render world drops first.
    unsafe {
        let core = {
            let hal = adapter.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
            let features = features(adapter);
            hal.physical_device_features(&hal.required_device_extensions(features), features).get_core()
        };
        let device = device.as_hal::<Vulkan>().ok_or(NO_VULKAN)?;
        let instance = device.shared_instance();
        Ok(ssct::Context::new(ssct::DeviceHandles {
            entry: instance.entry().clone(),
            instance: instance.raw_instance().clone(),
            physical: device.raw_physical_device(),
            device: device.raw_device().clone(),
            queue_family: device.queue_family_index(),
            enabled: enabled_features(core),
            debug_utils: instance.extensions().contains(&ash::ext::debug_utils::NAME),
            memory: None,
        })?)
    }
}
