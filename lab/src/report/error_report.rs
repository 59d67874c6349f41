//! The error study as files and text: records, plots of run time against error, picture strips.

use super::devices::{by_device, device_name};
use super::html::ErrorPage;
use super::images::{Rgb, write_exr};
use super::{files, plot, tables};
use crate::error::{Error, Result};
use crate::gpu::{DeviceInfo, Pixels};
use crate::metrics::flip::FlipMap;
use crate::metrics::pareto;
use crate::study::error::{Against, ErrorRecord, MeasuredCell, display};
use crate::study::record::DEFINITIONS;
use crate::study::sweep::{self, Point};
use std::collections::BTreeSet;
use std::path::Path;

/// The three references with what their plots show.
pub const REFERENCES: [(Against, &str, &str); 3] = [
    (Against::Oracle, "oracle", "share of wrong hits against the oracle (roughness 0)"),
    (Against::Screen, "screen", "RMSE against the screen reference"),
    (Against::World, "world", WORLD_AXIS),
];

/// What an error against the world is called.
const WORLD_AXIS: &str = "RMSE against the world reference";

/// The plot of a reference, and what it shows as a table.
#[derive(Debug, Clone)]
pub struct ErrorPlot {
    /// The reference's name.
    pub name: &'static str,
    /// The error that it shows.
    pub axis: &'static str,
    /// Run time against error, SVG.
    pub svg: String,
    /// The points of the plot as rows of a table.
    pub cells: Vec<Vec<String>>,
}

/// One plot for each reference that the records have.
pub fn plots(records: &[ErrorRecord]) -> std::result::Result<Vec<ErrorPlot>, String> {
    let mut plots = Vec::new();
    for (against, name, axis) in REFERENCES {
        let points = sweep::points(records, against);
        if !points.is_empty() {
            let svg = plot::time_against_error(&points, axis)?;
            plots.push(ErrorPlot { name, axis, svg, cells: point_cells(&points, floor(records, against)) });
        }
    }
    let points = sweep::points(records, Against::World);
    if let Some(svg) = bytes_against_error(&points)? {
        let cells = point_cells(&points, floor(records, Against::World));
        plots.push(ErrorPlot { name: "world-bytes", axis: WORLD_AXIS, svg, cells });
    }
    Ok(plots)
}

/// What is prepared against the error, where there is more than one size of it: one size alone is a column of the table.
fn bytes_against_error(points: &[Point]) -> std::result::Result<Option<String>, String> {
    let cost = |p: &Point| p.prepared.map_or(0.0, |(bytes, _)| bytes / MIB);
    let points: Vec<&Point> = points.iter().filter(|p| cost(p) > 0.0).collect();
    if points.iter().all(|p| cost(p) == cost(points[0])) {
        return Ok(None);
    }
    let front = pareto::front(&points.iter().map(|p| (cost(p), p.error)).collect::<Vec<_>>());
    let named = |(i, p): (usize, &&Point)| plot::NamedPoint {
        name: p.name.clone(),
        at: [cost(p), p.error],
        on_front: front.contains(&i),
    };
    let named: Vec<_> = points.iter().enumerate().map(named).collect();
    plot::against(&named, ["MiB on the device, prepared", WORLD_AXIS]).map(Some)
}

/// The folder of the cells' pictures.
pub const IMAGES: &str = "images";

/// Writes error.json, error.txt, one plot for each reference and device, and index.html. `command` is that
/// of the whole study, and `missing` names the cells of the study that have no records.
pub fn write(folder: &Path, records: &[ErrorRecord], command: &str, missing: &[String]) -> Result<()> {
    let failed = |e: String| Error::io("draw the plots of", folder, std::io::Error::other(e));
    let mut parts = Vec::new();
    let apart = by_device(records, |r| &r.head.program.device);
    for (n, (device, records)) in apart.iter().enumerate() {
        let plots = plots(records).map_err(failed)?;
        let device_part = if apart.len() > 1 { format!("-device-{}", n + 1) } else { String::new() };
        for plot in &plots {
            files::write(&folder.join(format!("error-{}{device_part}.svg", plot.name)), plot.svg.as_bytes())?;
        }
        parts.push(DevicePart { device: device.clone(), cells: cells(records), plots });
    }
    files::write(&folder.join("error.json"), files::json(records).as_bytes())?;
    files::write(&folder.join("error.txt"), text(records).as_bytes())?;
    let sources = source_cells(&one_of_each(records));
    let page = ErrorPage { definitions: definitions(records), command, devices: &parts, sources: &sources, missing };
    files::write(&folder.join("index.html"), page.render().as_bytes())
}

