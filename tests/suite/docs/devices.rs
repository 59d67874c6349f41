//! On which kind of device a table was measured, and which of its numbers carry over to others.

use super::figures::Result;
use std::path::Path;

/// The kinds of devices by the end of a run folder's name.
const KINDS: [(&str, &str); 4] = [
    ("-lavapipe", "a CPU driver"),
    ("-h100", "an H100"),
    ("-radv", "AMD's compiler, without a GPU"),
    ("-build", "two cores of a shared machine"),
];

/// Words of a header that are of time.
const TIMES: [&str; 2] = ["time", "ms"];

/// What shows times alone, whatever its header says.
const ALL_TIMES: [&str; 11] = [
    "triangle-times",
    "stages-on",
    "times-beyond",
    "frame-rates",
    "capture-sides",
    "history-times",
    "billboard-glow",
    "own-times",
    "bounce-times",
    "times",
    "waits",
];

/// The kind of device that a folder of records is of.
pub fn kind(folder: &Path) -> Result<&'static str> {
    let run = folder.components().skip_while(|c| c.as_os_str() != "runs").nth(1);
    let name = run.map(|c| c.as_os_str().to_string_lossy().into_owned()).unwrap_or_default();
    let found = KINDS.iter().find(|(end, _)| name.ends_with(end)).map(|(_, kind)| *kind);
    found.ok_or_else(|| format!("{}: which device is it of?", folder.display()))
}

/// Whether a header is that of times.
fn is_time(header: &str) -> bool {
    header.to_lowercase().split(|c: char| !c.is_alphanumeric()).any(|word| TIMES.contains(&word))
}

/// The line under a table from records of some folders: the devices, and what carries over.
pub fn line(query: &str, folders: &[impl AsRef<Path>], table: &str) -> Result<String> {
    let mut kinds = Vec::new();
    for folder in folders {
        let kind = kind(folder.as_ref())?;
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let head: Vec<&str> = table.lines().next().unwrap_or_default().split('|').map(str::trim).collect();
    let figures = head.iter().skip(2).filter(|cell| !cell.is_empty());
    let (times, others): (Vec<&str>, Vec<&str>) = figures.copied().partition(|cell| is_time(cell));
    let is_timed = ALL_TIMES.contains(&query.split(' ').next().unwrap_or_default());
    if query == "registers" {
        return Ok(format!("*Read from {}. Nobody measured what these programs take on one.*", kinds.join(", ")));
    }
    let what = match (times.is_empty() && !is_timed, others.is_empty() || is_timed) {
        (false, true) => "Times and their quotients hold for that kind of device alone.",
        (false, false) => "Hits, errors and counts carry over to other devices; times and their quotients do not.",
        (true, _) => "Hits, errors and counts carry over to other devices.",
    };
    Ok(format!("*Measured on {}. {what}*", kinds.join(" and ")))
}
