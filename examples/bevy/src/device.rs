//! Opens a device with what Bevy asks for and what `ssct` needs.

use bevy::render::renderer::raw_vulkan_init::AdditionalVulkanFeatures;
use bevy::render::renderer::{RenderAdapter, RenderAdapterInfo, RenderDevice, RenderInstance, RenderQueue};
use bevy::render::settings::RenderCreation;
pub use embed_wgpu::Result;

/// Marks, among Bevy's additional features, a device on which all features that `ssct` needs are on.
pub struct SsctFeatures;

/// Opens the fastest Vulkan device for Bevy's `RenderPlugin`. All features that it supports and that wgpu does not call
/// experimental are turned on, and those that `ssct` needs. `WGPU_VALIDATION=1` turns the validation layer on.
///
/// # Errors
/// Says what failed: there is no device, or it lacks a feature.
pub fn render_creation() -> Result<RenderCreation> {
    let (instance, adapter) = bevy::tasks::block_on(embed_wgpu::fastest())?;
    let required_features = features(&adapter);
    let open = embed_wgpu::open(&adapter, required_features, &adapter.limits())?;
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

/// Returns the features that Bevy turns on by itself, without those that wgpu calls experimental. Like Bevy, it leaves
/// `MAPPABLE_PRIMARY_BUFFERS` off on discrete GPUs.
fn features(adapter: &wgpu::Adapter) -> wgpu::Features {
    let mut features = adapter.features() - wgpu::Features::all_experimental_mask();
    if adapter.get_info().device_type == wgpu::DeviceType::DiscreteGpu {
        features.remove(wgpu::Features::MAPPABLE_PRIMARY_BUFFERS);
    }
    features
}

/// Makes the context of `ssct` on the device that [`render_creation`] opened.
///
/// # Errors
/// Says what the device lacks.
pub fn context(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Result<ssct::Context> {
    let handles = embed_wgpu::handles(adapter, device, features(adapter))?;
    // SAFETY: nothing is destroyed, and the handles outlive the context, which the render world drops first.
    Ok(unsafe { ssct::Context::new(handles) }?)
}
