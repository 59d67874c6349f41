//! Parts of buildings: walls with arches, vaults and columns.

use super::builder::MeshBuilder;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// The number of straight pieces in an arch.
const ARCH_STEPS: u32 = 20;

/// An upright wall. A point of it is given by its metres along the wall from `origin` and its height above `origin`.
#[derive(Debug, Clone, Copy)]
pub struct Wall {
    /// A point in the middle of the wall's thickness, at height 0.
    pub origin: Vec3,
    /// Horizontal unit vector along the wall.
    pub along: Vec3,
    /// Thickness from face to face, in metres.
    pub thickness_m: f32,
}

/// An opening that ends in a half ellipse.
#[derive(Debug, Clone, Copy)]
pub struct Arch {
    /// Middle of the opening, in metres along the wall.
    pub centre_m: f32,
    /// Half the width of the opening.
    pub half_width_m: f32,
    /// Height at which the curve begins (its spring).
    pub spring_m: f32,
    /// Height of the crown above the spring.
    pub rise_m: f32,
}

impl Wall {
    /// Returns the horizontal unit vector through the wall.
    fn across(&self) -> Vec3 {
        self.along.cross(Vec3::Y)
    }

    /// Returns a point `distance` metres along the wall; `side` runs from −1 to 1 through its thickness.
    fn point_at(&self, distance: f32, height: f32, side: f32) -> Vec3 {
        self.origin + distance * self.along + height * Vec3::Y + 0.5 * side * self.thickness_m * self.across()
    }

    /// Returns the wall, thicker by `by_m` on each side.
    fn thickened(self, by_m: f32) -> Self {
        Self { thickness_m: self.thickness_m + 2.0 * by_m, ..self }
    }
}

impl Arch {
    /// Returns a point of the curve, as metres along the wall and height, for `share` from 0 (the left end) to 1 (the
    /// right end).
    fn curve(&self, share: f32) -> Vec2 {
        let (sin, cos) = (PI * share).sin_cos();
        Vec2::new(self.centre_m - self.half_width_m * cos, self.spring_m + self.rise_m * sin)
    }

    /// Returns the arch whose curve lies `by_m` farther out, and begins at the same height.
    fn widened(self, by_m: f32) -> Self {
        Self { half_width_m: self.half_width_m + by_m, rise_m: self.rise_m + by_m, ..self }
    }
}

/// Adds both faces of a wall, from `span[0]` to `span[1]` metres along it and from the height `bottom` to `top`. The
/// arches, given in order along the wall, are left open down to `bottom`.
pub fn arched_wall(mesh: &mut MeshBuilder, wall: &Wall, span: [f32; 2], [bottom, top]: [f32; 2], arches: &[Arch]) {
    for side in [-1.0, 1.0] {
        let facing = side * wall.across();
        // Adds the wall between two arches: up to the height where they begin, and from there to the top.
        let mut pier = |from: f32, to: f32, spring: f32| {
            for [low, high] in [[bottom, spring], [spring, top]] {
                let corner = |distance: f32, height: f32| wall.point_at(distance, height, side);
                mesh.polygon(&[corner(from, low), corner(to, low), corner(to, high), corner(from, high)], facing);
            }
        };
        let mut from = span[0];
        for arch in arches {
            pier(from, arch.centre_m - arch.half_width_m, arch.spring_m);
            from = arch.centre_m + arch.half_width_m;
        }
        pier(from, span[1], arches.last().map_or(bottom, |arch| arch.spring_m));
        for arch in arches {
            let curve = arch_points(arch);
            let lower: Vec<Vec3> = curve.iter().map(|point| wall.point_at(point.x, point.y, side)).collect();
            let upper: Vec<Vec3> = curve.iter().map(|point| wall.point_at(point.x, top, side)).collect();
            mesh.band(&lower, &upper, facing);
        }
    }
}

/// Adds the inner surface of an arch through a wall, and the upright sides of the opening below it, down to `bottom`.
pub fn soffit(mesh: &mut MeshBuilder, wall: &Wall, arch: &Arch, bottom: f32) {
    arch_shell(mesh, wall, arch, true);
    for (distance, facing) in
        [(arch.centre_m - arch.half_width_m, wall.along), (arch.centre_m + arch.half_width_m, -wall.along)]
    {
        let corners = [(bottom, -1.0), (bottom, 1.0), (arch.spring_m, 1.0), (arch.spring_m, -1.0)];
        mesh.polygon(&corners.map(|(height, side)| wall.point_at(distance, height, side)), facing);
    }
}

/// Adds a raised band of stones around an arch, `width_m` wide, which projects by `proud_m` from both faces of the
/// wall. The band includes the inner surface of the arch.
pub fn archivolt(mesh: &mut MeshBuilder, wall: &Wall, arch: &Arch, width_m: f32, proud_m: f32) {
    let wall = wall.thickened(proud_m);
    let outer = arch.widened(width_m);
    let (inside, outside) = (arch_points(arch), arch_points(&outer));
    for side in [-1.0, 1.0] {
        let line =
            |points: &[Vec2]| points.iter().map(|point| wall.point_at(point.x, point.y, side)).collect::<Vec<_>>();
        mesh.band(&line(&inside), &line(&outside), side * wall.across());
    }
    arch_shell(mesh, &wall, arch, true);
    arch_shell(mesh, &wall, &outer, false);
}

