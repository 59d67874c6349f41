//! Tests of comparisons, with small runs and images that are made up.

use super::*;
use std::sync::Arc;

/// Makes the sample of a pass in the frame with number `sample`. All samples have the same scene, view and settings.
fn time_sample(method: &str, sample: u64, pass: &str, counted: bool, ms: f64) -> TimeSample {
    let values = [
        ("scene", "rooms"),
        ("view", "hall"),
        ("method", method),
        ("preset", "published"),
        ("width", "8"),
        ("roughness", ""),
        ("resolution_scale", "1"),
        ("cone_samples", "7"),
    ];
    let subject = Subject(values.map(|(name, value)| (name.to_owned(), value.to_owned())).into());
    TimeSample { subject: Arc::new(subject), sample, pass: pass.into(), counted, ms, floors: [None; 2] }
}

/// Makes a run of six frames of a method, with an uncounted pass and two counted passes; `scale` multiplies the time of
/// the pass `trace`.
fn run(method: &str, scale: f64) -> Run {
    let frame = |number| {
        [("lit", false, 5.0), ("trace", true, 2.0 * scale), ("composite", true, 1.0)]
            .map(|(pass, counted, ms)| time_sample(method, number, pass, counted, ms))
    };
    Run { name: method.into(), device: None, samples: (0..6).flat_map(frame).collect() }
}

#[test]
fn totals_are_sums_of_counted_passes_frame_by_frame() {
    let records = times(&run("ssct", 1.0), &run("ssct", 2.0), 0.05);
    let found: Vec<_> = records.iter().map(|r| (r.pass.as_str(), r.ratio, r.verdict)).collect();
    let (same, slower) = (Some(Verdict::Same), Some(Verdict::Slower));
    assert_eq!(
        found,
        [
            ("lit", Some(1.0), same),
            ("trace", Some(2.0), slower),
            ("composite", Some(1.0), same),
            (TOTAL, Some(5.0 / 3.0), slower)
        ]
    );
    assert!(records.iter().all(|r| (r.samples_a, r.samples_b, r.only_in) == (6, 6, None)));
}

#[test]
fn a_difference_within_the_noise_floor_leaves_the_verdict_undecided() {
    let with_floor = |scale: f64, floors: [Option<f64>; 2]| {
        let mut run = run("ssct", scale);
        run.samples.iter_mut().for_each(|s| s.floors = floors);
        run
    };
    let verdicts = |floors: [Option<f64>; 2]| {
        let records = times(&run("ssct", 1.0), &with_floor(1.2, floors), 0.05);
        ["trace", TOTAL].map(|pass| records.iter().find(|r| r.pass == pass).expect(pass).verdict)
    };
    let (undecided, slower) = (Some(Verdict::Undecided), Some(Verdict::Slower));
    assert_eq!(verdicts([None, None]), [slower, slower]);
    assert_eq!(verdicts([Some(0.3), Some(0.1)]), [undecided, slower]);
    assert_eq!(verdicts([Some(0.1), Some(0.3)]), [slower, undecided]);
    let table = cells(&times(&run("ssct", 1.0), &with_floor(1.2, [Some(0.3), None]), 0.05), false);
    let row = table.iter().find(|row| row.iter().any(|cell| cell == "trace")).expect("the pass");
    assert!(row.last().is_some_and(|verdict| verdict.starts_with("UNDECIDED by the floor, n ")), "{row:?}");
}

#[test]
fn passes_of_different_methods_are_listed_without_a_verdict() {
    let records = times(&run("ssct", 1.0), &run("hzct", 1.0), 0.05);
    assert_eq!(records.len(), 8);
    assert!(records[..4].iter().all(|r| r.only_in == Some(Side::A) && r.subject.get("method") == "ssct"));
    assert!(records[4..].iter().all(|r| r.only_in == Some(Side::B) && r.subject.get("method") == "hzct"));
    assert!(records.iter().all(|r| r.verdict.is_none() && r.ratio.is_none()));
}

