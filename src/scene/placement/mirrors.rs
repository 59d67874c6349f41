//! What mirrors show.

use super::space::{Stand, normal};
use super::sees;
use crate::math::random::Stream;
use crate::scene::Triangles;
use crate::scene::bvh::WorldRay;
use glam::DVec3;
use rayon::prelude::*;

/// The angle of a pixel.
pub const PIXEL: f64 = 0.0028;
const PATHS: usize = 8192;
const SEED: u64 = 0x63_6170;

/// Where a mirror ray ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// World position.
    pub position: DVec3,
    /// Unit normal of the triangle.
    pub normal: DVec3,
    /// Length from the eye over the mirror.
    pub path_m: f64,
    /// Weight.
    pub weight: f32,
}

/// Ends.
pub fn ends(triangles: &Triangles, stands: &[Stand]) -> Vec<End> {
    if stands.is_empty() {
        return vec![];
    }
    (0..PATHS as u64 * 12).into_par_iter().filter_map(|i| path(triangles, stands, i)).collect::<Vec<_>>().into_iter().take(PATHS).collect()
}

fn path(triangles: &Triangles, stands: &[Stand], index: u64) -> Option<End> {
    let random = Stream::new(SEED, index);
    let stand = &stands[((random.uniform(0) * stands.len() as f64) as usize).min(stands.len() - 1)];
    let sine = 1.4 * random.uniform(1) - 0.7;
    let (s, c) = (std::f64::consts::TAU * random.uniform(2)).sin_cos();
    let cosine = (1.0 - sine * sine).sqrt();
    let looking = DVec3::new(cosine * c, sine, cosine * s);
    let ray = WorldRay { origin: stand.eye, direction: looking, t_min: 0.0, t_max: f64::INFINITY };
    let first = triangles.closest(&ray)?;
    let dull: f64 = std::env::var("DULL").ok().and_then(|v| v.parse().ok()).unwrap_or(0.1);
    let reflectivity = f64::from(triangles.surface(&first).0.reflectivity).max(dull);
    if random.uniform(3) >= reflectivity {
        return None;
    }
    let mirror = normal(triangles.corners(&first));
    let origin = ray.at(first.t);
    let ray = WorldRay { origin, direction: looking.reflect(mirror).normalize(), t_min: 1e-4, t_max: f64::INFINITY };
    let hit = triangles.closest(&ray)?;
    let position = ray.at(hit.t);
    let on_screen = (position - stand.eye).normalize_or_zero().dot(looking) > 0.7 && sees(triangles, stand.eye, position);
    let weight = if on_screen { 0.0 } else { 1.0 };
    (weight > 0.0).then_some(End { position, normal: normal(triangles.corners(&hit)), path_m: first.t + hit.t, weight })
}
