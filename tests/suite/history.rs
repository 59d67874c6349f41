//! Tests the history of `unified`: what it averages at rest, which pixels it leaves alone, and how it follows a camera
//! or a mesh that moves.

use crate::common::gpu;
use glam::{Vec2, Vec3};
use ssct::methods::setup::HistoryUse;
use ssct::methods::{EffectParams, Setup, Wants, find};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::{Placement, Scene, View};
use ssct_truth::metrics::image::masked_rmse;

/// Size of the images in pixels.
const EXTENT: [u32; 2] = [161, 91];

/// The number of frames that the history averages.
const AVERAGED: u32 = 8;

/// Returns a setup with a history.
fn with_history() -> Setup {
    Setup::new(EXTENT).with(|p: &mut EffectParams| (p.history, p.history_frames) = (HistoryUse::On, AVERAGED))
}

/// The state of a frame: the view, the place of the ball, and the shift of the image.
struct Moment {
    view: View,
    ball: Placement,
    /// The shift of the image in pixels, to the right and down.
    shift: [f32; 2],
}

impl Moment {
    /// Returns a moment at rest: the view, with the ball in its own place and no shift.
    fn from_view(view: &View) -> Self {
        Self { view: view.clone(), ball: Placement::HERE, shift: [0.0; 2] }
    }
}

/// Returns the reflections that `unified` makes of a scene, one image for each moment.
fn film(scene: &Scene, roughness: f32, setup: &Setup, moments: &[Moment]) -> Vec<Vec<[f32; 3]>> {
    let gpu = gpu();
    let mut stage = Stage::new(&gpu, scene).unwrap();
    let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(scene, &moments[0].view);
    let camera = |moment: &Moment| moment.view.camera(scene, EXTENT).jittered(moment.shift, EXTENT);
    let first_camera = camera(&moments[0]);
    let mut shot =
        Shot::new(&mut stage, find("unified").unwrap(), setup, Wants::REFLECTION, first_camera, materials).unwrap();
    let mut images = Vec::new();
    for moment in moments {
        stage.scene_mut().place_meshes("ball", moment.ball).unwrap();
        shot.camera = camera(moment);
        let (_, _, output) = stage.output(&shot).unwrap();
        let image = gbuffer::reflection(&mut stage.context, &output).unwrap();
        images.push(image.texels().map(|texel| [texel[0], texel[1], texel[2]]).collect());
    }
    gpu.check_validation().unwrap();
    images
}

/// Returns the rooms, and the view of their corridor.
fn rooms() -> (Scene, View) {
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap().clone();
    (scene, view)
}

/// Returns the rooms with the normals of their triangles, which all drivers draw alike: each driver filters maps of
/// normals in its own way (docs/devices.md).
fn rooms_without_bumps() -> (Scene, View) {
    let (mut scene, view) = rooms();
    scene.materials.iter_mut().for_each(|material| material.normal_deviation = 0.0);
    (scene, view)
}

/// Returns the moments of a camera that moves aside by 2 cm in each of `moving` frames and then rests.
fn walk(view: &View, moving: u32, resting: u32) -> Vec<Moment> {
    let right = Vec3::Y.cross(view.look_at - view.eye).normalize();
    let view_in = |frame: u32| {
        let aside = right * (0.02 * frame.min(moving) as f32);
        View { eye: view.eye + aside, look_at: view.look_at + aside, ..view.clone() }
    };
    (0..=moving + resting).map(|frame| Moment::from_view(&view_in(frame))).collect()
}

/// Returns the moments of a camera at rest: after `resting` frames, the ball rolls by 3 cm along x and along z in each
/// frame.
fn roll(view: &View, resting: u32, rolling: u32) -> Vec<Moment> {
    let ball_offset = |frame: u32| Vec3::new(-0.03, 0.0, -0.03) * frame.saturating_sub(resting) as f32;
    let moment = |frame: u32| Moment { ball: ball_offset(frame).into(), ..Moment::from_view(view) };
    (0..=resting + rolling).map(moment).collect()
}

/// Returns the root mean square difference of two images, over all pixels.
fn rmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    masked_rmse(a, b, &vec![true; a.len()])
}

/// At roughness 0, the film with a history equals the film without, to the bit. A mirror has no noise, so that
/// averaging could only smear it.
#[test]
fn mirrors_have_no_history() {
    let (scene, view) = rooms();
    let moments = walk(&view, 3, 2);
    let [alone, averaged] = [Setup::new(EXTENT), with_history()].map(|setup| film(&scene, 0.0, &setup, &moments));
    assert!(alone == averaged, "a history changes a mirror");
}

