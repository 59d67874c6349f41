//! Tests the pages of errata: their kinds of rows, and that their percentages come from records alone.

use super::root;
use ssct_docs::pages::BEGIN;
use ssct_docs::records::read;
use std::fs;
use std::path::Path;

/// Returns the place in print and the kind, `erratum` or `departure`, of each row of a page of errata. On a page
/// without a column for the kind, all rows are departures.
pub fn kinds(page: &Path) -> Vec<(String, String)> {
    let mut rows = read(page, "").unwrap();
    let kind = |row: &mut ssct_docs::records::Row| {
        let place = row.remove("where").or_else(|| row.remove("no."))?;
        Some((place, row.remove("kind").unwrap_or_else(|| "departure".to_owned())))
    };
    rows.iter_mut().filter_map(kind).collect()
}

/// Each row of the pages of errata of the thesis and of Schmidt's document is of one of the two kinds, and both kinds
/// occur. Other pages count on these two words.
#[test]
fn every_row_is_an_erratum_or_a_departure() {
    let mut found = std::collections::BTreeMap::<String, usize>::new();
    for folder in ["thesis", "schmidt"] {
        for (place, kind) in kinds(&root().join("shaders-glsl").join(folder).join("ERRATA.md")) {
            assert!(["erratum", "departure"].contains(&kind.as_str()), "{folder}, {place}: {kind} is no kind");
            *found.entry(kind).or_default() += 1;
        }
    }
    assert!(found.values().all(|n| *n > 20) && found.len() == 2, "{found:?}");
}

/// Percentages on the pages that are no measurements: one that a test demands, and the part of a square outside of its
/// circle.
const NOT_MEASURED: [&str; 2] = ["99.99 %", "21.5 %"];

/// Each percentage on a page of errata is written from a record, except the two known ones. A number that was typed in
/// grows wrong unseen.
#[test]
fn percentages_in_the_pages_of_errata_come_from_records() {
    let mut pages = 0;
    for entry in fs::read_dir(root().join("shaders-glsl")).unwrap() {
        let path = entry.unwrap().path().join("ERRATA.md");
        let Ok(text) = fs::read_to_string(&path) else { continue };
        pages += 1;
        // `make docs` writes the text between a mark and its end from records, so that this text is left out.
        let mut parts = text.split(BEGIN);
        let typed: String =
            parts.next().into_iter().chain(parts.filter_map(|p| Some(p.split_once("<!-- end -->")?.1))).collect();
        let typed = NOT_MEASURED.iter().fold(typed, |text, known| text.replace(known, ""));
        let unrecorded = typed.lines().find(|line| line.contains(" %"));
        assert_eq!(unrecorded, None, "{}: a percentage without a record", path.display());
    }
    assert!(pages > 6, "only {pages} pages");
}
