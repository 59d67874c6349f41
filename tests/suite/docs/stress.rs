//! Tables and numbers of the stress study.

use super::figures::{Result, Row, csv, grouped, number, percent, table};
use std::path::Path;

/// Cases of the stress suite by method, in the order of the records.
fn rows_of(folder: &Path) -> Result<Vec<(String, Vec<Row>)>> {
    let mut methods: Vec<(String, Vec<Row>)> = Vec::new();
    for row in csv(folder, "stress.csv")? {
        let name = row["method"].clone();
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
    let of = all.iter().find(|(m, _)| m == method);
    of.map(|(_, rows)| rows.len().to_string()).ok_or_else(|| format!("no {method}"))
}

/// How many hits of a method were compared with the oracle, and how many of them are not its.
pub fn hits(folder: &Path, method: &str) -> Result<(String, String)> {
    let all = rows_of(folder)?;
    let (_, rows) = all.iter().find(|(m, _)| m == method).ok_or_else(|| format!("no {method}"))?;
    let (all, wrong) = compared(rows)?;
    Ok((grouped(all), grouped(wrong)))
}
