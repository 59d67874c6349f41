//! The language of queries: the types of expressions, and a parser that reads them from text.
//!
//! A field, such as `rmse`, stands for its numbers in all rows. `[against=world] rmse` takes only the rows for which
//! the condition holds, and `[a.csv:] rmse` takes the rows of a file. Numbers are added, divided and compared row by
//! row; rows are matched by their keys. `median(…)` makes one number of many.

use crate::records::Result;
use std::collections::BTreeMap;

/// An expression that has a name.
#[derive(Debug, Clone)]
pub(crate) struct Word {
    /// The names of its arguments.
    arguments: Vec<String>,
    /// The text of the expression, in which `$name` stands for an argument.
    body: String,
}

/// Named expressions by their names. Queries call them like functions.
pub(crate) type Words = BTreeMap<String, Word>;

/// A condition on a field: `field=a|b`. The comparison is one of [`COMPARISONS`].
#[derive(Debug, Clone)]
pub(crate) struct Condition {
    pub(crate) field: String,
    pub(crate) comparison: &'static str,
    pub(crate) values: Vec<String>,
}

/// The comparisons, in this order: is none of, does not contain, begins with, contains, is one of.
const COMPARISONS: [&str; 5] = ["!=", "!*", "^=", "*=", "="];

/// A choice of rows, for which all conditions hold.
#[derive(Debug, Clone, Default)]
pub(crate) struct Choice {
    /// The files whose rows are chosen from; `None` for the rows that the expression around it has.
    pub(crate) files: Option<String>,
    pub(crate) conditions: Vec<Condition>,
}

/// An expression.
#[derive(Debug, Clone)]
pub(crate) enum Expression {
    Number(f64),
    Text(String),
    /// The numbers of a field in all rows.
    Field(String),
    /// 1 for each row for which all conditions hold, and 0 for the others.
    Holds(Vec<Condition>),
    /// An expression over the rows of a choice.
    OverRows(Choice, Box<Self>),
    /// An operator with its left and its right side.
    Binary(char, Box<[Self; 2]>),
    /// A call of a function. `by` has the fields of the groups, for functions that end with `_by`.
    Call {
        function: String,
        by: Vec<String>,
        arguments: Vec<Self>,
    },
}

/// Reads a named expression as `words.toml` defines it. `head` is its name with the names of its arguments, such as
/// `over(x, a)`, and `body` is the text of the expression. Returns the name and the expression.
pub(crate) fn read_word(head: &str, body: &str) -> (String, Word) {
    let (name, list) = head.split_once('(').unwrap_or((head, ""));
    let arguments = list.trim_end_matches(')').split(',').map(|a| a.trim().to_owned()).filter(|a| !a.is_empty());
    (name.to_owned(), Word { arguments: arguments.collect(), body: body.to_owned() })
}

/// Returns a text in which each variable, written as `$name`, is replaced by its value. If several names fit, the
/// longest one counts. Variables within a value are replaced, too. An unknown name is an error.
pub(crate) fn fill_variables(text: &str, variables: &BTreeMap<String, String>) -> Result<String> {
    let mut parts = text.split('$');
    let mut filled = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let fitting = variables.iter().filter(|(name, _)| part.starts_with(&***name));
        let (name, value) = fitting.max_by_key(|(name, _)| name.len()).ok_or_else(|| format!("what is ${part:?}?"))?;
        filled += &if value.contains('$') { fill_variables(value, variables)? } else { value.clone() };
        filled += &part[name.len()..];
    }
    Ok(filled)
}

