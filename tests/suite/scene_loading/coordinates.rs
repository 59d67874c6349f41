//! Tests the coordinates of the places in a scene file. They are those of its files, right-handed as in OBJ and glTF,
//! unless the scene file says otherwise. Wrong coordinates often cause views that see next to nothing, whose warnings
//! are tested, too.

use super::*;
use crate::common::repository;
use ssct_scenes::{AreaShape, Light, scene_file};

/// A scene file with everything that has a place or a direction.
const PLACES: &str = "[[mesh]]\nfile = 'a.obj'\n[[light]]\nkind = 'point'\nposition = [1, 2, 3]\nenergy = 1\n[[light]]\n\
    kind = 'directional'\ndirection = [0, 0, -2]\nenergy = 1\n[view.v]\neye = [0, 1, 5]\nlook_at = [0, 0, -1]\n\
    [[path.p.key]]\neye = [0, 1, 5]\nlook_at = [0, 0, -1]\n[[path.p.key]]\neye = [0, 1, 6]\nlook_at = [0, 0, -2]\n\
    [[probe]]\nname = 'p'\nposition = [0, 1, 2]\nmin = [-1, 0, 1]\nmax = [1, 2, 4]\n[[impostor]]\nfile = 'sign.png'\n\
    centre = [0, 2, 1]\nhalf_u = [0, 0, 1]\nhalf_v = [0, -1, 0]\n[[area_light]]\nkind = 'rectangle'\nradiance = [1, 1, 1]\n\
    centre = [0, 3, 4]\nhalf_u = [1, 0, 0]\nhalf_v = [0, 0, 2]\n[[area_light]]\nkind = 'capsule'\nradiance = [1, 1, 1]\n\
    a = [0, 1, 2]\nb = [0, 1, 3]\nradius = 1\n[[capture]]\nplace = [0, 1, 2]\n[motion.turn]\nmesh = 'a'\npivot = [0, 0, 1]\n\
    [[motion.turn.key]]\ntime = 0\n[[motion.turn.key]]\ntime = 1\noffset = [0, 0, 2]\nturn_deg = 90\n";

/// Loads a scene file that begins with the lines `first`, in a folder with a square `a.obj` that is named `a`.
fn placed(first: &str, rest: &str) -> Scene {
    let folder = square("o a\nf 1 2 3\nf 1 3 4\n");
    folder.image("sign.png", 4, 2, |_, _| [200, 0, 0, 255]);
    folder.write("a.scene.toml", format!("{first}{rest}").as_bytes());
    scene_file::load(&folder.path("a.scene.toml"), &LoadOptions::default()).unwrap()
}

/// Places are mirrored in z for right-handed files and kept for left-handed ones; `coordinates` overrides `handedness`.
/// Every kind of place is checked, since a forgotten one would lie behind the scene.
#[test]
fn places_are_in_the_coordinates_of_the_files_unless_a_file_says_otherwise() {
    let right = placed("", PLACES);
    let left = placed("coordinates = 'left'\n", PLACES);
    let mirror = |v: Vec3| v * Vec3::new(1.0, 1.0, -1.0);
    for same in [placed("coordinates = 'right'\n", PLACES), placed("handedness = 'right'\n", PLACES)] {
        assert_eq!((&same.views, &same.lights, &same.captures), (&right.views, &right.lights, &right.captures));
    }
    // A scene file with left-handed meshes has left-handed places, too.
    assert_eq!(placed("handedness = 'left'\n", PLACES).views, left.views);
    assert_eq!(placed("handedness = 'left'\ncoordinates = 'right'\n", PLACES).views, right.views);
    let written = &left.views[0];
    assert_eq!((written.eye, written.look_at), (Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 0.0, -1.0)));
    assert_eq!((right.views[0].eye, right.views[0].look_at), (mirror(written.eye), mirror(written.look_at)));
    assert_eq!(right.paths[0].keys()[1].eye, mirror(left.paths[0].keys()[1].eye));
    let Light::Point { position, .. } = right.lights[0] else { panic!("a point light") };
    let Light::Directional { direction, .. } = right.lights[1] else { panic!("a directional light") };
    assert_eq!((position, direction), (Vec3::new(1.0, 2.0, -3.0), Vec3::Z));
    let bounds = right.probes[0].bounds;
    assert_eq!(right.probes[0].position, Vec3::new(0.0, 1.0, -2.0));
    assert_eq!((bounds.min, bounds.max), (Vec3::new(-1.0, 0.0, -4.0), Vec3::new(1.0, 2.0, -1.0)));
    assert_eq!((right.impostors[0].centre, right.impostors[0].half_u), (Vec3::new(0.0, 2.0, -1.0), Vec3::NEG_Z));
    assert_eq!(right.captures[0].position, Vec3::new(0.0, 1.0, -2.0));
    let AreaShape::Capsule { a, b, .. } = right.area_lights[1].shape else { panic!("a capsule") };
    assert_eq!((a, b), (Vec3::new(0.0, 1.0, -2.0), Vec3::new(0.0, 1.0, -3.0)));
    // The light shines down, to the side of half_u × half_v, in the file and in the scene.
    for scene in [&left, &right] {
        let AreaShape::Rectangle { half_u, half_v, .. } = scene.area_lights[0].shape else { panic!("a rectangle") };
        assert!(half_u.cross(half_v).y < 0.0, "{half_u} {half_v}");
    }
}

