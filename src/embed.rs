//! The door for other renderers: their device, their images, their command buffers. [`Context`] is made of raw handles,
//! [`Reflections`] holds what one view needs and records into a command buffer, [`CaptureCubes`] holds images of the scene
//! around places that the screen does not show, [`Triangles`] the scene's meshes. Nothing here submits, waits or presents.

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

/// A device of the caller's that reflections are recorded for. Clones share it. It destroys nothing of the caller's.
#[derive(Clone)]
pub struct Context {
    gpu: Gpu,
}

impl Context {
    /// Takes a device over as it is.
    ///
    /// # Errors
    /// [`Error::NoDevice`](crate::Error::NoDevice) with what is missing: Vulkan 1.3 on the device or in the version that the
    /// instance was made for, a feature of
    /// [`enable_features`](crate::enable_features) that is not on, or graphics or compute in the queue family.
    ///
    /// # Safety
    /// The handles belong together, and outlive the context and all that is made with it. What
    /// [`DeviceHandles::enabled`] says to be on is on. When the last object made with the context is dropped, the device
    /// is done with everything that was recorded with it.
    pub unsafe fn new(device: DeviceHandles) -> Result<Self> {
        // SAFETY: by the contract.
        Ok(Self { gpu: unsafe { Gpu::of_others(device) }? })
    }

    /// What the device calls itself.
    pub fn info(&self) -> &DeviceInfo {
        self.gpu.info()
    }

    /// Whether passes can be timed: the queue family has timestamps.
    pub fn has_timestamps(&self) -> bool {
        self.gpu.has_timestamps()
    }

    /// Bytes of device memory that are allocated with the context; 0 with an allocator of the caller's, who knows them.
    pub fn allocated_bytes(&self) -> u64 {
        self.gpu.allocated_bytes()
    }

    /// Destroys the pipelines that nothing uses now. Otherwise they are kept, so that what is made or resized next
    /// compiles nothing twice.
    pub fn trim(&self) {
        self.gpu.trim();
    }
}

/// The methods that need no more than a G-buffer, as [`ReflectionsInfo::method`] names them: their names, and a line on
/// each. `captures` needs [`CaptureCubes`], too, and `traced` needs [`Triangles`].
pub fn methods() -> impl Iterator<Item = (&'static str, &'static str)> {
    METHODS.iter().filter(|m| m.is_screen_space() || m.takes_captures || m.takes_triangles).map(|m| (m.name, m.summary))
}

/// The method of a name. One that needs the scene is refused where it is made.
///
/// # Errors
/// [`Error::Usage`] for a name that no method has, with the names of [`methods`].
fn method(name: &str) -> Result<&'static MethodInfo> {
    METHODS.iter().find(|m| m.name == name).ok_or_else(|| {
        let names: Vec<_> = methods().map(|(name, _)| name).collect();
        Error::Usage(format!("no method {name:?}; there is: {}", names.join(", ")))
    })
}
