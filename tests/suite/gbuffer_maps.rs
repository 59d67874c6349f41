//! Tests G-buffers in the conventions of other renderers, read by maps. The tests write a G-buffer of this program in
//! other conventions, read it back, and compare it and its images with the original. They must be equal to the bit if
//! nothing was rounded, else within the rounding of the format. The example maps read files of the layouts that they
//! are for.

mod agreement;
mod errors;
mod examples;
mod files;
mod formats;
mod lenses;
mod materials;
mod mitsuba;
mod page;
mod views;

use crate::common::folder::Folder;
use crate::common::gpu;
use exr::image::FlatSamples;
use exr::meta::attribute::AttributeValue;
use exr::prelude::Compression;
use files::{Part, flipped, floats, halves, integers, write_exr};
use glam::{DMat4, DVec3, Mat4, Vec3};
use half::f16;
use ssct::gpu::Pixels;
use ssct::methods::{self, METHODS, Setup, Wants};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer};
use ssct_scenes::gbuffer_map::GBufferMap;
use ssct_scenes::{GBufferData, gbuffer_file};
use std::sync::OnceLock;

/// Size of the images in pixels.
const SIZE: [u32; 2] = [161, 119];

/// Half the distance from 1 to the next larger 32-bit float: the largest share by which rounding changes a value.
const ROUNDS_32: f64 = 1.0 / (1 << 24) as f64;
/// Half the distance from 1 to the next larger 16-bit float.
const ROUNDS_16: f64 = 1.0 / (1 << 11) as f64;

/// Returns the corridor of the rooms with its own materials, and with sky in the uppermost rows. It is drawn once.
fn original() -> &'static GBufferData {
    static DATA: OnceLock<GBufferData> = OnceLock::new();
    DATA.get_or_init(|| {
        let gpu = gpu();
        let scene = crate::common::built_in("rooms");
        let view = scene.view("corridor").unwrap();
        let mut stage = Stage::new(&gpu, &scene).unwrap();
        let materials = Globals::default().materials(&scene, view);
        let camera = view.camera(&scene, SIZE);
        let setup = Setup::new(SIZE);
        let shot = Shot::new(&mut stage, &METHODS[0], &setup, Wants::IMAGE, camera, materials).unwrap();
        stage.run(&shot, ssct::gpu::frame::Mode::Plain).unwrap();
        let mut data = gbuffer::read(&mut stage.context, &shot).unwrap();
        // The view shows no sky, so that the uppermost seven rows become sky.
        let sky = SIZE[0] as usize * 7;
        data.depth[..sky].fill(0.0);
        data.normal[..sky].fill(Vec3::ZERO);
        data.roughness[..sky].fill(0.0);
        data.reflectivity[..sky].fill(0.0);
        data.surface.fill(ssct_scenes::Surface::Lit);
        assert!(data.reflecting().iter().filter(|reflects| **reflects).count() > 4000, "a scene that reflects");
        data
    })
}

/// Reads the G-buffer whose main file has the name `main_file` by the text of a map.
fn read_by_map(folder: &Folder, map: &str, main_file: &str) -> GBufferData {
    folder.write("map.toml", map);
    GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path(main_file)).unwrap()
}

/// Returns the number that `to_number` makes of each value.
fn numbers_of<'a, T>(values: &'a [T], to_number: impl Fn(&T) -> f64 + 'a) -> impl Iterator<Item = f64> + 'a {
    values.iter().map(to_number)
}

/// Returns component `component` (0 to 2) of each vector.
fn axis_values(vectors: &[Vec3], component: usize) -> impl Iterator<Item = f64> + '_ {
    numbers_of(vectors, move |v| f64::from(v[component]))
}

/// Pairs names of channels with their samples.
fn named_channels(names: &[&str], samples: impl IntoIterator<Item = FlatSamples>) -> Vec<(String, FlatSamples)> {
    names.iter().map(|name| (*name).to_owned()).zip(samples).collect()
}

/// Returns the numbers of a matrix, column after column, as a list of TOML.
fn toml_numbers(matrix: &DMat4) -> String {
    format!("{:?}", matrix.to_cols_array())
}

