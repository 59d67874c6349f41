//! Tests motions: animations of glTF files, and motions that scene files name.

use super::gltf::{Square, scene, sentences};
use super::*;
use glam::Quat;
use serde_json::{Value, json};
use ssct_scenes::{Motion, scene_file};
use std::f32::consts::FRAC_1_SQRT_2;

/// Returns a document with two squares, one of which (node 0) hangs from an arm (node 2), and an animation. Each
/// channel has a node, a path, an interpolation, and the numbers of the key frames at 0 s and 1 s.
fn animated(channels: &[(usize, &str, &str, &[f32])]) -> Value {
    let mut square = Square::new();
    let times = square.accessors.len();
    square.floats("SCALAR", &[0.0, 1.0]);
    let (mut samplers, mut targets) = (Vec::new(), Vec::new());
    for (node, path, interpolation, values) in channels {
        square.floats(if *path == "rotation" { "VEC4" } else { "VEC3" }, values);
        samplers.push(json!({"input": times, "output": square.accessors.len() - 1, "interpolation": interpolation}));
        targets.push(json!({"sampler": targets.len(), "target": {"node": node, "path": path}}));
    }
    let mut document = square.document(json!({}));
    document["scenes"] = json!([{"nodes": [2, 1]}]);
    document["nodes"] = json!([
        {"mesh": 0, "name": "square", "translation": [1, 0, 0]},
        {"mesh": 0, "name": "square"},
        {"name": "arm", "children": [0], "translation": [0, 5, 0]},
    ]);
    document["animations"] = json!([{"name": "wave", "samplers": samplers, "channels": targets}]);
    document
}

/// Returns the place of the moving square's lower left corner at a time; in the file it is at (1, 5, 0).
fn corner(scene: &Scene, time_s: f32) -> Vec3 {
    let moved: Vec<_> = scene.motions[0].placements_at(time_s).collect();
    let [(mesh, placement)] = &moved[..] else { panic!("one of the two squares moves") };
    assert_eq!(*mesh, "square");
    placement.place(Vec3::new(1.0, 5.0, 0.0))
}

/// Rotation by linear, translation by spline and scale by stepped interpolation place the square as computed by hand.
/// The other square does not move, and a scaled scene has a scaled motion.
#[test]
fn nodes_are_moved_turned_and_made_larger_with_what_hangs_from_them() {
    let none = [0.0; 3];
    let quarter = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
    // A spline with slopes of 0 at both ends is half way in the middle.
    let spline = [none, [1.0, 0.0, 0.0], none, none, [3.0, 0.0, 0.0], none].concat();
    let steps = [[1.0; 3], [2.0; 3]].concat();
    let moved = scene(&animated(&[
        (2, "rotation", "LINEAR", &quarter),
        (0, "translation", "CUBICSPLINE", &spline),
        (2, "scale", "STEP", &steps),
    ]));
    assert!(sentences(&moved).is_empty(), "{:?}", sentences(&moved));
    assert_eq!(moved.meshes.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["square", "square 2"]);
    let turned = |degrees: f32, distance: f32| {
        Vec3::new(0.0, 5.0, 0.0) + Quat::from_rotation_z(degrees.to_radians()) * Vec3::X * distance
    };
    // The file is right-handed, and its x and y stay.
    for (time_s, expected) in
        [(-1.0, turned(0.0, 1.0)), (0.5, turned(45.0, 2.0)), (1.0, turned(90.0, 6.0)), (7.0, turned(90.0, 6.0))]
    {
        let position = corner(&moved, time_s);
        assert!(position.distance(expected) < 1e-4, "{time_s} s: {position} instead of {expected}");
    }
    let mut posed = moved.clone();
    posed.pose(&moved.motions[0], 1.0);
    let mesh = posed.meshes.iter().find(|m| m.name == "square").unwrap();
    assert!(mesh.bounds.min.distance(Vec3::new(-2.0, 11.0, 0.0)) < 1e-4, "{:?}", mesh.bounds);
    assert!(mesh.bounds.max.distance(Vec3::new(0.0, 15.0, 0.0)) < 1e-4, "{:?}", mesh.bounds);
    assert_eq!(
        posed.meshes.iter().find(|m| m.name == "square 2").unwrap().bounds,
        moved.meshes.iter().find(|m| m.name == "square 2").unwrap().bounds
    );
    // In a scene that is twice as large, the motion is twice as long.
    let mut doubled = moved.clone();
    doubled.scale(2.0);
    let (_, placement) = doubled.motions[0].placements_at(1.0).next().unwrap();
    let position = placement.place(Vec3::new(2.0, 10.0, 0.0));
    assert!(position.distance(2.0 * turned(90.0, 6.0)) < 1e-4, "{position}");
}

