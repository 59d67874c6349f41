//! `ssct study`: pictures, times and the page that shows them.

use super::cli::StudyOptions;
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::methods::{METHODS, Setup};
use crate::report::figures::{self, Figure};
use crate::report::html::{Page, Picture, Strip};
use crate::report::{files, images, plot, tables};
use crate::scene::{Scene, View, library};
use crate::study::table::{TABLE_5_8, compare};
use crate::study::timing::{TimeSpec, camera, time};
use crate::study::{Globals, Shot, Stage, TimeRecord, image};
use indicatif::ProgressBar;
use std::io::Write;
use std::path::Path;

/// Size of pictures and of the views' times: the thesis's own benchmark size.
const SIZE: [u32; 2] = [960, 540];
/// Roughness and normal deviation of the pictures: table 5.8's rougher rows.
const GLOSSY: Globals = Globals { roughness: Some(0.1), reflectivity: 1.0, normal_deviation: Some(0.1) };

/// How much is done.
struct Plan {
    views: usize,
    size: [u32; 2],
    samples: usize,
    table_sizes: Vec<[u32; 2]>,
}

/// Runs the study and writes its folder.
pub fn run(options: &StudyOptions) -> anyhow::Result<()> {
    let folder = &options.output;
    let plan = if options.quick {
        Plan { views: 1, size: [480, 270], samples: 3, table_sizes: vec![[640, 480]] }
    } else {
        let mut table_sizes: Vec<_> = TABLE_5_8.iter().map(|r| r.size).collect();
        table_sizes.dedup();
        Plan { views: usize::MAX, size: SIZE, samples: options.samples, table_sizes }
    };
    if plan.samples == 0 {
        return Err(Error::Usage("--samples 0: at least one is needed".into()).into());
    }
    let gpu = resolve::gpu(&options.device)?;
    let scenes: Vec<Scene> = library::names().iter().filter_map(|n| library::scene(n)).collect();

    let bar = progress::bar("study", 0);
    let mut strips = Vec::new();
    let mut view_records = Vec::new();
    for scene in &scenes {
        let views: Vec<&View> = scene.views.iter().take(plan.views).collect();
        bar.inc_length((views.len() * METHODS.len()) as u64);
        strips.extend(pictures(&gpu, scene, &views, folder, &plan, &bar)?);
        for view in views {
            view_records.extend(timed(&gpu, scene, view, &[plan.size], &[GLOSSY], plan.samples, &bar)?);
        }
    }
    let figures = thesis_figures(&gpu, &scenes, folder, &plan)?;
    let table_records = table_5_8(&gpu, &scenes, &plan, &bar)?;
    bar.finish_and_clear();

    let table = compare(&table_records);
    let all: Vec<TimeRecord> = view_records.iter().chain(&table_records).cloned().collect();
    files::write(&folder.join("time.json"), files::json(&all).as_bytes())?;
    files::write(&folder.join("time-samples.csv"), files::samples_csv(&all).as_bytes())?;
    let page = Page {
        device: gpu.info(),
        command: if options.quick { "ssct study --quick".into() } else { "ssct study".into() },
        strips,
        figures,
        table,
        table_records: &table_records,
        view_records: &view_records,
        plot: plot::stage_bars(&view_records).map_err(anyhow::Error::msg)?,
    };
    let index = folder.join("index.html");
    files::write(&index, page.render().as_bytes())?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "Table 5.8 of the thesis (GeForce GTX 670) and here ({}):", gpu.info().name)?;
    write!(out, "{}", tables::table_5_8(&page.table))?;
    writeln!(out, "{}", index.display())?;
    gpu.check_validation()?;
    Ok(())
}

/// Each view: lit only, and every method.
fn pictures(
    gpu: &Gpu,
    scene: &Scene,
    views: &[&View],
    folder: &Path,
    plan: &Plan,
    bar: &ProgressBar,
) -> Result<Vec<Strip>> {
    let mut stage = Stage::new(gpu, scene)?;
    let mut strips = Vec::new();
    for view in views {
        let mut pictures = Vec::new();
        for (n, method) in METHODS.iter().enumerate() {
            let camera = camera(scene, view, plan.size);
            let shot = Shot::new(gpu, method, &Setup::new(plan.size), camera, GLOSSY.materials(scene, view))?;
            let rendered = image::render(&mut stage, &shot, false)?;
            if n == 0 {
                let lit = stage.context.read(shot.gbuffer.gbuffer().color.level(0))?;
                let file = format!("images/{}-{}-lit.png", scene.name, view.name);
                images::write_image(&folder.join(&file), &lit)?;
                pictures.push(Picture { file, caption: "direct light only".into() });
            }
            let file = format!("images/{}-{}-{}.png", scene.name, view.name, method.name);
            images::write_image(&folder.join(&file), &rendered.composite)?;
            pictures.push(Picture { file, caption: format!("{}, roughness 0.1", method.name) });
            bar.inc(1);
        }
        strips.push(Strip { title: format!("{}, {}", scene.name, view.name), pictures });
    }
    Ok(strips)
}

fn timed(
    gpu: &Gpu,
    scene: &Scene,
    view: &View,
    sizes: &[[u32; 2]],
    globals: &[Globals],
    samples: usize,
    bar: &ProgressBar,
) -> Result<Vec<TimeRecord>> {
    let spec = TimeSpec {
        gpu,
        scene,
        view,
        methods: METHODS.iter().collect(),
        sizes: sizes.to_vec(),
        globals: globals.to_vec(),
        setup: Setup::new(sizes[0]),
        warmup: 1,
        samples,
    };
    bar.inc_length(spec.frames() as u64);
    time(&spec, &mut || bar.inc(1))
}

/// Table 5.8 on the atrium's view `hall`.
fn table_5_8(gpu: &Gpu, scenes: &[Scene], plan: &Plan, bar: &ProgressBar) -> Result<Vec<TimeRecord>> {
    let Some(atrium) = scenes.iter().find(|s| s.name == "atrium") else { return Ok(Vec::new()) };
    let globals = [0.0, 0.1].map(|r| Globals { roughness: Some(r), reflectivity: 1.0, normal_deviation: Some(r) });
    timed(gpu, atrium, atrium.view("hall")?, &plan.table_sizes, &globals, plan.samples, bar)
}

/// Figures 4.4 and 4.5 on the first scene.
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
    ];
    let mut stage = Stage::new(gpu, scene)?;
    let mut pictures = Vec::new();
    for (figure, stem, extent, view, caption) in wanted {
        let view = scene.view(view)?;
        let camera = camera(scene, view, extent);
        let setup = Setup { split: true, ..Setup::new(extent) };
        let shot = Shot::new(gpu, &METHODS[0], &setup, camera, GLOSSY.materials(scene, view))?;
        if let Some(all) = image::render(&mut stage, &shot, true)?.intermediates {
            let file = format!("images/{stem}.png");
            figures::draw(figure, &all, &camera.lens)?.write_png(&folder.join(&file))?;
            pictures.push(Picture { file, caption: caption.to_owned() });
        }
    }
    Ok(pictures)
}
