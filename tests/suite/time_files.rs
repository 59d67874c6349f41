//! Tests the files of times that scripts read: docs/definitions.md explains their columns, and its lines of Python plot
//! them. Also tests the rows of `ssct time --table 5.8`.

use crate::common::folder::Folder;
use crate::common::repository;
use serde_json::Value;
use ssct_lab::study::table::{SECONDS, sizes};
use ssct_lab::study::timing::{MEASURED, MEDIAN_COLUMNS, MEDIANS, PLACE, SAMPLES};
use std::collections::BTreeMap;
use std::process::Command;

/// Returns the section of the definitions that explains the files.
fn section() -> String {
    let text = std::fs::read_to_string(repository().join("docs").join("definitions.md")).unwrap();
    let (_, section) = text.split_once("### Files of times").expect("the section");
    section.split("\n## ").next().unwrap().to_owned()
}

/// Returns a folder with a run of two methods, its samples, and the printed text in `said.txt`.
fn run() -> Folder {
    let folder = Folder::new();
    let time = ["time", "--view", "corridor", "--method", "ssct,environment", "--size", "66x37", "--samples", "5"];
    folder.write("said.txt", folder.succeed(&[&time[..], &["-o", "run"]].concat()));
    folder
}

/// Returns the rows of a CSV file, each as a map from column name to value.
fn rows(folder: &Folder, name: &str) -> Vec<BTreeMap<String, String>> {
    let text = folder.text(name);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let by_column = |record: csv::StringRecord| header.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|record| by_column(record.unwrap())).collect()
}

/// The section on files of times names every column, and the file of samples has exactly these columns and those of the
/// settings. A new column without an explanation would leave readers guessing its unit.
#[test]
fn the_columns_are_those_that_the_definitions_explain() {
    let (folder, section) = (run(), section());
    // The first six columns of medians, from the scene to the method, need no explanation of their own.
    for name in PLACE.iter().chain(&MEASURED).chain(&MEDIAN_COLUMNS[6..]).chain(&[SAMPLES, MEDIANS]) {
        assert!(section.contains(name), "{name}");
    }
    let samples = rows(&folder, &format!("run/{SAMPLES}"));
    let records: Vec<Value> = serde_json::from_str(&folder.text("run/time.json")).unwrap();
    let settings = records.iter().flat_map(|r| r["setup"].as_object().unwrap().keys().cloned());
    let expected = PLACE.iter().chain(&MEASURED).map(|name| (*name).to_owned()).chain(settings);
    assert_eq!(
        samples[0].keys().cloned().collect::<Vec<_>>(),
        expected.collect::<std::collections::BTreeSet<_>>().into_iter().collect::<Vec<_>>()
    );
    assert!(samples.iter().all(|row| ["true", "false"].contains(&&*row["counted"]) && row["noise_floor"].is_empty()));
}

/// The medians in the file of medians, by groups of passes, are the numbers in the printed table. The two are written
/// by different code from the same samples.
#[test]
fn medians_are_those_of_the_printed_table_in_its_groups() {
    let folder = run();
    let printed = folder.text("said.txt");
    let medians = rows(&folder, &format!("run/{MEDIANS}"));
    let lines: Vec<Vec<&str>> = printed
        .lines()
        .skip(1)
        .map(|line| line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect())
        .collect();
    let (header, methods) = (&lines[0], &lines[1..]);
    // The passes stand between four columns that name the method and the column of the total.
    let groups = &header[4..header.iter().position(|title| *title == "total ms").unwrap()];
    for line in methods {
        let median = |pass: &str| {
            let is_of_pass = |row: &&BTreeMap<String, String>| row["method"] == line[3] && row["pass"] == pass;
            let found = medians.iter().find(|row| is_of_pass(row) && row["counted"] == "true");
            found.map_or_else(|| "-".to_owned(), |row| format!("{:.3}", row["median_ms"].parse::<f64>().unwrap()))
        };
        let found: Vec<String> = groups.iter().chain(&["total"]).map(|pass| median(pass)).collect();
        assert_eq!(found, line[4..5 + groups.len()], "{printed}");
    }
    assert!(
        groups.contains(&"hi-z") && medians.iter().any(|row| row["pass"] == "g-buffer" && row["counted"] == "false")
    );
    assert!(medians.iter().all(|row| !row["pass"].contains('/')));
}

