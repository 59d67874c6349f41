//! Glossy reflections in screen space on Vulkan, for other renderers to build on: a G-buffer goes in, a reflection comes
//! out, recorded into the caller's command buffer. Nothing is submitted, and nothing waits.
//!
//! ```no_run
//! # use ash::vk;
//! # fn example(
//! #     handles: ssct::DeviceHandles, commands: vk::CommandBuffer, world_to_view: [f32; 16], view_to_clip: [f32; 16],
//! #     [depth, normal, color]: [ssct::ImageInput; 3],
//! # ) -> ssct::Result<()> {
//! // Once: the caller's device, and what a view is to show.
//! // SAFETY: the handles belong together and outlive what is made with them.
//! let context = unsafe { ssct::Context::new(handles) }?;
//! let info = ssct::ReflectionsInfo { extent: [1920, 1080], method: "unified", ..Default::default() };
//! let mut reflections = ssct::Reflections::new(&context, &info)?;
//!
//! // In every frame, after lighting:
//! let input = ssct::FrameInput {
//!     slot: 0,
//!     camera: ssct::CameraInput { world_to_view, view_to_clip, clip_y: ssct::ClipY::Down },
//!     depth,
//!     normal: ssct::NormalInput {
//!         image: normal,
//!         space: ssct::NormalSpace::World,
//!         encoding: ssct::NormalEncoding::Octahedral,
//!     },
//!     reflectivity: ssct::FactorInput::Constant(0.5),
//!     roughness: ssct::FactorInput::Constant(0.1),
//!     reflectors: ssct::Reflectors::UNKNOWN,
//!     color,
//!     sky: None,
//!     captures: None,
//!     triangles: None,
//!     triangle_numbers: None,
//!     motion: None,
//!     timed: false,
//!     outputs: ssct::ImageUse::FRAGMENT_SAMPLED,
//! };
//! // SAFETY: the command buffer is recording outside rendering, and is submitted before the next frame's.
//! let recorded = unsafe { reflections.record(commands, &input) }?;
//! println!("{:?}", recorded.composite);
//! # Ok(())
//! # }
//! ```
//!
//! `docs/embedding.md` goes through this example step by step, and `examples/embed` is a whole renderer that uses the crate. The
//! map of this package and of the laboratory beside it is `src/ARCHITECTURE.md`.
//!
//! The modules are public with the feature `internals` alone. The feature is for the laboratory, and promises nothing.

// Some items are used by the laboratory alone, and are unused without the feature.
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
mod methods;
#[cfg(feature = "internals")]
pub mod methods;
#[cfg(not(feature = "internals"))]
mod passes;
#[cfg(feature = "internals")]
pub mod passes;

mod embed;

/// Compiles the examples of docs/embedding.md.
#[cfg(doctest)]
#[doc = include_str!("../docs/embedding.md")]
struct Embedding;

pub use embed::{
    CameraInput, CaptureCubes, CaptureCubesInfo, CaptureFaceInput, Context, FactorInput, FrameInput, HitTexture,
    ImageInput, MeshTexture, MotionInput, NormalInput, OutputImage, Recorded, Reflections, ReflectionsInfo,
    TriangleMesh, Triangles, methods,
};
pub use error::{Error, Result};
pub use gpu::device::{DeviceHandles, DeviceInfo, EnabledFeatures, enable_features};
pub use gpu::memory::{DeviceMemory, MemoryBlock, MemoryPlace};
pub use gpu::sync::ImageUse;
pub use gpu::{PassTime, Skipped};
pub use passes::{Reflectors, WIDE_ABOVE};
pub use ssct_ground::conventions::{ClipY, NormalEncoding, NormalSpace};
pub use ssct_ground::scene::ProjectionKind;