/// A turn and an offset of a motion have the direction of the file's coordinates, right-handed and left-handed.
/// Mirroring reverses the direction of a turn.
#[test]
fn a_motion_turns_as_its_coordinates_do() {
    // In a file of either handedness, a quarter turn about +y takes +x to −z, about a pivot at z = 1. Then everything
    // moves by 2 along z.
    let corner = |scene: &Scene, z: f32| {
        let (_, placement) = scene.motions[0].placements_at(1.0).next().unwrap();
        placement.place(Vec3::new(1.0, 0.0, z))
    };
    let right = corner(&placed("", PLACES), -1.0);
    assert!(right.distance(Vec3::new(0.0, 0.0, -2.0)) < 1e-5, "z = 1 − 1 + 2 in the file: {right}");
    let left = corner(&placed("coordinates = 'left'\n", PLACES), 1.0);
    assert!(left.distance(Vec3::new(0.0, 0.0, 2.0)) < 1e-5, "{left}");
}

/// A view in front of the square, in the coordinates of its file, sees the front of the square, for OBJ and for glTF.
#[test]
fn a_view_in_front_of_an_obj_and_of_a_gltf_file_sees_its_front() {
    let view = "[view.v]\neye = [0.5, 0.5, 3]\nlook_at = [0.5, 0.5, 0]\n";
    // The square faces +z of its file.
    for file in ["a.obj", "b.gltf"] {
        let folder = square("f 1 2 3\nf 1 3 4\n");
        let document = super::gltf::Square::new().document(serde_json::json!({}));
        folder.write("b.gltf", document.to_string().as_bytes());
        folder.write("a.scene.toml", format!("[[mesh]]\nfile = '{file}'\n{view}").as_bytes());
        let scene = scene_file::load(&folder.path("a.scene.toml"), &LoadOptions::default()).unwrap();
        let vertex = &scene.meshes[0].vertices[0];
        let seen = (scene.views[0].eye - position(vertex)).dot(normal(vertex));
        assert!(seen > 0.0, "{file}: {seen}");
    }
}

/// Loads the example `two-rooms` with some lines before its scene file and others after it. Returns the folder and the
/// scene.
fn two_rooms(first: &str, last: &str) -> (Folder, Scene) {
    let folder = Folder::new(&[]);
    let example = repository().join("examples/scene");
    for name in ["two-rooms.obj", "two-rooms.mtl"] {
        folder.write(name, &std::fs::read(example.join(name)).unwrap());
    }
    let text = std::fs::read_to_string(example.join("two-rooms.scene.toml")).unwrap();
    folder.write("two-rooms.scene.toml", format!("{first}{text}{last}").as_bytes());
    let scene = scene_file::load(&folder.path("two-rooms.scene.toml"), &LoadOptions::default()).unwrap();
    (folder, scene)
}

/// The example of a scene file loads without a warning. With the wrong coordinates, a view outside of the room gets
/// one, which tells a user what is wrong.
#[test]
fn the_example_loads_without_a_warning_and_places_in_other_coordinates_get_one() {
    let (_, scene) = two_rooms("", "");
    assert_sound(&scene);
    assert!(scene.warnings.is_empty() && scene.notes.is_empty(), "{:?} {:?}", scene.warnings, scene.notes);
    assert_eq!((scene.views.len(), scene.paths.len(), scene.lights.len()), (2, 1, 2));
    let mirrors: Vec<_> = scene.materials.iter().filter(|m| m.reflectivity > 0.0).map(|m| m.name.as_str()).collect();
    assert_eq!(mirrors, ["floor"]);
    let (folder, mirrored) = two_rooms("coordinates = 'left'\n", "");
    let warning = "two-rooms.scene.toml: [view.front] stands outside of the room and sees no front of its walls";
    assert_eq!(folder.warnings(&mirrored), [warning]);
}

