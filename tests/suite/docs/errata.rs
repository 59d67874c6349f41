//! What the departures from print change, from the records of `cargo bench --bench errata`: the numbers in the pages of errata.

use super::figures::{Result, csv, greatest, median, number, percent};
use super::root;
use std::fs;
use std::path::Path;

/// The share of pixels that a departure changes, and the difference of the images: median and maximum over the views.
pub fn erratum(folder: &Path, variant: &str) -> Result<String> {
    let rows = csv(folder, "errata.csv")?;
    let own: Vec<_> = rows.iter().filter(|r| r["variant"] == variant).collect();
    let column = |field: &str| own.iter().map(|r| number(r, field)).collect::<Result<Vec<f64>>>();
    let (shares, errors) = (column("share")?, column("rmse")?);
    let shares = [median(&shares)?, greatest(&shares)].map(|share| percent(share, 2));
    let errors = [median(&errors)?, greatest(&errors)].map(|error| format!("{error:.4}"));
    Ok(format!("{} of pixels; RMSE {}", shares.join(", "), errors.join(", ")))
}

/// The kind of each row of a page of errata, by the place in print: `erratum` or `departure`. A page without that column has
/// departures alone.
pub fn kinds(page: &str) -> Vec<(String, String)> {
    let mut has_kinds = false;
    let mut rows = Vec::new();
    for cells in page.lines().filter_map(|line| line.strip_prefix("| ")) {
        let mut cells = cells.split(" | ");
        let [place, second] = [cells.next(), cells.next()].map(|cell| cell.unwrap_or_default().to_owned());
        if place == "where" || place == "no." {
            has_kinds = second == "kind";
        } else {
            rows.push((place, if has_kinds { second } else { "departure".to_owned() }));
        }
    }
    rows
}

/// The number of rows of a kind in a page, or in those of the two theses below a folder.
pub fn rows(path: &Path, kind: &str) -> Result<String> {
    let pages = match path.is_dir() {
        true => ["thesis", "schmidt"].map(|document| path.join(document).join("ERRATA.md")).to_vec(),
        false => vec![path.to_owned()],
    };
    let texts = pages.iter().map(|page| fs::read_to_string(page).map_err(|e| format!("{}: {e}", page.display())));
    let all: Vec<_> = texts.collect::<Result<Vec<_>>>()?.iter().flat_map(|text| kinds(text)).collect();
    match all.iter().filter(|(_, found)| found == kind).count() {
        0 => Err(format!("no row is of the kind {kind}")),
        n => Ok(n.to_string()),
    }
}

#[test]
fn every_row_is_an_erratum_or_a_departure() {
    let mut found = std::collections::BTreeMap::<String, usize>::new();
    for folder in ["thesis", "schmidt"] {
        let page = fs::read_to_string(root().join("shaders-glsl").join(folder).join("ERRATA.md")).unwrap();
        for (place, kind) in kinds(&page) {
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
        let mut parts = text.split("<!-- show: ");
        let own: String =
            parts.next().into_iter().chain(parts.filter_map(|p| Some(p.split_once("<!-- end -->")?.1))).collect();
        let own = NOT_MEASURED.iter().fold(own, |text, known| text.replace(known, ""));
        let left = own.lines().find(|line| line.contains(" %"));
        assert_eq!(left, None, "{}: a percentage without a record", path.display());
    }
    assert!(pages > 6, "only {pages} pages");
}
