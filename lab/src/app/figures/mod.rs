//! `ssct figures`: makes every figure of the published documents that this program can reproduce, and a page
//! that shows each one beside a description of the printed figure.

mod draw;
mod plate;
mod plates;
mod workshop;

use super::cli::FiguresOptions;
use super::{progress, resolve};
use crate::error::{Error, Result};
use crate::report::files;
use crate::report::html::{Entry, FiguresPage, Group, Panel};
use crate::report::run_folder::Claim;
use plate::{Document, FinishedFigure, Plate};
use plates::plates;
use std::io::Write;
use std::path::Path;
use workshop::Workshop;

/// Makes the figures and writes their page.
pub fn run(options: &FiguresOptions) -> anyhow::Result<()> {
    let wanted = wanted(&options.only)?;
    let gpu = resolve::gpu(&options.device)?;
    let _claim = Claim::new(&options.output)?;
    let mut workshop = Workshop::new(&gpu);
    let bar = progress::bar("figures", wanted.len());
    let mut entries = Vec::new();
    for plate in &wanted {
        bar.set_message(format!("figure {}", plate.number));
        entries.push((plate.source, entry(plate, &mut workshop, options)?));
        bar.inc(1);
    }
    bar.finish_and_clear();

    let mut out = std::io::stdout().lock();
    for (_, e) in &entries {
        match &e.file {
            Ok(file) => writeln!(out, "{file}: {}", e.title)?,
            Err(why) => writeln!(out, "{} left out: {why}", e.stem)?,
        }
    }
    let made = entries.iter().filter(|(_, e)| e.file.is_ok()).count();
    let left_out = entries.len() - made;
    let page = FiguresPage { device: gpu.info(), command: command(options), groups: groups(entries) };
    let index = options.output.join("index.html");
    files::write(&index, page.render(&options.output)?.as_bytes())?;
    writeln!(out, "{}: {made} figures, {left_out} left out", index.display())?;
    drop(workshop);
    gpu.check_validation()?;
    Ok(())
}

/// The figures with the given numbers, with or without their document's name; all figures if none are given.
fn wanted(only: &[String]) -> Result<Vec<&'static Plate>> {
    let is = |p: &Plate, name: &String| *name == p.number || *name == p.stem();
    if let Some(unknown) = only.iter().find(|name| plates().all(|p| !is(p, name))) {
        let numbers: Vec<&str> = plates().map(|p| p.number).collect();
        return Err(Error::Usage(format!(
            "--only {unknown}: there is no such figure; available are: {}",
            numbers.join(", ")
        )));
    }
    Ok(plates().filter(|p| only.is_empty() || only.iter().any(|name| is(p, name))).collect())
}

/// Makes a figure, writes its file, and returns its entry on the page.
fn entry(plate: &Plate, workshop: &mut Workshop, options: &FiguresOptions) -> anyhow::Result<Entry> {
    let arguments = plate.arguments(options.size);
    let file = match arguments.iter().find_map(|a| workshop::lack(a)) {
        Some(why) => Err(why),
        None => Ok(write(plate, (plate.make)(workshop, &arguments)?, &options.output)?),
    };
    let panels = plate.panels.iter().zip(&arguments).enumerate().map(|(n, ((label, _), arguments))| {
        // A figure made of intermediates has a folder in its arguments, the others have a file.
        let inside = arguments.contains("--dump");
        let file = if inside { String::new() } else { format!(" -o {}-{}.png", plate.stem(), n + 1) };
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
        differs: plate.differs.to_owned(),
        panels: panels.collect(),
        command: format!("ssct figures --only {} -o {}", plate.number, options.output.display()),
    })
}

/// Writes a figure to a file and returns the file's name.
fn write(plate: &Plate, made: FinishedFigure, folder: &Path) -> Result<String> {
    match made {
        FinishedFigure::Picture(picture) => {
            let file = format!("{}.png", plate.stem());
            picture.write_png(&folder.join(&file))?;
            Ok(file)
        }
        FinishedFigure::Drawing(svg) => {
            let file = format!("{}.svg", plate.stem());
            files::write(&folder.join(&file), svg.as_bytes())?;
            Ok(file)
        }
    }
}

fn groups(entries: Vec<(Document, Entry)>) -> Vec<Group> {
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
             frames per second on the way through a scene: ssct time --path views.",
        ),
    ];
    let mut entries = entries;
    let mut groups = Vec::new();
    for (source, title, text) in documents {
        let (own, others): (Vec<_>, Vec<_>) = entries.into_iter().partition(|(s, _)| *s == source);
        entries = others;
        if !own.is_empty() {
            groups.push(Group {
                id: source.stem().to_owned(),
                title: title.to_owned(),
                source: text.to_owned(),
                entries: own.into_iter().map(|(_, e)| e).collect(),
            });
        }
    }
    groups
}

fn command(options: &FiguresOptions) -> String {
    let mut command = "ssct figures".to_owned();
    if !options.only.is_empty() {
        command += &format!(" --only {}", options.only.join(","));
    }
    if let Some([width, height]) = options.size {
        command += &format!(" --size {width}x{height}");
    }
    format!("{command} -o {}", options.output.display())
}
