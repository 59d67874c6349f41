//! Invariants of every triangle, material and view of the built-in scenes.

use super::*;
use crate::planes::coplanar_groups;
use crate::{AreaShape, Light, Vertex};
use glam::DVec3;
use ssct_geometry::bvh::WorldRay;
use ssct_geometry::placement::{WantedCaptures, place};
use ssct_geometry::triangles::Triangles;
use std::sync::LazyLock;

/// The built-in scenes, built once for all tests.
static SCENES: LazyLock<Vec<Scene>> =
    LazyLock::new(|| every_name().map(|name| scene(name).expect("a built-in scene")).collect());

/// The built-in scene with this name.
fn built(name: &str) -> &'static Scene {
    SCENES.iter().find(|s| s.name == name).expect("a built-in scene")
}

/// The corners of every triangle, with the name of its mesh.
fn triangles(scene: &Scene) -> impl Iterator<Item = (&str, [Vertex; 3])> {
    scene.meshes.iter().flat_map(|m| {
        m.indices.chunks_exact(3).map(|t| {
            (m.name.as_str(), [m.vertices[t[0] as usize], m.vertices[t[1] as usize], m.vertices[t[2] as usize]])
        })
    })
}

#[test]
fn names_and_scenes_agree() {
    for (name, scene) in every_name().zip(SCENES.iter()) {
        assert_eq!(scene.name, name);
    }
    assert!(scene("sponza").is_none());
}

#[test]
fn indices_materials_and_textures_exist() {
    for scene in SCENES.iter() {
        for mesh in &scene.meshes {
            assert!(!mesh.indices.is_empty() && mesh.indices.len() % 3 == 0, "{}", mesh.name);
            assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.vertices.len()), "{}", mesh.name);
            assert!(mesh.material < scene.materials.len(), "{}", mesh.name);
            assert_eq!(mesh.bounds, crate::Aabb::around(&mesh.vertices));
        }
        for material in &scene.materials {
            let maps = [material.albedo_map, material.normal_map, material.alpha_mask, material.reflectivity_map];
            assert!(maps.into_iter().flatten().all(|t| t < scene.textures.len()), "{material:?}");
            // A material without images must have a colour other than white, or be a window.
            let is_even = maps == [None; 4] && material.albedo != Vec3::ONE;
            assert!(is_even || maps[0].is_some() == (material.surface == Surface::Lit), "{material:?}");
        }
        for (k, material) in scene.materials.iter().enumerate() {
            assert!(scene.meshes.iter().any(|m| m.material == k), "nothing is made of {}", material.name);
        }
    }
}

#[test]
fn vertices_are_finite_with_unit_normals_and_orthogonal_tangents() {
    for scene in SCENES.iter() {
        for mesh in &scene.meshes {
            for v in &mesh.vertices {
                let (n, t) = (Vec3::from(v.normal), Vec3::from_slice(&v.tangent[..3]));
                assert!(Vec3::from(v.position).is_finite(), "{} {v:?}", mesh.name);
                assert!(v.uv.iter().all(|x| x.is_finite()), "{} {v:?}", mesh.name);
                assert!((n.length() - 1.0).abs() < 1e-4 && (t.length() - 1.0).abs() < 1e-4, "{} {v:?}", mesh.name);
                assert!(n.dot(t).abs() < 1e-3, "{} {v:?}", mesh.name);
                assert_eq!(v.tangent[3].abs(), 1.0);
            }
        }
    }
}

#[test]
fn winding_agrees_with_the_normals() {
    for scene in SCENES.iter() {
        for (name, [a, b, c]) in triangles(scene) {
            let position = |v: Vertex| Vec3::from(v.position);
            let across = (position(b) - position(a)).cross(position(c) - position(a)).normalize();
            for v in [a, b, c] {
                assert!(across.dot(Vec3::from(v.normal)) > 0.0, "{name}: {across} against {v:?}");
            }
        }
    }
}

#[test]
fn tangents_follow_the_texture() {
    for scene in SCENES.iter() {
        let (mut wrong, mut all) = (0, 0);
        for (_, [a, b, c]) in triangles(scene) {
            let position = |v: Vertex| Vec3::from(v.position);
            let uv = |v: Vertex| glam::Vec2::from(v.uv);
            let (p, q) = (position(b) - position(a), position(c) - position(a));
            let (i, j) = (uv(b) - uv(a), uv(c) - uv(a));
            let det = i.perp_dot(j);
            // dP/du and −dP/dv of the triangle, up to a positive factor.
            let along_u = (p * j.y - q * i.y) * det.signum();
            let against_v = -(q * i.x - p * j.x) * det.signum();
            let n = Vec3::from(a.normal);
            let t = Vec3::from_slice(&a.tangent[..3]);
            let bitangent = a.tangent[3] * n.cross(t);
            all += 1;
            if along_u.dot(t) <= 0.0 || against_v.dot(bitangent) <= 0.0 {
                wrong += 1;
            }
        }
        // Where a surface closes to a point, the texture is twisted within one triangle, so that a few triangles may differ.
        assert!(wrong * 200 < all, "{}: {wrong} of {all}", scene.name);
    }
}

