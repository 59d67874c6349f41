//! Tables of the league (docs/findings/league.md), from the records of `scripts/league.sh`.

use super::figures::{Result, json, table};
use serde_json::Value;
use std::path::Path;

/// The contestants in the order of the records.
fn contestants(records: &[Value]) -> Vec<&str> {
    let mut names: Vec<&str> = records.iter().filter_map(|r| r["contestant"].as_str()).collect();
    names.dedup();
    names
}

fn record<'a>(records: &'a [Value], contestant: &str, scene: &str, setting: &str) -> Result<&'a Value> {
    let is_it = |r: &&Value| r["contestant"] == contestant && r["scene"] == scene && r["setting"] == setting;
    records.iter().find(is_it).ok_or_else(|| format!("nothing of {contestant}, {scene}, {setting}"))
}

fn shown(record: &Value, figure: &str) -> String {
    match record[figure].as_f64() {
        None => "–".to_owned(),
        Some(value) if figure.starts_with("rmse") => format!("{value:.3}"),
        Some(value) => format!("{value:.2}"),
    }
}

/// Every contestant on a scene: its defaults, and the best of its settings.
pub fn scene(folder: &Path, scene: &str) -> Result<String> {
    let records = json(folder, "league.json")?;
    let figures = ["right", "known", "rmse", "rmse of all", "hue", "hidden right", "hidden black"];
    let mut rows = Vec::new();
    for contestant in contestants(&records) {
        for setting in ["defaults", "best"] {
            let Ok(record) = record(&records, contestant, scene, setting) else { continue };
            if setting == "best" && record["settings"] == Value::Object(serde_json::Map::new()) {
                continue;
            }
            let cells = figures.map(|figure| shown(record, figure));
            rows.push([format!("{contestant}, {setting}")].into_iter().chain(cells).collect());
        }
    }
    table(
        &["", "right %", "known %", "RMSE of known", "RMSE of all", "hue %", "hidden right %", "hidden black %"],
        rows,
    )
}

/// Known pixels and their error on every scene, with the defaults or the best setting.
pub fn scenes(folder: &Path, setting: &str) -> Result<String> {
    let records = json(folder, "league.json")?;
    let mut scenes: Vec<(&str, &str)> = Vec::new();
    for r in records.iter().filter(|r| r["scene"].is_string()) {
        let pair = (r["scene"].as_str().unwrap_or(""), r["title"].as_str().unwrap_or(""));
        if !scenes.contains(&pair) {
            scenes.push(pair);
        }
    }
    let header: Vec<&str> = [""].into_iter().chain(scenes.iter().map(|(_, title)| *title)).collect();
    let row = |contestant: &&str| -> Vec<String> {
        let cell = |(scene, _): &(&str, &str)| {
            let record = record(&records, contestant, scene, setting);
            record.map_or("–".to_owned(), |r| format!("{}; {}", shown(r, "known"), shown(r, "rmse")))
        };
        [(*contestant).to_owned()].into_iter().chain(scenes.iter().map(cell)).collect()
    };
    table(&header, contestants(&records).iter().map(row).collect())
}

/// A figure of a contestant, whose name, or its beginning, has hyphens for blanks.
pub fn figure(folder: &Path, [contestant, setting, scene, figure]: [&str; 4]) -> Result<String> {
    let records = json(folder, "league.json")?;
    let joined = |name: &str| name.replace(", ", "-").replace(' ', "-");
    let names = contestants(&records);
    let whole = names.iter().find(|name| joined(name) == contestant);
    let begun = || names.iter().find(|name| joined(name).starts_with(contestant));
    let name = whole.or_else(begun).ok_or_else(|| format!("no contestant {contestant}"))?;
    let record = record(&records, name, scene, setting)?;
    let value = shown(record, figure);
    Ok(if figure.starts_with("rmse") { value } else { format!("{value} %") })
}
