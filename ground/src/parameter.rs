//! Parameters: what a user can change about a method. Each is declared once, as a field of a struct made by
//! [`parameters!`](crate::parameter::parameters). From this declaration are derived: the command line's flags, the
//! window's panel and the table in `docs/options.md`; the `setup` of records, the keys of journals and the columns of
//! CSV files. Sweeps of the error study and the pairing of comparisons follow it, too.

mod domain;

use crate::error::{Error, Result};
pub use domain::{Choice, Domain};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// A value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// On or off.
    Switch(bool),
    /// A whole number.
    Count(u32),
    /// A finite number.
    Number(f32),
    /// The name of one of several choices.
    Choice(&'static str),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Switch(on) => f.write_str(if *on { "on" } else { "off" }),
            Self::Count(n) => n.fmt(f),
            Self::Number(n) => n.fmt(f),
            Self::Choice(name) => f.write_str(name),
        }
    }
}

/// Writes a value for records. A number is written as its decimal, such as 0.1, and not as a longer binary fraction.
impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Switch(on) => serializer.serialize_bool(*on),
            Self::Count(n) => serializer.serialize_u32(*n),
            Self::Number(n) => serializer.serialize_f64(n.to_string().parse().unwrap_or(f64::NAN)),
            Self::Choice(name) => serializer.serialize_str(name),
        }
    }
}

choices! {
    /// Whose constants a published method uses.
    pub enum Preset {
        /// What the thesis prints; the author's value where it prints nothing, and for the cone's angle.
        Published = "published",
        /// The author's own program.
        Author = "author",
    }
}

/// The description of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The name in records, in snake case.
    pub name: &'static str,
    /// What the parameter does, as a sentence.
    pub help: String,
    /// Unit of a number; empty for none.
    pub unit: &'static str,
    /// Which values it takes.
    pub domain: Domain,
    /// The published value, or this project's if none is published. This value is the default.
    pub published: Value,
    /// The value in the author's own program.
    pub author: Value,
    /// The source of the published value.
    pub source: &'static str,
    /// Values that the study of run time against error tries, beside the preset's.
    pub sweep: Vec<(Preset, Value)>,
}

impl Parameter {
    /// Makes a parameter with one value for both presets; the functions below set the rest.
    pub fn new<T: Field>(published: T) -> Self {
        let published = published.value();
        Self {
            name: "",
            help: String::new(),
            unit: "",
            domain: T::domain(),
            published,
            author: published,
            source: "",
            sweep: Vec::new(),
        }
    }

    /// Sets the value in the author's own program.
    pub fn author<T: Field>(self, value: T) -> Self {
        Self { author: value.value(), ..self }
    }

    /// Allows whole numbers from `least` to `most`.
    pub fn within(self, least: u32, most: u32) -> Self {
        Self { domain: Domain::Count(least, most), ..self }
    }

    /// Allows numbers from `least` to `most`.
    pub fn between(self, least: f32, most: f32) -> Self {
        Self { domain: Domain::Number { least, with_least: true, most }, ..self }
    }

    /// Allows numbers above `least`, up to `most`.
    pub fn above(self, least: f32, most: f32) -> Self {
        Self { domain: Domain::Number { least, with_least: false, most }, ..self }
    }

    /// Allows these numbers alone.
    pub fn one_of(self, numbers: &'static [f32]) -> Self {
        Self { domain: Domain::Numbers(numbers), ..self }
    }

    /// Sets the unit.
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Sets the source of the published value.
    pub fn source(self, source: &'static str) -> Self {
        Self { source, ..self }
    }

    /// Adds values that the error study tries around a preset.
    pub fn sweep<T: Field>(mut self, preset: Preset, values: &[T]) -> Self {
        self.sweep.extend(values.iter().map(|v| (preset, v.value())));
        self
    }

    /// Sets the name, and the help without spaces around it: a line of a doc comment begins with a space.
    #[doc(hidden)]
    pub fn named(self, name: &'static str, help: &str) -> Self {
        Self { name, help: help.trim().to_owned(), ..self }
    }

    /// The value of a preset.
    pub fn preset_value(&self, preset: Preset) -> Value {
        match preset {
            Preset::Published => self.published,
            Preset::Author => self.author,
        }
    }

