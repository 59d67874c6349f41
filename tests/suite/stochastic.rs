//! Tests `stochastic`: the mean of its rays, the hits of its two walks, and the pass of a history around any method.

use crate::common::{clutter, clutter_camera, gpu, unfaded};
use glam::Vec3;
use ssct::gpu::Pixels;
use ssct::methods::setup::HistoryUse;
use ssct::methods::stochastic::{StochasticParams, StochasticWalk};
use ssct::methods::{EffectParams, Fallback, Setup, Wants, find};
use ssct_ground::math::OracleVersion;
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Camera, GBufferData, Scene, Surface, View};
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::screen::{Sampling, ScreenReference};

/// Size of the images in pixels.
const EXTENT: [u32; 2] = [161, 91];

/// Returns a setup without fade, with rays from all of the lobe (`stochastic_part` 1) and a further change.
fn setup(change: impl FnOnce(&mut StochasticParams)) -> Setup {
    unfaded(EXTENT).with(|p: &mut StochasticParams| p.stochastic_part = 1.0).with(change)
}

/// Returns the setup with a history of a number of frames.
fn with_history(setup: &Setup, frames: u32) -> Setup {
    setup.with(|p: &mut EffectParams| (p.history, p.history_frames) = (HistoryUse::On, frames))
}

/// Returns the G-buffer of a view of the rooms, with one roughness for all surfaces. Windows count as lit surfaces, so
/// that a ray that meets one shows the colour of the screen, and not the sky along the ray.
fn rooms(view: &str, roughness: f32) -> GBufferData {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view(view).unwrap();
    let globals = Globals { roughness: Some(roughness), normal_deviation: Some(0.0), ..Globals::default() };
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let (materials, camera) = (globals.materials(&scene, view), view.camera(&scene, EXTENT));
    let shot = Shot::new(&mut stage, find("hzct").unwrap(), &Setup::on_screen(EXTENT), Wants::IMAGE, camera, materials);
    let shot = shot.unwrap();
    stage.output(&shot).unwrap();
    let data = gbuffer::read(&mut stage.context, &shot).unwrap();
    GBufferData { surface: vec![Surface::Lit; data.surface.len()], ..data }
}

/// Returns the reflection that a method makes of a G-buffer, with a camera at rest.
fn reflect(data: &GBufferData, method: &str, setup: &Setup) -> Pixels {
    let gpu = gpu();
    let reflection = gbuffer::reflect(&gpu, data, None, find(method).unwrap(), setup).unwrap().reflection;
    gpu.check_validation().unwrap();
    reflection
}

/// Returns the colours of an image without the fourth channel.
fn colors(pixels: &Pixels) -> Vec<[f32; 3]> {
    pixels.texels().map(|t| [t[0], t[1], t[2]]).collect()
}

/// Returns, for each pixel, whether it reflects.
fn mask(data: &GBufferData) -> Vec<bool> {
    (0..data.depth.len()).map(|i| data.reflects(i)).collect()
}

/// Returns the colours of the screen reference with a number of samples for each pixel.
fn truth(data: &GBufferData, samples: u32) -> Vec<[f32; 3]> {
    let sampling = Sampling { samples, seed: 1, oracle: OracleVersion::V1, bounces: 1 };
    let image = ScreenReference::render(data, &mask(data), sampling);
    image.color.iter().map(Vec3::to_array).collect()
}

/// Returns the sum of all channels divided by the number of pixels. Only ratios of two such means are used.
fn mean(color: &[[f32; 3]]) -> f64 {
    color.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / color.len() as f64
}

