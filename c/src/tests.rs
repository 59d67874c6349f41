//! Tests that use the interface as a C program does, on a device under the validation layers. The tests cover what the
//! program in `examples/c` does not use, and what the library refuses.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::undocumented_unsafe_blocks,
    reason = "a program's own handles"
)]

mod misuse;
mod program;

use crate::border::{SsctResult, ssct_last_error};
use crate::captures::*;
use crate::context::*;
use crate::image::*;
use crate::memory::*;
use crate::reflections::*;
use crate::triangles::*;
use ash::vk::{self, Handle};
use program::Program;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::{null, null_mut};

/// Makes a struct of zeros except for its size, as `{ .struct_size = sizeof s }` does in C.
fn sized<T: Copy>(size: usize) -> T {
    let mut value = std::mem::MaybeUninit::<T>::zeroed();
    // Every struct of the interface may consist of zeros, and its first field is its size.
    unsafe {
        value.as_mut_ptr().cast::<usize>().write(size);
        value.assume_init()
    }
}

/// Returns the sentence of `ssct_last_error`.
fn last_sentence() -> String {
    unsafe { CStr::from_ptr(ssct_last_error()) }.to_str().unwrap().to_owned()
}

/// Asserts that a call succeeded.
#[track_caller]
fn assert_ok(result: SsctResult) {
    assert_eq!(result, SsctResult::Ok, "{}", last_sentence());
}

/// Asserts that a call failed with a code, and that the sentence on the failure has some words.
#[track_caller]
fn assert_failed(result: SsctResult, code: SsctResult, words: &str) {
    assert!(result == code && last_sentence().contains(words), "{result:?}: {}", last_sentence());
}

/// Asserts that a call failed because an argument is wrong, and that the sentence on the failure has some words.
#[track_caller]
fn assert_refused(result: SsctResult, words: &str) {
    assert_failed(result, SsctResult::Usage, words);
}

/// A projection with an angle of view of a quarter turn, along +z, with y up, and reversed depth without a far plane.
const CLIP: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 0., 1., 0., 0., 0.1, 0.];
/// The identity: view space is world space.
const WORLD: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

/// Width and height of the reflections in pixels.
const SIDE: u32 = 48;

/// Describes reflections of a size, with the default method.
fn view(side: u32) -> SsctReflectionsInfo {
    let extent = vk::Extent2D { width: side, height: side };
    SsctReflectionsInfo { extent, ..sized(size_of::<SsctReflectionsInfo>()) }
}

/// Makes reflections, and asserts that the call succeeds.
fn make_reflections(context: *const SsctContext, info: &SsctReflectionsInfo) -> *mut SsctReflections {
    let mut reflections = null_mut();
    assert_ok(unsafe { ssct_reflections_create(context, info, &mut reflections) });
    reflections
}

/// Calls `ssct_reflections_create`, and asserts that the call writes NULL exactly if it fails.
fn create(context: *const SsctContext, info: &SsctReflectionsInfo) -> SsctResult {
    let mut reflections = std::ptr::dangling_mut();
    let result = unsafe { ssct_reflections_create(context, info, &mut reflections) };
    assert_eq!(result == SsctResult::Ok, !reflections.is_null());
    result
}

/// The inputs of a frame: a mirror that faces the eye, half a metre away.
struct Inputs {
    color: SsctImage,
    depth: SsctImage,
    normals: (SsctNormals, SsctImage),
    camera: SsctCamera,
    factors: [SsctFactor; 2],
}

impl Inputs {
    /// Makes images of a size. The inputs are in a box, since the structs hold pointers to each other.
    fn new(program: &mut Program, side: u32) -> Box<Self> {
        let half = vk::Format::R16G16B16A16_SFLOAT;
        let factor = |value| SsctFactor { value, ..sized(size_of::<SsctFactor>()) };
        Box::new(Self {
            color: program.image(half, side, [0.5, 0.25, 0.125, 1.0], 1),
            depth: program.image(vk::Format::R32_SFLOAT, side, [0.2; 4], 1),
            normals: (sized(size_of::<SsctNormals>()), program.image(half, side, [0.0, 0.0, -1.0, 0.0], 1)),
            camera: SsctCamera {
                struct_size: size_of::<SsctCamera>(),
                world_to_view: WORLD,
                view_to_clip: CLIP,
                clip_y: SSCT_CLIP_Y_UP,
            },
            factors: [factor(0.5), factor(0.0)],
        })
    }

