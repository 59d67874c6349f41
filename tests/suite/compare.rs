//! Tests `ssct compare` on runs and images whose differences are known.

use crate::common::folder::Folder;
use serde_json::Value;
use std::collections::BTreeSet;

/// The first line of a file of samples.
const HEADER: &str = "scene,view,method,preset,width,height,roughness,normal_deviation,resolution_scale,split,fallback,\
                      sample,pass,counted,ms\n";

/// Writes a run of six frames: a scene pass of 3 ms, and two counted passes, `trace` and `composite`. `trace` takes 8
/// ms, times the first factor in even frames and the second one in odd frames.
fn write_times(folder: &Folder, name: &str, method: &str, factors: [f64; 2], device: &str) {
    let mut rows = HEADER.to_owned();
    for n in 0..6 {
        for (pass, counted, ms) in
            [("lighting", false, 3.0), ("trace", true, 8.0 * factors[n % 2]), ("composite", true, 2.0)]
        {
            rows += &format!("rooms,hall,{method},published,64,36,0.1,,1,false,none,{n},{pass},{counted},{ms:.6}\n");
        }
    }
    let device = serde_json::json!({ "name": device, "driver": "1", "api": "1.3", "type": "CPU" });
    std::fs::create_dir_all(folder.path(name)).unwrap();
    folder.write(&format!("{name}/time-samples.csv"), rows);
    folder.write(&format!("{name}/time.json"), serde_json::json!([{ "device": device }]).to_string());
}

/// Writes a PNG of one colour.
fn write_png(folder: &Folder, name: &str, extent: [u32; 2], color: [u8; 3]) {
    image::RgbImage::from_pixel(extent[0], extent[1], image::Rgb(color)).save(folder.path(name)).unwrap();
}

/// Writes a 32×24 EXR whose left half has the first colour and whose right half the second.
fn write_exr(folder: &Folder, name: &str, halves: [[f32; 3]; 2]) {
    let color = |x: usize, _| halves[usize::from(x >= 16)].into();
    exr::prelude::write_rgb_file(folder.path(name), 32, 24, |x, y| -> (f32, f32, f32) { color(x, y) }).unwrap();
}

/// Runs `ssct compare`, which must succeed, and returns its standard output.
fn compare_text(folder: &Folder, args: &[&str]) -> String {
    folder.succeed(&[&["compare"], args].concat())
}

/// Returns the records of `ssct compare --json`.
fn compared(folder: &Folder, args: &[&str]) -> Vec<Value> {
    serde_json::from_str(&compare_text(folder, &[args, &["--json"]].concat())).unwrap()
}

