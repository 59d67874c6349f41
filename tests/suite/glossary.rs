//! The page of words (`docs/glossary.md`): what its tables name in the code is there, and each word stands once.

use crate::common::repository;
use std::collections::BTreeSet;
use std::path::Path;

/// Folders of code.
const CODE: [&str; 5] = ["build.rs", "c", "lab", "shaders-glsl", "src"];

/// Cells of a row: the term, its meaning, its unit, its names in the code, and what others call it.
const COLUMNS: usize = 5;

/// Adds the words of all sources below a path.
fn add_words(path: &Path, words: &mut BTreeSet<String>) {
    if path.is_dir() {
        std::fs::read_dir(path).unwrap().for_each(|entry| add_words(&entry.unwrap().path(), words));
    } else if path.extension().is_some_and(|e| ["rs", "glsl", "comp", "frag", "vert"].iter().any(|known| e == *known)) {
        let text = std::fs::read_to_string(path).unwrap();
        words.extend(text.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_owned));
    }
}

#[test]
fn what_the_glossary_names_is_in_the_code() {
    let page = std::fs::read_to_string(repository().join("docs/glossary.md")).unwrap();
    let mut words = BTreeSet::new();
    CODE.iter().for_each(|folder| add_words(&repository().join(folder), &mut words));
    let mut terms = BTreeSet::new();
    let is_row = |line: &&str| line.starts_with("| ") && !line.starts_with("| term |");
    for row in page.lines().filter(is_row) {
        let cells: Vec<&str> = row.trim_matches(['|', ' ']).split(" | ").collect();
        assert_eq!(cells.len(), COLUMNS, "{row}");
        assert!(terms.insert(cells[0]), "{} stands twice", cells[0]);
        for name in cells[3].split('`').skip(1).step_by(2) {
            let last = name.trim_end_matches('!').rsplit("::").next().unwrap();
            assert!(words.contains(last) || repository().join(name).exists(), "{}: no {name} in the code", cells[0]);
        }
    }
    assert!(terms.len() > 100, "only {} terms", terms.len());
}
