//! `ssct figures`: makes every figure of the published documents that this program can reproduce, and a page
//! that shows each one beside a description of the printed figure.

mod draw;
mod plate;
mod plates;
mod renderer;

use super::cli::FiguresOptions;
use super::printed;
use super::run::Run;
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::html::{Entry, FiguresPage, Group, Panel};
use crate::study::cell_list::{CellList, CellListHead, PlannedCell};
use crate::study::journal::{digest, scene_digest};
use crate::study::names::one_line;
use crate::study::record::DEFINITIONS;
use plate::{Document, FinishedFigure, Plate, PrintedScene};
use plates::plates;
use renderer::FigureRenderer;
use serde_json::{Value, json};
use ssct::gpu::{DeviceInfo, Gpu};
use ssct_scenes::inside::PathInFolder;
use ssct_scenes::{LoadOptions, Scene};
use std::io::Write;
use std::path::Path;

/// Makes the figures that the options name and the folder does not have yet, and writes their page. A shard makes its
/// own share alone.
pub fn run(options: &FiguresOptions) -> anyhow::Result<()> {
    let own_scene = options.scene.as_deref().map(OwnScene::load).transpose()?;
    let wanted = find_plates(&options.only, own_scene.as_ref())?;
    let gpu = resolve::gpu(&options.device)?;
    let folder = PathInFolder::folder(&options.output);
    let own_scene_digest = own_scene.as_ref().map(|scene| scene.digest.clone());
    let key = |plate: &Plate| {
        let settings = json!([settings(plate, options), own_scene_digest]);
        format!("figure {} {}", plate.stem(), digest(&gpu, &settings))
    };
    let list = cell_list(options, &gpu, wanted.iter().map(|plate| (*plate, key(plate))).collect());
    let mut run = Run::begin(Some(&options.output), options.resume)?;
    run.write_list(&list)?;
    let mut renderer = FigureRenderer::new(&gpu);
    if let Some(OwnScene { file, scene, .. }) = own_scene {
        renderer.hold(&file, scene)?;
    }
    let bar = progress::bar("figures", list.count_own());
    let mut outcome = Ok(());
    for plate in list.select_own(&wanted) {
        bar.set_message(format!("figure {}", plate.number));
        let known = run.journal.get::<Entry>(&key(plate));
        let has_file = |e: &Entry| e.file.as_ref().map_or(true, |file| folder.join(file).is_there());
        if !known.is_some_and(|e| has_file(&e)) {
            outcome = make_figure(plate, &mut renderer, options, &folder)
                .and_then(|e| Ok(run.journal.put(key(plate), &e)?));
        }
        // The figures that were made before an error are still put on the page.
        outcome = outcome.and_then(|()| Ok(progress::step(&bar)?));
        if outcome.is_err() {
            break;
        }
    }
    bar.finish_and_clear();
    let entries = wanted.iter().filter_map(|plate| run.journal.get::<Entry>(&key(plate))).collect::<Vec<_>>();

    let line = |e: &Entry| match &e.file {
        Ok(file) => format!("{}: {}\n", one_line(file), one_line(&e.title)),
        Err(why) => format!("{} left out: {}\n", one_line(&e.stem), one_line(why)),
    };
    let mut text: String = entries.iter().map(line).collect();
    let written = write_page(&folder, &entries, gpu.info(), &command(options, &options.only.join(",")));
    let made_count = entries.iter().filter(|e| e.file.is_ok()).count();
    let made_all = run.outcome_with_journal(outcome);
    let finished = if made_all.is_ok() && written.is_ok() {
        let index = options.output.join(INDEX);
        let left_out_count = entries.len() - made_count;
        text.push_str(&format!("{}: {made_count} figures, {left_out_count} left out\n", index.display()));
        run.finish()
    } else {
        Ok(())
    };
    // Printing comes last, so that a reader who closes the pipe early loses no file.
    let printed = printed::out().write_all(text.as_bytes());
    made_all?;
    written?;
    finished?;
    drop(renderer);
    gpu.check_validation()?;
    Ok(printed?)
}

/// The name of the page's file.
const INDEX: &str = "index.html";

/// Writes the page that shows some figures of one device. The files of the figures lie in `folder`.
pub fn write_page(folder: &PathInFolder, entries: &[Entry], device: &DeviceInfo, command: &str) -> Result<()> {
    let page = FiguresPage { device, command: command.to_owned(), groups: group_by_document(entries) };
    Ok(folder.join(INDEX).write(page.render(folder)?.as_bytes())?)
}

