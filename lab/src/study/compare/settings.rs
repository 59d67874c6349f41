//! Comparison of two settings: of one run, in which they were timed in turn, or of two runs.

use super::samples::{Group, groups, groups_of_both};
use super::subject::{NOT_SET, PLACE, Subject};
use super::{Comparison, Run, SAME_SAMPLES, TimeComparison, TimeSample};
use crate::study::exhibit::distinct;
use crate::study::record::differing;
use ssct::methods::{self, MethodInfo};
use ssct_ground::parameter::{Choices, Preset};
use std::collections::BTreeSet;
use std::str::FromStr;

/// Selects a setting of a run by a method and options, written as on the command line: `ssct --iterations 64`. Options
/// that are not named may have any value; of several such settings at one place, the one nearest to the preset is
/// meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    text: String,
    /// Names of columns of the samples, and their values.
    values: Vec<(String, String)>,
}

/// The options of a lens whose columns in the samples have other names: the option and its column.
const LENS: [(&str, &str); 4] =
    [("fov", "fov_degrees"), ("near", "near_m"), ("far", "far_m"), ("orthographic_height", "orthographic_height_m")];

/// Returns the name of the column of the samples that has the values of an option.
fn column(option: &str) -> String {
    let name = option.replace('-', "_");
    match LENS.iter().find(|(lens_option, _)| *lens_option == name) {
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
                _ => values.push((column(name), value.to_owned())),
            }
        }
        if values.is_empty() {
            return Err("it names neither a method nor an option".into());
        }
        Ok(Self { text: text.to_owned(), values })
    }
}

/// Whether the recorded value of a sample equals the value that a user typed. Numbers are compared as numbers.
fn is_value(recorded: &str, typed: &str) -> bool {
    let numbers = recorded.parse::<f64>().ok().zip(typed.parse::<f64>().ok());
    match (recorded, typed) {
        ("", NOT_SET) | ("true", "on") | ("false", "off") => true,
        _ => recorded == typed || numbers.is_some_and(|(a, b)| a == b),
    }
}

impl Selection {
    /// Whether the selection names a value of a column of the samples.
    fn names(&self, column: &str) -> bool {
        self.values.iter().any(|(named, _)| named == column)
    }

    /// Whether a subject has every value that the selection names.
    fn fits(&self, subject: &Subject) -> bool {
        self.values.iter().all(|(name, typed)| is_value(subject.get(name), typed))
    }

    /// Counts the parameters of a subject that differ from their preset and that the selection does not name. A preset
    /// other than the default counts as one more, unless the selection names the preset.
    fn unnamed(&self, subject: &Subject) -> usize {
        let preset = Preset::of_name(subject.get("preset")).unwrap_or_default();
        let rows = methods::find(subject.get("method")).map_or_else(|_| Vec::new(), MethodInfo::reads);
        let changed = rows.iter().filter(|row| differing(row, preset, subject.get(row.name)).is_some());
        let has_other_preset = !self.names("preset") && preset != Preset::default();
        changed.filter(|row| !self.names(row.name)).count() + usize::from(has_other_preset)
    }

    /// Returns those groups of `all`, the groups of a run, that fit the selection.
    ///
    /// # Errors
    /// A sentence, if no group fits, or if no sample of the run has a value for a named option.
    fn groups_in<'g>(&self, run: &Run, all: &'g [Group]) -> Result<Vec<&'g Group>, String> {
        let known: BTreeSet<&str> = all.iter().flat_map(|(s, _)| s.0.keys()).map(String::as_str).collect();
        if let Some((name, _)) = self.values.iter().find(|(name, _)| !known.contains(name.as_str())) {
            return Err(format!("{:?}: the samples of {} have no {}", self.text, run.name, name.replace('_', "-")));
        }
        let found: Vec<&Group> = all.iter().filter(|(subject, _)| self.fits(subject)).collect();
        if found.is_empty() {
            let has = self.values_in(all).join("; ");
            return Err(format!("{:?}: {} has no such setting; it has {has}", self.text, run.name));
        }
        Ok(found)
    }

    /// Returns a text for the method and for each option that the selection names, with the values that the groups
    /// have, such as "iterations 64, 1024".
    fn values_in(&self, all: &[Group]) -> Vec<String> {
        let names: BTreeSet<&str> = self.values.iter().map(|(name, _)| name.as_str()).chain(["method"]).collect();
        let shown = |name: &str| {
            let values: BTreeSet<&str> = all.iter().map(|(s, _)| s.get(name)).filter(|v| !v.is_empty()).collect();
            format!("{} {}", name.replace('_', "-"), values.into_iter().collect::<Vec<_>>().join(", "))
        };
        names.into_iter().map(shown).collect()
    }

    /// Picks one of the groups that fit the selection at one place: the group that differs from the preset in the
    /// fewest parameters, not counting those that the selection names.
    ///
    /// # Errors
    /// A sentence that names two of the groups, if several differ in equally few.
    fn one<'g>(&self, fitting: &[&'g Group]) -> Result<&'g Group, String> {
        let least = fitting.iter().map(|(subject, _)| self.unnamed(subject)).min();
        let nearest_to_preset: Vec<&Group> =
            fitting.iter().copied().filter(|(subject, _)| Some(self.unnamed(subject)) == least).collect();
        match nearest_to_preset[..] {
            [one] => Ok(one),
            [(first, _), (second, _), ..] => Err(format!(
                "{:?} means several settings, such as \"{}\" and \"{}\"",
                self.text,
                first.difference_from(second, "--"),
                second.difference_from(first, "--")
            )),
            [] => Err(format!("{:?} means no setting", self.text)),
        }
    }
}

