//! Tests mistakes in a map, or in the files that it names: each gets one sentence that says the mistake and its place.

use super::files::{Part, floats, halves, write_exr, write_png};
use super::named_channels;
use crate::common::folder::Folder;
use exr::meta::attribute::AttributeValue;
use exr::prelude::Compression;
use ssct_scenes::gbuffer_map::GBufferMap;

/// A map without a mistake, which reads the frame that [`folder`] writes.
pub const MAP: &str = r#"origin = "top-left"
[conventions]
world = "left"
view = "left"
[camera]
fov-y-deg = 60.0
near = 1.0
far = 10.0
eye = [0, 0, 0]
look-at = [0, 0, 1]
[depth]
channel = "Z"
kind = "view-z"
[normal]
channels = ["N.X", "N.Y", "N.Z"]
space = "world"
[roughness]
channel = "rough"
kind = "lobe"
[reflectivity]
value = 0.5
[[color]]
channels = ["R", "G", "B"]
"#;

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [4, 3];

/// Makes a folder with a frame of 4×3 pixels, and with files that do not fit the frame.
pub fn folder() -> Folder {
    let folder = Folder::new();
    // A channel with one value in all pixels.
    let flat = |value: f64| floats(vec![value; 12]);
    let names = ["Z", "N.X", "N.Y", "N.Z", "rough", "R", "G", "B", "behind", "far", "nan", "two"];
    let values = [2.0, 0.0, 0.0, -1.0, 0.25, 1.0, 0.5, 0.25, -2.0, 1e10, f64::NAN, 2.0];
    let frame = Part::new(named_channels(&names, values.map(flat)))
        .with("lens", AttributeValue::F32(60.0))
        .with("scene", AttributeValue::Text("corridor".into()));
    write_exr(&folder.path("f.exr"), SIZE, vec![frame]);
    let left = Part::new(named_channels(&["R", "Z"], [flat(1.0), flat(2.0)])).named("left");
    let right = Part::new(named_channels(&["R"], [flat(1.0)])).named("right");
    write_exr(&folder.path("parts.exr"), SIZE, vec![left, right]);
    write_exr(&folder.path("small.exr"), [2, 2], vec![Part::new(named_channels(&["R"], [floats(vec![1.0; 4])]))]);
    let b44 = Part::new(named_channels(&["R"], [halves(vec![1.0; 12])])).compressed(Compression::B44);
    write_exr(&folder.path("b44.exr"), SIZE, vec![b44]);
    write_exr(&folder.path("piece.exr"), SIZE, vec![piece()]);
    write_png(&folder.path("p.png"), SIZE, |_| [1.0; 3]);
    folder.write("text.exr", "hello");
    folder
}

/// Returns a part of 4×3 pixels that does not begin where the image does.
fn piece() -> Part {
    let mut part = Part::new(named_channels(&["R"], [floats(vec![1.0; 12])]));
    part.attributes.layer_position = exr::prelude::Vec2(1, 0);
    part
}

/// Returns the error about [`MAP`] with some changes, without the path of the folder. Each change is a piece of the map
/// and the text that replaces it.
pub fn map_error(folder: &Folder, changes: &[(&str, &str)]) -> String {
    let map = changes.iter().fold(MAP.to_owned(), |map, (piece, replacement)| {
        assert!(map.contains(piece), "{piece} is in the map");
        map.replacen(piece, replacement, 1)
    });
    folder.write("map.toml", map);
    let result = GBufferMap::load(&folder.path("map.toml")).and_then(|map| map.read(&folder.path("f.exr")));
    let error = result.err().unwrap_or_else(|| panic!("{changes:?} is read")).to_string();
    error.replace(&format!("{}/", folder.root().display()), "")
}