/// With 64 rays a pixel and no gathering, the error against the screen reference falls below 0.16 of that of one ray,
/// and the mean is right within 0.5 %. Rays drawn with a wrong density would converge to another image.
#[test]
fn many_rays_by_themselves_come_to_the_screen_reference() {
    for (view, roughness) in [("corridor", 0.1), ("window", 0.4)] {
        let data = rooms(view, roughness);
        let (truth, mask) = (truth(&data, 256), mask(&data));
        let alone = |rays| setup(|p| (p.stochastic_rays, p.stochastic_gathered) = (rays, 1));
        let [one, many] = [1, 64].map(|rays| colors(&reflect(&data, "stochastic", &alone(rays))));
        let [error_of_one, error_of_many] = [&one, &many].map(|image| masked_rmse(&truth, image, &mask));
        println!("{view}, {roughness}: 1 ray {error_of_one:.4}, 64 rays {error_of_many:.4}");
        // 64 independent rays would leave 1 / √64 = 0.125. These rays are spread better, but the reference has noise,
        // too.
        assert!(error_of_many < 0.16 * error_of_one, "{view}: {error_of_many} against {error_of_one}");
        let bias = mean(&many) / mean(&truth) - 1.0;
        assert!(bias.abs() < 0.005, "{view}: {bias}");
    }
}

/// Gathering nine rays lowers the error of one ray below three quarters and keeps the mean within 5 %. Weights that do
/// not follow the pixel's own lobe would change the mean.
#[test]
fn what_pixels_gather_keeps_the_mean_and_lowers_the_error() {
    for (view, roughness) in [("corridor", 0.1), ("window", 0.4)] {
        let data = rooms(view, roughness);
        let (truth, mask) = (truth(&data, 256), mask(&data));
        let gathered = |n| colors(&reflect(&data, "stochastic", &setup(|p| p.stochastic_gathered = n)));
        let [alone, nine] = [1, 9].map(gathered);
        let [error_alone, error_of_nine] = [&alone, &nine].map(|image| masked_rmse(&truth, image, &mask));
        println!("{view}: alone {error_alone:.4}, of nine {error_of_nine:.4}");
        assert!(error_of_nine < 0.75 * error_alone, "{view}: {error_of_nine} against {error_alone}");
        let bias = mean(&nine) / mean(&truth) - 1.0;
        // Gathering divides two sums, which is biased where the rays around a pixel see other things than the pixel's
        // own ray.
        assert!(bias.abs() < 0.05, "{view}: {bias}");
    }
}

/// For mirrors, the hits are those of `unified`, to the bit, or with the thesis's walk those of `ssct` in 98 % of the
/// pixels. The rays of a mirror have one direction, so that only a wrong walk could change the hits.
#[test]
fn mirrors_are_those_of_the_walk_that_is_chosen() {
    let gpu = gpu();
    let scene = clutter();
    let camera = clutter_camera(EXTENT);
    let materials = Globals { roughness: Some(0.0), ..Globals::default() }.materials(&scene, &View::default());
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let mut hits = |method: &str, setup: &Setup| {
        let method = find(method).unwrap();
        let shot = Shot::new(&mut stage, method, setup, Wants::HITS, camera, materials.clone()).unwrap();
        let (_, _, output) = stage.output(&shot).unwrap();
        let hits = stage.context.read(output.traced.hits.unwrap().0.all()).unwrap();
        (hits, gbuffer::reflection(&mut stage.context, &output).unwrap())
    };
    let exact = setup(|p| p.stochastic_rays = 3);
    let ((own, own_color), (unified, unified_color)) = (hits("stochastic", &exact), hits("unified", &exact));
    assert_eq!(own.values, unified.values);
    // Both methods interpolate the colour of the hit between four texels.
    let greatest = own_color.values.iter().zip(&unified_color.values).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(greatest < 2e-3, "{greatest}");

    let thesis = setup(|p| p.stochastic_walk = StochasticWalk::Thesis);
    let ((own, _), (ssct, _)) = (hits("stochastic", &thesis), hits("ssct", &thesis));
    let pixels: Vec<_> = own.texels().zip(ssct.texels()).filter(|(_, ssct)| ssct[3] > 0.0).collect();
    // Path codes must be equal, and places on the screen must be near.
    let near = |a: &[f32], b: &[f32]| a[3] == b[3] && (0..2).all(|i| (a[i] - b[i]).abs() < 1e-3);
    let same = pixels.iter().filter(|(own, ssct)| near(own, ssct)).count();
    // The two methods round the mirror direction differently, which now and then sends a ray another way.
    assert!(pixels.len() > 1000 && same as f64 > 0.98 * pixels.len() as f64, "{same} of {}", pixels.len());
    gpu.check_validation().unwrap();
}

