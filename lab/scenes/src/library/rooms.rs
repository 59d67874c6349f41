//! `rooms`: two low rooms joined by an arch, after the scene of the thesis's figures 5.1–5.5 and 5.9. The rooms have a
//! tiled floor, stone walls, a wooden ceiling with a skylight, two windows, and wooden objects to be reflected. Every
//! material reflects, except for the windows, which show the sky.

use super::builder::{MeshBuilder, Rect};
use super::masonry::{self, Arch, Wall};
use super::{Finish, materials, probe, thesis_lens, view};
use crate::{AreaLight, AreaShape, Light, Mesh, Scene};
use glam::{Vec2, Vec3};
use ssct_geometry::pattern::{Pattern, Wood};

// Indices of materials in `FINISHES`.
const STONES: usize = 0;
const TILES: usize = 1;
const CEILING: usize = 2;
const BRICKS: usize = 3;
const WOOD: usize = 4;
const DARK_WOOD: usize = 5;
const WINDOW: usize = 6;

const FINISHES: [Finish; 7] = [
    Finish::new("stones", Pattern::Stones, 1.0),
    Finish::new("tiles", Pattern::Tiles, 1.0),
    Finish::new("ceiling", Pattern::Wood(Wood::Pale), 1.0),
    Finish::new("bricks", Pattern::Bricks, 1.0),
    Finish::new("wood", Pattern::Wood(Wood::Middle), 1.0),
    Finish::new("dark-wood", Pattern::Wood(Wood::Dark), 1.0),
    Finish::window("window"),
];

/// Heights of the floor and of the ceiling, in metres.
const FLOOR_Y: f32 = -1.0;
const CEILING_Y: f32 = 1.0;
/// Overlap of floor and ceiling with the walls, in metres, so that no light shows through the corners.
const OVERLAP: f32 = 0.02;
/// The x of the left and right faces of the wall between the rooms, in metres.
const PARTITION_X: [f32; 2] = [-2.23, -1.9];
/// The z of the window panes, outside the wall at z = 5, in metres.
const GLASS_Z: f32 = 5.158;

/// The x and y ranges of the two windows in the wall at z = 5, in metres.
const WINDOWS: [([f32; 2], [f32; 2]); 2] = [([0.88, 3.22], [0.16, 0.85]), ([-5.15, -3.08], [-0.25, 0.86])];

/// The x and z ranges of the lower end of the skylight's well, at the ceiling, in metres.
const WELL: ([f32; 2], [f32; 2]) = ([0.6, 3.51], [-3.66, -0.85]);
/// The x and z ranges of the skylight's pane above the well, in metres.
const SKYLIGHT: ([f32; 2], [f32; 2]) = ([1.29, 2.82], [-2.99, -1.52]);

/// Builds the scene, with its meshes, materials, lights, views and probes.
pub fn scene() -> Scene {
    let (materials, textures) = materials(&FINISHES);
    let meshes = [shell(), windows(), blocks(), cylinders(), table()].into_iter().flatten().collect();
    Scene {
        name: "rooms".to_owned(),
        meshes,
        materials,
        textures,
        lights: vec![
            Light::Point { position: Vec3::new(2.0, 1.47, -1.9), energy: 15.0 },
            Light::Point { position: Vec3::new(-4.1, 0.38, 6.0), energy: 10.0 },
            Light::Point { position: Vec3::new(2.24, 0.6, 6.0), energy: 10.0 },
        ],
        lens: thesis_lens(),
        views: vec![
            view("cylinder", [2.1, -0.05, 0.9], [3.05, -0.95, 2.3]),
            view("window-floor", [2.0, 0.3, 2.6], [2.05, -0.75, 5.0]),
            view("corridor", [-0.4, 0.1, -4.7], [1.2, -0.15, 3.0]),
            view("two-cylinders", [3.0, 0.35, 0.6], [3.7, -1.0, 2.6]),
            view("window", [2.0, 0.0, 0.0], [2.05, 0.1, 5.0]),
            view("ceiling", [4.0, -0.6, -3.0], [-3.0, 0.9, 4.0]),
        ],
        probes: vec![
            probe("right-room", [2.0, 0.0, 0.3], [PARTITION_X[1], FLOOR_Y, -5.0], [6.0, CEILING_Y, 5.0]),
            probe("left-room", [-4.1, 0.0, 0.0], [-6.0, FLOOR_Y, -5.0], [PARTITION_X[0], CEILING_Y, 5.0]),
        ],
        area_lights: area_lights(),
        ..Scene::default()
    }
}

