//! `ssct study`: makes pictures, times and errors in the order in which a reader wants them. The page that shows them
//! is written after each part.

use super::cli::StudyOptions;
use super::error::{QUICK_ROUGHNESS, QUICK_SIZE, QUICK_VIEWS};
use super::printed;
use super::run::{Run, go_on};
use super::study_pictures::{self, ERROR_FOLDER, GLOSSY, ShownView, TRUTH_FOLDER};
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::html::{Errors, Gallery, Page, Picture, PictureFolder, Times};
use crate::report::results::{Results, write_extra_file};
use crate::report::{files, plot, tables};
use crate::stage::{Globals, Stage};
use crate::study::agreement::{AgreementRecord, AgreementSpec};
use crate::study::cell_list::CellList;
use crate::study::engine::{self, Bench, LastMade};
use crate::study::error::{ErrorRecord, ErrorStudy, Variant};
use crate::study::exhibit::ExtraFile;
use crate::study::journal::Journal;
use crate::study::table::{self, ComparedRow, compare};
use crate::study::timing::{self, TimeSpec};
use crate::study::{TimeRecord, other_devices};
use indicatif::ProgressBar;
use ssct::gpu::Gpu;
use ssct::methods::{self, METHODS, MethodInfo, Setup};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{Scene, View, library};
use std::borrow::Cow;
use std::cell::RefCell;
use std::io::Write;
use std::path::PathBuf;

/// Size of pictures and of the views' times: the thesis's own benchmark size.
const SIZE: [u32; 2] = [960, 540];
/// The number of scenes of the thesis, the rooms and the atrium. A quick study has only these, and by default only their views are timed.
const THESIS_SCENES: usize = 2;

/// How much the study makes.
struct Plan {
    /// Number of scenes with pictures.
    scenes: usize,
    /// Number of scenes that are timed as well, counted from the first.
    timed_scenes: usize,
    /// Number of views of each scene, counted from its first.
    views: usize,
    /// Width and height in pixels of the pictures, and of the frames that are timed on views.
    size: [u32; 2],
    /// Number of frames that are timed for each measurement.
    samples: usize,
    /// The sizes at which table 5.8 is measured.
    table_sizes: Vec<[u32; 2]>,
    /// Size of the images whose errors are measured.
    error_size: [u32; 2],
    /// Rays a pixel of the references.
    rays: u32,
    /// The methods of the table, and any from folders.
    methods: Vec<&'static MethodInfo>,
    /// The command as the page shows it.
    command: String,
}

impl Plan {
    /// Makes the plan of the study that the options ask for: quick, full, or without either flag in between.
    fn new(options: &StudyOptions) -> Result<Self> {
        let mut methods: Vec<_> = METHODS.iter().collect();
        for name in &options.method {
            let method = methods::find(name)?;
            if !methods.iter().any(|m| m.name == method.name) {
                methods.push(method);
            }
        }
        let method_flags: String = options.method.iter().map(|name| format!(" --method {name}")).collect();
        if options.quick {
            let table_sizes = vec![[640, 480]];
            return Ok(Self {
                scenes: THESIS_SCENES,
                timed_scenes: THESIS_SCENES,
                views: 1,
                size: [480, 270],
                samples: 3,
                table_sizes,
                error_size: QUICK_SIZE.map(|side| side / 2),
                rays: 16,
                methods,
                command: format!("ssct study --quick{method_flags}"),
            });
        }
        let samples = options.samples;
        if samples == 0 {
            return Err(Error::usage("--samples 0: at least one is needed".into()));
        }
        let table_sizes = table::sizes();
        let (timed_scenes, views, full_flag) =
            if options.full { (usize::MAX, usize::MAX, " --full") } else { (THESIS_SCENES, 1, "") };
        let command = format!("ssct study{full_flag} --samples {samples}{method_flags}");
        let (scenes, size, error_size, rays) = (usize::MAX, SIZE, QUICK_SIZE, 64);
        Ok(Self { scenes, timed_scenes, views, size, samples, table_sizes, error_size, rays, methods, command })
    }

