//! Two runs of the time study, or two images, beside each other (docs/definitions.md, "Time" and "Image
//! error"). Times are compared pass by pass from their raw samples.

use super::error::display;
use super::record::{DEFINITIONS, Provenance, Stats};
use crate::gpu::DeviceInfo;
use crate::metrics::bootstrap::{CONFIDENCE, MIN_SAMPLES, RESAMPLES, Verdict, ratio_of_medians};
use crate::metrics::flip::FlipMap;
use crate::metrics::image::{error_map, masked_relative_mse, masked_rmse};
use serde::{Serialize, Serializer};
use serde_json::Value as Json;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The name under which the sum of a frame's counted passes is compared.
pub const TOTAL: &str = "total";

/// Seed of every interval's resamples.
pub const SEED: u64 = 1;

/// What a frame was of: scene, view, method and everything that was set, by name. What the method does not have, and what
/// a file does not say, is not there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Subject(pub BTreeMap<String, String>);

impl Subject {
    /// A value as its file has it; nothing where it is null or not known.
    pub fn get(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// Whether two are of the same scene, view and method.
    fn is_like(&self, other: &Self) -> bool {
        LIKE.iter().all(|name| self.get(name) == other.get(name))
    }

    /// In what two differ, as "cone_samples 7 in A, 3 in B".
    fn differences(&self, b: &Self) -> Vec<String> {
        let value = |of: &Self, name: &str| match of.get(name) {
            "" => "not set".to_owned(),
            value => value.to_owned(),
        };
        let names: BTreeSet<&String> = self.0.keys().chain(b.0.keys()).collect();
        let differ = names.into_iter().filter(|name| self.get(name) != b.get(name));
        differ.map(|name| format!("{name} {} in A, {} in B", value(self, name), value(b, name))).collect()
    }
}

/// What makes two subjects alike enough to say in what they differ.
const LIKE: [&str; 3] = ["scene", "view", "method"];

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

/// A row of raw samples: the time of one pass in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeSample {
    /// What the frame was of; rows that follow each other share it.
    pub subject: Arc<Subject>,
    /// Number of the frame among those of its subject.
    pub sample: u64,
    /// Label.
    pub pass: String,
    /// Whether the pass counts towards the total.
    pub counted: bool,
    /// Milliseconds, finite and ≥ 0.
    pub ms: f64,
    /// Noise floors, as shares: of the pass, and of the total; where they were measured.
    pub floors: [Option<f64>; 2],
}

/// A run of the time study, as its files tell it.
#[derive(Debug, Clone)]
pub struct Run {
    /// What the user calls it.
    pub name: String,
    /// The device, if the run's records are there to say it.
    pub device: Option<DeviceInfo>,
    /// Raw samples, those of a frame one after the other.
    pub samples: Vec<TimeSample>,
}

impl Run {
    /// The names of what its file says of a method's frames; `None` if it has none.
    fn told(&self, method: &str) -> Option<BTreeSet<&String>> {
        let of = |s: &&TimeSample| s.subject.get("method") == method;
        self.samples
            .iter()
            .any(|s| of(&s))
            .then(|| self.samples.iter().filter(of).flat_map(|s| s.subject.0.keys()).collect())
    }

