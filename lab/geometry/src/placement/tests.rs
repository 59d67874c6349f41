//! Tests of places in rooms of walls, and in the built-in scenes.

use super::*;
use ssct_ground::scene::{Aabb, Material, Mesh, Surface, Vertex, View};

/// Makes the six sides of a box. With `inwards` the sides have their fronts on the inside, like the walls of a room;
/// otherwise they face outwards.
fn cuboid(min: Vec3, max: Vec3, inwards: bool) -> Mesh {
    // Bits 0, 1 and 2 of a corner's number choose between the least and the greatest x, y and z.
    let corner = |number: usize| {
        Vec3::new([min.x, max.x][number & 1], [min.y, max.y][number >> 1 & 1], [min.z, max.z][number >> 2])
    };
    let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let mut mesh = Mesh { name: "box".into(), ..Mesh::default() };
    for quad in quads {
        let [a, b, c, _] = quad.map(corner);
        let middle = 0.5 * (min + max);
        let normal = (b - a).cross(c - a).normalize();
        let must_turn = (normal.dot(a - middle) > 0.0) == inwards;
        let facing = if must_turn { -normal } else { normal };
        let first_vertex = mesh.vertices.len() as u32;
        let vertex = |number| Vertex {
            position: corner(number).to_array(),
            normal: facing.to_array(),
            uv: [0.0; 2],
            tangent: facing.any_orthonormal_vector().extend(1.0).to_array(),
        };
        mesh.vertices.extend(quad.map(vertex));
        let order = if must_turn { [0, 2, 1, 0, 3, 2] } else { [0, 1, 2, 0, 2, 3] };
        mesh.indices.extend(order.map(|index| first_vertex + index));
    }
    mesh.bounds = Aabb::around(&mesh.vertices);
    mesh
}

/// Makes a scene of meshes with one default material.
fn scene(meshes: Vec<Mesh>) -> Scene {
    Scene { meshes, materials: vec![Material::default()], ..Scene::default() }
}

/// Makes a room of 8×3×6 m with a wall across it that leaves a door of 1 m, inside a shell 0.5 m thick with a flat
/// roof.
fn two_rooms() -> Scene {
    scene(vec![
        cuboid(Vec3::ZERO, Vec3::new(8.0, 3.0, 6.0), true),
        cuboid(Vec3::new(3.9, 0.0, 0.0), Vec3::new(4.1, 3.0, 5.0), false),
        cuboid(Vec3::splat(-0.5), Vec3::new(8.5, 3.5, 6.5), false),
    ])
}

/// The positions of the captures.
fn positions(placement: &Placement) -> Vec<Vec3> {
    placement.captures.iter().map(|c| c.position).collect()
}

/// Two captures stand in one room each, and together they see over 85 % of what mirrors show.
#[test]
fn two_rooms_get_captures_on_both_sides_of_the_wall() {
    let placement = place(&two_rooms(), WantedCaptures::Count(2));
    let places = positions(&placement);
    let is_inside =
        |place: &Vec3| place.cmpgt(Vec3::splat(0.25)).all() && place.cmplt(Vec3::new(7.75, 2.75, 5.75)).all();
    assert!(places.len() == 2 && places.iter().all(is_inside), "{places:?}");
    assert!((places[0].x < 4.0) != (places[1].x < 4.0), "{places:?}");
    assert!(placement.seen[0] < placement.seen[1] && placement.seen[1] > 0.85, "{:?}", placement.seen);
    let is_off_roof = |eye: &Vec3| is_inside(&eye.with_y(1.5)) || eye.y < 3.0;
    assert!(placement.stands.iter().all(is_off_roof), "nobody on the roof");
}

