//! Tests the door for other renderers: whatever conventions a renderer has, the image equals that which the command
//! makes of the same G-buffer. Wrong inputs are refused with a sentence before anything is recorded.

use crate::common::engine::{
    BYTES, Convention, Engine, FLOAT, ForeignGBuffer, HALVES, NATIVE, bits, drawn, halves, info, rmse, view_of_rooms,
};
use crate::common::{gpu, own_gpu};
use ash::vk;
use glam::Vec3;
use ssct::gpu::{FrameContext, Gpu, Image};
use ssct::methods::capture::CaptureImages;
use ssct::methods::{METHODS, Setup, Wants};
use ssct::{
    CaptureCubes, CaptureCubesInfo, CaptureFaceInput, ClipY, Context, DeviceHandles, DeviceMemory, FactorInput,
    FrameInput, ImageInput, MemoryBlock, MemoryPlace, NormalEncoding, NormalSpace, Reflections, ReflectionsInfo,
    Reflectors,
};
use ssct_lab::stage::{Globals, Stage, gbuffer};
use ssct_scenes::Capture;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Through the door, in three frames, each method makes the images that it makes of that G-buffer directly, bit by bit.
#[test]
fn every_screen_space_method_makes_through_the_door_what_it_makes_otherwise() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    for method in METHODS.iter().filter(|m| m.is_screen_space()) {
        let mut reflections = Reflections::new(&context, &info(&data, method.name)).unwrap();
        let direct = gbuffer::reflect(&gpu, &data, None, method, &Setup::new([97, 61])).unwrap();
        for slot in [0, 1, 0] {
            let recorded = engine.frame(&mut reflections, &FrameInput { slot, ..theirs.input() }).unwrap();
            assert_eq!(recorded.passes.first().map(String::as_str), Some("import"));
            let composite = engine.read(&recorded.composite.unwrap());
            assert!(
                bits(&composite) == bits(&direct.composite),
                "{}: {}",
                method.name,
                rmse(&composite, &direct.composite)
            );
            let reflection = engine.read(&recorded.reflection.unwrap());
            assert!(bits(&reflection) == bits(&direct.reflection), "{}", method.name);
        }
    }
    assert!(ssct::methods().any(|(name, _)| name == "unified"));
    gpu.check_validation().unwrap();
}

/// A G-buffer in other conventions shows the same within rounding, and one in a wrongly named convention does not.
#[test]
fn every_convention_shows_the_same() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let context = engine.context();
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let mut show = |convention| engine.shown(&mut reflections, &data, convention);
    let native = show(NATIVE);
    for (right_handed, clip_y) in [(true, ClipY::Up), (false, ClipY::Down), (true, ClipY::Down)] {
        let convention = Convention { right_handed, clip_y, ..NATIVE };
        assert!(rmse(&show(convention), &native) < 1e-3, "{convention:?}");
    }
    // Other encodings round otherwise, so that some rays at edges end elsewhere and the bound is wider.
    for (space, encoding) in [
        (NormalSpace::World, NormalEncoding::Float),
        (NormalSpace::World, NormalEncoding::Unorm),
        (NormalSpace::View, NormalEncoding::Octahedral),
        (NormalSpace::World, NormalEncoding::OctahedralUnorm),
    ] {
        let convention = Convention { normal: (space, encoding), right_handed: true, ..NATIVE };
        let error = rmse(&show(convention), &native);
        assert!(error < 0.02, "{convention:?}: {error}");
    }
    let standard = Convention { standard_depth: true, ..NATIVE };
    assert!(rmse(&show(standard), &native) < 0.02);
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let mut input = theirs.input();
    input.normal.space = NormalSpace::World;
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    assert!(rmse(&engine.read(&recorded.composite.unwrap()), &native) > 0.03);
    gpu.check_validation().unwrap();
}

