//! The table of what engines' users complain of.

use super::figures::{Result, Row, csv, table};
use std::path::Path;

/// A row for each complaint, with what is good and the number of each method; good ones are printed in bold.
pub fn complaints(folder: &Path) -> Result<String> {
    let rows = csv(folder, "complaints.csv")?;
    let names = |field: &str| {
        let mut all: Vec<String> = Vec::new();
        for row in &rows {
            if !all.contains(&row[field]) {
                all.push(row[field].clone());
            }
        }
        all
    };
    let methods = names("method");
    let line = |case: String| {
        let here: Vec<&Row> = rows.iter().filter(|row| row["case"] == case).collect();
        let [first, ..] = here[..] else { return Err(format!("no row of {case}")) };
        let number =
            |method: &String| here.iter().find(|row| row["method"] == *method).map_or("–".to_owned(), |r| shown(r));
        let head = [format!("{case}: {}", first["measured"]), first["at_most"].clone()];
        Ok(head.into_iter().chain(methods.iter().map(number)).collect())
    };
    let titles: Vec<String> = methods.iter().map(|method| titled(method)).collect();
    let head: Vec<&str> = ["number", "good up to"].into_iter().chain(titles.iter().map(String::as_str)).collect();
    table(&head, names("case").into_iter().map(line).collect::<Result<_>>()?)
}

/// A method, whose name is code and what follows behind a comma is not.
fn titled(method: &str) -> String {
    let (name, more) = method.split_once(',').unwrap_or((method, ""));
    let more = if more.is_empty() { String::new() } else { format!(",{more}") };
    format!("`{name}`{more}")
}

fn shown(row: &Row) -> String {
    match row["value"].parse::<f64>() {
        Ok(value) if row["is_good"] == "yes" => format!("**{value:.1}**"),
        Ok(value) => format!("{value:.1}"),
        Err(_) => "–".to_owned(),
    }
}

/// The number of a case's method.
pub fn complaint(folder: &Path, case: &str, method: &str) -> Result<String> {
    let rows = csv(folder, "complaints.csv")?;
    let named = |name: &str| name.replace('_', " ");
    let is_it = |row: &&Row| row["case"] == named(case) && row["method"] == named(method);
    let row = rows.iter().find(is_it).ok_or_else(|| format!("no {method} in {case}"))?;
    row["value"].parse::<f64>().map(|value| format!("{value:.1}")).map_err(|_| "has no number".to_owned())
}