/// Returns points on the curve of an arch from left to right, each as metres along the wall and height.
fn arch_points(arch: &Arch) -> Vec<Vec2> {
    (0..=ARCH_STEPS).map(|k| arch.curve(k as f32 / ARCH_STEPS as f32)).collect()
}

/// Adds the curved surface of an arch through the wall, which faces inwards to the arch's centre or outwards.
fn arch_shell(mesh: &mut MeshBuilder, wall: &Wall, arch: &Arch, inwards: bool) {
    // The length of the half ellipse, taken to be that of a half circle of the mean radius.
    let arc_length_m = PI * 0.5 * (arch.half_width_m + arch.rise_m);
    let direction = if inwards { 1.0 } else { -1.0 };
    mesh.surface(Vec3::ZERO, [ARCH_STEPS, 1], |s, t| {
        let point = arch.curve(s);
        let side = direction * (2.0 * t - 1.0);
        (wall.point_at(point.x, point.y, side), Vec2::new(s * arc_length_m, t * wall.thickness_m))
    });
}

/// Adds a groin vault over a rectangle with the corners `min` and `max` (x, z): two crossing half-elliptic barrel
/// vaults that begin at the height `spring_m` and rise by `rise_m`. Its front faces down. Each of its four quarters has
/// `steps` columns and rows of cells.
pub fn groin_vault(mesh: &mut MeshBuilder, [min, max]: [Vec2; 2], spring_m: f32, rise_m: f32, steps: [u32; 2]) {
    let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
    let origin = Vec3::new(centre.x, spring_m, centre.y);
    for quarter in 0..4 {
        let (width, depth) = if quarter % 2 == 0 { (half.x, half.y) } else { (half.y, half.x) };
        let (right, outward) = match quarter {
            0 => (Vec3::X, Vec3::Z),
            1 => (Vec3::NEG_Z, Vec3::X),
            2 => (Vec3::NEG_X, Vec3::NEG_Z),
            _ => (Vec3::Z, Vec3::NEG_X),
        };
        // s runs along the half ellipse, and t outwards from the groin, the edge where the two barrels meet. The groin
        // lies at the share |sine| of the quarter's depth. A half ellipse is taken to be π / 2 · (width + rise) long.
        mesh.surface(origin, steps, |s, t| {
            let (sin, cos) = (PI * s - FRAC_PI_2).sin_cos();
            let groin = sin.abs();
            let out_m = depth * (groin + (1.0 - groin) * t);
            let position = width * sin * right + rise_m * cos * Vec3::Y + out_m * outward;
            (position, Vec2::new((s - 0.5) * (width + rise_m) * FRAC_PI_2, out_m))
        });
    }
}

/// Sizes of a round column.
#[derive(Debug, Clone, Copy)]
pub struct ColumnSize {
    /// Radius of the shaft at its foot, in metres.
    pub radius_m: f32,
    /// Height in metres, with plinth and abacus (the square slabs below and above).
    pub height_m: f32,
    /// Half the width of the square plinth and abacus, in metres.
    pub half_plinth_m: f32,
    /// Number of flat sides.
    pub sides: u32,
}

/// Adds a round column on `foot`: square plinth, mouldings, tapering shaft, ring, capital and square abacus.
pub fn column(mesh: &mut MeshBuilder, foot: Vec3, size: &ColumnSize) {
    let (radius, top, half_plinth) = (size.radius_m, size.height_m, size.half_plinth_m);
    // The height of the plinth.
    let plinth_height = 0.45 * half_plinth;
    // Adds a square slab between two heights.
    let square = |mesh: &mut MeshBuilder, low: f32, high: f32, half_width: f32| {
        mesh.cuboid(foot + Vec3::new(-half_width, low, -half_width), foot + Vec3::new(half_width, high, half_width));
    };
    square(mesh, -0.02, plinth_height, half_plinth);
    square(mesh, top - 0.6 * plinth_height, top, half_plinth);
    // Adds a ring of half-round profile at the height `low`, which is `bulge` thick.
    let moulding = |mesh: &mut MeshBuilder, low: f32, height: f32, inner: f32, bulge: f32| {
        mesh.revolve(foot + low * Vec3::Y, [size.sides, 5], |t| {
            let (sin, cos) = (PI * t).sin_cos();
            Vec2::new(inner + bulge * sin, height * (0.5 - 0.5 * cos))
        });
    };
    let roll_height = 0.35 * plinth_height;
    moulding(mesh, plinth_height, roll_height, radius, 0.8 * (half_plinth - radius));
    moulding(mesh, plinth_height + roll_height, 0.6 * roll_height, radius, 0.45 * (half_plinth - radius));
    let (shaft_low, shaft_high) = (plinth_height + 1.6 * roll_height, top - 1.9 * plinth_height);
    mesh.revolve(foot + shaft_low * Vec3::Y, [size.sides, 3], |t| {
        Vec2::new(radius * (1.0 - 0.14 * t * t), (shaft_high - shaft_low) * t)
    });
    moulding(mesh, shaft_high - 0.5 * roll_height, roll_height, 0.86 * radius, 0.14 * radius);
    mesh.revolve(foot + shaft_high * Vec3::Y, [size.sides, 6], |t| {
        let flare = 1.0 - (1.0 - t * t).max(0.0).sqrt();
        Vec2::new(0.86 * radius + (0.96 * half_plinth - 0.86 * radius) * flare.min(1.0), 1.3 * plinth_height * t)
    });
}
