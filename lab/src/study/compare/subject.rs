//! What a frame was of, and in what two such subjects differ.

use serde::{Serialize, Serializer};
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};

/// What a frame was of: scene, view, method and everything that was set, by name. What the method does not have, and what
/// a file does not say, is not there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Subject(pub BTreeMap<String, String>);

/// What makes two subjects alike enough to say in what they differ.
const LIKE: [&str; 3] = ["scene", "view", "method"];

/// Names of the values that decide how much work the passes of the scene are.
const WORK: [&str; 8] = ["scene", "view", "width", "height", "fov_degrees", "near_m", "far_m", "orthographic_height_m"];

/// Names of values that belong to the place of a measurement: methods and their parameters are compared within one.
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

/// The word of an option for a value that is not set, as tables show it.
pub(super) const NOT_SET: &str = "own";

impl Subject {
    /// A value as its file has it; nothing where it is null or not known.
    pub fn get(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// The values that belong to the place of the measurement, in an order of their own.
    pub fn place(&self) -> [&str; PLACE.len()] {
        PLACE.map(|name| self.get(name))
    }

    /// Whether two are of the same scene, view and method.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        LIKE.iter().all(|name| self.get(name) == other.get(name))
    }

    /// Whether the passes of the scene are the same work for both.
    pub(super) fn is_same_work(&self, other: &Self) -> bool {
        WORK.iter().all(|name| self.get(name) == other.get(name))
    }

    /// The names of the values in which two differ.
    pub(super) fn differing<'s>(&'s self, other: &'s Self) -> Vec<&'s str> {
        let names: BTreeSet<&String> = self.0.keys().chain(other.0.keys()).collect();
        names.into_iter().map(String::as_str).filter(|name| self.get(name) != other.get(name)).collect()
    }

    /// In what two differ, as "cone_samples 7 in A, 3 in B".
    pub(super) fn differences(&self, b: &Self) -> Vec<String> {
        let value = |subject: &Self, name: &str| match subject.get(name) {
            "" => "not set".to_owned(),
            value => value.to_owned(),
        };
        let said = |name: &str| format!("{name} {} in A, {} in B", value(self, name), value(b, name));
        self.differing(b).into_iter().map(said).collect()
    }

    /// The values that two have in common.
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
        // A parameter that only one of two methods has tells nothing more than the method.
        let is_set = |name: &str| !self.get(name).is_empty() && !other.get(name).is_empty();
        let own = |name: &&str| *name != "method" && (is_set(name) || PLACE.contains(name));
        self.differing(other).into_iter().filter(own).map(option).fold(method, |words, option| words + &option)
    }
}

/// Each value as what it looks like: a number, a truth value, null for nothing, else text.
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
