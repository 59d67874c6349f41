//! Tests runs that do not come to their end: killed, stopped, without device, without disk, two in one folder. Every
//! result stays, and nothing is measured twice.

use crate::common::folder::is_notice;
use crate::common::hang::wait_until;
use crate::common::{built_in, expected_failures, gpu};
use serde_json::Value;
use ssct::methods::{self, Setup};
use ssct_lab::error::{Error, Result};
use ssct_lab::stage::Globals;
use ssct_lab::study::precision::{self, PrecisionSpec};
use ssct_lab::study::stress::lineup::SceneMethods;
use ssct_lab::study::stress::motion::{self, Motion, MotionSpec};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// The program under test.
const SSCT: &str = env!("CARGO_BIN_EXE_ssct");
/// A small run of `ssct time` with two methods.
const TIME: [&str; 7] = ["time", "--scene", "corridor", "--size", "34x19", "--method", "ssct,unified"];
/// A small run of `ssct error`.
const ERROR: [&str; 10] =
    ["error", "--scene", "corridor", "--view", "corridor", "--no-sweep", "--size", "48x27", "--method", "ssct"];

/// Returns the command that runs the program with `args`, then `more`, and with its output in pipes.
fn command(args: &[&str], more: &[&str]) -> Command {
    let mut command = Command::new(SSCT);
    command.args(args).args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs the program with `args`, then `more`, to its end. Returns the exit status and standard error.
fn run(args: &[&str], more: &[&str]) -> (Option<i32>, String) {
    ended(command(args, more).output().unwrap())
}

/// Returns the exit status and standard error of a run that ended. Panics if the run panicked, or if it printed more
/// than one line of errors. Notices are not counted.
fn ended(output: Output) -> (Option<i32>, String) {
    let errors = String::from_utf8(output.stderr).unwrap();
    let lines = errors.lines().filter(|line| !is_notice(line));
    assert!(lines.count() <= 1 && !errors.contains("panicked"), "{errors}");
    (output.status.code(), errors)
}

/// Sends a signal to a process.
fn signal(child: &Child, name: &str) {
    // The shell's built-in `kill` is used, since a bare machine has no program of this name.
    let line = format!("kill -{name} {}", child.id());
    assert!(Command::new("sh").args(["-c", &line]).status().unwrap().success());
}

/// Returns the whole lines of a folder's journal.
fn journal(folder: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("journal.jsonl")).unwrap_or_default();
    let whole = text.rfind('\n').map_or(0, |newline| newline + 1);
    text[..whole].lines().map(str::to_owned).collect()
}

/// Waits until the journal of a folder has at least `lines` lines.
fn wait_for_lines(folder: &Path, lines: usize) {
    wait_until(|| format!("a run that should write {lines} lines"), || journal(folder).len() >= lines);
}

/// Starts a run and halts it once its journal has at least `lines` lines, so that a slow test does not find the run at
/// its end.
fn start(args: &[&str], more: &[&str], folder: &Path, lines: usize) -> Child {
    let child = command(args, more).spawn().unwrap();
    wait_for_lines(folder, lines);
    signal(&child, "STOP");
    child
}

/// Sends a signal to a halted run, which receives it as it continues, and waits for its end.
fn stop(child: Child, name: &str) -> (Option<i32>, String) {
    signal(&child, name);
    signal(&child, "CONT");
    ended(child.wait_with_output().unwrap())
}

/// Returns the keys of a journal's entries, and checks that no key occurs twice.
fn keys(lines: &[String]) -> HashSet<String> {
    let entries = lines.iter().map(|l| serde_json::from_str::<Value>(l).unwrap());
    let listed: Vec<String> = entries.filter_map(|e| e["key"].as_str().map(str::to_owned)).collect();
    let unique: HashSet<String> = listed.iter().cloned().collect();
    assert_eq!(unique.len(), listed.len(), "something was measured twice");
    unique
}

/// Returns the records of a file.
fn records(file: PathBuf) -> Vec<Value> {
    serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap()
}

