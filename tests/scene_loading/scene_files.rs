//! `NAME.scene.toml`.

use super::*;
use ssct::error::Result;
use ssct::scene::{Lens, Light, Surface, scene_file};

fn folder(text: &str) -> Folder {
    let folder = square("mtllib a.mtl\nusemtl floor\nf 1 2 3\nusemtl wall\nf 1 3 4\n");
    folder.write("a.mtl", b"newmtl floor\nKs 0.5 0.5 0.5\nNs 100\nnewmtl wall\nKs 0.25 0.25 0.25\n");
    folder.write("test.scene.toml", text.as_bytes());
    folder
}

fn load(folder: &Folder, extra_scale: f32) -> Result<Scene> {
    scene_file::load(&folder.path("test.scene.toml"), extra_scale)
}

const FULL: &str = r#"
name = "both"
handedness = "left"
scale = 2

[[mesh]]
file = "a.obj"

[[mesh]]
file = "a.obj"
surface = "sky"

[material.default]
reflectivity = 0.75

[material.floor]
roughness = 0.5
normal_deviation = 0.25

[camera]
fov_y_deg = 90
near = 0.5
far = 50.0

[[light]]
kind = "point"
position = [1, 2, 3]
energy = 4.0

[[light]]
kind = "directional"
direction = [0, -2, 0]
energy = 1

[view.zebra]
eye = [0, 0, -1]
look_at = [0, 0, 1]

[view.ant]
eye = [0, 1, -1]
look_at = [0, 0, 1]
near = 0.25
materials = { wall = { reflectivity = 1 }, default = { roughness = 0.125 } }

[view.mole]
eye = [0, 1, -1]
look_at = [0, 0, 1]

[view.mole.materials.floor]
reflectivity = 0.0
"#;

#[test]
fn every_key_arrives() {
    let scene = load(&folder(FULL), 1.0).unwrap();
    assert_sound(&scene);
    assert_eq!((scene.name.as_str(), scene.triangle_count(), scene.warnings.len()), ("both", 4, 0));
    assert_eq!(scene.bounds().max, Vec3::new(2.0, 2.0, 0.0));
    let materials: Vec<_> =
        scene.materials.iter().map(|m| (m.name.as_str(), m.reflectivity, m.normal_deviation, m.surface)).collect();
    assert_eq!(
        materials,
        [
            ("floor", 0.5, 0.25, Surface::Lit),
            ("wall", 0.75, 1.0, Surface::Lit),
            ("floor", 0.5, 0.25, Surface::Sky),
            ("wall", 0.75, 1.0, Surface::Sky),
        ]
    );
    assert_eq!((scene.materials[0].roughness, scene.materials[1].roughness), (0.5, 0.0));
    let lens = Lens { fov_y_radians: 90_f32.to_radians(), near_m: 0.5, far_m: 50.0 };
    assert_eq!(scene.lens, lens);
    assert_eq!(
        scene.lights,
        [
            Light::Point { position: Vec3::new(1.0, 2.0, 3.0), energy: 4.0 },
            Light::Directional { direction: Vec3::NEG_Y, energy: 1.0 },
        ]
    );
    let names: Vec<_> = scene.views.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["zebra", "ant", "mole"], "in the order of the file");
    assert_eq!(scene.views[0].lens, None);
    assert_eq!(scene.views[1].lens, Some(Lens { near_m: 0.25, ..lens }));
}

#[test]
fn views_change_materials_only_for_themselves() {
    let scene = load(&folder(FULL), 1.0).unwrap();
    let of = |name: &str| {
        let materials = scene.materials_in(scene.view(name).unwrap());
        [0, 1].map(|i| (materials[i].reflectivity, materials[i].roughness))
    };
    assert_eq!(of("zebra"), [(0.5, 0.5), (0.75, 0.0)]);
    assert_eq!(of("ant"), [(0.5, 0.125), (1.0, 0.0)], "default speaks for those that are not named");
    assert_eq!(of("mole"), [(0.0, 0.5), (0.75, 0.0)]);
}

#[test]
fn an_extra_scale_enlarges_everything_that_has_a_place() {
    let scene = load(&folder(FULL), 3.0).unwrap();
    assert_eq!(scene.bounds().max, Vec3::new(6.0, 6.0, 0.0));
    assert_eq!((scene.views[0].eye, scene.views[0].look_at), (Vec3::NEG_Z * 3.0, Vec3::Z * 3.0));
    assert_eq!(scene.lights[0], Light::Point { position: Vec3::new(3.0, 6.0, 9.0), energy: 4.0 });
    assert_eq!(scene.lens.near_m, 0.5);
}

#[test]
fn little_suffices() {
    let scene = load(&folder("[[mesh]]\nfile = 'A.OBJ'\n"), 1.0).unwrap();
    assert_eq!((scene.name.as_str(), scene.views[0].name.as_str()), ("test", "default"));
    assert_eq!((scene.lights.len(), scene.lens.fov_y_radians), (1, Lens::default().fov_y_radians));
    assert!(normal(&scene.meshes[0].vertices[0]).z < 0.0, "right-handed unless it says otherwise");
    let reflectivities: Vec<_> = scene.materials.iter().map(|m| m.reflectivity).collect();
    assert!((reflectivities[0] - 0.5).abs() < 1e-6 && (reflectivities[1] - 0.25).abs() < 1e-6);
}

