//! Finds the runs below a folder: every folder with records of the studies, whatever version wrote them. A folder that
//! cannot be read is returned with the reason.

use super::files;
use super::run_folder::{JOURNAL, is_finished};
use crate::error::{Error, Result};
use crate::study::compare;
use crate::study::library::changes::totals_only;
use crate::study::library::read::{self, KINDS, ReadRecord};
use crate::study::library::{DatedBy, LibraryRun, Measurement, Quantity, RecordFile, Setting};
use serde_json::Value as Json;
use ssct::gpu::DeviceInfo;
use ssct_scenes::inside::PathInFolder;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;
use time::{Date, OffsetDateTime};

/// The folder in which `ssct study` puts its records of errors, beside those of times.
const ERROR_FOLDER: &str = "error";

/// The file of a run's own page.
const PAGE: &str = "index.html";

/// The file with a run's raw samples of times.
const SAMPLES: &str = "time-samples.csv";

/// The runs that were found below a folder, and the folders without a run.
#[derive(Debug, Default)]
pub struct Library {
    /// Runs in the order of their dates; runs of one day are sorted by name.
    pub runs: Vec<LibraryRun>,
    /// Folders that should hold a run and cannot be read, each with the reason.
    pub unreadable: Vec<(String, String)>,
    /// Folders with files, none of which holds records.
    pub without_records: Vec<String>,
}

/// Reads every folder from a root down. Hidden folders and links to folders are not followed.
pub fn scan(root: &Path) -> Result<Library> {
    // A root that cannot be read is an error; a folder below it that cannot be read is part of the result.
    let inside = PathInFolder::folder(root);
    inside.list()?;
    let absolute_root = std::fs::canonicalize(root).map_err(|e| Error::io("read", root, e))?;
    let mut library = Library::default();
    let mut folders = list_folders(&inside, &mut library.unreadable);
    join_error_folders(&mut folders);
    // The page in the root is the page of the library, and belongs to no run.
    folders.entry(root.to_owned()).or_default().retain(|file| file.file_name().is_some_and(|n| n != PAGE));
    for (folder, files) in folders {
        let name = relative(root, &folder);
        let absolute = absolute_root.join(folder.strip_prefix(root).unwrap_or(&folder));
        match read_folder(&folder, &absolute, &name, &files) {
            FolderContent::Run(run) => library.runs.push(*run),
            FolderContent::Unreadable(why) => library.unreadable.push((name, why)),
            FolderContent::Nothing if files.is_empty() => {}
            FolderContent::Nothing => library.without_records.push(name),
        }
    }
    library.runs.sort_by(|a, b| (&a.date, &a.name).cmp(&(&b.date, &b.name)));
    Ok(library)
}

/// Returns every folder from a root down, each with its files. Folders that cannot be read are added to `unreadable`:
/// the path below the root, and the reason.
fn list_folders(root: &PathInFolder, unreadable: &mut Vec<(String, String)>) -> BTreeMap<PathBuf, Vec<PathBuf>> {
    let mut found = BTreeMap::new();
    let mut to_visit = vec![root.clone()];
    while let Some(folder) = to_visit.pop() {
        let entries = match folder.list() {
            Ok(entries) => entries,
            Err(e) => {
                unreadable.push((relative(&root.path(), &folder.path()), e.to_string()));
                continue;
            }
        };
        let (subfolders, others): (Vec<_>, Vec<_>) =
            entries.iter().filter(|entry| !entry.name.starts_with('.')).partition(|entry| entry.is_folder);
        to_visit.extend(subfolders.iter().map(|entry| folder.join(&entry.name)));
        let files = others.iter().map(|entry| folder.join(&entry.name).path());
        // Links to folders are not followed.
        found.insert(folder.path(), files.filter(|path| !path.is_dir()).collect());
    }
    found
}

/// Adds the files of each folder in which `ssct study` puts records of errors to the folder above it, which has the
/// times of the same run, and removes the former.
fn join_error_folders(folders: &mut BTreeMap<PathBuf, Vec<PathBuf>>) {
    let has = |files: Option<&Vec<PathBuf>>, name: &str| {
        files.is_some_and(|files| files.iter().any(|file| file.file_name().is_some_and(|n| n == name)))
    };
    let errors: Vec<PathBuf> =
        folders.keys().filter(|f| f.file_name().is_some_and(|n| n == ERROR_FOLDER)).cloned().collect();
    for folder in errors {
        let Some(parent) = folder.parent().map(Path::to_owned) else { continue };
        let is_one_run = has(folders.get(&parent), "time.json") && !has(folders.get(&parent), "error.json");
        if is_one_run && let Some(files) = folders.remove(&folder) {
            folders.entry(parent).or_default().extend(files);
        }
    }
}

