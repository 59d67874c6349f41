//! How records are read, and how their figures are put together and written.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What a page lacks is said in a sentence.
pub type Result<T> = std::result::Result<T, String>;

/// A row of a CSV file or an object of a JSON file, by field.
pub type Row = BTreeMap<String, String>;

/// Roughness values of the studies, as their CSV files write them.
pub const ROUGHNESS: [&str; 5] = ["0.0", "0.05", "0.1", "0.3", "0.6"];

/// The first day of records that are held against today's references, and the version of the definitions that records of JSON have
/// since then. Before it, the rays of a reference left the centre of a pixel.
const FIRST: (&str, u64) = ("2026-11-23", 2);

/// First day and version of the screen reference of today, which version 3 of the definitions changed along edges and behind poles.
const FIRST_OF_SCREEN: (&str, u64) = ("2026-11-28", 3);

/// When a record was made.
#[derive(Clone, Copy)]
pub enum Made<'a> {
    /// By this version of the definitions, which a record of JSON names.
    By(u64),
    /// On the day of the run whose folder the file lies in.
    OnDayOf(&'a Path),
}

/// Whether a record is older than a day and a version.
fn is_before(made: Made, (day, version): (&str, u64)) -> bool {
    match made {
        Made::By(definitions) => definitions < version,
        Made::OnDayOf(path) => day_of(path).is_some_and(|made| made.as_str() < day),
    }
}

/// Whether a record is held against an older screen reference.
fn is_of_an_older_screen((against, made): (&str, Made)) -> bool {
    against == "screen" && is_before(made, FIRST_OF_SCREEN)
}

/// Refuses a file of records of which one is held against an older reference: for each record, what it is held against.
pub fn of_todays_references<'a>(path: &Path, records: impl IntoIterator<Item = (&'a str, Made<'a>)>) -> Result<()> {
    let is_older = |record: (&str, Made)| is_before(record.1, FIRST) || is_of_an_older_screen(record);
    let older = records.into_iter().any(is_older);
    if older { Err(format!("{} is against an older reference", path.display())) } else { Ok(()) }
}

/// The day of the run that a path lies in.
fn day_of(path: &Path) -> Option<String> {
    let run = path.components().skip_while(|c| c.as_os_str() != "runs").nth(1)?;
    Some(run.as_os_str().to_str()?.get(..FIRST.0.len())?.to_owned())
}

/// Rows of a CSV file; lines that begin with # are comments.
pub fn csv(folder: &Path, file: &str) -> Result<Vec<Row>> {
    let path = folder.join(file);
    let message = |e: csv::Error| format!("{}: {e}", path.display());
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(&path).map_err(message)?;
    let head = reader.headers().map_err(message)?.clone();
    let row =
        |record: csv::StringRecord| head.iter().map(str::to_owned).zip(record.iter().map(str::to_owned)).collect();
    let rows = reader.records().map(|r| r.map(row).map_err(message)).collect::<Result<Vec<Row>>>()?;
    let judged = rows.iter().filter_map(|r| Some((r.get("against")?.as_str(), Made::OnDayOf(&path))));
    of_todays_references(&path, judged)?;
    Ok(rows)
}

/// What a record of JSON is held against, if anything, and by which definitions.
fn made(record: &Value) -> Option<(&str, Made<'_>)> {
    Some((record["against"].as_str().unwrap_or_default(), Made::By(record["definitions"].as_u64()?)))
}

pub fn json(folder: &Path, file: &str) -> Result<Vec<Value>> {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let records: Vec<Value> = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    of_todays_references(&path, records.iter().filter_map(made))?;
    Ok(records)
}

pub fn text(folder: &Path, file: &str) -> Result<String> {
    let path = folder.join(file);
    fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
}

pub fn number(row: &Row, field: &str) -> Result<f64> {
    let value = row.get(field).ok_or_else(|| format!("no field {field}"))?;
    value.parse().map_err(|_| format!("{field} is {value:?}, not a number"))
}

/// A Markdown table.
pub fn table(head: &[&str], rows: Vec<Vec<String>>) -> Result<String> {
    if rows.is_empty() {
        return Err("the table would be empty".to_owned());
    }
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = head.iter().map(|h| (*h).to_owned()).collect();
    let rule = format!("|{}\n", "---|".repeat(head.len()));
    Ok(line(&head) + &rule + &rows.iter().map(|r| line(r)).collect::<String>())
}

/// Median; of an even number, the mean of the middle two.
pub fn median(values: &[f64]) -> Result<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => Err("nothing to take the median of".to_owned()),
        n => Ok((sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0),
    }
}

pub fn mean(values: &[f64]) -> Result<f64> {
    if values.is_empty() {
        Err("nothing to take the mean of".to_owned())
    } else {
        Ok(values.iter().sum::<f64>() / values.len() as f64)
    }
}

pub fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

pub fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Two decimals, or three for what is small.
pub fn ratio(value: f64) -> String {
    if value < 0.02 { format!("{value:.3}") } else { format!("{value:.2}") }
}

/// Median and, in brackets, the greatest.
pub fn median_and_greatest(values: &[f64]) -> Result<String> {
    Ok(format!("{} ({})", ratio(median(values)?), ratio(greatest(values))))
}

/// Median and, in brackets, the least and the greatest.
pub fn median_and_range(values: &[f64]) -> Result<String> {
    Ok(format!("{:.2} ({:.2} to {:.2})", median(values)?, least(values), greatest(values)))
}

/// A share in percent, with so many decimals.
pub fn percent(share: f64, decimals: usize) -> String {
    format!("{:.decimals$} %", 100.0 * share)
}

/// Digits in groups of three.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let parts = digits.as_bytes().rchunks(3).rev().map(|part| String::from_utf8_lossy(part).into_owned());
    parts.collect::<Vec<_>>().join(",")
}

/// A roughness as pages write it: 0.0 is 0.
pub fn shortest(roughness: &str) -> String {
    roughness.trim_end_matches(".0").to_owned()
}

/// A figure of a method against a reference at a roughness, of every view.
pub fn figures(records: &[Value], method: &str, against: &str, roughness: &str, field: &str) -> Vec<f64> {
    let wanted: f64 = roughness.parse().unwrap_or(f64::NAN);
    let method_records = records.iter().filter(|r| r["method"] == method && r["against"] == against);
    method_records
        .filter(|r| r["roughness"].as_f64().is_some_and(|r| (r - wanted).abs() < 1e-6))
        .filter_map(|r| r[field].as_f64())
        .collect()
}

/// The commit that a folder's records are of.
pub fn commit(folder: &Path) -> Result<String> {
    for file in ["error.json", "time.json", "precision.json"] {
        if let Some(commit) = json(folder, file).ok().as_ref().and_then(|r| r.first()?["commit"].as_str()) {
            return Ok(format!("`{commit}`"));
        }
    }
    Err("no record says its commit".to_owned())
}
