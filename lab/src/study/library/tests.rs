//! Tests of the library, with made-up runs whose figures are known.

use super::changes::{changes, totals_only};
use super::read::{are_records, record};
use super::trends::trends;
use super::*;
use crate::study::compare::{Run, Subject, TOTAL, TimeSample, times};
use serde_json::{Value as Json, json};
use ssct_truth::metrics::bootstrap::Verdict;
use std::sync::Arc;

fn device(name: &str) -> Json {
    json!({ "name": name, "driver": "1", "api": "1.3", "type": "other" })
}

/// Makes a record of a time, as this version of the program writes it.
fn time_record(device_name: &str, view: &str, method: &str, ms: f64) -> Json {
    json!({
        "kind": "time", "definitions": 2, "version": "0.1.0", "commit": "c", "device": device(device_name),
        "scene": "rooms", "view": view, "method": method, "preset": "published", "width": 64, "height": 36,
        "roughness": 0.1, "setup": { "fov_degrees": 74.0, "roughness": 0.1 }, "total": { "median_ms": ms },
    })
}

/// Makes a run of the library from some records, without samples of its frames.
fn run(name: &str, records: &[Json]) -> LibraryRun {
    let mut run = LibraryRun {
        name: name.into(),
        date: "2026-11-24".into(),
        dated_by: DatedBy::Folder,
        files: Vec::new(),
        has_page: false,
        programs: Vec::new(),
        definitions: vec![2],
        devices: Vec::new(),
        measurements: Vec::new(),
        stress: None,
        samples: None,
        notes: Vec::new(),
    };
    for json in records {
        let read = record(json).expect("a whole record");
        let index = run.devices.iter().position(|d| *d == read.device).unwrap_or_else(|| {
            run.devices.push(read.device.clone());
            run.devices.len() - 1
        });
        run.measurements.extend(read.measurements.into_iter().map(|m| Measurement { device: index, ..m }));
    }
    run
}

/// The quantity of a trend, the indices of its runs, and its lines: the method and its value in each run.
type TrendValues = (Quantity, Vec<usize>, Vec<(String, Vec<Option<f64>>)>);

/// Finds the trends of a library, with times divided by those of `ssct`.
fn trend_values(library: &[LibraryRun]) -> Vec<TrendValues> {
    let lines = |t: &trends::Trend| t.lines.iter().map(|l| (l.method.clone(), l.values.clone())).collect();
    trends(library, "ssct").iter().map(|t| (t.quantity, t.runs.clone(), lines(t))).collect()
}

#[test]
fn a_time_is_divided_by_that_of_the_base_method_in_its_run_and_lines_have_medians_over_views() {
    let library_run = |factor: f64, ratios_of_unified: [f64; 3]| {
        let views = ["a", "b", "c"].into_iter().zip(ratios_of_unified);
        let records = views.flat_map(|(view, ratio)| {
            let ssct = time_record("gpu", view, "ssct", 10.0 * factor);
            [ssct, time_record("gpu", view, "unified", 10.0 * factor * ratio)]
        });
        run("r", &records.collect::<Vec<_>>())
    };
    // The second machine is ten times as slow, which must not change any ratio.
    let library = [library_run(1.0, [0.5, 0.75, 2.0]), library_run(10.0, [0.5, 0.25, 0.5])];
    let expected = vec![("unified".to_owned(), vec![Some(0.75), Some(0.5)])];
    assert_eq!(trend_values(&library), [(Quantity::Time, vec![0, 1], expected)]);
}

#[test]
fn runs_with_different_devices_views_settings_or_definitions_share_no_line() {
    let pair = |device: &str, view: &str| {
        run("r", &[time_record(device, view, "ssct", 10.0), time_record(device, view, "unified", 5.0)])
    };
    assert_eq!(trend_values(&[pair("one", "a"), pair("two", "a")]), [], "devices");
    assert_eq!(trend_values(&[pair("one", "a"), pair("one", "b")]), [], "views");
    // In a run with two devices, times are divided by the base method's time on the same device.
    let merged = run("r", &[time_record("one", "a", "ssct", 10.0), time_record("two", "a", "unified", 5.0)]);
    assert_eq!(trend_values(&[merged.clone(), merged]), [], "a ratio across devices");
    let mut other = time_record("one", "a", "unified", 5.0);
    other["roughness"] = 0.3.into();
    let other = run("r", &[other, time_record("one", "a", "ssct", 10.0)]);
    assert_eq!(trend_values(&[pair("one", "a"), other]), [], "roughness");
    let mut older = time_record("one", "a", "unified", 5.0);
    older["definitions"] = 1.into();
    let older = run("r", &[older, time_record("one", "a", "ssct", 10.0)]);
    assert_eq!(trend_values(&[pair("one", "a"), older]), [], "definitions");
    // Another value of a parameter makes another method.
    let mut varied = time_record("one", "a", "unified", 5.0);
    varied["setup"]["resolution_scale"] = 0.5.into();
    let varied = run("r", &[varied, time_record("one", "a", "ssct", 10.0)]);
    assert_eq!(trend_values(&[pair("one", "a"), varied]), [], "parameters");
    assert_eq!(trend_values(&[pair("one", "a"), pair("one", "a")]).len(), 1, "and the same is joined");
}

