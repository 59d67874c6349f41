//! Invariants of every triangle, material and view of the built-in scenes.

use super::*;
use crate::planes::coplanar_groups;
use crate::{AreaShape, Impostor, Light, Vertex};
use glam::DVec3;
use ssct_geometry::bvh::WorldRay;
use ssct_geometry::placement::{WantedCaptures, place};
use ssct_geometry::triangles::Triangles;
use std::sync::LazyLock;

/// The built-in scenes, built once for all tests.
static SCENES: LazyLock<Vec<Scene>> =
    LazyLock::new(|| every_name().map(|name| scene(name).expect("a built-in scene")).collect());

/// Returns the built-in scene with this name.
fn built(name: &str) -> &'static Scene {
    SCENES.iter().find(|scene| scene.name == name).expect("a built-in scene")
}

/// Returns the corners of every triangle, with the name of its mesh.
fn triangles(scene: &Scene) -> impl Iterator<Item = (&str, [Vertex; 3])> {
    scene.meshes.iter().flat_map(|mesh| {
        mesh.indices.chunks_exact(3).map(|triangle| {
            let corner = |index: usize| mesh.vertices[triangle[index] as usize];
            (mesh.name.as_str(), [corner(0), corner(1), corner(2)])
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
            assert!(mesh.indices.iter().all(|&index| (index as usize) < mesh.vertices.len()), "{}", mesh.name);
            assert!(mesh.material < scene.materials.len(), "{}", mesh.name);
            assert_eq!(mesh.bounds, crate::Aabb::around(&mesh.vertices));
        }
        for material in &scene.materials {
            let maps = [material.albedo_map, material.normal_map, material.alpha_mask, material.reflectivity_map];
            assert!(maps.into_iter().flatten().all(|texture| texture < scene.textures.len()), "{material:?}");
            // A lit material without images must have a colour other than white, and a window must have no image.
            let is_paint = maps == [None; 4] && material.albedo != Vec3::ONE;
            assert!(is_paint || maps[0].is_some() == (material.surface == Surface::Lit), "{material:?}");
        }
        for (index, material) in scene.materials.iter().enumerate() {
            assert!(scene.meshes.iter().any(|mesh| mesh.material == index), "nothing is made of {}", material.name);
        }
    }
}

#[test]
fn vertices_are_finite_with_unit_normals_and_orthogonal_tangents() {
    for scene in SCENES.iter() {
        for mesh in &scene.meshes {
            for v in &mesh.vertices {
                let (normal, tangent) = (Vec3::from(v.normal), Vec3::from_slice(&v.tangent[..3]));
                assert!(Vec3::from(v.position).is_finite(), "{} {v:?}", mesh.name);
                assert!(v.uv.iter().all(|coordinate| coordinate.is_finite()), "{} {v:?}", mesh.name);
                assert!((normal.length() - 1.0).abs() < 1e-4, "{} {v:?}", mesh.name);
                assert!((tangent.length() - 1.0).abs() < 1e-4, "{} {v:?}", mesh.name);
                assert!(normal.dot(tangent).abs() < 1e-3, "{} {v:?}", mesh.name);
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
            let face = (position(b) - position(a)).cross(position(c) - position(a)).normalize();
            for v in [a, b, c] {
                assert!(face.dot(Vec3::from(v.normal)) > 0.0, "{name}: {face} against {v:?}");
            }
        }
    }
}

#[test]
fn tangents_follow_the_texture() {
    for scene in SCENES.iter() {
        let (mut wrong, mut total) = (0, 0);
        for (_, [a, b, c]) in triangles(scene) {
            let position = |v: Vertex| Vec3::from(v.position);
            let uv = |v: Vertex| glam::Vec2::from(v.uv);
            let (to_b, to_c) = (position(b) - position(a), position(c) - position(a));
            let (uv_to_b, uv_to_c) = (uv(b) - uv(a), uv(c) - uv(a));
            let sign = uv_to_b.perp_dot(uv_to_c).signum();
            // dP/du and −dP/dv of the triangle, up to a positive factor.
            let along_u = (to_b * uv_to_c.y - to_c * uv_to_b.y) * sign;
            let against_v = -(to_c * uv_to_b.x - to_b * uv_to_c.x) * sign;
            let tangent = Vec3::from_slice(&a.tangent[..3]);
            let bitangent = a.tangent[3] * Vec3::from(a.normal).cross(tangent);
            total += 1;
            if along_u.dot(tangent) <= 0.0 || against_v.dot(bitangent) <= 0.0 {
                wrong += 1;
            }
        }
        // Where a surface closes to a point, the texture is twisted within one triangle, so that a few triangles may
        // differ.
        assert!(wrong * 200 < total, "{}: {wrong} of {total}", scene.name);
    }
}

#[test]
fn texture_scale_is_true_to_the_metre() {
    for scene in SCENES.iter() {
        let floor = scene.meshes.iter().find(|mesh| ["floor", "road"].contains(&mesh.name.as_str())).expect("a floor");
        let (a, b) = (floor.vertices[0], floor.vertices[1]);
        let metres = Vec3::from(a.position).distance(Vec3::from(b.position));
        // The number of widths of the image that lie between the two vertices.
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

/// Returns true if a point is less than `reach` metres from a triangle.
fn is_near(point: Vec3, [a, b, c]: [Vec3; 3], reach: f32) -> bool {
    let (low, high) = (a.min(b).min(c) - reach, a.max(b).max(c) + reach);
    if point.cmplt(low).any() || point.cmpgt(high).any() {
        return false;
    }
    // The method is that of Ericson, Real-Time Collision Detection, 5.1.5, without early exits. Above or below the
    // triangle, the distance to its plane counts, and elsewhere the distance to its nearest edge.
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    if edges.iter().all(|&(start, end)| (end - start).cross(point - start).dot(normal) >= 0.0) {
        return (point - a).dot(normal).abs() / normal.length() < reach;
    }
    edges.iter().any(|&(start, end)| {
        let share = ((point - start).dot(end - start) / (end - start).length_squared()).clamp(0.0, 1.0);
        point.distance(start.lerp(end, share)) < reach
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
            let is_inside = probe.position.cmpgt(min).all() && probe.position.cmplt(max).all();
            assert!(is_inside, "{}: {probe:?}", scene.name);
            assert!(min.cmpge(bounds.min - 0.01).all() && max.cmple(bounds.max + 0.01).all(), "{probe:?}");
            for (name, corners) in triangles(scene) {
                let corners = corners.map(|v| Vec3::from(v.position));
                assert!(!is_near(probe.position, corners, 0.25), "{} {}: {name} there", scene.name, probe.name);
            }
        }
    }
}

/// Returns lengths of an area light's shape: distances of its points, and its radius or half lengths.
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
        let mut lengths_m: Vec<f32> = scene.area_lights.iter().flat_map(|light| lengths(&light.shape)).collect();
        let probe = |probe: &Probe| [probe.position, probe.bounds.min, probe.bounds.max].map(Vec3::length);
        lengths_m.extend(scene.probes.iter().flat_map(probe));
        let impostor = |impostor: &Impostor| [impostor.centre, impostor.half_u, impostor.half_v].map(Vec3::length);
        lengths_m.extend(scene.impostors.iter().flat_map(impostor));
        lengths_m
    };
    let before = built("street");
    let mut scaled = before.clone();
    scaled.scale(2.5);
    assert!(before.area_lights.len() >= 2 && before.impostors.len() >= 5);
    for (old, new) in sizes(before).into_iter().zip(sizes(&scaled)) {
        assert!((new - 2.5 * old).abs() < 1e-3, "{old} became {new}");
    }
}

#[test]
fn spheres_capsules_and_rectangles_shine_in_the_built_in_scenes() {
    let shapes: Vec<AreaShape> = SCENES.iter().flat_map(|scene| &scene.area_lights).map(|light| light.shape).collect();
    assert!(shapes.iter().any(|shape| matches!(shape, AreaShape::Sphere { .. })));
    assert!(shapes.iter().any(|shape| matches!(shape, AreaShape::Capsule { .. })));
    assert!(shapes.iter().any(|shape| matches!(shape, AreaShape::Rectangle { .. })));
    // The lamps of the corridor's ceiling shine down.
    for light in &built("corridor").area_lights {
        let AreaShape::Rectangle { half_u, half_v, .. } = light.shape else { panic!("{light:?}") };
        assert!(half_u.cross(half_v).normalize().abs_diff_eq(Vec3::NEG_Y, 1e-5), "{light:?}");
    }
}

#[test]
fn the_road_is_wet_in_places() {
    let street = built("street");
    let road = street.materials.iter().find(|material| material.name == "road").expect("a road");
    let map = &street.textures[road.reflectivity_map.expect("a map of its reflectivity")];
    // The share of the texels whose red is at least `least`.
    let share =
        |least: u8| map.rgba.chunks(4).filter(|texel| texel[0] >= least).count() as f32 / (map.rgba.len() / 4) as f32;
    assert!((0.05..0.4).contains(&share(200)), "puddles: {}", share(200));
    assert!(share(40) > 0.99, "damp everywhere: {}", share(40));
}

#[test]
fn views_and_reflectivities_are_those_of_the_thesis() {
    let rooms = built("rooms");
    let names: Vec<_> = rooms.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names, ["cylinder", "window-floor", "corridor", "two-cylinders", "window", "ceiling"]);
    assert!(rooms.materials.iter().all(|material| material.roughness == 0.0));
    let reflects = |material: &Material| material.surface == Surface::Sky || material.reflectivity == 1.0;
    assert!(rooms.materials.iter().all(reflects));

    let atrium = built("atrium");
    let reflecting = |view: &str| -> Vec<String> {
        let view = atrium.view(view).expect("a view");
        let materials = atrium.materials_in(view).into_iter();
        materials.filter(|material| material.reflectivity > 0.0).map(|material| material.name).collect()
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
        for (mesh, other) in a.meshes.iter().zip(&b.meshes) {
            assert!(mesh.vertices == other.vertices && mesh.indices == other.indices, "{name}: {}", mesh.name);
        }
        assert_eq!((&a.materials, &a.lights, &a.views), (&b.materials, &b.lights, &b.views), "{name}");
        assert_eq!((&a.probes, &a.impostors, &a.area_lights), (&b.probes, &b.impostors, &b.area_lights), "{name}");
    }
}

#[test]
fn the_floor_of_the_rooms_is_found() {
    let groups = coplanar_groups(built("rooms"));
    let floor = groups.iter().find(|group| group.plane.y > 0.999).expect("a floor");
    assert!(floor.area_m2 > 40.0, "{} m²", floor.area_m2);
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
