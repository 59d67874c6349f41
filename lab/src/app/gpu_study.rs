//! `ssct gpu-study`: measures in minutes what a device does: times and their noise, work, rates, and whether its images equal those of
//! other devices.

use super::cli::DeviceOptions;
use super::printed;
use super::run::{Run, go_on};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::gpu_study_report::{self as report, CompiledPrograms, DeviceTimes, Findings, LayerMessages};
use crate::report::{files, kept_images};
use crate::stage::{Globals, Stage};
use crate::study::agreement::{self, AgreementRecord, AgreementSpec};
use crate::study::engine::{self, Bench};
use crate::study::error::{ErrorRecord, ErrorStudy, Variant};
use crate::study::readme::{self, JUDGED_SIZE, MeasuredRecords, ReadmeRecord, TIMED_SIZE, VIEWS};
use crate::study::table as table_5_8;
use crate::study::timing::{self, TimeSpec};
use crate::study::{bandwidth, other_devices, shaders, steps, sweep};
use clap::Args;
use indicatif::ProgressBar;
use ssct::gpu::Gpu;
use ssct::methods::setup::{BeyondScreen, CaptureCount, HistoryUse, Stage as ShaderStage, StageChoice, Tracer};
use ssct::methods::unified::{FirstTraced, UnifiedParams};
use ssct::methods::{EffectParams, METHODS, MethodInfo, Setup, captures, traced, unified};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{Scene, View, library};
use ssct_truth::metrics::bootstrap::MIN_SAMPLES;
use std::io::Write;
use std::path::PathBuf;

/// The scene and the view that the thesis's table 5.8 is measured on.
const TABLE_VIEW: [&str; 2] = ["atrium", "hall"];

/// Roughness values at which fragment and compute shaders of `unified` are compared; each of its passes runs at one of these values.
const STAGES_ROUGHNESS: [f32; 3] = [0.0, 0.1, 0.6];

/// Roughness values at which [`Plan::tracing_orders`] and [`Plan::tracers`] compare variants: a mirror, and a narrow lobe.
const COMPARED_ROUGHNESS: [f32; 2] = [0.0, 0.1];

/// Side of the copied image, in texels of four bytes; the image is larger than caches.
const COPIED: u32 = 4096;

/// Rays a pixel of the references for the README's errors. The variance of the reference is subtracted from each error.
const RAYS: u32 = 64;
/// Rays a pixel of the references of a quick study.
const QUICK_RAYS: u32 = 16;

/// Width and height in pixels of the images that are kept for other machines: odd, so that halving rounds.
const KEPT_SIZE: [u32; 2] = [97, 55];
/// Roughness values of the kept images: a mirror, whose hits can be compared, and a glossy surface.
const KEPT_ROUGHNESS: [f32; 2] = [0.0, 0.1];
/// The folder of the kept images, inside the folder of the study.
const KEPT: &str = "same";

/// Options of `ssct gpu-study`.
#[derive(Debug, Args)]
pub struct GpuStudyOptions {
    /// Small images and few frames, for a device that is a CPU
    #[arg(long)]
    pub quick: bool,
    /// Folder of a study of another device
    ///
    /// The other device may be of any machine. Both devices' images are compared, on the same G-buffers.
    #[arg(long, value_name = "DIR")]
    pub beside: Vec<PathBuf>,
    /// Folder to write, with index.html
    #[arg(short, long, value_name = "DIR", default_value = "gpu-study")]
    pub output: PathBuf,
    /// Go on with what the folder has
    ///
    /// Nothing that was measured with the same settings is measured again.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub device: DeviceOptions,
}

/// How much the study measures.
struct Plan {
    /// Width and height in pixels of the frames that are timed.
    size: [u32; 2],
    /// Number of frames that are timed for each measurement.
    samples: usize,
    /// The sizes of table 5.8 that are measured.
    table_sizes: Vec<[u32; 2]>,
    /// Number of views on which the study measures.
    views: usize,
}

