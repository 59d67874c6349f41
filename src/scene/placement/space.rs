//! Where people can be: places to stand on, and places for captures above them.

use crate::math::random::Stream;
use crate::scene::bvh::WorldRay;
use crate::scene::{Aabb, Light, Scene, Surface, Triangles};
use super::sees;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Height of the eyes above the floor, in metres.
pub const EYE_M: f64 = 1.5;
const HEAD_ROOM_M: f64 = 1.9;
const COLUMNS: usize = 16384;
const STANDS: usize = 2048;
const DIRECTIONS: usize = 128;
const BACKS_MAX: f64 = 0.5;
const FREE_M: f64 = 0.1;
const SEED: u64 = 1;

/// A place to stand on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// The eyes.
    pub eye: DVec3,
    /// Free height above the floor; infinite under the sky.
    pub height_m: f64,
    /// Share of the upper half of all directions that meet something.
    pub roofed: f64,
    /// Share of what is met that shows its back.
    pub backs: f64,
    /// The nearest thing met, in metres.
    pub nearest_m: f64,
    /// Whether the sky, a window or a point light is seen.
    pub lit: bool,
}

/// Place `index` of the sequence R2 of Roberts (2018), which fills the unit square evenly.
pub fn r2(index: u64) -> [f64; 2] {
    const G: f64 = 1.324_717_957_244_746;
    let n = index as f64 + 1.0;
    [(0.5 + n / G).fract(), (0.5 + n / (G * G)).fract()]
}

/// Direction `index` of `count` that fill the sphere evenly (spherical Fibonacci).
pub fn fibonacci(index: usize, count: usize) -> DVec3 {
    let y = 1.0 - (2.0 * index as f64 + 1.0) / count as f64;
    let (s, c) = (index as f64 * 2.399_963_229_728_653).sin_cos();
    let r = (1.0 - y * y).sqrt();
    DVec3::new(r * c, y, r * s)
}

/// Places to stand on.
pub fn stands(triangles: &Triangles, scene: &Scene) -> Vec<Stand> {
    let bounds = scene.bounds();
    let columns: Vec<Vec<Stand>> =
        (0..COLUMNS).into_par_iter().map(|i| column(triangles, bounds, r2(i as u64))).collect();
    let mut found: Vec<Stand> = columns.into_iter().flatten().collect();
    found.truncate(STANDS);
    let mut free: Vec<Stand> = found.into_par_iter().map(|s| judged(triangles, scene, s)).collect();
    free.retain(|s| s.backs <= BACKS_MAX && s.nearest_m >= FREE_M);
    let mut enclosures: Vec<f64> = free.iter().map(|s| s.roofed).collect();
    enclosures.sort_by(f64::total_cmp);
    let typical = enclosures.get(enclosures.len() * 9 / 10).copied().unwrap_or(0.0);
    free.retain(|s| s.roofed >= 0.5 * typical);
    with_light(triangles, free)
}

/// The stands from which there is a way, by sight from one to the next, to one that light reaches; all, if there is
/// none.
fn with_light(triangles: &Triangles, stands: Vec<Stand>) -> Vec<Stand> {
    let pairs: Vec<(usize, usize)> = (0..stands.len())
        .into_par_iter()
        .flat_map_iter(|i| {
            let random = Stream::new(SEED, i as u64);
            let others = stands.len() as f64;
            let mut near: Vec<usize> = (0..stands.len()).collect();
            near.sort_by(|a, b| {
                let d = |j: &usize| stands[*j].eye.distance_squared(stands[i].eye);
                d(a).total_cmp(&d(b))
            });
            let far = (0..32).map(move |k| (random.uniform(k) * others) as usize);
            let near: Vec<usize> = near.into_iter().skip(1).take(16).collect();
            let stands = &stands;
            near.into_iter().chain(far).filter(move |j| sees(triangles, stands[i].eye, stands[*j].eye)).map(move |j| (i, j))
        })
        .collect();
    let mut lit: Vec<bool> = stands.iter().map(|s| s.lit).collect();
    if !lit.contains(&true) {
        return stands;
    }
    // Light spreads along the pairs until it has reached all that it can.
    loop {
        let before = lit.iter().filter(|l| **l).count();
        for &(i, j) in &pairs {
            let either = lit[i] || lit[j];
            (lit[i], lit[j]) = (either, either);
        }
        if lit.iter().filter(|l| **l).count() == before {
            break;
        }
    }
    stands.into_iter().zip(lit).filter(|(_, lit)| *lit).map(|(s, _)| s).collect()
}

fn judged(triangles: &Triangles, scene: &Scene, stand: Stand) -> Stand {
    let mut lit = scene.lights.iter().any(|l| matches!(l, Light::Point { position, .. } if sees(triangles, stand.eye, position.as_dvec3())));
    let (mut up, mut roofed, mut met, mut backs, mut nearest) = (0, 0, 0, 0, f64::INFINITY);
    for i in 0..DIRECTIONS {
        let direction = fibonacci(i, DIRECTIONS);
        let ray = WorldRay { origin: stand.eye, direction, t_min: 0.0, t_max: f64::INFINITY };
        let hit = triangles.closest(&ray);
        lit |= hit.is_none_or(|h| triangles.surface(&h).0.surface == Surface::Sky);
        if direction.y > 0.0 {
            up += 1;
            roofed += i32::from(hit.is_some());
        }
        if let Some(hit) = hit {
            met += 1;
            nearest = hit.t.min(nearest);
            backs += i32::from(normal(triangles.corners(&hit)).dot(direction) > 0.0);
        }
    }
    Stand {
        roofed: f64::from(roofed) / f64::from(up),
        backs: f64::from(backs) / f64::from(met.max(1)),
        nearest_m: nearest,
        lit,
        ..stand
    }
}

/// The normal of a triangle on the side of its front.
pub fn normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| v.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero()
}

/// The places to stand on in a vertical line.
fn column(triangles: &Triangles, bounds: Aabb, [u, v]: [f64; 2]) -> Vec<Stand> {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let (x, z) = (min.x + u * (max.x - min.x), min.z + v * (max.z - min.z));
    let top = max.y + 1.0;
    let mut stands = Vec::new();
    let (mut above, mut from) = (f64::INFINITY, 0.0);
    for _ in 0..64 {
        let ray = WorldRay { origin: DVec3::new(x, top, z), direction: DVec3::NEG_Y, t_min: from, t_max: f64::INFINITY };
        let Some(hit) = triangles.closest(&ray) else { break };
        let y = top - hit.t;
        let height_m = above - y;
        let up = normal(triangles.corners(&hit)).y;
        if height_m >= HEAD_ROOM_M && up > 0.7 {
            let eye = DVec3::new(x, y + EYE_M, z);
            stands.push(Stand { eye, height_m, roofed: 0.0, backs: 0.0, nearest_m: 0.0, lit: false });
        }
        above = y;
        from = hit.t + 1e-4;
    }
    stands
}

/// Candidates.
pub fn candidates(_triangles: &Triangles, stands: &[Stand]) -> Vec<DVec3> {
    let mut places = Vec::new();
    for stand in stands.iter().filter(|s| s.nearest_m > 0.25).take(300) {
        places.push(stand.eye);
        if stand.height_m > 4.0 {
            places.push(stand.eye + DVec3::Y * ((stand.height_m.min(8.0)) / 2.0 - EYE_M).max(0.5));
        }
    }
    places
}