/// Checks that a comparison fails with an exit status, and that its sentence has some words.
fn fails(folder: &Folder, args: &[&str], status: i32, words: &str) {
    let output = folder.run(&[&["compare"], args].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{args:?}: {text}");
    assert!(text.contains(words), "{args:?}: {text}");
}

/// Returns the name and the verdict of each pass; the verdict is "null" where there is none.
fn verdicts(records: &[Value]) -> Vec<(&str, &str)> {
    records.iter().map(|r| (r["pass"].as_str().unwrap(), r["verdict"].as_str().unwrap_or("null"))).collect()
}

/// The time of `trace` is multiplied by one factor in even frames and by another one in odd frames. The verdicts are
/// those that follow from the ratios and the threshold of 5 %. The fields of the total's record are those of a hand
/// computation.
#[test]
fn each_pass_and_the_total_get_a_verdict() {
    let folder = Folder::new();
    write_times(&folder, "base", "ssct", [1.0, 1.0], "gpu");
    for (factors, trace, total) in [
        ([1.0, 1.0], "SAME", "SAME"),
        ([2.0, 2.0], "SLOWER", "SLOWER"),
        ([0.5, 0.5], "FASTER", "FASTER"),
        ([0.6, 1.5], "UNDECIDED", "UNDECIDED"),
        // The trace is 8 of 10 ms: 8 % more of it are 6.4 % more in total, and 6 % are 4.8 %.
        ([1.08, 1.08], "SLOWER", "SLOWER"),
        ([1.06, 1.06], "SLOWER", "SAME"),
    ] {
        write_times(&folder, "new", "ssct", factors, "gpu");
        let records = compared(&folder, &["base", "new"]);
        let expected = [("lighting", "SAME"), ("trace", trace), ("composite", "SAME"), ("total", total)];
        assert_eq!(verdicts(&records), expected, "{factors:?}");
    }
    write_times(&folder, "new", "ssct", [2.0, 2.0], "gpu");
    let records = compared(&folder, &["base/time-samples.csv", "new"]);
    let total = &records[3];
    assert_eq!((&total["kind"], &total["definitions"]), (&"compare".into(), &3.into()));
    assert_eq!([&total["median_a_ms"], &total["median_b_ms"]], [&10.0.into(), &Value::from(18.0)]);
    assert_eq!([&total["ratio"], &total["low"], &total["high"]], [&Value::from(1.8); 3]);
    assert_eq!((&total["resamples"], &total["samples_b"]), (&2000.into(), &6.into()));
    assert_eq!((&total["warning"], &total["device_a"]["name"]), (&Value::Null, &"gpu".into()));
}

/// The bootstrap interval is the same in each run, and reaches the extreme ratios. With a threshold of 5 % the verdict
/// is UNDECIDED, and with one of 50 % it is SAME. A random seed would change verdicts from run to run.
#[test]
fn the_interval_is_the_same_every_time_and_the_threshold_moves_the_verdict() {
    let folder = Folder::new();
    write_times(&folder, "a", "ssct", [0.9, 1.1], "gpu");
    write_times(&folder, "b", "ssct", [1.1, 1.3], "gpu");
    let trace = compared(&folder, &["a", "b"])[1].clone();
    assert_eq!(trace, compared(&folder, &["a", "b"])[1]);
    // The medians of resamples reach both values of either run: the ratio goes from 1.1 / 1.1 to 1.3 / 0.9.
    let (low, high) = (trace["low"].as_f64().unwrap(), trace["high"].as_f64().unwrap());
    assert!((low - 1.0).abs() < 1e-9 && (high - 1.3 / 0.9).abs() < 1e-9, "{low} {high}");
    assert_eq!(trace["verdict"], "UNDECIDED");
    assert_eq!(compared(&folder, &["a", "b", "--threshold", "0.5"])[1]["verdict"], "SAME");
}

/// With `--fail-on-slower`, status 1 says that a total is slower by more than the threshold. Without it the status is
/// 0, and a slower pass alone changes nothing.
#[test]
fn a_slower_total_fails_where_asked() {
    let folder = Folder::new();
    write_times(&folder, "base", "ssct", [1.0, 1.0], "gpu");
    write_times(&folder, "slow", "ssct", [1.06, 1.06], "gpu");
    // The trace is slower by more than the threshold, and the total is not.
    compare_text(&folder, &["base", "slow", "--fail-on-slower"]);
    fails(&folder, &["base", "slow", "--fail-on-slower", "--threshold", "0.01"], 1, "1 total(s) are slower");
    compare_text(&folder, &["base", "slow", "--threshold", "0.01"]);
}

/// The text names two different devices, lists a pass that one run lacks, and explains the verdicts, and is written to
/// a file with the records. Times of different devices say nothing about a change of the program.
#[test]
fn the_text_warns_and_lists_what_one_run_lacks() {
    let folder = Folder::new();
    write_times(&folder, "base", "ssct", [1.0, 1.0], "old gpu");
    write_times(&folder, "new", "ssct", [1.0, 1.0], "new gpu");
    let extra = "rooms,hall,ssct,published,64,36,0.1,,1,false,none,0,resolve,true,1\n";
    folder.write("new/time-samples.csv", folder.text("new/time-samples.csv") + extra);
    let text = compare_text(&folder, &["base", "new", "-o", "out"]);
    assert!(text.contains("warning: A ran on old gpu (1), B on new gpu (1)"), "{text}");
    let (_, lacking) = text.split_once("Only in B:\n").unwrap();
    assert!(lacking.starts_with("  rooms hall  64x36  0.1  own  ssct  published  resolve\n"), "{text}");
    assert!(text.contains("2000 bootstrap resamples"), "{text}");
    assert!(text.contains("SAME: the interval lies within ±5 %. FASTER, SLOWER: it lies beyond ±5 %"), "{text}");
    let strict = compare_text(&folder, &["base", "new", "--threshold", "0.025"]);
    assert!(strict.contains("SAME: the interval lies within ±2.5 %"), "{strict}");
    assert_eq!(folder.text("out/compare.txt"), text);
    let records = compared(&folder, &["base", "new"]);
    assert!(records[0]["warning"].as_str().unwrap().contains("one device"));
    assert_eq!((&records[4]["only_in"], &records[4]["verdict"]), (&"B".into(), &Value::Null));
    let written: Vec<Value> = serde_json::from_slice(&std::fs::read(folder.path("out/compare.json")).unwrap()).unwrap();
    assert_eq!(written, records);
    std::fs::remove_file(folder.path("new/time.json")).unwrap();
    assert!(compare_text(&folder, &["base", "new"]).contains("no time.json says on which device B ran"));
}

/// A real run compared with itself has a ratio of 1 in each pass, and its total is the total that the run recorded. The
/// passes and groups are found by name in files that another command wrote.
#[test]
fn a_run_of_the_time_study_is_the_same_as_itself() {
    let folder = Folder::new();
    folder.succeed(&["time", "--size", "17x9", "--samples", "5", "--method", "ssct", "-o", "times"]);
    let records = compared(&folder, &["times", "times", "--threshold", "0.999"]);
    let timed: Value = serde_json::from_slice(&std::fs::read(folder.path("times/time.json")).unwrap()).unwrap();
    let passes = timed[0]["passes"].as_array().unwrap();
    let groups = |counted: bool| {
        let named = passes.iter().filter(|p| p["counted"] == counted).map(|p| p["name"].as_str().unwrap());
        named.filter_map(|name| name.split_once('/')).map(|(group, _)| group).collect::<BTreeSet<_>>().len()
    };
    assert_eq!(records.len(), passes.len() + groups(true) + groups(false) + 1);
    assert!(records.iter().all(|r| r["ratio"] == 1.0 && r["samples_a"] == 5), "{records:?}");
    assert!(records[0]["warning"].as_str().unwrap().contains("A and B are one run"), "{}", records[0]);
    let total = records.last().unwrap();
    let ungrouped = records.iter().filter(|r| r["part_of"].is_null()).count();
    assert!(ungrouped < records.len() - 8, "the levels of the chains are parts of three groups");
    let (found, expected) = (&total["median_a_ms"], &timed[0]["total"]["median_ms"]);
    assert!((found.as_f64().unwrap() - expected.as_f64().unwrap()).abs() < 1e-4, "{found} {expected}");
}

/// Passes of runs whose options differ are not compared; the text lists them and says which option differs. Otherwise a
/// change of an option would pass for a change of speed.
#[test]
fn runs_with_other_flags_are_no_pair() {
    let folder = Folder::new();
    let run = |name: &str, flags: &[&str]| {
        let common = ["time", "--size", "17x9", "--samples", "1", "--method", "ssct", "-o", name];
        folder.succeed(&[&common[..], flags].concat());
        folder.text(&format!("{name}/time-samples.csv"))
    };
    let plain = run("plain", &[]);
    let others = ["--normal-deviation", "0.5", "--resolution-scale", "0.5", "--fallback", "environment"];
    for (name, flags, row, differs) in [
        ("split", &["--split"][..], "  own  ssct (split)  ", "split false in A, true in B"),
        ("cone", &["--cone-samples", "3"], "  own  ssct (cone-samples 3)  ", "cone_samples 7 in A, 3 in B"),
        ("lens", &["--near", "0.2"], "  own  ssct  ", "near_m 0.1 in A, 0.2 in B"),
        (
            "others",
            &others,
            "  0.5  ssct (resolution-scale 0.5, fallback environment)  ",
            "fallback none in A, environment in B; normal_deviation not set in A, 0.5 in B; resolution_scale 1 in A, 0.5 in B",
        ),
    ] {
        let samples = run(name, flags);
        let (_header, rows) = samples.split_once('\n').unwrap();
        fails(&folder, &["plain", name], 1, "no pass in common");
        fails(&folder, &["plain", name], 1, differs);
        folder.write("both.csv", plain.clone() + rows);
        let text = compare_text(&folder, &["plain", "both.csv"]);
        let (_, only) = text.split_once("Only in B:").unwrap();
        assert!(only.contains(row) && only.contains(differs), "{text}");
    }
}

/// Errors of two images of two colours each equal a computation by hand: RMSE, relative error, greatest error and its
/// pixel, maps, and texts.
#[test]
fn images_have_the_errors_of_a_hand_computation() {
    let folder = Folder::new();
    write_exr(&folder, "a.exr", [[1.0, 2.0, 0.0], [0.5; 3]]);
    write_exr(&folder, "b.exr", [[1.0, 2.0, 3.0], [0.5; 3]]);
    let found = &compared(&folder, &["a.exr", "b.exr", "-o", "out"])[0];
    // Half of the pixels differ by 3 in one of three channels: the mean square is 9 / 6. The squares of the reference
    // are 5 in one half and 0.75 in the other, so that the relative error is 9 / 5.75.
    let close = |key: &str, expected: f64| (found[key].as_f64().unwrap() - expected).abs() < 1e-6;
    assert!(close("rmse", 1.5_f64.sqrt()) && close("rel_mse", 9.0 / 5.75), "{found}");
    assert_eq!((&found["kind"], &found["width"], &found["height"]), (&"compare-images".into(), &32.into(), &24.into()));
    let error = folder.image("out/error.png");
    assert_eq!((error.get_pixel(3, 3).0, error.get_pixel(20, 3).0), ([255; 3], [0; 3]));
    assert_eq!(folder.image("out/flip.png").dimensions(), (32, 24));
    let map = exr::prelude::read_first_flat_layer_from_file(folder.path("out/error.exr")).unwrap();
    let values: Vec<f32> = map.layer_data.channel_data.list[0].sample_data.values_as_f32().collect();
    assert!((values[0] - 3_f32.sqrt()).abs() < 1e-6 && values[31] == 0.0);
    let text = compare_text(&folder, &["a.exr", "b.exr"]);
    assert!(text.contains("1.224745") && text.contains("1.565217"), "{text}");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("greatest RMSE of a pixel 1.732051 where that pixel is 0, 0"), "{text}");
    assert!(close("greatest", 3.0_f64.sqrt()) && found["greatest_at"] == serde_json::json!([0, 0]), "{found}");
    let scale = folder.text("out/error-scale.svg");
    assert!(
        scale.starts_with("<svg") && scale.contains("the greatest, 1.732051") && scale.contains("1 or more"),
        "{scale}"
    );
    let same = compare_text(&folder, &["a.exr", "a.exr"]);
    assert_eq!((same.matches("identical").count(), same.contains("0.000000")), (4, false), "{same}");
}

