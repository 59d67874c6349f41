//! How long whoever works on the program waits, by two builds of it on one machine.

use super::figures::{Result, csv, number, ratio, table};
use std::path::Path;

/// A wait in seconds, or in minutes and seconds.
fn wait(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    if whole < 60 { format!("{whole} s") } else { format!("{}:{:02} min", whole / 60, whole % 60) }
}

/// Each wait by the earlier and by the later build of `waits.csv`, their quotient, and the quotient that was aimed at.
pub fn waits(folder: &Path) -> Result<String> {
    let rows = csv(folder, "waits.csv")?;
    let mut builds: Vec<&str> = rows.iter().map(|row| row["build"].as_str()).collect();
    builds.dedup();
    let [earlier, later] = builds[..] else { return Err(format!("two builds, not {builds:?}")) };
    let of_build = |build: &str| rows.iter().filter(|row| row["build"] == build).collect::<Vec<_>>();
    let mut cells = Vec::new();
    for row in of_build(earlier) {
        let what = &row["what"];
        let same = of_build(later).into_iter().find(|other| other["what"] == *what);
        let other = same.ok_or_else(|| format!("{later} has no {what}"))?;
        let [before, after] = [number(row, "value")?, number(other, "value")?];
        let shown = |value: f64| if row["unit"] == "s" { wait(value) } else { format!("{value:.0} {}", row["unit"]) };
        let aim = if row["aim"].is_empty() { "–".to_owned() } else { row["aim"].clone() };
        cells.push(vec![what.clone(), shown(before), shown(after), ratio(after / before), aim]);
    }
    table(&["", earlier, later, "quotient", "aim"], cells)
}
