//! Raw samples of times, and their grouping by subject and pass.

use super::TOTAL;
use super::subject::Subject;
use crate::study::record::group_of;
use ssct::gpu::DeviceInfo;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A row of raw samples: the time of one pass in one frame.
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
    /// The names of the settings that the run's file gives for a method's frames; `None` if it has no frames of the method.
    fn stated_names(&self, method: &str) -> Option<BTreeSet<&String>> {
        let is_of = |s: &&TimeSample| s.subject.get("method") == method;
        self.samples
            .iter()
            .any(|s| is_of(&s))
            .then(|| self.samples.iter().filter(is_of).flat_map(|s| s.subject.0.keys()).collect())
    }

    /// The run's samples; each method keeps only the settings that another run's file gives for it, too.
    fn with_common_names(&self, other: &Self) -> Vec<TimeSample> {
        let mut known: BTreeMap<String, Option<BTreeSet<&String>>> = BTreeMap::new();
        let mut samples = self.samples.clone();
        // Rows that follow each other share their subject, so that the last subject and its shortened copy are kept.
        let mut last: Option<[Arc<Subject>; 2]> = None;
        for s in &mut samples {
            let stripped = match &last {
                Some([from, to]) if Arc::ptr_eq(from, &s.subject) => Arc::clone(to),
                _ => {
                    let method = s.subject.get("method").to_owned();
                    match known.entry(method).or_insert_with_key(|method| other.stated_names(method)) {
                        None => Arc::clone(&s.subject),
                        Some(told) => {
                            let values = s.subject.0.iter().filter(|(name, _)| told.contains(name));
                            Arc::new(Subject(values.map(|(name, text)| (name.clone(), text.clone())).collect()))
                        }
                    }
                }
            };
            last = Some([std::mem::replace(&mut s.subject, Arc::clone(&stripped)), stripped]);
        }
        samples
    }

    /// The names of settings that another run's file gives, and this run's file does not, for methods that both runs have.
    pub(super) fn missing_settings(&self, other: &Self) -> BTreeSet<String> {
        let methods: BTreeSet<&str> = self.samples.iter().map(|s| s.subject.get("method")).collect();
        let lacking = |method: &&str| {
            let (mine, theirs) = (self.stated_names(method)?, other.stated_names(method)?);
            Some(theirs.difference(&mine).map(|name| (*name).clone()).collect::<Vec<_>>())
        };
        methods.iter().filter_map(lacking).flatten().collect()
    }
}

/// The samples of one pass, of a group of passes, or of the total.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Samples {
    pub(super) pass: String,
    /// The group that the pass is a part of.
    pub(super) part_of: Option<String>,
    pub(super) counted: bool,
    /// Number of the frame of each sample.
    pub(super) numbers: Vec<u64>,
    pub(super) ms: Vec<f64>,
    pub(super) noise_floor: Option<f64>,
}

impl Samples {
    /// Whether a row belongs to these samples.
    fn has_row(&self, row: &Row) -> bool {
        self.pass == row.pass && self.part_of.as_deref() == row.part_of && self.counted == row.counted
    }

    /// The pass's time and the time of `other` in each frame whose number both have.
    pub(super) fn paired_times(&self, other: &Self) -> Vec<[f64; 2]> {
        let theirs: BTreeMap<u64, f64> = other.numbers.iter().copied().zip(other.ms.iter().copied()).collect();
        let mine = self.numbers.iter().zip(&self.ms);
        mine.filter_map(|(number, ms)| Some([*ms, *theirs.get(number)?])).collect()
    }
}

/// A pass, a group or the total in one frame.
struct Row<'r> {
    pass: &'r str,
    part_of: Option<&'r str>,
    counted: bool,
    ms: f64,
    noise_floor: Option<f64>,
}

/// All samples of one subject: its passes in order, each group before its parts, and the total last.
pub(super) type Group = (Subject, Vec<Samples>);

/// Samples by subject and pass, both in order of appearance. Rows of one subject and sample number
/// that follow each other are one frame.
pub(super) fn groups(samples: &[TimeSample]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for frame in samples.chunk_by(|a, b| a.sample == b.sample && a.subject == b.subject) {
        let Some(first) = frame.first() else { continue };
        let place = groups.iter().rposition(|(s, _)| *s == *first.subject).unwrap_or_else(|| {
            groups.push(((*first.subject).clone(), Vec::new()));
            groups.len() - 1
        });
        let passes = &mut groups[place].1;
        for row in rows(frame) {
            let known = passes.iter().position(|s| s.has_row(&row)).unwrap_or_else(|| {
                let (pass, part_of) = (row.pass.to_owned(), row.part_of.map(str::to_owned));
                let (counted, noise_floor) = (row.counted, row.noise_floor);
                passes.push(Samples { pass, part_of, counted, numbers: Vec::new(), ms: Vec::new(), noise_floor });
                passes.len() - 1
            });
            passes[known].numbers.push(first.sample);
            passes[known].ms.push(row.ms);
        }
    }
    for (_, passes) in &mut groups {
        passes.sort_by_key(|s| s.pass == TOTAL);
    }
    groups
}

/// The groups of two runs, by the settings that the files of both give for each method.
pub(super) fn groups_of_both(a: &Run, b: &Run) -> [Vec<Group>; 2] {
    [(a, b), (b, a)].map(|(run, other)| groups(&run.with_common_names(other)))
}

/// The rows of a frame: passes, groups of passes, and the sum of the counted passes.
fn rows(frame: &[TimeSample]) -> Vec<Row<'_>> {
    let mut rows: Vec<Row> = Vec::new();
    for sample in frame {
        let (name, counted) = (group_of(&sample.pass), sample.counted);
        let mut parts = frame.iter().filter(|s| group_of(&s.pass) == name && s.counted == counted);
        let is_part = parts.any(|s| s.pass.contains('/'));
        if is_part && !rows.iter().any(|r| r.pass == name && r.part_of.is_none() && r.counted == counted) {
            rows.push(sum(name, frame.iter().filter(|s| group_of(&s.pass) == name && s.counted == counted)));
        }
        let (part_of, ms, noise_floor) = (is_part.then_some(name), sample.ms, sample.floors[0]);
        rows.push(Row { pass: &sample.pass, part_of, counted, ms, noise_floor });
    }
    if frame.iter().any(|s| s.counted) {
        let total = sum(TOTAL, frame.iter().filter(|s| s.counted));
        rows.push(Row { noise_floor: frame.first().and_then(|s| s.floors[1]), ..total });
    }
    rows
}

/// A sum of passes. Its noise floor is the greatest that it can be: the sum of the parts' noise floors in milliseconds,
/// divided by the sum of their times.
fn sum<'r>(pass: &'r str, parts: impl Iterator<Item = &'r TimeSample> + Clone) -> Row<'r> {
    let ms: f64 = parts.clone().map(|s| s.ms).sum();
    let strays: Option<f64> = parts.clone().map(|s| Some(s.floors[0]? * s.ms)).sum();
    let counted = parts.clone().all(|s| s.counted);
    Row { pass, part_of: None, counted, ms, noise_floor: strays.map(|strays| if ms > 0.0 { strays / ms } else { 0.0 }) }
}
