//! Evaluates expressions over the rows of records.

use crate::expression::{Choice, Condition, Expression};
use crate::format::{self, greatest, least, median};
use crate::records::{Failure, Library, Result, Row, Rows};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::rc::Rc;

/// The context in which the expressions of a query are evaluated.
pub(crate) struct Context<'a> {
    /// The records that were read.
    pub(crate) library: &'a Library,
    /// The folders that the query is about.
    pub(crate) folders: &'a [PathBuf],
    /// The fields by which rows are matched.
    pub(crate) by: Vec<String>,
}

/// Numbers, each with the row that it comes from.
#[derive(Debug, Clone)]
pub(crate) struct Numbers {
    /// The fields by which the rows are matched with others.
    by: Vec<String>,
    items: Vec<(Rc<Row>, f64)>,
}

/// The value of an expression.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
    Numbers(Numbers),
}

impl Value {
    /// Returns all numbers of the value; a text has none and is an error.
    pub(crate) fn numbers(&self) -> Result<Vec<f64>> {
        match self {
            Self::Number(number) => Ok(vec![*number]),
            Self::Numbers(numbers) => Ok(numbers.items.iter().map(|(_, number)| *number).collect()),
            Self::Text(text) => Err(format!("{text:?} is no number").into()),
        }
    }

    /// Returns the only number of the value; several numbers, or none, are an error.
    pub(crate) fn number(&self) -> Result<f64> {
        let numbers = self.numbers()?;
        let [number] = numbers[..] else {
            return Err(Failure::missing(format!("{} values where one is wanted", numbers.len())));
        };
        Ok(number)
    }

    /// Returns the value as pages write it.
    pub(crate) fn text(&self) -> Result<String> {
        match self {
            Self::Text(text) => Ok(text.clone()),
            _ => self.number().map(|number| number.to_string()),
        }
    }
}

/// Returns whether two values of a field are the same text or, up to 1e-6, the same number.
fn is_same(a: &str, b: &str) -> bool {
    a == b || a.parse().ok().zip(b.parse().ok()).is_some_and(|(a, b): (f64, f64)| (a - b).abs() < 1e-6)
}

/// Returns whether a condition holds for a row. The value `*` fits any field, and `~` a field that is missing or empty.
fn holds(row: &Row, condition: &Condition) -> bool {
    let found = row.get(&condition.field).map(String::as_str).filter(|value| !value.is_empty());
    // True if the row's value fits one of the condition's values.
    let fits_any = |fits: &dyn Fn(&str, &str) -> bool| {
        condition.values.iter().any(|value| match (&**value, found) {
            ("*", _) | ("~", None) => true,
            (value, Some(found)) => fits(found, value),
            _ => false,
        })
    };
    match condition.comparison {
        "=" => fits_any(&is_same),
        "!=" => !fits_any(&is_same),
        "^=" => fits_any(&|found, value| found.starts_with(value)),
        "*=" => fits_any(&|found, value| found.contains(value)),
        // `!*`, the last of the comparisons: the field contains none of the values.
        _ => !fits_any(&|found, value| found.contains(value)),
    }
}

/// Returns the key by which a row is matched with others: the values of the fields `by`. Numbers have one form, so that
/// 1 and 1.0 are equal, and texts are in lower case.
fn row_key(row: &Row, by: &[String]) -> Vec<String> {
    let value = |field: &String| {
        let value = row.get(field).map_or("", String::as_str);
        value.parse::<f64>().map_or_else(|_| value.to_lowercase(), |number| number.to_string())
    };
    by.iter().map(value).collect()
}

/// Returns the values of some fields in the rows that have all of them: each tuple once, in the order of the rows.
pub(crate) fn distinct(rows: &Rows, fields: &[String]) -> Vec<Vec<String>> {
    let mut tuples = Vec::new();
    for row in rows.iter().filter(|row| fields.iter().all(|field| row.contains_key(field))) {
        let values: Vec<String> = fields.iter().map(|field| row[field].clone()).collect();
        if !tuples.contains(&values) {
            tuples.push(values);
        }
    }
    tuples
}

