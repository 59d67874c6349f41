//! `ssct gpu-study`: what a device does with all of it, in minutes: times, their noise, work, rates, and whether its images
//! are those of other devices.

use super::cli::DeviceOptions;
use super::run::Run;
use super::{drivers, progress, resolve};
use crate::error::{Error, Result};
use crate::gpu::{DeviceQuery, Gpu};
use crate::methods::setup::CaptureCount;
use crate::methods::unified::UnifiedParams;
use crate::methods::{EffectParams, METHODS, MethodInfo, Setup, captures, unified};
use crate::metrics::bootstrap::MIN_SAMPLES;
use crate::passes::tiles::TileStage;
use crate::report::gpu_study_report::{self as report, Findings, Silence};
use crate::report::{files, kept_images};
use crate::scene::{Scene, View, library};
use crate::study::agreement::{self, AgreementRecord, AgreementSpec};
use crate::study::error::Variant;
use crate::study::journal::Journal;
use crate::study::stages::{self, StagesSpec};
use crate::study::table::TABLE_5_8;
use crate::study::timing::{self, TimeSpec};
use crate::study::{Globals, TimeRecord, bandwidth, steps};
use clap::Args;
use indicatif::ProgressBar;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The views that are timed: the scene and its view.
const VIEWS: [[&str; 2]; 4] = [["rooms", "corridor"], ["atrium", "hall"], ["museum", "exit-sign"], ["street", "car"]];

/// Roughness values at which the passes of `unified` are compared, so that each is among them.
const STAGES_ROUGHNESS: [f32; 3] = [0.0, 0.1, 0.6];

/// Side of the image that is copied, in texels of four bytes: larger than caches.
const COPIED: u32 = 4096;

/// Pixels of the images that are kept for other machines: odd, so that every level of a chain rounds.
const KEPT_SIZE: [u32; 2] = [97, 55];
/// Their roughness values: hits of mirrors, and gloss.
const KEPT_ROUGHNESS: [f32; 2] = [0.0, 0.1];
/// Where they lie in the study's folder.
const KEPT: &str = "same";

