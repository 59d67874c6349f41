//! Tables and numbers of captures and of what is behind a method, against the world.

use super::figures::{
    ROUGHNESS, Result, csv, greatest, json, least, median, median_and_greatest, number, percent, ratio, table, text,
};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The scenes that captures are measured on, each with its aim: the world RMSE of `unified` with four captures over
/// that of `ssct`, for mirrors and in the median of its views.
const BEYOND: [(&str, f64); 8] = [
    ("rooms", 0.2),
    ("ssct-rooms", 0.2),
    ("atrium", 0.6),
    ("sponza", 0.6),
    ("museum", 0.25),
    ("street", 0.3),
    ("cathedral", 0.75),
    ("corridor", 0.55),
];

/// How much more than its aim a scene may have at each of [`ROUGHNESS`].
const ALLOWED: [f64; 5] = [0.0, 0.05, 0.05, 0.1, 0.1];

/// `unified` beyond the screen, and what it is held against: a method, and what is behind it.
const CAPTURED: (&str, &str) = ("unified", "none");
const ALONE: (&str, &str) = ("ssct", "none");

/// The records of a scene, of folders that have one folder a scene; not every folder has every scene.
fn of_scene(folders: &[PathBuf], scene: &str) -> Result<Vec<Value>> {
    let there = folders.iter().map(|folder| folder.join(scene)).filter(|folder| folder.exists());
    let all = there.map(|folder| json(&folder, "error.json"));
    Ok(all.collect::<Result<Vec<_>>>()?.concat())
}

/// A figure against the world of a method at a roughness, by view; of the RMSE, the variance of the reference is taken off.
fn by_view(records: &[Value], (method, behind): (&str, &str), roughness: &str, field: &str) -> BTreeMap<String, f64> {
    let wanted: f64 = roughness.parse().unwrap_or(f64::NAN);
    let method_records = records.iter().filter(|r| r["method"] == method && r["against"] == "world");
    let here = method_records
        .filter(|r| r["setup"]["fallback"] == behind)
        .filter(|r| r["roughness"].as_f64().is_some_and(|r| (r - wanted).abs() < 1e-6));
    let mut views = BTreeMap::new();
    for r in here {
        let noise = if field == "rmse" { r["standard_error"].as_f64().unwrap_or(0.0) } else { 0.0 };
        if let (Some(view), Some(value)) = (r["view"].as_str(), r[field].as_f64()) {
            // What is in several folders counts as the first has it.
            views.entry(view.to_owned()).or_insert((value * value - noise * noise).max(0.0).sqrt());
        }
    }
    views
}

/// A figure of `unified` with captures over that of another method, for each view.
fn captured_over(records: &[Value], other: (&str, &str), roughness: &str, field: &str) -> Result<Vec<f64>> {
    let [own, others] = [CAPTURED, other].map(|variant| by_view(records, variant, roughness, field));
    if own.is_empty() || own.keys().ne(others.keys()) {
        return Err(format!("at roughness {roughness}, not every view has unified and {other:?}"));
    }
    Ok(own.values().zip(others.values()).map(|(a, b)| a / b).collect())
}

/// The time of a method's effect by view, of the runs that measured times alone, which lie in the first folder.
fn times(folders: &[PathBuf], scene: &str, method: &str, roughness: &str) -> Result<BTreeMap<String, f64>> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no number"))?;
    let mut views = BTreeMap::new();
    for row in csv(&folders[0], "times.csv")? {
        let is_wanted = row["scene"] == scene && row["method"] == method;
        if is_wanted && (number(&row, "roughness")? - wanted).abs() < 1e-6 {
            views.insert(row["view"].clone(), number(&row, "median_ms")?);
        }
    }
    Ok(views)
}

/// The time of a method over that of `ssct`, for each view.
fn times_over(folders: &[PathBuf], scene: &str, method: &str, roughness: &str) -> Result<Vec<f64>> {
    let own = times(folders, scene, method, roughness)?;
    let others = times(folders, scene, "ssct", roughness)?;
    if own.is_empty() || own.keys().ne(others.keys()) {
        return Err(format!("{scene} at roughness {roughness}: not every view has times of {method} and ssct"));
    }
    Ok(own.values().zip(others.values()).map(|(a, b)| a / b).collect())
}

