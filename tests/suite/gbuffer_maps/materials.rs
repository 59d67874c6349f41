//! Tests materials and colours in the terms of engines: roughness and reflectivity in bytes, sRGB, constants, sums of
//! colours, and lossy compressions.

use super::files::{Part, floats, write_exr, write_png};
use super::{SIZE, assert_same_images, axis_values, named_channels, numbers_of, original, read_by_map, toml_numbers};
use crate::common::folder::Folder;
use exr::prelude::Compression;
use ssct_scenes::gbuffer_map::GBufferMap;

/// Returns ϱ of a perceptual roughness by the formula of docs/definitions.md, "glTF", written independently of the
/// program. Half of the light leaves within `half_light_angle` of the mirror direction.
fn lobe_of_perceptual(perceptual: f64) -> f64 {
    let half_light_angle = 2.0 * (perceptual * perceptual).atan();
    if half_light_angle >= std::f64::consts::FRAC_PI_2 {
        return 1.0;
    }
    let exponent_and_one = 0.5_f64.ln() / half_light_angle.cos().ln();
    (2.0 * 0.244_f64.powf(1.0 / exponent_and_one).acos()).clamp(0.0, 1.0)
}

/// Returns the perceptual roughness of ϱ: the inverse of [`lobe_of_perceptual`].
fn perceptual_of_lobe(rho: f64) -> f64 {
    if rho <= 0.0 {
        return 0.0;
    }
    let exponent_and_one = 0.244_f64.ln() / (rho / 2.0).cos().ln();
    let half_light_angle = 0.5_f64.powf(1.0 / exponent_and_one).acos();
    (half_light_angle / 2.0).tan().sqrt()
}

/// Smoothness, perceptual roughness and α of GGX in bytes give ϱ within half a step of a byte. Metal has the
/// reflectivity of its base colour, and constants and colours are read as such. The scales of roughness are easily
/// mistaken for each other.
#[test]
fn roughness_and_reflectivity_of_engines_in_bytes() {
    let data = original();
    let folder = Folder::new();
    let decode_srgb = |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    let encode_srgb = |v: f64| if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    let perceptual: Vec<f64> = data.roughness.iter().map(|v| perceptual_of_lobe(f64::from(*v))).collect();
    // Metal of a grey base colour reflects that grey.
    let base = write_png(&folder.path("base.png"), SIZE, |i| [encode_srgb(f64::from(data.reflectivity[i])); 3]);
    // The channels are smoothness, perceptual roughness and α of GGX.
    let orm = write_png(&folder.path("orm.png"), SIZE, |i| {
        [1.0 - perceptual[i], perceptual[i], perceptual[i] * perceptual[i]]
    });
    let floats_of = |values: &[f32]| floats(numbers_of(values, |v| f64::from(*v)));
    let channels = [floats_of(&data.depth)]
        .into_iter()
        .chain([0, 1, 2].map(|component| floats(axis_values(&data.normal, component))));
    let channels = named_channels(&["D", "X", "Y", "Z"], channels);
    let colour = named_channels(
        &["c.R", "c.G", "c.B"],
        [0, 1, 2].map(|component| floats(axis_values(&data.color, component).map(encode_srgb))),
    );
    write_exr(&folder.path("f.exr"), SIZE, vec![Part::new([channels, colour].concat())]);
    let lens = data.camera.lens;
    let map = |roughness: &str, reflectivity: &str| {
        format!(
            "[camera]\nfov-y-rad = {}\nnear = {}\nfar = {}\nworld-to-view = {}\n[depth]\nchannel = \"D\"\n\
             kind = \"reversed\"\n[normal]\nspace = \"view\"\nchannels = [\"X\", \"Y\", \"Z\"]\n[roughness]\n\
             {roughness}\n{reflectivity}\n[[color]]\nchannels = [\"c.R\", \"c.G\", \"c.B\"]\nencoding = \"srgb\"\n",
            f64::from(lens.fov_y_radians().unwrap()),
            lens.near_m,
            lens.far_m,
            toml_numbers(&data.camera.world_to_view.as_dmat4()),
        )
    };
    let metal = "[metallic]\nvalue = 1\n[base-color]\nfile = \"base.png\"\nchannels = [\"R\", \"G\", \"B\"]\nencoding \
     = \"srgb\"";
    let half_step = 1.0 / 510.0;
    for (roughness, stored_perceptual) in [
        (
            "file = \"orm.png\"\nchannel = \"R\"\nkind = \"smoothness\"",
            &(|i: usize| 1.0 - orm[i][0]) as &dyn Fn(usize) -> f64,
        ),
        ("file = \"orm.png\"\nchannel = \"G\"\nkind = \"perceptual\"", &|i| orm[i][1]),
        ("file = \"orm.png\"\nchannel = \"B\"\nkind = \"ggx-alpha\"", &|i| orm[i][2].sqrt()),
    ] {
        let found = read_by_map(&folder, &map(roughness, metal), "f.exr");
        assert!(found.depth == data.depth && found.normal == data.normal && found.camera == data.camera);
        let mut expected = found.clone();
        for i in 0..data.depth.len() {
            if data.depth[i] <= 0.0 {
                assert_eq!((found.roughness[i], found.reflectivity[i]), (0.0, 0.0));
                continue;
            }
            expected.roughness[i] = lobe_of_perceptual(stored_perceptual(i)) as f32;
            expected.reflectivity[i] = decode_srgb(base[i][0]) as f32;
            assert!((found.roughness[i] - expected.roughness[i]).abs() < 1e-6, "{i}");
            assert!((found.reflectivity[i] - expected.reflectivity[i]).abs() < 1e-6, "{i}");
            // A byte rounds by half a step. As ϱ rises with the roughness, the values of ϱ at both ends of the step
            // bound it.
            let rho = f64::from(data.roughness[i]);
            let rho_bounds = if roughness.contains("alpha") {
                [-half_step, half_step]
                    .map(|error| lobe_of_perceptual((perceptual[i] * perceptual[i] + error).max(0.0).sqrt()))
            } else {
                [-half_step, half_step].map(|error| lobe_of_perceptual((perceptual[i] + error).max(0.0)))
            };
            let found_rho = f64::from(found.roughness[i]);
            assert!(
                found_rho >= rho_bounds[0].min(rho) - 1e-6 && found_rho <= rho_bounds[1].max(rho) + 1e-6,
                "{i}: {found_rho} {rho} {rho_bounds:?}"
            );
            // The slope of sRGB's decoding is 2.4 / 1.055 at most.
            let difference = f64::from((found.reflectivity[i] - data.reflectivity[i]).abs());
            assert!(difference <= 2.4 / 1.055 * half_step + 1e-6, "{i}: {difference}");
            let colour = (found.color[i] - data.color[i]).abs().max_element();
            assert!(f64::from(colour) <= 1e-6 * f64::from(data.color[i].max_element()).max(1.0), "{i}: {colour}");
        }
        if roughness.contains("perceptual") {
            assert_same_images(&found, &expected);
        }
    }
    // Constants, dielectrics, and a reflectivity that is given as a colour.
    let found = read_by_map(
        &folder,
        &map(
            "value = 0.25\nkind = \"lobe\"",
            "[metallic]\nvalue = 0\n[base-color]\nvalue = 0.5\n[f0]\nvalue = 0.5\nscale = 0.08",
        ),
        "f.exr",
    );
    let is_surface = |i: &usize| data.depth[*i] > 0.0;
    assert!(
        (0..data.depth.len())
            .filter(is_surface)
            .all(|i| found.roughness[i] == 0.25 && (found.reflectivity[i] - 0.04).abs() < 1e-7)
    );
    let found =
        read_by_map(&folder, &map("value = 0\nkind = \"lobe\"", "[reflectivity]\nvalue = [1, 0.5, 0]"), "f.exr");
    assert!(
        (0..data.depth.len()).filter(is_surface).all(|i| (found.reflectivity[i] - 0.2126 - 0.5 * 0.7152).abs() < 1e-6)
    );
}

