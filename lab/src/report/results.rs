//! Makes the files, tables and page of a study from its rows and their columns. With one device, the files lie in the
//! folder of the run. With several, each device has a folder of its own, so that no table, chart or comparison mixes
//! times of two devices. One page shows all devices (docs/many-machines.md, "Merging").

use super::devices::{by_device, device_name};
use super::html::{DevicePart, StudyPage};
use super::images::{Rgb, write_exr};
use super::plot::{self, DrawnChart};
use super::{clips, files, tables};
use crate::study::cell_list::CellList;
use crate::study::columns::Columns;
use crate::study::engine::Row;
use crate::study::exhibit::{Content, ExtraFile, Sheet, Table};
use ssct::gpu::{DeviceInfo, Pixels};
use ssct_ground::{Error, Result};
use ssct_scenes::inside::PathInFolder;
use std::path::{Path, PathBuf};

/// The folder that holds the folders of the devices.
const DEVICES: &str = "devices";

/// The folder of a device, counted from 0, inside the folder of the run.
pub fn device_folder(device: usize) -> PathBuf {
    Path::new(DEVICES).join((device + 1).to_string())
}

/// The rows of a run.
pub struct Results<'a, R> {
    /// The rows.
    pub rows: &'a [R],
    /// The cells of the run, with its settings and the command of the whole study.
    pub list: &'a CellList,
    /// The names of the cells that the study has and the rows lack.
    pub missing: &'a [String],
}

impl<R: Row> Results<'_, R> {
    /// Returns the records as a JSON array.
    pub fn json(&self) -> String {
        files::json(self.rows)
    }

    /// Returns the tables for a terminal: those of each device, and then the tables over all devices.
    pub fn text(&self) -> String {
        let device_text =
            |(device, rows): &(DeviceInfo, Vec<R>)| format!("{}\n{}", device_name(device), self.tables_text(rows));
        let by_device: String = by_device(self.rows, |r| &r.program().device).iter().map(device_text).collect();
        let common = tables::text(&R::common_tables(self.rows));
        if common.is_empty() { by_device } else { format!("{by_device}\n{common}") }
    }

    /// Returns the tables of one device's rows for a terminal.
    fn tables_text(&self, rows: &[R]) -> String {
        tables::text(&R::tables(rows, &self.list.settings))
    }

    /// Writes every file into the folder of the run. Files of one device lie there; each of several devices has a
    /// folder of its own with a page, and the folder of the run has the page and the records of all of them.
    pub fn write(&self, folder: &PathInFolder) -> Result<()> {
        let devices = by_device(self.rows, |r| &r.program().device);
        let mut parts = Vec::new();
        for (n, (device, rows)) in devices.iter().enumerate() {
            let target = if devices.len() > 1 { folder.join(device_folder(n)) } else { folder.clone() };
            let mut part = self.device_part(&target, device, rows)?;
            part.files = self.write_device_files(&target, rows, &part)?;
            if devices.len() > 1 {
                target.join(PAGE).write(self.page(rows, std::slice::from_ref(&part)).as_bytes())?;
                // On the page of all devices, the paths of clips begin with the device's folder.
                let place = device_folder(n).to_string_lossy().replace('\\', "/");
                let clips = part.clips.iter_mut().flat_map(|group| &mut group.clips);
                clips.for_each(|clip| clip.file = format!("{place}/{}", clip.file));
                part.folder = Some(place);
            }
            parts.push(part);
        }
        if devices.len() != 1 {
            folder.join(format!("{}.json", R::KIND)).write(self.json().as_bytes())?;
            folder.join(format!("{}.txt", R::KIND)).write(self.text().as_bytes())?;
        }
        folder.join(PAGE).write(self.page(self.rows, &parts).as_bytes())
    }

    /// Makes the charts, the tables and the clips of one device, whose files lie in `folder`. Clips without a file are
    /// left out.
    fn device_part(&self, folder: &PathInFolder, device: &DeviceInfo, rows: &[R]) -> Result<DevicePart> {
        let failed = |e: String| Error::io("draw the charts of", folder.path(), std::io::Error::other(e));
        let mut clips = R::clips(rows);
        // An interrupted run may lack the pictures of rows that it measured.
        clips.iter_mut().for_each(|group| group.clips.retain(|clip| folder.join(&clip.file).is_there()));
        let charts = plot::draw_charts(rows).map_err(failed)?;
        let tables = R::tables(rows, &self.list.settings);
        Ok(DevicePart { device: device.clone(), folder: None, files: Vec::new(), charts, tables, clips })
    }

    /// Writes the files of one device except the page. Returns the name of each file that the page links, with words that
    /// describe the file. Charts stand in the page itself.
    fn write_device_files(
        &self,
        folder: &PathInFolder,
        rows: &[R],
        part: &DevicePart,
    ) -> Result<Vec<(String, String)>> {
        for DrawnChart { chart, svg } in &part.charts {
            folder.join(format!("{}.svg", chart.stem)).write(svg.as_bytes())?;
        }
        let mut linked = Vec::new();
        let mut write = |name: String, about: &str, text: &str| -> Result<()> {
            folder.join(&name).write(text.as_bytes())?;
            linked.push((name, about.to_owned()));
            Ok(())
        };
        for (stem, rows) in R::files(rows) {
            write(format!("{stem}.json"), "every record", &files::json(&rows))?;
        }
        for sheet in declared_sheets(rows).into_iter().chain(R::sheets(rows)) {
            write(sheet.file, &sheet.about, &files::csv(&sheet.cells))?;
        }
        let tables: Vec<Table> = part.tables.iter().cloned().chain(R::common_tables(rows)).collect();
        let device = rows.first().map(|r| device_name(&r.program().device)).unwrap_or_default();
        let text = format!("{device}\n{}", tables::text(&tables));
        write(format!("{}.txt", R::KIND), "the tables, as text", &text)?;
        write(format!("{}.md", R::KIND), "the tables, as Markdown", &tables::markdown(&tables))?;
        Ok(linked)
    }

    /// Returns the page of some rows, with a part for each device.
    fn page(&self, rows: &[R], parts: &[DevicePart]) -> String {
        let page = StudyPage {
            title: R::TITLE,
            definitions: self.list.definitions,
            command: &self.list.command,
            devices: parts,
            common: &R::common_tables(rows),
            meanings: &meanings::<R>(),
            folders: R::FOLDERS,
            kind: R::KIND,
            missing: self.missing,
        };
        page.render()
    }
}