/// Options of `ssct gpu-study`.
#[derive(Debug, Args)]
pub struct GpuStudyOptions {
    /// Small images, few frames: to try it, or for a device that is a CPU.
    #[arg(long)]
    pub quick: bool,
    /// The folder of a study of another device, from any machine: this one's images are held against that one's, on the
    /// same G-buffers.
    #[arg(long, value_name = "DIR")]
    pub beside: Vec<PathBuf>,
    /// The folder; its page is index.html.
    #[arg(short, long, value_name = "DIR", default_value = "gpu-study")]
    pub output: PathBuf,
    /// Go on with what the folder has: nothing that was measured with the same settings is measured again.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// How much is done.
struct Plan {
    size: [u32; 2],
    samples: usize,
    table_sizes: Vec<[u32; 2]>,
    views: usize,
}

impl Plan {
    fn new(quick: bool) -> Self {
        if quick {
            let table_sizes = vec![TABLE_5_8[0].size];
            return Self { size: [320, 180], samples: MIN_SAMPLES, table_sizes, views: 2 };
        }
        let mut table_sizes: Vec<_> = TABLE_5_8.iter().map(|r| r.size).collect();
        table_sizes.dedup();
        Self { size: [1920, 1080], samples: 15, table_sizes, views: VIEWS.len() }
    }
}

/// A scene with one of its views.
type Place = (Scene, View);

fn places(count: usize) -> Result<Vec<Place>> {
    let place = |[scene, view]: &[&str; 2]| {
        let scene = library::scene(scene).ok_or_else(|| Error::Usage(format!("there is no scene {scene}")))?;
        let view = scene.view(view)?.clone();
        Ok((scene, view))
    };
    VIEWS[..count].iter().map(place).collect()
}

/// Measures, writes the folder and prints where the page is.
pub fn run(options: &GpuStudyOptions) -> anyhow::Result<()> {
    let (folder, plan) = (&options.output, Plan::new(options.quick));
    let gpu = resolve::gpu(&options.device)?;
    let mut run = Run::begin(Some(folder), options.resume)?;
    let places = places(plan.views)?;
    let table = (places[1].0.clone(), places[1].1.clone());
    let specs = time_specs(&gpu, &plan, &places);
    let table_spec = table_spec(&gpu, &plan, &table);
    let bar = progress::bar("gpu-study", 0);
    let frames = specs.iter().chain([&table_spec]).map(TimeSpec::frames).sum::<usize>();
    bar.inc_length(frames as u64);

    let outcome = specs
        .iter()
        .chain([&table_spec])
        .try_for_each(|spec| timing::measure(spec, &mut run.journal, &mut || progress::step(&bar)))
        .and_then(|()| findings(&gpu, options, &plan, &places, &mut run.journal, &bar));
    bar.finish_and_clear();
    let views: Vec<TimeRecord> = specs.iter().flat_map(|s| timing::records(s, &run.journal)).collect();
    let of_table = timing::records(&table_spec, &run.journal);
    // What there is, whatever ended the measurement; and what ended it counts for more.
    let all: Vec<TimeRecord> = of_table.iter().chain(&views).cloned().collect();
    let wrote = files::write(&folder.join("time.json"), files::json(&all).as_bytes())
        .and_then(|()| files::write(&folder.join("time-samples.csv"), files::samples_csv(&all).as_bytes()));
    let mut findings = run.ended(outcome)?;
    wrote?;
    let rates = of_table.iter().chain(&views).flat_map(|r| bandwidth::of_passes(r, &findings.copy)).collect();
    findings.rates = rates;
    report::write(folder, gpu.info(), &command(options), &of_table, &views, &findings)?;
    writeln!(std::io::stdout().lock(), "{}", folder.join("index.html").display())?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

fn command(options: &GpuStudyOptions) -> String {
    format!("ssct gpu-study{}", if options.quick { " --quick" } else { "" })
}

const GLOSSY: Globals = Globals { roughness: Some(0.1), reflectivity: 1.0, normal_deviation: Some(0.1) };

/// Every method, timed against itself, on each view; and what looks into captures, with captures.
fn time_specs<'a>(gpu: &'a Gpu, plan: &Plan, places: &'a [Place]) -> Vec<TimeSpec<'a>> {
    let plain = Setup::new(plan.size);
    let captured = plain.with(|p: &mut EffectParams| p.captures = CaptureCount::Four);
    let spec = |(scene, view): &'a Place, methods: Vec<&'static MethodInfo>, setup: &Setup| {
        let (sizes, globals, setup) = (vec![plan.size], vec![GLOSSY], setup.clone());
        TimeSpec {
            gpu,
            scene,
            view,
            methods,
            sizes,
            globals,
            setup,
            warmup: 2,
            samples: plan.samples,
            a_a: true,
            only: None,
        }
    };
    let of = |place| {
        let all = METHODS.iter().filter(|m| m.name != captures::INFO.name).collect();
        [spec(place, all, &plain), spec(place, vec![&unified::INFO, &captures::INFO], &captured)]
    };
    places.iter().flat_map(of).collect()
}

fn table_spec<'a>(gpu: &'a Gpu, plan: &Plan, (scene, view): &'a Place) -> TimeSpec<'a> {
    TimeSpec {
        gpu,
        scene,
        view,
        methods: METHODS.iter().filter(|m| TABLE_5_8[0].of(m.name).is_some()).collect(),
        sizes: plan.table_sizes.clone(),
        globals: [0.0, 0.1]
            .map(|r| Globals { roughness: Some(r), reflectivity: 1.0, normal_deviation: Some(r) })
            .to_vec(),
        setup: Setup::new(plan.size),
        warmup: 2,
        samples: plan.samples,
        a_a: true,
        only: None,
    }
}

/// All that is no table of times.
fn findings(
    gpu: &Gpu,
    options: &GpuStudyOptions,
    plan: &Plan,
    places: &[Place],
    journal: &mut Journal,
    bar: &ProgressBar,
) -> Result<Findings> {
    let (scene, view) = &places[0];
    let mut stages = Vec::new();
    for roughness in STAGES_ROUGHNESS {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let variants = stages_of_unified(&Setup::new(plan.size));
        let spec = StagesSpec { gpu, scene, view, globals, variants, samples: plan.samples };
        stages.extend(stages::measure(&spec, journal, &mut || progress::step(bar))?);
    }
    let spec = |roughness: f32, size, methods| AgreementSpec {
        scene,
        view,
        globals: Globals { roughness: Some(roughness), ..Globals::default() },
        methods,
        setup: Setup::new(size),
    };
    let mut steps = Vec::new();
    for (scene, view) in places {
        let globals = Globals { roughness: Some(0.0), ..Globals::default() };
        let spec = AgreementSpec { scene, view, globals, methods: Vec::new(), setup: Setup::new(plan.size) };
        steps.push(steps::count(gpu, [&scene.name, &view.name], &agreement::draw(gpu, &spec)?));
        progress::step(bar)?;
    }
    let screen: Vec<&'static MethodInfo> = METHODS.iter().filter(|m| m.is_screen_space()).collect();
    let kept_specs = KEPT_ROUGHNESS.map(|r| spec(r, KEPT_SIZE, screen.clone()));
    keep(gpu, &options.output.join(KEPT), &kept_specs)?;
    let mut same = Vec::new();
    for folder in &options.beside {
        same.extend(beside(gpu, &folder.join(KEPT), &kept_specs)?);
    }
    let mut drawn = Vec::new();
    for other in drivers::others(gpu, options.device.validation)? {
        for spec in &kept_specs {
            same.extend(drivers::compare(
                &other,
                gpu,
                &AgreementSpec { methods: METHODS.iter().collect(), ..spec.clone() },
            )?);
            progress::step(bar)?;
        }
        drawn.extend(drivers::compare_drawn([&other, gpu], options.device.validation, &kept_specs[0])?);
        progress::step(bar)?;
    }
    Ok(Findings {
        stages,
        copy: bandwidth::copy(gpu, COPIED, plan.samples)?,
        rates: Vec::new(),
        steps,
        same,
        drawn,
        validation: silence(gpu, &kept_specs)?,
    })
}

/// `unified` with every pass as a fragment shader, and as a compute shader.
fn stages_of_unified(setup: &Setup) -> Vec<Variant> {
    let of = |stage| {
        let setup = setup.with(|p: &mut UnifiedParams| (p.trace_stage, p.resolve_stage) = (stage, stage));
        Variant { method: &unified::INFO, setup }
    };
    [TileStage::Fragment, TileStage::Compute].map(of).to_vec()
}

/// Keeps what the methods make, for studies on other machines.
fn keep(gpu: &Gpu, folder: &Path, specs: &[AgreementSpec]) -> Result<()> {
    kept_images::write_device(folder, gpu.info())?;
    for spec in specs {
        let data = agreement::draw(gpu, spec)?;
        kept_images::write(folder, &stem(spec), &data, &agreement::images(gpu, spec, &data)?)?;
    }
    Ok(())
}

fn stem(spec: &AgreementSpec) -> String {
    spec.globals.roughness.unwrap_or_default().to_string()
}

/// What the device makes of G-buffers that another one kept, against what that one made of them.
fn beside(gpu: &Gpu, folder: &Path, specs: &[AgreementSpec]) -> Result<Vec<AgreementRecord>> {
    let base = kept_images::read_device(folder)?;
    let mut records = Vec::new();
    for spec in specs {
        let stem = stem(spec);
        let data = kept_images::read_gbuffer(folder, &stem)?;
        let kept = spec.methods.iter().map(|method| kept_images::read_image(folder, &stem, method));
        let kept: Vec<_> = kept.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
        let size = [data.width, data.height];
        if let Some(other) = kept.iter().find(|k| [k.reflection.width, k.reflection.height] != size) {
            let [w, h] = size;
            let what = format!("the image of {} has another size than its G-buffer of {w}x{h}", other.method.name);
            return Err(Error::malformed(folder, None, what));
        }
        let methods = kept.iter().map(|k| k.method).collect();
        let spec = AgreementSpec { methods, ..spec.clone() };
        let made = agreement::images(gpu, &spec, &data)?;
        records.extend(agreement::compare(gpu, &base, &spec, &data, [&kept, &made]));
    }
    Ok(records)
}

/// What the validation layers say of every method, where they are installed.
fn silence(gpu: &Gpu, specs: &[AgreementSpec]) -> Result<Silence> {
    let query =
        DeviceQuery { device: Some(drivers::index(gpu)?.to_string()), validation: true, ..DeviceQuery::default() };
    let watched = match Gpu::open(&query) {
        Err(Error::Usage(why)) => return Ok(Silence::Unknown(why)),
        opened => opened?,
    };
    for spec in specs {
        let spec = AgreementSpec { methods: METHODS.iter().collect(), ..spec.clone() };
        agreement::images(&watched, &spec, &agreement::draw(&watched, &spec)?)?;
    }
    Ok(Silence::Heard(watched.violations().into_iter().map(|m| (m.id, m.text)).collect()))
}
