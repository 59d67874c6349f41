//! The reflections of one view.

mod reported;

use crate::border::{
    Failure, Guarded, Outcome, SsctResult, copy_struct, create, destroy, guard, read_text, sized_structs, stated_size,
    to_c_text, to_reference_mut, to_slice,
};
use crate::captures::{SsctCaptureCubes, frames_in_flight};
use crate::context::SsctContext;
use crate::image::{
    SsctCamera, SsctFactor, SsctImage, SsctImageUse, SsctMotion, SsctNormals, none_of, to_camera_input,
    to_factor_input, to_image_input, to_motion_input, to_normal_input,
};
use crate::live;
use crate::triangles::SsctTriangles;
use crate::vulkan::{VkBool32, VkCommandBuffer, VkExtent2D, VkFormat, VkImage, VkImageView};
use ash::vk;
use reported::{Report, Times};
use ssct::{CaptureCubes, FrameInput, ProjectionKind, Reflections, ReflectionsInfo, Reflectors, Triangles};
use std::ffi::{CString, c_char};

/// The pipelines, images and uniform memory that reflect one view in every frame.
pub struct SsctReflections {
    reflections: Guarded<Reflections>,
    /// The texts and arrays that the last frame's `SsctRecorded` points to.
    recorded: Report,
    /// The times to which the last call of `ssct_reflections_times` returned a pointer.
    times: Times,
}

/// The images that are produced: SSCT_OUTPUT_*, combined by `|`.
pub type SsctOutputs = u32;

/// Lit colour plus reflections.
pub const SSCT_OUTPUT_COMPOSITE: SsctOutputs = 1;
/// The reflection alone, for a renderer that adds it up itself.
pub const SSCT_OUTPUT_REFLECTION: SsctOutputs = 2;
/// The place where each ray ended, if the method can say it.
pub const SSCT_OUTPUT_HITS: SsctOutputs = 4;

/// The kinds of reflecting surface that a frame may have, which you know from the materials that you drew:
/// SSCT_REFLECTORS_*, combined by `|`. The passes for a kind that is absent are left out.
pub type SsctReflectors = u32;

/// You do not know the kinds, and the frame may have every kind. This flag is right for every frame.
pub const SSCT_REFLECTORS_UNKNOWN: SsctReflectors = 0;
/// There may be mirrors: surfaces that reflect with roughness 0.
pub const SSCT_REFLECTORS_MIRRORS: SsctReflectors = 1;
/// There may be surfaces with narrow lobes: roughness above 0, up to 0.2f.
pub const SSCT_REFLECTORS_NARROW: SsctReflectors = 2;
/// There may be surfaces with wide lobes: roughness above 0.2f.
pub const SSCT_REFLECTORS_WIDE: SsctReflectors = 4;
/// Every lit surface reflects, so that every pixel reflects except those that show the sky.
pub const SSCT_REFLECTORS_EVERYWHERE: SsctReflectors = 8;
/// Nothing reflects. This flag stands alone, and is not combined with others.
pub const SSCT_REFLECTORS_NONE: SsctReflectors = 16;

// Checks that 0.2f in the comments above is `WIDE_ABOVE`. The header has no such constant, since it would be of the
// type double in C.
const _: () = assert!(ssct::WIDE_ABOVE == 0.2);

/// The projection of a camera: one of SSCT_PROJECTION_*.
pub type SsctProjection = u32;

/// All rays of sight leave from the eye.
pub const SSCT_PROJECTION_PERSPECTIVE: SsctProjection = 0;
/// All rays of sight are parallel.
pub const SSCT_PROJECTION_ORTHOGRAPHIC: SsctProjection = 1;

/// A parameter of a method and its value, such as { "fade", "off" }; docs/options.md lists all parameters. "preset" is
/// a parameter, too.
#[repr(C)]
pub struct SsctParameter {
    /// The parameter's name.
    pub name: *const c_char,
    /// The parameter's value as text.
    pub value: *const c_char,
}

