//! Tests the large scenes in `../shared/scenes`, if they are present.

use super::*;
use crate::common::repository;
use ssct_geometry::texture;
use ssct_scenes::{Light, LoadOptions, Surface, gltf, scene_file};
use std::path::PathBuf;
use std::time::Instant;

/// Returns the folder of the large scenes. If it is absent, a line tells that the test is skipped.
fn shared() -> Option<PathBuf> {
    let folder = repository().join("../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: ../shared/scenes is absent");
        return None;
    }
    Some(folder)
}

/// Checks that two points are less than a millimetre apart.
fn assert_near(a: Vec3, b: Vec3) {
    assert!((a - b).length() < 1e-3, "{a} {b}");
}

/// Returns the names of images that the warnings call missing.
fn missing(scene: &Scene) -> Vec<&str> {
    let found = scene.warnings.iter().filter_map(|w| w.split_once(": image ")?.1.split_once(" is missing; "));
    found.map(|(name, _)| name).collect()
}

/// Crytek Sponza has the triangles, bounds, materials, maps and views that its files say, with two known warnings.
/// Measurements of several pages are of this scene.
#[test]
fn sponza_loads_as_its_scene_file_says() {
    let start = Instant::now();
    let Some(scene) = crate::common::sponza() else { return };
    println!("sponza.scene.toml loaded in {:.2} s", start.elapsed().as_secs_f32());
    assert_sound(&scene);
    // 8521 triangles and 135,321 quads, less one triangle without area.
    assert_eq!((scene.name.as_str(), scene.triangle_count()), ("sponza", 8521 + 2 * 135_321 - 1));
    assert_near(scene.bounds().min, Vec3::new(-19.209_46, -1.264_425, -11.054_26));
    assert_near(scene.bounds().max, Vec3::new(17.999_08, 14.294_332, 11.828_071));
    assert_eq!(missing(&scene), ["textures\\gi_flag.tga"]);
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings[0].ends_with("sponza.obj: 1 triangle without area was left out"));

    let reflecting = |materials: &[ssct_scenes::Material]| -> Vec<String> {
        materials.iter().filter(|m| m.reflectivity > 1e-4).map(|m| m.name.clone()).collect()
    };
    let views: Vec<_> = scene.views.iter().map(|v| (v.name.as_str(), reflecting(&scene.materials_in(v)))).collect();
    let expected = [("atrium", vec!["floor"]), ("lion", vec!["floor"]), ("hall", vec!["bricks", "floor"])];
    assert_eq!(views, expected.map(|(v, m)| (v, m.into_iter().map(String::from).collect())));
    assert_eq!(scene.materials.len(), 26);
    assert_eq!(scene.materials.iter().filter(|m| m.alpha_mask.is_some()).count(), 3);
    // Eight normal maps and the bricks' colour, which is taken for a height field.
    let maps: Vec<_> = scene.materials.iter().filter_map(|m| m.normal_map).collect();
    assert_eq!(maps.len(), 9);
    assert!(maps.iter().all(|&i| texture::is_normal_map(&scene.textures[i])));
    assert_eq!(scene.lights.len(), 1);
    // The views have the places of an older file format, which had left-handed places.
    assert_near(scene.views[2].eye, Vec3::new(-11.5, 1.6, -4.2));
}

/// The rooms of the thesis's author have the triangles, bounds, windows, views and lights that their files say; ten
/// images of theirs are missing.
#[test]
fn the_rooms_load_as_their_scene_file_says() {
    let Some(folder) = shared() else { return };
    let scene = scene_file::load(&folder.join("ssct-rooms/rooms.scene.toml"), &LoadOptions::default()).unwrap();
    assert_sound(&scene);
    assert_eq!((scene.name.as_str(), scene.triangle_count(), scene.materials.len()), ("ssct-rooms", 1542, 7));
    assert_near(scene.bounds().min, Vec3::new(-6.0, -1.0, -5.0));
    assert_near(scene.bounds().max, Vec3::new(6.0, 1.951_34, 5.158_07));
    let sky: Vec<_> = scene.meshes.iter().filter(|m| scene.materials[m.material].surface == Surface::Sky).collect();
    assert_eq!(sky.iter().map(|m| m.indices.len() / 3).sum::<usize>(), 6, "three windows");
    assert!(scene.materials.iter().all(|m| m.reflectivity == 1.0 && m.roughness == 0.0));
    let views: Vec<_> = scene.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(views, ["cylinder", "window-floor", "corridor", "two-cylinders", "window", "ceiling"]);
    assert_eq!(scene.lights.iter().filter(|l| matches!(l, Light::Point { .. })).count(), 3);
    let mut images = missing(&scene);
    images.sort_unstable();
    let expected = [
        "Bricks4.jpg",
        "Bricks4_NORM.png",
        "CeilingWood1.jpg",
        "StonesColorMap.jpg",
        "StonesNormalMap.jpg",
        "TilesColorMap.jpg",
        "TilesNormalMap.jpg",
        "WoodFloor1.jpg",
        "WoodFloor2.jpg",
        "white.png",
    ];
    assert_eq!(images, expected);
    assert_eq!(scene.warnings.len(), expected.len(), "{:?}", scene.warnings);
}

/// The OBJ files alone load with their triangles. The default view stands inside of the two rooms and outside of the
/// windows.
#[test]
fn the_bare_files_load_and_show_something() {
    let Some(folder) = shared() else { return };
    for (name, triangles, inside) in [
        ("sponza/sponza.obj", 279_162, true),
        ("ssct-rooms/SSCTTestScene2.obj", 1536, true),
        ("ssct-rooms/SSCTTestScene2-Windows.obj", 6, false),
    ] {
        let scene = obj::load(&[ObjFile::from(folder.join(name))], &ObjOptions::default()).unwrap();
        assert_sound(&scene);
        assert_eq!(scene.triangle_count(), triangles, "{name}");
        let (eye, bounds) = (scene.views[0].eye, scene.bounds());
        assert_eq!(eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all(), inside, "{name}: {eye}");
        assert!(scene.lens.far_m > (bounds.max - bounds.min).length());
    }
}

/// The roughness of the five spheres of the lower row does not fall along the row, from a mirror to the widest lobe.
#[test]
fn lobes_of_the_shared_spheres_widen_as_their_roughness_says() {
    let Some(folder) = shared() else { return };
    let scene = gltf::load(&folder.join("roughness-scale/scene.gltf"), &LoadOptions::default()).unwrap();
    assert_sound(&scene);
    assert_eq!((scene.meshes.len(), scene.triangle_count()), (10, 51_200));
    // The lower row has factors, from a mirror at +z of the file to the roughest at −z.
    let mut z_and_roughness: Vec<(f32, f32)> = (scene.meshes.iter().filter(|m| m.bounds.max.y < 0.0))
        .map(|m| (m.bounds.min.z, scene.materials[m.material].roughness))
        .collect();
    z_and_roughness.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let roughness: Vec<f32> = z_and_roughness.iter().map(|(_, roughness)| *roughness).collect();
    println!("{roughness:?}");
    assert!(roughness[0] < 1e-3 && roughness[0] < roughness[1] && roughness[1] < roughness[2], "{roughness:?}");
    assert_eq!(roughness[2..], [1.0; 3], "0.5 and above are wider than the widest lobe");
    let centre = Vec3::new(0.0, -3.0, 0.0);
    assert!(scene.meshes.iter().any(|m| (0.5 * (m.bounds.min + m.bounds.max)).distance(centre) < 1e-3));
}
