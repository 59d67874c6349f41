//! Checks whether the values of records in a file are possible. A foreign or damaged file is refused if it has a value
//! that no measurement gives.

use super::columns::Columns;
use super::names::safe_word;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The greatest width or height of an image.
const MOST_PIXELS: f64 = 65536.0;

/// The field of a record with everything that was set. It is not checked, since its numbers have the ranges of their
/// parameters.
const SETUP: &str = "setup";

/// Says why a record of the row type `R` is impossible, as the end of a sentence that begins with the record; `None` if
/// it is possible.
pub fn fault<R: Columns>(record: &Value) -> Option<String> {
    let mut ranges = R::columns().ranges;
    ranges.extend(["width", "height"].map(|name| (name, [1.0, MOST_PIXELS])));
    range_fault(record, &ranges)
}

/// Finds the first fault among the fields of a value, at whatever depth; `ranges` has the least and the greatest number
/// of fields, by their names.
fn range_fault(value: &Value, ranges: &BTreeMap<&'static str, [f64; 2]>) -> Option<String> {
    match value {
        Value::Array(items) => items.iter().find_map(|item| range_fault(item, ranges)),
        Value::Object(fields) => {
            fields.iter().filter(|(name, _)| *name != SETUP).find_map(|(name, value)| field_fault(name, value, ranges))
        }
        _ => None,
    }
}

/// Finds the fault of a field: a number out of its range, a method's name that is not safe in a file's name, or a fault
/// in a part of the value. `None` if the value is possible.
fn field_fault(name: &str, value: &Value, ranges: &BTreeMap<&'static str, [f64; 2]>) -> Option<String> {
    if let (Some([least, most]), Some(number)) = (ranges.get(name), value.as_f64()) {
        let is_possible = number >= *least && number <= *most;
        return (!is_possible).then(|| format!("has the {name} {number}, which cannot be"));
    }
    // Names of methods are used in names of files, and must be safe there.
    if let ("method", Some(method)) = (name, value.as_str()) {
        let is_safe = safe_word(method) == method;
        return (!is_safe).then(|| format!("has the method {method:?}, which is no name of a method"));
    }
    range_fault(value, ranges)
}

/// Names of the fields of samples that are durations in milliseconds.
const DURATIONS: [&str; 4] = ["ms", "frame_ms", "record_ms", "wait_ms"];

/// Says why a sample of times is impossible, as the end of a sentence that begins with the sample; `None` if no
/// duration is negative.
pub fn fault_of_sample(sample: &Value) -> Option<String> {
    /// Finds the first negative duration among some fields, at whatever depth.
    fn negative(fields: &Map<String, Value>) -> Option<String> {
        fields.iter().find_map(|(name, value)| match value {
            Value::Number(n) if DURATIONS.contains(&name.as_str()) && n.as_f64().is_some_and(|n| n < 0.0) => {
                Some(format!("has the {name} {n}"))
            }
            Value::Object(fields) => negative(fields),
            Value::Array(items) => items.iter().filter_map(Value::as_object).find_map(negative),
            _ => None,
        })
    }
    match sample {
        Value::Object(fields) => negative(fields).map(|duration| format!("{duration}, which cannot be")),
        _ => Some("is no sample of times".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::columns::{columns, figure, time};
    use serde_json::json;

    columns! {
        /// A row.
        struct Row {
            pub rmse: f64 = figure(""),
            pub agreement: f64 = figure("").share(),
            pub quality: f64 = figure("").signed(),
            pub time_ms: f64 = time(""),
        }
    }

    #[test]
    fn an_impossible_value_of_a_record_or_a_sample_is_found_and_named() {
        let good = json!({
            "width": 8, "height": 8, "rmse": 0.0, "agreement": 1.0, "quality": -3.0, "time_ms": 1.5, "method": "ssct",
            "captures": [[-1.0, 0.0, 2.0]], "setup": {"rmse": -1.0}, "missing": null,
        });
        assert_eq!(fault::<Row>(&good), None);
        for (name, value, message) in [
            ("rmse", json!(-1e-9), "has the rmse -0.000000001, which cannot be"),
            ("agreement", json!(1.5), "has the agreement 1.5, which cannot be"),
            ("time_ms", json!(-1.0), "has the time_ms -1, which cannot be"),
            ("width", json!(0), "has the width 0, which cannot be"),
            ("height", json!(1e9), "has the height 1000000000, which cannot be"),
            ("method", json!("x/../../y"), "has the method \"x/../../y\", which is no name of a method"),
            ("frames", json!([{"rmse": -2.0}]), "has the rmse -2, which cannot be"),
        ] {
            let mut bad = good.clone();
            bad[name] = value;
            assert_eq!(fault::<Row>(&bad).as_deref(), Some(message));
        }
        assert_eq!(fault_of_sample(&json!({"report": {"passes": [{"ms": 1.0}]}})), None);
        let negative = json!({"report": {"passes": [{"ms": -1.0}]}});
        assert_eq!(fault_of_sample(&negative).as_deref(), Some("has the ms -1.0, which cannot be"));
        assert!(fault_of_sample(&json!(1)).is_some());
    }
}
