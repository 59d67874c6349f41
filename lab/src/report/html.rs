//! The page of a study: tables, plots and pictures in one file that needs nothing from elsewhere. The page embeds pictures at a small size,
//! and links to files beside the page with lossless pictures and raw records.

mod embed;
mod figures;
mod gallery;
mod library;
mod sections;
mod study;

pub use embed::{PictureFolder, data_uri};
pub use figures::{Entry, FiguresPage, Group, Panel};
pub use gallery::{Gallery, Picture, Strip};
pub use library::{LibraryPage, TITLE as LIBRARY_TITLE};
pub use study::{DevicePart, StudyPage};

use super::plot::DrawnChart;
use crate::error::Result;
use crate::study::TimeRecord;
use crate::study::agreement::AgreementRecord;
use crate::study::error::ErrorRecord;
use crate::study::exhibit::Table;
use crate::study::names::{is_unsafe_in_lines, with_replacements};
use crate::study::record::{DEFINITIONS, Provenance};
use crate::study::table::ComparedRow;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use ssct::gpu::DeviceInfo;
use std::path::PathBuf;

/// Everything that the page shows.
pub struct Page<'a> {
    /// Device that everything ran on.
    pub device: &'a DeviceInfo,
    /// The command that made the page.
    pub command: String,
    /// The parts that are still to be made, if the study has not ended.
    pub to_come: Vec<String>,
    /// Times.
    pub times: Times<'a>,
    /// Errors.
    pub errors: Errors<'a>,
    /// Pictures by view.
    pub views: &'a [Gallery],
    /// Figures of the thesis.
    pub figures: &'a [Picture],
    /// Comparisons of the methods' images on other devices with those on this device; empty if there is no other device.
    pub agreement: &'a [AgreementRecord],
    /// Records beside the page: a file or folder, relative to the page, and its content.
    pub records: Vec<(String, String)>,
}

/// The times that the page shows.
pub struct Times<'a> {
    /// One sentence: which views were timed, and how.
    pub settings: String,
    /// Rows of table 5.8.
    pub table: &'a [ComparedRow],
    /// The measurements behind the table.
    pub table_records: &'a [TimeRecord],
    /// The measurements of the views.
    pub view_records: &'a [TimeRecord],
    /// Plot of the views' times, SVG.
    pub plot: String,
}

/// The errors that the page shows.
pub struct Errors<'a> {
    /// One sentence: what was measured, and how.
    pub settings: String,
    /// The measurements.
    pub records: &'a [ErrorRecord],
    /// Run time against error.
    pub plots: Vec<DrawnChart>,
    /// Methods, references and error maps by view and roughness.
    pub pictures: Vec<Gallery>,
}

/// Parts of the page: id and title.
const PARTS: [(&str, &str); 8] = [
    ("views", "Pictures"),
    ("figures", "Figures of the thesis"),
    ("table", "Table 5.8"),
    ("stages", "Where the time goes"),
    ("error", "Run time against error"),
    ("passes", "Every pass"),
    ("drivers", "The same on other drivers"),
    ("records", "Raw records"),
];

impl Page<'_> {
    /// Returns the whole page as HTML. Its pictures are read from `folder`, in which the page will lie.
    pub fn render(&self, folder: &PictureFolder) -> Result<String> {
        let [views, figures, table, stages, error, passes, drivers, records] = PARTS.map(heading);
        let parts = PARTS.map(|(id, title)| (id.to_owned(), title));
        let body = html! {
            @if !self.to_come.is_empty() {
                p id="to-come" {
                    "This page is not complete. It is written again after each part, so that loading it again shows more. "
                    "Still to come: " (self.to_come.join("; ")) "."
                }
            }
            (views)
            p {
                "Drag the divider, or move it with the arrow keys. Pictures are embedded as JPEG of quality "
                (embed::JPEG_QUALITY) ", at most " (gallery::WIDEST) " pixels wide; each links to its lossless PNG at "
                "full size."
            }
            (gallery_list(self.views, folder)?)
            (figures) div.strip { (gallery::figures("Thesis", self.figures, folder)?) }
            (table) (sections::table_5_8(&self.times))
            (stages) p { (self.times.settings) }
            (sections::inline_svg(&self.times.plot, "Median time of each stage by view and method; \
                the tables under “Every pass” have the same times"))
            (error) (sections::errors(&self.errors))
            (gallery_list(&self.errors.pictures, folder)?)
            (passes)
            p { "Medians, minima and 95th percentiles over the samples; only the stages after the scene passes count." }
            (sections::passes(self.times.view_records))
            (drivers)
            @if self.agreement.is_empty() {
                p { "Vulkan lists no other device here that can be used." }
            } @else {
                (sections::table_with_text(&AgreementRecord::table(self.agreement)))
            }
            (records)
            ul { @for (file, what) in &self.records { li { a href=(file) { (file) } ": " (what) } } }
            (gallery::compare_template())
            script { (PreEscaped(include_str!("html/compare.js"))) }
        };
        let header =
            page_header("Glossy reflections in screen space", Some(self.device), DEFINITIONS, &self.command, &parts);
        Ok(assemble("study", &header, &body))
    }
}

