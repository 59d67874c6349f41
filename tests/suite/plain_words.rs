//! Comments that a stranger understands: each begins with its subject or with what its item does. Beginnings that point at
//! something else ("The same", "Those", "Of") are kept out of code, shaders and tests.

use crate::common::repository;
use std::path::{Path, PathBuf};

/// Folders and files with comments.
const PLACES: &[&str] =
    &["benches", "build.rs", "c", "examples", "fuzz", "lab", "scripts", "shaders-glsl", "src", "tests"];

/// Folders in them with what nobody wrote.
const SKIPPED: &[&str] = &["target", "corpus", "runs", "golden"];

/// Files of these kinds have comments after slashes.
const EXTENSIONS: &[&str] = &["rs", "c", "h", "glsl", "frag", "vert", "comp"];

/// Beginnings that leave open what a comment is about.
const UNCLEAR: &[&str] = &["What of ", "Of ", "Those ", "That of ", "As ", "The same", "What there ", "Whether there "];

/// The text of the comment on a line, and whether code stands before it.
fn comment(line: &str) -> Option<(&str, bool)> {
    let offset = line.find("//")?;
    let (before, marked) = line.split_at(offset);
    // Two slashes in a string or in an address are no comment.
    let is_code = before.contains('"') || before.ends_with(':');
    (!is_code).then(|| (marked.trim_start_matches(['/', '!']).trim(), !before.trim().is_empty()))
}

/// The lines on which a comment, or a paragraph of one, begins in an unclear way, counted from 1.
fn unclear(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let mut goes_on = false;
    for (n, line) in text.lines().enumerate() {
        let Some((said, is_behind_code)) = comment(line) else {
            goes_on = false;
            continue;
        };
        if (!goes_on || is_behind_code) && UNCLEAR.iter().any(|words| said.starts_with(words)) {
            found.push(n + 1);
        }
        goes_on = !said.is_empty() && !said.starts_with('#');
    }
    found
}

fn add(path: &Path, found: &mut Vec<PathBuf>) {
    if path.is_dir() {
        if path.file_name().is_some_and(|name| SKIPPED.iter().any(|skipped| name == *skipped)) {
            return;
        }
        for entry in std::fs::read_dir(path).unwrap() {
            add(&entry.unwrap().path(), found);
        }
    } else if path.extension().is_some_and(|e| EXTENSIONS.iter().any(|wanted| e == *wanted)) {
        found.push(path.to_owned());
    }
}

#[test]
fn comments_begin_with_their_subject() {
    let mut files = Vec::new();
    PLACES.iter().for_each(|place| add(&repository().join(place), &mut files));
    assert!(files.len() > 400, "only {} files", files.len());
    let mut wrong = Vec::new();
    for path in files {
        let name = path.strip_prefix(repository()).unwrap().to_string_lossy().replace('\\', "/");
        let lines = unclear(&std::fs::read_to_string(&path).unwrap());
        wrong.extend(lines.iter().map(|line| format!("{name}:{line}")));
    }
    assert!(wrong.is_empty(), "comments begin with {UNCLEAR:?}:\n{}", wrong.join("\n"));
}

#[test]
fn beginnings_are_told_from_continuations() {
    for (text, lines) in [
        ("/// Those of the device.", &[1][..]),
        ("/// # Errors\n/// Those of the device.", &[2]),
        ("//! Draws an image.\n//!\n//! The same without sky.", &[3]),
        ("const A: i32 = 1; // As it is.", &[1]),
        ("// The value is kept.\n// Of course it may change.", &[]),
        ("let a = \"// Of strings\";", &[]),
        ("/// Offset in bytes.\n// Assumed thickness.", &[]),
    ] {
        assert_eq!(unclear(text), lines, "{text}");
    }
}
