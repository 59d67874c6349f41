//! Tests captures that frames renew, and their error over age. Renewed faces equal faces made anew, to the bit, and the
//! passes are counted. A mesh that moves is seen in captures as late as they are old.

use crate::common::{Builder, check_validation, gpu};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{DeviceQuery, FrameContext, Gpu, Pixels, Watch};
use ssct::methods::capture::{CaptureImages, Renewal};
use ssct::methods::setup::CaptureCount;
use ssct::methods::{EffectParams, Fallback, MethodInfo, SceneInput, Setup, Wants, captures, ssct as thesis, unified};
use ssct::passes::pyramid;
use ssct::passes::scene_data::SceneData;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_lab::study::age::{self, AgeStudy};
use ssct_lab::study::engine::{Bench, Study};
use ssct_lab::study::journal::Journal;
use ssct_scenes::{Capture, Light, Scene, View};
use std::sync::Arc;

/// Returns a mirror floor, a mirror wall, a lit wall, and a red screen behind the eye, which both mirrors show.
fn scene() -> Scene {
    let mut b = Builder::new("moving");
    b.light(Vec3::new(0.2, -0.5, 1.0));
    let (mirror, wall, red) = (b.mirror(), b.matt(Vec3::new(0.2, 0.5, 0.7)), b.matt(Vec3::new(0.9, 0.1, 0.1)));
    b.quad(mirror, Vec3::new(-6.0, 0.0, -6.0), Vec3::X * 12.0, Vec3::Z * 12.0, Vec3::Y);
    b.quad(mirror, Vec3::new(-3.0, 0.0, 5.0), Vec3::X * 6.0, Vec3::Y * 3.0, Vec3::NEG_Z);
    b.quad(wall, Vec3::new(-6.0, 0.0, -6.0), Vec3::X * 12.0, Vec3::Y * 4.0, Vec3::Z);
    b.quad(red, Vec3::new(-2.5, 0.2, -3.0), Vec3::X * 1.5, Vec3::Y * 2.0, Vec3::Z);
    b.0.meshes.last_mut().unwrap().name = MOVING.into();
    b.light(Vec3::new(0.1, -0.3, -1.0));
    b.0.views = vec![View { eye: Vec3::new(0.0, 1.4, 0.0), look_at: Vec3::new(0.0, 1.2, 5.0), ..View::default() }];
    b.0.captures = [Vec3::new(0.0, 1.5, 1.0), Vec3::new(-1.5, 1.0, 2.5)]
        .map(|place| Capture { resolution: 33, ..Capture::placed_at(place) })
        .to_vec();
    b.0
}

/// The mesh that moves.
const MOVING: &str = "red";

/// Replaces the lights, and moves the moving mesh to its new place.
fn change(data: &mut SceneData) {
    let lights = [Light::Point { position: Vec3::new(1.0, 3.0, -1.0), energy: 4.0 }];
    data.set_lights(&lights).unwrap();
    data.place_meshes(MOVING, Vec3::new(2.25, 0.5, -0.25)).unwrap();
}

/// Returns the bits of captures, a list for each image: normals, each level of the colour, and the pyramids' cells.
fn bits(context: &mut FrameContext, images: &CaptureImages) -> Vec<Vec<u32>> {
    let captures = images.captures();
    let levels = (0..captures.color.levels()).map(|level| captures.color.level(level));
    let slices = [captures.normal.level(0)].into_iter().chain(levels);
    let float_bits = |pixels: Pixels| pixels.values.iter().map(|v| v.to_bits()).collect();
    let mut slices: Vec<Vec<u32>> = slices.map(|slice| float_bits(context.read(slice).unwrap())).collect();
    slices.push(cells(&context.read(captures.pyramid.level(0)).unwrap(), captures.normal.extent(), images.faces()));
    slices
}

