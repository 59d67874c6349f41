//! The objects in the atrium: curtains and banners, vases and planters, and the lion's head at the atrium's end.

use super::{CLOTH, LEAF, LINES_X, LINES_Z, PARAPET, POLE, RELIEF, VASE, mesh};
use crate::library::builder::MeshBuilder;
use glam::{IVec2, Vec2, Vec3};
use ssct_ground::math::atan2;
use ssct_ground::math::noise::{fractal, smoothstep};
use std::f32::consts::{PI, TAU};

/// Builds all furnishing.
pub fn build() -> Vec<MeshBuilder> {
    [curtains(), banners(), vases(), planters(), lion()].into_iter().flatten().collect()
}

/// Builds a pair of curtains in every bay of the long arcades, tied back to the columns.
fn curtains() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    for (row, z) in [LINES_Z[1] + 0.02, LINES_Z[2] - 0.02].into_iter().enumerate() {
        for (bay, x) in LINES_X[1..7].windows(2).enumerate() {
            let material = CLOTH + (bay + row) % 3;
            let (from, to) = (x[0] + 0.42, x[1] - 0.42);
            let width = 0.5 * (to - from);
            let mut cloth = mesh("curtain", material);
            for (edge, inwards) in [(from, 1.0), (to, -1.0)] {
                curtain(&mut cloth, Vec3::new(edge, 0.04, z), inwards * width);
            }
            let mut pole = mesh("curtain-pole", POLE);
            rod(&mut pole, Vec3::new(from - 0.1, 2.72, z), Vec3::new(to + 0.1, 2.72, z), 0.03);
            parts.extend([cloth, pole]);
        }
    }
    parts
}

/// Adds one of a pair of curtains, 2.7 m high. `foot` is the lower end of its edge at the column, from where it spreads
/// over `width` metres along x (negative: towards −x). The curtain is wide at the pole, gathered where it is tied, and
/// hangs straight below.
fn curtain(mesh: &mut MeshBuilder, foot: Vec3, width: f32) {
    const HEIGHT_M: f32 = 2.7;
    /// Height of the tie, as a share of the curtain's height.
    const TIE: f32 = 0.42;
    // Returns the point of the cloth at the share s of its width and t of its height, and s itself. The x of the point
    // is a share of the width.
    let surface = |s: f32, t: f32| {
        let above_tie = ((t - TIE) / (1.0 - TIE)).max(0.0);
        let below_tie = ((TIE - t) / TIE).max(0.0);
        let open = 0.16 + 0.84 * smoothstep(0.0, 1.0, above_tie).powf(0.8) + 0.10 * smoothstep(0.0, 0.7, below_tie);
        let folds = (TAU * 5.0 * s).sin() * (0.008 + 0.055 * open) + 0.015 * (TAU * 2.5 * s + 3.0 * t).sin();
        let sag = 0.06 * (PI * s).sin() * smoothstep(0.5, 1.0, above_tie);
        (Vec3::new(s * open, HEIGHT_M * t - sag, folds), s)
    };
    let right = width.signum();
    mesh.surface(foot, [48, 14], |s, t| {
        // A curtain towards −x is mirrored, so that the two of a pair have their front on the same side.
        let along = if right > 0.0 { s } else { 1.0 - s };
        let (point, width_share) = surface(along, t);
        (Vec3::new(point.x * width, point.y, point.z), Vec2::new(width_share * right * 1.4 * width.abs(), t * HEIGHT_M))
    });
}

/// Adds a horizontal round bar between two points on a line parallel to x.
fn rod(mesh: &mut MeshBuilder, from: Vec3, to: Vec3, radius: f32) {
    mesh.surface(from, [12, 1], |s, t| {
        let (sin, cos) = (TAU * s).sin_cos();
        let along = t * (to - from);
        (along + radius * Vec3::new(0.0, sin, cos), Vec2::new(s * 0.2, t * from.distance(to)))
    });
}

/// Builds cloths that hang over the parapets, one in each bay.
fn banners() -> Vec<MeshBuilder> {
    let mut parts = Vec::new();
    for (row, (z, court_sign)) in [(LINES_Z[1], 1.0), (LINES_Z[2], -1.0)].into_iter().enumerate() {
        for (bay, x) in LINES_X[1..7].windows(2).enumerate() {
            let mut cloth = mesh("banner", CLOTH + (bay + 2 * row + 1) % 3);
            let origin = Vec3::new(0.5 * (x[0] + x[1]), PARAPET + 0.03, z);
            cloth.surface(origin, [24, 16], |s, t| banner(s, t, court_sign));
            parts.push(cloth);
        }
    }
    parts
}

