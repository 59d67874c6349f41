//! Single numbers of the table that holds the documents' claims against measurements.

use super::captions;
use super::figures::{
    Result, csv, figures, greatest, json, least, mean, median, median_and_range, number, percent, ratio,
};
use super::records::plain_errors;
use super::thesis;
use std::path::{Path, PathBuf};

/// Ratios of one method's values to another's, view by view.
pub fn ratios(own: &[f64], other: &[f64]) -> Result<Vec<f64>> {
    if own.len() != other.len() {
        return Err(format!("{} values beside {}", own.len(), other.len()));
    }
    Ok(own.iter().zip(other).map(|(a, b)| a / b).collect())
}

/// Median over the views of what a method has over what another has.
fn over(own: &[f64], other: &[f64]) -> Result<String> {
    median(&ratios(own, other)?).map(ratio)
}

/// The time of a method over another's at a roughness, on the same frames: median over the views, and the least and the greatest.
pub fn time(folder: &Path, [method, other, roughness]: [&str; 3]) -> Result<String> {
    let records = plain_errors(folder)?;
    let times = |method: &str| figures(&records, method, "world", roughness, "time_ms");
    median_and_range(&ratios(&times(method), &times(other))?)
}

/// A figure of a method under small motions of the camera, `ratio` or `deviation`: median over the views and motions.
pub fn motion(folder: &Path, [field, method, roughness]: [&str; 3]) -> Result<String> {
    let rows = csv(folder, "motion.csv")?;
    let own = rows.iter().filter(|r| r["method"] == method && r["roughness"] == roughness);
    median(&own.map(|r| number(r, field)).collect::<Result<Vec<_>>>()?).map(ratio)
}

/// The RMSE of a method over another's, against a reference at a roughness.
pub fn error(folder: &Path, [method, other, against, roughness]: [&str; 4]) -> Result<String> {
    let records = plain_errors(folder)?;
    let errors = |method: &str| figures(&records, method, against, roughness, "rmse");
    over(&errors(method), &errors(other))
}

/// The RMSE of a method in one run over that in another, against a reference at a roughness: median over the views.
pub fn error_between(folders: &[PathBuf], [method, against, roughness]: [&str; 3]) -> Result<String> {
    let [run, other] = folders else { return Err("two runs are compared".to_owned()) };
    let errors = |folder: &Path| {
        let records = json(folder, "error.json")?;
        Ok::<_, String>(figures(&records, method, against, roughness, "rmse"))
    };
    over(&errors(run)?, &errors(other)?)
}

/// A share of the hits of a method's mirrors: `hit_agreement`, `false`, `missed` or `displaced`, mean over the views.
pub fn hits(folder: &Path, [share, method]: [&str; 2]) -> Result<String> {
    let records = plain_errors(folder)?;
    mean(&figures(&records, method, "oracle", "0", share)).map(|share| percent(share, 1))
}

/// The time of what stands beside SSCT in a figure, over SSCT's, as measured here.
pub fn caption(folder: &Path, figure: &str) -> Result<String> {
    let rows = captions::rows(folder)?;
    let row = rows.iter().find(|r| r[0] == figure).ok_or(format!("no figure {figure}"))?;
    row.last().cloned().ok_or_else(|| "an empty row".to_owned())
}

/// The column of a method in table 5.8.
fn column(method: &str, columns: &[(&str, usize)]) -> Result<usize> {
    let found = columns.iter().find(|(name, _)| *name == method);
    found.map(|(_, column)| *column).ok_or_else(|| format!("table 5.8 has no {method}"))
}

/// A column of table 5.8, as measured here: a method's times over SSCT's at a roughness, from the least to the greatest.
pub fn table_5_8(folder: &Path, [method, roughness]: [&str; 2]) -> Result<String> {
    let column = column(method, &[("hzct", 9), ("sslr", 11)])?;
    range(thesis::rows_5_8(folder)?.iter().filter(|r| r[1] == roughness).map(|r| r[column].as_str()))
}

/// A method's time over SSCT's in table 5.8 at a size, as measured here.
pub fn table_5_8_at(folder: &Path, [method, roughness, size]: [&str; 3]) -> Result<String> {
    let column = column(method, &[("hzct", 9), ("sslr", 11)])?;
    let rows = thesis::rows_5_8(folder)?;
    let row = rows.iter().find(|r| r[0] == size.replace('x', "×") && r[1] == roughness);
    Ok(row.ok_or(format!("no {size} at {roughness}"))?[column].clone())
}

/// A method's time in table 5.8 at a size and a roughness.
fn time_5_8(rows: &[Vec<String>], method: &str, size: &str, roughness: &str) -> Result<f64> {
    let column = column(method, &[("ssct", 3), ("hzct", 5), ("sslr", 7)])?;
    let row = rows.iter().find(|r| r[0] == size && r[1] == roughness).ok_or(format!("no {size} at {roughness}"))?;
    row[column].parse().map_err(|e| format!("table 5.8, {method}, {size}, roughness {roughness}: {e}"))
}

/// A method's time at the greatest size of table 5.8 over that at the least one, which has 6.75 times fewer pixels.
pub fn pixels(folder: &Path, [method, roughness]: [&str; 2]) -> Result<String> {
    let rows = thesis::rows_5_8(folder)?;
    let time = |size| time_5_8(&rows, method, size, roughness);
    Ok(ratio(time("1920×1080")? / time("640×480")?))
}

/// Times at roughness 0.1 over those of mirrors in table 5.8, as measured here.
pub fn rougher(folder: &Path, method: &str) -> Result<String> {
    let rows = thesis::rows_5_8(folder)?;
    let time = |roughness, size| time_5_8(&rows, method, size, roughness);
    let mirrors = rows.iter().filter(|r| r[1] == "0.0");
    let ratios = mirrors.map(|r| Ok(ratio(time("0.1", &r[0])? / time("0.0", &r[0])?))).collect::<Result<Vec<_>>>()?;
    range(ratios.iter().map(String::as_str))
}

/// By how much the time of `ssr` over another method's grows from 1024×768 to a size, on the ways through the scenes.
pub fn scaling(folder: &Path, [method, size]: [&str; 2]) -> Result<String> {
    let size = captions::size(size)?;
    let growth = ["street", "museum", "cathedral"].map(|scene| {
        let records = json(&folder.join(scene), "path.json")?;
        let milliseconds =
            |size| captions::over(&records, method, size, "effect_ms")?.ok_or(format!("no {method} in {scene}"));
        Ok(ratio(milliseconds(size)? / milliseconds([1024, 768])?))
    });
    let growth = growth.into_iter().collect::<Result<Vec<_>>>()?;
    range(growth.iter().map(String::as_str))
}

/// The least and the greatest of some numbers.
fn range<'a>(numbers: impl Iterator<Item = &'a str>) -> Result<String> {
    let numbers = numbers.map(|n| n.parse::<f64>().map_err(|e| format!("{n}: {e}"))).collect::<Result<Vec<_>>>()?;
    median(&numbers)?;
    Ok(format!("{:.2} to {:.2}", least(&numbers), greatest(&numbers)))
}
