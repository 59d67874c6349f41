//! Takes the keys of a map's sections one by one. An error about a key has the key's line. Once all known keys of a
//! section were taken, the keys that are left are unknown.

use super::files::AttributeName;
use super::numbers::{MapNumbers, NumbersFrom};
use crate::source_text::SourceText;
use ssct_ground::{Error, Result};
use std::collections::BTreeMap;
use toml::{Spanned, Value};

/// A section as parsed from TOML.
pub(super) type MapSection = Spanned<BTreeMap<String, Spanned<Value>>>;

/// The keys of a section that have not been taken yet.
pub(super) struct MapKeys<'a> {
    text: &'a SourceText<'a>,
    /// Name of the section with its brackets, as in "[depth]".
    pub name: String,
    /// The line in which the section begins.
    pub line: usize,
    /// The keys that have not been taken, each with its value and its line.
    untaken: BTreeMap<String, (Value, usize)>,
    /// The keys that the section may have, for the error about an unknown key.
    known: Vec<&'static str>,
}

impl<'a> MapKeys<'a> {
    /// Collects the keys of a section of the map `text`. `name` is the section's name with its brackets, for errors.
    pub fn new(text: &'a SourceText<'a>, name: &str, section: MapSection) -> Self {
        let line = text.line(section.span());
        let entry = |(key, value): (String, Spanned<Value>)| {
            let line = text.line(value.span());
            (key, (value.into_inner(), line))
        };
        let untaken = section.into_inner().into_iter().map(entry).collect();
        Self { text, name: name.to_owned(), line, untaken, known: Vec::new() }
    }

    /// Collects the keys of an optional section; there are none if the section is missing.
    pub fn or_empty(text: &'a SourceText<'a>, name: &str, section: Option<MapSection>) -> Self {
        Self::new(text, name, section.unwrap_or_else(|| Spanned::new(0..0, BTreeMap::new())))
    }

    /// Makes an error about this section at a line of the map.
    pub fn error(&self, line: usize, message: impl AsRef<str>) -> Error {
        Error::malformed(self.text.path, Some(line), format!("{}: {}", self.name, message.as_ref()))
    }

    /// Takes the value and the line of a key, or `None` if it is absent. The key is noted as one that the section
    /// knows.
    fn take(&mut self, key: &'static str) -> Option<(Value, usize)> {
        self.known.push(key);
        self.untaken.remove(key)
    }

    /// Returns true if a key is present and has not been taken.
    pub fn has(&self, key: &str) -> bool {
        self.untaken.contains_key(key)
    }

    /// Takes a key whose value must be a text; `None` if the key is absent.
    pub fn text(&mut self, key: &'static str) -> Result<Option<String>> {
        match self.take(key) {
            None => Ok(None),
            Some((Value::String(text), _)) => Ok(Some(text)),
            Some((other, line)) => {
                Err(self.error(line, format!("{key} must be a text, not {}", kind_in_words(&other))))
            }
        }
    }