/// The settings that a figure depends on, besides the device and the program; the program includes the built-in scenes.
fn settings(plate: &Plate, options: &FiguresOptions) -> Value {
    json!([plate.stem(), plate.arguments(options.size, scene_file(options).as_deref())])
}

/// The path of the scene file that the options name, as text.
fn scene_file(options: &FiguresOptions) -> Option<String> {
    options.scene.as_ref().map(|path| path.to_string_lossy().into_owned())
}

/// A printed scene that the user has as a file.
struct OwnScene {
    file: String,
    printed: PrintedScene,
    digest: String,
    scene: Scene,
}

impl OwnScene {
    /// Loads the scene of a file. Its views decide which printed scene it is; it is an error if they are those of none.
    fn load(path: &Path) -> Result<Self> {
        let file = path.to_string_lossy().into_owned();
        if !path.is_file() {
            return Err(Error::usage(format!("--scene {file}: there is no such file")));
        }
        let scene = resolve::load(&[path.to_owned()], &LoadOptions::default())?;
        let Some(printed) = PrintedScene::from_scene(&scene) else {
            let views = |p: PrintedScene| p.views().join(", ");
            return Err(Error::usage(format!(
                "--scene {file}: no figure is drawn in this scene, as it has neither the views of the thesis's rooms ({}) nor \
                 those of Sponza ({})",
                views(PrintedScene::Rooms),
                views(PrintedScene::Sponza)
            )));
        };
        if file.contains('"') {
            return Err(Error::usage(format!(
                "--scene {file}: a path with a quotation mark cannot stand in a command"
            )));
        }
        Ok(Self { printed, digest: scene_digest(&scene), scene, file })
    }
}

/// Makes the list of the run's cells, one for each figure. Each figure comes with the key of its entry in the journal.
fn cell_list(options: &FiguresOptions, gpu: &Gpu, plates: Vec<(&Plate, String)>) -> CellList {
    let planned = |(plate, key): (&Plate, String)| PlannedCell::new(plate.stem(), settings(plate, options), key);
    let cells = plates.into_iter().map(planned).collect();
    let head = CellListHead {
        kind: "figures",
        definitions: DEFINITIONS,
        command: command(options, &options.only.join(",")),
        shard: options.shard,
        settings: Value::Null,
        scenes: Vec::new(),
    };
    CellList::new(head, gpu.info(), cells)
}

/// Returns the figures that `only` names by number, with or without the document's stem; all figures if `only` is
/// empty. With a scene from a file, only figures that show this scene in print are found.
fn find_plates(only: &[String], own_scene: Option<&OwnScene>) -> Result<Vec<&'static Plate>> {
    let has_name = |p: &Plate, name: &String| *name == p.number || *name == p.stem();
    let prints = |p: &Plate, scene: PrintedScene| p.prints.is_some_and(|(printed, _)| printed == scene);
    let available: Vec<_> = plates().filter(|p| own_scene.is_none_or(|scene| prints(p, scene.printed))).collect();
    if let Some(unknown) = only.iter().find(|name| available.iter().all(|p| !has_name(p, name))) {
        let numbers: Vec<&str> = available.iter().map(|p| p.number).collect();
        let why = own_scene.map_or("there is no such figure".to_owned(), |scene| {
            format!("no such figure shows the scene of {} in print", scene.file)
        });
        return Err(Error::usage(format!("--only {unknown}: {why}; available are: {}", numbers.join(", "))));
    }
    Ok(available.into_iter().filter(|p| only.is_empty() || only.iter().any(|name| has_name(p, name))).collect())
}