/// The description of reflections that are to be made: size, method, inputs and outputs.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctReflectionsInfo {
    /// sizeof(SsctReflectionsInfo).
    pub struct_size: usize,
    /// Width and height of the view in pixels.
    pub extent: VkExtent2D,
    /// A method of `ssct_methods`; NULL for "unified".
    pub method: *const c_char,
    /// Parameters of the method. A parameter that is not given has its published value.
    pub parameters: *const SsctParameter,
    /// Number of parameters.
    pub parameter_count: u32,
    /// Width and height of the faces of the capture cubes that every frame is given; 0 for frames without captures.
    pub capture_side: u32,
    /// The images that are produced; 0 for composite and reflection.
    pub outputs: SsctOutputs,
    /// Number of frames that may be under way at once; 0 for 2.
    pub frames_in_flight: u32,
    /// Triangles that are made like those of every later frame; NULL for frames without triangles. Reflections have
    /// captures or triangles, and not both.
    pub triangles: *const SsctTriangles,
    /// The projection of every frame's camera.
    pub projection: SsctProjection,
}

/// The inputs of a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctFrame {
    /// sizeof(SsctFrame).
    pub struct_size: usize,
    /// The number of this frame among the frames under way, below `SsctReflectionsInfo.frames_in_flight`. The device must be done
    /// with the frame that was recorded with the same number before.
    pub slot: u32,
    /// Whether each pass is timed (`ssct_reflections_times`). The passes of a timed frame do not overlap.
    pub timed: VkBool32,
    /// The camera that the images were drawn with.
    pub camera: *const SsctCamera,
    /// Depth: a depth image, or a colour image with depth in red.
    pub depth: *const SsctImage,
    /// Normals.
    pub normals: *const SsctNormals,
    /// The share of the light that is reflected.
    pub reflectivity: *const SsctFactor,
    /// Roughness; 0 is a mirror.
    pub roughness: *const SsctFactor,
    /// Lit colour, linear, without reflections.
    pub color: *const SsctImage,
    /// A cube map of the sky's light, in world axes. Its view is an array of the six faces
    /// (VK_IMAGE_VIEW_TYPE_2D_ARRAY). A ray gets this light if captures or triangles say that the ray ends in the sky.
    /// With NULL such rays miss. Without captures and triangles, every ray that leaves the screen misses.
    pub sky: *const SsctImage,
    /// Images of the scene around places, for rays that the screen loses; NULL where `capture_side` is 0.
    pub captures: *const SsctCaptureCubes,
    /// Triangles of the scene, for rays that the screen loses; NULL where `SsctReflectionsInfo.triangles` is NULL.
    pub triangles: *const SsctTriangles,
    /// The number of the triangle that each pixel shows, counted over all meshes in their order, or UINT32_MAX for
    /// none. The image is R32_UINT, made with VK_IMAGE_USAGE_STORAGE_BIT. With NULL, some rays hit the very surface
    /// that they start from.
    pub triangle_numbers: *const SsctImage,
    /// The kinds of reflecting surface that the frame may have.
    pub reflectors: SsctReflectors,
    /// How you use the outputs next.
    pub outputs: SsctImageUse,
    /// The motion of surfaces since the frame that was recorded before, for the parameter "history"; NULL if the motion
    /// is not known, or if nothing but the camera moved.
    pub motion: *const SsctMotion,
}

/// An image that the library made and owns. The handle stays the same in every frame, until the reflections are resized
/// or destroyed. The image can be sampled, and copied from.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctOutputImage {
    /// The image; VK_NULL_HANDLE if there is none.
    pub image: VkImage,
    /// A view of the image's first level.
    pub view: VkImageView,
    /// The image's format.
    pub format: VkFormat,
    /// Width and height in pixels.
    pub extent: VkExtent2D,
}

/// A pass that a frame leaves out.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctSkipped {
    /// The pass's label.
    pub pass: *const c_char,
    /// The reason, in a clause.
    pub why: *const c_char,
}

/// The outputs and passes of a recorded frame. Texts and arrays stay until the next frame of the same reflections is recorded, or
/// the reflections are destroyed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctRecorded {
    /// sizeof(SsctRecorded).
    pub struct_size: usize,
    /// Lit colour plus reflections, linear, R16G16B16A16_SFLOAT. There is no such image if
    /// `SsctReflectionsInfo.outputs` leaves it out.
    pub composite: SsctOutputImage,
    /// The reflection in rgb, before reflectivity, and its fade in alpha: 0 where the method has no reflection, less
    /// than 1 where the reflection fades out. R16G16B16A16_SFLOAT. There is no such image if
    /// `SsctReflectionsInfo.outputs` leaves it out, or if nothing reflects.
    pub reflection: SsctOutputImage,
    /// The place where each ray ended: texture coordinates, standard depth, and a code that says how the ray ended
    /// (`PATH_*` of shaders-glsl/common/constants.glsl). R32G32B32A32_SFLOAT. There is no such image if
    /// `SsctReflectionsInfo.outputs` leaves it out, or if the method does not tell where rays end.
    pub hits: SsctOutputImage,
    /// The passes that were recorded, in order.
    pub passes: *const *const c_char,
    /// Number of passes.
    pub pass_count: u32,
    /// Number of passes that this frame leaves out.
    pub skipped_count: u32,
    /// The passes that this frame leaves out, and why.
    pub skipped: *const SsctSkipped,
}

