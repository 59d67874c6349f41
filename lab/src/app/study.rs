//! `ssct study`: pictures, times and the page that shows them.

use super::cli::StudyOptions;
use super::error_cells::{Plan as ErrorPlan, QUICK_ROUGHNESS, QUICK_SIZE};
use super::run::Run;
use super::{progress, reference, resolve};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Pixels};
use crate::methods::setup::CaptureCount;
use crate::methods::{self, EffectParams, METHODS, MethodInfo, Setup, Wants, unified};
use crate::report::figures::{self, Figure};
use crate::report::html::{Errors, Gallery, Page, Picture, Strip, Times};
use crate::report::{error_report, files, images, plot, tables};
use crate::scene::{Scene, View, library};
use crate::study::agreement::{AgreementRecord, AgreementSpec};
use crate::study::error::{EXACT_HITS, ErrorRecord, SCREEN_REFERENCE, Variant, WORLD_REFERENCE};
use crate::study::journal::Journal;
use crate::study::table::{self, compare};
use crate::study::timing::{self, TimeSpec};
use crate::study::{Globals, Shot, Stage, TimeRecord, gbuffer, image, other_devices};
use indicatif::ProgressBar;
use std::io::Write;
use std::path::Path;

/// Size of pictures and of the views' times: the thesis's own benchmark size.
const SIZE: [u32; 2] = [960, 540];
/// Name of the pictures without reflections.
const LIT: &str = "direct light";
/// Name of the pictures by the world reference, and its rays a pixel.
const TRUTH: &str = "truth";
const TRUTH_RAYS: u32 = 16;
/// Where the truth's samples lie, for the next run.
const TRUTH_FOLDER: &str = "truth";
/// Name of the pictures of `unified` whose rays go on in captures.
const CAPTURED: &str = "unified with captures";
/// Where the error study lies.
const ERROR_FOLDER: &str = "error";
/// Roughness and normal deviation of the pictures: table 5.8's rougher rows.
const GLOSSY: Globals = table::factors(0.1, 1.0);

/// The rooms and the atrium: the scenes of a quick study, and those whose views are timed unless all are.
const THESIS_SCENES: usize = 2;

/// How much is done.
struct Plan {
    /// Scenes of which there are pictures.
    scenes: usize,
    /// Scenes that are timed as well: the first of them.
    timed_scenes: usize,
    /// Views of each scene: its first.
    views: usize,
    size: [u32; 2],
    samples: usize,
    table_sizes: Vec<[u32; 2]>,
    /// Rays a pixel of the references.
    rays: u32,
    /// The methods of the table, and any from folders.
    methods: Vec<&'static MethodInfo>,
    command: String,
}

impl Plan {
    fn new(options: &StudyOptions) -> Result<Self> {
        let mut methods: Vec<_> = METHODS.iter().collect();
        for name in &options.method {
            let method = methods::find(name)?;
            if !methods.iter().any(|m| m.name == method.name) {
                methods.push(method);
            }
        }
        let more: String = options.method.iter().map(|name| format!(" --method {name}")).collect();
        if options.quick {
            let table_sizes = vec![[640, 480]];
            return Ok(Self {
                scenes: THESIS_SCENES,
                timed_scenes: THESIS_SCENES,
                views: 1,
                size: [480, 270],
                samples: 3,
                table_sizes,
                rays: 16,
                methods,
                command: format!("ssct study --quick{more}"),
            });
        }
        let samples = options.samples;
        if samples == 0 {
            return Err(Error::Usage("--samples 0: at least one is needed".into()));
        }
        let table_sizes = table::sizes();
        let (timed_scenes, views, full) =
            if options.full { (usize::MAX, usize::MAX, " --full") } else { (THESIS_SCENES, 1, "") };
        let command = format!("ssct study{full} --samples {samples}{more}");
        let (scenes, size, rays) = (usize::MAX, SIZE, 64);
        Ok(Self { scenes, timed_scenes, views, size, samples, table_sizes, rays, methods, command })
    }

