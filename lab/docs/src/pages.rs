//! Finds the pages and plots of the repository that quote records, and renews the texts between their marks.

use crate::queries::Queries;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The beginning of the mark before a quotation, which a query's name follows.
pub const BEGIN: &str = "<!-- show: ";

/// The mark after a quotation.
const END: &str = "<!-- end -->";

/// A result, or a sentence about why there is none.
type Result<T> = std::result::Result<T, String>;

/// Reads the text of a file, whose name is relative to the root.
pub(crate) fn read_page(root: &Path, name: &str) -> Result<String> {
    fs::read_to_string(root.join(name)).map_err(|e| format!("{name}: {e}"))
}

/// Returns the lines of a page that are not in a fenced block of code.
pub fn outside_code(text: &str) -> Vec<&str> {
    let mut is_inside = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_inside = !is_inside;
        } else if !is_inside {
            lines.push(line);
        }
    }
    lines
}

/// Returns the target of each link definition of a page by its name: `[name]: target`.
pub fn definitions(text: &str) -> BTreeMap<String, String> {
    let definition = |line: &str| {
        let (name, target) = line.strip_prefix('[')?.split_once("]: ")?;
        Some((name.to_owned(), target.trim().to_owned()))
    };
    outside_code(text).into_iter().filter_map(definition).collect()
}

/// A quotation of records on a page.
#[derive(Debug)]
pub struct Quotation<'a> {
    /// The name of the query, with its arguments.
    pub query: &'a str,
    /// The folders with the records that the query is about.
    pub folders: Vec<PathBuf>,
    /// The text that the page has now between the marks.
    pub says: &'a str,
    /// The text of the page between the previous quotation and this one.
    before: &'a str,
    /// The text of the mark: the query and the names of its records.
    mark: &'a str,
}

/// Returns the quotations of a page, and the text after the last one. A mark is `QUERY of RECORDS`, where RECORDS are
/// names of link definitions of the page, separated by commas. `name` is the page's name below the root, and `text` its
/// text.
pub fn quotations<'a>(root: &Path, name: &str, text: &'a str) -> Result<(Vec<Quotation<'a>>, &'a str)> {
    let folder = root.join(name).parent().map(Path::to_owned).unwrap_or_default();
    let defined = definitions(text);
    let (mut found, mut rest) = (Vec::new(), text);
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (mark, after) = after.split_once(" -->").ok_or_else(|| format!("{name}: a marker without an end"))?;
        let (says, after) =
            after.split_once(END).ok_or_else(|| format!("{name}: no end of what is shown of {mark}"))?;
        let (query, labels) = mark.split_once(" of ").ok_or_else(|| format!("{name}: {mark} of which records?"))?;
        let target = |label| match defined.get(label) {
            Some(target) => Ok(folder.join(target)),
            None => Err(format!("{name}: no link definition [{label}]")),
        };
        let folders = labels.split(", ").map(target).collect::<Result<_>>()?;
        found.push(Quotation { query, folders, says, before, mark });
        rest = after;
    }
    Ok((found, rest))
}

/// Returns the text of a page in which every quotation is replaced by the present answer of its query.
pub fn renew_quotations(queries: &Queries, root: &Path, name: &str, text: &str) -> Result<String> {
    let (quotations, rest) = quotations(root, name, text)?;
    let (mut renewed, mut failures) = (String::new(), Vec::new());
    for quotation in &quotations {
        match answer(queries, quotation) {
            Ok(answer) => renewed += &format!("{}{BEGIN}{} -->{answer}{END}", quotation.before, quotation.mark),
            Err(failure) => failures.push(format!("{name}: {}: {failure}", quotation.mark)),
        }
    }
    if failures.is_empty() { Ok(renewed + rest) } else { Err(failures.join("\n")) }
}

/// Returns the text that a page should have between the two marks of a quotation. A table, which begins with a line
/// break, must stand at the beginning of a line, and any other answer within a line.
fn answer(queries: &Queries, Quotation { query, folders, before, .. }: &Quotation) -> Result<String> {
    let answer = queries.answer(query, folders)?;
    // Markdown does not format a line that begins with an HTML comment, so that a number may not begin a line.
    if answer.starts_with('\n') == before.ends_with('\n') {
        Ok(answer)
    } else {
        Err("a table begins a line, and a number does not".to_owned())
    }
}

/// Beginnings of the names of folders that have no pages.
const NO_PAGES: [&str; 4] = ["target", "out", "fuzz/corpus", "benches/runs/2"];

/// Returns the names, relative to the root, of all pages and plots that quote records, in alphabetical order.
pub fn quoting_pages(root: &Path) -> Result<Vec<String>> {
    // Files and folders that are still to be looked at.
    let mut pending = vec![root.to_owned()];
    let mut found = Vec::new();
    while let Some(path) = pending.pop() {
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let is_hidden = name.starts_with('.') || name.ends_with("/target");
        if is_hidden || NO_PAGES.iter().any(|folder| name.starts_with(folder)) {
            continue;
        }
        if path.is_dir() {
            let entries = fs::read_dir(&path).map_err(|e| format!("{name}: {e}"))?;
            pending.extend(entries.filter_map(|entry| entry.ok().map(|entry| entry.path())));
        } else if (name.ends_with(".md") || name.ends_with(".svg")) && read_page(root, &name)?.contains(BEGIN) {
            found.push(name);
        }
    }
    found.sort();
    Ok(found)
}
