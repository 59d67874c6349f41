//! The time study: methods interleaved on the same view, warm-up first, one submission a sample, and each
//! sample in the journal as soon as it is there.

use super::compare::SEED;
use super::interleave::{Round, Sample, interleave};
use super::journal::{Journal, digest, scene_digest};
use super::record::{Head, Of, PassRecord, Stats, TimeRecord};
use super::stage::{Globals, Shot, Stage};
use crate::error::Result;
use crate::gpu::frame::Mode;
use crate::gpu::{FrameReport, Gpu};
use crate::methods::{MethodInfo, Setup, Wants};
use crate::metrics::bootstrap::noise_floor;
use crate::scene::{Scene, View};
use serde_json::json;
use std::fmt::Display;

/// What is timed: every combination of sizes, roughness values and methods.
pub struct TimeSpec<'a> {
    /// Device.
    pub gpu: &'a Gpu,
    /// Scene.
    pub scene: &'a Scene,
    /// View of the scene.
    pub view: &'a View,
    /// Methods, taken in turn within each size and roughness.
    pub methods: Vec<&'static MethodInfo>,
    /// Sizes in pixels.
    pub sizes: Vec<[u32; 2]>,
    /// Global factors of each run.
    pub globals: Vec<Globals>,
    /// How the methods are set up; the size is each of `sizes`.
    pub setup: Setup,
    /// Frames before the first that counts.
    pub warmup: usize,
    /// Frames that count.
    pub samples: usize,
    /// Whether each method is timed against itself as well: twice in each turn, so that what it strays from itself is known.
    pub a_a: bool,
}

impl TimeSpec<'_> {
    /// Frames that [`measure`] submits if the journal has none.
    pub fn frames(&self) -> usize {
        let series = if self.a_a { 2 } else { 1 };
        series * self.methods.len() * self.sizes.len() * self.globals.len() * (self.warmup + self.samples + 1)
    }
}

/// The samples of one size with one of the global factors: where the journal keeps them.
struct Group<'a> {
    spec: &'a TimeSpec<'a>,
    extent: [u32; 2],
    globals: &'a Globals,
    digest: String,
}

impl<'a> TimeSpec<'a> {
    /// In the order in which they are measured.
    fn groups(&'a self) -> impl Iterator<Item = Group<'a>> {
        let scene = scene_digest(self.scene);
        self.sizes.iter().flat_map(move |&extent| {
            let scene = scene.clone();
            self.globals.iter().map(move |globals| {
                let setup = self.setup.at(extent);
                let methods: Vec<_> = self.methods.iter().map(|m| (m.name, setup.recorded(Some(m)))).collect();
                // Not how many samples: more may be asked for later.
                let settings = json!([scene, format!("{:?}", self.view), globals, methods, self.warmup]);
                Group { spec: self, extent, globals, digest: digest(self.gpu, &settings) }
            })
        })
    }
}

impl Group<'_> {
    fn key(&self, method: &MethodInfo, sample: impl Display) -> String {
        let [width, height] = self.extent;
        let (scene, view) = (&self.spec.scene.name, &self.spec.view.name);
        format!("time {scene} {view} {width}x{height} {} {} {sample}", self.digest, method.name)
    }

    /// Keys of every sample of a method, and of the frame that counts its work.
    fn keys(&self, method: &MethodInfo) -> Vec<String> {
        let samples = (0..self.spec.samples).map(|n| self.key(method, n));
        let again = (0..self.spec.samples).filter(|_| self.spec.a_a).map(|n| self.key(method, again(n)));
        samples.chain(again).chain([self.key(method, COUNTED)]).collect()
    }

    /// What the journal has of a method; `None` without a sample.
    fn record(&self, method: &MethodInfo, journal: &Journal) -> Option<TimeRecord> {
        let spec = self.spec;
        let reports: Vec<Sample> =
            (0..spec.samples).filter_map(|n| journal.get::<Sample>(&self.key(method, n))).collect();
        let first = reports.first()?;
        let work = journal.get::<Sample>(&self.key(method, COUNTED)).map(|s| s.report.work).unwrap_or_default();
        let (place, setup) = ((spec.scene, spec.view), spec.setup.at(self.extent));
        let head = Head::new("time", spec.gpu, place, Of::Method(method), &setup, self.globals);
        let times = |reports: &[Sample]| -> Vec<Vec<f64>> {
            reports.iter().map(|r| r.report.passes.iter().map(|p| p.ms).collect()).collect()
        };
        let samples = times(&reports);
        let reports_again: Vec<Sample> =
            (0..spec.samples).filter_map(|n| journal.get::<Sample>(&self.key(method, again(n)))).collect();
        let samples_again = times(&reports_again);
        let of_pass =
            |samples: &[Vec<f64>], i: usize| samples.iter().filter_map(|s| s.get(i).copied()).collect::<Vec<_>>();
        let totals = |reports: &[Sample]| reports.iter().map(Sample::effect_ms).collect::<Vec<_>>();
        let passes = first.report.passes.iter().enumerate();
        let passes = passes
            .map(|(i, p)| PassRecord {
                name: p.name.clone(),
                counted: p.counted,
                stats: Stats::of(&of_pass(&samples, i)),
                noise_floor: noise_floor(&of_pass(&samples, i), &of_pass(&samples_again, i), SEED),
                work: work.get(i).copied(),
            })
            .collect();
        Some(TimeRecord {
            head,
            passes,
            total: Stats::of(&totals(&reports)),
            noise_floor: noise_floor(&totals(&reports), &totals(&reports_again), SEED),
            frame: Stats::of(&reports.iter().map(|r| r.report.frame_ms).collect::<Vec<_>>()),
            drawn: first.drawn,
            recorded: first.report.recorded.clone(),
            skipped: first.report.skipped.clone(),
            samples,
        })
    }