/// The path of a folder from the root, with slashes between names; a point for the root itself.
fn relative(root: &Path, folder: &Path) -> String {
    let parts = folder.strip_prefix(root).unwrap_or(folder).components();
    let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
    if parts.is_empty() { ".".to_owned() } else { parts.join("/") }
}

/// The content of a folder.
enum FolderContent {
    Run(Box<LibraryRun>),
    /// The reason why a folder that should hold a run cannot be read.
    Unreadable(String),
    Nothing,
}

/// Reads every array of records among a folder's files, and the raw samples. `absolute` is the folder's path from the
/// root of the file system, in which a name may begin with the date. `name` is its path below the library's folder.
fn read_folder(folder: &Path, absolute: &Path, name: &str, files: &[PathBuf]) -> FolderContent {
    let mut found = FolderRecords::default();
    let (mut faults, mut notes) = (Vec::new(), Vec::new());
    for path in files.iter().filter(|path| path.extension().is_some_and(|e| e == "json")) {
        match read_records(path) {
            Ok(Some(content)) => found.add_file(&relative(folder, path), &content, &mut notes),
            Ok(None) => {}
            Err(why) => faults.push(why),
        }
    }
    let inside = PathInFolder::folder(folder);
    let unfinished = inside.join(JOURNAL).is_there() && !is_finished(&inside).unwrap_or(false);
    if found.files.is_empty() {
        return match (faults.is_empty(), unfinished) {
            (false, _) => FolderContent::Unreadable(faults.join("; ")),
            (true, true) => {
                FolderContent::Unreadable(format!("the run was not finished: there is a {JOURNAL}, and no records"))
            }
            (true, false) => FolderContent::Nothing,
        };
    }
    notes.extend(faults);
    if unfinished {
        notes.push(format!("the run was not finished, by its {JOURNAL}"));
    }
    let samples = read_samples(folder, name, &found).unwrap_or_else(|e| {
        notes.push(e.to_string());
        None
    });
    let (date, dated_by) = run_date(absolute, files);
    FolderContent::Run(Box::new(LibraryRun {
        name: name.to_owned(),
        date,
        dated_by,
        files: found.files,
        has_page: files.iter().any(|file| file.file_name().is_some_and(|n| n == PAGE)),
        programs: found.programs.into_iter().collect(),
        definitions: found.definitions.into_iter().collect(),
        devices: found.devices,
        measurements: found.measurements,
        stress: (found.stress[1] > 0).then_some(found.stress),
        samples,
        notes,
    }))
}

/// Reads the records of a file; `None` if it holds something else. That is an error if the file's name is that of a
/// kind of records.
fn read_records(path: &Path) -> std::result::Result<Option<Vec<Json>>, String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let must_hold_records = name.strip_suffix(".json").is_some_and(|kind| KINDS.contains(&kind));
    let content = PathInFolder::file(path)
        .bytes()
        .map_err(|e| e.to_string())
        .and_then(|bytes| serde_json::from_slice::<Json>(&bytes).map_err(|e| e.to_string()));
    match content {
        Ok(Json::Array(objects)) if read::are_records(&objects) => Ok(Some(objects)),
        Ok(_) if must_hold_records => Err(format!("{name} holds no records of the studies")),
        Err(why) if must_hold_records => Err(format!("{name}: {why}")),
        _ => Ok(None),
    }
}

/// The data of all records of a folder.
#[derive(Default)]
struct FolderRecords {
    files: Vec<RecordFile>,
    programs: BTreeSet<String>,
    definitions: BTreeSet<u32>,
    devices: Vec<DeviceInfo>,
    measurements: Vec<Measurement>,
    /// The index of each measurement, so that a measurement that several records have is added once.
    known: HashMap<MeasurementKey, usize>,
    /// Cases of the stress study that failed, and all cases.
    stress: [usize; 2],
}

/// The key of a measurement within a run: device, setting, view, method and quantity.
type MeasurementKey = (usize, Setting, String, String, Quantity);

