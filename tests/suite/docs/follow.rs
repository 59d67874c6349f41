//! Tables of what following rays in captures takes: cells that are looked at, and time by the size of the faces.

use super::figures::{Result, json, median, percent, ratio, table};
use serde_json::Value;
use std::path::Path;

/// The images in which `ssct gpu-study` counts cells.
const IMAGES: [&str; 3] = ["screen", "screen-before-captures", "captures"];

/// The sides of faces that are timed, and the rounds of each.
const SIDES: [&str; 4] = ["128", "256", "512", "1024"];
const ROUNDS: std::ops::RangeInclusive<u32> = 1..=3;

pub fn figure(record: &Value, field: &str) -> Result<f64> {
    record[field].as_f64().ok_or_else(|| format!("no {field} in {record}"))
}

/// Cells that the mirror rays of `unified` look at, by view.
pub fn steps(folder: &Path) -> Result<String> {
    let records: Vec<Value> = json(folder, "gpu-study.json")?.into_iter().filter(|r| r["kind"] == "steps").collect();
    let row = |views: &[Value]| -> Result<Vec<String>> {
        let ordered: Vec<&Value> =
            IMAGES.iter().filter_map(|images| views.iter().find(|r| r["images"] == *images)).collect();
        let [alone, before, captures] = ordered[..] else { return Err("a view lacks images".to_owned()) };
        let cells = |r: &Value, field| Ok::<_, String>(format!("{:.1}", figure(r, field)?));
        Ok(vec![
            [&alone["scene"], &alone["view"]].map(|name| name.as_str().unwrap_or("–")).join(", "),
            cells(alone, "mean")?,
            cells(before, "mean")?,
            cells(before, "mean_of_eight")?,
            percent(figure(captures, "rays")? / figure(before, "rays")?, 0),
            cells(captures, "mean")?,
            cells(captures, "mean_of_eight")?,
        ])
    };
    let rows = records.chunk_by(|a, b| a["view"] == b["view"]).map(row).collect::<Result<_>>()?;
    let head = [
        "view",
        "cells, screen alone",
        "screen before captures",
        "most of eight rays",
        "lost rays",
        "cells in captures",
        "most of eight rays",
    ];
    table(&head, rows)
}

/// The time of the pass that follows rays, over that with faces of 512²; that of the effect over that of `ssct`; and the
/// same without the pass. By the side of the faces, medians of the rounds.
pub fn sides(folder: &Path) -> Result<String> {
    let medians = |side: &str| -> Result<[f64; 3]> {
        let (mut follow, mut effect, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        for round in ROUNDS {
            let records = json(folder, &format!("{side}-{round}.json"))?;
            let method = |name: &str| records.iter().find(|r| r["method"] == name).ok_or(format!("no {name}"));
            let (ssct, unified) = (method("ssct")?, method("unified")?);
            let passes = unified["passes"].as_array().ok_or("no passes")?;
            let pass = passes.iter().find(|p| p["name"] == "follow/mirrors").ok_or("no follow/mirrors")?;
            let [pass, all, ssct] = [pass, &unified["total"], &ssct["total"]].map(|t| figure(t, "median_ms"));
            let (pass, all, ssct) = (pass?, all?, ssct?);
            follow.push(pass);
            effect.push(all / ssct);
            rest.push((all - pass) / ssct);
        }
        Ok([median(&follow)?, median(&effect)?, median(&rest)?])
    };
    let [usual, ..] = medians("512")?;
    let row = |side: &&str| {
        let [follow, effect, rest] = medians(side)?;
        Ok(vec![format!("{side}²"), ratio(follow / usual), ratio(effect), ratio(rest)])
    };
    let rows = SIDES.iter().map(row).collect::<Result<_>>()?;
    table(&["faces", "following rays / those with 512²", "effect / `ssct`'s", "without following"], rows)
}
