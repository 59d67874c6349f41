//! Tests users' mistakes: each gets one sentence and the exit status that belongs to it, and leaves no file.

use super::{EYE, folder};
use ssct::methods::METHODS;

/// Returns the users' mistakes, each with the arguments, the exit status, and words of the sentence.
fn mistakes() -> Vec<(Vec<&'static str>, i32, &'static str)> {
    // `room` draws the small room, and `aimed` draws it from a place with a direction.
    let render = |args: &[&'static str]| [&["render", "-o", "x.png"], args].concat();
    let room =
        |args: &[&'static str]| [&["render", "-o", "x.png", "--size", "16x16", "--scene", "room.obj"], args].concat();
    let aimed = |args: &[&'static str]| [room(&EYE), args.to_vec()].concat();
    let names: Vec<_> = METHODS.iter().map(|method| method.name).collect();
    let no_method = format!("no method \"magic\"; there is: {}", names.join(", ")).leak();
    vec![
        (vec![], 2, "Usage"),
        (vec!["paint"], 2, "paint"),
        (vec!["captures"], 2, "<NAME|FILE>"),
        (vec!["captures", "nowhere"], 2, "neither a built-in scene (rooms, atrium"),
        (vec!["captures", "rooms", "atrium"], 2, "rooms, atrium: only OBJ files make one scene together"),
        (vec!["captures", "room.obj", "--captures", "9"], 2, "write auto, or a number from 1 to 8"),
        (
            vec!["captures", "room.obj", "--scale", "1e-6", "--write", "x.toml"],
            2,
            "no place for a capture was found in scene",
        ),
        (vec!["render", "--scene", "room.obj"], 2, "--output"),
        (render(&["--scene", "nowhere"]), 2, "neither a built-in scene (rooms, atrium"),
        (render(&["--scene", "missing.obj"]), 1, "cannot read"),
        (render(&["--scene", "missing.obj"]), 1, "missing.obj"),
        (render(&["--scene", "missing.scene.toml"]), 1, "missing.scene.toml"),
        (render(&["--scene", "broken.obj"]), 1, "broken.obj:4: "),
        (render(&["--scene", "room.obj", "--scene", "rooms"]), 2, "room.obj, rooms: only OBJ files make one scene"),
        (aimed(&["--method", "magic"]), 2, no_method),
        (
            aimed(&["--method", "pccm", "--fallback", "pccm"]),
            2,
            "only screen-space methods have a fallback, and pccm is none",
        ),
        (
            aimed(&["--method", "ssct", "--fallback", "mirror"]),
            2,
            "[possible values: none, environment, pccm, captures, planar]",
        ),
        (room(&["--view", "nowhere"]), 2, "has no view \"nowhere\"; it has: "),
        (render(&["--size", "0x10"]), 2, "has no pixels"),
        (render(&["--size", "10x0"]), 2, "has no pixels"),
        (render(&["--size", "ten"]), 2, "write it as 960x540"),
        (render(&["--size", "4294967295x4294967295"]), 2, "at most 1073741824 pixels"),
        (render(&["--size", "10x-3"]), 2, "write it as 960x540"),
        (
            [&["render", "-o", "x.png", "--size", "999999x4", "--scene", "room.obj"], &EYE[..]].concat(),
            2,
            "each side must be 1 to",
        ),
        (aimed(&["--device", "no such device"]), 2, "no device \"no such device\"; there is: 0 "),
        (aimed(&["--device", "99"]), 2, "no device \"99\""),
        (aimed(&["--orthographic-height", "0"]), 2, "--orthographic-height 0: must be a number of metres above 0"),
        (aimed(&["--orthographic-height", "3", "--fov", "60"]), 2, "cannot be used with"),
        (
            aimed(&["--orthographic-height", "3", "--method", "ssct"]),
            2,
            "the method ssct needs a perspective, which its published formulas are made for, and the camera is orthographic; \
             these take both: local-map, pccm, environment, captures, traced, unified",
        ),
        (aimed(&["--roughness", "7"]), 2, "--roughness 7: must lie between 0 and 1"),
        (aimed(&["--roughness", "NaN"]), 2, "--roughness NaN: must lie between 0 and 1"),
        (aimed(&["--roughness", "0,0.1"]), 2, "give one --roughness"),
        (aimed(&["--reflectivity", "2"]), 2, "--reflectivity 2: must lie between 0 and 1"),
        (aimed(&["--normal-deviation", "2"]), 2, "--normal-deviation 2: must lie between 0 and 1"),
        (aimed(&["--scale", "0"]), 2, "--scale 0: must be a number above 0"),
        (aimed(&["--fov", "180"]), 2, "--fov 180: must lie between 0 and 180 degrees"),
        (aimed(&["--near", "5", "--far", "1"]), 2, "near 5 and far 1: near must be above 0 and below far"),
        (aimed(&["--near", "1", "--far", "1"]), 2, "near must be above 0 and below far"),
        (aimed(&["--near", "0"]), 2, "near must be above 0"),
        (room(&["--eye", "0,1,2"]), 2, "--look-at"),
        (room(&["--look-at", "0,1,2"]), 2, "--eye"),
        (room(&["--eye", "0,1,2", "--look-at", "0,1,2"]), 2, "the same point"),
        (room(&["--eye", "0,1", "--look-at", "0,1,2"]), 2, "write it as 1.5,0,-3"),
        (aimed(&["--view", "front"]), 2, "cannot be used with"),
        (
            [&["render", "-o", "x.jpg", "--scene", "room.obj"], &EYE[..]].concat(),
            2,
            "x.jpg: an image is written as .png or .exr",
        ),
        (vec!["gbuffer", "export", "x.png"], 2, "x.png: a G-buffer is written as .exr"),
        (vec!["gbuffer", "convert", "f", "--gbuffer-map", "m", "-o", "x.png"], 2, "a G-buffer is written as .exr"),
        (
            [&["render", "-o", "room.obj/x.png", "--size", "8x8", "--scene", "room.obj"], &EYE[..]].concat(),
            1,
            "room.obj",
        ),
        (aimed(&["--figure", "9.9"]), 2, "9.9"),
        (aimed(&["--figure", "4.10", "--method", "linear"]), 2, "a chain mask of more than 1 levels"),
        (aimed(&["--march-stride", "0"]), 2, "it takes numbers above 0 and at most 1"),
        (aimed(&["--method", "reference", "--march-stride", "0.5"]), 2, "--march-stride is not read by"),
        (aimed(&["--method", "reference", "--preset", "author"]), 2, "--preset is not read by --method reference"),
        (aimed(&["--method", "reference", "--validation"]), 2, "--validation is not read by --method reference"),
        (aimed(&["--max-rays", "16"]), 2, "--max-rays is for --method reference"),
        (aimed(&["--cache", "rays"]), 2, "--cache is for --method reference"),
        (vec!["time", "--scene", "room.obj", "--samples", "0"], 2, "--samples 0: at least one is needed"),
        (vec!["time", "--warmup", "18446744073709551615"], 2, "18446744073709551615"),
        (vec!["error", "--samples", "4294967296"], 2, "4294967296 is not in 0..=1000000"),
        (vec!["time", "--table", "captions", "--eye", "0,1,0", "--look-at", "0,1,6"], 2, "name their views"),
        (vec!["error", "--near", "5", "--far", "1"], 2, "near 5 and far 1"),
        (vec!["precision", "--scene", "rooms", "--near", "5", "--far", "1"], 2, "near 5 and far 1"),
        (vec!["error", "--time", "1", "--motion", "nosuch"], 2, "has no motion \"nosuch\""),
        (vec!["error", "--march-stride", "0.5", "--variant", "unified"], 2, "march-stride is no parameter of unified"),
        (vec!["stress", "--quick", "--case", "nosuch"], 2, "no case has \"nosuch\" in its name"),
        (vec!["time", "--table", "5.8", "--size", "10x10"], 2, "no row for 10x10; its sizes are 640x480 ("),
        (vec!["time", "--table", "5.8", "--roughness", "0.7"], 2, "each with rows of roughness 0 and 0.1"),
        (vec!["time", "--scene", "room.obj", "--method", "ssct,magic"], 2, "no method \"magic\""),
        (vec!["study", "--samples", "0", "-o", "out"], 2, "--samples 0"),
    ]
}

/// Every mistake in the list ends with its status and its sentence on standard error, prints nothing on standard
/// output, and leaves no file. A mistake that is found late would leave an empty file or a panic.
#[test]
fn a_mistake_gets_a_sentence_and_leaves_no_file() {
    let folder = folder();
    let before = folder.list(".");
    for (args, status, words) in mistakes() {
        let output = folder.run(&args);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{args:?}: {text}");
        assert!(text.contains(words), "{args:?}: {text:?} lacks {words:?}");
        assert!(output.stdout.is_empty(), "{args:?}: an error goes to standard error");
        // A sentence of this program is one line; a message of clap begins with "error:" and may explain.
        let ours = text.starts_with("ssct: ") && text.trim_end().lines().count() == 1;
        assert!(ours || text.contains("error:") || text.contains("Usage"), "{args:?}: {text}");
    }
    assert_eq!(folder.list("."), before, "nothing is left behind");
}
