//! Tests a capture at the camera (`--captures camera`): it stands where the camera is in each frame, each frame has
//! passes that draw its six faces, and it shows things behind the camera.

use crate::common::folder::Folder;
use crate::common::{Builder, camera, check_validation, clutter, clutter_camera, gpu, unfaded};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, Gpu, Pixels, Watch};
use ssct::methods::setup::{BeyondScreen, CaptureCount};
use ssct::methods::{EffectParams, Fallback, Setup, Wants, find};
use ssct::passes::PathCode;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, Capture, Scene, View};
use ssct_truth::metrics::place::RayEnd;
use std::sync::Arc;

/// Size of the image in pixels.
const EXTENT: [u32; 2] = [80, 45];
/// Texels along each side of a face: the default, both of a scene's own captures and of the capture at the camera.
const SIDE: u32 = Capture::RESOLUTION;

/// The methods that look into captures, each with its fallback: by themselves, or as captures behind another method.
const LOOKING: [(&str, Fallback); 3] =
    [("unified", Fallback::None), ("captures", Fallback::None), ("dda", Fallback::Captures)];

/// Makes a shot of a scene in which every surface is a mirror.
fn shot(stage: &mut Stage, scene: &Scene, method: &str, camera: Camera, setup: &Setup, wants: Wants) -> Shot {
    let materials = Globals { roughness: Some(0.0), ..Globals::default() }.materials(scene, &View::default());
    Shot::new(stage, find(method).unwrap(), setup, wants, camera, materials).unwrap()
}

/// Returns a setup with a choice of captures and a fallback.
fn setup(captures: CaptureCount, fallback: Fallback) -> Setup {
    Setup::new(EXTENT).with(|p: &mut EffectParams| (p.captures, p.fallback) = (captures, fallback))
}

/// Draws one frame. Returns the values of the reflection, and the names of the passes that count for the method's time.
fn frame(stage: &mut Stage, shot: &Shot) -> (Vec<f32>, Vec<String>) {
    let (report, _, output) = stage.output_in(Mode::Timed, shot).unwrap();
    let pixels = gbuffer::reflection(&mut stage.context, &output).unwrap();
    let counted = report.passes.into_iter().filter(|p| p.counted).map(|p| p.name).collect();
    (pixels.values, counted)
}

/// The greatest allowed difference of two images of one view. Threads list rays in any order, and the colour that a ray
/// takes from captures may depend on its neighbours in the list, by the last bit of a 16-bit float below 1.
const LAST_BITS: f32 = 1.0 / 2048.0;

