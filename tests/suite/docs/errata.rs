//! The pages of errata: their kinds of rows, and percentages that come from records alone.

use super::root;
use ssct_docs::pages::BEGIN;
use ssct_docs::records::read;
use std::fs;
use std::path::Path;

/// The kind of each row of a page of errata, by the place in print: `erratum` or `departure`. A page without that column has
/// departures alone.
pub fn kinds(page: &Path) -> Vec<(String, String)> {
    let mut rows = read(page, "").unwrap();
    let kind = |row: &mut ssct_docs::records::Row| {
        let place = row.remove("where").or_else(|| row.remove("no."))?;
        Some((place, row.remove("kind").unwrap_or_else(|| "departure".to_owned())))
    };
    rows.iter_mut().filter_map(kind).collect()
}

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

/// Percentages of the pages that nobody measured: what a test demands, and the part of a square outside of its circle.
const NOT_MEASURED: [&str; 2] = ["99.99 %", "21.5 %"];

#[test]
fn percentages_in_the_pages_of_errata_come_from_records() {
    let mut pages = 0;
    for entry in fs::read_dir(root().join("shaders-glsl")).unwrap() {
        let path = entry.unwrap().path().join("ERRATA.md");
        let Ok(text) = fs::read_to_string(&path) else { continue };
        pages += 1;
        // What stands between a mark and its end is written from records.
        let mut parts = text.split(BEGIN);
        let own: String =
            parts.next().into_iter().chain(parts.filter_map(|p| Some(p.split_once("<!-- end -->")?.1))).collect();
        let own = NOT_MEASURED.iter().fold(own, |text, known| text.replace(known, ""));
        let left = own.lines().find(|line| line.contains(" %"));
        assert_eq!(left, None, "{}: a percentage without a record", path.display());
    }
    assert!(pages > 6, "only {pages} pages");
}