/// The time of `unified` with captures over that of `ssct`, a scene a row and a roughness a column.
pub fn times_beyond(folders: &[PathBuf]) -> Result<String> {
    let row = |scene: &str| -> Result<Vec<String>> {
        let cell = |roughness: &&str| median_and_greatest(&times_over(folders, scene, "unified", roughness)?);
        let cells = ROUGHNESS.iter().map(cell).collect::<Result<Vec<_>>>()?;
        Ok([scene.to_owned()].into_iter().chain(cells).collect())
    };
    let mut rows = BEYOND.iter().map(|(scene, _)| row(scene)).collect::<Result<Vec<_>>>()?;
    let all = |roughness: &&str| {
        let scene_times = |(scene, _): &(&str, f64)| times_over(folders, scene, "unified", roughness);
        median_and_greatest(&BEYOND.iter().map(scene_times).collect::<Result<Vec<_>>>()?.concat())
    };
    let cells = ROUGHNESS.iter().map(all).collect::<Result<Vec<_>>>()?;
    rows.push(["*all views*".to_owned()].into_iter().chain(cells).collect());
    table(&["scene", "ϱ 0", "0.05", "0.1", "0.3", "0.6"], rows)
}

/// The error of `unified` with captures over that of another method, for all views of all scenes.
fn captured_over_in_all(folders: &[PathBuf], other: (&str, &str), roughness: &str) -> Result<Vec<f64>> {
    let scene_ratios = |(scene, _): &(&str, f64)| captured_over(&of_scene(folders, scene)?, other, roughness, "rmse");
    Ok(BEYOND.iter().map(scene_ratios).collect::<Result<Vec<_>>>()?.concat())
}

/// What the captures of `unified` took before the first frame of a scene, at most: seconds and bytes on the device.
pub fn prepared(folder: &Path, scene: &str) -> Result<String> {
    let records = of_scene(&[folder.to_owned()], scene)?;
    let prepared = records.iter().filter(|r| r["method"] == CAPTURED.0).map(|r| &r["prepared"]);
    let most = |field: &str| greatest(&prepared.clone().filter_map(|p| p[field].as_f64()).collect::<Vec<_>>());
    Ok(format!("{:.1} s and {:.0} MB", 1e-3 * most("time_ms"), 1e-6 * most("device_bytes")))
}

/// The share of mirror rays that end where they do in the world: median and, in brackets, the least.
fn right_places(records: &[Value]) -> Result<String> {
    let places: Vec<f64> = by_view(records, CAPTURED, "0", "place_agreement").into_values().collect();
    Ok(format!("{} ({})", percent(median(&places)?, 1), percent(least(&places), 1)))
}

/// What captures gain against the world at a roughness, a scene's views a row: medians of the errors, and `unified` over
/// `ssct`.
pub fn beyond(folders: &[PathBuf], roughness: &str) -> Result<String> {
    let is_mirror = roughness == "0";
    let row = |(scene, _): &(&str, f64)| -> Result<Vec<String>> {
        let records = of_scene(folders, scene)?;
        let middle = |method: (&str, &str), field: &str| {
            let values: Vec<f64> = by_view(&records, method, roughness, field).into_values().collect();
            median(&values).map(|m| format!("{m:.3}"))
        };
        let over = |field: &str| median_and_greatest(&captured_over(&records, ALONE, roughness, field)?);
        let errors = [ALONE, ("captures", "none"), CAPTURED].map(|method| middle(method, "rmse"));
        let mut row = vec![(*scene).to_owned()];
        row.extend(errors.into_iter().collect::<Result<Vec<_>>>()?);
        // Lobes have no places, and their floor is for the most part the noise of the reference.
        if is_mirror {
            row.extend([middle(ALONE, "floor")?, over("rmse")?, right_places(&records)?]);
        } else {
            row.push(over("rmse")?);
        }
        Ok(row)
    };
    let places = "rays that end right";
    let all = ["scene", "`ssct`", "`captures`", "`unified`", "floor", "`unified` / `ssct`", places];
    let head: Vec<_> = all.into_iter().filter(|h| is_mirror || !["floor", places].contains(h)).collect();
    table(&head, BEYOND.iter().map(row).collect::<Result<_>>()?)
}

