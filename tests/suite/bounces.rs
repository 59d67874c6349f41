//! Tests several bounces (thesis §4.2.11). Each bounce reflects the image that has the bounce before it, and passes
//! that read no colour are recorded once. Between mirrors, light grows no further than their reflectivity allows.

use crate::common::{Builder, camera, gpu};
use glam::Vec3;
use half::f16;
use ssct::error::Error;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, FrameReport, Gpu};
use ssct::methods::setup::{BeyondScreen, CaptureCount, HistoryUse};
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::{Effect, EffectParams, Fallback, Input, METHODS, MethodInfo, Setup, Wants, find};
use ssct::passes::gbuffer::GBufferImages;
use ssct::passes::trace_normals::TraceNormals;
use ssct_ground::math::OracleVersion;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, GBufferData, Material, Scene};
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::screen::{Sampling, ScreenReference};
use std::collections::BTreeSet;

/// Size of the image in pixels.
const EXTENT: [u32; 2] = [161, 97];
/// The reflectivity of both mirrors.
const REFLECTIVITY: f32 = 0.8;

/// Returns two mirrors that face each other across a corridor, over a floor of stripes, with a board at the corridor's
/// end.
fn facing_mirrors(roughness: f32) -> Scene {
    let mut b = Builder::new("facing mirrors");
    b.light(Vec3::new(0.0, -1.0, 0.4));
    let mirror = b.material(Material {
        albedo: Vec3::new(0.3, 0.2, 0.4),
        reflectivity: REFLECTIVITY,
        roughness,
        ..Material::default()
    });
    b.quad(mirror, Vec3::new(-1.5, 0.0, 0.5), Vec3::Z * 9.0, Vec3::Y * 3.0, Vec3::X);
    b.quad(mirror, Vec3::new(1.5, 0.0, 0.5), Vec3::Z * 9.0, Vec3::Y * 3.0, -Vec3::X);
    let stripes = b.picture(64, 64, |x, y| [(4 * x) as u8, if y % 8 < 4 { 40 } else { 220 }, 128]);
    b.quad(stripes, Vec3::new(-1.5, 0.0, 0.5), Vec3::X * 3.0, Vec3::Z * 9.0, Vec3::Y);
    // A ceiling hides the sky: the camera sees one part of it in the mirrors, and rays of further bounces another.
    let ceiling = b.matt(Vec3::splat(0.6));
    b.quad(ceiling, Vec3::new(-1.5, 3.0, 0.5), Vec3::X * 3.0, Vec3::Z * 9.0, -Vec3::Y);
    let board = b.matt(Vec3::new(0.9, 0.5, 0.2));
    b.quad(board, Vec3::new(-1.5, 0.0, 9.5), Vec3::X * 3.0, Vec3::Y * 3.0, -Vec3::Z);
    b.0
}

/// Returns a camera at one end of the corridor that looks along it.
fn corridor_camera() -> Camera {
    camera(Vec3::new(0.2, 1.4, 0.0), Vec3::new(0.0, 1.2, 6.0), EXTENT)
}

/// Returns a setup whose rays end on the screen, with a number of bounces.
fn bounces(bounces: u32) -> Setup {
    Setup::on_screen(EXTENT).with(|p: &mut EffectParams| p.bounces = bounces)
}

/// Makes a shot of a scene in its own materials that keeps the reflection.
fn shot(stage: &mut Stage, scene: &Scene, view: Camera, method: &str, setup: &Setup) -> Shot {
    Shot::new(stage, find(method).unwrap(), setup, Wants::REFLECTION, view, scene.materials.clone()).unwrap()
}

/// Draws a scene and returns its G-buffer.
fn draw_gbuffer(gpu: &Gpu, scene: &Scene, view: Camera) -> GBufferData {
    let mut stage = Stage::new(gpu, scene).unwrap();
    let shot = shot(&mut stage, scene, view, "linear", &bounces(1));
    stage.draw(&shot).unwrap();
    gbuffer::read(&mut stage.context, &shot).unwrap()
}

