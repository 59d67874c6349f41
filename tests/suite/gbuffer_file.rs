//! Tests that a G-buffer that goes to a file and comes back gives the same image as the direct run, to the bit. The
//! same holds for captures beside the file.

use crate::common::engine::{Engine, ForeignGBuffer, NATIVE, info, view_of_rooms};
use crate::common::folder::Folder;
use crate::common::gpu;
use glam::Vec3;
use ssct::methods::setup::{CaptureCount, CaptureSide};
use ssct::methods::{self, EffectParams, Fallback, METHODS, Setup, Wants};
use ssct_ground::parameter::{Choices, Field};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer, image};
use ssct_scenes::capture_file::CaptureFolder;
use ssct_scenes::{GBufferData, gbuffer_file};
use std::path::Path;
use std::process::Command;

/// For every screen-space method at two sizes, the G-buffer from the file equals the one that was written, and the
/// reflection and the finished image of both are equal, to the bit. A value that is rounded or mapped twice would
/// differ.
#[test]
fn export_and_reflect_are_the_direct_run_to_the_bit() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    for extent in [[161, 119], [64, 64]] {
        let camera = view.camera(&scene, extent);
        let globals = Globals { roughness: Some(0.1), ..Globals::default() };
        for method in METHODS.iter().filter(|m| m.is_screen_space()) {
            let setup = Setup::on_screen(extent);
            let shot =
                Shot::new(&mut stage, method, &setup, Wants::REFLECTION, camera, globals.materials(&scene, view))
                    .unwrap();
            let direct = image::render(&mut stage, &shot, false).unwrap();
            let data = gbuffer::read(&mut stage.context, &shot).unwrap();
            let path = folder.path().join("g.exr");
            std::fs::write(&path, gbuffer_file::encode(&data, &path).unwrap()).unwrap();
            let loaded = gbuffer_file::load(&path).unwrap();
            assert!(loaded == data, "the file gives back every bit");
            let reflected = gbuffer::reflect(&gpu, &loaded, None, method, &setup).unwrap();
            let bits = |image: &ssct::gpu::Pixels| image.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert!(bits(&reflected.reflection) == bits(&direct.reflection), "{} {extent:?}: reflection", method.name);
            assert!(bits(&reflected.composite) == bits(&direct.composite), "{} {extent:?}: composite", method.name);
        }
    }
    gpu.check_validation().unwrap();
}

/// `unified` on a G-buffer beside its scene is within a tenth of the error of the G-buffer alone, at three roughnesses.
/// Methods that need the scene reflect something.
#[test]
fn beside_its_scene_a_gbuffer_shows_what_the_screen_does_not() {
    let gpu = gpu();
    let scene = crate::common::built_in("rooms");
    let view = scene.view("window").unwrap();
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let (extent, unified) = ([161, 119], methods::find("unified").unwrap());
    let setup = Setup::new(extent);
    for roughness in [0.0, 0.1, 0.6] {
        let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, view);
        let camera = view.camera(&scene, extent);
        let shot = Shot::new(&mut stage, unified, &setup, Wants::REFLECTION, camera, materials).unwrap();
        let direct = image::render(&mut stage, &shot, false).unwrap().composite;
        let data = gbuffer::read(&mut stage.context, &shot).unwrap();
        let beside = gbuffer::reflect_in(&gpu, &scene, &data, unified, &setup).unwrap().composite;
        let alone = gbuffer::reflect(&gpu, &data, None, unified, &setup).unwrap().composite;
        let rmse_of = |image: &ssct::gpu::Pixels| {
            let squares = image.values.iter().zip(&direct.values).map(|(a, b)| f64::from(a - b).powi(2));
            (squares.sum::<f64>() / image.values.len() as f64).sqrt()
        };
        // Rays that begin at the point that a depth gives, and not on the pixel's triangle, may end elsewhere at edges.
        let [error_beside, error_alone] = [rmse_of(&beside), rmse_of(&alone)];
        assert!(
            error_beside < 0.1 * error_alone && error_alone > 0.005,
            "roughness {roughness}: {error_beside} and {error_alone}"
        );
    }
    // Methods that need the scene find it beside the G-buffer.
    let (camera, materials) = (view.camera(&scene, extent), scene.materials.clone());
    let shot = Shot::new(&mut stage, unified, &setup, Wants::IMAGE, camera, materials).unwrap();
    stage.draw(&shot).unwrap();
    let data = gbuffer::read(&mut stage.context, &shot).unwrap();
    for method in ["traced", "pccm"].map(|name| methods::find(name).unwrap()) {
        let reflected = gbuffer::reflect_in(&gpu, &scene, &data, method, &setup).unwrap();
        assert!(reflected.reflection.values.iter().any(|v| *v > 0.0), "{}", method.name);
    }
    gpu.check_validation().unwrap();
}

