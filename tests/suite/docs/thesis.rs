//! Tables of the thesis: its table 5.8 beside what was measured, and what its numbers and formulas cost, to which its
//! errata point.

use super::figures::{Result, csv, figures, greatest, json, least, mean, median, number, percent, ratio, table, text};
use serde_json::Value;
use std::path::Path;

/// Rows of table 5.8 in `time.txt`: size, roughness, and the ten columns that it lays beside each other. The methods take turns, so
/// that their ratios here are medians over the turns, which other programs disturb less than they disturb the times.
pub fn rows_5_8(folder: &Path) -> Result<Vec<Vec<String>>> {
    let mut rows = printed_rows(folder)?;
    let samples = csv(folder, "time-samples.csv")?;
    for row in &mut rows {
        for (column, method) in [(9, "hzct"), (11, "sslr")] {
            let times = |method: &str| {
                let here = samples.iter().filter(|s| {
                    let roughness = s["roughness"].parse::<f64>().is_ok_and(|r| format!("{r:.1}") == row[1]);
                    s["method"] == method && format!("{}×{}", s["width"], s["height"]) == row[0] && roughness
                });
                here.map(|s| number(s, "effect_ms")).collect::<Result<Vec<_>>>()
            };
            let turns: Vec<_> = times(method)?.iter().zip(times("ssct")?).map(|(other, ssct)| other / ssct).collect();
            row[column] = median(&turns).map(ratio)?;
        }
    }
    Ok(rows)
}

fn printed_rows(folder: &Path) -> Result<Vec<Vec<String>>> {
    let text = text(folder, "time.txt")?;
    let mut rows = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        // Roughness and ten numbers, and then the drift, in per cent.
        let [width, "x", height, rest @ .., _, "%"] = &words[..] else { continue };
        if rest.len() != 11 {
            return Err(format!("a row of {} columns in {}/time.txt", rest.len(), folder.display()));
        }
        rows.push([format!("{width}×{height}")].into_iter().chain(rest.iter().map(|w| (*w).to_owned())).collect());
    }
    Ok(rows)
}

/// HZCT beside SSCT, in print and here.
pub fn table_5_8(folder: &Path) -> Result<String> {
    let columns = [0, 1, 2, 3, 4, 5, 8, 9];
    let rows = rows_5_8(folder)?.into_iter().map(|r| columns.map(|c| r[c].clone()).to_vec()).collect();
    let head = [
        "size",
        "ϱ",
        "SSCT, thesis, ms",
        "SSCT, here, ms",
        "HZCT, thesis, ms",
        "HZCT, here, ms",
        "HZCT/SSCT, thesis",
        "HZCT/SSCT, here",
    ];
    table(&head, rows)
}

/// SSLR beside SSCT, in print and here.
pub fn sslr(folder: &Path) -> Result<String> {
    let columns = [0, 1, 6, 7, 10, 11];
    let rows = rows_5_8(folder)?.into_iter().map(|r| columns.map(|c| r[c].clone()).to_vec()).collect();
    table(&["size", "ϱ", "SSLR, thesis, ms", "SSLR, here, ms", "SSLR/SSCT, thesis", "SSLR/SSCT, here"], rows)
}

/// Least and greatest HZCT/SSCT that was measured.
pub fn table_5_8_range(folder: &Path) -> Result<String> {
    let ratios =
        rows_5_8(folder)?.iter().map(|r| r[9].parse::<f64>().map_err(|e| e.to_string())).collect::<Result<Vec<_>>>()?;
    median(&ratios)?;
    Ok(format!("{:.2} to {:.2}", least(&ratios), greatest(&ratios)))
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
            let values = |against: &str, field: &str| figures(&records, method, against, "0", field);
            let mut row = vec![format!("`{method}`"), name.to_owned()];
            for field in ["hit_agreement", "false", "missed", "displaced"] {
                row.push(percent(mean(&values("oracle", field))?, 1));
            }
            row.push(format!("{:.3}", median(&values("screen", "rmse"))?));
            rows.push(row);
        }
    }
    table(&["method", "search", "right", "false", "missed", "displaced", "RMSE"], rows)
}

/// The two readings of Eq. 4.5: the errors of both, and the time of the interpolated exponent over that of the lobe.
pub fn cone_angle(folder: &Path) -> Result<String> {
    let [lobe, interpolated] = ["lobe", "interpolated"].map(|run| json(&folder.join(run), "error.json"));
    let (lobe, interpolated) = (lobe?, interpolated?);
    let mut rows = Vec::new();
    for method in ["ssct", "hzct"] {
        for roughness in ["0.1", "0.3", "0.6"] {
            let median_of =
                |records: &[Value], field: &str| median(&figures(records, method, "screen", roughness, field));
            let time = median_of(&interpolated, "time_ms")? / median_of(&lobe, "time_ms")?;
            let errors = [median_of(&lobe, "rmse")?, median_of(&interpolated, "rmse")?].map(|v| format!("{v:.4}"));
            let [lobe, interpolated] = errors;
            rows.push(vec![format!("`{method}`"), roughness.to_string(), lobe, interpolated, ratio(time)]);
        }
    }
    table(&["method", "ϱ", "RMSE, lobe", "RMSE, interpolated", "time, interpolated / lobe"], rows)
}

/// What passes cost that another renderer would not need: the time of the effect with them and without.
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
