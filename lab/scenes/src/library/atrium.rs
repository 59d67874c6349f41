//! `atrium`: a colonnaded court of two storeys in the proportions of Crytek Sponza, for the thesis's figures
//! 5.6–5.8: arcades around an open court, vaulted galleries behind them, and furnishing ([`furnishing`]). Only
//! the floor reflects; in the view `hall` the walls reflect as well.

mod furnishing;

use super::builder::{MeshBuilder, Rect, ordered};
use super::masonry::{self, Arch, ColumnSize, Wall};
use super::{Finish, materials, probe, thesis_lens, view};
use crate::{Light, MaterialChange, Mesh, Scene, sky};
use glam::{Vec2, Vec3};
use ssct_geometry::pattern::{Dye, Pattern, Wood};

// Indices of materials in `FINISHES`.
const FLOOR: usize = 0;
const BRICKS: usize = 1;
const ARCH: usize = 2;
const COLUMN: usize = 3;
const CEILING: usize = 4;
const ROOF: usize = 5;
pub const VASE: usize = 6;
pub const RELIEF: usize = 7;
pub const LEAF: usize = 8;
pub const POLE: usize = 9;
/// Index of the first of three cloths.
pub const CLOTH: usize = 10;

const FINISHES: [Finish; 13] = [
    Finish::new("floor", Pattern::Slabs, 1.0),
    Finish::new("bricks", Pattern::Bricks, 0.0),
    Finish::new("arch", Pattern::Limestone, 0.0),
    Finish::new("column", Pattern::Limestone, 0.0),
    Finish::new("ceiling", Pattern::Plaster, 0.0),
    Finish::new("roof", Pattern::Bricks, 0.0),
    Finish::new("vase", Pattern::Limestone, 0.0),
    Finish::new("relief", Pattern::Limestone, 0.0),
    Finish::new("leaf", Pattern::Foliage, 0.0),
    Finish::new("pole", Pattern::Wood(Wood::Dark), 0.0),
    Finish::new("cloth-red", Pattern::Cloth(Dye::Red), 0.0),
    Finish::new("cloth-green", Pattern::Cloth(Dye::Green), 0.0),
    Finish::new("cloth-blue", Pattern::Cloth(Dye::Blue), 0.0),
];

/// Walls and columns stand on these lines of constant x, in metres. The first and the last are the outer walls; the
/// second and the second to last bound the court.
pub const LINES_X: [f32; 8] = [-14.3, -9.95, -6.2, -2.46, 1.22, 4.9, 8.75, 13.0];
/// The lines of constant z on which walls and columns stand, in the same order.
pub const LINES_Z: [f32; 4] = [-5.75, -2.05, 2.8, 6.45];
/// The building's outer extent, in metres: least and greatest x, then least and greatest z.
const OUTSIDE: ([f32; 2], [f32; 2]) = ([-18.7, 17.5], [-10.4, 11.4]);

/// Height above the floor, in metres, at which the curves of the arches of each storey begin (their spring).
const SPRING_M: [f32; 2] = [2.3, 6.95];
/// Height of the upper floor above the floor, in metres.
const UPPER_FLOOR: f32 = 4.16;
/// Height of the top of the parapets above the floor, in metres.
pub const PARAPET: f32 = 5.08;
/// Height of the top of the walls above the floor, in metres.
const WALL_TOP: f32 = 13.0;
/// Overlap of neighbouring geometry, in metres, so that no light shows through the joints.
const OVERLAP: f32 = 0.02;
/// Thickness of the walls around the court, in metres.
const ARCADE_M: f32 = 0.6;
/// Half the width of a corner pier, in metres.
const HALF_PIER_M: f32 = 0.5;

