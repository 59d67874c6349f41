//! The ends of paths that lead from a person's eye over a mirror. A path is kept with the probability of its mirror's
//! reflectivity. Ends that the screen itself would show are left out, since captures are needed only for the other
//! ends.

use super::sees;
use super::space::{StandingPlace, front_normal};
use crate::bvh::WorldRay;
use crate::triangles::Triangles;
use glam::DVec3;
use rayon::prelude::*;
use ssct_ground::math::random::Stream;

/// The angle that a pixel of an image of 960×540 with the thesis's lens spans, in radians: 2 tan(37°) / 540.
pub const PIXEL_RADIANS: f64 = 0.0028;

/// Greatest number of ends, which gives a share a standard error of at most 0.8 %.
const ENDS: usize = 4096;
/// Greatest number of paths that are tried.
const TRIES: u64 = 16 * ENDS as u64;
/// Number of paths after which the search asks whether there are enough ends. It divides [`TRIES`].
const TRIED_AT_ONCE: usize = 4096;
/// Greatest sine of the angle between a ray of the eye and the horizontal, as in an image of 74° from a level camera.
const PITCH_SINE: f64 = 0.65;
/// The cosine of about 46°. An end at a smaller angle from the direction in which the eye sees the mirror counts as on
/// the screen.
const ON_SCREEN_COSINE: f64 = 0.7;
/// Least reflectivity that the search assumes of a surface, since views and users change materials.
const LEAST_REFLECTIVITY: f64 = 0.3;
/// The seed of all random numbers of the paths.
const SEED: u64 = 0x6361_7074;

/// The end of a mirror ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorEnd {
    /// World position in metres.
    pub position: DVec3,
    /// Unit normal of the triangle at the end, or zero if the triangle has no area.
    pub normal: DVec3,
    /// Length of the path from the eye over the mirror, in metres.
    pub path_m: f64,
}

/// Tries up to [`TRIES`] random paths over a mirror, and returns the first [`ENDS`] ends that the screen does not show.
/// A path begins where people stand, at a place that is drawn in proportion to its weight.
pub fn ends(triangles: &Triangles, stands: &[StandingPlace]) -> Vec<MirrorEnd> {
    // The sum of the weights up to and including each place.
    let mut sums: Vec<f64> = Vec::with_capacity(stands.len());
    stands.iter().for_each(|stand| sums.push(sums.last().unwrap_or(&0.0) + stand.weight));
    let Some(total) = sums.last().copied() else { return Vec::new() };
    // Returns the place at a share, 0…1, of the total weight.
    let stand_at = |share: f64| &stands[sums.partition_point(|sum| *sum <= share * total).min(stands.len() - 1)];
    let mut ends: Vec<MirrorEnd> = Vec::new();
    for first_path in (0..TRIES).step_by(TRIED_AT_ONCE) {
        let paths = (first_path..first_path + TRIED_AT_ONCE as u64).into_par_iter();
        ends.par_extend(paths.filter_map(|path| {
            let random = Stream::new(SEED, path);
            end_of_path(triangles, stand_at(random.uniform(0)).eye, &random)
        }));
        if ends.len() >= ENDS {
            break;
        }
    }
    ends.truncate(ENDS);
    ends
}

/// Returns the end of one random path from an eye. The result is `None` if the ray of the eye hits nothing, if a random
/// number exceeds the surface's reflectivity, if the mirror ray escapes, or if the screen shows the end.
fn end_of_path(triangles: &Triangles, eye: DVec3, random: &Stream) -> Option<MirrorEnd> {
    // A random direction between the greatest pitches, in any compass direction.
    let y = PITCH_SINE * (2.0 * random.uniform(1) - 1.0);
    let (sine, cosine) = (std::f64::consts::TAU * random.uniform(2)).sin_cos();
    let horizontal = (1.0 - y * y).sqrt();
    let direction = DVec3::new(horizontal * cosine, y, horizontal * sine);
    let ray = WorldRay { origin: eye, direction, t_min: 0.0, t_max: f64::INFINITY };
    let mirror_hit = triangles.closest(&ray)?;
    if random.uniform(3) >= f64::from(triangles.surface(&mirror_hit).0.reflectivity).max(LEAST_REFLECTIVITY) {
        return None;
    }
    let mirrored = direction.reflect(front_normal(triangles.corners(&mirror_hit))).normalize();
    let ray = WorldRay { origin: ray.point_at(mirror_hit.t), direction: mirrored, t_min: 1e-4, t_max: f64::INFINITY };
    let end_hit = triangles.closest(&ray)?;
    let position = ray.point_at(end_hit.t);
    let is_off_screen = (position - eye).normalize_or_zero().dot(direction) < ON_SCREEN_COSINE;
    let is_beyond_screen = is_off_screen || !sees(triangles, eye, position);
    is_beyond_screen.then(|| MirrorEnd {
        position,
        normal: front_normal(triangles.corners(&end_hit)),
        path_m: mirror_hit.t + end_hit.t,
    })
}
