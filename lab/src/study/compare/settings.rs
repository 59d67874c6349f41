//! Comparison of two settings: of one run, in which they were timed in turn, or of two runs.

use super::samples::{SubjectSamples, both_by_subject, by_subject};
use super::subject::{NOT_SET, PLACE, Subject};
use super::{Comparison, Run, SAME_SAMPLES, TimeComparison, TimeSample};
use crate::study::exhibit::distinct;
use crate::study::record::changed_value;
use ssct::methods::{self, MethodInfo};
use ssct_ground::parameter::{Choices, Preset};
use std::collections::BTreeSet;
use std::str::FromStr;

/// Selects a setting of a run by a method and options, written as on the command line: `ssct --iterations 64`. Options
/// that are not named may have any value; of several such settings at one place, the one nearest to the preset is
/// meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The selection as the user wrote it, for messages.
    text: String,
    /// Names of columns of the samples, and their values.
    values: Vec<(String, String)>,
}

/// The options of a lens whose columns in the samples have other names: the option and its column.
const LENS_OPTIONS: [(&str, &str); 4] =
    [("fov", "fov_degrees"), ("near", "near_m"), ("far", "far_m"), ("orthographic_height", "orthographic_height_m")];

/// Returns the name of the column of the samples that has the values of an option.
fn column_of_option(option: &str) -> String {
    let name = option.replace('-', "_");
    match LENS_OPTIONS.iter().find(|(lens_option, _)| *lens_option == name) {
        Some((_, column)) => (*column).to_owned(),
        None => name,
    }
}

impl FromStr for Selection {
    type Err = String;

    /// Reads a method, if the text begins with one, and then options. A value follows its option after a space or after
    /// `=`; an option without a value is a switch, and is taken as on.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut values: Vec<(String, String)> = Vec::new();
        let mut words = text.split_whitespace().peekable();
        if let Some(method) = words.next_if(|word| !word.starts_with("--")) {
            values.push(("method".into(), method.into()));
        }
        while let Some(word) = words.next() {
            let option = word.strip_prefix("--").filter(|name| !name.is_empty());
            let option = option.ok_or_else(|| format!("no option stands before {word:?}"))?;
            let (name, value) = match option.split_once('=') {
                Some((name, value)) => (name, value),
                None => (option, words.next_if(|next| !next.starts_with("--")).unwrap_or("on")),
            };
            match (name, value.split_once('x')) {
                ("size", Some((width, height))) => {
                    values.extend([("width".into(), width.into()), ("height".into(), height.into())]);
                }
                _ => values.push((column_of_option(name), value.to_owned())),
            }
        }
        if values.is_empty() {
            return Err("it names neither a method nor an option".into());
        }
        Ok(Self { text: text.to_owned(), values })
    }
}

/// Whether the recorded value of a sample equals the value that a user typed. Numbers are compared as numbers.
fn is_same_value(recorded: &str, typed: &str) -> bool {
    let numbers = recorded.parse::<f64>().ok().zip(typed.parse::<f64>().ok());
    match (recorded, typed) {
        ("", NOT_SET) | ("true", "on") | ("false", "off") => true,
        _ => recorded == typed || numbers.is_some_and(|(a, b)| a == b),
    }
}

impl Selection {
    /// Whether the selection names a value of a column of the samples.
    fn names_column(&self, column: &str) -> bool {
        self.values.iter().any(|(named, _)| named == column)
    }

    /// Whether a subject has every value that the selection names.
    fn fits(&self, subject: &Subject) -> bool {
        self.values.iter().all(|(name, typed)| is_same_value(subject.get(name), typed))
    }

    /// Counts the parameters of a subject that differ from their preset and that the selection does not name. A preset
    /// other than the default counts as one more, unless the selection names the preset.
    fn count_unnamed(&self, subject: &Subject) -> usize {
        let preset = Preset::of_name(subject.get("preset")).unwrap_or_default();
        let parameters = methods::find(subject.get("method")).map_or_else(|_| Vec::new(), MethodInfo::read_parameters);
        let changed = parameters.iter().filter(|p| changed_value(p, preset, subject.get(p.name)).is_some());
        let has_other_preset = !self.names_column("preset") && preset != Preset::default();
        changed.filter(|p| !self.names_column(p.name)).count() + usize::from(has_other_preset)
    }