/// `unified` with captures over `ssct` against the world, a scene a row and a roughness a column, beside what the floor is
/// of `ssct`; bold where the median misses the scene's aim.
pub fn gain(folders: &[PathBuf]) -> Result<String> {
    let row = |(scene, aim): &(&str, f64)| -> Result<Vec<String>> {
        let records = of_scene(folders, scene)?;
        let cell = |(roughness, allowed): (&&str, &f64)| {
            if by_view(&records, CAPTURED, roughness, "rmse").is_empty() {
                return Ok("–".to_owned());
            }
            let over = captured_over(&records, ALONE, roughness, "rmse")?;
            let (middle, most) = (median(&over)?, greatest(&over));
            let mark = if middle > aim + allowed { "**" } else { "" };
            Ok(format!("{mark}{}{mark} ({})", ratio(middle), ratio(most)))
        };
        let cells = ROUGHNESS.iter().zip(&ALLOWED).map(cell).collect::<Result<Vec<_>>>()?;
        let (floor, base) = (by_view(&records, ALONE, "0", "floor"), by_view(&records, ALONE, "0", "rmse"));
        let floors: Vec<f64> = floor.values().zip(base.values()).map(|(floor, base)| floor / base).collect();
        let first = [(*scene).to_owned(), median_and_greatest(&floors)?, format!("{aim}")];
        Ok(first.into_iter().chain(cells).collect())
    };
    let head = ["scene", "floor, ϱ 0", "aim", "ϱ 0", "0.05", "0.1", "0.3", "0.6"];
    table(&head, BEYOND.iter().map(row).collect::<Result<_>>()?)
}

/// `unified` with captures over `ssct` with each fallback against the world, at the roughness values that all have.
pub fn fallbacks(folders: &[PathBuf]) -> Result<String> {
    let columns = ["0", "0.1"].map(|r| ["none", "environment", "pccm"].map(|behind| (behind, r))).concat();
    let mut rows = Vec::new();
    for (scene, _) in BEYOND {
        let records = of_scene(folders, scene)?;
        let cell =
            |(behind, r): &(&str, &str)| median_and_greatest(&captured_over(&records, ("ssct", behind), r, "rmse")?);
        let cells = columns.iter().map(cell).collect::<Result<Vec<_>>>()?;
        rows.push([scene.to_owned()].into_iter().chain(cells).collect());
    }
    let all = |(behind, r): &(&str, &str)| median_and_greatest(&captured_over_in_all(folders, ("ssct", behind), r)?);
    let cells = columns.iter().map(all).collect::<Result<Vec<_>>>()?;
    rows.push(["*all views*".to_owned()].into_iter().chain(cells).collect());
    let head = [
        "scene",
        "error / `ssct`'s, ϱ 0",
        "/ `ssct` + `environment`",
        "/ `ssct` + `pccm`",
        "error / `ssct`'s, ϱ 0.1",
        "/ `ssct` + `environment`",
        "/ `ssct` + `pccm`",
    ];
    table(&head, rows)
}

/// On how many of all views `unified` with captures has more than so many times the error of `ssct` with a fallback.
pub fn views_above(folders: &[PathBuf], limit: &str, behind: &str, roughness: &str) -> Result<String> {
    let limit: f64 = limit.parse().map_err(|_| format!("{limit} is no number"))?;
    let over = captured_over_in_all(folders, ("ssct", behind), roughness)?;
    Ok(format!("{} of {}", over.iter().filter(|o| **o > limit).count(), over.len()))
}

/// The share of what mirrors show in a scene that the screen and so many captures see: median of its views.
pub fn seen(folder: &Path, scene: &str, captures: &str) -> Result<String> {
    let all = text(folder, "captures.txt")?;
    let row = |name: &str| all.lines().find_map(|l| l.strip_prefix(&format!("{scene},{name},"))).map(|l| l.split(','));
    let found =
        row("view").zip(row("median")).and_then(|(mut head, mut row)| row.nth(head.position(|n| n == captures)?));
    Ok(format!("{} %", found.ok_or_else(|| format!("nothing is said of {captures} captures of {scene}"))?))
}

/// What captures gain for mirrors, in short.
pub fn captures_headline(folders: &[PathBuf]) -> Result<String> {
    let row = |(scene, _): &(&str, f64)| -> Result<Vec<String>> {
        let records = of_scene(folders, scene)?;
        let over = |other| median_and_greatest(&captured_over(&records, other, "0", "rmse")?);
        let time = median_and_greatest(&times_over(folders, scene, "unified", "0")?)?;
        Ok(vec![(*scene).to_owned(), over(ALONE)?, over(("ssct", "pccm"))?, right_places(&records)?, time])
    };
    let head = [
        "scene",
        "error / `ssct`'s",
        "error / that of `ssct --fallback pccm`",
        "rays that end right",
        "time / `ssct`'s",
    ];
    table(&head, BEYOND.iter().map(row).collect::<Result<_>>()?)
}

