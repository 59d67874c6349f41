//! Files written whole or not at all: a temporary name beside the target, then a rename.

use crate::error::{Error, Result};
use crate::gpu::DeviceInfo;
use crate::methods::{self, EffectParams, MethodInfo};
use crate::parameter::{Parameter, Parameters};
use crate::study::TimeRecord;
use crate::study::compare::{Subject, TimeSample};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// Writes a file through a temporary one in the same folder, which is made if it is missing.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// Writes a file whole or not at all, as [`write()`] does; `fill` streams the content.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut std::fs::File) -> std::io::Result<()>) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| Error::io("create the folder", folder, e))?;
    let failed = |e| Error::io("write", path, e);
    let mut file = tempfile::Builder::new().prefix(".ssct-").tempfile_in(folder).map_err(failed)?;
    fill(file.as_file_mut()).map_err(failed)?;
    // A temporary file is private; a result is as readable as any other file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).map_err(failed)?;
    }
    file.persist(path).map_err(|e| failed(e.error))?;
    Ok(())
}

/// A name as a part of a file's name, whatever a user or a file calls a scene, a view or a variant: without separators of
/// folders and other characters that file systems, shells' patterns or addresses of pages give a meaning, and short. A
/// name that had to be changed ends in a digest of what it was, so that different names stay different.
pub fn safe_word(name: &str) -> Cow<'_, str> {
    const MOST_BYTES: usize = 64;
    let is_safe = |c: char| !c.is_control() && !r#"/\:*?"<>|%#"#.contains(c);
    if !name.is_empty() && name.len() <= MOST_BYTES && !name.starts_with('.') && name.chars().all(is_safe) {
        return name.into();
    }
    let mut word = String::new();
    for c in name.chars() {
        if word.len() + c.len_utf8() > MOST_BYTES {
            break;
        }
        word.push(if is_safe(c) && !(c == '.' && word.is_empty()) { c } else { '_' });
    }
    let digest = Sha256::digest(name.as_bytes());
    word.push('-');
    word.extend(digest.iter().take(4).map(|byte| format!("{byte:02x}")));
    word.into()
}

/// Records as a JSON array, one record a line.
pub fn json<T: Serialize>(records: &[T]) -> String {
    let lines: Vec<String> =
        records.iter().map(|r| serde_json::to_string(r).unwrap_or_else(|e| e.to_string())).collect();
    format!("[{}]\n", lines.join(",\n "))
}

/// The columns of a sample that say what it is of, before everything that was set.
const PLACE: [&str; 3] = ["scene", "view", "method"];
/// The columns of a sample that say what was measured, after everything that was set.
const MEASURED: [&str; 6] = ["sample", "pass", "counted", "ms", FLOORS[0], FLOORS[1]];
/// The columns of noise floors, of the pass and of the total; empty where they were not measured.
const FLOORS: [&str; 2] = ["noise_floor", "total_noise_floor"];