    /// The parts of the study, in the order in which a reader wants them. The pictures of one view, the thesis's table,
    /// the errors and the thesis's figures come before the other pictures, the times and the images of other devices.
    /// Views of `scenes` are shown and timed, and those of `untimed` only shown.
    fn parts<'a>(&self, gpu: &'a Gpu, scenes: &'a [Scene], untimed: &[Scene]) -> Result<Vec<Part<'a>>> {
        let pictures_of = |scene: &Scene, view: &View| Part::Pictures {
            scene: scene.name.clone(),
            view: view.clone(),
            methods: self.methods_in(scene),
        };
        let all_scenes = scenes.iter().chain(untimed);
        let mut pictures =
            all_scenes.flat_map(|scene| self.shown_views(scene).map(move |view| pictures_of(scene, view)));
        let mut parts: Vec<Part> = pictures.next().into_iter().collect();
        parts.extend(self.table_5_8(gpu, scenes)?.map(Part::Table));
        parts.extend(self.errors(gpu, scenes)?);
        parts.extend(scenes.first().map(Part::Figures));
        parts.extend(pictures);
        let timed = scenes.iter().flat_map(|scene| self.shown_views(scene).map(move |view| (scene, view)));
        parts.extend(timed.map(|(scene, view)| {
            Part::Times(self.time(gpu, scene, view, &self.methods_in(scene), vec![self.size], vec![GLOSSY]))
        }));
        parts.extend(scenes.first().map(Part::OtherDevices));
        Ok(parts)
    }

    /// The methods that find what they need in a scene.
    fn methods_in(&self, scene: &Scene) -> Vec<&'static MethodInfo> {
        self.methods.iter().copied().filter(|method| method.unmet_needs(scene).is_empty()).collect()
    }

    /// The views of a scene that are shown.
    fn shown_views<'a>(&self, scene: &'a Scene) -> impl Iterator<Item = &'a View> + use<'a> {
        scene.views.iter().take(self.views)
    }

    /// Returns the measurement of table 5.8 on the atrium's view `hall`; `None` without the atrium.
    fn table_5_8<'a>(&self, gpu: &'a Gpu, scenes: &'a [Scene]) -> Result<Option<TimeSpec<'a>>> {
        let Some(atrium) = scenes.iter().find(|s| s.name == "atrium") else { return Ok(None) };
        let globals = table::ROUGHNESS.map(|roughness| table::factors(roughness, 1.0)).to_vec();
        let sizes = self.table_sizes.clone();
        Ok(Some(self.time(gpu, atrium, atrium.view("hall")?, &table::methods(), sizes, globals)))
    }

    /// Returns the quick error study of the rooms: two views, a mirror and a glossy surface, methods as published.
    /// `None` without the rooms.
    fn errors<'a>(&self, gpu: &Gpu, scenes: &[Scene]) -> Result<Option<Part<'a>>> {
        let Some(rooms) = scenes.iter().find(|s| s.name == "rooms") else { return Ok(None) };
        let globals = QUICK_ROUGHNESS.map(|r| Globals { roughness: Some(r), ..Globals::default() }).to_vec();
        let views = rooms.views.iter().take(QUICK_VIEWS).cloned().collect();
        let (scenes, variants) =
            (vec![(rooms.clone(), views)], Variant::for_methods(&self.methods, &Setup::new(self.error_size)));
        let study = ErrorStudy::new(scenes, vec![self.error_size], globals, variants, (self.samples, self.rays));
        let list = engine::list(&study, gpu, self.command.clone(), None);
        Ok(Some(Part::Errors(Box::new((RefCell::new(Some(study)), list)))))
    }

    /// Returns the measurement that times methods on a view.
    fn time<'a>(
        &self,
        gpu: &'a Gpu,
        scene: &'a Scene,
        view: &'a View,
        methods: &[&'static MethodInfo],
        sizes: Vec<[u32; 2]>,
        globals: Vec<Globals>,
    ) -> TimeSpec<'a> {
        let variants = Variant::for_methods(methods, &Setup::new(self.size));
        // The frame in which work is counted serves as the warm-up.
        TimeSpec { gpu, scene, view, variants, sizes, globals, warmup: 0, samples: self.samples, a_a: false }
    }
}