/// How long a pass took.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct SsctPassTime {
    /// The pass's label; a level of a chain follows a slash, as in "hi-z/3".
    pub name: *const c_char,
    /// Milliseconds that the pass took.
    pub ms: f64,
    /// Milliseconds from the frame's first timestamp to the first timestamp of the pass.
    pub start_ms: f64,
    /// Whether the pass counts towards the method's total.
    pub counted: bool,
}

sized_structs!(SsctReflectionsInfo, SsctFrame, SsctRecorded);

/// Makes all that the frames of a view need, and writes the new object to `reflections`, or NULL if the call fails.
/// Nothing is submitted.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_reflections_create(
    context: *const SsctContext,
    info: *const SsctReflectionsInfo,
    reflections: *mut *mut SsctReflections,
) -> SsctResult {
    let make = || {
        // SAFETY: the header asks for such pointers.
        unsafe {
            let (context, info) = (live::read("context", context)?, copy_struct("info", info)?);
            // While the lock lives, no other call changes or destroys the triangles.
            let _lock = live::read_optional("info.triangles", info.triangles)?;
            let method = if info.method.is_null() { "unified" } else { read_text("info.method", info.method)? };
            let to_name_and_value =
                |p: &SsctParameter| Ok((read_text("parameter.name", p.name)?, read_text("parameter.value", p.value)?));
            let parameters = to_slice("info.parameters", info.parameters, info.parameter_count)?;
            let parameters: Vec<_> = parameters.iter().map(to_name_and_value).collect::<Outcome<_>>()?;
            create_reflections(&context, &info, method, (&parameters, usable_triangles(info.triangles)?))
        }
    };
    // SAFETY: the header asks for a valid place.
    unsafe { create("reflections", reflections, make) }
}

/// Makes reflections from the caller's description `info`. Its pointers were already read into `method`, `parameters`
/// (names and values) and `triangles`.
fn create_reflections(
    context: &SsctContext,
    info: &SsctReflectionsInfo,
    method: &str,
    (parameters, triangles): (&[(&str, &str)], Option<&Triangles>),
) -> Outcome<SsctReflections> {
    let all_outputs = SSCT_OUTPUT_COMPOSITE | SSCT_OUTPUT_REFLECTION | SSCT_OUTPUT_HITS;
    if info.outputs & !all_outputs != 0 {
        return Err(Failure::usage(format!(
            "info.outputs is {}, which has bits that are none of SSCT_OUTPUT_*",
            info.outputs
        )));
    }
    let outputs = if info.outputs == 0 { SSCT_OUTPUT_COMPOSITE | SSCT_OUTPUT_REFLECTION } else { info.outputs };
    let reflections = Reflections::new(
        &context.context,
        &ReflectionsInfo {
            extent: [info.extent.width, info.extent.height],
            projection: to_projection(info.projection)?,
            method,
            parameters,
            captures: Some(info.capture_side).filter(|side| *side != 0),
            triangles,
            composite: outputs & SSCT_OUTPUT_COMPOSITE != 0,
            reflection: outputs & SSCT_OUTPUT_REFLECTION != 0,
            hits: outputs & SSCT_OUTPUT_HITS != 0,
            frames_in_flight: frames_in_flight(info.frames_in_flight)?,
        },
    )?;
    Ok(SsctReflections { reflections: Guarded::new(reflections), recorded: Report::default(), times: Times::default() })
}

/// Converts a constant of the header to the Rust interface's type; fails for a number that is none of
/// SSCT_PROJECTION_*.
fn to_projection(value: SsctProjection) -> Outcome<ProjectionKind> {
    match value {
        SSCT_PROJECTION_PERSPECTIVE => Ok(ProjectionKind::Perspective),
        SSCT_PROJECTION_ORTHOGRAPHIC => Ok(ProjectionKind::Orthographic),
        other => Err(none_of("SSCT_PROJECTION_*", "info.projection", other)),
    }
}

