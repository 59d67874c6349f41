//! The skeleton of a large two-legged dinosaur, like the one in Schmidt's museum. Screen-space methods cannot
//! see through the gaps between its bones.

use super::builder::MeshBuilder;
use glam::Vec3;
use std::f32::consts::PI;

/// The centre line of the spine from the tip of the tail to the skull: height (y) and z of its points, in metres.
const SPINE: [[f32; 2]; 9] = [
    [1.35, -2.75],
    [1.48, -2.1],
    [1.66, -1.45],
    [1.86, -0.75],
    [2.0, 0.0],
    [2.1, 0.65],
    [2.28, 1.2],
    [2.6, 1.55],
    [2.92, 1.85],
];
/// The positions on the spine (0…1) of the first and the last pair of ribs.
const RIBS: [f32; 2] = [0.56, 0.80];

/// Adds a skeleton that stands on `ground`, with its tail towards −z and its head towards +z.
pub fn stand(bones: &mut MeshBuilder, ground: Vec3) {
    // Returns a point of the spine, for t from 0 at the tip of the tail to 1 at the skull.
    let spine = |t: f32| ground + spline(&SPINE.map(|[y, z]| Vec3::new(0.0, y, z)), t);
    bones.tube([8, 48], Vec3::X, |t| (spine(t), 0.02 + 0.05 * (PI * (0.12 + 0.76 * t)).sin()));
    for vertebra in 0..34 {
        let t = (vertebra as f32 + 0.5) / 34.0;
        let radius = 0.03 + 0.06 * (PI * (0.08 + 0.8 * t)).sin();
        bones.sphere(spine(t), radius, [8, 6]);
        let spike = Vec3::new(0.0, 2.1 * radius, -0.6 * radius);
        bone(bones, spine(t), spine(t) + spike, [0.35 * radius, 0.2 * radius]);
    }
    for pair in 0..9 {
        let t = RIBS[0] + (RIBS[1] - RIBS[0]) * pair as f32 / 8.0;
        let swell = (PI * (0.2 + 0.6 * pair as f32 / 8.0)).sin();
        for side in [-1.0, 1.0] {
            rib(bones, spine(t), side, [0.46 * swell, 0.92 * swell]);
        }
    }
    for side in [-1.0, 1.0] {
        leg(bones, ground, spine(0.5), side);
        arm(bones, spine(0.80), side);
    }
    skull(bones, spine(1.0));
}

/// Adds a bone that is a little thicker at both ends, which are closed. Its radius goes from `thick` at `from` to
/// `thin` at `to`.
fn bone(bones: &mut MeshBuilder, from: Vec3, to: Vec3, [thick, thin]: [f32; 2]) {
    let across = (to - from).normalize_or(Vec3::Y).any_orthonormal_vector();
    bones.tube([7, 8], across, |t| {
        let radius = thick + (thin - thick) * t;
        let from_middle = 2.0 * t.clamp(0.0, 1.0) - 1.0;
        let end_cap = (1.0 - from_middle.powi(8)).sqrt();
        (from.lerp(to, t), radius * end_cap * (0.75 + 0.25 * from_middle.powi(2)))
    });
}

/// Adds one rib: half a hoop from the spine out to one side and down, at +x for a `side` of 1 and at −x for −1. Width
/// and depth are in metres.
fn rib(bones: &mut MeshBuilder, top: Vec3, side: f32, [width, depth]: [f32; 2]) {
    bones.tube([6, 12], Vec3::Z, |t| {
        let (sin, cos) = (PI * 0.92 * t).sin_cos();
        let offset = Vec3::new(side * width * sin, 0.5 * depth * (cos - 1.0), -0.22 * depth * t);
        (top + offset, 0.028 - 0.012 * t)
    });
}

/// Adds one leg with its half of the pelvis, at +x for a `side` of 1 and at −x for −1. The legs are one step apart
/// along z.
fn leg(bones: &mut MeshBuilder, ground: Vec3, hip: Vec3, side: f32) {
    let step = 0.32 * side;
    let hip = hip + Vec3::new(0.22 * side, -0.1, 0.0);
    let knee = ground + Vec3::new(0.36 * side, 1.22, 0.42 + step);
    let ankle = ground + Vec3::new(0.36 * side, 0.52, -0.02 + step);
    let foot = ground + Vec3::new(0.36 * side, 0.07, 0.22 + step);
    // The pelvis: its blade, and the bones that point down in front of it and behind it.
    bone(bones, hip + Vec3::new(0.0, 0.18, -0.45), hip + Vec3::new(0.0, 0.22, 0.42), [0.07, 0.07]);
    bone(bones, hip, hip + Vec3::new(-0.12 * side, -0.62, 0.3), [0.07, 0.04]);
    bone(bones, hip, hip + Vec3::new(-0.12 * side, -0.5, -0.5), [0.06, 0.04]);
    for (from, to, radii) in [(hip, knee, [0.10, 0.09]), (knee, ankle, [0.085, 0.06]), (ankle, foot, [0.065, 0.05])] {
        bone(bones, from, to, radii);
        bones.sphere(from, 1.05 * radii[0], [10, 6]);
        bones.sphere(to, 1.1 * radii[1], [10, 6]);
    }
    for toe_angle in [-0.45, 0.0, 0.45_f32] {
        let (sin, cos) = toe_angle.sin_cos();
        bone(bones, foot, foot + Vec3::new(0.36 * sin, -0.03, 0.36 * cos), [0.045, 0.03]);
        bones.sphere(foot + Vec3::new(0.36 * sin, -0.03, 0.36 * cos), 0.034, [8, 6]);
    }
}

