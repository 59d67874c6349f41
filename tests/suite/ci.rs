//! Tests the workflow of the public CI service and the scripts for clusters: the targets that the workflow makes exist,
//! and the scripts refuse wrong arguments.

use crate::common::repository;
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

/// Reads the workflow file of the public CI service.
fn workflow() -> Value {
    let text = std::fs::read_to_string(repository().join(".github/workflows/ci.yml")).unwrap();
    serde_saphyr::from_str(&text).unwrap()
}

/// Returns the jobs of the workflow, each with its name.
fn jobs(workflow: &Value) -> Vec<(&str, &Value)> {
    workflow["jobs"].as_object().unwrap().iter().map(|(name, job)| (name.as_str(), job)).collect()
}

/// Returns the steps of a job.
fn steps(job: &Value) -> &[Value] {
    job["steps"].as_array().unwrap()
}

/// Returns the lines of shell that the steps of a job run.
fn commands(job: &Value) -> Vec<&str> {
    steps(job).iter().filter_map(|step| step["run"].as_str()).flat_map(str::lines).collect()
}

/// Returns the names of the targets that the Makefile declares.
pub fn targets() -> BTreeSet<String> {
    let text = std::fs::read_to_string(repository().join("Makefile")).unwrap();
    let target_name = |line: &str| {
        let (name, rest) = line.split_once(':')?;
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
        (is_name && !rest.starts_with('=')).then(|| name.to_owned())
    };
    text.lines().filter_map(target_name).collect()
}

/// Each `make` target of the workflow is in the Makefile, and five important targets are made. A renamed target would
/// fail only on the service.
#[test]
fn the_workflow_makes_targets_that_exist() {
    let (workflow, targets) = (workflow(), targets());
    let jobs = jobs(&workflow);
    let commands = jobs.iter().flat_map(|(_, job)| commands(job));
    let made_targets: Vec<&str> = commands
        .filter_map(|c| c.strip_prefix("make "))
        .flat_map(str::split_whitespace)
        .filter(|w| !w.contains('='))
        .collect();
    for target in &made_targets {
        assert!(targets.contains(*target), "make {target}: the Makefile has {targets:?}");
    }
    for needed in ["test", "lint", "library", "test-cluster", "test-snakemake"] {
        assert!(made_targets.contains(&needed), "the workflow does not make {needed}");
    }
}

/// Bash can parse each script. For each kind of wrong arguments, `cluster/submit.sh` ends with status 2 and a sentence
/// and leaves no file, so that no job of a wrong run enters a queue.
#[test]
fn scripts_are_whole_and_refuse_wrong_arguments() {
    let root = repository().join("scripts");
    let scripts_in = |folder: &str| {
        let entries = std::fs::read_dir(root.join(folder)).unwrap().map(|e| e.unwrap().path());
        entries.filter(|p| p.extension().is_some_and(|e| e == "sh")).collect::<Vec<_>>()
    };
    let scripts = [scripts_in(""), scripts_in("cluster")].concat();
    assert!(scripts.len() > 8, "{scripts:?}");
    for script in scripts {
        let output = Command::new("bash").arg("-n").arg(&script).output().unwrap();
        assert!(output.status.success(), "{}: {}", script.display(), String::from_utf8_lossy(&output.stderr));
    }
    let submit = root.join("cluster/submit.sh");
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

/// Each script prints a help text for `--help`, prints nothing on standard error, and writes no file. An unknown flag
/// of `drivers.sh` is refused before anything is fetched.
#[test]
fn every_script_says_what_it_is_for() {
    let mut tried = 0;
    for folder in ["scripts", "scripts/cluster"] {
        for entry in std::fs::read_dir(repository().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let is_run = |path: &std::path::Path| {
                path.extension().is_some_and(|e| e == "sh") && std::fs::read_to_string(path).unwrap().starts_with("#!")
            };
            if !is_run(&path) {
                continue;
            }
            let empty = tempfile::tempdir().unwrap();
            let output = Command::new("bash").arg(&path).arg("--help").current_dir(empty.path()).output().unwrap();
            let [help, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
            assert!(
                output.status.success() && errors.is_empty() && help.lines().count() > 1,
                "{path:?}: {help}{errors}"
            );
            assert_eq!(std::fs::read_dir(empty.path()).unwrap().count(), 0, "{path:?}");
            tried += 1;
        }
    }
    assert!(tried > 15, "{tried}");
    let drivers = repository().join("scripts/drivers.sh");
    let output = Command::new("bash").arg(drivers).arg("--unknown").output().unwrap();
    assert_eq!(output.status.code(), Some(2), "nothing is fetched for a flag that there is not");
}

/// Returns the numbers of a version, without `=` before them and without labels after them: `=1.2.3+x` gives 1, 2 and
/// 3.
fn numbers(version: &str) -> Vec<u64> {
    let plain = version.trim_start_matches('=').split(['+', '-']).next().unwrap();
    plain.split('.').map(|number| number.parse().unwrap()).collect()
}

/// Each dependency asks for a version of three numbers, and the lock file, with which tests run, has that version or a
/// later compatible one. A manifest that asks for less allows versions that no test has seen.
#[test]
fn each_manifest_asks_for_versions_that_are_tested() {
    let read = |file: &str| std::fs::read_to_string(repository().join(file)).unwrap().parse::<toml::Table>().unwrap();
    let lock = read("Cargo.lock");
    let locked: Vec<(&str, Vec<u64>)> = lock["package"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| (p["name"].as_str().unwrap(), numbers(p["version"].as_str().unwrap())))
        .collect();
    let mut checked = 0;
    let workspace = read("Cargo.toml")["workspace"]["members"].as_array().unwrap().clone();
    for folder in &workspace {
        let file = format!("{}/Cargo.toml", folder.as_str().unwrap());
        let manifest = read(&file);
        let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
        let own = kinds.iter().filter_map(|kind| manifest.get(*kind)?.as_table());
        let shared = manifest.get("workspace").and_then(|w| w.get("dependencies")?.as_table());
        for (name, requirement) in own.chain(shared).flatten() {
            let Some(version) = requirement.as_str().or_else(|| requirement.get("version")?.as_str()) else { continue };
            let required = numbers(version);
            assert_eq!(required.len(), 3, "{file}: {name} = {version:?} does not say which version it needs");
            let is_tested = |(locked_name, locked_version): &(&str, Vec<u64>)| {
                locked_name == name && *locked_version >= required && locked_version[0] == required[0]
            };
            assert!(locked.iter().any(is_tested), "{file}: {name} {version} is not what Cargo.lock has");
            checked += 1;
        }
    }
    assert!(checked > 40, "{checked}");
}

/// The script that checks the licences of all crates succeeds. A new dependency may have a licence under which the
/// program cannot be passed on.
#[test]
fn licences_of_all_crates_may_be_passed_on() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: there is no python3");
        return;
    }
    let script = repository().join("scripts/licences.py");
    let output = Command::new("python3").arg(script).arg("--check").output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && String::from_utf8_lossy(&output.stdout).contains(" crates"), "{errors}");
}