#[test]
fn unknown_materials_are_warnings() {
    let text = "[[mesh]]\nfile = 'a.obj'\n[material.ceiling]\nroughness = 0.5\n[view.v]\neye = [0, 0, 0]\n\
        look_at = [1, 0, 0]\nmaterials = { roof = { roughness = 1.0 } }\n";
    let folder = folder(text);
    assert_eq!(
        folder.warnings(&load(&folder, 1.0).unwrap()),
        [
            "test.scene.toml: [material.ceiling] changes nothing: no mesh has this material",
            "test.scene.toml: [view.v] changes material roof, which no mesh has",
        ]
    );
}

#[test]
fn errors_name_the_line() {
    let view = |rest: &str| format!("[view.v]\neye = [0, 0, 0]\nlook_at = [0, 0, 1]\n{rest}\n");
    let cases = [
        ("[camera]\nfov_y_deg = 180\n".into(), "4: fov_y_deg must lie between 0 and 180, but is 180"),
        ("[camera]\nfov_y_deg = 0.0\n".into(), "4: fov_y_deg must be a number > 0, not 0"),
        ("[camera]\nnear = -1\n".into(), "4: near must be a number > 0, not -1"),
        ("[camera]\nnear = nan\n".into(), "4: near must be a number > 0, not NaN"),
        ("[camera]\nnear = 2\nfar = 2\n".into(), "5: far (2) must be greater than near (2)"),
        (view("near = 5000"), "6: far (1000) must be greater than near (5000)"),
        (view("materials = { floor = { roughness = 2 } }"), "6: roughness must lie in 0 to 1, but is 2"),
        (
            "[view.v]\neye = [1, 2, 3]\nlook_at = [1, 2, 3]\n".into(),
            "5: view \"v\" looks at its own eye; look_at must be another point",
        ),
        (
            "[view.v]\neye = [inf, 2, 3]\nlook_at = [1, 2, 3]\n".into(),
            "4: eye must have three finite numbers, not [inf, 2, 3]",
        ),
        ("[material.floor]\nreflectivity = -0.5\n".into(), "4: reflectivity must lie in 0 to 1, but is -0.5"),
        ("[material.floor]\nnormal_deviation = nan\n".into(), "4: normal_deviation must lie in 0 to 1, but is NaN"),
        ("[[light]]\nkind = 'point'\nenergy = 1\n".into(), "3: a point light has a position and no direction"),
        (
            "[[light]]\nkind = 'directional'\nenergy = 1\nposition = [0, 0, 0]\n".into(),
            "3: a directional light has a direction and no position",
        ),
        (
            "[[light]]\nkind = 'directional'\nenergy = 1\ndirection = [0, 0, 0]\n".into(),
            "6: direction must not be zero",
        ),
        (
            "[[light]]\nkind = 'point'\nenergy = 0\nposition = [0, 0, 0]\n".into(),
            "5: energy must be a number > 0, not 0",
        ),
        ("[[mesh]]\nfile = 'gone.obj'\n".into(), "4: there is no file \"gone.obj\" here"),
    ];
    for (rest, expected) in cases {
        let folder = folder(&format!("[[mesh]]\nfile = 'a.obj'\n{rest}"));
        let error = load(&folder, 1.0).unwrap_err().to_string();
        assert_eq!(folder.without_folder(&error), format!("test.scene.toml:{expected}"), "{rest}");
    }
}

#[test]
fn syntax_errors_and_unknown_keys_name_the_line() {
    let cases = [
        ("[[mesh]]\nfile = 'a.obj'\nfiel = 1\n", "3: unknown field `fiel`"),
        ("sky = 1\n", "1: unknown field `sky`"),
        ("[[mesh]]\nfile = 'a.obj'\nsurface = 'glass'\n", "3: unknown variant `glass`"),
        ("handedness = 'both'\n", "1: unknown variant `both`"),
        ("\n[camera\n", "2: "),
        ("[camera]\nnear = 'close'\n", "2: invalid type"),
        ("[[light]]\nkind = 'point'\n", "1: missing field `energy`"),
        ("[view.v]\neye = [0, 0]\nlook_at = [0, 0, 1]\n", "2: invalid length 2"),
        ("[view.v]\neye = [0, 0, 0]\nlook_at = [0, 0, 1]\n[view.v]\n", "4: duplicate key"),
    ];
    for (text, expected) in cases {
        let folder = folder(text);
        let error = load(&folder, 1.0).unwrap_err().to_string();
        let error = folder.without_folder(&error);
        assert!(error.starts_with(&format!("test.scene.toml:{expected}")), "{text:?}: {error}");
        assert!(!error.contains('\n'), "{error:?}");
    }
}

#[test]
fn files_that_cannot_be_scene_files_are_refused() {
    let folder = folder("name = 'empty'\n");
    let error = |folder: &Folder| folder.without_folder(&load(folder, 1.0).unwrap_err().to_string());
    assert_eq!(error(&folder), "test.scene.toml: a scene file needs at least one [[mesh]]");
    folder.write("test.scene.toml", b"name = 'a'\nname2 = '\xff'\n");
    assert_eq!(error(&folder), "test.scene.toml:2: a scene file must be UTF-8 text");
    std::fs::File::create(folder.path("test.scene.toml")).unwrap().set_len(2 << 20).unwrap();
    assert!(error(&folder).starts_with("test.scene.toml: a scene file of 2097152 bytes is larger than"));
    std::fs::remove_file(folder.path("test.scene.toml")).unwrap();
    assert!(error(&folder).starts_with("cannot read test.scene.toml: "));
    assert_eq!(load(&folder, -1.0).unwrap_err().exit_status(), 2);
}
