//! Raw samples of times, and their grouping by subject and pass.

use super::TOTAL;
use super::subject::Subject;
use crate::study::record::group_of;
use ssct::gpu::DeviceInfo;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A raw sample: the time of one pass in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeSample {
    /// Subject of the frame; successive rows of one subject share it.
    pub subject: Arc<Subject>,
    /// Number of the frame among those of its subject. In one run, frames of one number at one place were timed in turn.
    pub sample: u64,
    /// Label of the pass.
    pub pass: String,
    /// Whether the pass counts towards the total.
    pub counted: bool,
    /// Milliseconds, finite and ≥ 0.
    pub ms: f64,
    /// Noise floors of the pass and of the total, as shares, if measured.
    pub floors: [Option<f64>; 2],
}

/// A run of the time study, as read from its files.
#[derive(Debug, Clone)]
pub struct Run {
    /// Name that the user gave to the run.
    pub name: String,
    /// The device, if the run's records are present.
    pub device: Option<DeviceInfo>,
    /// Raw samples; the samples of a frame follow each other.
    pub samples: Vec<TimeSample>,
}

impl Run {
    /// Returns the names of the settings that the run's file gives for a method's frames; `None` if it has no frames of
    /// the method.
    fn stated_names(&self, method: &str) -> Option<BTreeSet<&String>> {
        let is_of_method = |s: &&TimeSample| s.subject.get("method") == method;
        self.samples
            .iter()
            .any(|s| is_of_method(&s))
            .then(|| self.samples.iter().filter(is_of_method).flat_map(|s| s.subject.0.keys()).collect())
    }

    /// Returns a copy of the run's samples, whose subjects have only settings that the file of the run `other` gives
    /// for the same method, too. The subjects of methods that `other` lacks keep all settings.
    fn with_common_names(&self, other: &Self) -> Vec<TimeSample> {
        let mut names_in_other: BTreeMap<String, Option<BTreeSet<&String>>> = BTreeMap::new();
        let mut samples = self.samples.clone();
        // Samples that follow each other often share a subject: the last subject and its shortened copy are kept.
        let mut last: Option<[Arc<Subject>; 2]> = None;
        for sample in &mut samples {
            let shortened = match &last {
                Some([full, shortened]) if Arc::ptr_eq(full, &sample.subject) => Arc::clone(shortened),
                _ => {
                    let method = sample.subject.get("method").to_owned();
                    match names_in_other.entry(method).or_insert_with_key(|method| other.stated_names(method)) {
                        None => Arc::clone(&sample.subject),
                        Some(names) => {
                            let values = sample.subject.0.iter().filter(|(name, _)| names.contains(name));
                            Arc::new(Subject(values.map(|(name, text)| (name.clone(), text.clone())).collect()))
                        }
                    }
                }
            };
            last = Some([std::mem::replace(&mut sample.subject, Arc::clone(&shortened)), shortened]);
        }
        samples
    }

    /// Returns the names of settings that the file of the run `other` gives, and this run's file does not, for methods
    /// that both runs have.
    pub(super) fn missing_settings(&self, other: &Self) -> BTreeSet<String> {
        let methods: BTreeSet<&str> = self.samples.iter().map(|s| s.subject.get("method")).collect();
        let missing = |method: &&str| {
            let (names, names_in_other) = (self.stated_names(method)?, other.stated_names(method)?);
            Some(names_in_other.difference(&names).map(|name| (*name).clone()).collect::<Vec<_>>())
        };
        methods.iter().filter_map(missing).flatten().collect()
    }
}

/// The samples of one pass, of a group of passes, or of the total.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Samples {
    /// Label of the pass, name of the group, or [`TOTAL`].
    pub(super) pass: String,
    /// The group that the pass is a part of.
    pub(super) part_of: Option<String>,
    /// Whether the pass counts towards the total.
    pub(super) counted: bool,
    /// Number of the frame of each sample.
    pub(super) frame_numbers: Vec<u64>,
    /// Milliseconds of each sample.
    pub(super) ms: Vec<f64>,
    /// Noise floor as a share, if measured.
    pub(super) noise_floor: Option<f64>,
}

impl Samples {
    /// Whether a row of a frame is a sample of this pass, group or total.
    fn has_row(&self, row: &Row) -> bool {
        self.pass == row.pass && self.part_of.as_deref() == row.part_of && self.counted == row.counted
    }