/// Builds the scene, with its meshes, materials, light, views and probes.
pub fn scene() -> Scene {
    let (materials, textures) = materials(&FINISHES);
    let parts = [floors(), outer_walls(), galleries(), arcades(), columns(), upper_walls(), roof()];
    let mut meshes: Vec<Mesh> = parts.into_iter().flatten().map(MeshBuilder::build).collect();
    meshes.extend(furnishing::build().into_iter().map(MeshBuilder::build));
    let reflecting =
        |name: &str| (name.to_owned(), MaterialChange { reflectivity: Some(1.0), ..MaterialChange::default() });
    let mut hall = view("hall", [-11.5, 1.6, -4.2], [4.0, 1.4, -4.4]);
    hall.materials = vec![reflecting("floor"), reflecting("bricks")];
    Scene {
        name: "atrium".to_owned(),
        meshes,
        materials,
        textures,
        lights: vec![Light::Directional { direction: -sky::SUN, energy: 1.0 }],
        lens: thesis_lens(),
        views: vec![
            view("atrium", [10.5, 1.7, -0.3], [-4.0, 2.2, 0.2]),
            view("lion", [6.0, 1.0, 0.4], [13.0, 1.0, 0.4]),
            hall,
        ],
        probes: vec![
            probe("court-east", [4.0, 2.0, 0.4], [LINES_X[1], 0.0, LINES_Z[1]], [LINES_X[6], WALL_TOP, LINES_Z[2]]),
            probe("court-west", [-5.0, 2.0, 0.4], [LINES_X[1], 0.0, LINES_Z[1]], [LINES_X[6], WALL_TOP, LINES_Z[2]]),
            probe("south-gallery", [-2.0, 1.7, -3.9], [LINES_X[0], 0.0, LINES_Z[0]], [LINES_X[7], 3.8, LINES_Z[1]]),
        ],
        ..Scene::default()
    }
}

/// Makes an empty mesh; `material` is an index into [`FINISHES`].
pub fn mesh(name: impl Into<String>, material: usize) -> MeshBuilder {
    FINISHES[material].mesh(name, material)
}

/// Returns the least and the greatest corner (x, z) of each bay of the galleries, that is, of each bay outside the
/// court.
fn gallery_bays() -> impl Iterator<Item = [Vec2; 2]> {
    let columns = LINES_X.windows(2).enumerate();
    columns.flat_map(|(column, x)| {
        let (low_x, high_x) = (x[0], x[1]);
        LINES_Z.windows(2).enumerate().filter_map(move |(row, z)| {
            let is_court = (1..LINES_X.len() - 2).contains(&column) && row == 1;
            (!is_court).then_some([Vec2::new(low_x, z[0]), Vec2::new(high_x, z[1])])
        })
    })
}

/// Returns the four corners, at height `y`, of a horizontal rectangle from its least and its greatest corner (x, z).
fn corners_at_height(rectangle: [Vec2; 2], y: f32) -> [Vec3; 4] {
    let [min, max] = rectangle;
    [(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y)].map(|(x, z)| Vec3::new(x, y, z))
}

/// Builds the floor of court and galleries, and the galleries' upper floors.
fn floors() -> Vec<MeshBuilder> {
    let mut floor = mesh("floor", FLOOR);
    let overlap = Vec2::splat(OVERLAP);
    let least = Vec2::new(LINES_X[0], LINES_Z[0]) - overlap;
    let most = Vec2::new(LINES_X[7], LINES_Z[3]) + overlap;
    floor.polygon(&corners_at_height([least, most], 0.0), Vec3::Y);
    let mut upper = mesh("upper-floor", FLOOR);
    for bay in gallery_bays() {
        upper.polygon(&corners_at_height(bay, UPPER_FLOOR), Vec3::Y);
    }
    vec![floor, upper]
}

/// Builds the four walls behind the galleries, and the outside of the building.
fn outer_walls() -> Vec<MeshBuilder> {
    let heights = [-OVERLAP, 8.7];
    let (x, z) = ([LINES_X[0], LINES_X[7]], [LINES_Z[0], LINES_Z[3]]);
    // For each wall a point on it, its right direction, and its extent along this direction.
    let frames = [
        (Vec3::new(0.0, 0.0, z[0]), Vec3::NEG_X, [-x[1], -x[0]]),
        (Vec3::new(0.0, 0.0, z[1]), Vec3::X, x),
        (Vec3::new(x[0], 0.0, 0.0), Vec3::Z, z),
        (Vec3::new(x[1], 0.0, 0.0), Vec3::NEG_Z, [-z[1], -z[0]]),
    ];
    let mut walls: Vec<_> = frames
        .into_iter()
        .map(|(origin, right, extent)| {
            let mut wall = mesh("gallery-wall", BRICKS);
            wall.panel([origin, right, Vec3::Y], Rect::new(extent, heights), &[]);
            wall
        })
        .collect();
    let mut outside = mesh("outside", BRICKS);
    let (x, z) = OUTSIDE;
    outside.cuboid_without(Vec3::new(x[0], -1.26, z[0]), Vec3::new(x[1], 13.4, z[1]), &[Vec3::Y]);
    walls.push(outside);
    walls
}

