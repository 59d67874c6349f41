//! `corridor`: one long box with a polished floor, the kind of room that Schmidt recommends for parallax-corrected cube
//! maps (2013, section 5.2.2). Doors, lamps and pictures break its symmetry, so that a shifted or mirrored cube map is
//! noticed.

use super::builder::{MeshBuilder, Rect, ordered};
use super::fittings::{Face, centred_rect, standing_rect};
use super::{Finish, materials, probe, thesis_lens, view};
use crate::{AreaLight, AreaShape, Light, Mesh, Scene};
use glam::Vec3;
use ssct_geometry::impostor_image;
use ssct_geometry::pattern::{Painting, Pattern, Picture, Sign, SignOutline, Text, Wood};

// Indices of materials in `FINISHES`; the dado is the panelling at the foot of the walls.
const FLOOR: usize = 0;
const WALL: usize = 1;
const DADO: usize = 2;
const CEILING: usize = 3;
const DOOR: usize = 4;
const TRIM: usize = 5;
const LAMP: usize = 6;
const METAL: usize = 7;
const RED: usize = 8;
const WINDOW: usize = 9;
const EXIT: usize = 10;
/// The index of the first of three paintings.
const PAINTING: usize = 11;
/// The index of the first of four number plates.
const NUMBER: usize = 14;

const FINISHES: [Finish; 18] = [
    Finish::new("floor", Pattern::Terrazzo, 0.5).reflecting(0.5, 0.02).smoothed(0.3),
    Finish::new("wall", Pattern::Stucco, 0.0).tinted(0.95, 1.0, 0.92),
    Finish::new("dado", Pattern::Wood(Wood::Middle), 0.2).reflecting(0.2, 0.08).smoothed(0.3),
    Finish::new("ceiling", Pattern::Stucco, 0.0),
    Finish::new("door", Pattern::Wood(Wood::Dark), 0.15).reflecting(0.15, 0.08).smoothed(0.3),
    Finish::paint("trim", 0.62, 0.60, 0.55),
    Finish::paint("lamp", 1.0, 0.97, 0.90),
    Finish::paint("metal", 0.30, 0.30, 0.31).reflecting(0.5, 0.05),
    Finish::paint("red", 0.62, 0.03, 0.03).reflecting(0.15, 0.05),
    Finish::window("window"),
    Finish::picture("exit", Picture::Sign(&EXIT_SIGN)),
    Finish::picture("landscape", Picture::Painting(Painting::Landscape)),
    Finish::picture("ship", Picture::Painting(Painting::Ship)),
    Finish::picture("portrait", Picture::Painting(Painting::Portrait)),
    Finish::picture("number-1", Picture::Sign(&PLATES[0])),
    Finish::picture("number-2", Picture::Sign(&PLATES[1])),
    Finish::picture("number-3", Picture::Sign(&PLATES[2])),
    Finish::picture("number-4", Picture::Sign(&PLATES[3])),
];

const EXIT_SIGN: Sign = Sign {
    text: Text { letters: "EXIT >", stacked: false },
    cut: SignOutline::Plate,
    ink: Vec3::new(0.95, 1.0, 0.95),
    ground: Vec3::new(0.01, 0.42, 0.12),
    bulbs: false,
    size: [384, 128],
};

const PLATES: [Sign; 4] = [plate("1"), plate("2"), plate("3"), plate("4")];

/// Makes the sign with the number of a door.
const fn plate(letters: &'static str) -> Sign {
    Sign {
        text: Text { letters, stacked: false },
        cut: SignOutline::Plate,
        ink: Vec3::new(0.9, 0.85, 0.7),
        ground: Vec3::new(0.03, 0.05, 0.12),
        bulbs: false,
        size: [96, 96],
    }
}

