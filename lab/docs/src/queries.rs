//! The queries of the pages: reads their declarations in `lab/docs/queries/`, and answers them from records.

use crate::devices;
use crate::evaluation::{Context, distinct};
use crate::expression::{Words, fill_variables, parse, parse_choice, read_word, split_outside_brackets};
use crate::records::{Library, Result, Rows};
use serde::Deserialize;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The variables of a query by name: its arguments, and the variables of its loops in the current round.
type Variables = BTreeMap<String, String>;

/// A declared query. It has an `answer`, the `rows` and `columns` of a table, or `rows` and `lines`.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Query {
    /// The files whose records the expressions read.
    from: String,
    /// The conditions on these records.
    r#where: String,
    /// The fields by which records are matched; `None` for those of [`BY`].
    by: Option<String>,
    /// The text of the answer, with expressions between braces.
    answer: Option<String>,
    /// The text of each row, if the rows are not those of a table.
    lines: Option<String>,
    /// The text between the texts of two rows; `None` for a line break.
    between: Option<String>,
    /// The text around the texts of all rows, in which `$lines` stands for them.
    frame: Option<String>,
    /// Loops, from the outer one to the inner one, that make the rows.
    rows: Vec<String>,
    /// An expression; a row is left out if it is 0 or its records are missing.
    when: Option<String>,
    /// A number by which rows are ordered, the greatest first.
    order: Option<String>,
    /// Each column: its caption, its cell, and loops that make several columns of it.
    columns: Vec<Vec<String>>,
    /// True if the table shows times alone, whatever its captions say.
    times: bool,
    /// The text under the table, instead of the sentence about devices and times.
    note: Option<String>,
    /// For a number of the README that no study of a device measures: its place there, and the command that measures
    /// it.
    pub(crate) readme: Option<[String; 2]>,
}

/// The fields by which records are matched, unless a query names others.
const BY: &str = "scene view roughness size";

/// All queries, with the records that they read.
#[derive(Debug, Default)]
pub struct Queries {
    /// The queries by name. Words of a name that begin with `$` are arguments.
    all: BTreeMap<String, Query>,
    /// The named expressions.
    words: Words,
    /// The values of variables that all queries have.
    constants: Variables,
    library: Library,
    /// The names of the queries that were asked for.
    asked: RefCell<BTreeSet<String>>,
}

impl Queries {
    /// Reads the queries of the repository whose root is `root`.
    pub fn read(root: &Path) -> std::result::Result<Self, String> {
        let folder = root.join("lab/docs/queries");
        let fails = |e: &dyn std::fmt::Display| format!("{}: {e}", folder.display());
        let mut queries = Self::default();
        for entry in fs::read_dir(&folder).map_err(|e| fails(&e))? {
            let path = entry.map_err(|e| fails(&e))?.path();
            let fails = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
            let text = fs::read_to_string(&path).map_err(|e| fails(&e))?;
            if path.ends_with("words.toml") {
                let words: BTreeMap<String, String> = toml::from_str(&text).map_err(|e| fails(&e))?;
                let (constants, words): (Vec<_>, Vec<_>) =
                    words.into_iter().partition(|(head, _)| head.starts_with('$'));
                queries.words = words.iter().map(|(head, body)| read_word(head, body)).collect();
                queries.constants = constants.into_iter().map(|(head, value)| (head[1..].to_owned(), value)).collect();
            } else {
                let read: BTreeMap<String, Query> = toml::from_str(&text).map_err(|e| fails(&e))?;
                queries.all.extend(read);
            }
        }
        Ok(queries)
    }

    /// Returns the query that a text such as "claim-error ssct hzct" calls, and its variables: the constants and the
    /// arguments. If the names of several queries fit, the one with the fewest arguments is called.
    pub(crate) fn find(&self, text: &str) -> Result<(&Query, Variables)> {
        let words: Vec<&str> = text.split(' ').collect();
        let fits = |name: &&String| {
            let parts: Vec<&str> = name.split(' ').collect();
            parts.len() == words.len()
                && parts.iter().zip(&words).all(|(part, word)| part.starts_with('$') || part == word)
        };
        let fixed_words = |name: &&String| name.split(' ').filter(|word| !word.starts_with('$')).count();
        let found = self.all.keys().filter(fits).max_by_key(fixed_words);
        let name = found.ok_or_else(|| format!("nothing is called {text:?}"))?;
        self.asked.borrow_mut().insert(name.clone());
        let mut variables = self.constants.clone();
        // An argument `a` is also there as `a~`, with blanks instead of underscores.
        for (name, word) in name.split(' ').zip(&words).filter_map(|(part, word)| Some((part.strip_prefix('$')?, word)))
        {
            variables.insert(format!("{name}~"), word.replace('_', " "));
            variables.insert(name.to_owned(), (*word).to_owned());
        }
        Ok((&self.all[name], variables))
    }