/// Returns the skylight and the two windows as area lights, as bright as the point lights that represent these
/// openings.
fn area_lights() -> Vec<AreaLight> {
    // Makes a pane from its least and greatest corner and the vectors from its centre to the middles of two edges.
    let pane = |min: Vec3, max: Vec3, half_u: Vec3, half_v: Vec3| AreaLight {
        shape: AreaShape::Rectangle { centre: 0.5 * (min + max), half_u, half_v },
        radiance: Vec3::new(0.75, 0.85, 1.0),
    };
    let (x, z) = SKYLIGHT;
    let mut lights = vec![pane(
        Vec3::new(x[0], 1.95, z[0]),
        Vec3::new(x[1], 1.95, z[1]),
        0.5 * (x[1] - x[0]) * Vec3::X,
        0.5 * (z[1] - z[0]) * Vec3::Z,
    )];
    lights.extend(WINDOWS.map(|(x, y)| {
        pane(
            Vec3::new(x[0], y[0], GLASS_Z),
            Vec3::new(x[1], y[1], GLASS_Z),
            0.5 * (x[1] - x[0]) * Vec3::X,
            0.5 * (y[1] - y[0]) * Vec3::NEG_Y,
        )
    }));
    lights
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
fn mesh(name: &str, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Builds walls, floor, ceiling and the partition with its arch.
fn shell() -> Vec<Mesh> {
    let mut walls = mesh("walls", STONES);
    let heights = [FLOOR_Y, CEILING_Y];
    let holes = WINDOWS.map(|(x, y)| Rect::new(x, y));
    let z_wall = Rect::new([-6.0, 6.0], heights);
    walls.panel([Vec3::new(0.0, 0.0, 5.0), Vec3::X, Vec3::Y], z_wall, &holes);
    walls.panel([Vec3::new(0.0, 0.0, -5.0), Vec3::NEG_X, Vec3::Y], z_wall, &[]);
    let x_wall = Rect::new([-5.0, 5.0], heights);
    walls.panel([Vec3::new(6.0, 0.0, 0.0), Vec3::NEG_Z, Vec3::Y], x_wall, &[]);
    walls.panel([Vec3::new(-6.0, 0.0, 0.0), Vec3::Z, Vec3::Y], x_wall, &[]);

    let partition = Wall {
        origin: Vec3::new(0.5 * (PARTITION_X[0] + PARTITION_X[1]), 0.0, 0.0),
        along: Vec3::Z,
        thickness_m: PARTITION_X[1] - PARTITION_X[0],
    };
    let arch = Arch { centre_m: -2.255, half_width_m: 0.955, spring_m: 0.36, rise_m: 0.53 };
    masonry::arched_wall(&mut walls, &partition, [-5.0, 5.0], heights, &[arch]);
    let mut frame = mesh("arch", WOOD);
    masonry::soffit(&mut frame, &partition, &arch, FLOOR_Y);

    let (x, z) = ([-6.0 - OVERLAP, 6.0 + OVERLAP], [-5.0 - OVERLAP, 5.0 + OVERLAP]);
    let mut floor = mesh("floor", TILES);
    floor.panel([FLOOR_Y * Vec3::Y, Vec3::X, Vec3::Z], Rect::new(x, z), &[]);
    let mut ceiling = mesh("ceiling", CEILING);
    let well = Rect::new(WELL.0, [-WELL.1[1], -WELL.1[0]]);
    ceiling.panel([CEILING_Y * Vec3::Y, Vec3::X, Vec3::NEG_Z], Rect::new(x, z), &[well]);
    [walls, frame, floor, ceiling].map(MeshBuilder::build).into()
}

/// Builds the skylight's well, the inner sides of the window openings, and the panes.
fn windows() -> Vec<Mesh> {
    let mut well = mesh("skylight-well", CEILING);
    let mut reveals = mesh("window-frames", WOOD);
    let mut panes = Vec::new();
    // The corners, at the height y, of a rectangle with these x and z ranges.
    let corners_at_height = |(x, z): ([f32; 2], [f32; 2]), y: f32| {
        [[x[0], z[0]], [x[1], z[0]], [x[1], z[1]], [x[0], z[1]]].map(|[x, z]| Vec3::new(x, y, z))
    };
    let middle = Vec3::new(2.055, 1.0, -2.255);
    sides_between(&mut reveals, &corners_at_height(WELL, CEILING_Y), &corners_at_height(WELL, 1.14), middle);
    sides_between(&mut well, &corners_at_height(WELL, 1.14), &corners_at_height(SKYLIGHT, 1.83), middle);
    sides_between(&mut reveals, &corners_at_height(SKYLIGHT, 1.83), &corners_at_height(SKYLIGHT, 1.95), middle);
    let mut pane = mesh("skylight", WINDOW);
    pane.polygon(&corners_at_height(SKYLIGHT, 1.95), Vec3::NEG_Y);
    panes.push(pane);
    for (x, y) in WINDOWS {
        // The corners of the window at the depth z.
        let upright =
            |z: f32| [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]].map(|[x, y]| Vec3::new(x, y, z));
        let middle = Vec3::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), 5.08);
        sides_between(&mut reveals, &upright(5.0), &upright(GLASS_Z), middle);
        let mut pane = mesh("pane", WINDOW);
        pane.polygon(&upright(GLASS_Z), Vec3::NEG_Z);
        panes.push(pane);
    }
    panes.extend([well, reveals]);
    panes.into_iter().map(MeshBuilder::build).collect()
}