    /// Returns a frame that points to these inputs.
    fn frame(&mut self) -> SsctFrame {
        self.normals.0.image = &self.normals.1;
        SsctFrame {
            camera: &self.camera,
            depth: &self.depth,
            normals: &self.normals.0,
            reflectivity: &self.factors[0],
            roughness: &self.factors[1],
            color: &self.color,
            ..sized(size_of::<SsctFrame>())
        }
    }
}

#[test]
fn a_struct_of_features_with_the_type_of_another_is_refused() {
    let (mut features, mut features12) = (Default::default(), vk::PhysicalDeviceVulkan12Features::default());
    let s_type = features12.s_type;
    let mut features13 = vk::PhysicalDeviceVulkan13Features { s_type, ..Default::default() };
    // SAFETY: each pointer is to a live struct of the type that the function takes; only the third `sType` is wrong.
    let result = unsafe { ssct_enable_features(&mut features, &mut features12, &mut features13) };
    assert_refused(result, "features13 is 51; it must be VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3");
}

/// A frame with captures and a sky is recorded, and its passes and times are returned, after the context is destroyed.
/// Until each face was handed over, and with inputs of another size than the reflections', recording is refused.
#[test]
fn captures_a_sky_and_times_come_through() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let sky = program.image(vk::Format::R16G16B16A16_SFLOAT, 8, [0.1, 0.2, 0.9, 1.0], 6);
    let face_color = program.image(vk::Format::R16G16B16A16_SFLOAT, 16, [0.9, 0.1, 0.1, 1.0], 1);
    let face_depth = program.image(vk::Format::R32_SFLOAT, 16, [0.05; 4], 1);
    let context = program.context();
    unsafe {
        let mut device = sized::<SsctDeviceInfo>(size_of::<SsctDeviceInfo>());
        assert_eq!(ssct_context_device_info(context, &mut device), SsctResult::Ok);
        assert!(CStr::from_ptr(device.api).to_str().unwrap().starts_with("1."));
        let (places, bounds) = ([[0.0_f32; 3]], [[-9.0_f32, -9.0, -9.0], [9.0, 9.0, 9.0]]);
        let info = SsctCaptureCubesInfo {
            places: places.as_ptr().cast(),
            place_count: 1,
            side: 16,
            view_to_clip: CLIP,
            clip_y: SSCT_CLIP_Y_UP,
            bounds: bounds.as_ptr().cast(),
            ..sized(size_of::<SsctCaptureCubesInfo>())
        };
        let mut cubes = null_mut();
        assert_ok(ssct_capture_cubes_create(context, &info, &mut cubes));
        let reflections = make_reflections(context, &SsctReflectionsInfo { capture_side: 16, ..view(SIDE) });
        // Objects that were made with a context stay usable after the context is destroyed.
        ssct_context_destroy(context);
        let frame = SsctFrame { sky: &sky, captures: cubes, timed: vk::TRUE, ..inputs.frame() };
        let without_faces = ssct_reflections_record(reflections, program.commands, &frame, null_mut());
        assert_refused(without_faces, "face 0 of capture 0 was never handed over");
        for face in 0..6 {
            let sized = sized(size_of::<SsctCaptureFace>());
            let face = SsctCaptureFace { face, color: &face_color, depth: &face_depth, ..sized };
            assert_ok(program.submit(|_, commands| ssct_capture_cubes_record_face(cubes, commands, 0, &face)));
        }
        let mut recorded = sized::<SsctRecorded>(size_of::<SsctRecorded>());
        let result =
            program.submit(|_, commands| ssct_reflections_record(reflections, commands, &frame, &mut recorded));
        assert_ok(result);
        assert!(!recorded.composite.image.is_null() && !recorded.reflection.view.is_null());
        assert!(recorded.hits.image.is_null() && recorded.struct_size == size_of::<SsctRecorded>());
        let passes = std::slice::from_raw_parts(recorded.passes, recorded.pass_count as usize);
        let name = |pointer: *const c_char| CStr::from_ptr(pointer).to_str().unwrap();
        assert_eq!(name(passes[0]), "import");
        let skipped = std::slice::from_raw_parts(recorded.skipped, recorded.skipped_count as usize);
        assert!(skipped.iter().all(|s| !name(s.pass).is_empty() && !name(s.why).is_empty()) && !skipped.is_empty());
        let (mut times, mut count) = (null(), 0);
        assert_eq!(ssct_reflections_times(reflections, 0, &mut times, &mut count), SsctResult::Ok);
        let times = std::slice::from_raw_parts(times, count as usize);
        assert_eq!(times.len(), passes.len());
        assert!(times.iter().all(|t| t.ms >= 0.0) && name(times[0].name) == "import");
        let without_slot = ssct_reflections_times(reflections, 7, &mut null(), &mut count);
        assert_refused(without_slot, "the slot is 7");
        // After a change of size, images of the old size are refused.
        let extent = vk::Extent2D { width: 32, height: 32 };
        assert_ok(ssct_reflections_resize(reflections, extent));
        assert_eq!(ssct_reflections_restart_history(reflections), SsctResult::Ok);
        let result = ssct_reflections_record(reflections, program.commands, &frame, null_mut());
        assert_refused(result, "depth is 48x48 pixels; it must be 32x32");
        ssct_reflections_destroy(reflections);
        ssct_capture_cubes_destroy(cubes);
    }
}

