//! The keys of a map's sections, taken one by one. An error about a key has the key's line. After all known keys of a section
//! were taken, the remaining keys are unknown.

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
    /// Name of the section, in the brackets of the map.
    pub name: String,
    /// The line in which the section begins.
    pub line: usize,
    /// The keys that have not been taken, each with its value and its line.
    left: BTreeMap<String, (Value, usize)>,
    /// The keys that the section may have, for the error about an unknown key.
    known: Vec<&'static str>,
}

impl<'a> MapKeys<'a> {
    /// The keys of a section of the map `text`. `name` is the section's name in brackets, for errors.
    pub fn new(text: &'a SourceText<'a>, name: &str, section: MapSection) -> Self {
        let line = text.line(section.span());
        let entry = |(key, value): (String, Spanned<Value>)| {
            let line = text.line(value.span());
            (key, (value.into_inner(), line))
        };
        let left = section.into_inner().into_iter().map(entry).collect();
        Self { text, name: name.to_owned(), line, left, known: Vec::new() }
    }

    /// The keys of an optional section; no keys if it is missing.
    pub fn or_empty(text: &'a SourceText<'a>, name: &str, section: Option<MapSection>) -> Self {
        Self::new(text, name, section.unwrap_or_else(|| Spanned::new(0..0, BTreeMap::new())))
    }

    /// An error at a line.
    pub fn error(&self, line: usize, message: impl AsRef<str>) -> Error {
        Error::malformed(self.text.path, Some(line), format!("{}: {}", self.name, message.as_ref()))
    }

    /// Takes the value and the line of a key, if it is present, and notes that the section knows the key.
    fn take(&mut self, key: &'static str) -> Option<(Value, usize)> {
        self.known.push(key);
        self.left.remove(key)
    }

    /// Whether a key is present and has not been taken.
    pub fn has(&self, key: &str) -> bool {
        self.left.contains_key(key)
    }

    /// Takes a text; `None` if the key is absent.
    pub fn text(&mut self, key: &'static str) -> Result<Option<String>> {
        match self.take(key) {
            None => Ok(None),
            Some((Value::String(text), _)) => Ok(Some(text)),
            Some((other, line)) => Err(self.error(line, format!("{key} must be a text, not {}", kind(&other)))),
        }
    }

