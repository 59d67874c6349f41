//! Tests `ssct render --pixel` and `--dump`: the report on a pixel agrees with the images, and a dump holds the
//! recorded images and no others.

use crate::common::folder::Folder;
use crate::common::repository;
use serde_json::Value;
use ssct::passes::PathCode;

/// A mirror floor before a wall, and a plate that hangs between the camera and the wall.
const ROOM: &str = "o floor\nv -4 0 -8\nv 4 0 -8\nv 4 0 0\nv -4 0 0\nf 1 4 3 2\n\
                    o wall\nv -4 0 -6\nv 4 0 -6\nv 4 4 -6\nv -4 4 -6\nf 5 6 7 8\n\
                    o plate\nv -4 1.1 -3\nv 4 1.1 -3\nv 4 1.6 -3\nv -4 1.6 -3\nf 9 10 11 12\n";
/// Size of the images in pixels.
const SIZE: [u32; 2] = [64, 48];

/// Makes a folder with the room.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("room.obj", ROOM);
    folder
}

/// Returns the arguments of `render` on the room, followed by `more`.
fn args<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let place = ["--scene", "room.obj", "--eye", "0,1.5,0", "--look-at", "0,1,6", "--size", "64x48"];
    [&["render"], &place[..], more].concat()
}

/// Returns the report of `render` on a pixel ("X,Y") as JSON, with further options.
fn report_on(folder: &Folder, pixel: &str, more: &[&str]) -> Value {
    let output = folder.succeed(&args(&[&["--pixel", pixel, "--json"], more].concat()));
    let records: Value = serde_json::from_str(&output).unwrap();
    records[0]["pixel"].clone()
}

/// Returns the numbers of a JSON list.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Returns the channel of a name in an OpenEXR image, in rows from the top.
fn channel(folder: &Folder, file: &str, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_first_flat_layer_from_file(folder.path(file)).unwrap();
    let list = &image.layer_data.channel_data.list;
    let found = list.iter().find(|c| c.name == *name).unwrap_or_else(|| panic!("{file} has no channel {name}"));
    found.sample_data.values_as_f32().collect()
}

/// For four methods, the report on a floor pixel has the walk of its ray and three ends: by the method, the oracle and
/// the triangles. Its colours add up to the image within the rounding of 16-bit floats. A twin on the CPU makes the
/// report, and may differ from the device.
#[test]
fn a_pixel_of_every_method_with_a_twin_is_explained_from_its_walk_to_its_colour() {
    let folder = folder();
    for (method, more) in [("ssct", &[][..]), ("hzct", &[]), ("unified", &["--beyond", "none"]), ("stochastic", &[])] {
        let flags = [&["--method", method, "--roughness", "0"], more].concat();
        let report = report_on(&folder, "32,44", &flags);
        assert_eq!((&report["method"], &report["surface"]["mesh"]), (&method.into(), &"floor".into()), "{report}");
        let colors = &report["colors"];
        let [lit, reflection, image] = ["lit", "reflection", "image"].map(|name| numbers(&colors[name]));
        let added = colors["reflectivity"].as_f64().unwrap() * colors["fade"].as_f64().unwrap();
        for c in 0..3 {
            // The image is stored in 16-bit floats.
            assert!((lit[c] + added * reflection[c] - image[c]).abs() < 2e-3, "{method}: {colors}");
        }
        let walk = &report["walk"];
        assert!(walk["steps"].as_u64().unwrap() > 0 && walk["last"]["cell"].is_array(), "{method}: {walk}");
        assert!(report["method_end"]["end"].is_string(), "{method}: {report}");
        assert!(report["oracle_end"]["end"].is_string(), "{method}: {report}");
        assert!(report["world_end"]["mesh"].is_string(), "{method}: {report}");
    }
}