/// The state of the caller's allocator: how many memory objects are alive, and whether `allocate` gives another.
struct Objects {
    device: ash::Device,
    kinds: vk::PhysicalDeviceMemoryProperties,
    alive: usize,
    gives: bool,
}

/// The caller's `allocate`: gives each image or buffer a memory object of its own, or fails if `Objects::gives` is
/// false.
unsafe extern "C" fn allocate(
    objects: *mut c_void,
    name: *const c_char,
    requirements: *const vk::MemoryRequirements,
    place: SsctMemoryPlace,
    _linear: bool,
    block: *mut SsctMemoryBlock,
) -> *const c_char {
    use vk::MemoryPropertyFlags as P;
    let (objects, requirements) = unsafe { (&mut *objects.cast::<Objects>(), &*requirements) };
    assert!(!unsafe { CStr::from_ptr(name) }.is_empty());
    if !objects.gives {
        return c"nothing is left".as_ptr();
    }
    let is_device = place == SSCT_MEMORY_PLACE_DEVICE;
    let wanted = if is_device { P::DEVICE_LOCAL } else { P::HOST_VISIBLE | P::HOST_COHERENT };
    let kinds = objects.kinds.memory_types_as_slice();
    let fits = |i: &usize| requirements.memory_type_bits >> i & 1 == 1 && kinds[*i].property_flags.contains(wanted);
    let kind = (0..kinds.len()).find(fits).unwrap() as u32;
    let info = vk::MemoryAllocateInfo::default().allocation_size(requirements.size).memory_type_index(kind);
    unsafe {
        let memory = objects.device.allocate_memory(&info, None).unwrap();
        let map = || objects.device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).unwrap();
        let mapped = if is_device { null_mut() } else { map() };
        *block = SsctMemoryBlock { memory, offset: 0, mapped, key: 42 };
    }
    objects.alive += 1;
    null()
}

/// Frees a block, and checks that the block came from `allocate`.
unsafe extern "C" fn release(objects: *mut c_void, block: *const SsctMemoryBlock) {
    let (objects, block) = unsafe { (&mut *objects.cast::<Objects>(), &*block) };
    assert_eq!(block.key, 42);
    unsafe { objects.device.free_memory(block.memory, None) };
    objects.alive -= 1;
}

