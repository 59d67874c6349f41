//! Tests scene files, `NAME.scene.toml`: every key, defaults, and errors with their line.

use super::*;
use ssct_ground::Result;
use ssct_scenes::{Aabb, AreaLight, AreaShape, Capture, Encoding, Impostor, Lens, Light, Probe, Surface, scene_file};

/// Makes a folder with the scene file, an OBJ file of two materials and a picture.
fn folder(text: &str) -> Folder {
    let folder = square("mtllib a.mtl\nusemtl floor\nf 1 2 3\nusemtl wall\nf 1 3 4\n");
    folder.write("a.mtl", b"newmtl floor\nKs 0.5 0.5 0.5\nNs 100\nnewmtl wall\nKs 0.25 0.25 0.25\n");
    folder.write("test.scene.toml", text.as_bytes());
    folder.image("sign.png", 4, 2, |x, y| [x as u8 * 60, y as u8 * 200, 9, if x == 0 { 0 } else { 255 }]);
    folder
}

/// Loads the scene file with an additional scale.
fn load(folder: &Folder, extra_scale: f32) -> Result<Scene> {
    scene_file::load(&folder.path("test.scene.toml"), &scaled(extra_scale))
}

/// A scene file with every key.
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

[[probe]]
name = "door"
position = [1, 2, 3]
min = [0, 0, 0]
max = [2, 4, 5]

[[impostor]]
file = "sign.png"
centre = [0, 2, 1]
half_u = [1, 0, 0]
half_v = [0, -0.5, 0]

[[impostor]]
name = "the same"
file = "sign.png"
centre = [0, 2, 2]
half_u = [0, 0, 1]
half_v = [0, -0.5, 0]

[[area_light]]
kind = "sphere"
radiance = [1, 0.5, 0.25]
centre = [1, 2, 3]
radius = 0.5

[[area_light]]
kind = "capsule"
radiance = [1, 1, 1]
a = [0, 1, 0]
b = [0, 2, 0]
radius = 0.125

[[area_light]]
kind = "rectangle"
radiance = [2, 2, 2]
centre = [0, 3, 0]
half_u = [1, 0, 0]
half_v = [0, 0, 2]

[[area_light]]
kind = "cuboid"
radiance = [1, 1, 1]
centre = [0, 3, 0]
half_u = [1, 0, 0]
half_v = [0, 0, 2]
half_w = 0.5

[[area_light]]
kind = "cylinder"
radiance = [1, 1, 1]
a = [0, 1, 0]
b = [0, 2, 0]
radius = 0.25

[[capture]]
place = [1, 1.5, 2]
resolution = 256
near = 0.25

[[capture]]
place = [3, 1.5, 2]
resolution = 256
"#;

/// The full file gives exactly the meshes, materials, lens, lights and views that its keys say. A key that is parsed
/// and then dropped would show nowhere else.
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
    let lens = Lens::perspective(90_f32.to_radians(), 0.5, 50.0);
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

/// The full file gives exactly the probes, impostors and area lights that its keys say, and an impostor's image faces
/// the viewer.
#[test]
fn probes_impostors_and_area_lights_arrive() {
    let scene = load(&folder(FULL), 1.0).unwrap();
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 4.0, 5.0) };
    assert_eq!(scene.probes, [Probe { name: "door".into(), position: Vec3::new(1.0, 2.0, 3.0), bounds }]);
    let [sign, same] = &scene.impostors[..] else { panic!("two impostors") };
    let half_v = -0.5 * Vec3::Y;
    let expected = Impostor {
        name: "sign.png".into(),
        centre: Vec3::new(0.0, 2.0, 1.0),
        half_u: Vec3::X,
        half_v,
        texture: sign.texture,
    };
    assert_eq!((sign, same.name.as_str(), same.half_u), (&expected, "the same", Vec3::Z));
    assert_eq!(sign.normal(), Vec3::NEG_Z, "an image that reads to the right and down faces the viewer");
    let image = &scene.textures[sign.texture];
    assert_eq!((image.width, image.height, image.encoding), (4, 2, Encoding::Srgb));
    assert_eq!((image.rgba[3], image.rgba[7], &scene.textures[same.texture].rgba), (0, 255, &image.rgba));
    let rectangle = AreaShape::Rectangle { centre: 3.0 * Vec3::Y, half_u: Vec3::X, half_v: 2.0 * Vec3::Z };
    let cuboid = AreaShape::Cuboid { centre: 3.0 * Vec3::Y, half_u: Vec3::X, half_v: 2.0 * Vec3::Z, half_w: 0.5 };
    assert_eq!(
        scene.area_lights,
        [
            AreaLight {
                shape: AreaShape::Sphere { centre: Vec3::new(1.0, 2.0, 3.0), radius: 0.5 },
                radiance: Vec3::new(1.0, 0.5, 0.25)
            },
            AreaLight {
                shape: AreaShape::Capsule { a: Vec3::Y, b: 2.0 * Vec3::Y, radius: 0.125 },
                radiance: Vec3::ONE
            },
            AreaLight { shape: rectangle, radiance: Vec3::splat(2.0) },
            AreaLight { shape: cuboid, radiance: Vec3::ONE },
            AreaLight {
                shape: AreaShape::Cylinder { a: Vec3::Y, b: 2.0 * Vec3::Y, radius: 0.25 },
                radiance: Vec3::ONE
            },
        ]
    );
}