/// The good map is read. Each change of one piece (old text, new text, beginning of the sentence) is refused with one
/// sentence that has the line. Most mistakes are found after parsing, when the line is easily lost.
#[test]
fn a_mistake_in_the_map_has_its_line() {
    let folder = folder();
    folder.write("map.toml", MAP);
    GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path("f.exr")).unwrap();
    for (from, to, sentence) in [
        ("kind = \"lobe\"", "kind = lobe", "map.toml:19: "),
        (
            "[roughness]",
            "[rouhness]",
            "map.toml:17: unknown field `rouhness`, expected one of `origin`, `view`, `conventions`",
        ),
        ("origin = \"top-left\"", "origin = \"left\"", "map.toml:1: unknown variant `left`"),
        (
            "channel = \"rough\"\n",
            "chanel = \"rough\"\n",
            "map.toml:17: [roughness]: channel is missing: name 1 channel of the file, or give a value",
        ),
        (
            "kind = \"lobe\"",
            "kind = \"lobe\"\nflip = true",
            "map.toml:20: [roughness]: there is no key \"flip\" here; there are kind, file, part, channel, value, \
             scale, offset",
        ),
        (
            "kind = \"view-z\"\n",
            "",
            "map.toml:11: [depth]: kind is missing: one of \"reversed\", \"standard\", \"minus-one-to-one\", \
             \"view-z\", \"distance\", \"distance-from-near\"",
        ),
        (
            "kind = \"view-z\"",
            "kind = \"z\"",
            "map.toml:13: [depth]: kind must be one of \"reversed\", \"standard\", \"minus-one-to-one\", \"view-z\", \
             \"distance\", \"distance-from-near\", not \"z\"",
        ),
        (
            "world = \"left\"",
            "world = 1",
            "map.toml:3: [conventions]: world must be one of \"left\", \"right\", \"right-z-up\", \"left-z-up\", \"right-y-down\", not 1",
        ),
        (
            "channels = [\"N.X\", \"N.Y\", \"N.Z\"]",
            "channels = [\"N.X\", \"N.Y\"]",
            "map.toml:15: [normal]: 2 channels are named, not 3",
        ),
        (
            "channels = [\"N.X\", \"N.Y\", \"N.Z\"]",
            "channels = 3",
            "map.toml:15: [normal]: channels must be the name of a channel or a list of names, not a number",
        ),
        (
            "value = 0.5",
            "value = [1, 2]",
            "map.toml:21: [reflectivity]: value must be a finite number or three, not [1, 2]",
        ),
        (
            "value = 0.5",
            "value = 0.5\nfile = \"p.png\"",
            "map.toml:20: [reflectivity]: file and part go with channels, not with a value",
        ),
        (
            "value = 0.5",
            "value = 0.5\nchannel = \"R\"",
            "map.toml:20: [reflectivity]: there is a channel and a value; one of them is enough",
        ),
        (
            "[reflectivity]\nvalue = 0.5\n",
            "",
            "map.toml: there is neither [reflectivity] nor [metallic] with [base-color]",
        ),
        ("[reflectivity]", "[metallic]", "map.toml: there is no [base-color]"),
        (
            "[reflectivity]",
            "[f0]\nvalue = 0.04\n[reflectivity]",
            "map.toml:20: [f0] is read beside [metallic], and there is none",
        ),
        (
            "[reflectivity]",
            "[metallic]\nvalue = 1\n[reflectivity]",
            "map.toml:20: [metallic]: there is [reflectivity] already",
        ),
        ("[[color]]", "[color]", "map.toml:22: colours are listed as [[color]] ("),
        ("[[color]]\nchannels = [\"R\", \"G\", \"B\"]\n", "", "map.toml: there is no [[color]]"),
        (
            "fov-y-deg = 60.0\n",
            "",
            "map.toml:5: [camera]: no lens is given: say one of fov-y-deg, fov-x-deg, fov-y-rad, fov-x-rad, \
             orthographic-height, orthographic-width, projection, or focal-length-mm with sensor-width-mm or sensor-height-mm",
        ),
        ("fov-y-deg = 60.0", "fov-y-deg = 60.0\nfov-x-deg = 90.0", "map.toml:5: [camera]: more than one lens is given"),
        (
            "fov-y-deg = 60.0",
            "focal-length-mm = 50.0",
            "map.toml:5: [camera]: focal-length-mm goes with one of sensor-width-mm and sensor-height-mm",
        ),
        (
            "fov-y-deg = 60.0",
            "fov-y-deg = \"wide\"",
            "map.toml:6: [camera]: fov-y-deg must be a finite number or { attribute = \"…\" }, not \"wide\"",
        ),
        ("far = 10.0\n", "", "map.toml:5: [camera]: far is missing: the distance of the far plane"),
        (
            "far = 10.0\n",
            "far = 0.5\n",
            "map.toml:5: [camera]: a field of view of 60° from top to bottom, planes at 1 m and 0.5 m and an aspect \
             of 1.3333334 cannot be used",
        ),
        (
            "look-at = [0, 0, 1]\n",
            "",
            "map.toml:5: [camera]: the camera's place is world-to-view, or view-to-world, or eye with look-at or \
             forward (and up)",
        ),
        (
            "eye = [0, 0, 0]\nlook-at = [0, 0, 1]\n",
            "",
            "map.toml:5: [camera]: normals in world space need the camera's place",
        ),
        (
            "look-at = [0, 0, 1]",
            "look-at = [0, 0, 0]",
            "map.toml:10: [camera]: look-at gives no direction of view, or one along up",
        ),
        (
            "eye = [0, 0, 0]\nlook-at = [0, 0, 1]",
            "world-to-view = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]",
            "map.toml:9: [camera]: world-to-view has a scale or a skew: a camera has neither",
        ),
        (
            "eye = [0, 0, 0]\nlook-at = [0, 0, 1]",
            "world-to-view = [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]",
            "map.toml:9: [camera]: world-to-view is no rotation and translation: is it in the other order (matrices \
             of [conventions])?",
        ),
        (
            "eye = [0, 0, 0]\nlook-at = [0, 0, 1]",
            "world-to-view = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]",
            "map.toml:9: [camera]: world-to-view mirrors the world: world or view of [conventions] must be another one",
        ),
        (
            "eye = [0, 0, 0]\nlook-at = [0, 0, 1]",
            "world-to-view = [1, 2]",
            "map.toml:9: [camera]: world-to-view must be 16 finite numbers or { attribute = \"…\" }, not [1, 2]",
        ),
        (
            "view = \"left\"",
            "view = \"left\"\nmetres-per-unit = 0",
            "map.toml:2: [conventions]: metres-per-unit must be above 0, not 0",
        ),
        (
            "kind = \"view-z\"",
            "kind = \"view-z\"\nnear = 1",
            "map.toml:11: [depth]: view-z and distances have no near and far; those are the camera's",
        ),
        (
            "kind = \"view-z\"",
            "kind = \"reversed\"\nnear = 1",
            "map.toml:11: [depth]: near and far go together; far = inf is one at infinity",
        ),
        (
            "kind = \"view-z\"",
            "kind = \"reversed\"\nnear = 2\nfar = 1",
            "map.toml:11: [depth]: near must be above 0 and far above near, not 2 and 1",
        ),
    ] {
        let text = map_error(&folder, &[(from, to)]);
        assert!(text.starts_with(sentence) && text.lines().count() == 1, "{to}:\n{text}\n{sentence}");
    }
}