    /// Returns an error if there is a query that no page asked for.
    pub(crate) fn check_all_asked(&self) -> std::result::Result<(), String> {
        let asked = self.asked.borrow();
        let unasked = self.all.keys().find(|name| !asked.contains(*name));
        unasked.map_or(Ok(()), |name| Err(format!("no page asks for {name:?} of lab/docs/queries")))
    }

    /// Returns the text that pages show for a query about the records of some folders: an answer within a line, or
    /// lines or a table, which begin and end with a line break.
    pub fn answer(&self, text: &str, folders: &[PathBuf]) -> std::result::Result<String, String> {
        self.try_answer(text, folders).map_err(|failure| failure.words)
    }

    /// Returns the text of [`Self::answer`]. The failure says whether records are missing.
    fn try_answer(&self, text: &str, folders: &[PathBuf]) -> Result<String> {
        let (query, variables) = self.find(text)?;
        if let Some(answer) = &query.answer {
            return self.evaluate_text(query, answer, folders, &variables);
        }
        let Some(lines) = &query.lines else {
            let rows = self.table(text, folders)?;
            let line = |cells: &Vec<String>| format!("| {} |\n", cells.join(" | "));
            let rule = format!("|{}\n", "---|".repeat(rows[0].len()));
            let [head, rest] = [&rows[..1], &rows[1..]].map(|rows| rows.iter().map(line).collect::<String>());
            let note = devices::device_note(folders, &head, query.times, query.note.as_deref())?;
            return Ok(format!("\n{head}{rule}{rest}\n{note}\n"));
        };
        let rows = self.row_variables(query, folders, &variables)?;
        let lines =
            rows.iter().map(|row| self.evaluate_text(query, lines, folders, row)).collect::<Result<Vec<_>>>()?;
        let joined = lines.join(query.between.as_deref().unwrap_or("\n"));
        let frame = query.frame.as_deref().unwrap_or("$lines");
        Ok(format!("\n{}\n", frame.replace("$lines", &joined)))
    }

    /// Returns the records that a query's `from` and `where` choose, for its expressions; none if both are empty.
    fn records(&self, query: &Query, context: &Context, variables: &Variables) -> Result<Rows> {
        if query.from.is_empty() && query.r#where.is_empty() {
            return Ok(Rows::default());
        }
        let text =
            format!("{}:{}", fill_variables(&query.from, variables)?, fill_variables(&query.r#where, variables)?);
        // The text before the colon names the files, so that no rows are needed to choose from.
        context.choose(&parse_choice(&text)?, &Rc::default())
    }

    /// Returns the context in which the expressions of a query about some folders are evaluated.
    fn context<'a>(&'a self, query: &Query, folders: &'a [PathBuf]) -> Context<'a> {
        let by = query.by.as_deref().unwrap_or(BY).split(' ').map(str::to_owned).collect();
        Context { library: &self.library, folders, by }
    }

    /// Returns a text in which variables are replaced by their values, and expressions between braces by theirs.
    fn evaluate_text(&self, query: &Query, text: &str, folders: &[PathBuf], variables: &Variables) -> Result<String> {
        let text = fill_variables(text, variables)?;
        // Each part but the first begins with an expression.
        let mut parts = text.split('{');
        let mut written = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (expression, after) = part.split_once('}').ok_or_else(|| format!("{text:?} lacks a brace"))?;
            let context = self.context(query, folders);
            let rows = self.records(query, &context, variables)?;
            written += &context.evaluate(&parse(expression, &self.words)?, &rows)?.text()?;
            written += after;
        }
        Ok(written)
    }

    /// Returns the value of an expression, whose variables are replaced by their values first. Unlike in
    /// [`Self::evaluate_text`], the whole text is the expression, and its value is one number.
    fn evaluate_number(&self, query: &Query, text: &str, folders: &[PathBuf], variables: &Variables) -> Result<f64> {
        let context = self.context(query, folders);
        let rows = self.records(query, &context, variables)?;
        context.evaluate(&parse(&fill_variables(text, variables)?, &self.words)?, &rows)?.number()
    }

    /// Returns the variables of each round of nested loops, given from the outer loop to the inner one. `from` has the
    /// variables outside the loops, which the rounds have, too.
    fn rounds(&self, query: &Query, loops: &[String], folders: &[PathBuf], from: &Variables) -> Result<Vec<Variables>> {
        let [first, rest @ ..] = loops else { return Ok(vec![from.clone()]) };
        let mut rounds = Vec::new();
        for own_variables in self.loop_variables(query, &fill_variables(first, from)?, folders, from)? {
            let variables = from.clone().into_iter().chain(own_variables).collect();
            rounds.extend(self.rounds(query, rest, folders, &variables)?);
        }
        Ok(rounds)
    }