#[test]
fn texture_scale_is_true_to_the_metre() {
    for scene in SCENES.iter() {
        let floor = scene.meshes.iter().find(|m| ["floor", "road"].contains(&m.name.as_str())).expect("a floor");
        let (a, b) = (floor.vertices[0], floor.vertices[1]);
        let metres = Vec3::from(a.position).distance(Vec3::from(b.position));
        let images = glam::Vec2::from(a.uv).distance(glam::Vec2::from(b.uv));
        assert!((1.0..4.0).contains(&(metres / images)), "{}", metres / images);
    }
}

#[test]
fn extents_are_those_of_the_scenes_they_stand_for() {
    let near = |a: Vec3, b: Vec3, tolerance: f32| a.abs_diff_eq(b, tolerance);
    let rooms = built("rooms").bounds();
    assert!(near(rooms.min, Vec3::new(-6.0, -1.0, -5.0), 0.03), "{rooms:?}");
    assert!(near(rooms.max, Vec3::new(6.0, 1.951, 5.158), 0.03), "{rooms:?}");
    let atrium = built("atrium").bounds();
    assert!(near(atrium.min, Vec3::new(-19.2, -1.264, -11.05), 0.3), "{atrium:?}");
    assert!(near(atrium.max, Vec3::new(18.0, 14.294, 11.83), 0.3), "{atrium:?}");
}

/// Whether a point is within `reach` of a triangle.
fn is_near(point: Vec3, [a, b, c]: [Vec3; 3], reach: f32) -> bool {
    let (low, high) = (a.min(b).min(c) - reach, a.max(b).max(c) + reach);
    if point.cmplt(low).any() || point.cmpgt(high).any() {
        return false;
    }
    // Ericson, Real-Time Collision Detection, 5.1.5, without the early outs: inside the triangle's prism the distance to the
    // plane counts, outside the distance to the nearest edge.
    let n = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| (q - p).cross(point - p).dot(n) >= 0.0);
    if inside {
        return (point - a).dot(n).abs() / n.length() < reach;
    }
    [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| {
        let along = ((point - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
        point.distance(p.lerp(q, along)) < reach
    })
}

#[test]
fn eyes_have_free_space_around_them() {
    for scene in SCENES.iter() {
        for view in &scene.views {
            for (name, corners) in triangles(scene) {
                let corners = corners.map(|v| Vec3::from(v.position));
                assert!(!is_near(view.eye, corners, 0.1), "{}: {name} close in front of the eye", view.name);
            }
        }
    }
}

#[test]
fn probes_stand_free_inside_boxes_that_fit_the_scene() {
    for scene in SCENES.iter() {
        let bounds = scene.bounds();
        assert!(scene.probes.len() >= 2, "{}: two maps to blend", scene.name);
        for probe in &scene.probes {
            let Aabb { min, max } = probe.bounds;
            let inside = |p: Vec3| p.cmpgt(min).all() && p.cmplt(max).all();
            assert!(inside(probe.position), "{}: {probe:?}", scene.name);
            assert!(min.cmpge(bounds.min - 0.01).all() && max.cmple(bounds.max + 0.01).all(), "{probe:?}");
            for (name, corners) in triangles(scene) {
                let corners = corners.map(|v| Vec3::from(v.position));
                assert!(!is_near(probe.position, corners, 0.25), "{} {}: {name} there", scene.name, probe.name);
            }
        }
    }
}

/// Every length in an area light: the distances between its points, and its radius.
fn lengths(shape: &AreaShape) -> Vec<f32> {
    match *shape {
        AreaShape::Sphere { centre, radius } => vec![centre.length(), radius],
        AreaShape::Capsule { a, b, radius } | AreaShape::Cylinder { a, b, radius } => {
            vec![a.length(), b.length(), a.distance(b), radius]
        }
        AreaShape::Rectangle { centre, half_u, half_v } => vec![centre.length(), half_u.length(), half_v.length()],
        AreaShape::Cuboid { centre, half_u, half_v, half_w } => {
            vec![centre.length(), half_u.length(), half_v.length(), half_w]
        }
    }
}

#[test]
fn a_scale_enlarges_probes_impostors_and_area_lights() {
    let sizes = |scene: &Scene| {
        let mut all: Vec<f32> = scene.area_lights.iter().flat_map(|l| lengths(&l.shape)).collect();
        all.extend(scene.probes.iter().flat_map(|p| [p.position, p.bounds.min, p.bounds.max].map(Vec3::length)));
        all.extend(scene.impostors.iter().flat_map(|i| [i.centre, i.half_u, i.half_v].map(Vec3::length)));
        all
    };
    let before = built("street");
    let mut scaled = before.clone();
    scaled.scale(2.5);
    assert!(before.area_lights.len() >= 2 && before.impostors.len() >= 5);
    for (was, is) in sizes(before).into_iter().zip(sizes(&scaled)) {
        assert!((is - 2.5 * was).abs() < 1e-3, "{was} became {is}");
    }
}

#[test]
fn spheres_capsules_and_rectangles_shine_in_the_built_in_scenes() {
    let shapes: Vec<AreaShape> = SCENES.iter().flat_map(|s| &s.area_lights).map(|l| l.shape).collect();
    assert!(shapes.iter().any(|s| matches!(s, AreaShape::Sphere { .. })));
    assert!(shapes.iter().any(|s| matches!(s, AreaShape::Capsule { .. })));
    assert!(shapes.iter().any(|s| matches!(s, AreaShape::Rectangle { .. })));
    // The lamps of the corridor's ceiling shine down.
    for light in &built("corridor").area_lights {
        let AreaShape::Rectangle { half_u, half_v, .. } = light.shape else { panic!("{light:?}") };
        assert!(half_u.cross(half_v).normalize().abs_diff_eq(Vec3::NEG_Y, 1e-5), "{light:?}");
    }
}

#[test]
fn the_road_is_wet_in_places() {
    let street = built("street");
    let road = street.materials.iter().find(|m| m.name == "road").expect("a road");
    let map = &street.textures[road.reflectivity_map.expect("a map of its reflectivity")];
    let share = |from: u8| map.rgba.chunks(4).filter(|t| t[0] >= from).count() as f32 / (map.rgba.len() / 4) as f32;
    assert!((0.05..0.4).contains(&share(200)), "puddles: {}", share(200));
    assert!(share(40) > 0.99, "damp everywhere: {}", share(40));
}

#[test]
fn views_and_reflectivities_are_those_of_the_thesis() {
    let rooms = built("rooms");
    let names: Vec<_> = rooms.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["cylinder", "window-floor", "corridor", "two-cylinders", "window", "ceiling"]);
    assert!(rooms.materials.iter().all(|m| m.roughness == 0.0));
    assert!(rooms.materials.iter().all(|m| m.surface == Surface::Sky || m.reflectivity == 1.0));

    let atrium = built("atrium");
    let reflecting = |view: &str| -> Vec<String> {
        let view = atrium.view(view).expect("a view");
        let materials = atrium.materials_in(view).into_iter();
        materials.filter(|m| m.reflectivity > 0.0).map(|m| m.name).collect()
    };
    assert_eq!(reflecting("atrium"), ["floor"]);
    assert_eq!(reflecting("lion"), ["floor"]);
    assert_eq!(reflecting("hall"), ["floor", "bricks"]);
    let [Light::Directional { direction, .. }] = atrium.lights[..] else {
        panic!("one directional light");
    };
    assert!(direction.abs_diff_eq(Vec3::new(-0.3, -1.0, 0.25).normalize(), 1e-4), "{direction}");
}

