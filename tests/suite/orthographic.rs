//! Tests orthographic cameras, off-axis ones, and two views of one frame (docs/definitions.md, "Spaces"). `unified`
//! hits what the oracle says, is its twin to the bit, and among triangles hits what the world says. The door takes
//! other renderers' cameras, and methods that need a perspective say so.

use crate::common::engine::{Convention, Engine, ForeignGBuffer, NATIVE, bits, info, rmse};
use crate::common::folder::Folder;
use crate::common::{check_validation, clutter, gpu, is_gpu_assisted};
use crate::{gloss_twin, triangles, unified as on_screen};
use glam::{Mat4, Vec3};
use ssct::gpu::frame::Mode;
use ssct::gpu::{Gpu, Pixels};
use ssct::methods::setup::{BeyondScreen, CaptureCount, HistoryUse};
use ssct::methods::unified::FirstTraced;
use ssct::methods::{self, Effect, EffectParams, Fallback, METHODS, Setup, Wants, unified};
use ssct::{ClipY, ProjectionKind, Reflections};
use ssct_ground::math::OracleVersion;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, Capture, GBufferData, Lens, Projection, Scene, View};

/// Returns a view of a built-in scene along parallel lines, `height_m` metres high.
fn parallel(scene: &Scene, eye: Vec3, look_at: Vec3, height_m: f32) -> View {
    let lens = Some(Lens::orthographic(height_m, 0.0, 60.0));
    View { name: format!("{} from {eye}", scene.name), eye, look_at, lens, ..View::default() }
}

/// Returns scenes with orthographic views: down at an angle, along an axis, down at the car of the street, and straight
/// down.
fn views() -> Vec<(Scene, View)> {
    let parallel_view = |name: &str, eye: [f32; 3], look_at: [f32; 3], height_m| {
        let scene = crate::common::built_in(name);
        let view = parallel(&scene, eye.into(), look_at.into(), height_m);
        (scene, view)
    };
    let eye_and_target = |name: &str, view: &str| {
        let scene = crate::common::built_in(name);
        let view = scene.view(view).unwrap();
        (view.eye, view.look_at)
    };
    let (corridor, ahead) = eye_and_target("rooms", "corridor");
    let along = ahead - corridor;
    let axis = if along.x.abs() > along.z.abs() { Vec3::X * along.x.signum() } else { Vec3::Z * along.z.signum() };
    let (street, car) = eye_and_target("street", "car");
    let (hall, _) = eye_and_target("atrium", "hall");
    vec![
        parallel_view("rooms", corridor.to_array(), (corridor + axis - 0.4 * Vec3::Y).to_array(), 3.0),
        parallel_view("rooms", corridor.to_array(), (corridor + axis).to_array(), 2.5),
        parallel_view(
            "street",
            (car + 12.0 * (street - car).normalize() + 9.0 * Vec3::Y).to_array(),
            car.to_array(),
            9.0,
        ),
        parallel_view("atrium", (hall + 2.0 * Vec3::Y).to_array(), (hall - Vec3::Y).to_array(), 6.0),
    ]
}

/// Returns the camera with its window moved aside and with pixels that are not square.
fn off_axis(camera: Camera) -> Camera {
    let clip = camera.view_to_clip_reversed();
    let kind = camera.kind();
    // The order of the two numbers depends on the kind (`Projection::depth`).
    let depth = match kind {
        ProjectionKind::Perspective => [clip.z_axis.z, clip.w_axis.z],
        ProjectionKind::Orthographic => [clip.w_axis.z, clip.z_axis.z],
    };
    let projection =
        Projection { kind, scale: [1.3 * clip.x_axis.x, 0.8 * clip.y_axis.y], shift: [0.31, -0.17], depth };
    Camera::of_projection(camera.world_to_view, projection)
}

/// Draws the G-buffer that a camera sees of a scene.
fn seen(gpu: &Gpu, scene: &Scene, camera: Camera, globals: &Globals, extent: [u32; 2]) -> GBufferData {
    let mut stage = Stage::new(gpu, scene).unwrap();
    let materials = globals.materials(scene, &View::default());
    let shot = Shot::new(&mut stage, &unified::INFO, &Setup::new(extent), Wants::IMAGE, camera, materials).unwrap();
    stage.run(&shot, Mode::Plain).unwrap();
    gbuffer::read(&mut stage.context, &shot).unwrap()
}

