//! The door for other renderers: whatever conventions they have, what comes out is what the command makes of the same
//! G-buffer; and what is wrong with their inputs is said before anything is recorded.

use crate::common::{gpu, own_gpu};
use ash::vk;
use glam::{Mat3, Mat4, Vec2, Vec3};
use half::f16;
use ssct::gpu::{Buffer, FrameContext, Gpu, Image, ImageDesc, Pixels};
use ssct::methods::METHODS;
use ssct::methods::{Setup, Wants};
use ssct::scene::Projection;
use ssct::{
    CameraInput, CaptureCubes, CaptureCubesInfo, CaptureFaceInput, ClipY, Context, DeviceHandles, EnabledFeatures,
    FactorInput, FrameInput, ImageInput, ImageUse, NormalEncoding, NormalInput, NormalSpace, OutputImage, Recorded,
    Reflections, ReflectionsInfo,
};
use ssct_lab::scene::{Camera, Capture, GBufferData, Lens, Surface, library};
use ssct_lab::study::{Globals, Shot, Stage, gbuffer, image};
use std::path::Path;
use std::process::Command;

const HALVES: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const BYTES: vk::Format = vk::Format::R8G8B8A8_UNORM;
const FLOAT: vk::Format = vk::Format::R32_SFLOAT;

/// A renderer with a device of its own: the raw handles of ours stand for theirs.
struct Engine {
    gpu: Gpu,
    frames: FrameContext,
    pool: vk::CommandPool,
}

impl Engine {
    fn new(gpu: &Gpu) -> Self {
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.shared().queue_family);
        // SAFETY: destroyed in `drop`.
        let pool = unsafe { gpu.raw().create_command_pool(&info, None) }.unwrap();
        Self { gpu: gpu.clone(), frames: FrameContext::new(gpu).unwrap(), pool }
    }

    fn handles(&self) -> DeviceHandles {
        let shared = self.gpu.shared();
        let mut enabled = EnabledFeatures::default();
        ssct::enable_features(&mut enabled.core, &mut enabled.vulkan12, &mut enabled.vulkan13);
        DeviceHandles {
            entry: shared.entry.clone(),
            instance: shared.instance.clone(),
            physical: shared.physical,
            device: shared.device.clone(),
            queue_family: shared.queue_family,
            enabled,
            debug_utils: false,
            memory: None,
        }
    }

    fn context(&self) -> Context {
        // SAFETY: the handles are of one device, which outlives the test's contexts; its features are those of
        // `Gpu::open`, which has them on.
        unsafe { Context::new(self.handles()) }.unwrap()
    }

    fn upload(&mut self, format: vk::Format, extent: [u32; 2], bytes: &[u8]) -> Image {
        use vk::ImageUsageFlags as U;
        let usage = U::SAMPLED | U::TRANSFER_DST | U::TRANSFER_SRC;
        let image =
            Image::new(&self.gpu, &ImageDesc { name: "theirs", format, extent, levels: 1, layers: 1, usage }).unwrap();
        let staging = Buffer::upload(&self.gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC).unwrap();
        self.frames
            .once(|frame| {
                frame.upload("upload", &staging, image.all())?;
                frame.hand_over(&image, ImageUse::FRAGMENT_SAMPLED);
                Ok(())
            })
            .unwrap();
        image
    }

    fn begin(&self) -> vk::CommandBuffer {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is alive, and frees its command buffers.
        unsafe {
            let commands = self.gpu.raw().allocate_command_buffers(&info).unwrap()[0];
            self.gpu.raw().begin_command_buffer(commands, &begin).unwrap();
            commands
        }
    }

    fn submit(&self, commands: vk::CommandBuffer) -> ash::prelude::VkResult<()> {
        let buffers = [commands];
        let queue = self.gpu.queue().unwrap();
        // SAFETY: the command buffer is recorded; the queue is waited for.
        unsafe {
            self.gpu.raw().end_command_buffer(commands)?;
            self.gpu.raw().queue_submit(
                *queue,
                &[vk::SubmitInfo::default().command_buffers(&buffers)],
                vk::Fence::null(),
            )?;
            self.gpu.raw().queue_wait_idle(*queue)
        }
    }

    fn read(&mut self, output: &OutputImage) -> Pixels {
        let part =
            vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1);
        let like = (output.format, output.extent);
        let image = Image::of_others(&self.gpu, "output", (output.image, output.view), part, like);
        self.frames
            .once(|frame| {
                frame.take_over(&image, ImageUse::TRANSFER_SOURCE);
                Ok(())
            })
            .unwrap();
        self.frames.read(image.all()).unwrap()
    }

    /// One frame, submitted.
    fn frame(&mut self, reflections: &mut Reflections, input: &FrameInput) -> ssct::Result<Recorded> {
        let commands = self.begin();
        // SAFETY: the command buffer is recording; what is recorded is submitted and waited for at once.
        let recorded = unsafe { reflections.record(commands, input) }?;
        self.submit(commands).unwrap();
        Ok(recorded)
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        // SAFETY: nothing is under way.
        unsafe { self.gpu.raw().destroy_command_pool(self.pool, None) };
    }
}