/// Returns the view-space z, in metres, of a reversed depth.
fn view_z(depth: f32, data: &GBufferData) -> f64 {
    let [near, far] = [data.camera.lens.near_m, data.camera.lens.far_m].map(f64::from);
    near * far / (near + f64::from(depth) * (far - near))
}

/// Compares the reflections that methods make of two G-buffers. Returns, for each method, its name, the root mean
/// square difference, and the share of values that differ by more than a step of a display.
fn compare_reflections(a: &GBufferData, b: &GBufferData) -> Vec<(&'static str, f64, f64)> {
    let gpu = gpu();
    let compared = ["unified", "ssct"].map(|name| {
        let method = methods::find(name).unwrap();
        let setup = Setup::new(SIZE);
        let [a, b] = [a, b].map(|data| gbuffer::reflect(&gpu, data, None, method, &setup).unwrap().reflection);
        let colours = |image: &Pixels| {
            image.texels().flat_map(|texel| [texel[0], texel[1], texel[2]]).map(f64::from).collect::<Vec<_>>()
        };
        let differences: Vec<f64> = colours(&a).into_iter().zip(colours(&b)).map(|(a, b)| (a - b).abs()).collect();
        let count = differences.len() as f64;
        let rmse = (differences.iter().map(|d| d * d).sum::<f64>() / count).sqrt();
        (name, rmse, differences.iter().filter(|d| **d > 1.0 / 255.0).count() as f64 / count)
    });
    gpu.check_validation().unwrap();
    compared.to_vec()
}

/// Checks that methods make nearly the same images of `read`, a G-buffer that a map read, and of `expected`, the
/// content of the same files as the test itself decodes it.
///
/// Rays that graze an edge may differ. Their difference is bounded by 0.005 and half of the difference that the
/// format's own rounding makes between `expected` and the original.
fn assert_same_images(read: &GBufferData, expected: &GBufferData) {
    let rounding = compare_reflections(expected, original());
    for ((name, rmse, differing), (_, format_rmse, _)) in compare_reflections(read, expected).into_iter().zip(rounding)
    {
        assert!(differing < 0.005, "{name}: {differing} of all values differ, by {rmse}");
        assert!(rmse < 0.005 + 0.5 * format_rmse, "{name}: {rmse} apart, where the format alone gives {format_rmse}");
    }
}

