//! Reads records of measurements: files of JSON, CSV, Markdown tables and plain text are all read as rows with named
//! fields.

use crate::scenes;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A failure to answer a query.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// True if records or fields are missing, so that a query may give another answer instead.
    pub is_missing: bool,
    /// A sentence with the reason.
    pub words: String,
}

impl Failure {
    /// Returns a failure because a file, a record or a field is missing.
    pub fn missing(words: impl Into<String>) -> Self {
        Self { is_missing: true, words: words.into() }
    }
}

impl<W: Into<String>> From<W> for Failure {
    fn from(words: W) -> Self {
        Self { is_missing: false, words: words.into() }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.words)
    }
}

/// An answer, or the reason why there is none.
pub type Result<T> = std::result::Result<T, Failure>;

/// A record: the text of each field by the field's name. A field of a nested object is called `object.field`.
pub type Row = BTreeMap<String, String>;

/// The rows of a file.
pub type Rows = Rc<Vec<Rc<Row>>>;

/// Which records are the first that compare with a reference as it is computed today. Older ones are refused.
struct FirstRecords {
    /// The day of the first records that are not JSON.
    day: &'static str,
    /// The version of the definitions that the first records of JSON have.
    definitions: u64,
}

/// The first records that compare with any reference as it is now. Before them, the rays of a reference left the centre
/// of a pixel.
const FIRST_VALID: FirstRecords = FirstRecords { day: "2026-11-23", definitions: 2 };

/// The first records that compare with the screen reference, which version 3 changed along edges and behind poles.
const FIRST_VALID_OF_SCREEN: FirstRecords = FirstRecords { day: "2026-11-28", definitions: 3 };

/// Returns the name of the run in which a path lies: the folder below `runs`.
pub fn run_name(path: &Path) -> Option<&str> {
    path.components().skip_while(|c| c.as_os_str() != "runs").nth(1)?.as_os_str().to_str()
}

/// Refuses a file if one of its records compares with an older reference. A record of JSON names the version of the
/// definitions by which it was made. Any other record was made on the day with which the name of its run begins.
fn check_references(path: &Path, rows: &[Row]) -> Result<()> {
    let day = run_name(path).and_then(|run| run.get(.."YYYY-MM-DD".len()));
    let is_json = path.extension().is_some_and(|extension| extension == "json");
    let is_older = |row: &Row| {
        let version = row.get("definitions").and_then(|version| version.parse::<u64>().ok()).filter(|_| is_json);
        let is_before = |first: &FirstRecords| match version {
            Some(version) => version < first.definitions,
            None => day.is_some_and(|day| day < first.day),
        };
        match row.get("against").map(String::as_str) {
            Some("screen") => is_before(&FIRST_VALID_OF_SCREEN),
            Some(_) => is_before(&FIRST_VALID),
            // Without the field, only JSON is refused: it may compare with a reference that it does not name.
            None => version.is_some() && is_before(&FIRST_VALID),
        }
    };
    if rows.iter().any(is_older) {
        Err(format!("{} is against an older reference", path.display()).into())
    } else {
        Ok(())
    }
}

/// Adds the fields of a JSON value to a row, under a name. An object is added as a whole, too; arrays and nulls are
/// left out.
fn flatten(row: &mut Row, name: &str, value: &Value) {
    match value {
        Value::Null | Value::Array(_) => {}
        Value::String(text) => drop(row.insert(name.to_owned(), text.clone())),
        Value::Object(fields) => {
            let prefix = if name.is_empty() { String::new() } else { format!("{name}.") };
            fields.iter().for_each(|(field, value)| flatten(row, &format!("{prefix}{field}"), value));
            row.insert(name.to_owned(), value.to_string());
        }
        other => drop(row.insert(name.to_owned(), other.to_string())),
    }
}

