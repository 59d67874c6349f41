//! Compares two runs of the time study, two settings of one run, or two images (docs/definitions.md, "Verdicts" and
//! "Image error"). Times are compared pass by pass from their raw samples.

mod images;
mod rows;
mod samples;
mod settings;
mod subject;

pub use self::images::{ImageComparison, LinearImage, display, images, rgb};
pub use self::rows::{SUBJECT_COLUMNS, cells, note_on_own, ordered, shown_drift, subject_labels};
pub use self::samples::{Run, TimeSample};
pub use self::settings::{Selection, in_turns, settings};
pub use self::subject::Subject;

use self::samples::{Samples, SubjectSamples, both_by_subject};
use super::record::{DEFINITIONS, Provenance, Stats};
use serde::Serialize;
use ssct::gpu::DeviceInfo;
use ssct_truth::metrics::bootstrap::{
    CONFIDENCE, MIN_SAMPLES, RESAMPLES, Ratio, Verdict, median_of_ratios, ratio_of_medians, samples_to_decide,
};
use std::collections::BTreeMap;

/// The name under which the sum of a frame's counted passes is compared.
pub const TOTAL: &str = "total";

/// Seed of the resamples from which each interval is found.
pub const SEED: u64 = 1;

/// The least change of a time that makes a verdict faster or slower, as a share, unless the user says otherwise.
pub const THRESHOLD: f64 = 0.05;

/// How an interval was found, and the threshold it was compared with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Judgement {
    /// Change that counts, as a share, 0 ≤ t < 1.
    pub threshold: f64,
    /// Share of the resamples in the interval.
    pub confidence: f64,
    /// Number of resamples.
    pub resamples: u32,
    /// Seed of the resamples.
    pub seed: u64,
}

/// One of the two runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Side {
    /// The first run, which the other one is compared with.
    A,
    /// The second run.
    B,
}

/// The first fields of the record of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompareHead {
    /// Kind of comparison.
    pub kind: &'static str,
    /// Version of docs/definitions.md, which is [`DEFINITIONS`].
    pub definitions: u32,
    /// Version of this program.
    pub version: &'static str,
    /// Commit of the program's source.
    pub commit: String,
    /// Name of the first run, which the other one is compared with.
    pub a: String,
    /// Name of the second run.
    pub b: String,
}

impl CompareHead {
    /// Makes the head of a record that compares the runs or images `a` and `b`.
    fn new(kind: &'static str, a: &str, b: &str) -> Self {
        let (version, commit) = (Provenance::VERSION, Provenance::commit());
        Self { kind, definitions: DEFINITIONS, version, commit, a: a.to_owned(), b: b.to_owned() }
    }
}

/// The times of a pass, of a group of passes, or of the total, in two runs. A value that one run lacks is null, and the
/// verdict is then null, too.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeComparison {
    /// Kind of the record, which is `compare`, with versions and the names of the runs.
    #[serde(flatten)]
    pub head: CompareHead,
    /// Subject that was timed: scene, view, method and settings, as far as A and B have them in common.
    #[serde(flatten)]
    pub subject: Subject,
    /// The values in which the subjects of A and B differ, by name: first that of A, then that of B. Tables show both.
    #[serde(skip)]
    pub differing: BTreeMap<String, [String; 2]>,
    /// The method of A, and the settings in which it differs from B, where two settings are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setting_a: Option<String>,
    /// The method of B, and the settings in which it differs from A, where two settings are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setting_b: Option<String>,
    /// Label of a pass, name of a group of passes, or [`TOTAL`].
    pub pass: String,
    /// The group that the pass is a part of: `hi-z` for `hi-z/3`. The group has a record of its own.
    pub part_of: Option<String>,
    /// Whether the pass counts towards the total.
    pub counted: bool,
    /// The run that has the pass, if the other run lacks it.
    pub only_in: Option<Side>,
    /// The settings in which the other run's nearest frames differ, if only one run has the pass and the other has frames of
    /// the same scene, view and method.
    pub differs: Option<String>,
    /// Whether A and B were timed in turn: if so, the ratio is the median of the ratios of the turns, else the ratio of the
    /// medians.
    pub paired: bool,
    /// Number of samples of A.
    pub samples_a: usize,
    /// Number of samples of B.
    pub samples_b: usize,
    /// Median of A in milliseconds.
    pub median_a_ms: Option<f64>,
    /// Median of B in milliseconds.
    pub median_b_ms: Option<f64>,
    /// Ratio of B to A; null in JSON if infinite, for an A of 0.
    pub ratio: Option<f64>,
    /// Lower end of the ratio's interval.
    pub low: Option<f64>,
    /// Upper end of the ratio's interval.
    pub high: Option<f64>,
    /// Noise floor, as a share: the greater of those of the two runs, where measured. A change up to the noise floor is
    /// neither faster nor slower.
    pub noise_floor: Option<f64>,
    /// Verdict on the interval; undecided with fewer than [`MIN_SAMPLES`] samples of A or B.
    pub verdict: Option<Verdict>,
    /// About how many samples would decide an undecided verdict; null if the number is too large to foretell.
    pub samples_to_decide: Option<u64>,
    /// How much longer the scene passes of B took than those of A, which do the same work, as a share. Null if the files have
    /// no times of scene passes, or if these are not known to do the same work.
    pub drift: Option<f64>,
    /// How the interval was found and judged.
    #[serde(flatten)]
    pub judgement: Judgement,
    /// Device of A; null if not known.
    pub device_a: Option<DeviceInfo>,
    /// Device of B; null if not known.
    pub device_b: Option<DeviceInfo>,
    /// Why the runs may not be comparable, if so.
    pub warning: Option<String>,
}