/// Views of a wall from 0.5 m, from above the roof, and past the only square each get a warning with the likely cause.
#[test]
fn views_that_see_next_to_nothing_get_a_warning() {
    let hint = "; the file's places are read as right-handed: if they are not, write coordinates = \"left\"";
    let views =
        "[view.wall]\neye = [0, 1.5, 6.5]\nlook_at = [0, 1.5, 7]\n[view.roof]\neye = [0, 9, 0]\nlook_at = [1, 0, 0]\n";
    let (folder, scene) = two_rooms("", views);
    let wall = format!("two-rooms.scene.toml: [view.wall] sees nothing but one flat surface{hint}");
    let roof =
        format!("two-rooms.scene.toml: [view.roof] stands outside of the room and sees no front of its walls{hint}");
    assert_eq!(folder.warnings(&scene), [wall, roof]);
    // One square makes no room, so that a view may look at the square from anywhere. A view past the square gets a
    // warning.
    let near = "[[mesh]]\nfile = 'a.obj'\n[view.near]\neye = [0.5, 0.5, 0.2]\nlook_at = [0.5, 0.5, 0]\n";
    assert!(placed("", near).warnings.is_empty(), "it has no other surface");
    let past = format!("{near}[view.past]\neye = [0, 0, 2]\nlook_at = [0, 0, 5]\n");
    let warnings = placed("coordinates = 'right'\n", &past).warnings;
    assert!(
        matches!(&warnings[..], [only] if only.ends_with("[view.past] sees no surface of the scene")),
        "{warnings:?}"
    );
}

/// A file with `handedness = 'right'` and places gets a note about their coordinates, and a file that says its
/// coordinates does not.
#[test]
fn a_file_that_calls_its_obj_files_right_handed_is_told_what_that_means_for_places() {
    let view = "[view.v]\neye = [0, 0, 3]\nlook_at = [0, 0, 0]\n";
    let mesh = "[[mesh]]\nfile = 'a.obj'\n";
    let notes = |first: &str, rest: &str| placed(first, rest).notes.len();
    assert_eq!(notes("handedness = 'right'\n", &format!("{mesh}{view}")), 1);
    assert_eq!(notes("handedness = 'right'\ncoordinates = 'left'\n", &format!("{mesh}{view}")), 0);
    assert_eq!((notes("", &format!("{mesh}{view}")), notes("handedness = 'right'\n", mesh)), (0, 0));
}

/// The script `left_handed.sh` makes a copy of an old scene file whose places mean the same as before, unless the file
/// already says its coordinates. Old files have left-handed places and no line about them.
#[test]
fn the_script_makes_copies_whose_places_stay_where_they_were() {
    let folder = square("f 1 2 3\nf 1 3 4\n");
    let view = "[view.v]\neye = [0, 0, -3]\nlook_at = [0, 0, 0]\n";
    let loaded_copy = |first: &str| {
        folder.write("old.scene.toml", format!("{first}[[mesh]]\nfile = \"a.obj\"\n{view}").as_bytes());
        let copy = folder.path("elsewhere/copy.scene.toml");
        let script = repository().join("scripts/left_handed.sh");
        let made = std::process::Command::new(script).arg(folder.path("old.scene.toml")).arg(&copy).status();
        assert!(made.unwrap().success());
        scene_file::load(&copy, &LoadOptions::default()).unwrap()
    };
    let copied = loaded_copy("handedness = \"right\"\n");
    assert_eq!((copied.views[0].eye, copied.triangle_count()), (Vec3::new(0.0, 0.0, -3.0), 2));
    assert_eq!(loaded_copy("coordinates = \"right\"\n").views[0].eye, Vec3::new(0.0, 0.0, 3.0));
}

/// A view into an open box, from outside through its missing front, gets no warning.
#[test]
fn a_view_into_a_box_without_a_front_gets_no_warning() {
    let folder = square("");
    let corners = "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nv -1 2 1\nv 1 2 1\nv 1 2 -1\nv -1 2 -1\n";
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 3 2 6 7\n";
    folder.write("box.obj", format!("{corners}{faces}").as_bytes());
    let file = b"[[mesh]]\nfile = 'box.obj'\n[view.front]\neye = [0, 1, 4]\nlook_at = [0, 1, 0]\n";
    folder.write("a.scene.toml", file);
    let scene = scene_file::load(&folder.path("a.scene.toml"), &LoadOptions::default()).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}
