//! Tests the command as a user meets it: exit statuses, sentences, files, and the stream on which each text is printed.

mod mistakes;

use crate::common::folder::Folder;
use crate::common::hang::wait_until;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};

/// An OBJ file with a floor and a wall.
const ROOM: &str = "o floor\nv -4 0 -8\nv 4 0 -8\nv 4 0 0\nv -4 0 0\nf 1 4 3 2\n\
                    o wall\nv -4 0 -6\nv 4 0 -6\nv 4 4 -6\nv -4 4 -6\nf 5 6 7 8\n";
/// The options of a camera that looks at the room.
const EYE: [&str; 4] = ["--eye", "0,1.5,0", "--look-at", "0,1,6"];

/// Makes a folder with two OBJ files: a mirror floor before a wall, and a file that is broken in line 4.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("room.obj", ROOM);
    folder.write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    folder
}

/// Returns the arguments of a command on the small room, followed by `args`.
fn room<'a>(command: &'a str, args: &[&'a str]) -> Vec<&'a str> {
    [&[command, "--scene", "room.obj"], &EYE[..], args].concat()
}

/// `render` writes a PNG of the size that was asked for and no other file. An EXR has the same pixels in linear light,
/// and each of four options changes the image, so that no option is dropped on its way.
#[test]
fn render_writes_the_image_at_its_size() {
    let folder = folder();
    let printed = folder.succeed(&room("render", &["--size", "53x31", "-o", "new/folder/x.png"]));
    assert_eq!(printed, "", "render says nothing");
    assert_eq!(folder.list("new/folder"), ["x.png"], "the file, and no temporary one");
    let image = folder.image("new/folder/x.png");
    assert_eq!(image.dimensions(), (53, 31));
    assert!(image.pixels().any(|p| p != image.get_pixel(0, 0)), "something is in view");

    folder.succeed(&room("render", &["--size", "53x31", "-o", "x.exr"]));
    let exr = exr::prelude::read_first_rgba_layer_from_file(
        folder.path("x.exr"),
        |size, _| vec![[0.0_f32; 4]; size.area()],
        |pixels, position, (r, g, b, a): (f32, f32, f32, f32)| pixels[position.y() * 53 + position.x()] = [r, g, b, a],
    )
    .unwrap()
    .layer_data
    .channel_data
    .pixels;
    for (linear, display) in exr.iter().zip(image.pixels()) {
        assert_eq!(
            [0, 1, 2].map(|c| ssct_ground::math::display_byte(linear[c])),
            display.0,
            "the EXR is the PNG, linear"
        );
    }

    // A method other than the default makes another image, and so does each of these flags.
    for flags in [&["--method", "hzct"][..], &["--roughness", "0.5"], &["--reflectivity", "0"], &["--fade", "off"]] {
        folder.succeed(&room("render", &[&["--size", "53x31", "-o", "y.png"], flags].concat()));
        let other = folder.image("y.png");
        assert!(other != image, "{flags:?} changes the image");
    }
}

/// Images of one pixel, one column and one row are written at their sizes. Chains of levels and divisions by a side
/// minus one fail there first.
#[test]
fn one_pixel_is_an_image() {
    let folder = folder();
    for size in ["1x1", "1x7", "7x1"] {
        folder.succeed(&room("render", &["--size", size, "-o", "x.png"]));
        let (width, height) = folder.image("x.png").dimensions();
        assert_eq!(format!("{width}x{height}"), size);
    }
}

/// With `--json`, standard output is one record, whose fields say what was drawn and which passes were recorded. Any
/// other text there would break programs that read it.
#[test]
fn json_is_all_that_goes_to_standard_output() {
    let folder = folder();
    let printed = folder.succeed(&room("render", &["--size", "53x31", "-o", "x.png", "--json", "--validation"]));
    let records: Value = serde_json::from_str(&printed).unwrap();
    let [record] = &records.as_array().unwrap()[..] else { panic!("one record: {printed}") };
    assert_eq!(record["kind"], "render");
    assert_eq!(record["definitions"], 3);
    assert_eq!((&record["width"], &record["height"]), (&53.into(), &31.into()));
    assert_eq!(record["method"], "ssct");
    assert_eq!(record["drawn"]["meshes"], 2);
    assert_eq!(record["drawn"]["triangles"], 4);
    assert_eq!(record["validation"], 0, "messages of the layers");
    let passes: Vec<_> = record["recorded"].as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect();
    assert_eq!(passes[..5], ["g-buffer/depth", "g-buffer", "lighting", "depth", "hi-z/1"]);
    assert_eq!(passes[passes.len() - 2..], ["trace+cone", "composite"]);
    assert!(!folder.succeed(&room("render", &["--size", "9x9", "-o", "x.png", "--json"])).contains("Usage"));
}

/// `--dump` writes every intermediate image and every level of the chains as PNG and EXR, and the legends. A pass whose
/// image is not registered for reading would be missing.
#[test]
fn dump_writes_every_intermediate_as_png_and_exr() {
    let folder = folder();
    folder.succeed(&room("render", &["--size", "13x6", "--dump", "dump"]));
    let chain = |name: &str, levels: u32| (0..levels).map(|n| format!("{name}-{n}")).collect::<Vec<_>>();
    let single = ["albedo", "normal", "depth", "material", "reflection", "composite", "hits", "fade", "verdict"];
    let single = single.map(str::to_owned);
    // A chain of 13 pixels has four levels: 13, 6, 3 and 1.
    let stems = [single.to_vec(), chain("color", 4), chain("hi-z", 4), chain("visibility", 4)].concat();
    let mut expected: Vec<_> = stems.iter().flat_map(|s| [format!("{s}.png"), format!("{s}.exr")]).collect();
    expected.extend(["paths.png", "paths-legend.svg", "verdict-legend.svg"].map(str::to_owned));
    expected.sort();
    assert_eq!(folder.list("dump"), expected);
    let size = |name: &str| folder.image(&format!("dump/{name}")).dimensions();
    assert_eq!([size("color-0.png"), size("hi-z-1.png"), size("visibility-3.png")], [(13, 6), (6, 3), (1, 1)]);
}

/// `render --figure` draws figures 4.4 and 4.5. In figure 4.5, Hi-Z rays are green and rays of the linear march are
/// red, which must not be swapped.
#[test]
fn figures_of_the_thesis_are_drawn() {
    let folder = folder();
    for figure in ["4.4", "4.5"] {
        folder.succeed(&room("render", &["--size", "64x48", "--figure", figure, "-o", "figure.png"]));
        let image = folder.image("figure.png");
        assert!(image.pixels().any(|p| p != image.get_pixel(0, 0)), "{figure}");
        if figure == "4.5" {
            // Rays that the floor reflects go away from the camera, and are Hi-Z rays; the wall's come towards it.
            // Returns whether some pixel has clearly more of the first channel than of the second.
            let shows =
                |brighter: usize, darker: usize| image.pixels().any(|p| p.0[brighter] > p.0[darker].saturating_add(60));
            assert!(shows(1, 0), "Hi-Z rays are green");
            assert!(shows(0, 1), "rays of the linear march are red");
        }
    }
}

/// A small run of `time` gives a record for each method, size and roughness, with the passes and totals in it, and
/// writes its files. All timings of the project's pages come from such records.
#[test]
fn time_reports_every_pass_of_every_method_and_size() {
    let folder = folder();
    let printed = folder.succeed(&room(
        "time",
        &["--size", "32x16,17x9", "--roughness", "0,0.3", "--samples", "3", "--warmup", "1", "--json", "-o", "times"],
    ));
    let records: Value = serde_json::from_str(&printed).unwrap();
    let records = records.as_array().unwrap();
    assert_eq!(records.len() % 4, 0, "methods × two sizes × two roughness values");
    assert!(records.len() >= 8);
    for r in records {
        assert_eq!((&r["kind"], &r["definitions"]), (&"time".into(), &3.into()));
        let passes = r["passes"].as_array().unwrap();
        assert!(passes.iter().all(|p| p["samples"] == 3 && p["min_ms"].as_f64().unwrap() >= 0.0), "{r}");
        let sum: f64 = passes.iter().filter(|p| p["counted"] == true).map(|p| p["min_ms"].as_f64().unwrap()).sum();
        let total = &r["total"];
        assert!(sum <= total["min_ms"].as_f64().unwrap() + 1e-9, "no sample is below the sum of the least: {r}");
        assert!(total["median_ms"].as_f64().unwrap() <= r["frame"]["p95_ms"].as_f64().unwrap(), "{r}");
        assert_eq!(passes[0]["name"], "g-buffer/depth");
        assert_eq!(passes[0]["counted"], false, "scene passes are not counted");
        assert_eq!(passes.last().unwrap()["counted"], true);
        let names: Vec<_> = passes.iter().map(|p| &p["name"]).collect();
        assert!(
            names.iter().any(|n| n
                .as_str()
                .is_some_and(|n| n.contains("composite") || n.contains("resolve") || n == "trace/mirrors")),
            "{names:?}"
        );
        assert_eq!(names, r["recorded"].as_array().unwrap().iter().collect::<Vec<_>>());
    }
    let files = [
        "cells.json",
        "index.html",
        "journal.jsonl",
        "pass-medians.csv",
        "time-samples.csv",
        "time.csv",
        "time.json",
        "time.md",
        "time.svg",
        "time.txt",
    ];
    assert_eq!(folder.list("times"), files);
    assert_eq!(folder.text("times/time.json"), printed);
    let rows = csv::Reader::from_path(folder.path("times/time-samples.csv")).unwrap().into_records().count();
    let passes: usize = records.iter().map(|r| r["passes"].as_array().unwrap().len()).sum();
    assert_eq!(rows, 3 * passes, "a row for each sample and pass");

    let text = folder.succeed(&room("time", &["--size", "17x9", "--samples", "1", "--method", "hzct"]));
    assert!(text.contains("hzct") && !text.contains("ssct"), "{text}");
}

/// A reader that closes standard output at once loses no file of a run, and the run is finished.
#[test]
fn a_closed_pipe_loses_no_file() {
    let folder = folder();
    let args = room("time", &["--size", "17x9", "--samples", "1", "--warmup", "0", "--method", "hzct", "-o", "out"]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
    let mut child = command.args(args).current_dir(folder.root()).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert!(folder.text("out/journal.jsonl").contains("finished") && folder.path("out/index.html").is_file());
}

/// A small run of `path` over a path from a file gives records and frames for each method and size, writes its files,
/// and refuses wrong paths in a sentence. The percentiles of frames per second must be ordered.
#[test]
fn a_path_gives_frames_per_second_of_each_method() {
    let folder = folder();
    let path_file =
        "[[key]]\neye = [0, 1, 0]\nlook_at = [0, 0, 3]\n[[key]]\neye = [0.5, 1, 0.5]\nlook_at = [0, 0, 3]\n";
    folder.write("way.toml", path_file);
    let args = ["--size", "32x16,17x9", "--method", "hzct,ssct", "--frames", "5", "--warmup", "1"];
    let succeed = |own: &[&str]| folder.succeed(&[&["path"], own, &args].concat());
    let printed = succeed(&["--scene", "room.obj", "--path", "way.toml", "--json", "-o", "p"]);
    let records: Value = serde_json::from_str(&printed).unwrap();
    let records = records.as_array().unwrap();
    assert_eq!(records.len(), 4, "two methods, two sizes");
    for r in records {
        assert_eq!((&r["kind"], &r["definitions"], &r["view"]), (&"path".into(), &3.into(), &"way".into()));
        let frames = r["frames"].as_array().unwrap();
        assert_eq!(frames.len(), 5);
        for f in frames {
            let value = |name: &str| f[name].as_f64().unwrap();
            assert!(value("frame_ms") > value("effect_ms") && value("effect_ms") > 0.0, "{f}");
            assert!((value("fps") * value("frame_ms") - 1000.0).abs() < 1e-3, "{f}");
        }
        let fps = |name: &str| r["fps"][name].as_f64().unwrap();
        assert!(fps("median") >= fps("p95") && fps("p95") >= fps("low_1_percent"), "{r}");
    }
    let files = [
        "cells.json",
        "index.html",
        "journal.jsonl",
        "path-frames.csv",
        "path.csv",
        "path.json",
        "path.md",
        "path.svg",
        "path.txt",
    ];
    assert_eq!(folder.list("p"), files);
    let rows = csv::Reader::from_path(folder.path("p/path-frames.csv")).unwrap().into_records().count();
    assert_eq!(rows, 4 * 5);
    let svg = folder.text("p/path.svg");
    assert_eq!(svg.matches("stroke-width=\"2\"").count(), 4, "a line a record");
    let text = succeed(&[]);
    assert!(text.contains("rooms views") && text.contains("1 % low"), "{text}");
    for (wrong, words) in
        [(["--path", "nowhere"], "neither a path of scene rooms (views"), (["--view", "corridor"], "leave out --view")]
    {
        let output = folder.run(&[&["path"][..], &wrong].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && message.contains(words), "{message}");
    }
}

/// `time --table captions` shows the frame times that the thesis prints beside the measured ones, each in the row of
/// its figure.
#[test]
fn captions_stand_beside_what_is_measured() {
    let folder = folder();
    let quick = ["--table", "captions", "--samples", "1", "--warmup", "0", "--reference-rays", "1"];
    let succeed = |own: &[&str]| folder.succeed(&[&["time"], &quick[..], own].concat());
    let table = succeed(&["--view", "window-floor"]);
    let row = table.lines().find(|l| l.starts_with("5.2")).unwrap();
    assert!(["HZCT", "2.25", "1.12", "0.50", "960 x 540"].iter().all(|w| row.contains(w)), "{row}");
    let json = succeed(&["--view", "corridor", "--json"]);
    let records: Value = serde_json::from_str(&json).unwrap();
    let kinds: Vec<_> = records.as_array().unwrap().iter().map(|r| (&r["kind"], &r["method"], &r["width"])).collect();
    let expected = [("time", "ssct"), ("reference", "reference")].map(|(k, m)| (k.into(), m.into(), 1280.into()));
    assert_eq!(kinds, expected.iter().map(|(k, m, w): &(Value, Value, Value)| (k, m, w)).collect::<Vec<_>>());
    assert!(records[1]["wall_ms"].as_f64().unwrap() > 0.0 && records[1]["rays"] == 1);
    for wrong in [["--method", "ssct"], ["--view", "ceiling"]] {
        assert_eq!(folder.run(&[&["time", "--table", "captions"][..], &wrong].concat()).status.code(), Some(2));
    }
}

/// A quick study that is killed and resumed measures nothing twice. Its page shows every image that was written, embeds
/// none twice, and links the files of records. One page gathers results of many studies, so that a part is lost easily.
#[test]
fn a_quick_study_makes_a_page_with_all_that_it_shows() {
    let folder = folder();
    // The study is killed once its journal has 40 lines, and resumed: no result is lost, and none is measured twice.
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
    let journal = || std::fs::read_to_string(folder.path("out/journal.jsonl")).unwrap_or_default();
    let mut killed = command.args(["study", "--quick", "-o", "out"]).current_dir(folder.root()).spawn().unwrap();
    wait_until(
        || "a quick study that should write 40 lines".to_owned(),
        || journal().lines().count() >= 40 || killed.try_wait().unwrap().is_some(),
    );
    killed.kill().unwrap();
    killed.wait().unwrap();
    let before = journal();
    let whole_lines = &before[..before.rfind('\n').unwrap() + 1];
    let printed = folder.succeed(&["study", "--quick", "--resume", "-o", "out"]);
    let after = journal();
    let key = |line: &str| Some(serde_json::from_str::<Value>(line).unwrap()["key"].as_str()?.to_owned());
    let mut keys: Vec<String> = after.lines().filter_map(key).collect();
    let measured = keys.len();
    keys.sort();
    keys.dedup();
    assert!(after.starts_with(whole_lines) && measured > whole_lines.lines().count() && keys.len() == measured);
    assert!(printed.contains("Table 5.8") && printed.contains("index.html"), "{printed}");
    let page = folder.text("out/index.html");
    let linked: Vec<_> = page.split("href=\"").skip(1).map(|s| s.split('"').next().unwrap()).collect();
    let linked_in = |prefix: &str| {
        let mut files: Vec<_> =
            linked.iter().filter_map(|s| s.strip_prefix(prefix)).filter(|s| !s.is_empty()).collect();
        files.sort();
        files.dedup();
        files
    };
    let images = folder.list("out/images");
    assert_eq!(linked_in("images/"), images, "every image is shown, and every image shown is there");
    // For the first two scenes: direct light, the truth, each method that the scene allows, and unified on the screen
    // alone; and four figures.
    let methods_in = |name: &str| {
        let scene = crate::common::built_in(name);
        ssct::methods::METHODS.iter().filter(|method| method.unmet_needs(&scene).is_empty()).count()
    };
    let methods = methods_in("rooms");
    assert_eq!(images.len(), 2 * 3 + methods + methods_in("atrium") + 4);
    for name in ["truth", "unified-on-the-screen", "direct-light"] {
        assert!(images.contains(&format!("rooms-cylinder-{name}.png")), "{images:?}");
    }
    assert!(page.contains("data-compare=\"ssct,truth\""));
    assert_eq!(folder.list("out/truth").len(), 2, "the next run need not trace what is there");
    let pngs = folder.list("out/error/images").into_iter().filter(|n| n.ends_with(".png"));
    // The maps of RMSE are files in the same folder, which the page does not show.
    let (maps, pngs): (Vec<_>, Vec<_>) = pngs.partition(|n| n.ends_with("-rmse.png"));
    assert_eq!(maps.len(), 4 * (methods + 1));
    assert_eq!(linked_in("error/images/"), pngs);
    assert_eq!(page.matches("src=\"data:").count(), images.len() + pngs.len(), "no picture is embedded twice");
    // The page may be sent by mail, so that it has a budget: 206 pictures of 22 kB, and 2 % more with Mesa 25, which
    // draws maps more sharply.
    assert!(page.len() < 5_000_000, "a page of {} bytes", page.len());
    // Per cell: two references, and each method and the exact hits with their FLIP maps.
    assert_eq!(pngs.len(), 4 * (2 + 2 * (methods + 1)));
    for (file, kind) in [("time.json", "time"), ("error/error.json", "error")] {
        assert!(linked.contains(&file), "{file}");
        let text = folder.text(&format!("out/{file}"));
        let records: Value = serde_json::from_str(&text).unwrap();
        let records = records.as_array().unwrap();
        assert!(!records.is_empty() && records.iter().all(|r| r["kind"] == kind), "{file}");
    }
    let files = ["error", "images", "index.html", "journal.jsonl", "time-samples.csv", "time.json", "truth"];
    assert_eq!(folder.list("out"), files);
}

/// `captures` places captures in a room and writes them as tables of a scene file. A scene file with these tables has
/// the captures at the same places, though its coordinates have another sign of z.
#[test]
fn captures_are_listed_written_and_read_again() {
    let folder = folder();
    let printed =
        folder.succeed(&["captures", "room.obj", "--captures", "2", "--json", "--write", "a.toml", "--map", "a.svg"]);
    let placed: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&placed[0]["kind"], &placed[0]["from"]), (&"capture".into(), &"placement".into()));
    assert!(placed[0]["seen"].as_f64().is_some_and(|s| s > 0.5 && s <= 1.0), "{printed}");
    assert!(folder.text("a.svg").starts_with("<svg"));
    // The records are in the program's coordinates, and the tables in those of the scene file, which are right-handed.
    let tables: toml::Table = toml::from_str(&folder.text("a.toml")).unwrap();
    let millimetres = |metres: f64| (1e3 * metres).round();
    let (written, recorded) = (&tables["capture"][0]["place"][2], &placed[0]["place"][2]);
    assert_eq!(written.as_float().map(millimetres), recorded.as_f64().map(|z| -millimetres(z)));
    folder.write("room.scene.toml", format!("[[mesh]]\nfile = 'room.obj'\n{}", folder.text("a.toml")));
    let read: Value = serde_json::from_str(&folder.succeed(&["captures", "room.scene.toml", "--json"])).unwrap();
    assert_eq!((&read[0]["place"], &read[0]["from"]), (&placed[0]["place"], &"file".into()));
    assert_eq!(read.as_array().map(Vec::len), placed.as_array().map(Vec::len));
    assert!(folder.succeed(&["captures", "room.scene.toml"]).contains("file"));
}

