//! Screen-space cone tracing for glossy reflections, on Vulkan.

pub mod error;
pub mod scene;
