//! The time study: variants of methods are timed in turn on one view, after a warm-up. Each sample is the time of one
//! frame, and goes into the journal at once.

mod suite;
mod verdicts;

pub use suite::{
    FLOORS, MEASURED, MEDIAN_COLUMNS, MEDIANS, PLACE, SAMPLES, ThesisFigures, TimeJob, TimeRow, TimeSettings,
    TimeStudy, TimedFrame, chart, frames, sample_cells,
};

use super::compare::SEED;
use super::engine::LastMade;
use super::error::Variant;
use super::interleave::{Round, Sample, interleave, sample_in_journal};
use super::journal::{Journal, digest, scene_digest};
use super::record::{Head, PassRecord, RecordSubject, Stats, TimeRecord};
use crate::error::Result;
use crate::stage::{Globals, SharedImages, Shot, Stage};
use serde_json::{Value, json};
use ssct::gpu::Gpu;
use ssct::gpu::frame::Mode;
use ssct::gpu::timing::PassTime;
use ssct::methods::Wants;
use ssct_scenes::{Scene, View};
use ssct_truth::metrics::bootstrap::noise_floor;
use std::fmt::Display;

/// Scene, view and settings of the study: every combination of sizes, factors and variants is timed.
pub struct TimeSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene.
    pub scene: &'a Scene,
    /// View of the scene.
    pub view: &'a View,
    /// Methods with their parameters, timed in turn within each size and set of factors.
    pub variants: Vec<Variant>,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Sets of global factors.
    pub globals: Vec<Globals>,
    /// Number of frames that warm up. The frame whose work is counted comes before them.
    pub warmup: usize,
    /// Number of timed frames.
    pub samples: usize,
    /// Whether each variant is also timed against itself, by two shots in each turn, which measures its noise floor.
    pub a_a: bool,
}

/// A group: one size with one set of factors, at which all variants are timed in turn.
struct Group<'a> {
    spec: &'a TimeSpec<'a>,
    extent: [u32; 2],
    globals: Globals,
    /// Digest of everything that the samples depend on, which is a part of their keys in the journal.
    digest: String,
}

impl<'a> TimeSpec<'a> {
    /// Returns the number of frames that [`measure`] draws if the journal has none.
    pub fn frames(&self) -> usize {
        let frames_of_group = frames_of_a_group(self.variants.len(), self.warmup, self.samples, self.a_a);
        self.sizes.len() * self.globals.len() * frames_of_group
    }