/// Makes a figure, writes its file, and returns its entry on the page. A figure that this program cannot make gets an
/// entry with the reason, and no file.
fn make_figure(
    plate: &Plate,
    renderer: &mut FigureRenderer,
    options: &FiguresOptions,
    folder: &PathInFolder,
) -> anyhow::Result<Entry> {
    let scene_file = scene_file(options);
    let arguments = plate.arguments(options.size, scene_file.as_deref());
    let file = match arguments.iter().find_map(|a| renderer::find_lack(a)) {
        Some(why) => Err(why),
        None => Ok(write_figure(plate, (plate.make)(renderer, &arguments)?, folder)?),
    };
    let panels = plate.panels.iter().zip(&arguments).enumerate().map(|(n, ((label, _), arguments))| {
        // Arguments with `--dump` name a folder for the render's images; to other arguments the file is added.
        let has_folder = arguments.contains("--dump");
        let file = if has_folder { String::new() } else { format!(" -o {}-{}.png", plate.stem(), n + 1) };
        Panel { label: (*label).to_owned(), command: format!("ssct render {arguments}{file}") }
    });
    let name = match plate.source {
        Document::Thesis => "Figure",
        Document::Poster => "The poster's figure",
        Document::Schmidt => "Schmidt's figure",
    };
    Ok(Entry {
        stem: plate.stem(),
        title: format!("{name} {}: {}", plate.number, plate.title),
        file,
        print: plate.print.to_owned(),
        differs: plate.differs(scene_file.is_some()).to_owned(),
        panels: panels.collect(),
        command: command(options, plate.number),
    })
}

/// Writes a figure to a file and returns the file's name.
fn write_figure(plate: &Plate, figure: FinishedFigure, folder: &PathInFolder) -> Result<String> {
    match figure {
        FinishedFigure::Picture(picture) => {
            let file = format!("{}.png", plate.stem());
            picture.write_png(folder.join(&file))?;
            Ok(file)
        }
        FinishedFigure::Drawing(svg) => {
            let file = format!("{}.svg", plate.stem());
            folder.join(&file).write(svg.as_bytes())?;
            Ok(file)
        }
    }
}

/// Groups the entries of the page by their documents. A document without entries has no group.
fn group_by_document(entries: &[Entry]) -> Vec<Group> {
    let documents = [
        (
            Document::Thesis,
            "Hermanns 2015",
            "Lukas Hermanns, Screen Space Cone Tracing for Glossy Reflections, thesis, TU Darmstadt, 2015. The \
             times in its captions: ssct time --table captions; table 5.8: ssct time --table 5.8.",
        ),
        (
            Document::Poster,
            "Hermanns and Franke 2014",
            "Lukas Hermanns and Tobias Alexander Franke, Screen Space Cone Tracing for Glossy Reflections, SIGGRAPH poster, \
             2014.",
        ),
        (
            Document::Schmidt,
            "Schmidt 2013",
            "Guido Schmidt, Rendering view dependent reflections using the graphics card, thesis, University of \
             Koblenz-Landau, 2013. Its figures 42 and 52, \
             frames per second on the way through a scene: ssct path.",
        ),
    ];
    let group = |(document, title, description): (Document, &str, &str)| {
        let is_of_document = |e: &&Entry| plates().any(|p| p.source == document && p.stem() == e.stem);
        let entries: Vec<Entry> = entries.iter().filter(is_of_document).cloned().collect();
        let (id, title, source) = (document.stem().to_owned(), title.to_owned(), description.to_owned());
        (!entries.is_empty()).then_some(Group { id, title, source, entries })
    };
    documents.into_iter().filter_map(group).collect()
}

/// The command that makes the figures `only` as the options say, as the page shows it; all figures if `only` is empty.
fn command(options: &FiguresOptions, only: &str) -> String {
    let mut command = format!("ssct figures{}", scene_option(options));
    if !only.is_empty() {
        command += &format!(" --only {only}");
    }
    if let Some([width, height]) = options.size {
        command += &format!(" --size {width}x{height}");
    }
    command
}

/// The text ` --scene FILE` for a shown command; empty if the options name no scene file.
fn scene_option(options: &FiguresOptions) -> String {
    scene_file(options).map_or_else(String::new, |file| format!(" --scene {}", printed::quote_word(&file)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    /// The command line of one `ssct figures`.
    #[derive(Parser)]
    struct Figures {
        #[command(flatten)]
        options: FiguresOptions,
    }

    #[test]
    fn the_command_of_one_figure_has_the_scene_and_the_size_that_were_given() {
        let command_of_figure = |arguments: &[&str]| {
            let words = ["figures"].into_iter().chain(arguments.iter().copied());
            command(&Figures::try_parse_from(words).expect("arguments").options, "4.5")
        };
        assert_eq!(command_of_figure(&["--only", "4.5,5.2"]), "ssct figures --only 4.5");
        let given = ["--scene", "my rooms.gltf", "--only", "4.5,5.2", "--size", "64x36"];
        let expected = "ssct figures --scene \"my rooms.gltf\" --only 4.5 --size 64x36";
        assert_eq!(command_of_figure(&given), expected);
    }
}
