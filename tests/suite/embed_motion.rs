//! Tests motion through the door: if the caller hands over motion, the history of a mesh that moves is that of the
//! laboratory, which knows where meshes stand.

use crate::common::engine::{Engine, ForeignGBuffer, NATIVE, bits, info, plain_rooms, triangles_of};
use crate::common::gpu;
use ash::vk;
use glam::{Vec2, Vec3, Vec4Swizzles};
use ssct::gpu::{Image, Pixels};
use ssct::methods::setup::{BeyondScreen, HistoryUse};
use ssct::methods::unified::{FirstTraced, HitColor, UnifiedParams};
use ssct::methods::{EffectParams, Setup, Wants, find};
use ssct::{FrameInput, ImageInput, MotionInput, Reflections, ReflectionsInfo};
use ssct_ground::scene::{Aabb, Camera};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{GBufferData, Scene, View};
use ssct_truth::metrics::image::masked_rmse;

/// Size of the images in pixels.
const EXTENT: [u32; 2] = [161, 91];

/// The format of images of motion: two 32-bit floats a pixel.
const MOTION_FORMAT: vk::Format = vk::Format::R32G32_SFLOAT;

/// The parameters that the door gets; `setup` sets the same for the laboratory.
const PARAMETERS: [(&str, &str); 3] = [("history", "on"), ("history-frames", "8"), ("first", "screen")];

/// Returns the laboratory's setup, with the same parameters as `PARAMETERS`.
fn setup() -> Setup {
    Setup::new(EXTENT)
        .with(|p: &mut EffectParams| (p.history, p.history_frames) = (HistoryUse::On, 8))
        .with(|p: &mut EffectParams| p.beyond = BeyondScreen::Triangles)
        .with(|p: &mut UnifiedParams| (p.first, p.hit_color) = (FirstTraced::Screen, HitColor::Screen))
}

/// A frame of a film: the G-buffer and the scene that the laboratory drew, and the reflection that it made of them.
struct Moment {
    data: GBufferData,
    /// The bounds of the mesh that moves, and its way since the frame before, in metres.
    mover_bounds: Aabb,
    mover_step: Vec3,
    scene: Scene,
    reflection: Vec<[f32; 3]>,
}

/// Returns the rooms with another colour for each material.
fn painted_rooms() -> Scene {
    let mut scene = plain_rooms();
    for (n, material) in scene.materials.iter_mut().enumerate() {
        let part = |step: f32| 0.1 + 0.9 * (step * n as f32).fract();
        material.albedo = Vec3::new(part(0.618), part(0.382), part(0.271));
    }
    scene
}

/// Returns the camera by its matrix alone, as the door knows it.
fn by_matrix(camera: &Camera) -> Camera {
    Camera::of_projection(camera.world_to_view, camera.projection_numbers())
}

/// Renders a film of a mesh of the rooms, by the laboratory. The meshes called `name` move by `step` metres in each of
/// the first frames and then rest; the last argument has the two numbers of frames.
fn film(view: &View, name: &str, step: Vec3, [moving, resting]: [u32; 2]) -> Vec<Moment> {
    let gpu = gpu();
    let scene = painted_rooms();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let mut materials = Globals { roughness: Some(0.1), ..Globals::default() }.materials(&scene, view);
    materials.iter_mut().for_each(|m| m.reflectivity = 0.5);
    let camera = by_matrix(&view.camera(&scene, EXTENT));
    let mut shot =
        Shot::new(&mut stage, find("unified").unwrap(), &setup(), Wants::REFLECTION, camera, materials).unwrap();
    shot.camera = camera;
    let mut moments = Vec::new();
    for n in 0..=moving + resting {
        let offset = step * n.min(moving) as f32;
        stage.scene_mut().place_meshes(name, offset).unwrap();
        let (_, _, output) = stage.output(&shot).unwrap();
        let image = gbuffer::reflection(&mut stage.context, &output).unwrap();
        let mut placed = scene.clone();
        placed.meshes.iter_mut().filter(|m| m.name == name).for_each(|m| m.translate(offset));
        let bounds = placed.meshes.iter().filter(|m| m.name == name).fold(Aabb::default(), |b, m| b.union(m.bounds));
        moments.push(Moment {
            data: gbuffer::read(&mut stage.context, &shot).unwrap(),
            mover_bounds: bounds,
            mover_step: if (1..=moving).contains(&n) { step } else { Vec3::ZERO },
            scene: placed,
            reflection: colors(&image),
        });
    }
    gpu.check_validation().unwrap();
    moments
}

/// Returns the colours of an image without the fourth channel.
fn colors(image: &Pixels) -> Vec<[f32; 3]> {
    image.texels().map(|t| [t[0], t[1], t[2]]).collect()
}