/// Half the width (x), the height (y) and the length (z, from 0) of the corridor, in metres.
const HALF_WIDTH: f32 = 1.3;
const HEIGHT: f32 = 2.7;
const LENGTH: f32 = 26.0;
/// Height of the dado, in metres.
const DADO_TOP: f32 = 0.95;
/// The z of the middle of each lamp, in metres.
const LAMPS_Z: [f32; 5] = [3.0, 8.0, 13.0, 18.0, 23.0];
/// The z of the middle of each door on the left (−x) and on the right, in metres.
const DOORS: [&[f32]; 2] = [&[4.0, 11.0, 18.0], &[8.0, 20.0]];
/// Width and height of a door, in metres.
const DOOR_M: [f32; 2] = [1.0, 2.1];
/// Overlap of neighbouring geometry, in metres, so that no light shows through the joints.
const OVERLAP: f32 = 0.02;
/// The ranges of the window at the far end in x and in height, in metres.
const END_WINDOW: ([f32; 2], [f32; 2]) = ([-0.75, 0.75], [0.85, 2.05]);

/// Builds the scene, with its meshes, materials, lights, views, probes and impostors.
pub fn scene() -> Scene {
    let (materials, textures) = materials(&FINISHES);
    let parts = [shell(), doors(), lamps(), furnishings()];
    let meshes: Vec<Mesh> = parts.into_iter().flatten().map(MeshBuilder::build).collect();
    let (min, max) = ([-HALF_WIDTH, 0.0, 0.0], [HALF_WIDTH, HEIGHT, LENGTH]);
    let mut scene = Scene {
        name: "corridor".to_owned(),
        meshes,
        materials,
        textures,
        lights: LAMPS_Z.map(|z| Light::Point { position: Vec3::new(0.0, HEIGHT - 0.6, z), energy: 6.0 }).to_vec(),
        lens: thesis_lens(),
        views: vec![
            view("corridor", [0.25, 1.5, 1.0], [-0.1, 1.05, 12.0]),
            view("floor", [0.6, 0.55, 3.2], [-0.1, 0.15, 12.0]),
            view("wall", [-0.85, 1.45, 5.0], [1.1, 1.05, 11.5]),
            view("back", [-0.5, 1.5, 22.5], [0.1, 0.9, 10.0]),
        ],
        probes: [("near", 4.5), ("middle", 13.0), ("far", 21.5)]
            .map(|(name, z)| probe(name, [0.0, 1.4, z], min, max))
            .into(),
        area_lights: LAMPS_Z.map(area_light).to_vec(),
        ..Scene::default()
    };
    let [left, right] = walls();
    impostor_image::add(&mut scene, &["exit"], &exit_face().portrait("exit sign", exit_rect(), 0.0, 384));
    impostor_image::add(
        &mut scene,
        &["landscape"],
        &right.portrait("landscape", rect_on_wall(&right, 13.5, 1.7, 1.5, 1.0), 0.05, 384),
    );
    impostor_image::add(
        &mut scene,
        &["portrait"],
        &left.portrait("portrait", rect_on_wall(&left, 14.5, 1.72, 0.8, 1.0), 0.05, 256),
    );
    scene
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
fn mesh(name: &str, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Returns the left (−x) and the right wall.
fn walls() -> [Face; 2] {
    [Face::new([-HALF_WIDTH, 0.0, 0.0], Vec3::Z), Face::new([HALF_WIDTH, 0.0, 0.0], Vec3::NEG_Z)]
}

/// Returns a rectangle on one of the walls, given by the z and the height of its centre and by its size, in metres.
fn rect_on_wall(wall: &Face, z: f32, y: f32, width: f32, height: f32) -> Rect {
    centred_rect(z * wall.right.z, y, width, height)
}

/// Builds floor, ceiling, side walls with wooden panelling at their feet, and the end walls.
fn shell() -> Vec<MeshBuilder> {
    let mut floor = mesh("floor", FLOOR);
    let (x, z) = ([-HALF_WIDTH - OVERLAP, HALF_WIDTH + OVERLAP], [-OVERLAP, LENGTH + OVERLAP]);
    floor.panel([Vec3::ZERO, Vec3::X, Vec3::Z], Rect::new(x, z), &[]);
    let mut ceiling = mesh("ceiling", CEILING);
    ceiling.panel([HEIGHT * Vec3::Y, Vec3::X, Vec3::NEG_Z], Rect::new(x, [-z[1], -z[0]]), &[]);
    let mut plaster = mesh("walls", WALL);
    let mut dado = mesh("dado", DADO);
    let mut trim = mesh("trim", TRIM);
    for (wall, doors) in walls().into_iter().zip(DOORS) {
        let extent = Rect::new(ordered(0.0, LENGTH * wall.right.z), [0.0, HEIGHT]);
        let holes: Vec<Rect> = doors.iter().map(|z| standing_rect(z * wall.right.z, DOOR_M[0], DOOR_M[1])).collect();
        wall.wall(&mut plaster, extent, &holes);
        // Boards run between the door frames. Their ends are listed from left to right.
        let mut edges: Vec<f32> = holes.iter().flat_map(|hole| [hole.min.x - 0.09, hole.max.x + 0.09]).collect();
        edges.sort_by(f32::total_cmp);
        edges.insert(0, extent.min.x);
        edges.push(extent.max.x);
        for span in edges.chunks_exact(2) {
            let board = |heights: [f32; 2]| Rect::new([span[0], span[1]], heights);
            wall.block(&mut dado, board([0.1, DADO_TOP]), [0.0, 0.02]);
            wall.block(&mut trim, board([DADO_TOP, DADO_TOP + 0.05]), [0.0, 0.04]);
            wall.block(&mut trim, board([0.0, 0.1]), [0.0, 0.03]);
        }
    }
    let far = Face::new([0.0, 0.0, LENGTH], Vec3::X);
    let window = Rect::new(END_WINDOW.0, END_WINDOW.1);
    let across = Rect::new([-HALF_WIDTH, HALF_WIDTH], [0.0, HEIGHT]);
    far.wall(&mut plaster, across, &[window]);
    far.reveals(&mut trim, window, 0.2);
    far.border(&mut trim, window, 0.08, [0.0, 0.03]);
    far.block(&mut trim, Rect::new([-0.025, 0.025], END_WINDOW.1), [-0.17, -0.13]);
    far.block(&mut trim, Rect::new(END_WINDOW.0, [1.55, 1.6]), [-0.17, -0.13]);
    Face::new([0.0, 0.0, 0.0], Vec3::NEG_X).wall(&mut plaster, across, &[]);
    let mut pane = mesh("window", WINDOW);
    Face::new([0.0, 0.0, LENGTH + 0.18], Vec3::X).wall(&mut pane, window, &[]);
    vec![floor, ceiling, plaster, dado, trim, pane]
}

/// Builds door leaves in recesses, with frames, handles and number plates.
fn doors() -> Vec<MeshBuilder> {
    let mut leaves = mesh("doors", DOOR).turned();
    let mut frames = mesh("door-frames", TRIM);
    let mut handles = mesh("handles", METAL);
    let mut parts = Vec::new();
    let mut door_number = 0;
    for (wall, doors) in walls().into_iter().zip(DOORS) {
        for z in doors {
            let middle = z * wall.right.z;
            let hole = standing_rect(middle, DOOR_M[0], DOOR_M[1]);
            wall.reveals(&mut frames, hole, 0.12);
            for side in [-1.0, 1.0] {
                let edge = middle + side * (0.5 * DOOR_M[0] + 0.045);
                wall.block(&mut frames, Rect::new([edge - 0.045, edge + 0.045], [0.0, DOOR_M[1] + 0.09]), [0.0, 0.04]);
            }
            let top = Rect::new([hole.min.x, hole.max.x], [DOOR_M[1], DOOR_M[1] + 0.09]);
            wall.block(&mut frames, top, [0.0, 0.04]);
            let leaf_rect = Rect::new([hole.min.x, hole.max.x], [0.0, DOOR_M[1]]);
            wall.block(&mut leaves, leaf_rect, [-0.14, -0.10]);
            for (y, height) in [(0.55, 0.7), (1.5, 0.9)] {
                wall.border(&mut leaves, centred_rect(middle, y, 0.56, height), 0.04, [-0.1, -0.085]);
            }
            handles.sphere(wall.point_at(middle + 0.4, 1.03, -0.05), 0.035, [16, 8]);
            // The fifth door has no number plate.
            if door_number < 4 {
                let mut plate = mesh("number", NUMBER + door_number);
                wall.picture(&mut plate, centred_rect(middle, 1.72, 0.16, 0.16), -0.08);
                parts.push(plate);
            }
            door_number += 1;
        }
    }
    parts.extend([leaves, frames, handles]);
    parts
}

/// Builds the lamps: panels in cases below the ceiling, which the scene's point lights below them light.
fn lamps() -> Vec<MeshBuilder> {
    let mut panels = mesh("lamps", LAMP);
    let mut cases = mesh("lamp-cases", METAL);
    for z in LAMPS_Z {
        let (half, y) = (Vec3::new(0.16, 0.0, 0.7), HEIGHT - 0.08);
        let middle = Vec3::new(0.0, y, z);
        cases.cuboid(middle - half - Vec3::new(0.03, -0.005, 0.03), middle + half + Vec3::new(0.03, 0.08, 0.03));
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        panels.polygon(&corners.map(|(x, z)| middle + half * Vec3::new(x, 0.0, z)), Vec3::NEG_Y);
    }
    vec![panels, cases]
}

/// Returns the panel of the lamp at this z as an area light.
fn area_light(z: f32) -> AreaLight {
    let (half_u, half_v) = (0.16 * Vec3::X, 0.7 * Vec3::Z);
    let centre = Vec3::new(0.0, HEIGHT - 0.08, z);
    AreaLight { shape: AreaShape::Rectangle { centre, half_u, half_v }, radiance: Vec3::new(1.0, 0.97, 0.90) }
}

/// Returns the plane of the exit sign, which hangs across the corridor and faces −z.
fn exit_face() -> Face {
    Face::new([0.0, 0.0, 15.5], Vec3::X)
}

/// Returns the rectangle of the exit sign in its plane.
fn exit_rect() -> Rect {
    centred_rect(0.72, 2.42, 0.72, 0.24)
}

/// Builds paintings, the exit sign that hangs across the corridor, a bench and a fire extinguisher.
fn furnishings() -> Vec<MeshBuilder> {
    let [left, right] = walls();
    let mut frames = mesh("picture-frames", DOOR);
    let mut parts = Vec::new();
    // Wall, name of the mesh, material and rectangle of each painting.
    let paintings = [
        (right, "landscape", PAINTING, rect_on_wall(&right, 13.5, 1.7, 1.5, 1.0)),
        (left, "ship", PAINTING + 1, rect_on_wall(&left, 7.5, 1.7, 1.5, 1.0)),
        (left, "portrait", PAINTING + 2, rect_on_wall(&left, 14.5, 1.72, 0.8, 1.0)),
    ];
    for (wall, name, material, rect) in paintings {
        let mut painting = mesh(name, material);
        wall.picture(&mut painting, rect, 0.02);
        wall.border(&mut frames, rect, 0.06, [0.0, 0.05]);
        parts.push(painting);
    }
    let mut exit = mesh("exit", EXIT);
    exit_face().picture(&mut exit, exit_rect(), 0.0);
    let back_face = Face::new([0.0, 0.0, exit_face().origin.z + 0.02], Vec3::NEG_X);
    let mut back = mesh("exit-back", EXIT);
    back_face.picture(&mut back, centred_rect(-0.72, 2.42, 0.72, 0.24), 0.0);
    let mut rods = mesh("exit-rods", METAL);
    for offset in [-0.28, 0.28] {
        let top = exit_face().point_at(0.72 + offset, HEIGHT, -0.005);
        rods.cuboid(top - Vec3::new(0.01, HEIGHT - 2.5, 0.0), top + Vec3::new(0.01, 0.0, 0.01));
    }
    let mut bench = mesh("bench", DOOR);
    // The two legs of the bench, then its seat.
    bench.cuboid(Vec3::new(0.92, 0.0, 12.8), Vec3::new(1.22, 0.42, 12.9));
    bench.cuboid(Vec3::new(0.92, 0.0, 14.1), Vec3::new(1.22, 0.42, 14.2));
    bench.cuboid(Vec3::new(0.86, 0.42, 12.6), Vec3::new(1.27, 0.47, 14.4));
    let mut extinguisher = mesh("extinguisher", RED);
    extinguisher.cylinder(Vec3::new(-1.16, 0.35, 9.2), 0.085, 0.5, 24);
    extinguisher.sphere(Vec3::new(-1.16, 0.85, 9.2), 0.085, [24, 12]);
    parts.extend([frames, exit, back, rods, bench, extinguisher]);
    parts
}
