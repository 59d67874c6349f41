//! The Vulkan features that every device has on.

use ash::vk;

/// Lists the features that every device needs: the name of each, and its flag in the given structs.
fn needed<'a>(
    v10: &'a mut vk::PhysicalDeviceFeatures,
    v12: &'a mut vk::PhysicalDeviceVulkan12Features<'_>,
    v13: &'a mut vk::PhysicalDeviceVulkan13Features<'_>,
) -> [(&'static str, &'a mut vk::Bool32); 7] {
    [
        ("imageCubeArray", &mut v10.image_cube_array),
        ("fragmentStoresAndAtomics", &mut v10.fragment_stores_and_atomics),
        ("shaderStorageImageExtendedFormats", &mut v10.shader_storage_image_extended_formats),
        ("hostQueryReset", &mut v12.host_query_reset),
        ("dynamicRendering", &mut v13.dynamic_rendering),
        ("synchronization2", &mut v13.synchronization2),
        ("maintenance4", &mut v13.maintenance4),
    ]
}

/// Turns on the features that this crate needs, and leaves other features as they are. All of them are core Vulkan 1.3,
/// so that no extension is needed. If a device lacks `largePoints`, turn it off again; only `unified` needs it.
pub fn enable_features(
    core: &mut vk::PhysicalDeviceFeatures,
    vulkan12: &mut vk::PhysicalDeviceVulkan12Features<'_>,
    vulkan13: &mut vk::PhysicalDeviceVulkan13Features<'_>,
) {
    core.large_points = vk::TRUE;
    for (_, feature) in needed(core, vulkan12, vulkan13) {
        *feature = vk::TRUE;
    }
}

/// Returns the name of the first needed feature whose flag is off in the given structs.
pub fn missing(
    mut v10: vk::PhysicalDeviceFeatures,
    mut v12: vk::PhysicalDeviceVulkan12Features<'_>,
    mut v13: vk::PhysicalDeviceVulkan13Features<'_>,
) -> Option<&'static str> {
    needed(&mut v10, &mut v12, &mut v13).into_iter().find(|(_, flag)| **flag == vk::FALSE).map(|(name, _)| name)
}
