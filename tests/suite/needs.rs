//! Tests the needs of methods: in a scene that has what a method needs, its reflection shows something. In any other
//! scene the reflection is black, and studies leave the method out.

use crate::common;
use crate::common::folder::Folder;
use ssct::gpu::Pixels;
use ssct::methods::thesis::{ConeAngle, ConeParams, FadeParams};
use ssct::methods::{METHODS, MethodInfo, Setup, Wants, find};
use ssct_lab::stage::{Globals, Shot, Stage, image};
use ssct_scenes::{Scene, library};
use std::collections::BTreeMap;

/// Size of the images in pixels.
const SIZE: [u32; 2] = [66, 37];

/// Returns whether a method's reflection is black in every view of a scene.
fn is_black(stage: &mut Stage, scene: &Scene, method: &MethodInfo) -> bool {
    let setup = common::with_small_captures(&Setup::new(SIZE));
    scene.views.iter().all(|view| {
        let materials = Globals::default().materials(scene, view);
        let camera = view.camera(scene, SIZE);
        let shot = Shot::new(stage, method, &setup, Wants::REFLECTION, camera, materials).unwrap();
        let rendered = image::render(stage, &shot, false).unwrap();
        rendered.reflection.texels().all(|t| t[..3] == [0.0; 3])
    })
}

/// Returns the reflection that a method with its setup makes of the corridor of a scene.
fn corridor(stage: &mut Stage, scene: &Scene, (method, setup): (&str, &Setup), roughness: f32) -> Pixels {
    let view = scene.view("corridor").unwrap();
    let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(scene, view);
    let camera = view.camera(scene, SIZE);
    let shot = Shot::new(stage, find(method).unwrap(), setup, Wants::REFLECTION, camera, materials).unwrap();
    image::render(stage, &shot, false).unwrap().reflection
}

/// In every built-in scene that lacks what a method needs, its reflection is black in all views. In the first two that
/// have it, the reflection shows something (`golden` has the image in every scene). A need that is declared wrongly
/// would hide a method, or judge a black image.
#[test]
fn a_method_is_black_where_it_lacks_what_it_needs_and_only_there() {
    let gpu = common::gpu();
    let (mut times_shown, mut black) = (BTreeMap::new(), 0);
    for name in library::names() {
        let scene = common::built_in(name);
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        for method in METHODS.iter().filter(|m| !m.needs.is_empty()) {
            let lacks = method.unmet_needs(&scene);
            let times = times_shown.entry(method.name).or_insert(0);
            // Two scenes are enough, since making impostors and cube maps takes a second or two.
            if lacks.is_empty() && *times == 2 {
                continue;
            }
            assert_eq!(is_black(&mut stage, &scene, method), !lacks.is_empty(), "{} in {name}: {lacks:?}", method.name);
            let count = if lacks.is_empty() { times } else { &mut black };
            *count += 1;
        }
    }
    assert!(times_shown.values().all(|times| *times > 0) && black > 3, "shown: {times_shown:?}, black: {black}");
}

/// `ssct error` leaves out methods that would show nothing, says so, and refuses a list of such methods alone; `render`
/// warns. A black image has an error, too, which a table would show.
#[test]
fn what_a_study_compares_shows_something() {
    let folder = Folder::new();
    let small =
        ["--view", "cylinder", "--size", "34x19", "--roughness", "0", "--samples", "1", "--rays", "2", "--no-sweep"];
    let mixed = [&["error", "--scene", "rooms", "--method", "billboard,ssct,ibr", "-o", "out"], &small[..]].concat();
    let message = String::from_utf8(folder.run(&mixed).stderr).unwrap();
    assert!(
        message.contains("scene rooms has no impostors; left out, as they would show nothing: billboard, ibr"),
        "{message}"
    );
    let records: Vec<serde_json::Value> = serde_json::from_str(&folder.text("out/error.json")).unwrap();
    assert!(records.iter().all(|r| r["method"] != "billboard" && r["method"] != "ibr"));
    assert!(records.iter().any(|r| r["method"] == "ssct" && r["black"].as_f64().is_some_and(|b| b < 1.0)));

    let alone = [&["error", "--scene", "rooms", "--method", "billboard"], &small[..]].concat();
    let refused = folder.run(&alone);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("no method is left that would show anything in rooms"), "{message}");

    let render =
        ["render", "--scene", "rooms", "--view", "cylinder", "--method", "billboard", "--size", "34x19", "-o", "a.png"];
    let warned = folder.run(&render);
    assert!(warned.status.success());
    let message = String::from_utf8(warned.stderr).unwrap();
    assert!(message.contains("warning: billboard reflects impostors alone, and scene rooms has none"), "{message}");
}

/// The fade of Eq. 4.7 is tried with other ends, for seven methods. A start at the end is a hard edge and no division
/// by zero, a wide fade has many values between 0 and 1, and a far one fades nothing.
#[test]
fn a_fade_whose_ends_meet_is_a_hard_edge() {
    let gpu = common::gpu();
    let scene = common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let mut fades = |start: f32, end: f32, method: &str| {
        let setup = Setup::on_screen(SIZE).with(|p: &mut FadeParams| (p.fade_start, p.fade_end) = (start, end));
        let reflection = corridor(&mut stage, &scene, (method, &setup), 0.0);
        reflection.texels().map(|t| t[3]).collect::<Vec<f32>>()
    };
    for method in ["ssct", "hzct", "linear", "poster", "dda", "unified", "stochastic"] {
        let hard = fades(0.5, 0.5, method);
        assert!(hard.iter().all(|f| f.is_finite() && (0.0..=1.0).contains(f)), "{method}");
        let (soft, none) = (fades(0.1, 1.5, method), fades(2.0, 2.0, method));
        let between = |fades: &[f32]| fades.iter().filter(|f| (0.02..0.98).contains(*f)).count();
        assert!(between(&soft) > between(&none) + 20, "{method}: {} and {}", between(&soft), between(&none));
        assert!(hard.iter().sum::<f32>() < none.iter().sum::<f32>(), "{method}");
    }
}

/// Other values of ξ of Eq. 4.5 and of the exponent of mirrors change the image of `ssct`, and the published value
/// gives the image of the default. A shader that has them as constants would ignore the options.
#[test]
fn the_numbers_of_the_cone_are_options() {
    let gpu = common::gpu();
    let scene = common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let mut image = |change: fn(&mut ConeParams)| {
        let setup = Setup::on_screen(SIZE).with(change);
        let reflection = corridor(&mut stage, &scene, ("ssct", &setup), 0.1);
        reflection.values.into_iter().map(f32::to_bits).collect::<Vec<_>>()
    };
    let plain = image(|_| ());
    assert_eq!(plain, image(|p| p.cone_xi = 0.244));
    assert_ne!(plain, image(|p| p.cone_xi = 0.9));
    let interpolated = image(|p| p.cone_angle = ConeAngle::Interpolated);
    assert_ne!(interpolated, image(|p| (p.cone_angle, p.cone_mirror_alpha) = (ConeAngle::Interpolated, 100.0)));
    assert_ne!(interpolated, image(|p| (p.cone_angle, p.cone_xi) = (ConeAngle::Interpolated, 0.9)));
}