#[test]
fn memory_comes_from_the_callers_allocator_and_goes_back() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let kinds = unsafe { program.instance.get_physical_device_memory_properties(program.physical) };
    let mut objects = Objects { device: program.device.clone(), kinds, alive: 0, gives: true };
    let state: *mut Objects = &mut objects;
    let memory = SsctMemory {
        user_data: state.cast(),
        allocate: Some(allocate),
        release: Some(release),
        ..sized(size_of::<SsctMemory>())
    };
    unsafe {
        let mut context = null_mut();
        let without_release = SsctMemory { release: None, ..memory };
        let result = ssct_context_create(&SsctContextInfo { memory: &without_release, ..program.info() }, &mut context);
        assert_refused(result, "release of SsctMemory is NULL");
        let info = SsctContextInfo { memory: &memory, ..program.info() };
        assert_ok(ssct_context_create(&info, &mut context));
        let reflections = make_reflections(context, &view(SIDE));
        assert!((*state).alive > 4 && ssct_context_allocated_bytes(context) == 0);
        let frame = inputs.frame();
        assert_ok(program.submit(|_, commands| ssct_reflections_record(reflections, commands, &frame, null_mut())));
        (*state).gives = false;
        assert_failed(create(context, &view(SIDE)), SsctResult::Memory, "nothing is left");
        ssct_reflections_destroy(reflections);
        ssct_context_trim(context);
        ssct_context_destroy(context);
        assert_eq!((*state).alive, 0);
    }
}

/// A mesh of one colour, moved along z by `z` metres.
fn mesh_at(z: f32, (positions, indices): (&[[f32; 3]], &[u32]), color: [f32; 3]) -> SsctTriangleMesh {
    let mut mesh_to_world = WORLD;
    mesh_to_world[14] = z;
    SsctTriangleMesh {
        positions: positions.as_ptr().cast(),
        indices: indices.as_ptr(),
        vertex_count: positions.len() as u32,
        index_count: indices.len() as u32,
        mesh_to_world,
        color,
        texture: 0,
        texture_places: null(),
    }
}