/// The part of the study that was measured on one device.
pub struct DevicePart {
    /// The device.
    pub device: DeviceInfo,
    /// The number of cells.
    pub cells: usize,
    /// Run time against error on the device.
    pub plots: Vec<ErrorPlot>,
}

fn definitions(records: &[ErrorRecord]) -> u32 {
    records.first().map_or(DEFINITIONS, |r| r.head.program.definitions)
}

/// The name of a record's cell.
fn cell_of(r: &ErrorRecord) -> String {
    stem(&r.head.scene, &r.head.view, [r.head.width, r.head.height], r.head.roughness)
}

/// How many cells some records are of.
fn cells(records: &[ErrorRecord]) -> usize {
    records.iter().map(cell_of).collect::<BTreeSet<_>>().len()
}

/// Keeps the first record of each figure that several devices measured: an error is the same on all devices.
fn one_of_each(records: &[ErrorRecord]) -> Vec<ErrorRecord> {
    let mut seen = BTreeSet::new();
    let of = |r: &&ErrorRecord| {
        let set = serde_json::to_string(&r.head.setup).unwrap_or_default();
        seen.insert(format!("{} {} {:?} {:?} {set}", cell_of(r), r.head.method, r.head.preset, r.against))
    };
    records.iter().filter(of).cloned().collect()
}

/// What the files of a cell begin with.
pub fn stem(scene: &str, view: &str, [width, height]: [u32; 2], roughness: Option<f32>) -> String {
    let [scene, view] = [scene, view].map(files::safe_word);
    format!("{scene}-{view}-{width}x{height}-r{}", tables::roughness(roughness))
}

/// Name of a cell's picture; its error maps have "-rmse" or "-flip" before the extension.
pub fn picture_file(stem: &str, name: &str) -> String {
    format!("{stem}-{}.png", files::safe_word(name))
}

/// Name of the FLIP map of a cell's picture.
pub fn flip_file(stem: &str, name: &str) -> String {
    format!("{stem}-{}-flip.png", files::safe_word(name))
}

/// Writes the images of a cell: reflection colours, and for methods each error map as EXR and as a
/// picture in FLIP's colours, where white is 1.
pub fn write_strips(folder: &Path, stem: &str, cell: &MeasuredCell) -> Result<()> {
    let [width, height] = cell.extent;
    for strip in &cell.strips {
        let file = |suffix: &str| folder.join(format!("{stem}-{}{suffix}", files::safe_word(&strip.name)));
        Rgb { width, height, bytes: display(&strip.color) }.write_png(&folder.join(picture_file(stem, &strip.name)))?;
        if let Some(error) = &strip.error {
            let maps = [("rmse", &error.rmse), ("flip", &error.flip.errors)];
            for (name, values) in maps {
                let pixels = Pixels { width, height, channels: 1, values: values.clone() };
                write_exr(&file(&format!("-{name}.exr")), &pixels, &[name])?;
                Rgb { width, height, bytes: heat(values, width, height) }.write_png(&file(&format!("-{name}.png")))?;
            }
        }
    }
    Ok(())
}

fn heat(errors: &[f32], width: u32, height: u32) -> Vec<u8> {
    FlipMap { width, height, errors: errors.iter().map(|e| e.clamp(0.0, 1.0)).collect() }.picture()
}

/// The points of every reference with the front, device by device, and the parts of the error.
pub fn text(records: &[ErrorRecord]) -> String {
    let mut text = String::new();
    let apart = by_device(records, |r| &r.head.program.device);
    for (device, records) in &apart {
        if apart.len() > 1 {
            text += &format!("{}; {} cells\n\n", device_name(device), cells(records));
        }
        text += &points_text(records);
    }
    text += "RMSE of the reflection colour by roughness, median over the views\n";
    text + &tables::aligned(&source_cells(&one_of_each(records)))
}