impl Plan {
    /// Makes the plan of a full study or, if `quick`, of one that a CPU can measure in minutes.
    fn new(quick: bool) -> Self {
        let table_sizes = table_5_8::sizes();
        if quick {
            let table_sizes = table_sizes[..1].to_vec();
            return Self { size: [320, 180], samples: MIN_SAMPLES, table_sizes, views: 2 };
        }
        Self { size: [1920, 1080], samples: 15, table_sizes, views: VIEWS.len() }
    }

    /// Returns the measurement that times variants in turn on a view, and each variant also against itself.
    fn time<'a>(
        &self,
        gpu: &'a Gpu,
        (scene, view): &'a Place,
        variants: Vec<Variant>,
        sizes: Vec<[u32; 2]>,
        globals: Vec<Globals>,
    ) -> TimeSpec<'a> {
        TimeSpec { gpu, scene, view, variants, sizes, globals, warmup: 2, samples: self.samples, a_a: true }
    }

    /// Returns the measurement of every method in each shader stage that it supports, fragment shaders first. Methods
    /// that look into captures are also timed with four captures.
    fn methods<'a>(&self, gpu: &'a Gpu, place: &'a Place) -> TimeSpec<'a> {
        let setup = Setup::on_screen(self.size);
        let captured = Setup::new(self.size).with(|p: &mut EffectParams| p.captures = CaptureCount::Number(4));
        // The method `captures` shows nothing without captures, nor does a method that lacks what it needs of the scene.
        let shows = |m: &&MethodInfo| m.name != captures::INFO.name && m.unmet_needs(&place.0).is_empty();
        let methods: Vec<_> = METHODS.iter().filter(shows).collect();
        let mut variants = Variant::for_methods(&methods, &setup);
        variants.push(triangles_variant(&setup, FirstTraced::Auto));
        variants.extend(Variant::for_methods(&[&unified::INFO, &captures::INFO], &captured));
        let variants = variants.iter().flat_map(in_its_stages).collect();
        self.time(gpu, place, variants, vec![self.size], vec![table_5_8::factors(0.1, 1.0)])
    }

    /// The measurement of the thesis's table 5.8.
    fn table<'a>(&self, gpu: &'a Gpu, place: &'a Place) -> TimeSpec<'a> {
        let variants = Variant::for_methods(&table_5_8::methods(), &Setup::new(self.size));
        let globals = table_5_8::ROUGHNESS.map(|roughness| table_5_8::factors(roughness, 1.0)).to_vec();
        self.time(gpu, place, variants, self.table_sizes.clone(), globals)
    }

    /// Returns the measurement of `unified` with rays traced on the screen first, and with rays traced among the
    /// triangles first. Which order is cheaper depends on the number of triangles and on the device.
    fn tracing_orders<'a>(&self, gpu: &'a Gpu, place: &'a Place) -> TimeSpec<'a> {
        let variants =
            [FirstTraced::Screen, FirstTraced::Triangles].map(|first| triangles_variant(&Setup::new(self.size), first));
        self.time(gpu, place, variants.to_vec(), vec![self.size], COMPARED_ROUGHNESS.map(globals_of_roughness).to_vec())
    }

    /// Returns the measurement of `traced` by a walk through the tree, and by ray queries; `None` on a device without
    /// ray queries.
    fn tracers<'a>(&self, gpu: &'a Gpu, place: &'a Place) -> Option<TimeSpec<'a>> {
        let variant = |tracer| {
            let setup = Setup::new(self.size).with(|p: &mut EffectParams| p.tracer = tracer);
            Variant { method: &traced::INFO, setup }
        };
        let variants = [Tracer::Tree, Tracer::Query].map(variant).to_vec();
        let globals = COMPARED_ROUGHNESS.map(globals_of_roughness).to_vec();
        gpu.has_ray_queries().then(|| self.time(gpu, place, variants, vec![self.size], globals))
    }

    /// Returns the measurement of the variants of the README's tables on a view, at the roughness values that these
    /// tables have for the view's scene.
    fn readme<'a>(&self, gpu: &'a Gpu, place: &'a Place) -> Result<TimeSpec<'a>> {
        let variants = readme::variants(TIMED_SIZE, gpu.info().is_cpu())?;
        let globals = self.readme_roughness(place).iter().map(|r| globals_of_roughness(*r)).collect();
        Ok(self.time(gpu, place, variants, vec![TIMED_SIZE], globals))
    }

    /// The roughness values at which the README's variants are measured in a scene.
    fn readme_roughness(&self, (scene, _): &Place) -> &'static [f32] {
        let is_of_the_screen = readme::SCREEN_SCENES.contains(&scene.name.as_str());
        if is_of_the_screen && !self.is_quick() { &sweep::ROUGHNESS } else { &sweep::ROUGHNESS[..1] }
    }

    /// The study of the errors of the README's variants on a view.
    fn readme_errors(&self, gpu: &Gpu, [scene, view]: [&str; 2]) -> Result<ErrorStudy> {
        let place = place([scene, view])?;
        let globals = self.readme_roughness(&place).iter().map(|r| globals_of_roughness(*r)).collect();
        let variants = readme::variants(JUDGED_SIZE, gpu.info().is_cpu())?;
        let rays = if self.is_quick() { QUICK_RAYS } else { RAYS };
        let (scene, view) = place;
        Ok(ErrorStudy::new(vec![(scene, vec![view])], vec![JUDGED_SIZE], globals, variants, (1, rays)))
    }

    /// The number of views on which the README's numbers are measured, and every method is timed.
    fn timed_views(&self) -> usize {
        if self.is_quick() { 1 } else { self.views }
    }

    /// True if the plan is that of a quick study.
    fn is_quick(&self) -> bool {
        self.views < VIEWS.len()
    }

    /// Returns the measurement of `unified` with fragment shaders in every pass, and with compute shaders in every
    /// pass.
    fn stages<'a>(&self, gpu: &'a Gpu, place: &'a Place) -> TimeSpec<'a> {
        let setup = Setup::on_screen(self.size);
        let variants = [StageChoice::Fragment, StageChoice::Compute].map(|stage| in_stage(&setup, stage)).to_vec();
        self.time(gpu, place, variants, vec![self.size], STAGES_ROUGHNESS.map(globals_of_roughness).to_vec())
    }
}