/// In each view, plain and off-axis, by both versions of the oracle, `unified` agrees with the oracle in at least 99.99
/// % of the reflecting pixels, and path codes are right in 99.9 %. Code for perspectives divides by depth, which is
/// wrong here.
#[test]
fn unified_hits_what_the_oracle_says() {
    let gpu = gpu();
    // GPU-assisted validation is slow, so that one view must do.
    let most_views = if is_gpu_assisted() { 1 } else { usize::MAX };
    for (scene, view) in views().iter().take(most_views) {
        let mut stage = Stage::new(&gpu, scene).unwrap();
        for (extent, moved) in [([321, 239], false), ([480, 270], true)] {
            let camera = view.camera(scene, extent);
            let camera = if moved { off_axis(camera) } else { camera };
            for oracle in [OracleVersion::V1, OracleVersion::V2] {
                let camera_and_materials = (camera, on_screen::flat_mirrors(scene, view));
                let (found, reasons, unfinished) =
                    on_screen::agreement(&mut stage, camera_and_materials, extent, oracle);
                let share = found.hit_agreement.expect("something reflects");
                let (pixels, missed) = (found.pixels, found.missed.unwrap_or(0.0));
                println!(
                    "{} {extent:?} moved {moved} {oracle:?}: {:.4} % of {pixels}, missed {missed:.1e}, reasons {:.3} %",
                    view.name,
                    100.0 * share,
                    100.0 * reasons
                );
                assert!(pixels > 5000 && share >= 0.9999, "{} {extent:?}: {found:?}", view.name);
                assert!(reasons >= 0.999 && unfinished == 0, "{}: {reasons} {unfinished}", view.name);
            }
        }
    }
    check_validation(&gpu).unwrap();
}

/// A perspective camera with a moved window agrees with the oracle in at least 99.99 % of the reflecting pixels. A
/// projection that is taken to be symmetric would shift all rays.
#[test]
fn an_off_axis_perspective_hits_what_the_oracle_says() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let extent = [321, 239];
    let camera_and_materials = (off_axis(view.camera(&scene, extent)), on_screen::flat_mirrors(&scene, view));
    let (found, reasons, unfinished) =
        on_screen::agreement(&mut stage, camera_and_materials, extent, OracleVersion::V1);
    assert!(found.hit_agreement.unwrap() >= 0.9999 && reasons >= 0.999 && unfinished == 0, "{found:?}");
    check_validation(&gpu).unwrap();
}

/// For orthographic and off-axis cameras over random G-buffers and one view, at five sizes and by both versions of the
/// oracle, pyramid and hits are the twin's, to the bit.
#[test]
fn pyramid_and_hits_equal_their_twin_to_the_bit() {
    let gpu = gpu();
    let (scene, view) = views().swap_remove(0);
    let mirrors = Globals { roughness: Some(0.0), ..Globals::default() };
    let mut totals = [0; 3];
    let sizes = [[1, 1], [53, 1], [5, 3], [65, 127], [321, 239]];
    for extent in sizes.into_iter().take(if is_gpu_assisted() { 3 } else { usize::MAX }) {
        let camera = view.camera(&scene, extent);
        let mut parallel: Vec<GBufferData> = (0..4).map(|kind| on_screen::random_gbuffer(kind, extent)).collect();
        parallel.iter_mut().for_each(|data| data.camera = camera);
        parallel.push(seen(&gpu, &scene, camera, &mirrors, extent));
        let moved: Vec<GBufferData> =
            parallel.iter().map(|data| GBufferData { camera: off_axis(camera), ..data.clone() }).collect();
        let random = on_screen::random_gbuffer(0, extent);
        let perspective = GBufferData { camera: off_axis(random.camera), ..random };
        for data in parallel.iter().chain(&moved).chain([&perspective]) {
            for oracle in [OracleVersion::V1, OracleVersion::V2] {
                let counts = on_screen::check_twin(&gpu, data, oracle);
                totals = [0, 1, 2].map(|i| totals[i] + counts[i]);
            }
        }
    }
    println!("pixels, hits and blocks met from behind: {totals:?}, 0 ULP");
    let [pixels, hits, met_from_behind] = totals;
    assert!(hits > pixels / 10 && met_from_behind > 0, "{totals:?}");
    check_validation(&gpu).unwrap();
}

