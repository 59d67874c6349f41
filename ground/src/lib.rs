//! Plain data that every package of the repository shares, without Vulkan: scenes, parameters, conventions, and
//! mathematics. The crate is made for `ssct` and the laboratory, and promises nothing to others.

pub mod conventions;
mod error;
pub mod math;
pub mod parameter;
pub mod scene;

pub use error::{Error, Result};