/// The full file gives exactly its captures. Written as TOML and read again, they are the same.
#[test]
fn captures_arrive_and_can_be_written_again() {
    let scene = load(&folder(FULL), 1.0).unwrap();
    let first = Capture { position: Vec3::new(1.0, 1.5, 2.0), near_m: 0.25, resolution: 256 };
    let second = Capture { position: Vec3::new(3.0, 1.5, 2.0), near_m: Capture::NEAR_M, resolution: 256 };
    assert_eq!(scene.captures, [first, second]);
    let written: String = scene.captures.iter().map(|c| c.to_toml()).collect();
    let again = load(&folder(&format!("coordinates = 'left'\n[[mesh]]\nfile = 'a.obj'\n{written}")), 1.0).unwrap();
    assert_eq!(again.captures, scene.captures);
    let bare = load(&folder("[[mesh]]\nfile = 'a.obj'\n[[capture]]\nplace = [0, 1, 0]\n"), 2.0).unwrap();
    let scaled_capture = Capture { near_m: 2.0 * Capture::NEAR_M, ..Capture::placed_at(2.0 * Vec3::Y) };
    assert_eq!(bare.captures, [scaled_capture]);
}

/// A view's own materials replace those of the scene in that view alone; `default` counts for materials that are not
/// named.
#[test]
fn views_change_materials_only_for_themselves() {
    let scene = load(&folder(FULL), 1.0).unwrap();
    let factors = |name: &str| {
        let materials = scene.materials_in(scene.view(name).unwrap());
        [0, 1].map(|i| (materials[i].reflectivity, materials[i].roughness))
    };
    assert_eq!(factors("zebra"), [(0.5, 0.5), (0.75, 0.0)]);
    assert_eq!(factors("ant"), [(0.5, 0.125), (1.0, 0.0)], "default speaks for those that are not named");
    assert_eq!(factors("mole"), [(0.0, 0.5), (0.75, 0.0)]);
}

/// A scale that the caller adds to that of the file enlarges every length: places, energies, boxes, lenses and planes.
#[test]
fn an_extra_scale_enlarges_everything_that_has_a_place() {
    let scene = load(&folder(FULL), 3.0).unwrap();
    assert_eq!(scene.bounds().max, Vec3::new(6.0, 6.0, 0.0));
    assert_eq!((scene.views[0].eye, scene.views[0].look_at), (Vec3::NEG_Z * 3.0, Vec3::Z * 3.0));
    assert_eq!(scene.lights[0], Light::Point { position: Vec3::new(3.0, 6.0, 9.0), energy: 36.0 });
    assert_eq!(
        (scene.probes[0].position, scene.probes[0].bounds.max),
        (Vec3::new(3., 6., 9.), Vec3::new(6., 12., 15.))
    );
    let AreaShape::Sphere { centre, radius } = scene.area_lights[0].shape else { panic!("a sphere") };
    assert_eq!((centre, radius), (Vec3::new(3.0, 6.0, 9.0), 1.5));
    assert_eq!((scene.impostors[1].centre, scene.impostors[1].half_u), (Vec3::new(0.0, 6.0, 6.0), 3.0 * Vec3::Z));
    assert_eq!((scene.captures[0].position, scene.captures[0].near_m), (Vec3::new(3.0, 4.5, 6.0), 0.75));
    assert_eq!((scene.lens.near_m, scene.lens.far_m), (1.5, 150.0));
    assert_eq!(scene.views[1].lens.map(|lens| lens.near_m), Some(0.75));
}

