//! What stands between a window and Vulkan: the images that it shows ([`swapchain`]) and its panel ([`overlay`]). It knows
//! nothing about what the window shows.

pub mod overlay;
pub mod swapchain;

pub use overlay::Overlay;
pub use swapchain::{PresentMode, Swapchain};
