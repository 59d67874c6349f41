//! The block of depth that a pixel stands for when rays are traced. The block extends from the pixel's own depth to a
//! back that lies the thickness T behind it (docs/definitions.md, "Oracle", item 3; docs/numerics.md, "Thickness").

use super::Level;
use glam::DVec3;
pub use ssct_ground::math::constants::{JOINED, SHARE_OF_DEPTH, THIN};
use ssct_scenes::GBufferData;

/// A closed interval of reversed depth; empty for sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthBlock {
    /// Farthest depth, at view depth z + T.
    pub back: f64,
    /// Nearest depth, which is the pixel's own.
    pub front: f64,
}

impl DepthBlock {
    /// The empty interval, whose front lies behind its back.
    pub const EMPTY: Self = Self { back: f64::INFINITY, front: f64::NEG_INFINITY };

    /// Returns the thickness in reversed depth; 0 for sky.
    pub fn thickness(self) -> f64 {
        (self.front - self.back).max(0.0)
    }

    /// Returns the smallest interval that contains both intervals.
    pub fn union(self, other: Self) -> Self {
        Self { back: self.back.min(other.back), front: self.front.max(other.front) }
    }
}

/// Returns the thickness T in metres of a pixel at view depth `z`: the span of the surface in depth along both axes,
/// plus a share of `reach`, the camera's reach at z ([`Camera::reach_m`](ssct_scenes::Camera::reach_m)). The neighbours
/// are given by their view depths in metres; `None` for a neighbour that is sky or off screen.
pub fn thickness(z: f64, reach: f64, [left, right, up, down]: [Option<f64>; 4]) -> f64 {
    // The span along one axis is the smaller difference to a neighbour.
    let span = |first: Option<f64>, second: Option<f64>| {
        let least_step =
            [first, second].into_iter().flatten().map(|neighbour_z| (z - neighbour_z).abs()).min_by(f64::total_cmp);
        // A surface far before both neighbours is narrower than two pixels. The neighbours say nothing about its depth.
        let is_thin =
            [first, second].iter().all(|z_beside| z_beside.is_some_and(|z_beside| z_beside - z > THIN * reach));
        least_step.filter(|_| !is_thin).unwrap_or(0.0)
    };
    span(left, right) + span(up, down) + SHARE_OF_DEPTH * reach
}

/// Returns the block of every pixel of a G-buffer.
pub fn blocks(gbuffer: &GBufferData) -> Level<DepthBlock> {
    let view_to_clip = gbuffer.view_to_clip();
    let clip_to_view = view_to_clip.inverse();
    let view_depth = |reversed: f32| {
        (reversed > 0.0).then(|| clip_to_view.project_point3(DVec3::new(0.0, 0.0, f64::from(reversed))).z)
    };
    let (width, height) = (gbuffer.width, gbuffer.height);
    let depths: Vec<_> = gbuffer.depth.iter().map(|d| view_depth(*d)).collect();
    let depth_at = |x: Option<u32>, y: Option<u32>| {
        let (x, y) = (x.filter(|x| *x < width)?, y.filter(|y| *y < height)?);
        depths[gbuffer.index(x, y)]
    };
    Level::from_fn(width, height, |x, y| {
        let Some(z) = depth_at(Some(x), Some(y)) else { return DepthBlock::EMPTY };
        let beside_x = [depth_at(x.checked_sub(1), Some(y)), depth_at(Some(x + 1), Some(y))];
        let beside_y = [depth_at(Some(x), y.checked_sub(1)), depth_at(Some(x), Some(y + 1))];
        let reach = gbuffer.camera.reach_m(z);
        let back_z = z + thickness(z, reach, [beside_x[0], beside_x[1], beside_y[0], beside_y[1]]);
        let front = f64::from(gbuffer.depth[gbuffer.index(x, y)]);
        DepthBlock { back: view_to_clip.project_point3(DVec3::new(0.0, 0.0, back_z)).z, front }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{depth_of, gbuffer_from};
    use glam::Vec3;

    #[test]
    fn thickness_takes_the_smaller_step_of_each_axis() {
        let thickness_m = thickness(10.0, 10.0, [Some(10.5), Some(9.8), Some(13.0), Some(10.0)]);
        assert!((thickness_m - (0.2 + 0.0 + 0.04)).abs() < 1e-12);
        assert!((thickness(10.0, 10.0, [None, Some(12.0), None, None]) - (2.0 + 0.0 + 0.04)).abs() < 1e-12);
        assert!((thickness(10.0, 10.0, [None; 4]) - 0.04).abs() < 1e-12, "a lone pixel must get the least thickness");
    }

    #[test]
    fn what_stands_far_before_both_neighbours_has_the_least_thickness() {
        // The first two cases are poles of one and of two pixels' width, 2 m before a wall. The third pixel is less
        // than a twentieth of z before its neighbours, so that it counts as a slope.
        let thickness_between = |left, right| thickness(10.0, 10.0, [Some(left), Some(right), Some(10.0), Some(10.0)]);
        assert!((thickness_between(12.0, 12.0) - 0.04).abs() < 1e-12);
        assert!((thickness_between(12.0, 10.0) - 0.04).abs() < 1e-12);
        assert!((thickness_between(10.4, 10.3) - 0.34).abs() < 1e-12);
        assert!((thickness_between(12.0, 8.0) - 2.04).abs() < 1e-12, "a steep surface goes on behind and before");
    }

    #[test]
    fn blocks_reach_from_the_depth_to_the_thickness_behind_it() {
        // A row with 2 m, 2.5 m, sky, 4 m: T = 0.5 + 0.008, 0.5 + 0.01 (sky is ignored), none, 0.016.
        let view_z_m = [2.0, 2.5, f64::INFINITY, 4.0];
        let gbuffer = gbuffer_from(4, 1, |x, _| depth_of(view_z_m[x as usize]), |_, _| Vec3::NEG_Z);
        let blocks = blocks(&gbuffer).texels;
        for (i, thickness_m) in [(0, 0.508), (1, 0.51), (3, 0.016)] {
            assert_eq!(blocks[i].front, f64::from(gbuffer.depth[i]));
            assert!(
                (blocks[i].back - f64::from(depth_of(view_z_m[i] + thickness_m))).abs() < 1e-6 * blocks[i].back,
                "{i}: {blocks:?}"
            );
        }
        assert_eq!(blocks[2], DepthBlock::EMPTY);
    }

    #[test]
    fn an_empty_block_adds_nothing() {
        let block = DepthBlock { back: 0.2, front: 0.3 };
        assert_eq!(block.union(DepthBlock::EMPTY), block);
        assert_eq!(block.union(DepthBlock { back: 0.1, front: 0.25 }), DepthBlock { back: 0.1, front: 0.3 });
    }
}