/// If a plate hides the true end of the ray, the report names the plate and the verdict. The text has at most 24 lines
/// of 100 characters.
#[test]
fn the_report_fits_a_screen_and_names_what_hides_the_place() {
    let folder = folder();
    // Rays from far places of the floor end on the wall below the plate, and rays from near places above it; between
    // them, they end behind the plate.
    let flags = ["--method", "unified", "--beyond", "none", "--roughness", "0"];
    let reports = (28..40).map(|y| report_on(&folder, &format!("32,{y}"), &flags));
    let hidden: Vec<Value> = reports.filter(|report| report["world_end"]["hidden_by"] == "plate").collect();
    let found = hidden.get(hidden.len() / 2).expect("a ray ends behind the plate");
    let causes = found["why"].to_string();
    assert!(
        causes.contains("the ray meets wall after") && causes.contains("is hidden behind plate, at 3.0"),
        "{causes}"
    );
    assert_eq!(found["verdict"], "wrong by the world", "{found}");
    let pixel = numbers(&found["pixel"]);
    let picked = format!("{},{}", pixel[0], pixel[1]);
    let text = folder.succeed(&args(&[&["--pixel", &*picked][..], &flags].concat()));
    assert!(text.lines().count() <= 24 && text.lines().all(|line| line.chars().count() <= 100), "{text}");
    for part in ["wrong by the world", "hidden behind plate", "fade", "oracle", "last cell", "by world", "in a PNG"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let printed = folder.succeed(&args(&["--pixel", &picked, "--explain", "-o", "a.png"]));
    assert!(printed.contains("recorded  trace+cone") && printed.contains(&format!("pixel {}, {}", pixel[0], pixel[1])));
}

/// A pixel outside the image is refused with its range. For sky and for a surface without reflectivity, the report says
/// why nothing is reflected.
#[test]
fn pixels_outside_and_pixels_without_reflection_get_a_sentence() {
    let folder = folder();
    let outside = folder.run(&args(&["--pixel", "64,3"]));
    let sentence = String::from_utf8_lossy(&outside.stderr).into_owned();
    assert_eq!(outside.status.code(), Some(2), "{sentence}");
    assert!(sentence.contains("64,3") && sentence.contains("64x48") && sentence.contains("63,47"), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    let up = ["--scene", "room.obj", "--eye", "0,1.5,0", "--look-at", "0,9,1", "--size", "64x48"];
    // A view that shows sky alone also gets a warning on standard error.
    let output = folder.run(&[&["render", "--pixel", "32,0", "--json"], &up[..]].concat());
    assert!(output.status.success(), "{output:?}");
    let sky = serde_json::from_slice::<Value>(&output.stdout).unwrap()[0]["pixel"].clone();
    assert_eq!(sky["why"][0], "The pixel does not reflect: it shows the sky.", "{sky}");
    assert!(sky["oracle_end"].is_null() && sky["world_end"].is_null() && sky["walk"].is_null(), "{sky}");
    let dull = report_on(&folder, "32,44", &["--reflectivity", "0"]);
    assert_eq!(dull["verdict"], "does not reflect");
    assert_eq!(dull["why"][0], "The pixel does not reflect: the reflectivity of floor is 0 there.", "{dull}");
    let incomplete = folder.run(&args(&["--pixel", "3"]));
    assert!(String::from_utf8_lossy(&incomplete.stderr).contains("write it as 480,270"));
}

/// For mirrors, a dump of `unified` has the pyramid and no colour chain; with gloss it has the chain. Fronts of blocks
/// are depths, and the top of the pyramid is the nearest depth. An image that no pass wrote would show old memory.
#[test]
fn a_dump_has_what_was_recorded_and_no_more() {
    let folder = folder();
    let flags = ["--method", "unified", "--beyond", "none", "--roughness", "0", "--json", "--explain", "--dump", "d"];
    let record: Value = serde_json::from_str(&folder.succeed(&args(&flags))).unwrap();
    let passes = record[0]["recorded"].to_string();
    assert!(passes.contains("\"pyramid\"") && !passes.contains("\"color/"), "{passes}");
    assert!(record[0]["prepared"].is_object() && record[0]["skipped"].is_array(), "--explain with --json: {record}");
    let names = folder.list("d");
    let count = |stem: &str| names.iter().filter(|name| name.starts_with(stem) && name.ends_with(".exr")).count();
    // 64 pixels are halved six times down to one, so that the pyramid has seven levels.
    assert_eq!((count("color-"), count("pyramid-")), (1, 7), "{names:?}");
    let [front, back] = ["front", "back"].map(|name| channel(&folder, "d/pyramid-0.exr", name));
    let depth = channel(&folder, "d/depth.exr", "depth");
    let covered = depth.iter().zip(&front).zip(&back).filter(|((depth, _), _)| **depth > 0.0);
    assert!(covered.clone().count() > 1000 && covered.clone().all(|((d, f), b)| d == f && b <= f), "fronts are depths");
    let top = channel(&folder, "d/pyramid-6.exr", "front");
    assert_eq!(top, [depth.iter().copied().fold(0.0, f32::max)], "the top is the nearest of all");
    // With gloss, colours are read from the chain, so that the dump has the chain.
    folder.succeed(&args(&["--method", "unified", "--beyond", "none", "--roughness", "0.3", "--dump", "g"]));
    assert!(folder.list("g").contains(&"color-6.png".to_owned()));
}

/// The example method's own chain of depth is dumped, and its top level is the nearest depth of the image.
#[test]
fn a_method_from_a_folder_dumps_the_chains_that_it_reads() {
    let folder = folder();
    let method = crate::common::repository().join("examples/methods/three-pass");
    folder.succeed(&args(&["--method", method.to_str().unwrap(), "--dump", "d"]));
    let names = folder.list("d");
    assert!(
        ["hi-z-max-reversed-0.exr", "hi-z-max-reversed-6.png"].iter().all(|n| names.contains(&(*n).to_owned())),
        "{names:?}"
    );
    let depth = channel(&folder, "d/depth.exr", "depth");
    let top = channel(&folder, "d/hi-z-max-reversed-6.exr", "depth");
    assert_eq!(top, [depth.iter().copied().fold(0.0, f32::max)]);
}

/// At four pixels, the fade of a dump is that of the report, and both agree on whether the pixel reflects. The page
/// docs/dump.md explains each path code and each file.
#[test]
fn verdicts_and_fade_of_a_dump_agree_with_what_is_said_of_a_pixel() {
    let folder = folder();
    let flags = ["--method", "ssct", "--roughness", "0"];
    folder.succeed(&args(&[&flags[..], &["--dump", "d"]].concat()));
    let verdict = channel(&folder, "d/verdict.exr", "verdict");
    let fade = channel(&folder, "d/fade.exr", "fade");
    let picture = folder.image("d/verdict.png");
    let verdict_names = ["does not reflect", "right", "wrong by the screen", "wrong by the world"];
    for (x, y) in [(32, 46), (5, 40), (60, 36), (32, 2)] {
        let report = report_on(&folder, &format!("{x},{y}"), &flags);
        let index = (y * SIZE[0] + x) as usize;
        assert_eq!(fade[index] as f64, report["colors"]["fade"].as_f64().unwrap(), "fade at {x}, {y}");
        let dumped_verdict = verdict_names[verdict[index] as usize];
        assert_eq!(report["verdict"] == "does not reflect", dumped_verdict == "does not reflect", "{x}, {y}");
        assert_eq!(picture.get_pixel(x, y).0 == [0; 3], dumped_verdict == "does not reflect", "{x}, {y}");
    }
    for (legend, words) in
        [("paths-legend.svg", "hit by the Hi-Z traversal"), ("verdict-legend.svg", "wrong by the world")]
    {
        let text = folder.text(&format!("d/{legend}"));
        assert!(text.starts_with("<svg") && text.contains(words) && text.contains(" pixels, "), "{text}");
    }
    let page = std::fs::read_to_string(crate::common::repository().join("docs/dump.md")).unwrap();
    for number in 0..=16 {
        let words = PathCode::from_channel(number as f32).unwrap().words();
        assert!(page.contains(&format!("| {number} | {words} |\n")), "docs/dump.md does not explain {number}, {words}");
    }
    for name in folder.list("d") {
        let (stem, _) = name.rsplit_once('.').unwrap();
        let stem = stem.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('-');
        assert!(page.contains(&format!("`{stem}")), "docs/dump.md does not name {stem}");
    }
}

/// The pixel that the README takes as an example, and another one, are wrong by the screen, with the cause that the
/// texts name. A change of the method may make the example right.
#[test]
fn the_pixel_that_the_readme_explains_is_wrong() {
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let readme_pixel = readme.split("--pixel ").nth(1).unwrap().split(' ').next().unwrap();
    // The ray of the second pixel ends at the right place in a window, where the references show the environment along
    // the ray.
    for (pixel, cause) in [(readme_pixel, "The method's ray hits"), ("480,204", "The ray ends right, and its colour")] {
        let report = Folder::new().succeed(&["render", "--view", "corridor", "--pixel", pixel]);
        let one_line = report.replace('\n', " ");
        assert!(one_line.contains("wrong by the screen") && one_line.contains(cause), "{pixel}: {report}");
    }
}

/// If a reflection is wrong by its fade alone, the report names this cause first. With the fade off, the reflection is
/// right.
#[test]
fn a_fade_that_is_the_only_cause_is_named_first() {
    let causes = |more: &[&str]| {
        let pixel =
            ["render", "--view", "corridor", "--size", "320x180", "--roughness", "0", "--pixel", "20,150", "--json"];
        let report: Value = serde_json::from_str(&Folder::new().succeed(&[&pixel[..], more].concat())).unwrap();
        report[0]["pixel"]["why"].clone()
    };
    let faded = causes(&[]);
    assert!(faded[0].as_str().unwrap().contains("wrong by the fade at the picture's border alone"), "{faded}");
    assert_eq!(faded.to_string().matches("fade").count(), 1, "{faded}");
    let whole = causes(&["--fade", "off"]);
    assert!(whole[0].as_str().unwrap().starts_with("The reflection is right"), "{whole}");
}

/// A view in which one wall fills everything gets a warning, and another view from the same place gets none. A user
/// would otherwise take the image for a fault.
#[test]
fn a_view_that_options_place_before_a_wall_gets_a_warning() {
    let folder = folder();
    let place = ["render", "--scene", "room.obj", "--eye", "0,3,5.5", "--size", "64x48", "-o", "a.png", "--look-at"];
    let warned = |look_at: &str| {
        let output = folder.run(&[&place[..], &[look_at]].concat());
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stderr).contains("warning: --eye and --look-at: the view sees nothing but one")
    };
    assert_eq!([warned("0,3,6"), warned("0,0,6")], [true, false]);
}