/// Two frames without a history are equal to the bit. Rays that changed from frame to frame would flicker where nothing
/// averages them.
#[test]
fn frames_without_a_history_are_equal() {
    let data = rooms("corridor", 0.3);
    let [first, second] = [(), ()].map(|()| reflect(&data, "stochastic", &setup(|_| {})));
    assert_eq!(first.values, second.values);
}

/// A history of 16 frames lowers the error of one ray below 0.45 of itself. The image of `ssct` does not change from
/// frame to frame, and a history changes it by less than 0.001. A history whose weights did not sum to 1 would change
/// it.
#[test]
fn at_rest_a_history_lowers_the_error_of_rays_and_leaves_what_does_not_change() {
    let data = rooms("corridor", 0.3);
    let (truth, mask) = (truth(&data, 256), mask(&data));
    let plain = setup(|p| p.stochastic_gathered = 1);
    let error = |setup: &Setup| masked_rmse(&truth, &colors(&reflect(&data, "stochastic", setup)), &mask);
    let [alone, averaged] = [error(&plain), error(&with_history(&plain, 16))];
    println!("one frame {alone:.4}, sixteen {averaged:.4}");
    assert!(averaged < 0.45 * alone, "{averaged} against {alone}");

    let plain = setup(|_| {});
    let [without, with] = [&plain, &with_history(&plain, 4)].map(|setup| colors(&reflect(&data, "ssct", setup)));
    let difference = masked_rmse(&without, &with, &mask);
    // The history averages equal images, and rounds the result to 16-bit floats once more.
    assert!(difference < 1e-3, "{difference}");
}

/// Draws a scene with a method, one frame for each camera in order. Returns the last reflection and the passes of its
/// frame.
fn frames(scene: &Scene, method: &str, setup: &Setup, cameras: &[Camera]) -> (Pixels, Vec<String>) {
    let gpu = gpu();
    let mut stage = Stage::new(&gpu, scene).unwrap();
    let materials = Globals { roughness: Some(0.2), ..Globals::default() }.materials(scene, &View::default());
    let method = find(method).unwrap();
    let mut shot = Shot::new(&mut stage, method, setup, Wants::REFLECTION, cameras[0], materials).unwrap();
    let mut last = None;
    for camera in cameras {
        shot.camera = *camera;
        let (report, _, output) = stage.output(&shot).unwrap();
        last = Some((gbuffer::reflection(&mut stage.context, &output).unwrap(), report.recorded));
    }
    gpu.check_validation().unwrap();
    last.unwrap()
}

/// When the camera turns round at once, the next frame with a history equals the frame without one, within 0.001. A
/// history that trusts the old pixels would show the earlier view.
#[test]
fn after_a_cut_nothing_of_the_earlier_frames_is_left() {
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    // The second view looks the other way, so that the two views share no surface.
    let back = View { look_at: 2.0 * view.eye - view.look_at, ..view.clone() };
    let plain = setup(|_| {});
    let history = with_history(&plain, 16);
    let [ahead, back] = [view, &back].map(|view| view.camera(&scene, EXTENT));
    let (alone, _) = frames(&scene, "ssct", &plain, &[back]);
    let (cut, _) = frames(&scene, "ssct", &history, &[ahead, ahead, ahead, back]);
    let (kept, _) = frames(&scene, "ssct", &history, &[back, back, back, back]);
    let every_pixel = vec![true; alone.texels().count()];
    let [after_cut, at_rest] = [&cut, &kept].map(|image| masked_rmse(&colors(&alone), &colors(image), &every_pixel));
    println!("after a cut {after_cut:.5}, at rest {at_rest:.5}");
    assert!(after_cut < 1e-3 && at_rest < 1e-3, "{after_cut}, {at_rest}");
}

