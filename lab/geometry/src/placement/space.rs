//! The space that people move in: the floors that they can stand on, and the possible places of captures above them.
//!
//! A floor is a level surface with head room. A floor counts if all of these conditions hold:
//!
//! - The floor is at least half as enclosed as the most enclosed floors. Roofs are less enclosed.
//! - The surfaces around it show their fronts. Inside a solid body they show their backs.
//! - Light reaches the floor. No light reaches a void between two walls.

use super::sees;
use crate::bvh::WorldRay;
use crate::triangles::Triangles;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct_ground::math::constants;
use ssct_ground::math::random::Stream;
use ssct_ground::scene::{Light, Scene, Surface};

/// Height of the eyes above the floor, in metres.
const EYE_M: f64 = 1.5;
/// Least height above a floor that people can stand on, in metres.
const HEAD_ROOM_M: f64 = 1.9;
/// Sizes of people that are tried in turn, where 1 is human: the first size is taken at which someone can stand and see
/// something in a mirror. Smaller people fit a scene with other units than metres.
pub const SIZES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// Least vertical part of a floor's unit normal.
const LEAST_UPWARD: f64 = 0.7;
/// Number of vertical lines along which floors are searched for.
const COLUMNS: u64 = 16384;
/// Greatest number of surfaces that are looked at along one vertical line.
const STOREYS: usize = 64;
/// Greatest number of places to stand on.
const STANDS: usize = 2048;
/// Number of directions in which a person looks around.
const DIRECTIONS: usize = 128;
/// Greatest share of the surfaces around a person that may show their backs, unless all places exceed this share. A
/// share is allowed because single walls are seen from both sides; inside a solid body everything shows its back.
const BACKS_MAX: f64 = 0.5;
/// Least free distance around the eyes of a person of size 1, in metres.
const FREE_M: f64 = 0.1;
/// Least enclosure of a place, relative to the enclosure that the best tenth of all places reaches. Enclosure is the
/// share of upward directions that meet a surface. Roofs have a relative enclosure of 0 to 0.4, streets of 0.85, rooms
/// and arcades of 1.
const LEAST_ENCLOSURE: f64 = 0.5;
/// How many other places are tested for visibility from each place: nearest neighbours, and random places.
const NEIGHBOURS: [usize; 2] = [16, 32];
/// Greatest difference in height between neighbouring places of one floor, in metres, for people of size 1.
const STEP_M: f64 = 0.6;
/// Greatest number of places that get candidates above them.
const CANDIDATE_STANDS: usize = 256;
/// Vertical distance between the candidates above one place, in metres; a place has at most four candidates.
const RISE_M: f64 = 1.5;
/// Least distance of a capture from every surface, in metres: more than twice the distance of the near plane's corners
/// in the faces of the cube.
const CLEARANCE_M: f64 = 0.25;
/// The seed of the random pairs of places.
const SEED: u64 = 0x7374_616e;

/// A place where a person stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingPlace {
    /// Position of the eyes in world space, in metres.
    pub eye: DVec3,
    /// Size of the people here, where 1 is human.
    size: f64,
    /// Free height above the floor in metres; infinite under the sky.
    height_m: f64,
    /// Relative probability that a path begins here: the number of places on the same floor.
    pub weight: f64,
}

/// A place where a capture may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// World position in metres.
    pub position: DVec3,
    /// Distance in metres that the candidate must keep from every surface.
    clearance_m: f64,
}

/// What a person sees all around.
struct Surroundings {
    /// Share of the upward directions that meet a surface.
    enclosed: f64,
    /// Share of the surfaces seen that show their backs.
    backs: f64,
    /// Distance of the nearest surface, in metres.
    nearest_m: f64,
    /// Whether the person sees the sky, a window or a point light.
    lit: bool,
}

/// Finds the places where people of a size can stand; empty if the scene has no floor for them.
pub fn stands(triangles: &Triangles, scene: &Scene, size: f64) -> Vec<StandingPlace> {
    let columns: Vec<Vec<StandingPlace>> =
        (0..COLUMNS).into_par_iter().map(|index| stands_on_line(triangles, scene, size, index)).collect();
    let mut places: Vec<StandingPlace> = columns.into_iter().flatten().collect();
    places.truncate(STANDS);
    keep_habitable(triangles, scene, places)
}