/// A frame with other names, in two files and several parts, in tiles, with rows from the bottom up and in two kinds of
/// floats, is the original to the bit. Nothing in it is rounded, so that any difference is a mistake.
#[test]
fn other_names_files_parts_tiles_rows_and_kinds_of_floats_change_no_bit() {
    let data = original();
    let folder = Folder::new();
    let width = SIZE[0] as usize;
    let flip = |samples| flipped(samples, width);
    let is_half = |v: f32| f32::from(f16::from_f32(v)) == v;
    // The program keeps colours and normals in 16-bit floats, so that a file of 16-bit floats has them exactly.
    assert!(data.color.iter().chain(&data.normal).all(|v| v.to_array().into_iter().all(is_half)));
    let camera = &data.camera;
    let main = Part::new(named_channels(&["Depth.D"], [flip(floats(numbers_of(&data.depth, |v| f64::from(*v))))]))
        .named("depth")
        .tiled(16)
        .compressed(Compression::PIZ)
        .with("lens/fov", AttributeValue::F32(camera.lens.fov_y_radians().unwrap()))
        .with("planes", AttributeValue::Text(format!("{}", camera.lens.near_m).as_str().into()))
        .with("far plane", AttributeValue::F64(f64::from(camera.lens.far_m)))
        .with("aspect", AttributeValue::F32(camera.aspect))
        // The matrix of a right-handed world, in the order in which a program with row vectors writes it.
        .with(
            "place",
            AttributeValue::Matrix4x4(
                (camera.world_to_view * Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0))).to_cols_array(),
            ),
        );
    let colour =
        named_channels(&["R", "G", "B"], [0, 1, 2].map(|component| flip(halves(axis_values(&data.color, component)))));
    let material = named_channels(
        &["R", "G"],
        [&data.roughness, &data.reflectivity].map(|v| flip(floats(numbers_of(v, |v| f64::from(*v))))),
    );
    let colour = Part::new(colour).named("lit").compressed(Compression::RLE);
    write_exr(&folder.path("frame.exr"), SIZE, vec![main, colour, Part::new(material).named("material")]);
    // In the right-handed view space, z has the other sign.
    let normal = [0, 1, 2].map(|component| {
        flip(halves(axis_values(&data.normal, component).map(|v| if component == 2 { -v } else { v })))
    });
    let normal = Part::new(named_channels(&["x", "y", "z"], normal)).compressed(Compression::PXR24).tiled(33);
    write_exr(&folder.path("normals.exr"), SIZE, vec![normal]);
    let map = r#"
        origin = "bottom-left"
        [conventions]
        world = "right"
        view = "left"
        [camera]
        fov-y-rad = { attribute = "lens/fov" }
        near = { attribute = "planes", part = "depth" }
        far = { attribute = "far plane" }
        aspect = { attribute = "aspect" }
        world-to-view = { attribute = "place" }
        [depth]
        channel = "depth.Depth.D"
        kind = "reversed"
        [normal]
        file = "normals.exr"
        channels = ["x", "y", "z"]
        space = "view"
        [roughness]
        part = "material"
        channel = "R"
        kind = "lobe"
        [reflectivity]
        channel = "material.G"
        [[color]]
        part = "lit"
        channels = ["R", "G", "B"]
    "#;
    let mut expected = data.clone();
    for normal in &mut expected.normal {
        normal.z = -normal.z;
    }
    assert!(read_by_map(&folder, map, "frame.exr") == expected, "a view space that is ours, of normals that are not");
    // With a right-handed world and a right-handed view, the map gives the original back.
    let right_map = map.replace("view = \"left\"", "view = \"right\"");
    let right_handed = (Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0)) * camera.world_to_view).as_dmat4()
        * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let right_map = right_map.replace("{ attribute = \"place\" }", &toml_numbers(&right_handed));
    assert!(read_by_map(&folder, &right_map, "frame.exr") == *data, "to the bit");
    let rows = format!("{:?}", right_handed.transpose().to_cols_array_2d());
    let by_rows =
        right_map.replace(&toml_numbers(&right_handed), &rows).replace("world = ", "matrices = \"rows\"\nworld = ");
    assert!(read_by_map(&folder, &by_rows, "frame.exr") == *data, "as four rows");

    // The command makes the image of the original out of the mapped files, and `convert` writes them as a file of this
    // program.
    folder.write("map.toml", &right_map);
    std::fs::write(folder.path("own.exr"), gbuffer_file::encode(data, &folder.path("own.exr")).unwrap()).unwrap();
    for method in ["unified", "ssct"] {
        let options = ["--method", method, "-o"];
        folder.succeed(&[&["gbuffer", "reflect", "own.exr"], &options[..], &["a.exr"]].concat());
        folder.succeed(
            &[&["gbuffer", "reflect", "frame.exr", "--gbuffer-map", "map.toml"], &options[..], &["b.exr"]].concat(),
        );
        let [a, b] = ["a.exr", "b.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
        assert!(a == b, "{method}");
    }
    folder.succeed(&["gbuffer", "convert", "frame.exr", "--gbuffer-map", "map.toml", "-o", "converted.exr"]);
    assert!(gbuffer_file::load(&folder.path("converted.exr")).unwrap() == *data, "the file is the exported one");
}

/// Swaps y and z, which leads from this program's world to a right-handed world with z up, and back.
fn swap_y_and_z(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.z, v.y)
}