/// `gbuffer reflect --triangles` takes a built-in scene. An unknown scene, captures beside it, and a method that lacks
/// its scene are refused.
#[test]
fn a_scene_beside_a_gbuffer_is_named_or_refused_in_a_sentence() {
    let folder = Folder::new();
    let view_options = ["--scene", "rooms", "--view", "window", "--size", "34x19"];
    folder.succeed(&[&["gbuffer", "export", "g.exr"][..], &view_options].concat());
    let reflect = ["gbuffer", "reflect", "g.exr", "--method", "traced", "-o", "r.png"];
    folder.succeed(&[&reflect[..], &["--triangles", "rooms"]].concat());
    for (options, expected) in [
        (&["--triangles", "nowhere"][..], "nowhere: neither a built-in scene"),
        (&["--triangles", "rooms", "--captures", "none"], "cannot be used with"),
        (&[], "a G-buffer alone does not have them"),
    ] {
        let output = folder.run(&[&reflect[..], options].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && message.contains(expected), "{message}");
    }
}

/// By default, `gbuffer reflect` gives pixels in doubt 16 own rays, and with `auto` none. An image of a file takes its
/// time, while the default of methods is meant for frames.
#[test]
fn an_image_of_a_file_gets_the_most_own_rays_unless_a_number_is_given() {
    let folder = Folder::new();
    let view_options = ["--scene", "rooms", "--view", "corridor", "--roughness", "0.3", "--size", "66x37"];
    folder.succeed(&[&["gbuffer", "export", "g.exr"][..], &view_options].concat());
    let image_with = |options: &[&str]| {
        folder.succeed(&[&["gbuffer", "reflect", "g.exr", "--method", "unified", "-o", "r.exr"], options].concat());
        std::fs::read(folder.path("r.exr")).unwrap()
    };
    let default_image = image_with(&[]);
    assert!(default_image == image_with(&["--own-rays", "16"]));
    assert!(default_image != image_with(&["--own-rays", "none"]));
    assert!(image_with(&["--own-rays", "auto"]) == image_with(&["--own-rays", "none"]));
}

/// The view of the rooms, whose windows show the sky, and the number of captures.
const CAPTURED: (&str, CaptureCount) = ("window", CaptureCount::Number(2));

/// Texels along a side of the captures.
const SIDE: CaptureSide = CaptureSide::Side128;

/// The environment variable by which [`child`] learns the folder with the captures of each scene.
const CUBES: &str = "SSCT_TEST_CUBES";

