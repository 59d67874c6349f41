//! Compiles every program for AMD's GPUs, without such a GPU: if `RADV_FORCE_FAMILY` names a family, Mesa's driver RADV
//! makes a device without hardware, and compiles for it. `make test-drivers` runs these tests with the variables of
//! `scripts/drivers.sh --radv`.
//!
//! No program may spill registers or use scratch memory. The numbers of its vector registers and instructions must be
//! those in `tests/registers.csv`, so that a change that costs occupancy is seen. With SSCT_WRITE_REGISTERS=FILE the
//! test writes the table to this file instead; SSCT_COMMAND names another build of `ssct` to take the numbers from.

use crate::common::folder::Folder;
use crate::common::repository;
use serde_json::Value;
use ssct::gpu::programs;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// The families of GPUs that programs are compiled for: RADV's name of the family, and whether it has ray queries.
const FAMILIES: [(&str, bool); 5] =
    [("vega20", false), ("navi10", false), ("navi21", true), ("navi31", true), ("gfx1201", true)];

/// Built-in scenes, and for each the variants (a method with its options) that are run in it. Together they run every
/// program.
const RUNS: [(&str, &[&str]); 3] = [
    (
        "rooms",
        &[
            "ssct",
            "ssct --split on",
            "ssct --chain-mask surface --chain-filter gaussian",
            "ssct --chain-filter gaussian",
            "ssct --hi-z-maximum on",
            "ssct --resolution-scale 0.5",
            "ssct --trace-normals geometric --bump-after 0.5",
            "ssct --bounces 2",
            "hzct",
            "hzct --fallback environment",
            "hzct --fallback pccm",
            "sslr",
            "sslr --mask-filter hardware",
            "linear",
            "poster",
            "poster --poster-filter volume",
            "poster --poster-filter edge-aware",
            "ssr",
            "ssr-fast",
            "dda",
            "stochastic",
            "stochastic --stochastic-walk thesis",
            "environment",
            "pccm",
            "planar",
            "local-map",
            "traced",
            "captures --captures 2",
            "unified",
            "unified --first screen",
            "unified --first screen --history on",
            "unified --first screen --own-rays 8",
            "unified --beyond none",
            "unified --beyond none --own-rays 8",
            "unified --beyond none --trace-stage fragment --resolve-stage fragment",
            "unified --beyond triangles --first screen --trace-stage fragment --resolve-stage fragment",
            "unified --beyond captures --captures 2",
            "unified --history on --history-stage fragment",
            "unified --resolution-scale 0.5",
        ],
    ),
    ("street", &["billboard", "area-light", "ibr"]),
    ("museum", &["unified --first screen", "traced"]),
];

/// Variants, run in the rooms, that find what rays meet by ray queries.
const QUERIED: [&str; 3] =
    ["traced --tracer query", "unified --tracer query --own-rays 8", "unified --first screen --tracer query"];

/// Statistics of a program, as the compiler reports them: the greatest over all runs of the program.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Numbers {
    registers: u32,
    /// Registers that the program needs at a time, before the compiler takes more of them so that loads begin earlier.
    needed: u32,
    instructions: u32,
    /// Inverse throughput, in cycles, as the compiler estimates it: it takes each loop to run eight times.
    cycles: u32,
    /// Subgroups that a SIMD unit holds at a time: the least over all runs.
    subgroups: Option<u32>,
    spilled: u32,
    scratch: u32,
}

