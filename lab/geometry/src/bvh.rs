//! Finds the closest triangle along a ray. A bounding volume hierarchy in f32 (the crate obvhs) proposes triangles, and
//! the watertight test of Woop, Benthin and Wald ("Watertight Ray/Triangle Intersection", JCGT 2013) decides in f64.
//!
//! An edge function of the test in f64 depends only on the two vertices of the edge, and swapping them changes only its
//! sign. A ray that passes between two triangles with a shared edge therefore hits at least one of them. The boxes are
//! enlarged by more than the rounding error of f32 ([`PaddedTriangles`]), so that no box hides a triangle that the test
//! in f64 would accept.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ray::{Ray as BoxRay, RayHit};
use ssct_ground::scene::tree::boxes::{MAX_LEAF_TRIANGLES, PaddedBox, PaddedTriangles, build_ploc, levels};

/// A ray and the range of distances, in metres, in which hits count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldRay {
    /// Start in world space, in metres.
    pub origin: DVec3,
    /// Unit direction in world space.
    pub direction: DVec3,
    /// Hits closer than this do not count.
    pub t_min: f64,
    /// Hits farther away than this do not count; may be infinite.
    pub t_max: f64,
}

impl WorldRay {
    /// The point at distance `t`.
    pub fn point_at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// The intersection of a ray with a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Index of the triangle.
    pub triangle: u32,
    /// Distance in metres.
    pub t: f64,
    /// Weights of the three vertices; none is negative, and their sum is 1.
    pub barycentrics: [f64; 3],
}

/// An algorithm that finds the closest hit of a ray among triangles.
pub trait Intersector: Send + Sync {
    /// Returns the closest hit with t_min ≤ t ≤ t_max that `accept` accepts. The ray passes through all other hits, as
    /// through the holes of an alpha mask.
    fn closest(&self, ray: &WorldRay, accept: &dyn Fn(&TriangleHit) -> bool) -> Option<TriangleHit>;

    /// Returns true if [`Intersector::closest`] would find a hit, which may take less time than finding the closest
    /// one.
    fn any(&self, ray: &WorldRay, accept: &dyn Fn(&TriangleHit) -> bool) -> bool {
        self.closest(ray, accept).is_some()
    }
}

/// Triangles in a bounding volume hierarchy.
pub struct TriangleBvh {
    triangles: Vec<[Vec3; 3]>,
    /// The middle of the bounds, from which boxes are measured, so that a scene far from the origin loses no precision.
    middle: DVec3,
    /// `None` if no triangle has an area.
    boxes: Option<Boxes>,
}

/// A hierarchy of boxes, whose `primitive_indices` are indices of triangles.
enum Boxes {
    /// Eight boxes a node, which is fast. The traversal has room for [`WIDE_LEVELS`] levels.
    Wide(CwBvh),
    /// Two boxes a node, with room for any number of levels.
    Binary(Bvh2),
}

/// Greatest number of levels of a [`CwBvh`] that its traversal can handle; beyond it obvhs 0.4 silently skips boxes.
/// Many equal boxes make deeper hierarchies, for example in a scene so far from the origin that its corners round to
/// few places.
const WIDE_LEVELS: u32 = 32;

impl Boxes {
    /// Builds a hierarchy of eight boxes a node, or of two if the wide one would be too deep. Its `primitive_indices`
    /// are indices into `padded`.
    fn new(padded: &[PaddedBox]) -> Self {
        let mut binary = build_ploc(padded);
        let wide = bvh2_to_cwbvh(&binary, MAX_LEAF_TRIANGLES, true, false);
        if levels(&wide) < WIDE_LEVELS {
            return Self::Wide(wide);
        }
        // The traversal of obvhs needs a `max_depth` that is one more than the depth of the hierarchy.
        binary.max_depth = binary.max_depth.max(binary.depth(0) + 1);
        Self::Binary(binary)
    }

    /// The indices in the leaves, leaf by leaf: indices of boxes after [`Boxes::new`], and later those of triangles.
    fn primitive_indices_mut(&mut self) -> &mut [u32] {
        match self {
            Self::Wide(boxes) => &mut boxes.primitive_indices,
            Self::Binary(boxes) => &mut boxes.primitive_indices,
        }
    }
}

impl TriangleBvh {
    /// Builds the hierarchy over triangles in metres. A hit names its triangle by its index in `triangles`.
    pub fn new(triangles: Vec<[Vec3; 3]>) -> Self {
        let PaddedTriangles { middle, with_area, boxes: padded } =
            PaddedTriangles::new(triangles.len(), |i| triangles[i].map(|v| v.as_dvec3()));
        let boxes = (!padded.is_empty()).then(|| {
            let mut boxes = Boxes::new(&padded);
            // Only triangles with an area have boxes, so each index of a box is replaced by that of its triangle.
            boxes.primitive_indices_mut().iter_mut().for_each(|index| *index = with_area[*index as usize]);
            boxes
        });
        Self { triangles, middle, boxes }
    }