#[test]
fn rays_that_leave_the_screen_end_on_triangles() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let numbers = program.image(vk::Format::R32_UINT, SIDE, [0.0; 4], 1);
    let context = program.context();
    let positions = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]];
    let wall = |indices: &[u32]| mesh_at(-1.0, (&positions, indices), [0.25, 0.5, 1.0]);
    unsafe {
        let mut triangles = null_mut();
        let create_triangles = |mesh, triangles| ssct_triangles_create(context, mesh, 1, triangles);
        assert_refused(create_triangles(&wall(&[0, 1]), &mut triangles), "triangle mesh 0 has 2 indices");
        assert_refused(create_triangles(&wall(&[0, 1, 4]), &mut triangles), "the index 4, and 4 vertices");
        assert_ok(create_triangles(&wall(&[0, 1, 2, 2, 3, 0]), &mut triangles));

        // The expected composites in half floats: the mirror's colour plus half of the wall's, and the mirror's alone.
        let [with_wall, without_wall]: [[u16; 3]; 2] = [[0x3900, 0x3800, 0x3900], [0x3800, 0x3400, 0x3000]];
        let outputs = ssct_image_use(SSCT_USE_TRANSFER_SOURCE);
        let record_and_read = |reflections, frame: &SsctFrame| {
            let mut recorded = sized::<SsctRecorded>(size_of::<SsctRecorded>());
            let texels = program.read(SIDE, |commands| {
                assert_ok(ssct_reflections_record(reflections, commands, frame, &mut recorded));
                recorded.composite.image
            });
            texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect::<Vec<_>>()
        };
        let no_triangles = make_reflections(context, &view(SIDE));
        let frame = SsctFrame { outputs, ..inputs.frame() };
        assert!(record_and_read(no_triangles, &frame).iter().all(|texel| *texel == without_wall));
        let with_triangles = SsctFrame { triangles, ..frame };
        let result = ssct_reflections_record(no_triangles, program.commands, &with_triangles, null_mut());
        assert_refused(result, "buffers, and the reflections were made for nothing");
        ssct_reflections_destroy(no_triangles);
        for method in [c"unified", c"traced"] {
            let reflections =
                make_reflections(context, &SsctReflectionsInfo { triangles, method: method.as_ptr(), ..view(SIDE) });
            if method == c"unified" {
                let result = ssct_reflections_record(reflections, program.commands, &with_triangles, null_mut());
                assert_refused(result, "never uploaded");
                assert_ok(program.submit(|_, commands| ssct_triangles_record_upload(triangles, commands)));
            }
            let composite = record_and_read(reflections, &with_triangles);
            assert!(composite.iter().all(|texel| *texel == with_wall), "{method:?}: {:x?}", composite[0]);
            ssct_reflections_destroy(reflections);
        }
        // The mirror's triangle lies a little in front of the depth image, so that it stops its own rays unless its
        // number is known.
        let large = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 18.0, 0.0]];
        let mirror = mesh_at(0.49, (&large, &[0, 1, 2]), [1.0, 0.0, 0.0]);
        let mut two_meshes = null_mut();
        let meshes = [mirror, wall(&[0, 1, 2, 2, 3, 0])];
        assert_ok(ssct_triangles_create(context, meshes.as_ptr(), 2, &mut two_meshes));
        assert_ok(program.submit(|_, commands| ssct_triangles_record_upload(two_meshes, commands)));
        let with_triangles = SsctFrame { triangles: two_meshes, ..with_triangles };
        let reflections = make_reflections(context, &SsctReflectionsInfo { triangles: two_meshes, ..view(SIDE) });
        let composite = record_and_read(reflections, &with_triangles);
        assert!(composite.iter().all(|texel| *texel == [0x3c00, 0x3400, 0x3000]), "{:x?}", composite[0]);
        let composite = record_and_read(reflections, &SsctFrame { triangle_numbers: &numbers, ..with_triangles });
        assert!(composite.iter().all(|texel| *texel == with_wall), "{:x?}", composite[0]);
        let wrong = SsctImage { format: vk::Format::R32_SFLOAT, ..numbers };
        let frame = SsctFrame { triangle_numbers: &wrong, ..with_triangles };
        let result = ssct_reflections_record(reflections, program.commands, &frame, null_mut());
        assert_refused(result, "triangle_numbers has the format R32_SFLOAT; it must be R32_UINT");
        ssct_reflections_destroy(reflections);
        ssct_triangles_destroy(two_meshes);

        // A texture of a white and a grey texel; every vertex of the wall has the place of the white texel.
        let texels = [255, 255, 255, 0, 64, 64, 64, 0];
        let texture = SsctHitTexture { texels: texels.as_ptr(), width: 2, height: 1, is_srgb: vk::FALSE };
        let places = [[0.25_f32, 0.5]; 4];
        let textured = SsctTriangleMesh { texture_places: places.as_ptr().cast(), ..wall(&[0, 1, 2, 2, 3, 0]) };
        let create_textured = |mesh, textures, triangles| {
            ssct_triangles_create_textured(context, mesh, 1, textures, u32::from(!textures.is_null()), triangles)
        };
        let mut textured_triangles = null_mut();
        assert_refused(create_textured(&textured, null(), &mut textured_triangles), "has texture 0, and there are 0");
        let large = SsctHitTexture { width: 40000, ..texture };
        assert_refused(create_textured(&textured, &large, &mut textured_triangles), "texture 0 is 40000x1 texels");
        assert_ok(create_textured(&textured, &texture, &mut textured_triangles));
        assert_ok(program.submit(|_, commands| ssct_triangles_record_upload(textured_triangles, commands)));
        let reflections =
            make_reflections(context, &SsctReflectionsInfo { triangles: textured_triangles, ..view(SIDE) });
        let composite = record_and_read(reflections, &SsctFrame { triangles: textured_triangles, ..with_triangles });
        assert!(composite.iter().all(|texel| *texel == with_wall), "{:x?}", composite[0]);
        ssct_reflections_destroy(reflections);
        ssct_triangles_destroy(textured_triangles);
        assert_refused(ssct_triangles_record_upload(triangles, program.commands), "uploaded before");
        let wrong = SsctReflectionsInfo { triangles, method: c"ssct".as_ptr(), ..view(SIDE) };
        assert_refused(create(context, &wrong), "follows no rays among triangles");
        ssct_triangles_destroy(triangles);
        ssct_context_destroy(context);
    }
}