    /// Its samples, of each method with what both this and another run's file say.
    fn told_by_both(&self, other: &Self) -> Vec<TimeSample> {
        let mut known: BTreeMap<String, Option<BTreeSet<&String>>> = BTreeMap::new();
        let mut samples = self.samples.clone();
        let mut last: Option<[Arc<Subject>; 2]> = None;
        for s in &mut samples {
            let stripped = match &last {
                Some([from, to]) if Arc::ptr_eq(from, &s.subject) => Arc::clone(to),
                _ => {
                    let method = s.subject.get("method").to_owned();
                    match known.entry(method).or_insert_with_key(|method| other.told(method)) {
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

    /// What another run's file says of the methods that both have, and this one's does not.
    fn untold(&self, other: &Self) -> BTreeSet<String> {
        let methods: BTreeSet<&str> = self.samples.iter().map(|s| s.subject.get("method")).collect();
        let of = |method: &&str| {
            let (mine, theirs) = (self.told(method)?, other.told(method)?);
            Some(theirs.difference(&mine).map(|name| (*name).clone()).collect::<Vec<_>>())
        };
        methods.iter().filter_map(of).flatten().collect()
    }
}

/// How an interval was found, and what it was held against.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Judgement {
    /// Change that counts, 0 ≤ t < 1.
    pub threshold: f64,
    /// Share of the resamples in the interval.
    pub confidence: f64,
    /// Resamples.
    pub resamples: u32,
    /// Their seed.
    pub seed: u64,
}

/// One of the two runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Side {
    /// The first, what is compared with.
    A,
    /// The second.
    B,
}

/// What a record of a comparison begins with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompareHead {
    /// Which comparison.
    pub kind: &'static str,
    /// [`DEFINITIONS`].
    pub definitions: u32,
    /// Version of this program.
    pub version: &'static str,
    /// Commit of the program's source.
    pub commit: &'static str,
    /// The first, what is compared with.
    pub a: String,
    /// The second.
    pub b: String,
}

impl CompareHead {
    fn new(kind: &'static str, a: &str, b: &str) -> Self {
        let (version, commit) = (Provenance::VERSION, Provenance::COMMIT);
        Self { kind, definitions: DEFINITIONS, version, commit, a: a.to_owned(), b: b.to_owned() }
    }
}

/// A pass, or the total, of two runs. What one run lacks is null, and then so is the verdict.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimeComparison {
    /// "compare"; the runs' names.
    #[serde(flatten)]
    pub head: CompareHead,
    /// What was timed.
    #[serde(flatten)]
    pub subject: Subject,
    /// Label, or [`TOTAL`].
    pub pass: String,
    /// Whether the pass counts towards the total.
    pub counted: bool,
    /// The run that has it, if only one has.
    pub only_in: Option<Side>,
    /// If only one has it: in what the other's frames of the same scene, view and method differ, if it has any.
    pub differs: Option<String>,
    /// Samples.
    pub samples_a: usize,
    /// Samples.
    pub samples_b: usize,
    /// Median in milliseconds.
    pub median_a_ms: Option<f64>,
    /// Median in milliseconds.
    pub median_b_ms: Option<f64>,
    /// B's median over A's; null in JSON if infinite, for an A of 0.
    pub ratio: Option<f64>,
    /// Lower end of its interval.
    pub low: Option<f64>,
    /// Upper end of its interval.
    pub high: Option<f64>,
    /// How far a run strays from itself, as a share: the greater of the two, where one was measured. Nothing within it is
    /// faster or slower.
    pub noise_floor: Option<f64>,
    /// What the interval says; undecided with fewer than [`MIN_SAMPLES`] on a side.
    pub verdict: Option<Verdict>,
    /// How.
    #[serde(flatten)]
    pub judgement: Judgement,
    /// Device of A; null if not known.
    pub device_a: Option<DeviceInfo>,
    /// Device of B; null if not known.
    pub device_b: Option<DeviceInfo>,
    /// Why the runs are no fair pair, if they may be none.
    pub warning: Option<String>,
}

/// The samples of one pass.
struct Samples {
    pass: String,
    counted: bool,
    ms: Vec<f64>,
    noise_floor: Option<f64>,
}

/// Everything of one subject: its passes in order, the total last.
type Group = (Subject, Vec<Samples>);

/// Compares every pass and total, in A's order; what only B has comes last. Threshold: 0 ≤ t < 1.
/// Frames are a pair only if everything that was set is the same. What one run's file does not say is left out of account,
/// and the warning names it.
pub fn times(a: &Run, b: &Run, threshold: f64) -> Vec<TimeComparison> {
    let warning = warning(a, b);
    let judgement = Judgement { threshold, confidence: CONFIDENCE, resamples: RESAMPLES, seed: SEED };
    let [groups_a, groups_b] = [(a, b), (b, a)].map(|(run, other)| groups(&run.told_by_both(other)));
    let compared = |subject: &Subject, of_a: Option<&Samples>, of_b: Option<&Samples>| {
        let [ms_a, ms_b] = [of_a, of_b].map(|s| s.map_or(&[][..], |s| &s.ms));
        let median = |ms: &[f64]| (!ms.is_empty()).then(|| Stats::of(ms).median_ms);
        let ratio = ratio_of_medians(ms_a, ms_b, SEED);
        let floors = [of_a, of_b].into_iter().flatten().filter_map(|s| s.noise_floor);
        let noise_floor = floors.reduce(f64::max);
        let threshold = threshold.max(noise_floor.unwrap_or(0.0));
        let enough = ms_a.len().min(ms_b.len()) >= MIN_SAMPLES;
        TimeComparison {
            head: CompareHead::new("compare", &a.name, &b.name),
            subject: subject.clone(),
            pass: of_a.or(of_b).map(|s| s.pass.clone()).unwrap_or_default(),
            counted: of_a.or(of_b).is_some_and(|s| s.counted),
            only_in: match (of_a, of_b) {
                (Some(_), None) => Some(Side::A),
                (None, Some(_)) => Some(Side::B),
                _ => None,
            },
            differs: match (of_a, of_b) {
                (Some(_), None) => nearest(&groups_b, subject).map(|b| subject.differences(b).join("; ")),
                (None, Some(_)) => nearest(&groups_a, subject).map(|a| a.differences(subject).join("; ")),
                _ => None,
            },
            samples_a: ms_a.len(),
            samples_b: ms_b.len(),
            median_a_ms: median(ms_a),
            median_b_ms: median(ms_b),
            ratio: ratio.map(|r| r.ratio),
            low: ratio.map(|r| r.low),
            high: ratio.map(|r| r.high),
            noise_floor,
            verdict: ratio.map(|r| if enough { Verdict::of(&r, threshold) } else { Verdict::Undecided }),
            judgement,
            device_a: a.device.clone(),
            device_b: b.device.clone(),
            warning: warning.clone(),
        }
    };
    let mut records = Vec::new();
    for (subject, passes) in &groups_a {
        records.extend(passes.iter().map(|s| compared(subject, Some(s), find(&groups_b, subject, &s.pass))));
    }
    for (subject, passes) in &groups_b {
        let missing = passes.iter().filter(|s| find(&groups_a, subject, &s.pass).is_none());
        records.extend(missing.map(|s| compared(subject, None, Some(s))));
    }
    records
}

/// Why two runs may be no fair pair.
fn warning(a: &Run, b: &Run) -> Option<String> {
    let only = "times compare only on one device";
    let device = match (&a.device, &b.device) {
        (Some(a), Some(b)) if a == b => None,
        (Some(a), Some(b)) => {
            Some(format!("A ran on {} ({}), B on {} ({}): {only}", a.name, a.driver, b.name, b.driver))
        }
        (None, None) => Some(format!("no time.json says on which devices A and B ran: {only}")),
        (None, _) => Some(format!("no time.json says on which device A ran: {only}")),
        (_, None) => Some(format!("no time.json says on which device B ran: {only}")),
    };
    let untold = [("A", a.untold(b)), ("B", b.untold(a))].into_iter().filter(|(_, names)| !names.is_empty());
    let settings = untold.map(|(run, names)| {
        let names: Vec<_> = names.into_iter().collect();
        format!("{run}'s samples do not say {}, which is left out of account", names.join(", "))
    });
    let all: Vec<_> = device.into_iter().chain(settings).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// The subject like a given one that differs from it in the fewest values; `None` if it is there itself, and lacks no more
/// than a pass, or if there is none like it.
fn nearest<'g>(groups: &'g [Group], subject: &Subject) -> Option<&'g Subject> {
    let like = groups.iter().map(|(s, _)| s).filter(|s| s.is_like(subject));
    like.min_by_key(|s| s.differences(subject).len()).filter(|s| *s != subject)
}

