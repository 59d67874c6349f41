//! Tables of what the numbers and formulas of the thesis cost, which its errata point to.

use super::records::{json, mean, median, percent, ratio, table};
use serde_json::Value;
use std::path::Path;

type Result<T> = std::result::Result<T, String>;

/// A figure of a method against a reference, of every view at a roughness; of the RMSE, the variance of the reference is
/// taken off.
fn values(records: &[Value], method: &str, against: &str, roughness: f64, field: &str) -> Result<Vec<f64>> {
    let is_wanted = |r: &&Value| {
        r["method"] == method
            && r["against"] == against
            && r["roughness"].as_f64().is_some_and(|r| (r - roughness).abs() < 1e-6)
    };
    let value = |r: &Value| {
        let noise = if field == "rmse" { r["standard_error"].as_f64().unwrap_or(0.0) } else { 0.0 };
        r[field].as_f64().map(|v| (v * v - noise * noise).max(0.0).sqrt())
    };
    let all: Vec<f64> = records.iter().filter(is_wanted).filter_map(value).collect();
    if all.is_empty() {
        return Err(format!("no {field} of {method} against {against} at roughness {roughness}"));
    }
    Ok(all)
}

/// What the binary search of the second listing finds with the printed numbers, and with the author's: mirrors.
pub fn search(folder: &Path) -> Result<String> {
    let runs = [
        ("published", "published"),
        ("tolerance", "2e-4 of depth"),
        ("first", "first step a quarter of the last"),
        ("both", "both, as the author's"),
    ];
    let mut rows = Vec::new();
    for method in ["ssct", "linear"] {
        for (run, name) in runs {
            let records = json(&folder.join(run), "error.json")?;
            let of = |against: &str, field: &str| values(&records, method, against, 0.0, field);
            let mut row = vec![format!("`{method}`"), name.to_owned()];
            for field in ["hit_agreement", "false", "missed", "displaced"] {
                row.push(percent(mean(&of("oracle", field)?)?, 1));
            }
            row.push(format!("{:.3}", median(&of("screen", "rmse")?)?));
            rows.push(row);
        }
    }
    table(&["method", "search", "right", "false", "missed", "displaced", "RMSE"], rows)
}

/// The two readings of Eq. 4.5: error and time of the interpolated exponent over those of the project's lobe.
pub fn cone_angle(folder: &Path) -> Result<String> {
    let [lobe, interpolated] = ["lobe", "interpolated"].map(|run| json(&folder.join(run), "error.json"));
    let (lobe, interpolated) = (lobe?, interpolated?);
    let mut rows = Vec::new();
    for method in ["ssct", "hzct"] {
        for roughness in [0.1, 0.3, 0.6] {
            let of = |records: &[Value], field: &str| median(&values(records, method, "screen", roughness, field)?);
            let time = of(&interpolated, "time_ms")? / of(&lobe, "time_ms")?;
            let errors = [of(&lobe, "rmse")?, of(&interpolated, "rmse")?].map(|v| format!("{v:.4}"));
            let [lobe, interpolated] = errors;
            rows.push(vec![format!("`{method}`"), roughness.to_string(), lobe, interpolated, ratio(time)]);
        }
    }
    table(&["method", "ϱ", "RMSE, lobe", "RMSE, interpolated", "time, interpolated over lobe"], rows)
}

/// What passes cost that another renderer would not need: the time of the effect, without them, and their share.
pub fn unneeded(folder: &Path) -> Result<String> {
    let total = |r: &Value| r["total"]["median_ms"].as_f64().ok_or("a record has no total");
    let passes = |r: &Value, wanted: &str| -> f64 {
        let all = r["passes"].as_array().into_iter().flatten();
        all.filter(|p| p["name"].as_str().is_some_and(|n| n.starts_with(wanted)))
            .filter_map(|p| p["median_ms"].as_f64())
            .sum()
    };
    let find = |records: &[Value], method: &str| {
        records.iter().find(|r| r["method"] == method).cloned().ok_or(format!("no times of {method}"))
    };
    let [without, with] = ["minimum", "maximum"].map(|run| json(folder, &format!("{run}.json")));
    let (without, with) = (without?, with?);
    let mut rows = Vec::new();
    for method in ["ssct", "hzct"] {
        let [less, more] = [find(&without, method)?, find(&with, method)?];
        let part = passes(&more, "hi-z") + passes(&more, "depth") - passes(&less, "hi-z") - passes(&less, "depth");
        rows.push((method, "maximum of the Hi-Z buffer", total(&more)?, part));
    }
    for method in ["ssct", "hzct", "linear", "sslr"] {
        let record = find(&without, method)?;
        rows.push((method, "conversion of depth", total(&record)?, passes(&record, "depth")));
    }
    let row = |(method, what, total, part): (&str, &str, f64, f64)| {
        let [total, rest] = [total, total - part].map(|v| format!("{v:.1}"));
        vec![format!("`{method}`"), what.to_owned(), total, rest]
    };
    table(&["method", "what", "effect with it, ms", "without it, ms"], rows.into_iter().map(row).collect())
}
