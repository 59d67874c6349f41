//! A parked car: the obstacle that blocks reflections in the street (Schmidt 2013, figures 32, 41 and 47).

use super::builder::{MeshBuilder, ordered};
use glam::{Vec2, Vec3};
use ssct_ground::math::noise::smoothstep;

/// The material indices of a car's parts.
pub struct Materials {
    pub paint: usize,
    pub glass: usize,
    /// Tyres, wheel arches and radiator grille.
    pub dark: usize,
    /// Hubcaps, bumpers, headlamps and door handles.
    pub chrome: usize,
    pub tail_lamp: usize,
}

/// The names of a car's meshes.
pub const MESH_NAMES: [&str; 5] = ["car-body", "car-glass", "car-dark", "car-chrome", "car-tail-lamps"];
/// Width (x), height (y) and length (z) of the bounding box in metres.
pub const SIZE: Vec3 = Vec3::new(1.80, 1.46, 4.36);

const HALF_LENGTH: f32 = 0.5 * SIZE.z;
const WHEEL_RADIUS: f32 = 0.33;
/// The z of both axles, in metres from the middle of the car.
const AXLES: [f32; 2] = [-1.32, 1.36];

/// Builds a car whose front points to +z; `ground` is the point on the ground below its middle.
pub fn parked_car(ground: Vec3, materials: &Materials) -> Vec<MeshBuilder> {
    // Makes the empty mesh of a part, given by its index in `MESH_NAMES`.
    let mesh = |part: usize, material: usize| MeshBuilder::new(MESH_NAMES[part], material, 1.0);
    let mut body = mesh(0, materials.paint);
    hull(&mut body, ground, [40, 26], lower_body);
    hull(&mut body, ground, [28, 8], roof);
    pillars(&mut body, ground);
    // The door mirrors.
    for side in [-1.0, 1.0] {
        body.sphere(ground + Vec3::new(0.96 * side, 0.98, 0.62), 0.085, [12, 8]);
    }
    let mut glass = mesh(1, materials.glass);
    hull(&mut glass, ground, [32, 18], cabin);
    let mut dark = mesh(2, materials.dark);
    let mut chrome = mesh(3, materials.chrome);
    for z in AXLES {
        for side in [-1.0, 1.0] {
            let hub = ground + Vec3::new(0.80 * side, WHEEL_RADIUS, z);
            // The wheel arch, the tyre and the hubcap.
            wheel(&mut dark, hub, WHEEL_RADIUS + 0.07, 0.165, 0.01);
            wheel(&mut dark, hub, WHEEL_RADIUS, 0.20, 0.05);
            wheel(&mut chrome, hub, 0.6 * WHEEL_RADIUS, 0.215, 0.02);
        }
    }
    // Adds a box with these ranges, in metres from `ground`, to each side of the car; the two are mirror images.
    let boxes_on_both_sides = |mesh: &mut MeshBuilder, z: [f32; 2], x: [f32; 2], y: [f32; 2]| {
        for side in [-1.0, 1.0] {
            let [left, right] = ordered(side * x[0], side * x[1]);
            mesh.cuboid(ground + Vec3::new(left, y[0], z[0]), ground + Vec3::new(right, y[1], z[1]));
        }
    };
    // Headlamps, front bumper, rear bumper, and the radiator grille.
    boxes_on_both_sides(&mut chrome, [2.05, 2.16], [0.42, 0.70], [0.62, 0.76]);
    boxes_on_both_sides(&mut chrome, [2.10, 2.20], [0.0, 0.74], [0.38, 0.46]);
    boxes_on_both_sides(&mut chrome, [-2.21, -2.10], [0.0, 0.74], [0.42, 0.50]);
    boxes_on_both_sides(&mut dark, [2.05, 2.165], [0.0, 0.36], [0.56, 0.72]);
    // Two door handles on each side.
    for z in [-0.55, 0.35] {
        boxes_on_both_sides(&mut chrome, [z - 0.09, z + 0.09], [0.86, 0.905], [0.80, 0.83]);
    }
    let mut lamps = mesh(4, materials.tail_lamp);
    boxes_on_both_sides(&mut lamps, [-2.17, -2.02], [0.46, 0.76], [0.66, 0.82]);
    vec![body, glass, dark, chrome, lamps]
}

/// A cross-section of the hull, in metres: its z, half width, and lower and upper edge. `tumblehome` is the share (0…1)
/// of the width by which it is narrower at the top.
struct Section {
    z: f32,
    half_width: f32,
    heights: [f32; 2],
    tumblehome: f32,
}

