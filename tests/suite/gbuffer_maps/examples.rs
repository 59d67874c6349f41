//! Tests the maps under `examples/gbuffer-maps`: they read files of the layouts that they are for. The files show a
//! floor and a ball, which the tests trace in the world of the renderer; the surfaces that the maps read must lie on
//! them.

use super::files::{Part, floats, halves, write_exr, write_png};
use super::named_channels;
use crate::common::folder::Folder;
use crate::common::repository;
use exr::image::FlatSamples;
use glam::{DMat4, DVec3, DVec4, Vec3};
use ssct_scenes::GBufferData;
use ssct_scenes::gbuffer_map::GBufferMap;

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [160, 90];

/// The surface that the camera sees in a pixel.
#[derive(Clone, Copy)]
struct VisibleSurface {
    /// The depth along the view, in the renderer's units; none for sky.
    z: Option<f64>,
    /// The normal in the renderer's world.
    normal: DVec3,
    is_ball: bool,
}

/// Traces a floor at z = 0 and a ball on it, in a world with z up, and returns the surface of each pixel. The camera
/// looks along +z or −z of its view space, as `forward` (±1) says. Its projection multiplies x and y by `scale`.
fn trace(world_to_view: DMat4, scale: [f64; 2], forward: f64, radius: f64, centre: DVec3) -> Vec<VisibleSurface> {
    let to_world = world_to_view.inverse();
    let eye = to_world.w_axis.truncate();
    let pixel = |i: usize| {
        let (column, row) = ((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
        let ndc = [column / f64::from(SIZE[0]) * 2.0 - 1.0, 1.0 - row / f64::from(SIZE[1]) * 2.0];
        let ray = to_world.transform_vector3(DVec3::new(ndc[0] / scale[0], ndc[1] / scale[1], forward));
        let floor_t = -eye.z / ray.z;
        let from_centre = eye - centre;
        // The ball is hit where a t² + 2 b t + c = 0.
        let (a, b, c) = (ray.length_squared(), from_centre.dot(ray), from_centre.length_squared() - radius * radius);
        let discriminant = b * b - a * c;
        let ball_t = if discriminant > 0.0 { (-b - discriminant.sqrt()) / a } else { -1.0 };
        if ball_t > 0.0 && (floor_t <= 0.0 || ball_t < floor_t) {
            VisibleSurface { z: Some(ball_t), normal: (eye + ball_t * ray - centre) / radius, is_ball: true }
        } else if floor_t > 0.0 && floor_t < 40.0 * radius {
            VisibleSurface { z: Some(floor_t), normal: DVec3::Z, is_ball: false }
        } else {
            VisibleSurface { z: None, normal: DVec3::ZERO, is_ball: false }
        }
    };
    (0..SIZE[0] as usize * SIZE[1] as usize).map(pixel).collect()
}

/// Checks that every pixel that was read lies on the floor or on the ball.
///
/// `to_our_world` takes a place of the renderer's world to this program's world, in metres. `ball` is the radius and
/// the centre of the ball in the renderer's world. A place may be off by `depth_share` of its depth, and a normal by
/// the length `normal_bound`.
fn assert_on_scene(
    data: &GBufferData,
    seen: &[VisibleSurface],
    to_our_world: impl Fn(DVec3) -> DVec3,
    ball: (f64, DVec3),
    depth_share: f64,
    normal_bound: f64,
) {
    let clip_to_world =
        (data.camera.view_to_clip_reversed().as_dmat4() * data.camera.world_to_view.as_dmat4()).inverse();
    let world_to_view = data.camera.world_to_view.as_dmat4();
    let metres_per_unit = to_our_world(DVec3::X).length();
    // The numbers of pixels that show the floor, and of those that show the ball.
    let (mut floors, mut balls) = (0, 0);
    for (i, seen) in seen.iter().enumerate() {
        assert_eq!(seen.z.is_some(), data.depth[i] > 0.0, "pixel {i}");
        let Some(z) = seen.z else { continue };
        let (x, y) = ((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
        let ndc = DVec3::new(
            x / f64::from(SIZE[0]) * 2.0 - 1.0,
            1.0 - y / f64::from(SIZE[1]) * 2.0,
            f64::from(data.depth[i]),
        );
        let place = clip_to_world.project_point3(ndc);
        let error = if seen.is_ball {
            balls += 1;
            place.distance(to_our_world(ball.1)) - ball.0 * metres_per_unit
        } else {
            floors += 1;
            place.y
        };
        assert!(error.abs() < depth_share * z * metres_per_unit, "pixel {i}: {error} m off at {z}");
        let normal = world_to_view.transform_vector3(to_our_world(seen.normal).normalize());
        let normal_error = normal.distance(data.normal[i].as_dvec3());
        assert!(normal_error < normal_bound, "pixel {i}: normal {} is {normal_error} off", data.normal[i]);
        assert!(data.normal[i].z < 0.3, "pixel {i}: it is seen from in front");
    }
    assert!(floors > 3000 && balls > 500, "{floors} {balls}");
}

/// Returns a map of the examples, and its text as a table.
fn example(name: &str) -> (GBufferMap, toml::Table) {
    let path = repository().join("examples/gbuffer-maps").join(name);
    (GBufferMap::load(&path).unwrap(), std::fs::read_to_string(&path).unwrap().parse().unwrap())
}

/// Returns the numbers of a key of `[camera]`.
fn camera_numbers(map: &toml::Table, key: &str) -> Vec<f64> {
    /// Returns all numbers of a value as one list, also the numbers of nested lists.
    fn numbers(value: &toml::Value) -> Vec<f64> {
        match value {
            toml::Value::Array(list) => list.iter().flat_map(numbers).collect(),
            toml::Value::Integer(n) => vec![*n as f64],
            other => vec![other.as_float().unwrap()],
        }
    }
    numbers(&map["camera"][key])
}

/// Blender's passes in many parts, in one part and from the compositor's node give one G-buffer. Its places, normals,
/// colours and materials are those of the traced scene. Blender names and orders channels otherwise in each case.
#[test]
fn the_map_of_blender_reads_one_part_and_many() {
    let (map, text) = example("blender.toml");
    // The map gives the matrix by its rows.
    let view_to_world = DMat4::from_cols_slice(&camera_numbers(&text, "view-to-world")).transpose();
    let scale_x = 2.0 * camera_numbers(&text, "focal-length-mm")[0] / camera_numbers(&text, "sensor-width-mm")[0];
    let ball = (0.9, DVec3::new(-0.4, 0.0, 0.9));
    let seen = trace(view_to_world.inverse(), [scale_x, scale_x * 16.0 / 9.0], -1.0, ball.0, ball.1);
    let floats_of = |value: &dyn Fn(&VisibleSurface) -> f64| floats(seen.iter().map(value));
    let halves_of = |value: &dyn Fn(&VisibleSurface) -> f64| halves(seen.iter().map(value));
    let rgb = |color: [f64; 3]| color.map(|v| halves_of(&|s| if s.z.is_some() { v } else { 0.0 })).to_vec();
    let xyz = |component: usize| floats_of(&|s| s.normal[component]);
    let sky = [0.25, 0.5, 1.0].map(|v| halves_of(&|s| if s.z.is_some() { 0.0 } else { v })).to_vec();
    let passes: Vec<(&str, &str, Vec<FlatSamples>)> = vec![
        ("Combined", "RGBA", [rgb([9.0; 3]), rgb([1.0; 3])[..1].to_vec()].concat()),
        ("Depth", "Z", vec![floats_of(&|s| s.z.unwrap_or(1e10))]),
        ("Normal", "XYZ", vec![xyz(0), xyz(1), xyz(2)]),
        ("Diffuse Direct", "RGB", rgb([2.0, 1.0, 0.5])),
        ("Diffuse Indirect", "RGB", rgb([1.0, 0.5, 0.25])),
        ("Diffuse Color", "RGB", rgb([0.5, 0.25, 0.125])),
        ("Emission", "RGB", rgb([0.0, 0.25, 0.0])),
        ("Environment", "RGB", sky),
        ("roughness", "X", vec![floats_of(&|s| if s.is_ball { 0.3 } else { 0.1 })]),
        ("metallic", "X", vec![floats_of(&|s| if s.is_ball { 0.0 } else { 1.0 })]),
        ("base color", "RGBA", [rgb([0.5; 3]), rgb([1.0; 3])[..1].to_vec()].concat()),
    ];
    let channels = |(pass, suffixes, samples): &(&str, &str, Vec<FlatSamples>)| {
        let names: Vec<String> = suffixes.chars().map(|c| format!("ViewLayer.{pass}.{c}")).collect();
        named_channels(&names.iter().map(String::as_str).collect::<Vec<_>>(), samples.clone())
    };
    let folder = Folder::new();
    let parts = passes.iter().map(|pass| Part::new(channels(pass)).named(&format!("ViewLayer.{}", pass.0)));
    write_exr(&folder.path("many.exr"), SIZE, parts.collect());
    write_exr(&folder.path("one.exr"), SIZE, vec![Part::new(passes.iter().flat_map(channels).collect())]);
    let data = map.read(&folder.path("many.exr")).unwrap();
    assert!(data == map.read(&folder.path("one.exr")).unwrap(), "in one part as in many");
    assert_eq!(map.check(&folder.path("many.exr"), &data).unwrap(), None, "it does not contradict itself");
    // The compositor's node names channels without the layer, and gives single numbers the component V.
    let node_part = |(pass, suffixes, samples): &(&str, &str, Vec<FlatSamples>)| {
        let is_number = ["Depth", "roughness", "metallic"].contains(pass);
        let names: Vec<String> =
            suffixes.chars().map(|c| format!("{pass}.{}", if is_number { 'V' } else { c })).collect();
        Part::new(named_channels(&names.iter().map(String::as_str).collect::<Vec<_>>(), samples.clone())).named(pass)
    };
    write_exr(&folder.path("node.exr"), SIZE, passes.iter().map(node_part).collect());
    let (node, _) = example("blender-file-output.toml");
    assert!(data == node.read(&folder.path("node.exr")).unwrap(), "by the node as by the output");
    assert_on_scene(&data, &seen, |v| DVec3::new(v.x, v.z, v.y), ball, 3e-6, 1e-6);
    for (i, seen) in seen.iter().enumerate() {
        let colour = if seen.z.is_some() { Vec3::new(1.5, 0.625, 0.09375) } else { Vec3::new(0.25, 0.5, 1.0) };
        assert_eq!(data.color[i], colour, "diffuse light times colour, emission, and the background");
        // A dielectric has the reflectivity of its F0, and a metal that of its colour. The perceptual roughnesses 0.1
        // and 0.3 give ϱ by docs/definitions.md, "glTF".
        let (reflectivity, roughness) = match (seen.z, seen.is_ball) {
            (None, _) => (0.0, 0.0),
            (_, true) => (0.04, 0.511),
            (_, false) => (0.5, 0.057),
        };
        assert!(
            (data.reflectivity[i] - reflectivity).abs() < 1e-6 && (data.roughness[i] - roughness).abs() < 1e-3,
            "{i}"
        );
    }
}

/// Textures as RenderDoc saves them from Unreal (depth, normals of ten bits, material bytes) give the places, normals
/// and materials of the traced scene.
#[test]
fn the_map_of_an_unreal_capture_reads_its_textures() {
    let (map, text) = example("renderdoc-unreal.toml");
    // The matrix of row vectors, read row by row, is the matrix of column vectors, read column by column.
    let [to_view, to_clip] =
        ["world-to-view", "projection"].map(|key| DMat4::from_cols_slice(&camera_numbers(&text, key)));
    assert_eq!(to_clip.row(3), DVec4::Z);
    let ball = (120.0, DVec3::new(500.0, 40.0, 120.0));
    let seen = trace(to_view, [to_clip.x_axis.x, to_clip.y_axis.y], 1.0, ball.0, ball.1);
    let folder = Folder::new();
    let rgba_part = |values: [FlatSamples; 4]| Part::new(named_channels(&["R", "G", "B", "A"], values));
    let ones = || halves(seen.iter().map(|_| 1.0));
    let halves_of = |value: &dyn Fn(&VisibleSurface) -> f64| halves(seen.iter().map(value));
    write_exr(
        &folder.path("SceneColor.exr"),
        SIZE,
        vec![rgba_part([halves_of(&|s| f64::from(u8::from(s.is_ball))), ones(), ones(), ones()])],
    );
    // With a far plane at infinity, depth is the distance of the near plane over z. RenderDoc writes the one component
    // of a depth buffer into R.
    let near = to_clip.w_axis.z;
    let depth = floats(seen.iter().map(|s| s.z.map_or(0.0, |z| near / z)));
    let zeros = || floats(seen.iter().map(|_| 0.0));
    write_exr(
        &folder.path("SceneDepthZ.exr"),
        SIZE,
        vec![rgba_part([depth, zeros(), zeros(), floats(seen.iter().map(|_| 1.0))])],
    );
    // Ten bits a component.
    let in_ten_bits = |v: f64| ((v * 0.5 + 0.5) * 1023.0).round() / 1023.0;
    let normal = |component: usize| halves_of(&|s| in_ten_bits(s.normal[component]));
    write_exr(&folder.path("GBufferA.exr"), SIZE, vec![rgba_part([normal(0), normal(1), normal(2), ones()])]);
    // Metallic, specular, roughness: a floor of metal, a ball of a dielectric.
    write_png(&folder.path("GBufferB.png"), SIZE, |i| if seen[i].is_ball { [0.0, 0.5, 0.3] } else { [1.0, 0.5, 0.1] });
    write_png(&folder.path("GBufferC.png"), SIZE, |_| [0.5; 3]);
    let data = map.read(&folder.path("SceneColor.exr")).unwrap();
    // A component is rounded to ten bits and then to a 16-bit float from ½ to 1, and the map doubles it: its error is
    // the sum of one step of each. Three components together are off by √3 times this error, and normalising them may
    // double the result.
    let normal_bound = 2.0 * 3_f64.sqrt() * (1.0 / 1023.0 + 1.0 / 2048.0);
    assert_on_scene(&data, &seen, |v| DVec3::new(v.y, v.z, v.x) * 0.01, ball, 3e-6, normal_bound);
    let grey = ((128.0 / 255.0 + 0.055_f64) / 1.055).powf(2.4);
    for (i, seen) in seen.iter().enumerate().filter(|(_, s)| s.z.is_some()) {
        // F0 is 0.08 of the specular, which is 128 of 255.
        let reflectivity = if seen.is_ball { 0.08 * 128.0 / 255.0 } else { grey };
        assert!((f64::from(data.reflectivity[i]) - reflectivity).abs() < 1e-6, "{i}: {}", data.reflectivity[i]);
        let roughness = if seen.is_ball { 0.511 } else { 0.057 };
        assert!((data.roughness[i] - roughness).abs() < 8e-3, "{i}: {}", data.roughness[i]);
        assert_eq!(data.color[i], Vec3::new(f32::from(u8::from(seen.is_ball)), 1.0, 1.0));
    }
}
