//! Tables of other renderers: the colour of a hit through the door, and Bevy's own reflections beside ours.

use super::figures::{Result, csv, greatest, json, least, median, number, percent, ratio, table};
use serde_json::Value;
use std::path::Path;

/// What a texture costs rays over a colour, by scene: median over its views, and in brackets the greatest; what making the
/// triangles takes, and their bytes.
pub fn hit_colors(folder: &Path) -> Result<String> {
    let all = csv(folder, "hit-colors.csv")?;
    let row = |scene: &&str| -> Result<Vec<String>> {
        let column = |field: &str| {
            let here = all.iter().filter(|row| row["scene"] == *scene);
            here.map(|row| number(row, field)).collect::<Result<Vec<f64>>>()
        };
        let [ratios, color, texture] = [column("ratio")?, column("color_ms")?, column("texture_ms")?];
        let one = |field: &str| column(field)?.first().copied().ok_or_else(|| format!("{scene}: no {field}"));
        Ok(vec![
            scene.to_string(),
            format!("{:.1} to {:.1}", least(&color), greatest(&color)),
            format!("{:.1} to {:.1}", least(&texture), greatest(&texture)),
            format!("{} ({})", ratio(median(&ratios)?), ratio(greatest(&ratios))),
            format!("{:.0}, {:.0}", one("color_made_ms")?, one("texture_made_ms")?),
            format!("{:.1}, {:.1}", one("color_bytes")? / 1e6, one("texture_bytes")? / 1e6),
        ])
    };
    let head = ["scene", "colours, ms", "textures, ms", "textures / colours", "ms to make them", "MB"];
    table(&head, ["rooms", "street", "atrium"].iter().map(row).collect::<Result<_>>()?)
}

/// Who reflects, as the records call it, and how the page does.
const WITH: [(&str, &str); 6] = [
    ("ssct", "`unified`, with the world's meshes"),
    ("guess", "`unified`, with the meshes' own colours alone"),
    ("traced", "`traced`"),
    ("screen", "`unified`, of the screen alone"),
    ("bevy", "Bevy's, mirrors on"),
    ("bevy-steps", "Bevy's, 100 steps"),
];

fn run<'a>(records: &'a [Value], picture: &str) -> Result<&'a Value> {
    records.iter().find(|r| r["picture"] == picture).ok_or_else(|| format!("nothing of {picture}"))
}

fn figure(record: &Value, name: &str) -> Result<f64> {
    record[name].as_f64().ok_or_else(|| format!("no {name}"))
}

/// Errors, right hits and times of the mirror in Bevy, where surfaces are lit or not.
pub fn bevy(folder: &Path, is_lit: bool) -> Result<String> {
    let records = json(folder, "figures.json")?;
    let record_with = |with: &str| run(&records, &format!("{}{with}", if is_lit { "lit-" } else { "" }));
    let row = |(with, name): &(&str, &str)| -> Result<Vec<String>> {
        let record = record_with(with)?;
        Ok(vec![
            name.to_string(),
            format!("{:.3}", figure(record, "rmse")?),
            percent(figure(record, "right")?, 1),
            format!("{:.1}", figure(record, "least_ms")?),
        ])
    };
    let measured = WITH.iter().filter(|(with, _)| record_with(with).is_ok());
    table(&["reflections", "error", "right", "ms"], measured.map(row).collect::<Result<_>>()?)
}

/// A figure of one of them.
pub fn bevy_figure(folder: &Path, with: &str, name: &str) -> Result<String> {
    let records = json(folder, "figures.json")?;
    let value = figure(run(&records, with)?, name)?;
    Ok(match name {
        "right" => percent(value, 1),
        "rmse" => format!("{value:.3}"),
        _ => format!("{value:.1}"),
    })
}