/// A matrix of projection that contradicts a convention of the map is refused with the name of that convention.
#[test]
fn a_projection_that_does_not_go_with_the_conventions_is_named() {
    let folder = folder();
    // A matrix with near plane 1, far plane 10 and a right angle of view, for reversed depth, a left-handed view and y
    // up.
    let reversed = "projection = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -0.1111111, 1, 0, 0, 1.1111111, 0]";
    let planes = "near = 1.0\nfar = 10.0\n";
    for (projection, others, sentence) in [
        (
            reversed,
            ("view = \"left\"", "view = \"right\""),
            "looks backwards: view of [conventions] must be another one",
        ),
        (reversed, ("view = \"left\"", "view = \"left\"\nclip-y = \"down\""), "has the image upside down"),
        (
            reversed,
            ("kind = \"view-z\"", "kind = \"standard\""),
            "gives reversed depth, and kind of [depth] says otherwise",
        ),
        (
            reversed,
            ("view = \"left\"", "matrices = \"rows\""),
            "is neither a perspective projection, whose last row is 0, 0, ±1, 0, nor an orthographic one",
        ),
        (reversed, (planes, "aspect = 1.5\n"), "a projection says the aspect and the shift itself; leave them out"),
        (
            "projection = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0]",
            (planes, ""),
            "has its far plane at infinity: say far",
        ),
    ] {
        let text = map_error(&folder, &[("fov-y-deg = 60.0", projection), others]);
        assert!(text.contains(sentence) && text.contains("[camera]: "), "{text}");
        let line = text.strip_prefix("map.toml:").unwrap().split(':').next().unwrap();
        assert!(["6", "7"].contains(&line), "{text}");
    }
}

