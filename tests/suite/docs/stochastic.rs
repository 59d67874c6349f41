//! The tables of how `stochastic` was tuned, and of what a history does.

use super::figures::{self, Result, json, mean, median, ratio, table};
use serde_json::{Value, json};
use std::path::Path;

/// The scenes that it was tuned on; each has a folder of the sweep beside other methods, and one with a history.
const SCENES: [&str; 3] = ["rooms", "museum", "street"];

/// Roughness values of the runs.
const ROUGHNESS: [&str; 4] = ["0.05", "0.1", "0.3", "0.6"];

/// What the records say of the defaults.
fn defaults() -> Value {
    json!({"stochastic_rays": 1, "stochastic_gathered": 9, "stochastic_radius": 2.0, "stochastic_part": 0.7, "stochastic_walk": "exact"})
}

/// What was tried beside the defaults: what a row is called, and what is otherwise.
fn tried() -> Vec<(&'static str, Value)> {
    vec![
        ("the defaults", json!({})),
        ("1 ray gathered: no spatial filter", json!({"stochastic_gathered": 1})),
        ("4 gathered", json!({"stochastic_gathered": 4})),
        ("16 gathered", json!({"stochastic_gathered": 16})),
        ("within 1.5 pixels", json!({"stochastic_radius": 1.5})),
        ("within 3 pixels", json!({"stochastic_radius": 3.0})),
        ("half of the lobe", json!({"stochastic_part": 0.5})),
        ("all of the lobe", json!({"stochastic_part": 1.0})),
        ("walk of the thesis", json!({"stochastic_walk": "thesis"})),
        ("2 rays", json!({"stochastic_rays": 2})),
        ("4 rays", json!({"stochastic_rays": 4})),
        ("4 rays, 1 gathered", json!({"stochastic_rays": 4, "stochastic_gathered": 1})),
        ("16 rays, 1 gathered", json!({"stochastic_rays": 16, "stochastic_gathered": 1})),
    ]
}

/// Whether two values of a setup are the same, whatever kind of number they are.
fn same(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-6,
        _ => a == b,
    }
}

/// The records of a method at full resolution by version 1 of the oracle; of `stochastic`, those of a variant.
fn of_variant<'a>(records: &'a [Value], method: &str, changed: &Value) -> Vec<Value> {
    let defaults = defaults();
    let is = |r: &&'a Value| {
        let setup = &r["setup"];
        let own = defaults.as_object().into_iter().flatten();
        r["method"] == method
            && setup["preset"] == "published"
            && same(&setup["resolution_scale"], &json!(1))
            && setup["oracle"].to_string().contains('1')
            && (method != "stochastic"
                || own.map(|(k, v)| (k, changed.get(k).unwrap_or(v))).all(|(k, v)| same(&setup[k], v)))
    };
    records.iter().filter(is).cloned().collect()
}

/// Four columns of errors against the screen, by roughness, and their mean against the world; means over the views.
fn errors(records: &[Value], method: &str) -> Result<Vec<String>> {
    let rmse = |against: &str, roughness: &str| mean(&figures::figures(records, method, against, roughness, "rmse"));
    let screen = ROUGHNESS.iter().map(|r| rmse("screen", r)).collect::<Result<Vec<_>>>()?;
    let world = ROUGHNESS.iter().map(|r| rmse("world", r)).collect::<Result<Vec<_>>>()?;
    Ok(screen.into_iter().chain([mean(&world)?]).map(|v| format!("{v:.4}")).collect())
}

const ERRORS: [&str; 5] = ["screen, 0.05", "0.1", "0.3", "0.6", "world, mean"];

/// Every variant, and two other methods.
pub fn tuning(folder: &Path) -> Result<String> {
    let runs = SCENES.map(|scene| json(&folder.join(scene), "error.json"));
    let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
    let row = |name: String, method: &str, changed: &Value| -> Result<Vec<String>> {
        // Times are compared within a run alone.
        let over = runs.iter().map(|run| {
            let ms = |records: &[Value]| {
                median(
                    &records
                        .iter()
                        .filter(|r| r["against"] == "world")
                        .filter_map(|r| r["time_ms"].as_f64())
                        .collect::<Vec<_>>(),
                )
            };
            Ok(ms(&of_variant(run, method, changed))? / ms(&of_variant(run, "ssct", &Value::Null))?)
        });
        let time = mean(&over.collect::<Result<Vec<_>>>()?)?;
        let all: Vec<_> = runs.iter().flat_map(|run| of_variant(run, method, changed)).collect();
        Ok([vec![name, ratio(time)], errors(&all, method)?].concat())
    };
    let mut rows = Vec::new();
    for (name, changed) in tried() {
        rows.push(row(name.to_owned(), "stochastic", &changed)?);
    }
    for method in ["unified", "ssct"] {
        rows.push(row(format!("`{method}`"), method, &Value::Null)?);
    }
    table(&[["variant", "time / `ssct`'s"].as_slice(), &ERRORS].concat(), rows)
}

/// With a history and without it, at rest.
pub fn history(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for method in ["stochastic", "unified"] {
        for (name, suffix) in [("one frame", ""), ("a history", "-history-16-1")] {
            let mut all = Vec::new();
            for scene in SCENES {
                let run = json(&folder.join(format!("{scene}{suffix}")), "error.json")?;
                all.extend(of_variant(&run, method, &Value::Null));
            }
            rows.push([vec![format!("`{method}`, {name}")], errors(&all, method)?].concat());
        }
    }
    table(&[["method"].as_slice(), &ERRORS].concat(), rows)
}

/// Frames and bounds that were tried, on the rooms.
pub fn history_tuning(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (frames, deviations) in [(8, "1"), (16, "0.5"), (16, "1"), (16, "2"), (32, "1")] {
        let run = json(&folder.join(format!("rooms-history-{frames}-{deviations}")), "error.json")?;
        let all = of_variant(&run, "stochastic", &Value::Null);
        rows.push([vec![frames.to_string(), deviations.to_owned()], errors(&all, "stochastic")?].concat());
    }
    table(&[["frames", "standard deviations"].as_slice(), &ERRORS].concat(), rows)
}