/// A shifted G-buffer with its shifted projection gives the shifted image in nine tenths of the pixels. In the others,
/// rays that leave the image by its sides see more or less of the scene.
#[test]
fn a_shifted_projection_shifts_the_image() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [96, 64]);
    let context = engine.context();
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
    let native = engine.read(&recorded.composite.unwrap());
    // The images stay, but the projection is said to be shifted by 8 pixels: the middle of the view is then at its
    // side, and every angle of reflection changes.
    let mut aside = theirs.input();
    aside.camera.view_to_clip[8] = 2.0 * 8.0 / 96.0;
    let recorded = engine.frame(&mut reflections, &aside).unwrap();
    let changed = engine.read(&recorded.composite.unwrap());
    assert!(rmse(&changed, &native) > 0.01, "the shift counts");
    let shift = 8;
    let width = data.width as usize;
    let source = |i: usize| if i % width >= shift { i - shift } else { i };
    let mut moved = data.clone();
    for i in (0..data.depth.len()).rev() {
        let from = source(i);
        moved.depth[i] = data.depth[from];
        moved.normal[i] = data.normal[from];
        moved.color[i] = data.color[from];
        moved.reflectivity[i] = data.reflectivity[from];
        moved.roughness[i] = data.roughness[from];
    }
    let theirs = ForeignGBuffer::new(&mut engine, &moved, NATIVE);
    let mut input = theirs.input();
    input.camera.view_to_clip[8] = 2.0 * shift as f32 / width as f32;
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    let shifted = engine.read(&recorded.composite.unwrap());
    let (mut equal, mut compared) = (0, 0);
    for (i, texel) in shifted.texels().enumerate().filter(|(i, _)| i % width >= 2 * shift && i % width < width - shift)
    {
        let expected = native.texels().nth(source(i)).unwrap();
        compared += 1;
        equal += usize::from(texel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02));
    }
    assert!(equal * 10 > compared * 9, "{equal} of {compared} pixels are as they were");
    gpu.check_validation().unwrap();
}

/// A cube map that is handed over as the sky shows in pixels whose rays end in the sky, and changes no other pixel.
#[test]
fn a_sky_shows_where_rays_end_in_it() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = drawn(&gpu, "street", "puddles", [97, 61]);
    assert!(data.depth.contains(&0.0), "the street is under the sky");
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let (reflectivity, roughness) = (FactorInput::Constant(0.5), FactorInput::Constant(0.0));
    let mirrors = FrameInput { reflectivity, roughness, ..theirs.input() };
    let mut show = |sky: Option<Vec3>| {
        let cube = sky.map(|color| engine.cube(8, color));
        let image_input =
            |cube: &Image| ImageInput::cube(cube.handle(), cube.faces().view(), cube.format(), cube.extent());
        let recorded = engine.frame(&mut reflections, &FrameInput { sky: cube.as_ref().map(image_input), ..mirrors });
        engine.read(&recorded.unwrap().composite.unwrap())
    };
    let (none, black, bright) = (show(None), show(Some(Vec3::ZERO)), show(Some(Vec3::new(0.0, 8.0, 0.0))));
    assert!(bits(&black) != bits(&none), "without a sky, what the screen shows of it is reflected");
    let greener = bright.texels().zip(black.texels()).filter(|(a, b)| a[1] > b[1] + 0.1).count();
    assert!(greener > 20, "{greener} pixels show the sky");
    assert!(bright.texels().zip(black.texels()).all(|(a, b)| a[0] == b[0] && a[1] >= b[1]), "and nothing else changes");
    gpu.check_validation().unwrap();
}

/// An image that is not asked for takes no memory, no pass makes it, and the other image is the same. The hits that a
/// trace in a pass of its own leaves are not handed over.
#[test]
fn what_is_not_asked_for_is_not_made() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [66, 49]);
    let (context, theirs) = (engine.context(), ForeignGBuffer::new(&mut engine, &data, NATIVE));
    for (method, parameters) in [("unified", &[][..]), ("ssct", &[]), ("ssct", &[("split", "on")])] {
        let mut draw = |composite, reflection| {
            let before = context.allocated_bytes();
            let wanted = ReflectionsInfo { composite, reflection, parameters, ..info(&data, method) };
            let mut reflections = Reflections::new(&context, &wanted).unwrap();
            let bytes = context.allocated_bytes() - before;
            let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
            assert_eq!((recorded.composite.is_some(), recorded.reflection.is_some()), (composite, reflection));
            assert!(recorded.hits.is_none());
            let images = [recorded.composite, recorded.reflection].map(|o| o.map(|o| bits(&engine.read(&o))));
            (images, bytes, recorded.passes)
        };
        let ([composite, reflection], most, _) = draw(true, true);
        let ([alone, _], bytes, _) = draw(true, false);
        assert!(alone == composite && bytes <= most, "{method}: {bytes} of {most} bytes");
        let ([_, alone], bytes, passes) = draw(false, true);
        assert!(alone == reflection && bytes < most, "{method}: {bytes} of {most} bytes");
        assert!(!passes.iter().any(|pass| pass == "composite"), "{passes:?}");
    }
    gpu.check_validation().unwrap();
}

