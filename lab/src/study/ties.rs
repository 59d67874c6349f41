//! Ties: rays that end in one place or in another by the rounding of 32-bit floats alone, since they pass through a
//! corner of pixels or graze a block. A hit at any of these places does not contradict the oracle.

use glam::DVec3;
use ssct_truth::metrics::hits::HitVerdict;
use ssct_truth::reference::hierarchy::Hierarchy;

/// Whether rounding can explain a method's hit for the pixel (x, y), in pixels, or its miss, `None`. Hundreds of rays
/// are tried that differ from the pixel's mirror ray by a few units in the last place of an f32. They differ in
/// direction, in the depth where they start, or where they cross the sides of pixels. The hit is a tie if one of them
/// ends there by version 1 of the oracle.
pub fn is_tie(hierarchy: &Hierarchy, [x, y]: [u32; 2], hit: Option<[f64; 2]>) -> bool {
    let rays = hierarchy.rays();
    let Some(direction) = rays.mirror(x, y) else { return hit.is_none() };
    let signs = [0.0, -1.0, 1.0];
    // Three sizes of change are tried, each with three signs for x, y and z of the direction and for the start depth: 3
    // · 3⁴.
    (0..3 * 81).any(|n| {
        let change = [1.0, 4.0, 16.0][n / 81] * f64::from(f32::EPSILON);
        let direction_signs = DVec3::new(signs[n % 3], signs[n / 3 % 3], signs[n / 9 % 3]);
        let changed_segment = rays.segment(x, y, direction + change * direction_signs);
        let Some(mut segment) = changed_segment else { return hit.is_none() };
        segment.start.z *= 1.0 + change * signs[n / 27 % 3];
        let ends = hierarchy.possible_ends(&segment, change);
        ends.into_iter().any(|end| HitVerdict::compare(hit, end) == HitVerdict::Agrees)
    })
}