/// Returns the candidates for captures above places to stand on: at the height of the eyes, and higher if there is
/// room.
pub fn candidates(stands: &[StandingPlace]) -> Vec<Candidate> {
    let above = |stand: &StandingPlace| {
        let (eye, clearance_m) = (stand.eye, CLEARANCE_M * stand.size);
        // How often a candidate can be raised by `RISE_M` so that another `RISE_M` stays free above it.
        let rises = (stand.height_m / stand.size - EYE_M - RISE_M) / RISE_M;
        let levels = 1 + (rises.max(0.0) as usize).min(3);
        let rise = RISE_M * stand.size;
        (0..levels).map(move |level| Candidate { position: eye + level as f64 * rise * DVec3::Y, clearance_m })
    };
    stands.iter().take(CANDIDATE_STANDS).flat_map(above).collect()
}

/// Returns true if a candidate keeps its clearance from every triangle. Bounds are compared first, which is fast.
pub fn is_clear(triangles: &Triangles, candidate: &Candidate) -> bool {
    let Candidate { position, clearance_m } = *candidate;
    let (low, high) = ((position - clearance_m).as_vec3(), (position + clearance_m).as_vec3());
    triangles.all().par_iter().all(|&[a, b, c]| {
        let is_apart = a.min(b).min(c).cmpgt(high).any() || a.max(b).max(c).cmplt(low).any();
        is_apart || distance_to_triangle([a, b, c], position) >= clearance_m
    })
}