/// Returns a point of a banner, and its texture coordinates in metres. The banner runs from its lower end in the court
/// over the parapet into the gallery. `s` and `t` run from 0 to 1 across and along the cloth; `court_sign` is the sign
/// of z towards the court.
fn banner(s: f32, t: f32, court_sign: f32) -> (Vec3, Vec2) {
    const WIDTH_M: f32 = 2.2;
    /// The length that hangs into the court, in metres.
    const OUTSIDE: f32 = 1.45;
    /// Half the length that lies on the parapet, in metres.
    const HALF_TOP: f32 = 0.42;
    let across = WIDTH_M * (s - 0.5) * court_sign;
    let length = OUTSIDE + 2.0 * HALF_TOP + 0.3;
    // The distance along the cloth from its lower end, and how far below the parapet the cloth hangs in the court.
    let run = t * length;
    let hanging = (OUTSIDE - run).max(0.0);
    let hem = 0.12 * (TAU * 2.0 * s).cos() * smoothstep(OUTSIDE, 0.0, run);
    let folds = 0.035 * (TAU * 5.0 * s).sin() * smoothstep(0.0, 0.8, hanging);
    // The share of the way over the parapet, and how far below it the cloth hangs in the gallery.
    let share_over_parapet = ((run - OUTSIDE) / (2.0 * HALF_TOP)).clamp(0.0, 1.0);
    let hanging_in_gallery = (run - OUTSIDE - 2.0 * HALF_TOP).max(0.0);
    let (sin, cos) = (PI * share_over_parapet).sin_cos();
    let position = Vec3::new(
        across,
        0.10 * sin - hanging - hanging_in_gallery + hem,
        court_sign * (HALF_TOP * cos + folds + 0.03),
    );
    (position, Vec2::new(WIDTH_M * (s - 0.5), run))
}

/// Builds four large vases in the corners of the galleries, with a shrub in each.
fn vases() -> Vec<MeshBuilder> {
    [(-13.3, -4.9), (-13.3, 5.6), (11.9, -4.6), (11.9, 5.3)]
        .into_iter()
        .flat_map(|(x, z)| {
            let foot = Vec3::new(x, 0.0, z);
            let mut vase = mesh("vase", VASE);
            vase.cuboid(foot - Vec3::new(0.4, 0.02, 0.4), foot + Vec3::new(0.4, 0.14, 0.4));
            vase.revolve(foot + 0.14 * Vec3::Y, [40, 32], |t| {
                let belly = 0.16 + 0.40 * (PI * t.clamp(0.0, 1.0).powf(0.75)).sin().max(0.0);
                let lip = 0.14 * smoothstep(0.86, 1.0, t);
                Vec2::new(belly * (1.0 - 0.25 * smoothstep(0.7, 0.9, t)) + lip, 1.1 * t)
            });
            vase.disc(foot + 1.18 * Vec3::Y, 0.25, 40, Vec3::Y);
            [vase, bush(foot + 1.4 * Vec3::Y, 0.42)]
        })
        .collect()
}

/// Builds planters with shrubs beside the columns of the court.
fn planters() -> Vec<MeshBuilder> {
    [LINES_X[1] + 0.9, LINES_X[3], LINES_X[4], LINES_X[6] - 0.9]
        .into_iter()
        .flat_map(|x| [(x, LINES_Z[1] + 0.78), (x, LINES_Z[2] - 0.78)])
        .flat_map(|(x, z)| {
            let foot = Vec3::new(x, 0.0, z);
            let mut pot = mesh("planter", VASE);
            pot.revolve(foot - 0.01 * Vec3::Y, [32, 16], |t| {
                let foot_ring = 0.05 * smoothstep(0.2, 0.0, t);
                Vec2::new(0.15 + foot_ring + 0.11 * t * t, 0.52 * t)
            });
            pot.revolve(foot + 0.51 * Vec3::Y, [32, 6], |t| {
                let (sin, cos) = (PI * t).sin_cos();
                Vec2::new(0.25 + 0.03 * sin, 0.025 - 0.025 * cos)
            });
            pot.disc(foot + 0.52 * Vec3::Y, 0.25, 32, Vec3::Y);
            [pot, bush(foot + 0.68 * Vec3::Y, 0.28)]
        })
        .collect()
}