/// Errors of PNG files are errors of linear light: grey of the byte 188 has its value by the sRGB curve, also beside an
/// EXR of that value.
#[test]
fn a_png_is_decoded_to_linear() {
    let folder = Folder::new();
    write_png(&folder, "black.png", [32, 24], [0; 3]);
    write_png(&folder, "white.png", [32, 24], [255; 3]);
    write_png(&folder, "grey.png", [32, 24], [188; 3]);
    // sRGB 188 by IEC 61966-2-1: ((188/255 + 0.055) / 1.055)^2.4.
    let linear = ((188.0_f64 / 255.0 + 0.055) / 1.055).powf(2.4);
    let rmse = |a: &str, b: &str| compared(&folder, &[a, b])[0]["rmse"].as_f64().unwrap();
    assert!((rmse("black.png", "grey.png") - linear).abs() < 1e-6);
    assert!((rmse("white.png", "grey.png") - (1.0 - linear)).abs() < 1e-6);
    write_exr(&folder, "grey.exr", [[linear as f32; 3]; 2]);
    let same = &compared(&folder, &["grey.png", "grey.exr"])[0];
    assert!(same["rmse"].as_f64().unwrap() < 1e-6 && same["flip"] == 0.0, "{same}");
    let black = &compared(&folder, &["black.png", "white.png"])[0];
    assert_eq!((&black["rmse"], &black["rel_mse"]), (&1.0.into(), &Value::Null));
    assert!((0.967..0.968).contains(&black["flip"].as_f64().unwrap()), "{black}");
}