/// Builds the vaults of both storeys, with ribs between the bays.
fn galleries() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    for (storey, spring_m) in SPRING_M.into_iter().enumerate() {
        for bay in gallery_bays() {
            let mut vault = mesh(format!("vault-{storey}"), CEILING);
            masonry::groin_vault(&mut vault, bay, spring_m + 0.1, 1.45, [20, 1]);
            parts.push(vault);
        }
        let mut ribs = mesh(format!("ribs-{storey}"), ARCH);
        // Ribs cross the galleries beside the long sides of the court along z, and those beside its short sides along
        // x.
        for (x, z) in LINES_X[1..7].iter().flat_map(|&x| [0, 2].map(|row| (x, [LINES_Z[row], LINES_Z[row + 1]]))) {
            rib(&mut ribs, Vec3::new(x, 0.0, 0.0), Vec3::Z, z, spring_m);
        }
        for (z, x) in
            LINES_Z[1..3].iter().flat_map(|&z| [0, 6].map(|column| (z, [LINES_X[column], LINES_X[column + 1]])))
        {
            rib(&mut ribs, Vec3::new(0.0, 0.0, z), Vec3::X, x, spring_m);
        }
        parts.push(ribs);
    }
    parts
}

/// Adds an arch that carries a vault, on corbels. It stands on the line through `origin` in the direction `along`, from
/// `from` to `to` metres along it, and begins at the height `spring_m`.
fn rib(mesh: &mut MeshBuilder, origin: Vec3, along: Vec3, [from, to]: [f32; 2], spring_m: f32) {
    let wall = Wall { origin, along, thickness_m: 0.4 };
    let half_width = 0.5 * (to - from) - 0.3;
    let arch = Arch { centre_m: 0.5 * (from + to), half_width_m: half_width, spring_m, rise_m: 1.25 };
    masonry::arched_wall(mesh, &wall, [from, to], [spring_m, spring_m + 1.5], &[arch]);
    masonry::soffit(mesh, &wall, &arch, spring_m);
    let across = along.cross(Vec3::Y).abs();
    for end in [from, to] {
        // The blocks of a corbel: half size, and least and greatest height above the beginning of the arch, in metres.
        for (half, low, high) in [(0.36, -0.16, 0.02), (0.28, -0.28, -0.16), (0.20, -0.38, -0.28)] {
            let centre = origin + end * along;
            let reach = half * along + (half - 0.1) * across;
            mesh.cuboid(centre - reach + (spring_m + low) * Vec3::Y, centre + reach + (spring_m + high) * Vec3::Y);
        }
    }
}

/// A side of the court: a point and the direction of its wall's line, and the distances of columns and piers along it.
struct Side {
    origin: Vec3,
    along: Vec3,
    posts: Vec<f32>,
}

/// Returns the four sides of the court: the two long ones along x, then the two short ones along z.
fn sides() -> [Side; 4] {
    let long = |z: f32| Side { origin: Vec3::new(0.0, 0.0, z), along: Vec3::X, posts: LINES_X[1..7].to_vec() };
    let short = |x: f32| Side { origin: Vec3::new(x, 0.0, 0.0), along: Vec3::Z, posts: LINES_Z[1..3].to_vec() };
    [long(LINES_Z[1]), long(LINES_Z[2]), short(LINES_X[1]), short(LINES_X[6])]
}

/// Builds the arches of both storeys with the walls above them, the parapets and the horizontal bands of stone.
fn arcades() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    for side in sides() {
        let wall = Wall { origin: side.origin, along: side.along, thickness_m: ARCADE_M };
        for bay in side.posts.windows(2) {
            let mut bricks = mesh("arcade", BRICKS);
            let mut stone = mesh("arches", ARCH);
            let ends = [bay[0], bay[1]];
            let arches = [lower_arches(ends), upper_arches(ends)];
            let tops = [UPPER_FLOOR, 8.2];
            for ((arches, spring_m), top) in arches.iter().zip(SPRING_M).zip(tops) {
                masonry::arched_wall(&mut bricks, &wall, ends, [spring_m, top], arches);
                for arch in arches {
                    masonry::archivolt(&mut stone, &wall, arch, 0.18, 0.03);
                }
            }
            masonry::arched_wall(&mut bricks, &wall, ends, [UPPER_FLOOR, PARAPET], &[]);
            course(&mut stone, &wall, ends, [UPPER_FLOOR - 0.1, UPPER_FLOOR + 0.1], 0.08);
            course(&mut stone, &wall, ends, [PARAPET - 0.14, PARAPET], 0.1);
            course(&mut stone, &wall, ends, [8.2, 8.4], 0.08);
            course(&mut stone, &wall, ends, [SPRING_M[1] - 0.01, SPRING_M[1] + 0.01], -0.02);
            parts.extend([bricks, stone]);
        }
    }
    parts
}