/// The glossy passes equal their twins with an orthographic camera, at three roughnesses and with mixed ones. One of
/// the cameras is off-axis. Footprints and directions of sight are other ones than in a perspective.
#[test]
fn every_glossy_pass_is_its_twin() {
    use OracleVersion::{V1, V2};
    let gpu = gpu();
    let (scene, view) = views().swap_remove(0);
    let extent = [127, 61];
    let mut totals = gloss_twin::Counts::default();
    for (n, (roughness, deviation)) in [(0.1, 1.0), (0.3, 0.0), (0.6, 1.0)].into_iter().enumerate() {
        let globals = Globals { roughness: Some(roughness), normal_deviation: Some(deviation), ..Globals::default() };
        let camera = view.camera(&scene, extent);
        let camera = if n == 1 { off_axis(camera) } else { camera };
        let data = seen(&gpu, &scene, camera, &globals, extent);
        for (data, is_of_one_kind) in [(&data, true), (&gloss_twin::mixed(&data, 5), false)] {
            for (oracle, tiles, over) in [(V1, !is_of_one_kind, false), (V2, true, true)] {
                let mode = gloss_twin::DrawMode { oracle, tiles, over };
                let counts = gloss_twin::check(data, &gloss_twin::draw(&gpu, data, mode), mode);
                println!(
                    "roughness {roughness}, {mode:?}: {:?}",
                    counts.map(|count| [count.all, count.hits, count.ties, count.wrong])
                );
                assert!(counts.iter().all(|count| count.wrong == 0), "roughness {roughness}, {mode:?}");
                totals.iter_mut().zip(counts).for_each(|(total, count)| {
                    (total.all, total.hits) = (total.all + count.all, total.hits + count.hits)
                });
            }
        }
    }
    assert!(totals.iter().all(|total| total.hits > 500), "{totals:?}");
    check_validation(&gpu).unwrap();
}

/// In each view, at most one ray in 200 of `traced` ends elsewhere than the triangles say, and at most one in 50 if the
/// screen is asked first.
#[test]
fn traced_rays_end_where_the_world_says() {
    let gpu = gpu();
    for (mut scene, view) in views() {
        let name = view.name.clone();
        scene.views.push(view);
        let materials = triangles::mirrors(&scene, &name);
        let drawing =
            |method, setup: &Setup| triangles::draw(&gpu, (&scene, &name), materials.clone(), (method, setup), false);
        let traced_image = drawing(triangles::traced(), &Setup::new(triangles::EXTENT));
        let (rays, wrong) = triangles::against_world(&traced_image, &scene, &materials);
        println!("{name}: {wrong} of {rays}");
        assert!(rays > 1000 && wrong * 200 <= rays, "{name}: {wrong} of {rays} end elsewhere");
        let screen_first = drawing(&unified::INFO, &triangles::beyond(FirstTraced::Screen));
        let (rays, wrong) = triangles::against_world(&screen_first, &scene, &materials);
        println!("{name}, the screen first: {wrong} of {rays}");
        assert!(rays > 1000 && wrong * 50 <= rays, "{name}: {wrong} of {rays} end elsewhere");
    }
    check_validation(&gpu).unwrap();
}

/// Returns the cluttered scene and a view of it from above, along parallel lines.
fn clutter_from_above() -> (Scene, View) {
    let scene = clutter();
    let view = parallel(&scene, Vec3::new(0.0, 6.0, -2.0), Vec3::new(0.0, 0.0, 8.0), 9.0);
    (scene, view)
}

/// Returns the reflection that a method makes of a view at one roughness, with a camera at rest.
fn reflection(
    gpu: &Gpu,
    (scene, view): &(Scene, View),
    (method, roughness): (&str, f32),
    change: impl FnOnce(&mut EffectParams),
) -> Pixels {
    let mut stage = Stage::new(gpu, scene).unwrap();
    let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(scene, view);
    let setup = Setup::on_screen(triangles::EXTENT).with(change);
    let camera = view.camera(scene, triangles::EXTENT);
    let method = methods::find(method).unwrap();
    let shot = Shot::new(&mut stage, method, &setup, Wants::REFLECTION, camera, materials).unwrap();
    let (_, _, output) = stage.output_at_rest(&shot).unwrap();
    gbuffer::reflection(&mut stage.context, &output).unwrap()
}

/// Returns the colour that is added to the lit colour, before reflectivity, in each pixel. Panics if a value is
/// negative, infinite or NaN.
fn added(image: &Pixels) -> Vec<Vec3> {
    assert!(image.values.iter().all(|v| v.is_finite() && *v >= 0.0));
    image.texels().map(|t| t[3] * Vec3::from_slice(t)).collect()
}