/// A run of `time` is killed, resumed, interrupted and resumed: no line of its journal is lost or repeated. A second
/// run in the same folder is refused, as is a new run over unfinished results. Hours of measurements would be lost
/// otherwise.
#[test]
fn times_survive_a_kill_and_a_signal() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let name = out.to_str().unwrap();
    let samples = 300;
    let args = ["--samples", &samples.to_string(), "-o", name];

    let mut killed = start(&TIME, &args, &out, 30);
    let (status, message) = run(&TIME, &args);
    assert_eq!(status, Some(1), "{message}");
    assert!(message.contains("another run is writing into"), "{message}");
    let halted = journal(&out).len();
    signal(&killed, "CONT");
    wait_for_lines(&out, halted + 1);
    signal(&killed, "KILL");
    killed.wait().unwrap();
    let first = journal(&out);
    assert!((30..2 * samples).contains(&first.len()), "{}", first.len());

    let (status, message) = run(&TIME, &args);
    assert_eq!(status, Some(2), "what was measured is not thrown away: {message}");
    assert!(message.contains("--resume goes on with it"), "{message}");
    assert_eq!(journal(&out), first);

    let resumed = start(&TIME, &[&args[..], &["--resume"]].concat(), &out, first.len() + 30);
    let (status, message) = stop(resumed, "INT");
    assert_eq!(status, Some(130), "{message}");
    assert!(message.contains("stopped by SIGINT") && message.contains("--resume"), "{message}");
    let second = journal(&out);
    assert!(second.len() < 2 * samples + 2 && second[..first.len()] == first, "nothing is lost");
    let timed: u64 = records(out.join("time.json")).iter().map(|r| r["total"]["samples"].as_u64().unwrap()).sum();
    // For each of the two methods, the journal's first entry is a frame whose work is counted, not timed.
    assert_eq!(timed + 2, second.len() as u64, "what was measured is written");

    assert_eq!(run(&TIME, &[&args[..], &["--resume"]].concat()), (Some(0), String::new()));
    let third = journal(&out);
    assert_eq!((&third[..second.len()], keys(&third).len()), (&second[..], 2 * samples + 2));
    let final_records = records(out.join("time.json"));
    assert!(
        final_records.len() == 2
            && final_records.iter().all(|r| r["total"]["samples"] == samples && r["frame"]["samples"] == samples)
    );
    assert_eq!(run(&TIME, &[&args[..], &["--resume"]].concat()), (Some(0), String::new()));
    assert_eq!(
        (keys(&journal(&out)), records(out.join("time.json"))),
        (keys(&third), final_records),
        "there is nothing to do"
    );
    // A finished run is begun anew without the flag.
    assert_eq!(run(&TIME, &["--samples", "1", "-o", name]), (Some(0), String::new()));
    assert_eq!(keys(&journal(&out)).len(), 2 + 2);
}

/// A run of `error` is killed, resumed, terminated and resumed: all cells and samples are in its journal once. Its
/// journal has two kinds of entries, samples of times and cells.
#[test]
fn cells_of_the_error_study_survive_too() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = ["--rays", "4", "--roughness", "0,0.1,0.2,0.3,0.4,0.5", "--samples", "9", "-o", out];
    let mut killed = start(&ERROR, &args, folder.path(), 6);
    signal(&killed, "KILL");
    killed.wait().unwrap();
    let first = journal(folder.path());
    let resumed = start(&ERROR, &[&args[..], &["--resume"]].concat(), folder.path(), first.len() + 5);
    let (status, message) = stop(resumed, "TERM");
    assert_eq!(status, Some(143), "{message}");
    let second = journal(folder.path());
    assert_eq!(run(&ERROR, &[&args[..], &["--resume"]].concat()), (Some(0), String::new()));
    let third = journal(folder.path());
    assert_eq!((&second[..first.len()], &third[..second.len()]), (&first[..], &second[..]));
    // Each of the six roughnesses has nine samples and one cell.
    assert_eq!(keys(&third).len(), 6 * 10);
    let roughness: HashSet<String> =
        records(folder.path().join("error.json")).iter().map(|r| r["roughness"].to_string()).collect();
    assert_eq!(roughness.len(), 6);
}

/// Checks that a measurement ends with an error as soon as it asks whether to go on and the answer is an error.
/// `measure` gets the function that it asks between its steps.
fn check_questions(mut measure: impl FnMut(&mut dyn FnMut() -> Result<()>) -> Result<()>) {
    // Answers the first `yes` questions by yes. Returns how many were asked, and whether the measurement succeeded.
    let mut questions = |yes: usize| {
        let mut asked = 0;
        let outcome = measure(&mut || {
            asked += 1;
            if asked > yes { Err(Error::Stopped { signal: 2, kept: None }) } else { Ok(()) }
        });
        (asked, outcome.is_ok())
    };
    let (most, is_done) = questions(usize::MAX);
    assert!(is_done && most > 7, "{most}");
    for yes in [0, 1, most / 2, most - 1] {
        assert_eq!(questions(yes), (yes + 1, false));
    }
}

