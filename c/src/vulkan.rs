//! Vulkan's types under their names in C. The header takes these types from `vulkan_core.h`.

pub use ash::vk::{
    Bool32 as VkBool32, CommandBuffer as VkCommandBuffer, Device as VkDevice, DeviceMemory as VkDeviceMemory,
    Extent2D as VkExtent2D, Format as VkFormat, Image as VkImage, ImageLayout as VkImageLayout,
    ImageSubresourceRange as VkImageSubresourceRange, ImageUsageFlags as VkImageUsageFlags, ImageView as VkImageView,
    Instance as VkInstance, MemoryRequirements as VkMemoryRequirements, PhysicalDevice as VkPhysicalDevice,
    PhysicalDeviceFeatures as VkPhysicalDeviceFeatures,
};

use ash::vk;

/// Features of Vulkan 1.2.
pub type VkPhysicalDeviceVulkan12Features = vk::PhysicalDeviceVulkan12Features<'static>;
/// Features of Vulkan 1.3.
pub type VkPhysicalDeviceVulkan13Features = vk::PhysicalDeviceVulkan13Features<'static>;
/// Pipeline stages, which C declares as an integer of 64 bits.
pub type VkPipelineStageFlags2 = u64;
/// Kinds of memory access, which C declares as an integer of 64 bits.
pub type VkAccessFlags2 = u64;
/// The loader's first function, or NULL.
#[allow(non_camel_case_types, reason = "C has it so")]
pub type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;