/// A channel, part, file or attribute that does not exist is refused with the names that exist. Files of another size,
/// or with lossy depth, are refused, too.
#[test]
fn what_the_files_lack_is_named_with_what_they_have() {
    let folder = folder();
    let depth = ("channel = \"Z\"\n", "channel = \"Depth.Z\"\n");
    let color = "channels = [\"R\", \"G\", \"B\"]";
    for (from, to, sentence) in [
        (
            depth.0,
            depth.1,
            "map.toml:12: there is no channel Depth.Z in f.exr, which has B, G, N.X, N.Y, N.Z, R, Z, behind, far, \
             nan, rough, two",
        ),
        (
            color,
            "part = \"rgb\"\nchannels = [\"R\", \"G\", \"B\"]",
            "map.toml:24: there is no part \"rgb\" in f.exr, which has no parts with a name",
        ),
        (color, "file = \"none.exr\"\nchannels = [\"R\", \"G\", \"B\"]", "map.toml:24: there is no file none.exr"),
        (color, "file = \"text.exr\"\nchannels = \"R\"", "text.exr: is neither an OpenEXR nor a PNG image"),
        (
            depth.0,
            "file = \"b44.exr\"\nchannel = \"R\"\n",
            "map.toml:13: channel R of b44.exr was rounded by b44 compression; depth, normals and sky must be compressed \
             without loss (in Blender, Output, Codec: ZIP)",
        ),
        (color, "file = \"small.exr\"\nchannels = \"R\"", "map.toml:24: small.exr has 2x2 pixels, and f.exr has 4x3"),
        (
            color,
            "file = \"parts.exr\"\nchannels = \"R\"",
            "map.toml:24: channel R is in several parts of parts.exr: say which by part, one of left, right",
        ),
        (
            color,
            "file = \"parts.exr\"\npart = \"both\"\nchannels = \"R\"",
            "map.toml:25: there is no part \"both\" in parts.exr, which has left, right",
        ),
        (
            color,
            "file = \"parts.exr\"\npart = \"right\"\nchannels = \"Z\"",
            "map.toml:25: there is no channel Z in parts.exr, which has right.R",
        ),
        (
            color,
            "file = \"piece.exr\"\nchannels = \"R\"",
            "piece.exr: it has 4x3 pixels from 1, 0 on, and its image has 4x3 from 0, 0 on; only whole images can be \
             read",
        ),
        (
            color,
            "file = \"p.png\"\nchannels = [\"R\", \"G\", \"X\"]",
            "map.toml:24: there is no channel X in p.png, which has A, B, G, R",
        ),
        (
            "fov-y-deg = 60.0",
            "fov-y-deg = { attribute = \"fov\" }",
            "map.toml:6: [camera]: fov-y-deg: there is no attribute \"fov\" in f.exr, which has lens, \
             pixelAspectRatio, scene, screenWindowWidth",
        ),
        (
            "fov-y-deg = 60.0",
            "fov-y-deg = { attribute = \"scene\" }",
            "map.toml:6: [camera]: fov-y-deg: the attribute \"scene\" is not one finite number",
        ),
        (
            "fov-y-deg = 60.0",
            "fov-y-deg = { name = \"lens\" }",
            "map.toml:6: [camera] fov-y-deg: there is no key \"name\" here; there are attribute, file, part",
        ),
    ] {
        assert_eq!(map_error(&folder, &[(from, to)]), sentence, "{to}");
    }
    let elsewhere = MAP
        .replace("channel = ", "file = \"f.exr\"\nchannel = ")
        .replace("channels = ", "file = \"f.exr\"\nchannels = ");
    folder.write("map.toml", elsewhere);
    let map = GBufferMap::load(&folder.path("map.toml")).unwrap();
    assert!(map.read(&folder.path("f.exr")).is_ok(), "a name may be that of the main file");
    let text = map.read(&folder.path("other.exr")).unwrap_err().to_string();
    assert!(text.contains("map.toml: the map takes nothing from ") && text.ends_with("without `file`"), "{text}");
}