/// Two runs, or two settings, that are compared.
struct Comparison<'a> {
    a: &'a Run,
    b: &'a Run,
    judgement: Judgement,
    warning: Option<String>,
}

impl<'a> Comparison<'a> {
    /// Prepares the comparison of two runs. `threshold` is the change of a time that counts, as a share.
    fn new(a: &'a Run, b: &'a Run, threshold: f64) -> Self {
        let judgement = Judgement { threshold, confidence: CONFIDENCE, resamples: RESAMPLES, seed: SEED };
        Self { a, b, judgement, warning: warning(a, b) }
    }

    /// Makes the record of a pass from its samples in A and in B, one of which may be missing. `paired` says that
    /// frames with the same number were timed in turn.
    fn record(&self, subject: &Subject, sides: [Option<&Samples>; 2], paired: bool) -> TimeComparison {
        let [in_a, in_b] = sides;
        let [ms_a, ms_b] = sides.map(|s| s.map_or(&[][..], |s| &s.ms));
        let median = |ms: &[f64]| (!ms.is_empty()).then(|| Stats::from_samples(ms).median_ms);
        let ratio_and_samples = ratio(sides, paired);
        let ratio = ratio_and_samples.map(|(ratio, _)| ratio);
        let floors = sides.into_iter().flatten().filter_map(|s| s.noise_floor);
        let noise_floor = floors.reduce(f64::max);
        let judged =
            ratio_and_samples.map(|(ratio, samples)| self.judgement.judge(&ratio, samples, noise_floor.unwrap_or(0.0)));
        TimeComparison {
            head: CompareHead::new("compare", &self.a.name, &self.b.name),
            subject: subject.clone(),
            differing: BTreeMap::new(),
            setting_a: None,
            setting_b: None,
            pass: in_a.or(in_b).map(|s| s.pass.clone()).unwrap_or_default(),
            part_of: in_a.or(in_b).and_then(|s| s.part_of.clone()),
            counted: in_a.or(in_b).is_some_and(|s| s.counted),
            only_in: match sides {
                [Some(_), None] => Some(Side::A),
                [None, Some(_)] => Some(Side::B),
                _ => None,
            },
            differs: None,
            paired,
            samples_a: ms_a.len(),
            samples_b: ms_b.len(),
            median_a_ms: median(ms_a),
            median_b_ms: median(ms_b),
            ratio: ratio.map(|r| r.ratio),
            low: ratio.map(|r| r.low),
            high: ratio.map(|r| r.high),
            noise_floor,
            verdict: judged.map(|(verdict, _)| verdict),
            samples_to_decide: judged.and_then(|(_, samples)| samples),
            drift: None,
            judgement: self.judgement,
            device_a: self.a.device.clone(),
            device_b: self.b.device.clone(),
            warning: self.warning.clone(),
        }
    }