#[test]
fn samples_of_one_subject_are_pooled_and_fewer_than_five_decide_nothing() {
    let mut twice = run("ssct", 1.0);
    twice.samples.extend(twice.samples.clone());
    let records = times(&twice, &run("ssct", 1.0), 0.05);
    assert_eq!(records.iter().map(|r| (r.samples_a, r.median_a_ms)).next_back(), Some((12, Some(3.0))));
    let mut few = run("ssct", 9.0);
    few.samples.truncate(4 * 3);
    let records = times(&run("ssct", 1.0), &few, 0.05);
    assert!(records.iter().all(|r| r.samples_b == 4 && r.verdict == Some(Verdict::Undecided)));
}

#[test]
fn frames_with_different_settings_are_not_compared_and_the_difference_is_named() {
    let plain = run("ssct", 1.0);
    let changed = |name: &str, value: &str| {
        let mut run = plain.clone();
        for s in &mut run.samples {
            Arc::make_mut(&mut s.subject).0.insert(name.into(), value.into());
        }
        run
    };
    for (name, before, after) in
        [("cone_samples", "7", "3"), ("resolution_scale", "1", "0.5"), ("roughness", "not set", "0.1")]
    {
        let records = times(&plain, &changed(name, after), 0.05);
        assert_eq!(
            records.iter().map(|r| r.only_in).collect::<Vec<_>>(),
            [[Some(Side::A); 4], [Some(Side::B); 4]].concat()
        );
        let expected = format!("{name} {before} in A, {after} in B");
        assert!(records.iter().all(|r| r.differs.as_ref() == Some(&expected)), "{expected}: {:?}", records[0].differs);
    }
}

#[test]
fn a_setting_that_one_file_lacks_is_ignored_with_a_warning() {
    let plain = run("ssct", 1.0);
    let mut older = plain.clone();
    for s in &mut older.samples {
        Arc::make_mut(&mut s.subject).0.remove("cone_samples");
    }
    for (a, b, whose_samples) in [(&plain, &older, "B's samples"), (&older, &plain, "A's samples")] {
        let records = times(a, b, 0.05);
        assert!(records.len() == 4 && records.iter().all(|r| r.only_in.is_none()), "{records:?}");
        assert!(records[0].warning.as_ref().is_some_and(|w| w.contains(whose_samples) && w.contains("cone_samples")));
    }
    assert!(times(&older, &older, 0.05)[0].warning.as_ref().is_some_and(|w| !w.contains("samples do not say")));
    // Settings of the other run's other methods do not count as settings of this run.
    let mut both = plain.clone();
    both.samples.extend(run("poster", 1.0).samples.into_iter().map(|mut s| {
        Arc::make_mut(&mut s.subject).0.insert("edge_retries".into(), "0".into());
        s
    }));
    assert_eq!(times(&plain, &both, 0.05).iter().filter(|r| r.only_in.is_none()).count(), 4);
}

#[test]
fn different_or_unknown_devices_give_a_warning() {
    let device = |name: &str| {
        let text = |s: &str| s.to_owned();
        Some(DeviceInfo { name: text(name), driver: text("1"), api: text("1.3"), kind: text("CPU") })
    };
    let device_run = |name: &str| Run { device: device(name), ..run("ssct", 1.0) };
    let slow = Run { device: device("x"), ..run("ssct", 1.5) };
    assert_eq!(warning(&device_run("x"), &slow), None);
    assert!(warning(&device_run("x"), &device_run("y")).is_some_and(|w| w.contains("A ran on x (1), B on y (1)")));
    assert!(warning(&device_run("x"), &run("ssct", 1.0)).is_some_and(|w| w.contains("device B")));
}