impl Context<'_> {
    /// Returns the rows of a choice: of its files, or of `rows` if it names none. The value `@first` in a condition
    /// stands for the value that the first row has, or for a missing value (`~`) if the row has none.
    pub(crate) fn choose(&self, choice: &Choice, rows: &Rows) -> Result<Rows> {
        let rows =
            choice.files.as_ref().map_or_else(|| Ok(rows.clone()), |files| self.library.select(self.folders, files))?;
        let mut conditions = choice.conditions.clone();
        for condition in &mut conditions {
            for value in condition.values.iter_mut().filter(|value| *value == "@first") {
                *value = rows.first().and_then(|row| row.get(&condition.field)).cloned().unwrap_or("~".to_owned());
            }
        }
        Ok(Rc::new(rows.iter().filter(|row| conditions.iter().all(|c| holds(row, c))).cloned().collect()))
    }

    /// Returns the value of an expression over some rows.
    pub(crate) fn evaluate(&self, expression: &Expression, rows: &Rows) -> Result<Value> {
        match expression {
            Expression::Number(number) => Ok(Value::Number(*number)),
            Expression::Text(text) => Ok(Value::Text(text.clone())),
            Expression::Field(field) => self.field(field, rows),
            Expression::Holds(conditions) => {
                let truth = |row: &Row| conditions.iter().all(|condition| holds(row, condition));
                let items = rows.iter().map(|row| (row.clone(), f64::from(u8::from(truth(row))))).collect();
                Ok(Value::Numbers(Numbers { by: self.by.clone(), items }))
            }
            Expression::OverRows(choice, inner) => self.evaluate(inner, &self.choose(choice, rows)?),
            Expression::Binary(operator, sides) => {
                self.combine(*operator, self.evaluate(&sides[0], rows)?, self.evaluate(&sides[1], rows)?)
            }
            Expression::Call { function, by, arguments } => self.call(function, by, arguments, rows),
        }
    }

    /// Returns the numbers of a field in the rows that have it. It is an error if no row has it, or if a value is not a
    /// number.
    fn field(&self, field: &str, rows: &Rows) -> Result<Value> {
        let mut items = Vec::new();
        for row in rows.iter() {
            let Some(text) = row.get(field).filter(|text| !text.is_empty()) else { continue };
            let number = text.parse().map_err(|_| format!("{field} is {text:?}, not a number"))?;
            items.push((row.clone(), number));
        }
        if items.is_empty() {
            return Err(Failure::missing(format!("none of {} records has {field}", rows.len())));
        }
        Ok(Value::Numbers(Numbers { by: self.by.clone(), items }))
    }

    /// Returns the value of an operator between two values; `/` and `~` divide. A comparison is 1 if true, else 0. A
    /// number is combined with each of several numbers; several numbers on both sides are matched by their rows.
    fn combine(&self, operator: char, left: Value, right: Value) -> Result<Value> {
        let truth = |is_true: bool| f64::from(u8::from(is_true));
        let apply = |a: f64, b: f64| match operator {
            '+' => a + b,
            '-' => a - b,
            '*' => a * b,
            '<' => truth(a < b),
            '>' => truth(a > b),
            '=' => truth(a == b),
            _ => a / b,
        };
        Ok(match (left, right) {
            (Value::Text(a), Value::Text(b)) if operator == '=' => Value::Number(truth(a == b)),
            (Value::Number(a), Value::Number(b)) => Value::Number(apply(a, b)),
            (Value::Numbers(mut a), Value::Number(b)) => {
                a.items.iter_mut().for_each(|(_, number)| *number = apply(*number, b));
                Value::Numbers(a)
            }
            (Value::Number(a), Value::Numbers(mut b)) => {
                b.items.iter_mut().for_each(|(_, number)| *number = apply(a, *number));
                Value::Numbers(b)
            }
            // The quotient ~ leaves out rows that have no partner.
            (Value::Numbers(a), Value::Numbers(b)) => Value::Numbers(match_rows(a, &b, apply, operator == '~')?),
            _ => return Err(format!("{operator} between texts").into()),
        })
    }

    /// Returns the value of a call of a function over some rows. `by` has the fields of the groups for a function that
    /// ends with `_by`.
    fn call(&self, function: &str, by: &[String], arguments: &[Expression], rows: &Rows) -> Result<Value> {
        // Three closures give the argument with the index n: its expression, its value, and its value as a number.
        let argument =
            |n: usize| arguments.get(n).ok_or_else(|| Failure::from(format!("{function} lacks an argument")));
        let value = |n: usize| self.evaluate(argument(n)?, rows);
        let number = |n: usize| value(n)?.number();
        match function {
            "if" => return if number(0)? != 0.0 { value(1) } else { value(2) },
            "or" => return value(0).or_else(|failure| if failure.is_missing { value(1) } else { Err(failure) }),
            "count" if arguments.is_empty() => return Ok(Value::Number(rows.len() as f64)),
            "some" if rows.is_empty() => return Err(Failure::missing("there is no such record")),
            "some" => return Ok(Value::Number(rows.len() as f64)),
            "join" => {
                let texts = (0..arguments.len()).map(|n| value(n)?.text()).collect::<Result<Vec<_>>>()?;
                return Ok(Value::Text(texts.concat()));
            }
            "text" => {
                let Expression::Field(field) = argument(0)? else { return Err("text is of a field".into()) };
                let found = rows.first().and_then(|row| row.get(field));
                return found.cloned().map(Value::Text).ok_or_else(|| Failure::missing(format!("no {field}")));
            }
            "within" => {
                let (checked, low, high) = (number(0)?, number(1)?, number(2)?);
                let fails = || Failure::from(format!("{checked} is not within {low} and {high}"));
                return (low..=high).contains(&checked).then_some(Value::Number(checked)).ok_or_else(fails);
            }
            "max" => return Ok(map(value(0)?, |a, b| a.max(b), number(1)?)),
            _ => {}
        }
        if let Some(function) = number_function(function) {
            return Ok(map(value(0)?, |a, _| function(a), 0.0));
        }
        let first = value(0)?;
        if let (Some(function), Value::Numbers(numbers)) = (function.strip_suffix("_by"), &first) {
            return summarize_groups(function, by, numbers).map(Value::Numbers);
        }
        if let ("part", Value::Numbers(numbers)) = (function, &first) {
            let bounds = (1..arguments.len()).map(number).collect::<Result<Vec<_>>>()?;
            return part(numbers, &bounds).map(Value::Numbers);
        }
        let numbers = first.numbers()?;
        if let Some(number) = summarize(function, &numbers) {
            return number.map(Value::Number);
        }
        // All other functions write numbers; their second argument is the number of decimals.
        let decimals = arguments.get(1).map_or(Ok(2.0), |_| number(1))? as usize;
        let written = format::write(function, &numbers, decimals)?;
        Ok(Value::Text(written.ok_or_else(|| format!("there is no function {function}"))?))
    }
}