/// Returns the mean of the added colours, as a sum of three channels.
fn brightness(image: &Pixels) -> f32 {
    let colors = added(image);
    colors.iter().map(|c| c.element_sum()).sum::<f32>() / colors.len() as f32
}

/// With an orthographic camera, a history keeps the mean brightness within 5 % and half resolution within 35 %. A
/// history at rest leaves mirrors unchanged.
#[test]
fn what_surrounds_a_method_takes_parallel_lines_of_sight() {
    let gpu = gpu();
    let clutter_view = clutter_from_above();
    for roughness in [0.0, 0.1, 0.4] {
        let image = |change: fn(&mut EffectParams)| reflection(&gpu, &clutter_view, ("unified", roughness), change);
        let plain = image(|_| ());
        let history = image(|p| p.history = HistoryUse::On);
        let half = image(|p| p.resolution_scale = 0.5);
        let brightnesses = [&plain, &history, &half].map(brightness);
        let [of_history, of_half] = [brightnesses[1], brightnesses[2]].map(|b| b / brightnesses[0]);
        let pairs = added(&plain).into_iter().zip(added(&history));
        let greatest_difference = pairs.map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f32::max);
        println!("roughness {roughness}: plain, history, half: {brightnesses:?}; {greatest_difference} apart");
        assert!(brightnesses[0] > 0.02, "it shows something: {brightnesses:?}");
        assert!((of_history - 1.0).abs() < 0.05, "{brightnesses:?}");
        // Blocks of larger pixels are thicker, so that more rays hit. In perspective, mirrors at this place are a third
        // brighter.
        assert!((of_half - 1.0).abs() < 0.35, "{brightnesses:?}");
        // A camera at rest finds each point where it was; the one ray of a mirror is the same in all frames.
        assert!(roughness > 0.0 || greatest_difference < 2e-3, "{greatest_difference}");
    }
    check_validation(&gpu).unwrap();
}

/// With an orthographic camera, captures alone, behind and beyond the screen have the brightness of traced rays within
/// 15 %, and over 1.5 times that of the screen alone. `pccm` shows something. The faces of captures are perspectives
/// themselves.
#[test]
fn captures_and_cube_maps_take_parallel_lines_of_sight() {
    let gpu = gpu();
    let (mut scene, view) = clutter_from_above();
    scene.captures = [[0.0, 6.0, 4.0], [0.0, 4.0, 14.0]].map(|place| Capture::placed_at(place.into())).to_vec();
    let clutter_view = (scene, view);
    let brightness_of =
        |method, change: fn(&mut EffectParams)| brightness(&reflection(&gpu, &clutter_view, (method, 0.0), change));
    let truth = brightness_of("traced", |_| ());
    let captures = brightness_of("captures", |p| p.captures = CaptureCount::Auto);
    let behind = brightness_of("unified", |p| (p.fallback, p.captures) = (Fallback::Captures, CaptureCount::Auto));
    let beyond = brightness_of("unified", |p| (p.beyond, p.captures) = (BeyondScreen::Captures, CaptureCount::Auto));
    let screen = brightness_of("unified", |_| ());
    println!("traced {truth}, captures {captures}, behind {behind}, beyond {beyond}, screen {screen}");
    for (name, shown) in [("captures", captures), ("behind", behind), ("beyond", beyond)] {
        assert!((shown / truth - 1.0).abs() < 0.15 && shown > 1.5 * screen, "{name}: {shown} beside {truth}");
    }
    let rooms = views().swap_remove(0);
    let local = brightness(&reflection(&gpu, &rooms, ("pccm", 0.0), |_| ()));
    assert!(local > 0.05, "{local}");
    check_validation(&gpu).unwrap();
}

