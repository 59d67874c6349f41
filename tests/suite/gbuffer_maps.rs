//! G-buffers in the conventions of other renderers, read by maps. The tests write a G-buffer of this program in other
//! conventions, read it back, and compare it and its images with the original. They must be equal to the bit where
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

/// The corridor of the rooms with its own materials, and with sky in the uppermost rows.
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
        assert!(data.reflecting().iter().filter(|r| **r).count() > 4000, "a scene that reflects");
        data
    })
}

/// Reads a file by the text of a map.
fn read(folder: &Folder, map: &str, main: &str) -> GBufferData {
    folder.write("map.toml", map);
    GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path(main)).unwrap()
}

/// A number for each value.
fn each<'a, T>(values: &'a [T], value: impl Fn(&T) -> f64 + 'a) -> impl Iterator<Item = f64> + 'a {
    values.iter().map(value)
}

/// One component of each vector.
fn axis(values: &[Vec3], k: usize) -> impl Iterator<Item = f64> + '_ {
    each(values, move |v| f64::from(v[k]))
}

/// Pairs of a channel's name and its samples.
fn named(names: &[&str], samples: impl IntoIterator<Item = FlatSamples>) -> Vec<(String, FlatSamples)> {
    names.iter().map(|name| (*name).to_owned()).zip(samples).collect()
}

/// The numbers of a matrix, column after column.
fn numbers(m: &DMat4) -> String {
    format!("{:?}", m.to_cols_array())
}

/// View-space z of a reversed depth.
fn view_z(depth: f32, data: &GBufferData) -> f64 {
    let [n, f] = [data.camera.lens.near_m, data.camera.lens.far_m].map(f64::from);
    n * f / (n + f64::from(depth) * (f - n))
}

/// The differences of the reflections that methods make of two G-buffers: for each method its name, the root mean
/// square difference, and the share of values that differ by more than a step of a display.
fn reflections(a: &GBufferData, b: &GBufferData) -> Vec<(&'static str, f64, f64)> {
    let gpu = gpu();
    let made = ["unified", "ssct"].map(|name| {
        let method = methods::find(name).unwrap();
        let setup = Setup::new(SIZE);
        let [a, b] = [a, b].map(|data| gbuffer::reflect(&gpu, data, None, method, &setup).unwrap().reflection);
        let colours = |p: &Pixels| p.texels().flat_map(|t| [t[0], t[1], t[2]]).map(f64::from).collect::<Vec<_>>();
        let differences: Vec<f64> = colours(&a).into_iter().zip(colours(&b)).map(|(a, b)| (a - b).abs()).collect();
        let count = differences.len() as f64;
        let rmse = (differences.iter().map(|d| d * d).sum::<f64>() / count).sqrt();
        (name, rmse, differences.iter().filter(|d| **d > 1.0 / 255.0).count() as f64 / count)
    });
    gpu.check_validation().unwrap();
    made.to_vec()
}

/// Checks the images of `read`, a G-buffer that a map read, against those of `held`, the content of the same files as
/// the test itself decodes it. Both are the same but for rays that graze an edge: their difference is bounded by 0.005
/// and half of the difference that the format's own rounding makes between `held` and the original.
fn same_images(read: &GBufferData, held: &GBufferData) {
    let rounding = reflections(held, original());
    for ((name, rmse, differing), (_, of_format, _)) in reflections(read, held).into_iter().zip(rounding) {
        assert!(differing < 0.005, "{name}: {differing} of all values differ, by {rmse}");
        assert!(rmse < 0.005 + 0.5 * of_format, "{name}: {rmse} apart, where the format alone gives {of_format}");
    }
}

