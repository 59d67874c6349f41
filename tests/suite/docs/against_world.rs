//! Every method against the world, by records of scripts/beyond.sh with VARIANTS: its table, and what the plot shows.

use super::figures::{Result, Row, csv, median, median_and_greatest, number, shortest, table};
use std::collections::BTreeMap;
use std::path::Path;

/// How two times of one frame may differ although the same passes were recorded.
const REPEATS_WITHIN: f64 = 0.02;

/// What a ray of a method can go on in where the screen loses it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    Nothing,
    Captures,
    Triangles,
}

/// A method with what stands behind it, on one view at one roughness.
#[derive(Debug)]
struct Measured {
    scene: String,
    roughness: String,
    name: String,
    /// Time and error, over those of `ssct` on the same view.
    over_ssct: [f64; 2],
}

/// A method in the plot: medians over the views of its time and of its error, over those of `ssct`.
#[derive(Debug, Clone)]
pub struct Point {
    pub name: String,
    pub beyond: Beyond,
    /// Time and error, over those of `ssct`.
    pub ratios: [f64; 2],
}

/// What pages call a method with its options.
fn name(row: &Row) -> String {
    let [method, beyond, fallback, captures] =
        ["method", "beyond", "fallback", "captures"].map(|field| row.get(field).map_or("", String::as_str));
    let alone = if beyond == "none" { ", screen alone" } else { "" };
    let behind = if fallback == "none" { String::new() } else { format!(" + {fallback}") };
    let captured = if captures == "none" { String::new() } else { format!(", {captures} captures") };
    format!("{method}{alone}{behind}{captured}")
}

fn beyond(name: &str) -> Beyond {
    match name {
        "unified" | "traced" => Beyond::Triangles,
        name if name.ends_with(" captures") => Beyond::Captures,
        _ => Beyond::Nothing,
    }
}

/// The error without what the reference's own noise adds.
fn error(row: &Row) -> Result<f64> {
    Ok((number(row, "rmse")?.powi(2) - number(row, "standard_error")?.powi(2)).max(0.0).sqrt())
}

type Cell = (String, String, String, String);

fn by_cell(rows: &[Row], figure: impl Fn(&Row) -> Result<f64>) -> Result<BTreeMap<Cell, f64>> {
    let cell = |row: &Row| (row["scene"].clone(), row["view"].clone(), row["roughness"].clone(), name(row));
    rows.iter().map(|row| Ok((cell(row), figure(row)?))).collect()
}

/// Everything that has both a time and an error.
fn measured(folder: &Path) -> Result<Vec<Measured>> {
    measured_over(folder, "ssct")
}

/// Reads the records with times over those of a method, and errors over those of `ssct`.
fn measured_over(folder: &Path, timed: &str) -> Result<Vec<Measured>> {
    let times = by_cell(&csv(folder, "times.csv")?, |row| number(row, "median_ms"))?;
    let errors = by_cell(&csv(folder, "errors.csv")?, error)?;
    let mut all = Vec::new();
    for (cell, time) in &times {
        let Some(error) = errors.get(cell) else { continue };
        let (scene, view, roughness, name) = cell.clone();
        let base = |name: &str| (scene.clone(), view.clone(), roughness.clone(), name.to_owned());
        let (Some(base_time), Some(base_error)) = (times.get(&base(timed)), errors.get(&base("ssct"))) else {
            return Err(format!("{cell:?} has no {timed} and no ssct beside it"));
        };
        all.push(Measured { scene, roughness, name, over_ssct: [time / base_time, error / base_error] });
    }
    Ok(all)
}

/// The names of the methods in the order of their errors, greatest first, at the first roughness.
fn names(all: &[Measured]) -> Result<Vec<String>> {
    let first = all.iter().map(|m| &m.roughness).min().ok_or("nothing was measured")?;
    let mut errors: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for m in all.iter().filter(|m| m.roughness == *first) {
        errors.entry(&m.name).or_default().push(m.over_ssct[1]);
    }
    let mut order =
        errors.into_iter().map(|(name, e)| Ok((median(&e)?, name.to_owned()))).collect::<Result<Vec<_>>>()?;
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(order.into_iter().map(|(_, name)| name).collect())
}

fn views_of<'a>(all: &'a [Measured], name: &'a str, roughness: &'a str) -> impl Iterator<Item = &'a Measured> {
    all.iter().filter(move |m| m.name == name && m.roughness == roughness)
}

/// The points of the plot at a roughness.
pub fn points(folder: &Path, roughness: &str) -> Result<Vec<Point>> {
    let all = measured(folder)?;
    let point = |name: String| {
        let median_of =
            |i: usize| median(&views_of(&all, &name, roughness).map(|m| m.over_ssct[i]).collect::<Vec<_>>());
        Ok(Point { ratios: [median_of(0)?, median_of(1)?], beyond: beyond(&name), name })
    };
    names(&all)?.into_iter().map(point).collect()
}

