//! The door for other renderers: their device, their images, their command buffers. [`Context`] is made of raw handles.
//! [`Reflections`] holds the pipelines and images of one view, and records into a command buffer. [`CaptureCubes`] are
//! images of the scene beyond the screen, and [`Triangles`] its meshes. Nothing here submits, waits or presents.

mod camera;
mod captures;
mod input;
mod reflections;
mod triangles;

pub use camera::CameraInput;
pub use captures::{CaptureCubes, CaptureCubesInfo, CaptureFaceInput};
pub use input::{FactorInput, ImageInput, MotionInput, NormalInput};
pub use reflections::{FrameInput, OutputImage, Recorded, Reflections, ReflectionsInfo};
pub use triangles::{HitTexture, MeshTexture, TriangleMesh, Triangles};

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::device::{DeviceHandles, DeviceInfo};
use crate::methods::{METHODS, MethodInfo};

/// A caller's device for which reflections are recorded. Clones share it; a drop destroys no handle of the caller.
#[derive(Clone)]
pub struct Context {
    gpu: Gpu,
}

impl Context {
    /// Makes a context of the caller's device.
    ///
    /// # Errors
    /// [`Error::NoDevice`](crate::Error::NoDevice) if device or instance has no Vulkan 1.3, if a feature of
    /// [`enable_features`](crate::enable_features) is off, or if the queue family lacks graphics or compute.
    ///
    /// # Safety
    /// The handles belong together, and outlive the context and all that is made with it. The features of
    /// [`DeviceHandles::enabled`] are on. When the last object made with the context is dropped, the device is done
    /// with everything that was recorded with it.
    pub unsafe fn new(device: DeviceHandles) -> Result<Self> {
        // SAFETY: `Gpu::from_handles` has the contract of this function.
        Ok(Self { gpu: unsafe { Gpu::from_handles(device) }? })
    }

    /// Returns name, driver and kind of the device.
    pub fn info(&self) -> &DeviceInfo {
        self.gpu.info()
    }

    /// Whether passes can be timed, which needs a queue family with timestamps.
    pub fn has_timestamps(&self) -> bool {
        self.gpu.has_timestamps()
    }

    /// Bytes of device memory that are allocated with the context; 0 if the caller has an allocator of its own.
    pub fn allocated_bytes(&self) -> u64 {
        self.gpu.allocated_bytes()
    }

    /// Destroys the pipelines that no object uses now. Without this call such pipelines are kept, so that an object
    /// that is made or resized later compiles nothing twice.
    pub fn trim(&self) {
        self.gpu.trim();
    }
}

/// Lists the methods that need no more than a G-buffer: the name of each, as in [`ReflectionsInfo::method`], and a line
/// that describes it. `captures` needs [`CaptureCubes`], too, and `traced` needs [`Triangles`].
pub fn methods() -> impl Iterator<Item = (&'static str, &'static str)> {
    METHODS.iter().filter(|m| m.is_screen_space() || m.takes_captures || m.takes_triangles).map(|m| (m.name, m.summary))
}

/// Finds a method by its name. A method that needs the scene is found, too: [`Reflections::new`] refuses it.
///
/// # Errors
/// [`Error::Usage`] for a name that no method has, with the names of [`methods`].
fn method(name: &str) -> Result<&'static MethodInfo> {
    METHODS.iter().find(|m| m.name == name).ok_or_else(|| {
        let names: Vec<_> = methods().map(|(name, _)| name).collect();
        Error::Usage(format!("no method {name:?}; there is: {}", names.join(", ")))
    })
}
