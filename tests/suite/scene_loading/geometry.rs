//! Tests faces, normals, tangents, winding and groups of OBJ files, and the default view.

use super::*;
use ssct_scenes::Light;

/// A square and a concave polygon are cut into triangles of the same area in all.
#[test]
fn polygons_are_triangulated() {
    let scene = square("f 1 2 3 4\n").scene();
    assert_eq!((scene.triangle_count(), area(&scene)), (2, 1.0));
    let concave = Folder::new(&[("a.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n")]).scene();
    assert_eq!((concave.triangle_count(), area(&concave)), (3, 10.0));
    assert_sound(&concave);
}

/// Points, lines and triangles without area are left out with a warning each, and the other triangles are drawn. A
/// triangle without area has no normal.
#[test]
fn points_lines_and_triangles_without_area_are_left_out() {
    let folder = square("f 1\nl 1 2\np 1\nf 1 2\nf 1 2 2\nv 2 0 0\nf 1 2 5\nf 1 2 3\n");
    let scene = folder.scene();
    assert_eq!(scene.triangle_count(), 1);
    let warnings = ["a.obj:10: lines and points are not drawn", "a.obj: 2 triangles without area were left out"];
    assert_eq!(folder.warnings(&scene), warnings);
}

/// Negative indices count back from the last vertex before the face. A face may also name a vertex that follows it in
/// the file.
#[test]
fn negative_indices_count_from_the_end_and_later_vertices_may_be_named() {
    let scene = square("f -4/-4 -3/-3 -2/-2\nf 1 2 5\nv 0 -1 0\n").scene();
    assert_eq!(scene.triangle_count(), 2);
    assert_eq!(scene.bounds().min.y, -1.0);
    assert_eq!(scene.meshes[0].vertices[2].uv, [1.0, 0.0]);
}

/// Vertices with a weight or a colour, texture coordinates of one number, lines that a backslash continues, and the
/// line ends of Windows and old Macs are read.
#[test]
fn weights_colours_short_texture_coordinates_and_continued_lines_are_read() {
    let text = "v 0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\r\nv 1 1 \\\r\n 0 2\r\nvt 0.25\r\nf 1/1 2/1 \\\r\n3/1 # end\r\n";
    let scene = Folder::new(&[("a.obj", text)]).scene();
    assert_eq!((scene.triangle_count(), area(&scene)), (1, 0.5));
    assert_eq!(scene.meshes[0].vertices[0].uv, [0.25, 1.0]);
    let old_mac = Folder::new(&[("a.obj", "v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r")]).scene();
    assert_eq!(old_mac.triangle_count(), 1);
}

/// A backslash at the end of a comment does not continue it: paths of Windows end so, and the next face would be lost.
#[test]
fn a_comment_that_ends_in_a_backslash_ends_there() {
    assert_eq!(square("# C:\\models\\\nf 1 2 3\n").scene().triangle_count(), 1);
}

/// Texture coordinates of OBJ count from the lower left, and those of the program from the upper left, as textures'
/// rows do.
#[test]
fn texture_coordinates_start_at_the_top_left() {
    let scene = square("f 1/1 2/2 3/3 4/4\n").scene();
    for vertex in &scene.meshes[0].vertices {
        assert_eq!(vertex.uv, [vertex.position[0], 1.0 - vertex.position[1]]);
    }
}

/// A right-handed file is mirrored in z: positions and normals change sign, and the front stays the front.
#[test]
fn right_handed_files_are_mirrored_with_their_winding() {
    let folder = square("vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\n");
    let scene = folder.load("a.obj", &ObjOptions { load: scaled(2.0), ..ObjOptions::default() }).unwrap();
    assert_sound(&scene);
    assert!(scene.meshes[0].vertices.iter().all(|v| (normal(v) + Vec3::Z).length() < 1e-6));
    assert_eq!(scene.bounds().max, Vec3::new(2.0, 2.0, 0.0));
    let behind = Folder::new(&[("a.obj", "v 0 0 3\nv 1 0 3\nv 0 1 4\nf 1 2 3\n")]);
    let right = behind.load("a.obj", &ObjOptions::default()).unwrap();
    assert_eq!((right.bounds().min.z, right.bounds().max.z), (-4.0, -3.0));
    let left = behind.scene();
    assert_eq!((left.bounds().min.z, left.bounds().max.z), (3.0, 4.0));
    assert!(normal(&left.meshes[0].vertices[0]).z > 0.0 && normal(&right.meshes[0].vertices[0]).z < 0.0);
}

