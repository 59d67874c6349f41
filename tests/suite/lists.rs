//! Tests lists on the command line: a value that is named twice counts once. A table of errors also says which average
//! it shows.

use crate::common::folder::Folder;
use serde_json::Value;

/// Runs a command that must succeed, and returns its records.
fn records(folder: &Folder, arguments: &[&str]) -> Vec<Value> {
    let output = folder.run(&[arguments, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Sizes, methods, roughnesses and variants that are named twice, also in another spelling, are measured once. A
/// key that occurs twice would confuse the journal.
#[test]
fn a_value_that_a_list_names_twice_counts_once() {
    let folder = Folder::new();
    let time = ["time", "--scene", "rooms", "--samples", "2", "--warmup", "0"];
    let twice = ["--size", "17x9,17X9", "--method", "linear,linear", "--roughness", "0.1,0.10"];
    let records_found = records(&folder, &[&time[..], &twice].concat());
    assert_eq!(records_found.len(), 1, "{records_found:?}");
    assert_eq!(records_found[0]["total"]["samples"], 2);
    let variants = ["--size", "17x9", "--variant", "linear", "--variant", "linear"];
    assert_eq!(records(&folder, &[&time[..], &variants].concat()).len(), 1);
    let two = ["--size", "17x9,18x9", "--method", "linear"];
    assert_eq!(records(&folder, &[&time[..], &two].concat()).len(), 2, "different values are all measured");
}

/// The tables of errors in `error.md` say in their titles whether they show a mean or a median. The two differ, and a
/// table of numbers does not tell which it shows.
#[test]
fn each_table_of_an_error_names_its_average() {
    let folder = Folder::new();
    let run = ["error", "--scene", "rooms", "--size", "34x19", "--method", "linear", "--roughness", "0.1,0.1"];
    let run = [&run[..], &["--samples", "1", "--rays", "4", "--no-sweep", "-o", "e"]].concat();
    let output = folder.run(&run);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let page = folder.text("e/error.md");
    let titles: Vec<&str> = page.lines().filter(|l| l.starts_with("**")).collect();
    for title in titles.iter().filter(|t| t.contains("RMSE") || t.contains("Where the error comes from")) {
        assert!(title.contains("mean") || title.contains("median"), "{title}");
    }
    assert!(titles.iter().any(|t| t.contains("Where the error comes from: the median")), "{titles:?}");
}