    /// Returns the samples whose subjects fit the selection; `samples` has all samples of the run.
    ///
    /// # Errors
    /// A sentence, if no subject fits, or if no sample of the run has a value for a named option.
    fn fitting_in<'s>(&self, run: &Run, samples: &'s [SubjectSamples]) -> Result<Vec<&'s SubjectSamples>, String> {
        let known: BTreeSet<&str> = samples.iter().flat_map(|s| s.subject.0.keys()).map(String::as_str).collect();
        if let Some((name, _)) = self.values.iter().find(|(name, _)| !known.contains(name.as_str())) {
            return Err(format!("{:?}: the samples of {} have no {}", self.text, run.name, name.replace('_', "-")));
        }
        let fitting: Vec<&SubjectSamples> = samples.iter().filter(|s| self.fits(&s.subject)).collect();
        if fitting.is_empty() {
            let values = self.values_in(samples).join("; ");
            return Err(format!("{:?}: {} has no such setting; it has {values}", self.text, run.name));
        }
        Ok(fitting)
    }

    /// Returns a text for the method and for each option that the selection names, with the values that the subjects
    /// have, such as "iterations 64, 1024".
    fn values_in(&self, samples: &[SubjectSamples]) -> Vec<String> {
        let names: BTreeSet<&str> = self.values.iter().map(|(name, _)| name.as_str()).chain(["method"]).collect();
        let text = |name: &str| {
            let values: BTreeSet<&str> =
                samples.iter().map(|s| s.subject.get(name)).filter(|v| !v.is_empty()).collect();
            format!("{} {}", name.replace('_', "-"), values.into_iter().collect::<Vec<_>>().join(", "))
        };
        names.into_iter().map(text).collect()
    }

    /// Picks one of the settings that fit the selection at one place: the one that differs from the preset in the
    /// fewest parameters, not counting those that the selection names.
    ///
    /// # Errors
    /// A sentence that names two of the settings, if several differ in equally few.
    fn pick<'s>(&self, fitting: &[&'s SubjectSamples]) -> Result<&'s SubjectSamples, String> {
        let least = fitting.iter().map(|s| self.count_unnamed(&s.subject)).min();
        let is_nearest_to_preset = |s: &&SubjectSamples| Some(self.count_unnamed(&s.subject)) == least;
        let nearest_to_preset: Vec<&SubjectSamples> = fitting.iter().copied().filter(is_nearest_to_preset).collect();
        match nearest_to_preset[..] {
            [picked] => Ok(picked),
            [first, second, ..] => Err(format!(
                "{:?} means several settings, such as \"{}\" and \"{}\"",
                self.text,
                first.subject.difference_from(&second.subject, "--"),
                second.subject.difference_from(&first.subject, "--")
            )),
            [] => Err(format!("{:?} means no setting", self.text)),
        }
    }
}

/// Returns the values of a subject's place, without those that one of the two selections names.
fn unnamed_place(subject: &Subject, selections: [&Selection; 2]) -> Vec<String> {
    let is_unnamed = |name: &&str| !selections.iter().any(|selection| selection.names_column(name));
    PLACE.into_iter().filter(is_unnamed).map(|name| subject.get(name).to_owned()).collect()
}

/// Compares a setting of A with a setting of B at every place where both were timed; `selections` select the two
/// settings. If A and B are one run and the settings have the same place, their frames are compared turn by turn.
/// `threshold` is the change of a time that counts, as a share, at least 0 and below 1.
///
/// # Errors
/// A sentence, if a selection fits no setting or several, or if no place has both settings.
pub fn settings(a: &Run, b: &Run, selections: [&Selection; 2], threshold: f64) -> Result<Vec<TimeComparison>, String> {
    let comparison = Comparison::new(a, b, threshold);
    let [samples_of_a, samples_of_b] = both_by_subject(a, b);
    let with_option = |side: &str, message: String| format!("--{side} {message}");
    let fitting_a = selections[0].fitting_in(a, &samples_of_a).map_err(|e| with_option("a", e))?;
    let fitting_b = selections[1].fitting_in(b, &samples_of_b).map_err(|e| with_option("b", e))?;
    let mut records = Vec::new();
    for place in distinct(fitting_a.iter().map(|s| unnamed_place(&s.subject, selections))) {
        let is_at_place = |s: &&&SubjectSamples| unnamed_place(&s.subject, selections) == place;
        let [candidates_a, candidates_b] =
            [&fitting_a, &fitting_b].map(|fitting| fitting.iter().filter(is_at_place).copied().collect::<Vec<_>>());
        if candidates_b.is_empty() {
            continue;
        }
        let picked_a = selections[0].pick(&candidates_a).map_err(|e| with_option("a", e))?;
        let picked_b = selections[1].pick(&candidates_b).map_err(|e| with_option("b", e))?;
        let in_turn = std::ptr::eq(a, b) && picked_a.subject.place() == picked_b.subject.place();
        records.extend(compare_pair(&comparison, [picked_a, picked_b], in_turn));
    }
    if records.is_empty() {
        return Err(format!("{:?} and {:?} were timed at no common place", selections[0].text, selections[1].text));
    }
    Ok(records)
}

/// Makes the records that compare two settings, each named by its method and the values in which it differs from the
/// other. `paired` says that frames with the same number were timed in turn.
fn compare_pair(comparison: &Comparison, [a, b]: [&SubjectSamples; 2], paired: bool) -> Vec<TimeComparison> {
    let records = comparison.records([&a.subject, &b.subject], [&a.passes, &b.passes], paired).into_iter();
    let [setting_a, setting_b] =
        [(a, b), (b, a)].map(|(setting, other)| setting.subject.difference_from(&other.subject, ""));
    let same_setting = (a == b).then(|| format!("A and B are one setting of one run, {SAME_SAMPLES}"));
    let warnings = same_setting.iter().chain(&comparison.warning).cloned().collect::<Vec<_>>();
    let warning = (!warnings.is_empty()).then(|| warnings.join("; "));
    let with_settings = |record: TimeComparison| TimeComparison {
        warning: warning.clone(),
        setting_a: Some(setting_a.clone()),
        setting_b: Some(setting_b.clone()),
        ..record
    };
    records.map(with_settings).collect()
}

/// Compares settings of one run that were timed in turn: each setting with the first, turn by turn. Each element of
/// `series` has the samples of one setting. `threshold` is the change of a time that counts, as a share, at least 0 and
/// below 1.
pub fn in_turns(run: &Run, series: &[Vec<TimeSample>], threshold: f64) -> Vec<TimeComparison> {
    let grouped: Vec<Vec<SubjectSamples>> = series.iter().map(|samples| by_subject(samples)).collect();
    let comparison = Comparison::new(run, run, threshold);
    let Some(first) = grouped.first().and_then(|subjects| subjects.first()) else { return Vec::new() };
    let others = grouped.iter().skip(1).filter_map(|subjects| subjects.first());
    others.flat_map(|other| compare_pair(&comparison, [first, other], true)).collect()
}