/// Adds the four quadrilaterals that connect the edges of two rectangles; they face the point `middle`.
fn sides_between(mesh: &mut MeshBuilder, first: &[Vec3; 4], second: &[Vec3; 4], middle: Vec3) {
    for k in 0..4 {
        let next = (k + 1) % 4;
        mesh.polygon(&[first[k], first[next], second[next], second[k]], middle - 0.5 * (first[k] + second[next]));
    }
}

/// Builds sixteen brick blocks of several heights with wooden tops, and a ball that lies on a small block above them.
fn blocks() -> Vec<Mesh> {
    /// Width of a block, in metres.
    const WIDTH: f32 = 0.6575;
    /// The least x and z of all blocks, in metres.
    const CORNER: Vec2 = Vec2::new(1.81, -3.59);
    /// The y of the blocks' tops, in metres, in rows from −z to +z, each from −x to +x. The last block of the first row
    /// stays below the eye of the view `ceiling`.
    const TOPS: [[f32; 4]; 4] = [
        [-0.30, -0.07, -0.80, -0.82],
        [-0.80, -0.80, -0.80, -0.80],
        [-0.56, -0.80, -0.90, -0.80],
        [-0.80, -0.80, -0.80, -0.64],
    ];
    /// Thickness of the wooden tops, in metres.
    const BOARD: f32 = 0.025;
    let mut bricks = mesh("blocks", BRICKS);
    let mut tops = mesh("block-tops", DARK_WOOD);
    for (row, tops_of_row) in TOPS.iter().enumerate() {
        for (column, &top) in tops_of_row.iter().enumerate() {
            let corner = CORNER + WIDTH * Vec2::new(column as f32, row as f32);
            let min = Vec3::new(corner.x, FLOOR_Y - OVERLAP, corner.y);
            let max = Vec3::new(corner.x + WIDTH, top, corner.y + WIDTH);
            bricks.cuboid_without(min, max - BOARD * Vec3::Y, &[Vec3::Y, Vec3::NEG_Y]);
            let min = Vec3::new(min.x, top - BOARD, min.z);
            tops.cuboid_without(min, max, &[Vec3::NEG_Y]);
        }
    }
    let ball = Vec3::new(2.14, -0.19, -1.92);
    bricks.cuboid_without(ball - Vec3::new(0.11, 0.38, 0.11), ball + Vec3::new(0.11, -0.22, 0.11), &[Vec3::NEG_Y]);
    let mut wood = mesh("ball", WOOD);
    wood.sphere(ball, 0.24, [48, 24]);
    [bricks, tops, wood].map(MeshBuilder::build).into()
}