/// Destroys reflections; NULL is allowed. The device must be done with every frame that was recorded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_reflections_destroy(reflections: *mut SsctReflections) {
    // SAFETY: the header asks for an object that is not yet destroyed.
    unsafe { destroy(reflections) };
}

/// Makes images of another size. The device must be done with every frame that was recorded. If the call fails, the old size stays.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_reflections_resize(reflections: *mut SsctReflections, extent: VkExtent2D) -> SsctResult {
    // SAFETY: the header asks for such a pointer.
    unsafe { change_reflections(reflections, |r| Ok(r.resize([extent.width, extent.height])?)) }
}

/// Forgets the frames that the parameter "history" averages, so that the next frame stands alone. Call it after a cut, and after a
/// command buffer was thrown away.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_reflections_restart_history(reflections: *mut SsctReflections) -> SsctResult {
    let restart = |reflections: &mut Reflections| {
        reflections.restart_history();
        Ok(())
    };
    // SAFETY: the header asks for such a pointer.
    unsafe { change_reflections(reflections, restart) }
}

/// Records a frame's reflections into a command buffer. The call submits nothing and does not wait. After one frame in
/// every slot, the call allocates nothing on the device. The call writes the frame's outputs and passes to `recorded`,
/// whose `struct_size` you set; `recorded` may be NULL. If the result is SSCT_RESULT_USAGE, nothing is recorded. After
/// another failure, throw the command buffer away.
///
/// - The command buffer is recording, outside rendering, for a queue of the context's family.
/// - The handles of the inputs belong to the context's device, are as their fields describe them, and live until the
///   device is done. The commands that write the images were submitted before.
/// - The frame that was recorded with the same slot before is no longer under way.
/// - Frames of one object are submitted in the order in which they were recorded, to one queue. The faces of the
///   captures that they see are submitted to the same queue, in order. A command buffer is submitted once, or thrown
///   away before another is recorded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_reflections_record(
    reflections: *mut SsctReflections,
    commands: VkCommandBuffer,
    frame: *const SsctFrame,
    recorded: *mut SsctRecorded,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for such pointers.
        let (mut object, _locks, input, struct_size) = unsafe {
            let frame = copy_struct("frame", frame)?;
            let object = live::write("reflections", reflections)?;
            // While the locks live, no other call changes or destroys the captures and triangles of the frame.
            let captures_lock = live::read_optional("frame.captures", frame.captures)?;
            let locks = (captures_lock, live::read_optional("frame.triangles", frame.triangles)?);
            let struct_size = if recorded.is_null() { None } else { Some(stated_size("recorded", recorded)?) };
            (object, locks, to_frame_input(&frame)?, struct_size)
        };
        if commands == VkCommandBuffer::null() {
            return Err(Failure::usage("the argument commands is a null handle"));
        }
        // SAFETY: the header asks the caller for the same of the command buffer, the slot and the images.
        let output = object.reflections.with(|r| Ok(unsafe { r.record(commands, &input) }?))?;
        object.recorded = Report::new(&output);
        if let Some(struct_size) = struct_size {
            // SAFETY: the header asks for a struct of the stated size, which is at least the size of `SsctRecorded`.
            unsafe { recorded.write(object.recorded.to_c_struct(&output, struct_size)) };
        }
        Ok(())
    })
}

/// Writes to `times` an array of how long each pass of the last frame of a slot took, and to `count` the array's
/// length, which is 0 if the frame was not timed. The result is SSCT_RESULT_NOT_READY if the device is not done with
/// the frame yet. The array stays until the next call of this function, or until the reflections are destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ssct_reflections_times(
    reflections: *mut SsctReflections,
    slot: u32,
    times: *mut *const SsctPassTime,
    count: *mut u32,
) -> SsctResult {
    guard(|| {
        // SAFETY: the header asks for such pointers.
        let (mut object, times, count) = unsafe {
            (
                live::write("reflections", reflections)?,
                to_reference_mut("times", times)?,
                to_reference_mut("count", count)?,
            )
        };
        let pass_times = object.reflections.with(|r| Ok(r.times(slot as usize)?))?;
        let names: Vec<_> = pass_times.iter().map(|time| to_c_text(&time.name)).collect();
        let to_row = |(time, name): (&ssct::PassTime, &CString)| SsctPassTime {
            name: name.as_ptr(),
            ms: time.ms,
            start_ms: time.start_ms,
            counted: time.counted,
        };
        let rows = pass_times.iter().zip(&names).map(to_row).collect();
        object.times = Times { _names: names, rows };
        (*times, *count) = (object.times.rows.as_ptr(), object.times.rows.len() as u32);
        Ok(())
    })
}

