//! Checks shaders against the limits of a device, since a shader may need more than Vulkan promises of every device.

use super::device::Gpu;
use super::shader::{Binding, BindingKind, Shader};
use crate::error::{Error, Result};
use ash::vk;

/// The most descriptors of one kind that a descriptor set has.
pub(super) const MAX_DESCRIPTORS: u32 = 32;

/// Checks that a device can run the shaders of one pipeline; `bindings` are those of all its shaders. The error names
/// the last shader, which shades or computes, and the limit that is exceeded.
pub(super) fn check(gpu: &Gpu, shaders: &[&Shader], bindings: &[Binding]) -> Result<()> {
    let Some(shader) = shaders.last() else { return Ok(()) };
    match first_excess(&gpu.shared().limits, shader.local_size, bindings) {
        None => Ok(()),
        Some((what, count, most)) => Err(Error::NoDevice(format!(
            "the shader {} has {count} {what}; {} takes at most {most}",
            shader.name,
            gpu.info().name
        ))),
    }
}

/// Finds the first limit that a stage or its workgroup exceeds: what is limited, the number there is, and the limit.
fn first_excess(
    limits: &vk::PhysicalDeviceLimits,
    local_size: [u32; 3],
    bindings: &[Binding],
) -> Option<(&'static str, u32, u32)> {
    let count = |kind| -> u32 { bindings.iter().filter(|b| b.kind == kind).map(|b| b.count).sum() };
    let sampled = limits.max_per_stage_descriptor_sampled_images.min(limits.max_per_stage_descriptor_samplers);
    [
        ("sampled images", count(BindingKind::SampledImage), sampled),
        (
            "storage images",
            count(BindingKind::StorageImage) + count(BindingKind::StorageTexels),
            limits.max_per_stage_descriptor_storage_images,
        ),
        ("uniform blocks", count(BindingKind::UniformBuffer), limits.max_per_stage_descriptor_uniform_buffers),
        ("storage blocks", count(BindingKind::StorageBuffer), limits.max_per_stage_descriptor_storage_buffers),
        ("threads a workgroup", local_size.iter().product(), limits.max_compute_work_group_invocations),
    ]
    .into_iter()
    .find(|(_, count, most)| count > most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::programs::ALL;

    #[test]
    fn no_shader_has_more_than_every_device_pushes() {
        for shader in ALL {
            let descriptors: u32 = shader.bindings.iter().map(|b| b.count).sum();
            assert!(descriptors <= MAX_DESCRIPTORS, "{}: {descriptors}", shader.name);
            assert!(shader.push_constant_size <= 128, "{}: {} bytes", shader.name, shader.push_constant_size);
        }
    }

    #[test]
    fn the_first_limit_that_is_exceeded_is_named() {
        let binding = |kind, count| Binding { name: "b", binding: 0, kind, count };
        let mut limits = vk::PhysicalDeviceLimits {
            max_per_stage_descriptor_sampled_images: 64,
            max_per_stage_descriptor_samplers: 16,
            max_per_stage_descriptor_storage_images: 4,
            max_per_stage_descriptor_uniform_buffers: 12,
            max_per_stage_descriptor_storage_buffers: 4,
            max_compute_work_group_invocations: 128,
            ..vk::PhysicalDeviceLimits::default()
        };
        let bindings = [binding(BindingKind::SampledImage, 16), binding(BindingKind::SampledImage, 3)];
        assert_eq!(first_excess(&limits, [1; 3], &bindings[..1]), None);
        assert_eq!(first_excess(&limits, [1; 3], &bindings), Some(("sampled images", 19, 16)));
        limits.max_per_stage_descriptor_samplers = 64;
        assert_eq!(first_excess(&limits, [16, 16, 1], &bindings), Some(("threads a workgroup", 256, 128)));
        let images = [binding(BindingKind::StorageImage, 5)];
        assert_eq!(first_excess(&limits, [1; 3], &images), Some(("storage images", 5, 4)));
    }
}
