//! Tests walks over trees that are hard to walk over. A walk must find every triangle that a test of all triangles
//! finds. The stack must never hold more than a shader has room for, and no ray may make a NaN.

use super::*;
use bytemuck::Zeroable;
use glam::{DVec3, Quat};
use ssct_geometry::bvh::{Intersector, TriangleBvh, WorldRay};
use ssct_ground::math::random::Stream;
use ssct_scenes::tree::{BuildTrees, Trees};
use ssct_scenes::{Aabb, Material, Mesh, Placement, Scene, Vertex};

type Corners = [Vec3; 3];

/// Returns a scene of one mesh with these triangles.
fn scene(triangles: &[Corners]) -> Scene {
    let vertex = |p: &Vec3| Vertex { position: p.to_array(), ..Vertex::zeroed() };
    let vertices: Vec<Vertex> = triangles.iter().flatten().map(vertex).collect();
    let indices = (0..vertices.len() as u32).collect();
    let bounds = Aabb::around(&vertices);
    let mesh = Mesh { name: "triangles".into(), vertices, indices, material: 0, bounds };
    Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() }
}

/// Returns random number `j` of stream `i`, in −1…1.
fn random_signed(i: u64, j: u64) -> f32 {
    (2.0 * Stream::new(11, i).uniform(j) - 1.0) as f32
}

/// Returns random vector `j` of stream `i`, whose components lie in −1…1.
fn random_vector(i: u64, j: u64) -> Vec3 {
    Vec3::new(random_signed(i, 3 * j), random_signed(i, 3 * j + 1), random_signed(i, 3 * j + 2))
}

/// Compares walks of rays (origin, direction) over the tree of some triangles with tests of every triangle. Returns the
/// number of rays that hit. `name` is for messages.
fn check_walk(name: &str, triangles: &[Corners], rays: impl Iterator<Item = (Vec3, Vec3)>) -> usize {
    let scene = scene(triangles);
    let tree = Tree::build(&scene).expect("a tree");
    assert!(tree.is_walkable(), "{name}: {} levels", tree.levels);
    let with_area = |[a, b, c]: &&Corners| {
        let [a, b, c] = [a, b, c].map(|v| v.as_dvec3());
        (b - a).cross(c - a) != DVec3::ZERO
    };
    let mut slots = tree.slots.clone();
    slots.sort_unstable();
    slots.dedup();
    assert_eq!(slots.len(), triangles.iter().filter(with_area).count(), "{name}: a triangle is lost or there twice");
    assert_eq!(slots.len(), tree.slots.len(), "{name}");
    let records = TriangleRecords::new(&scene, &tree);
    let walk = TriangleWalk::new(&tree, &records);
    let mut hits = 0;
    for (origin, direction) in rays {
        let origin = (origin.as_dvec3() - tree.origin).as_vec3();
        let ray = TreeRay { origin, direction: direction.normalize_or(Vec3::X), own_triangle: NO_TRIANGLE };
        let (found, most_groups) = walk.traverse_tree(&ray);
        assert_eq!(found, walk.nearest_of_all(&ray), "{name}: {ray:?}");
        assert!(most_groups <= TREE_DEPTH as usize, "{name}: {most_groups} groups on the stack");
        assert!(found.t.is_finite() && found.weight.iter().all(|w| w.is_finite()), "{name}: {found:?}");
        hits += usize::from(found.triangle().is_some());
    }
    hits
}

/// Returns `count` rays (origin, direction) that begin around a centre; every other ray is aimed near it.
fn rays(centre: Vec3, radius_m: f32, count: u64) -> impl Iterator<Item = (Vec3, Vec3)> {
    (0..count).map(move |i| {
        let origin = centre + 1.5 * radius_m * random_vector(i, 5);
        let aimed = centre + 0.3 * radius_m * random_vector(i, 6) - origin;
        (origin, if i % 2 == 0 { aimed } else { random_vector(i, 6) })
    })
}

/// Returns random triangles of about this size in metres, whose middles lie up to 5 m from the origin along each axis.
fn scattered(count: u64, size: f32) -> Vec<Corners> {
    (0..count).map(|i| [1, 2, 3].map(|k| 5.0 * random_vector(i, 0) + size * random_vector(i, k))).collect()
}

#[test]
fn scattered_triangles_are_found() {
    assert!(check_walk("scattered", &scattered(4000, 0.6), rays(Vec3::ZERO, 5.0, 3000)) > 1000);
    assert!(check_walk("one", &[[Vec3::ZERO, 3.0 * Vec3::X, 3.0 * Vec3::Y]], rays(Vec3::ZERO, 5.0, 3000)) > 100);
    assert_eq!(check_walk("none", &[], rays(Vec3::ZERO, 5.0, 20)), 0);
}

#[test]
fn triangles_in_one_box_make_no_deep_tree() {
    let corner = |i: u32, j: u32| Vec3::new((i >> (2 * j) & 1) as f32, (i >> (2 * j + 1) & 1) as f32, j as f32);
    let triangles: Vec<Corners> = (0..3000).map(|i| [0, 1, 2].map(|j| corner(i % 64, j))).collect();
    assert!(check_walk("one box", &triangles, rays(Vec3::new(0.5, 0.5, 1.0), 2.0, 300)) > 20);
}