/// An image with NaN has no RMSE, its pixels are magenta in the map, and the text says NaN. A maximum or a sum over
/// channels may drop NaN unseen.
#[test]
fn what_is_no_number_is_not_hidden() {
    let folder = Folder::new();
    write_exr(&folder, "a.exr", [[0.5; 3], [0.5; 3]]);
    write_exr(&folder, "nan.exr", [[0.5; 3], [f32::NAN, 0.5, 0.5]]);
    assert_eq!(compared(&folder, &["a.exr", "nan.exr", "-o", "out"])[0]["rmse"], Value::Null);
    let error = folder.image("out/error.png");
    assert_eq!((error.get_pixel(3, 3).0, error.get_pixel(20, 3).0), ([0; 3], [255, 0, 255]));
    assert!(compare_text(&folder, &["a.exr", "nan.exr"]).contains("NaN"));
}

/// Wrong arguments and broken files of `compare` each get a sentence and status 1 or 2.
#[test]
fn mistakes_are_sentences() {
    let folder = Folder::new();
    write_times(&folder, "a", "ssct", [1.0, 1.0], "gpu");
    write_times(&folder, "other", "hzct", [1.0, 1.0], "gpu");
    write_png(&folder, "small.png", [8, 8], [9; 3]);
    write_png(&folder, "large.png", [9, 8], [9; 3]);
    std::fs::create_dir(folder.path("empty")).unwrap();
    for name in ["text.txt", "broken.png", "broken.exr"] {
        folder.write(name, "no image");
    }
    fails(&folder, &["a"], 2, "two folders or images, A and B, or one folder of times with --a and --b");
    fails(&folder, &["a", "--a", "ssct"], 2, "--b");
    fails(&folder, &["a", "--a", "ssct 3", "--b", "ssct"], 2, "no option stands before \"3\"");
    fails(&folder, &["a", "--a", "ssct", "--b", "hzct"], 1, "--b \"hzct\": a has no such setting; it has method ssct");
    fails(&folder, &["small.png", "small.png", "--all"], 2, "--all: for times, not for images");
    fails(&folder, &["a", "small.png"], 2, "not one of each");
    fails(&folder, &["a", "text.txt"], 2, "text.txt: neither a folder");
    fails(&folder, &["a", "a", "--threshold", "1"], 2, "--threshold 1: ");
    fails(&folder, &["a", "a", "--threshold", "NaN"], 2, "--threshold NaN: ");
    fails(&folder, &["small.png", "small.png", "--fail-on-slower"], 2, "--fail-on-slower: for times");
    fails(&folder, &["a", "nowhere"], 1, "cannot read nowhere");
    fails(&folder, &["a", "empty"], 1, "time-samples.csv");
    fails(&folder, &["a", "other"], 1, "no pass in common");
    fails(
        &folder,
        &["small.png", "large.png"],
        1,
        "of one size are compared; small.png has 8x8 pixels, large.png has 9x8",
    );
    fails(&folder, &["small.png", "broken.png"], 1, "broken.png: cannot be decoded");
    fails(&folder, &["small.png", "broken.exr"], 1, "broken.exr: no OpenEXR image");
    fails(&folder, &["small.png", "missing.exr"], 1, "missing.exr");
    let row = "rooms,hall,ssct,published,64,36,0.1,,1,false,none,0,trace,true";
    for (content, words) in [
        (HEADER.to_owned(), "bad.csv: holds no samples"),
        ("pass,ms\ntrace,1\n".to_owned(), "bad.csv:2: no sample of a time"),
        (format!("{HEADER}{row},1\n{row},fast\n"), "bad.csv:3: no sample of a time"),
        (format!("{HEADER}{row},-1\n"), "bad.csv:2: -1 ms is no time"),
        (format!("{HEADER}{row},NaN\n"), "bad.csv:2: NaN ms is no time"),
        (format!("{HEADER}{row}\n"), "bad.csv:2: "),
    ] {
        folder.write("bad.csv", content);
        fails(&folder, &["a", "bad.csv"], 1, words);
    }
    folder.write("a/time.json", "[]");
    fails(&folder, &["a", "a"], 1, "time.json: holds no record with a device");
}

