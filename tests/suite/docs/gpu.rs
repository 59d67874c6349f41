//! Tables of what a GPU takes: the screen beside the triangles of the scene, and fragment shaders beside compute shaders.

use super::figures::{Result, Row, csv, greatest, json, least, median, number, ratio, shortest, table};
use super::follow::figure;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The times of a run at a roughness: scene, method and milliseconds of each view.
fn rows(folder: &Path, roughness: &str) -> Result<Vec<(String, String, f64)>> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no number"))?;
    let mut rows = Vec::new();
    for row in csv(folder, "times.csv")? {
        if (number(&row, "roughness")? - wanted).abs() < 1e-6 {
            rows.push((row["scene"].clone(), row["method"].clone(), number(&row, "median_ms")?));
        }
    }
    Ok(rows)
}

/// Median times of the effect in milliseconds over a scene's views, by scene and method.
fn times(folder: &Path, roughness: &str) -> Result<BTreeMap<(String, String), f64>> {
    let mut all: BTreeMap<_, Vec<f64>> = BTreeMap::new();
    for (scene, method, ms) in rows(folder, roughness)? {
        all.entry((scene, method)).or_default().push(ms);
    }
    all.into_iter().map(|(key, views)| Ok((key, median(&views)?))).collect()
}

/// `unified` on the screen alone, on the screen before the triangles, and among the triangles at once, all in compute shaders:
/// milliseconds at a roughness, a scene a row. The first folder has the screen alone, the second the screen first.
pub fn triangle_times(folders: &[PathBuf], roughness: &str) -> Result<String> {
    let [alone, first] = folders else { return Err("two folders are needed".to_owned()) };
    let (alone, first) = (times(alone, roughness)?, times(first, roughness)?);
    let scenes: BTreeSet<_> = first.keys().map(|(scene, _)| scene.clone()).collect();
    let row = |scene: &String| -> Result<Vec<String>> {
        let cell = |times: &BTreeMap<_, f64>, method: &str| {
            let time = times.get(&(scene.clone(), method.to_owned()));
            time.map(|ms| format!("{ms:.2}")).ok_or_else(|| format!("{scene} has no time of {method}"))
        };
        let cells = [cell(&alone, "unified")?, cell(&first, "unified")?, cell(&first, "traced")?];
        Ok([scene.clone()].into_iter().chain(cells).collect())
    };
    let head = ["scene", "screen alone", "screen first", "triangles first"];
    table(&head, scenes.iter().map(row).collect::<Result<_>>()?)
}

/// The least and the greatest ratio of a method's time to that of `ssct` over the sizes of table 5.8 at a roughness, of a study of a
/// device, which has the table's records first.
pub fn over_ssct(folder: &Path, method: &str, roughness: &str) -> Result<String> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no number"))?;
    let records = json(folder, "time.json")?;
    let first = records.first().ok_or("no records")?;
    let of_table = records.iter().take_while(|r| r["scene"] == first["scene"] && r["view"] == first["view"]);
    let here: Vec<&Value> =
        of_table.filter(|r| r["roughness"].as_f64().is_some_and(|r| (r - wanted).abs() < 1e-6)).collect();
    let time = |name: &str, size: &Value| {
        let is_it = |r: &&&Value| r["method"] == name && r["width"] == size["width"] && r["height"] == size["height"];
        here.iter().find(is_it).ok_or(format!("no {name}")).and_then(|r| figure(&r["total"], "median_ms"))
    };
    let sizes = here.iter().filter(|r| r["method"] == "ssct");
    let ratios = sizes.map(|size| Ok(time(method, size)? / time("ssct", size)?)).collect::<Result<Vec<_>>>()?;
    if ratios.is_empty() {
        return Err(format!("no time at roughness {roughness}"));
    }
    Ok(format!("{:.2} to {:.2}", least(&ratios), greatest(&ratios)))
}

/// The least and the greatest time of a method over all views at a roughness, in milliseconds.
pub fn time_range(folder: &Path, method: &str, roughness: &str) -> Result<String> {
    let method_rows = rows(folder, roughness)?.into_iter().filter(|(_, name, _)| name == method);
    let all: Vec<f64> = method_rows.map(|(_, _, ms)| ms).collect();
    if all.is_empty() {
        return Err(format!("no time of {method} at roughness {roughness}"));
    }
    Ok(format!("{:.1} to {:.1}", least(&all), greatest(&all)))
}