#[test]
fn slivers_and_triangles_in_one_plane_are_found() {
    let sliver = |i: u64| {
        let (start, along) = (5.0 * random_vector(i, 0), random_vector(i, 1));
        [start, start + 8.0 * along, start + 4.0 * along + 1e-3 * random_vector(i, 2)]
    };
    check_walk("slivers", &(0..3000).map(sliver).collect::<Vec<_>>(), rays(Vec3::ZERO, 5.0, 1000));
    let flattened = |triangle: Corners| triangle.map(|v| Vec3::new(v.x, 0.0, v.z));
    let plane: Vec<Corners> = scattered(3000, 1.0).into_iter().map(flattened).collect();
    let rays_down = (0..500).map(|i| (5.0 * random_vector(i, 5).with_y(1.0), random_vector(i, 6).with_y(-1.0)));
    assert!(check_walk("plane", &plane, rays_down) > 200);
}

#[test]
fn triangles_far_from_the_origin_are_found() {
    let far_centre = Vec3::new(1e6, -1e6, 1e6);
    let triangles: Vec<Corners> =
        scattered(1000, 2.0).into_iter().map(|triangle| triangle.map(|v| v + far_centre)).collect();
    assert!(check_walk("far", &triangles, rays(far_centre, 5.0, 1000)) > 300);
}

#[test]
fn no_ray_makes_a_nan_or_runs_for_ever() {
    let scene = scene(&scattered(300, 1.0));
    let tree = Tree::build(&scene).expect("a tree");
    let records = TriangleRecords::new(&scene, &tree);
    let walk = TriangleWalk::new(&tree, &records);
    let odd_numbers = [0.0, -0.0, 1.0, -1.0, 1e-38, 1e30, f32::INFINITY, f32::NAN];
    for i in 0..odd_numbers.len().pow(2) {
        let [a, b] = [odd_numbers[i % odd_numbers.len()], odd_numbers[i / odd_numbers.len()]];
        for (origin, direction) in [(Vec3::new(a, b, 0.0), Vec3::new(b, 1.0, a)), (Vec3::splat(a), Vec3::splat(b))] {
            let (met, _) = walk.traverse_tree(&TreeRay { origin, direction, own_triangle: NO_TRIANGLE });
            assert!(!met.t.is_nan(), "{origin} {direction}: {met:?}");
        }
    }
}

