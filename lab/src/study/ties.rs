//! Rays that end in one of two places by the rounding of 32-bit floats alone: through corners of pixels, or grazing a block. A
//! hit at either place does not contradict the oracle.

use glam::DVec3;
use ssct_truth::metrics::hits::HitVerdict;
use ssct_truth::reference::hierarchy::Hierarchy;

/// Whether a method's hit can be explained by rounding, by version 1 of the oracle. The rays tried differ from the mirror ray
/// of the pixel (x, y) by a few units in the last place of an f32, in direction, start depth or crossings of pixel sides. A tie
/// is found if one of these hundreds of rays ends at the hit.
pub fn is_tie(hierarchy: &Hierarchy, [x, y]: [u32; 2], hit: Option<[f64; 2]>) -> bool {
    let rays = hierarchy.rays();
    let Some(direction) = rays.mirror(x, y) else { return hit.is_none() };
    let signs = [0.0, -1.0, 1.0];
    // Three sizes of change are tried, each with three signs for x, y and z of the direction and for the start depth.
    (0..3 * 81).any(|n| {
        let few = [1.0, 4.0, 16.0][n / 81] * f64::from(f32::EPSILON);
        let off = DVec3::new(signs[n % 3], signs[n / 3 % 3], signs[n / 9 % 3]);
        let Some(mut segment) = rays.segment(x, y, direction + few * off) else { return hit.is_none() };
        segment.start.z *= 1.0 + few * signs[n / 27 % 3];
        let ends = hierarchy.possible_ends(&segment, few);
        ends.into_iter().any(|end| HitVerdict::compare(hit, end) == HitVerdict::Agrees)
    })
}