/// Entries of `[[color]]` are scaled, multiplied and added, and negative sums become 0. Lossy compressions are allowed
/// for colours and refused for normals, from which rays start.
#[test]
fn colours_are_sums_of_products_and_only_they_may_be_rounded() {
    let folder = Folder::new();
    let size = [64, 48];
    let count = size[0] as usize * size[1] as usize;
    let ramp = |component: usize| (0..count).map(move |i| ((i * (component + 1)) % 97) as f64 / 97.0);
    let channels = |names: [&str; 3]| named_channels(&names, [0, 1, 2].map(|component| floats(ramp(component))));
    let lossless =
        Part::new([named_channels(&["Z"], [floats(vec![2.0; count])]), channels(["a.X", "a.Y", "a.Z"])].concat())
            .named("plain");
    let lossy =
        |name: &str, compression| Part::new(channels(["b.R", "b.G", "b.B"])).named(name).compressed(compression);
    write_exr(
        &folder.path("f.exr"),
        size,
        vec![lossless, lossy("dwa", Compression::DWAA(None)), lossy("pxr", Compression::PXR24)],
    );
    let map = |colour: &str| {
        format!(
            "[camera]\nfov-y-deg = 60\nnear = 1\nfar = 10\n[depth]\nchannel = \"plain.Z\"\nkind = \
             \"view-z\"\n[normal]\n\
             space = \"view\"\nchannels = [\"a.X\", \"a.Y\", \"a.Z\"]\n[roughness]\nvalue = 0\nkind = \"lobe\"\n\
             [reflectivity]\nvalue = 1\n{colour}"
        )
    };
    let term = "[[color]]\nchannels = [\"a.X\", \"a.Y\", \"a.Z\"]\nscale = 3\n[color.times]\nvalue = [1, 0.5, 0.25]\n";
    let found = read_by_map(&folder, &map(&format!("{term}[[color]]\nvalue = -1.0\n")), "f.exr");
    for (i, colour) in found.color.iter().enumerate() {
        for (component, factor) in [1.0, 0.5, 0.25].into_iter().enumerate() {
            let a = f64::from(((i * (component + 1)) % 97) as f32 / 97.0);
            let expected = (3.0 * a * factor - 1.0).max(0.0);
            assert!((f64::from(colour[component]) - expected).abs() < 1e-6, "{i} {component}");
        }
    }
    for (part, bound) in [("dwa", 0.1), ("pxr", 1.0 / (1 << 15) as f64)] {
        let lossy = format!("[[color]]\npart = \"{part}\"\nchannels = [\"b.R\", \"b.G\", \"b.B\"]\n");
        let found = read_by_map(&folder, &map(&lossy), "f.exr");
        let difference =
            (0..count).map(|i| (f64::from(found.color[i].x) - (i % 97) as f64 / 97.0).abs()).fold(0.0, f64::max);
        assert!(difference <= bound && difference > 0.0, "{part}: {difference}");
        let normal = map(&lossy).replace(
            "channels = [\"a.X\", \"a.Y\", \"a.Z\"]",
            &format!("part = \"{part}\"\nchannels = [\"b.R\", \"b.G\", \"b.B\"]"),
        );
        folder.write("map.toml", &normal);
        let message =
            GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path("f.exr")).unwrap_err().to_string();
        assert!(message.contains("map.toml:11: channel b.R of ") && message.contains("was rounded by "), "{message}");
    }
}