/// The name of the page's file.
pub const PAGE: &str = "index.html";

/// Makes the CSV files that the columns of rows declare. One file has a line for each row. If rows have a series, a second
/// file has a line for each item of the series, such as a frame of a film.
fn declared_sheets<R: Row>(rows: &[R]) -> Vec<Sheet> {
    let declared = R::columns();
    let named: Vec<_> = declared.columns.iter().filter(|c| !c.name.is_empty()).collect();
    let header = || named.iter().map(|c| c.name.clone());
    let row_cells = |row: &R| named.iter().map(|c| c.written(row)).collect::<Vec<_>>();
    let cells = std::iter::once(header().collect()).chain(rows.iter().map(row_cells)).collect();
    let mut sheets = vec![Sheet { file: format!("{}.csv", R::KIND), about: "a row for each record".to_owned(), cells }];
    if let Some(series) = &declared.series {
        // The column of an item's number has the name of the series without its s: `frame` for `frames`.
        let item = series.name.trim_end_matches('s').to_owned();
        // No two columns have one name: for a film, `flip` is the mean, and `frame_flip` the value of a frame.
        let row_names: Vec<String> = header().collect();
        let unique_name =
            |name: &String| if row_names.contains(name) { format!("{item}_{name}") } else { name.clone() };
        let item_names: Vec<String> = series.names.iter().map(unique_name).collect();
        let mut cells = vec![[row_names, vec![item], item_names].concat()];
        for row in rows {
            let items = (series.items)(row).into_iter().enumerate();
            cells
                .extend(items.map(|(n, item)| row_cells(row).into_iter().chain([n.to_string()]).chain(item).collect()));
        }
        let about = format!("a row for each of the {} of each record", series.name);
        sheets.push(Sheet { file: format!("{}-{}.csv", R::KIND, series.name), about, cells });
    }
    sheets
}

/// Returns the titles and explanations of the columns that have both.
fn meanings<R: Columns>() -> Vec<(String, &'static str)> {
    let columns = R::columns().columns.into_iter();
    let explained = columns.filter(|c| !c.title.is_empty() && !c.about.is_empty());
    explained.map(|c| (c.title, c.about.trim())).collect()
}