    /// The corners of each triangle, in metres.
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }
}

/// Makes the ray for tests against boxes: in f32, and relative to `middle`, the middle of the bounds.
fn box_ray(ray: &WorldRay, middle: DVec3) -> BoxRay {
    // Adding 0 turns −0 into +0. With −0, obvhs would be inconsistent: it takes the sign of the reciprocal from the
    // zero itself, but the order of a box's sides from a comparison, in which −0 is not less than 0.
    let direction = ray.direction.as_vec3a() + Vec3A::ZERO;
    BoxRay::new((ray.origin - middle).as_vec3a(), direction, 0.0, f32::INFINITY)
}

impl Intersector for TriangleBvh {
    /// Walks through the hierarchy, and tests the triangles of the boxes that the ray meets.
    fn closest(&self, ray: &WorldRay, accept: &dyn Fn(&TriangleHit) -> bool) -> Option<TriangleHit> {
        // An empty scene returns before anything is computed, since its rays may begin anywhere, even at infinity.
        let boxes = self.boxes.as_ref()?;
        let sheared = ShearedRay::new(ray);
        let mut closest: Option<TriangleHit> = None;
        // Tests one triangle, and keeps it in `closest` if it is hit. The result is the distance of the hit, rounded
        // up, beyond which the traversal skips boxes, or infinity for no hit.
        let mut test_triangle = |triangle: u32| {
            let farthest = closest.map_or(ray.t_max, |hit| hit.t);
            match sheared.intersect(triangle, &self.triangles[triangle as usize]) {
                // The lower index wins between equally close triangles, so that the order of the boxes does not matter.
                Some(hit)
                    if hit.t >= ray.t_min
                        && (hit.t < farthest || hit.t == farthest && closest.is_none_or(|c| triangle < c.triangle))
                        && accept(&hit) =>
                {
                    closest = Some(hit);
                    (hit.t as f32).next_up()
                }
                _ => f32::INFINITY,
            }
        };
        let box_ray = box_ray(ray, self.middle);
        match boxes {
            Boxes::Wide(boxes) => {
                boxes.ray_traverse(box_ray, &mut RayHit::none(), |_, slot| test_triangle(boxes.primitive_indices[slot]))
            }
            Boxes::Binary(boxes) => {
                boxes.ray_traverse(box_ray, &mut RayHit::none(), |_, slot| test_triangle(boxes.primitive_indices[slot]))
            }
        };
        closest
    }

    /// Walks as [`Intersector::closest`] does, and ends at the first hit that counts.
    fn any(&self, ray: &WorldRay, accept: &dyn Fn(&TriangleHit) -> bool) -> bool {
        let Some(boxes) = &self.boxes else { return false };
        let sheared = ShearedRay::new(ray);
        let mut box_ray = box_ray(ray, self.middle);
        box_ray.tmax = (ray.t_max as f32).next_up();
        // The traversal ends at the first result below `tmax`, so minus infinity for a hit ends it at once.
        let test_triangle = |triangle: u32| match sheared.intersect(triangle, &self.triangles[triangle as usize]) {
            Some(hit) if (ray.t_min..=ray.t_max).contains(&hit.t) && accept(&hit) => f32::NEG_INFINITY,
            _ => f32::INFINITY,
        };
        let missed = match boxes {
            Boxes::Wide(boxes) => {
                boxes.ray_traverse_miss(box_ray, |_, slot| test_triangle(boxes.primitive_indices[slot]))
            }
            Boxes::Binary(boxes) => {
                boxes.ray_traverse_miss(box_ray, |_, slot| test_triangle(boxes.primitive_indices[slot]))
            }
        };
        !missed
    }
}

/// A ray with the shear of Woop et al. The shear maps points to a space in which the ray begins at the origin and runs
/// along the z axis, so that z is the distance along the ray.
pub struct ShearedRay {
    origin: DVec3,
    /// The axes of world space (0 to 2) that become x, y and z.
    axes: [usize; 3],
    /// The numbers S of the paper: by how much x and y shift with each metre along the third axis, and the factor of z.
    shear: DVec3,
}