/// Returns the greatest difference of a value between two images.
fn farthest(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A frame with a capture at the camera equals one with a capture that stands still there, for each of three cameras in
/// turn. A face kept from an earlier camera would show. The six faces are further passes.
#[test]
fn it_follows_the_camera() {
    let gpu = gpu();
    let scene = clutter();
    let first = clutter_camera(EXTENT);
    let cameras = [first, camera(Vec3::new(-0.8, 1.7, -0.5), Vec3::new(1.0, 0.5, 5.0), EXTENT), first];
    for (method, fallback) in LOOKING {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let following_setup = setup(CaptureCount::Camera, fallback);
        let mut following = shot(&mut stage, &scene, method, first, &following_setup, Wants::REFLECTION);
        assert_eq!(following.prepared().captures, Vec::<[f32; 3]>::new(), "it has no place before the first frame");
        for camera in cameras {
            following.camera = camera;
            let (reflection, counted) = frame(&mut stage, &following);
            let (images, places) = following.captures().unwrap();
            assert_eq!((places.len(), images.places.len()), (1, 1), "{method}");
            assert_eq!((places[0].position, images.places[0].get()), (camera.eye(), camera.eye()), "{method}");
            assert_eq!(images.color.extent(), [SIDE; 2]);

            stage.set_captures(vec![Capture::placed_at(camera.eye())]);
            let standing = setup(CaptureCount::Auto, fallback);
            let standing = shot(&mut stage, &scene, method, camera, &standing, Wants::REFLECTION);
            let (expected, standing_passes) = frame(&mut stage, &standing);
            let difference = farthest(&reflection, &expected);
            assert!(difference <= LAST_BITS, "{method}: not what a capture at {} shows: {difference}", camera.eye());
            assert!(!standing_passes.iter().any(|name| name.starts_with("capture/")), "{standing_passes:?}");
            let without: Vec<_> = counted.iter().filter(|name| !name.starts_with("capture/")).cloned().collect();
            assert_eq!(without, standing_passes, "{method}: the other passes are the same");
            for pass in
                ["g-buffer/depth", "g-buffer", "lighting", "pyramid", "keep pyramid", "keep normal", "keep color"]
            {
                let name = format!("capture/{pass}");
                assert_eq!(counted.iter().filter(|n| **n == name).count(), 6, "{method}: {name}");
            }
        }
        let [start, .., end] = cameras.map(|camera| {
            following.camera = camera;
            frame(&mut stage, &following).0
        });
        let difference = farthest(&start, &end);
        assert!(difference <= LAST_BITS, "{method}: a frame depends on those before it: {difference}");
    }
    check_validation(&gpu).unwrap();
}

/// The wall behind the camera stands at this z, in metres.
const BEHIND_Z: f32 = -4.0;
/// The mirror stands at this z, in metres.
const MIRROR_Z: f32 = 3.0;

/// Returns a mirror in front of the camera, and a wall behind the camera. The red and green of the wall's picture tell
/// where on the wall a point lies.
fn facing_mirror() -> Scene {
    let mut b = Builder::new("behind");
    b.light(-Vec3::Z);
    let picture = b.picture(64, 64, |x, y| [(4 * x) as u8, (4 * y) as u8, 128]);
    b.quad(picture, Vec3::new(-16.0, -15.0, BEHIND_Z), Vec3::X * 32.0, Vec3::Y * 32.0, Vec3::Z);
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-1.5, 0.0, MIRROR_Z), Vec3::X * 3.0, Vec3::Y * 2.0, -Vec3::Z);
    b.0
}

/// Each pixel of the mirror shows the point of the wall that the mirror law gives, within 5 cm and within 0.05 of its
/// colour. The screen alone does not show the wall. A face that is mirrored or turned would show another point.
#[test]
fn a_mirror_shows_what_is_behind_the_camera_where_it_is() {
    let gpu = gpu();
    let scene = facing_mirror();
    for eye in [Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.4, 1.3, -1.0)] {
        let viewpoint = camera(eye, eye + Vec3::Z, EXTENT);
        for method in ["unified", "captures"] {
            let mut stage = Stage::new(&gpu, &scene).unwrap();
            let screen_only = unfaded(EXTENT);
            let with_capture = screen_only.with(|p: &mut EffectParams| {
                (p.captures, p.beyond) = (CaptureCount::Camera, BeyondScreen::Captures);
            });
            // Renders with a setup, and returns the reflection and the image of the hits.
            let shown = |stage: &mut Stage, setup: &Setup| -> (Pixels, Pixels) {
                let shot = shot(stage, &scene, method, viewpoint, setup, Wants::HITS);
                let (_, _, output) = stage.output(&shot).unwrap();
                let hits = stage.context.read(output.traced.hits.unwrap().0.all()).unwrap();
                (gbuffer::reflection(&mut stage.context, &output).unwrap(), hits)
            };
            let (reflection, hits) = shown(&mut stage, &with_capture);
            let data = {
                let drawn = shot(&mut stage, &scene, method, viewpoint, &with_capture, Wants::IMAGE);
                stage.draw(&drawn).unwrap();
                gbuffer::read(&mut stage.context, &drawn).unwrap()
            };
            let (to_view, to_world) = (data.view_to_clip().inverse(), viewpoint.world_to_view.as_dmat4().inverse());
            let ends = gbuffer::ray_ends(&hits, &data);
            let mut reflecting = 0;
            for (i, (end, color)) in ends.iter().zip(reflection.texels()).enumerate() {
                if !data.reflects(i) {
                    continue;
                }
                reflecting += 1;
                let [x, y] = [i as u32 % data.width, i as u32 / data.width].map(|v| f64::from(v) + 0.5);
                let place = data.unproject(x, y, f64::from(data.depth[i]), &to_view);
                let place = to_world.transform_point3(place).as_vec3();
                // The direction of the reflected ray: the mirror's normal is the z axis, so that z changes its sign.
                let along = (place - eye) * Vec3::new(1.0, 1.0, -1.0);
                let truth = place + along * ((BEHIND_Z - place.z) / along.z);
                let code = PathCode::from_channel(hits.texel(i as u32 % data.width, i as u32 / data.width)[3]);
                let RayEnd::Place(found) = end else { panic!("{method}: {code:?}, not on the wall") };
                let distance = found.as_vec3().distance(truth);
                assert!(code == Some(PathCode::Capture) && distance < 0.05, "{method}: {code:?}, {distance} m off");
                // The picture runs over 32 m from black to white, in sRGB.
                let encoded = |v: f32| ssct_ground::math::display_byte(v) as f32 / 255.0;
                let [u, v] = [(truth.x + 16.0) / 32.0, 1.0 - (truth.y + 15.0) / 32.0];
                let color_error = (encoded(color[0]) - u).abs().max((encoded(color[1]) - v).abs());
                assert!(color_error < 0.05, "{method}: {color:?} at {u}, {v}");
            }
            assert!(reflecting > 200, "{reflecting} pixels of the mirror");
            if method == "unified" {
                let (lost, _) = shown(&mut stage, &screen_only);
                assert!(lost.texels().all(|t| t[2] == 0.0), "the screen alone shows the wall behind the camera");
            }
        }
    }
    check_validation(&gpu).unwrap();
}