/// The ten lines of Python in the definitions draw a line for each method with a point for each frame. Code on a page
/// breaks silently when the files change.
#[test]
fn ten_lines_of_python_plot_the_samples() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: there is no python3");
        return;
    }
    let (folder, section) = (run(), section());
    let (_, code) = section.split_once("```python\n").unwrap();
    let code = code.split("```").next().unwrap();
    assert_eq!(code.lines().count(), 10);
    folder.write("plot.py", code);
    let samples = folder.path(&format!("run/{SAMPLES}"));
    let output = Command::new("python3").arg("plot.py").arg(samples).current_dir(folder.root()).output().unwrap();
    let (svg, errors) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{errors}");
    // One line for each method, with a point for each frame.
    let lines: Vec<&str> =
        svg.split("<polyline points=\"").skip(1).map(|line| line.split('"').next().unwrap()).collect();
    assert_eq!(lines.iter().map(|line| line.split(' ').count()).collect::<Vec<_>>(), [5, 5], "{svg}");
    assert!(svg.contains(">ssct</text>") && svg.contains(">environment</text>"), "{svg}");
    // The last frame stands at the right border, however many there are.
    assert!(lines.iter().all(|line| line.rsplit(' ').next().unwrap().starts_with("890.0,")), "{svg}");
}

/// The seconds that `ssct time --help` gives for each size of table 5.8 follow from the recorded frames. They are
/// constants of the program, which may differ from new records.
#[test]
fn the_seconds_of_table_5_8_are_those_of_the_records() {
    let path = repository().join("benches/runs/2026-11-28-lavapipe/table-5.8-atrium/time.json");
    let records: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    // Frames of one row: ten that are timed, two that warm up, and one whose work is counted.
    let frames = 10.0 + 2.0 + 1.0;
    let seconds = sizes().into_iter().map(|[width, height]| {
        let has_size = |r: &&Value| r["width"] == width && r["height"] == height;
        let frame_ms = |r: &Value| r["frame"]["median_ms"].as_f64().unwrap();
        (records.iter().filter(has_size).map(frame_ms).sum::<f64>() * frames / 1e3).round() as u32
    });
    assert_eq!(seconds.collect::<Vec<_>>(), SECONDS);
    let folder = Folder::new();
    let help = folder.succeed(&["time", "--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
    for ([width, height], seconds) in sizes().into_iter().zip(SECONDS) {
        assert!(help.contains(&format!("{width}x{height} ({seconds} s)")), "{width}x{height}");
    }
}

/// A size that is no row of table 5.8 has measured times but no printed ones, beside a size with both. Matching rows by
/// position would give it the times of another size.
#[test]
fn a_size_without_a_row_stands_beside_one_that_has() {
    let folder = Folder::new();
    let table =
        ["time", "--table", "5.8", "--roughness", "0.1", "--samples", "1", "--warmup", "0", "--method", "ssct,hzct"];
    let printed_table = folder.succeed(&[&table[..], &["--size", "66x37,640x480"]].concat());
    let row = |size: &str| {
        let line = printed_table
            .lines()
            .find(|line| line.starts_with(size))
            .unwrap_or_else(|| panic!("{size}: {printed_table}"));
        line[size.len()..].split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    // After its size, a row has the roughness, the thesis's and the measured time of each method, and both quotients.
    let [with_row, without] = ["640 x 480", "66 x 37"].map(row);
    let of_thesis = (&*with_row[1], &*without[1], &*without[3], &*without[5]);
    assert_eq!(of_thesis, ("0.81", "-", "-", "-"), "{printed_table}");
    assert!(without[2].parse::<f64>().is_ok() && without[6].parse::<f64>().is_ok(), "{printed_table}");
}