/// Returns a row for each record of a JSON text or, if `array` names an array, for each element of this array in each
/// record.
fn json_rows(text: &str, array: &str) -> std::result::Result<Vec<Row>, String> {
    let records: Vec<Value> = serde_json::from_str(text).map_err(|e| e.to_string())?;
    let mut rows = Vec::new();
    for record in records {
        let mut row = Row::new();
        flatten(&mut row, "", &record);
        row.remove("");
        if array.is_empty() {
            rows.push(row);
            continue;
        }
        for element in record[array].as_array().into_iter().flatten() {
            let mut row = row.clone();
            flatten(&mut row, array, element);
            rows.push(row);
        }
    }
    Ok(rows)
}

/// Returns the rows of a CSV text; lines that begin with # are comments.
fn csv_rows(text: &str) -> std::result::Result<Vec<Row>, String> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let head = reader.headers().map_err(|e| e.to_string())?.clone();
    let row = |record: csv::StringRecord| {
        head.iter().map(str::to_owned).zip(record.iter().map(str::to_owned)).collect::<Row>()
    };
    reader.records().map(|record| record.map(row).map_err(|e| e.to_string())).collect()
}

/// Returns the rows of all tables of a Markdown page. The heads of the tables name the fields; the field `row` is the
/// whole line.
fn table_rows(text: &str) -> Vec<Row> {
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let lines: Vec<&str> = text.lines().collect();
    let (mut head, mut rows) = (Vec::new(), Vec::new());
    for (n, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("| ")) {
        if lines.get(n + 1).is_some_and(|next| next.starts_with("|---")) {
            head = cells(line);
        } else {
            rows.push(head.iter().cloned().zip(cells(line)).chain([("row".to_owned(), (*line).to_owned())]).collect());
        }
    }
    rows
}

/// Returns a row for each line of a plain text. Blanks and commas separate the words of a line. The fields `w1`, `w2`,
/// … are the words counted from the first, and `e1`, `e2`, … those counted from the last. `text` is the line, and
/// `words` its number of words.
fn word_rows(text: &str) -> Vec<Row> {
    let row = |line: &str| {
        let words: Vec<_> = line.split([' ', ',']).filter(|word| !word.is_empty()).map(str::to_owned).collect();
        let count = words.len();
        // The two fields of the word with index n.
        let fields =
            |(n, word): (usize, String)| [(format!("w{}", n + 1), word.clone()), (format!("e{}", count - n), word)];
        let mut row: Row = words.into_iter().enumerate().flat_map(fields).collect();
        row.extend([("text".to_owned(), line.to_owned()), ("words".to_owned(), count.to_string())]);
        row
    };
    text.lines().map(row).collect()
}

/// Returns the name that tables give to the method of a row with its options, such as `unified + pccm, 4 captures`.
/// `None` if the row lacks one of the fields that the name has.
fn method_name(row: &Row) -> Option<String> {
    let [method, beyond, fallback, captures] = ["method", "beyond", "fallback", "captures"].map(|field| row.get(field));
    let (method, beyond, fallback, captures) = (method?, beyond?, fallback?, captures?);
    let alone = if beyond == "none" { ", screen alone" } else { "" };
    let behind = if fallback == "none" { String::new() } else { format!(" + {fallback}") };
    let captured = if captures == "none" { String::new() } else { format!(", {captures} captures") };
    Some(format!("{method}{alone}{behind}{captured}"))
}

/// Adds fields that follow from other fields: `size`, `name`, and for a case of stress the field `lacks`, which says
/// whether the method lacks something that it needs of the scene.
fn add_derived_fields(row: &mut Row) {
    if let (Some(width), Some(height), None) = (row.get("width"), row.get("height"), row.get("size")) {
        row.insert("size".to_owned(), format!("{width}x{height}"));
    }
    if let Some(name) = method_name(row).filter(|_| !row.contains_key("name")) {
        row.insert("name".to_owned(), name);
    }
    if let (Some(case), Some(method)) = (row.get("case"), row.get("method")) {
        let lacks = scenes::scene_of_row(None, Some(case)).is_some_and(|scene| scenes::lacks(scene, method));
        row.insert("lacks".to_owned(), if lacks { "yes" } else { "no" }.to_owned());
    }
}