/// Returns a variant in each shader stage in which its rays can be traced: in fragment and in compute shaders, or in
/// compute shaders alone, since only these follow rays in captures or among triangles.
fn in_its_stages(variant: &Variant) -> Vec<Variant> {
    let effect = variant.setup.effect();
    let has_scene = true;
    let needs_compute = effect.captures != CaptureCount::None || effect.is_among_triangles(variant.method, has_scene);
    let stages = [ShaderStage::Fragment, ShaderStage::Compute].into_iter().skip(usize::from(needs_compute));
    let with = |stage| variant.setup.with(|p: &mut EffectParams| p.stage = stage);
    stages.map(|stage| Variant { method: variant.method, setup: with(stage) }).collect()
}

/// `unified` with every pass in the given shader stage.
fn in_stage(setup: &Setup, stage: StageChoice) -> Variant {
    let setup = setup.with(|p: &mut UnifiedParams| (p.trace_stage, p.resolve_stage) = (stage, stage));
    Variant { method: &unified::INFO, setup }
}

/// Returns `unified` with rays that end among the scene's triangles, traced first as `first` says.
fn triangles_variant(setup: &Setup, first: FirstTraced) -> Variant {
    let setup = setup.with(|p: &mut EffectParams| p.beyond = BeyondScreen::Triangles);
    Variant { method: &unified::INFO, setup: setup.with(|p: &mut UnifiedParams| p.first = first) }
}

/// The global factors that give every material one roughness.
fn globals_of_roughness(roughness: f32) -> Globals {
    Globals { roughness: Some(roughness), ..Globals::default() }
}

/// A scene with one of its views.
type Place = (Scene, View);