/// Adds a horizontal band of stone that projects by `proud_m` from both faces of a wall. The band goes from `from` to
/// `to` metres along the wall, and from the height `low` to `high`.
fn course(mesh: &mut MeshBuilder, wall: &Wall, [from, to]: [f32; 2], [low, high]: [f32; 2], proud_m: f32) {
    let across = wall.along.cross(Vec3::Y).abs() * (0.5 * wall.thickness_m + proud_m);
    let point = |distance: f32, y: f32| wall.origin + distance * wall.along + y * Vec3::Y;
    mesh.cuboid(point(from, low) - across, point(to, high) + across);
}

/// Returns the arch of the lower storey between two posts at `from` and `to` metres along the wall.
fn lower_arches([from, to]: [f32; 2]) -> Vec<Arch> {
    let half = 0.5 * (to - from);
    let half_width_m = half - if half > 2.0 { HALF_PIER_M } else { 0.42 };
    let rise_m = half_width_m.min(1.45);
    vec![Arch { centre_m: from + half, half_width_m, spring_m: SPRING_M[0], rise_m }]
}

/// Returns the two arches of the upper storey between two posts at `from` and `to` metres along the wall. The arches
/// share a slender column.
fn upper_arches([from, to]: [f32; 2]) -> Vec<Arch> {
    let half = 0.5 * (to - from);
    let half_width = 0.5 * (half - 0.3 - 0.15);
    let arch =
        |centre_m: f32| Arch { centre_m, half_width_m: half_width, spring_m: SPRING_M[1], rise_m: half_width.min(0.9) };
    vec![arch(from + 0.3 + half_width), arch(to - 0.3 - half_width)]
}

/// Builds the columns and corner piers of both storeys, and the slender columns between the upper arches.
fn columns() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    let build_column = |name: &str, foot: Vec3, size: ColumnSize| {
        let mut stone = mesh(name, COLUMN);
        masonry::column(&mut stone, foot, &size);
        stone
    };
    let upper_height_m = SPRING_M[1] - PARAPET;
    for side in sides() {
        let point = |distance: f32, y: f32| side.origin + distance * side.along + y * Vec3::Y;
        for &post in &side.posts[1..side.posts.len() - 1] {
            let lower = ColumnSize { radius_m: 0.27, height_m: SPRING_M[0], half_plinth_m: 0.43, sides: 28 };
            parts.push(build_column("column", point(post, 0.0), lower));
            let upper = ColumnSize { radius_m: 0.23, height_m: upper_height_m, half_plinth_m: 0.33, sides: 20 };
            parts.push(build_column("upper-column", point(post, PARAPET), upper));
        }
        for bay in side.posts.windows(2) {
            let slender = ColumnSize { radius_m: 0.11, height_m: upper_height_m, half_plinth_m: 0.19, sides: 12 };
            parts.push(build_column("slender-column", point(0.5 * (bay[0] + bay[1]), PARAPET), slender));
        }
    }
    for (x, z) in [1, 6].into_iter().flat_map(|column| [1, 2].map(|row| (LINES_X[column], LINES_Z[row]))) {
        let mut pier = mesh("pier", COLUMN);
        let foot = Vec3::new(x, 0.0, z);
        // The blocks of a pier: half width, and least and greatest height, in metres.
        for (half, low, high) in [
            (0.62, -OVERLAP, 0.3),
            (0.56, 0.3, 0.42),
            (HALF_PIER_M, 0.42, 2.02),
            (0.56, 2.02, 2.12),
            (0.62, 2.12, SPRING_M[0] + OVERLAP),
            (0.42, SPRING_M[0], 8.45),
        ] {
            pier.cuboid(foot + Vec3::new(-half, low, -half), foot + Vec3::new(half, high, half));
        }
        parts.push(pier);
    }
    parts
}