/// `devices` lists each device, and `--device` takes its index, or its name in upper or lower case. A number that is no
/// index is part of a name, as a user of an "RTX 4090" may type it.
#[test]
fn devices_are_listed_with_the_index_that_device_takes() {
    let folder = folder();
    let devices: Value = serde_json::from_str(&folder.succeed(&["devices", "--json"])).unwrap();
    let devices = devices.as_array().unwrap();
    assert_eq!(devices[0]["index"], 0);
    let text = folder.succeed(&["devices"]);
    assert_eq!(text.lines().count(), devices.len());
    let usable = devices.iter().find(|d| d["unsuitable"].is_null()).expect("a device that can be used");
    let (index, name) = (usable["index"].to_string(), usable["name"].as_str().unwrap());
    let mut numbers = name.split(|c: char| !c.is_ascii_digit());
    let number_in_name = numbers.rfind(|n| n.parse::<usize>().is_ok_and(|n| n >= devices.len()));
    for wanted in [index.as_str(), &name.to_uppercase()].into_iter().chain(number_in_name) {
        folder.succeed(&room("render", &["--size", "4x4", "-o", "x.png", "--device", wanted]));
    }
}

/// Help and version are printed with status 0. The parser of arguments treats them as errors inside.
#[test]
fn help_and_version_are_no_errors() {
    let folder = folder();
    for args in [&["--help"][..], &["--version"], &["render", "--help"], &["time", "--help"], &["study", "--help"]] {
        assert!(!folder.succeed(args).is_empty(), "{args:?}");
    }
}