/// A frame with other names, in two files and several parts, in tiles, with rows from the bottom up and in two kinds of
/// floats, is the original to the bit.
#[test]
fn other_names_files_parts_tiles_rows_and_kinds_of_floats_change_no_bit() {
    let data = original();
    let folder = Folder::new();
    let width = SIZE[0] as usize;
    let up = |samples| flipped(samples, width);
    let is_half = |v: f32| f32::from(f16::from_f32(v)) == v;
    // The program keeps colours and normals in 16-bit floats, so that a file of 16-bit floats has them exactly.
    assert!(data.color.iter().chain(&data.normal).all(|v| v.to_array().into_iter().all(is_half)));
    let camera = &data.camera;
    let main = Part::new(named(&["Depth.D"], [up(floats(each(&data.depth, |v| f64::from(*v))))]))
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
    let colour = named(&["R", "G", "B"], [0, 1, 2].map(|k| up(halves(axis(&data.color, k)))));
    let material =
        named(&["R", "G"], [&data.roughness, &data.reflectivity].map(|v| up(floats(each(v, |v| f64::from(*v))))));
    let colour = Part::new(colour).named("lit").compressed(Compression::RLE);
    write_exr(&folder.path("frame.exr"), SIZE, vec![main, colour, Part::new(material).named("material")]);
    // In the right-handed view space, z has the other sign.
    let normal = [0, 1, 2].map(|k| up(halves(axis(&data.normal, k).map(|v| if k == 2 { -v } else { v }))));
    let normal = Part::new(named(&["x", "y", "z"], normal)).compressed(Compression::PXR24).tiled(33);
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
    assert!(read(&folder, map, "frame.exr") == expected, "a view space that is ours, of normals that are not");
    // With a right-handed world and a right-handed view, the map gives the original back.
    let both = map.replace("view = \"left\"", "view = \"right\"");
    let turned = (Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0)) * camera.world_to_view).as_dmat4()
        * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let both = both.replace("{ attribute = \"place\" }", &numbers(&turned));
    assert!(read(&folder, &both, "frame.exr") == *data, "to the bit");
    let rows = format!("{:?}", turned.transpose().to_cols_array_2d());
    let by_rows = both.replace(&numbers(&turned), &rows).replace("world = ", "matrices = \"rows\"\nworld = ");
    assert!(read(&folder, &by_rows, "frame.exr") == *data, "as four rows");

    // The command makes the image of the original out of the mapped files, and `convert` writes them as a file of this
    // program.
    folder.write("map.toml", &both);
    std::fs::write(folder.path("own.exr"), gbuffer_file::encode(data, &folder.path("own.exr")).unwrap()).unwrap();
    for method in ["unified", "ssct"] {
        let with = ["--method", method, "-o"];
        folder.succeed(&[&["gbuffer", "reflect", "own.exr"], &with[..], &["a.exr"]].concat());
        folder.succeed(
            &[&["gbuffer", "reflect", "frame.exr", "--gbuffer-map", "map.toml"], &with[..], &["b.exr"]].concat(),
        );
        let [a, b] = ["a.exr", "b.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
        assert!(a == b, "{method}");
    }
    folder.succeed(&["gbuffer", "convert", "frame.exr", "--gbuffer-map", "map.toml", "-o", "converted.exr"]);
    assert!(gbuffer_file::load(&folder.path("converted.exr")).unwrap() == *data, "the file is the exported one");
}