/// Adds one short arm with its shoulder blade and two fingers, at +x for a `side` of 1 and at −x for −1.
fn arm(bones: &mut MeshBuilder, shoulder: Vec3, side: f32) {
    let shoulder = shoulder + Vec3::new(0.26 * side, -0.4, 0.1);
    let elbow = shoulder + Vec3::new(0.05 * side, -0.3, -0.04);
    let hand = elbow + Vec3::new(-0.02 * side, -0.06, 0.26);
    bone(bones, shoulder + Vec3::new(-0.12 * side, 0.3, -0.3), shoulder, [0.03, 0.05]);
    bone(bones, shoulder, elbow, [0.04, 0.03]);
    bone(bones, elbow, hand, [0.03, 0.022]);
    for spread in [-0.3, 0.3_f32] {
        bone(bones, hand, hand + Vec3::new(0.11 * spread, -0.07, 0.11), [0.018, 0.01]);
    }
}

/// Adds the skull: two jaws with teeth, and the cheeks and brows. `back` is its rear end, where the spine meets it.
fn skull(bones: &mut MeshBuilder, back: Vec3) {
    let snout = back + Vec3::new(0.0, -0.12, 0.95);
    bones.tube([12, 10], Vec3::X, |t| {
        let height = 0.20 * (1.0 - 0.55 * t) * (0.55 + 0.45 * (PI * (0.25 + 0.6 * t)).sin());
        (back.lerp(snout, t) + 0.06 * Vec3::Y, height.max(0.01))
    });
    bones.sphere(back + Vec3::new(0.0, 0.05, 0.02), 0.14, [12, 8]);
    bones.sphere(snout + 0.06 * Vec3::Y, 0.075, [12, 8]);
    for side in [-1.0, 1.0] {
        let hinge = back + Vec3::new(0.15 * side, -0.12, 0.05);
        let chin = back + Vec3::new(0.06 * side, -0.46, 0.86);
        bone(bones, back + Vec3::new(0.13 * side, 0.1, 0.0), hinge, [0.05, 0.05]);
        bone(bones, hinge, chin, [0.06, 0.045]);
        bones.sphere(back + Vec3::new(0.13 * side, 0.16, 0.3), 0.06, [10, 8]);
        for tooth in 0..8 {
            let t = 0.3 + 0.68 * tooth as f32 / 7.0;
            let above = back.lerp(snout, t) + Vec3::new((0.13 - 0.07 * t) * side, -0.04, 0.0);
            bone(bones, above, above + Vec3::new(0.0, -0.10, 0.01), [0.022, 0.004]);
            let below = hinge.lerp(chin, t);
            bone(bones, below, below + Vec3::new(0.0, 0.09, 0.02), [0.02, 0.004]);
        }
    }
    bone(bones, back + Vec3::new(-0.06, -0.46, 0.86), back + Vec3::new(0.06, -0.46, 0.86), [0.045, 0.045]);
}

/// Returns a point of the smooth curve through `points` (a Catmull-Rom spline, uniform in the points' index), for t
/// from 0 at the first to 1 at the last. Beyond both ends the curve is extended by straight lines.
fn spline(points: &[Vec3], t: f32) -> Vec3 {
    let last = points.len() - 1;
    let position = t * last as f32;
    // The curve runs from b, the point before the position, to c; f is the share of the way from b to c.
    let index = (position.floor().max(0.0) as usize).min(last - 1);
    let f = position - index as f32;
    let neighbour = |offset: isize| points[index.saturating_add_signed(offset).min(last)];
    let [a, b, c, d] = [-1, 0, 1, 2].map(neighbour);
    if !(0.0..=1.0).contains(&f) {
        return b + (c - b) * f;
    }
    0.5 * (2.0 * b + (c - a) * f + (2.0 * a - 5.0 * b + 4.0 * c - d) * f * f + (3.0 * b - 3.0 * c + d - a) * f * f * f)
}