/// Builds the court's walls above the upper arcade, with a row of windows.
fn upper_walls() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    for (side, outward) in sides().into_iter().zip([Vec3::NEG_Z, Vec3::Z, Vec3::NEG_X, Vec3::X]) {
        let (first, last) = (side.posts[0], side.posts[side.posts.len() - 1]);
        let right = Vec3::Y.cross(outward);
        // The side's own direction is `right` or its opposite, so that distances along it may change their sign.
        let sign = right.dot(side.along);
        let face = side.origin - 0.5 * ARCADE_M * outward;
        let range = |from: f32, to: f32| ordered(from * sign, to * sign);
        let holes: Vec<Rect> = side
            .posts
            .windows(2)
            .map(|bay| 0.5 * (bay[0] + bay[1]))
            .map(|centre| Rect::new(range(centre - 0.45, centre + 0.45), [9.6, 10.9]))
            .collect();
        let mut wall = mesh("court-wall", BRICKS);
        let extent = Rect::new(range(first, last), [8.2, WALL_TOP]);
        wall.panel([face, right, Vec3::Y], extent, &holes);
        let mut frames = mesh("court-windows", ARCH);
        for hole in &holes {
            window(&mut frames, face, right, outward, hole);
        }
        parts.extend([wall, frames]);
    }
    parts
}

/// Adds a blind window: four sides of its recess, a back wall and a sill. `hole` is the window in the plane through
/// `face` that `right` and the vertical span, and `outward` points into the wall.
fn window(mesh: &mut MeshBuilder, face: Vec3, right: Vec3, outward: Vec3, hole: &Rect) {
    const DEPTH: f32 = 0.35;
    let point = |x: f32, y: f32, depth: f32| face + x * right + y * Vec3::Y + depth * outward;
    let (low, high) = (hole.min, hole.max);
    let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
    let middle = 0.5 * (low + high);
    for k in 0..4 {
        let ((x, y), (next_x, next_y)) = (corners[k], corners[(k + 1) % 4]);
        let facing = point(middle.x, middle.y, 0.0) - point(0.5 * (x + next_x), 0.5 * (y + next_y), 0.0);
        let [front, next_front] = [point(x, y, 0.0), point(next_x, next_y, 0.0)];
        let [back, next_back] = [point(x, y, DEPTH), point(next_x, next_y, DEPTH)];
        mesh.polygon(&[front, next_front, next_back, back], facing);
    }
    mesh.polygon(&corners.map(|(x, y)| point(x, y, DEPTH)), -outward);
    let sill = [point(low.x - 0.12, low.y - 0.14, 0.02), point(high.x + 0.12, low.y, -0.12)];
    mesh.cuboid(sill[0].min(sill[1]), sill[0].max(sill[1]));
}

/// Builds the roof: a ring of tiles that slopes to the court and to the outside, with its eaves.
fn roof() -> Vec<MeshBuilder> {
    // Returns the least and the greatest corner (x, z) of a rectangle around the court, for `out` from 0 at the court
    // to 1 at the outer edge of the roof.
    let ring = |out: f32| {
        let (x, z) = OUTSIDE;
        let court = [Vec2::new(LINES_X[1], LINES_Z[1]) + 0.3, Vec2::new(LINES_X[6], LINES_Z[2]) - 0.3];
        let outside = [Vec2::new(x[0], z[0]) - 0.4, Vec2::new(x[1], z[1]) + 0.4];
        [court[0].lerp(outside[0], out), court[1].lerp(outside[1], out)]
    };
    let mut tiles = mesh("roof", ROOF);
    let mut eaves = mesh("eaves", POLE);
    // Adds a sloping ring between two rectangles, each given by its `out` and its height.
    let slope = |mesh: &mut MeshBuilder, inner: f32, inner_y: f32, outer: f32, outer_y: f32, facing: Vec3| {
        let (inner, outer) = (corners_at_height(ring(inner), inner_y), corners_at_height(ring(outer), outer_y));
        for k in 0..4 {
            let next = (k + 1) % 4;
            mesh.polygon(&[inner[k], inner[next], outer[next], outer[k]], facing);
        }
    };
    slope(&mut tiles, -0.08, 13.3, 0.45, 14.29, Vec3::Y);
    slope(&mut tiles, 0.45, 14.29, 1.0, 13.3, Vec3::Y);
    slope(&mut eaves, -0.08, 13.1, 0.06, 13.02, Vec3::NEG_Y);
    slope(&mut eaves, 0.94, 13.2, 1.0, 13.28, Vec3::NEG_Y);
    let (low, high) = (corners_at_height(ring(-0.08), 13.1), corners_at_height(ring(-0.08), 13.3));
    for k in 0..4 {
        let next = (k + 1) % 4;
        // The edge of the eaves faces the middle of the court.
        let facing = Vec3::new(-0.6, 13.2, 0.375) - 0.5 * (low[k] + low[next]);
        eaves.polygon(&[low[k], low[next], high[next], high[k]], facing);
    }
    vec![tiles, eaves]
}
