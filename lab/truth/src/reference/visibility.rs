//! The visibility chain on the CPU (thesis §4.2.5, Eq. 4.2 and its listing): the twin of `passes::visibility` and
//! `shaders-glsl/thesis/visibility.frag`. The visibility of a cell is the share of it (0 to 1) that the Hi-Z chain
//! leaves visible.

use super::Level;
use super::hi_z::MinMax;

/// The near and far planes in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Near plane.
    pub near_m: f32,
    /// Far plane.
    pub far_m: f32,
}

/// Returns the linearised depth of a standard depth `z` by the thesis's Eq. 4.2 as printed. The equation is meant for
/// depths in −1…1 but receives 0…1 (an erratum that is kept). With near n and far f, the result rises from 2n / (f + n)
/// at 0 to 1 at 1, but it is not a distance.
pub fn linearize(z: f32, range: Range) -> f32 {
    let Range { near_m: near, far_m: far } = range;
    (2.0 * near) / (far + near - z * (far - near))
}

/// Returns a share (0 to 1) as a target of 8 bits stores it. Vulkan rounds to nearest; rounding at a tie depends on the
/// device.
pub fn quantize(share: f32) -> f32 {
    (share.clamp(0.0, 1.0) * 255.0).round() / 255.0
}

/// Returns the visibility of a level, computed from the depth and visibility of the next finer level as in the thesis's
/// listing. `None` if the finer level is the coarsest. The result is not quantised. Fetches beyond the edge return the
/// texel at the edge, as in the shader.
pub fn integrate(depth: &Level<MinMax>, visibility: &Level<f32>, range: Range) -> Option<Level<f32>> {
    let (width, height) = depth.coarser()?;
    Some(Level::from_fn(width, height, |x, y| {
        let texels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (2 * x + dx, 2 * y + dy));
        let fine_z = texels.map(|(x, y)| linearize(depth.at_clamped(x, y).min, range));
        let max_z = fine_z.into_iter().fold(f32::NEG_INFINITY, f32::max);
        texels.iter().zip(fine_z).map(|(&(x, y), z)| 0.25 * (visibility.at_clamped(x, y) * (z / max_z))).sum()
    }))
}

/// Returns the whole visibility chain over a Hi-Z chain. Level 0 is 1 everywhere, and every level is quantised before
/// the next is computed from it.
pub fn chain(hi_z: &[Level<MinMax>], range: Range) -> Vec<Level<f32>> {
    let Some(finest) = hi_z.first() else { return Vec::new() };
    let mut chain = vec![Level::from_fn(finest.width, finest.height, |_, _| 1.0)];
    for (depth, finer_level) in hi_z.iter().zip(0..) {
        let Some(mut level) = integrate(depth, &chain[finer_level], range) else { break };
        level.texels.iter_mut().for_each(|v| *v = quantize(*v));
        chain.push(level);
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::super::hi_z;
    use super::*;

    const RANGE: Range = Range { near_m: 0.1, far_m: 1000.0 };

    #[test]
    fn a_flat_wall_is_wholly_visible() {
        let hi_z = hi_z::chain(&Level::from_fn(7, 5, |_, _| 0.98));
        for level in chain(&hi_z, RANGE) {
            assert!(level.texels.iter().all(|v| *v == 1.0));
        }
    }

    #[test]
    fn a_step_hides_what_is_before_the_farthest_texel() {
        // With near plane n = 1 and far plane f = 3, Eq. 4.2 gives 2/4 at depth 0 and 1 at depth 1. Three near texels
        // and a far one therefore give ¼ (½ + ½ + ½ + 1) = 0.625, which is stored as 159/255.
        let range = Range { near_m: 1.0, far_m: 3.0 };
        let hi_z = hi_z::chain(&Level { width: 2, height: 2, texels: vec![0.0, 0.0, 0.0, 1.0] });
        assert_eq!(chain(&hi_z, range)[1].texels, [159.0 / 255.0]);
    }

    #[test]
    fn no_cell_is_more_visible_than_its_best_part() {
        // "The coarse representation has less or equal visibility" (§4.2.5).
        let hi_z = hi_z::chain(&Level::from_fn(64, 64, |x, y| 0.9 + 0.0015 * ((x * 31 + y * 17) % 61) as f32));
        let chain = chain(&hi_z, RANGE);
        for (fine, coarse) in chain.iter().zip(&chain[1..]) {
            let most_visible = |level: &Level<f32>| level.texels.iter().copied().fold(0.0, f32::max);
            assert!(most_visible(coarse) <= most_visible(fine));
        }
        assert!(chain[6].texels[0] < 1.0);
    }
}