/// While the camera rests, the image changes as long as frames are averaged. From the eighth frame on, it is the same
/// to the bit. A history that keeps rounding would drift for ever.
#[test]
fn at_rest_the_picture_settles_and_then_stands_still_to_the_bit() {
    let (scene, view) = rooms();
    for roughness in [0.1, 0.4] {
        let frames = film(&scene, roughness, &with_history(), &walk(&view, 0, AVERAGED + 3));
        let last = AVERAGED as usize - 1;
        assert!(frames[0] != frames[last], "roughness {roughness}: nothing was averaged");
        assert!(
            frames[last..].iter().all(|frame| *frame == frames[last]),
            "roughness {roughness}: it does not stand still"
        );
    }
}

/// Four frames after a moving camera stops, the error against the settled image is below 0.7 of the error of one frame
/// without a history. A history that keeps old frames too long would trail behind.
#[test]
fn four_frames_after_a_stop_the_picture_is_what_it_will_be() {
    let (scene, view) = rooms_without_bumps();
    for roughness in [0.1, 0.4] {
        let moments = walk(&view, 6, 2 * AVERAGED);
        let frames = film(&scene, roughness, &with_history(), &moments);
        // The reference: as many frames, all of them at rest.
        let settled = film(&scene, roughness, &with_history(), &moments[6..]);
        let truth = settled.last().unwrap();
        let [at_stop, after_four, at_end] = [6, 10, frames.len() - 1].map(|frame| rmse(truth, &frames[frame]));
        let alone = rmse(truth, &film(&scene, roughness, &Setup::new(EXTENT), &moments[6..7])[0]);
        println!("roughness {roughness}: {alone:.4} alone, {at_stop:.4} at the stop, {after_four:.4}, {at_end:.4}");
        assert!(at_stop < alone, "{at_stop} against {alone}");
        assert!(after_four < 0.7 * alone, "{after_four} against {alone}");
    }
}

/// Returns the mean of images, as a renderer averages the frames of a jittered camera.
fn mean(images: &[Vec<[f32; 3]>]) -> Vec<[f32; 3]> {
    let sum = |pixel: usize, channel: usize| images.iter().map(|image| image[pixel][channel]).sum::<f32>();
    (0..images[0].len()).map(|pixel| [0, 1, 2].map(|channel| sum(pixel, channel) / images.len() as f32)).collect()
}

/// Over five phases of a jitter, the mean image with a history is nearer to the truth than without, by a factor of 0.6
/// for narrow lobes and 0.7 for wide ones. A history that takes the jitter for motion would begin anew in each frame.
#[test]
fn a_jittered_camera_at_rest_is_at_rest() {
    let (scene, view) = rooms();
    let phases = [[0.0, -0.17], [-0.25, 0.17], [0.25, -0.39], [-0.38, -0.06], [0.13, 0.28]];
    let jittered = |phase: usize| Moment { shift: phases[phase % phases.len()], ..Moment::from_view(&view) };
    for (roughness, greatest_ratio) in [(0.1, 0.6), (0.4, 0.7)] {
        // The truth: each phase by itself at rest, averaged over five times as many frames.
        let long_history = with_history().with(|p: &mut EffectParams| p.history_frames = 5 * AVERAGED);
        let settled_in = |phase: usize| {
            let moments: Vec<_> = (0..5 * AVERAGED).map(|_| jittered(phase)).collect();
            film(&scene, roughness, &long_history, &moments).pop().unwrap()
        };
        let truth = mean(&(0..phases.len()).map(settled_in).collect::<Vec<_>>());
        let moments: Vec<_> = (0..4 * phases.len()).map(jittered).collect();
        let over_phases = |setup: &Setup| {
            let frames = film(&scene, roughness, setup, &moments);
            rmse(&truth, &mean(&frames[3 * phases.len()..]))
        };
        let [error_with, error_without] = [with_history(), Setup::new(EXTENT)].map(|setup| over_phases(&setup));
        println!("roughness {roughness}: {error_with:.4} with a history, {error_without:.4} without");
        assert!(
            error_with < greatest_ratio * error_without,
            "roughness {roughness}: {error_with} with a history, {error_without} without"
        );
    }
}

