//! Tests scenes with very many materials, planes or lights, or too large an image: they are drawn, or refused in a
//! sentence that names the thing.

use crate::common::{Builder, camera, gpu, show};
use glam::Vec3;
use ssct::methods::Setup;
use ssct::methods::planar::PlanarParams;
use ssct::passes::scene_data::MAX_LIGHTS;
use ssct_lab::stage::{Globals, Stage};
use ssct_scenes::obj::{Handedness, ObjFile, ObjOptions};
use ssct_scenes::{Light, obj};
use std::fmt::Write;

/// Returns the albedo of the material with a number. Materials of neighbouring numbers differ.
fn albedo(n: u32) -> Vec3 {
    Vec3::new((n % 16) as f32 / 15.0, (n / 16 % 16) as f32 / 15.0, (n / 256) as f32 / 15.0)
}

/// Returns the texts of an OBJ and an MTL file: quads in columns and rows, each with a material of its own. Together
/// they fill a rectangle around the z axis, whose half sides and z are in metres. Quad 0 is at the bottom left.
fn mosaic([columns, rows]: [u32; 2], [half_width, half_height]: [f32; 2], z: f32) -> [String; 2] {
    let (mut mesh, mut materials) = ("mtllib a.mtl\n".to_owned(), String::new());
    for n in 0..columns * rows {
        let edge = |i: u32, count: u32, half: f32| half * (2.0 * i as f32 / count as f32 - 1.0);
        let [left, right] = [0, 1].map(|i| edge(n % columns + i, columns, half_width));
        let [low, high] = [0, 1].map(|i| edge(n / columns + i, rows, half_height));
        let Vec3 { x: r, y: g, z: b } = albedo(n);
        writeln!(materials, "newmtl m{n}\nKd {r} {g} {b}").unwrap();
        writeln!(mesh, "v {left} {low} {z}\nv {right} {low} {z}\nv {right} {high} {z}\nv {left} {high} {z}").unwrap();
        writeln!(mesh, "usemtl m{n}\nf -1 -2 -3 -4").unwrap();
    }
    [mesh, materials]
}

/// A wall of 3000 quads of 3000 materials is drawn, each quad with the albedo of its own material. A uniform block that
/// two materials shared would show a wrong colour.
#[test]
fn three_thousand_materials_are_drawn() {
    // Each material has a uniform block of its own; together they need more than one chunk of the frame's uniform
    // memory.
    let (grid, extent, z) = ([60, 50], [240, 200], 10.0);
    let view = camera(Vec3::ZERO, Vec3::Z, extent);
    let half_height = 0.5 * view.lens.height_at_m(z);
    let folder = tempfile::tempdir().unwrap();
    let [mesh, materials] = mosaic(grid, [half_height * 1.2, half_height], z);
    for (name, text) in [("a.obj", mesh), ("a.mtl", materials)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let options = ObjOptions { handedness: Handedness::Left, ..ObjOptions::default() };
    let mut scene = obj::load(&[ObjFile::from(folder.path().join("a.obj"))], &options).unwrap();
    assert_eq!([scene.materials.len(), scene.meshes.len()], [3000, 3000]);
    scene.lights = vec![Light::Directional { direction: Vec3::Z, energy: 1.0 }];
    let globals = Globals { reflectivity: 0.0, ..Globals::default() };
    let shown = show(&gpu(), &scene, view, "ssct", &Setup::new(extent), &globals);
    assert_eq!(shown.image.drawn.meshes, 3000);
    for n in 0..3000 {
        // The pixel is in the middle of the quad's 4 × 4 pixels; rows of the picture run from the top.
        let [x, y] = [4 * (n % grid[0]) + 2, 4 * (grid[1] - 1 - n / grid[0]) + 2];
        let color = Vec3::from_slice(&shown.image.composite.texel(x, y)[..3]);
        let expected = albedo(n);
        assert!(color.distance(expected) < 0.02, "material {n}: {color} instead of {expected}");
    }
}

/// `planar` mirrors a scene of 300 materials at eight planes, in eight passes, each of which needs all materials again.
#[test]
fn three_hundred_materials_are_mirrored_at_eight_planes() {
    let mut b = Builder::new("eight mirrors");
    b.light(Vec3::new(0.3, -0.6, 1.0));
    for n in 0..300 {
        let material = b.matt(albedo(n));
        let corner = Vec3::new((n % 20) as f32 - 10.0, 0.5 + (n / 20) as f32 * 0.2, 9.0);
        b.quad(material, corner, Vec3::X, Vec3::Y * 0.2, Vec3::NEG_Z);
    }
    let mirror = b.mirror();
    for n in 0..8 {
        // A fan of mirrors, side by side, each turned towards the eye by its own angle.
        let (x, tilt) = (n as f32 * 2.0 - 8.0, 0.05 * n as f32);
        let up = Vec3::new(0.0, tilt.sin(), tilt.cos()) * 6.0;
        b.quad(mirror, Vec3::new(x, -1.0, 2.0), Vec3::X * 2.0, up, Vec3::new(0.0, tilt.cos(), -tilt.sin()));
    }
    let extent = [66, 37];
    let view = camera(Vec3::new(0.0, 1.5, 0.0), Vec3::new(0.0, 0.0, 6.0), extent);
    let setup = Setup::new(extent).with(|p: &mut PlanarParams| p.planar_planes = 8);
    let shown = show(&gpu(), &b.0, view, "planar", &setup, &Globals::default());
    let mirrored = shown.image.report.recorded.iter().filter(|pass| *pass == "mirrored g-buffer").count();
    assert_eq!(mirrored, 8, "{:?}", shown.image.report.recorded);
}

/// A scene of 16 lights is taken, and one of 17 is refused with both numbers, where a shader would ignore the last
/// light.
#[test]
fn more_lights_than_are_drawn_are_refused() {
    let mut b = Builder::new("disco");
    let floor = b.mirror();
    b.quad(floor, Vec3::new(-1.0, 0.0, 1.0), Vec3::X, Vec3::Z, Vec3::Y);
    (0..MAX_LIGHTS).for_each(|_| b.light(Vec3::NEG_Y));
    let gpu = gpu();
    assert!(Stage::new(&gpu, &b.0).is_ok());
    b.light(Vec3::NEG_Y);
    let message = Stage::new(&gpu, &b.0).err().unwrap().to_string();
    assert_eq!(message, "scene disco has 17 lights; at most 16 can be drawn");
}

/// An image that is wider than the device allows is refused with its name and size. A driver's error would name
/// neither.
#[test]
fn an_image_that_is_too_large_is_refused_by_its_name() {
    let gpu = gpu();
    let side = gpu.max_image_size() + 1;
    let image = ssct::gpu::Image::target(&gpu, "poster", ash::vk::Format::R8G8B8A8_UNORM, [side, 1]);
    let message = image.err().unwrap().to_string();
    assert!(message.starts_with(&format!("poster: an image of {side}x1 is impossible: ")), "{message}");
}
