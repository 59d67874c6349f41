//! The quick stress study as a gate: every method survives every case without a validation message, and
//! the judged one without a fault.

use crate::common::folder::Folder;
use serde_json::Value;

#[test]
fn every_method_survives_and_the_judged_one_passes() {
    let folder = Folder::new();
    let output = folder.run(&["stress", "--quick", "--validation", "--json", "-o", "."]);
    let said = String::from_utf8_lossy(&output.stderr);
    let report = std::fs::read_to_string(folder.path("stress.txt")).unwrap_or_default();
    assert!(output.status.success(), "{said}\n{report}");
    let records: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let of = |method: &str| records.iter().filter(|r| r["method"] == method).collect::<Vec<_>>();
    for method in ssct::methods::METHODS {
        assert!(of(method.name).len() > if method.is_screen_space() { 100 } else { 10 }, "{}", method.name);
    }
    // The counts count: the thesis's cone divides 0 by 0, and its march takes exhaustion for a hit.
    let sum = |method: &str, what: &str| of(method).iter().filter_map(|r| r[what].as_u64()).sum::<u64>();
    for what in ["nan", "inf", "negative", "exhausted"] {
        assert!(sum("ssct", what) > 0, "no {what} in ssct");
    }
    let page = folder.text("index.html");
    assert!(page.contains("Method × failure") && page.contains("rays through the corners of cells"));
}