/// Raw samples of time records as CSV: one row a sample and pass, one column for everything that was set of any of the
/// methods; what a method does not have is empty.
pub fn samples_csv(records: &[TimeRecord]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let settings: BTreeSet<&String> = records.iter().flat_map(|r| r.head.setup.keys()).collect();
    // Writing to memory can't fail; were it to, the file would be short, and its reader would see.
    let columns = settings.iter().map(|name| name.as_str());
    let _ = writer.write_record(PLACE.into_iter().chain(columns).chain(MEASURED));
    for r in records {
        let place = [&r.head.scene, &r.head.view, &r.head.method].map(Clone::clone);
        let set: Vec<String> = settings.iter().map(|name| r.head.setting(name)).collect();
        for (n, sample) in r.samples.iter().enumerate() {
            for (pass, ms) in r.passes.iter().zip(sample) {
                let floor = |floor: Option<f64>| floor.map(|f| format!("{f:.6}")).unwrap_or_default();
                let measured = [
                    n.to_string(),
                    pass.name.clone(),
                    pass.counted.to_string(),
                    format!("{ms:.6}"),
                    floor(pass.noise_floor),
                    floor(r.noise_floor),
                ];
                let _ = writer.write_record(place.iter().chain(&set).chain(&measured));
            }
        }
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Reads what [`samples_csv`] makes, now or at an earlier version, whose files have fewer columns.
///
/// # Errors
/// [`Error::Io`] if it can't be read, [`Error::Malformed`] with the line of a row that lacks a column
/// or has a time that is no finite number ≥ 0, or if there are no rows.
pub fn read_samples(path: &Path) -> Result<Vec<TimeSample>> {
    let text = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let mut rows = Vec::new();
    let mut reader = csv::Reader::from_reader(&text[..]);
    let headers = reader.headers().map_err(|e| Error::malformed(path, Some(1), e.to_string()))?.clone();
    let parameters = methods::parameters();
    for record in reader.records() {
        let line = |p: Option<&csv::Position>| p.and_then(|p| usize::try_from(p.line()).ok());
        let record = record.map_err(|e| Error::malformed(path, line(e.position()), e.to_string()))?;
        let wrong = |message: String| Error::malformed(path, line(record.position()), message);
        let of = subject(&headers, &record, &parameters);
        // The rows of a run are of few subjects, which follow each other.
        let known = rows.last().map(|row: &TimeSample| &row.subject).filter(|known| ***known == of);
        let row = TimeSample {
            subject: known.cloned().unwrap_or_else(|| Arc::new(of)),
            sample: parsed(&headers, &record, "sample").map_err(wrong)?,
            pass: parsed(&headers, &record, "pass").map_err(wrong)?,
            counted: parsed(&headers, &record, "counted").map_err(wrong)?,
            ms: parsed(&headers, &record, "ms").map_err(wrong)?,
            floors: FLOORS.map(|column| parsed(&headers, &record, column).ok()),
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

/// A cell of a row, or what is wrong with it.
fn parsed<T: FromStr>(
    headers: &csv::StringRecord,
    record: &csv::StringRecord,
    column: &str,
) -> std::result::Result<T, String> {
    let at = headers.iter().position(|h| h == column);
    let text = at.and_then(|at| record.get(at)).ok_or_else(|| format!("no sample of a time: no column {column}"))?;
    text.parse().map_err(|_| format!("no sample of a time: {text:?} in the column {column}"))
}

/// What a row is of. Parameters that the method does not have are left out: an older file has a value in every column.
fn subject(
    headers: &csv::StringRecord,
    record: &csv::StringRecord,
    parameters: &[(Parameter, Vec<&MethodInfo>)],
) -> Subject {
    let method = headers.iter().zip(record).find(|(name, _)| *name == "method").map_or("", |(_, method)| method);
    let around: Vec<_> = EffectParams::table().iter().map(|p| p.name).collect();
    let has = |name: &str| {
        let mut of = parameters.iter().filter(|(p, _)| p.name == name).peekable();
        let is_parameter = of.peek().is_some();
        around.contains(&name) || !is_parameter || of.any(|(_, methods)| methods.iter().any(|m| m.name == method))
    };
    let known = methods::find(method).is_ok();
    let columns = headers.iter().zip(record).filter(|(name, _)| !MEASURED.contains(name) && (!known || has(name)));
    // Numbers as they are written today: an older file has 1 where a newer has 1.0.
    let plain = |text: &str| text.parse::<f64>().map_or_else(|_| text.to_owned(), |n| n.to_string());
    Subject(columns.map(|(name, text)| (name.to_owned(), plain(text))).collect())
}

/// The device of a time.json, from its first record; `None` if there is no such file.
///
/// # Errors
/// [`Error::Io`] if it is there and can't be read, [`Error::Malformed`] if it holds no record with a device.
pub fn read_device(path: &Path) -> Result<Option<DeviceInfo>> {
    let text = match std::fs::read(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io("read", path, e)),
    };
    let wrong = |e: serde_json::Error| Error::malformed(path, None, format!("holds no record with a device: {e}"));
    let mut records: serde_json::Value = serde_json::from_slice(&text).map_err(wrong)?;
    let device = records.pointer_mut("/0/device").map(serde_json::Value::take).unwrap_or_default();
    serde_json::from_value(device).map(Some).map_err(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_words_of_file_names_and_stay_different() {
        for plain in ["exit sign", "Küche (Süd)", "front 2", "r0.4", "a-b_c"] {
            assert_eq!(safe_word(plain), plain);
        }
        let long = "x".repeat(400);
        let wide = "\u{30ab}".repeat(100);
        let odd = [
            "", ".", "..", "a/b", "a\\b", "a_b/", "../../x", "a\0b", "a\nb", "a:b", "50 %", "#1", ".hidden", &long,
            &wide,
        ];
        let words: BTreeSet<String> = odd.iter().map(|name| safe_word(name).into_owned()).collect();
        assert_eq!(words.len(), odd.len(), "{words:?}");
        for word in &words {
            let path = Path::new(word);
            assert!(path.components().count() == 1 && path.file_name().is_some_and(|f| f == word.as_str()), "{word:?}");
            assert!(word.len() < 80 && !word.starts_with('.') && !word.contains(char::is_control), "{word:?}");
        }
    }
}
