//! Plain data that every package of the repository shares, without Vulkan: scenes, parameters, conventions, and
//! mathematics. It is made for `ssct` and for the laboratory, and promises nothing to others.

pub mod conventions;
mod error;
pub mod math;
pub mod parameter;
pub mod scene;

pub use error::{Error, Result};