    /// The name as it is typed: in kebab case.
    pub fn typed_name(&self) -> String {
        self.name.replace('_', "-")
    }

    /// Reads a value from text.
    ///
    /// # Errors
    /// [`Error::Usage`] with the values that the parameter takes.
    pub fn parse(&self, text: &str) -> Result<Value> {
        let text = text.trim();
        self.domain
            .read(text)
            .ok_or_else(|| Error::Usage(format!("{} is {text:?}; it takes {}", self.typed_name(), self.domain)))
    }
}

/// A type of Rust that the value of a parameter has.
pub trait Field: Copy + PartialEq {
    /// Every value of the type.
    fn domain() -> Domain;
    /// Converts to a value.
    fn value(self) -> Value;
    /// Converts from a value; `None` if the value is of another type.
    fn from_value(value: Value) -> Option<Self>;
}

impl Field for bool {
    fn domain() -> Domain {
        Domain::Switch
    }

    fn value(self) -> Value {
        Value::Switch(self)
    }

    fn from_value(value: Value) -> Option<Self> {
        if let Value::Switch(on) = value { Some(on) } else { None }
    }
}

impl Field for u32 {
    fn domain() -> Domain {
        Domain::Count(0, Self::MAX)
    }

    fn value(self) -> Value {
        Value::Count(self)
    }

    fn from_value(value: Value) -> Option<Self> {
        if let Value::Count(n) = value { Some(n) } else { None }
    }
}

impl Field for f32 {
    fn domain() -> Domain {
        Domain::Number { least: Self::MIN, with_least: true, most: Self::MAX }
    }

    fn value(self) -> Value {
        Value::Number(self)
    }

    fn from_value(value: Value) -> Option<Self> {
        if let Value::Number(n) = value { Some(n) } else { None }
    }
}

/// A type of few values with names.
pub trait Choices: Copy + PartialEq + 'static {
    /// Every value, the default first.
    const ALL: &'static [Self];
    /// Their names, in the same order.
    const CHOICES: &'static [Choice];

    /// The name of the value.
    fn name(self) -> &'static str {
        Self::ALL.iter().position(|v| *v == self).map_or("", |n| Self::CHOICES[n].name)
    }

    /// Returns the value with a name; `None` if no value has it.
    fn of_name(name: &str) -> Option<Self> {
        Self::CHOICES.iter().position(|c| c.name == name).map(|n| Self::ALL[n])
    }
}

impl<T: Choices> Field for T {
    fn domain() -> Domain {
        Domain::Choices(T::CHOICES)
    }

    fn value(self) -> Value {
        Value::Choice(self.name())
    }

    fn from_value(value: Value) -> Option<Self> {
        if let Value::Choice(name) = value { Self::of_name(name) } else { None }
    }
}

/// Parameters as a struct; [`parameters!`](crate::parameter::parameters) makes one.
pub trait Parameters: Sized {
    /// The descriptions of the parameters, in the order of the fields.
    fn table() -> Vec<Parameter>;
    /// Makes the struct from given values, and from their preset for parameters that are not given.
    fn from_values(values: &Values) -> Self;
    /// Each value, in the order of the fields.
    fn list(&self) -> Vec<Value>;
}

/// Values that were given to parameters, by the parameters' names. Any other parameter has the preset's value. There
/// may be values for several methods, each of which reads its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values {
    /// The preset that gives the values of all other parameters.
    pub preset: Preset,
    given: BTreeMap<&'static str, Value>,
}

impl Values {
    /// The value of a parameter: the one that was given, if the parameter's domain has it, or else the preset's.
    pub fn value(&self, parameter: &Parameter) -> Value {
        let given = self.given.get(parameter.name).copied().filter(|v| parameter.domain.has(*v));
        given.unwrap_or_else(|| parameter.preset_value(self.preset))
    }

    /// Gives a parameter a value.
    pub fn set(&mut self, parameter: &Parameter, value: Value) {
        self.given.insert(parameter.name, value);
    }