/// Returns a page of tables, each under a heading with its title.
pub fn tables_page(title: &str, device: Option<&DeviceInfo>, command: &str, tables: &[Table]) -> String {
    let ids: Vec<_> = tables.iter().map(|table| (table.id.to_owned(), table.title.as_str())).collect();
    let body = html! {
        @for table in tables {
            (heading((table.id, &table.title)))
            (sections::table_with_text(table))
        }
    };
    assemble(title, &page_header(title, device, DEFINITIONS, command, &ids), &body)
}

/// Puts a page together from its title, its header and its body. Characters that a terminal would obey are removed.
fn assemble(title: &str, header: &Markup, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(title))
            body {
                (header)
                (body)
            }
        }
    };
    with_replacements(&page.into_string(), is_unsafe_in_lines).into_owned()
}

/// The header of a page: device, provenance, command, and links to the parts, each with its id and its title.
fn page_header(
    title: &str,
    device: Option<&DeviceInfo>,
    definitions: u32,
    command: &str,
    parts: &[(String, &str)],
) -> Markup {
    html! {
        header {
                h1 { (title) }
                dl {
                    @if let Some(d) = device {
                        dt { "Device" }
                        dd { (device_text(d)) }
                    }
                    dt { "Provenance" }
                    dd { "ssct " (Provenance::VERSION) ", commit " code { (Provenance::commit()) } ", definitions " (definitions) }
                    dt { "Command" }
                    dd { code { (command) } }
                }
                @if device.is_some_and(|d| d.kind == "CPU") {
                    p { "This device is a CPU: its times are the host's. Compare only ratios, and only within this page." }
                }
                nav aria-label="Parts of the page" {
                    ul { @for (id, title) in parts { li { a href={ "#" (id) } { (title) } } } }
                }
            }
    }
}

/// The text about a device: name, kind, version of Vulkan, and driver.
fn device_text(device: &DeviceInfo) -> String {
    format!("{} ({}, Vulkan {}, {})", device.name, device.kind, device.api, device.driver)
}

/// The head of a page, with the style sheet in it.
fn head(title: &str) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            title { "ssct " (title) }
            // Without this link, a browser asks the server for an icon.
            link rel="icon" href="data:,";
            style { (PreEscaped(include_str!("html/page.css"))) }
        }
    }
}

/// Names the cells of a study that a page lacks, if there are any.
fn missing_cells(missing: &[String]) -> Markup {
    html! {
        @if !missing.is_empty() {
            h2 id="missing" { "Missing cells" }
            p { "This page does not show the whole study. Cells that were not measured (" (missing.len()) "):" }
            ul { @for name in missing { li { (name) } } }
        }
    }
}

/// Returns the HTML `page` of a study with a list of missing cells below its header, or unchanged if none are missing.
pub fn with_missing_cells(page: &str, missing: &[String]) -> String {
    const END: &str = "</header>";
    let header_end = page.find(END).map_or(0, |offset| offset + END.len());
    format!("{}{}{}", &page[..header_end], missing_cells(missing).into_string(), &page[header_end..])
}

/// The results of a device, as text.
pub struct DeviceText {
    /// The name of the device.
    pub title: String,
    /// The results.
    pub text: String,
    /// The folder with the device's files, relative to the page.
    pub folder: PathBuf,
}

/// Returns a page with the results of several devices, each under a heading with the device's name.
pub fn devices_page(
    title: &str,
    definitions: u32,
    command: &str,
    devices: &[DeviceText],
    missing: &[String],
) -> String {
    let ids: Vec<_> =
        devices.iter().enumerate().map(|(n, d)| (format!("device-{}", n + 1), d.title.as_str())).collect();
    let body = html! {
        (missing_cells(missing))
        @for ((id, title), device) in ids.iter().zip(devices) {
            (heading((id, title)))
            p { "The files of this device: " a href=(device.folder.display()) { (device.folder.display()) } }
            div.scroll { pre { (device.text) } }
        }
    };
    assemble(title, &page_header(title, None, definitions, command, &ids), &body)
}

/// Returns the heading of a part of a page, to which links lead by its id.
fn heading((id, title): (&str, &str)) -> Markup {
    html! { h2 id=(id) { (title) } }
}

/// Returns galleries as HTML, one below the other.
fn gallery_list(galleries: &[Gallery], folder: &PictureFolder) -> Result<Markup> {
    let galleries = galleries.iter().map(|g| gallery::gallery(g, folder)).collect::<Result<Vec<_>>>()?;
    Ok(html! { @for gallery in galleries { (gallery) } })
}
