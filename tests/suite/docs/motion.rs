//! Figures of how much reflections change under a moving camera (`ssct motion`).

use super::figures::{Result, greatest, json, ratio, table};
use super::follow::figure;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// How the camera moves.
const MOTIONS: [&str; 2] = ["sub-pixel", "slow-pan"];

/// The change of `unified` over that of the world reference at a roughness: the greater one of both motions.
pub fn most(folder: &Path, roughness: &str) -> Result<String> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no roughness"))?;
    let records = json(folder, "motion.json")?;
    let selected = records.iter().filter(|r| r["roughness"].as_f64().is_some_and(|r| (r - wanted).abs() < 1e-6));
    let ratios = selected.map(|r| figure(&r["world"], "ratio")).collect::<Result<Vec<_>>>()?;
    if ratios.len() == MOTIONS.len() {
        Ok(ratio(greatest(&ratios)))
    } else {
        Err(format!("not both motions at {roughness}"))
    }
}

/// The change from frame to frame, in thousandths: of the world reference in folders that are named by its rays a pixel, and
/// of `unified`, without a history in the last but one of the folders and with one in the last.
pub fn by_rays(folders: &[PathBuf]) -> Result<String> {
    let [worlds @ .., with_history] = folders else { return Err("no records are named".to_owned()) };
    let most = worlds.last().ok_or("records without a history are missing")?;
    let rays = |folder: &PathBuf| {
        let name = folder.file_name().and_then(|n| n.to_str()).ok_or("a folder has no name")?;
        Ok::<_, String>(format!("{name} rays a pixel"))
    };
    let row = |name: &str, folder: &Path, cell: fn(&Value) -> Result<String>| {
        let records = json(folder, "motion.json")?;
        let motion_cell =
            |motion: &&str| cell(records.iter().find(|r| r["motion"] == **motion).ok_or(format!("no {motion}"))?);
        std::iter::once(Ok(name.to_owned())).chain(MOTIONS.iter().map(motion_cell)).collect::<Result<Vec<_>>>()
    };
    let world: fn(&Value) -> Result<String> = |r| thousandths(figure(&r["world"], "reference_flicker")?);
    let own: fn(&Value) -> Result<String> = |r| thousandths(figure(r, "flicker")?);
    let mut rows = Vec::new();
    for folder in worlds {
        rows.push(row(&format!("the world, {}", rays(folder)?), folder, world)?);
    }
    rows.push(row("`unified`", most, own)?);
    rows.push(row("`unified` with `--history on`", with_history, own)?);
    rows.push(row(&format!("`unified` / the world, {}", rays(most)?), most, |r| {
        Ok(ratio(figure(&r["world"], "ratio")?))
    })?);
    table(&["what", "moved by an eighth of a pixel", "panned by a quarter of a pixel"], rows)
}

fn thousandths(change: f64) -> Result<String> {
    Ok(format!("{:.1}", 1e3 * change))
}