/// Builds the two wooden cylinders of the thesis's figures 5.1 and 5.4.
fn cylinders() -> Vec<Mesh> {
    let cylinder = |name: &str, x: f32, z: f32, height: f32| {
        let mut wood = mesh(name, WOOD).turned();
        let foot = Vec3::new(x, FLOOR_Y - OVERLAP, z);
        wood.cylinder(foot, 0.25, height + OVERLAP, 64);
        wood.build()
    };
    vec![cylinder("tall-cylinder", 4.31, 2.93, 1.0), cylinder("low-cylinder", 2.98, 2.18, 0.62)]
}

/// Builds a round table with a bowl, a ball and a box on it.
fn table() -> Vec<Mesh> {
    let middle = Vec3::new(-0.29, FLOOR_Y, 3.17);
    let mut table = mesh("table", WOOD);
    table.cylinder(middle + 0.50 * Vec3::Y, 0.60, 0.05, 64);
    let mut leg = mesh("table-leg", WOOD).turned();
    leg.revolve(middle - OVERLAP * Vec3::Y, [32, 24], |t| {
        let foot = 0.24 * (1.0 - t).max(0.0).powi(6);
        let swell = 0.03 * (3.0 * std::f32::consts::PI * t).sin();
        Vec2::new(0.07 + foot + swell, 0.54 * t)
    });
    let top = middle + 0.55 * Vec3::Y;
    let bowl = bowl(top + Vec3::new(0.22, 0.0, -0.15));
    let mut box_on_table = mesh("small-things", BRICKS);
    box_on_table.cuboid_without(top + Vec3::new(-0.42, 0.0, -0.12), top + Vec3::new(-0.18, 0.2, 0.08), &[Vec3::NEG_Y]);
    let mut ball = mesh("table-ball", DARK_WOOD);
    ball.sphere(top + Vec3::new(0.02, 0.12, 0.22), 0.12, [32, 16]);
    [table, leg, bowl, box_on_table, ball].map(MeshBuilder::build).into()
}

/// Builds a wooden bowl on `foot`: its outside, rim, inside and bottom.
fn bowl(foot: Vec3) -> MeshBuilder {
    // Returns the radius and the height of a profile, for `share` from 0 at the bottom to 1 at the rim. `radius` scales
    // the profile's radii, and `floor` is the height from which it rises.
    let side = |radius: f32, floor: f32, share: f32| {
        let (sin, cos) = (0.35 + 1.1 * share).sin_cos();
        Vec2::new(radius * sin, floor + 0.14 * (0.94 - cos))
    };
    let (outer, inner) = (|t: f32| side(0.19, 0.0, t), |t: f32| side(0.175, 0.012, t));
    let (lip_out, lip_in) = (outer(1.0), inner(1.0));
    let mut wood = mesh("bowl", DARK_WOOD);
    wood.revolve(foot, [48, 10], outer);
    wood.revolve(foot, [48, 1], |t| lip_out.lerp(lip_in, t));
    wood.revolve(foot, [48, 10], |t| inner(1.0 - t));
    wood.disc(foot + inner(0.0).y * Vec3::Y, inner(0.0).x, 48, Vec3::Y);
    wood
}
