//! What stands between a window and Vulkan: the images that it shows ([`swapchain`]) and its panel ([`overlay`]). What
//! the window shows, and how it is steered, is in `app/view`.

pub mod overlay;
pub mod swapchain;

pub use overlay::Overlay;
pub use swapchain::{PresentMode, Swapchain};