/// Six methods take an orthographic camera, and all others refuse with a sentence that names a method which does. An
/// effect that was made for a perspective refuses an orthographic camera.
#[test]
fn methods_that_need_a_perspective_say_so() {
    let gpu = gpu();
    let (scene, view) = views().swap_remove(0);
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let (mut taken, mut refused) = (Vec::new(), 0);
    for method in METHODS {
        let camera = view.camera(&scene, [32, 32]);
        let materials = Globals::default().materials(&scene, &view);
        match Shot::new(&mut stage, method, &Setup::new([32, 32]), Wants::IMAGE, camera, materials) {
            Ok(shot) => {
                stage.run(&shot, Mode::Plain).unwrap();
                taken.push(method.name);
            }
            Err(error) => {
                let message = error.to_string();
                let is_right = message.contains(method.name) && message.contains("needs a perspective");
                assert!(is_right && message.contains("unified") && matches!(error, ssct::Error::Usage(_)), "{message}");
                refused += 1;
            }
        }
    }
    assert_eq!(taken, ["local-map", "pccm", "environment", "captures", "traced", "unified"]);
    assert_eq!(refused + taken.len(), METHODS.len());
    let mut context = ssct::gpu::FrameContext::new(&gpu).unwrap();
    let effect = Effect::new(&mut context, &unified::INFO, &Setup::on_screen([32, 32]), Wants::IMAGE, None).unwrap();
    let data = seen(&gpu, &scene, view.camera(&scene, [32, 32]), &Globals::default(), [32, 32]);
    let images = ssct::passes::gbuffer::GBufferImages::upload(&mut context, &data).unwrap();
    let mut frame = context.begin(Mode::Plain).unwrap();
    let message = effect.record(&mut frame, &methods::Input::of_screen(images.gbuffer(), &data.camera)).err().unwrap();
    assert!(message.to_string().contains("the camera is orthographic"), "{message}");
}

/// Six commands with an orthographic camera and no named method measure the methods that take such a camera, and name
/// the others in one line. An error at the first other method would end the study.
#[test]
fn studies_without_named_methods_leave_out_those_that_need_a_perspective() {
    let folder = Folder::new();
    folder.write_boards(".", &["ahead", "again"]);
    let aimed = ["--eye", "1,0,-3", "--look-at", "1,-0.5,0"];
    let scene = ["--scene", "boards.scene.toml", "--size", "16x16"];
    let options = [&scene[..], &["--roughness", "0", "--capture-side", "128", "--json"]].concat();
    for (command, taken) in [
        ([&["time", "--samples", "1", "--warmup", "0"], &aimed[..]].concat(), 6),
        ([&["error", "--no-sweep", "--samples", "1", "--rays", "2"], &aimed[..]].concat(), 6),
        ([&["motion", "--frames", "2", "--rays", "2"], &aimed[..]].concat(), 6),
        ([&["precision", "--rays", "2"], &aimed[..]].concat(), 1),
        (vec!["path", "--frames", "2", "--warmup", "0"], 6),
        (vec!["video", "--way", "views", "--frames", "2", "--rays", "2", "-o", "film"], 6),
    ] {
        // A study of precision has no scene behind its G-buffers, and takes no captures.
        let captures = if command[0] == "precision" { &[][..] } else { &["--captures", "1"] };
        let output = folder.run(&[&command[..], &options, captures, &["--orthographic-height", "3"]].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command:?}: {message}");
        let left_out: Vec<&str> = message.lines().filter(|line| line.contains("need a perspective")).collect();
        assert!(matches!(left_out[..], [line] if line.contains("ssct, ") || line.ends_with("ssct")), "{message}");
        let records: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
        let names: std::collections::BTreeSet<&str> = records.iter().filter_map(|r| r["method"].as_str()).collect();
        let takes_orthographic = |name: &&&str| methods::find(name).is_ok_and(|method| method.takes_orthographic);
        assert_eq!(names.iter().filter(takes_orthographic).count(), taken, "{command:?}: {names:?}");
        assert!(!names.contains("ssct"), "{command:?}: {names:?}");
    }
    let plain =
        folder.run(&[&["time", "--samples", "1", "--warmup", "0", "--method", "ssct"], &aimed[..], &options].concat());
    assert!(plain.status.success() && !String::from_utf8_lossy(&plain.stderr).contains("need a perspective"));
}