fn find<'g>(groups: &'g [Group], subject: &Subject, pass: &str) -> Option<&'g Samples> {
    let (_, passes) = groups.iter().find(|(s, _)| s == subject)?;
    passes.iter().find(|s| s.pass == pass)
}

/// Samples by subject and pass, both in order of appearance. Rows of one subject and sample number
/// that follow each other are one frame; its counted passes add up to a sample of the total.
fn groups(rows: &[TimeSample]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for frame in rows.chunk_by(|a, b| a.sample == b.sample && a.subject == b.subject) {
        let Some(first) = frame.first() else { continue };
        let at = groups.iter().rposition(|(s, _)| *s == *first.subject).unwrap_or_else(|| {
            groups.push(((*first.subject).clone(), Vec::new()));
            groups.len() - 1
        });
        let passes = &mut groups[at].1;
        let mut add = |pass: &str, counted, ms, noise_floor| match passes.iter_mut().find(|s| s.pass == pass) {
            Some(s) => s.ms.push(ms),
            None => passes.push(Samples { pass: pass.to_owned(), counted, ms: vec![ms], noise_floor }),
        };
        for row in frame {
            add(&row.pass, row.counted, row.ms, row.floors[0]);
        }
        if frame.iter().any(|r| r.counted) {
            add(TOTAL, true, frame.iter().filter(|r| r.counted).map(|r| r.ms).sum(), first.floors[1]);
        }
    }
    for (_, passes) in &mut groups {
        passes.sort_by_key(|s| s.pass == TOTAL);
    }
    groups
}