/// By the command, the image of a G-buffer beside a folder of captures equals that of the scene with the same captures,
/// byte by byte. [`child`] tries the other methods, fallbacks and roughness values without the command.
#[test]
fn captures_beside_a_gbuffer_are_those_of_the_scene_to_the_bit() {
    let folder = Folder::new();
    // Rays are listed in the order in which threads find them, and with several threads a wide cone's colour may depend
    // on its neighbours in the list, in the last bit. Other drivers than lavapipe do not read the variable.
    let succeed = |mut command: Command| {
        let output = command.current_dir(folder.root()).env("LP_NUM_THREADS", "1").output().unwrap();
        let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        assert!(output.status.success(), "{command:?}: {text}");
    };
    let run = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
        command.args(args);
        succeed(command);
    };
    let side = SIDE.name();
    let (view, captures) = CAPTURED;
    let captures = &captures.value().to_string();
    let write_captures = |count: &str| {
        run(&["captures", "rooms", "--captures", count, "--capture-side", side, "--view", view, "-o", "cubes"]);
    };
    write_captures(captures);
    // The command draws the scene's own materials, and `child` gives all of them one roughness.
    let view_options = ["--scene", "rooms", "--view", view, "--size", "97x61"];
    run(&[&["gbuffer", "export", "g.exr"], &view_options[..]].concat());
    let method_options = ["--method", "unified", "--fallback", "captures"];
    let render_options = ["render", "--captures", captures, "--capture-side", side, "-o", "a.exr"];
    run(&[&render_options[..], &method_options, &view_options].concat());
    run(&[&["gbuffer", "reflect", "g.exr", "--captures", "cubes", "-o", "b.exr"], &method_options[..]].concat());
    let [direct_image, image_of_files] = ["a.exr", "b.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert!(direct_image == image_of_files, "{view}");
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "gbuffer_file::child", "--ignored", "--nocapture"]).env(CUBES, folder.root());
    succeed(command);
    // The second of two captures stays where a later command writes one.
    write_captures("1");
    assert_eq!(folder.list("cubes"), ["1", "2", "captures.toml", "sky"]);
    let faces = ["nx.exr", "ny.exr", "nz.exr", "px.exr", "py.exr", "pz.exr"];
    let mut files = [&["color.png", "depth.png"], &faces[..]].concat();
    files.sort_unstable();
    assert_eq!(folder.list("cubes/1"), files);
    assert_eq!(folder.list("cubes/sky"), faces);
    assert_eq!(folder.image("cubes/1/color.png").dimensions(), (512, 384));
}

/// For each kind of lobe, and for pairs of method and fallback, a G-buffer beside captures from files gives the direct
/// image, to the bit. The driver has one thread in this process, so that rays are listed in one order.
#[test]
#[ignore = "a process that the test above starts"]
fn child() {
    let folder = std::path::PathBuf::from(std::env::var_os(CUBES).unwrap());
    let gpu = gpu();
    let (view, captures) = CAPTURED;
    let scene = crate::common::built_in("rooms");
    let (mut stage, view) = (Stage::new(&gpu, &scene).unwrap(), scene.view(view).unwrap());
    let cubes = CaptureFolder::open(&folder.join("cubes")).unwrap();
    for (method, fallback, roughness) in [
        ("unified", Fallback::None, 0.0),
        ("unified", Fallback::None, 0.1),
        ("unified", Fallback::None, 0.6),
        ("captures", Fallback::None, 0.0),
        ("captures", Fallback::None, 0.6),
        ("ssct", Fallback::Captures, 0.0),
        ("ssct", Fallback::Captures, 0.6),
        ("unified", Fallback::Captures, 0.6),
    ] {
        let case = format!("{method} before {fallback:?}, roughness {roughness}");
        let method = methods::find(method).unwrap();
        let setup = Setup::new([97, 61]).with(|p: &mut EffectParams| {
            p.fallback = fallback;
            (p.captures, p.capture_side) = (captures, SIDE);
        });
        let camera = view.camera(&scene, setup.extent);
        let materials = Globals { roughness: Some(roughness), ..Globals::default() }.materials(&scene, view);
        let shot = Shot::new(&mut stage, method, &setup, Wants::REFLECTION, camera, materials).unwrap();
        let direct = image::render(&mut stage, &shot, false).unwrap();
        let data = gbuffer::read(&mut stage.context, &shot).unwrap();
        let path = folder.join("child.exr");
        std::fs::write(&path, gbuffer_file::encode(&data, &path).unwrap()).unwrap();
        let data = gbuffer_file::load(&path).unwrap();
        let beside = gbuffer::reflect(&gpu, &data, Some(&cubes), method, &setup).unwrap();
        let bits = |image: &ssct::gpu::Pixels| image.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(bits(&beside.composite) == bits(&direct.composite), "{case}: composite");
        assert!(bits(&beside.reflection) == bits(&direct.reflection), "{case}: reflection");
        if method.is_screen_space() && fallback == Fallback::None {
            let alone = gbuffer::reflect(&gpu, &data, None, method, &Setup::new([97, 61])).unwrap();
            assert!(bits(&beside.composite) != bits(&alone.composite), "{case}: the captures show something");
        }
    }
    gpu.check_validation().unwrap();
}

