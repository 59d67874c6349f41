//! Tests the lights and views that are chosen for a glTF file without lights or cameras, and the exposure of the lights
//! that a file has. Tests which cameras lose a roll.

use super::gltf::{close, scene, sentences, square};
use super::*;
use glam::Quat;
use serde_json::{Value, json};
use ssct_scenes::Light;

/// Returns the notes about a document, without the name of the file.
fn notes(document: &Value) -> Vec<String> {
    scene(document).notes.iter().map(|n| n.split_once("a.gltf: ").expect("the file's name").1.to_owned()).collect()
}

/// Adds a camera to the document of the square, 5 m in front of it, as node 1.
fn add_camera(document: &mut Value) {
    document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1, "zfar": 100.0}}]);
    document["nodes"].as_array_mut().unwrap().push(json!({"camera": 0, "translation": [0, 0, 5]}));
    document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(1));
}

/// Returns the square with a light of `KHR_lights_punctual`, which stands at a place and shines along the file's −z.
fn lit(light: Value, translation: [f32; 3]) -> Value {
    square(json!({}), |d| {
        d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        d["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
        d["nodes"][0] = json!({"mesh": 0});
        d["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!({"translation": translation, "extensions": {"KHR_lights_punctual": {"light": 0}}}));
        d["scenes"][0]["nodes"] = json!([0, 1]);
    })
}

/// If a file has neither lights nor cameras, or no lights, a note says what the program chose instead. A user could
/// take the choice for the file's own.
#[test]
fn a_file_without_lights_or_cameras_says_what_was_chosen() {
    let neither = notes(&square(json!({}), |_| ()));
    assert_eq!(
        neither,
        [
            "it has neither lights nor cameras; one directional light shines from above, and the view shows all of the scene"
        ]
    );
    assert_eq!(notes(&square(json!({}), add_camera)), ["it has no lights; one directional light shines from above"]);
}

/// A sun and a lamp, which give different illuminances, are both exposed so that the brightest gives 1 at the centre of
/// the scene.
#[test]
fn suns_and_lamps_of_any_strength_give_one_exposure() {
    // A sun of 3 W/m² as Blender exports it, and a lamp of 1000 W, 2 m in front of the square's centre.
    let sun = lit(json!({"type": "directional", "intensity": 2049.0}), [0.0, 0.0, 0.0]);
    let lamp = lit(json!({"type": "point", "intensity": 54_351.0}), [1.0, 0.5, 2.0]);
    for (document, lux) in [(&sun, "2049"), (&lamp, "13588")] {
        let lines = notes(document);
        let expected = format!(
            "its lights are exposed so that the brightest, which gives {lux} lx at the scene's centre, gives 1"
        );
        assert_eq!(lines, [expected, "it has no cameras; the view shows all of the scene".to_owned()]);
    }
    let energy = |document: &Value| match scene(document).lights[..] {
        [Light::Directional { energy, .. } | Light::Point { energy, .. }] => energy,
        _ => panic!("one light"),
    };
    assert!(close(energy(&sun), 1.0) && close(energy(&lamp), 4.0), "{} {}", energy(&sun), energy(&lamp));
    // The lamp lights the square that faces it, but less than fully.
    let lit_by = scene(&lamp).lights[0].shading(Vec3::new(1.0, 0.5, 0.0), Vec3::NEG_Z);
    assert!(lit_by > 0.2 && lit_by < 1.0, "{lit_by}");
}

/// Lamps of 0.5 and 5 000 000 candela at one place give the same exposed light.
#[test]
fn a_dim_lamp_is_exposed_as_a_bright_one_is() {
    let dim = lit(json!({"type": "point", "intensity": 0.5}), [1.0, 0.5, 2.0]);
    let bright = lit(json!({"type": "point", "intensity": 5e6}), [1.0, 0.5, 2.0]);
    assert_eq!(scene(&dim).lights, scene(&bright).lights);
    assert!(notes(&dim)[0].contains("which gives 0.125 lx"), "{:?}", notes(&dim));
}

/// A camera that is rolled, hangs upside down, or is turned while it looks straight down gets a warning, since views
/// are upright. Level and tilted cameras, and those that look straight up or down as a view does, get none.
#[test]
fn only_cameras_that_are_set_upright_get_a_warning() {
    let [x, y, z] = [Quat::from_rotation_x, Quat::from_rotation_y, Quat::from_rotation_z];
    let half_pi = std::f32::consts::FRAC_PI_2;
    for (turn, is_rolled) in [
        (Quat::IDENTITY, false),
        (y(0.5) * x(-0.4), false),
        (x(-half_pi), false),
        (x(half_pi), false),
        (z(0.3), true),
        (z(2.0 * half_pi), true),
        (x(-half_pi) * z(half_pi), true),
    ] {
        let document = square(json!({}), |d| {
            add_camera(d);
            d["nodes"][1]["rotation"] = json!(turn.to_array());
        });
        let scene = scene(&document);
        let has_warning = sentences(&scene).iter().any(|sentence| sentence.starts_with("cameras that are rolled"));
        assert_eq!(has_warning, is_rolled, "{turn}");
    }
}