    /// The views of a scene that are shown.
    fn shown<'a>(&self, scene: &'a Scene) -> Vec<&'a View> {
        scene.views.iter().take(self.views).collect()
    }

    /// What is timed of each view.
    fn view_specs<'a>(&self, gpu: &'a Gpu, scenes: &'a [Scene]) -> Vec<TimeSpec<'a>> {
        let spec = |scene, view| {
            let (sizes, globals) = (vec![self.size], vec![GLOSSY]);
            self.time(gpu, scene, view, &self.methods, sizes, globals)
        };
        let timed = scenes.iter().take(self.timed_scenes);
        timed.flat_map(|s| self.shown(s).into_iter().map(move |v| spec(s, v))).collect()
    }

    /// Table 5.8 on the atrium's view `hall`.
    fn table_5_8<'a>(&self, gpu: &'a Gpu, scenes: &'a [Scene]) -> Result<Option<TimeSpec<'a>>> {
        let Some(atrium) = scenes.iter().find(|s| s.name == "atrium") else { return Ok(None) };
        let globals = table::ROUGHNESS.map(|roughness| table::factors(roughness, 1.0)).to_vec();
        let sizes = self.table_sizes.clone();
        Ok(Some(self.time(gpu, atrium, atrium.view("hall")?, &table::methods(), sizes, globals)))
    }

    /// The quick error study of the rooms.
    fn errors(&self, scenes: &[Scene]) -> Option<ErrorPlan> {
        let rooms = scenes.iter().find(|s| s.name == "rooms")?;
        Some(ErrorPlan::quick(rooms.clone(), &self.methods, self.samples, self.rays))
    }

    /// What is timed of a view.
    fn time<'a>(
        &self,
        gpu: &'a Gpu,
        scene: &'a Scene,
        view: &'a View,
        methods: &[&'static MethodInfo],
        sizes: Vec<[u32; 2]>,
        globals: Vec<Globals>,
    ) -> TimeSpec<'a> {
        let variants = Variant::of(methods, &Setup::new(self.size));
        let (samples, a_a, only) = (self.samples, false, None);
        TimeSpec { gpu, scene, view, variants, sizes, globals, warmup: 1, samples, a_a, only }
    }
}