/// Returns the bits of the pyramids' cells, face by face and level by level, as they lie in strips (`pyramid.glsl`).
/// Texels between levels are left out, since no pass writes them.
fn cells(pyramids: &Pixels, extent: [u32; 2], faces: u32) -> Vec<u32> {
    let ([width, height], strip) = (pyramid::padded(extent), pyramid::strip(extent));
    let rows = pyramid::size(extent, strip)[1];
    let strips = (2 * width) >> strip;
    let mut bits = Vec::new();
    for (face, level) in (0..faces).flat_map(|face| (0..=pyramid::top_level(extent)).map(move |level| (face, level))) {
        let first = face * rows + strips - (strips >> level);
        for (x, y) in (0..height >> level).flat_map(|y| (0..width >> level).map(move |x| (x, y))) {
            let cell = pyramids.texel((y << strip) | (x % (1 << strip)), first + (x >> strip));
            bits.extend(cell.iter().map(|v| v.to_bits()));
        }
    }
    bits
}

/// Two captures of 12 faces are renewed by 1, 5, 6, 12 or 48 faces a frame. Once all faces had their turn, and not
/// before, they equal captures that were made after the change, to the bit. A face that is left out or filtered
/// otherwise would differ.
#[test]
fn captures_that_were_renewed_in_turn_equal_captures_made_anew() {
    let gpu = gpu();
    let scene = scene();
    let mut context = FrameContext::new(&gpu).unwrap();
    for per_frame in [1, 5, 6, 12, 48] {
        let mut data = SceneData::upload(&mut context, &scene).unwrap();
        let materials = &scene.materials;
        let old = CaptureImages::new(&mut context, &SceneInput { data: &data, materials }, &scene.captures).unwrap();
        let renewal = Renewal::new(&gpu, &scene.captures, per_frame).unwrap();
        let before = bits(&mut context, &old);
        change(&mut data);
        let input = SceneInput { data: &data, materials };
        let fresh = CaptureImages::new(&mut context, &input, &scene.captures).unwrap();
        let fresh = bits(&mut context, &fresh);
        assert!(before.iter().zip(&fresh).filter(|(a, b)| a != b).count() > 3, "the change shows");
        assert_eq!(old.faces(), 12);
        let frames = 12_u32.div_ceil(per_frame);
        for frame in 0..frames {
            assert!(frame == 0 || bits(&mut context, &old) != fresh, "{per_frame} a frame: done after {frame}");
            context.once(|frame| renewal.record(frame, &input, &old)).unwrap();
        }
        let renewed = bits(&mut context, &old);
        for (n, (renewed, fresh)) in renewed.iter().zip(&fresh).enumerate() {
            let differ = renewed.iter().zip(fresh).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{per_frame} a frame: image {n}");
        }
    }
    check_validation(&gpu).unwrap();
}

/// Makes a shot of the scene with captures of which `per_frame` faces are renewed in each frame.
fn shot(stage: &mut Stage, scene: &Scene, method: &MethodInfo, per_frame: u32) -> Shot {
    let setup = Setup::new([80, 45]).with(|p: &mut EffectParams| {
        (p.captures, p.captures_per_frame) = (CaptureCount::Auto, per_frame);
        if method.name == thesis::INFO.name {
            p.fallback = Fallback::Captures;
        }
    });
    let camera = scene.views[0].camera(scene, setup.extent);
    Shot::new(stage, method, &setup, Wants::REFLECTION, camera, scene.materials.clone()).unwrap()
}

/// Draws one frame. Returns the bits of the reflection, and the names of its passes with whether each counts.
fn frame(stage: &mut Stage, shot: &Shot) -> (Vec<u32>, Vec<(String, bool)>) {
    let (report, _, output) = stage.output_in(Mode::Timed, shot).unwrap();
    let pixels = gbuffer::reflection(&mut stage.context, &output).unwrap();
    let bits = pixels.values.iter().map(|v| v.to_bits()).collect();
    (bits, report.passes.into_iter().map(|p| (p.name, p.counted)).collect())
}