    /// Returns the time of these samples and that of `other`, in milliseconds, for each frame number that both have.
    pub(super) fn paired_times(&self, other: &Self) -> Vec<[f64; 2]> {
        let other_ms: BTreeMap<u64, f64> = other.frame_numbers.iter().copied().zip(other.ms.iter().copied()).collect();
        let numbered_ms = self.frame_numbers.iter().zip(&self.ms);
        numbered_ms.filter_map(|(number, ms)| Some([*ms, *other_ms.get(number)?])).collect()
    }
}

/// A row of a frame: the time of a pass, of a group of passes, or of the total.
struct Row<'r> {
    pass: &'r str,
    part_of: Option<&'r str>,
    counted: bool,
    ms: f64,
    noise_floor: Option<f64>,
}

/// All samples of one subject.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SubjectSamples {
    pub(super) subject: Subject,
    /// The passes in order, each group before its parts, and the total last.
    pub(super) passes: Vec<Samples>,
}

/// Groups samples by subject and pass, both in the order in which they first appear. Samples of one subject with one
/// frame number that follow each other are one frame.
pub(super) fn by_subject(samples: &[TimeSample]) -> Vec<SubjectSamples> {
    let mut groups: Vec<SubjectSamples> = Vec::new();
    for frame in samples.chunk_by(|a, b| a.sample == b.sample && a.subject == b.subject) {
        let Some(first) = frame.first() else { continue };
        let index = groups.iter().rposition(|group| group.subject == *first.subject).unwrap_or_else(|| {
            groups.push(SubjectSamples { subject: (*first.subject).clone(), passes: Vec::new() });
            groups.len() - 1
        });
        let passes = &mut groups[index].passes;
        for row in rows(frame) {
            let pass_index = passes.iter().position(|s| s.has_row(&row)).unwrap_or_else(|| {
                let (pass, part_of) = (row.pass.to_owned(), row.part_of.map(str::to_owned));
                let (counted, noise_floor) = (row.counted, row.noise_floor);
                passes.push(Samples { pass, part_of, counted, frame_numbers: Vec::new(), ms: Vec::new(), noise_floor });
                passes.len() - 1
            });
            passes[pass_index].frame_numbers.push(first.sample);
            passes[pass_index].ms.push(row.ms);
        }
    }
    for group in &mut groups {
        group.passes.sort_by_key(|s| s.pass == TOTAL);
    }
    groups
}

/// Groups the samples of each of two runs, by the settings that both files give for a method; other settings are left
/// out.
pub(super) fn both_by_subject(a: &Run, b: &Run) -> [Vec<SubjectSamples>; 2] {
    [(a, b), (b, a)].map(|(run, other)| by_subject(&run.with_common_names(other)))
}

/// Makes the rows of a frame from the samples of its passes. Each group of passes has a row before its first part, and
/// the sum of the counted passes comes last.
fn rows(frame: &[TimeSample]) -> Vec<Row<'_>> {
    let mut rows: Vec<Row> = Vec::new();
    for sample in frame {
        let (group, counted) = (group_of(&sample.pass), sample.counted);
        let mut parts = frame.iter().filter(|s| group_of(&s.pass) == group && s.counted == counted);
        let is_part = parts.any(|s| s.pass.contains('/'));
        if is_part && !rows.iter().any(|r| r.pass == group && r.part_of.is_none() && r.counted == counted) {
            rows.push(sum(group, frame.iter().filter(|s| group_of(&s.pass) == group && s.counted == counted)));
        }
        let (part_of, ms, noise_floor) = (is_part.then_some(group), sample.ms, sample.floors[0]);
        rows.push(Row { pass: &sample.pass, part_of, counted, ms, noise_floor });
    }
    if frame.iter().any(|s| s.counted) {
        let total = sum(TOTAL, frame.iter().filter(|s| s.counted));
        rows.push(Row { noise_floor: frame.first().and_then(|s| s.floors[1]), ..total });
    }
    rows
}

/// Makes the row of a sum of passes under the name `pass`. Its noise floor is the greatest that it can be: the sum of
/// the parts' noise floors in milliseconds, divided by the sum of their times. It is `None` if a part has none.
fn sum<'r>(pass: &'r str, parts: impl Iterator<Item = &'r TimeSample> + Clone) -> Row<'r> {
    let ms: f64 = parts.clone().map(|s| s.ms).sum();
    let floor_ms: Option<f64> = parts.clone().map(|s| Some(s.floors[0]? * s.ms)).sum();
    let counted = parts.clone().all(|s| s.counted);
    let noise_floor = floor_ms.map(|floor_ms| if ms > 0.0 { floor_ms / ms } else { 0.0 });
    Row { pass, part_of: None, counted, ms, noise_floor }
}