/// The points of every reference with the front, for the records of one device.
fn points_text(records: &[ErrorRecord]) -> String {
    let mut text = String::new();
    for (against, _, axis) in REFERENCES {
        let points = sweep::points(records, against);
        if points.is_empty() {
            continue;
        }
        text += &format!("{axis}, mean over the cells; * is on the Pareto front\n");
        text += &tables::aligned(&point_cells(&points, floor(records, against)));
        text += "\n";
    }
    text
}

/// What is beside errors against the world.
fn floor(records: &[ErrorRecord], against: Against) -> Option<f64> {
    sweep::floor(records).filter(|_| against == Against::World)
}

/// Bytes of a MiB.
const MIB: f64 = (1 << 20) as f64;

/// Name of the floor in tables.
const FLOOR: &str = "floor of the screen";

/// One row a point, and below them the floor. Places, and what was prepared, are columns where a point has any.
fn point_cells(points: &[Point], floor: Option<f64>) -> Vec<Vec<String>> {
    let has_places = points.iter().any(|p| p.place_agreement.is_some());
    let has_prepared = points.iter().any(|p| p.prepared.is_some_and(|(bytes, _)| bytes > 0.0));
    let row = |[name, time, error, front, place, bytes, prepared]: [String; 7]| {
        let first = [name, time, error, front].into_iter().chain(has_places.then_some(place));
        first.chain([bytes, prepared].into_iter().filter(|_| has_prepared)).collect::<Vec<_>>()
    };
    let point = |p: &Point| {
        let front = if p.on_front { "*" } else { "" };
        let place = p.place_agreement.map_or_else(|| "-".into(), |share| format!("{:.1} %", 100.0 * share));
        let (bytes, prepared) = p.prepared.unwrap_or_default();
        let [time, error] = [format!("{:.3}", p.time_ms), format!("{:.4}", p.error)];
        let prepared = [format!("{:.1}", bytes / MIB), format!("{prepared:.0}")];
        let [bytes, prepared] = prepared;
        row([p.name.clone(), time, error, front.to_owned(), place, bytes, prepared])
    };
    let names = ["variant", "median ms", "error", "front", "right places, r 0", "prepared MiB", "prepared ms"];
    let dash = || "-".to_owned();
    let last =
        floor.map(|error| row([FLOOR.into(), dash(), format!("{error:.4}"), String::new(), dash(), dash(), dash()]));
    std::iter::once(row(names.map(str::to_owned))).chain(points.iter().map(point)).chain(last).collect()
}

/// One row a method and reference, and one for the floor; one column a roughness.
pub fn source_cells(records: &[ErrorRecord]) -> Vec<Vec<String>> {
    let sources = sweep::sources(records);
    let mut rows: Vec<(String, Against)> = Vec::new();
    for (method, against, _) in sources.iter().flat_map(|s| &s.rmse) {
        if !rows.contains(&(method.clone(), *against)) {
            rows.push((method.clone(), *against));
        }
    }
    let mut header = vec!["what, against".to_owned()];
    header.extend(sources.iter().map(|s| format!("r {}", tables::roughness(s.roughness))));
    let row = |(method, against): &(String, Against)| {
        let against_name = REFERENCES.iter().find(|r| r.0 == *against).map_or("", |r| r.1);
        let mut row = vec![format!("{method}, {against_name}")];
        row.extend(sources.iter().map(|s| {
            let found = s.rmse.iter().find(|(m, a, _)| m == method && a == against);
            found.map_or_else(|| "-".into(), |(.., rmse)| format!("{rmse:.4}"))
        }));
        row
    };
    let mut cells: Vec<_> = std::iter::once(header).chain(rows.iter().map(row)).collect();
    if sources.iter().any(|s| s.floor.is_some()) {
        let floors = sources.iter().map(|s| s.floor.map_or_else(|| "-".into(), |floor| format!("{floor:.4}")));
        cells.push(std::iter::once(format!("{FLOOR}, world")).chain(floors).collect());
    }
    cells
}
