//! Makes what the pages of the repository quote from records of measurements, and the pages that are made of tables in the code.
//!
//! A page names a query between two marks: `<!-- show: QUERY of RECORDS -->` and `<!-- end -->`. `make docs` writes what the query
//! says between them. RECORDS are link definitions of the page. The queries are declared in `lab/docs/queries/`:
//!
//! ```toml
//! ["claim-error $method $other $against $roughness"]
//! from = "error.json"
//! where = "against=$against, roughness=$roughness"
//! answer = "{ratio(median([method=$method] rmse / [method=$other] rmse))}"
//! ```
//!
//! Words of the name that begin with `$` are arguments. A query has an `answer`, or `rows` and `columns` of a table, or `rows` and
//! `lines`, as plots have. What stands between braces in an answer, a cell or a line is an expression. These are its parts:
//!
//! - **A field**, such as `rmse` or `setup.own_rays`, is its numbers in all rows that have it. A name with blanks, or one that a
//!   function or a word has, stands between single quotes.
//! - **A choice** of rows, `[a=1|2, b!=x] rmse`. Conditions are `=`, `!=`, `^=` (begins with), `*=` (contains) and `!*` (does not).
//!   `*` is any value, `~` none, and `@first` that of the first row. `[time.csv: a=1]` has the rows of another file, `@2/time.csv` is
//!   in the second folder, `(a|b)/time.csv` is two files, and `path.json#frames` has a row for each element of an array.
//! - **Arithmetic**: `+ - * / < > =`. Two choices are matched row by row, by the fields of `by` (scene, view, roughness and size, if
//!   the query does not say otherwise). A row without a partner is an error; `~` divides, and leaves such rows out.
//! - **One number of many**: `median`, `mean`, `sum`, `least`, `greatest`, `first`, `last` and `count`. `median_by(scene view, x)` has
//!   a number for each group of rows, and so have the others. `part(x, 8, 16)` is some of the numbers; `some()` counts rows, of which
//!   there must be one.
//! - **A printed number**: `fixed(x, 4)`, `signed`, `percent`, `ratio` (two or three decimals), `grouped` (digits), `wait`, and of
//!   several numbers `middle` (median and greatest), `spread` and `ratios` (median, least and greatest), `range` and
//!   `range_of_ratios`. `text(field)` is the text of a field, and `join` puts texts together.
//! - **Cases**: `if(condition, a, b)`; `or(a, b)` is `b` where records or fields of `a` are missing; `holds(a=1)` is 1 or 0 by row;
//!   `within(x, 0, 1)` fails where a number lies outside of bounds.
//! - **Words**: expressions with a name, and constants, in `words.toml`.
//!
//! A loop of `rows`, or behind the cell of a column, gives variables their values: `a b: 1|2; 3|4` has two rounds. `a: distinct method`
//! takes the values of a field from the records, `sorted` sorts them, and `each [a.csv:]` makes a round of each record, with all of its
//! fields. `when` leaves rows out, and `order` sorts them by a number; `$nth` is then the number of a row.

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

/// The files that are made: the name of each below the root of the repository, and the text that it should have.
pub fn files(root: &Path) -> Result<Vec<(String, String)>, String> {
    let queries = queries::Queries::read(root)?;
    let (mut files, mut failures) = (Vec::new(), Vec::new());
    for name in pages::quoting(root)? {
        match pages::text(root, &name).and_then(|text| pages::shown(&queries, root, &name, &text)) {
            Ok(text) => files.push((name, text)),
            Err(failure) => failures.push(failure),
        }
    }
    let made = [
        ("docs/listings.md", listings::page(&queries, root)),
        ("docs/options.md", Ok(options::page())),
        ("lab/src/study/readme.csv", readme::csv(&queries, root)),
    ];
    for (name, text) in made {
        match text {
            Ok(text) => files.push((name.to_owned(), text)),
            Err(failure) => failures.push(format!("{name}: {failure}")),
        }
    }
    failures.extend(queries.all_asked().err());
    if failures.is_empty() { Ok(files) } else { Err(failures.join("\n")) }
}

/// Where a file first differs from the text that it should have: the number of the line, and the line in both, from a
/// little before the difference on. `None` if nothing differs.
pub fn difference(root: &Path, name: &str, should: &str) -> Option<String> {
    let is = pages::text(root, name).unwrap_or_default();
    if is == should {
        return None;
    }
    let count = is.lines().zip(should.lines()).take_while(|(a, b)| a == b).count();
    let [is, should] = [&*is, should].map(|text| text.lines().nth(count).unwrap_or_default());
    let same = is.chars().zip(should.chars()).take_while(|(a, b)| a == b).count().saturating_sub(60);
    let [is, should] = [is, should].map(|line| line.chars().skip(same).take(160).collect::<String>());
    Some(format!("{name}, line {}:\n{is}\n{should}", count + 1))
}
