//! Checks that each of these has one module for it: writing files, reading files of runs, and printing text. Only the
//! command and the window know command-line flags.

use super::{SCENES, Source, VIEW, sources};

/// Returns whether a source belongs to a program that reads arguments and prints: the command or the window.
fn is_command(s: &Source) -> bool {
    s.package == VIEW || s.is_of("app")
}

/// No source outside the command and the window prints or opens standard output. Other programs embed the rest, and
/// text of a library would mix with their own.
#[test]
fn only_the_command_prints() {
    for s in sources().iter().filter(|s| !is_command(s)) {
        for word in ["println!", "print!(", "dbg!(", "stdout()"] {
            assert!(!s.code.contains(word), "{}: {word}", s.path);
        }
    }
}

/// Standard output is opened in `app/printed.rs` and, when the program ends, in `app.rs`; no source calls `println!`.
/// The macro panics if a reader closes the pipe early.
#[test]
fn one_module_prints_to_standard_output() {
    // The code that ends the program flushes standard output, so that no text is left unprinted.
    const DOORS: [&str; 2] = ["app/printed.rs", "app.rs"];
    let sources = sources();
    let found: Vec<_> = sources.iter().filter(|s| s.code.contains("stdout()")).map(|s| s.path.as_str()).collect();
    assert!(found.len() == DOORS.len() && found.iter().all(|path| DOORS.contains(path)), "{found:?}");
    for s in sources.iter().filter(|s| !s.path.starts_with("tests/")) {
        // The macro `eprintln!` has the same end and prints to standard error.
        let prints = s.code.match_indices("println!(").any(|(place, _)| !s.code[..place].ends_with('e'));
        assert!(!prints, "{} of {} prints past the door", s.path, s.package);
    }
}

/// Words of code that writes files; only the door to files has them.
const WRITING: [&str; 10] = [
    "fs::write",
    "File::create",
    "OpenOptions",
    "create_dir",
    "fs::copy",
    "fs::rename",
    "hard_link",
    "symlink(",
    "tempfile",
    "persist(",
];

/// Only `inside.rs` of the package of scenes, the door to files, has code that writes files. Code elsewhere would
/// escape its checks, which keep files inside their folder.
#[test]
fn one_module_writes_files() {
    let sources = sources();
    let is_door = |s: &&Source| s.package == SCENES && s.path == "inside.rs";
    for s in sources.iter().filter(|s| !is_door(s) && !s.path.starts_with("tests/")) {
        let word = WRITING.iter().find(|word| s.code.contains(**word));
        assert!(word.is_none(), "{} of {} writes by {word:?}; inside.rs is the door", s.path, s.package);
    }
    let found = sources.iter().find(is_door).unwrap();
    assert!(["OpenOptions", "create_dir"].iter().all(|word| found.code.contains(word)));
}

/// Commands, reports and studies read files through the door `inside.rs`, which refuses paths that leave a folder. The
/// one other file opens a folder only to lock it.
#[test]
fn files_of_runs_are_read_by_one_module() {
    const LOCKS: [&str; 1] = ["report/run_folder.rs"];
    let reads = ["fs::read", "File::open", "read_to_string"];
    let reads_runs = |s: &&Source| s.package == "lab/src" && (s.is_of("report") || s.is_of("app") || s.is_of("study"));
    let sources = sources();
    let found: Vec<_> =
        sources.iter().filter(reads_runs).filter(|s| reads.iter().any(|w| s.code.contains(w))).collect();
    let paths: Vec<_> = found.iter().map(|s| s.path.as_str()).collect();
    assert_eq!(paths, LOCKS, "inside.rs reads");
}

/// Returns whether code names a flag in a string: two hyphens and a small letter, after a quotation mark, a blank or a
/// backquote.
fn names_a_flag(code: &str) -> bool {
    let is_flag = |(offset, _): (usize, &str)| {
        let before = code[..offset].chars().next_back();
        before.is_some_and(|c| c == '"' || c == ' ' || c == '`')
            && code[offset + 2..].starts_with(|c: char| c.is_ascii_lowercase())
    };
    code.match_indices("--").any(is_flag)
}

/// No source outside the command and the window names a flag, an exit status or `clap`. A message of the library that
/// names a flag means nothing to a program that embeds it.
#[test]
fn only_the_command_knows_flags_and_exit_statuses() {
    for s in sources().iter().filter(|s| !is_command(s)) {
        // The property `--rows` of a style sheet is no flag.
        let code = s.code.replace("\"--rows: \"", "");
        let flag = code.lines().find(|l| names_a_flag(l));
        assert!(flag.is_none(), "{} names a flag: {flag:?}", s.path);
        for word in ["clap::", "exit_status", "ExitCode", "process::exit"] {
            assert!(!code.contains(word) || s.path == "main.rs", "{}: {word}", s.path);
        }
    }
    assert!(names_a_flag("\"give --one\"") && names_a_flag("\"--one\"") && !names_a_flag("i-- ; a--b"));
}
