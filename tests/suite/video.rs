//! Tests `ssct video`: films of variants beside that of the world reference, compared with still images of the same
//! frames.

use crate::common::folder::Folder;
use serde_json::Value;
use std::fs::File;

/// The options of a small view of the rooms.
const SMALL_VIEW: [&str; 11] =
    ["--scene", "rooms", "--view", "corridor", "--size", "96x54", "--roughness", "0.1", "--rays", "4", "--json"];

/// Returns the records of a command on the small view.
fn records(folder: &Folder, command: &str, more: &[&str]) -> Vec<Value> {
    serde_json::from_str(&folder.succeed(&[&[command], &SMALL_VIEW[..], more].concat())).unwrap()
}

/// Returns the records of `ssct video` on the small view.
fn films(folder: &Folder, more: &[&str]) -> Vec<Value> {
    records(folder, "video", more)
}

/// Returns a number of a record by the name of its field.
fn number(record: &Value, name: &str) -> f64 {
    record[name].as_f64().unwrap_or_else(|| panic!("no {name} in {record}"))
}

/// With the camera at rest, each frame of two variants has the error of the still image, and nothing flickers. A film
/// that prepared a frame differently would have another error.
#[test]
fn at_rest_every_frame_is_the_still_image() {
    let folder = Folder::new();
    let variants = ["--variant", "ssct", "--variant", "unified --captures 1"];
    let still = records(&folder, "error", &[&variants[..], &["--samples", "1"]].concat());
    let records = films(&folder, &[&variants[..], &["--way", "rest", "--frames", "3"]].concat());
    assert_eq!(records.len(), 2);
    for (record, method) in records.iter().zip(["ssct", "unified"]) {
        assert_eq!((&record["method"], &record["way"]), (&method.into(), &"rest".into()));
        let is_match = |r: &&Value| r["method"] == method && r["against"] == "world";
        let still = still.iter().find(is_match).unwrap();
        let frames = record["frames"].as_array().unwrap();
        assert_eq!(frames.len(), 3);
        for frame in frames {
            assert_eq!(frame["rmse"], still["rmse"], "{method}");
            assert!((number(frame, "flip") - number(still, "flip")).abs() < 1e-6, "{method}: {frame}");
        }
        // Nothing changes, so nothing flickers.
        let changes = ["flicker", "reference_flicker", "change_error"].map(|name| number(record, name));
        assert!(changes.iter().all(|v| *v < 1e-6), "{method}: {changes:?}");
        assert!(number(record, "jod") < 9.9 && number(record, "jod_reflection") < number(record, "jod"), "{record}");
    }
    let [ssct, unified] = [&records[0], &records[1]].map(|r| number(r, "jod"));
    assert!(unified > ssct, "with what the screen lacks, {unified}, and without, {ssct}");
}

/// A walk of four frames: frames differ, a history lowers the flicker, clips have their frames, the page shows the
/// clips, and `--resume` films nothing again. A clip of equal frames would look like a film.
#[test]
fn a_walk_is_kept_as_records_clips_and_a_page() {
    let folder = Folder::new();
    let options = ["--way", "walk", "--frames", "4", "--variant", "stochastic", "--variant", "stochastic --history on"];
    let records = films(&folder, &[&options[..], &["-o", "out"]].concat());
    for record in &records {
        assert!(number(record, "reference_flicker") > 0.0 && number(record, "flicker") > 0.0, "{record}");
        let rmse: Vec<f64> = record["frames"].as_array().unwrap().iter().map(|f| number(f, "rmse")).collect();
        assert!((rmse.iter().sum::<f64>() / 4.0 - number(record, "rmse")).abs() < 1e-12);
        assert!(rmse.windows(2).all(|pair| pair[0] != pair[1]), "each frame is another: {rmse:?}");
    }
    // A history lags behind, and flickers less.
    let [plain, averaged] = [&records[0], &records[1]].map(|r| number(r, "flicker"));
    assert!(averaged < plain, "{averaged}, {plain}");
    let page = folder.text("out/index.html");
    let stem = "rooms-corridor-walk-96x54-r0.1";
    for name in ["world", "stochastic", "stochastic-history-on"] {
        let file = format!("clips/{stem}-{name}.webp");
        assert!(page.contains(&format!("src=\"{file}\"")), "{file}");
        let bytes = std::fs::read(folder.path(&format!("out/{file}"))).unwrap();
        let frames: Vec<_> = webp_animation::Decoder::new(&bytes).unwrap().into_iter().collect();
        assert_eq!((frames.len(), frames[0].dimensions()), (4, (96, 54)), "{file}");
        assert!(frames.windows(2).all(|pair| pair[0].data() != pair[1].data()), "{file} moves");
    }
    let rows =
        csv::Reader::from_reader(File::open(folder.path("out/video-frames.csv")).unwrap()).into_records().count();
    assert_eq!(rows, 8, "a row a frame");
    // With --resume, films that the folder has are not made again, and their records are the same.
    let again = films(&folder, &[&options[..], &["-o", "out", "--resume"]].concat());
    assert_eq!(again, records);
}

/// With a ball that moves, each frame has another error, and the world reference flickers, too. A reference of the
/// ball's first place would not flicker.
#[test]
fn what_moves_is_filmed_where_it_is() {
    let folder = Folder::new();
    let options = ["--way", "rest", "--frames", "3", "--variant", "ssct"];
    let moving = films(&folder, &[&options[..], &["--moving", "ball", "--step", "0.1,0,0"]].concat());
    let frames = moving[0]["frames"].as_array().unwrap();
    assert!(frames.windows(2).all(|pair| pair[0]["rmse"] != pair[1]["rmse"]), "{frames:?}");
    assert_eq!((&moving[0]["moving"][0], moving[0]["step_m"][0].as_f64()), (&"ball".into(), Some(0.1)));
    assert!(number(&moving[0], "reference_flicker") > 0.0);
}

/// Paths, rates, meshes and options that do not exist or do not fit are refused with status 2 and the option's name,
/// before anything is filmed.
#[test]
fn what_cannot_be_filmed_is_refused_in_a_sentence() {
    let folder = Folder::new();
    for (flags, expected) in [
        (&["--way", "nowhere"][..], "--way nowhere: neither a path of scene rooms"),
        (&["--way", "views"], "--way: a path says where the camera is"),
        (&["--way", "rest", "--fps", "0"], "--fps 0: must lie between 1 and 1000"),
        (&["--way", "rest", "--moving", "nobody", "--step", "1,0,0"], "has no mesh of this name"),
        (&["--way", "rest", "--variant", "ssct --no-such-flag"], "--no-such-flag"),
        (&["--way", "rest", "--variant", "ssct --stochastic-rays 2"], "stochastic-rays"),
        (&["--moving", "ball"], "--step"),
        (&["--step", "1,0,0"], "--moving"),
    ] {
        let output = folder.run(&[&["video"], &SMALL_VIEW[..], flags].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains(expected), "{flags:?}: {errors}");
    }
}