#[test]
fn errors_of_images_are_relative_to_the_first_image() {
    let flat = |v: f32| LinearImage { width: 8, height: 8, rgb: vec![[v; 3]; 64] };
    let found = images(("a", &flat(0.5)), ("b", &flat(0.25))).expect("one size");
    assert_eq!((found.rmse, found.rel_mse), (0.25, Some(0.25)));
    assert!(found.flip > 0.1 && found.rmse_map == vec![0.25; 64]);
    assert_eq!(images(("a", &flat(0.5)), ("b", &flat(0.5))).map(|c| (c.rmse, c.flip)), Some((0.0, 0.0)));
    let wide = LinearImage { width: 16, height: 4, rgb: vec![[0.0; 3]; 64] };
    assert_eq!(images(("a", &flat(0.5)), ("b", &wide)), None);
}

/// Sets the value with a name in the subject of every sample of a run.
fn with_value(mut run: Run, name: &str, value: &str) -> Run {
    for s in &mut run.samples {
        Arc::make_mut(&mut s.subject).0.insert(name.into(), value.into());
    }
    run
}

/// Makes a run of two settings that were timed in turn. All passes of the second take a fifth longer; in each third
/// turn, a load on the machine doubles the times of both.
fn two_settings() -> Run {
    let loaded = |mut run: Run, factor: f64| {
        for s in &mut run.samples {
            s.ms *= if s.sample % 3 == 0 { 2.0 * factor } else { factor };
        }
        run
    };
    let first = loaded(with_value(run("ssct", 1.0), "iterations", "1024"), 1.0);
    let second = loaded(with_value(run("ssct", 1.0), "iterations", "64"), 1.2);
    Run { samples: [first.samples, second.samples].concat(), ..run("ssct", 1.0) }
}

fn selection(text: &str) -> Selection {
    text.parse().expect(text)
}

