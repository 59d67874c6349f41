//! The values that a parameter takes, how they are read from text, and how they are described to a user.

use super::Value;
use std::fmt;

/// One of the choices of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The choice's name.
    pub name: &'static str,
    /// What the choice does.
    pub help: &'static str,
}

/// Which values a parameter takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Domain {
    /// On and off.
    Switch,
    /// Whole numbers from the first to the second, both included.
    Count(u32, u32),
    /// Numbers between two bounds. The upper bound is included, and the lower bound is if `with_least` is true.
    Number {
        /// Lower bound.
        least: f32,
        /// Whether the lower bound itself is a value.
        with_least: bool,
        /// Upper bound, a value itself.
        most: f32,
    },
    /// These numbers alone.
    Numbers(&'static [f32]),
    /// One of these choices.
    Choices(&'static [Choice]),
    /// One of these choices, or a whole number from the first to the second, both included.
    ChoicesOrCount(&'static [Choice], u32, u32),
}

impl Domain {
    /// Whether a value is in the domain.
    pub fn has(&self, value: Value) -> bool {
        match (self, value) {
            (Self::Switch, Value::Switch(_)) => true,
            (Self::Count(least, most), Value::Count(n)) => (*least..=*most).contains(&n),
            (Self::Number { least, with_least, most }, Value::Number(n)) => {
                n <= *most && (n > *least || *with_least && n == *least)
            }
            (Self::Numbers(numbers), Value::Number(n)) => numbers.contains(&n),
            (Self::Choices(choices) | Self::ChoicesOrCount(choices, ..), Value::Choice(name)) => {
                choices.iter().any(|c| c.name == name)
            }
            (Self::ChoicesOrCount(_, least, most), Value::Count(n)) => (*least..=*most).contains(&n),
            _ => false,
        }
    }

    /// Reads a value of the domain from text; `None` if the domain has no such value.
    pub(super) fn read(&self, text: &str) -> Option<Value> {
        let value = match self {
            Self::Switch => match text {
                "on" => Some(Value::Switch(true)),
                "off" => Some(Value::Switch(false)),
                _ => None,
            },
            Self::Count(..) => text.parse().ok().map(Value::Count),
            Self::Number { .. } | Self::Numbers(_) => text.parse().ok().map(Value::Number),
            Self::Choices(choices) => choice_named(choices, text),
            Self::ChoicesOrCount(choices, ..) => {
                choice_named(choices, text).or_else(|| text.parse().ok().map(Value::Count))
            }
        };
        value.filter(|v| self.has(*v))
    }

    /// Whether the only values are on and off, either as a switch or as a list of the two choices `on` and `off`.
    pub fn is_switch(&self) -> bool {
        match self {
            Self::Switch => true,
            Self::Choices(choices) => choices.len() == 2 && choices.iter().all(|c| ["on", "off"].contains(&c.name)),
            _ => false,
        }
    }

    /// Returns every value of the domain, or `None` for a range of numbers without choices.
    pub fn all_if_few(&self) -> Option<Vec<Value>> {
        match self {
            Self::Switch => Some(vec![Value::Switch(true), Value::Switch(false)]),
            Self::Numbers(numbers) => Some(numbers.iter().map(|n| Value::Number(*n)).collect()),
            Self::Choices(choices) => Some(choices.iter().map(|c| Value::Choice(c.name)).collect()),
            Self::ChoicesOrCount(choices, least, most) => {
                let names = choices.iter().map(|c| Value::Choice(c.name));
                Some(names.chain((*least..=*most).map(Value::Count)).collect())
            }
            Self::Count(..) | Self::Number { .. } => None,
        }
    }
}

/// Describes the values to a reader: "whole numbers from 1 to 64", "numbers above 0 and at most 1", "mip, gaussian".
impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Self::ChoicesOrCount(choices, least, most) = self {
            let names: Vec<_> = choices.iter().map(|c| c.name).collect();
            return write!(f, "{}, or whole numbers from {least} to {most}", names.join(", "));
        }
        if let Some(few) = self.all_if_few() {
            let names: Vec<_> = few.iter().map(Value::to_string).collect();
            return f.write_str(&names.join(", "));
        }
        match self {
            Self::Count(least, most) => write!(f, "whole numbers from {least} to {most}"),
            Self::Number { least, with_least: true, most } => write!(f, "numbers from {least} to {most}"),
            Self::Number { least, most, .. } => write!(f, "numbers above {least} and at most {most}"),
            _ => Ok(()),
        }
    }
}

/// The choice with a name, as a value; `None` if no choice has the name.
fn choice_named(choices: &[Choice], name: &str) -> Option<Value> {
    choices.iter().find(|c| c.name == name).map(|c| Value::Choice(c.name))
}