/// Effects that look into captures of the same places share one drawing, and each says what it costs alone. An effect
/// whose captures move draws its own, and so does one that is made after a change of the scene. The others stay equal.
#[test]
fn captures_are_drawn_once_for_all_effects_until_they_move_or_the_scene_changes() {
    let gpu = gpu();
    let scene = scene();
    let alone = |method| shot(&mut Stage::new(&gpu, &scene).unwrap(), &scene, method, 0).prepared().device_bytes;
    let cost = [&captures::INFO, &unified::INFO].map(alone);
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let empty = gpu.allocated_bytes();
    let first = shot(&mut stage, &scene, &captures::INFO, 0);
    let with_first = gpu.allocated_bytes();
    let mut second = shot(&mut stage, &scene, &unified::INFO, 0);
    assert_eq!([first.prepared().device_bytes, second.prepared().device_bytes], cost);
    assert!(with_first - empty > cost[0], "the first draws captures");
    let places = |shot: &Shot| shot.captures().unwrap().1;
    assert_eq!(places(&first), places(&second));
    let [before_first, before_second] = [&first, &second].map(|shot| frame(&mut stage, shot).0);

    let held = gpu.allocated_bytes();
    second.move_captures(&mut stage, &[Vec3::new(0.5, 1.5, 1.0), Vec3::new(-1.0, 1.0, 2.5)]).unwrap();
    assert!(gpu.allocated_bytes() - held >= cost[1], "captures that move are drawn into images of their own");
    assert_ne!(frame(&mut stage, &second).0, before_second);
    assert_eq!(frame(&mut stage, &first).0, before_first);
    let third = shot(&mut stage, &scene, &unified::INFO, 0);
    assert_eq!(frame(&mut stage, &third).0, before_second);

    change(stage.scene_mut());
    let held = gpu.allocated_bytes();
    let late = shot(&mut stage, &scene, &captures::INFO, 0);
    assert!(gpu.allocated_bytes() - held >= cost[0], "a scene that changed is captured again");
    assert_ne!(frame(&mut stage, &late).0, frame(&mut stage, &first).0);
    check_validation(&gpu).unwrap();
}

/// With 5 of 12 faces a frame, each frame has the passes of five faces, all of which count. After three frames, and not
/// before, the image shows the change, to the bit. The method's time must include what it costs to keep captures new.
#[test]
fn frames_renew_captures_by_passes_that_count_and_then_show_what_changed() {
    let gpu = gpu();
    let scene = scene();
    for method in [&unified::INFO, &captures::INFO, &thesis::INFO] {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let old = shot(&mut stage, &scene, method, 0);
        let renewed = shot(&mut stage, &scene, method, 5);
        let (before, passes) = frame(&mut stage, &old);
        assert!(!passes.iter().any(|(name, _)| name.starts_with("capture/")), "{}: {passes:?}", method.name);
        let others = |recorded_passes: &[(String, bool)]| {
            recorded_passes.iter().filter(|(name, _)| !name.starts_with("capture/")).cloned().collect::<Vec<_>>()
        };
        change(stage.scene_mut());
        let fresh = shot(&mut stage, &scene, method, 0);
        let truth = frame(&mut stage, &fresh).0;
        for n in 0..3 {
            let (reflection, recorded_passes) = frame(&mut stage, &renewed);
            // Passes for each face; the colour has five more levels, from 33 texels down to 1.
            let per_face = [
                ("capture/g-buffer/depth", 1),
                ("capture/g-buffer", 1),
                ("capture/lighting", 1),
                ("capture/pyramid", 1),
                ("capture/keep pyramid", 1),
                ("capture/keep normal", 1),
                ("capture/keep color", 1),
                ("capture/color", 5),
            ];
            for (name, count) in per_face {
                let recorded = recorded_passes.iter().filter(|(pass, _)| pass == name).count();
                assert_eq!(recorded, 5 * count, "{}: {name}", method.name);
            }
            let added: usize = per_face.iter().map(|(_, count)| 5 * count).sum();
            assert_eq!(recorded_passes.len(), passes.len() + added, "{}", method.name);
            assert!(recorded_passes.iter().all(|(name, counted)| !name.starts_with("capture/") || *counted));
            assert_eq!(others(&recorded_passes), others(&passes), "{}: other passes change", method.name);
            assert_eq!(reflection == truth, n == 2, "{}: after {} of 3 frames", method.name, n + 1);
        }
        assert_ne!(frame(&mut stage, &old).0, truth, "{}: captures that nothing renews stay old", method.name);
        assert_ne!(before, truth, "{}", method.name);
    }
    check_validation(&gpu).unwrap();
}