/// Adds a closed, rounded surface through cross-sections. `section` gives the cross-section at t, from 0 (the rear) to
/// 1 (the front). `steps` are the numbers of cells around a cross-section and along t, and positions are relative to
/// `ground`.
fn hull(mesh: &mut MeshBuilder, ground: Vec3, steps: [u32; 2], section: impl Fn(f32) -> Section) {
    let outline = |s: f32, t: f32| {
        let profile = section(t);
        let (sin, cos) = (std::f32::consts::TAU * s).sin_cos();
        // The cross-section is a superellipse of exponent 4: nearly a box, with rounded edges.
        let signed_root = |number: f32| number.abs().sqrt().copysign(number);
        // The height in the cross-section, from −1 at its lower edge to 1 at its upper edge.
        let up = -signed_root(sin);
        let half_height = 0.5 * (profile.heights[1] - profile.heights[0]);
        let share_of_width = 1.0 - profile.tumblehome * (0.5 + 0.5 * up);
        Vec3::new(
            profile.half_width * share_of_width * signed_root(cos),
            profile.heights[0] + half_height * (1.0 + up),
            profile.z,
        )
    };
    mesh.surface(ground, steps, |s, t| (outline(s, t), Vec2::new(4.0 * s, 4.4 * t)));
    // The flat ends close the surface at the rear and at the front.
    for (end, facing) in [(0.0, Vec3::NEG_Z), (1.0, Vec3::Z)] {
        let rim: Vec<Vec3> = (0..steps[0]).map(|k| ground + outline(k as f32 / steps[0] as f32, end)).collect();
        mesh.polygon(&rim, facing);
    }
}

/// Returns 1 for t in the middle of 0…1. Within `width` of both ends, the result falls to 0 along a quarter circle.
fn rounded(t: f32, width: f32) -> f32 {
    let from_end = (t.min(1.0 - t) / width).clamp(0.0, 1.0);
    (1.0 - (1.0 - from_end).powi(2)).max(0.0).sqrt()
}

/// Returns the cross-section of the body below the windows, for t from 0 (the rear) to 1 (the front).
fn lower_body(t: f32) -> Section {
    let t = t.clamp(0.0, 1.0);
    let end_rounding = rounded(t, 0.10);
    let z = HALF_LENGTH * (2.0 * t - 1.0);
    // The bonnet falls towards the front; the boot stays high.
    let top_y = 0.93 - 0.16 * smoothstep(0.45, 1.0, t);
    let middle_y = 0.58;
    Section {
        z,
        half_width: 0.62 + 0.27 * end_rounding,
        heights: [
            middle_y - (middle_y - 0.22) * (0.25 + 0.75 * end_rounding),
            middle_y + (top_y - middle_y) * (0.35 + 0.65 * end_rounding),
        ],
        tumblehome: 0.06,
    }
}

/// Returns the cross-section of the cabin, which is all of glass, for t from 0 (the rear window) to 1 (the windscreen).
fn cabin(t: f32) -> Section {
    let t = t.clamp(0.0, 1.0);
    let z = -1.62 + 2.60 * t;
    let rise = smoothstep(0.0, 0.30, t) * smoothstep(1.0, 0.58, t);
    Section { z, half_width: 0.80, heights: [0.72, 0.80 + 0.60 * rise], tumblehome: 0.24 }
}

/// Returns the cross-section of the roof over the cabin, for t from 0 (the rear) to 1 (the front).
fn roof(t: f32) -> Section {
    let t = t.clamp(0.0, 1.0);
    let crown = (std::f32::consts::PI * t).sin();
    let half_width = 0.615 + 0.02 * crown;
    Section { z: -0.98 + 1.14 * t, half_width, heights: [1.34, 1.385 + 0.07 * crown], tumblehome: 0.06 }
}

/// Adds the posts between the windows: thin tubes, three on each side, from the body to the roof.
fn pillars(mesh: &mut MeshBuilder, ground: Vec3) {
    for side in [-1.0, 1.0] {
        for (foot, head) in [
            ((0.77, 0.86, 0.90), (0.60, 1.39, 0.12)),
            ((0.815, 0.86, -0.22), (0.635, 1.39, -0.32)),
            ((0.77, 0.88, -1.50), (0.60, 1.39, -0.92)),
        ] {
            let point = |(x, y, z): (f32, f32, f32)| ground + Vec3::new(x * side, y, z);
            let (foot, head) = (point(foot), point(head));
            mesh.tube([8, 4], Vec3::X, |t| (foot.lerp(head, t), 0.035));
        }
    }
}

/// Adds a disc with bulging sides around `hub`, whose axle is parallel to x. `width` is the greatest width of the disc
/// along the axle, in metres. The middle of each side stands out by 0.375 · `shoulder` over the edge of the tread.
fn wheel(mesh: &mut MeshBuilder, hub: Vec3, radius: f32, width: f32, shoulder: f32) {
    let half_width = 0.5 * width;
    mesh.tube([24, 8], Vec3::Y, |t| {
        let angle = (t.clamp(0.0, 1.0) - 0.5) * std::f32::consts::PI;
        // The profile goes from the middle of one side out to its edge, across the tread, and along the other side back
        // to its middle. The edges are where |sin| is 1 / 1.6; there, the disc is 1 % smaller than mid-tread.
        let (sin, cos) = angle.sin_cos();
        let along_axle = (1.6 * sin).clamp(-1.0, 1.0) * (half_width - shoulder) + shoulder * sin;
        let ring_radius = radius * (1.0 - (1.0 - cos).powi(3)).clamp(0.0, 1.0).min(cos * 1.5);
        (hub + along_axle * Vec3::X, ring_radius)
    });
}