/// Reads a choice from the text between its brackets: `file: field=value, other!=value`. The file may be left out with
/// its colon, and so may the conditions.
pub(crate) fn parse_choice(text: &str) -> Result<Choice> {
    let (files, conditions) = match text.split_once(':') {
        Some((files, rest)) if !files.contains('=') => (Some(files.trim().to_owned()), rest),
        _ => (None, text),
    };
    let mut choice = Choice { files, conditions: Vec::new() };
    for part in split_outside_brackets(conditions, ',').iter().map(|part| part.trim()).filter(|part| !part.is_empty()) {
        // The comparison that comes first in the text. Where two begin at one place, the longer one counts.
        let in_text = COMPARISONS.iter().filter_map(|c| Some((part.find(c)?, *c)));
        let found = in_text.min_by_key(|(place, c)| (*place, 2 - c.len()));
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

/// Splits a text at each separator that is outside of brackets and quotes. A closing bracket may be the separator; then
/// the first part ends where the bracket closes that was opened before the text.
pub(crate) fn split_outside_brackets(text: &str, separator: char) -> Vec<&str> {
    let (mut depth, mut is_quoted, mut start, mut parts) = (0, false, 0, Vec::new());
    for (place, c) in text.char_indices() {
        match c {
            '"' => is_quoted = !is_quoted,
            _ if is_quoted => {}
            c if c == separator && depth == 0 => {
                parts.push(&text[start..place]);
                start = place + c.len_utf8();
            }
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

/// Parses a whole text as one expression.
pub(crate) fn parse(text: &str, words: &Words) -> Result<Expression> {
    let mut parser = Parser { rest: text.trim(), words };
    let expression = parser.expression()?;
    if parser.rest.is_empty() { Ok(expression) } else { Err(format!("what is {:?} in {text:?}?", parser.rest).into()) }
}

/// A recursive-descent parser of expressions.
struct Parser<'a> {
    /// The text that is not read yet.
    rest: &'a str,
    words: &'a Words,
}

impl<'a> Parser<'a> {
    /// Reads `length` bytes, and the blanks after them. Returns the bytes.
    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest.trim_start();
        taken
    }

    /// Reads the operator that comes next, if it is one of `operators`.
    fn operator(&mut self, operators: &str) -> Option<char> {
        let next = self.rest.chars().next().filter(|c| operators.contains(*c))?;
        self.take(next.len_utf8());
        Some(next)
    }

    /// Reads an expression: comparisons of sums of products of single operands.
    fn expression(&mut self) -> Result<Expression> {
        self.chain("<>=", |parser| parser.chain("+-", |parser| parser.chain("*/~", Self::operand)))
    }

    /// Reads operands by `next` and joins them from left to right, as long as one of `operators` follows.
    fn chain(&mut self, operators: &str, next: impl Fn(&mut Self) -> Result<Expression>) -> Result<Expression> {
        let mut left = next(self)?;
        while let Some(operator) = self.operator(operators) {
            left = Expression::Binary(operator, Box::new([left, next(self)?]));
        }
        Ok(left)
    }

    /// Reads the bracket or quote that comes next, up to its closing character `end`, and returns the text inside.
    fn bracketed(&mut self, end: char) -> Result<&'a str> {
        let inside = match end {
            '"' | '\'' => self.rest[1..].split(end).next().unwrap_or_default(),
            _ => split_outside_brackets(&self.rest[1..], end)[0],
        };
        let closes = self.rest[1 + inside.len()..].starts_with(end);
        if !closes {
            return Err(format!("{:?} lacks {end}", self.rest).into());
        }
        Ok(&self.take(inside.len() + 2)[1..=inside.len()])
    }

    /// Reads a single operand: a choice with an operand, an expression in brackets, a text, a field, a number or a
    /// call.
    fn operand(&mut self) -> Result<Expression> {
        let is_in_name = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        match self.rest.chars().next() {
            Some('[') => {
                let choice = parse_choice(self.bracketed(']')?)?;
                Ok(Expression::OverRows(choice, Box::new(self.operand()?)))
            }
            Some('(') => parse(self.bracketed(')')?, self.words),
            Some('"') => Ok(Expression::Text(self.bracketed('"')?.to_owned())),
            Some('\'') => Ok(Expression::Field(self.bracketed('\'')?.to_owned())),
            Some(c) if c.is_ascii_digit() || c == '-' => {
                let length = self.rest[1..].find(|c: char| !is_in_name(c)).map_or(self.rest.len(), |n| n + 1);
                let number = self.take(length);
                Ok(Expression::Number(number.parse().map_err(|_| format!("{number} is no number"))?))
            }
            Some(c) if c.is_alphabetic() => {
                let name = self.take(self.rest.find(|c| !is_in_name(c)).unwrap_or(self.rest.len()));
                let arguments = if self.rest.starts_with('(') { Some(self.bracketed(')')?) } else { None };
                self.named(name, arguments)
            }
            _ => Err(format!("{:?} begins no expression", self.rest).into()),
        }
    }

    /// Returns the expression for a name and the text of its arguments: a named expression with its arguments replaced,
    /// a field if there are no brackets, or the call of a function.
    fn named(&self, name: &str, arguments: Option<&str>) -> Result<Expression> {
        let parts =
            arguments.filter(|list| !list.is_empty()).map_or(Vec::new(), |list| split_outside_brackets(list, ','));
        let texts: Vec<&str> = parts.into_iter().map(str::trim).collect();
        if let Some(word) = self.words.get(name) {
            if word.arguments.len() != texts.len() {
                return Err(format!("{name} has {} arguments", word.arguments.len()).into());
            }
            let values = word.arguments.iter().cloned().zip(texts.iter().map(|text| (*text).to_owned())).collect();
            return parse(&fill_variables(&word.body, &values)?, self.words);
        }
        let Some(list) = arguments else { return Ok(Expression::Field(name.to_owned())) };
        if name == "holds" {
            return Ok(Expression::Holds(parse_choice(list)?.conditions));
        }
        // The first argument of a function that ends with `_by` is the fields of a key.
        let (by, texts) = match (name.ends_with("_by"), texts.split_first()) {
            (true, Some((fields, rest))) => (fields.split(' ').map(str::to_owned).collect(), rest.to_vec()),
            _ => (Vec::new(), texts),
        };
        let arguments = texts.iter().map(|text| parse(text, self.words)).collect::<Result<_>>()?;
        Ok(Expression::Call { function: name.to_owned(), by, arguments })
    }
}