/// `unified` on the screen with its passes in fragment and in compute shaders, of a study of a device.
pub fn stages_on(folder: &Path) -> Result<String> {
    let records = json(folder, "time.json")?;
    // All others leave the stages to the device.
    let told: Vec<Value> =
        records.into_iter().filter(|r| r["setup"]["trace_stage"].as_str().is_some_and(|s| s != "auto")).collect();
    let row = |pair: &[Value]| -> Result<Vec<String>> {
        let [fragment, compute] = pair else { return Err("records come in pairs".to_owned()) };
        let stages = [fragment, compute].map(|r| r["setup"]["trace_stage"].as_str());
        if stages != [Some("fragment"), Some("compute")] {
            return Err(format!("{stages:?} instead of fragment and compute"));
        }
        let [slow, fast] = [figure(&fragment["total"], "median_ms")?, figure(&compute["total"], "median_ms")?];
        let roughness = fragment["roughness"].to_string();
        Ok(vec![shortest(&roughness).to_owned(), format!("{slow:.2}"), format!("{fast:.2}"), ratio(slow / fast)])
    };
    table(
        &["roughness", "fragment, ms", "compute, ms", "fragment / compute"],
        told.chunks_exact(2).map(row).collect::<Result<_>>()?,
    )
}

/// The median or the greatest FLIP between the golden images of two versions of Mesa, by how maps are filtered.
pub fn filters(folder: &Path, filter: &str, average: &str) -> Result<String> {
    let rows = csv(folder, "golden.csv")?;
    let flips = rows.iter().map(|r| number(r, &format!("{filter}_point_flip"))).collect::<Result<Vec<_>>>()?;
    let flip = if average == "most" { flips.iter().copied().fold(0.0, f64::max) } else { median(&flips)? };
    Ok(if flip < 0.001 { format!("{flip:.4}") } else { format!("{flip:.3}") })
}

/// Milliseconds of the effect in the programs of `programs-again`, with the code kept on the disk (`yes`) or not, at a width.
pub fn programs_again(folder: &Path, [program, kept, width]: [&str; 3]) -> Result<String> {
    let rows = csv(folder, "times.csv")?;
    let selected = rows.iter().filter(|r| r["program"] == program && r["kept_on_disk"] == kept && r["width"] == width);
    let ms = median(&selected.map(|r| number(r, "effect_ms")).collect::<Result<Vec<_>>>()?)?;
    Ok(if ms < 1.0 { format!("{ms:.2}") } else { format!("{ms:.1}") })
}

/// The programs whose registers the page shows, by their files under `shaders-glsl/` and what is defined for them.
const SHOWN: [&str; 13] = [
    "thesis/ssct.frag",
    "unified/pyramid.comp",
    "unified/mirror.comp",
    "unified/mirror.comp CONFIRMED",
    "unified/mirror.comp AMONG_TRIANGLES",
    "unified/gloss_trace.comp NARROW CONFIRMED",
    "unified/gloss_trace.comp CONFIRMED",
    "unified/gloss_resolve.comp NARROW",
    "unified/gloss_resolve.comp CELLS",
    "unified/gloss_resolve.frag CELLS",
    "triangles/follow.comp NARROW",
    "triangles/own.comp NARROW AMONG_TRIANGLES",
    "common/history.comp",
];

/// Vector registers and subgroups a SIMD unit of some programs on each family, before and after, a program a row. In brackets stand the
/// registers that a program needs.
pub fn registers(folder: &Path) -> Result<String> {
    let [before, after] = ["before.csv", "after.csv"].map(|file| csv(folder, file));
    let (before, after) = (before?, after?);
    let families = ["vega20", "navi10", "navi21", "navi31", "gfx1201"];
    let find = |rows: &[Row], program: &str, family: &str| -> Result<Row> {
        let row = rows.iter().find(|r| r["program"] == program && r["family"] == family);
        row.cloned().ok_or(format!("no {program} on {family}"))
    };
    let row = |program: &&str| -> Result<Vec<String>> {
        let both = |family: &str| {
            let (old, new) = (find(&before, program, family)?, find(&after, program, family)?);
            let is_same = ["registers", "subgroups"].iter().all(|column| old[*column] == new[*column]);
            let was = if is_same { String::new() } else { format!("{}, {} → ", old["registers"], old["subgroups"]) };
            Ok(format!("{was}{} ({}), {}", new["registers"], new["needed"], new["subgroups"]))
        };
        let cells = families.iter().map(|family| both(family)).collect::<Result<Vec<_>>>()?;
        Ok([format!("`{program}`")].into_iter().chain(cells).collect())
    };
    let head: Vec<&str> = ["program"].into_iter().chain(families).collect();
    table(&head, SHOWN.iter().map(row).collect::<Result<_>>()?)
}

/// The most vector registers that a program of a stage needs, after: on the families of RDNA and on those before, as "63 and 63".
pub fn most_needed(folder: &Path, stage: &str) -> Result<String> {
    let rows = csv(folder, "after.csv")?;
    let most = |is_wanted: fn(&str) -> bool| -> Result<f64> {
        let of_stage = rows.iter().filter(|r| r["program"].contains(stage) && is_wanted(&r["family"]));
        Ok(greatest(&of_stage.map(|r| number(r, "needed")).collect::<Result<Vec<_>>>()?))
    };
    Ok(format!("{} and {}", most(|family| family != "vega20")?, most(|family| family == "vega20")?))
}