/// With a capture at a moving camera, four frames after the first one allocate no Vulkan object. Images that are made
/// anew in each frame would cost time and fill the memory.
#[test]
fn it_makes_no_object_in_the_steady_state() {
    let watch = Arc::<Watch>::default();
    let gpu = Gpu::open(&DeviceQuery { watch: Some(Arc::clone(&watch)), ..DeviceQuery::default() }).unwrap();
    let scene = clutter();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let following_setup = setup(CaptureCount::Camera, Fallback::None);
    let mut following = shot(&mut stage, &scene, "unified", clutter_camera(EXTENT), &following_setup, Wants::IMAGE);
    frame(&mut stage, &following);
    watch.arm(None);
    for n in 0..4 {
        following.camera = camera(Vec3::new(0.1 * n as f32, 1.4, 0.0), Vec3::new(0.0, 1.0, 6.0), EXTENT);
        stage.run(&following, Mode::Timed).unwrap();
    }
    assert_eq!(watch.calls()[0], 0, "allocations");
}

/// `--captures camera` works with `render`, `motion` and `path`. It is refused for a G-buffer file, which has no scene
/// to draw, and beside `--captures-per-frame`, since each frame draws all six faces already.
#[test]
fn the_command_takes_it_and_says_where_it_cannot_be() {
    let folder = Folder::new();
    let refused = |args: &[&str], words: &str| {
        let output = folder.run(args);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
        assert!(message.contains(words) && !message.contains("panicked"), "{args:?}: {message}");
    };
    let small = ["--scene", "rooms", "--size", "48x27"];
    folder.succeed(&[&["gbuffer", "export", "view.exr"], &small[..]].concat());
    let on_file = ["gbuffer", "reflect", "view.exr", "--method", "unified", "--captures", "camera", "-o", "image.png"];
    refused(&on_file, "a G-buffer has no scene to be captured");
    let render = [&["render", "--method", "unified", "--captures", "camera", "-o", "image.png"], &small[..]].concat();
    folder.succeed(&[&render, &["--capture-side", "128"][..]].concat());
    refused(&[&render, &["--captures-per-frame", "6"][..]].concat(), "drawn anew in each frame");
    let camera = ["--captures", "camera", "--capture-side", "128"];
    let motion = ["motion", "--view", "window", "--method", "unified", "--frames", "2", "--rays", "2", "--json"];
    let records = folder.succeed(&[&motion, &small[..], &camera].concat());
    let records: Vec<serde_json::Value> = serde_json::from_str(&records).unwrap();
    assert!(!records.is_empty());
    for record in &records {
        assert_eq!(record["setup"]["captures"], "camera");
        assert!(record["flicker"].is_number(), "{record}");
    }
    let path = ["path", "--method", "unified", "--frames", "3", "--warmup", "1", "-o", "path"];
    folder.succeed(&[&path, &small[..], &camera].concat());
}