/// Through the door, an orthographic G-buffer in eight conventions of handedness, clip space and depth gives one image.
/// Standard depth has a wider bound, since rounding moves rays at edges.
#[test]
fn every_convention_of_an_orthographic_renderer_shows_the_same() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let (scene, view) = views().swap_remove(0);
    let camera = off_axis(view.camera(&scene, [97, 61]));
    let data = seen(&gpu, &scene, camera, &Globals { roughness: Some(0.0), ..Globals::default() }, [97, 61]);
    let context = engine.context();
    let mut reflections = Reflections::new(&context, &info(&data, "unified")).unwrap();
    let mut show = |convention| engine.shown(&mut reflections, &data, convention);
    let native = show(NATIVE);
    let direct = gbuffer::reflect(&gpu, &data, None, &unified::INFO, &Setup::new([97, 61])).unwrap();
    assert!(rmse(&native, &direct.composite) < 1e-4, "{}", rmse(&native, &direct.composite));
    for right_handed in [false, true] {
        for (clip_y, standard_depth) in
            [(ClipY::Up, false), (ClipY::Down, false), (ClipY::Up, true), (ClipY::Down, true)]
        {
            let convention = Convention { right_handed, clip_y, standard_depth, ..NATIVE };
            let error = rmse(&show(convention), &native);
            let limit = if standard_depth { 0.02 } else { 1e-3 };
            assert!(error < limit, "{convention:?}: {error}");
        }
    }
    // Reflections that were made for one kind of projection refuse the other.
    let theirs = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    let wrong = Reflections::new(
        &context,
        &ssct::ReflectionsInfo { projection: ProjectionKind::Perspective, ..info(&data, "unified") },
    );
    let message = engine.frame(&mut wrong.unwrap(), &theirs.input()).err().unwrap().to_string();
    assert!(message.contains("orthographic") && message.contains("ReflectionsInfo.projection"), "{message}");
    let refused = Reflections::new(&context, &info(&data, "ssct")).err().unwrap().to_string();
    assert!(refused.contains("needs a perspective"), "{refused}");
    gpu.check_validation().unwrap();
}

/// Returns the two cameras of a stereo frame: eyes 6.4 cm apart, each with its window moved towards the other's.
fn stereo(camera: Camera) -> [Camera; 2] {
    [-1.0, 1.0].map(|side| {
        let moved = Mat4::from_translation(Vec3::X * (-0.032 * side)) * camera.world_to_view;
        let clip = camera.view_to_clip_reversed();
        let projection = Projection {
            kind: ProjectionKind::Perspective,
            scale: [clip.x_axis.x, clip.y_axis.y],
            shift: [0.08 * side, 0.0],
            depth: [clip.z_axis.z, clip.w_axis.z],
        };
        Camera::of_projection(moved, projection)
    })
}

/// Both eyes in one command buffer, and both in turn by one object, give the images of each eye alone, to the bit. Two
/// objects of one context could share images or descriptors by mistake.
#[test]
fn both_views_of_a_stereo_frame_are_as_each_alone() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let scene = crate::common::built_in("rooms");
    let extent = [97, 61];
    let eyes = stereo(scene.view("corridor").unwrap().camera(&scene, extent));
    let gloss = Globals { roughness: Some(0.1), ..Globals::default() };
    let data = eyes.map(|eye| seen(&gpu, &scene, eye, &gloss, extent));
    let theirs = [0, 1].map(|eye| ForeignGBuffer::new(&mut engine, &data[eye], NATIVE));
    let alone = [0, 1].map(|eye| {
        let context = engine.context();
        let mut reflections = Reflections::new(&context, &info(&data[eye], "unified")).unwrap();
        let recorded = engine.frame(&mut reflections, &theirs[eye].input()).unwrap();
        engine.read(&recorded.composite.unwrap())
    });
    assert!(rmse(&alone[0], &alone[1]) > 0.01, "the eyes see different things");
    // Two objects of one context record both eyes into one command buffer.
    let context = engine.context();
    let mut one_per_eye = [0, 1].map(|eye| Reflections::new(&context, &info(&data[eye], "unified")).unwrap());
    for slot in [0, 1, 0] {
        let commands = engine.begin();
        let recorded = [0, 1].map(|eye| {
            let input = ssct::FrameInput { slot, ..theirs[eye].input() };
            // SAFETY: the command buffer is recording; what is recorded is submitted and waited for below.
            unsafe { one_per_eye[eye].record(commands, &input) }.unwrap().composite.unwrap()
        });
        engine.submit(commands).unwrap();
        for eye in [0, 1] {
            assert!(bits(&engine.read(&recorded[eye])) == bits(&alone[eye]), "eye {eye}");
        }
    }
    // One object can also show both eyes in turn.
    let mut in_turn = Reflections::new(&context, &info(&data[0], "unified")).unwrap();
    for eye in [0, 1, 0] {
        let recorded = engine.frame(&mut in_turn, &theirs[eye].input()).unwrap();
        assert!(bits(&engine.read(&recorded.composite.unwrap())) == bits(&alone[eye]), "eye {eye} in turn");
    }
    gpu.check_validation().unwrap();
}