/// Swaps y and z: from this program's world to a right-handed world with z up, and back.
fn z_up(v: DVec3) -> DVec3 {
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
    let world: Vec<DVec3> =
        data.normal.iter().map(|n| z_up(to_world.transform_vector3(n.as_dvec3()).normalize_or_zero())).collect();
    let stored: Vec<DVec3> =
        world.iter().map(|n| DVec3::from((*n * 0.5 + 0.5).to_array().map(|v| f64::from(f16::from_f64(v))))).collect();
    let z: Vec<f64> = data.depth.iter().map(|d| if *d > 0.0 { view_z(*d, data) } else { 1e10 }).collect();
    let unorm = |k: usize| halves(stored.iter().map(|n| n[k]));
    let channels = [floats(z.iter().copied()), unorm(0), unorm(1), unorm(2)];
    let depth_and_normal = Part::new(named(&["Z", "X", "Y", "W"], channels));
    let rest = Part::new(named(
        &["R", "G", "B", "s", "p"],
        [0, 1, 2].map(|k| floats(axis(&data.color, k))).into_iter().chain([
            floats(each(&data.reflectivity, |v| f64::from(*v) * 0.25)),
            // α(ϱ) by its formula; an exponent is infinite for a mirror.
            floats(each(&data.roughness, |v| ssct_ground::math::phong::exponent(f64::from(*v)))),
        ]),
    ));
    write_exr(&folder.path("a.exr"), SIZE, vec![depth_and_normal]);
    write_exr(&folder.path("b.exr"), SIZE, vec![rest]);
    // The matrix takes a view along −z to a world with z up.
    let swap = DMat4::from_cols(glam::DVec4::X, glam::DVec4::Z, glam::DVec4::Y, glam::DVec4::W);
    let turned = swap * to_world * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
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
        numbers(&turned)
    );
    let got = read(&folder, &map, "a.exr");
    assert!(got.camera.world_to_view.abs_diff_eq(data.camera.world_to_view, 1e-6 * data.camera.eye().length()));
    assert!(
        (got.camera.lens.fov_y_radians().unwrap() - lens.fov_y_radians().unwrap()).abs()
            <= 1e-7 * lens.fov_y_radians().unwrap()
    );
    assert_eq!((got.camera.lens.near_m, got.camera.lens.far_m), (lens.near_m, lens.far_m));
    assert!(got.color == data.color && got.surface == data.surface);
    let mut held = data.clone();
    let of_depth = f64::from(lens.near_m) * f64::from(lens.far_m) / f64::from(lens.far_m - lens.near_m);
    for i in 0..data.depth.len() {
        // The reversed depth is d = a + b / z. Both z and d are rounded once.
        let d = f64::from(data.depth[i]);
        let bound = ROUNDS_32 * (of_depth / z[i] + d);
        assert!((f64::from(got.depth[i]) - d).abs() <= bound * 1.01, "{i}: {} {d}", got.depth[i]);
        assert!((got.reflectivity[i] - data.reflectivity[i]).abs() <= 2.0 * ROUNDS_32 as f32);
        let rough = f64::from(data.roughness[i]);
        assert!((f64::from(got.roughness[i]) - rough).abs() <= 1e-5 * rough.max(1e-3), "{i}: {rough}");
        if data.depth[i] > 0.0 {
            let n = DVec3::from((stored[i] * 2.0 - 1.0).to_array()).normalize();
            held.normal[i] = to_view.transform_vector3(z_up(n)).as_vec3();
            // A component in 0 to 1 is rounded by at most half a step of 2⁻¹¹, and the map doubles it; normalising at
            // most doubles the error once more.
            let off = got.normal[i].as_dvec3().distance(data.normal[i].as_dvec3().normalize());
            assert!(off <= 4.0 * 3_f64.sqrt() * ROUNDS_16 / 2.0, "{i}: {off}");
            assert!(got.normal[i].distance(held.normal[i]) < 1e-6, "{i}");
        } else {
            assert_eq!(got.normal[i], Vec3::ZERO);
        }
    }
    same_images(&got, &held);
}

/// Octahedral coordinates from −1 to 1 of a direction. The fold is written in the other of the two usual ways than in
/// the program.
fn octahedral(n: DVec3) -> [f64; 2] {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    if n.z >= 0.0 { [n.x, n.y] } else { [(1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)] }
}