/// How a renderer keeps its G-buffer.
#[derive(Debug, Clone, Copy)]
struct Convention {
    normal: (NormalSpace, NormalEncoding),
    /// Whether its view space is right-handed.
    right_handed: bool,
    standard_depth: bool,
    clip_y: ClipY,
}

const NATIVE: Convention = Convention {
    normal: (NormalSpace::View, NormalEncoding::Float),
    right_handed: false,
    standard_depth: false,
    clip_y: ClipY::Up,
};

/// A G-buffer as a renderer of a convention has it, in its images.
struct Theirs {
    depth: Image,
    normal: Image,
    material: Image,
    color: Image,
    camera: CameraInput,
    convention: Convention,
}

fn halves(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(|v| f16::from_f32(v).to_ne_bytes()).collect()
}

fn octahedral(n: Vec3) -> Vec2 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(1e-12);
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    if n.z >= 0.0 { n.truncate() } else { Vec2::new((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)) }
}

impl Theirs {
    fn new(engine: &mut Engine, data: &GBufferData, convention: Convention) -> Self {
        let extent = [data.width, data.height];
        let turn = Mat3::from_diagonal(Vec3::new(1.0, 1.0, if convention.right_handed { -1.0 } else { 1.0 }));
        let ours = data.camera.view_to_clip_reversed().to_cols_array();
        let mut clip = ours;
        let side = if convention.right_handed { -1.0 } else { 1.0 };
        if convention.standard_depth {
            clip[10] = 1.0 - ours[10];
            clip[14] = -ours[14];
        }
        clip[10] *= side;
        clip[11] = side;
        if convention.clip_y == ClipY::Down {
            clip[5] = -clip[5];
        }
        let world_to_view = Mat4::from_mat3(turn) * data.camera.world_to_view;
        let to_world = Mat3::from_mat4(data.camera.world_to_view).transpose();
        let stored = |n: &Vec3| -> [f32; 4] {
            let n = match convention.normal.0 {
                NormalSpace::View => turn * *n,
                NormalSpace::World => to_world * *n,
            };
            let (o, unorm) = (octahedral(n), |v: f32| 0.5 * v + 0.5);
            match convention.normal.1 {
                NormalEncoding::Float => [n.x, n.y, n.z, 0.0],
                NormalEncoding::Unorm => [unorm(n.x), unorm(n.y), unorm(n.z), 0.0],
                NormalEncoding::Octahedral => [o.x, o.y, 0.0, 0.0],
                NormalEncoding::OctahedralUnorm => [unorm(o.x), unorm(o.y), 0.0, 0.0],
            }
        };
        let depth: Vec<f32> = data.depth.iter().map(|d| if convention.standard_depth { 1.0 - d } else { *d }).collect();
        let material = data.roughness.iter().zip(&data.reflectivity).flat_map(|(ro, re)| [0.25, *ro, 0.5, *re]);
        let color = data.color.iter().flat_map(|c| c.extend(1.0).to_array());
        let camera =
            CameraInput { world_to_view: world_to_view.to_cols_array(), view_to_clip: clip, clip_y: convention.clip_y };
        Self {
            depth: engine.upload(FLOAT, extent, bytemuck::cast_slice(&depth)),
            normal: engine.upload(HALVES, extent, &halves(data.normal.iter().flat_map(stored))),
            material: engine.upload(HALVES, extent, &halves(material)),
            color: engine.upload(HALVES, extent, &halves(color)),
            camera,
            convention,
        }
    }