/// The error of a method among the triangles over that of `ssct`, for each view of a scene.
fn errors_over_ssct(records: &[Value], scene: &str, method: &str, roughness: &str) -> Result<Vec<f64>> {
    let [own, base] = [(method, "none"), ALONE].map(|variant| by_view(records, variant, roughness, "rmse"));
    if own.is_empty() || own.keys().ne(base.keys()) {
        return Err(format!("{scene} at roughness {roughness}: not every view has {method} and ssct"));
    }
    Ok(own.values().zip(base.values()).map(|(a, b)| a / b).collect())
}

/// What the scene's triangles gain at each roughness: the error of `unified` over that of `ssct`.
pub fn triangles_by_roughness(folder: &Path) -> Result<String> {
    let folders = [folder.to_owned()];
    let row = |(scene, _): &(&str, f64)| -> Result<Vec<String>> {
        let records = of_scene(&folders, scene)?;
        let over = |roughness: &&str| median_and_greatest(&errors_over_ssct(&records, scene, "unified", roughness)?);
        let cells = ROUGHNESS.iter().map(over).collect::<Result<Vec<_>>>()?;
        Ok(std::iter::once((*scene).to_owned()).chain(cells).collect())
    };
    let head: Vec<String> = ROUGHNESS.iter().map(|roughness| format!("roughness {roughness}")).collect();
    let head: Vec<&str> = std::iter::once("scene").chain(head.iter().map(String::as_str)).collect();
    table(&head, BEYOND.iter().map(row).collect::<Result<_>>()?)
}

/// What the scene's triangles gain at a roughness: `unified` and `traced` over `ssct`, with the right places of mirrors.
pub fn triangles(folder: &Path, roughness: &str) -> Result<String> {
    let folders = [folder.to_owned()];
    let row = |(scene, _): &(&str, f64)| -> Result<Vec<String>> {
        let records = of_scene(&folders, scene)?;
        let over = |method: &str| median_and_greatest(&errors_over_ssct(&records, scene, method, roughness)?);
        let time = |method: &str| median_and_greatest(&times_over(&folders, scene, method, roughness)?);
        let mut row = vec![(*scene).to_owned(), over("unified")?, over("traced")?];
        // Lobes end in many places.
        if roughness == "0" {
            row.push(right_places(&records)?);
        }
        row.extend([time("unified")?, time("traced")?]);
        Ok(row)
    };
    let mut rows = BEYOND.iter().map(row).collect::<Result<Vec<_>>>()?;
    let all = |method: &str| -> Result<String> {
        let scene_times = |(scene, _): &(&str, f64)| times_over(&folders, scene, method, roughness);
        median_and_greatest(&BEYOND.iter().map(scene_times).collect::<Result<Vec<_>>>()?.concat())
    };
    let blank = if roughness == "0" { 3 } else { 2 };
    let mut last = vec!["*all views*".to_owned()];
    last.extend(vec!["–".to_owned(); blank]);
    last.extend([all("unified")?, all("traced")?]);
    rows.push(last);
    let head = [
        "scene",
        "`unified`: error / `ssct`'s",
        "`traced`: error / `ssct`'s",
        "rays that end right",
        "`unified`: time / `ssct`'s",
        "`traced`: time / `ssct`'s",
    ];
    let head: Vec<_> = head.into_iter().filter(|h| roughness == "0" || *h != "rays that end right").collect();
    table(&head, rows)
}

/// A table's figures of one view: of `unified` and `traced` the error over that of `ssct`, the share of `unified`'s mirror rays that
/// end right, and both times over that of `ssct`.
pub fn triangles_of_view(folder: &Path, scene: &str, view: &str) -> Result<[f64; 5]> {
    let folders = [folder.to_owned()];
    let records = of_scene(&folders, scene)?;
    let one = |values: &BTreeMap<String, f64>| values.get(view).copied().ok_or(format!("{scene} has no {view}"));
    let error = |variant| one(&by_view(&records, variant, "0", "rmse"));
    let time = |method| one(&times(&folders, scene, method, "0")?);
    let (error_of_ssct, time_of_ssct) = (error(ALONE)?, time(ALONE.0)?);
    Ok([
        error(("unified", "none"))? / error_of_ssct,
        error(("traced", "none"))? / error_of_ssct,
        one(&by_view(&records, CAPTURED, "0", "place_agreement"))?,
        time("unified")? / time_of_ssct,
        time("traced")? / time_of_ssct,
    ])
}