/// Returns the numbers from the index `bounds[0]` to before the index `bounds[1]`, in steps of `bounds[2]`. Negative
/// indices are counted from the end. Bounds that are left out mean all numbers and steps of 1.
fn part(numbers: &Numbers, bounds: &[f64]) -> Result<Numbers> {
    let count = numbers.items.len();
    let index = |n: f64| if n < 0.0 { count.saturating_sub(-n as usize) } else { n as usize };
    let (from, to) = (bounds.first().map_or(0, |n| index(*n)), bounds.get(1).map_or(count, |n| index(*n)));
    let step = bounds.get(2).map_or(1, |step| (*step as usize).max(1));
    let items =
        numbers.items.get(from..to).ok_or_else(|| Failure::missing(format!("there is no part {from} to {to}")))?;
    Ok(Numbers { by: numbers.by.clone(), items: items.iter().step_by(step).cloned().collect() })
}

/// Returns the function of a single number that has the given name.
fn number_function(function: &str) -> Option<fn(f64) -> f64> {
    Some(match function {
        "sqrt" => f64::sqrt,
        "ln" => f64::ln,
        "floor" => f64::floor,
        "round" => f64::round,
        _ => return None,
    })
}

/// Replaces each number n of a value by `function(n, other)`; a text stays as it is.
fn map(value: Value, function: impl Fn(f64, f64) -> f64, other: f64) -> Value {
    match value {
        Value::Number(number) => Value::Number(function(number, other)),
        Value::Numbers(mut numbers) => {
            numbers.items.iter_mut().for_each(|(_, number)| *number = function(*number, other));
            Value::Numbers(numbers)
        }
        text => text,
    }
}

