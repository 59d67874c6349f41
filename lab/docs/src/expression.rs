//! The language of queries: what an expression is, and how it is read.
//!
//! A field, such as `rmse`, is its numbers in all rows. `[against=world] rmse` takes the rows of a condition alone, and `[a.csv:] rmse`
//! those of a file. Numbers are added, divided and compared row by row, by the key of their rows; `median(…)` makes one of many.

use crate::records::Result;
use std::collections::BTreeMap;

/// A name for an expression, with the names of its arguments.
#[derive(Debug, Clone)]
pub(crate) struct Word {
    arguments: Vec<String>,
    body: String,
}

/// Expressions that have a name, which queries call as they call functions.
pub(crate) type Words = BTreeMap<String, Word>;

/// A condition on a field: `field=a|b`. The comparison is one of [`COMPARISONS`].
#[derive(Debug, Clone)]
pub(crate) struct Condition {
    pub(crate) field: String,
    pub(crate) comparison: &'static str,
    pub(crate) values: Vec<String>,
}

/// Is none of, does not contain, begins with, contains, is one of.
const COMPARISONS: [&str; 5] = ["!=", "!*", "^=", "*=", "="];

/// Rows that are chosen: those of a file, or those at hand, for which all conditions hold.
#[derive(Debug, Clone, Default)]
pub(crate) struct Choice {
    pub(crate) files: Option<String>,
    pub(crate) conditions: Vec<Condition>,
}

/// An expression.
#[derive(Debug, Clone)]
pub(crate) enum Expression {
    Number(f64),
    Text(String),
    Field(String),
    /// 1 for each row for which all conditions hold, and 0 for the others.
    Holds(Vec<Condition>),
    In(Choice, Box<Self>),
    Both(char, Box<[Self; 2]>),
    Call {
        function: String,
        by: Vec<String>,
        arguments: Vec<Self>,
    },
}

/// Returns the name of a word and the word, from its head, `name(a, b)`, and its body.
pub(crate) fn word(head: &str, body: &str) -> (String, Word) {
    let (name, rest) = head.split_once('(').unwrap_or((head, ""));
    let names = rest.trim_end_matches(')').split(',').map(|a| a.trim().to_owned()).filter(|a| !a.is_empty());
    (name.to_owned(), Word { arguments: names.collect(), body: body.to_owned() })
}

/// Replaces each variable in a text, written as `$name`, by its value. Where several names fit, the longest one counts.
/// Variables within a value are replaced, too. A name that is not known is an error.
pub(crate) fn fill(text: &str, variables: &BTreeMap<String, String>) -> Result<String> {
    let mut parts = text.split('$');
    let mut filled = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let fitting = variables.iter().filter(|(name, _)| part.starts_with(&***name));
        let (name, value) = fitting.max_by_key(|(name, _)| name.len()).ok_or_else(|| format!("what is ${part:?}?"))?;
        filled += &if value.contains('$') { fill(value, variables)? } else { value.clone() };
        filled += &part[name.len()..];
    }
    Ok(filled)
}

/// What stands between brackets: `file: field=value, other!=value`. A file may be left out, with its colon, or the conditions.
pub(crate) fn choice(text: &str) -> Result<Choice> {
    let (files, conditions) = match text.split_once(':') {
        Some((files, rest)) if !files.contains('=') => (Some(files.trim().to_owned()), rest),
        _ => (None, text),
    };
    let mut choice = Choice { files, conditions: Vec::new() };
    for part in split(conditions, ',').iter().map(|part| part.trim()).filter(|part| !part.is_empty()) {
        let found =
            COMPARISONS.iter().filter_map(|c| Some((part.find(c)?, *c))).min_by_key(|(place, c)| (*place, 2 - c.len()));
        let (place, comparison) = found.ok_or_else(|| format!("{part:?} is no condition"))?;
        let values = part[place + comparison.len()..].split('|').map(|v| v.trim().trim_matches('"').to_owned());
        choice.conditions.push(Condition {
            field: part[..place].trim().to_owned(),
            comparison,
            values: values.collect(),
        });
    }
    Ok(choice)
}

