//! The few samplers that there are.

use crate::error::{Error, Result};
use ash::vk;

/// The samplers that exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// Nearest texel and level, clamped: Hi-Z.
    NearestClamp,
    /// Trilinear, clamped: colour and visibility chains.
    TrilinearClamp,
    /// Trilinear with anisotropy where there is any, repeating: material maps.
    Material,
}

/// One object per [`Sampler`].
pub(crate) struct Samplers([vk::Sampler; 3]);

impl Samplers {
    /// Makes all samplers; if one fails, destroys those that were made.
    pub(super) fn new(device: &ash::Device, anisotropy: bool, limits: &vk::PhysicalDeviceLimits) -> Result<Self> {
        use vk::{Filter as F, SamplerAddressMode as A, SamplerMipmapMode as M};
        let mut samplers = Self([vk::Sampler::null(); 3]);
        let kinds = [
            (F::NEAREST, M::NEAREST, A::CLAMP_TO_EDGE, false),
            (F::LINEAR, M::LINEAR, A::CLAMP_TO_EDGE, false),
            (F::LINEAR, M::LINEAR, A::REPEAT, anisotropy),
        ];
        for (i, (filter, mipmap, address, anisotropy)) in kinds.into_iter().enumerate() {
            let info = vk::SamplerCreateInfo::default()
                .mag_filter(filter)
                .min_filter(filter)
                .mipmap_mode(mipmap)
                .address_mode_u(address)
                .address_mode_v(address)
                .address_mode_w(address)
                .anisotropy_enable(anisotropy)
                .max_anisotropy(if anisotropy { limits.max_sampler_anisotropy.min(8.0) } else { 1.0 })
                .max_lod(vk::LOD_CLAMP_NONE);
            // SAFETY: the create info is complete; destroyed by `destroy`.
            match unsafe { device.create_sampler(&info, None) } {
                Ok(sampler) => samplers.0[i] = sampler,
                Err(result) => {
                    // SAFETY: nothing uses the samplers yet; null is allowed.
                    unsafe { samplers.destroy(device) };
                    return Err(Error::Vulkan { what: "vkCreateSampler".into(), result });
                }
            }
        }
        Ok(samplers)
    }

    pub(super) fn get(&self, sampler: Sampler) -> vk::Sampler {
        self.0[sampler as usize]
    }

    /// # Safety
    /// No submission uses the samplers any more.
    pub(super) unsafe fn destroy(&self, device: &ash::Device) {
        for sampler in self.0 {
            // SAFETY: by the contract, no submission uses the sampler.
            unsafe { device.destroy_sampler(sampler, None) };
        }
    }
}