#[test]
fn errors_are_not_divided_by_a_base_and_a_run_without_an_error_leaves_a_gap() {
    let error = |method: &str, rmse: Option<f64>| {
        let mut record = time_record("gpu", "a", method, 1.0);
        let fields = [("kind", json!("error")), ("against", json!("world")), ("rmse", json!(rmse))];
        fields.into_iter().for_each(|(name, value)| record[name] = value);
        record
    };
    let library = [
        run("1", &[error("ssct", Some(0.04)), error("unified", Some(0.02))]),
        run("2", &[error("ssct", Some(0.05)), error("unified", None)]),
        run("3", &[error("unified", Some(0.01))]),
    ];
    let lines = vec![
        ("ssct".to_owned(), vec![Some(0.04), Some(0.05), None]),
        ("unified".to_owned(), vec![Some(0.02), None, Some(0.01)]),
    ];
    assert_eq!(trend_values(&library), [(Quantity::WorldRmse, vec![0, 1, 2], lines)]);
}

#[test]
fn records_of_the_first_version_are_read_and_a_missing_field_is_named() {
    // The first version had parameters beside the setup, and some of them at the top.
    let old = json!({
        "kind": "error", "definitions": 1, "version": "0.1.0", "commit": "1a673ff7e6", "device": device("gpu"),
        "scene": "rooms", "view": "a", "method": "ssct", "preset": "author", "width": 64, "height": 36,
        "resolution_scale": 0.5, "roughness": 0.0, "normal_deviation": 0.25, "params": { "cone_samples": 3 },
        "time_ms": 12.5, "against": "oracle", "hit_agreement": 0.75, "rmse": null,
    });
    let read = record(&old).expect("read");
    assert_eq!((read.program.as_str(), read.definitions), ("0.1.0, commit 1a673ff7e6", 1));
    let figures: Vec<_> = read.measurements.iter().map(|m| (m.quantity, m.value)).collect();
    assert_eq!(figures, [(Quantity::WrongHits, 0.25), (Quantity::ErrorStudyTime, 12.5)]);
    let first = &read.measurements[0];
    assert_eq!(first.setting.other_settings, ["definitions 1", "normal_deviation 0.25"]);
    for word in ["ssct", "author", "cone-samples 3", "resolution-scale 0.5"] {
        assert!(first.method.contains(word), "{word}: {}", first.method);
    }
    // The presets of a method from a folder are not known.
    let mut folder = time_record("gpu", "a", "my/method", 1.0);
    folder["setup"]["steps"] = 12.into();
    let read = record(&folder).expect("read");
    assert_eq!(read.measurements[0].method, "my/method steps 12");
    // Rows of no method were recorded with the settings of a method.
    let mut exact_hits = time_record("gpu", "a", "exact-hits+cone", 1.0);
    exact_hits["setup"]["beyond"] = "triangles".into();
    assert_eq!(record(&exact_hits).expect("read").measurements[0].method, "exact-hits+cone");

    assert!(are_records(&[old]) && !are_records(&[]) && !are_records(&[json!({ "kind": "compare" })]));
    let error_without = |name: &str| {
        let mut record = time_record("gpu", "a", "ssct", 1.0);
        record.as_object_mut().expect("an object").remove(name);
        super::read::record(&record).expect_err(name)
    };
    assert_eq!(
        ["device", "view", "width", "kind"].map(error_without),
        ["has no device", "has no view", "has no width", "has no kind that is known"]
    );
}

/// Makes nine frames of two passes that count and one that does not; `factor` multiplies the counted times.
fn frames(device: Option<DeviceInfo>, factor: f64) -> Run {
    let values = [("scene", "rooms"), ("view", "a"), ("method", "ssct")]
        .map(|(name, value)| (name.to_owned(), value.to_owned()));
    let subject = Arc::new(Subject(values.into_iter().collect()));
    let sample = |frame: u64, pass: &str, counted, ms| TimeSample {
        subject: Arc::clone(&subject),
        sample: frame,
        pass: pass.to_owned(),
        counted,
        ms,
        floors: [Some(0.5), Some(0.02)],
    };
    let jitter = |n: u64| 1.0 + 0.01 * (n % 3) as f64;
    let frame = |n: u64| {
        [
            sample(n, "lighting", false, 50.0),
            sample(n, "trace", true, 8.0 * factor * jitter(n)),
            sample(n, "composite", true, 2.0 * factor),
        ]
    };
    Run { name: "r".into(), device, samples: (0..9).flat_map(frame).collect() }
}

#[test]
fn each_run_is_compared_with_the_last_on_its_device_as_compare_judges_the_total() {
    let gpu = |name: &str| record(&time_record(name, "a", "ssct", 1.0)).expect("read").device;
    let timed_run = |device: Option<DeviceInfo>, factor: f64| LibraryRun {
        samples: Some(totals_only(frames(device, factor))),
        ..run("r", &[])
    };
    let [one, two] = ["one", "two"].map(gpu);
    let library = [
        timed_run(Some(one.clone()), 1.0),
        timed_run(Some(two.clone()), 1.0),
        run("no samples", &[]),
        timed_run(None, 1.0),
        timed_run(Some(one.clone()), 2.0),
        timed_run(Some(two), 1.001),
    ];
    let found = changes(&library, 0.05);
    let verdicts: Vec<_> =
        found.iter().map(|c| (c.before, c.after, c.totals.iter().map(|t| t.verdict).collect::<Vec<_>>())).collect();
    assert_eq!(verdicts, [(0, 4, vec![Some(Verdict::Slower)]), (1, 5, vec![Some(Verdict::Same)])]);
    // The figures must equal those for the total in a comparison of all passes.
    let whole = times(&frames(Some(one.clone()), 1.0), &frames(Some(one), 2.0), 0.05);
    let total = whole.iter().find(|r| r.pass == TOTAL).expect("a total");
    let figures =
        |r: &crate::study::compare::TimeComparison| (r.median_a_ms, r.ratio, r.low, r.high, r.noise_floor, r.samples_b);
    assert_eq!(figures(&found[0].totals[0]), figures(total));
}