/// Makes one number of several by the function of the given name; `None` if there is no such function.
fn summarize(function: &str, numbers: &[f64]) -> Option<Result<f64>> {
    let sum = || numbers.iter().sum::<f64>();
    // A result that needs at least one number.
    let some = |number: f64| if numbers.is_empty() { Err(Failure::missing("there is no number")) } else { Ok(number) };
    Some(match function {
        "median" => median(numbers),
        "mean" => some(sum() / numbers.len() as f64),
        "sum" => Ok(sum()),
        "least" => some(least(numbers)),
        "greatest" => some(greatest(numbers)),
        "first" => some(numbers.first().copied().unwrap_or_default()),
        "last" => some(numbers.last().copied().unwrap_or_default()),
        "count" => Ok(numbers.len() as f64),
        _ => return None,
    })
}

/// Groups the numbers whose rows agree in the fields `by`, and makes one number of each group by the named function.
/// Groups stand in the order of their first rows.
fn summarize_groups(function: &str, by: &[String], numbers: &Numbers) -> Result<Numbers> {
    // For the key of each group: the index of its first row, and its numbers.
    let mut groups: BTreeMap<Vec<String>, (usize, Vec<f64>)> = BTreeMap::new();
    for (n, (row, number)) in numbers.items.iter().enumerate() {
        groups.entry(row_key(row, by)).or_insert_with(|| (n, Vec::new())).1.push(*number);
    }
    let mut groups: Vec<_> = groups.into_values().collect();
    groups.sort_by_key(|(first, _)| *first);
    let summarize_group = |(first, group): (usize, Vec<f64>)| {
        let number = summarize(function, &group).ok_or_else(|| format!("there is no function {function}_by"))??;
        Ok((numbers.items[first].0.clone(), number))
    };
    Ok(Numbers { by: by.to_vec(), items: groups.into_iter().map(summarize_group).collect::<Result<_>>()? })
}

/// Says that the record with a key has no record that it could be matched with.
fn lonely_record(key: &[String]) -> String {
    let values: Vec<&str> = key.iter().map(String::as_str).filter(|value| !value.is_empty()).collect();
    format!("the record of {} has no other beside it", values.join(", "))
}

/// Applies a function to the numbers of two sets, row by row. Rows with the same key belong together, in the order in
/// which they stand; a single row on the right belongs to all rows of its key on the left. Rows on the left without a
/// partner are left out if `is_lenient`, and otherwise an error. Rows on the right without a partner are an error, too,
/// unless `is_lenient`, or the rows on the right are matched by fewer fields.
fn match_rows(left: Numbers, right: &Numbers, apply: impl Fn(f64, f64) -> f64, is_lenient: bool) -> Result<Numbers> {
    let by: Vec<String> = left.by.iter().filter(|field| right.by.contains(field)).cloned().collect();
    // The numbers on the right by their key.
    let mut partners: HashMap<Vec<String>, Vec<f64>> = HashMap::new();
    for (row, number) in &right.items {
        partners.entry(row_key(row, &by)).or_default().push(*number);
    }
    // For each key, the number of rows on the left so far.
    let mut seen: HashMap<Vec<String>, usize> = HashMap::new();
    let mut items = Vec::new();
    for (row, number) in &left.items {
        let key = row_key(row, &by);
        let place = seen.entry(key.clone()).or_default();
        let partner = partners
            .get(&key)
            .and_then(|numbers| if let [only] = numbers[..] { Some(only) } else { numbers.get(*place).copied() });
        *place += 1;
        match partner {
            Some(other) => items.push((row.clone(), apply(*number, other))),
            None if is_lenient => {}
            None => return Err(Failure::missing(lonely_record(&key))),
        }
    }
    let is_whole_key = by.len() == left.by.len();
    let lonely = right
        .items
        .iter()
        .map(|(row, _)| row_key(row, &by))
        .find(|key| seen.get(key).copied().unwrap_or_default() < partners[key].len());
    if let Some(key) = lonely.filter(|_| is_whole_key && !is_lenient) {
        return Err(lonely_record(&key).into());
    }
    Ok(Numbers { by: left.by, items })
}