/// Returns, for each pixel, its centre in pixels and the point that it shows_mover, in world space.
fn places(data: &GBufferData) -> impl Iterator<Item = (Vec2, Vec3)> {
    let to_clip = data.camera.view_to_clip_reversed() * data.camera.world_to_view;
    let place = move |(i, depth): (usize, &f32)| {
        let pixel = Vec2::new((i as u32 % data.width) as f32 + 0.5, (i as u32 / data.width) as f32 + 0.5);
        let ndc = (pixel / size() * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
        (pixel, to_clip.inverse().project_point3(ndc.extend(depth.max(1e-6))))
    };
    data.depth.iter().enumerate().map(place)
}

/// Returns the size of the images as a vector.
fn size() -> Vec2 {
    Vec2::from(EXTENT.map(|side| side as f32))
}

/// Returns, for each pixel, whether it shows_mover the mesh that moves.
fn shows_mover(moment: &Moment) -> Vec<bool> {
    let inside = moment.mover_bounds.grown(0.01);
    let is_in = |place: Vec3| place.cmpge(inside.min).all() && place.cmple(inside.max).all();
    places(&moment.data).map(|(_, place)| is_in(place)).collect()
}

/// Returns the motion of each pixel: the way from where its surface is seen to where it was seen in the frame before,
/// in pixels.
fn ways(moment: &Moment) -> Vec<Vec2> {
    let to_clip = moment.data.camera.view_to_clip_reversed() * moment.data.camera.world_to_view;
    let way = |((pixel, place), moves): ((Vec2, Vec3), bool)| {
        let before = to_clip * (if moves { place - moment.mover_step } else { place }).extend(1.0);
        (before.xy() / before.w * Vec2::new(1.0, -1.0) + 1.0) * 0.5 * size() - pixel
    };
    places(&moment.data).zip(shows_mover(moment)).map(way).collect()
}

/// Returns the reflections that the door makes of a film, with motion stored in units of `scale` pixels, or without
/// motion.
fn through_the_door(film: &[Moment], scale: Option<[f32; 2]>) -> Vec<Pixels> {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let context = engine.context();
    let first = triangles_of(&engine, &film[0].scene);
    let reflections_info =
        ReflectionsInfo { triangles: Some(&first), parameters: &PARAMETERS, ..info(&film[0].data, "unified") };
    let mut reflections = Reflections::new(&context, &reflections_info).unwrap();
    let mut reflections_made = Vec::new();
    for moment in film {
        let theirs = ForeignGBuffer::new(&mut engine, &moment.data, NATIVE);
        let triangles = triangles_of(&engine, &moment.scene);
        // Where nothing moves, no motion is given.
        let scale = scale.filter(|_| moment.mover_step != Vec3::ZERO);
        let image = scale.map(|[x, y]| {
            let stored: Vec<[f32; 2]> = ways(moment).iter().map(|way| [way.x / x, way.y / y]).collect();
            engine.upload(MOTION_FORMAT, EXTENT, bytemuck::cast_slice(&stored))
        });
        let motion = image.as_ref().zip(scale).map(|(image, scale)| motion(image, scale));
        let input = FrameInput { triangles: Some(&triangles), motion, ..theirs.input() };
        let recorded = engine.frame(&mut reflections, &input).unwrap();
        reflections_made.push(engine.read(&recorded.reflection.unwrap()));
    }
    gpu.check_validation().unwrap();
    reflections_made
}

/// Returns an image of motion as an input of the door.
fn motion(image: &Image, scale: [f32; 2]) -> MotionInput {
    let image = ImageInput::color(image.handle(), image.all().view(), image.format(), image.extent());
    MotionInput { image, scale, jittered: false }
}

/// Returns the RMSE between the door's reflection and the laboratory's in a frame, over the pixels that show the moving
/// mesh.
fn mover_error(film: &[Moment], reflections: &[Pixels], frame: usize) -> f64 {
    let mask = shows_mover(&film[frame]);
    assert!(mask.iter().filter(|m| **m).count() > 30, "nothing that moves is seen");
    masked_rmse(&film[frame].reflection, &colors(&reflections[frame]), &mask)
}

/// A ball rolls for six frames and rests for six. With motion, the door's reflections are less than half as far off the
/// laboratory's as without. Another sign or unit of the motion changes no bit.
#[test]
fn a_moved_reflector_with_motion_given_is_what_the_laboratory_makes_of_it() {
    let scene = painted_rooms();
    let view = scene.view("corridor").unwrap().clone();
    let film = film(&view, "ball", Vec3::new(-0.06, 0.0, -0.06), [6, 6]);
    let [with_motion, without_motion] = [Some([1.0, 1.0]), None].map(|scale| through_the_door(&film, scale));
    let mean = |reflections: &[Pixels]| {
        (1..film.len()).map(|n| mover_error(&film, reflections, n)).sum::<f64>() / (film.len() - 1) as f64
    };
    let [off_with, off_without] = [mean(&with_motion), mean(&without_motion)];
    println!("{off_with:.4} off with motion, {off_without:.4} without");
    assert!(off_with < 0.5 * off_without, "{off_with} with motion, {off_without} without");
    // In frame 3, the door's reflection in the rolling ball is the laboratory's, but for 0.001.
    let [error_with, error_without] =
        [&with_motion, &without_motion].map(|reflections| mover_error(&film, reflections, 3));
    assert!(error_with < 1e-3 && error_without > 0.05, "{error_with} with motion, {error_without} without");
    // Motion may be stored with either sign and in any unit.
    let scaled = through_the_door(&film[..6], Some([-2.0, 0.5]));
    assert!(bits(&scaled[5]) == bits(&with_motion[5]));
}

/// Images of motion of a wrong size, format or scale are refused. Motion of NaN moves nothing, and no value becomes
/// infinite or NaN, which a history would keep for all later frames.
#[test]
fn motion_that_cannot_be_read_is_refused_with_a_sentence() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = crate::common::engine::view_of_rooms(&gpu, [34, 25]);
    let context = engine.context();
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let reflections_info = ReflectionsInfo { parameters: &PARAMETERS[..1], ..info(&data, "unified") };
    let mut reflections = Reflections::new(&context, &reflections_info).unwrap();
    let not_numbers = vec![[f32::NAN; 2]; 34 * 25];
    let image = engine.upload(MOTION_FORMAT, [34, 25], bytemuck::cast_slice(&not_numbers));
    let good = motion(&image, [1.0, 1.0]);
    let mut refused = |change: &dyn Fn(&mut MotionInput), words: &str| {
        let mut motion = good;
        change(&mut motion);
        let input = FrameInput { motion: Some(motion), ..theirs.input() };
        let message = engine.frame(&mut reflections, &input).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(words), "{words}: {message:?}");
    };
    refused(&|m| m.image.extent = [34, 26], "the input motion is 34x26 pixels; it must be 34x25");
    refused(
        &|m| m.image.format = vk::Format::R32_SFLOAT,
        "the input motion has the format R32_SFLOAT, which has no green",
    );
    refused(&|m| m.image.format = vk::Format::R16G16_UNORM, "holds no number below 0");
    refused(&|m| m.image.format = vk::Format::R16G16_SINT, "floats");
    refused(&|m| m.scale = [1.0, 0.0], "the input motion has the scale [1.0, 0.0]");
    refused(&|m| m.scale = [f32::NAN, 1.0], "finite");
    // Motion of NaN counts as no motion.
    let input = FrameInput { motion: Some(good), ..theirs.input() };
    for _ in 0..3 {
        let recorded = engine.frame(&mut reflections, &input).unwrap();
        let reflection = engine.read(&recorded.reflection.unwrap());
        assert!(reflection.values.iter().all(|v| v.is_finite()));
    }
    gpu.check_validation().unwrap();
}