/// The scene and each view may have an orthographic lens, whose height is scaled as lengths are. Two projections at
/// once, and a height of 0, are refused with the line.
#[test]
fn views_may_be_orthographic() {
    let text = "[[mesh]]\nfile = 'a.obj'\n[camera]\northographic_height_m = 4\nnear = 0.5\n[view.plan]\neye = [0, 9, 0]\n\
                look_at = [0, 0, 0]\n[view.detail]\neye = [0, 9, 0]\nlook_at = [0, 0, 0]\northographic_height_m = 1.5\n\
                [view.eye]\neye = [0, 1, -5]\nlook_at = [0, 1, 0]\nfov_y_deg = 90\n";
    let scene = load(&folder(text), 2.0).unwrap();
    // The height of an orthographic lens is a length, so that it is scaled, too.
    assert_eq!(scene.lens, Lens::orthographic(8.0, 1.0, 2000.0));
    let lenses: Vec<_> = scene.views.iter().map(|v| v.lens).collect();
    let perspective = Lens::perspective(90_f32.to_radians(), 1.0, 2000.0);
    assert_eq!(lenses, [None, Some(Lens::orthographic(3.0, 1.0, 2000.0)), Some(perspective)]);
    let refused = |old: &str, new: &str, expected: &str| {
        let folder = folder(&text.replace(old, new));
        let error = load(&folder, 1.0).unwrap_err().to_string();
        assert_eq!(folder.without_folder(&error), format!("test.scene.toml:{expected}"));
    };
    let two = "fov_y_deg and orthographic_height_m are two projections: one of them is too many";
    refused("near = 0.5", "fov_y_deg = 90", &format!("4: {two}"));
    refused("height_m = 4", "height_m = 0", "4: orthographic_height_m must be a number > 0, not 0");
}

/// A file that names one mesh has defaults for everything else: a view, a light, a lens and a probe.
#[test]
fn little_suffices() {
    let scene = load(&folder("[[mesh]]\nfile = 'A.OBJ'\n"), 1.0).unwrap();
    assert_eq!((scene.name.as_str(), scene.views[0].name.as_str()), ("test", "default"));
    assert_eq!((scene.lights.len(), scene.lens.opening), (1, Lens::default().opening));
    let middle = Probe { name: "middle".into(), position: Vec3::new(0.5, 0.5, 0.0), bounds: scene.bounds() };
    assert_eq!((scene.probes, scene.impostors.len(), scene.area_lights.len()), (vec![middle], 0, 0));
    assert!(scene.captures.is_empty());
    let bare = folder("").load("a.obj", &LEFT).unwrap();
    assert_eq!((bare.probes[0].position, bare.probes.len()), (Vec3::new(0.5, 0.5, 0.0), 1));
    assert!(normal(&scene.meshes[0].vertices[0]).z < 0.0, "right-handed unless it says otherwise");
    let reflectivities: Vec<_> = scene.materials.iter().map(|m| m.reflectivity).collect();
    assert!((reflectivities[0] - 0.5).abs() < 1e-6 && (reflectivities[1] - 0.25).abs() < 1e-6);
}

/// A table for a material that no mesh has, in the scene or in a view, gets a warning: its name is probably misspelt.
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