    /// Makes a record of each pass that A or B has, in A's order; passes of B alone come last. `subjects` are the
    /// subjects of A and of B, and `a` and `b` have the samples of their passes.
    fn records(&self, subjects: [&Subject; 2], [a, b]: [&[Samples]; 2], paired: bool) -> Vec<TimeComparison> {
        let [subject_a, subject_b] = subjects;
        let common = subject_a.common(subject_b);
        let differing = subject_a.differing_values(subject_b);
        let passes_of_a = a.iter().map(|s| self.record(&common, [Some(s), find(b, s)], paired));
        let only_in_b = b.iter().filter(|s| find(a, s).is_none());
        let all_passes = passes_of_a.chain(only_in_b.map(|s| self.record(&common, [None, Some(s)], paired)));
        let drift = drift([a, b]).filter(|_| subject_a.is_same_work(subject_b));
        let with_drift_and_differing = |record: TimeComparison| TimeComparison {
            drift: drift.filter(|_| record.only_in.is_none()),
            differing: differing.clone(),
            ..record
        };
        all_passes.map(with_drift_and_differing).collect()
    }
}

impl Judgement {
    /// Returns the verdict on a ratio that was found from `samples` samples, where `floor` is the noise floor as a
    /// share. The second value says about how many samples would decide an undecided verdict; `None` if it is decided,
    /// or if the number is too large to foretell.
    fn judge(&self, ratio: &Ratio, samples: usize, floor: f64) -> (Verdict, Option<u64>) {
        let has_too_few = samples < MIN_SAMPLES;
        let verdict = if has_too_few { Verdict::Undecided } else { Verdict::for_ratio(ratio, self.threshold, floor) };
        let is_open = verdict == Verdict::Undecided;
        (verdict, is_open.then(|| samples_to_decide(ratio, samples, self.threshold, floor)).flatten())
    }
}

/// Returns the ratio of B to A with its interval, and the number of samples that it follows from; `None` if A or B
/// lacks the pass. Frames that were timed in turn give the median of their ratios; other frames give the ratio of the
/// medians.
fn ratio(sides: [Option<&Samples>; 2], paired: bool) -> Option<(Ratio, usize)> {
    let [Some(a), Some(b)] = sides else { return None };
    if paired {
        let pairs = a.paired_times(b);
        return Some((median_of_ratios(&pairs, SEED)?, pairs.len()));
    }
    Some((ratio_of_medians(&a.ms, &b.ms, SEED)?, a.ms.len().min(b.ms.len())))
}

/// Returns how much longer the passes that do not count took in B than in A, as a share. These passes draw the scene.
/// Where this is the same work on both sides, any difference comes from the machine. `None` if A and B have no such pass
/// in common.
fn drift([a, b]: [&[Samples]; 2]) -> Option<f64> {
    let draws_scene = |s: &&Samples| !s.counted && s.part_of.is_none() && s.pass != TOTAL;
    let in_both = a.iter().filter(draws_scene).filter_map(|s| Some([s, find(b, s)?]));
    let medians = in_both.map(|pair| pair.map(|s| Stats::from_samples(&s.ms).median_ms));
    let [ms_in_a, ms_in_b] = medians.reduce(|sum, pair| [sum[0] + pair[0], sum[1] + pair[1]])?;
    Some(ms_in_b / ms_in_a - 1.0).filter(|drift| drift.is_finite())
}