/// Runs a method on a G-buffer alone. Returns the reflection with the fade in the fourth channel, the finished image,
/// and the report of the frame.
fn run_on_gbuffer(
    gpu: &Gpu,
    data: &GBufferData,
    method: &MethodInfo,
    setup: &Setup,
) -> (Vec<[f32; 4]>, Vec<Vec3>, FrameReport) {
    let mut context = FrameContext::new(gpu).unwrap();
    let images = GBufferImages::upload(&mut context, data).unwrap();
    let effect = Effect::new(&mut context, method, setup, Wants::REFLECTION, None).unwrap();
    let mut frame = context.begin(Mode::Plain).unwrap();
    let output = effect.record(&mut frame, &Input::of_screen(images.gbuffer(), &data.camera)).unwrap();
    let report = frame.finish().unwrap();
    let reflection = context.read(output.traced.reflection.unwrap().0.all()).unwrap();
    let composite = context.read(output.composite.level(0)).unwrap();
    let texels = reflection.texels().map(|t| [t[0], t[1], t[2], t[3]]).collect();
    (texels, composite.texels().map(|t| Vec3::from_slice(&t[..3])).collect(), report)
}

/// Computes the finished image of a reflection: lit colour + reflectivity · fade · reflection, rounded to 16-bit floats
/// as images store it.
fn composite(data: &GBufferData, reflection: &[[f32; 4]]) -> Vec<Vec3> {
    let round_to_half = |v: f32| f16::from_f32(v).to_f32();
    let pixel = |(index, texel): (usize, &[f32; 4])| {
        let share = if data.reflects(index) { data.reflectivity[index] } else { 0.0 };
        (data.color[index] + share * texel[3] * Vec3::new(texel[0], texel[1], texel[2])).map(round_to_half)
    };
    reflection.iter().enumerate().map(pixel).collect()
}

/// Returns the methods that need nothing but the screen.
fn screen_space() -> impl Iterator<Item = &'static MethodInfo> {
    METHODS.iter().filter(|m| m.is_screen_space())
}

/// Two bounces of every screen-space method equal one bounce on a G-buffer whose colour is the finished image of the
/// first. A method that kept the lit colour for its second bounce would fail. Mirrors and a roughness of 0.15 are
/// tried.
#[test]
fn a_bounce_reflects_the_image_with_the_one_before_in_it() {
    let gpu = gpu();
    for roughness in [0.0, 0.15] {
        let data = draw_gbuffer(&gpu, &facing_mirrors(roughness), corridor_camera());
        for method in screen_space() {
            let (two, image, _) = run_on_gbuffer(&gpu, &data, method, &bounces(2));
            let (one, ..) = run_on_gbuffer(&gpu, &data, method, &bounces(1));
            let with_first_bounce = GBufferData { color: composite(&data, &one), ..data.clone() };
            let (expected, ..) = run_on_gbuffer(&gpu, &with_first_bounce, method, &bounces(1));
            let greatest_difference = |a: &[[f32; 4]], b: &[[f32; 4]]| {
                let off = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
                off.fold(0.0_f32, f32::max)
            };
            let (off, moved) = (greatest_difference(&two, &expected), greatest_difference(&two, &one));
            println!("{} at {roughness}: off by {off}, of {moved} that the bounce adds", method.name);
            // A composite of 16-bit floats may be rounded otherwise by one step, hence 0.001. `sslr` keeps colours of 8
            // bits, whose step is larger, hence 0.01.
            assert!(off <= if method.name == "sslr" { 0.01 } else { 0.001 } && moved > 0.05, "{}", method.name);
            // The finished image is the lit colour of the surfaces plus this reflection.
            let finished = composite(&data, &two);
            let off = image.iter().zip(&finished).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
            assert!(off <= 0.001, "{}: the image is off by {off}", method.name);
        }
    }
    gpu.check_validation().unwrap();
}