    fn input(&self) -> FrameInput<'static> {
        let of = |image: &Image| ImageInput::color(image.handle(), image.all().view(), image.format(), image.extent());
        let (space, encoding) = self.convention.normal;
        FrameInput {
            slot: 0,
            camera: self.camera,
            depth: of(&self.depth),
            normal: NormalInput { image: of(&self.normal), space, encoding },
            reflectivity: FactorInput::Channel(of(&self.material), 3),
            roughness: FactorInput::Channel(of(&self.material), 1),
            color: of(&self.color),
            sky: None,
            captures: None,
            timed: false,
            outputs: ImageUse::TRANSFER_SOURCE,
        }
    }
}

/// A view of the rooms, with all kinds of surfaces; the camera is known by its matrix.
fn view_of_rooms(gpu: &Gpu, extent: [u32; 2]) -> GBufferData {
    let scene = library::scene("rooms").unwrap();
    let view = scene.view("corridor").unwrap();
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let materials = Globals::default().materials(&scene, view);
    let camera = view.camera(&scene, extent);
    let shot = Shot::new(&mut stage, &METHODS[0], &Setup::new(extent), Wants::IMAGE, camera, materials).unwrap();
    image::render(&mut stage, &shot, false).unwrap();
    let mut data = gbuffer::read(&mut stage.context, &shot).unwrap();
    let clip = camera.view_to_clip_reversed();
    let [a, b] = [clip.z_axis.z, clip.w_axis.z];
    let scale = [clip.x_axis.x, clip.y_axis.y];
    data.camera.projection = Some(Projection { scale, shift: [0.0; 2], depth: [a, b] });
    data.camera.aspect = scale[1] / scale[0];
    data.camera.lens = Lens { fov_y_radians: 2.0 * (1.0 / scale[1]).atan(), near_m: b / (1.0 - a), far_m: -b / a };
    // The example's images know no surface that shows the sky.
    data.surface.fill(Surface::Lit);
    data
}

fn info<'a>(data: &GBufferData, method: &'a str) -> ReflectionsInfo<'a> {
    ReflectionsInfo { extent: [data.width, data.height], method, ..ReflectionsInfo::default() }
}

fn bits(pixels: &Pixels) -> Vec<u32> {
    pixels.values.iter().map(|v| v.to_bits()).collect()
}

fn rmse(a: &Pixels, b: &Pixels) -> f64 {
    assert_eq!(a.values.len(), b.values.len());
    let sum: f64 = a.values.iter().zip(&b.values).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / a.values.len() as f64).sqrt()
}

