//! Ties: rays that end in one place or in another by the rounding of 32-bit floats alone, since they pass through a
//! corner of pixels or graze a block. A hit at any of these places does not contradict the oracle.

use glam::DVec3;
use ssct_scenes::GBufferData;
use ssct_truth::metrics::hits::HitVerdict;
use ssct_truth::reference::hierarchy::Hierarchy;

/// Whether rounding alone can explain where a method's ray of the pixel (x, y) ended: at `hit`, in pixels, or with a
/// miss, `None`. Hundreds of rays are tried that differ from the pixel's mirror ray by a few units in the last place of
/// an f32. They differ in direction, in the depth where they start, or where they cross the sides of pixels. The hit is
/// a tie if version 1 of the oracle lets one of these rays end there.
pub fn is_tie(hierarchy: &Hierarchy, [x, y]: [u32; 2], hit: Option<[f64; 2]>) -> bool {
    let rays = hierarchy.rays();
    let Some(direction) = rays.mirror(x, y) else { return hit.is_none() };
    let signs = [0.0, -1.0, 1.0];
    // Three sizes of change, each with three signs for x, y and z of the direction and for the start depth: 3 · 3⁴.
    (0..3 * 81).any(|n| {
        let change = [1.0, 4.0, 16.0][n / 81] * f64::from(f32::EPSILON);
        let direction_signs = DVec3::new(signs[n % 3], signs[n / 3 % 3], signs[n / 9 % 3]);
        let changed_direction = direction + change * direction_signs;
        let Some(mut segment) = rays.segment(x, y, changed_direction) else { return hit.is_none() };
        segment.start.z *= 1.0 + change * signs[n / 27 % 3];
        let ends = hierarchy.possible_ends(&segment, change);
        ends.into_iter().any(|end| HitVerdict::compare(hit, end) == HitVerdict::Agrees)
    })
}

/// Whether every reflecting pixel of a G-buffer is a mirror; only then can hits be compared.
pub fn are_mirrors(data: &GBufferData) -> bool {
    (0..data.depth.len()).all(|pixel| !data.reflects(pixel) || data.roughness[pixel] <= 0.0)
}
