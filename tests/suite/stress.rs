//! The quick stress study as a gate: every method survives every case without a validation message, and the judged
//! method has no fault.

use crate::common::folder::Folder;
use serde_json::Value;

/// In one quick run with validation, each method has its cases, and known faults of `ssct` are counted. Captures in
/// hard places and hard triangles have no fault. A case that is skipped without a word would hide a crash.
#[test]
fn every_method_survives_and_the_judged_one_passes() {
    let folder = Folder::new();
    let output = folder.run(&["stress", "--quick", "--validation", "--json", "-o", "."]);
    let errors = String::from_utf8_lossy(&output.stderr);
    let report = std::fs::read_to_string(folder.path("stress.txt")).unwrap_or_default();
    assert!(output.status.success(), "{errors}\n{report}");
    let records: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let records_of = |method: &str| records.iter().filter(|r| r["method"] == method).collect::<Vec<_>>();
    for method in ssct::methods::METHODS {
        assert!(records_of(method.name).len() > if method.is_screen_space() { 100 } else { 10 }, "{}", method.name);
    }
    // Faults are found where they exist: the thesis's cone divides 0 by 0, and its march takes exhaustion for a hit.
    let sum = |method: &str, fault: &str| records_of(method).iter().filter_map(|r| r[fault].as_u64()).sum::<u64>();
    for fault in ["nan", "negative", "exhausted"] {
        assert!(sum("ssct", fault) > 0, "no {fault} in ssct");
    }
    // Values beyond 16-bit floats are clamped to the greatest of them.
    assert_eq!(sum("ssct", "inf"), 0);
    // Captures stand inside a wall, on a surface, have one texel a face, or move in each frame: no pixel is wrong, and
    // no ray is exhausted.
    let is_case = |r: &Value, words: &str| r["case"].as_str().is_some_and(|case| case.contains(words));
    let captured = records.iter().filter(|r| is_case(r, ": captures ")).collect::<Vec<_>>();
    for words in ["inside a wall", "on a surface", "1x1", "moved each frame"] {
        for method in ["unified", "captures"] {
            let cases = captured.iter().filter(|r| r["method"] == method && is_case(r, words));
            assert!(cases.count() >= 3, "{method}: {words}");
        }
    }
    for r in captured {
        assert_eq!((&r["pass"], &r["judged"]), (&true.into(), &true.into()), "{r}");
        assert_eq!([&r["nan"], &r["inf"], &r["negative"]], [0, 0, 0].map(|n: u32| Value::from(n)).each_ref(), "{r}");
        assert_eq!(r["exhausted"], 0, "{r}");
        assert_ne!(r["setup"]["captures"], "none", "{r}");
    }
    // Hard triangles, such as slivers, one plane, a closed box and holes: mirror rays end where the world reference
    // ends them.
    for words in ["one alone", "slivers", "all in one plane", "closed box", "holes", "a millimetre apart"] {
        for method in ["unified", "traced"] {
            let cases: Vec<_> = records
                .iter()
                .filter(|r| r["method"] == method && is_case(r, "triangles ") && is_case(r, words))
                .collect();
            assert!(cases.len() >= 6 && cases.iter().all(|r| r["judged"] == true), "{method}: {words}");
            assert!(cases.iter().any(|r| r["compared"].as_u64() > Some(1000)), "{method}: {words}");
        }
    }
    let page = folder.text("index.html");
    assert!(page.contains("Method × failure") && page.contains("rays through the corners of cells"));
}