#[test]
fn every_screen_space_method_makes_through_the_door_what_it_makes_otherwise() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
    let context = engine.context();
    for method in METHODS.iter().filter(|m| m.is_screen_space()) {
        let mut reflections = Reflections::new(&context, &info(&data, method.name)).unwrap();
        let direct = gbuffer::reflect(&gpu, &data, None, method, &Setup::new([97, 61])).unwrap();
        for slot in [0, 1, 0] {
            let recorded = engine.frame(&mut reflections, &FrameInput { slot, ..theirs.input() }).unwrap();
            assert_eq!(recorded.passes.first().map(String::as_str), Some("import"));
            let composite = engine.read(&recorded.composite);
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

#[test]
fn every_convention_shows_the_same() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let context = engine.context();
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let mut show = |convention| {
        let theirs = Theirs::new(&mut engine, &data, convention);
        let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
        engine.read(&recorded.composite)
    };
    let native = show(NATIVE);
    // Turned view spaces and clip spaces change nothing.
    for (right_handed, clip_y) in [(true, ClipY::Up), (false, ClipY::Down), (true, ClipY::Down)] {
        let convention = Convention { right_handed, clip_y, ..NATIVE };
        assert!(rmse(&show(convention), &native) < 1e-3, "{convention:?}");
    }
    // Other encodings round otherwise, so that some rays at edges end elsewhere.
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
    // A wrong convention shows something else: the bounds above mean something.
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
    let mut input = theirs.input();
    input.normal.space = NormalSpace::World;
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    assert!(rmse(&engine.read(&recorded.composite), &native) > 0.03);
    gpu.check_validation().unwrap();
}

#[test]
fn a_shifted_projection_shifts_the_image() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [96, 64]);
    let context = engine.context();
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
    let recorded = engine.frame(&mut reflections, &theirs.input()).unwrap();
    let native = engine.read(&recorded.composite);
    // The same images, taken to be those of a projection that is shifted by 8 pixels, of a camera that looks so much
    // aside: what was in the middle of the view is at its side, and every angle changes.
    let mut aside = theirs.input();
    aside.camera.view_to_clip[8] = 2.0 * 8.0 / 96.0;
    let recorded = engine.frame(&mut reflections, &aside).unwrap();
    let changed = engine.read(&recorded.composite);
    assert!(rmse(&changed, &native) > 0.01, "the shift counts");
    // A G-buffer that is shifted with its projection shows the shifted image.
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
    let theirs = Theirs::new(&mut engine, &moved, NATIVE);
    let mut input = theirs.input();
    input.camera.view_to_clip[8] = 2.0 * shift as f32 / width as f32;
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    let shifted = engine.read(&recorded.composite);
    let (mut equal, mut all) = (0, 0);
    for (i, texel) in shifted.texels().enumerate().filter(|(i, _)| i % width >= 2 * shift && i % width < width - shift)
    {
        let expected = native.texels().nth(source(i)).unwrap();
        all += 1;
        equal += usize::from(texel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02));
    }
    // Rays that leave by the sides see more or less of the scene.
    assert!(equal * 10 > all * 9, "{equal} of {all} pixels are as they were");
    gpu.check_validation().unwrap();
}

#[test]
fn captures_of_the_caller_show_what_those_of_a_file_show() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let scene = library::scene("rooms").unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals::default().materials(&scene, scene.view("corridor").unwrap());
    let eye = data.camera.eye();
    let capture = Capture { resolution: 64, ..Capture::at(eye + Vec3::new(0.3, 0.1, 0.2)) };
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
        frames_in_flight: 1,
    };
    let mut captures = CaptureCubes::new(&context, &captures_info).unwrap();
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
    let with = ReflectionsInfo { captures: Some(64), ..info(&data, "unified") };
    let mut reflections = Reflections::new(&context, &with).unwrap();
    let commands = engine.begin();
    let unfilled = FrameInput { captures: Some(&captures), ..theirs.input() };
    // SAFETY: the command buffer is recording, and is thrown away.
    let refused = unsafe { reflections.record(commands, &unfilled) }.err().unwrap().to_string();
    assert!(refused.contains("face 0 of capture 0"), "{refused}");
    let mut kept = Vec::new();
    for (face, data) in faces.iter().enumerate() {
        let color = engine.upload(HALVES, [64; 2], &halves(data.color.iter().flat_map(|c| c.extend(1.0).to_array())));
        let depth = engine.upload(FLOAT, [64; 2], bytemuck::cast_slice(&data.depth));
        let of = |image: &Image| ImageInput::color(image.handle(), image.all().view(), image.format(), [64; 2]);
        let input = CaptureFaceInput { capture: 0, face, color: of(&color), depth: of(&depth) };
        let commands = engine.begin();
        // SAFETY: as above; submitted and waited for at once.
        unsafe { captures.record_face(commands, 0, &input) }.unwrap();
        engine.submit(commands).unwrap();
        kept.push((color, depth));
    }
    let input = FrameInput { captures: Some(&captures), ..theirs.input() };
    let recorded = engine.frame(&mut reflections, &input).unwrap();
    assert!(recorded.passes.iter().any(|p| p.starts_with("follow")), "{:?}", recorded.passes);
    let seen = engine.read(&recorded.composite);
    // Beside the same captures from the host, whose normals are not made of depth.
    let mut host = FrameContext::new(&gpu).unwrap();
    let given =
        ssct::methods::capture::CaptureImages::of_faces(&mut host, &[capture], |_, f| Ok(faces[f].clone())).unwrap();
    let method = ssct::methods::find("unified").unwrap();
    let setup = Setup::new([97, 61]);
    let effect = ssct::methods::Effect::with_captures(&mut host, method, &setup, Wants::REFLECTION, given).unwrap();
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

