//! Files written whole or not at all: a temporary name beside the target, then a rename.

use crate::error::{Error, Result};
use crate::gpu::DeviceInfo;
use crate::study::TimeRecord;
use crate::study::compare::TimeSample;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Writes a file through a temporary one in the same folder, which is made if it is missing.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// As [`write()`], with the content streamed by `fill`.
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

/// Records as a JSON array, one record a line.
pub fn json<T: Serialize>(records: &[T]) -> String {
    let lines: Vec<String> =
        records.iter().map(|r| serde_json::to_string(r).unwrap_or_else(|e| e.to_string())).collect();
    format!("[{}]\n", lines.join(",\n "))
}

/// Raw samples of time records as CSV: one row a sample and pass.
pub fn samples_csv(records: &[TimeRecord]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let subject = ["scene", "view", "method", "preset", "width", "height", "roughness"];
    let settings = ["normal_deviation", "resolution_scale", "split", "fallback", "oracle"];
    let header = [&subject[..], &settings, &["sample", "pass", "counted", "ms"]].concat();
    // Writing to memory can't fail; were it to, the file would be short, and its reader would see.
    let _ = writer.write_record(header);
    let text = |value: serde_json::Result<serde_json::Value>| {
        value.ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
    };
    let number = |value: Option<f32>| value.map(|v| v.to_string()).unwrap_or_default();
    for r in records {
        for (n, sample) in r.samples.iter().enumerate() {
            for (pass, ms) in r.passes.iter().zip(sample) {
                let _ = writer.write_record([
                    r.head.scene.clone(),
                    r.head.view.clone(),
                    r.head.method.clone(),
                    text(serde_json::to_value(r.head.preset)),
                    r.head.width.to_string(),
                    r.head.height.to_string(),
                    number(r.head.roughness),
                    number(r.head.normal_deviation),
                    r.head.resolution_scale.to_string(),
                    r.split.to_string(),
                    text(serde_json::to_value(r.fallback)),
                    u32::from(r.head.oracle).to_string(),
                    n.to_string(),
                    pass.name.clone(),
                    pass.counted.to_string(),
                    format!("{ms:.6}"),
                ]);
            }
        }
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Reads what [`samples_csv`] makes.
///
/// # Errors
/// [`Error::Io`] if it can't be read, [`Error::Malformed`] with the line of a row that lacks a column
/// or has a time that is no finite number ≥ 0, or if there are no rows.
pub fn read_samples(path: &Path) -> Result<Vec<TimeSample>> {
    let text = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let mut rows = Vec::new();
    let mut reader = csv::Reader::from_reader(&text[..]);
    let headers = reader.headers().map_err(|e| Error::malformed(path, Some(1), e.to_string()))?.clone();
    for record in reader.records() {
        let line = |p: Option<&csv::Position>| p.and_then(|p| usize::try_from(p.line()).ok());
        let record = record.map_err(|e| Error::malformed(path, line(e.position()), e.to_string()))?;
        let wrong = |message: String| Error::malformed(path, line(record.position()), message);
        let row: TimeSample =
            record.deserialize(Some(&headers)).map_err(|e| wrong(format!("no sample of a time: {e}")))?;
        if !(row.ms.is_finite() && row.ms >= 0.0) {
            return Err(wrong(format!("{} ms is no time", row.ms)));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(Error::malformed(path, None, "holds no samples"));
    }
    Ok(rows)
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
