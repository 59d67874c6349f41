//! Descriptor sets from pools, which the frames of a slot reuse. Descriptor sets are core Vulkan.
//! VK_KHR_push_descriptor would do without them, but is missing on some drivers, and the validation layers 1.3.239 do
//! not tell instrumented shaders what was pushed (KhronosGroup/Vulkan-ValidationLayers issue 5321).

use crate::error::Result;
use crate::gpu::device::{Gpu, vulkan};
use crate::gpu::limits::MAX_DESCRIPTORS;
use crate::gpu::shader::BindingKind;
use ash::vk;

const SETS_PER_POOL: usize = 64;

/// Descriptors of each kind in a pool, enough for its sets.
const DESCRIPTORS_PER_POOL: u32 = MAX_DESCRIPTORS * SETS_PER_POOL as u32;

/// The descriptor sets of one frame at a time.
pub(in crate::gpu::frame) struct DescriptorSets {
    gpu: Gpu,
    pools: Vec<vk::DescriptorPool>,
    /// Sets taken since the reset.
    taken: usize,
}

impl DescriptorSets {
    /// Starts without a pool; the first set that is taken makes one.
    pub fn new(gpu: &Gpu) -> Self {
        Self { gpu: gpu.clone(), pools: Vec::new(), taken: 0 }
    }

    /// Takes every set back.
    ///
    /// # Safety
    /// No submission that reads a set is under way.
    pub unsafe fn reset(&mut self) -> Result<()> {
        for pool in &self.pools {
            // SAFETY: by the contract, no submission reads a set of the pool.
            unsafe { self.gpu.raw().reset_descriptor_pool(*pool, vk::DescriptorPoolResetFlags::empty()) }
                .map_err(vulkan("vkResetDescriptorPool"))?;
        }
        self.taken = 0;
        Ok(())
    }

    /// Takes a set of a layout, which belongs to this frame until [`Self::reset`].
    pub fn take(&mut self, layout: vk::DescriptorSetLayout, name: &str) -> Result<vk::DescriptorSet> {
        if self.taken == SETS_PER_POOL * self.pools.len() {
            self.pools.push(self.new_pool()?);
        }
        let layouts = [layout];
        let pool = self.pools[self.taken / SETS_PER_POOL];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: pool and layout are alive.
        let sets = unsafe { self.gpu.raw().allocate_descriptor_sets(&info) }
            .map_err(vulkan(format!("vkAllocateDescriptorSets for {name}")))?;
        self.taken += 1;
        Ok(sets[0])
    }

    /// Makes a pool with room for [`SETS_PER_POOL`] sets.
    fn new_pool(&self) -> Result<vk::DescriptorPool> {
        use BindingKind as K;
        let pool_size =
            |kind: K| vk::DescriptorPoolSize { ty: kind.descriptor_type(), descriptor_count: DESCRIPTORS_PER_POOL };
        let mut sizes = [K::SampledImage, K::StorageImage, K::StorageTexels, K::UniformBuffer, K::StorageBuffer]
            .map(pool_size)
            .to_vec();
        // A set binds one structure at most.
        let rays = vk::DescriptorPoolSize { descriptor_count: SETS_PER_POOL as u32, ..pool_size(K::RayStructure) };
        sizes.extend(self.gpu.has_ray_queries().then_some(rays));
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS_PER_POOL as u32).pool_sizes(&sizes);
        // SAFETY: the create info lives through the call; destroyed in `drop`.
        unsafe { self.gpu.raw().create_descriptor_pool(&info, None) }.map_err(vulkan("vkCreateDescriptorPool"))
    }
}

impl Drop for DescriptorSets {
    fn drop(&mut self) {
        for pool in &self.pools {
            // SAFETY: submissions are waited for before their context is dropped.
            unsafe { self.gpu.raw().destroy_descriptor_pool(*pool, None) };
        }
    }
}