#[test]
fn wrong_arguments_are_refused_with_a_sentence_that_names_them() {
    let mut program = Program::new();
    let mut inputs = Inputs::new(&mut program, SIDE);
    let context = program.context();
    unsafe {
        let mut refused = null_mut();
        assert_refused(ssct_context_create(null(), &mut refused), "info is NULL");
        assert_refused(ssct_context_create(&program.info(), null_mut()), "context is NULL");
        let info = SsctContextInfo { device: vk::Device::null(), ..program.info() };
        assert_refused(ssct_context_create(&info, &mut refused), "device of SsctContextInfo is a null handle");
        let no_features = vk::PhysicalDeviceFeatures::default();
        let info = SsctContextInfo { features: &no_features, ..program.info() };
        assert_failed(ssct_context_create(&info, &mut refused), SsctResult::NoDevice, "imageCubeArray");
        assert_refused(create(null(), &view(SIDE)), "context is NULL");
        assert_refused(create(context, &SsctReflectionsInfo { struct_size: 0, ..view(SIDE) }), "struct_size");
        assert_refused(create(context, &SsctReflectionsInfo { method: c"none".as_ptr(), ..view(SIDE) }), "no method");
        let method = c"\xff".as_ptr();
        assert_refused(create(context, &SsctReflectionsInfo { method, ..view(SIDE) }), "no text in UTF-8");
        assert_refused(create(context, &SsctReflectionsInfo { outputs: 8, ..view(SIDE) }), "SSCT_OUTPUT_*");
        let parameters = [SsctParameter { name: c"fade".as_ptr(), value: c"perhaps".as_ptr() }];
        let wrong = SsctReflectionsInfo { parameters: parameters.as_ptr(), parameter_count: 1, ..view(SIDE) };
        assert_refused(create(context, &wrong), "perhaps");
        assert_refused(create(context, &SsctReflectionsInfo { parameters: null(), ..wrong }), "its count is 1");

        let reflections = make_reflections(context, &view(SIDE));
        let valid = inputs.frame();
        let commands = program.commands;
        let record = |frame: &SsctFrame| ssct_reflections_record(reflections, commands, frame, null_mut());
        assert_refused(record(&SsctFrame { camera: null(), ..valid }), "frame.camera is NULL");
        let camera = SsctCamera { clip_y: 9, ..*valid.camera };
        assert_refused(record(&SsctFrame { camera: &camera, ..valid }), "frame.camera.clip_y is 9");
        let normals = SsctNormals { space: 5, ..*valid.normals };
        assert_refused(record(&SsctFrame { normals: &normals, ..valid }), "frame.normals.space is 5");
        assert_refused(record(&SsctFrame { reflectors: 17, ..valid }), "SSCT_REFLECTORS_NONE alone");
        assert_refused(record(&SsctFrame { slot: 2, ..valid }), "frames_in_flight is 2");
        let unsampled = SsctImage { usage: vk::ImageUsageFlags::STORAGE, ..*valid.color };
        assert_refused(record(&SsctFrame { color: &unsampled, ..valid }), "SAMPLED");
        let motion = SsctMotion { image: valid.color, scale: [1.0, 0.0], ..sized(size_of::<SsctMotion>()) };
        assert_refused(record(&SsctFrame { motion: &motion, ..valid }), "the input motion has");
        let motion = SsctMotion { image: null(), ..motion };
        assert_refused(record(&SsctFrame { motion: &motion, ..valid }), "frame.motion.image is NULL");
        let mut short = sized::<SsctRecorded>(8);
        let result = ssct_reflections_record(reflections, commands, &valid, &mut short);
        assert_refused(result, "struct_size of the SsctRecorded of the argument recorded is 8");
        assert_refused(ssct_reflections_record(null_mut(), commands, &valid, null_mut()), "reflections is NULL");
        let result = ssct_reflections_record(reflections, vk::CommandBuffer::null(), &valid, null_mut());
        assert_refused(result, "commands is a null handle");
        assert_eq!(ssct_image_use(99).stages, 0);
        assert!(last_sentence().contains("kind is 99"), "{}", last_sentence());

        let mut count = 0;
        let methods = std::slice::from_raw_parts(ssct_methods(&mut count), count as usize);
        assert!(methods.iter().any(|m| CStr::from_ptr(m.name) == c"unified"));
        assert!(ssct_methods(null_mut()).is_null());
        assert_eq!(CStr::from_ptr(ssct_version()).to_str(), Ok(env!("CARGO_PKG_VERSION")));
        ssct_reflections_destroy(reflections);
        ssct_reflections_destroy(null_mut());
        ssct_context_destroy(context);
    }
}