/// Runs the study and writes its folder.
pub fn run(options: &StudyOptions) -> anyhow::Result<()> {
    let folder = &options.output;
    let plan = Plan::new(options)?;
    let gpu = resolve::gpu(&options.device)?;
    let mut run = Run::begin(Some(folder), options.resume)?;
    let scenes: Vec<Scene> = library::names().iter().take(plan.scenes).filter_map(|n| library::scene(n)).collect();

    let bar = progress::bar("study", 0);
    let view_specs = plan.view_specs(&gpu, &scenes);
    let table_spec = plan.table_5_8(&gpu, &scenes)?;
    let cells = plan.errors(&scenes);
    let frames = view_specs.iter().chain(&table_spec).map(TimeSpec::frames).sum::<usize>();
    let shown = scenes.iter().map(|s| plan.shown(s).len()).sum::<usize>();
    // Each method, unified with captures, and the truth.
    bar.inc_length((shown * (plan.methods.len() + 2) + frames) as u64);
    bar.inc_length(cells.as_ref().map_or(0, ErrorPlan::cells) as u64);

    type Shown = (Vec<Gallery>, Vec<Picture>, Vec<AgreementRecord>);
    let measure = |journal: &mut Journal| -> anyhow::Result<Shown> {
        let mut views = Vec::new();
        for scene in &scenes {
            views.extend(pictures(&gpu, scene, &plan.shown(scene), folder, &plan, &bar)?);
        }
        let figures = thesis_figures(&gpu, &scenes, folder, &plan)?;
        for spec in view_specs.iter().chain(&table_spec) {
            timing::measure(spec, journal, &mut || progress::step(&bar))?;
        }
        if let Some(cells) = &cells {
            let images = folder.join(ERROR_FOLDER).join("images");
            cells.measure(&gpu, journal, None, Some(&images), &mut || bar.inc(1))?;
        }
        Ok((views, figures, same_elsewhere(&gpu, &scenes, &plan, options.device.validation)?))
    };
    let outcome = measure(&mut run.journal);
    bar.finish_and_clear();

    // Whatever ended the measurement: what there is, is written.
    let journal = &run.journal;
    let view_records: Vec<TimeRecord> = view_specs.iter().flat_map(|s| timing::records(s, journal)).collect();
    let table_records: Vec<TimeRecord> = table_spec.iter().flat_map(|s| timing::records(s, journal)).collect();
    let error_costs = cells.as_ref().map(|c| c.costs(&gpu, journal)).unwrap_or_default();
    let error_records = cells.map(|c| c.records(&gpu, journal)).unwrap_or_default();
    let all: Vec<TimeRecord> = view_records.iter().chain(&table_records).cloned().collect();
    let wrote = files::write(&folder.join("time.json"), files::json(&all).as_bytes())
        .and_then(|()| files::write(&folder.join("time-samples.csv"), files::samples_csv(&all).as_bytes()))
        .and_then(|()| {
            error_report::write(&folder.join(ERROR_FOLDER), &error_records, &error_costs, &plan.command, &[])
        });
    // What ended it counts for more than what could not be written then.
    let (views, figures, same) = run.ended(outcome)?;
    wrote?;
    let page = Page {
        device: gpu.info(),
        command: plan.command.clone(),
        times: Times {
            settings: time_settings(&plan),
            table: compare(&table_records),
            table_records: &table_records,
            view_records: &view_records,
            plot: plot::stage_bars(&view_records).map_err(anyhow::Error::msg)?,
        },
        errors: Errors {
            settings: error_settings(&plan),
            records: &error_records,
            plots: error_report::plots(&error_records).map_err(anyhow::Error::msg)?,
            pictures: error_galleries(&error_records, &plan.methods),
        },
        views,
        figures,
        same,
        records: records(),
    };
    let html = page.render(folder)?;
    let index = folder.join("index.html");
    files::write(&index, html.as_bytes())?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "Table 5.8 of the thesis (GeForce GTX 670) and here ({}):", gpu.info().name)?;
    write!(out, "{}", tables::table_5_8(&page.times.table))?;
    writeln!(out, "{} ({:.1} MB)", index.display(), html.len() as f64 / 1e6)?;
    run.finish()?;
    gpu.check_validation()?;
    Ok(())
}

/// What every other device makes of a G-buffer of the rooms, against what this one makes of it.
fn same_elsewhere(gpu: &Gpu, scenes: &[Scene], plan: &Plan, validation: bool) -> Result<Vec<AgreementRecord>> {
    let mut records = Vec::new();
    let Some(scene) = scenes.first() else { return Ok(records) };
    let others = other_devices::others(gpu, validation)?;
    for roughness in QUICK_ROUGHNESS.into_iter().filter(|_| !others.is_empty()) {
        let globals = Globals { roughness: Some(roughness), ..Globals::default() };
        let (methods, setup) = (plan.methods.clone(), Setup::new(QUICK_SIZE));
        let spec = AgreementSpec { scene, view: scene.view("corridor")?, globals, methods, setup };
        records.extend(other_devices::compare(gpu, &others, &spec)?);
    }
    others.iter().try_for_each(Gpu::check_validation)?;
    Ok(records)
}

