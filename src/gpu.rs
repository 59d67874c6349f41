//! Vulkan, and nothing about reflections: device, memory, images, synchronisation, pipelines, the frame with its
//! timestamps, and reading results back.
//!
//! A [`Gpu`] is a cheap handle to a device. Every resource keeps one, so that resources destroy themselves. A
//! [`FrameContext`] records one frame at a time; `frame.rs` gives each pass its label, its timestamps and its barriers.

pub mod device;
pub mod executables;
pub mod frame;
#[cfg(feature = "reload")]
pub mod glsl;
pub mod image;
#[cfg(feature = "reload")]
pub mod interface;
mod limits;
#[cfg(feature = "reload")]
pub mod loose;
pub mod memory;
pub mod pipeline;
mod pipelines;
pub mod pixels;
pub mod program;
pub mod programs;
pub mod ray_structure;
pub mod readback;
pub mod sampler;
pub mod shader;
#[cfg(feature = "reload")]
pub mod sources;
pub mod sync;
pub mod testing;
pub mod timing;
pub mod validation;

pub use device::{DeviceInfo, DeviceQuery, Gpu, Precision};
pub use frame::{Frame, FrameContext, FrameReport, Resource, Skipped, Target};
pub use image::{Image, ImageDesc, ImagePool, ImageSlice};
pub use memory::{Buffer, TexelBuffer};
pub use pipeline::{ComputePipeline, GraphicsPipeline};
pub use pixels::{PixelPipeline, ShaderStage, StoringPipeline};
pub use program::Sampled;
pub use ray_structure::RayStructure;
pub use readback::Pixels;
pub use sampler::Sampler;
pub use testing::watch::{Fault, Watch};
pub use timing::PassTime;