/// An allocator of the caller's that makes a memory object for each block.
struct Objects {
    gpu: Gpu,
    /// The number of blocks that were given out, and the number of those that were not taken back.
    count: Arc<[AtomicUsize; 2]>,
}

// SAFETY: each block is an object of its own, of a type that fits; those for the host are mapped as long as they live.
unsafe impl DeviceMemory for Objects {
    fn allocate(
        &mut self,
        name: &str,
        requirements: &vk::MemoryRequirements,
        place: MemoryPlace,
        _: bool,
    ) -> Result<MemoryBlock, String> {
        use vk::MemoryPropertyFlags as P;
        let wanted = if place == MemoryPlace::Device { P::DEVICE_LOCAL } else { P::HOST_VISIBLE | P::HOST_COHERENT };
        let (shared, device) = (self.gpu.shared(), self.gpu.raw());
        // SAFETY: the device is alive; memory that is mapped was made for it.
        unsafe {
            let types = shared.instance.get_physical_device_memory_properties(shared.physical);
            let fits = |(i, t): &(usize, &vk::MemoryType)| {
                requirements.memory_type_bits & (1 << i) != 0 && t.property_flags.contains(wanted)
            };
            let found = types.memory_types_as_slice().iter().enumerate().find(fits);
            let (kind, _) = found.ok_or_else(|| format!("no memory for {name}"))?;
            // The layers advise against smaller objects.
            let info = vk::MemoryAllocateInfo::default().allocation_size(requirements.size.max(1 << 20));
            let info = info.memory_type_index(kind as u32);
            let memory = device.allocate_memory(&info, None).map_err(|e| e.to_string())?;
            let map = || device.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).unwrap();
            let mapped = (place != MemoryPlace::Device).then(|| NonNull::new(map().cast()).unwrap());
            let key = self.count[0].fetch_add(1, Ordering::SeqCst) as u64;
            self.count[1].fetch_add(1, Ordering::SeqCst);
            Ok(MemoryBlock { memory, offset: 0, mapped, key })
        }
    }

    fn free(&mut self, block: MemoryBlock) {
        assert!(block.key < self.count[0].load(Ordering::SeqCst) as u64);
        self.count[1].fetch_sub(1, Ordering::SeqCst);
        // SAFETY: what it was for is destroyed.
        unsafe { self.gpu.raw().free_memory(block.memory, None) };
    }
}

/// An allocator of the caller's gives all memory, gets all of it back, and changes no pixel. One without memory leads
/// to an error with its reason.
#[test]
fn memory_of_the_callers_is_taken_and_given_back() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [66, 49]);
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let mut show = |context: Context| {
        let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
        let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
        (bits(&engine.read(&recorded.composite.unwrap())), context.allocated_bytes())
    };
    let count = Arc::new([const { AtomicUsize::new(0) }; 2]);
    let memory: Box<dyn DeviceMemory> = Box::new(Objects { gpu: gpu.clone(), count: Arc::clone(&count) });
    let owner = Engine::new(&gpu);
    // SAFETY: as in `Engine::context`.
    let with_memory = unsafe { Context::new(DeviceHandles { memory: Some(memory), ..owner.handles() }) }.unwrap();
    let (expected, own_bytes) = show(owner.context());
    let (found, own_bytes_beside) = show(with_memory);
    assert!(found == expected && own_bytes > 0 && own_bytes_beside == 0, "{own_bytes} {own_bytes_beside}");
    let [allocated, kept] = count.each_ref().map(|n| n.load(Ordering::SeqCst));
    assert!(allocated > 10 && kept == 0, "{kept} of {allocated} blocks are held");
    struct Nothing;
    // SAFETY: it gives nothing.
    unsafe impl DeviceMemory for Nothing {
        fn allocate(
            &mut self,
            _: &str,
            _: &vk::MemoryRequirements,
            _: MemoryPlace,
            _: bool,
        ) -> Result<MemoryBlock, String> {
            Err("the budget is spent".into())
        }

        fn free(&mut self, _: MemoryBlock) {}
    }
    // SAFETY: as above.
    let poor = unsafe { Context::new(DeviceHandles { memory: Some(Box::new(Nothing)), ..owner.handles() }) }.unwrap();
    let why = Reflections::new(&poor, &info(&data, "unified")).err().unwrap();
    assert!(matches!(why, ssct::Error::Memory { .. }) && why.to_string().contains("the budget is spent"), "{why}");
    gpu.check_validation().unwrap();
}

