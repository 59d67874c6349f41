//! Makes what the pages of the repository quote from records of measurements, and the pages that are made of tables in the code.
//!
//! A page names a query between two marks: `<!-- show: QUERY of RECORDS -->` and `<!-- end -->`. The queries are declared in
//! `lab/docs/queries/`, in the language of [`queries`]; `make docs` writes what they say between the marks.

mod devices;
mod evaluation;
mod expression;
mod format;
mod listings;
mod options;
pub mod pages;
mod plots;
pub mod queries;
mod readme;
pub mod records;
pub mod scenes;

use std::path::Path;

/// The files that are made: the name of each below the root of the repository, and the text that it should have.
pub fn files(root: &Path) -> Result<Vec<(String, String)>, String> {
    let queries = queries::Queries::read(root)?;
    let (mut files, mut failures) = (Vec::new(), Vec::new());
    for name in pages::quoting(root)? {
        match pages::text(root, &name).and_then(|text| pages::shown(&queries, root, &name, &text)) {
            Ok((text, _)) => files.push((name, text)),
            Err(failure) => failures.push(failure),
        }
    }
    let links = pages::definitions(&pages::text(root, "README.md")?);
    let folder =
        |name: &str| links.get(name).map(|target| root.join(target)).ok_or(format!("README.md has no link [{name}]"));
    let made = [
        ("docs/listings.md", listings::page(&queries, root)),
        ("docs/options.md", Ok(options::page())),
        ("docs/headline.svg", plots::headline(&queries, &folder("bars")?, &folder("bars-errors")?)),
        ("docs/world.svg", plots::world(&queries, folder("world")?)),
        ("lab/src/study/readme.csv", readme::csv(&queries, root)),
    ];
    for (name, text) in made {
        match text {
            Ok(text) => files.push((name.to_owned(), text)),
            Err(failure) => failures.push(format!("{name}: {failure}")),
        }
    }
    if failures.is_empty() { Ok(files) } else { Err(failures.join("\n")) }
}

/// What differs between a file and the text that it should have: the number of its first other line, and what both say there.
pub fn difference(root: &Path, name: &str, should: &str) -> Option<String> {
    let is = pages::text(root, name).unwrap_or_default();
    if is == should {
        return None;
    }
    let count = is.lines().zip(should.lines()).take_while(|(a, b)| a == b).count();
    let line = |text: &str| text.lines().nth(count).unwrap_or_default().to_owned();
    Some(format!("{name}, line {}:\n{}\n{}", count + 1, line(&is), line(should)))
}