/// A frame of a right-handed world with z up, depth in metres, 16-bit normals, Phong exponents and scaled reflectivity
/// is the original within the rounding of each format.
#[test]
fn a_right_handed_world_with_z_up_and_distances_in_metres() {
    let data = original();
    let folder = Folder::new();
    let to_view = data.camera.world_to_view.as_dmat4();
    let to_world = to_view.inverse();
    // Half floats from 0 to 1, as engines store them.
    let world_normals: Vec<DVec3> = data
        .normal
        .iter()
        .map(|n| swap_y_and_z(to_world.transform_vector3(n.as_dvec3()).normalize_or_zero()))
        .collect();
    let stored_normals: Vec<DVec3> = world_normals
        .iter()
        .map(|n| DVec3::from((*n * 0.5 + 0.5).to_array().map(|v| f64::from(f16::from_f64(v)))))
        .collect();
    let z: Vec<f64> = data.depth.iter().map(|d| if *d > 0.0 { view_z(*d, data) } else { 1e10 }).collect();
    let unorm = |component: usize| halves(stored_normals.iter().map(|n| n[component]));
    let channels = [floats(z.iter().copied()), unorm(0), unorm(1), unorm(2)];
    let depth_and_normal = Part::new(named_channels(&["Z", "X", "Y", "W"], channels));
    let color_and_material = Part::new(named_channels(
        &["R", "G", "B", "s", "p"],
        [0, 1, 2].map(|component| floats(axis_values(&data.color, component))).into_iter().chain([
            floats(numbers_of(&data.reflectivity, |v| f64::from(*v) * 0.25)),
            // α(ϱ) by its formula; an exponent is infinite for a mirror.
            floats(numbers_of(&data.roughness, |v| ssct_ground::math::phong::exponent(f64::from(*v)))),
        ]),
    ));
    write_exr(&folder.path("a.exr"), SIZE, vec![depth_and_normal]);
    write_exr(&folder.path("b.exr"), SIZE, vec![color_and_material]);
    // The matrix takes a view along −z to a world with z up.
    let swap = DMat4::from_cols(glam::DVec4::X, glam::DVec4::Z, glam::DVec4::Y, glam::DVec4::W);
    let view_to_world = swap * to_world * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let lens = data.camera.lens;
    let map = format!(
        r#"
        [conventions]
        world = "right-z-up"
        view = "right"
        [camera]
        fov-y-deg = {}
        near = {}
        far = {}
        view-to-world = {}
        [depth]
        channel = "Z"
        kind = "view-z"
        sky-beyond = 1e9
        [normal]
        channels = ["X", "Y", "W"]
        space = "world"
        encoding = "unorm"
        [roughness]
        file = "b.exr"
        channel = "p"
        kind = "phong-exponent"
        [reflectivity]
        file = "b.exr"
        channel = "s"
        scale = 4.0
        [[color]]
        file = "b.exr"
        channels = ["R", "G", "B"]
        "#,
        f64::from(lens.fov_y_radians().unwrap()).to_degrees(),
        lens.near_m,
        lens.far_m,
        toml_numbers(&view_to_world)
    );
    let found = read_by_map(&folder, &map, "a.exr");
    assert!(found.camera.world_to_view.abs_diff_eq(data.camera.world_to_view, 1e-6 * data.camera.eye().length()));
    assert!(
        (found.camera.lens.fov_y_radians().unwrap() - lens.fov_y_radians().unwrap()).abs()
            <= 1e-7 * lens.fov_y_radians().unwrap()
    );
    assert_eq!((found.camera.lens.near_m, found.camera.lens.far_m), (lens.near_m, lens.far_m));
    assert!(found.color == data.color && found.surface == data.surface);
    let mut expected = data.clone();
    let depth_scale = f64::from(lens.near_m) * f64::from(lens.far_m) / f64::from(lens.far_m - lens.near_m);
    for i in 0..data.depth.len() {
        // The reversed depth is d = a + b / z. Both z and d are rounded once.
        let d = f64::from(data.depth[i]);
        let bound = ROUNDS_32 * (depth_scale / z[i] + d);
        assert!((f64::from(found.depth[i]) - d).abs() <= bound * 1.01, "{i}: {} {d}", found.depth[i]);
        assert!((found.reflectivity[i] - data.reflectivity[i]).abs() <= 2.0 * ROUNDS_32 as f32);
        let roughness = f64::from(data.roughness[i]);
        assert!((f64::from(found.roughness[i]) - roughness).abs() <= 1e-5 * roughness.max(1e-3), "{i}: {roughness}");
        if data.depth[i] > 0.0 {
            let n = DVec3::from((stored_normals[i] * 2.0 - 1.0).to_array()).normalize();
            expected.normal[i] = to_view.transform_vector3(swap_y_and_z(n)).as_vec3();
            // A component in 0 to 1 is rounded by at most half a step of 2⁻¹¹, and the map doubles it; normalising at
            // most doubles the error once more.
            let distance = found.normal[i].as_dvec3().distance(data.normal[i].as_dvec3().normalize());
            assert!(distance <= 4.0 * 3_f64.sqrt() * ROUNDS_16 / 2.0, "{i}: {distance}");
            assert!(found.normal[i].distance(expected.normal[i]) < 1e-6, "{i}");
        } else {
            assert_eq!(found.normal[i], Vec3::ZERO);
        }
    }
    assert_same_images(&found, &expected);
}