/// A face whose corners run against its stated normal is turned, and the normal stays.
#[test]
fn the_winding_follows_the_stated_normals() {
    let scene = square("vn 0 0 -5\nf 1//1 2//1 3//1 4//1\n").scene();
    assert_sound(&scene);
    assert_eq!(scene.meshes[0].vertices[0].normal, [0.0, 0.0, -1.0]);
}

/// A normal that leans 8 degrees behind its face, as smooth normals do at a silhouette, is kept, and so is the order of
/// the corners.
#[test]
fn normals_that_lean_behind_their_face_stay_as_they_are() {
    let scene = square("vn 0 0.99 -0.14\nf 1//1 2//1 3//1\n").scene();
    assert_sound(&scene);
    let [a, b, c] = triangles(&scene.meshes[0]).next().unwrap();
    assert!((position(&b) - position(&a)).cross(position(&c) - position(&a)).z > 0.0, "the winding stays");
    assert!((normal(&a) - Vec3::new(0.0, 0.99, -0.14).normalize()).length() < 1e-6);
}

/// Faces of two squares at a right angle along the edge x = 1: that of `SQUARE`, and one of two further vertices.
const FOLD: &str = "v 1 0 -1\nv 1 1 -1\nf 1 2 3 4\nf 2 5 6 3\n";

/// Two squares at a right angle without normals have the normals of their faces, for every way to turn smoothing off.
#[test]
fn without_smoothing_groups_missing_normals_are_flat() {
    for switch in ["", "s off\n", "s 0\n", "s null\n", "s off # none\n"] {
        let scene = square(&format!("{switch}{FOLD}")).scene();
        assert_eq!(scene.meshes[0].vertices.len(), 8, "{switch:?}");
        for vertex in &scene.meshes[0].vertices {
            assert!([Vec3::X, Vec3::Z].contains(&normal(vertex)), "{vertex:?}");
        }
    }
}

/// In one smoothing group, the normal at the common edge of two squares is the bisector; two groups keep the edge.
#[test]
fn in_a_smoothing_group_missing_normals_are_means() {
    let scene = square(&format!("s 1\n{FOLD}")).scene();
    assert_eq!(scene.meshes[0].vertices.len(), 6);
    let edge_vertex = scene.meshes[0].vertices.iter().find(|v| v.position == [1.0, 0.0, 0.0]).unwrap();
    assert_sound(&scene);
    // Both squares have a right angle here, however they are cut: the mean is the bisector.
    assert!((normal(edge_vertex) - Vec3::new(0.5_f32.sqrt(), 0.0, 0.5_f32.sqrt())).length() < 1e-6);
    // Only the first word counts, and `on` is a group.
    for group in ["s 1 # one", "s on"] {
        assert_eq!(square(&format!("{group}\n{FOLD}")).scene().meshes[0].vertices.len(), 6, "{group}");
    }
    // In two groups, the edge between the squares stays sharp.
    let two = square("v 1 0 -1\nv 1 1 -1\ns 1\nf 1 2 3 4\ns 2\nf 2 5 6 3\n").scene();
    assert_eq!(two.meshes[0].vertices.len(), 8);
}