/// An uneven scale, too few values, and an unknown interpolation each leave the scene without the motion, with a
/// sentence.
#[test]
fn animations_that_cannot_be_played_leave_the_scene_with_a_sentence() {
    let warnings = |document: &Value| sentences(&scene(document)).join("; ");
    let uneven = animated(&[(0, "scale", "LINEAR", &[1.0, 1.0, 1.0, 1.0, 2.0, 1.0])]);
    assert_eq!(warnings(&uneven), "square stands still: a size that changes along one axis alone is not supported");
    let few = animated(&[(0, "translation", "CUBICSPLINE", &[0.0; 6])]);
    assert_eq!(
        warnings(&few),
        "animation wave was left out: its channel 0 does not have as many values as its key frames need"
    );
    let other = animated(&[(0, "translation", "BEZIER", &[0.0; 6])]);
    assert!(warnings(&other).contains("channel 0 has an interpolation that is not one of glTF"));
    for document in [uneven, few, other] {
        assert!(scene(&document).motions.is_empty());
    }
}

/// A square whose size becomes 0 shrinks to the place of its node. A square whose size is 0 at rest is named in a
/// sentence, since no scene has it.
#[test]
fn things_may_shrink_to_nothing() {
    let gone = scene(&animated(&[(0, "scale", "STEP", &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0])]));
    assert_eq!(sentences(&gone), [""; 0]);
    let node = Vec3::new(1.0, 5.0, 0.0);
    let upper_right = |time_s: f32| {
        let (_, placement) = gone.motions[0].placements_at(time_s).next().unwrap();
        placement.place(node + Vec3::new(2.0, 1.0, 0.0))
    };
    assert!(upper_right(0.5).distance(node + Vec3::new(2.0, 1.0, 0.0)) < 1e-5, "{}", upper_right(0.5));
    assert!(upper_right(1.0).distance(node) < 1e-4, "{}", upper_right(1.0));
    let mut grows = animated(&[(0, "scale", "LINEAR", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0])]);
    grows["nodes"][0]["scale"] = json!([0, 0, 0]);
    let expected =
        ["triangles without area were left out", "square is never drawn, since its size is 0 while no animation plays"];
    assert_eq!(sentences(&scene(&grows)), expected);
}

/// An animation that moves a camera or a light alone is named in a sentence, and is no motion.
#[test]
fn cameras_and_lights_do_not_move() {
    for node in [json!({"camera": 0}), json!({"extensions": {"KHR_lights_punctual": {"light": 0}}})] {
        let mut document = animated(&[(3, "translation", "LINEAR", &[0.0; 6])]);
        document["nodes"].as_array_mut().unwrap().push(node);
        document["scenes"] = json!([{"nodes": [2, 1, 3]}]);
        document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.2}}]);
        document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 64}]}});
        let scene = scene(&document);
        let expected = ["animations of cameras and lights are not played; they stay where they stand at rest"];
        assert_eq!((sentences(&scene), scene.motions.len()), (expected.to_vec(), 0));
    }
}

/// The lines of a scene file that name its mesh.
const MESH: &str = "[[mesh]]\nfile = \"a.obj\"\n";

/// Loads a scene file with the square as a mesh named `flag`, followed by the lines `text`.
fn load_flag(text: &str) -> ssct_ground::Result<Scene> {
    let folder = square("o flag\nf 1 2 3\nf 1 3 4\n");
    folder.write("test.scene.toml", format!("{MESH}{text}").as_bytes());
    scene_file::load(&folder.path("test.scene.toml"), &LoadOptions::default())
}

/// A motion of a scene file moves and turns its mesh between key frames. Wrong motions are refused with a line or a
/// name.
#[test]
fn scene_files_name_motions() {
    let keys = "[[motion.fly.key]]\ntime = 1\n[[motion.fly.key]]\ntime = 2\noffset = [0, 2, 0]\nturn_deg = 90\n";
    let scene =
        load_flag(&format!("[motion.fly]\nmesh = \"flag\"\npivot = [0, 0, 0]\naxis = [0, 0, 2]\n{keys}")).unwrap();
    let Motion { name, .. } = &scene.motions[0];
    assert_eq!(name, "fly");
    let position = |time_s: f32| {
        let (_, placement) = scene.motions[0].placements_at(time_s).next().unwrap();
        placement.place(Vec3::X)
    };
    assert!(position(0.5).distance(Vec3::X) < 1e-6, "{}", position(0.5));
    let half = Quat::from_rotation_z(45f32.to_radians()) * Vec3::X + Vec3::Y;
    assert!(position(1.5).distance(half) < 1e-5, "{}", position(1.5));
    assert!(position(3.0).distance(3.0 * Vec3::Y) < 1e-5, "{}", position(3.0));
    let refused = |text: &str, words: &str| {
        let message = load_flag(text).unwrap_err().to_string();
        assert!(message.contains(words), "{words}: {message}");
    };
    refused("[motion.fly]\nmesh = \"fag\"\n", "4: motion fly moves \"fag\", and no mesh has this name");
    refused("[motion.fly]\nmesh = \"flag\"\n", "motion fly does not have as many values as its key frames need");
    refused("[motion.fly]\nmesh = \"flag\"\naxis = [0, 0, 0]\n", "5: axis must not be zero");
    let turned = format!("[motion.fly]\nmesh = \"flag\"\n{}", keys.replace("90", "180"));
    refused(&turned, "turn_deg must change by less than 180");
    let back = format!("[motion.fly]\nmesh = \"flag\"\n{}", keys.replace("time = 2", "time = 1"));
    refused(&back, "motion fly has times that do not increase");
}