/// From one frame of the rolling ball to the next, at most 1.2 times as many pixels change with a history as without.
#[test]
fn a_thing_that_moves_changes_no_pixel_that_does_not_see_it() {
    let (scene, view) = rooms();
    let moments = roll(&view, AVERAGED, 4);
    let [alone, averaged] = [Setup::new(EXTENT), with_history()].map(|setup| film(&scene, 0.1, &setup, &moments));
    // The last two frames are compared, in which the ball rolls. In frames at rest, a history changes the directions of
    // rays.
    let (before, after) = (moments.len() - 2, moments.len() - 1);
    let changes = |film: &[Vec<[f32; 3]>], pixel: usize| film[before][pixel] != film[after][pixel];
    let count = |film: &[Vec<[f32; 3]>]| (0..film[0].len()).filter(|pixel| changes(film, *pixel)).count();
    let [changed_without, changed_with] = [count(&alone), count(&averaged)];
    println!("{changed_without} pixels change without a history, {changed_with} with one");
    assert!(changed_without > 50, "the ball changes {changed_without} pixels");
    assert!(
        changed_with as f64 <= 1.2 * changed_without as f64,
        "{changed_with} pixels change with a history, {changed_without} without"
    );
}

/// After ten frames of rolling, the pixels that showed or show the ball are at most 1.1 times as far from the truth as
/// one frame without a history: no ghost is left.
#[test]
fn nothing_of_a_thing_is_left_where_it_was_reflected() {
    let (scene, view) = rooms();
    let moments = roll(&view, AVERAGED, 10);
    let rolled = film(&scene, 0.1, &with_history(), &moments);
    // The truth: frames in which the ball always is where it ends.
    let still: Vec<Moment> =
        (0..AVERAGED).map(|_| Moment { ball: moments.last().unwrap().ball, ..Moment::from_view(&view) }).collect();
    let settled = film(&scene, 0.1, &with_history(), &still);
    let alone = film(&scene, 0.1, &Setup::new(EXTENT), &still[..1]);
    let at_start = film(&scene, 0.1, &Setup::new(EXTENT), &moments[..1]);
    let shows_ball: Vec<bool> = at_start[0].iter().zip(&alone[0]).map(|(a, b)| a != b).collect();
    let truth = settled.last().unwrap();
    let [error_with, error_without] =
        [rolled.last().unwrap(), &alone[0]].map(|image| masked_rmse(truth, image, &shows_ball));
    println!("where the ball was and is: {error_with:.4} with a history, {error_without:.4} without");
    assert!(error_with < 1.1 * error_without, "{error_with} against {error_without}");
}

/// Places the ball of the rooms twenty times as large before the camera, so deep in the floor that a hill 3.4 m wide
/// stands out: a slightly curved mirror. Returns the placement, the ball's centre and its radius in metres.
fn hill(scene: &Scene, view: &View) -> (Placement, Vec3, f32) {
    /// The factor on the size of the ball.
    const SIZE: f32 = 20.0;
    const HEIGHT_M: f32 = 0.3;
    let bounds = scene.meshes.iter().find(|mesh| mesh.name == "ball").unwrap().bounds;
    let (ball_centre, radius) = (0.5 * (bounds.min + bounds.max), 0.5 * SIZE * (bounds.max.y - bounds.min.y));
    let floor = scene.meshes.iter().find(|mesh| mesh.name == "floor").unwrap().bounds.max.y;
    let ahead = (view.look_at - view.eye).with_y(0.0).normalize();
    let centre = (view.eye + 2.5 * ahead).with_y(floor + HEIGHT_M - radius);
    (Placement { size: SIZE, offset: centre - SIZE * ball_centre, ..Placement::HERE }, centre, radius)
}

