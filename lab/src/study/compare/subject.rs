//! The subject of a frame: the scene, view, method and settings that the frame was drawn with. Also finds how two
//! subjects differ.

use serde::{Serialize, Serializer};
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};

/// The subject of a frame: scene, view, method and everything that was set, by name. A setting that the method does not have,
/// or that a file does not give, is missing.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Subject(pub BTreeMap<String, String>);

/// The values in which two subjects must be equal before their differences are listed.
const LIKE: [&str; 3] = ["scene", "view", "method"];

/// Names of the values that decide how much work the scene passes do.
const WORK: [&str; 8] = ["scene", "view", "width", "height", "fov_degrees", "near_m", "far_m", "orthographic_height_m"];

/// Names of values that belong to the place of a measurement: methods and their parameters are compared within one place.
pub(super) const PLACE: [&str; 11] = [
    "scene",
    "view",
    "width",
    "height",
    "roughness",
    "normal_deviation",
    "reflectivity",
    "fov_degrees",
    "near_m",
    "far_m",
    "orthographic_height_m",
];

/// Word in tables for a value that no option set.
pub(super) const NOT_SET: &str = "own";

impl Subject {
    /// A value as its file has it; empty if it is null or not known.
    pub fn get(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// The values that belong to the place of the measurement, in the order of `PLACE`.
    pub fn place(&self) -> [&str; PLACE.len()] {
        PLACE.map(|name| self.get(name))
    }

    /// Whether two subjects have the same scene, view and method.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        LIKE.iter().all(|name| self.get(name) == other.get(name))
    }

    /// Whether the scene passes do the same work for both subjects.
    pub(super) fn is_same_work(&self, other: &Self) -> bool {
        WORK.iter().all(|name| self.get(name) == other.get(name))
    }

    /// The names of the values in which two subjects differ.
    pub(super) fn differing<'s>(&'s self, other: &'s Self) -> Vec<&'s str> {
        let names: BTreeSet<&String> = self.0.keys().chain(other.0.keys()).collect();
        names.into_iter().map(String::as_str).filter(|name| self.get(name) != other.get(name)).collect()
    }

    /// The differences of two subjects, as "cone_samples 7 in A, 3 in B".
    pub(super) fn differences(&self, b: &Self) -> Vec<String> {
        let value = |subject: &Self, name: &str| match subject.get(name) {
            "" => "not set".to_owned(),
            value => value.to_owned(),
        };
        let said = |name: &str| format!("{name} {} in A, {} in B", value(self, name), value(b, name));
        self.differing(b).into_iter().map(said).collect()
    }

    /// The values that two subjects have in common.
    pub(super) fn common(&self, other: &Self) -> Self {
        let same = self.0.iter().filter(|(name, value)| other.0.get(*name) == Some(*value));
        Self(same.map(|(name, value)| (name.clone(), value.clone())).collect())
    }

    /// The method, and each value in which the subject differs from another one, as options that begin with `mark`.
    pub(super) fn difference_from(&self, other: &Self, mark: &str) -> String {
        let option = |name: &str| {
            let value = match self.get(name) {
                "" => NOT_SET,
                value => value,
            };
            format!(" {mark}{} {value}", name.replace('_', "-"))
        };
        let method = self.get("method").to_owned();
        // A parameter that only one of the two methods has is implied by the method's name.
        let is_set = |name: &str| !self.get(name).is_empty() && !other.get(name).is_empty();
        let own = |name: &&str| *name != "method" && (is_set(name) || PLACE.contains(name));
        self.differing(other).into_iter().filter(own).map(option).fold(method, |words, option| words + &option)
    }
}

/// Serializes each value by its form: a number, a truth value, null if empty, otherwise text.
impl Serialize for Subject {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let value = |text: &str| match text {
            "" => Json::Null,
            "true" | "false" => Json::Bool(text == "true"),
            _ => serde_json::from_str::<serde_json::Number>(text).map_or_else(|_| text.into(), Json::Number),
        };
        serializer.collect_map(self.0.iter().map(|(name, text)| (name, value(text))))
    }
}