    /// Takes a key whose value must be a word of `choices`, which pairs each word with its meaning. Returns the meaning
    /// of the word, or `None` if the key is absent.
    pub fn word<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Result<Option<T>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let found = value.as_str().and_then(|stated| choices.iter().find(|(word, _)| *word == stated));
        match found {
            Some((_, meaning)) => Ok(Some(*meaning)),
            None => {
                let message = format!("{key} must be one of {}, not {}", quoted_words(choices), value_text(&value));
                Err(self.error(line, message))
            }
        }
    }

    /// Takes a required key like [`Self::word`]; it is an error if the key is absent.
    pub fn required_word<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Result<T> {
        match self.word(key, choices)? {
            Some(meaning) => Ok(meaning),
            None => Err(self.error(self.line, format!("{key} is missing: one of {}", quoted_words(choices)))),
        }
    }

    /// Takes a key whose value must be a number, which may be infinite only if `may_be_infinite`; `None` if the key is
    /// absent.
    pub fn number(&mut self, key: &'static str, may_be_infinite: bool) -> Result<Option<f64>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let allowed = |number: &f64| number.is_finite() || (may_be_infinite && !number.is_nan());
        match number(&value).filter(allowed) {
            Some(number) => Ok(Some(number)),
            None => {
                let finite = if may_be_infinite { "" } else { "finite " };
                Err(self.error(line, format!("{key} must be a {finite}number, not {}", value_text(&value))))
            }
        }
    }

    /// Takes a key whose value must be one finite number or three; `None` if the key is absent.
    pub fn one_or_three(&mut self, key: &'static str) -> Result<Option<Vec<f64>>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let is_allowed = |numbers: &Vec<f64>| [1, 3].contains(&numbers.len()) && numbers.iter().all(|v| v.is_finite());
        let numbers = flat_numbers(&value).filter(is_allowed);
        let error = || self.error(line, format!("{key} must be a finite number or three, not {}", value_text(&value)));
        numbers.ok_or_else(error).map(Some)
    }

    /// Takes a key whose value must be names of channels, a text or a list of texts. Returns the names and the key's
    /// line, or `None` if the key is absent.
    pub fn names(&mut self, key: &'static str) -> Result<Option<(Vec<String>, usize)>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let list = match &value {
            Value::String(name) => Some(vec![name.clone()]),
            Value::Array(list) => list.iter().map(|value| value.as_str().map(str::to_owned)).collect(),
            _ => None,
        };
        let error = || {
            self.error(
                line,
                format!("{key} must be the name of a channel or a list of names, not {}", kind_in_words(&value)),
            )
        };
        list.ok_or_else(error).map(|list| Some((list, line)))
    }

    /// Takes a key whose value must be `count` finite numbers, or a table that names an attribute of a file with them;
    /// `None` if the key is absent. Such a table is `{ attribute = "…", file = "…", part = "…" }`.
    pub fn numbers(&mut self, key: &'static str, count: usize) -> Result<Option<MapNumbers>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let from = if let Value::Table(table) = value {
            NumbersFrom::Attribute(self.attribute(key, line, table)?)
        } else {
            let is_allowed = |numbers: &Vec<f64>| numbers.len() == count && numbers.iter().all(|v| v.is_finite());
            let numbers = flat_numbers(&value).filter(is_allowed);
            NumbersFrom::Here(numbers.ok_or_else(|| {
                let expected =
                    if count == 1 { "a finite number".to_owned() } else { format!("{count} finite numbers") };
                self.error(
                    line,
                    format!("{key} must be {expected} or {{ attribute = \"…\" }}, not {}", value_text(&value)),
                )
            })?)
        };
        Ok(Some(MapNumbers { key: format!("{}: {key}", self.name), line, count, from }))
    }

    /// Reads a table that names an attribute of a file. The table is the value of `key`, in the line `line`.
    fn attribute(&self, key: &str, line: usize, table: toml::Table) -> Result<AttributeName> {
        let mut keys = self.table_keys(key, line, table);
        let [name, file, part] = ["attribute", "file", "part"].map(|key| keys.text(key));
        let [name, file, part] = [name?, file?, part?];
        keys.finish()?;
        let name = name.ok_or_else(|| self.error(line, format!("{key} must name an attribute")))?;
        Ok(AttributeName { name, file, part })
    }

    /// Takes a key whose value must be a table, and returns the table's keys; `None` if the key is absent.
    pub fn table(&mut self, key: &'static str) -> Result<Option<Self>> {
        match self.take(key) {
            None => Ok(None),
            Some((Value::Table(table), line)) => Ok(Some(self.table_keys(key, line, table))),
            Some((other, line)) => {
                Err(self.error(line, format!("{key} must be a table, not {}", kind_in_words(&other))))
            }
        }
    }

    /// Collects the keys of a table that is the value of `key`. All keys get the line of the table.
    fn table_keys(&self, key: &str, line: usize, table: toml::Table) -> Self {
        let untaken = table.into_iter().map(|(key, value)| (key, (value, line))).collect();
        Self { text: self.text, name: format!("{} {key}", self.name), line, untaken, known: Vec::new() }
    }

    /// Ends the section; it is an error if keys are left.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the first key that was not taken, and the names of the keys that the section knows.
    pub fn finish(self) -> Result<()> {
        match self.untaken.iter().min_by_key(|(_, (_, line))| *line) {
            None => Ok(()),
            Some((key, (_, line))) => {
                Err(self.error(*line, format!("there is no key {key:?} here; there are {}", self.known.join(", "))))
            }
        }
    }
}

/// Lists the words of `choices` in quotation marks, with commas between them.
fn quoted_words<T>(choices: &[(&str, T)]) -> String {
    choices.iter().map(|(word, _)| format!("{word:?}")).collect::<Vec<_>>().join(", ")
}

/// Returns the number in a value, with or without a decimal point; `None` for any other value.
fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

/// Returns a number as a list of one number, or the numbers of a list and of lists in it, in order; `None` if anything
/// in the value is no number.
fn flat_numbers(value: &Value) -> Option<Vec<f64>> {
    match value {
        Value::Array(list) => list.iter().map(flat_numbers).collect::<Option<Vec<_>>>().map(|lists| lists.concat()),
        single => number(single).map(|number| vec![number]),
    }
}

/// Writes a value for an error.
fn value_text(value: &Value) -> String {
    /// Greatest length, in bytes, of a value that is quoted; a longer value is described by its kind.
    const LONGEST_BYTES: usize = 40;
    let text = value.to_string();
    if text.len() <= LONGEST_BYTES { text } else { kind_in_words(value).to_owned() }
}

/// Names the kind of a value for an error.
fn kind_in_words(value: &Value) -> &'static str {
    match value {
        Value::String(_) => "a text",
        Value::Integer(_) | Value::Float(_) => "a number",
        Value::Boolean(_) => "true or false",
        Value::Datetime(_) => "a date",
        Value::Array(_) => "this list",
        Value::Table(_) => "a table",
    }
}
