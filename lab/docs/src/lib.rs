//! Writes the numbers and tables that the pages of the repository quote from records of measurements, and the pages
//! that are made of tables in the code.
//!
//! A page quotes records between two marks: `<!-- show: QUERY of RECORDS -->` and `<!-- end -->`. `make docs` writes
//! the answer of the query between them. RECORDS are names of link definitions of the page, which lead to the folders
//! of the records. The queries are declared in `lab/docs/queries/`:
//!
//! ```toml
//! ["claim-error $method $other $against $roughness"]
//! from = "error.json"
//! where = "against=$against, roughness=$roughness"
//! answer = "{ratio(median([method=$method] rmse / [method=$other] rmse))}"
//! ```
//!
//! Words of a query's name that begin with `$` are arguments. A query has an `answer`, or the `rows` and `columns` of a
//! table, or the `rows` and `lines` of a plot. In an answer, a cell or a line, the text between two braces is an
//! expression. An expression has these parts:
//!
//! - **A field**, such as `rmse` or `setup.own_rays`, stands for its numbers in all rows that have it. A name with
//!   blanks, or one that a function or a word has, is put between single quotes.
//! - **A choice** takes some rows: `[a=1|2, b!=x] rmse`. Comparisons are `=`, `!=`, `^=` (begins with), `*=` (contains)
//!   and `!*` (does not contain). The value `*` fits any value, `~` a missing one, and `@first` is the value in the
//!   first row. `[time.csv: a=1]` takes rows of another file. `@2/time.csv` is in the second folder, `(a|b)/time.csv`
//!   is two files, and `path.json#frames` has a row for each element of an array.
//! - **Arithmetic** has the operators `+ - * / < > =`. The rows of two choices are matched by the fields of `by`
//!   (scene, view, roughness and size, if the query does not say otherwise). A row without a partner is an error; `~`
//!   divides, but leaves such rows out.
//! - **A summary** makes one number of many: `median`, `mean`, `sum`, `least`, `greatest`, `first`, `last` and `count`.
//!   `median_by(scene view, x)` makes one of each group of rows that agree in these fields; the other summaries have
//!   this form, too. `part(x, 8, 16)` takes some of the numbers. `some()` counts the rows, and fails if there are none.
//! - **A printed number** is made by `fixed(x, 4)`, `signed`, `percent`, `ratio` (two or three decimals), `grouped`
//!   (digits) or `wait`. Several numbers are printed by `middle` (median and greatest), `spread` and `ratios` (median,
//!   least and greatest), `range` and `range_of_ratios`. `text(field)` is the text of a field, and `join` puts texts
//!   together.
//! - **Cases** are `if(condition, a, b)`, and `or(a, b)`, which is `b` if records or fields of `a` are missing.
//!   `holds(a=1)` is 1 or 0 for each row; `within(x, 0, 1)` fails if a number lies outside the bounds.
//! - **Words** are expressions that have a name, and constants; `words.toml` defines both.
//!
//! A loop gives values to variables, round after round. Loops make the `rows` of a query, or, after the cell of a
//! column, several columns. `a b: 1|2; 3|4` gives values to two variables in two rounds. `a: distinct method` takes the
//! values of a field from the records, and `sorted` sorts them, too. `each [a.csv:]` makes a round of each record, with
//! all of its fields as variables. `when` leaves rows out, and `order` sorts them by a number; `$nth` is then the
//! number of a row.

mod devices;
mod evaluation;
mod expression;
mod format;
mod listings;
mod options;
pub mod pages;
pub mod queries;
mod readme;
pub mod records;
pub mod scenes;
#[cfg(test)]
mod tests;

use std::path::Path;

/// Returns all files that `make docs` writes: the name of each below the root of the repository, and the text that it
/// should have.
///
/// # Errors
/// The messages of all queries and pages that failed, a line each.
pub fn files(root: &Path) -> Result<Vec<(String, String)>, String> {
    let queries = queries::Queries::read(root)?;
    let (mut files, mut failures) = (Vec::new(), Vec::new());
    for name in pages::quoting_pages(root)? {
        match pages::read_page(root, &name).and_then(|text| pages::renew_quotations(&queries, root, &name, &text)) {
            Ok(text) => files.push((name, text)),
            Err(failure) => failures.push(failure),
        }
    }
    let other_files = [
        ("docs/listings.md", listings::page(&queries, root)),
        ("docs/options.md", Ok(options::page())),
        ("lab/src/study/readme.csv", readme::csv(&queries, root)),
    ];
    for (name, text) in other_files {
        match text {
            Ok(text) => files.push((name.to_owned(), text)),
            Err(failure) => failures.push(format!("{name}: {failure}")),
        }
    }
    failures.extend(queries.check_all_asked().err());
    if failures.is_empty() { Ok(files) } else { Err(failures.join("\n")) }
}

/// Returns a message about the first difference of a file from the text that it should have; `None` if nothing differs.
/// The message has the number of the line, and the line in both texts, from at most 60 characters before the difference
/// on.
pub fn difference(root: &Path, name: &str, should: &str) -> Option<String> {
    let actual = pages::read_page(root, name).unwrap_or_default();
    if actual == should {
        return None;
    }
    let equal_lines = actual.lines().zip(should.lines()).take_while(|(a, b)| a == b).count();
    let [actual, expected] = [&*actual, should].map(|text| text.lines().nth(equal_lines).unwrap_or_default());
    let skipped = actual.chars().zip(expected.chars()).take_while(|(a, b)| a == b).count().saturating_sub(60);
    let [actual, expected] = [actual, expected].map(|line| line.chars().skip(skipped).take(160).collect::<String>());
    Some(format!("{name}, line {}:\n{actual}\n{expected}", equal_lines + 1))
}
