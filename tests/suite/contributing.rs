//! The page for whoever changes this repository (`CONTRIBUTING.md`): every file, target, option, variable and test that it names exists.

use crate::ci::targets;
use crate::common::folder::Folder;
use crate::common::repository;
use std::path::{Path, PathBuf};

/// Folders whose sources declare the names in capitals that the page quotes.
const DECLARING: [&str; 5] = ["c", "lab", "scripts", "src", "tests"];

/// Extensions of these sources.
const SOURCES: [&str; 3] = ["rs", "sh", "py"];

/// The pieces of code of the page.
fn codes(page: &str) -> Vec<&str> {
    page.lines().flat_map(|line| line.split('`').skip(1).step_by(2)).collect()
}

/// The words of a piece of code; a variable and its value are two.
fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split([' ', '=']).filter(|word| !word.is_empty())
}

/// Whether a word is the path of a file or a folder below the root. A name in angle brackets stands for any.
fn is_path(word: &str) -> bool {
    let is_plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
    let is_of_root = word == "Makefile" || [".md", ".rs"].iter().any(|end| word.ends_with(end));
    is_plain && !word.starts_with(['.', '-', '/']) && (word.contains('/') || is_of_root)
}

/// The names in capitals in a piece of code: constants, variables of `make` and of the environment.
fn capitals(code: &str) -> impl Iterator<Item = &str> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let is_name = |word: &&str| word.len() > 3 && word.chars().all(|c| c.is_ascii_uppercase() || c == '_');
    code.split(move |c| !is_part(c)).filter(is_name)
}

/// What a piece of code makes: the words behind `make` that are no variables.
fn made(code: &str) -> Vec<&str> {
    let behind = code.strip_prefix("make ").unwrap_or_default();
    behind.split_whitespace().filter(|word| !word.contains('=')).collect()
}

/// The command of the program in a piece of code, with its options.
fn command(code: &str) -> Option<(&str, Vec<&str>)> {
    let mut words = code.split_whitespace().skip_while(|word| word.contains('='));
    let command = words.next().filter(|word| *word == "ssct").and_then(|_| words.next())?;
    Some((command, words.filter(|word| word.starts_with('-')).collect()))
}

fn add_sources(path: &Path, text: &mut String) {
    if path.is_dir() {
        for entry in std::fs::read_dir(path).unwrap() {
            add_sources(&entry.unwrap().path(), text);
        }
    } else if path.extension().is_some_and(|e| SOURCES.iter().any(|wanted| e == *wanted)) {
        text.push_str(&std::fs::read_to_string(path).unwrap());
    }
}

fn page() -> String {
    std::fs::read_to_string(repository().join("CONTRIBUTING.md")).unwrap()
}

#[test]
fn files_that_the_page_names_exist() {
    let page = page();
    let named: Vec<&str> = codes(&page).into_iter().flat_map(words).filter(|word| is_path(word)).collect();
    let missing: Vec<&&str> = named.iter().filter(|path| !repository().join(path).exists()).collect();
    assert!(missing.is_empty(), "there are no {missing:?}");
    assert!(named.len() > 50, "only {} files are named", named.len());
}

#[test]
fn targets_that_the_page_makes_exist() {
    let (page, targets) = (page(), targets());
    let made: Vec<&str> = codes(&page).into_iter().flat_map(made).collect();
    let missing: Vec<&&str> = made.iter().filter(|target| !targets.contains(**target)).collect();
    assert!(missing.is_empty(), "the Makefile makes no {missing:?}");
    assert!(made.len() > 10, "only {} targets are named", made.len());
}

#[test]
fn commands_that_the_page_shows_have_their_options() {
    let (page, folder) = (page(), Folder::new());
    let commands: Vec<_> = codes(&page).into_iter().filter_map(command).collect();
    for (command, options) in &commands {
        let help = folder.succeed(&[command, "--help"]);
        let is_there = |option: &&str| help.split([' ', ',', '\n']).any(|word| word == *option);
        let missing: Vec<_> = options.iter().filter(|option| !is_there(option)).collect();
        assert!(missing.is_empty(), "ssct {command} has no {missing:?}");
    }
    assert!(commands.len() > 2, "only {} commands are shown", commands.len());
}

#[test]
fn constants_and_variables_that_the_page_quotes_are_declared() {
    let page = page();
    let mut sources = std::fs::read_to_string(repository().join("Makefile")).unwrap();
    let folders: Vec<PathBuf> = DECLARING.iter().map(|folder| repository().join(folder)).collect();
    folders.iter().for_each(|folder| add_sources(folder, &mut sources));
    let quoted: Vec<&str> = codes(&page).into_iter().flat_map(capitals).collect();
    let missing: Vec<&&str> = quoted.iter().filter(|name| !sources.contains(**name)).collect();
    assert!(missing.is_empty(), "nothing declares {missing:?}");
    assert!(quoted.len() > 8, "only {} names are quoted", quoted.len());
}

#[test]
fn tests_that_the_page_runs_exist() {
    let page = page();
    let run: Vec<&str> = codes(&page).into_iter().flat_map(words).filter_map(|word| word.strip_suffix("::")).collect();
    let is_there = |module: &str| {
        ["suite", "alone"].iter().any(|program| repository().join(format!("tests/{program}/{module}.rs")).exists())
    };
    let missing: Vec<&&str> = run.iter().filter(|module| !is_there(module)).collect();
    assert!(missing.is_empty(), "no file of tests is called {missing:?}");
    assert!(run.len() > 2, "only {} files of tests are named", run.len());
}

#[test]
fn code_is_read_as_its_author_means_it() {
    let page = "Set `A_VARIABLE=shaders-glsl/common` and run `make docs FILE=x`, then `ssct render -o a.png`.";
    assert_eq!(codes(page), ["A_VARIABLE=shaders-glsl/common", "make docs FILE=x", "ssct render -o a.png"]);
    let paths = |code| words(code).filter(|word| is_path(word)).collect::<Vec<_>>();
    assert_eq!(paths("A_VARIABLE=shaders-glsl/common ssct render -o a.png"), ["shaders-glsl/common"]);
    assert_eq!(paths("src/methods/<name>.rs ../up/x.rs build.rs"), ["build.rs"]);
    assert_eq!(made("make docs FILE=x lint"), ["docs", "lint"]);
    assert_eq!(command("A_VARIABLE=shaders-glsl ssct index runs -o site"), Some(("index", vec!["-o"])));
    assert_eq!(command("ssct"), None);
    assert_eq!(capitals("A_VARIABLE=1 cargo test METHODS").collect::<Vec<_>>(), ["A_VARIABLE", "METHODS"]);
}