/// EXR files that claim a huge size, lack a channel or have a subsampled channel are refused with a sentence. Their
/// headers are edited byte by byte, since no library writes such files.
#[test]
fn an_exr_that_cannot_be_read_is_refused() {
    use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
    let folder = Folder::new();
    write_exr(&folder, "a.exr", [[0.5; 3]; 2]);
    // The data window's last column, 31, becomes 99999; the pixels would need 29 MB, but the header is enough.
    let mut bytes = std::fs::read(folder.path("a.exr")).unwrap();
    let name = b"dataWindow\0box2i\0";
    let column_offset = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4 + 8;
    assert_eq!(bytes[column_offset..column_offset + 4], 31_i32.to_le_bytes());
    bytes[column_offset..column_offset + 4].copy_from_slice(&99_999_i32.to_le_bytes());
    folder.write("huge.exr", bytes);
    fails(&folder, &["a.exr", "huge.exr"], 1, "huge.exr: an image of 100000x24 pixels; at most 16384");

    let flat = |name: &'static str| AnyChannel::new(name, FlatSamples::F32(vec![0.5; 8 * 8]));
    let write = |name: &str, channels: [&'static str; 3]| {
        let channels = AnyChannels::sort(channels.map(flat).into_iter().collect());
        let layer = Layer::new((8, 8), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
        Image::from_layer(layer).write().to_file(folder.path(name)).unwrap();
    };
    write("depth.exr", ["R", "G", "depth"]);
    fails(&folder, &["a.exr", "depth.exr"], 1, "depth.exr: no OpenEXR image");
    // Channel B has a name, a pixel type (2 is 32-bit float), linearity, reserved bytes, and then the samplings.
    write("coarse.exr", ["R", "G", "B"]);
    let mut bytes = std::fs::read(folder.path("coarse.exr")).unwrap();
    let start = b"chlist\0";
    let channel_offset = bytes.windows(start.len()).position(|w| w == start).unwrap() + start.len() + 4;
    assert_eq!(bytes[channel_offset..channel_offset + 18], *b"B\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0");
    (bytes[channel_offset + 10], bytes[channel_offset + 14]) = (2, 2);
    folder.write("coarse.exr", bytes);
    fails(&folder, &["a.exr", "coarse.exr"], 1, "coarse.exr: channel B is subsampled");
}

/// `time --a-a` records a noise floor. A difference below the floor is undecided, and one above it is slower, even
/// though all samples of a run are equal.
#[test]
fn a_method_timed_against_itself_knows_its_noise_floor() {
    let folder = Folder::new();
    let time =
        ["time", "--view", "corridor", "--method", "environment", "--size", "66x37", "--samples", "6", "--warmup"];
    let records: Vec<Value> = serde_json::from_str(
        &folder.succeed(&[&time[..], &["0", "--a-a", "-o", "a", "--trace", "t.json", "--json"]].concat()),
    )
    .unwrap();
    // Twelve frames, each with three spans (two of the host and the whole frame) and its passes.
    let trace: Value = serde_json::from_str(&folder.text("t.json")).unwrap();
    let passes = records[0]["passes"].as_array().unwrap().len();
    let timed = trace["traceEvents"].as_array().unwrap().iter().filter(|e| e["ph"] == "X").count();
    assert_eq!(timed, 12 * (3 + passes));
    let floor = records[0]["noise_floor"].as_f64().expect("a floor");
    assert!(floor > 0.0 && records[0]["passes"].as_array().unwrap().iter().all(|p| p["noise_floor"].is_f64()));
    // Copies of the run in which all times are equal, so that the noise floor alone decides.
    let floor = floor.max(0.06);
    let samples = folder.text("a/time-samples.csv");
    let write_run = |name: &str, ms: f64| {
        let mut reader = csv::Reader::from_reader(samples.as_bytes());
        let header = reader.headers().unwrap().clone();
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&header).unwrap();
        for row in reader.records() {
            let cell = |(column, text): (&str, &str)| match column {
                "ms" => ms.to_string(),
                "noise_floor" | "total_noise_floor" => floor.to_string(),
                _ => text.to_owned(),
            };
            writer.write_record(header.iter().zip(&row.unwrap()).map(cell)).unwrap();
        }
        std::fs::create_dir(folder.path(name)).unwrap();
        folder.write(&format!("{name}/time-samples.csv"), writer.into_inner().unwrap());
    };
    write_run("one", 1.0);
    write_run("within", 1.0 + 0.9 * floor);
    write_run("beyond", 1.0 + 1.1 * floor);
    for (other, verdict) in [("within", "UNDECIDED"), ("beyond", "SLOWER")] {
        let records = compared(&folder, &["one", other]);
        let total = records.iter().find(|r| r["pass"] == "total").unwrap();
        assert_eq!(total["verdict"], verdict, "{total}");
    }
}