/// Returns the octahedral coordinates of a direction, from −1 to 1. Of the two usual ways to write the fold, this is
/// the one that the program does not use.
fn octahedral(direction: DVec3) -> [f64; 2] {
    let n = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    if n.z >= 0.0 { [n.x, n.y] } else { [(1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)] }
}

/// Three kinds of depth and three encodings of octahedral normals, with rows from the bottom up, are the original
/// within the rounding of each encoding. The fold of the octahedron and the bits that share a byte are easily mistaken.
#[test]
fn depth_of_opengl_and_octahedral_normals_from_the_bottom_up() {
    let data = original();
    let folder = Folder::new();
    let width = SIZE[0] as usize;
    let flip = |samples| flipped(samples, width);
    // The octahedral coordinates of the normals in a right-handed view space.
    let coordinates: Vec<[f64; 2]> = data
        .normal
        .iter()
        .map(|n| octahedral((n.as_dvec3() * DVec3::new(1.0, 1.0, -1.0)).normalize_or(DVec3::Z)))
        .collect();
    // Standard depth, from −1 to 1.
    let gl_depths: Vec<f32> = data.depth.iter().map(|d| (1.0 - 2.0 * f64::from(*d)) as f32).collect();
    let bits_16: Vec<[u32; 2]> =
        coordinates.iter().map(|v| v.map(|c| ((c * 0.5 + 0.5) * 65535.0).round() as u32)).collect();
    let bits_12: Vec<[u32; 2]> =
        coordinates.iter().map(|v| v.map(|c| ((c * 0.5 + 0.5) * 4095.0).round() as u32)).collect();
    // Returns one of the three bytes into which two coordinates of twelve bits are packed.
    let packed = |component: usize| {
        let byte = |v: &[u32; 2]| match component {
            2 => (v[0] >> 8) | (v[1] >> 8) << 4,
            component => v[component] & 255,
        };
        flip(floats(bits_12.iter().map(|v| f64::from(byte(v)) / 255.0)))
    };
    let distances = (0..data.depth.len()).map(|i| {
        let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let tan_half_fov = (0.5 * f64::from(data.camera.lens.fov_y_radians().unwrap())).tan();
        let ray = DVec3::new(
            (2.0 * x / f64::from(SIZE[0]) - 1.0) * tan_half_fov * f64::from(data.camera.aspect),
            (1.0 - 2.0 * y / f64::from(SIZE[1])) * tan_half_fov,
            1.0,
        );
        if data.depth[i] > 0.0 { view_z(data.depth[i], data) * ray.length() } else { -1.0 }
    });
    let channels = [
        flip(floats(gl_depths.iter().map(|v| f64::from(*v)))),
        flip(floats(numbers_of(&data.depth, |d| 1.0 - f64::from(*d)))),
        flip(floats(distances.map(|d| if d < 0.0 { d } else { d * 100.0 }))),
        flip(integers(bits_16.iter().map(|v| v[0]))),
        flip(integers(bits_16.iter().map(|v| v[1]))),
        flip(floats(coordinates.iter().map(|v| v[0]))),
        flip(floats(coordinates.iter().map(|v| v[1]))),
        packed(0),
        packed(1),
        packed(2),
        flip(floats(numbers_of(&data.roughness, |v| f64::from(*v)))),
        flip(floats(numbers_of(&data.reflectivity, |v| f64::from(*v)))),
    ];
    let names = ["gl", "d3d", "t", "u", "v", "x", "y", "p0", "p1", "p2", "rough", "refl"];
    let colour =
        named_channels(&["R", "G", "B"], [0, 1, 2].map(|component| flip(floats(axis_values(&data.color, component)))));
    write_exr(
        &folder.path("f.exr"),
        SIZE,
        vec![Part::new([named_channels(&names, channels), colour].concat()).tiled(64)],
    );
    let lens = data.camera.lens;
    let map = |depth: &str, normal: &str| {
        format!(
            "origin = \"bottom-left\"\n[conventions]\nview = \"right\"\n[camera]\nfov-y-rad = {}\nnear = {}\nfar = {}\n\
             [depth]\n{depth}\n[normal]\nspace = \"view\"\n{normal}\n[roughness]\nchannel = \"rough\"\n\
             kind = \"lobe\"\n[reflectivity]\nchannel = \"refl\"\n[[color]]\nchannels = [\"R\", \"G\", \"B\"]\n",
            f64::from(lens.fov_y_radians().unwrap()),
            lens.near_m,
            lens.far_m,
        )
    };
    let gl_depth = "channel = \"gl\"\nkind = \"minus-one-to-one\"";
    let signed = "encoding = \"octahedral\"\nchannels = [\"x\", \"y\"]";
    let in_view = |data: &GBufferData| GBufferData {
        camera: ssct_scenes::Camera { world_to_view: Mat4::IDENTITY, ..data.camera },
        ..data.clone()
    };
    let expected = in_view(data);
    // Each encoding of normals, with the greatest error e of a coordinate. An error of e in x, e in y and 2 e in z is
    // √6 e long. The octahedron is at least 1/√3 away from its centre, so that the direction is off by √18 e at most.
    for (normal, step) in [
        (signed, ROUNDS_32),
        ("encoding = \"octahedral-unorm\"\nchannels = [\"u\", \"v\"]\nscale = 1.5259021896696422e-5", 1.0 / 65535.0),
        ("encoding = \"octahedral-888\"\nchannels = [\"p0\", \"p1\", \"p2\"]", 1.0 / 4095.0),
    ] {
        let found = read_by_map(&folder, &map(gl_depth, normal), "f.exr");
        assert_eq!(found.camera, expected.camera);
        assert!(
            found.color == data.color && found.roughness == data.roughness && found.reflectivity == data.reflectivity
        );
        for (i, normal) in found.normal.iter().enumerate().filter(|(i, _)| data.depth[*i] > 0.0) {
            let difference = normal.as_dvec3().distance(data.normal[i].as_dvec3().normalize());
            assert!(difference <= 18_f64.sqrt() * step + 4.0 * ROUNDS_32, "{i}, {step}: {difference}");
        }
    }
    // Depth near 1 or −1 is rounded by half a step of these numbers, and −1…1 has twice the range.
    for (depth, bound) in [
        (gl_depth, ROUNDS_32 / 2.0),
        ("channel = \"d3d\"\nkind = \"standard\"", ROUNDS_32 / 2.0),
        ("channel = \"t\"\nkind = \"distance\"\nscale = 0.01\nsky-value = -1", 0.0),
    ] {
        let found = read_by_map(&folder, &map(depth, signed), "f.exr");
        for i in 0..data.depth.len() {
            let d = f64::from(data.depth[i]);
            let z = view_z(data.depth[i], data);
            let b = f64::from(lens.near_m) * f64::from(lens.far_m) / f64::from(lens.far_m - lens.near_m);
            // A distance is rounded by a share of itself, and the depth that is computed from it by a share of b / z +
            // d.
            let distance_bound = if bound == 0.0 && d > 0.0 { 1.01 * ROUNDS_32 * (b / z + d) } else { 0.0 };
            let difference = (f64::from(found.depth[i]) - d).abs();
            assert!(difference <= bound + distance_bound + ROUNDS_32 * d, "{depth}, {i}: {difference}");
            assert_eq!(found.depth[i] > 0.0, d > 0.0, "{depth}, {i}");
        }
        // The depth that the files hold after rounding, as the test itself computes it.
        let mut expected_depths = expected.clone();
        let rounded: Option<Vec<f64>> = match depth {
            d if d == gl_depth => Some(gl_depths.iter().map(|v| 0.5 - 0.5 * f64::from(*v)).collect()),
            d if d.contains("d3d") => {
                Some(data.depth.iter().map(|d| 1.0 - f64::from((1.0 - f64::from(*d)) as f32)).collect())
            }
            _ => None,
        };
        for (expected_depth, rounded_depth) in expected_depths.depth.iter_mut().zip(rounded.into_iter().flatten()) {
            *expected_depth = rounded_depth as f32;
        }
        assert_same_images(&found, &expected_depths);
    }
}