/// The hill moves aside by 3 cm in each frame. In its pixels, the history has less than 0.75 of the error of one frame,
/// since it follows the mesh and not only the camera.
#[test]
fn a_mirror_that_moves_finds_what_it_showed() {
    let (scene, view) = rooms_without_bumps();
    let (hill, centre, radius) = hill(&scene, &view);
    let right = Vec3::Y.cross(view.look_at - view.eye).normalize();
    let view = View { look_at: centre.with_y(centre.y + radius), ..view };
    let moment = |frame: u32| {
        let aside = right * (0.03 * frame as f32 - 0.24);
        Moment { ball: Placement { offset: hill.offset + aside, ..hill }, ..Moment::from_view(&view) }
    };
    let moments: Vec<Moment> = (0..=AVERAGED).map(moment).collect();
    let last_moment = || moment(AVERAGED);
    let still: Vec<Moment> = (0..2 * AVERAGED).map(|_| last_moment()).collect();
    let far_below = Placement { offset: Vec3::new(0.0, -100.0, 0.0), ..Placement::HERE };
    for roughness in [0.1, 0.3] {
        let settled = film(&scene, roughness, &with_history(), &still);
        let truth = settled.last().unwrap();
        let without_hill = film(&scene, roughness, &Setup::new(EXTENT), &[Moment { ball: far_below, ..last_moment() }]);
        let alone = film(&scene, roughness, &Setup::new(EXTENT), &[last_moment()]);
        let shows_hill: Vec<bool> = without_hill[0].iter().zip(&alone[0]).map(|(a, b)| a != b).collect();
        let moved = film(&scene, roughness, &with_history(), &moments);
        let [averaged, alone] = [moved.last().unwrap(), &alone[0]].map(|image| masked_rmse(truth, image, &shows_hill));
        println!(
            "roughness {roughness}, {} pixels: {averaged:.4} with a history, {alone:.4} without",
            shows_hill.iter().filter(|shown| **shown).count()
        );
        assert!(averaged < 0.75 * alone, "roughness {roughness}: {averaged} with a history, {alone} without");
    }
}

/// The camera moves past the hill, which stands still. In the hill's pixels, the history has a smaller error than one
/// frame. The reflected point moves over a curved mirror in another way than over a flat one.
#[test]
fn a_curved_mirror_finds_what_it_showed() {
    let (scene, view) = rooms_without_bumps();
    let (hill, centre, radius) = hill(&scene, &view);
    let right = Vec3::Y.cross(view.look_at - view.eye).normalize();
    let moment = |frame: u32| {
        let aside = right * (0.05 * frame.min(8) as f32 - 0.4);
        let look_at = centre.with_y(centre.y + radius) + aside;
        let view = View { eye: view.eye + aside, look_at, ..view.clone() };
        Moment { ball: hill, ..Moment::from_view(&view) }
    };
    let moments: Vec<Moment> = (0..8 + 3 * AVERAGED).map(moment).collect();
    let camera = moments[8].view.camera(&scene, EXTENT);
    let scale = camera.view_to_clip().to_cols_array_2d();
    // Returns true if a pixel shows the top of the hill: the ray through it meets the sphere near the top.
    let shows_top = |pixel: u32| {
        let place = Vec2::new((pixel % EXTENT[0]) as f32, (pixel / EXTENT[0]) as f32) + 0.5;
        let ndc = (2.0 * place / Vec2::new(EXTENT[0] as f32, EXTENT[1] as f32) - 1.0) * Vec2::new(1.0, -1.0);
        let direction = Vec3::new(ndc.x / scale[0][0], ndc.y / scale[1][1], 1.0);
        let direction = camera.world_to_view.inverse().transform_vector3(direction).normalize();
        let to_centre = centre - camera.eye();
        let (distance_to_closest, miss_distance) = (to_centre.dot(direction), to_centre.cross(direction).length());
        let end = camera.eye()
            + (distance_to_closest - (radius * radius - miss_distance * miss_distance).max(0.0).sqrt()) * direction;
        distance_to_closest > 0.0 && miss_distance < radius && end.y > centre.y + radius - 0.25
    };
    let mask: Vec<bool> = (0..EXTENT[0] * EXTENT[1]).map(shows_top).collect();
    assert!(mask.iter().filter(|shown| **shown).count() > 500, "too little of the hill is seen");
    for roughness in [0.05, 0.1, 0.3] {
        let settled = film(&scene, roughness, &with_history(), &moments[8..]);
        let [alone, averaged] =
            [Setup::new(EXTENT), with_history()].map(|setup| film(&scene, roughness, &setup, &moments[..9]));
        let truth = settled.last().unwrap();
        let [alone, averaged] = [alone, averaged].map(|frames| masked_rmse(truth, &frames[8], &mask));
        println!("roughness {roughness}: {alone:.4} alone, {averaged:.4} with a history");
        // If the history took the mirror as flat, its error at roughness 0.3 would be 1.16 times that of one frame.
        assert!(averaged < alone, "{averaged} with a history, {alone} without");
    }
}