#[test]
fn nobody_stands_on_a_roof_in_a_solid_body_or_in_a_dark_void() {
    // Beside the rooms stands a larger closed chamber without light. The rooms get a window, a box that shows the sky.
    let mut scene = two_rooms();
    scene.meshes.push(cuboid(Vec3::new(20.0, 0.0, 0.0), Vec3::new(40.0, 3.0, 20.0), true));
    scene.meshes.push(cuboid(Vec3::new(2.0, 1.0, 5.9), Vec3::new(3.0, 2.0, 6.0), false));
    scene.meshes.last_mut().unwrap().material = 1;
    scene.materials.push(Material { surface: Surface::Sky, ..Material::default() });
    let placement = place(&scene, WantedCaptures::Count(1));
    assert!(placement.stands.len() > 20);
    for stand in &placement.stands {
        assert!(stand.x > 0.0 && stand.x < 8.0 && stand.y == 1.5, "{stand}");
        assert!(!(3.9..4.1).contains(&stand.x) || stand.z > 5.0, "{stand}");
    }
}

#[test]
fn views_and_threads_have_no_influence() {
    let scene = two_rooms();
    let placement = place(&scene, WantedCaptures::Count(3));
    let mut scene_with_view = scene.clone();
    scene_with_view.views.push(View { eye: Vec3::new(1.0, 1.0, 1.0), look_at: Vec3::ONE * 2.0, ..View::default() });
    assert_eq!(place(&scene_with_view, WantedCaptures::Count(3)), placement);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| place(&scene, WantedCaptures::Count(3))), placement);
    // More captures are only added after the first ones, which stay the same.
    let with_one_capture = place(&scene, WantedCaptures::Count(1));
    assert_eq!((with_one_capture.captures[0], with_one_capture.seen[0]), (placement.captures[0], placement.seen[0]));
}

/// `Auto` places one capture in an empty room, and two to [`AUTO_MOST`] in two rooms.
#[test]
fn auto_stops_where_another_capture_gains_little() {
    // An empty room is completely visible from anywhere in it.
    let placement = place(&scene(vec![cuboid(Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0), true)]), WantedCaptures::Auto);
    assert_eq!((placement.captures.len(), placement.from_file), (1, 0));
    assert!(placement.seen[0] > 0.999, "{:?}", placement.seen);
    let placement = place(&two_rooms(), WantedCaptures::Auto);
    assert!((2..=AUTO_MOST).contains(&placement.captures.len()), "{:?}", placement.seen);
}

/// Captures of the file come first. Further ones have the resolution and the near plane of the first of them.
#[test]
fn the_captures_of_a_file_come_first() {
    let mut scene = two_rooms();
    let captures_of_file =
        [1.0, 7.0].map(|x| Capture { resolution: 64, near_m: 0.1, ..Capture::placed_at(Vec3::new(x, 1.0, 3.0)) });
    scene.captures = captures_of_file.to_vec();
    let auto = place(&scene, WantedCaptures::Auto);
    assert_eq!((auto.captures.as_slice(), auto.from_file), (&captures_of_file[..], 2));
    assert!(auto.seen[0] > 0.2 && auto.seen[1] > auto.seen[0]);
    let with_one = place(&scene, WantedCaptures::Count(1));
    assert_eq!((with_one.captures.as_slice(), with_one.from_file), (&captures_of_file[..1], 1));
    let with_three = with_captures(&mut scene, WantedCaptures::Count(3));
    assert_eq!((with_three.from_file, with_three.captures.len(), &with_three.captures), (2, 3, &scene.captures));
    assert_eq!((with_three.captures[2].resolution, with_three.captures[2].near_m), (64, 0.1), "as the file's first");
}

/// A room of 30 cm gets a capture, an empty scene gets none, and at most [`MAX_CAPTURES`] are placed.
#[test]
fn a_small_scene_gets_small_people_and_an_empty_one_nobody() {
    let tiny = place(&scene(vec![cuboid(Vec3::ZERO, Vec3::splat(0.3), true)]), WantedCaptures::Auto);
    let [capture] = tiny.captures[..] else { panic!("{:?}", tiny.captures) };
    assert!(capture.position.cmpgt(Vec3::ZERO).all() && capture.position.cmplt(Vec3::splat(0.3)).all());
    assert_eq!(place(&Scene::default(), WantedCaptures::Count(4)), Placement::default());
    assert_eq!(place(&two_rooms(), WantedCaptures::Count(99)).captures.len().min(MAX_CAPTURES + 1), MAX_CAPTURES);
}