#[test]
fn a_load_in_every_third_turn_widens_intervals_between_two_runs_and_not_within_one() {
    let run = two_settings();
    let chosen = ["ssct --iterations 1024", "--iterations=64"].map(selection);
    let records = settings(&run, &run, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert_eq!(records.len(), 4);
    for r in &records {
        let [ratio, low, high] = [r.ratio, r.low, r.high].map(|v| v.expect("a ratio"));
        assert!([ratio, low, high].iter().all(|v| (v - 1.2).abs() < 1e-9), "{r:?}");
        assert!(r.paired && r.verdict == Some(Verdict::Slower) && r.only_in.is_none());
        assert_eq!(r.setting_a.as_deref(), Some("ssct iterations 1024"));
        assert_eq!(r.setting_b.as_deref(), Some("ssct iterations 64"));
        assert_eq!((r.subject.get("scene"), r.subject.get("iterations")), ("rooms", ""));
    }
    // Two runs have no turns in common.
    let other = run.clone();
    let apart = settings(&run, &other, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert!(apart.iter().all(|r| !r.paired && r.high.is_some_and(|high| high > 2.0)), "{apart:?}");
}

#[test]
fn a_selection_picks_one_setting_or_gives_a_message() {
    // The selection `ssct` means the preset's own value of an option that it does not name.
    let run = two_settings();
    let [plain, few] = ["ssct", "ssct --iterations 64"].map(selection);
    let records = settings(&run, &run, [&plain, &few], 0.05).expect("both are there");
    assert_eq!(records[0].setting_a.as_deref(), Some("ssct iterations 1024"));
    let error_of = |a: &str, run: &Run| settings(run, run, [&selection(a), &plain], 0.05).expect_err(a);
    assert!(error_of("hzct", &run).contains("--a \"hzct\": ssct has no such setting; it has method ssct"));
    assert!(error_of("ssct --iterations 65", &run).contains("it has iterations 1024, 64; method ssct"));
    assert!(error_of("ssct --iteration 64", &run).contains("have no iteration"));
    let with_samples = |cone_samples: &str| with_value(two_settings(), "cone_samples", cone_samples).samples;
    let several = Run { samples: [with_samples("3"), with_samples("5")].concat(), ..two_settings() };
    let message = error_of("ssct --iterations 64", &several);
    assert!(message.contains("\"ssct --cone-samples 3\" and \"ssct --cone-samples 5\""), "{message}");
    for (text, why) in [("", "neither a method"), ("ssct 64", "no option stands before"), ("ssct -- 3", "no option")] {
        assert!(text.parse::<Selection>().expect_err(text).contains(why), "{text}");
    }
}

#[test]
fn selections_may_name_values_of_the_place() {
    let [smooth, rough] = ["0", "0.1"].map(|value| with_value(run("ssct", 1.0), "roughness", value).samples);
    let both = Run { samples: [smooth, rough].concat(), ..run("ssct", 1.0) };
    let chosen = ["--roughness 0", "--roughness 0.1"].map(selection);
    let records = settings(&both, &both, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert!(records.iter().all(|r| !r.paired), "they were not timed in turn");
    assert_eq!(records[0].setting_b.as_deref(), Some("ssct roughness 0.1"));
    // Selections that do not name the roughness compare each place with itself.
    let any = selection("ssct");
    assert_eq!(settings(&both, &both, [&any, &any], 0.05).expect("both are there").len(), 8);
}

#[test]
fn passes_of_one_chain_are_added_up_and_tables_begin_with_the_total_and_changed_passes() {
    let levels = |name: &str, trace: f64| {
        let passes = [("lit", false, 9.0), ("hi-z/1", true, 2.0), ("hi-z/2", true, 1.0), ("copy", true, 4.0)];
        let frame = |number| {
            let all_passes = passes.into_iter().chain([("trace", true, trace)]);
            all_passes.map(|(pass, counted, ms)| time_sample("ssct", number, pass, counted, ms)).collect::<Vec<_>>()
        };
        Run { name: name.into(), device: None, samples: (0..6).flat_map(frame).collect() }
    };
    let records = times(&levels("a", 2.0), &levels("b", 3.0), 0.05);
    let group = records.iter().find(|r| r.pass == "hi-z").expect("a group");
    assert_eq!((group.median_a_ms, group.ratio, &group.part_of), (Some(3.0), Some(1.0), &None));
    let shown = |with_parts| ordered(&records, with_parts).iter().map(|r| r.pass.as_str()).collect::<Vec<_>>();
    assert_eq!(shown(false), ["total", "trace", "copy", "hi-z", "lit"]);
    assert_eq!(shown(true), ["total", "trace", "copy", "hi-z", "hi-z/1", "hi-z/2", "lit"]);
}

#[test]
fn an_undecided_verdict_has_the_number_of_samples_that_would_decide() {
    let mut wide = run("ssct", 1.0);
    wide.samples.iter_mut().filter(|s| s.pass == "trace").for_each(|s| s.ms *= [0.7, 1.0, 1.3][s.sample as usize % 3]);
    let records = times(&run("ssct", 1.0), &wide, 0.05);
    let record_of = |pass: &str| records.iter().find(|r| r.pass == pass).expect(pass);
    let trace = record_of("trace");
    assert_eq!(trace.verdict, Some(Verdict::Undecided));
    assert!(trace.samples_to_decide.is_some_and(|n| n > 6), "{trace:?}");
    assert_eq!((record_of("composite").verdict, record_of("composite").samples_to_decide), (Some(Verdict::Same), None));
    let shown = cells(&records, false);
    let row = shown.iter().find(|row| row[6] == "trace").expect("a row");
    let expected = format!("UNDECIDED, n about {}", trace.samples_to_decide.expect("a number"));
    assert_eq!(row.last(), Some(&expected));
}

#[test]
fn a_run_or_setting_compared_with_itself_gives_a_warning() {
    let (a, b) = (run("ssct", 1.0), run("ssct", 1.0));
    let warning = |records: &[TimeComparison]| records[0].warning.clone().unwrap_or_default();
    assert!(warning(&times(&a, &b, 0.05)).contains("A and B are one run, with the same samples"));
    assert!(!warning(&times(&a, &run("ssct", 1.5), 0.05)).contains("one run"));
    let ssct = selection("ssct");
    let with_itself = settings(&a, &a, [&ssct, &ssct], 0.05).expect("it is there");
    assert!(warning(&with_itself).contains("A and B are one setting of one run"), "{with_itself:?}");
    let turns = two_settings();
    let chosen = ["--iterations 1024", "--iterations 64"].map(selection);
    let others = settings(&turns, &turns, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert!(!warning(&others).contains("one setting"), "{:?}", others[0].warning);
}

#[test]
fn records_have_the_drift_of_the_scene_passes() {
    // The whole machine is a quarter slower in B, including its scene passes.
    let slow = |mut run: Run| {
        run.samples.iter_mut().for_each(|s| s.ms *= 1.25);
        run
    };
    let records = times(&run("ssct", 1.0), &slow(run("ssct", 1.0)), 0.05);
    assert!(records.iter().all(|r| r.drift.is_some_and(|drift| (drift - 0.25).abs() < 1e-9)), "{records:?}");
    assert!(cells(&records, false)[1].contains(&"+25 %".to_owned()));
    let turns = two_settings();
    let chosen = ["--iterations 1024", "--iterations 64"].map(selection);
    let in_turn = settings(&turns, &turns, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert!(in_turn.iter().all(|r| r.drift.is_some_and(|drift| drift.abs() < 0.5)), "in turn, too: {in_turn:?}");
}

#[test]
fn settings_of_different_sizes_have_no_drift() {
    let [small, large] =
        ["16", "32"].map(|width| with_value(with_value(run("ssct", 1.0), "width", width), "height", "8"));
    let both = Run { samples: [small.samples, large.samples].concat(), ..run("ssct", 1.0) };
    let chosen = ["ssct --size 16x8", "ssct --size 32x8"].map(selection);
    let records = settings(&both, &both, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert!(records.iter().all(|r| r.drift.is_none()), "scene passes of two sizes are not the same work");
}

#[test]
fn different_settings_of_equal_runs_are_compared_without_a_warning() {
    let (turns, copy) = (two_settings(), two_settings());
    let chosen = ["--iterations 1024", "--iterations 64"].map(selection);
    let records = settings(&turns, &copy, [&chosen[0], &chosen[1]], 0.05).expect("both are there");
    assert!(!records[0].warning.clone().unwrap_or_default().contains("one run"), "{:?}", records[0].warning);
}

#[test]
fn a_selection_finds_the_column_of_a_lens_option() {
    let wide = with_value(run("ssct", 1.0), "fov_degrees", "90");
    let chosen = ["ssct --fov 90", "ssct --fov=90"].map(selection);
    assert!(settings(&wide, &wide, [&chosen[0], &chosen[1]], 0.05).is_ok());
}

/// Returns the records that compare two settings of one run, which has the samples of `runs`.
fn records_of_settings(runs: &[Run], chosen: [&str; 2]) -> Vec<TimeComparison> {
    let samples = runs.iter().flat_map(|run| run.samples.clone()).collect();
    let joined_run = Run { name: "all".into(), device: None, samples };
    let chosen = chosen.map(selection);
    settings(&joined_run, &joined_run, [&chosen[0], &chosen[1]], 0.05).expect("both are there")
}

#[test]
fn settings_that_draw_different_g_buffers_have_no_drift() {
    let beyond = |method: &str, value: &str| with_value(run(method, 1.0), "beyond", value);
    let runs = [beyond("ssct", "auto"), beyond("traced", "none"), beyond("unified", "auto"), beyond("unified", "none")];
    for (chosen, is_same_work) in [
        (["unified --beyond auto", "unified --beyond none"], false),
        (["ssct", "unified --beyond auto"], false),
        (["ssct", "traced"], false),
        (["ssct", "unified --beyond none"], true),
        (["traced", "unified --beyond auto"], true),
    ] {
        let records = records_of_settings(&runs, chosen);
        assert!(records.iter().all(|r| r.drift.is_some() == is_same_work), "{chosen:?}: {:?}", records[0].drift);
    }
    // With captures, a fallback or several bounces, rays do not go on among triangles.
    for (name, value) in [("captures", "4"), ("captures", "auto"), ("fallback", "pccm"), ("bounces", "2")] {
        let runs = [beyond("ssct", "auto"), with_value(beyond("unified", "auto"), name, value)];
        assert!(records_of_settings(&runs, ["ssct", "unified"]).iter().all(|r| r.drift.is_some()), "{name}");
    }
    // A file that is older than the parameter does not say what was drawn.
    let old = run("unified", 1.0);
    assert!(times(&old, &old, 0.05).iter().all(|r| r.drift.is_none()));
}

#[test]
fn columns_show_both_values_where_settings_differ() {
    let run_at = |roughness: &str, width: &str, view: &str| {
        let values =
            [("roughness", roughness), ("width", width), ("height", "9"), ("view", view), ("normal_deviation", "")];
        values.into_iter().fold(run("ssct", 1.0), |run, (name, value)| with_value(run, name, value))
    };
    let runs =
        [run_at("0", "16", "hall"), run_at("0.1", "16", "hall"), run_at("0", "32", "hall"), run_at("", "16", "window")];
    let labels = |chosen: [&str; 2]| records_of_settings(&runs, chosen)[0].labels();
    let rough = labels(["ssct --roughness 0 --size 16x9", "ssct --roughness 0.1"]);
    assert_eq!(rough[..4], ["rooms hall", "16x9", "0 / 0.1", "own"]);
    assert_eq!(rough[4..6], ["ssct roughness 0", "ssct roughness 0.1"]);
    let sizes = labels(["--size 16x9 --roughness 0", "--size 32x9 --roughness 0"]);
    assert_eq!(sizes[..4], ["rooms hall", "16x9 / 32x9", "0", "own"]);
    let views = labels(["--roughness 0.1 --view hall", "--roughness own --view window"]);
    assert_eq!(views[..4], ["rooms hall / rooms window", "16x9", "0.1 / own", "own"]);
}

#[test]
fn the_note_on_own_values_is_for_values_that_no_option_set() {
    let run_with_deviation =
        |value: &str| with_value(with_value(run("ssct", 1.0), "normal_deviation", value), "roughness", "0.1");
    let note = |values: [&str; 2]| {
        let chosen = values.map(|value| format!("--normal-deviation {value}"));
        let runs = values.map(|value| run_with_deviation(if value == "own" { "" } else { value }));
        note_on_own(&records_of_settings(&runs, [&chosen[0], &chosen[1]]))
    };
    assert_eq!(note(["0", "0.5"]), None);
    assert!(note(["own", "0.5"]).is_some());
}

#[test]
fn a_setting_is_named_by_the_parameters_that_its_method_reads() {
    let beyond = |method: &str, value: &str| with_value(run(method, 1.0), "beyond", value);
    let runs = [beyond("ssct", "auto"), beyond("unified", "none")];
    let names = |runs: &[Run], chosen| {
        let record = records_of_settings(runs, chosen).remove(0);
        [record.setting_a, record.setting_b].map(Option::unwrap_or_default)
    };
    assert_eq!(names(&runs, ["ssct", "unified"]), ["ssct", "unified beyond none"]);
    // Two settings of one method keep the only names that tell them apart.
    let runs = [beyond("ssct", "auto"), beyond("ssct", "none")];
    let found = names(&runs, ["ssct --beyond auto", "ssct --beyond none"]);
    assert_eq!(found, ["ssct beyond auto", "ssct beyond none"]);
}