/// Captures that the caller draws face by face, whose normals are made of depth, show nearly what the same captures
/// show as host images. Wrong faces, slots and bounds are refused.
#[test]
fn captures_of_the_caller_show_what_those_of_a_file_show() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals::default().materials(&scene, scene.view("corridor").unwrap());
    let eye = data.camera.eye();
    let capture = Capture { resolution: 64, ..Capture::placed_at(eye + Vec3::new(0.3, 0.1, 0.2)) };
    let mut faces = Vec::new();
    gbuffer::draw_captures(&mut stage, &materials, &[capture], |_, _, face| {
        faces.push(face);
        Ok(())
    })
    .unwrap();
    let context = engine.context();
    let place = [capture.position.to_array()];
    let captures_info = CaptureCubesInfo {
        places: &place,
        side: 64,
        view_to_clip: faces[0].camera.view_to_clip_reversed().to_cols_array(),
        clip_y: ClipY::Up,
        bounds: Some([scene.bounds().min.to_array(), scene.bounds().max.to_array()]),
        frames_in_flight: 1,
    };
    let turned = CaptureCubesInfo { bounds: Some([[1.0; 3], [0.0; 3]]), ..captures_info };
    let refused = CaptureCubes::new(&context, &turned).err().unwrap().to_string();
    assert!(refused.contains("bounds"), "{refused}");
    let mut captures = CaptureCubes::new(&context, &captures_info).unwrap();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let with_captures = ReflectionsInfo { captures: Some(64), ..info(&data, "unified") };
    let mut reflections = Reflections::new(&context, &with_captures).unwrap();
    let commands = engine.begin();
    let unfilled = FrameInput { captures: Some(&captures), ..theirs.input() };
    // SAFETY: the command buffer is recording, and is thrown away.
    let refused = unsafe { reflections.record(commands, &unfilled) }.err().unwrap().to_string();
    assert!(refused.contains("face 0 of capture 0"), "{refused}");
    let mut kept = Vec::new();
    for (face, data) in faces.iter().enumerate() {
        let color = engine.upload(HALVES, [64; 2], &halves(data.color.iter().flat_map(|c| c.extend(1.0).to_array())));
        let depth = engine.upload(FLOAT, [64; 2], bytemuck::cast_slice(&data.depth));
        let image_input =
            |image: &Image| ImageInput::color(image.handle(), image.all().view(), image.format(), [64; 2]);
        let input = CaptureFaceInput { capture: 0, face, color: image_input(&color), depth: image_input(&depth) };
        let commands = engine.begin();
        // SAFETY: as above; submitted and waited for at once.
        unsafe { captures.record_face(commands, 0, &input) }.unwrap();
        engine.submit(commands).unwrap();
        for (slot, wrong, words) in [
            (1, input, ["slot", "frames_in_flight"]),
            (0, CaptureFaceInput { capture: 1, ..input }, ["capture 1", "places has 1"]),
            (0, CaptureFaceInput { face: 6, ..input }, ["face 6", "6 faces"]),
        ] {
            let commands = engine.begin();
            // SAFETY: as above; it is thrown away.
            let message = unsafe { captures.record_face(commands, slot, &wrong) }.unwrap_err().to_string();
            assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
        }
        kept.push((color, depth));
    }
    let input = FrameInput { captures: Some(&captures), ..theirs.input() };
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    assert!(recorded.passes.iter().any(|p| p.starts_with("follow")), "{:?}", recorded.passes);
    let seen = engine.read(&recorded.composite.unwrap());
    // The expected image is made with the same captures from the host, whose normals were drawn.
    let mut host = FrameContext::new(&gpu).unwrap();
    let uploaded = CaptureImages::of_faces(&mut host, &[capture], |_, f| Ok(faces[f].clone())).unwrap();
    let uploaded = uploaded.with_bounds(scene.bounds());
    let method = ssct::methods::find("unified").unwrap();
    let setup = Setup::new([97, 61]);
    let effect = ssct::methods::Effect::with_captures(&mut host, method, &setup, Wants::REFLECTION, uploaded).unwrap();
    let images = ssct::passes::gbuffer::GBufferImages::upload(&mut host, &data).unwrap();
    let mut frame = host.begin(ssct::gpu::frame::Mode::Plain).unwrap();
    let input = ssct::methods::Input::of_screen(images.gbuffer(), &data.camera);
    let output = effect.record(&mut frame, &input).unwrap();
    frame.finish().unwrap();
    let expected = host.read(output.composite.level(0)).unwrap();
    let plain = gbuffer::reflect(&gpu, &data, None, method, &setup).unwrap();
    let (error, gain) = (rmse(&seen, &expected), rmse(&plain.composite, &expected));
    assert!(error < 0.25 * gain, "{error} of what captures change, {gain}");
    gpu.check_validation().unwrap();
}

