//! The pages and plots of the repository, and what they quote from records between their marks.

use crate::queries::Queries;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The mark before what a query says.
pub const BEGIN: &str = "<!-- show: ";

/// The mark behind it.
const END: &str = "<!-- end -->";

/// A text, or a sentence about why there is none.
type Result<T> = std::result::Result<T, String>;

/// The text of a file below the root.
pub(crate) fn text(root: &Path, name: &str) -> Result<String> {
    fs::read_to_string(root.join(name)).map_err(|e| format!("{name}: {e}"))
}

/// Lines that do not stand in a fenced block.
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

/// A page's link definitions: `[name]: target`.
pub fn definitions(text: &str) -> BTreeMap<String, String> {
    let definition = |line: &str| {
        let (name, target) = line.strip_prefix('[')?.split_once("]: ")?;
        Some((name.to_owned(), target.trim().to_owned()))
    };
    outside_code(text).into_iter().filter_map(definition).collect()
}

/// What stands between a mark and its end.
#[derive(Debug)]
pub struct Shown<'a> {
    /// The query, with its arguments.
    pub query: &'a str,
    /// The folders that it is of.
    pub folders: Vec<PathBuf>,
    /// What the page says.
    pub says: &'a str,
    /// The text of the page before the mark.
    before: &'a str,
    /// The mark.
    mark: &'a str,
}

/// What a page quotes, and the text behind its last quotation. Behind ` of ` in a mark stand link definitions of the page, with commas
/// between them.
pub fn quotations<'a>(root: &Path, name: &str, text: &'a str) -> Result<(Vec<Shown<'a>>, &'a str)> {
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
        found.push(Shown { query, folders, says, before, mark });
        rest = after;
    }
    Ok((found, rest))
}

/// The text of a page in which every quotation is replaced by what its query answers now.
///
/// # Errors
/// A sentence about a mark that is wrong, or the failures of all queries.
pub fn shown(queries: &Queries, root: &Path, name: &str, text: &str) -> Result<String> {
    let (all, rest) = quotations(root, name, text)?;
    let (mut result, mut failures) = (String::new(), Vec::new());
    for shown in &all {
        match answer(queries, shown) {
            Ok(answer) => result += &format!("{}{BEGIN}{} -->{answer}{END}", shown.before, shown.mark),
            Err(failure) => failures.push(format!("{name}: {}: {failure}", shown.mark)),
        }
    }
    if failures.is_empty() { Ok(result + rest) } else { Err(failures.join("\n")) }
}

/// What a page should say between a mark and its end.
fn answer(queries: &Queries, Shown { query, folders, before, .. }: &Shown) -> Result<String> {
    let answer = queries.shown(query, folders)?;
    // Markdown does not format a line that begins with an HTML comment, so that a number may not begin a line.
    if answer.starts_with('\n') == before.ends_with('\n') {
        Ok(answer)
    } else {
        Err("a table begins a line, and a number does not".to_owned())
    }
}

/// Folders that no page lies in.
const NO_PAGES: [&str; 4] = ["target", "out", "fuzz/corpus", "benches/runs/2"];

/// The names below the root of all pages and plots that quote records.
pub fn quoting(root: &Path) -> Result<Vec<String>> {
    let mut left = vec![root.to_owned()];
    let mut found = Vec::new();
    while let Some(path) = left.pop() {
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        let is_hidden = name.starts_with('.') || name.ends_with("/target");
        if is_hidden || NO_PAGES.iter().any(|folder| name.starts_with(folder)) {
            continue;
        }
        if path.is_dir() {
            let entries = fs::read_dir(&path).map_err(|e| format!("{name}: {e}"))?;
            left.extend(entries.filter_map(|entry| entry.ok().map(|entry| entry.path())));
        } else if (name.ends_with(".md") || name.ends_with(".svg")) && text(root, &name)?.contains(BEGIN) {
            found.push(name);
        }
    }
    found.sort();
    Ok(found)
}
