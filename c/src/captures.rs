//! Capture cubes: images of the scene around places.

use crate::border::{Failure, Guarded, SsctResult, copy_struct, create, destroy, guard, sized_structs, to_slice};
use crate::context::SsctContext;
use crate::image::{SsctClipY, SsctImage, to_clip_y, to_image_input};
use crate::live;
use crate::vulkan::VkCommandBuffer;
use ssct::{CaptureCubes, CaptureCubesInfo, CaptureFaceInput};

/// Cubes of images of the scene around places, in which the methods "unified" and "captures" follow the rays that the
/// screen loses. You draw the faces, and hand over each face at least once, and again whenever you like.
pub struct SsctCaptureCubes {
    pub(crate) cubes: Guarded<CaptureCubes>,
}

/// The description of capture cubes that are to be made.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctCaptureCubesInfo {
    /// sizeof(SsctCaptureCubesInfo).
    pub struct_size: usize,
    /// The places of the captures in world space: x, y and z of each place, one after the other.
    pub places: *const f32,
    /// Number of places, 1 to 8.
    pub place_count: u32,
    /// Width and height of each face in texels, 1 to 4096.
    pub side: u32,
    /// The projection that all faces were drawn with. Its angle of view is a quarter turn, and its numbers have the
    /// order of those of `SsctCamera.view_to_clip`.
    pub view_to_clip: [f32; 16],
    /// The place of the top of a face in clip space: one of SSCT_CLIP_Y_*.
    pub clip_y: SsctClipY,
    /// How many frames that renew faces may be under way at once, 1 to 64; 0 stands for 2.
    pub frames_in_flight: u32,
    /// A box in world space outside of which nothing stands, so that rays that leave it end in the sky: six numbers, the least
    /// corner and then the greatest. NULL if there is no such box.
    pub bounds: *const f32,
}

/// A face of a capture.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctCaptureFace {
    /// sizeof(SsctCaptureFace).
    pub struct_size: usize,
    /// The capture's number, from 0.
    pub capture: u32,
    /// The face's number, 0 to 5: +x -x +y -y +z -z. Each face is turned as in a cube map of Vulkan whose directions
    /// are world directions.
    pub face: u32,
    /// The colour of the surfaces in the face, linear, in light that does not depend on the viewer.
    pub color: *const SsctImage,
    /// The depth of the face.
    pub depth: *const SsctImage,
}

sized_structs!(SsctCaptureCubesInfo, SsctCaptureFace);

/// Makes the images of captures, which have no content yet, and writes the new object to `cubes`, or NULL if the call
/// fails.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_capture_cubes_create(
    context: *const SsctContext,
    info: *const SsctCaptureCubesInfo,
    cubes: *mut *mut SsctCaptureCubes,
) -> SsctResult {
    let make = || {
        // SAFETY: the header asks for such pointers.
        let (context, info) = unsafe { (live::read("context", context)?, copy_struct("info", info)?) };
        // SAFETY: the header asks for arrays of three numbers for each place, and of six numbers for the box.
        let (places, bounds) = unsafe {
            (
                to_slice("info.places", info.places.cast::<[f32; 3]>(), info.place_count)?,
                info.bounds.cast::<[[f32; 3]; 2]>().as_ref().copied(),
            )
        };
        let cubes = CaptureCubes::new(
            &context.context,
            &CaptureCubesInfo {
                places,
                side: info.side,
                view_to_clip: info.view_to_clip,
                clip_y: to_clip_y("info.clip_y", info.clip_y)?,
                bounds,
                frames_in_flight: frames_in_flight(info.frames_in_flight)?,
            },
        )?;
        Ok(SsctCaptureCubes { cubes: Guarded::new(cubes) })
    };
    // SAFETY: the header asks for a valid place.
    unsafe { create("cubes", cubes, make) }
}

/// Destroys captures; NULL is allowed. The device must be done with every frame that saw the captures.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_capture_cubes_destroy(cubes: *mut SsctCaptureCubes) {
    // SAFETY: the header asks for an object that is not yet destroyed.
    unsafe { destroy(cubes) };
}

/// Records the commands that copy a face into the captures. Submit the commands before frames that are to see the face.
/// `slot` is the number of this frame among the frames under way, below `SsctCaptureCubesInfo.frames_in_flight`. If the
/// result is SSCT_RESULT_USAGE, nothing is recorded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_capture_cubes_record_face(
    cubes: *mut SsctCaptureCubes,
    commands: VkCommandBuffer,
    slot: u32,
    face: *const SsctCaptureFace,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for such pointers.
        let (mut cubes, input) = unsafe {
            let cubes = live::write("cubes", cubes)?;
            let face = copy_struct("face", face)?;
            let (color, depth) =
                (to_image_input("face.color", face.color, 1)?, to_image_input("face.depth", face.depth, 1)?);
            (cubes, CaptureFaceInput { capture: face.capture as usize, face: face.face as usize, color, depth })
        };
        // SAFETY: the header asks the caller for the same of the command buffer, the slot and the images.
        cubes.cubes.with(|cubes| Ok(unsafe { cubes.record_face(commands, slot as usize, &input) }?))
    })
}

/// Returns the number of frames under way that a caller's field means: 0 stands for 2, and more than 64 is refused.
pub fn frames_in_flight(count: u32) -> Result<usize, Failure> {
    match count {
        0 => Ok(2),
        1..=64 => Ok(count as usize),
        _ => Err(Failure::usage(format!("frames_in_flight is {count}; it must be 1 to 64, or 0 for 2"))),
    }
}
