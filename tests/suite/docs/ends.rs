//! The table of where rays of `unified` with captures end wrongly (`cargo bench --bench ends`).

use super::figures::{Result, Row, csv, median, number, percent, table};
use std::path::Path;

/// Whether a row of the record counts, by its `method`, `end` and `truth`.
type Counts = fn([&str; 3]) -> bool;

const RIGHT: Counts = |[_, end, _]| end == "right";

/// The columns of pixels, each with the rows that it adds up. After the first, each wrong ray is in one.
const COLUMNS: [(&str, Counts); 8] = [
    ("wrong", |kind| !RIGHT(kind)),
    ("ends beside its start", |kind| !RIGHT(kind) && kind[2] == "beside"),
    ("off by less than a tenth", |[_, end, truth]| end == "near" && truth != "beside"),
    ("another hit, on the screen", |kind| is_elsewhere(kind) && kind[0] == "screen"),
    ("another hit, or sky, beyond the screen", |kind| is_elsewhere(kind) && !is_lost(kind) && kind[0] != "screen"),
    ("lost, ends in the sky", |kind| is_elsewhere(kind) && is_lost(kind) && kind[2] == "sky"),
    ("lost, an image shows the end", |kind| {
        is_elsewhere(kind) && is_lost(kind) && !["sky", "hidden"].contains(&kind[2])
    }),
    ("lost, none shows it", |kind| is_elsewhere(kind) && is_lost(kind) && kind[2] == "hidden"),
];

fn is_elsewhere([_, end, truth]: [&str; 3]) -> bool {
    !["right", "near"].contains(&end) && truth != "beside"
}

fn is_lost([method, ..]: [&str; 3]) -> bool {
    ["unknown", "none"].contains(&method)
}

/// Shares of the reflecting pixels by how their rays end, medians over the views of a scene, and the part of the summed
/// squared error that the pixels have whose rays end right.
pub fn ends(folder: &Path) -> Result<String> {
    let rows = csv(folder, "ends.csv")?;
    let sum = |view: &[Row], field: &str, counts: Counts| {
        let is_counted = |row: &&Row| counts(["method", "end", "truth"].map(|field| row[field].as_str()));
        view.iter().filter(is_counted).try_fold(0.0, |sum, row| Ok::<_, String>(sum + number(row, field)?))
    };
    // The rows of a view are together, and the views of a scene.
    let mut scenes: Vec<(&str, Vec<&[Row]>)> = Vec::new();
    for view in rows.chunk_by(|a, b| (&a["scene"], &a["view"]) == (&b["scene"], &b["view"])) {
        let scene = view[0]["scene"].as_str();
        match scenes.last_mut().filter(|(last, _)| *last == scene) {
            Some((_, views)) => views.push(view),
            None => scenes.push((scene, vec![view])),
        }
    }
    let row = |(scene, views): &(&str, Vec<&[Row]>)| {
        let middle = |field: &str, counts: Counts| {
            let values = views.iter().map(|view| sum(view, field, counts)).collect::<Result<Vec<_>>>()?;
            Ok::<_, String>(percent(median(&values)?, 1))
        };
        let mut cells = vec![(*scene).to_owned()];
        for (_, counts) in COLUMNS {
            cells.push(middle("share", counts)?);
        }
        cells.push(middle("of_error", RIGHT)?);
        Ok(cells)
    };
    let names = COLUMNS.map(|(name, _)| name);
    let head = [&["scene"][..], &names, &["squared error of right rays"]].concat();
    table(&head, scenes.iter().map(row).collect::<Result<_>>()?)
}