/// Three kinds of depth and three encodings of octahedral normals, with rows from the bottom up, are the original
/// within the rounding of each encoding.
#[test]
fn depth_of_opengl_and_octahedral_normals_from_the_bottom_up() {
    let data = original();
    let folder = Folder::new();
    let width = SIZE[0] as usize;
    let up = |samples| flipped(samples, width);
    // Right-handed view space.
    let view: Vec<[f64; 2]> = data
        .normal
        .iter()
        .map(|n| octahedral((n.as_dvec3() * DVec3::new(1.0, 1.0, -1.0)).normalize_or(DVec3::Z)))
        .collect();
    // Standard depth, from −1 to 1.
    let gl: Vec<f32> = data.depth.iter().map(|d| (1.0 - 2.0 * f64::from(*d)) as f32).collect();
    let unorm: Vec<[u32; 2]> = view.iter().map(|v| v.map(|c| ((c * 0.5 + 0.5) * 65535.0).round() as u32)).collect();
    let twelve: Vec<[u32; 2]> = view.iter().map(|v| v.map(|c| ((c * 0.5 + 0.5) * 4095.0).round() as u32)).collect();
    let packed = |k: usize| {
        let byte = |v: &[u32; 2]| match k {
            2 => (v[0] >> 8) | (v[1] >> 8) << 4,
            k => v[k] & 255,
        };
        up(floats(twelve.iter().map(|v| f64::from(byte(v)) / 255.0)))
    };
    let distances = (0..data.depth.len()).map(|i| {
        let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let top = (0.5 * f64::from(data.camera.lens.fov_y_radians().unwrap())).tan();
        let ray = DVec3::new(
            (2.0 * x / f64::from(SIZE[0]) - 1.0) * top * f64::from(data.camera.aspect),
            (1.0 - 2.0 * y / f64::from(SIZE[1])) * top,
            1.0,
        );
        if data.depth[i] > 0.0 { view_z(data.depth[i], data) * ray.length() } else { -1.0 }
    });
    let channels = [
        up(floats(gl.iter().map(|v| f64::from(*v)))),
        up(floats(each(&data.depth, |d| 1.0 - f64::from(*d)))),
        up(floats(distances.map(|d| if d < 0.0 { d } else { d * 100.0 }))),
        up(integers(unorm.iter().map(|v| v[0]))),
        up(integers(unorm.iter().map(|v| v[1]))),
        up(floats(view.iter().map(|v| v[0]))),
        up(floats(view.iter().map(|v| v[1]))),
        packed(0),
        packed(1),
        packed(2),
        up(floats(each(&data.roughness, |v| f64::from(*v)))),
        up(floats(each(&data.reflectivity, |v| f64::from(*v)))),
    ];
    let names = ["gl", "d3d", "t", "u", "v", "x", "y", "p0", "p1", "p2", "rough", "refl"];
    let colour = named(&["R", "G", "B"], [0, 1, 2].map(|k| up(floats(axis(&data.color, k)))));
    write_exr(&folder.path("f.exr"), SIZE, vec![Part::new([named(&names, channels), colour].concat()).tiled(64)]);
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
        let got = read(&folder, &map(gl_depth, normal), "f.exr");
        assert_eq!(got.camera, expected.camera);
        assert!(got.color == data.color && got.roughness == data.roughness && got.reflectivity == data.reflectivity);
        for (i, normal) in got.normal.iter().enumerate().filter(|(i, _)| data.depth[*i] > 0.0) {
            let off = normal.as_dvec3().distance(data.normal[i].as_dvec3().normalize());
            assert!(off <= 18_f64.sqrt() * step + 4.0 * ROUNDS_32, "{i}, {step}: {off}");
        }
    }
    // Depth near 1 or −1 is rounded by half a step of these numbers, and −1…1 has twice the range.
    for (depth, bound) in [
        (gl_depth, ROUNDS_32 / 2.0),
        ("channel = \"d3d\"\nkind = \"standard\"", ROUNDS_32 / 2.0),
        ("channel = \"t\"\nkind = \"distance\"\nscale = 0.01\nsky-value = -1", 0.0),
    ] {
        let got = read(&folder, &map(depth, signed), "f.exr");
        for i in 0..data.depth.len() {
            let d = f64::from(data.depth[i]);
            let z = view_z(data.depth[i], data);
            let b = f64::from(lens.near_m) * f64::from(lens.far_m) / f64::from(lens.far_m - lens.near_m);
            // A distance is rounded by a share of itself, and the depth that is computed from it by a share of b / z +
            // d.
            let of_distance = if bound == 0.0 && d > 0.0 { 1.01 * ROUNDS_32 * (b / z + d) } else { 0.0 };
            let off = (f64::from(got.depth[i]) - d).abs();
            assert!(off <= bound + of_distance + ROUNDS_32 * d, "{depth}, {i}: {off}");
            assert_eq!(got.depth[i] > 0.0, d > 0.0, "{depth}, {i}");
        }
        // The depth that the files hold after rounding, as the test itself computes it.
        let mut held = expected.clone();
        let rounded: Option<Vec<f64>> = match depth {
            d if d == gl_depth => Some(gl.iter().map(|v| 0.5 - 0.5 * f64::from(*v)).collect()),
            d if d.contains("d3d") => {
                Some(data.depth.iter().map(|d| 1.0 - f64::from((1.0 - f64::from(*d)) as f32)).collect())
            }
            _ => None,
        };
        for (held, rounded) in held.depth.iter_mut().zip(rounded.into_iter().flatten()) {
            *held = rounded as f32;
        }
        same_images(&got, &held);
    }
}