impl ShearedRay {
    /// Computes the shear of a ray; its z is the axis of world space along which the ray advances most.
    pub fn new(ray: &WorldRay) -> Self {
        let direction = ray.direction;
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        // Swapping the axes keeps the winding of triangles, as in the paper.
        if direction[z] < 0.0 {
            (x, y) = (y, x);
        }
        let shear = DVec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        Self { origin: ray.origin, axes: [x, y, z], shear }
    }

    /// Returns the intersection with a triangle, whose index is `triangle` and whose corners are in metres. Hits count
    /// from either side and at any distance, even a negative one. A triangle that has no area or contains the ray is
    /// not hit. The edge functions u, v and w are those of the paper.
    pub fn intersect(&self, triangle: u32, corners: &[Vec3; 3]) -> Option<TriangleHit> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|corner| {
            let offset = corner.as_dvec3() - self.origin;
            DVec3::new(
                offset[x] - self.shear.x * offset[z],
                offset[y] - self.shear.y * offset[z],
                self.shear.z * offset[z],
            )
        });
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let barycentrics = [u / determinant, v / determinant, w / determinant];
        let t = barycentrics[0] * a.z + barycentrics[1] * b.z + barycentrics[2] * c.z;
        Some(TriangleHit { triangle, t, barycentrics })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_ground::math::random::Stream;

    /// Finds the closest hit by testing every triangle, given by its corners.
    struct BruteForce(Vec<[Vec3; 3]>);

    impl Intersector for BruteForce {
        fn closest(&self, ray: &WorldRay, accept: &dyn Fn(&TriangleHit) -> bool) -> Option<TriangleHit> {
            let sheared = ShearedRay::new(ray);
            let triangles = self.0.iter().enumerate();
            let hits = triangles.filter_map(|(index, corners)| sheared.intersect(index as u32, corners));
            let counts = |hit: &TriangleHit| (ray.t_min..=ray.t_max).contains(&hit.t) && accept(hit);
            hits.filter(counts).min_by(|a, b| a.t.total_cmp(&b.t))
        }
    }

    /// A random number in −1…1; `i` and `j` choose it.
    fn random_signed(i: u64, j: u64) -> f64 {
        2.0 * Stream::new(7, i).uniform(j) - 1.0
    }

    /// A random vector whose components lie in −1…1; `i` and `j` choose it.
    fn random_vector(i: u64, j: u64) -> DVec3 {
        DVec3::new(random_signed(i, 3 * j), random_signed(i, 3 * j + 1), random_signed(i, 3 * j + 2))
    }

    /// A ray whose hits count at any distance from 0 on.
    fn ray(origin: DVec3, direction: DVec3) -> WorldRay {
        WorldRay { origin, direction: direction.normalize(), t_min: 0.0, t_max: f64::INFINITY }
    }

    /// Tests triangles that all have the same box, over which the hierarchy is one long chain.
    #[test]
    fn triangles_in_one_box_are_all_found() {
        // Corner j has the height j, and takes its x and y, each 0 or 1, from two bits of i.
        let corner = |i: u32, j: u32| Vec3::new((i >> (2 * j) & 1) as f32, (i >> (2 * j + 1) & 1) as f32, j as f32);
        let triangles: Vec<[Vec3; 3]> = (0..3000).map(|i| [0, 1, 2].map(|j| corner(i % 64, j))).collect();
        let bvh = TriangleBvh::new(triangles.clone());
        assert!(matches!(bvh.boxes, Some(Boxes::Binary(_))), "the hierarchy is not deep enough to test anything");
        let brute = BruteForce(triangles);
        let mut hits = 0;
        for i in 0..200 {
            let ray = ray(3.0 * random_vector(i, 0), random_vector(i, 1));
            let expected = brute.closest(&ray, &|_| true).map(|h| h.t);
            assert_eq!(bvh.closest(&ray, &|_| true).map(|h| h.t), expected);
            assert_eq!(bvh.any(&ray, &|_| true), expected.is_some());
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 5, "only {hits} of 200 rays hit");
    }

    /// Tests a scene whose corners have rounded to a few points: triangles without area must not make the hierarchy
    /// deep, and a triangle with an area among them must be found.
    #[test]
    fn points_are_never_hit_and_hide_nothing() {
        let point = |i: u32| [Vec3::splat((i % 3) as f32); 3];
        let mut triangles: Vec<[Vec3; 3]> = (0..5000).map(point).collect();
        triangles.push([Vec3::ZERO, Vec3::X, Vec3::Y]);
        let bvh = TriangleBvh::new(triangles);
        let towards_triangle = ray(DVec3::new(0.2, 0.2, -1.0), DVec3::Z);
        assert_eq!(bvh.closest(&towards_triangle, &|_| true).map(|h| h.triangle), Some(5000));
        assert!(TriangleBvh::new((0..9).map(point).collect()).closest(&towards_triangle, &|_| true).is_none());
    }

    /// Compares the hits of 3000 random rays in 400 random triangles, of which all count or those with odd indices.
    #[test]
    fn the_hierarchy_agrees_with_brute_force() {
        let triangles: Vec<[Vec3; 3]> = (0..400)
            .map(|i| {
                let centre = 5.0 * random_vector(i, 0);
                [1, 2, 3].map(|corner| (centre + random_vector(i, corner)).as_vec3())
            })
            .collect();
        let brute = BruteForce(triangles.clone());
        let bvh = TriangleBvh::new(triangles);
        let mut hits = 0;
        for i in 1000..4000 {
            let mut ray = ray(6.0 * random_vector(i, 0), random_vector(i, 1));
            ray.t_min = random_signed(i, 9).abs();
            let is_odd = |hit: &TriangleHit| hit.triangle % 2 == 1;
            assert_eq!(bvh.closest(&ray, &|_| true), brute.closest(&ray, &|_| true));
            assert_eq!(bvh.closest(&ray, &is_odd), brute.closest(&ray, &is_odd));
            ray.t_max = 4.0;
            assert_eq!(bvh.any(&ray, &is_odd), brute.any(&ray, &is_odd));
            ray.t_max = f64::INFINITY;
            hits += u32::from(bvh.closest(&ray, &|_| true).is_some());
        }
        assert!((500..2900).contains(&hits), "{hits} of 3000 hit, so both outcomes are tested");
    }

    /// Rays along z hit a flat wall wherever they meet it, also on the edges and corners of its triangles.
    #[test]
    fn axis_parallel_rays_hit_flat_walls_edges_and_corners() {
        // A wall of 4 × 4 squares at z = 3; every ray along z through a grid point hits it.
        let mut triangles = Vec::new();
        for i in 0..16 {
            let (x, y) = ((i % 4) as f32, (i / 4) as f32);
            let corner = |dx: f32, dy: f32| Vec3::new(x + dx, y + dy, 3.0);
            triangles.push([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)]);
            triangles.push([corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
        }
        let bvh = TriangleBvh::new(triangles);
        for i in 0..=16 {
            for j in 0..=16 {
                let origin = DVec3::new(f64::from(i) * 0.25, f64::from(j) * 0.25, -1.0);
                let hit = bvh.closest(&ray(origin, DVec3::Z), &|_| true).expect("no gap");
                assert_eq!(hit.t, 4.0);
                assert!((hit.barycentrics.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            }
        }
        assert_eq!(bvh.closest(&ray(DVec3::new(1.5, 1.5, -1.0), -DVec3::Z), &|_| true), None);
        // Zeros of either sign must give the same hits.
        for (x, y) in [(0.0, -0.0), (-0.0, 0.0), (-0.0, -0.0), (-1e-60, -1e-60)] {
            for (start_z, z) in [(-1.0, 1.0), (7.0, -1.0)] {
                let ray = WorldRay { direction: DVec3::new(x, y, z), ..ray(DVec3::new(1.3, 2.6, start_z), DVec3::Z) };
                assert!(bvh.closest(&ray, &|_| true).is_some(), "{:?}", ray.direction);
            }
        }
        let short = WorldRay { t_max: 3.9, ..ray(DVec3::new(1.5, 1.5, -1.0), DVec3::Z) };
        assert_eq!(bvh.closest(&short, &|_| true), None);
    }

    #[test]
    fn slanted_rays_never_pass_through_shared_edges() {
        // Seven triangles fan out from the origin to points around the z axis. Rays are aimed at the shared edges.
        let rim = |k: u32| {
            let k = k % 7;
            let angle = std::f32::consts::TAU * k as f32 / 7.0;
            Vec3::new(angle.cos(), angle.sin(), 0.1 * (k % 3) as f32)
        };
        let bvh = TriangleBvh::new((0..7).map(|k| [Vec3::ZERO, rim(k), rim(k + 1)]).collect());
        for i in 0..5000_u64 {
            let target = rim((i % 7) as u32).as_dvec3() * random_signed(i, 0).abs() * 0.999;
            let origin = DVec3::new(random_signed(i, 1), random_signed(i, 2), 2.0);
            assert!(bvh.closest(&ray(origin, target - origin), &|_| true).is_some(), "ray {i}");
        }
    }

    #[test]
    fn without_triangles_nothing_is_hit() {
        assert_eq!(TriangleBvh::new(Vec::new()).closest(&ray(DVec3::ZERO, DVec3::X), &|_| true), None);
    }
}