/// Compares every pass, group and total of two runs, in A's order; passes of B alone come last. `threshold` is the
/// change of a time that counts, as a share, at least 0 and below 1. Frames are compared only if everything that was
/// set is the same. If one run's file does not give a setting, the setting is ignored, and the warning names it.
pub fn times(a: &Run, b: &Run, threshold: f64) -> Vec<TimeComparison> {
    let mut comparison = Comparison::new(a, b, threshold);
    if !a.samples.is_empty() && a.samples == b.samples {
        let same_run = format!("A and B are one run, {SAME_SAMPLES}");
        comparison.warning = Some(std::iter::once(same_run).chain(comparison.warning).collect::<Vec<_>>().join("; "));
    }
    let [samples_of_a, samples_of_b] = both_by_subject(a, b);
    let mut records = Vec::new();
    let mut only_in_b = Vec::new();
    for SubjectSamples { subject, passes } in &samples_of_a {
        let in_b = samples_of_b.iter().find(|samples| samples.subject == *subject);
        let passes_of_b = in_b.map_or(&[][..], |samples| &samples.passes);
        let differs = nearest(&samples_of_b, subject).map(|subject_b| subject.differences(subject_b).join("; "));
        for record in comparison.records([subject, subject], [passes, passes_of_b], false) {
            let is_of_b = record.only_in == Some(Side::B);
            let differs = differs.clone().filter(|_| record.only_in.is_some());
            let list = if is_of_b { &mut only_in_b } else { &mut records };
            list.push(TimeComparison { differs, ..record });
        }
    }
    let is_in_a = |subject: &Subject| samples_of_a.iter().any(|samples| samples.subject == *subject);
    for SubjectSamples { subject, passes } in samples_of_b.iter().filter(|samples| !is_in_a(&samples.subject)) {
        let differs = nearest(&samples_of_a, subject).map(|subject_a| subject_a.differences(subject).join("; "));
        let records_of_b = comparison.records([subject, subject], [&[], passes], false).into_iter();
        only_in_b.extend(records_of_b.map(|record| TimeComparison { differs: differs.clone(), ..record }));
    }
    records.extend(only_in_b);
    records
}

/// Names the settings in which the first subject of A and the subject of B nearest to it differ. The result has two
/// texts, for the options `--a` and `--b`, and says whether both subjects have one place, so that one run can time them
/// in turn. `None` if a run has no frames.
pub fn named_settings(a: &Run, b: &Run) -> Option<([String; 2], bool)> {
    let [samples_of_a, samples_of_b] = both_by_subject(a, b);
    let first = &samples_of_a.first()?.subject;
    let other = nearest(&samples_of_b, first).or_else(|| samples_of_b.first().map(|samples| &samples.subject))?;
    Some(([first.difference_from(other, "--"), other.difference_from(first, "--")], first.place() == other.place()))
}

/// End of the warning about a comparison of a run with itself.
const SAME_SAMPLES: &str = "with the same samples: nothing is compared";

/// Says why two runs may not be comparable: different or unknown devices, and settings that only one of the files
/// gives. `None` if nothing speaks against a comparison.
fn warning(a: &Run, b: &Run) -> Option<String> {
    let condition = "times compare only on one device";
    let device = match (&a.device, &b.device) {
        (Some(a), Some(b)) if a == b => None,
        (Some(a), Some(b)) => {
            Some(format!("A ran on {} ({}), B on {} ({}): {condition}", a.name, a.driver, b.name, b.driver))
        }
        (None, None) => Some(format!("no time.json says on which devices A and B ran: {condition}")),
        (None, _) => Some(format!("no time.json says on which device A ran: {condition}")),
        (_, None) => Some(format!("no time.json says on which device B ran: {condition}")),
    };
    let missing_settings =
        [("A", a.missing_settings(b)), ("B", b.missing_settings(a))].into_iter().filter(|(_, names)| !names.is_empty());
    let settings = missing_settings.map(|(run, names)| {
        let names: Vec<_> = names.into_iter().collect();
        format!("{run}'s samples do not say {}, which is left out of account", names.join(", "))
    });
    let reasons: Vec<_> = device.into_iter().chain(settings).collect();
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

/// Finds the subject in `samples` that differs from `subject` in the fewest values, among those with the same scene,
/// view and method. `None` if there is none, or if `samples` has `subject` itself.
fn nearest<'g>(samples: &'g [SubjectSamples], subject: &Subject) -> Option<&'g Subject> {
    let candidates = samples.iter().map(|s| &s.subject).filter(|s| s.has_same_scene_view_and_method(subject));
    let nearest = candidates.min_by_key(|candidate| candidate.differences(subject).len());
    nearest.filter(|candidate| *candidate != subject)
}

/// Finds the samples of the pass that has the same name, group and `counted` as the pass of `wanted`.
fn find<'g>(passes: &'g [Samples], wanted: &Samples) -> Option<&'g Samples> {
    passes.iter().find(|s| s.pass == wanted.pass && s.part_of == wanted.part_of && s.counted == wanted.counted)
}

#[cfg(test)]
mod tests;