/// A folder of captures that does not exist, lacks a face, or has a broken file is refused with a sentence, and so is a
/// method that reads no captures. No image is written.
#[test]
fn captures_beside_a_gbuffer_that_cannot_be_are_refused_in_a_sentence() {
    let folder = Folder::new();
    let room = "v -4 0 -8\nv 4 0 -8\nv 4 0 0\nv -4 0 0\nf 1 4 3 2\n";
    folder.write("room.obj", room);
    folder.succeed(&["captures", "rooms", "--captures", "1", "--capture-side", "4", "-o", "cubes"]);
    let view_options = ["--scene", "room.obj", "--eye", "0,1.5,0", "--look-at", "0,1,6", "--size", "16x16"];
    folder.succeed(&[&["gbuffer", "export", "g.exr"], &view_options[..]].concat());
    let reflect = |args: &[&str]| {
        let output = folder.run(&[&["gbuffer", "reflect", "g.exr", "-o", "x.png"], args].concat());
        let errors = String::from_utf8(output.stderr).unwrap();
        (output.status.code().unwrap(), errors)
    };
    let assert_refused = |args: &[&str], status: i32, words: &str| {
        let (code, errors) = reflect(args);
        assert!(code == status && errors.contains(words), "{args:?}: {code}, {errors}");
        assert!(!Path::new(&folder.path("x.png")).exists(), "{args:?}");
    };
    let unified = ["--method", "unified", "--captures"];
    let with_captures = |folder: &'static str| [&unified[..], &[folder]].concat();
    for wrong in ["auto", "2", "nowhere", "g.exr"] {
        assert_refused(
            &with_captures(wrong),
            2,
            &format!("--captures {wrong}: there is no such folder; a G-buffer has no scene"),
        );
    }
    assert_refused(&["--captures", "cubes"], 2, "the method ssct follows no rays in captures");
    assert_refused(
        &[&with_captures("cubes")[..], &["--capture-side", "128"]].concat(),
        2,
        "have the side that they have",
    );
    assert_refused(&["--method", "captures"], 2, "captures need the scene");
    std::fs::remove_file(folder.path("cubes/1/ny.exr")).unwrap();
    assert_refused(
        &with_captures("cubes"),
        1,
        "cubes/1/ny.exr: there is no such file, and capture 1 needs all of its six faces",
    );
    folder.write("cubes/1/ny.exr", "hello");
    assert_refused(&with_captures("cubes"), 1, "cubes/1/ny.exr: cannot be read as an OpenEXR image");
    folder.write("cubes/captures.toml", "[[capture]]\nplace = [0, 0, 0]\nside = 4\n");
    assert_refused(&with_captures("cubes"), 1, "cubes/captures.toml:3: unknown field `side`");
    std::fs::remove_file(folder.path("cubes/captures.toml")).unwrap();
    assert_refused(&with_captures("cubes"), 1, "cannot read cubes/captures.toml");
    let (code, errors) = reflect(&[&unified[..], &["none"]].concat());
    assert!(code == 0 && errors.is_empty(), "{errors}");
}

/// Draws a small G-buffer of the corridor.
fn corridor(gpu: &ssct::gpu::Gpu) -> GBufferData {
    let scene = crate::common::built_in("rooms");
    let view = scene.view("corridor").unwrap();
    let extent = [64, 36];
    let mut stage = Stage::new(gpu, &scene).unwrap();
    let globals = Globals { roughness: Some(0.1), ..Globals::default() };
    let materials = globals.materials(&scene, view);
    let camera = view.camera(&scene, extent);
    let shot = Shot::new(&mut stage, &METHODS[0], &Setup::new(extent), Wants::REFLECTION, camera, materials).unwrap();
    image::render(&mut stage, &shot, false).unwrap();
    gbuffer::read(&mut stage.context, &shot).unwrap()
}