/// A wrong input or description is refused with a sentence that names it, and leaves the reflections usable.
#[test]
fn what_is_wrong_with_an_input_is_said_with_its_name() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [34, 25]);
    let context = engine.context();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let mut refused = |change: &dyn Fn(&mut FrameInput<'static>), words: [&str; 2]| {
        let mut input = theirs.input();
        change(&mut input);
        let message = engine.frame(&mut reflections, &input).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message:?}");
    };
    refused(&|i| i.depth.view = vk::ImageView::null(), ["depth", "null"]);
    refused(&|i| i.normal.image.format = BYTES, ["normal", "below 0"]);
    refused(&|i| i.color.usage = vk::ImageUsageFlags::TRANSFER_SRC, ["color", "SAMPLED"]);
    refused(&|i| i.normal.image.extent = [32, 23], ["normal", "32x23"]);
    refused(&|i| i.color.format = vk::Format::R8G8B8A8_UINT, ["color", "floats"]);
    refused(&|i| i.color.before.layout = vk::ImageLayout::UNDEFINED, ["color", "UNDEFINED"]);
    refused(&|i| i.roughness = FactorInput::Constant(1.5), ["roughness", "0 to 1"]);
    refused(&|i| i.roughness = FactorInput::Channel(i.color, 4), ["roughness", "channel"]);
    refused(&|i| i.slot = 2, ["slot", "frames_in_flight"]);
    refused(&|i| i.camera.view_to_clip[11] = 0.0, ["view_to_clip", "perspective"]);
    refused(&|i| i.outputs.layout = vk::ImageLayout::UNDEFINED, ["outputs", "UNDEFINED"]);
    refused(&|i| i.sky = Some(i.color), ["sky", "6"]);
    refused(&|i| i.depth.part.aspect_mask = vk::ImageAspectFlags::DEPTH, ["depth", "aspects"]);
    let wrong = |info: &ReflectionsInfo, word: &str| {
        let message = Reflections::new(&context, info).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(word), "{word}: {message:?}");
    };
    let good = info(&data, "unified");
    wrong(&ReflectionsInfo { method: "magic", ..good }, "magic");
    wrong(&ReflectionsInfo { method: "planar", ..good }, "scene");
    let message = Reflections::new(&context, &ReflectionsInfo { method: "magic", ..good }).err().unwrap().to_string();
    assert!(message.contains("unified") && !message.contains("planar"), "{message}");
    wrong(&ReflectionsInfo { method: "pccm", ..good }, "scene");
    wrong(&ReflectionsInfo { parameters: &[("cone-samples", "7")], ..good }, "cone-samples");
    wrong(&ReflectionsInfo { parameters: &[("fade", "maybe")], ..good }, "on, off");
    wrong(&ReflectionsInfo { frames_in_flight: 0, ..good }, "frames_in_flight");
    wrong(&ReflectionsInfo { extent: [0, 5], ..good }, "0x5");
    wrong(&ReflectionsInfo { composite: false, reflection: false, ..good }, "no output");
    let mut lacking = engine.handles();
    lacking.enabled.vulkan13.synchronization2 = vk::FALSE;
    // SAFETY: refused before anything is made of it.
    let message = unsafe { Context::new(lacking) }.err().unwrap().to_string();
    assert!(message.contains("synchronization2"), "{message}");
    // The refused calls changed nothing: a good frame still works.
    assert!(engine.frame(&mut reflections, &theirs.input()).is_ok());
    gpu.check_validation().unwrap();
}