/// A part of the study, after which the page is written again.
enum Part<'a> {
    /// Pictures of a view of a scene by the methods that find what they need there.
    Pictures { scene: String, view: View, methods: Vec<&'static MethodInfo> },
    /// Table 5.8.
    Table(TimeSpec<'a>),
    /// Errors of views: the study, which is taken out when it is made, and its list of cells.
    Errors(Box<(RefCell<Option<ErrorStudy>>, CellList)>),
    /// Figures of the thesis, on a scene.
    Figures(&'a Scene),
    /// Times of a view.
    Times(TimeSpec<'a>),
    /// Images of other devices, on a scene.
    OtherDevices(&'a Scene),
}

impl Part<'_> {
    /// The part's name on the page while the part is not made yet.
    fn title(&self) -> String {
        match self {
            Self::Pictures { scene, view, .. } => format!("pictures of {scene}, {}", view.name),
            Self::Table(_) => "table 5.8".into(),
            Self::Errors(_) => "run time against error".into(),
            Self::Figures(_) => "figures of the thesis".into(),
            Self::Times(spec) => format!("times of {}, {}", spec.scene.name, spec.view.name),
            Self::OtherDevices(_) => "images of other devices".into(),
        }
    }

    /// Number of steps of the progress bar for the part.
    fn steps(&self) -> usize {
        match self {
            // Each method, unified on the screen alone, and the truth.
            Self::Pictures { methods, .. } => methods.len() + 2,
            Self::Table(spec) | Self::Times(spec) => spec.frames(),
            Self::Errors(study_and_list) => study_and_list.1.count_own(),
            Self::Figures(_) | Self::OtherDevices(_) => 1,
        }
    }
}

/// Results so far that the journal does not hold.
#[derive(Default)]
struct StudyResults {
    /// The pictures of views.
    views: Vec<Gallery>,
    /// The figures of the thesis.
    figures: Vec<Picture>,
    /// The agreement of images with those of other devices.
    agreement: Vec<AgreementRecord>,
    /// How many parts are done.
    parts: usize,
}

/// A study that is being made.
struct Study<'a> {
    gpu: &'a Gpu,
    plan: &'a Plan,
    /// The scenes that are timed.
    scenes: &'a [Scene],
    parts: &'a [Part<'a>],
    pictures: PictureFolder,
    validation: bool,
    bar: ProgressBar,
}

/// Runs the study and writes its folder.
pub fn run(options: &StudyOptions) -> anyhow::Result<()> {
    let folder = &options.output;
    let plan = Plan::new(options)?;
    let gpu = resolve::gpu(&options.device)?;
    let mut run = Run::begin(Some(folder), options.resume)?;
    let mut scenes: Vec<Scene> = library::names().iter().take(plan.scenes).filter_map(|n| library::scene(n)).collect();
    // Called only for its messages, which say which methods are left out in which scene.
    resolve::leave_out_lacking(plan.methods.clone(), |method| method, &scenes.iter().collect::<Vec<_>>())?;
    // Scenes that are shown and not timed are made again one by one, so that never two of them are in memory.
    let untimed = scenes.split_off(plan.timed_scenes.min(scenes.len()));
    let parts = plan.parts(&gpu, &scenes, &untimed)?;
    drop(untimed);
    let study = Study {
        gpu: &gpu,
        plan: &plan,
        scenes: &scenes,
        parts: &parts,
        pictures: PictureFolder::new(folder),
        validation: options.device.validation,
        bar: progress::bar("study", parts.iter().map(Part::steps).sum()),
    };
    let mut results = StudyResults::default();
    let outcome = study.measure(&mut run.journal, &mut results);
    study.bar.finish_and_clear();
    // Results are written even if an error ended the measurement. That error is reported before an error of writing.
    let written = study.write(&run.journal, &results);
    run.outcome_with_journal(outcome)?;
    let written = written?;
    run.finish()?;
    gpu.check_validation()?;
    let mut out = printed::out();
    writeln!(out, "Table 5.8 of the thesis (GeForce GTX 670) and here ({}):", gpu.info().name)?;
    write!(out, "{}", tables::aligned(&table::cells(&written.table)))?;
    writeln!(out, "{} ({:.1} MB)", study.index().display(), written.page_bytes as f64 / 1e6)?;
    Ok(())
}

/// Data of the page that was written last.
struct WrittenPage {
    table: Vec<ComparedRow>,
    page_bytes: usize,
}

impl<'a> Study<'a> {
    /// The path of the page.
    fn index(&self) -> PathBuf {
        self.pictures.place().path().join("index.html")
    }

    /// Makes every part, and writes the page after each part except the last, after which the caller writes it.
    fn measure(&self, journal: &mut Journal, results: &mut StudyResults) -> anyhow::Result<()> {
        let mut last = LastMade::default();
        for (n, part) in self.parts.iter().enumerate() {
            self.make_part(part, journal, results, &mut last)?;
            results.parts = n + 1;
            if results.parts < self.parts.len() {
                self.write(journal, results)?;
            }
            if n == 0 {
                self.bar.println(format!("{}: the first pictures; more follow", self.index().display()));
            }
        }
        Ok(())
    }

    /// Makes a part. `last` keeps the last scene and its stage, since the views of a scene follow one another. Parts
    /// that make scenes or stages of their own forget it first, to free its memory, and the pipelines that it used.
    fn make_part(
        &self,
        part: &Part<'a>,
        journal: &mut Journal,
        results: &mut StudyResults,
        last: &mut LastMade<String, (Cow<'a, Scene>, Stage)>,
    ) -> anyhow::Result<()> {
        let (folder, step) = (self.pictures.place(), &mut || progress::step(&self.bar));
        if !matches!(part, Part::Pictures { .. } | Part::Figures(_)) {
            last.forget();
            self.gpu.trim();
        }
        match part {
            Part::Pictures { scene, view, methods } => {
                let (scene, stage) = last.get_or_make(scene.clone(), || self.scene_on_stage(scene))?;
                let shown = ShownView { scene, view, size: self.plan.size, methods };
                results.views.push(study_pictures::view_gallery(stage, &shown, folder, step)?);
            }
            Part::Table(spec) | Part::Times(spec) => timing::measure(spec, journal, step)?,
            Part::Errors(study_and_list) => {
                let (study, list) = &**study_and_list;
                // The study is dropped with what it keeps for its next cell.
                let Some(mut study) = study.take() else { return Ok(()) };
                let error_folder = folder.join(ERROR_FOLDER);
                let keep = &mut |file: &ExtraFile| Ok(write_extra_file(&error_folder, file)?);
                let advance = &mut |steps: usize| self.bar.inc(steps as u64);
                let mut bench = Bench { gpu: self.gpu, journal, go_on, advance, keep };
                engine::measure(&mut study, list, &mut bench)?;
            }
            Part::Figures(scene) => {
                let (_, stage) = last.get_or_make(scene.name.clone(), || self.scene_on_stage(&scene.name))?;
                results.figures = study_pictures::thesis_figures(stage, scene, folder, self.plan.size)?;
                step()?;
            }
            Part::OtherDevices(scene) => {
                results.agreement = compare_other_devices(self.gpu, scene, self.plan, self.validation)?;
                step()?;
            }
        }
        Ok(())
    }

    /// Returns the scene with a name, and a new stage with it. A timed scene is in memory, and any other scene is made.
    fn scene_on_stage(&self, name: &str) -> Result<(Cow<'a, Scene>, Stage)> {
        let scene = match self.scenes.iter().find(|scene| scene.name == name) {
            Some(timed) => Cow::Borrowed(timed),
            None => Cow::Owned(library::scene_or_file(name)?),
        };
        let stage = Stage::new(self.gpu, &scene)?;
        Ok((scene, stage))
    }

    /// Writes the records and the page with all results so far.
    fn write(&self, journal: &Journal, results: &StudyResults) -> anyhow::Result<WrittenPage> {
        let folder = self.pictures.place();
        let (mut table_times, mut view_times) = (Vec::new(), Vec::new());
        let mut errors: Vec<ErrorRecord> = Vec::new();
        for part in self.parts {
            match part {
                Part::Table(spec) => table_times.extend(timing::records(spec, journal)),
                Part::Times(spec) => view_times.extend(timing::records(spec, journal)),
                Part::Errors(study_and_list) => {
                    let (_, list) = &**study_and_list;
                    errors.extend(engine::rows(list, journal));
                    Results { rows: &errors, list, missing: &[] }.write(&folder.join(ERROR_FOLDER))?;
                }
                Part::Pictures { .. } | Part::Figures(_) | Part::OtherDevices(_) => {}
            }
        }
        let all_times: Vec<TimeRecord> = view_times.iter().chain(&table_times).cloned().collect();
        folder.join("time.json").write(files::json(&all_times).as_bytes())?;
        folder.join(timing::SAMPLES).write(files::csv(&timing::sample_cells(&all_times)).as_bytes())?;
        let table = compare(&table_times);
        let page = Page {
            device: self.gpu.info(),
            command: self.plan.command.clone(),
            to_come: self.parts[results.parts..].iter().map(Part::title).collect(),
            times: Times {
                settings: time_settings(self.plan),
                table: &table,
                table_records: &table_times,
                view_records: &view_times,
                plot: plot::draw(&timing::chart(&view_times).drawing).map_err(anyhow::Error::msg)?,
            },
            errors: Errors {
                settings: error_settings(self.plan),
                records: &errors,
                plots: plot::draw_charts(&errors).map_err(anyhow::Error::msg)?,
                pictures: study_pictures::error_galleries(&errors, &self.plan.methods),
            },
            views: &results.views,
            figures: &results.figures,
            agreement: &results.agreement,
            records: listed_files(folder),
        };
        let html = page.render(&self.pictures)?;
        folder.join("index.html").write(html.as_bytes())?;
        Ok(WrittenPage { table, page_bytes: html.len() })
    }
}

/// Compares the images that all other devices make of one G-buffer with the images of this device, at each roughness of
/// a quick study. The G-buffer shows the view `corridor` of the scene, which must have it.
fn compare_other_devices(gpu: &Gpu, scene: &Scene, plan: &Plan, validation: bool) -> Result<Vec<AgreementRecord>> {
    let mut records = Vec::new();
    let others = other_devices::others(gpu, validation)?;
    for roughness in QUICK_ROUGHNESS.into_iter().filter(|_| !others.is_empty()) {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let (methods, setup) = (plan.methods_in(scene), Setup::new(QUICK_SIZE));
        let spec = AgreementSpec { scene, view: scene.view("corridor")?, globals, methods, setup };
        records.extend(other_devices::compare(gpu, &others, &spec)?);
    }
    others.iter().try_for_each(Gpu::check_validation)?;
    Ok(records)
}

/// Returns the files and folders beside the page, each with its description. Those that do not exist are left out.
fn listed_files(folder: &PathInFolder) -> Vec<(String, String)> {
    let entry = |file: &str, what: &str| (file.to_owned(), what.to_owned());
    let mut entries = vec![
        entry("time.json", "every time, one record a method, view, size and roughness"),
        entry("time-samples.csv", "every sample of every pass"),
        entry("journal.jsonl", "every sample and cell as it was measured, for --resume"),
        entry("images/", "the pictures, lossless"),
        (format!("{TRUTH_FOLDER}/"), "the truth's samples, with which the next run goes on".into()),
        (format!("{ERROR_FOLDER}/error.json"), "every error, one record a method, cell and reference".into()),
        (format!("{ERROR_FOLDER}/error.txt"), "the same as tables".into()),
        (format!("{ERROR_FOLDER}/images/"), "reflections and FLIP maps as PNG, error maps as EXR".into()),
    ];
    entries.retain(|(file, _)| folder.path().join(file).exists());
    entries
}

/// The text on the page that says which times were measured, and how.
fn time_settings(plan: &Plan) -> String {
    let [width, height] = plan.size;
    let which = match (plan.timed_scenes, plan.views) {
        (usize::MAX, usize::MAX) => "every view of every scene",
        _ => "the first view of the rooms and of the atrium (ssct study --full times every view of every scene)",
    };
    format!(
        "Medians of {} frames of every method on {which}, at {width} × {height}, roughness and normal deviation \
         0.1; only the stages after the scene passes.",
        plan.samples
    )
}

/// The text on the page that says which errors were measured, and how.
fn error_settings(plan: &Plan) -> String {
    let [width, height] = plan.error_size;
    format!(
        "Every method as published on two views of the rooms at {width} × {height}, a mirror (roughness 0) and a glossy \
         one (0.1); references of {} rays a pixel, medians of {} frames. Left out are methods of which the rooms lack what \
         they need, as billboard needs impostors. Errors are of the reflection colour before fade \
         and reflectivity. Black is where nothing is found. In a FLIP \
         map black is no difference, and the brighter the more. A point on the Pareto front (red, and * in the \
         tables) is beaten by none in both time and error.",
        plan.rays, plan.samples
    )
}
