//! Subjects: the scene, view, method and settings that a frame was drawn with; and the differences of two subjects.

use crate::study::drift::has_triangle_gbuffer;
use serde::{Serialize, Serializer};
use serde_json::Value as Json;
use ssct::methods::{self, EffectParams};
use ssct_ground::parameter::Parameters;
use std::collections::{BTreeMap, BTreeSet};

/// The subject of a frame: scene, view, method and everything that was set, by name. A setting that the method does not have,
/// or that a file does not give, is missing.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Subject(pub BTreeMap<String, String>);

/// Names of the values in which two subjects must be equal before their other differences are listed.
const SCENE_VIEW_METHOD: [&str; 3] = ["scene", "view", "method"];

/// Names of the values that decide how much work the passes that draw the scene do, besides those that decide which
/// G-buffer they draw.
const WORK: [&str; 8] = ["scene", "view", "width", "height", "fov_degrees", "near_m", "far_m", "orthographic_height_m"];

/// Names of the values that are the place of a measurement. Methods and their parameters are compared within one place.
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
    /// Returns the value with a name as its file has it; empty if it is null or missing.
    pub fn get(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// Returns the values of the measurement's place, in the order of `PLACE`.
    pub fn place(&self) -> [&str; PLACE.len()] {
        PLACE.map(|name| self.get(name))
    }

    /// Whether two subjects have the same scene, view and method.
    pub(super) fn has_same_scene_view_and_method(&self, other: &Self) -> bool {
        SCENE_VIEW_METHOD.iter().all(|name| self.get(name) == other.get(name))
    }

    /// Whether the scene passes are known to do the same work for both subjects.
    pub(super) fn is_same_work(&self, other: &Self) -> bool {
        let has_triangles = |s: &Self| has_triangle_gbuffer(s.get("method"), |name| s.get(name).to_owned());
        let is_same_gbuffer = has_triangles(self).zip(has_triangles(other)).is_some_and(|(a, b)| a == b);
        is_same_gbuffer && WORK.iter().all(|name| self.get(name) == other.get(name))
    }

    /// Whether the subject's method reads a value. It reads all but some parameters of the effect around it.
    fn reads(&self, name: &str) -> bool {
        let is_effect_parameter = EffectParams::table().iter().any(|p| p.name == name);
        let method = methods::find(self.get("method")).ok().filter(|_| is_effect_parameter);
        method.is_none_or(|method| method.read_parameters().iter().any(|p| p.name == name))
    }

    /// Returns the names of the values in which two subjects differ.
    pub(super) fn differing_names<'s>(&'s self, other: &'s Self) -> Vec<&'s str> {
        let names: BTreeSet<&String> = self.0.keys().chain(other.0.keys()).collect();
        names.into_iter().map(String::as_str).filter(|name| self.get(name) != other.get(name)).collect()
    }

    /// Describes each difference of this subject, as A, from the subject `b`, as B: "cone_samples 7 in A, 3 in B".
    pub(super) fn differences(&self, b: &Self) -> Vec<String> {
        let value = |subject: &Self, name: &str| match subject.get(name) {
            "" => "not set".to_owned(),
            value => value.to_owned(),
        };
        let difference = |name: &str| format!("{name} {} in A, {} in B", value(self, name), value(b, name));
        self.differing_names(b).into_iter().map(difference).collect()
    }

    /// Returns the values in which two subjects differ, by name, each as a pair.
    pub(super) fn differing_values(&self, other: &Self) -> BTreeMap<String, [String; 2]> {
        let values = |name: &str| (name.to_owned(), [self, other].map(|subject| subject.get(name).to_owned()));
        self.differing_names(other).into_iter().map(values).collect()
    }

    /// Returns a subject with the values that are equal in both subjects.
    pub(super) fn common(&self, other: &Self) -> Self {
        let same = self.0.iter().filter(|(name, value)| other.0.get(*name) == Some(*value));
        Self(same.map(|(name, value)| (name.clone(), value.clone())).collect())
    }

    /// Returns the subject's method, followed by each value in which the subject differs from `other`, as an option and
    /// its value. An option begins with `mark`, which is "--" for text that a user can type, or empty.
    pub(super) fn difference_from(&self, other: &Self, mark: &str) -> String {
        let option = |name: &str| {
            let value = match self.get(name) {
                "" => NOT_SET,
                value => value,
            };
            format!(" {mark}{} {value}", name.replace('_', "-"))
        };
        let method = self.get("method").to_owned();
        // A parameter that only one of the two methods has is implied by the method's name. The values in PLACE
        // belong to no method, and are named even if one subject does not set them.
        let is_set_in_both = |name: &str| !self.get(name).is_empty() && !other.get(name).is_empty();
        // Records have the parameters of the effect that the method does not read, too. Two settings of one method may
        // differ in nothing else, so that they are told apart by these.
        let has_same_method = self.get("method") == other.get("method");
        let tells_apart = |name: &str| is_set_in_both(name) && (has_same_method || self.reads(name));
        let is_named = |name: &&str| *name != "method" && (tells_apart(name) || PLACE.contains(name));
        self.differing_names(other)
            .into_iter()
            .filter(is_named)
            .map(option)
            .fold(method, |words, option| words + &option)
    }
}

/// Serializes each value as what its text looks like: a number, a truth value, null if empty, otherwise text.
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
