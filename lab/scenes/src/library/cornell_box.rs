//! `cornell-box`: the box of the thesis's figure 2.4 (after Goral et al. 1984), with two blocks, a red and a green
//! wall, and a lamp in the ceiling. The measures are those that Cornell University publishes, divided by 100, so that
//! the size of the box suits the planes of the other scenes' lens. No surface reflects.

use super::builder::{MeshBuilder, Rect};
use super::{Finish, materials, probe, view};
use crate::{AreaLight, AreaShape, FieldOfView, Lens, Light, Scene};
use glam::{Vec2, Vec3};

// Indices of materials in `FINISHES`.
const WHITE: usize = 0;
const RED: usize = 1;
const GREEN: usize = 2;
const LAMP: usize = 3;

const FINISHES: [Finish; 4] = [
    Finish::paint("white", 0.73, 0.71, 0.68),
    Finish::paint("red", 0.61, 0.06, 0.06),
    Finish::paint("green", 0.12, 0.43, 0.11),
    Finish::paint("lamp", 1.0, 0.95, 0.8),
];

/// Width (x), height (y) and depth (z) of the box, in metres.
const WIDTH: f32 = 5.56;
const HEIGHT: f32 = 5.488;
const DEPTH: f32 = 5.592;
/// The x and z ranges of the lamp, in metres.
const LAMP_RANGES: ([f32; 2], [f32; 2]) = ([2.13, 3.43], [2.27, 3.32]);
/// Distance of the lamp below the ceiling, and of the lamp's area light below the lamp, in metres.
const LAMP_GAP: f32 = 0.005;
/// The corners of the two blocks on the floor (x and z), and the heights of the blocks, in metres.
const BLOCKS: [([[f32; 2]; 4], f32); 2] = [
    ([[4.26, 0.65], [4.74, 2.25], [3.16, 2.72], [2.66, 1.14]], 1.65),
    ([[1.33, 2.47], [2.91, 2.96], [2.42, 4.56], [0.84, 4.06]], 3.3),
];

/// Builds the scene, with its meshes, materials, lights, view and probes.
pub fn scene() -> Scene {
    let (mut materials, textures) = materials(&FINISHES);
    materials[LAMP].emission = 1.0;
    let meshes = shell().into_iter().chain([blocks(), lamp()]).map(MeshBuilder::build).collect();
    // The middle and half the extent of the lamp in x and z.
    let [(x, half_x), (z, half_z)] =
        [LAMP_RANGES.0, LAMP_RANGES.1].map(|[low, high]| (0.5 * (low + high), 0.5 * (high - low)));
    let lamp = AreaShape::Rectangle {
        centre: Vec3::new(x, HEIGHT - 2.0 * LAMP_GAP, z),
        half_u: half_x * Vec3::X,
        half_v: half_z * Vec3::Z,
    };
    let (min, max) = ([0.0, 0.0, 0.0], [WIDTH, HEIGHT, DEPTH]);
    Scene {
        name: "cornell-box".to_owned(),
        meshes,
        materials,
        textures,
        lights: vec![Light::Point { position: Vec3::new(x, HEIGHT - 0.3, z), energy: 6.0 }],
        area_lights: vec![AreaLight { shape: lamp, radiance: Vec3::new(26.0, 21.0, 14.0) }],
        lens: Lens { opening: FieldOfView::Angle(39.3_f32.to_radians()), ..Lens::default() },
        views: vec![view("box", [2.78, 2.73, -8.0], [2.78, 2.73, 2.8])],
        probes: vec![probe("front", [2.78, 4.4, 1.5], min, max), probe("back", [4.5, 3.0, 4.5], min, max)],
        ..Scene::default()
    }
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
fn mesh(name: &str, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Builds floor, ceiling and three walls; the side towards the camera is open.
fn shell() -> [MeshBuilder; 5] {
    // Makes a rectangle of this width and height; `axes` are its lower left corner, and its right and up directions.
    let face = |name: &str, material: usize, axes: [Vec3; 3], size: [f32; 2]| {
        let mut side = mesh(name, material);
        side.panel(axes, Rect::new([0.0, size[0]], [0.0, size[1]]), &[]);
        side
    };
    let far = DEPTH * Vec3::Z;
    [
        face("floor", WHITE, [Vec3::ZERO, Vec3::X, Vec3::Z], [WIDTH, DEPTH]),
        face("ceiling", WHITE, [HEIGHT * Vec3::Y + far, Vec3::X, Vec3::NEG_Z], [WIDTH, DEPTH]),
        face("back-wall", WHITE, [far, Vec3::X, Vec3::Y], [WIDTH, HEIGHT]),
        face("red-wall", RED, [Vec3::ZERO, Vec3::Z, Vec3::Y], [DEPTH, HEIGHT]),
        face("green-wall", GREEN, [WIDTH * Vec3::X + far, Vec3::NEG_Z, Vec3::Y], [DEPTH, HEIGHT]),
    ]
}

/// Builds the sides and tops of both blocks.
fn blocks() -> MeshBuilder {
    let mut blocks = mesh("blocks", WHITE);
    for (corners, height) in BLOCKS {
        let point = |[x, z]: [f32; 2], y: f32| Vec3::new(x, y, z);
        let middle = corners.iter().map(|corner| Vec2::from(*corner)).sum::<Vec2>() / 4.0;
        for (number, corner) in corners.into_iter().enumerate() {
            let next = corners[(number + 1) % 4];
            let outwards = 0.5 * (Vec2::from(corner) + Vec2::from(next)) - middle;
            let side = [point(corner, 0.0), point(next, 0.0), point(next, height), point(corner, height)];
            blocks.polygon(&side, Vec3::new(outwards.x, 0.0, outwards.y));
        }
        blocks.polygon(&corners.map(|corner| point(corner, height)), Vec3::Y);
    }
    blocks
}

/// Builds the lamp, a rectangle whose material emits light.
fn lamp() -> MeshBuilder {
    let ([left, right], [near, far]) = LAMP_RANGES;
    let corners = [[left, near], [right, near], [right, far], [left, far]];
    let mut lamp = mesh("lamp", LAMP);
    lamp.polygon(&corners.map(|[x, z]| Vec3::new(x, HEIGHT - LAMP_GAP, z)), Vec3::NEG_Y);
    lamp
}