/// Returns the records that `ssct shaders --json` prints for a family of GPUs, a scene and some variants. `stage` is
/// the stage of shaders in which passes run: "published" or "compute".
fn records(family: &str, scene: &str, variants: &[&str], stage: &str) -> Vec<Value> {
    let radv = Command::new(repository().join("scripts/drivers.sh")).arg("--radv").output().unwrap();
    assert!(radv.status.success(), "{}", String::from_utf8_lossy(&radv.stderr));
    let variables = String::from_utf8(radv.stdout).unwrap();
    let folder = Folder::new();
    let mut arguments = vec!["shaders", "--scene", scene, "--json", "--size", "320x180", "--stage", stage];
    arguments.extend(variants.iter().flat_map(|variant| ["--variant", variant]));
    let line = format!("{variables}\nexec \"$@\"");
    let command = std::env::var("SSCT_COMMAND").unwrap_or_else(|_| env!("CARGO_BIN_EXE_ssct").to_owned());
    let output = Command::new("bash")
        .args(["-c", &line, "bash", &command])
        .args(arguments)
        .env("RADV_FORCE_FAMILY", family)
        .env_remove("SSCT_DEVICE")
        .env_remove("VK_ADD_DRIVER_FILES")
        .current_dir(folder.root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{family}, {scene}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Returns the statistics of each program on a family of GPUs, by the program's name, and the name of the driver.
/// `has_queries` adds the variants that use ray queries. If several runs compile a program, the greatest numbers are
/// kept, and the fewest subgroups.
fn numbers(family: &str, has_queries: bool) -> (BTreeMap<String, Numbers>, String) {
    let mut programs: BTreeMap<String, Numbers> = BTreeMap::new();
    let mut driver = String::new();
    let queried = has_queries.then_some(("rooms", &QUERIED[..]));
    let runs = || RUNS.into_iter().chain(queried);
    let in_stage = |stage| runs().map(move |(scene, variants)| (scene, variants, stage));
    for (scene, variants, stage) in ["published", "compute"].into_iter().flat_map(in_stage) {
        for record in records(family, scene, variants, stage) {
            driver = record["device"]["driver"].as_str().unwrap().to_owned();
            let statistic = |name: &str| {
                let list = record["statistics"].as_array().unwrap();
                let found = list.iter().find(|s| s["name"] == name).unwrap_or_else(|| panic!("{name} of {record}"));
                found["value"].as_f64().unwrap() as u32
            };
            let program = record["program"].as_str().unwrap().to_owned();
            let kept = programs.entry(program).or_default();
            kept.registers = kept.registers.max(statistic("VGPRs"));
            kept.needed = kept.needed.max(statistic("Pre-Sched VGPRs"));
            kept.instructions = kept.instructions.max(statistic("Instructions"));
            kept.cycles = kept.cycles.max(statistic("Inverse Throughput"));
            let subgroups = statistic("Subgroups per SIMD");
            kept.subgroups = Some(kept.subgroups.map_or(subgroups, |least| least.min(subgroups)));
            kept.spilled = kept.spilled.max(statistic("Spilled VGPRs") + statistic("Spilled SGPRs"));
            kept.scratch = kept.scratch.max(statistic("Scratch size"));
        }
    }
    (programs, driver)
}

/// Returns the table as CSV: a line for the driver, a header, and a row for each program and family.
fn table(found: &BTreeMap<(String, &str), Numbers>, driver: &str) -> String {
    let mut text = format!("# {driver}\nprogram,family,registers,needed,subgroups,instructions,cycles\n");
    for ((program, family), Numbers { registers, needed, instructions, cycles, subgroups, .. }) in found {
        let subgroups = subgroups.unwrap_or_default();
        text += &format!("\"{program}\",{family},{registers},{needed},{subgroups},{instructions},{cycles}\n");
    }
    text
}

/// Compiled for each family of AMD's GPUs, no program spills registers, and each has the numbers that
/// `tests/registers.csv` keeps. A change of a shader may cost occupancy on GPUs that the machine lacks, where no time
/// would show it.
#[test]
#[ignore = "make test-drivers runs it: it needs Mesa's driver for AMD's GPUs"]
fn programs_on_gpus_that_are_not_there_have_the_registers_that_are_kept_of_them() {
    let mut found = BTreeMap::new();
    let mut driver = String::new();
    for (family, has_queries) in FAMILIES {
        let (programs, driver_name) = numbers(family, has_queries);
        driver = driver_name;
        for (program, numbers) in programs {
            found.insert((program, family), numbers);
        }
    }
    let measured = table(&found, &driver);
    if let Some(file) = std::env::var_os("SSCT_WRITE_REGISTERS") {
        std::fs::write(repository().join(file), measured).unwrap();
        return;
    }
    for ((program, family), numbers) in &found {
        assert_eq!((numbers.spilled, numbers.scratch), (0, 0), "{program} on {family}: spills and scratch bytes");
    }
    // Every program must be compiled, except those that draw the scene and those of other tools.
    let compiled: BTreeSet<&str> = found.keys().map(|(program, _)| program.as_str()).collect();
    let left_out: Vec<&str> =
        programs::ALL.iter().map(|s| s.name).filter(|name| !compiled.contains(name) && !is_elsewhere(name)).collect();
    assert!(left_out.is_empty(), "no variant runs these programs: {left_out:?}");

    let kept = std::fs::read_to_string(repository().join("tests/registers.csv")).unwrap();
    if kept.lines().next() != measured.lines().next() {
        println!(
            "the table was made by {}, and this is {driver}: numbers are not compared",
            kept.lines().next().unwrap()
        );
        return;
    }
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<BTreeSet<_>>();
    let (kept, measured) = (lines(&kept), lines(&measured));
    let differ: Vec<String> = measured
        .difference(&kept)
        .map(|line| format!("now  {line}"))
        .chain(kept.difference(&measured).map(|line| format!("kept {line}")))
        .collect();
    assert!(
        differ.is_empty(),
        "programs have other numbers than tests/registers.csv keeps; if that is meant, \
         SSCT_WRITE_REGISTERS=tests/registers.csv writes it anew:\n{}",
        differ.join("\n")
    );
}

/// Returns whether a program may be missing in the table, by its name. Frames of methods run neither programs that draw
/// the scene, import images or serve other tools, nor vertex stages alone.
fn is_elsewhere(name: &str) -> bool {
    let name_parts = [".vert", "embed/", "custom/", "scene/", "view/", "common/nothing", "planar/lookup"];
    name_parts.iter().any(|part| name.contains(part))
}