/// Builds a clipped shrub: a sphere with bumps.
fn bush(centre: Vec3, radius: f32) -> MeshBuilder {
    let mut leaves = mesh("bush", LEAF);
    leaves.surface(centre, [28, 16], |s, t| {
        let (sin, cos) = (PI * t).sin_cos();
        let (east, north) = (TAU * s).sin_cos();
        let lumps = fractal(Vec2::new(s * 10.0, t * 7.0), IVec2::new(10, 64), 2, 307);
        // The surface is smooth towards the poles, where all columns of the grid meet.
        let bumpy_radius = radius * (0.85 + 0.3 * lumps * sin.max(0.0));
        let position = Vec3::new(bumpy_radius * sin * north, -bumpy_radius * cos, bumpy_radius * sin * east);
        (position, Vec2::new(s * 2.4, t * PI * radius))
    });
    leaves
}

/// Builds the relief on the end wall: a plate, a disc, and a lion's head on the disc.
fn lion() -> Vec<MeshBuilder> {
    const WALL_X: f32 = LINES_X[7];
    const MIDDLE: Vec3 = Vec3::new(WALL_X - 0.12, 1.72, 0.375);
    const RADIUS: f32 = 0.92;
    let mut plate = mesh("lion-plate", RELIEF);
    // The slabs of the plate: half width, least and greatest height, and thickness, in metres.
    for (half, low, high, depth) in [(1.25, 0.4, 3.06, 0.12), (1.4, 0.28, 0.4, 0.2), (1.4, 3.06, 3.2, 0.2)] {
        let min = Vec3::new(WALL_X - depth, low, MIDDLE.z - half);
        plate.cuboid_without(min, Vec3::new(WALL_X + 0.02, high, MIDDLE.z + half), &[Vec3::X]);
    }
    let mut head = mesh("lion", RELIEF);
    head.surface(MIDDLE, [48, 128], |s, t| {
        let (sin, cos) = (TAU * t).sin_cos();
        let point = RADIUS * s * Vec2::new(cos, sin);
        (Vec3::new(-lion_relief(point / RADIUS), point.y, -point.x), point)
    });
    vec![plate, head]
}

/// Returns the height of the lion's head above the plate, in metres, at a point of the unit disc with y up.
fn lion_relief(point: Vec2) -> f32 {
    let radius = point.length();
    let angle = atan2(point.y, point.x);
    // A Gaussian bump of height 1 around (x, y) and its mirror image at −x, `width` wide in x and `height` high in y.
    let lump = |x: f32, y: f32, width: f32, height: f32| {
        let offset = Vec2::new((point.x.abs() - x) / width, (point.y - y) / height);
        (-offset.length_squared()).exp()
    };
    let border = 0.07 * smoothstep(0.88, 0.90, radius) * smoothstep(1.0, 0.985, radius);
    let locks = (0.5 + 0.5 * (angle * 13.0 + 0.9 * (radius * 11.0).sin()).sin()).sqrt();
    let tiers = 0.5 + 0.5 * (radius * 22.0 + 1.5 * (angle * 13.0).sin()).sin();
    let hair = smoothstep(0.46, 0.56, radius) * (0.07 * locks + 0.03 * tiers);
    let mane = smoothstep(0.87, 0.70, radius) * (0.08 + hair);
    let face = Vec2::new(point.x * 1.1, point.y * 0.9 - 0.02).length();
    let skull = 0.17 * smoothstep(0.52, 0.36, face) + 0.08 * smoothstep(0.45, 0.1, face);
    let ears = 0.10 * lump(0.36, 0.40, 0.09, 0.10);
    let brows = 0.06 * lump(0.18, 0.22, 0.13, 0.055);
    let eyes = 0.08 * lump(0.18, 0.11, 0.08, 0.05) - 0.04 * lump(0.18, 0.10, 0.045, 0.04);
    let nose = 0.10 * lump(0.0, 0.05, 0.07, 0.18) + 0.07 * lump(0.0, -0.10, 0.12, 0.065);
    let muzzle = 0.14 * lump(0.10, -0.19, 0.11, 0.09);
    let mouth = 0.11 * lump(0.0, -0.335, 0.16, 0.055) + 0.03 * lump(0.0, -0.2, 0.03, 0.08);
    let chin = 0.07 * lump(0.0, -0.43, 0.12, 0.06);
    border + mane + skull + ears + brows - eyes + nose + muzzle - mouth + chin
}