/// Each faulty piece after two lines of a good file is refused with its line and its sentence. Most of these faults are
/// found after parsing, when the line is easily lost.
#[test]
fn errors_name_the_line() {
    let impostor = |file: &str, half_v: &str| {
        format!("[[impostor]]\nfile = '{file}'\ncentre = [0, 0, 0]\nhalf_u = [1, 0, 0]\nhalf_v = {half_v}\n")
    };
    let view = |rest: &str| format!("[view.v]\neye = [0, 0, 0]\nlook_at = [0, 0, 1]\n{rest}\n");
    let cases = [
        ("[camera]\nfov_y_deg = 180\n".into(), "4: fov_y_deg must lie between 0 and 180, but is 180"),
        ("[camera]\nfov_y_deg = 0.0\n".into(), "4: fov_y_deg must be a number > 0, not 0"),
        ("[camera]\nnear = -1\n".into(), "4: near must be a number > 0, not -1"),
        ("[camera]\nnear = nan\n".into(), "4: near must be a number > 0, not NaN"),
        ("[camera]\nnear = 2\nfar = 2\n".into(), "5: far (2) must be greater than near (2)"),
        (
            "[camera]\nfov_y_deg = 1e-40\n".into(),
            "3: a lens with fov_y_deg 0.00000000000000000000000000000000000000010004, near 0.1 and far 1000 is beyond the \
             precision of the projection",
        ),
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
        ("[[mesh]]\nfile = 'gone.obj'\n".into(), "4: there is no file \"gone.obj\""),
        (
            "[[probe]]\nname = 'a'\nposition = [0, 0, 0]\nmin = [0, 0, 0]\nmax = [1, 0, 1]\n".into(),
            "7: max must be greater than min along every axis",
        ),
        (
            "[[probe]]\nname = 'a'\nposition = [0, 2, 0]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n".into(),
            "5: position must lie between min and max",
        ),
        (
            "[[probe]]\nname = 'a'\nposition = [0, 0, 0]\nmin = [-2e8, 0, 0]\nmax = [1, 1, 1]\n".into(),
            "6: min lies more than 1e8 m from the origin",
        ),
        (
            "[[area_light]]\nkind = 'sphere'\nradiance = [1, 1, 1]\ncentre = [0, 2e8, 0]\nradius = 1\n".into(),
            "6: centre lies more than 1e8 m from the origin",
        ),
        ("[[capture]]\nplace = [0, nan, 0]\n".into(), "4: place must have three finite numbers, not [0, NaN, 0]"),
        ("[[capture]]\nplace = [0, 0, 0]\nresolution = 0\n".into(), "5: resolution must lie in 1 to 4096, but is 0"),
        ("[[capture]]\nplace = [0, 0, 0]\nnear = 0\n".into(), "5: near must be a number > 0, not 0"),
        (
            "[[capture]]\nplace = [0, 0, 0]\n[[capture]]\nplace = [1, 0, 0]\nresolution = 64\n".into(),
            "7: all captures of a scene have one resolution: this one has 64, the first has 512",
        ),
        ("[[capture]]\nplace = [0, 0, 0]\n".repeat(9), "19: a scene has at most 8 captures"),
        (impostor("gone.png", "[0, 1, 0]"), "4: there is no file \"gone.png\""),
        (impostor("sign.png", "[0, 0, 0]"), "7: half_v must not be zero"),
        (impostor("sign.png", "[1, 1, 0]"), "7: half_u and half_v must stand at right angles"),
        (
            "[[area_light]]\nkind = 'sphere'\nradiance = [1, 1, 1]\ncentre = [0, 0, 0]\n".into(),
            "3: a sphere has a centre and a radius beside its radiance, and no other key",
        ),
        (
            "[[area_light]]\nkind = 'sphere'\nradiance = [1, -1, 1]\ncentre = [0, 0, 0]\nradius = 1\n".into(),
            "5: radiance must not be negative, but is [1, -1, 1]",
        ),
        (
            "[[area_light]]\nkind = 'capsule'\nradiance = [1, 1, 1]\na = [0, 0, 0]\nb = [0, 1, 0]\nradius = 0\n".into(),
            "8: radius must be a number > 0, not 0",
        ),
        (
            "[[area_light]]\nkind = 'cuboid'\nradiance = [1, 1, 1]\ncentre = [0, 0, 0]\nhalf_u = [1, 0, 0]\n\
             half_v = [0, 1, 0]\n"
                .into(),
            "3: a cuboid has a centre, half_u, half_v and the length half_w beside its radiance, and no other key",
        ),
    ];
    for (rest, expected) in cases {
        let folder = folder(&format!("[[mesh]]\nfile = 'a.obj'\n{rest}"));
        let error = load(&folder, 1.0).unwrap_err().to_string();
        assert_eq!(folder.without_folder(&error), format!("test.scene.toml:{expected}"), "{rest}");
    }
}

