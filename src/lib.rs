//! Glossy reflections in screen space on Vulkan, for other engines to build on: a G-buffer goes in, a reflection comes
//! out, and every pass is timed. The map of this package and of the laboratory beside it is `src/ARCHITECTURE.md`.
//!
//! The modules are public with the feature `internals` alone. It is for the laboratory, and promises nothing.

// What the laboratory alone asks for is unused without it.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unused_imports))]

#[cfg(not(feature = "internals"))]
mod error;
#[cfg(feature = "internals")]
pub mod error;
#[cfg(not(feature = "internals"))]
mod gpu;
#[cfg(feature = "internals")]
pub mod gpu;
#[cfg(not(feature = "internals"))]
mod math;
#[cfg(feature = "internals")]
pub mod math;
#[cfg(not(feature = "internals"))]
mod methods;
#[cfg(feature = "internals")]
pub mod methods;
#[cfg(not(feature = "internals"))]
mod parameter;
#[cfg(feature = "internals")]
pub mod parameter;
#[cfg(not(feature = "internals"))]
mod passes;
#[cfg(feature = "internals")]
pub mod passes;
#[cfg(not(feature = "internals"))]
mod scene;
#[cfg(feature = "internals")]
pub mod scene;

mod embed;

pub use embed::{
    CameraInput, CaptureFaceInput, Captures, CapturesInfo, ClipY, Context, FactorInput, FrameInput, ImageInput,
    NormalEncoding, NormalInput, NormalSpace, OutputImage, Recorded, Reflections, ReflectionsInfo, enable_features, methods,
};
pub use error::{Error, Result};
pub use gpu::device::{DeviceHandles, DeviceInfo, EnabledFeatures};
pub use gpu::memory::{DeviceMemory, MemoryBlock, Place};
pub use gpu::sync::ImageUse;
pub use gpu::{PassTime, Skipped};
