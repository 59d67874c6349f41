//! The tables of how `dda` was tuned, and of where it stands beside other methods.

use super::figures::{self, Result, json, mean, median, percent, ratio, table};
use serde_json::Value;
use std::path::Path;

/// The scenes that it was tuned on; each has a folder of the defaults beside other methods, and one for each stride.
const SCENES: [&str; 3] = ["rooms", "museum", "street"];

/// Its strides, pixels.
const STRIDES: [u64; 3] = [1, 4, 16];

/// What was tried at each stride: thickness in metres, refinement, jitter.
const TRIED: [(f64, bool, bool); 7] = [
    (0.05, true, false),
    (0.1, true, false),
    (0.25, true, false),
    (0.5, true, false),
    (1.0, true, false),
    (0.25, true, true),
    (0.25, false, false),
];

/// The variant that stands in every folder of a stride, by which times are told.
const TIMED_BY: (u64, (f64, bool, bool)) = (16, (0.25, true, false));

/// The records of a variant, at full resolution and with nothing behind it.
fn of_variant(records: &[Value], stride: u64, (thickness, refine, jitter): (f64, bool, bool)) -> Vec<&Value> {
    let is = |r: &&Value| {
        let setup = &r["setup"];
        let plain = setup["fade"] == true && setup["fallback"] == "none" && setup["resolution_scale"] == 1.0;
        plain
            && r["method"] == "dda"
            && (setup["dda_stride"] == stride && setup["dda_refine"] == refine && setup["dda_jitter"] == jitter)
            && setup["dda_thickness"] == thickness
    };
    records.iter().filter(is).collect()
}

/// A figure of some records against something, a value a view.
fn figures(records: &[&Value], against: &str, field: &str) -> Vec<f64> {
    records.iter().filter(|r| r["against"] == against).filter_map(|r| r[field].as_f64()).collect()
}

/// The four columns of errors: right hits, RMSE against screen and world, right places; means over all views.
fn errors(records: &[&Value]) -> Result<Vec<String>> {
    let mean_of = |against, field| mean(&figures(records, against, field));
    Ok(vec![
        percent(mean_of("oracle", "hit_agreement")?, 1),
        format!("{:.4}", mean_of("screen", "rmse")?),
        format!("{:.4}", mean_of("world", "rmse")?),
        percent(mean_of("world", "place_agreement")?, 1),
    ])
}

const ERRORS: [&str; 4] = ["right hits", "error, screen", "error, world", "right places"];

/// Every stride with every variant.
pub fn tuning(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for stride in STRIDES {
        let runs = SCENES.map(|scene| json(&folder.join(format!("{scene}-stride-{stride}")), "error.json"));
        let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
        for variant @ (thickness, refine, jitter) in TRIED {
            let all: Vec<_> = runs.iter().flat_map(|run| of_variant(run, stride, variant)).collect();
            // Times are compared within a run alone.
            let over = runs.iter().map(|run| {
                let ms = |stride, variant| median(&figures(&of_variant(run, stride, variant), "world", "time_ms"));
                Ok(ms(stride, variant)? / ms(TIMED_BY.0, TIMED_BY.1)?)
            });
            let time = mean(&over.collect::<Result<Vec<_>>>()?)?;
            let says = |on| if on { "on" } else { "off" }.to_owned();
            let head = vec![stride.to_string(), format!("{thickness} m"), says(refine), says(jitter), ratio(time)];
            rows.push([head, errors(&all)?].concat());
        }
    }
    table(&[["stride", "thickness", "refined", "jittered", "time"].as_slice(), &ERRORS].concat(), rows)
}

/// The defaults beside other methods.
pub fn beside(folder: &Path) -> Result<String> {
    let runs = SCENES.map(|scene| json(&folder.join(scene), "error.json"));
    let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
    let mut rows = Vec::new();
    for method in ["dda", "ssct", "linear", "unified"] {
        let over = runs.iter().map(|run| {
            let ms = |method| median(&figures::figures(run, method, "world", "0", "time_ms"));
            Ok(ms(method)? / ms("ssct")?)
        });
        let time = mean(&over.collect::<Result<Vec<_>>>()?)?;
        let all: Vec<_> = runs.iter().flatten().filter(|r| r["method"] == method).collect();
        rows.push([vec![format!("`{method}`"), ratio(time)], errors(&all)?].concat());
    }
    table(&[["method", "time / `ssct`'s"].as_slice(), &ERRORS].concat(), rows)
}