#[test]
fn what_is_wrong_with_an_input_is_said_with_its_name() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [32, 24]);
    let context = engine.context();
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let mut refused = |change: &dyn Fn(&mut FrameInput<'static>), words: [&str; 2]| {
        let mut input = theirs.input();
        change(&mut input);
        let said = engine.frame(&mut reflections, &input).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said:?}");
    };
    refused(&|i| i.depth.view = vk::ImageView::null(), ["depth", "null"]);
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
    // And of what they are made for.
    let wrong = |info: &ReflectionsInfo, word: &str| {
        let said = Reflections::new(&context, info).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(said.contains(word), "{word}: {said:?}");
    };
    let good = info(&data, "unified");
    wrong(&ReflectionsInfo { method: "magic", ..good }, "magic");
    wrong(&ReflectionsInfo { method: "pccm", ..good }, "scene");
    wrong(&ReflectionsInfo { parameters: &[("cone-samples", "7")], ..good }, "cone-samples");
    wrong(&ReflectionsInfo { parameters: &[("fade", "maybe")], ..good }, "on, off");
    wrong(&ReflectionsInfo { frames_in_flight: 0, ..good }, "frames_in_flight");
    wrong(&ReflectionsInfo { extent: [0, 5], ..good }, "0x5");
    let mut lacking = engine.handles();
    lacking.enabled.vulkan13.synchronization2 = vk::FALSE;
    // SAFETY: refused before anything is made of it.
    let said = unsafe { Context::new(lacking) }.err().unwrap().to_string();
    assert!(said.contains("synchronization2"), "{said}");
    // All is as it was.
    assert!(engine.frame(&mut reflections, &theirs.input()).is_ok());
    gpu.check_validation().unwrap();
}

#[test]
fn constants_stand_for_images_and_passes_are_timed_and_skipped() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [64, 48]);
    let context = engine.context();
    let theirs = Theirs::new(&mut engine, &data, NATIVE);
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
    let nothing = FrameInput { reflectivity: FactorInput::Constant(0.0), ..input };
    let recorded = engine.frame(&mut reflections, &nothing).unwrap();
    assert!(recorded.reflection.is_none() && recorded.passes.iter().all(|p| p == "import"), "{:?}", recorded.passes);
    // Bytes are as good as halves for what needs no more.
    let bytes: Vec<u8> = data.roughness.iter().flat_map(|r| [(r * 255.0).round() as u8, 128, 0, 255]).collect();
    let image = engine.upload(BYTES, [64, 48], &bytes);
    let of = ImageInput::color(image.handle(), image.all().view(), BYTES, [64, 48]);
    let input = FrameInput {
        reflectivity: FactorInput::Channel(of, 1),
        roughness: FactorInput::Channel(of, 0),
        ..theirs.input()
    };
    assert!(engine.frame(&mut reflections, &input).unwrap().reflection.is_some());
    gpu.check_validation().unwrap();
}