/// Errors of syntax, unknown keys and missing keys are refused in one line that has the line of the file, and lists all
/// of them at once.
#[test]
fn syntax_errors_and_unknown_keys_name_the_line() {
    let cases = [
        ("[[mesh]]\nfile = 'a.obj'\nfiel = 1\n", "3: unknown field `fiel`"),
        ("sky = 1\n", "1: unknown field `sky`"),
        ("[[mesh]]\nfile = 'a.obj'\nsurface = 'glass'\n", "3: unknown variant `glass`"),
        ("handedness = 'both'\n", "1: unknown variant `both`"),
        ("\n[camera\n", "2: "),
        ("[camera]\nnear = 'close'\n", "2: invalid type"),
        ("[[probe]]\nnam = 'a'\n", "2: unknown field `nam`"),
        ("[[capture]]\nposition = [0, 0, 0]\n", "2: unknown field `position`"),
        ("[[capture]]\nresolution = 64\n", "1: missing field `place`"),
        ("[[impostor]]\nfile = 'a.png'\nalpha = 1\n", "3: unknown field `alpha`"),
        ("[[area_light]]\nkind = 'disc'\n", "2: unknown variant `disc`"),
        ("[[light]]\nkind = 'point'\n", "1: missing field `energy`"),
        (
            "[view.v]\neye = [0, 0, 0]\nlookat = [0, 0, 1]\n[[light]]\nkind = 'point'\nenergie = 3\nenergy = 1\n",
            "3: unknown field `lookat`, expected one of `eye`, `look_at`, `fov_y_deg`, `orthographic_height_m`, `near`, \
             `far`, `materials`; line 6: unknown field `energie`, expected one of `kind`, `position`, `direction`, `energy`; \
             line 1: missing field `look_at`",
        ),
        ("coordinates = 'both'\n", "1: unknown variant `both`"),
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

/// A file without meshes, one that is no UTF-8, one of 2 MiB and a missing one are refused with a sentence each; a
/// scale below 0 is a mistake of usage.
#[test]
fn files_that_cannot_be_scene_files_are_refused() {
    let folder = folder("name = 'empty'\n");
    let error = |folder: &Folder| folder.without_folder(&load(folder, 1.0).unwrap_err().to_string());
    assert_eq!(error(&folder), "test.scene.toml: a scene file needs at least one [[mesh]]");
    folder.write("test.scene.toml", b"name = 'a'\nname2 = '\xff'\n");
    assert_eq!(error(&folder), "test.scene.toml:2: a scene file must be UTF-8 text");
    std::fs::File::create(folder.path("test.scene.toml")).unwrap().set_len(2 << 20).unwrap();
    assert!(error(&folder).starts_with("test.scene.toml: a scene file of 2097152 bytes is too large"));
    std::fs::remove_file(folder.path("test.scene.toml")).unwrap();
    assert!(error(&folder).starts_with("cannot read test.scene.toml: "));
    assert!(matches!(load(&folder, -1.0).unwrap_err(), ssct_ground::Error::Usage(_)));
}

/// A path arrives with its key frames, scaled and mirrored like views. Times that do not increase are refused with the
/// line.
#[test]
fn a_scene_file_may_have_paths_and_their_faults_have_a_line() {
    let text = "[[mesh]]\nfile = \"a.obj\"\n[[path.walk.key]]\neye = [0, 1, 0]\nlook_at = [0, 1, 4]\ntime = 0\n\
                [[path.walk.key]]\neye = [2, 1, 0]\nlook_at = [0, 1, 4]\ntime = 3\n";
    let scene = load(&folder(text), 2.0).unwrap();
    let [path] = &scene.paths[..] else { panic!("{:?}", scene.paths) };
    assert_eq!((path.name.as_str(), path.keys().len(), path.keys()[1].time_s), ("walk", 2, Some(3.0)));
    assert_eq!(
        path.eye_and_look_at(1.0),
        ([4.0, 2.0, 0.0].into(), [0.0, 2.0, -8.0].into()),
        "scaled and mirrored like views"
    );
    let wrong = load(&folder(&text.replace("time = 3", "time = 0")), 1.0).unwrap_err().to_string();
    assert!(wrong.ends_with("test.scene.toml:7: its time must be after 0, but is 0"), "{wrong}");
}
