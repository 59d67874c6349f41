//! Parses the JSON of a document to the types of the crate `gltf`. Errors about values of a wrong type use the words of
//! JSON.

use gltf::json::Root;
use serde_json::Value;

/// Parses a JSON value as a glTF document.
///
/// # Errors
/// A message with the place, such as `materials[0].pbrMetallicRoughness.roughnessFactor`, the value found there, and
/// what is expected.
pub(super) fn parse_typed(value: Value) -> Result<Root, String> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let place = error.path().to_string();
        let problem = in_words(&error.inner().to_string());
        if place == "." { format!("the document: {problem}") } else { format!("{place}: {problem}") }
    })
}

/// Rewrites a message of serde about a value in the words of JSON; other messages are returned unchanged.
fn in_words(message: &str) -> String {
    let type_message = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "));
    if let Some((found, expected)) = type_message.and_then(|rest| rest.rsplit_once(", expected ")) {
        return format!("{} where {} belongs", found_in_words(found), expected_in_words(expected));
    }
    if let Some(field) = message.strip_prefix("missing field ") {
        return format!("it has no {}", field.trim_matches('`'));
    }
    if let Some((length, expected)) =
        message.strip_prefix("invalid length ").and_then(|rest| rest.rsplit_once(", expected "))
    {
        return format!("a list of {length} where {} belongs", expected_in_words(expected));
    }
    message.to_owned()
}

/// Names the value that serde found in the words of JSON, such as `a text` for `string "0.5"`.
fn found_in_words(found: &str) -> String {
    let kind = found.split(['`', '"']).next().unwrap_or(found).trim();
    match kind {
        "string" => "a text".to_owned(),
        "map" => "an object".to_owned(),
        "sequence" => "a list".to_owned(),
        "boolean" => "true or false".to_owned(),
        "null" | "unit value" => "nothing".to_owned(),
        "integer" | "floating point" => match found.split('`').nth(1) {
            Some(number) => format!("the number {number}"),
            None => "a number".to_owned(),
        },
        other => other.to_owned(),
    }
}

/// Names the value that serde expected in the words of JSON, such as `a number` for `f32`.
fn expected_in_words(expected: &str) -> String {
    let expected = expected.trim();
    let is_integer = |sign: char| expected.strip_prefix(sign).is_some_and(|bits| bits.parse::<u32>().is_ok());
    match expected {
        "f32" | "f64" => "a number".to_owned(),
        "a string" | "string" | "str" => "a text".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a map" => "an object".to_owned(),
        "usize" | "index into child of root" => "a whole number of at least 0".to_owned(),
        _ if is_integer('u') => "a whole number of at least 0".to_owned(),
        _ if is_integer('i') => "a whole number".to_owned(),
        text if text.starts_with("struct ") => "an object".to_owned(),
        text => match text.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} numbers"),
            None => text.to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_library_become_those_of_json() {
        for (message, words) in [
            ("invalid type: string \"0.5\", expected f32", "a text where a number belongs"),
            ("invalid type: map, expected a sequence", "an object where a list belongs"),
            ("invalid type: string \"main\", expected u32", "a text where a whole number of at least 0 belongs"),
            ("invalid value: integer `-1`, expected u32", "the number -1 where a whole number of at least 0 belongs"),
            (
                "invalid type: floating point `1.5`, expected u64",
                "the number 1.5 where a whole number of at least 0 belongs",
            ),
            ("invalid type: boolean `true`, expected struct Asset", "true or false where an object belongs"),
            ("missing field `attributes`", "it has no attributes"),
            ("invalid length 2, expected an array of length 3", "a list of 2 where a list of 3 numbers belongs"),
            ("invalid type: string \", expected é\", expected f32", "a text where a number belongs"),
            ("something new", "something new"),
        ] {
            assert_eq!(in_words(message), words);
        }
    }
}
