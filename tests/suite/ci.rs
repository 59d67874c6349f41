//! The workflow of the public CI service, and the scripts for clusters: the targets that the workflow makes exist, and the
//! scripts refuse wrong arguments.

use crate::common::repository;
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

fn workflow() -> Value {
    let text = std::fs::read_to_string(repository().join(".github/workflows/ci.yml")).unwrap();
    serde_saphyr::from_str(&text).unwrap()
}

fn jobs(workflow: &Value) -> Vec<(&str, &Value)> {
    workflow["jobs"].as_object().unwrap().iter().map(|(name, job)| (name.as_str(), job)).collect()
}

fn steps(job: &Value) -> &[Value] {
    job["steps"].as_array().unwrap()
}

/// The lines that the steps of a job run.
fn commands(job: &Value) -> Vec<&str> {
    steps(job).iter().filter_map(|step| step["run"].as_str()).flat_map(str::lines).collect()
}

/// The targets of the Makefile.
fn targets() -> BTreeSet<String> {
    let text = std::fs::read_to_string(repository().join("Makefile")).unwrap();
    let rule = |line: &str| {
        let (name, rest) = line.split_once(':')?;
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
        (is_name && !rest.starts_with('=')).then(|| name.to_owned())
    };
    text.lines().filter_map(rule).collect()
}

#[test]
fn the_workflow_makes_targets_that_exist() {
    let (workflow, targets) = (workflow(), targets());
    let jobs = jobs(&workflow);
    let commands = jobs.iter().flat_map(|(_, job)| commands(job));
    let made: Vec<&str> = commands
        .filter_map(|c| c.strip_prefix("make "))
        .flat_map(str::split_whitespace)
        .filter(|w| !w.contains('='))
        .collect();
    for target in &made {
        assert!(targets.contains(*target), "make {target}: the Makefile has {targets:?}");
    }
    for needed in ["test", "lint", "library", "test-cluster", "test-snakemake"] {
        assert!(made.contains(&needed), "the workflow does not make {needed}");
    }
}

#[test]
fn scripts_are_whole_and_refuse_wrong_arguments() {
    let scripts = repository().join("scripts");
    let of = |folder: &str| {
        let entries = std::fs::read_dir(scripts.join(folder)).unwrap().map(|e| e.unwrap().path());
        entries.filter(|p| p.extension().is_some_and(|e| e == "sh")).collect::<Vec<_>>()
    };
    let all = [of(""), of("cluster")].concat();
    assert!(all.len() > 8, "{all:?}");
    for script in all {
        let output = Command::new("bash").arg("-n").arg(&script).output().unwrap();
        assert!(output.status.success(), "{}: {}", script.display(), String::from_utf8_lossy(&output.stderr));
    }
    let submit = scripts.join("cluster/submit.sh");
    for (args, words) in [
        (&["--tasks", "2", "-o", "x"][..], "no command"),
        (
            &["--tasks", "2", "-o", "x", "--", "render", "--method", "reference"],
            "ssct render has no shards that are folders",
        ),
        (&["--tasks", "2", "-o", "x", "--", "error", "--shard", "1/2"], "--shard is set by this script"),
        (&["--tasks", "two", "-o", "x", "--", "error"], "--tasks takes a whole number, not 'two'"),
        (&["-o", "x", "--", "error"], "--tasks must be at least 1"),
        (&["--tasks", "2", "--", "error"], "no folder"),
        (&["--task", "2"], "unknown option '--task'"),
        (&["--tasks", "2", "-o"], "-o lacks its value"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = Command::new(&submit).args(args).current_dir(folder.path()).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {text}");
        assert!(text.contains(words), "{args:?}: {text}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{args:?} leaves nothing");
    }
}

#[test]
fn every_script_says_what_it_is_for() {
    let mut seen = 0;
    for folder in ["scripts", "scripts/cluster"] {
        for entry in std::fs::read_dir(repository().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let is_run = |path: &std::path::Path| {
                path.extension().is_some_and(|e| e == "sh") && std::fs::read_to_string(path).unwrap().starts_with("#!")
            };
            if !is_run(&path) {
                continue;
            }
            let nowhere = tempfile::tempdir().unwrap();
            let output = Command::new("bash").arg(&path).arg("--help").current_dir(nowhere.path()).output().unwrap();
            let [out, said] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
            assert!(output.status.success() && said.is_empty() && out.lines().count() > 1, "{path:?}: {out}{said}");
            assert_eq!(std::fs::read_dir(nowhere.path()).unwrap().count(), 0, "{path:?}");
            seen += 1;
        }
    }
    assert!(seen > 15, "{seen}");
    let drivers = repository().join("scripts/drivers.sh");
    let output = Command::new("bash").arg(drivers).arg("--unknown").output().unwrap();
    assert_eq!(output.status.code(), Some(2), "nothing is fetched for a flag that there is not");
}
