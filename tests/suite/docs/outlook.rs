//! The tables of what the theses only propose: further bounces, a mask in the blur of the colour chain, and a glow around
//! billboards.

use super::figures::{Result, figures, json, mean, median, ratio, shortest, table};
use serde_json::Value;
use std::path::Path;

/// The records of one number of bounces.
fn with_bounces(records: &[Value], bounces: u64) -> Vec<Value> {
    records.iter().filter(|r| r["setup"]["bounces"] == bounces).cloned().collect()
}

/// One, two and three bounces against light of three: medians over the views of each scene, and the medians of the times of a
/// view over those of one bounce.
pub fn bounces(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for scene in ["rooms", "museum"] {
        let records = json(&folder.join(scene), "error.json")?;
        let by_bounces: Vec<_> = (1..=3).map(|n| with_bounces(&records, n)).collect();
        for roughness in ["0.0", "0.3"] {
            for method in ["ssct", "unified"] {
                let mut row = vec![format!("`{scene}`"), shortest(roughness), format!("`{method}`")];
                for against in ["screen", "world"] {
                    for records in &by_bounces {
                        let rmse = median(&figures(records, method, against, roughness, "rmse"))?;
                        row.push(format!("{rmse:.4}"));
                    }
                }
                let times: Vec<_> =
                    by_bounces.iter().map(|records| figures(records, method, "world", roughness, "time_ms")).collect();
                for more in &times[1..] {
                    let over: Vec<f64> = more.iter().zip(&times[0]).map(|(more, one)| more / one).collect();
                    row.push(ratio(median(&over)?));
                }
                rows.push(row);
            }
        }
    }
    let head = ["scene", "ϱ", "method", "screen, 1", "screen, 2", "screen, 3", "world, 1", "world, 2", "world, 3"];
    table(&[head.as_slice(), &["time, 2", "time, 3"]].concat(), rows)
}

/// Number and time of the passes of the second bounce, beside those of the first.
pub fn bounce_times(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for file in ["combined.json", "split.json"] {
        for record in json(folder, file)? {
            let passes = record["passes"].as_array().ok_or("no passes")?;
            let counted: Vec<&Value> = passes.iter().filter(|p| p["counted"] == true).collect();
            let totals = |again: bool| {
                let is_of = |p: &&&Value| p["name"].as_str().is_some_and(|n| n.starts_with("bounce 2/")) == again;
                let all: Vec<f64> = counted.iter().filter(is_of).filter_map(|p| p["median_ms"].as_f64()).collect();
                (all.len(), all.iter().sum::<f64>())
            };
            let ((passes, ms), (passes_again, ms_again)) = (totals(false), totals(true));
            let split = if record["setup"]["split"] == true { ", split" } else { "" };
            let method = record["method"].as_str().ok_or("no method")?;
            rows.push(vec![
                format!("`{method}`{split}"),
                passes.to_string(),
                passes_again.to_string(),
                ratio(ms_again / ms),
            ]);
        }
    }
    table(&["method", "passes, first bounce", "passes, second", "time of the second / of the first"], rows)
}

/// Filters of the colour chain: errors of `ssct` against the screen and the world by roughness, and its time over that of
/// `dda`, which has no chain; means over all views of three scenes.
pub fn chain_masks(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (variant, filter, mask) in [
        ("hardware-none", "hardware", "–"),
        ("gaussian-none", "Gaussian", "–"),
        ("gaussian-covered", "Gaussian", "`covered`"),
        ("gaussian-surface", "Gaussian", "`surface`"),
    ] {
        let records = json(&folder.join(variant), "error.json")?;
        let all = |method: &str, against: &str, roughness: &str, field: &str| -> Vec<f64> {
            figures(&records, method, against, roughness, field)
        };
        let mut row = vec![filter.to_owned(), mask.to_owned()];
        let times = all("ssct", "world", "0.1", "time_ms");
        let beside = all("dda", "world", "0.1", "time_ms");
        row.push(ratio(median(&times.iter().zip(&beside).map(|(a, b)| a / b).collect::<Vec<_>>())?));
        for against in ["screen", "world"] {
            for roughness in ["0.1", "0.3", "0.6"] {
                row.push(format!("{:.4}", mean(&all("ssct", against, roughness, "rmse"))?));
            }
        }
        rows.push(row);
    }
    let head = ["filter", "mask", "time / `dda`'s", "screen, ϱ 0.1", "screen, ϱ 0.3", "screen, ϱ 0.6"];
    table(&[head.as_slice(), &["world, ϱ 0.1", "world, ϱ 0.3", "world, ϱ 0.6"]].concat(), rows)
}

/// The time of `billboard` over that of `linear`, by what hides billboards and by how far they glow.
pub fn billboard_glow(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for occlusion in ["none", "depth"] {
        for (glow, says) in [("0", "none"), ("0.5", "0.5 m"), ("0.5-2m", "2 m")] {
            let records = json(folder, &format!("{occlusion}-{glow}.json"))?;
            let time = |method: &str| {
                let record = records.iter().find(|r| r["method"] == method);
                record.and_then(|r| r["total"]["median_ms"].as_f64()).ok_or_else(|| format!("no time of {method}"))
            };
            rows.push(vec![format!("`{occlusion}`"), says.to_owned(), ratio(time("billboard")? / time("linear")?)]);
        }
    }
    table(&["occlusion", "glow", "time / `linear`'s"], rows)
}