impl FolderRecords {
    /// Adds the records of a file, and a note about records and figures that do not count. The kind of the first
    /// readable record is that of the file; a file without one is left out.
    fn add_file(&mut self, file: &str, records: &[Json], notes: &mut Vec<String>) {
        let (mut unreadable, mut contradictions) = (Vec::new(), 0);
        let mut first_kind = None;
        for json in records {
            match read::record(json) {
                Ok(record) => {
                    first_kind.get_or_insert_with(|| record.kind.clone());
                    contradictions += self.add_record(record);
                }
                Err(why) => unreadable.push(why),
            }
        }
        if let Some(first) = unreadable.first() {
            let (count, total) = (unreadable.len(), records.len());
            notes.push(format!("{count} of {total} records of {file} are left out; the first {first}"));
        }
        if contradictions > 0 {
            notes.push(format!(
                "{contradictions} figures of {file} are left out: another record has the same setup and another value"
            ));
        }
        if let Some(kind) = first_kind {
            self.files.push(RecordFile { file: file.to_owned(), kind, records: records.len() });
        }
    }

    /// Adds a record. Returns how many of its figures are left out, since an earlier record has them with another
    /// value.
    fn add_record(&mut self, record: ReadRecord) -> usize {
        let device = self.devices.iter().position(|d| *d == record.device).unwrap_or_else(|| {
            self.devices.push(record.device.clone());
            self.devices.len() - 1
        });
        self.programs.insert(record.program);
        self.definitions.insert(record.definitions);
        if let Some(passed) = record.passed {
            self.stress[0] += usize::from(!passed);
            self.stress[1] += 1;
        }
        let mut contradictions = 0;
        for measurement in record.measurements {
            let Measurement { setting, view, method, quantity, value, .. } = &measurement;
            let key = (device, setting.clone(), view.clone(), method.clone(), *quantity);
            match self.known.get(&key) {
                Some(index) => contradictions += usize::from(self.measurements[*index].value != *value),
                None => {
                    self.known.insert(key, self.measurements.len());
                    self.measurements.push(Measurement { device, ..measurement });
                }
            }
        }
        contradictions
    }
}

/// Reads the total times of a run's raw samples; `None` if it has no raw samples. `records` are those of the folder.
fn read_samples(folder: &Path, name: &str, records: &FolderRecords) -> Result<Option<compare::Run>> {
    let file = PathInFolder::folder(folder).join(SAMPLES);
    if file.open()?.is_none() {
        return Ok(None);
    }
    // The samples do not name their device, so it is known only if all records of the folder are from one device.
    let device = match &records.devices[..] {
        [only] => Some(only.clone()),
        _ => None,
    };
    let run = compare::Run { name: name.to_owned(), device, samples: files::read_samples(&file)? };
    Ok(Some(totals_only(run)))
}

/// Returns the date of a run. It is the date with which the name of its folder begins or, if there is none, that of the
/// nearest folder above. If no name begins with a date, it is the date of the run's newest file.
fn run_date(folder: &Path, files: &[PathBuf]) -> (String, DatedBy) {
    let names = folder.components().rev().filter_map(|part| match part {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    if let Some(date) = names.filter_map(leading_date).next() {
        return (date.to_string(), DatedBy::Folder);
    }
    let changed = files.iter().filter_map(|file| file.metadata().ok()?.modified().ok());
    let newest = changed.max().unwrap_or(SystemTime::UNIX_EPOCH);
    (OffsetDateTime::from(newest).date().to_string(), DatedBy::Files)
}

/// The date that a name begins with, as YYYY-MM-DD; `None` if it begins with no date of the calendar.
fn leading_date(name: &str) -> Option<Date> {
    let [year, month, day] = [(0, 4), (5, 7), (8, 10)].map(|(from, to)| name.get(from..to)?.parse::<u16>().ok());
    let dashes = name.get(4..5)? == "-" && name.get(7..8)? == "-";
    let month = time::Month::try_from(u8::try_from(month?).ok()?).ok()?;
    Date::from_calendar_date(year?.into(), month, u8::try_from(day?).ok()?).ok().filter(|_| dashes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_begins_with_a_date_or_has_none() {
        let date = |name: &str| leading_date(name).map(|d| d.to_string());
        assert_eq!(date("2026-11-24-lavapipe").as_deref(), Some("2026-11-24"));
        assert_eq!(date("2024-02-29").as_deref(), Some("2024-02-29"));
        for name in ["2025-02-29", "2026-13-01", "2026/11/24", "run-2026-11-24", "2026-11", "", "２０２６-11-24"] {
            assert_eq!(date(name), None, "{name}");
        }
    }
}