/// A third of the pixels have colours of up to the greatest 32-bit float, and every screen-space method still makes
/// finite images. A 16-bit float of such a colour is infinite, and infinity times a weight of 0 is NaN.
#[test]
fn no_method_makes_infinity_of_colours_beyond_half_floats() {
    let gpu = gpu();
    let mut data = corridor(&gpu);
    for (index, colour) in data.color.iter_mut().enumerate() {
        // A third of the pixels are lamps, as bright as 32-bit floats allow.
        if index % 3 == 0 {
            *colour = Vec3::new(7e4, 1e9, f32::MAX);
        }
    }
    data.reflectivity.iter_mut().for_each(|value| *value = if *value > 0.0 { 1.0 } else { 0.0 });
    for method in METHODS.iter().filter(|m| m.is_screen_space()) {
        let setup = Setup::new([data.width, data.height]);
        let reflected = gbuffer::reflect(&gpu, &data, None, method, &setup).unwrap();
        for (image_name, pixels) in [("reflection", &reflected.reflection), ("composite", &reflected.composite)] {
            let infinite = pixels.values.iter().filter(|v| !v.is_finite()).count();
            assert_eq!(infinite, 0, "{}: {image_name}", method.name);
        }
    }
}

/// Very bright colours of either sign, handed over in 32-bit floats through the door, lead to finite images of every
/// screen-space method. The import converts them, and not the upload of a file.
#[test]
fn no_method_makes_infinity_of_them_behind_the_door() {
    let gpu = gpu();
    let mut engine = Engine::new(&gpu);
    let data = view_of_rooms(&gpu, [97, 61]);
    let mut foreign_gbuffer = ForeignGBuffer::new(&mut engine, &data, NATIVE);
    // A third of the pixels get a very bright value.
    let bright = |index: usize, v: f32| if index.is_multiple_of(3) { [1e9, -1e9, f32::MAX][index / 3 % 3] } else { v };
    let numbers =
        data.color.iter().enumerate().flat_map(|(index, c)| c.extend(1.0).to_array().map(|v| bright(index, v)));
    let texels: Vec<f32> = numbers.collect();
    foreign_gbuffer.color =
        engine.upload(ash::vk::Format::R32G32B32A32_SFLOAT, [97, 61], bytemuck::cast_slice(&texels));
    let context = engine.context();
    for method in METHODS.iter().filter(|m| m.is_screen_space()) {
        let mut reflections = ssct::Reflections::new(&context, &info(&data, method.name)).unwrap();
        let recorded = engine.frame(&mut reflections, &foreign_gbuffer.input()).unwrap();
        let composite = engine.read(&recorded.composite.unwrap());
        assert!(composite.values.iter().all(|v| v.is_finite()), "{}", method.name);
    }
    gpu.check_validation().unwrap();
}