/// With 1, 2, 3 and 8 bounces between facing mirrors of reflectivity r, the mean brightness never falls. The brightest
/// pixel stays below the geometric series 1 + r + … + rⁿ times the brightest lit colour L. Light that is added twice
/// exceeds it.
#[test]
fn light_between_mirrors_grows_as_far_as_they_reflect_it() {
    let gpu = gpu();
    for roughness in [0.0, 0.15] {
        let data = draw_gbuffer(&gpu, &facing_mirrors(roughness), corridor_camera());
        let brightest = data.color.iter().map(|c| c.max_element()).fold(0.0, f32::max);
        for method in screen_space() {
            let images = [1, 2, 3, 8].map(|n| (n, run_on_gbuffer(&gpu, &data, method, &bounces(n)).1));
            let mean = |image: &[Vec3]| image.iter().map(|c| c.element_sum()).sum::<f32>() / image.len() as f32;
            let means: Vec<f32> = images.iter().map(|(_, image)| mean(image)).collect();
            println!("{} at {roughness}: {means:?}", method.name);
            assert!(means[1] > 1.001 * means[0], "{}: {means:?}", method.name);
            assert!(means.windows(2).all(|m| m[1] >= m[0]), "{}: {means:?}", method.name);
            for (n, image) in &images {
                // The limit is L (1 + r + … + rⁿ) = L (1 − rⁿ⁺¹) / (1 − r), plus 1 % for the rounding of 16-bit floats.
                let most = brightest * (1.0 - REFLECTIVITY.powi(*n as i32 + 1)) / (1.0 - REFLECTIVITY) * 1.01;
                let brightest_found = image.iter().map(|c| c.max_element()).fold(0.0, f32::max);
                assert!(brightest_found <= most, "{} with {n} bounces: {brightest_found} above {most}", method.name);
            }
        }
    }
}

/// With three bounces, passes that read depth or normals alone are recorded once, since their result stays the same.
/// The other passes of a bounce n are named `bounce n/…`, and each further bounce records equally many.
#[test]
fn passes_that_read_no_colour_are_recorded_once() {
    let gpu = gpu();
    let data = draw_gbuffer(&gpu, &facing_mirrors(0.15), corridor_camera());
    let recorded = |method: &str, setup: &Setup| run_on_gbuffer(&gpu, &data, find(method).unwrap(), setup).2.recorded;
    let split = |n| bounces(n).with(|p: &mut ThesisDrawing| p.split = true);
    for (method, setup, shared_passes) in [
        ("ssct", bounces as fn(u32) -> Setup, &["depth", "hi-z/1", "visibility/1"] as &[&str]),
        ("hzct", split, &["depth", "hi-z/1", "visibility/1", "ray trace"]),
        ("linear", bounces, &["depth"]),
        ("sslr", bounces, &["depth"]),
        ("stochastic", bounces, &["pyramid"]),
        ("unified", bounces, &["pyramid", "classify/clear", "classify/tiles"]),
    ] {
        let (one, three) = (recorded(method, &setup(1)), recorded(method, &setup(3)));
        assert!(one.iter().all(|pass| !pass.starts_with("bounce")), "{method}: {one:?}");
        for pass in shared_passes {
            assert!(one.iter().any(|p| p == pass), "{method}: no {pass} in {one:?}");
            let again: Vec<_> = three.iter().filter(|p| p.ends_with(&format!("/{pass}"))).collect();
            assert!(again.is_empty(), "{method}: {again:?}");
        }
        let pass_count = |n: u32| three.iter().filter(|p| p.starts_with(&format!("bounce {n}/"))).count();
        assert!(pass_count(2) > 0 && pass_count(2) == pass_count(3) && pass_count(4) == 0, "{method}: {three:?}");
        assert_eq!(three.iter().collect::<BTreeSet<_>>().len(), three.len(), "{method}: {three:?}");
    }
    // With one bounce, the passes are those of a frame without the option.
    assert_eq!(recorded("linear", &bounces(1)), ["depth", "ray trace", "composite"]);
}

/// Returns the reflection that the screen shows along rays which are reflected `bounces` times, from 16 samples a pixel
/// by the oracle.
fn truth(data: &GBufferData, bounces: u32) -> Vec<[f32; 3]> {
    let sampling = Sampling { samples: 16, seed: 1, oracle: OracleVersion::V1, bounces };
    let image = ScreenReference::render(data, &data.reflecting(), sampling);
    image.color.iter().map(Vec3::to_array).collect()
}