/// A value that is not allowed is refused with its section, value, pixel, channel and file. In pixels of sky, materials
/// are not read.
#[test]
fn values_that_cannot_be_are_named_with_their_pixel() {
    let folder = folder();
    for (from, to, sentence) in [
        (
            "channel = \"Z\"",
            "channel = \"behind\"",
            "map.toml:11: [depth]: it is -2 at pixel 0, 0 (behind of f.exr); it must not be nearer than the near \
             plane, unless sky-value says that it is sky",
        ),
        (
            "channel = \"Z\"",
            "channel = \"nan\"",
            "map.toml:11: [depth]: it is NaN at pixel 0, 0 (nan of f.exr); it must not be nearer than the near plane, \
             unless sky-value says that it is sky",
        ),
        (
            "kind = \"view-z\"",
            "kind = \"reversed\"",
            "map.toml:11: [depth]: it is 2 at pixel 0, 0 (Z of f.exr); it must lie in 0 to 1",
        ),
        (
            "channels = [\"N.X\", \"N.Y\", \"N.Z\"]",
            "channels = [\"N.X\", \"nan\", \"N.Z\"]",
            "map.toml:14: [normal]: it is NaN at pixel 0, 0 (N.X, nan, N.Z of f.exr); it must be finite",
        ),
        (
            "channel = \"rough\"",
            "channel = \"two\"",
            "map.toml:17: [roughness]: it is 2 at pixel 0, 0 (two of f.exr); it must lie in 0 to 1 (scale and offset \
             can take it there)",
        ),
        (
            "channel = \"rough\"\nkind = \"lobe\"",
            "channel = \"behind\"\nkind = \"phong-exponent\"",
            "map.toml:17: [roughness]: it is -2 at pixel 0, 0 (behind of f.exr); it must be a number from 0 on",
        ),
        (
            "value = 0.5",
            "value = 5.5",
            "map.toml:20: [reflectivity]: it is 5.5; it must lie in 0 to 1 (scale and offset can take it there)",
        ),
        (
            "channels = [\"R\", \"G\", \"B\"]",
            "channels = [\"R\", \"G\", \"nan\"]",
            "map.toml:22: [[color]]: it is NaN at pixel 0, 0 (R, G, nan of f.exr); it must be finite",
        ),
    ] {
        assert_eq!(map_error(&folder, &[(from, to)]), sentence, "{to}");
    }
    // In pixels of sky, the values of materials do not matter.
    let all_sky = [("channel = \"Z\"", "channel = \"far\""), ("channel = \"rough\"", "channel = \"two\"")];
    let map = all_sky.iter().fold(MAP.to_owned(), |map, (from, to)| map.replacen(from, to, 1));
    folder.write("map.toml", map);
    let gbuffer = GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path("f.exr")).unwrap();
    assert!(gbuffer.depth.iter().chain(&gbuffer.roughness).all(|v| *v == 0.0));
    // A surface without a normal does not reflect.
    let without_normals =
        MAP.replace("channels = [\"N.X\", \"N.Y\", \"N.Z\"]", "channels = [\"N.X\", \"N.X\", \"N.X\"]");
    folder.write("map.toml", without_normals);
    let gbuffer = GBufferMap::load(&folder.path("map.toml")).unwrap().read(&folder.path("f.exr")).unwrap();
    assert!(gbuffer.reflecting().iter().all(|reflects| !reflects) && gbuffer.depth.iter().all(|d| *d > 0.0));
}

/// `gbuffer reflect` and `gbuffer convert` end with status 1 and the sentence about the map, and write no image.
#[test]
fn the_command_ends_with_the_sentence() {
    let folder = folder();
    folder.write("map.toml", MAP.replace("kind = \"lobe\"", "kind = \"rough\""));
    for command in [&["gbuffer", "reflect", "f.exr"][..], &["gbuffer", "convert", "f.exr"]] {
        let out = ["--gbuffer-map", "map.toml", "-o", "x.exr"];
        let output = folder.run(&[command, &out[..]].concat());
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(
            errors.starts_with("ssct: map.toml:19: [roughness]: kind must be one of") && errors.lines().count() == 1
        );
        let output = folder.run(&[command, &["--gbuffer-map", "none.toml", "-o", "x.exr"]].concat());
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(1) && errors.starts_with("ssct: cannot read none.toml: "), "{errors}");
        assert!(!folder.path("x.exr").exists());
    }
}