#[test]
fn views_come_and_go_in_two_threads_and_leave_nothing() {
    let run = || {
        let gpu = own_gpu();
        let mut engine = Engine::new(&gpu);
        let data = view_of_rooms(&gpu, [33, 21]);
        let theirs = Theirs::new(&mut engine, &data, NATIVE);
        let context = engine.context();
        let mut held = Vec::new();
        for round in 0..3 {
            for method in ["unified", "ssct", "hzct"] {
                let mut reflections = Reflections::new(&context, &info(&data, method)).unwrap();
                for extent in [[8, 8], [33, 21]] {
                    reflections.resize(extent).unwrap();
                }
                for frame in 0..4 {
                    engine.frame(&mut reflections, &FrameInput { slot: frame % 2, ..theirs.input() }).unwrap();
                }
                held.push((round, context.allocated_bytes()));
            }
        }
        assert_eq!(context.allocated_bytes(), 0, "{held:?}");
        drop((theirs, engine));
        gpu.check_validation().unwrap();
    };
    std::thread::scope(|scope| {
        let one = scope.spawn(run);
        run();
        one.join().unwrap();
    });
}

/// Numbers of a file of the example.
fn numbers(path: &Path) -> Vec<f32> {
    std::fs::read(path).unwrap().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

/// The example as a user starts it, and the command on the images that it drew.
#[test]
fn the_example_shows_what_the_command_makes_of_its_images() {
    let program = std::env::current_exe().unwrap();
    let program = program.ancestors().nth(2).unwrap().join("examples/embed");
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(&program)
        .args(["out.png", "images"])
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
        .current_dir(folder.path())
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("VUID") && !said.contains("SYNC-"), "{said}");
    let of = |name: &str| numbers(&folder.path().join(format!("images/{name}.f32")));
    let camera = of("camera");
    let (clip, view) = camera.split_at(16);
    let (width, height) = (640, 360);
    let vectors =
        |name: &str, z: f32| of(name).as_chunks::<4>().0.iter().map(|t| Vec3::new(t[0], t[1], z * t[2])).collect();
    let material: Vec<Vec3> = vectors("material", 1.0);
    let turn = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let projection = Projection { scale: [clip[0], -clip[5]], shift: [0.0; 2], depth: [-clip[10], clip[14]] };
    let [near, far] = [clip[14] / (1.0 + clip[10]), clip[14] / clip[10]];
    let lens = Lens { fov_y_radians: 2.0 * (1.0 / projection.scale[1]).atan(), near_m: near, far_m: far };
    let data = GBufferData {
        width,
        height,
        camera: Camera {
            world_to_view: turn * Mat4::from_cols_slice(view),
            lens,
            aspect: projection.scale[1] / projection.scale[0],
            near_plane: None,
            projection: Some(projection),
        },
        depth: of("depth"),
        normal: vectors("normal", -1.0),
        reflectivity: material.iter().map(|m| m.x).collect(),
        roughness: material.iter().map(|m| m.y).collect(),
        color: vectors("color", 1.0),
        surface: vec![Surface::Lit; (width * height) as usize],
    };
    let file = folder.path().join("g.exr");
    std::fs::write(&file, ssct_lab::scene::gbuffer_file::encode(&data, &file).unwrap()).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_ssct"))
        .args(["gbuffer", "reflect", "g.exr", "--method", "unified", "-o", "r.exr"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let command = ssct_lab::report::images::read_image(&folder.path().join("r.exr")).unwrap();
    let embedded = of("composite");
    let shown: Vec<[f32; 3]> = embedded.as_chunks::<4>().0.iter().map(|t| [t[0], t[1], t[2]]).collect();
    let differ = shown.iter().zip(&command.rgb).filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).count();
    assert_eq!(differ, 0, "of {} pixels", shown.len());
    assert!(shown.iter().zip(of("color").as_chunks::<4>().0).any(|(a, b)| (a[0] - b[0]).abs() > 0.1), "it reflects");
}
