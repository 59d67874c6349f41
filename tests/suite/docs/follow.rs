//! Tables of what following rays in captures takes: cells that are looked at, and time by the size of the faces.

use super::figures::{Result, greatest, json, median, percent, ratio, table};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The images in which `ssct gpu-study` counts cells.
const IMAGES: [&str; 3] = ["screen", "screen-before-captures", "captures"];

/// The sides of faces that are timed, and the rounds of each.
const SIDES: [&str; 4] = ["128", "256", "512", "1024"];
const ROUNDS: std::ops::RangeInclusive<u32> = 1..=3;

fn figure(record: &Value, field: &str) -> Result<f64> {
    record[field].as_f64().ok_or_else(|| format!("no {field} in {record}"))
}

/// Cells that the mirror rays of `unified` look at, by view.
pub fn steps(folder: &Path) -> Result<String> {
    let records: Vec<Value> = json(folder, "gpu-study.json")?.into_iter().filter(|r| r["kind"] == "steps").collect();
    let row = |views: &[Value]| -> Result<Vec<String>> {
        let of: Vec<&Value> =
            IMAGES.iter().filter_map(|images| views.iter().find(|r| r["images"] == *images)).collect();
        let [alone, before, captures] = of[..] else { return Err("a view lacks images".to_owned()) };
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

/// The motions of `ssct motion`.
const MOTIONS: [&str; 2] = ["sub-pixel", "slow-pan"];

/// How much a reflection changes from frame to frame, in thousandths: of the world reference by its rays, and of `unified`
/// without and with a history, which is the last folder's.
pub fn motion(folders: &[PathBuf]) -> Result<String> {
    let read = |folder: &PathBuf| json(folder, "motion.json");
    let of = |records: &[Value], what: &dyn Fn(&Value) -> Result<f64>| {
        let change = |motion: &&str| {
            let record = records.iter().find(|r| r["motion"] == **motion).ok_or(format!("no {motion}"))?;
            Ok::<_, String>(format!("{:.1}", 1e3 * what(record)?))
        };
        MOTIONS.iter().map(change).collect::<Result<Vec<_>>>()
    };
    let row = |name: String, cells: Vec<String>| std::iter::once(name).chain(cells).collect::<Vec<_>>();
    let (Some(history), Some(most)) = (folders.last(), folders.iter().rev().nth(1)) else {
        return Err("too few folders".to_owned());
    };
    let mut rows = Vec::new();
    for folder in &folders[..folders.len() - 1] {
        let rays = folder.file_name().and_then(|n| n.to_str()).ok_or("no name")?;
        let world = of(&read(folder)?, &|r| figure(&r["world"], "reference_flicker"))?;
        rows.push(row(format!("the world, {rays} rays a pixel"), world));
    }
    rows.push(row("`unified`".to_owned(), of(&read(most)?, &|r| figure(r, "flicker"))?));
    rows.push(row("`unified --history on`".to_owned(), of(&read(history)?, &|r| figure(r, "flicker"))?));
    table(&["what", "moved by an eighth of a pixel", "panned by a quarter of a pixel"], rows)
}

/// How much `unified` changes in a motion, over the world reference; the greatest of some records.
pub fn motion_over(folders: &[PathBuf], motion: &str, roughness: &str) -> Result<String> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no roughness"))?;
    let mut ratios = Vec::new();
    for folder in folders {
        let records = json(folder, "motion.json")?;
        let of = records.iter().filter(|r| [r["motion"].as_str(), Some("any")].contains(&Some(motion)));
        let of = of.filter(|r| r["roughness"].as_f64().is_some_and(|r| (r - wanted).abs() < 1e-6));
        ratios.append(&mut of.map(|r| figure(&r["world"], "ratio")).collect::<Result<Vec<_>>>()?);
    }
    if ratios.is_empty() {
        return Err(format!("no {motion} at roughness {roughness}"));
    }
    Ok(ratio(greatest(&ratios)))
}

/// The time of the pass that follows rays, over that with faces of 512²; that of the effect over that of `ssct`; and the
/// same without the pass. By the side of the faces, medians of the rounds.
pub fn sides(folder: &Path) -> Result<String> {
    let of = |side: &str| -> Result<[f64; 3]> {
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
    let [usual, ..] = of("512")?;
    let row = |side: &&str| {
        let [follow, effect, rest] = of(side)?;
        Ok(vec![format!("{side}²"), ratio(follow / usual), ratio(effect), ratio(rest)])
    };
    let rows = SIDES.iter().map(row).collect::<Result<_>>()?;
    table(&["faces", "following rays, over that with 512²", "effect over `ssct`", "without following"], rows)
}
