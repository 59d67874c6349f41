//! Tables as text: for a terminal, and as Markdown.

use crate::study::exhibit::Table;
use crate::study::names::{markdown_cell, one_line};
use std::borrow::Cow;

/// Rows of cells, each column as wide as its widest cell; the first is aligned left, others right.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<Cow<str>>> = rows.iter().map(|row| row.iter().map(|cell| one_line(cell)).collect()).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        let cells: Vec<String> = row
            .iter()
            .enumerate()
            .map(|(c, s)| if c == 0 { format!("{s:<w$}", w = widths[c]) } else { format!("{s:>w$}", w = widths[c]) })
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// Tables for a terminal, each under its title; those that are too large for one are left out.
pub fn text(tables: &[Table]) -> String {
    let of = |table: &Table| {
        let title = if table.title.is_empty() { String::new() } else { format!("{}\n", one_line(&table.title)) };
        title + &aligned(&table.cells)
    };
    for_terminal(tables).map(of).collect::<Vec<_>>().join("\n")
}

/// The tables that are not too large.
fn for_terminal(tables: &[Table]) -> impl Iterator<Item = &Table> {
    tables.iter().filter(|table| !table.is_large)
}

/// Tables as Markdown, each under its title.
pub fn markdown(tables: &[Table]) -> String {
    let row = |cells: &Vec<String>| {
        let cells: Vec<String> = cells.iter().map(|cell| markdown_cell(cell)).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let of = |table: &Table| {
        let Some((header, rows)) = table.cells.split_first() else { return String::new() };
        let title =
            if table.title.is_empty() { String::new() } else { format!("**{}**\n\n", markdown_cell(&table.title)) };
        let rule = format!("|---|{}\n", "--:|".repeat(header.len().saturating_sub(1)));
        title + &row(header) + &rule + &rows.iter().map(row).collect::<String>()
    };
    for_terminal(tables).map(of).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = [["a", "bb"], ["ccc", "d"]].map(|r| r.map(str::to_owned).to_vec());
        assert_eq!(aligned(&rows), "a    bb\nccc   d\n");
        let table = Table { id: "t", title: "T".to_owned(), cells: rows.to_vec(), ..Table::default() };
        assert_eq!(text(std::slice::from_ref(&table)), "T\na    bb\nccc   d\n");
        assert_eq!(markdown(&[table]), "**T**\n\n| a | bb |\n|---|--:|\n| ccc | d |\n");
    }
}