/// The shader stage in which a GPU traces the rays of a method and looks up what stands behind it, where its passes are as
/// published; `None` if it does the two in different stages.
fn stage_on_a_gpu(name: &str) -> Option<&'static str> {
    let is_compute = ["captures", "traced", "unified"].iter().any(|method| name.starts_with(method));
    match (is_compute, name.contains(" + ")) {
        (true, true) => None,
        (true, false) => Some("compute"),
        (false, _) => Some("fragment"),
    }
}

/// Time and error of each method that a GPU runs in a stage: median over the views, and in brackets the greatest. Errors are over
/// those of `ssct`; times are over those of a method of the stage, `ssct` or `unified` on the screen alone.
pub fn methods(folder: &Path, stage: &str) -> Result<String> {
    let base = if stage == "compute" { "unified, screen alone" } else { "ssct" };
    let mut all = measured_over(folder, base)?;
    all.retain(|m| stage_on_a_gpu(&m.name) == Some(stage));
    let mut roughness: Vec<&str> = all.iter().map(|m| m.roughness.as_str()).collect();
    roughness.sort_unstable();
    roughness.dedup();
    let mut head = vec!["method".to_owned()];
    for r in &roughness {
        head.extend(["time", "error"].map(|figure| format!("{}: {figure}", shortest(r))));
    }
    let row = |name: String| {
        let mut cells = vec![name.clone()];
        for r in &roughness {
            for i in 0..2 {
                cells.push(median_and_greatest(&views_of(&all, &name, r).map(|m| m.over_ssct[i]).collect::<Vec<_>>())?);
            }
        }
        Ok(cells)
    };
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    table(&head, names(&all)?.into_iter().map(row).collect::<Result<_>>()?)
}

/// In how many cases, a scene at a roughness, another method is both faster than this one and nearer to the world, by medians
/// over the scene's views and by more than what times of the same passes differ by.
pub fn beaten(folder: &Path, method: &str) -> Result<String> {
    let all = measured(folder)?;
    type ByMethod<'a> = BTreeMap<&'a str, [Vec<f64>; 2]>;
    let mut cases: BTreeMap<[&str; 2], ByMethod> = BTreeMap::new();
    for m in &all {
        let ratios = cases.entry([&m.scene, &m.roughness]).or_default().entry(&m.name).or_default();
        ratios[0].push(m.over_ssct[0]);
        ratios[1].push(m.over_ssct[1]);
    }
    let mut beaten = 0;
    for methods in cases.values() {
        let medians = |[time, error]: &[Vec<f64>; 2]| Ok::<_, String>([median(time)?, median(error)?]);
        let own = medians(methods.get(method).ok_or_else(|| format!("not every scene has {method}"))?)?;
        let others = methods.values().map(medians).collect::<Result<Vec<_>>>()?;
        let least = 1.0 - REPEATS_WITHIN;
        beaten += usize::from(others.iter().any(|o| o[0] < least * own[0] && o[1] < least * own[1]));
    }
    Ok(format!("{beaten} of {}", cases.len()))
}

/// The error of a method over that of `ssct` in each scene at each roughness: median over its views, and in brackets the greatest.
pub fn errors_of(folder: &Path, method: &str) -> Result<String> {
    let all = measured(folder)?;
    let mut scenes: BTreeMap<&str, BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
    for m in all.iter().filter(|m| m.name == method) {
        scenes.entry(&m.scene).or_default().entry(&m.roughness).or_default().push(m.over_ssct[1]);
    }
    let roughness: Vec<&str> = scenes.values().next().ok_or("nothing was measured")?.keys().copied().collect();
    let head: Vec<String> =
        std::iter::once("scene".to_owned()).chain(roughness.iter().map(|r| format!("at {}", shortest(r)))).collect();
    let row = |(scene, by): (&&str, &BTreeMap<&str, Vec<f64>>)| {
        let cells = by.values().map(|e| median_and_greatest(e));
        std::iter::once(Ok((*scene).to_owned())).chain(cells).collect::<Result<Vec<_>>>()
    };
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    table(&head, scenes.iter().map(row).collect::<Result<_>>()?)
}

/// The time of a method over that of `ssct` at a roughness: median over the views, and in brackets the greatest.
pub fn time_over(folder: &Path, method: &str, roughness: &str) -> Result<String> {
    let wanted: f64 = roughness.parse().map_err(|_| format!("{roughness} is no number"))?;
    let mut over = Vec::new();
    let times = by_cell(&csv(folder, "times.csv")?, |row| number(row, "median_ms"))?;
    for ((scene, view, cell_roughness, name), time) in &times {
        if name == method && cell_roughness.parse::<f64>().is_ok_and(|value| (value - wanted).abs() < 1e-6) {
            let base = (scene.clone(), view.clone(), cell_roughness.clone(), "ssct".to_owned());
            over.push(time / times.get(&base).ok_or_else(|| format!("{scene} {view} has no ssct"))?);
        }
    }
    median_and_greatest(&over)
}