/// Returns a bound of the walk's error in the distance to a triangle, in metres, to the first order in the rounding ε
/// of a number.
///
/// The start and the corners are rounded by ε along each axis relative to the tree's origin, which moves the plane by
/// at most the sum of both. The other part is the error of `t = Σ uᵢ (d · vᵢ) / Σ uᵢ`, with corners vᵢ up to L from the
/// start and edges up to E. Each uᵢ errs by 8 ε L². In this, 2 ε are for the differences of its two corners, and 3 ε
/// for the sum. The two products and the difference of each part of the cross product make √2 · 2 ε. Errors of the
/// weights move the hit within the triangle, whose extent along the ray is at most E. The products d · vᵢ and the
/// weighted sum err by 10 ε L.
fn distance_error(records: &TriangleRecords, [a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let (projected_area, cosine) = (normal.dot(direction).abs(), normal.normalize().dot(direction).abs());
    let farthest_corner = [a, b, c].map(|v| v.distance(origin)).into_iter().fold(0.0, f64::max);
    let longest_edge = [a.distance(b), b.distance(c), c.distance(a)].into_iter().fold(0.0, f64::max);
    let plane_shift = 3.0_f64.sqrt() * (f64::from(records.extent_m()) + origin.length());
    ROUNDING
        * (plane_shift / cosine
            + 3.0 * 8.0 * farthest_corner * farthest_corner * longest_edge / projected_area
            + 10.0 * farthest_corner)
}

/// Tests that the walk in 32-bit floats ends where the hierarchy in 64-bit floats does, except for ties.
#[test]
fn the_walk_agrees_with_the_hierarchy_in_f64() {
    let triangles = scattered(2000, 0.8);
    let scene = scene(&triangles);
    let tree = Tree::build(&scene).expect("a tree");
    let records = TriangleRecords::new(&scene, &tree);
    let walk = TriangleWalk::new(&tree, &records);
    let truth = TriangleBvh::new(triangles.clone());
    let (mut hits, mut different) = (0, 0);
    for (origin, direction) in rays(Vec3::ZERO, 5.0, 20_000) {
        let direction = direction.normalize();
        let ray = WorldRay { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: f64::INFINITY };
        let expected = truth.closest(&ray, &|_| true);
        let (met, _) = walk.traverse_tree(&TreeRay {
            origin: (origin.as_dvec3() - tree.origin).as_vec3(),
            direction,
            own_triangle: NO_TRIANGLE,
        });
        hits += usize::from(expected.is_some());
        match (expected, met.triangle()) {
            (None, None) => {}
            (Some(true_hit), Some(triangle)) if true_hit.triangle == triangle => {
                let corners = triangles[triangle as usize].map(|v| v.as_dvec3());
                let allowed_error = distance_error(&records, corners, origin.as_dvec3(), direction.as_dvec3());
                assert!(
                    (true_hit.t - f64::from(met.t)).abs() <= allowed_error,
                    "{true_hit:?} {met:?}, {allowed_error}"
                );
            }
            // The ray passes an edge, within rounding.
            _ => different += 1,
        }
    }
    assert!(hits > 5000 && different <= 2, "{different} of {hits} differ");
}

/// Tests moving triangles, which have a tree of their own. Rays must end where a test of every triangle ends them.
/// Except for ties, they must also end where the hierarchy in 64-bit floats over all triangles ends them.
#[test]
fn what_moves_is_met_beside_what_stands() {
    let triangles = scattered(2000, 0.8);
    let placement = Placement { turn: Quat::from_rotation_z(0.7), size: 1.5, offset: Vec3::new(1.0, -2.0, 0.5) };
    for moving in [0..0, 0..2000, 600..900, 1999..2000_usize] {
        let mut whole = scene(&triangles);
        let mesh = whole.meshes.remove(0);
        for (name, part) in [("a", 0..moving.start), ("moves", moving.clone()), ("b", moving.end..triangles.len())] {
            let indices = mesh.indices[3 * part.start..3 * part.end].to_vec();
            whole.meshes.push(Mesh { name: name.into(), indices, ..mesh.clone() });
        }
        let trees = Trees::new(&whole);
        let (tree, records) = trees.standing(&["moves"]).expect("a tree");
        let moved = trees.moving(&[("moves", placement)]).expect("a tree");
        assert_eq!(tree.slots.len() + moved.tree.slots.len(), triangles.len());
        assert_eq!(moved.numbers, moving.clone().map(|n| n as u32).collect::<Vec<_>>());
        let walk = TriangleWalk::new(&tree, &records).with_moving(&moved);
        let moved_corners = |(index, corners): (usize, &Corners)| {
            if moving.contains(&index) { corners.map(|corner| placement.place(corner)) } else { *corners }
        };
        let truth = TriangleBvh::new(triangles.iter().enumerate().map(moved_corners).collect::<Vec<_>>());
        let (mut hits, mut moving_hits, mut different) = (0, 0, 0);
        for (origin, direction) in rays(Vec3::ZERO, 5.0, 3000) {
            let direction = direction.normalize();
            let ray = WorldRay { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: f64::INFINITY };
            let tree_ray =
                TreeRay { origin: (origin.as_dvec3() - tree.origin).as_vec3(), direction, own_triangle: NO_TRIANGLE };
            let (met, most_groups) = walk.traverse_tree(&tree_ray);
            assert_eq!(met, walk.nearest_of_all(&tree_ray));
            assert!(most_groups <= TREE_DEPTH as usize);
            let expected = truth.closest(&ray, &|_| true).map(|hit| hit.triangle);
            hits += usize::from(expected.is_some());
            different += usize::from(met.triangle() != expected);
            moving_hits += usize::from(met.triangle().is_some_and(|n| moving.contains(&(n as usize))));
        }
        assert!(hits > 500 && different <= 2, "{different} of {hits} differ");
        assert!(moving_hits > 0 || moving.len() < 2, "nothing that moves is met");
    }
}

/// Tests that rays from one of two planes a millimetre apart meet the other plane, and not their own, whatever the
/// distance from the scene's middle.
#[test]
fn planes_a_millimetre_apart_neither_leak_nor_meet_themselves() {
    for distance_m in [1.0, 100.0, 10_000.0_f32] {
        let quad = |y: f32| {
            let [a, b, c, d] =
                [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| Vec3::new(distance_m + x, y, z));
            [[a, b, c], [a, c, d]]
        };
        let scene = scene(&[quad(0.0), quad(0.001)].concat());
        let tree = Tree::build(&scene).expect("a tree");
        let records = TriangleRecords::new(&scene, &tree);
        let walk = TriangleWalk::new(&tree, &records);
        for i in 0..2000 {
            let [x, z] = [0, 1].map(|k| 0.9 * random_signed(i, k));
            let start = DVec3::new(f64::from(distance_m + x), 0.0, f64::from(z)) - tree.origin;
            // Rays go up from the lower plane, and down from below it.
            for up in [1.0, -1.0] {
                let direction = Vec3::new(
                    random_signed(i, 2),
                    up * 0.2 + up * 0.8 * random_signed(i, 3).abs(),
                    random_signed(i, 4),
                )
                .normalize();
                for own_triangle in [u32::from(x > z), NO_TRIANGLE] {
                    let (met, _) = walk.traverse_tree(&TreeRay { origin: start.as_vec3(), direction, own_triangle });
                    let expected = up > 0.0;
                    assert_eq!(
                        met.triangle().is_some_and(|t| t >= 2),
                        expected,
                        "{distance_m} m, {direction}: {met:?}"
                    );
                    assert!(met.triangle().is_none_or(|t| t >= 2), "{distance_m} m: its own plane");
                }
            }
        }
    }
}