/// After the first frame, four frames that renew captures allocate no Vulkan object. Images that are made anew in each
/// frame would cost time and fill the memory.
#[test]
fn renewal_makes_no_object_in_the_steady_state() {
    let watch = Arc::<Watch>::default();
    let gpu = Gpu::open(&DeviceQuery { watch: Some(Arc::clone(&watch)), ..DeviceQuery::default() }).unwrap();
    let scene = scene();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let renewed = shot(&mut stage, &scene, &unified::INFO, 12);
    // In the first frame, queries and uniform memory grow to their final size.
    frame(&mut stage, &renewed);
    watch.arm(None);
    for n in 0..4 {
        stage.scene_mut().place_meshes(MOVING, Vec3::X * 0.1 * n as f32).unwrap();
        stage.run(&renewed, Mode::Timed).unwrap();
    }
    assert_eq!(watch.calls()[0], 0, "allocations");
}

/// An unknown mesh, a place of NaN and too many lights are refused with a sentence.
#[test]
fn what_moves_or_lights_a_scene_is_checked() {
    let gpu = gpu();
    let mut context = FrameContext::new(&gpu).unwrap();
    let mut data = SceneData::upload(&mut context, &scene()).unwrap();
    let message = data.place_meshes("green", Vec3::ZERO).unwrap_err().to_string();
    assert!(message.contains("no mesh \"green\""), "{message}");
    let message = data.place_meshes(MOVING, Vec3::NAN).unwrap_err().to_string();
    assert!(message.contains("finite"), "{message}");
    let many = vec![Light::Directional { direction: Vec3::X, energy: 1.0 }; 1000];
    let message = data.set_lights(&many).unwrap_err().to_string();
    assert!(message.contains("1000 lights"), "{message}");
}

/// A mesh that the device draws at an offset has the depth of a scene in which its vertices were moved, but for 8
/// pixels at edges.
#[test]
fn a_mesh_that_is_placed_is_drawn_where_the_moved_scene_has_it() {
    let gpu = gpu();
    let offset = Vec3::new(1.25, 0.5, 0.25);
    let mut moved = scene();
    moved.meshes.iter_mut().filter(|m| m.name == MOVING).for_each(|m| m.translate(offset));
    let camera = View { eye: Vec3::new(0.0, 1.4, 3.0), look_at: Vec3::new(0.0, 1.0, -5.0), ..View::default() }
        .camera(&moved, [80, 45]);
    let depth = |scene: &Scene, offset: Option<Vec3>| {
        let mut stage = Stage::new(&gpu, scene).unwrap();
        if let Some(offset) = offset {
            stage.scene_mut().place_meshes(MOVING, offset).unwrap();
        }
        let setup = Setup::new([80, 45]);
        let shot =
            Shot::new(&mut stage, &unified::INFO, &setup, Wants::IMAGE, camera, scene.materials.clone()).unwrap();
        stage.draw(&shot).unwrap();
        gbuffer::read(&mut stage.context, &shot).unwrap().depth
    };
    let (still, placed, truth) = (depth(&scene(), None), depth(&scene(), Some(offset)), depth(&moved, None));
    let differing = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 1e-5 * b.abs()).count();
    assert!(differing(&still, &truth) > 100, "{}", differing(&still, &truth));
    assert!(differing(&placed, &truth) <= 8, "{}", differing(&placed, &truth));
}

