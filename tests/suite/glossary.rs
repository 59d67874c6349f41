//! Tests the page of words (`docs/glossary.md`): each name in the code that its tables give exists, and each word
//! stands there once.

use crate::common::repository;
use crate::common::sources::{GLSL, texts};
use std::collections::BTreeSet;

/// Folders of code.
const CODE: [&str; 5] = ["build.rs", "c", "lab", "shaders-glsl", "src"];

/// Cells of a row: the term, its meaning, its unit, its names in the code, and what others call it.
const COLUMNS: usize = 5;

/// Each row has five cells and a term of its own, and its names of code occur in the sources. Renamed types and
/// functions would leave dead names on the page.
#[test]
fn what_the_glossary_names_is_in_the_code() {
    let page = std::fs::read_to_string(repository().join("docs/glossary.md")).unwrap();
    let code = texts(&CODE, &[&["rs"][..], &GLSL].concat());
    let words_of = |(_, text): &'_ (String, String)| -> Vec<String> {
        text.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_owned).collect()
    };
    let words: BTreeSet<String> = code.iter().flat_map(words_of).collect();
    let mut terms = BTreeSet::new();
    let is_row = |line: &&str| line.starts_with("| ") && !line.starts_with("| term |");
    for row in page.lines().filter(is_row) {
        let cells: Vec<&str> = row.trim_matches(['|', ' ']).split(" | ").collect();
        assert_eq!(cells.len(), COLUMNS, "{row}");
        assert!(terms.insert(cells[0]), "{} stands twice", cells[0]);
        for name in cells[3].split('`').skip(1).step_by(2) {
            let last_part = name.trim_end_matches('!').rsplit("::").next().unwrap();
            assert!(
                words.contains(last_part) || repository().join(name).exists(),
                "{}: no {name} in the code",
                cells[0]
            );
        }
    }
    assert!(terms.len() > 100, "only {} terms", terms.len());
}