/// Returns the distance of a point from a triangle: the distance from the plane if the point lies above the triangle's
/// inside, otherwise the distance from the nearest edge (Ericson, Real-Time Collision Detection, 5.1.5).
fn distance_to_triangle([a, b, c]: [Vec3; 3], point: DVec3) -> f64 {
    let [a, b, c] = [a, b, c].map(|v| v.as_dvec3());
    let edges = [(a, b), (b, c), (c, a)];
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal != DVec3::ZERO && edges.iter().all(|&(start, end)| (end - start).cross(point - start).dot(normal) >= 0.0)
    {
        return (point - a).dot(normal).abs();
    }
    let to_edge = |&(start, end): &(DVec3, DVec3)| {
        let edge = end - start;
        let along = ((point - start).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        point.distance(start.lerp(end, along))
    };
    edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Returns the unit normal of a triangle on the side of its front; zero if it has no area.
pub fn front_normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| v.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero()
}

/// Finds the places to stand on along one vertical line, from top to bottom; `index` chooses the line. The lines fill
/// the scene's bounds evenly, since their x and z are the sequence R2 (Roberts 2018, "The Unreasonable Effectiveness of
/// Quasirandom Sequences").
fn stands_on_line(triangles: &Triangles, scene: &Scene, size: f64, index: u64) -> Vec<StandingPlace> {
    /// The root of x³ = x + 1.
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let bounds = scene.bounds();
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let line_number = index as f64 + 1.0;
    let [u, v] = [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| (0.5 + line_number * step).fract());
    let origin = DVec3::new(min.x + u * (max.x - min.x), max.y + 1.0, min.z + v * (max.z - min.z));
    let mut ray = WorldRay { origin, direction: DVec3::NEG_Y, t_min: 0.0, t_max: f64::INFINITY };
    let mut stands = Vec::new();
    let mut ceiling_y = f64::INFINITY;
    for _ in 0..STOREYS {
        let Some(hit) = triangles.closest(&ray) else { break };
        let floor = ray.point_at(hit.t);
        let height_m = ceiling_y - floor.y;
        if height_m >= HEAD_ROOM_M * size && front_normal(triangles.corners(&hit)).y.abs() > LEAST_UPWARD {
            stands.push(StandingPlace { eye: floor + EYE_M * size * DVec3::Y, size, height_m, weight: 1.0 });
        }
        ceiling_y = floor.y;
        ray.t_min = hit.t + 1e-4;
    }
    stands
}

/// Keeps the places on floors that count by the rules at the top of this file, and gives them their weights.
///
/// A room is a group of places that see each other, directly or through others. A floor is a group of close places of
/// about the same height that see each other.
fn keep_habitable(triangles: &Triangles, scene: &Scene, stands: Vec<StandingPlace>) -> Vec<StandingPlace> {
    let mut places: Vec<(StandingPlace, Surroundings)> =
        stands.into_par_iter().map(|stand| (stand, surroundings(triangles, scene, stand.eye))).collect();
    places.retain(|(stand, around)| around.nearest_m >= FREE_M * stand.size);
    // In a file with all triangles reversed, every place sees backs, and none is dropped for this reason.
    if places.iter().any(|(_, around)| around.backs <= BACKS_MAX) {
        places.retain(|(_, around)| around.backs <= BACKS_MAX);
    }
    let mut enclosures: Vec<f64> = places.iter().map(|(_, around)| around.enclosed).collect();
    enclosures.sort_by(f64::total_cmp);
    let best_tenth = enclosures.get(enclosures.len() * 9 / 10).copied().unwrap_or(0.0);
    places.retain(|(_, around)| around.enclosed >= LEAST_ENCLOSURE * best_tenth);

    let [near_pairs, random_pairs] =
        mutually_visible(triangles, &places.iter().map(|(stand, _)| stand.eye).collect::<Vec<_>>());
    let rooms = groups(places.len(), near_pairs.iter().chain(&random_pairs).copied());
    let lit_rooms: Vec<usize> =
        places.iter().zip(&rooms).filter(|((_, around), _)| around.lit).map(|(_, room)| *room).collect();
    // Returns true if two places, given by their indices, are at about the same height.
    let is_level = |i: usize, j: usize| {
        let ((stand, _), (other, _)) = (&places[i], &places[j]);
        (stand.eye.y - other.eye.y).abs() < STEP_M * stand.size
    };
    let floors = groups(places.len(), near_pairs.iter().copied().filter(|&(i, j)| is_level(i, j)));
    // The places are spread evenly, so that a floor has as many as its area is large.
    let mut places_of_floor = vec![0.0; places.len()];
    floors.iter().for_each(|floor| places_of_floor[*floor] += 1.0);
    let stands =
        places.iter().zip(floors).map(|((stand, _), floor)| StandingPlace { weight: places_of_floor[floor], ..*stand });
    // If no room is lit, all rooms count.
    stands
        .zip(rooms)
        .filter(|(_, room)| lit_rooms.is_empty() || lit_rooms.contains(room))
        .map(|(stand, _)| stand)
        .collect()
}

/// Looks around from a person's eye in all [`DIRECTIONS`]. `lit` becomes true if a point light, the sky or a sky
/// surface is seen from there.
fn surroundings(triangles: &Triangles, scene: &Scene, eye: DVec3) -> Surroundings {
    let is_visible_lamp =
        |light: &Light| matches!(light, Light::Point { position, .. } if sees(triangles, eye, position.as_dvec3()));
    let mut around = Surroundings {
        enclosed: 0.0,
        backs: 0.0,
        nearest_m: f64::INFINITY,
        lit: scene.lights.iter().any(is_visible_lamp),
    };
    // The numbers of directions that hit a surface, and of directions that point upwards.
    let (mut hits, mut upwards) = (0, 0);
    for direction in (0..DIRECTIONS).map(sphere_direction) {
        let hit = triangles.closest(&WorldRay { origin: eye, direction, t_min: 0.0, t_max: f64::INFINITY });
        around.lit |= hit.is_none_or(|hit| triangles.surface(&hit).0.surface == Surface::Sky);
        upwards += i32::from(direction.y > 0.0);
        let Some(hit) = hit else { continue };
        hits += 1;
        around.nearest_m = around.nearest_m.min(hit.t);
        around.enclosed += f64::from(direction.y > 0.0);
        around.backs += f64::from(front_normal(triangles.corners(&hit)).dot(direction) > 0.0);
    }
    around.enclosed /= f64::from(upwards);
    around.backs /= f64::from(hits.max(1));
    around
}

/// Returns the unit vector number `index` of the [`DIRECTIONS`], which cover the sphere evenly on a Fibonacci spiral.
fn sphere_direction(index: usize) -> DVec3 {
    let y = 1.0 - (2.0 * index as f64 + 1.0) / DIRECTIONS as f64;
    let (sine, cosine) = (constants::GOLDEN_ANGLE * index as f64).sin_cos();
    let horizontal = (1.0 - y * y).sqrt();
    DVec3::new(horizontal * cosine, y, horizontal * sine)
}

/// Returns the pairs of eyes that see each other, as indices into `eyes`. The first list has pairs of nearest
/// neighbours, and the second has random pairs.
fn mutually_visible(triangles: &Triangles, eyes: &[DVec3]) -> [Vec<(usize, usize)>; 2] {
    let [near_count, random_count] = NEIGHBOURS;
    let visible_pairs = |i: usize, others: Vec<usize>| {
        others.into_iter().filter(move |j| sees(triangles, eyes[i], eyes[*j])).map(move |j| (i, j))
    };
    let nearest_others = |i: usize| {
        let mut others: Vec<usize> = (0..eyes.len()).filter(|j| *j != i).collect();
        let by_distance = |a: &usize, b: &usize| {
            let [squared_a, squared_b] = [*a, *b].map(|j| eyes[j].distance_squared(eyes[i]));
            squared_a.total_cmp(&squared_b).then(a.cmp(b))
        };
        if others.len() > near_count {
            others.select_nth_unstable_by(near_count, by_distance);
            others.truncate(near_count);
        }
        others
    };
    let random_others = |i: usize| {
        let random = Stream::new(SEED, i as u64);
        (0..random_count as u64)
            .map(|draw| ((random.uniform(draw) * eyes.len() as f64) as usize).min(eyes.len() - 1))
            .collect()
    };
    let eye_indices = || (0..eyes.len()).into_par_iter();
    [
        eye_indices().flat_map_iter(|i| visible_pairs(i, nearest_others(i))).collect(),
        eye_indices().flat_map_iter(|i| visible_pairs(i, random_others(i))).collect(),
    ]
}

/// Divides `count` elements into groups, given `pairs` of elements of the same group (union-find). Returns the group of
/// each element, named by the least index of its members.
fn groups(count: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Vec<usize> {
    /// Finds the least member of the group of `i` by following parents, and shortens the chain of parents for later
    /// calls.
    fn root(parents: &mut [usize], mut i: usize) -> usize {
        while parents[i] != i {
            parents[i] = parents[parents[i]];
            i = parents[i];
        }
        i
    }
    let mut parents: Vec<usize> = (0..count).collect();
    for (i, j) in pairs {
        let (root_i, root_j) = (root(&mut parents, i), root(&mut parents, j));
        parents[root_i.max(root_j)] = root_i.min(root_j);
    }
    (0..count).map(|i| root(&mut parents, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_from_a_triangle_is_that_from_its_nearest_point() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let distance_to = |x: f64, y: f64, z: f64| distance_to_triangle(triangle, DVec3::new(x, y, z));
        assert_eq!(distance_to(0.25, 0.25, 3.0), 3.0, "above its inside");
        assert_eq!(distance_to(0.5, -2.0, 0.0), 2.0, "beside an edge");
        assert_eq!(distance_to(4.0, 0.0, 4.0), 5.0, "beyond a corner");
        assert!((distance_to(1.0, 1.0, 0.0) - 0.5_f64.sqrt()).abs() < 1e-12, "beside the long edge");
        assert_eq!(distance_to_triangle([Vec3::ZERO; 3], DVec3::Z), 1.0, "a triangle that is a point");
    }

    #[test]
    fn pairs_join_groups() {
        let groups = groups(6, [(0, 3), (3, 5), (2, 1)].into_iter());
        assert!(groups[0] == groups[3] && groups[0] == groups[5] && groups[1] == groups[2]);
        assert!(groups[0] != groups[1] && groups[4] != groups[0] && groups[4] != groups[1]);
    }

    #[test]
    fn directions_fill_the_sphere_evenly() {
        let sum: DVec3 = (0..DIRECTIONS).map(sphere_direction).sum();
        assert!(sum.length() < 1.0, "{sum}");
        assert!((0..DIRECTIONS).all(|i| (sphere_direction(i).length() - 1.0).abs() < 1e-12));
    }
}
