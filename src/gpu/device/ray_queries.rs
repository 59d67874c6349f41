//! Ray queries: the extensions and features that they need, and the functions that build their acceleration structures.

use ash::{khr, vk};
use std::ffi::CStr;

/// The extensions that a device must have. The first one needs the last.
pub const EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// The functions and limits for ray queries, on a device that has them on.
pub struct RayQueries {
    /// The functions of VK_KHR_acceleration_structure.
    pub structures: khr::acceleration_structure::Device,
    /// Alignment of the addresses of a build's scratch memory, in bytes.
    pub scratch_alignment: u64,
}

impl RayQueries {
    /// Loads the functions and limits of a device that has ray queries on.
    pub fn load(instance: &ash::Instance, physical: vk::PhysicalDevice, device: &ash::Device) -> Self {
        let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
        // SAFETY: the physical device belongs to the instance and has the extension.
        unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
        let scratch_alignment = u64::from(limits.min_acceleration_structure_scratch_offset_alignment).max(1);
        Self { structures: khr::acceleration_structure::Device::new(instance, device), scratch_alignment }
    }
}

/// Checks that a device supports ray queries; `offers` says whether the device has an extension.
///
/// # Errors
/// The name of the first extension or feature that the device lacks.
pub fn check_support(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    offers: impl Fn(&CStr) -> bool,
) -> Result<(), String> {
    if let Some(lacked) = EXTENSIONS.into_iter().find(|name| !offers(name)) {
        return Err(lacked.to_string_lossy().into_owned());
    }
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut features =
        vk::PhysicalDeviceFeatures2::default().push_next(&mut v12).push_next(&mut structures).push_next(&mut queries);
    // SAFETY: the physical device belongs to the instance and has the extensions.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    let needed = [
        ("bufferDeviceAddress", v12.buffer_device_address),
        ("accelerationStructure", structures.acceleration_structure),
        ("rayQuery", queries.ray_query),
    ];
    let lacked = needed.into_iter().find(|(_, supported)| *supported == vk::FALSE);
    lacked.map_or(Ok(()), |(name, _)| Err(format!("the feature {name}")))
}

/// The features of the extensions, turned on.
pub fn features()
-> (vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>, vk::PhysicalDeviceRayQueryFeaturesKHR<'static>) {
    (
        vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true),
        vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
    )
}