/// The projection is jittered from frame to frame and nothing moves. Motion that includes the jitter and is declared so
/// gives the image of motion without jitter, to the bit. Motion that includes it undeclared does not.
#[test]
fn jitter_is_no_motion_whether_the_ways_hold_it_or_not() {
    let gpu = gpu();
    let scene = painted_rooms();
    let view = scene.view("corridor").unwrap().clone();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let materials = Globals { roughness: Some(0.1), ..Globals::default() }.materials(&scene, &view);
    let still = by_matrix(&view.camera(&scene, EXTENT));
    let shifts = [Vec2::ZERO, Vec2::new(3.0, -2.0), Vec2::new(-2.0, 1.0), Vec2::new(1.0, 3.0)];
    let mut shot =
        Shot::new(&mut stage, find("unified").unwrap(), &Setup::new(EXTENT), Wants::IMAGE, still, materials).unwrap();
    let frames: Vec<GBufferData> = shifts
        .iter()
        .map(|shift| {
            shot.camera = still.jittered(shift.to_array(), EXTENT);
            stage.draw(&shot).unwrap();
            gbuffer::read(&mut stage.context, &shot).unwrap()
        })
        .collect();
    let mut engine = Engine::new(&gpu);
    let context = engine.context();
    // The last frame's reflection, with motion that includes the jitter or not, and is declared to include it or not.
    let mut show = |is_included: bool, jittered: bool| {
        let reflections_info = ReflectionsInfo { parameters: &PARAMETERS[..2], ..info(&frames[0], "unified") };
        let mut reflections = Reflections::new(&context, &reflections_info).unwrap();
        let mut last = None;
        for (n, data) in frames.iter().enumerate() {
            let theirs = ForeignGBuffer::new(&mut engine, data, NATIVE);
            let difference = if is_included && n > 0 { shifts[n - 1] - shifts[n] } else { Vec2::ZERO };
            let ways = vec![difference.to_array(); data.depth.len()];
            let image = engine.upload(MOTION_FORMAT, EXTENT, bytemuck::cast_slice(&ways));
            let motion = MotionInput { jittered, ..motion(&image, [1.0, 1.0]) };
            let input = FrameInput { motion: Some(motion), ..theirs.input() };
            let recorded = engine.frame(&mut reflections, &input).unwrap();
            last = Some(engine.read(&recorded.reflection.unwrap()));
        }
        bits(&last.unwrap())
    };
    let [without, declared, undeclared] =
        [(false, false), (true, true), (true, false)].map(|(is_included, is_declared)| show(is_included, is_declared));
    assert!(without == declared, "the difference of the jitter is taken into account");
    assert!(without != undeclared, "and it counts");
    gpu.check_validation().unwrap();
}