/// Without `--scene`, the built-in rooms are drawn, so that a first try needs no files.
#[test]
fn a_built_in_scene_needs_no_files() {
    let folder = folder();
    let printed = folder.succeed(&["render", "--size", "48x27", "-o", "x.png", "--json"]);
    let records: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(records[0]["scene"], "rooms");
    let is_file = |name: &str| Path::is_file(&folder.path(name));
    assert!(is_file("x.png"));
}

/// Returns the sorted paths, from a folder, of everything below it.
fn all_below(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut to_visit = vec![folder.to_path_buf()];
    while let Some(next) = to_visit.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            found.push(path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned());
            if path.is_dir() {
                to_visit.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Names of scenes and views with `..`, separators, a zero byte or 400 letters make no file outside the folder of
/// results. Such names come from files that others wrote, and become parts of file names.
#[test]
fn names_in_files_are_no_paths() {
    let long = "x".repeat(400);
    for name in ["a/../../../../escaped/view", "..", "a\u{0}b", "a\\b", &long] {
        let folder = folder();
        // The name of a scene and a view, which a TOML text quotes as JSON does.
        let quoted = serde_json::to_string(name).unwrap();
        let scene = format!(
            "name = {quoted}\n[[mesh]]\nfile = \"room.obj\"\n[view.{quoted}]\neye = [0, 1.5, 0]\nlook_at = [0, 1, -6]\n"
        );
        folder.write("a.scene.toml", scene);
        let before = all_below(folder.root());
        let args = ["error", "--scene", "a.scene.toml", "--method", "linear", "--no-sweep", "--roughness", "0"];
        let small = ["--size", "34x19", "--rays", "4", "--samples", "1"];
        folder.succeed(&[&args[..], &small, &["-o", "out/deep"]].concat());
        let written: Vec<String> = all_below(folder.root()).into_iter().filter(|path| !before.contains(path)).collect();
        assert!(written.iter().any(|path| path.ends_with("-linear.png")), "{written:?}");
        assert!(written.iter().all(|path| *path == "out" || path.starts_with("out/deep")), "{name:?}: {written:?}");
    }
}

/// A material's name with an escape character is printed without that character. A terminal would obey the sequence
/// that it begins.
#[test]
fn names_in_files_do_not_command_the_terminal() {
    let folder = folder();
    folder.write("a.obj", format!("{ROOM}mtllib a.mtl\nusemtl \u{1b}[2Jwhite\nf 1 2 3\n"));
    folder.write("a.mtl", "newmtl m\n");
    let output = folder.run(&[&["render", "--scene", "a.obj"], &EYE[..], &["--size", "16x16", "-o", "x.png"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("is not defined in any MTL file") && !message.contains('\u{1b}'), "{message:?}");
}
