//! Writes records as text, and reads files of times.

use crate::study::compare::{Subject, TimeSample};
use crate::study::names::{csv_cell, json_text};
use crate::study::timing::{FLOORS, MEASURED, PLACE};
use serde::Serialize;
use serde::de::DeserializeOwned;
use ssct::gpu::DeviceInfo;
use ssct::methods::{self, EffectParams, MethodInfo};
use ssct_ground::parameter::{Parameter, Parameters};
use ssct_ground::{Error, Result};
use ssct_scenes::inside::PathInFolder;
use std::str::FromStr;
use std::sync::Arc;

/// Writes a file whole or not at all ([`PathInFolder::write`]). A plain path stands for a file that the user named.
pub fn write(to: impl Into<PathInFolder>, bytes: &[u8]) -> Result<()> {
    to.into().write(bytes)
}

/// Returns records as a JSON array, with one record a line.
pub fn json<T: Serialize>(records: &[T]) -> String {
    let lines: Vec<String> =
        records.iter().map(|r| serde_json::to_string(r).unwrap_or_else(|e| e.to_string())).collect();
    json_text(&format!("[{}]\n", lines.join(",\n ")))
}

/// Returns rows of cells as CSV.
pub fn csv(cells: &[Vec<String>]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in cells {
        // Writing to memory can't fail; if it did, the file would lack rows, and its reader would fail.
        let _ = writer.write_record(row.iter().map(|cell| csv_cell(cell).into_owned()));
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Reads the records of a study from the JSON array that it wrote.
pub fn read_records<R: DeserializeOwned>(file: &PathInFolder) -> Result<Vec<R>> {
    serde_json::from_slice(&file.bytes()?)
        .map_err(|e| Error::malformed(file.path(), None, format!("holds other records: {e}")))
}

/// Reads samples as [`sample_cells`](crate::study::timing::sample_cells) makes them, from CSV. Files of earlier versions have fewer
/// columns.
///
/// # Errors
/// [`Io`](ssct_ground::Error::Io) if the file can't be read. [`Malformed`](ssct_ground::Error::Malformed) if there are no rows, or with
/// the line of a row that lacks a column or has a time that is no finite number ≥ 0.
pub fn read_samples(file: &PathInFolder) -> Result<Vec<TimeSample>> {
    let (path, text) = (&file.path(), file.bytes()?);
    let mut rows = Vec::new();
    let mut reader = csv::Reader::from_reader(&text[..]);
    let headers = reader.headers().map_err(|e| Error::malformed(path, Some(1), e.to_string()))?.clone();
    let parameters = methods::parameters();
    for record in reader.records() {
        let line = |position: Option<&csv::Position>| position.and_then(|p| usize::try_from(p.line()).ok());
        let record = record.map_err(|e| Error::malformed(path, line(e.position()), e.to_string()))?;
        let wrong = |message: String| Error::malformed(path, line(record.position()), message);
        let subject = row_subject(&headers, &record, &parameters);
        // A run has few subjects, and rows of one subject follow each other. Such rows share one value, to save memory.
        let last_subject = rows.last().map(|row: &TimeSample| &row.subject).filter(|last| ***last == subject);
        let row = TimeSample {
            subject: last_subject.cloned().unwrap_or_else(|| Arc::new(subject)),
            sample: parse_cell(&headers, &record, "sample").map_err(wrong)?,
            pass: parse_cell(&headers, &record, "pass").map_err(wrong)?,
            counted: parse_cell(&headers, &record, "counted").map_err(wrong)?,
            ms: parse_cell(&headers, &record, "ms").map_err(wrong)?,
            floors: FLOORS.map(|column| parse_cell(&headers, &record, column).ok()),
        };
        if !(row.ms.is_finite() && row.ms >= 0.0) {
            return Err(wrong(format!("{} ms is no time", row.ms)));
        }
        if let Some(name) = PLACE.iter().find(|name| row.subject.get(name).is_empty()) {
            return Err(wrong(format!("no sample of a time: no {name}")));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(Error::malformed(path, None, "holds no samples"));
    }
    Ok(rows)
}

/// Parses the cell of a row in the column with the name `column`. The error says what is wrong with the cell.
fn parse_cell<T: FromStr>(
    headers: &csv::StringRecord,
    record: &csv::StringRecord,
    column: &str,
) -> std::result::Result<T, String> {
    let index = headers.iter().position(|h| h == column);
    let text =
        index.and_then(|index| record.get(index)).ok_or_else(|| format!("no sample of a time: no column {column}"))?;
    text.parse().map_err(|_| format!("no sample of a time: {text:?} in the column {column}"))
}

/// Returns the subject of a row: all its columns that are not measured. Parameters that the row's method does not have
/// are left out, since older files have a value for them, too.
fn row_subject(
    headers: &csv::StringRecord,
    record: &csv::StringRecord,
    parameters: &[(Parameter, Vec<&MethodInfo>)],
) -> Subject {
    let method = headers.iter().zip(record).find(|(name, _)| *name == "method").map_or("", |(_, method)| method);
    let effect_parameters: Vec<_> = EffectParams::table().iter().map(|p| p.name).collect();
    // False only for a parameter that other methods have, and this method and the effect lack.
    let concerns_method = |name: &str| {
        let mut entries = parameters.iter().filter(|(p, _)| p.name == name).peekable();
        let is_parameter = entries.peek().is_some();
        effect_parameters.contains(&name)
            || !is_parameter
            || entries.any(|(_, methods)| methods.iter().any(|m| m.name == method))
    };
    let is_known = methods::find(method).is_ok();
    let columns =
        headers.iter().zip(record).filter(|(name, _)| !MEASURED.contains(name) && (!is_known || concerns_method(name)));
    // A number gets one text, since an older file has 1 where a newer one has 1.0.
    let normalized = |text: &str| text.parse::<f64>().map_or_else(|_| text.to_owned(), |n| n.to_string());
    Subject(columns.map(|(name, text)| (name.to_owned(), normalized(text))).collect())
}

/// Reads the device of a time.json from its first record; `None` if there is no such file.
pub fn read_device(file: &PathInFolder) -> Result<Option<DeviceInfo>> {
    let Some(text) = file.read()? else { return Ok(None) };
    let path = &file.path();
    let wrong = |e: serde_json::Error| Error::malformed(path, None, format!("holds no record with a device: {e}"));
    let mut records: serde_json::Value = serde_json::from_slice(&text).map_err(wrong)?;
    let device = records.pointer_mut("/0/device").map(serde_json::Value::take).unwrap_or_default();
    serde_json::from_value(device).map(Some).map_err(wrong)
}