/// While the camera moves aside by 1 cm a frame, a history lowers the error of one ray below 0.6 of itself. A history
/// that reads the old pixels in the wrong place would blur the image.
#[test]
fn a_history_follows_what_a_moving_camera_sees() {
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let right = Vec3::Y.cross(view.look_at - view.eye).normalize();
    let aside =
        |metres: f32| View { eye: view.eye + right * metres, look_at: view.look_at + right * metres, ..view.clone() };
    let cameras: Vec<_> = (0..12).map(|n| aside(0.01 * n as f32).camera(&scene, EXTENT)).collect();
    let plain = setup(|p| p.stochastic_gathered = 1);
    let error = |setup: &Setup, reference: &[[f32; 3]]| {
        let (image, _) = frames(&scene, "stochastic", setup, &cameras);
        masked_rmse(reference, &colors(&image), &vec![true; reference.len()])
    };
    // The reference: one frame of the last camera with 64 rays a pixel.
    let many = setup(|p| (p.stochastic_rays, p.stochastic_gathered) = (64, 1));
    let (reference, _) = frames(&scene, "stochastic", &many, &cameras[11..]);
    let reference = colors(&reference);
    let [alone, averaged] = [error(&plain, &reference), error(&with_history(&plain, 16), &reference)];
    println!("moving: each frame alone {alone:.4}, with a history {averaged:.4}");
    assert!(averaged < 0.6 * alone, "{averaged} against {alone}");
}

/// For four methods, a frame with a history has one history pass, and a frame without one has none. A pass that ran
/// anyway would cost time.
#[test]
fn a_history_is_a_pass_and_its_absence_is_none() {
    let scene = clutter();
    let cameras = [clutter_camera(EXTENT); 2];
    for method in ["ssct", "unified", "dda", "stochastic"] {
        let plain = setup(|_| {});
        let (_, without) = frames(&scene, method, &plain, &cameras);
        let (_, with) = frames(&scene, method, &with_history(&plain, 2), &cameras);
        let count = |passes: &[String]| passes.iter().filter(|name| name.contains("history")).count();
        assert_eq!((count(&without), count(&with)), (0, 1), "{method}: {without:?}, {with:?}");
    }
}

/// Over the environment, a history of 16 frames lowers the error of one ray below 0.45 of itself. With wide bounds, it
/// keeps the mean of nine gathered rays within 2 %. The history must average the colour with its fade, since rays that
/// miss leave the fallback visible.
#[test]
fn over_a_fallback_a_history_averages_what_is_there() {
    let scene = crate::common::built_in("rooms");
    let camera = scene.view("corridor").unwrap().camera(&scene, EXTENT);
    let over = |rays| {
        setup(|p| (p.stochastic_rays, p.stochastic_gathered) = (rays, 1))
            .with(|p: &mut EffectParams| p.fallback = Fallback::Environment)
    };
    let image = |setup: &Setup, frame_count| {
        let (last, _) = frames(&scene, "stochastic", setup, &vec![camera; frame_count]);
        colors(&last)
    };
    let (many, one, averaged) = (image(&over(64), 1), image(&over(1), 1), image(&with_history(&over(1), 16), 16));
    let every_pixel = vec![true; many.len()];
    let [alone, averaged_error] = [&one, &averaged].map(|image| masked_rmse(&many, image, &every_pixel));
    println!("over the environment: one frame {alone:.4}, sixteen {averaged_error:.4}");
    assert!(averaged_error < 0.45 * alone, "{averaged_error} against {alone}");
    // The usual bounds of a history cut off the rare rays that find the bright sky. Wide bounds keep the mean.
    let gathered = over(1).with(|p: &mut StochasticParams| p.stochastic_gathered = 9);
    let wide = with_history(&gathered, 16).with(|p: &mut EffectParams| p.history_deviations = 100.0);
    let bias = mean(&image(&wide, 16)) / mean(&image(&gathered, 1)) - 1.0;
    println!("bias {bias:.4}");
    assert!(bias.abs() < 0.02, "{bias}");
}