/// The parts of a text between separators that stand in no brackets and no quotes.
pub(crate) fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut depth, mut is_quoted, mut from, mut parts) = (0, false, 0, Vec::new());
    for (place, c) in text.char_indices() {
        match c {
            '"' => is_quoted = !is_quoted,
            _ if is_quoted => {}
            c if c == separator && depth == 0 => {
                parts.push(&text[from..place]);
                from = place + c.len_utf8();
            }
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

/// The expression that a text is.
pub(crate) fn parse(text: &str, words: &Words) -> Result<Expression> {
    let mut parser = Parser { rest: text.trim(), words };
    let expression = parser.compared()?;
    if parser.rest.is_empty() { Ok(expression) } else { Err(format!("what is {:?} in {text:?}?", parser.rest).into()) }
}

struct Parser<'a> {
    rest: &'a str,
    words: &'a Words,
}

impl<'a> Parser<'a> {
    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest.trim_start();
        taken
    }

    /// The operator that comes next, if it is one of some.
    fn operator(&mut self, operators: &str) -> Option<char> {
        let next = self.rest.chars().next().filter(|c| operators.contains(*c))?;
        self.take(next.len_utf8());
        Some(next)
    }

    fn compared(&mut self) -> Result<Expression> {
        self.chain("<>=", |parser| parser.chain("+-", |parser| parser.chain("*/~", Self::single)))
    }

    /// Reads operands by `next` and joins them from left to right, as long as one of `operators` follows.
    fn chain(&mut self, operators: &str, next: impl Fn(&mut Self) -> Result<Expression>) -> Result<Expression> {
        let mut left = next(self)?;
        while let Some(operator) = self.operator(operators) {
            left = Expression::Both(operator, Box::new([left, next(self)?]));
        }
        Ok(left)
    }

    /// What stands between the bracket that comes next and its end.
    fn bracketed(&mut self, end: char) -> Result<&'a str> {
        let inside = match end {
            '"' | '\'' => self.rest[1..].split(end).next().unwrap_or_default(),
            _ => split(&self.rest[1..], end)[0],
        };
        let closes = self.rest[1 + inside.len()..].starts_with(end);
        if !closes {
            return Err(format!("{:?} lacks {end}", self.rest).into());
        }
        Ok(&self.take(inside.len() + 2)[1..=inside.len()])
    }

    fn single(&mut self) -> Result<Expression> {
        let is_of_name = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        match self.rest.chars().next() {
            Some('[') => {
                let choice = choice(self.bracketed(']')?)?;
                Ok(Expression::In(choice, Box::new(self.single()?)))
            }
            Some('(') => parse(self.bracketed(')')?, self.words),
            Some('"') => Ok(Expression::Text(self.bracketed('"')?.to_owned())),
            Some('\'') => Ok(Expression::Field(self.bracketed('\'')?.to_owned())),
            Some(c) if c.is_ascii_digit() || c == '-' => {
                let length = self.rest[1..].find(|c: char| !is_of_name(c)).map_or(self.rest.len(), |n| n + 1);
                let number = self.take(length);
                Ok(Expression::Number(number.parse().map_err(|_| format!("{number} is no number"))?))
            }
            Some(c) if c.is_alphabetic() => {
                let name = self.take(self.rest.find(|c| !is_of_name(c)).unwrap_or(self.rest.len()));
                let arguments = if self.rest.starts_with('(') { Some(self.bracketed(')')?) } else { None };
                self.called(name, arguments)
            }
            _ => Err(format!("{:?} begins no expression", self.rest).into()),
        }
    }

    /// A field, a word or a function.
    fn called(&self, name: &str, arguments: Option<&str>) -> Result<Expression> {
        let all = arguments.filter(|all| !all.is_empty()).map_or(Vec::new(), |all| split(all, ','));
        let texts: Vec<&str> = all.into_iter().map(str::trim).collect();
        if let Some(word) = self.words.get(name) {
            if word.arguments.len() != texts.len() {
                return Err(format!("{name} has {} arguments", word.arguments.len()).into());
            }
            let values = word.arguments.iter().cloned().zip(texts.iter().map(|text| (*text).to_owned())).collect();
            return parse(&fill(&word.body, &values)?, self.words);
        }
        let Some(all) = arguments else { return Ok(Expression::Field(name.to_owned())) };
        if name == "holds" {
            return Ok(Expression::Holds(choice(all)?.conditions));
        }
        // Functions that end like this have the fields of a key as their first argument.
        let (by, texts) = match (name.ends_with("_by"), texts.split_first()) {
            (true, Some((fields, rest))) => (fields.split(' ').map(str::to_owned).collect(), rest.to_vec()),
            _ => (Vec::new(), texts),
        };
        let arguments = texts.iter().map(|text| parse(text, self.words)).collect::<Result<_>>()?;
        Ok(Expression::Call { function: name.to_owned(), by, arguments })
    }
}