/// Runs a function that changes reflections, and returns the code of the result.
///
/// # Safety
/// The contract is that of [`live::write`].
unsafe fn change_reflections(
    reflections: *mut SsctReflections,
    run: impl FnOnce(&mut Reflections) -> Outcome<()>,
) -> SsctResult {
    // SAFETY: the caller keeps to the contract of this function.
    guard(|| unsafe { live::write("reflections", reflections) }?.reflections.with(run))
}

/// Copies the caller's description of a frame into the Rust interface's type.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
unsafe fn to_frame_input<'a>(frame: &SsctFrame) -> Outcome<FrameInput<'a>> {
    // SAFETY: the caller keeps to the contract of this function.
    unsafe {
        Ok(FrameInput {
            slot: frame.slot as usize,
            camera: to_camera_input(frame.camera)?,
            depth: to_image_input("frame.depth", frame.depth, 1)?,
            normal: to_normal_input(frame.normals)?,
            reflectivity: to_factor_input("frame.reflectivity", frame.reflectivity)?,
            roughness: to_factor_input("frame.roughness", frame.roughness)?,
            reflectors: to_reflectors(frame.reflectors)?,
            color: to_image_input("frame.color", frame.color, 1)?,
            sky: if frame.sky.is_null() { None } else { Some(to_image_input("frame.sky", frame.sky, 6)?) },
            captures: usable_captures(frame.captures)?,
            triangles: usable_triangles(frame.triangles)?,
            triangle_numbers: match frame.triangle_numbers.is_null() {
                true => None,
                false => Some(to_image_input("frame.triangle_numbers", frame.triangle_numbers, 1)?),
            },
            motion: to_motion_input("frame.motion", frame.motion)?,
            timed: frame.timed != vk::FALSE,
            outputs: frame.outputs.to_image_use(),
        })
    }
}

/// Returns the captures behind a frame's pointer; `None` for NULL. Fails if an earlier fault left them unusable.
///
/// # Safety
/// The pointer is NULL, or valid for as long as the result is used.
unsafe fn usable_captures<'a>(pointer: *const SsctCaptureCubes) -> Outcome<Option<&'a CaptureCubes>> {
    // SAFETY: the caller keeps to the contract of this function.
    unsafe { pointer.as_ref() }.map(|captures| captures.cubes.get()).transpose()
}

/// Returns the triangles behind a frame's pointer; `None` for NULL. Fails if an earlier fault left them unusable.
///
/// # Safety
/// The contract is that of [`usable_captures`].
unsafe fn usable_triangles<'a>(pointer: *const SsctTriangles) -> Outcome<Option<&'a Triangles>> {
    // SAFETY: the caller keeps to the contract of this function.
    unsafe { pointer.as_ref() }.map(|triangles| triangles.triangles.get()).transpose()
}

/// Converts the header's flags to the Rust interface's type; fails for flags that do not go together.
fn to_reflectors(flags: SsctReflectors) -> Outcome<Reflectors> {
    let has = |flag| flags & flag != 0;
    match flags {
        SSCT_REFLECTORS_UNKNOWN => Ok(Reflectors::UNKNOWN),
        SSCT_REFLECTORS_NONE => Ok(Reflectors::default()),
        1..SSCT_REFLECTORS_NONE => Ok(Reflectors {
            mirrors: has(SSCT_REFLECTORS_MIRRORS),
            narrow: has(SSCT_REFLECTORS_NARROW),
            wide: has(SSCT_REFLECTORS_WIDE),
            everywhere: has(SSCT_REFLECTORS_EVERYWHERE),
        }),
        _ => Err(Failure::usage(format!(
            "frame.reflectors is {flags}; it is SSCT_REFLECTORS_NONE alone, or other SSCT_REFLECTORS_* combined"
        ))),
    }
}