/// Makes a built-in scene, and finds one of its views.
fn place([scene, view]: [&str; 2]) -> Result<Place> {
    let scene = library::scene(scene).ok_or_else(|| Error::usage(format!("there is no scene {scene}")))?;
    let view = scene.view(view)?.clone();
    Ok((scene, view))
}

/// Measures all parts of the study, writes its folder and prints where the page is.
pub fn run(options: &GpuStudyOptions) -> anyhow::Result<()> {
    let (path, plan) = (&options.output, Plan::new(options.quick));
    let folder = PathInFolder::folder(path);
    let gpu = resolve::gpu(&options.device)?;
    let mut run = Run::begin(Some(path), options.resume)?;
    let places = VIEWS[..plan.views].iter().map(|view| place(*view)).collect::<Result<Vec<_>>>()?;
    let table_place = place(TABLE_VIEW)?;
    let table = [plan.table(&gpu, &table_place)];
    let timed_places = &places[..plan.timed_views()];
    let methods: Vec<_> = timed_places.iter().map(|place| plan.methods(&gpu, place)).collect();
    let orders: Vec<_> = places.iter().map(|place| plan.tracing_orders(&gpu, place)).collect();
    let tracers: Vec<_> = places.iter().filter_map(|place| plan.tracers(&gpu, place)).collect();
    let stages = [plan.stages(&gpu, &places[0])];
    let readme_specs = timed_places.iter().map(|place| plan.readme(&gpu, place)).collect::<Result<Vec<_>>>()?;
    let other_specs: [(&str, &[TimeSpec]); 5] = [
        ("table 5.8", &table),
        ("every method in either stage", &methods),
        ("the screen or the triangles first", &orders),
        ("tree and ray queries", &tracers),
        ("passes in either stage", &stages),
    ];
    let all_specs = || readme_specs.iter().chain(other_specs.iter().flat_map(|(_, specs)| *specs));
    let bar = progress::bar("gpu-study", all_specs().map(TimeSpec::frames).sum());
    // The README's numbers are measured before the others, and the findings other than times after them.
    let (part_count, mut part) = (other_specs.len() + 2, 0);
    let mut begin_part = |what: &str| {
        part += 1;
        progress::part(&bar, &format!("gpu-study, part {part} of {part_count}: {what}"));
    };

    let mut measure = || -> Result<(Vec<ReadmeRecord>, Findings)> {
        begin_part("the README's numbers");
        measure_times(&readme_specs, &mut run, &bar)?;
        let errors = measure_readme_errors(&gpu, &plan, &mut run, &bar)?;
        let times: Vec<_> = readme_specs.iter().flat_map(|spec| timing::records(spec, &run.journal)).collect();
        let readme = readme::compare(&MeasuredRecords { times: &times, errors: &errors })?;
        report::write_readme(&folder, gpu.info(), &command(options), &readme)?;
        let page = path.join(report::README).display().to_string();
        writeln!(printed::out(), "{page}").map_err(|e| Error::io("name on standard output", &page, e))?;
        for (what, specs) in other_specs {
            begin_part(what);
            measure_times(specs, &mut run, &bar)?;
        }
        begin_part("steps, images, programs and the validation layers");
        Ok((readme, measure_findings(&gpu, options, &plan, &places, &bar)?))
    };
    let outcome = measure();
    bar.finish_and_clear();
    let records = |specs: &[TimeSpec]| specs.iter().flat_map(|spec| timing::records(spec, &run.journal)).collect();
    let [table, methods, orders, tracers, stages] = other_specs.map(|(_, specs)| records(specs));
    let times = DeviceTimes { table, methods, orders, tracers, readme: records(&readme_specs), stages };
    // Measured times are written even after an error; that error is reported before an error of writing.
    let all_times = times.all();
    let written = folder
        .join("time.json")
        .write(files::json(&all_times).as_bytes())
        .and_then(|()| folder.join(timing::SAMPLES).write(files::csv(&timing::sample_cells(&all_times)).as_bytes()));
    let (readme, findings) = run.outcome_with_journal(outcome)?;
    written?;
    report::write(&folder, gpu.info(), &command(options), (&times, &readme), &findings)?;
    writeln!(printed::out(), "{}", path.join(report::PAGE).display())?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

/// Measures the times of `specs` that the journal of the run lacks.
fn measure_times(specs: &[TimeSpec], run: &mut Run, bar: &ProgressBar) -> Result<()> {
    specs.iter().try_for_each(|spec| timing::measure(spec, &mut run.journal, &mut || progress::step(bar)))
}

/// The command as the page shows it.
fn command(options: &GpuStudyOptions) -> String {
    let quick = if options.quick { " --quick" } else { "" };
    let beside: String = options.beside.iter().map(|folder| format!(" --beside {}", folder.display())).collect();
    format!("ssct gpu-study{quick}{beside}")
}

/// Measures the errors that the page compares with those of the README.
fn measure_readme_errors(gpu: &Gpu, plan: &Plan, run: &mut Run, bar: &ProgressBar) -> Result<Vec<ErrorRecord>> {
    let mut records = Vec::new();
    for view in &VIEWS[..plan.timed_views()] {
        let mut study = plan.readme_errors(gpu, *view)?;
        let list = engine::list(&study, gpu, String::new(), None);
        let journal = &mut run.journal;
        let (advance, keep) = (&mut |steps| bar.inc(steps as u64), &mut |_: &_| Ok(()));
        engine::measure(&mut study, &list, &mut Bench { gpu, journal, go_on, advance, keep })?;
        records.extend(engine::rows::<ErrorRecord>(&list, &run.journal));
    }
    Ok(records)
}

/// Measures what the study reports besides times: the rays' steps, the agreement of images with other devices, the rate
/// of copies, and the compiled programs. Keeps the device's images for studies on other machines.
fn measure_findings(
    gpu: &Gpu,
    options: &GpuStudyOptions,
    plan: &Plan,
    places: &[Place],
    bar: &ProgressBar,
) -> Result<Findings> {
    let mut steps = Vec::new();
    for (scene, view) in places {
        let (globals, methods, setup) = (globals_of_roughness(0.0), Vec::new(), Setup::on_screen(plan.size));
        let spec = AgreementSpec { scene, view, globals, methods, setup };
        steps.extend(steps::count(gpu, scene, view, &spec.globals, &agreement::draw(gpu, &spec)?)?);
        progress::step(bar)?;
    }
    let (scene, view) = &places[0];
    let kept_specs = KEPT_ROUGHNESS.map(|roughness| AgreementSpec {
        scene,
        view,
        globals: globals_of_roughness(roughness),
        methods: METHODS.iter().filter(|m| m.unmet_needs(scene).is_empty()).collect(),
        setup: Setup::on_screen(KEPT_SIZE),
    });
    keep_images(gpu, &PathInFolder::folder(&options.output).join(KEPT), &kept_specs)?;
    let (mut agreement, mut drawn) = (Vec::new(), Vec::new());
    for folder in &options.beside {
        agreement.extend(compare_with_kept(gpu, &PathInFolder::folder(folder).join(KEPT), &kept_specs)?);
    }
    for other in other_devices::others(gpu, options.device.validation)? {
        for spec in &kept_specs {
            agreement.extend(other_devices::compare(&other, [gpu], spec)?);
            progress::step(bar)?;
        }
        drawn.extend(other_devices::compare_drawn([&other, gpu], options.device.validation, &kept_specs[0])?);
        progress::step(bar)?;
    }
    let copy = bandwidth::time_copy(gpu, COPIED, plan.samples)?;
    let programs = compiled_programs(gpu, plan, &places[0])?;
    Ok(Findings { copy, steps, agreement, drawn, validation: layer_messages(gpu, &kept_specs)?, programs })
}

/// Compiles the programs of every method, in the published stages and in compute shaders. The programs of `unified` are
/// also compiled in both stages and with a history. Returns the compiler's statistics, or the reason why the device
/// reports none.
fn compiled_programs(gpu: &Gpu, plan: &Plan, (scene, view): &Place) -> Result<CompiledPrograms> {
    let compiler = match other_devices::compiler(gpu) {
        Err(Error::Ssct(ssct::Error::NoDevice(why))) => return Ok(CompiledPrograms::Unknown(why)),
        opened => opened?,
    };
    let setup = Setup::new(plan.size);
    let history =
        Variant { method: &unified::INFO, setup: setup.with(|p: &mut EffectParams| p.history = HistoryUse::On) };
    let in_compute = setup.with(|p: &mut EffectParams| p.stage = ShaderStage::Compute);
    let methods: Vec<_> = METHODS.iter().collect();
    let in_either_stage = [&setup, &in_compute].into_iter().flat_map(|setup| Variant::for_methods(&methods, setup));
    let staged = [StageChoice::Fragment, StageChoice::Compute].map(|stage| in_stage(&setup, stage));
    let mut stage = Stage::new(&compiler, scene)?;
    let mut records = Vec::new();
    for variant in in_either_stage.chain(staged).chain([history]) {
        for roughness in STAGES_ROUGHNESS {
            records.extend(shaders::compiled(
                &mut stage,
                (scene, view),
                &variant,
                plan.size,
                &globals_of_roughness(roughness),
            )?);
        }
    }
    Ok(CompiledPrograms::Said(records))
}

/// Keeps the images of the screen-space methods, for studies on other machines.
fn keep_images(gpu: &Gpu, folder: &PathInFolder, specs: &[AgreementSpec]) -> Result<()> {
    kept_images::write_device(folder, gpu.info())?;
    for spec in specs.iter().map(screen_space_part) {
        let data = agreement::draw(gpu, &spec)?;
        kept_images::write(folder, &stem(&spec), &data, &agreement::images(gpu, &spec, &data)?)?;
    }
    Ok(())
}

/// Returns the part of a comparison that a G-buffer is enough for: the screen-space methods.
fn screen_space_part<'a>(spec: &AgreementSpec<'a>) -> AgreementSpec<'a> {
    let methods: Vec<&'static MethodInfo> = spec.methods.iter().copied().filter(|m| m.is_screen_space()).collect();
    AgreementSpec { methods, ..spec.clone() }
}

