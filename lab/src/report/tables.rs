//! Tables as text: for a terminal, and as Markdown.

use crate::study::exhibit::Table;
use crate::study::names::{markdown_cell, one_line};
use std::borrow::Cow;

/// Returns rows of cells as text, with each column as wide as its widest cell. The first column is aligned left, the
/// others right.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<Cow<str>>> = rows.iter().map(|row| row.iter().map(|cell| one_line(cell)).collect()).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
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

/// Columns of a terminal that has room for tables.
pub const COLUMNS: usize = 100;

/// Returns a name and a sentence about it, wrapped to lines of at most [`COLUMNS`] characters, if no word is longer. In
/// each line the sentence begins at the column `column`, counted from 0.
pub fn wrapped(name: &str, column: usize, sentence: &str) -> String {
    let mut text = format!("{name:<column$}");
    let mut end = column;
    for (n, word) in one_line(sentence).split(' ').enumerate() {
        let width = word.chars().count();
        if n > 0 && end + 1 + width > COLUMNS {
            text.push_str(&format!("\n{:column$}", ""));
            end = column;
        } else if n > 0 {
            text.push(' ');
            end += 1;
        }
        text.push_str(word);
        end += width;
    }
    text + "\n"
}

/// Returns a table of sentences as text. The first cell of a row is its title, and each other cell is a paragraph
/// below, after the name of its column.
fn paragraphs(table: &Table) -> String {
    const INDENT: usize = 2;
    let Some((header, rows)) = table.cells.split_first() else { return String::new() };
    let longest = header.iter().skip(1).map(|name| name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for row in rows {
        text += &row.first().map_or_else(String::new, |first| wrapped("", 0, first));
        let cells = header.iter().zip(row).skip(1);
        text.extend(cells.map(|(name, cell)| wrapped(&format!("  {name}"), longest + 2 * INDENT, cell)));
    }
    text
}

/// Returns tables as text for a terminal, each below its title and the text about it. Tables that are too large for a
/// terminal are left out.
pub fn text(tables: &[Table]) -> String {
    let shown = |table: &Table| {
        let title = if table.title.is_empty() { String::new() } else { format!("{}\n", one_line(&table.title)) };
        let about = if table.about.is_empty() { String::new() } else { wrapped("", 0, &table.about) };
        title + &about + &if table.is_prose { paragraphs(table) } else { aligned(&table.cells) }
    };
    for_terminal(tables).map(shown).collect::<Vec<_>>().join("\n")
}

/// The tables that are not too large for a terminal.
fn for_terminal(tables: &[Table]) -> impl Iterator<Item = &Table> {
    tables.iter().filter(|table| !table.is_large)
}

/// Returns tables as Markdown, each under its title. Tables that are too large for a terminal are left out.
pub fn markdown(tables: &[Table]) -> String {
    let row = |cells: &Vec<String>| {
        let cells: Vec<String> = cells.iter().map(|cell| markdown_cell(cell)).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let table_text = |table: &Table| {
        let Some((header, rows)) = table.cells.split_first() else { return String::new() };
        let title =
            if table.title.is_empty() { String::new() } else { format!("**{}**\n\n", markdown_cell(&table.title)) };
        let rule = format!("|---|{}\n", "--:|".repeat(header.len().saturating_sub(1)));
        title + &row(header) + &rule + &rows.iter().map(row).collect::<String>()
    };
    for_terminal(tables).map(table_text).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_wrapped_and_names_have_a_column_of_their_own() {
        assert_eq!(wrapped("walk", 6, "3 steps"), "walk  3 steps\n");
        assert_eq!(wrapped("", 0, "It is."), "It is.\n");
        assert_eq!(wrapped("", 0, "two\nlines").lines().count(), 1, "a name with a line feed breaks no line");
        let cells =
            [["case", "said", "number"], ["poles", &"word ".repeat(60), "%"]].map(|r| r.map(str::to_owned).to_vec());
        let table = Table::of_sentences("t", "T", &"about ".repeat(40), cells.to_vec());
        let text = text(std::slice::from_ref(&table));
        assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{text}");
        let from = text.lines().position(|line| line == "poles").expect("the row's name");
        let said: Vec<_> = text.lines().skip(from + 1).collect();
        assert!(said[0].starts_with("  said    word") && said[1].starts_with("          word"), "{text}");
        assert_eq!(said.last(), Some(&"  number  %"), "{text}");
    }

    #[test]
    fn the_first_column_is_aligned_left_and_the_others_right() {
        let rows = [["a", "bb"], ["ccc", "d"]].map(|r| r.map(str::to_owned).to_vec());
        assert_eq!(aligned(&rows), "a    bb\nccc   d\n");
        let table = Table { id: "t", title: "T".to_owned(), cells: rows.to_vec(), ..Table::default() };
        assert_eq!(text(std::slice::from_ref(&table)), "T\na    bb\nccc   d\n");
        assert_eq!(markdown(&[table]), "**T**\n\n| a | bb |\n|---|--:|\n| ccc | d |\n");
    }
}
