//! Numbers of the camera, given in the map or in an attribute of a file.

use super::files::{AttributeName, MapFiles};
use exr::meta::attribute::AttributeValue;
use ssct_ground::Result;

/// Source of a number or of a matrix.
#[derive(Debug, Clone)]
pub(super) struct MapNumbers {
    /// The section and the key, for errors.
    pub key: String,
    /// The line of the key in the map.
    pub line: usize,
    /// How many numbers the key has: 1 for a number, 16 for a matrix.
    pub count: usize,
    pub from: NumbersFrom,
}

/// The place of numbers: in the map itself, or in an attribute of a file.
#[derive(Debug, Clone)]
pub(super) enum NumbersFrom {
    Here(Vec<f64>),
    Attribute(AttributeName),
}

impl MapNumbers {
    /// The [`Self::count`] numbers.
    ///
    /// # Errors
    /// [`Error::Malformed`](ssct_ground::Error::Malformed) for an attribute that is not [`Self::count`] finite
    /// numbers; the errors of [`MapFiles::attribute`].
    pub fn get(&self, files: &mut MapFiles) -> Result<Vec<f64>> {
        let name = match &self.from {
            NumbersFrom::Here(numbers) => return Ok(numbers.clone()),
            NumbersFrom::Attribute(name) => name,
        };
        let value = files.attribute(name, self.line, &self.key)?;
        let numbers = numbers_of(&value).filter(|n| n.len() == self.count && n.iter().all(|v| v.is_finite()));
        numbers.ok_or_else(|| {
            let many = if self.count == 1 { "one finite number".to_owned() } else { format!("{} numbers", self.count) };
            let message = format!("{}: the attribute {:?} is not {many}", self.key, name.name);
            files.error(self.line, message)
        })
    }

    /// The number, if [`Self::count`] is 1.
    ///
    /// # Errors
    /// The errors of [`Self::get`].
    pub fn one(&self, files: &mut MapFiles) -> Result<f64> {
        // The list is not empty, since `count` is 1.
        Ok(self.get(files)?.first().copied().unwrap_or_default())
    }
}

/// The numbers of an attribute; in a text, blanks or commas separate the numbers. `None` for an attribute without
/// numbers.
fn numbers_of(value: &AttributeValue) -> Option<Vec<f64>> {
    let of_text = |text: &str| {
        let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>()
    };
    Some(match value {
        AttributeValue::F32(v) => vec![f64::from(*v)],
        AttributeValue::F64(v) => vec![*v],
        AttributeValue::I32(v) => vec![f64::from(*v)],
        AttributeValue::Rational((over, under)) => vec![f64::from(*over) / f64::from(*under)],
        AttributeValue::FloatVec2(v) => vec![f64::from(v.0), f64::from(v.1)],
        AttributeValue::FloatVec3((x, y, z)) => [*x, *y, *z].map(f64::from).to_vec(),
        AttributeValue::Matrix4x4(m) => m.map(f64::from).to_vec(),
        AttributeValue::Text(text) => of_text(&text.to_string())?,
        _ => return None,
    })
}