    /// Runs what the journal lacks, the methods in turn; those that lack something are warmed up.
    fn measure(
        &self,
        stage: &mut Stage,
        shots: &mut [Shot],
        journal: &mut Journal,
        progress: &mut dyn FnMut() -> Result<()>,
    ) -> Result<()> {
        let spec = self.spec;
        let mut rounds = Round::timed(spec.warmup, spec.samples);
        rounds.push(Round { label: Some(COUNTED.to_owned()), mode: Mode::Counted, camera: None });
        // The second series of each method is that of its twin.
        let key = |shot: usize, sample: &str| match spec.methods.get(shot) {
            Some(method) => self.key(method, sample),
            None => self.key(spec.methods[shot - spec.methods.len()], again(sample)),
        };
        interleave(stage, shots, &rounds, &key, journal, progress)
    }
}

/// What the journal calls a sample of the second series.
fn again(sample: impl Display) -> String {
    format!("again {sample}")
}

/// The sample of the frame whose work is counted.
const COUNTED: &str = "work";

/// Measures what the journal lacks. `progress` is called after each frame; its error ends the study.
pub fn measure(spec: &TimeSpec, journal: &mut Journal, progress: &mut dyn FnMut() -> Result<()>) -> Result<()> {
    let mut stage = None;
    let mut shots: (Option<[u32; 2]>, Vec<Shot>) = (None, Vec::new());
    for group in spec.groups() {
        let lacks = |m: &&MethodInfo| group.keys(m).iter().any(|key| !journal.has(key));
        if !spec.methods.iter().any(lacks) {
            continue;
        }
        if stage.is_none() {
            stage = Some(Stage::new(spec.gpu, spec.scene)?);
        }
        let Some(stage) = &mut stage else { continue };
        let materials = group.globals.materials(spec.scene, spec.view);
        if shots.0 == Some(group.extent) {
            for shot in &mut shots.1 {
                shot.set_materials(stage, materials.clone())?;
            }
        } else {
            // The last size's first: the device may not have room for both.
            shots = (None, Vec::new());
            let camera = spec.view.camera(spec.scene, group.extent);
            let setup = spec.setup.at(group.extent);
            let series = if spec.a_a { 2 } else { 1 };
            for method in (0..series).flat_map(|_| &spec.methods) {
                // What is timed is the image; a reflection of its own is for those who look at it.
                shots.1.push(Shot::new(stage, method, &setup, Wants::IMAGE, camera, materials.clone())?);
            }
            shots.0 = Some(group.extent);
        }
        group.measure(stage, &mut shots.1, journal, progress)?;
    }
    Ok(())
}

/// The records of what the journal has, in the order of sizes, factors and methods.
pub fn records(spec: &TimeSpec, journal: &Journal) -> Vec<TimeRecord> {
    let of = |group: Group| spec.methods.iter().filter_map(|m| group.record(m, journal)).collect::<Vec<_>>();
    spec.groups().flat_map(of).collect()
}

/// A timed frame of a method, with what it was of.
pub struct TimedFrame {
    /// The method.
    pub method: &'static str,
    /// Size, roughness and number, for labels.
    pub label: String,
    /// Its passes and the host's side.
    pub report: FrameReport,
}

/// Every timed frame that the journal has, those of the second series of each method among them.
pub fn frames(spec: &TimeSpec, journal: &Journal) -> Vec<TimedFrame> {
    let mut frames = Vec::new();
    for group in spec.groups() {
        let [width, height] = group.extent;
        let roughness =
            group.globals.roughness.map_or_else(|| "own roughness".to_owned(), |r| format!("roughness {r}"));
        for method in &spec.methods {
            let keys = group.keys(method);
            for (n, key) in keys[..keys.len() - 1].iter().enumerate() {
                if let Some(Sample { report, .. }) = journal.get::<Sample>(key) {
                    let label = format!("{width}x{height}, {roughness}, sample {n}");
                    frames.push(TimedFrame { method: method.name, label, report });
                }
            }
        }
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::DeviceQuery;
    use crate::methods::METHODS;
    use crate::scene::library;
    use crate::study::record::tests::another;

    /// What the journal keeps under one name was measured with one setup.
    #[test]
    fn a_changed_parameter_changes_where_the_journal_keeps_a_sample() {
        let gpu = Gpu::open(&DeviceQuery::default()).expect("a device");
        let scene = library::scene("rooms").expect("built in");
        let key = |method: &'static MethodInfo, setup: &Setup| {
            let (sizes, globals) = (vec![[64, 48]], vec![Globals::default()]);
            let (view, setup) = (&scene.views[0], setup.clone());
            let methods = vec![method];
            let spec = TimeSpec {
                gpu: &gpu,
                scene: &scene,
                view,
                methods,
                sizes,
                globals,
                setup,
                warmup: 0,
                samples: 1,
                a_a: false,
            };
            let group = spec.groups().next().expect("one size");
            group.key(method, 0)
        };
        for method in METHODS {
            let base = Setup::new([64, 48]);
            let before = key(method, &base);
            for parameter in method.reads() {
                let mut changed = base.clone();
                changed.values.set(&parameter, another(&parameter, base.values.of(&parameter)));
                assert_ne!(before, key(method, &changed), "{} of {}", parameter.name, method.name);
            }
        }
    }
}
