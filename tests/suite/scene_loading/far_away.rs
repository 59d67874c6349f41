//! Tests scenes far from the origin. They are moved to the origin before positions are rounded to 32 bits, and a
//! warning says by how much.

use super::gltf::{Square, sentences, square as gltf_square};
use super::*;
use serde_json::{Value, json};
use ssct_scenes::{gltf, scene_file};

/// Returns a square as an OBJ file, with its corner at (x, y, z) and a side of `size`, in numbers with six decimals.
fn square_text(x: f64, y: f64, z: f64, size: f64) -> String {
    let corner = |u: f64, v: f64| format!("v {:.6} {:.6} {:.6}\n", x + size * u, y + size * v, z);
    [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)].concat() + "f 1 2 3 4\n"
}

/// Returns the length of the first edge of each triangle, which rounding would change.
fn edges(scene: &Scene) -> Vec<f32> {
    let triangles = scene.meshes.iter().flat_map(triangles);
    triangles.map(|[a, b, _]| position(&a).distance(position(&b))).collect()
}

/// A square of 12 cm at coordinates of a map keeps its edges within 0.1 mm, where a 32-bit float has steps of half a
/// metre. Two files of one scene are moved together.
#[test]
fn an_obj_file_of_a_map_keeps_its_details() {
    let folder = Folder::new(&[("a.obj", &square_text(456_789.25, 12.5, 5_432_109.75, 0.123))]);
    let scene = folder.scene();
    assert!(edges(&scene).iter().all(|e| (e - 0.123).abs() < 1e-4 || (e - 0.123 * 2_f32.sqrt()).abs() < 1e-4));
    assert!(scene.bounds().max.abs().max_element() < 1.0, "{:?}", scene.bounds());
    let warnings = folder.warnings(&scene);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("too far for its size") && warnings[0].contains("moved by (-456789"), "{warnings:?}");
    let half = folder.load("a.obj", &ObjOptions { load: scaled(0.5), ..LEFT }).unwrap();
    assert!(edges(&half).iter().any(|e| (e - 0.0615).abs() < 1e-4), "{:?}", edges(&half));
    // Files of one scene are moved together.
    folder.write("b.obj", square_text(456_791.25, 12.5, 5_432_109.75, 0.123).as_bytes());
    let files = ["a.obj", "b.obj"].map(|name| ObjFile::from(folder.path(name)));
    let bounds = obj::load(&files, &LEFT).unwrap().bounds();
    let size = bounds.max - bounds.min;
    assert!((size.x - 2.123).abs() < 1e-3, "{size}");
}

/// Scenes near the origin, or large ones around it, are not moved, so that their coordinates stay those of their files.
#[test]
fn near_scenes_stay_where_they_are() {
    for text in
        [square_text(0.0, 0.0, 0.0, 1.0), square_text(500.0, 0.0, 0.0, 1.0), square_text(-5_000.0, 0.0, 0.0, 10_000.0)]
    {
        let scene = Folder::new(&[("a.obj", &text)]).scene();
        assert_eq!(scene.warnings.len(), 0, "{:?}", scene.warnings);
    }
}

/// Returns the glTF square, scaled, at a place on the surface of the Earth, with a camera 4 m in front of it.
fn on_earth(scale: f64) -> Value {
    gltf_square(json!({}), |d| {
        d["nodes"] = json!([
            {"mesh": 0, "scale": [scale, scale, scale]},
            {"camera": 0, "translation": [0, 0, 4], "name": "cam"},
            {"children": [0, 1], "translation": [4_200_000, 170_000, 4_780_000]},
        ]);
        d["scenes"] = json!([{"nodes": [2]}]);
        d["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    })
}

/// The square keeps its area within 0.01 % at a place on the Earth, at two sizes, and the camera moves with it.
#[test]
fn a_gltf_scene_on_the_earth_is_as_smooth_as_at_the_origin() {
    for scale in [1.0, 1e-3] {
        let scene = super::gltf::scene(&on_earth(scale));
        assert!(
            (area(&scene) - (2.0 * scale * scale) as f32).abs() < 1e-4 * (scale * scale) as f32,
            "{}",
            area(&scene)
        );
        assert_eq!(sentences(&scene).len(), 1, "{:?}", scene.warnings);
        assert!(sentences(&scene)[0].contains("moved by (-4200"), "{:?}", scene.warnings);
        // The camera goes along.
        let view = &scene.views[0];
        assert!((view.eye.z - (scene.bounds().min.z - 4.0)).abs() < 1e-3, "{view:?} {:?}", scene.bounds());
    }
}

/// A scene file of a far mesh stays where it is and gets a warning, since its lights and views would not move with the
/// meshes.
#[test]
fn a_far_scene_file_is_not_moved_but_warned_of() {
    let folder = Folder::new(&[("a.obj", &square_text(456_789.25, 12.5, 5_432_109.75, 0.5))]);
    folder.write("a.scene.toml", b"handedness = \"left\"\n[[mesh]]\nfile = \"a.obj\"\n");
    let scene = scene_file::load(&folder.path("a.scene.toml"), &LoadOptions::default()).unwrap();
    assert!(scene.bounds().min.x > 456_000.0);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("floats lose its details"), "{:?}", scene.warnings);
    let gltf_folder = Folder::new(&[("a.gltf", &on_earth(1.0).to_string())]);
    gltf_folder.write("a.scene.toml", b"[[mesh]]\nfile = \"a.gltf\"\n");
    let scene = scene_file::load(&gltf_folder.path("a.scene.toml"), &LoadOptions::default()).unwrap();
    assert!(scene.bounds().min.x > 4e6 && scene.warnings.len() == 1, "{:?}", scene.warnings);
}

/// Positions that are far away in the glTF buffer itself are moved with a warning; the scene is sound.
#[test]
fn positions_that_are_rounded_in_the_file_are_moved_too() {
    let mut square = Square::new();
    let far = [[5e6, 0.0, 0.0], [5e6 + 2.0, 0.0, 0.0], [5e6 + 2.0, 1.0, 0.0], [5e6, 1.0, 0.0]];
    square.floats("VEC3", &far.concat());
    let mut document = square.document(json!({}));
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 4.into();
    let folder = Folder::new(&[("a.gltf", &document.to_string())]);
    let scene = gltf::load(&folder.path("a.gltf"), &LoadOptions::default()).unwrap();
    assert_sound(&scene);
    assert_eq!((area(&scene), scene.warnings.len()), (2.0, 1));
}
