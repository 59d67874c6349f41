//! Tables of rays of a pixel's own among the triangles: times on a GPU, and errors.

use super::figures::{Result, csv, greatest, json, least, median, number, ratio, table};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// How many rays of its own a pixel gets, as options and files name it.
const OWN: [&str; 3] = ["none", "4", "8"];

/// The time of `traced` with so many rays of their own over that without, median over the views, greatest in brackets, and the least
/// and greatest time; a roughness a row.
pub fn times(folder: &Path) -> Result<String> {
    let mut all = BTreeMap::new();
    for row in csv(folder, "times.csv")? {
        let [roughness, own, scene, view, method] =
            ["roughness", "own_rays", "scene", "view", "method"].map(|field| row[field].clone());
        all.insert((roughness, own, scene, view, method), number(&row, "median_ms")?);
    }
    let cell = |roughness: &str, own: &str| -> Result<[String; 2]> {
        let here = all.iter().filter(|((r, o, _, _, method), _)| r == roughness && o == own && method == "traced");
        let (mut ratios, mut ms) = (Vec::new(), Vec::new());
        for ((r, _, scene, view, _), time) in here {
            let base = (r.clone(), OWN[0].to_owned(), scene.clone(), view.clone(), "traced".to_owned());
            ratios.push(time / all.get(&base).ok_or_else(|| format!("no time without own rays on {scene} {view}"))?);
            ms.push(*time);
        }
        Ok([
            format!("{} ({})", ratio(median(&ratios)?), ratio(greatest(&ratios))),
            format!("{:.1} to {:.1}", least(&ms), greatest(&ms)),
        ])
    };
    let roughness: BTreeSet<_> = all.keys().map(|(roughness, ..)| roughness.clone()).collect();
    let row = |roughness: &String| -> Result<Vec<String>> {
        let cells = OWN.into_iter().map(|own| cell(roughness, own)).collect::<Result<Vec<_>>>()?.concat();
        // Over itself it is 1.
        Ok(std::iter::once(roughness.clone()).chain(cells.into_iter().skip(1)).collect())
    };
    table(
        &["roughness", "none, ms", "4 / none", "ms", "8 / none", "ms"],
        roughness.iter().map(row).collect::<Result<_>>()?,
    )
}

/// The error of `traced` over that of `ssct` with so many rays of their own, without what the reference's own noise adds, by
/// scene and roughness.
pub fn errors(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for scene in ["rooms", "corridor", "atrium", "street", "cathedral"] {
        let records = json(folder, &format!("{scene}.json"))?;
        let error = |roughness: f64, method: &str, own: Option<&str>| -> Result<f64> {
            let is = |r: &&Value| {
                r["against"] == "world"
                    && r["method"] == method
                    && r["roughness"].as_f64().is_some_and(|r| (r - roughness).abs() < 1e-6)
                    && own.is_none_or(|own| r["setup"]["own_rays"] == own)
            };
            let record = records.iter().find(is).ok_or_else(|| format!("{scene}: no {method} at {roughness}"))?;
            let figure = |key: &str| record[key].as_f64().ok_or_else(|| format!("{scene}: no {key}"));
            Ok((figure("rmse")?.powi(2) - figure("standard_error")?.powi(2)).max(0.0).sqrt())
        };
        let view = records.first().and_then(|r| r["view"].as_str()).ok_or("no records")?;
        let mut row = vec![format!("{scene} `{view}`")];
        for roughness in [0.1, 0.3] {
            for own in OWN {
                row.push(ratio(error(roughness, "traced", Some(own))? / error(roughness, "ssct", None)?));
            }
        }
        rows.push(row);
    }
    table(&["view", "0.1: none", "4", "8", "0.3: none", "4", "8"], rows)
}

/// The least and the greatest of `figure` with so many rays of their own on the screen alone over that without, over the views of a
/// folder.
pub fn on_screen(folder: &Path, own: &str, figure: &str) -> Result<String> {
    let mut ratios = Vec::new();
    for scene in ["rooms", "museum", "atrium", "street"] {
        let file = if figure == "rmse" { format!("{scene}.json") } else { format!("time-{scene}.json") };
        let records = json(folder, &file)?;
        let of_rays = |own: &str| -> Result<f64> {
            let is = |r: &&Value| r["setup"]["own_rays"] == own && (figure != "rmse" || r["against"] == "screen");
            let record = records.iter().find(is).ok_or_else(|| format!("{file}: nothing with {own}"))?;
            let value = if figure == "rmse" { &record["rmse"] } else { &record["total"]["median_ms"] };
            value.as_f64().ok_or_else(|| format!("{file}: no {figure}"))
        };
        ratios.push(of_rays(own)? / of_rays("none")?);
    }
    Ok(format!("{} to {}", ratio(least(&ratios)), ratio(greatest(&ratios))))
}
