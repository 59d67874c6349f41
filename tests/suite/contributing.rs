//! Tests the page for contributors (`CONTRIBUTING.md`): every target, option, constant and test that it names exists. A
//! test in `docs.rs` checks on all pages that the files which they name exist.

use crate::ci::targets;
use crate::common::folder::Folder;
use crate::common::repository;
use crate::common::sources::texts;
use std::fmt::Debug;

/// Folders whose sources declare the names in capitals that the page quotes.
const DECLARING: [&str; 5] = ["c", "lab", "scripts", "src", "tests"];

/// Returns the pieces of text between backquotes on the page.
fn codes(page: &str) -> Vec<&str> {
    page.lines().flat_map(|line| line.split('`').skip(1).step_by(2)).collect()
}

/// Returns the words of a piece of code; a variable and its value are two.
fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split([' ', '=']).filter(|word| !word.is_empty())
}

/// Returns the names in capitals in a piece of code: constants, and variables of `make` and of the environment.
fn capitals(code: &str) -> impl Iterator<Item = &str> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let is_name = |word: &&str| word.len() > 3 && word.chars().all(|c| c.is_ascii_uppercase() || c == '_');
    code.split(move |c| !is_part(c)).filter(is_name)
}

/// Returns the targets that a piece of code makes: the words after `make` that have no `=`.
fn targets_made_by(code: &str) -> Vec<&str> {
    let arguments = code.strip_prefix("make ").unwrap_or_default();
    arguments.split_whitespace().filter(|word| !word.contains('=')).collect()
}

/// Returns the command of `ssct` in a piece of code, and its options, or `None` if the code does not call `ssct`.
fn command(code: &str) -> Option<(&str, Vec<&str>)> {
    let mut words = code.split_whitespace().skip_while(|word| word.contains('='));
    let command = words.next().filter(|word| *word == "ssct").and_then(|_| words.next())?;
    Some((command, words.filter(|word| word.starts_with('-')).collect()))
}

/// Returns the text of the page.
fn page() -> String {
    std::fs::read_to_string(repository().join("CONTRIBUTING.md")).unwrap()
}

/// Fails if a thing of some kind that the page names does not exist, or if the page names at most `least` things of
/// this kind. `is_there` says whether a thing exists.
fn check<T: Debug>(kind: &str, named: &[T], least: usize, is_there: impl Fn(&T) -> bool) {
    let missing: Vec<&T> = named.iter().filter(|name| !is_there(name)).collect();
    assert!(missing.is_empty(), "there are no {kind} {missing:?}");
    assert!(named.len() > least, "only {} {kind} are named", named.len());
}

/// On the page, the targets are in the Makefile, the options in the help of their commands, the constants and variables
/// in the sources, and the modules of tests have files. A renamed thing would leave the page wrong.
#[test]
fn what_the_page_names_is_there() {
    let (page, targets, folder) = (page(), targets(), Folder::new());
    let codes = codes(&page);
    let made_targets: Vec<&str> = codes.iter().flat_map(|code| targets_made_by(code)).collect();
    check("targets", &made_targets, 10, |target| targets.contains(*target));

    let commands: Vec<_> = codes.iter().filter_map(|code| command(code)).collect();
    check("commands", &commands, 2, |(command, options)| {
        let help = folder.succeed(&[command, "--help"]);
        options.iter().all(|option| help.split([' ', ',', '\n']).any(|word| word == *option))
    });

    let mut sources = std::fs::read_to_string(repository().join("Makefile")).unwrap();
    sources.extend(texts(&DECLARING, &["rs", "sh", "py"]).into_iter().map(|(_, text)| text));
    let capitals: Vec<&str> = codes.iter().flat_map(|code| capitals(code)).collect();
    check("constants and variables", &capitals, 8, |name| sources.contains(*name));

    let tests: Vec<&str> =
        codes.iter().flat_map(|code| words(code)).filter_map(|word| word.strip_suffix("::")).collect();
    check("files of tests", &tests, 2, |module| {
        ["suite", "alone"].iter().any(|program| repository().join(format!("tests/{program}/{module}.rs")).exists())
    });
}

/// The functions above find targets, commands, options and names in pieces of code. If they found too little, the other
/// test would pass on a wrong page.
#[test]
fn code_is_read_as_its_author_means_it() {
    let page = "Set `A_VARIABLE=shaders-glsl/common` and run `make docs FILE=x`, then `ssct render -o a.png`.";
    assert_eq!(codes(page), ["A_VARIABLE=shaders-glsl/common", "make docs FILE=x", "ssct render -o a.png"]);
    assert_eq!(words("cargo test -- history::").last(), Some("history::"));
    assert_eq!(targets_made_by("make docs FILE=x lint"), ["docs", "lint"]);
    assert_eq!(command("A_VARIABLE=shaders-glsl ssct index runs -o site"), Some(("index", vec!["-o"])));
    assert_eq!(command("ssct"), None);
    assert_eq!(capitals("A_VARIABLE=1 cargo test METHODS").collect::<Vec<_>>(), ["A_VARIABLE", "METHODS"]);
}
