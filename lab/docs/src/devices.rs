//! Writes the line under a table that says on which kind of device it was measured, and which numbers hold for other
//! devices.

use crate::records::run_name;
use std::path::{Path, PathBuf};

/// The endings of the names of run folders, each with its kind of device.
const KINDS: [(&str, &str); 4] = [
    ("-lavapipe", "a CPU driver"),
    ("-h100", "an H100"),
    ("-radv", "AMD's compiler, without a GPU"),
    ("-build", "two cores of a shared machine"),
];

/// Words in the header of a column that shows times.
const TIMES: [&str; 2] = ["time", "ms"];

/// Returns the kind of device on which a folder's records were measured, in words such as "an H100". The ending of the
/// run folder's name decides, as in `runs/2026-11-24-h100`.
pub(crate) fn device_kind(folder: &Path) -> Result<&'static str, String> {
    let name = run_name(folder).unwrap_or_default();
    let found = KINDS.iter().find(|(end, _)| name.ends_with(end)).map(|(_, kind)| *kind);
    found.ok_or_else(|| format!("{}: which device is it of?", folder.display()))
}

/// Returns whether a header is that of a column of times.
fn is_time(header: &str) -> bool {
    header.to_lowercase().split(|c: char| !c.is_alphanumeric()).any(|word| TIMES.contains(&word))
}

/// Returns the line under a table that was made from the records of some folders: the devices, and the numbers that
/// carry over to others. `table` has the headers as its first line. `has_times` is true if all columns are times,
/// whatever their headers say. A `note` replaces the line; its `$devices` stands for the devices.
pub(crate) fn device_note(
    folders: &[PathBuf],
    table: &str,
    has_times: bool,
    note: Option<&str>,
) -> Result<String, String> {
    let mut kinds = Vec::new();
    for folder in folders {
        let kind = device_kind(folder)?;
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let devices = kinds.join(" and ");
    if let Some(note) = note {
        return Ok(format!("*{}*", note.replace("$devices", &devices)));
    }
    // The first cell is empty, since a line begins with a bar, and the second is the header of the rows' names.
    let header_cells: Vec<&str> = table.lines().next().unwrap_or_default().split('|').map(str::trim).collect();
    let headers = header_cells.iter().skip(2).filter(|cell| !cell.is_empty());
    let (times, others): (Vec<&str>, Vec<&str>) = headers.copied().partition(|header| is_time(header));
    let (shows_times, shows_others) = (has_times || !times.is_empty(), !has_times && !others.is_empty());
    let scope = match (shows_times, shows_others) {
        (true, false) => "Times and their quotients hold for that kind of device alone.",
        (true, true) => "Hits, errors and counts carry over to other devices; times and their quotients do not.",
        (false, _) => "Hits, errors and counts carry over to other devices.",
    };
    Ok(format!("*Measured on {devices}. {scope}*"))
}
