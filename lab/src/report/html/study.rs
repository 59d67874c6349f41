//! The page of a study: charts, tables and clips of each device, tables of figures over all devices, and the files beside the page.

use super::sections::{drawn_chart, table_with_text};
use super::{assemble, heading, missing_cells, page_header};
use crate::report::devices::device_name;
use crate::report::plot::DrawnChart;
use crate::study::exhibit::{ClipGroup, Table};
use maud::{Markup, PreEscaped, html};
use ssct::gpu::DeviceInfo;

/// Everything that the page shows.
pub struct StudyPage<'a> {
    /// The title of the page.
    pub title: &'a str,
    /// The version of the definitions.
    pub definitions: u32,
    /// The command of the whole study.
    pub command: &'a str,
    /// The results, device by device.
    pub devices: &'a [DevicePart],
    /// Tables of figures alone, over all devices.
    pub common: &'a [Table],
    /// The columns of the tables with their meanings.
    pub meanings: &'a [(String, &'static str)],
    /// Folders of files beside the page.
    pub folders: &'a [&'static str],
    /// The kind of study, by which its files are named.
    pub kind: &'a str,
    /// The cells that the study has and the page lacks.
    pub missing: &'a [String],
}

/// The results of one device.
pub struct DevicePart {
    /// The device.
    pub device: DeviceInfo,
    /// The folder with the device's files, relative to the page; `None` if they are beside the page.
    pub folder: Option<String>,
    /// The names of the files of the device's results, each with words that describe the file.
    pub files: Vec<(String, String)>,
    /// The device's charts.
    pub charts: Vec<DrawnChart>,
    /// The device's tables.
    pub tables: Vec<Table>,
    /// The device's clips.
    pub clips: Vec<ClipGroup>,
}

impl StudyPage<'_> {
    /// Returns the whole page as HTML.
    pub fn render(&self) -> String {
        let only_device = (self.devices.len() == 1).then(|| &self.devices[0].device);
        let title =
            |part: &DevicePart| if only_device.is_some() { "Results".to_owned() } else { device_name(&part.device) };
        let titles: Vec<String> = self.devices.iter().map(title).collect();
        let device_ids = titles.iter().enumerate().map(|(n, title)| (format!("device-{}", n + 1), title.as_str()));
        let common = self.common.iter().map(|table| (table.id.to_owned(), table.title.as_str()));
        let mut parts: Vec<_> = device_ids.chain(common).collect();
        parts.push(("records".to_owned(), "Raw records"));
        let body = html! {
            (missing_cells(self.missing))
            @if self.devices.len() > 1 {
                p { "Times of different devices are not compared: each device has its own charts and tables." }
            }
            @for ((id, title), part) in parts.iter().zip(self.devices) {
                (heading((id, title)))
                (device(part))
            }
            @for table in self.common {
                (heading((table.id, &table.title)))
                (table_with_text(table))
            }
            (heading(("records", "Raw records")))
            (self.records())
            @if self.devices.iter().any(|part| !part.clips.is_empty()) { script { (PreEscaped(TOGETHER)) } }
        };
        assemble(self.title, &page_header(self.title, only_device, self.definitions, self.command, &parts), &body)
    }

    /// Links to the files beside the page, and the meanings of the columns.
    fn records(&self) -> Markup {
        let has_device_folders = self.devices.len() > 1;
        // Without a device, or with several, these two alone lie beside the page; each device has its own in a folder.
        let common = [("json", "every record"), ("txt", "the tables, as text")];
        let common = common.map(|(ending, about)| (format!("{}.{ending}", self.kind), about.to_owned()));
        let files: &[(String, String)] = if let [only] = self.devices { &only.files } else { &common };
        html! {
            ul {
                @for (file, about) in files { li { a href=(file) { (file) } ": " (about) } }
                @for folder in self.folders.iter().filter(|_| !has_device_folders) {
                    li { a href=(folder) { (folder) } }
                }
            }
            @if !self.meanings.is_empty() {
                details {
                    summary { "What the columns mean" }
                    dl { @for (title, about) in self.meanings { dt { (title) } dd { (about) } } }
                }
            }
        }
    }
}

/// Returns the part of the page with the clips, the charts and the tables of a device.
fn device(part: &DevicePart) -> Markup {
    html! {
        @if let Some(folder) = &part.folder { p { "The files of this device: " a href=(folder) { (folder) } } }
        @for group in part.clips.iter().filter(|group| !group.clips.is_empty()) { (clips(group)) }
        @for chart in &part.charts { (drawn_chart(chart)) }
        @for table in &part.tables {
            @if !table.title.is_empty() { h3 { (table.title) } }
            (table_with_text(table))
        }
    }
}

/// Returns films or pictures beside each other; a group of films has a button that begins them together.
fn clips(group: &ClipGroup) -> Markup {
    let is_film = group.clips.iter().all(|clip| clip.file.ends_with(".webp"));
    let what = if is_film { "Film" } else { "Picture" };
    html! {
        section {
            h3 { (group.title) }
            @if is_film { button.together type="button" { "Begin together" } }
            div.strip {
                @for clip in &group.clips {
                    figure {
                        img src=(clip.file) alt={ (what) " of " (clip.name) ": " (group.title) } loading="lazy";
                        figcaption { b { (clip.name) } @if !clip.caption.is_empty() { ": " (clip.caption) } }
                    }
                }
            }
        }
    }
}

/// The script that restarts the films of a group together. An animated picture begins anew when it is loaded anew, so
/// the script fetches all files before it shows any of them.
const TOGETHER: &str = r#"
for (const button of document.querySelectorAll("button.together")) {
  button.addEventListener("click", async () => {
    const images = [...button.parentElement.querySelectorAll("img")];
    const blobs = await Promise.all(images.map(async (image) => {
      image.dataset.file ??= image.getAttribute("src");
      try { return await (await fetch(image.dataset.file)).blob(); } catch { return null; }
    }));
    images.forEach((image, n) => {
      image.src = blobs[n] ? URL.createObjectURL(blobs[n]) : image.dataset.file + "?" + Date.now();
    });
  });
}
"#;
