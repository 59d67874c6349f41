//! The layer between a window and Vulkan: the images that the window shows ([`swapchain`]) and its panel ([`overlay`]). This layer knows
//! nothing about what the images show.

pub mod overlay;
pub mod swapchain;

pub use overlay::Overlay;
pub use swapchain::{PresentMode, Swapchain};