/// What lies beside the page.
fn records() -> Vec<(String, String)> {
    let of = |file: &str, what: &str| (file.to_owned(), what.to_owned());
    vec![
        of("time.json", "every time, one record a method, view, size and roughness"),
        of("time-samples.csv", "every sample of every pass"),
        of("journal.jsonl", "every sample and cell as it was measured, for --resume"),
        of("images/", "the pictures, lossless"),
        (format!("{TRUTH_FOLDER}/"), "the truth's samples, with which the next run goes on".into()),
        (format!("{ERROR_FOLDER}/error.json"), "every error, one record a method, cell and reference".into()),
        (format!("{ERROR_FOLDER}/error.txt"), "the same as tables".into()),
        (format!("{ERROR_FOLDER}/images/"), "reflections and FLIP maps as PNG, error maps as EXR".into()),
    ]
}

/// Each view: lit only, the truth, every method, and `unified` with captures.
fn pictures(
    gpu: &Gpu,
    scene: &Scene,
    views: &[&View],
    folder: &Path,
    plan: &Plan,
    bar: &ProgressBar,
) -> Result<Vec<Gallery>> {
    let plain = Setup::new(plan.size);
    let captured = plain.with(|p: &mut EffectParams| p.captures = CaptureCount::Number(4));
    let methods = plan.methods.iter().map(|m| (*m, m.name, &plain, format!("{}, roughness 0.1", m.name)));
    let with_captures = "unified with four captures, roughness 0.1".to_owned();
    let shown: Vec<_> = methods.chain([(&unified::INFO, CAPTURED, &captured, with_captures)]).collect();
    let mut stage = Stage::new(gpu, scene)?;
    let mut galleries = Vec::new();
    for view in views {
        let camera = view.camera(scene, plan.size);
        let materials = GLOSSY.materials(scene, view);
        let mut pictures = Vec::new();
        let mut picture = |pixels: &Pixels, name: &str, caption: String| -> Result<()> {
            let [of, seen] = [&scene.name, &view.name].map(|name| files::safe_word(name));
            let file = format!("images/{of}-{seen}-{}.png", name.replace(' ', "-"));
            images::write_image(&folder.join(&file), pixels)?;
            pictures.push(Picture { file, name: name.into(), caption });
            Ok(())
        };
        for (n, (method, name, setup, caption)) in shown.iter().enumerate() {
            let shot = Shot::new(&mut stage, method, setup, Wants::IMAGE, camera, materials.clone())?;
            let rendered = image::render(&mut stage, &shot, false)?;
            if n == 0 {
                let lit = stage.context.read(shot.gbuffer.gbuffer().color.level(0))?;
                picture(&lit, LIT, "direct light only".into())?;
                let (data, cache) = (gbuffer::read(&mut stage.context, &shot)?, folder.join(TRUTH_FOLDER));
                let truth = reference::truth(scene, &materials, &data, TRUTH_RAYS, &cache)?;
                picture(&truth, TRUTH, format!("the truth, roughness 0.1: traced with {TRUTH_RAYS} rays a pixel"))?;
                progress::step(bar)?;
            }
            picture(&rendered.composite, name, caption.clone())?;
            progress::step(bar)?;
        }
        galleries.push(Gallery {
            title: format!("{}, {}", scene.name, view.name),
            strips: vec![Strip::Plain(pictures)],
            compared: [METHODS[0].name.into(), TRUTH.into()],
        });
    }
    Ok(galleries)
}