/// Constants and images of bytes serve as factors. Passes are timed, and skipping those without pixels changes nothing.
#[test]
fn constants_stand_for_images_and_passes_are_timed_and_skipped() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [66, 49]);
    let context = engine.context();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let with_hits = ReflectionsInfo { hits: true, parameters: &[("fade", "off")], ..info(&data, "unified") };
    let mut reflections = Reflections::new(&context, &with_hits).unwrap();
    let (reflectivity, roughness) = (FactorInput::Constant(0.5), FactorInput::Constant(0.0));
    let input = FrameInput { reflectivity, roughness, timed: true, ..theirs.input() };
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    assert!(recorded.hits.is_some());
    assert!(recorded.skipped.iter().any(|s| s.pass == "classify"), "{:?}", recorded.skipped);
    let times = reflections.times(0).unwrap();
    assert_eq!(times.iter().map(|t| t.name.clone()).collect::<Vec<_>>(), recorded.passes);
    assert!(times.iter().any(|t| t.counted && t.ms > 0.0) && !times[0].counted);
    assert!(reflections.times(1).unwrap().is_empty());
    let message = reflections.times(2).unwrap_err().to_string();
    assert!(message.contains("slot") && message.contains("frames_in_flight"), "{message}");
    let nothing = FrameInput { reflectivity: FactorInput::Constant(0.0), ..input };
    let recorded = engine.frame(&mut reflections, &nothing).unwrap();
    assert!(recorded.reflection.is_none() && recorded.passes.iter().all(|p| p == "import"), "{:?}", recorded.passes);
    // Passes for kinds of reflectors that the caller rules out are not recorded, and the image is the same.
    let other_input = theirs.input();
    let mut data = data.clone();
    data.roughness.fill(0.0);
    let mirrors = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let recorded = engine.frame(&mut reflections, &mirrors.input()).unwrap();
    let (most, expected) = (recorded.passes.len(), bits(&engine.read(&recorded.composite.unwrap())));
    let reflectors = Reflectors { narrow: false, wide: false, ..Reflectors::UNKNOWN };
    let recorded = engine.frame(&mut reflections, &FrameInput { reflectors, ..mirrors.input() }).unwrap();
    assert!(bits(&engine.read(&recorded.composite.unwrap())) == expected && recorded.passes.len() < most);
    let bytes: Vec<u8> = data.roughness.iter().flat_map(|r| [(r * 255.0).round() as u8, 128, 0, 255]).collect();
    let image = engine.upload(BYTES, [66, 49], &bytes);
    let image_input = ImageInput::color(image.handle(), image.all().view(), BYTES, [66, 49]);
    let input = FrameInput {
        reflectivity: FactorInput::Channel(image_input, 1),
        roughness: FactorInput::Channel(image_input, 0),
        ..other_input
    };
    assert!(engine.frame(&mut reflections, &input).unwrap().reflection.is_some());
    gpu.check_validation().unwrap();
}

/// Reflections are made, resized and dropped in two threads, and no device memory is left.
#[test]
fn views_come_and_go_in_two_threads_and_leave_nothing() {
    let run = || {
        let gpu = own_gpu();
        let mut engine = Engine::new(&gpu);
        let data = view_of_rooms(&gpu, [33, 21]);
        let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
        let context = engine.context();
        let mut allocated = Vec::new();
        for round in 0..3 {
            for method in ["unified", "ssct", "hzct"] {
                let mut reflections = Reflections::new(&context, &info(&data, method)).unwrap();
                for extent in [[8, 8], [33, 21]] {
                    reflections.resize(extent).unwrap();
                }
                for frame in 0..4 {
                    engine.frame(&mut reflections, &FrameInput { slot: frame % 2, ..theirs.input() }).unwrap();
                }
                allocated.push((round, context.allocated_bytes()));
            }
        }
        assert_eq!(context.allocated_bytes(), 0, "{allocated:?}");
        drop((theirs, engine));
        gpu.check_validation().unwrap();
    };
    std::thread::scope(|scope| {
        let thread = scope.spawn(run);
        run();
        thread.join().unwrap();
    });
}