/// Returns the rows of a file, read by the ending of its name. `array` names an array in records of JSON whose elements
/// become the rows, and may be empty.
pub fn read(path: &Path, array: &str) -> Result<Vec<Row>> {
    let fails = |e: String| Failure::from(format!("{}: {e}", path.display()));
    // A path `NAME.built-in` is no file: it stands for the counts of the built-in scene NAME.
    if let Some(scene) = path.to_str().and_then(|path| path.rsplit('/').next()?.strip_suffix(".built-in")) {
        return Ok(scenes::counts(scene).into_iter().collect());
    }
    let text = fs::read_to_string(path).map_err(|e| Failure::missing(format!("{}: {e}", path.display())))?;
    let mut rows = match path.extension().and_then(|extension| extension.to_str()) {
        Some("json") => json_rows(&text, array).map_err(fails)?,
        Some("csv") => csv_rows(&text).map_err(fails)?,
        Some("md") => table_rows(&text),
        _ => word_rows(&text),
    };
    rows.iter_mut().for_each(add_derived_fields);
    check_references(path, &rows)?;
    Ok(rows)
}

/// Returns the names that a pattern stands for: `(a|b)/c` stands for `a/c` and `b/c`.
fn each_name(pattern: &str) -> Vec<String> {
    let parts = pattern.split_once('(').and_then(|(before, rest)| Some((before, rest.split_once(')')?)));
    let Some((before, (names, after))) = parts else { return vec![pattern.to_owned()] };
    names.split('|').flat_map(|name| each_name(&format!("{before}{name}{after}"))).collect()
}

/// A cache of the files that were read.
#[derive(Debug, Default)]
pub struct Library {
    /// The rows by path and name of an array.
    read: RefCell<HashMap<(PathBuf, String), Rows>>,
}

impl Library {
    /// Returns the rows of a file, which is read only once.
    fn rows(&self, path: PathBuf, array: &str) -> Result<Rows> {
        let key = (path, array.to_owned());
        if let Some(rows) = self.read.borrow().get(&key) {
            return Ok(rows.clone());
        }
        let rows: Rows = Rc::new(read(&key.0, array)?.into_iter().map(Rc::new).collect());
        self.read.borrow_mut().insert(key, rows.clone());
        Ok(rows)
    }

    /// Returns the rows of the named files below some folders. `a/b.json` is in the first folder, `@2/b.json` in the
    /// second, and `@*/b.json` in each folder that has the file. `(a|b)/c.json` names two files. `b.json#passes` has a
    /// row for each element of the array `passes`. An empty name means the path of the folder itself, which then is a
    /// file.
    pub fn select(&self, folders: &[PathBuf], files: &str) -> Result<Rows> {
        let (files, array) = files.split_once('#').unwrap_or((files, ""));
        // The folders to look into, and the pattern of file names below them.
        let (searched, files) = match files.strip_prefix('@').map(|rest| rest.split_once('/').unwrap_or((rest, ""))) {
            Some(("*", files)) => (folders, files),
            Some((number, files)) => {
                let number: usize = number.parse().map_err(|_| format!("@{number} is no folder"))?;
                // A slice of one folder. The number 0 wraps to a range that no slice has.
                let folder =
                    folders.get(number.wrapping_sub(1)..number).ok_or(format!("there is no folder {number}"))?;
                (folder, files)
            }
            None => (folders.get(..1).ok_or("no records are named")?, files),
        };
        let names = each_name(files);
        let mut paths = Vec::new();
        for folder in searched {
            paths.extend(names.iter().map(|name| if name.is_empty() { folder.clone() } else { folder.join(name) }));
        }
        if searched.len() > 1 {
            paths.retain(|path| path.exists());
        }
        match &mut paths[..] {
            [path] => self.rows(std::mem::take(path), array),
            _ => {
                let mut rows = Vec::new();
                for path in paths {
                    rows.extend(self.rows(path, array)?.iter().cloned());
                }
                Ok(Rc::new(rows))
            }
        }
    }
}