/// A ladder of precision and a motion of the camera end at any of their steps, although each is a single cell. A cell
/// may take minutes, in which a signal would go unheard.
#[test]
fn a_signal_ends_a_cell_between_its_steps() {
    let (gpu, scene, size) = (gpu(), built_in("corridor"), [34, 19]);
    let (view, methods) = (&scene.views[0], [methods::find("dda").unwrap()]);
    check_questions(|go_on| {
        let (globals, setup) = (Globals { roughness: Some(0.0), ..Globals::default() }, Setup::new(size));
        let spec = PrecisionSpec { gpu: &gpu, scene: &scene, view, globals, methods: &methods, setup, rays: 2 };
        precision::measure(&spec, go_on).map(drop)
    });
    let mut lineup = SceneMethods::new(&gpu, scene.clone(), &Setup::new(size), &methods).unwrap();
    check_questions(|go_on| {
        let (motion, roughness, frames, rays) = (Motion::SlowPan, 0.0, 2, 32);
        let spec = MotionSpec { view, motion, extent: size, roughness, frames, rays, against_world: true };
        motion::run(&gpu, &spec, &mut lineup, go_on).map(drop)
    });
    gpu.check_validation().unwrap();
}

/// A simulated loss of the device ends the run with a sentence, and all frames before it are recorded. After a failed
/// allocation the journal is unchanged, and the run can be resumed.
#[test]
fn a_lost_device_leaves_what_was_measured() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let faulty = |fault: &str| {
        ended(command(&TIME, &["--samples", "50", "--resume", "-o", out]).env("SSCT_FAULT", fault).output().unwrap())
    };
    let (status, message) = faulty("submission:300");
    assert_eq!(status, Some(1), "{message}");
    assert!(message.contains("device has been lost"), "{message}");
    let first = journal(folder.path());
    let timed: u64 =
        records(folder.path().join("time.json")).iter().map(|r| r["total"]["samples"].as_u64().unwrap()).sum();
    // Each of the two methods also has an entry for a frame that is not timed.
    assert!(first.len() > 10 && timed + 2 == first.len() as u64, "{timed} of {}", first.len());
    let (status, message) = faulty("allocation:60");
    assert_eq!(status, Some(1), "{message}");
    assert!(message.starts_with("ssct: Vulkan: "), "{message}");
    assert_eq!(journal(folder.path()), first);
    assert_eq!(faulty("nonsense").0, Some(2));
    assert_eq!(run(&TIME, &["--samples", "50", "--resume", "-o", out]).0, Some(0));
    assert_eq!(keys(&journal(folder.path())).len(), 2 * 51);
}

/// Folders that cannot be created and files beyond a limit of size are named in one sentence, and no half-written file
/// is left.
#[test]
fn no_room_and_no_right_to_write_are_sentences() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("file"), "").unwrap();
    let runs = [&TIME[..], &["study", "--quick"], &["error", "--quick"], &["stress", "--quick"], &["figures"]];
    for (n, args) in runs.into_iter().enumerate() {
        let out = [path("file"), path("file/below"), "/proc/ssct".to_owned()][n % 3].clone();
        let (status, message) = run(args, &["-o", &out]);
        assert_eq!(status, Some(1), "{args:?} {out}: {message}");
        assert!(message.contains("cannot create the folder") && message.contains(&out), "{message}");
    }
    // Files may have one kilobyte, two blocks of 512 bytes. This limit holds for the superuser, too.
    let run_limited = |args: &str| {
        let line = format!("trap '' XFSZ; ulimit -f 2; exec {SSCT} {args}");
        ended(Command::new("sh").args(["-c", &line]).current_dir(folder.path()).output().unwrap())
    };
    let is_killed = !expected_failures("file-limit", &gpu()).is_empty();
    for (args, file) in [
        ("render --scene corridor --size 96x54 -o x.png", "x.png"),
        ("render --scene corridor --size 96x54 -o x.exr", "x.exr"),
        ("gbuffer export --scene corridor --size 96x54 g.exr", "g.exr"),
        ("time --scene corridor --size 34x19 --method ssct --samples 3 -o t", "cells.json"),
    ] {
        let (status, message) = run_limited(args);
        // The study writes its first file before it opens a device.
        if is_killed && file != "cells.json" {
            assert_eq!(status, None, "{args}: the driver is listed as one that dies, and does not: {message}");
            continue;
        }
        assert_eq!(status, Some(1), "{args}: {message}");
        assert!(
            message.contains("cannot write") && message.contains(file) && message.contains("too large"),
            "{message}"
        );
    }
    let names = |directory: &Path| {
        let mut names: Vec<_> =
            std::fs::read_dir(directory).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names(folder.path()), ["file", "t"], "nothing half-written");
    for name in names(&folder.path().join("t")).iter().filter(|n| n.ends_with(".json")) {
        records(folder.path().join("t").join(name)); // Whole, or it would not parse.
    }
    if Path::new("/dev/full").exists() {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = Command::new(SSCT).arg("devices").stdout(full).stderr(Stdio::piped()).output().unwrap();
        let (status, message) = ended(output);
        assert_eq!(status, Some(1));
        assert!(message.contains("cannot print: No space left on device"), "{message}");
    }
}