/// The part of the names of kept files that tells comparisons apart: the roughness, such as `0.1`.
fn stem(spec: &AgreementSpec) -> String {
    spec.globals.roughness.unwrap_or_default().to_string()
}

/// Compares this device's images with images of the same G-buffers that another device kept.
fn compare_with_kept(gpu: &Gpu, folder: &PathInFolder, specs: &[AgreementSpec]) -> Result<Vec<AgreementRecord>> {
    let base = kept_images::read_device(folder)?;
    let mut records = Vec::new();
    for spec in specs.iter().map(screen_space_part) {
        let data = kept_images::read_gbuffer(folder, &stem(&spec))?;
        let kept = kept_images::read(folder, &stem(&spec), &data, &spec.methods)?;
        let spec = AgreementSpec { methods: kept.iter().map(|k| k.method).collect(), ..spec };
        let own = agreement::images(gpu, &spec, &data)?;
        records.extend(agreement::compare(gpu, &base, &spec, &data, [&kept, &own]));
    }
    Ok(records)
}

/// Runs every method under the validation layers, on the G-buffer of each comparison. Returns the layers' messages, or
/// the reason why they cannot watch.
fn layer_messages(gpu: &Gpu, specs: &[AgreementSpec]) -> Result<LayerMessages> {
    let watched = match other_devices::validated(gpu) {
        Err(Error::Ssct(ssct::Error::Usage(why))) => return Ok(LayerMessages::Unknown(why)),
        opened => opened?,
    };
    for spec in specs {
        // The layers judge what a method records and not what it shows, so that every method is run.
        let spec = AgreementSpec { methods: METHODS.iter().collect(), ..spec.clone() };
        agreement::images(&watched, &spec, &agreement::draw(&watched, &spec)?)?;
    }
    Ok(LayerMessages::Said(watched.violations().into_iter().map(|m| (m.id, m.text)).collect()))
}
