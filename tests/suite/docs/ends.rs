//! The table of where rays of `unified` with captures end wrongly (`cargo bench --bench ends`).

use super::figures::{Result, Row, csv, median, number, percent, table};
use std::collections::BTreeMap;
use std::path::Path;

/// Which rows of the record count.
type Counts = fn(&Kind) -> bool;

/// The columns, each with the rows that it adds up.
const COLUMNS: [(&str, Counts); 7] = [
    ("wrong", |k| k.end != "right"),
    ("ends beside its start", |k| k.end != "right" && k.truth == "beside"),
    ("hit too soon or too late by less than a tenth", |k| k.end == "near" && k.truth != "beside"),
    ("another hit, on the screen", |k| k.is_elsewhere() && k.method == "screen"),
    ("another hit or sky, beyond", |k| k.is_elsewhere() && !k.is_lost() && k.method != "screen"),
    ("lost, an image shows the end", |k| k.is_elsewhere() && k.is_lost() && k.truth != "hidden"),
    ("lost, none shows it", |k| k.is_elsewhere() && k.is_lost() && k.truth == "hidden"),
];

/// What a row is of.
struct Kind<'a> {
    method: &'a str,
    end: &'a str,
    truth: &'a str,
}

impl Kind<'_> {
    fn is_elsewhere(&self) -> bool {
        !["right", "near"].contains(&self.end) && self.truth != "beside"
    }

    fn is_lost(&self) -> bool {
        ["unknown", "none"].contains(&self.method)
    }
}

/// Shares of the reflecting pixels by how their rays end, medians over the views of a scene, and the part of the summed
/// squared error that the pixels have whose rays end right.
pub fn ends(folder: &Path) -> Result<String> {
    let rows = csv(folder, "ends.csv")?;
    let mut scenes: Vec<&str> = Vec::new();
    let mut views: BTreeMap<(&str, &str), Vec<&Row>> = BTreeMap::new();
    for row in &rows {
        let of = |field: &str| row.get(field).map(String::as_str).ok_or_else(|| format!("no field {field}"));
        let scene = of("scene")?;
        if !scenes.contains(&scene) {
            scenes.push(scene);
        }
        views.entry((scene, of("view")?)).or_default().push(row);
    }
    let sum = |rows: &[&Row], field: &str, counts: Counts| {
        let of = |row: &Row| {
            let [method, end, truth] = ["method", "end", "truth"].map(|f| row.get(f).map_or("", String::as_str));
            if counts(&Kind { method, end, truth }) { number(row, field) } else { Ok(0.0) }
        };
        rows.iter().map(|row| of(row)).sum::<Result<f64>>()
    };
    let row = |scene: &&str| {
        let of_scene: Vec<&Vec<&Row>> = views.iter().filter(|((s, _), _)| s == scene).map(|(_, rows)| rows).collect();
        let middle = |field: &str, counts: Counts| {
            let values = of_scene.iter().map(|rows| sum(rows, field, counts)).collect::<Result<Vec<_>>>()?;
            Ok::<_, String>(percent(median(&values)?, 1))
        };
        let shares = COLUMNS.iter().map(|(_, counts)| middle("share", *counts));
        let right: Counts = |k| k.end == "right";
        let cells = std::iter::once(Ok((*scene).to_owned())).chain(shares);
        cells.chain(std::iter::once(middle("of_error", right))).collect::<Result<Vec<_>>>()
    };
    let head: Vec<&str> = std::iter::once("scene")
        .chain(COLUMNS.iter().map(|(name, _)| *name))
        .chain(std::iter::once("squared error of right rays"))
        .collect();
    table(&head, scenes.iter().map(row).collect::<Result<_>>()?)
}
