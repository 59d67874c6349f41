//! Place agreement (docs/definitions.md, "Place agreement"): how often a method's rays end where the same rays, traced
//! against the scene's triangles, end. The measure also suits methods that see more than the screen.

use crate::reference::world_hits::WorldHit;
use glam::DVec3;
use ssct_ground::math::constants::VISIBLE_WITHIN;

/// The end of a ray, as a method finds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RayEnd {
    /// At a place in the world, in metres.
    Place(DVec3),
    /// In the environment, to which the ray escapes.
    Sky,
    /// At a place that the method does not know.
    Unknown,
}

/// Returns whether a method ends a ray in the right place: within 2 % of the true ray's length plus 2 cm of its true
/// end, or in the sky if the true ray escapes. `None` if the pixel does not reflect, so that there is no ray.
pub fn is_right(truth: &WorldHit, method: &RayEnd) -> Option<bool> {
    match (*truth, *method) {
        (WorldHit::NotReflecting, _) => None,
        (WorldHit::Escaped, end) => Some(end == RayEnd::Sky),
        (WorldHit::Hit { position, length_m, .. }, RayEnd::Place(place)) => {
            Some(position.distance(place) <= VISIBLE_WITHIN * length_m + VISIBLE_WITHIN)
        }
        (WorldHit::Hit { .. }, _) => Some(false),
    }
}

/// Returns the share of the rays that a method ends in the right place ([`is_right`]); `None` if nothing reflects.
/// `truth` is the result of [`world_hits`](crate::reference::world_hits::world_hits). Both slices have one element for
/// each pixel.
///
/// # Panics
/// If the slices differ in length.
pub fn agreement(truth: &[WorldHit], method: &[RayEnd]) -> Option<f64> {
    assert_eq!(truth.len(), method.len(), "the images must have equal sizes");
    let judged: Vec<bool> = truth.iter().zip(method).filter_map(|(world, end)| is_right(world, end)).collect();
    (!judged.is_empty()).then(|| judged.iter().filter(|right| **right).count() as f64 / judged.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a true hit at `z` metres on the z axis, at the end of a ray of `length_m` metres.
    fn hit(z: f64, length_m: f64) -> WorldHit {
        WorldHit::Hit { position: DVec3::Z * z, pixel: None, view_z_m: z, length_m, visible: false }
    }

    #[test]
    fn a_place_is_right_within_two_per_cent_of_the_rays_length_and_two_centimetres() {
        // After 5 m a gap of 0.12 m is tolerated, in each direction, whether the screen shows the place or not.
        for (gap, expected) in [(0.0, true), (0.119, true), (0.121, false), (-0.119, true), (-0.121, false)] {
            assert_eq!(is_right(&hit(9.0, 5.0), &RayEnd::Place(DVec3::Z * (9.0 + gap))), Some(expected), "{gap}");
            assert_eq!(is_right(&hit(9.0, 5.0), &RayEnd::Place(DVec3::new(gap, 0.0, 9.0))), Some(expected), "{gap}");
        }
        assert_eq!(is_right(&hit(9.0, 0.0), &RayEnd::Place(DVec3::Z * 9.021)), Some(false));
        assert_eq!(is_right(&hit(9.0, 5.0), &RayEnd::Place(DVec3::NAN)), Some(false));
    }

    #[test]
    fn shares_are_those_of_a_count_by_hand() {
        let truth = [hit(1.0, 1.0), hit(1.0, 1.0), hit(1.0, 1.0), WorldHit::Escaped, WorldHit::Escaped];
        let method =
            [RayEnd::Place(DVec3::Z), RayEnd::Sky, RayEnd::Unknown, RayEnd::Sky, RayEnd::Place(DVec3::splat(1e9))];
        assert_eq!(agreement(&truth, &method), Some(0.4));
        assert_eq!(agreement(&[WorldHit::Escaped], &[RayEnd::Unknown]), Some(0.0));
        assert_eq!(agreement(&[WorldHit::NotReflecting], &[RayEnd::Sky]), None);
        let both = [WorldHit::NotReflecting, WorldHit::Escaped];
        assert_eq!(agreement(&both, &[RayEnd::Sky; 2]), Some(1.0), "what does not reflect does not count");
    }
}
