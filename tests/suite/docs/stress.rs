//! Tables and numbers of the stress study.

use super::figures::{Result, Row, csv, grouped, number, percent, table};
use super::visible::{lacks, scene_of};
use std::path::Path;

/// Cases of the stress suite by method, in the order of the records. Where a method lacks what it needs in the scene of a case, it
/// passed by showing nothing, which is no case.
fn rows_of(folder: &Path) -> Result<Vec<(String, Vec<Row>)>> {
    let mut methods: Vec<(String, Vec<Row>)> = Vec::new();
    for row in csv(folder, "stress.csv")? {
        let name = row["method"].clone();
        if scene_of(None, Some(row["case"].as_str())).is_some_and(|scene| lacks(scene, &name)) {
            continue;
        }
        match methods.iter_mut().find(|(m, _)| *m == name) {
            Some((_, rows)) => rows.push(row),
            None => methods.push((name, vec![row])),
        }
    }
    Ok(methods)
}

fn count(row: &Row, field: &str) -> u64 {
    row.get(field).and_then(|v| v.parse().ok()).unwrap_or(0)
}

/// Hits that were compared, and those that are not the oracle's.
fn compared(rows: &[Row]) -> Result<(u64, u64)> {
    let (mut all, mut wrong) = (0, 0);
    for row in rows.iter().filter(|r| !r["hit_agreement"].is_empty()) {
        let n = count(row, "compared");
        all += n;
        wrong += n - (number(row, "hit_agreement")? * n as f64).round() as u64;
    }
    Ok((all, wrong))
}

/// How the cases of each method ended.
pub fn stress(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (method, cases) in rows_of(folder)? {
        let passed = cases.iter().filter(|r| r["pass"].eq_ignore_ascii_case("true")).count();
        let bad = ["nan", "inf", "negative", "exhausted"]
            .map(|field| cases.iter().filter(|r| count(r, field) > 0).count().to_string());
        let (all, wrong) = compared(&cases)?;
        let right = if all == 0 { "–".to_owned() } else { percent(1.0 - wrong as f64 / all as f64, 2) };
        let head = [format!("`{method}`"), cases.len().to_string(), passed.to_string()];
        rows.push(head.into_iter().chain(bad).chain([right]).collect());
    }
    table(&["method", "cases", "passed", "with NaN", "infinite", "negative", "exhausted", "right hits"], rows)
}

/// How many cases a method has.
pub fn cases(folder: &Path, method: &str) -> Result<String> {
    let all = rows_of(folder)?;
    let found = all.iter().find(|(m, _)| m == method);
    found.map(|(_, rows)| rows.len().to_string()).ok_or_else(|| format!("no {method}"))
}

/// How many hits of a method were compared with the oracle, and how many of them are not its.
pub fn hits(folder: &Path, method: &str) -> Result<(String, String)> {
    let all = rows_of(folder)?;
    let (_, rows) = all.iter().find(|(m, _)| m == method).ok_or_else(|| format!("no {method}"))?;
    let (all, wrong) = compared(rows)?;
    Ok((grouped(all), grouped(wrong)))
}

/// The share of a case's hits that are the oracle's.
pub fn case(folder: &Path, method: &str, case: &str) -> Result<String> {
    let all = csv(folder, "stress.csv")?;
    let named = case.replace('_', " ");
    let own: Vec<_> = all.iter().filter(|r| r["method"] == method && r["case"] == named).collect();
    let [row] = own[..] else { return Err(format!("{} cases of {method} are called {named:?}", own.len())) };
    number(row, "hit_agreement").map(|share| percent(share, 0))
}

/// How many cases of a method passed.
pub fn passed(folder: &Path, method: &str) -> Result<String> {
    let all = csv(folder, "stress.csv")?;
    Ok(all.iter().filter(|r| r["method"] == method && r["pass"].eq_ignore_ascii_case("true")).count().to_string())
}

/// The greatest share of a case's hits that are not the oracle's.
pub fn most_wrong(folder: &Path, method: &str) -> Result<String> {
    let all = csv(folder, "stress.csv")?;
    let own = all.iter().filter(|r| r["method"] == method && !r["hit_agreement"].is_empty());
    let shares = own.map(|r| number(r, "hit_agreement")).collect::<Result<Vec<_>>>()?;
    Ok(percent(1.0 - shares.into_iter().fold(1.0, f64::min), 2))
}