/// In the study of age on a moving screen with 0, 1, 4 and 12 renewed faces a frame, the error grows with the age of
/// the captures, and less the more faces are renewed.
#[test]
fn error_grows_with_the_age_of_captures_and_not_where_all_faces_are_renewed() {
    let gpu = gpu();
    let scene = scene();
    let setup = Setup::new([96, 54]).with(|p: &mut EffectParams| p.captures = CaptureCount::Auto);
    let mut study = AgeStudy {
        view: scene.views[0].clone(),
        scene,
        globals: vec![Globals { roughness: Some(0.0), ..Globals::default() }],
        methods: vec![&unified::INFO],
        setup,
        sizes: vec![[96, 54]],
        moving: vec![MOVING.to_owned()],
        step_m: Vec3::X * 0.25,
        faces: vec![0, 1, 4, 12],
        frames: 9,
        rays: 16,
    };
    study.check().unwrap();
    let (cell, mut journal) = (study.cells().remove(0).cell, Journal::default());
    let (advance, keep) = (&mut |_| (), &mut |_: &_| Ok(()));
    let mut bench = Bench { gpu: &gpu, journal: &mut journal, go_on: || Ok(()), advance, keep };
    let records = study.measure(&cell, &mut bench).unwrap();
    let rmse = |row: usize, frame: usize| records[row].frames[frame].rmse;
    for (record, faces) in records.iter().zip(&study.faces) {
        assert_eq!((record.faces, record.faces_per_frame, record.frames.len()), (12, *faces, 9));
        assert_eq!(record.head.setup["captures_per_frame"], *faces);
        for (n, frame_record) in record.frames.iter().enumerate() {
            assert!((frame_record.moved_m - 0.25 * n as f32).abs() < 1e-6);
            assert_eq!(frame_record.age_frames, age::mean_age(12, *faces, n as u32));
            assert!(frame_record.rmse.is_finite() && frame_record.standard_error.is_finite());
            assert_eq!(frame_record.capture_ms > 0.0, *faces > 0);
            assert!(frame_record.capture_ms < frame_record.effect_ms);
        }
    }
    // In the first frame, all captures show the scene as it stands, so that all rows have one error.
    assert!((1..4).all(|row| rmse(row, 0) == rmse(0, 0)), "{:?}", (0..4).map(|row| rmse(row, 0)).collect::<Vec<_>>());
    let last = |row: usize| rmse(row, 8);
    // Only pixels that show a moved thing are touched; in the first frame, nothing has moved.
    for (n, frame_record) in records[0].frames.iter().enumerate() {
        assert_eq!(
            (frame_record.touched > 0.0, frame_record.touched_rmse.is_some()),
            (n > 0, n > 0),
            "{frame_record:?}"
        );
        assert!(frame_record.touched < 0.5, "{frame_record:?}");
    }
    let touched = |row: usize| records[row].frames[8].touched_rmse.unwrap();
    println!("touched: {:?}", [0, 1, 2, 3].map(touched));
    assert!(touched(0) > 1.5 * touched(3) && touched(2) < touched(0), "{:?}", [0, 1, 2, 3].map(touched));
    println!("{:?}, then {:?}", rmse(0, 0), [0, 1, 2, 3].map(last));
    assert!(last(0) > 1.2 * last(3), "{:?}", [0, 1, 2, 3].map(last));
    assert!(last(2) < last(0) && last(3) <= last(2), "{:?}", [0, 1, 2, 3].map(last));
    let message = AgeStudy { setup: Setup::new([96, 54]), ..study }.check().unwrap_err().to_string();
    assert!(message.contains("unified has no captures"), "{message}");
    check_validation(&gpu).unwrap();
}

/// In the rooms, where nothing moves, frames that renew two faces each show the same image, to the bit.
#[test]
fn captures_are_renewed_in_a_scene_of_many_meshes() {
    let gpu = gpu();
    let mut scene = crate::common::built_in("rooms");
    scene.captures = vec![Capture { resolution: 64, ..Capture::placed_at(scene.views[0].eye) }];
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let (still, renewed) = (shot(&mut stage, &scene, &unified::INFO, 0), shot(&mut stage, &scene, &unified::INFO, 2));
    let truth = frame(&mut stage, &still).0;
    for _ in 0..4 {
        assert_eq!(frame(&mut stage, &renewed).0, truth);
    }
    check_validation(&gpu).unwrap();
}
