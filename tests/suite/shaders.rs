//! Tests `ssct shaders`: its sentences about a device without statistics and about an absent GPU, and the comparison of
//! two of its runs. `tests/alone/compiled.rs` tests the numbers themselves.

use crate::common::folder::Folder;
use crate::common::repository;
use serde_json::{Value, json};
use ssct::gpu::glsl;
use std::path::Path;
use std::process::{Command, Output};

/// Mesa's driver for AMD's GPUs, as Debian installs it beside lavapipe.
const RADV: &str = "/usr/share/vulkan/icd.d/radeon_icd.x86_64.json";

/// Runs the program for a GPU of a family that is not in the machine, by Mesa's driver for AMD. Returns `None` if the
/// system has no such driver.
fn on_absent_gpu(folder: &Folder, family: &str, arguments: &[&str]) -> Option<Output> {
    if !Path::new(RADV).is_file() {
        println!("skipped: {RADV} is absent");
        return None;
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
    command.args(arguments).current_dir(folder.root()).env_remove("SSCT_DEVICE").env_remove("VK_ADD_DRIVER_FILES");
    // Both spellings of the variable, since loaders of different age read either.
    command.env("VK_DRIVER_FILES", RADV).env("VK_ICD_FILENAMES", RADV).env("RADV_FORCE_FAMILY", family);
    Some(command.output().unwrap())
}

/// Returns the text on standard error.
fn errors_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A device without the extension for statistics of compiled shaders is refused with the name of the extension.
#[test]
fn a_device_that_tells_nothing_of_its_compiler_is_refused_in_a_sentence() {
    let folder = Folder::new();
    let output = folder.run(&["shaders", "--device", "llvmpipe", "--method", "ssct"]);
    let text = errors_of(&output);
    assert_eq!((output.status.code(), text.lines().count()), (Some(1), 1), "{text}");
    assert!(text.contains("lacks VK_KHR_pipeline_executable_properties"), "{text}");
    let output = folder.run(&["shaders", "--validation"]);
    assert_eq!(output.status.code(), Some(2), "{}", errors_of(&output));
}

/// For an absent GPU, each program has registers, code size and no spilled register in its record, and two equal runs
/// compare as 1.000. The driver compiles although the device cannot draw.
#[test]
fn programs_compile_for_a_gpu_that_is_not_there() {
    let folder = Folder::new();
    let arguments = ["shaders", "--method", "ssct,unified", "--roughness", "0,0.3", "--json", "-o", "out"];
    let Some(output) = on_absent_gpu(&folder, "NAVI21", &arguments) else { return };
    assert!(output.status.success(), "{}", errors_of(&output));
    let records: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let records_of = |name: &str| records.iter().filter(|r| r["method"] == name).collect::<Vec<_>>();
    let trace = records_of("ssct").into_iter().find(|r| r["program"] == "thesis/ssct.frag").unwrap();
    assert_eq!((&trace["stage"], &trace["runs_in"]), (&"fragment".into(), &"frame".into()), "{trace}");
    // Among triangles, mirrors run one program and wide lobes three or more.
    let programs = |roughness: f64| {
        let is_wanted = |record: &&&Value| (record["roughness"].as_f64().unwrap() - roughness).abs() < 1e-6;
        records_of("unified").iter().filter(is_wanted).count()
    };
    assert!(programs(0.0) >= 1 && programs(0.3) >= 3, "{} {}", programs(0.0), programs(0.3));
    for record in &records {
        let statistic = |name: &str| {
            let statistics = record["statistics"].as_array().unwrap();
            statistics.iter().find(|s| s["name"] == name).and_then(|s| s["value"].as_f64())
        };
        assert!(statistic("VGPRs").unwrap() > 0.0 && statistic("Code size").unwrap() > 0.0, "{record}");
        assert_eq!(statistic("Spilled VGPRs"), Some(0.0), "{record}");
        assert_eq!(record["stage"] == "vertex", record["program"].as_str().unwrap().contains(".vert"), "{record}");
    }
    let page = folder.text("out/index.html");
    assert!(page.contains("VGPRs") && page.contains("unified/trace/mirror.comp"), "the page has the driver's names");
    let compared = folder.succeed(&["compare", "out", "out"]);
    assert!(compared.contains("VGPRs") && compared.contains("1.000"), "{compared}");
}

/// Drawing on an absent GPU and an unknown family are refused with a sentence.
#[test]
fn a_gpu_that_is_not_there_draws_nothing_and_an_unknown_one_is_named() {
    let folder = Folder::new();
    let render = ["render", "--scene", "rooms", "--size", "34x19", "-o", "a.png"];
    let Some(output) = on_absent_gpu(&folder, "NAVI21", &render) else { return };
    let text = errors_of(&output);
    assert!(output.status.code() == Some(1) && text.contains("its hardware is not there"), "{text}");
    let output = on_absent_gpu(&folder, "NAVI99", &["shaders", "--method", "ssct"]).unwrap();
    let text = errors_of(&output);
    assert!(output.status.code() == Some(1) && text.contains("RADV_FORCE_FAMILY=NAVI99"), "{text}");
}

/// Returns a record of a program with a number of registers and of subgroups.
fn record(program: &str, roughness: f64, registers: u32, subgroups: u32) -> Value {
    json!({
        "kind": "shaders", "definitions": 2, "version": "0.1.0", "commit": "unknown",
        "device": {"name": "a card", "driver": "a driver", "api": "1.3.0", "type": "discrete GPU"},
        "scene": "rooms", "view": "corridor", "method": "ssct", "preset": "published", "width": 64, "height": 48,
        "roughness": roughness, "setup": {}, "runs_in": "frame", "passes": "trace", "program": program, "stage": "compute",
        "constants": "", "subgroup_size": 64,
        "statistics": [
            {"name": "VGPRs", "about": "registers", "value": registers},
            {"name": "Subgroups per SIMD", "about": "that fit", "value": subgroups},
            {"name": "Hash", "about": "of the code", "value": 12345 + registers},
        ],
    })
}

/// In a comparison of two runs with known registers, a frame has the greatest registers and the fewest subgroups of its
/// programs. Equal programs and hashes are not listed.
#[test]
fn two_runs_are_compared_by_frames_and_by_programs() {
    let folder = Folder::new();
    for (name, registers, subgroups) in [("a", 96, 8), ("b", 48, 16)] {
        std::fs::create_dir(folder.path(name)).unwrap();
        let records = [record("one.comp", 0.0, registers, subgroups), record("two.comp", 0.0, 64, 12)];
        folder.write(&format!("{name}/shaders.json"), json!(records).to_string());
    }
    let text = folder.succeed(&["compare", "a", "b"]);
    let line = |words: &[&str]| {
        let found = text.lines().find(|line| words.iter().all(|word| line.split_whitespace().any(|w| w == *word)));
        found.unwrap_or_else(|| panic!("{words:?}: {text}")).split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    // A frame's registers are the greatest of its programs, and its subgroups the least.
    assert_eq!(line(&["ssct", "0", "VGPRs", "96", "64"]).last().unwrap(), "0.667");
    assert!(line(&["ssct", "0", "8", "12"]).last().unwrap() == "1.500", "{text}");
    assert_eq!(line(&["one.comp", "VGPRs"]).last().unwrap(), "0.500");
    assert!(
        !text.contains("two.comp") && !text.contains("Hash"),
        "equal programs and statistics that count nothing are not listed: {text}"
    );
    let records: Vec<Value> = serde_json::from_str(&folder.succeed(&["compare", "a", "b", "--json"])).unwrap();
    assert!(records.iter().any(|r| r["statistic"] == "VGPRs" && r["value_a"] == 96.0 && r["value_b"] == 48.0));
    folder.write("b/shaders.json", "[{}]");
    let output = folder.run(&["compare", "a", "b"]);
    assert!(output.status.code() == Some(1) && errors_of(&output).contains("b/shaders.json: holds other records"));
}

/// Copies the shaders to the subfolder `shaders`, with the text `from` of one file replaced by `to`.
fn write_changed_shaders(folder: &Folder, file: &str, from: &str, to: &str) {
    let sources = repository().join("shaders-glsl");
    for path in glsl::files(&sources, &["vert", "frag", "comp", "glsl"]).unwrap() {
        let copy = folder.path("shaders").join(path.strip_prefix(&sources).unwrap());
        std::fs::create_dir_all(copy.parent().unwrap()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let is_changed = path.ends_with(file);
        assert!(!is_changed || text.contains(from), "{file}: {from}");
        std::fs::write(copy, if is_changed { text.replace(from, to) } else { text }).unwrap();
    }
}

/// With a history, the records have the program of moving frames with the constant SEARCH on, and that of frames at
/// rest with it off. Each is compiled only in the frames in which it runs.
#[test]
fn a_history_runs_one_program_at_rest_and_another_while_the_camera_moves() {
    let folder = Folder::new();
    let arguments = ["shaders", "--variant", "unified --history on", "--roughness", "0.1", "--json"];
    let Some(output) = on_absent_gpu(&folder, "NAVI21", &arguments) else { return };
    let records: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    let is_of_history = |r: &&Value| r["program"].as_str().is_some_and(|name| name.starts_with("history/"));
    let found: Vec<&Value> = records.iter().filter(is_of_history).collect();
    let constants = |runs_in: &str| {
        let in_frame: Vec<_> = found.iter().filter(|r| r["runs_in"] == runs_in).map(|r| &r["constants"]).collect();
        assert_eq!(in_frame.len(), 1, "{runs_in}: {found:?}");
        in_frame[0].as_str().unwrap()
    };
    // The constant SEARCH of shaders-glsl/history/inputs.glsl.
    assert!(constants("frame").contains(" 3=1") && constants("frame at rest").contains(" 3=0"), "{found:?}");
}

/// With `SSCT_SHADERS`, a changed shader changes the image, and records say so. Mistakes, changed bindings and an empty
/// folder are refused, where the built shaders would be drawn unnoticed.
#[test]
fn shaders_of_a_named_folder_stand_for_those_that_were_built_in() {
    let folder = Folder::new();
    let run = |arguments: &[&str], shaders: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
        command.args(arguments).current_dir(folder.root()).env("SSCT_SHADERS", folder.path(shaders));
        let output = command.output().unwrap();
        (output.status.code(), errors_of(&output), output.stdout)
    };
    let render = ["render", "--method", "ssct", "--size", "17x9", "-o", "out.png"];
    write_changed_shaders(&folder, "common/composite.frag", "vec4(color, 1.0)", "vec4(1.0, 0.0, 0.0, 1.0)");
    let (status, text, _) = run(&render, "shaders");
    assert_eq!((status, text.lines().count()), (Some(0), 1), "{text}");
    assert!(text.contains("shaders are compiled from ") && text.contains("SSCT_SHADERS"), "{text}");
    assert!(folder.image("out.png").pixels().all(|p| p.0 == [255, 0, 0]));
    let time = ["time", "--method", "ssct", "--size", "17x9", "--samples", "2", "--json"];
    let (status, text, records) = run(&time, "shaders");
    assert_eq!(status, Some(0), "{text}");
    let records: Vec<Value> = serde_json::from_slice(&records).unwrap();
    assert!(records[0]["commit"].as_str().unwrap().ends_with(" with other shaders"), "{}", records[0]["commit"]);

    write_changed_shaders(&folder, "common/composite.frag", "vec4(color, 1.0)", "vec4(color, nonsense)");
    let (status, text, _) = run(&render, "shaders");
    assert!(status == Some(2) && text.contains("composite.frag:") && text.contains("nonsense"), "{text}");
    write_changed_shaders(&folder, "common/composite.frag", "layout(binding = 2)", "layout(binding = 3)");
    let (status, text, _) = run(&render, "shaders");
    assert!(status == Some(2) && text.contains("its bindings changed, so the program must be built again"), "{text}");
    let (status, text, _) = run(&render, "none");
    assert!(status == Some(2) && text.contains("SSCT_SHADERS") && text.contains("there are no shaders"), "{text}");
}