    /// Takes a key whose value must be a word of `choices`, and returns what the word stands for; `None` if the key is
    /// absent.
    pub fn word<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Result<Option<T>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let found = value.as_str().and_then(|word| choices.iter().find(|(name, _)| *name == word));
        match found {
            Some((_, choice)) => Ok(Some(*choice)),
            None => {
                let message = format!("{key} must be one of {}, not {}", words(choices), value_text(&value));
                Err(self.error(line, message))
            }
        }
    }

    /// Takes one of the words of `choices`, for a required key.
    pub fn required_word<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Result<T> {
        match self.word(key, choices)? {
            Some(choice) => Ok(choice),
            None => Err(self.error(self.line, format!("{key} is missing: one of {}", words(choices)))),
        }
    }

    /// Takes a number; infinite numbers are allowed only if `may_be_infinite`.
    pub fn number(&mut self, key: &'static str, may_be_infinite: bool) -> Result<Option<f64>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let allowed = |n: &f64| n.is_finite() || (may_be_infinite && !n.is_nan());
        match number(&value).filter(allowed) {
            Some(number) => Ok(Some(number)),
            None => {
                let finite = if may_be_infinite { "" } else { "finite " };
                Err(self.error(line, format!("{key} must be a {finite}number, not {}", value_text(&value))))
            }
        }
    }

    /// Takes one finite number, or three.
    pub fn value(&mut self, key: &'static str) -> Result<Option<Vec<f64>>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let numbers = flat(&value).filter(|n| [1, 3].contains(&n.len()) && n.iter().all(|v| v.is_finite()));
        let wrong = || self.error(line, format!("{key} must be a finite number or three, not {}", value_text(&value)));
        numbers.ok_or_else(wrong).map(Some)
    }

    /// Takes names of channels, given as a text or as a list of texts, with the line.
    pub fn names(&mut self, key: &'static str) -> Result<Option<(Vec<String>, usize)>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let list = match &value {
            Value::String(name) => Some(vec![name.clone()]),
            Value::Array(list) => list.iter().map(|v| v.as_str().map(str::to_owned)).collect(),
            _ => None,
        };
        let wrong = || {
            self.error(line, format!("{key} must be the name of a channel or a list of names, not {}", kind(&value)))
        };
        list.ok_or_else(wrong).map(|list| Some((list, line)))
    }

    /// Takes `count` finite numbers, from the map or from an attribute of a file: `{ attribute = "…", file = "…", part = "…"
    /// }`.
    pub fn numbers(&mut self, key: &'static str, count: usize) -> Result<Option<MapNumbers>> {
        let Some((value, line)) = self.take(key) else { return Ok(None) };
        let from = if let Value::Table(table) = value {
            NumbersFrom::Attribute(self.attribute(key, line, table)?)
        } else {
            let numbers = flat(&value).filter(|n| n.len() == count && n.iter().all(|v| v.is_finite()));
            NumbersFrom::Here(numbers.ok_or_else(|| {
                let many = if count == 1 { "a finite number".to_owned() } else { format!("{count} finite numbers") };
                self.error(line, format!("{key} must be {many} or {{ attribute = \"…\" }}, not {}", value_text(&value)))
            })?)
        };
        Ok(Some(MapNumbers { key: format!("{}: {key}", self.name), line, count, from }))
    }

    /// Reads the table that names an attribute of a file, which is the value of `key`.
    fn attribute(&self, key: &str, line: usize, table: toml::Table) -> Result<AttributeName> {
        let mut keys = self.inner(key, line, table);
        let [name, file, part] = ["attribute", "file", "part"].map(|k| keys.text(k));
        let [name, file, part] = [name?, file?, part?];
        keys.finish()?;
        let name = name.ok_or_else(|| self.error(line, format!("{key} must name an attribute")))?;
        Ok(AttributeName { name, file, part })
    }

    /// Takes the keys of a table within this section.
    pub fn table(&mut self, key: &'static str) -> Result<Option<Self>> {
        match self.take(key) {
            None => Ok(None),
            Some((Value::Table(table), line)) => Ok(Some(self.inner(key, line, table))),
            Some((other, line)) => Err(self.error(line, format!("{key} must be a table, not {}", kind(&other)))),
        }
    }

    /// The keys of a table that is the value of `key`. All keys have the line of the table.
    fn inner(&self, key: &str, line: usize, table: toml::Table) -> Self {
        let left = table.into_iter().map(|(key, value)| (key, (value, line))).collect();
        Self { text: self.text, name: format!("{} {key}", self.name), line, left, known: Vec::new() }
    }

    /// Ends the section, in which all keys must be known.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the first key that was not taken, and the names of the keys that the section knows.
    pub fn finish(self) -> Result<()> {
        match self.left.iter().min_by_key(|(_, (_, line))| *line) {
            None => Ok(()),
            Some((key, (_, line))) => {
                Err(self.error(*line, format!("there is no key {key:?} here; there are {}", self.known.join(", "))))
            }
        }
    }
}

/// The words of `choices` in quotation marks.
fn words<T>(choices: &[(&str, T)]) -> String {
    choices.iter().map(|(name, _)| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}

/// The number in a value, with or without a decimal point; `None` for any other value.
fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

/// A number, or the numbers of a list, or the numbers of a list of lists, one list after another.
fn flat(value: &Value) -> Option<Vec<f64>> {
    match value {
        Value::Array(list) => list.iter().map(flat).collect::<Option<Vec<_>>>().map(|lists| lists.concat()),
        other => number(other).map(|n| vec![n]),
    }
}

/// A value in the words of an error.
fn value_text(value: &Value) -> String {
    /// Greatest length of a value that is quoted; a longer value is described by its kind.
    const LONGEST: usize = 40;
    let text = value.to_string();
    if text.len() <= LONGEST { text } else { kind(value).to_owned() }
}

/// The kind of a value, in the words of an error.
fn kind(value: &Value) -> &'static str {
    match value {
        Value::String(_) => "a text",
        Value::Integer(_) | Value::Float(_) => "a number",
        Value::Boolean(_) => "true or false",
        Value::Datetime(_) => "a date",
        Value::Array(_) => "this list",
        Value::Table(_) => "a table",
    }
}
