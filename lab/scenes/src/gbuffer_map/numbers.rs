//! Numbers of the camera, given in the map or in an attribute of a file.

use super::files::{AttributeName, MapFiles};
use exr::meta::attribute::AttributeValue;
use ssct_ground::Result;

/// The numbers of one key: a number, a vector or a matrix.
#[derive(Debug, Clone)]
pub(super) struct MapNumbers {
    /// The section and the key, for errors.
    pub key: String,
    /// The line of the key in the map.
    pub line: usize,
    /// How many numbers the key has, such as 1 for a number and 16 for a matrix.
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
    /// Returns the [`Self::count`] numbers, which may be read from a file.
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
        let numbers = numbers_of(&value).filter(|list| list.len() == self.count && list.iter().all(|v| v.is_finite()));
        numbers.ok_or_else(|| {
            let expected =
                if self.count == 1 { "one finite number".to_owned() } else { format!("{} numbers", self.count) };
            let message = format!("{}: the attribute {:?} is not {expected}", self.key, name.name);
            files.error(self.line, message)
        })
    }

    /// Returns the only number of a key whose [`Self::count`] is 1.
    ///
    /// # Errors
    /// The errors of [`Self::get`].
    pub fn single(&self, files: &mut MapFiles) -> Result<f64> {
        // The list is not empty, since `count` is 1.
        Ok(self.get(files)?.first().copied().unwrap_or_default())
    }
}

/// Returns the numbers of an attribute; in a text, blanks or commas separate the numbers. The result is `None` if the
/// attribute holds anything else.
fn numbers_of(value: &AttributeValue) -> Option<Vec<f64>> {
    let numbers_of_text = |text: &str| {
        let words = text.split(|letter: char| letter.is_whitespace() || letter == ',').filter(|word| !word.is_empty());
        words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>()
    };
    Some(match value {
        AttributeValue::F32(number) => vec![f64::from(*number)],
        AttributeValue::F64(number) => vec![*number],
        AttributeValue::I32(number) => vec![f64::from(*number)],
        AttributeValue::Rational((numerator, denominator)) => vec![f64::from(*numerator) / f64::from(*denominator)],
        AttributeValue::FloatVec2(vector) => vec![f64::from(vector.0), f64::from(vector.1)],
        AttributeValue::FloatVec3((x, y, z)) => [*x, *y, *z].map(f64::from).to_vec(),
        AttributeValue::Matrix4x4(matrix) => matrix.map(f64::from).to_vec(),
        AttributeValue::Text(text) => numbers_of_text(&text.to_string())?,
        _ => return None,
    })
}