/// A linear image, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearImage {
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// `width · height` colours: red, green, blue.
    pub rgb: Vec<[f32; 3]>,
}

/// How far two images are apart. A figure is null in JSON where an image holds what is no number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageComparison {
    /// "compare-images"; the images' names.
    #[serde(flatten)]
    pub head: CompareHead,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Root mean square error of the linear values.
    pub rmse: f64,
    /// Mean square error over the reference's mean square; null if the reference is black.
    pub rel_mse: Option<f64>,
    /// Mean FLIP of the display images, 0…1.
    pub flip: f64,
    /// The greatest RMSE of a pixel, of those that are numbers.
    pub greatest: f32,
    /// Column and row of that pixel, from the top left.
    pub greatest_at: [u32; 2],
    /// RMSE of each pixel.
    #[serde(skip)]
    pub rmse_map: Vec<f32>,
    /// FLIP of each pixel as a picture: 3 bytes a pixel.
    #[serde(skip)]
    pub flip_picture: Vec<u8>,
}

/// Compares an image with a reference; `None` if their sizes differ.
pub fn images(reference: (&str, &LinearImage), test: (&str, &LinearImage)) -> Option<ImageComparison> {
    let ((a_name, a), (b_name, b)) = (reference, test);
    let (width, height) = (a.width, a.height);
    if (width, height) != (b.width, b.height) {
        return None;
    }
    let all = vec![true; a.rgb.len()];
    let flip = FlipMap::new(&display(&a.rgb), &display(&b.rgb), width, height);
    let rmse_map = error_map(&a.rgb, &b.rgb, &all);
    let greater =
        |(n, most): (usize, f32), (i, error): (usize, &f32)| if *error > most { (i, *error) } else { (n, most) };
    let (at, greatest) = rmse_map.iter().enumerate().fold((0, 0.0), greater);
    Some(ImageComparison {
        head: CompareHead::new("compare-images", a_name, b_name),
        width,
        height,
        rmse: masked_rmse(&a.rgb, &b.rgb, &all),
        rel_mse: masked_relative_mse(&a.rgb, &b.rgb, &all),
        flip: flip.mean(),
        greatest,
        greatest_at: [at as u32 % width, at as u32 / width],
        rmse_map,
        flip_picture: flip.picture(),
    })
}

#[cfg(test)]
mod tests;