/// Vertices that repeat a position are smoothed as one. In a face where only some corners have normals, or one has the
/// length 0, the others get the normal of the face.
#[test]
fn smoothing_is_by_position_and_some_corners_may_lack_normals() {
    let twice = "v 1 0 0\nv 1 1 0\nv 1 0 -1\nv 1 1 -1\ns 1\nf 1 2 3 4\nf 5 7 8 6\n";
    let scene = square(twice).scene();
    assert_eq!(scene.meshes[0].vertices.len(), 6, "vertices that repeat a position are welded");
    let mixed = square("vn 0 0.6 0.8\nvn 0 0 0\nf 1//1 2 3//2\n").scene();
    assert_sound(&mixed);
    let normals: Vec<_> = mixed.meshes[0].vertices.iter().map(normal).collect();
    assert!((normals[0] - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
    assert_eq!(normals[1..], [Vec3::Z, Vec3::Z]);
}

/// If some corners lack texture coordinates, those corners get (0, 0), and the coordinates of all others stay with
/// their corners. The two lists have different lengths then.
#[test]
fn corners_without_texture_coordinates_do_not_shift_the_others() {
    let scene = square("f 1 2/2 3/3\nf 1/3 3/3 4\n").scene();
    let uv_at = |p: [f32; 3]| scene.meshes[0].vertices.iter().filter(move |v| v.position == p).map(|v| v.uv);
    assert!(uv_at([1.0, 1.0, 0.0]).all(|uv| uv == [1.0, 0.0]));
    assert!(uv_at([1.0, 0.0, 0.0]).all(|uv| uv == [1.0, 1.0]));
    assert_eq!(uv_at([0.0; 3]).collect::<Vec<_>>(), [[0.0, 0.0], [1.0, 0.0]]);
    assert_sound(&scene);
}

/// For plain, mirrored and turned texture coordinates in files of both handednesses, tangent and bitangent are the
/// directions in which u and −v grow. A wrong sign turns bumps into dents.
#[test]
fn tangents_run_along_u_and_bitangents_up_in_the_image() {
    let mirrored = "f 2/1 1/2 4/3 3/4\n";
    let turned = "f 1/2 2/3 3/4 4/1\n";
    for (face, handedness) in [
        ("f 1/1 2/2 3/3 4/4\n", Handedness::Left),
        (mirrored, Handedness::Left),
        (turned, Handedness::Left),
        ("f 1/1 2/2 3/3 4/4\n", Handedness::Right),
        (mirrored, Handedness::Right),
    ] {
        let scene = square(face).load("a.obj", &ObjOptions { handedness, ..LEFT }).unwrap();
        assert_sound(&scene);
        for [a, b, c] in triangles(&scene.meshes[0]) {
            // Solve the edges for the directions in which u and −v grow.
            let (to_b, to_c) = (position(&b) - position(&a), position(&c) - position(&a));
            let uv = |v: Vertex| Vec2::new(v.uv[0] - a.uv[0], a.uv[1] - v.uv[1]);
            let (uv_b, uv_c) = (uv(b), uv(c));
            let along_u = (to_b * uv_c.y - to_c * uv_b.y) / uv_b.perp_dot(uv_c);
            let up = (to_c * uv_b.x - to_b * uv_c.x) / uv_b.perp_dot(uv_c);
            for vertex in [a, b, c] {
                let tangent = Vec3::from_slice(&vertex.tangent[..3]);
                let bitangent = vertex.tangent[3] * normal(&vertex).cross(tangent);
                assert!((tangent - along_u).length() < 1e-5, "{face} {handedness:?}");
                assert!((bitangent - up).length() < 1e-5, "{face} {handedness:?}");
            }
        }
    }
}

/// Each group of an OBJ file gives a mesh for each of its materials, and a material of one name is one material in all
/// groups.
#[test]
fn a_mesh_is_a_group_of_one_material() {
    let text = "g left\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\ng right\nusemtl red\nf 2 3 4\n";
    let scene = square(text).scene();
    let meshes: Vec<_> = scene.meshes.iter().map(|m| (m.name.as_str(), m.material)).collect();
    assert_eq!(meshes, [("left", 0), ("left", 1), ("right", 0)]);
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["red", "blue"]);
}

/// Makes a folder with a grid of n × n squares in the xz plane, each in a group of its own if `groups` is true.
fn grid(n: usize, groups: bool) -> Folder {
    use std::fmt::Write;
    let mut text = String::new();
    for i in 0..=n {
        for j in 0..=n {
            writeln!(text, "v {i} 0 {j}").unwrap();
        }
    }
    for i in 0..n {
        for j in 0..n {
            let corner = i * (n + 1) + j + 1;
            if groups {
                writeln!(text, "g {i}-{j}").unwrap();
            }
            writeln!(text, "f {corner} {} {} {}", corner + 1, corner + n + 2, corner + n + 1).unwrap();
        }
    }
    Folder::new(&[("a.obj", &text)])
}

/// A mesh of 20 000 triangles becomes four meshes, each of a part of the plane, so that a camera draws what it sees.
/// 2500 groups of one square become one mesh, since each mesh costs a draw; 100 such groups stay apart.
#[test]
fn large_meshes_are_split_in_space_and_tiny_groups_are_pooled() {
    let scene = grid(100, false).scene();
    assert_eq!((scene.triangle_count(), scene.meshes.len()), (20_000, 4));
    for mesh in &scene.meshes {
        let extent = mesh.bounds.max - mesh.bounds.min;
        assert!(extent.x * extent.z < 3000.0, "a quarter of the grid is 2500 m²: {extent}");
    }
    let pooled = grid(50, true).scene();
    assert_eq!((pooled.triangle_count(), pooled.meshes.len()), (5_000, 1));
    assert_eq!(grid(10, true).scene().meshes.len(), 100);
}

/// Two OBJ files become one scene with the name of the first. Each file keeps its kind of surface, although both name a
/// material `glass`.
#[test]
fn several_files_are_one_scene_with_their_own_surfaces() {
    let folder = square("usemtl glass\nf 1 2 3\n");
    folder.write("b.obj", format!("{SQUARE}usemtl glass\nf 1 3 4\n").as_bytes());
    let files = [
        ObjFile::from(folder.path("a.obj")),
        ObjFile { path: folder.path("b.obj"), surface: ssct_scenes::Surface::Sky },
    ];
    let scene = obj::load(&files, &LEFT).unwrap();
    assert_eq!((scene.name.as_str(), scene.triangle_count(), scene.materials.len()), ("a", 2, 2));
    let surfaces: Vec<_> = scene.meshes.iter().map(|m| scene.materials[m.material].surface).collect();
    assert_eq!(surfaces, [ssct_scenes::Surface::Lit, ssct_scenes::Surface::Sky]);
}

/// An axis-aligned box of half-extents (3, 1, 2), facing outwards.
const BOX: &str = "v -3 -1 -2\nv 3 -1 -2\nv 3 1 -2\nv -3 1 -2\nv -3 -1 2\nv 3 -1 2\nv 3 1 2\nv -3 1 2\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

/// A box seen from outside is viewed from in front of it. With its faces turned round, the box is a room, and the view
/// stands inside.
#[test]
fn the_default_view_stands_outside_of_things_and_inside_of_rooms() {
    let folder = Folder::new(&[("a.obj", BOX)]);
    let thing = folder.scene();
    let view = &thing.views[0];
    assert_eq!((view.name.as_str(), view.look_at), ("default", Vec3::ZERO));
    assert!(
        view.eye.z < -2.0 && view.eye.length() * (0.5 * thing.lens.fov_y_radians().unwrap()).sin() >= 14_f32.sqrt()
    );
    // With its faces turned round, the box is a room.
    let room: String = BOX
        .lines()
        .map(|l| match l.strip_prefix("f ") {
            Some(face) => format!("f {}\n", face.split(' ').rev().collect::<Vec<_>>().join(" ")),
            None => format!("{l}\n"),
        })
        .collect();
    let room = Folder::new(&[("a.obj", &room)]).scene();
    let eye = room.views[0].eye;
    assert!(eye.x.abs() < 3.0 && eye.y.abs() < 1.0 && eye.z.abs() < 2.0 && eye.length() > 1.0, "{eye}");
    assert_eq!(room.lights.len(), 1);
    let huge = folder.load("a.obj", &ObjOptions { load: scaled(1000.0), ..LEFT }).unwrap();
    assert!(huge.lens.far_m > huge.views[0].eye.length() + 7000.0);
}

/// Two boxes side by side, with ground and without, are viewed from in front of both. The centre of their bounds is
/// empty, which may pass for the inside of a room.
#[test]
fn the_default_view_sees_things_that_stand_around_an_empty_place() {
    let moved_box = |x: f32, y: f32, first: usize| {
        let corner = |line: &str| {
            let numbers: Vec<f32> = line[2..].split(' ').map(|v| v.parse().unwrap()).collect();
            format!("v {} {} {}\n", numbers[0] / 3.0 + x, numbers[1] + y, numbers[2] / 2.0)
        };
        let face = |line: &str| {
            let indices = line[2..].split(' ').map(|v| (v.parse::<usize>().unwrap() + first).to_string());
            format!("f {}\n", indices.collect::<Vec<_>>().join(" "))
        };
        BOX.lines().map(|line| if line.starts_with('v') { corner(line) } else { face(line) }).collect::<String>()
    };
    let ground = "v -9 -1 -9\nv 9 -1 -9\nv 9 -1 9\nv -9 -1 9\nf 17 20 19 18\n";
    for rest in ["", ground] {
        let text = format!("{}{}{rest}", moved_box(-2.0, 0.0, 0), moved_box(2.0, 0.0, 8));
        let scene = Folder::new(&[("a.obj", &text)]).scene();
        let bounds = scene.bounds();
        let eye = scene.views[0].eye;
        assert!(eye.z < bounds.min.z, "the eye is in front of both, not between them: {eye}");
    }
}

/// Moving or scaling a scene moves or scales every kind of place in it; energies of point lights scale with the square.
/// A new kind of place is easily left out.
#[test]
fn a_scene_scales_and_moves_with_everything_that_has_a_place() {
    let before = with_a_path(crate::common::built_in("street"));
    let (offset, factor) = (Vec3::new(3.0, -5.0, 7.0), 2.0);
    let (mut moved, mut scaled) = (before.clone(), before.clone());
    moved.translate(offset);
    scaled.scale(factor);
    for scene in [&moved, &scaled] {
        assert_eq!(places(scene).len(), places(&before).len());
    }
    assert_eq!(moved.lens, before.lens);
    let planes = |scene: &Scene| [scene.lens.near_m, scene.lens.far_m];
    assert_eq!(planes(&scaled), planes(&before).map(|plane| factor * plane));
    let energies = |scene: &Scene| -> Vec<f32> {
        let point_energy = |light: &Light| if let Light::Point { energy, .. } = light { Some(*energy) } else { None };
        scene.lights.iter().filter_map(point_energy).collect()
    };
    assert_eq!(energies(&scaled), energies(&before).iter().map(|e| factor * factor * e).collect::<Vec<_>>());
    for ((old, moved_place), scaled_place) in places(&before).into_iter().zip(places(&moved)).zip(places(&scaled)) {
        assert!(moved_place.distance(old + offset) < 1e-4, "{old} became {moved_place}");
        assert!(scaled_place.distance(factor * old) < 1e-4, "{old} became {scaled_place}");
    }
    // Places of a path between its key frames are moved and scaled, too.
    for share in [0.0, 0.3, 0.5, 0.9] {
        let [old, moved_place, scaled_place] = [&before, &moved, &scaled].map(|s| s.paths[0].eye_and_look_at(share).0);
        assert!(moved_place.distance(old + offset) < 1e-4 && scaled_place.distance(factor * old) < 1e-4, "{share}");
    }
}

/// Returns the scene with a path, a point light and a capture, so that no kind of place is missing.
fn with_a_path(mut scene: Scene) -> Scene {
    let path = ssct_scenes::CameraPath::through_views(&scene).unwrap();
    scene.paths.push(path);
    scene.lights.push(Light::Point { position: Vec3::ONE, energy: 1.0 });
    scene.captures.push(ssct_scenes::Capture::placed_at(Vec3::new(1.0, 2.0, 3.0)));
    scene
}

/// Returns every point of a scene, kind by kind. Panics if a kind has none.
fn places(scene: &Scene) -> Vec<Vec3> {
    use ssct_scenes::AreaShape;
    let vertices = scene.meshes.iter().flat_map(|m| m.vertices.iter().map(|v| Vec3::from(v.position)));
    let bounds = scene.meshes.iter().flat_map(|m| [m.bounds.min, m.bounds.max]);
    let views = scene.views.iter().flat_map(|v| [v.eye, v.look_at]);
    let keys = scene.paths.iter().flat_map(|p| p.keys().iter().flat_map(|k| [k.eye, k.look_at]));
    let lights = scene.lights.iter().filter_map(|l| match l {
        Light::Point { position, .. } => Some(*position),
        Light::Directional { .. } => None,
    });
    let probes = scene.probes.iter().flat_map(|p| [p.position, p.bounds.min, p.bounds.max]);
    let impostors = scene.impostors.iter().map(|i| i.centre);
    let area_lights = scene.area_lights.iter().map(|l| match l.shape {
        AreaShape::Sphere { centre, .. } | AreaShape::Rectangle { centre, .. } | AreaShape::Cuboid { centre, .. } => {
            centre
        }
        AreaShape::Capsule { a, .. } | AreaShape::Cylinder { a, .. } => a,
    });
    let captures = scene.captures.iter().map(|c| c.position);
    let kinds: [Vec<Vec3>; 9] = [
        vertices.collect(),
        bounds.collect(),
        views.collect(),
        keys.collect(),
        lights.collect(),
        probes.collect(),
        impostors.collect(),
        area_lights.collect(),
        captures.collect(),
    ];
    assert!(kinds.iter().all(|places| !places.is_empty()));
    kinds.concat()
}