    /// Returns the own variables of a loop in each of its rounds. The loop `a b: 1|2; 3|4` has two variables and two
    /// rounds. `a b: distinct c d` has the values of two fields as they first appear in the records, and `sorted`
    /// instead of `distinct` has them in order. `each` has all fields of each record. A condition in brackets after
    /// these words chooses records.
    fn loop_variables(
        &self,
        query: &Query,
        text: &str,
        folders: &[PathBuf],
        from: &Variables,
    ) -> Result<Vec<Variables>> {
        let (names, values) = text.split_once(':').map_or((text, ""), |(names, values)| (names, values.trim_start()));
        let names: Vec<&str> = names.split(' ').collect();
        let context = self.context(query, folders);
        let chosen = |condition: &str| {
            let choice = parse_choice(condition.trim().trim_start_matches('[').trim_end_matches(']'))?;
            let is_elsewhere = choice.files.is_some();
            let rows = if is_elsewhere { Rc::default() } else { self.records(query, &context, from)? };
            context.choose(&choice, &rows)
        };
        if names[0] == "each" {
            let rows = chosen(text.trim_start_matches("each"))?;
            return Ok(rows.iter().map(|row| (**row).clone()).collect());
        }
        let is_sorted = values.starts_with("sorted ");
        // The values of the variables in each round.
        let tuples = match values.strip_prefix("distinct ").or(values.strip_prefix("sorted ")) {
            Some(rest) => {
                let (condition, fields) = rest.rsplit_once(']').unwrap_or(("", rest));
                let fields: Vec<String> = fields.split_whitespace().map(str::to_owned).collect();
                let mut found = distinct(&chosen(condition)?, &fields);
                if is_sorted {
                    found.sort();
                }
                found
            }
            // Rounds are separated by semicolons, or, in the value of an argument, by commas.
            None => {
                let separator = if values.contains(';') { ';' } else { ',' };
                let parts = |item: &str| {
                    split_outside_brackets(item, '|').into_iter().map(|part| part.trim().to_owned()).collect()
                };
                split_outside_brackets(values, separator).into_iter().map(parts).collect()
            }
        };
        let named = |values: Vec<String>| {
            if values.len() == names.len() {
                Ok(names.iter().map(|name| (*name).to_owned()).zip(values).collect())
            } else {
                Err(format!("{} values for {}", values.len(), names.join(" ")).into())
            }
        };
        tuples.into_iter().map(named).collect()
    }

    /// Returns the variables of each row of a query: of the rounds that its `when` keeps, in its order. The variable
    /// `$nth` numbers the rows from 0.
    fn row_variables(&self, query: &Query, folders: &[PathBuf], variables: &Variables) -> Result<Vec<Variables>> {
        // The variables of each row, with the number by which it is ordered.
        let mut rows = Vec::new();
        for round in self.rounds(query, &query.rows, folders, variables)? {
            let number = |text: &Option<String>| {
                text.as_ref().map(|text| self.evaluate_number(query, text, folders, &round)).transpose()
            };
            match number(&query.when) {
                Ok(Some(0.0)) => {}
                Ok(_) => rows.push((number(&query.order)?.unwrap_or_default(), round)),
                Err(failure) if failure.is_missing => {}
                Err(failure) => return Err(failure),
            }
        }
        if rows.is_empty() {
            return Err("the table would be empty".into());
        }
        rows.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let numbered = |(nth, (_, mut round)): (usize, (f64, Variables))| {
            round.insert("nth".to_owned(), nth.to_string());
            round
        };
        Ok(rows.into_iter().enumerate().map(numbered).collect())
    }

    /// Returns the table of the query that a text calls: rows of cells, the first of which has the captions.
    pub(crate) fn table(&self, text: &str, folders: &[PathBuf]) -> Result<Vec<Vec<String>>> {
        let (query, mut variables) = self.find(text)?;
        // `$kind1`, `$kind2`, … are the kinds of device of the folders.
        for (n, folder) in folders.iter().enumerate() {
            variables.insert(format!("kind{}", n + 1), devices::device_kind(folder).unwrap_or_default().to_owned());
        }
        let (mut captions, mut rows) = (Vec::new(), Vec::new());
        for round in self.row_variables(query, folders, &variables)? {
            let mut cells = Vec::new();
            captions.clear();
            for column in &query.columns {
                let [caption, cell, loops @ ..] = &column[..] else { return Err("a column lacks its cell".into()) };
                for round in self.rounds(query, loops, folders, &round)? {
                    captions.push(fill_variables(caption, &round)?);
                    cells.push(self.evaluate_text(query, cell, folders, &round)?);
                }
            }
            rows.push(cells);
        }
        rows.insert(0, captions);
        Ok(rows)
    }
}