    /// Returns the groups in the order in which they are measured: by size, and then by factors.
    fn groups(&'a self) -> impl Iterator<Item = Group<'a>> {
        let digest = scene_digest(self.scene);
        let groups_of_size = move |extent| {
            let digest = digest.clone();
            self.globals.iter().map(move |globals| self.group(extent, *globals, &digest))
        };
        self.sizes.iter().copied().flat_map(groups_of_size)
    }

    /// Returns the group whose variants are timed in turn at a size and with a set of factors.
    fn group(&'a self, extent: [u32; 2], globals: Globals, scene_digest: &str) -> Group<'a> {
        let variants = recorded_variants(&self.variants, extent);
        // The number of samples is left out, since a later run may add more.
        let settings = json!([scene_digest, format!("{:?}", self.view), globals, variants, self.warmup]);
        let digest = digest(self.gpu, &settings);
        Group { spec: self, extent, globals, digest }
    }
}

impl Group<'_> {
    /// Returns the beginning of the keys of a variant's samples. The variant's index tells two variants of one method
    /// apart.
    fn key_prefix(&self, variant: usize) -> String {
        let [width, height] = self.extent;
        let (scene, view) = (&self.spec.scene.name, &self.spec.view.name);
        let method = self.spec.variants[variant].method.name;
        format!("time {scene} {view} {width}x{height} {} {variant} {method}", self.digest)
    }

    /// Returns the head of the record of a variant, given by its index.
    fn head(&self, variant: usize) -> Head {
        let Variant { method, setup } = &self.spec.variants[variant];
        let (place, setup) = ((self.spec.scene, self.spec.view), setup.with_extent(self.extent));
        Head::new("time", self.spec.gpu, place, RecordSubject::Method(method), &setup, &self.globals)
    }

    /// Whether the journal has every sample of every variant.
    fn is_whole(&self, journal: &Journal) -> bool {
        let spec = self.spec;
        (0..spec.variants.len()).all(|n| is_whole(&self.key_prefix(n), spec.samples, spec.a_a, journal))
    }

    /// Measures the samples that the journal lacks, with the variants in turn. Only variants that lack samples are
    /// warmed up. If variants are timed against themselves, `shots` has two shots of each variant: first one of each,
    /// and then the other.
    fn measure(
        &self,
        stage: &mut Stage,
        (shared, shots): (&mut SharedImages, &mut [Shot]),
        journal: &mut Journal,
        progress: &mut dyn FnMut() -> Result<()>,
    ) -> Result<()> {
        let spec = self.spec;
        let mut rounds = vec![Round { label: Some(COUNTED.to_owned()), mode: Mode::Counted, camera: None }];
        rounds.extend(Round::timed(spec.warmup, spec.samples));
        // Shots beyond the number of variants make the second series of the same variants.
        let key = |shot: usize, sample: &str| match shot.checked_sub(spec.variants.len()) {
            None => key(&self.key_prefix(shot), sample),
            Some(variant) => key(&self.key_prefix(variant), second_series_label(sample)),
        };
        interleave(stage, (shared, shots), &rounds, &key, journal, progress)
    }
}

/// Shots with their key: the number of the groups that they belong to ([`LastShots::time`]), and the size of their
/// images.
type SizedShots = ((usize, [u32; 2]), (SharedImages, Vec<Shot>));

/// The stage and the shots of the last group, which the next group uses again if it can.
#[derive(Default)]
struct LastShots {
    /// The stage, by the name of its scene.
    stage: LastMade<String, Stage>,
    shots: Option<SizedShots>,
}

impl LastShots {
    /// Measures the samples of a group that the journal lacks. Groups that are given the same `number` must have the
    /// same scene, view and variants.
    fn time(
        &mut self,
        number: usize,
        group: &Group,
        journal: &mut Journal,
        progress: &mut dyn FnMut() -> Result<()>,
    ) -> Result<()> {
        let spec = group.spec;
        let shots_key = (number, group.extent);
        let same_shots = self.shots.take().filter(|(key, _)| *key == shots_key);
        let stage = self.stage.get_or_make(spec.scene.name.clone(), || Stage::new(spec.gpu, spec.scene))?;
        let materials = group.globals.materials(spec.scene, spec.view);
        // Shots of another size were dropped above, since the device may not have room for both.
        let shots = match same_shots {
            Some((_, (shared, mut shots))) => {
                shots.iter_mut().try_for_each(|shot| shot.set_materials(stage, materials.clone()))?;
                (shared, shots)
            }
            None => {
                let camera = spec.view.camera(spec.scene, group.extent);
                let series = if spec.a_a { 2 } else { 1 };
                let variants = (0..series).flat_map(|_| &spec.variants);
                // Only the image is timed, so that no separate image of the reflection is made.
                let variants = variants.map(|Variant { method, setup }| (*method, setup.with_extent(group.extent)));
                let mut shared = SharedImages::default();
                let shots = shared.shots(stage, variants, Wants::IMAGE, camera, &materials)?;
                (shared, shots)
            }
        };
        let (_, (shared, shots)) = self.shots.insert((shots_key, shots));
        group.measure(stage, (shared, shots), journal, progress)
    }
}

/// Returns the number of frames of a group, including for each shot the frame whose work is counted.
fn frames_of_a_group(variants: usize, warmup: usize, samples: usize, a_a: bool) -> usize {
    let series = if a_a { 2 } else { 1 };
    series * variants * (warmup + samples + 1)
}

/// Returns a list of the names of variants' methods, each with everything that is set for the variant at a size.
fn recorded_variants(variants: &[Variant], extent: [u32; 2]) -> Value {
    let entry = |v: &Variant| (v.method.name, v.setup.with_extent(extent).recorded(Some(v.method)));
    json!(variants.iter().map(entry).collect::<Vec<_>>())
}

/// Returns the key of a sample in the journal, by its label; `prefix` is the beginning of the keys of all samples of a
/// variant.
fn key(prefix: &str, sample: impl Display) -> String {
    format!("{prefix} {sample}")
}

/// Makes the record of a variant from its samples in the journal, whose keys begin with `prefix`. The samples with a
/// number of at least `samples` are left out. `None` if the journal has none.
fn record_from_samples(head: Head, prefix: &str, samples: usize, journal: &Journal) -> Option<TimeRecord> {
    let series = |label: &dyn Fn(usize) -> String| -> Vec<Sample> {
        (0..samples).filter_map(|n| sample_in_journal(journal, &key(prefix, label(n)))).collect()
    };
    let (frames, second_frames) = (series(&|n| n.to_string()), series(&|n| second_series_label(n)));
    let first = frames.first()?;
    let work = sample_in_journal(journal, &key(prefix, COUNTED)).map(|s| s.report.work).unwrap_or_default();
    // For each frame the milliseconds of each pass.
    let pass_times = |frames: &[Sample]| -> Vec<Vec<f64>> {
        frames.iter().map(|frame| frame.report.passes.iter().map(|p| p.ms).collect()).collect()
    };
    let (samples, second_samples) = (pass_times(&frames), pass_times(&second_frames));
    let of_pass = |samples: &[Vec<f64>], i: usize| samples.iter().filter_map(|s| s.get(i).copied()).collect::<Vec<_>>();
    let totals = |frames: &[Sample]| frames.iter().map(Sample::effect_ms).collect::<Vec<_>>();
    let pass_record = |(i, pass): (usize, &PassTime)| PassRecord {
        name: pass.name.clone(),
        counted: pass.counted,
        stats: Stats::from_samples(&of_pass(&samples, i)),
        noise_floor: noise_floor(&of_pass(&samples, i), &of_pass(&second_samples, i), SEED),
        work: work.get(i).copied(),
    };
    let passes = first.report.passes.iter().enumerate().map(pass_record).collect();
    Some(TimeRecord {
        head,
        passes,
        total: Stats::from_samples(&totals(&frames)),
        noise_floor: noise_floor(&totals(&frames), &totals(&second_frames), SEED),
        frame: Stats::from_samples(&frames.iter().map(|frame| frame.report.frame_ms).collect::<Vec<_>>()),
        drawn: first.drawn,
        recorded: first.report.recorded.clone(),
        skipped: first.report.skipped.clone(),
        samples,
    })
}

/// Returns the keys of every sample of a variant, then those of the second series if `a_a`, and last the key of the
/// frame whose work is counted. The keys begin with `prefix`.
fn keys(prefix: &str, samples: usize, a_a: bool) -> Vec<String> {
    let second_series = (0..samples).filter(|_| a_a).map(second_series_label);
    let labels = (0..samples).map(|n| n.to_string()).chain(second_series).chain([COUNTED.to_owned()]);
    labels.map(|label| key(prefix, label)).collect()
}

/// Whether a journal has every sample of a variant, and the frame whose work is counted ([`keys`]).
fn is_whole(prefix: &str, samples: usize, a_a: bool, journal: &Journal) -> bool {
    keys(prefix, samples, a_a).iter().all(|key| sample_in_journal(journal, key).is_some())
}

/// Returns the label in the journal of a sample of the second series, by the label of the same sample in the first.
fn second_series_label(sample: impl Display) -> String {
    format!("again {sample}")
}

/// The label of the frame whose work is counted.
const COUNTED: &str = "work";

/// Measures the samples of all groups that the journal lacks. `progress` is called after each frame; its error ends the
/// study.
///
/// # Errors
/// Errors of the device, of the journal and of `progress`.
pub fn measure(spec: &TimeSpec, journal: &mut Journal, progress: &mut dyn FnMut() -> Result<()>) -> Result<()> {
    let mut timer = LastShots::default();
    for group in spec.groups() {
        if !group.is_whole(journal) {
            timer.time(0, &group, journal, progress)?;
        }
    }
    Ok(())
}

/// Makes the records of all variants that have samples in the journal, in the order of sizes, factors and variants.
pub fn records(spec: &TimeSpec, journal: &Journal) -> Vec<TimeRecord> {
    let record = |group: &Group, n| record_from_samples(group.head(n), &group.key_prefix(n), spec.samples, journal);
    let group_records = |group: Group| (0..spec.variants.len()).filter_map(|n| record(&group, n)).collect::<Vec<_>>();
    spec.groups().flat_map(group_records).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::record::tests::another;
    use ssct::gpu::DeviceQuery;
    use ssct::methods::{METHODS, MethodInfo, Setup};
    use ssct_scenes::library;

    #[test]
    fn samples_of_different_setups_have_different_keys_in_the_journal() {
        let gpu = Gpu::open(&DeviceQuery::default()).expect("a device");
        let scene = library::scene("rooms").expect("built in");
        let key = |method: &'static MethodInfo, setup: &Setup| {
            let (sizes, globals) = (vec![[64, 48]], vec![Globals::default()]);
            let (view, variants) = (&scene.views[0], Variant::for_methods(&[method], setup));
            let spec = TimeSpec {
                gpu: &gpu,
                scene: &scene,
                view,
                variants,
                sizes,
                globals,
                warmup: 0,
                samples: 1,
                a_a: false,
            };
            let group = spec.groups().next().expect("one size");
            group.key_prefix(0)
        };
        for method in METHODS {
            let base = Setup::new([64, 48]);
            let before = key(method, &base);
            for parameter in method.read_parameters() {
                let mut changed = base.clone();
                changed.values.set(&parameter, another(&parameter, base.values.value(&parameter)));
                assert_ne!(before, key(method, &changed), "{} of {}", parameter.name, method.name);
            }
        }
    }
}