/// Returns the values of a subject's place, without those that one of the two selections names.
fn place(subject: &Subject, chosen: [&Selection; 2]) -> Vec<String> {
    let is_unnamed = |name: &&str| !chosen.iter().any(|selection| selection.names(name));
    PLACE.into_iter().filter(is_unnamed).map(|name| subject.get(name).to_owned()).collect()
}

/// Compares a setting of A with a setting of B at every place where both were timed; `chosen` selects the two settings.
/// If A and B are one run and the settings have the same place, their frames are compared turn by turn. `threshold` is
/// the change of a time that counts, as a share, at least 0 and below 1.
///
/// # Errors
/// A sentence, if a selection fits no setting or several, or if no place has both settings.
pub fn settings(a: &Run, b: &Run, chosen: [&Selection; 2], threshold: f64) -> Result<Vec<TimeComparison>, String> {
    let comparison = Comparison::new(a, b, threshold);
    let [groups_a, groups_b] = groups_of_both(a, b);
    let with_option = |side: &str, e: String| format!("--{side} {e}");
    let fitting_a = chosen[0].groups_in(a, &groups_a).map_err(|e| with_option("a", e))?;
    let fitting_b = chosen[1].groups_in(b, &groups_b).map_err(|e| with_option("b", e))?;
    let mut records = Vec::new();
    for here in distinct(fitting_a.iter().map(|(subject, _)| place(subject, chosen))) {
        let is_here = |group: &&&Group| place(&group.0, chosen) == here;
        let [here_in_a, here_in_b] =
            [&fitting_a, &fitting_b].map(|all| all.iter().filter(is_here).copied().collect::<Vec<_>>());
        if here_in_b.is_empty() {
            continue;
        }
        let one_a = chosen[0].one(&here_in_a).map_err(|e| with_option("a", e))?;
        let one_b = chosen[1].one(&here_in_b).map_err(|e| with_option("b", e))?;
        let in_turn = std::ptr::eq(a, b) && one_a.0.place() == one_b.0.place();
        records.extend(pair(&comparison, [one_a, one_b], in_turn));
    }
    if records.is_empty() {
        return Err(format!("{:?} and {:?} were timed at no common place", chosen[0].text, chosen[1].text));
    }
    Ok(records)
}

/// Makes the records that compare two settings, each named by its method and the values in which it differs from the
/// other. `paired` says that frames with the same number were timed in turn.
fn pair(comparison: &Comparison, [a, b]: [&Group; 2], paired: bool) -> Vec<TimeComparison> {
    let records = comparison.records(&a.0.common(&b.0), [&a.1, &b.1], paired).into_iter();
    let [setting_a, setting_b] = [a.0.difference_from(&b.0, ""), b.0.difference_from(&a.0, "")];
    let same_warning = (a == b).then(|| format!("A and B are one setting of one run, {SAME_SAMPLES}"));
    let warnings = same_warning.iter().chain(&comparison.warning).cloned().collect::<Vec<_>>();
    let warning = (!warnings.is_empty()).then(|| warnings.join("; "));
    let is_same_work = a.0.is_same_work(&b.0);
    let with_settings = |record: TimeComparison| TimeComparison {
        drift: record.drift.filter(|_| is_same_work),
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
    let all: Vec<Vec<Group>> = series.iter().map(|samples| groups(samples)).collect();
    let comparison = Comparison::new(run, run, threshold);
    let Some(first) = all.first().and_then(|groups| groups.first()) else { return Vec::new() };
    let others = all.iter().skip(1).filter_map(|groups| groups.first());
    others.flat_map(|other| pair(&comparison, [first, other], true)).collect()
}