/// Returns the pass, the ratio and the verdict in each row of a table of verdicts, as `ssct time` and `ssct compare`
/// print it.
fn rows_of_verdicts(text: &str) -> Vec<[String; 3]> {
    let rows = text.lines().skip_while(|line| !line.contains("verdict")).skip(1).take_while(|line| !line.is_empty());
    let row = |line: &str| {
        let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let from_end = |n: usize| cells[cells.len() - n].to_owned();
        [from_end(10), from_end(7), from_end(1)]
    };
    rows.map(row).collect()
}

/// Variants of one run have the same verdicts at its end and in a later comparison. Two runs without a common variant
/// are refused, with the command that compares them.
#[test]
fn variants_of_one_run_are_judged_at_its_end_and_afterwards() {
    let folder = Folder::new();
    let [few, many] = ["ssct --iterations 64", "ssct --iterations 1024"];
    let time = ["time", "--view", "corridor", "--size", "66x37", "--samples", "6"];
    let run = |variants: &[&str], name: &str| {
        let named = variants.iter().flat_map(|v| ["--variant", v]).chain(["-o", name]);
        folder.succeed(&time.into_iter().chain(named).collect::<Vec<_>>())
    };
    let text = run(&[many, few], "run");
    let at_the_end = rows_of_verdicts(text.split_once("B beside A, turn by turn; SAME is within ±5 %").unwrap().1);
    let afterwards = rows_of_verdicts(&compare_text(&folder, &["run", "--a", many, "--b", few]));
    assert_eq!(at_the_end, afterwards);
    let passes: Vec<&str> = at_the_end.iter().map(|[pass, ..]| pass.as_str()).collect();
    assert_eq!(passes[0], "total", "{text}");
    assert_eq!(passes.iter().filter(|pass| pass.starts_with("hi-z")).collect::<Vec<_>>(), [&"hi-z"]);
    let opened = rows_of_verdicts(&compare_text(&folder, &["run", "--a", many, "--b", few, "--all"]));
    assert!(opened.iter().filter(|[pass, ..]| pass.starts_with("hi-z/")).count() > 3, "{opened:?}");
    // With three variants, the second and the third each have verdicts beside the first. One variant alone has none.
    let text = run(&[many, few, "hzct"], "three");
    let (_, verdicts) = text.split_once("B beside A").unwrap();
    assert_eq!(rows_of_verdicts(verdicts).iter().filter(|[pass, ..]| pass == "total").count(), 2, "{verdicts}");
    assert!(!run(&[few], "few").contains("B beside A"));
    run(&[many], "many");
    // Two runs that have nothing in common are refused with the words that compare them.
    let command = format!("ssct compare many few --a \"{many}\" --b \"{few}\"");
    fails(&folder, &["many", "few"], 1, &command);
    let named = compared(&folder, &["many", "few", "--a", many, "--b", few]);
    assert!(named.iter().all(|r| r["paired"] == false && r["setting_b"] == "ssct iterations 64"), "{named:?}");
}