/// Writes a file that a measurement made beside its record into the folder of the run.
///
/// # Errors
/// [`Io`](ssct_ground::Error::Io) if it cannot be written, and for a film that is too large for its format.
pub fn write_extra_file(folder: &PathInFolder, file: &ExtraFile) -> Result<()> {
    let path = folder.join(&file.path);
    match &file.content {
        Content::Picture([width, height], bytes) => {
            Rgb { width: *width, height: *height, bytes: bytes.clone() }.write_png(&path)
        }
        Content::Map([width, height], values, name) => {
            let pixels = Pixels { width: *width, height: *height, channels: 1, values: values.clone() };
            write_exr(&path, &pixels, &[name])
        }
        Content::Film(film, frames_per_second) => {
            let encoded = clips::encode_animation(film, *frames_per_second);
            path.write(&encoded.map_err(|e| Error::io("encode", path.path(), std::io::Error::other(e)))?)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::columns::{columns, figure, part, series};
    use crate::study::record::Provenance;
    use serde_json::Value;

    columns! {
        /// A frame.
        struct Frame {
            /// Error of the frame.
            pub error: f64 = figure(""),
        }
    }

    columns! {
        /// A device that a row was measured on.
        struct Measured {
            /// Number of the row.
            pub number: u32 = figure("number"),
        }
    }

    columns! {
        /// A row with frames.
        struct Film {
            #[serde(flatten)]
            pub program: Provenance,
            #[serde(flatten)]
            pub measured: Measured = part(),
            pub frames: Vec<Frame> = series(),
        }
    }

    impl Row for Film {
        const KIND: &'static str = "film";
        const TITLE: &'static str = "Films";

        fn program(&self) -> &Provenance {
            &self.program
        }

        fn sheets(_: &[Self]) -> Vec<Sheet> {
            vec![Sheet { file: "more.csv".into(), about: "a row for nothing".into(), cells: Vec::new() }]
        }

        fn files(rows: &[Self]) -> Vec<(&'static str, Vec<Self>)> {
            vec![("film", rows.to_vec()), ("other", Vec::new())]
        }
    }

    /// Makes a row that a device of some name measured.
    fn row(device: &str) -> Film {
        let [name, text] = [device, ""].map(str::to_owned);
        let device = DeviceInfo { name, driver: text.clone(), api: text.clone(), kind: text.clone() };
        let program = Provenance { definitions: 3, version: text.clone(), commit: text, device };
        Film { program, measured: Measured { number: 1 }, frames: vec![Frame { error: 0.5 }] }
    }

    /// Returns the names of the files in a folder, without folders, and the names of those files that its page links.
    fn files_and_links(folder: &Path) -> [Vec<String>; 2] {
        let page = std::fs::read_to_string(folder.join(PAGE)).expect("a page");
        let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
        let files = entries.filter(|entry| entry.path().is_file());
        let mut names: Vec<String> = files.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.retain(|name| name != PAGE);
        names.sort_unstable();
        let links = page.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next());
        let mut linked: Vec<String> = links.filter(|link| link.contains('.')).map(str::to_owned).collect();
        linked.sort_unstable();
        [names, linked]
    }

    #[test]
    fn a_page_links_every_file_of_its_results_and_no_other() {
        let list = CellList {
            kind: Film::KIND.to_owned(),
            definitions: 3,
            version: String::new(),
            commit: String::new(),
            command: "a command".to_owned(),
            shard: None,
            settings: Value::Null,
            scenes: Vec::new(),
            devices: Vec::new(),
            cells: Vec::new(),
        };
        let written = |devices: [&str; 2]| {
            let (folder, rows) = (tempfile::tempdir().expect("a folder"), devices.map(row));
            let results = Results { rows: &rows, list: &list, missing: &[] };
            results.write(&PathInFolder::folder(folder.path())).expect("files");
            folder
        };
        let of_device = ["film-frames.csv", "film.csv", "film.json", "film.md", "film.txt", "more.csv", "other.json"];
        assert_eq!(files_and_links(written(["a", "a"]).path()), [of_device; 2]);
        let several = written(["a", "b"]);
        assert_eq!(files_and_links(several.path()), [["film.json", "film.txt"]; 2]);
        for device in 0..2 {
            assert_eq!(files_and_links(&several.path().join(device_folder(device))), [of_device; 2]);
        }
    }
}