    /// The names of the parameters that were given a value.
    pub fn given_names(&self) -> impl Iterator<Item = &'static str> {
        self.given.keys().copied()
    }

    /// Returns these values with some parameters changed by a function; only those that it changes are given a value.
    #[must_use]
    pub fn with<P: Parameters>(&self, change: impl FnOnce(&mut P)) -> Self {
        let mut parameters = P::from_values(self);
        let before = parameters.list();
        change(&mut parameters);
        let mut changed = self.clone();
        for ((parameter, before), after) in P::table().iter().zip(before).zip(parameters.list()) {
            if before != after {
                changed.set(parameter, after);
            }
        }
        changed
    }
}

/// Used by [`parameters!`](crate::parameter::parameters): the value of a named parameter in a field's type.
#[doc(hidden)]
pub fn field_value<T: Field>(values: &Values, parameter: &Parameter) -> T {
    let value = T::from_value(values.value(parameter));
    // The conversion of the published value succeeds, since that value was made from a T.
    value.or_else(|| T::from_value(parameter.published)).unwrap_or_else(|| unreachable!("{}", parameter.name))
}

/// Declares a struct of parameters. A field is declared as
/// `/// What it does.` `name: type = Parameter::new(published).author(…).within(…).source("…")`, or, without a value,
/// as a group: `name: OtherParameters`.
#[macro_export]
#[doc(hidden)]
macro_rules! parameters {
    ($(#[$attribute:meta])* $visible:vis struct $name:ident {
        $($(#[doc = $help:literal])+ $field:ident: $type:ty $(= $row:expr)?,)*
    }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        $visible struct $name {
            $($(#[doc = $help])+ pub $field: $type,)*
        }

        impl $crate::parameter::Parameters for $name {
            fn table() -> Vec<$crate::parameter::Parameter> {
                [$($crate::parameter::parameters!(@row $field $type, concat!($($help),+) $(, $row)?)),*].concat()
            }

            fn from_values(values: &$crate::parameter::Values) -> Self {
                Self { $($field: $crate::parameter::parameters!(@value values $field $type $(, $row)?),)* }
            }

            fn list(&self) -> Vec<$crate::parameter::Value> {
                [$($crate::parameter::parameters!(@list self.$field $(, $row)?)),*].concat()
            }
        }
    };
    (@row $field:ident $type:ty, $help:expr) => { <$type as $crate::parameter::Parameters>::table() };
    (@row $field:ident $type:ty, $help:expr, $row:expr) => { vec![$row.named(stringify!($field), $help)] };
    (@value $values:ident $field:ident $type:ty) => { <$type as $crate::parameter::Parameters>::from_values($values) };
    (@value $values:ident $field:ident $type:ty, $row:expr) => {
        $crate::parameter::field_value::<$type>($values, &$row.named(stringify!($field), ""))
    };
    (@list $self:ident.$field:ident) => { $crate::parameter::Parameters::list(&$self.$field) };
    (@list $self:ident.$field:ident, $row:expr) => { vec![$crate::parameter::Field::value($self.$field)] };
}
pub use parameters;

/// Declares an enum whose values have names, the first of which is the default: `/// What it does.` `Value = "name",`, or
/// `Value(CODE) = "name",` if a shader knows the value by a code.
#[macro_export]
#[doc(hidden)]
macro_rules! choices {
    ($(#[$attribute:meta])* $visible:vis enum $name:ident {
        $($(#[doc = $help:literal])+ $value:ident $(($code:expr))? = $text:literal,)+
    }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $visible enum $name {
            $($(#[doc = $help])+ $value $(= $code as isize)?,)+
        }

        impl $crate::parameter::Choices for $name {
            const ALL: &'static [Self] = &[$(Self::$value),+];
            const CHOICES: &'static [$crate::parameter::Choice] =
                &[$($crate::parameter::Choice { name: $text, help: concat!($($help),+) }),+];
        }

        impl Default for $name {
            fn default() -> Self {
                <Self as $crate::parameter::Choices>::ALL[0]
            }
        }
    };
}
pub use choices;

impl Serialize for Preset {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Preset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::of_name(&name).ok_or_else(|| serde::de::Error::custom(format!("there is no preset {name:?}")))
    }
}

#[cfg(test)]
mod tests;