/// A file with a value that is not allowed in some channel is refused with the channel, the value and the pixel.
/// Colours beyond 16-bit floats are allowed.
#[test]
fn files_in_our_own_conventions_are_checked_pixel_by_pixel() {
    let good = corridor(&gpu());
    let path = Path::new("a.exr");
    let write_and_read = |change: &dyn Fn(&mut GBufferData)| {
        let mut data = good.clone();
        change(&mut data);
        gbuffer_file::decode(&gbuffer_file::encode(&data, path).unwrap(), path)
    };
    assert!(write_and_read(&|_| ()).unwrap() == good);
    // A colour beyond the range of 16-bit floats is no mistake in a file.
    assert_eq!(write_and_read(&|d| d.color[3].x = 7e4).unwrap().color[3].x, 7e4);
    let pixel = 64 * 5 + 7;
    let message = |change: &dyn Fn(&mut GBufferData)| write_and_read(change).unwrap_err().to_string();
    let colour = "it must be a finite number from 0 on";
    let unit = "it must be a number from 0 to 1";
    for (message, expected) in [
        (message(&|d| d.color[pixel].x = f32::NAN), format!("a.exr: channel R is NaN at pixel 7, 5; {colour}")),
        (message(&|d| d.color[pixel].y = f32::INFINITY), format!("a.exr: channel G is inf at pixel 7, 5; {colour}")),
        (message(&|d| d.color[pixel].z = -1.0), format!("a.exr: channel B is -1 at pixel 7, 5; {colour}")),
        (message(&|d| d.depth[pixel] = f32::NAN), format!("a.exr: channel depth is NaN at pixel 7, 5; {unit}")),
        (message(&|d| d.depth[pixel] = 1.5), format!("a.exr: channel depth is 1.5 at pixel 7, 5; {unit}")),
        (message(&|d| d.depth[pixel] = -0.5), format!("a.exr: channel depth is -0.5 at pixel 7, 5; {unit}")),
        (message(&|d| d.roughness[pixel] = f32::NAN), format!("a.exr: channel roughness is NaN at pixel 7, 5; {unit}")),
        (message(&|d| d.roughness[pixel] = 2.0), format!("a.exr: channel roughness is 2 at pixel 7, 5; {unit}")),
        (
            message(&|d| d.reflectivity[pixel] = -0.1),
            format!("a.exr: channel reflectivity is -0.1 at pixel 7, 5; {unit}"),
        ),
        (
            message(&|d| d.normal[pixel].y = f32::NEG_INFINITY),
            "a.exr: channel N.Y is -inf at pixel 7, 5; it must be a finite number".to_owned(),
        ),
    ] {
        assert_eq!(message, expected);
    }
}

/// A file that holds a part of its image is refused, pixels beyond 16-bit floats are counted in a warning, and a
/// compression that the program does not know is named. Such files come from renderers and from later versions of
/// OpenEXR.
#[test]
fn a_piece_of_an_image_is_refused_and_bright_pixels_are_counted() {
    let mut data = corridor(&gpu());
    let folder = Folder::new();
    let whole = gbuffer_file::encode(&data, Path::new("a.exr")).unwrap();
    // The display window becomes one pixel wider, so that the stored pixels are a part of the image.
    let name = b"displayWindow\0box2i\0\x10\0\0\0";
    let column_offset = whole.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 8;
    let mut piece = whole.clone();
    piece[column_offset..column_offset + 4].copy_from_slice(&64_i32.to_le_bytes());
    folder.write("piece.exr", &piece);
    let output = folder.run(&["gbuffer", "reflect", "piece.exr", "--method", "linear", "-o", "o.exr"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let expected = "ssct: piece.exr: it has 64x36 pixels from 0, 0 on, and its image has 65x36 from 0, 0 on; only whole images \
                    can be read\n";
    assert_eq!(message, expected);
    data.color[..5].fill(Vec3::splat(1e6));
    folder.write("bright.exr", gbuffer_file::encode(&data, Path::new("a.exr")).unwrap());
    let output = folder.run(&["gbuffer", "reflect", "bright.exr", "--method", "linear", "-o", "o.exr"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(message, "ssct: warning: bright.exr: 5 pixels are brighter than 65504 and were clamped to it\n");
    assert_eq!(output.status.code(), Some(0));
    // A compression that is younger than the program is named.
    for (number, compression) in
        [(10_u8, "HTJ2K256"), (11, "HTJ2K32"), (12, "LJ2K"), (13, "ZSTD"), (99, "of number 99")]
    {
        let name = b"compression\0compression\0\x01\0\0\0";
        let compression_offset = whole.windows(name.len()).position(|w| w == name).unwrap() + name.len();
        let mut changed = whole.clone();
        changed[compression_offset] = number;
        let error = gbuffer_file::decode(&changed, Path::new("a.exr")).unwrap_err().to_string();
        assert_eq!(
            error,
            format!(
                "a.exr: its compression {compression} is not supported; save it with ZIP, ZIPS, PIZ, RLE or none (in Blender, \
                 Output, Codec: ZIP)"
            )
        );
    }
}
