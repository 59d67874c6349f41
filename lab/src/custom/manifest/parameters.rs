//! The parameters that a manifest declares, as the tables of methods have them.

use super::sections::ParameterSection;
use super::{Manifest, is_word};
use ssct_ground::Result;
use ssct_ground::parameter::{Choice, Domain, Parameter, Preset, Value};
use std::collections::BTreeSet;
use toml::Spanned;

impl Manifest {
    /// Returns the method's own parameters, none of which may have a name in `reserved`. Their texts live as long as
    /// the program.
    pub fn parameters(&self, reserved: &BTreeSet<String>) -> Result<Vec<Parameter>> {
        self.parameters.iter().map(|(name, section)| self.parameter(name, section, reserved)).collect()
    }

    /// Makes and checks one parameter. Its name is `name` with underscores in place of hyphens.
    fn parameter(
        &self,
        name: &str,
        section: &Spanned<ParameterSection>,
        reserved: &BTreeSet<String>,
    ) -> Result<Parameter> {
        let span = section.span();
        let declaration = section.get_ref();
        let wrong = |message: &str| self.error(&span, format!("parameter {name}: {message}"));
        let leak = |text: &str| -> &'static str { text.to_owned().leak() };
        if !is_word(name) {
            return Err(wrong("the name must consist of small letters, digits and hyphens"));
        }
        if reserved.contains(name) {
            return Err(wrong("the option of this name belongs to the program; choose another name"));
        }
        let choices: &'static [Choice] =
            declaration.choices.iter().map(|c| Choice { name: leak(c), help: "" }).collect::<Vec<_>>().leak();
        // The value of the parameter that a value of the manifest stands for, if it has a type that parameters have.
        let value = |value: &toml::Value| -> Option<Value> {
            Some(match value {
                toml::Value::Boolean(on) => Value::Switch(*on),
                toml::Value::Integer(n) => Value::Count(u32::try_from(*n).ok()?),
                toml::Value::Float(n) => Value::Number(*n as f32),
                toml::Value::String(s) => Value::Choice(choices.iter().find(|c| c.name == s)?.name),
                _ => return None,
            })
        };
        let wrong_default =
            "the default must be true, false, a number, or one of the choices; 1.0 is a number, 1 a whole one";
        let published = value(&declaration.default).ok_or_else(|| wrong(wrong_default))?;
        let domain = match (published, declaration.range) {
            (Value::Switch(_), None) => Domain::Switch,
            (Value::Choice(_), None) => Domain::Choices(choices),
            (Value::Count(_), Some([least, most])) => Domain::Count(least as u32, most as u32),
            (Value::Number(_), Some([least, most])) => {
                Domain::Number { least: least as f32, with_least: true, most: most as f32 }
            }
            (Value::Count(_) | Value::Number(_), None) => return Err(wrong("a number needs a range")),
            _ => return Err(wrong("only numbers have a range")),
        };
        let sweep =
            declaration.sweep.iter().map(|v| value(v).ok_or_else(|| wrong("the sweep has values of another type")));
        let sweep: Vec<Value> = sweep.collect::<Result<_>>()?;
        if let Some(outside) = [published].iter().chain(&sweep).find(|v| !domain.has(**v)) {
            return Err(wrong(&format!("{outside} is outside {domain}")));
        }
        let help = declaration.help.trim();
        let help = if help.ends_with('.') { help.to_owned() } else { format!("{help}.") };
        let name: &'static str = name.replace('-', "_").leak();
        if ssct::methods::parameters().iter().any(|(p, _)| p.name == name && p.domain != domain) {
            return Err(wrong("another method has a parameter of this name that takes other values; rename it"));
        }
        Ok(Parameter {
            name,
            help,
            unit: leak(&declaration.unit),
            domain,
            published,
            author: published,
            source: leak(&self.name),
            sweep: sweep.into_iter().map(|v| (Preset::Published, v)).collect(),
        })
    }
}