/// Figures 4.4, 4.5, 4.9 and 4.10 on the first scene.
fn thesis_figures(gpu: &Gpu, scenes: &[Scene], folder: &Path, plan: &Plan) -> Result<Vec<Picture>> {
    let Some(scene) = scenes.first() else { return Ok(Vec::new()) };
    let wanted = [
        (
            Figure::VisibilityChain,
            "figure-4.4",
            [512, 512],
            "corridor",
            "Figure 4.4: the chain of the visibility buffer, level 0 omitted",
        ),
        (
            Figure::RaySplit,
            "figure-4.5",
            plan.size,
            "corridor",
            "Figure 4.5: rays traced by Hi-Z (green) and by the linear march (red); darker where nothing was hit",
        ),
        (
            Figure::RayTraceColorChain,
            "figure-4.9",
            plan.size,
            "corridor",
            "Figure 4.9: first five levels of the ray trace color buffer of SSLR",
        ),
        (
            Figure::MaskChain,
            "figure-4.10",
            plan.size,
            "corridor",
            "Figure 4.10: first five levels of the mask buffer of SSLR",
        ),
    ];
    let mut stage = Stage::new(gpu, scene)?;
    let mut pictures = Vec::new();
    for (figure, stem, extent, view, caption) in wanted {
        let view = scene.view(view)?;
        let camera = view.camera(scene, extent);
        let setup = figure.setup(&Setup::new(extent));
        let method = methods::find(figure.method())?;
        let shot = Shot::new(&mut stage, method, &setup, Wants::HITS, camera, GLOSSY.materials(scene, view))?;
        if let Some(all) = image::render(&mut stage, &shot, true)?.intermediates {
            let file = format!("images/{stem}.png");
            figures::draw(figure, &all, &camera.lens)?.write_png(&folder.join(&file))?;
            pictures.push(Picture { file, name: stem.to_owned(), caption: caption.to_owned() });
        }
    }
    Ok(pictures)
}

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

fn error_settings(plan: &Plan) -> String {
    let [width, height] = QUICK_SIZE;
    format!(
        "Every method as published on two views of the rooms at {width} × {height}, a mirror (roughness 0) and a glossy \
         one (0.1); references of {} rays a pixel, medians of {} frames. Errors are of the reflection colour before fade \
         and reflectivity. Black is where nothing is found: billboard, for one, shows impostors alone. In a FLIP \
         map black is no difference, and the brighter the more. A point on the Pareto front (red, and * in the \
         tables) is beaten by none in both time and error.",
        plan.rays, plan.samples
    )
}

/// Each cell: every method with its FLIP map beside what its errors are against.
fn error_galleries(records: &[ErrorRecord], methods: &[&MethodInfo]) -> Vec<Gallery> {
    let mut galleries: Vec<Gallery> = Vec::new();
    for r in records {
        let h = &r.head;
        let title = format!("{}, {}, roughness {}", h.scene, h.view, tables::roughness(h.roughness));
        if galleries.iter().any(|g| g.title == title) {
            continue;
        }
        let stem = error_report::stem(&h.scene, &h.view, [h.width, h.height], h.roughness);
        let picture = |file: String, name: &str, caption: String| Picture {
            file: format!("{ERROR_FOLDER}/images/{file}"),
            name: name.to_owned(),
            caption,
        };
        let reflection =
            |name: &str, caption: &str| picture(error_report::picture_file(&stem, name), name, caption.into());
        let pair = |name: &str| {
            let flip = error_report::flip_file(&stem, name);
            [reflection(name, name), picture(flip, &format!("FLIP map of {name}"), format!("FLIP map of {name}"))]
        };
        let (screen, more): (Vec<&MethodInfo>, Vec<&MethodInfo>) =
            methods.iter().copied().partition(|m| m.is_screen_space());
        let beside = |title: &str, reference, names: Vec<&str>| Strip::Beside {
            title: title.to_owned(),
            reference,
            pairs: names.into_iter().map(pair).collect(),
        };
        galleries.push(Gallery {
            title,
            strips: vec![
                beside(
                    "Against the screen reference",
                    reflection(SCREEN_REFERENCE, "screen reference"),
                    screen.iter().map(|m| m.name).chain([EXACT_HITS]).collect(),
                ),
                beside(
                    "Methods that see more than the screen, against the world",
                    reflection(WORLD_REFERENCE, "world reference"),
                    more.iter().map(|m| m.name).collect(),
                ),
            ],
            compared: [METHODS[0].name.into(), SCREEN_REFERENCE.into()],
        });
    }
    galleries
}