/// Measured against the reference of three bounces, three bounces of `unified` have less than 0.7 of the error of one
/// bounce. Further bounces must add true light, and not only some light.
#[test]
fn bounces_bring_the_image_nearer_to_light_that_is_reflected_as_often() {
    let gpu = gpu();
    let data = draw_gbuffer(&gpu, &facing_mirrors(0.0), corridor_camera());
    let unfaded = |n| bounces(n).with(|p: &mut EffectParams| p.fade = false);
    let image_with = |n| {
        let (reflection, ..) = run_on_gbuffer(&gpu, &data, find("unified").unwrap(), &unfaded(n));
        reflection.iter().map(|r| [r[0], r[1], r[2]]).collect::<Vec<_>>()
    };
    let (one, three) = (image_with(1), image_with(3));
    let error = |image: &[[f32; 3]], n| masked_rmse(&truth(&data, n), image, &data.reflecting());
    let errors = [error(&one, 1), error(&one, 3), error(&three, 3)];
    println!("one bounce against one, one against three, three against three: {errors:.4?}");
    assert!(errors[2] < 0.7 * errors[1], "{errors:?}");
    // The image of three bounces errs more than that of one: a second bounce reflects what mirrors show to the camera,
    // and not what they show along the ray.
    assert!(errors[2] > errors[0], "{errors:?}");
}

/// In the corridor with mirrors, three bounces are brighter than one, by at most a factor of 2, also with a history,
/// fallbacks, captures, a lower resolution and bumps. Each of these adds passes, which a further bounce must repeat or
/// share.
#[test]
fn bounces_work_with_all_that_stands_around_a_method() {
    let gpu = gpu();
    let mut scene = crate::common::built_in("corridor");
    scene.materials = Globals { roughness: Some(0.0), ..Globals::default() }.materials(&scene, &scene.views[0]);
    let view = scene.views[0].camera(&scene, EXTENT);
    // The mean value of the finished image with n bounces, after a check that no pass is recorded twice.
    let mean = |method: &str, n: u32, change: &dyn Fn(&mut EffectParams)| {
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let setup = bounces(n).with(|p: &mut EffectParams| change(p));
        let shot = shot(&mut stage, &scene, view, method, &setup);
        let (report, _, output) = stage.output_at_rest(&shot).unwrap();
        let image = stage.context.read(output.composite.level(0)).unwrap();
        let names: BTreeSet<_> = report.recorded.iter().collect();
        assert_eq!(names.len(), report.recorded.len(), "{method}: {:?}", report.recorded);
        image.values.iter().map(|v| f64::from(*v)).sum::<f64>() / image.values.len() as f64
    };
    type Change = fn(&mut EffectParams);
    let additions: [(&str, &str, Change); 7] = [
        ("unified", "history", |p| (p.history, p.history_frames) = (HistoryUse::On, 3)),
        ("ssct", "environment", |p| p.fallback = Fallback::Environment),
        ("ssct", "captures behind", |p| p.fallback = Fallback::Captures),
        ("unified", "captures", |p| (p.beyond, p.captures) = (BeyondScreen::Captures, CaptureCount::Number(1))),
        ("unified", "half resolution", |p| p.resolution_scale = 0.5),
        ("ssct", "quarter resolution", |p| p.resolution_scale = 0.25),
        ("ssct", "bumps", |p| (p.trace_normals, p.bump_after) = (TraceNormals::Geometric, 0.1)),
    ];
    for (method, name, change) in additions {
        let [one, three] = [1, 3].map(|n| mean(method, n, &change));
        println!("{method} with {name}: {one:.4}, {three:.4}");
        assert!(three > one + 0.002 && three < 2.0 * one, "{method} with {name}: {one}, {three}");
    }
    gpu.check_validation().unwrap();
}

/// Every method that is not screen-space refuses two bounces, with a message that names the method. Its source of
/// colours is no image of the frame, to which a bounce could be added.
#[test]
fn what_sees_more_than_the_screen_has_no_bounces() {
    let gpu = gpu();
    let scene = facing_mirrors(0.0);
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    for method in METHODS.iter().filter(|m| !m.is_screen_space()) {
        let shot =
            Shot::new(&mut stage, method, &bounces(2), Wants::REFLECTION, corridor_camera(), scene.materials.clone());
        let Some(Error::Usage(message)) = shot.err() else { panic!("{} takes bounces", method.name) };
        assert!(message.contains("bounces") && message.contains(method.name), "{message}");
    }
}
