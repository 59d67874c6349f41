//! The layer between a window and Vulkan: the images that the window shows ([`swapchain`]), and the drawing of its
//! panel ([`overlay`]). This layer does not know the content of the images.

pub mod overlay;
pub mod swapchain;

pub use overlay::Overlay;
pub use swapchain::{PresentMode, Swapchain};