#[test]
fn scenes_are_the_same_at_every_call() {
    for name in every_name() {
        let (a, b) = (built(name), scene(name).expect("a built-in scene"));
        assert!(a.textures == b.textures, "{name}");
        for (p, q) in a.meshes.iter().zip(&b.meshes) {
            assert!(p.vertices == q.vertices && p.indices == q.indices, "{name}: {}", p.name);
        }
        assert_eq!((&a.materials, &a.lights, &a.views), (&b.materials, &b.lights, &b.views), "{name}");
        assert_eq!((&a.probes, &a.impostors, &a.area_lights), (&b.probes, &b.impostors, &b.area_lights), "{name}");
    }
}

#[test]
fn the_floor_of_the_rooms_is_found() {
    let groups = coplanar_groups(built("rooms"));
    let up = groups.iter().find(|g| g.plane.y > 0.999).expect("a floor");
    assert!(up.area_m2 > 40.0, "{} m²", up.area_m2);
}

#[test]
fn on_streets_and_in_halls_captures_stand_above_floors_and_below_roofs() {
    for (name, roof) in [("atrium", 13.0), ("street", 7.5), ("cathedral", 13.9)] {
        let scene = built(name);
        let placement = place(scene, WantedCaptures::Count(4));
        let triangles = Triangles::new(scene, &scene.materials);
        assert_eq!(placement.captures.len(), 4, "{name}");
        for capture in &placement.captures {
            let position = capture.position;
            let down = WorldRay { origin: position.as_dvec3(), direction: DVec3::NEG_Y, t_min: 0.0, t_max: 7.6 };
            assert!(position.y < roof && triangles.any(&down), "{name}: no floor below {position}");
        }
        assert!(placement.seen.is_sorted() && placement.seen[3] > 0.7, "{name}: {:?}", placement.seen);
    }
}
