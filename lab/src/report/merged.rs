//! The files of a merged run. With one device they are those of the whole study run at once; with several, each
//! device's files lie in a folder of their own, so that no table, plot or comparison has times of two of them, and a
//! page shows the tables of each (docs/many-machines.md, "Merging").

use super::devices::{by_device, device_name};
use super::{files, html};
use crate::error::{Error, Result};
use crate::gpu::DeviceInfo;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Folder of the devices' folders.
pub const DEVICES: &str = "devices";

/// The page of a run.
const PAGE: &str = "index.html";

/// Records of one kind, and how a run of one device writes them.
pub struct MergedReport<'a, T> {
    /// The kind of study, which is also the stem of the records' file.
    pub kind: &'a str,
    /// The records.
    pub records: &'a [T],
    /// The device of a record.
    pub device: fn(&T) -> &DeviceInfo,
    /// Writes the files of a run of one device.
    pub write: &'a dyn Fn(&Path, &[T]) -> Result<()>,
    /// The tables of one device as text.
    pub text: &'a dyn Fn(&[T]) -> String,
    /// The command of the study.
    pub command: &'a str,
    /// The version of docs/definitions.md.
    pub definitions: u32,
    /// The cells that the study has and the records lack.
    pub missing: &'a [String],
}

impl<T: Serialize + Clone> MergedReport<'_, T> {
    /// Writes all files into a folder.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let apart = by_device(self.records, self.device);
        let json = format!("{}.json", self.kind);
        let [(device, records)] = &apart[..] else {
            files::write(&folder.join(&json), files::json(self.records).as_bytes())?;
            for (n, (_, records)) in apart.iter().enumerate() {
                (self.write)(&folder.join(device_folder(n)), records)?;
            }
            return self.page(folder, &apart);
        };
        (self.write)(folder, records)?;
        if self.missing.is_empty() {
            return Ok(());
        }
        // The missing cells are named on the study's own page; a study without a page gets one for them.
        let page = folder.join(PAGE);
        match std::fs::read_to_string(&page) {
            Ok(text) => files::write(&page, html::with_missing_cells(&text, self.missing).as_bytes()),
            Err(e) if e.kind() == ErrorKind::NotFound => self.page(folder, &[(device.clone(), records.clone())]),
            Err(e) => Err(Error::io("read", &page, e)),
        }
    }

    /// A page with the tables of each device.
    fn page(&self, folder: &Path, apart: &[(DeviceInfo, Vec<T>)]) -> Result<()> {
        let several = apart.len() > 1;
        let part = |(n, (device, records)): (usize, &(DeviceInfo, Vec<T>))| html::DeviceTables {
            title: device_name(device),
            text: (self.text)(records),
            folder: several.then(|| device_folder(n).to_string_lossy().into_owned()),
        };
        let parts: Vec<_> = apart.iter().enumerate().map(part).collect();
        let title = format!("Merged: {}", self.kind);
        let page = html::merged_page(&title, self.definitions, self.command, &parts, self.missing);
        files::write(&folder.join(PAGE), page.as_bytes())
    }
}

/// The folder of a device, counted from 0, in that of the run.
pub fn device_folder(device: usize) -> PathBuf {
    Path::new(DEVICES).join((device + 1).to_string())
}

/// Copies the files of some folders into one. Of several files of one name, the first is copied; with `same`, they must
/// all be equal.
///
/// # Errors
/// Errors of [`copy_file`].
pub fn copy_files(from: &[PathBuf], to: &Path, same: bool) -> Result<()> {
    let mut all: BTreeMap<OsString, Vec<PathBuf>> = BTreeMap::new();
    for folder in from {
        let entries = match std::fs::read_dir(folder) {
            Ok(entries) => entries,
            Err(e) if e.kind() == ErrorKind::NotFound => continue,
            Err(e) => return Err(Error::io("read", folder, e)),
        };
        for entry in entries {
            let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
            if let Some(name) = path.file_name().filter(|_| path.is_file()) {
                all.entry(name.to_owned()).or_default().push(path);
            }
        }
    }
    all.iter().try_for_each(|(name, paths)| copy_file(paths, &to.join(name), same))
}

/// Copies the first of some files that exists. With `same`, all that exist must be equal.
///
/// # Errors
/// [`Error::Io`] for what cannot be read or written, [`Error::Malformed`] for files that are not equal.
pub fn copy_file(from: &[PathBuf], to: &Path, same: bool) -> Result<()> {
    let read = |path: &PathBuf| std::fs::read(path).map_err(|e| Error::io("read", path, e));
    let mut there = from.iter().filter(|path| path.is_file());
    let Some(first) = there.next() else { return Ok(()) };
    let bytes = read(first)?;
    for other in there.filter(|_| same) {
        if read(other)? != bytes {
            return Err(Error::malformed(other, None, format!("is not the same as {}", first.display())));
        }
    }
    files::write(to, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Serialize)]
    struct Timed {
        device: DeviceInfo,
        ms: f64,
    }

    fn device(name: &str) -> DeviceInfo {
        DeviceInfo { name: name.into(), driver: "d".into(), api: "1.3".into(), kind: "CPU".into() }
    }

    fn written(records: &[Timed], missing: &[String], own_page: bool) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |folder: &Path, records: &[Timed]| {
            files::write(&folder.join("time.json"), files::json(records).as_bytes())?;
            if own_page { files::write(&folder.join(PAGE), b"<header></header><p>all</p>") } else { Ok(()) }
        };
        let text = |records: &[Timed]| records.iter().map(|r| format!("{} ms\n", r.ms)).collect::<String>();
        let report = MergedReport {
            kind: "time",
            records,
            device: |r| &r.device,
            write: &write,
            text: &text,
            command: "ssct time",
            definitions: 2,
            missing,
        };
        report.write(folder.path()).expect("written");
        folder
    }

    fn read(folder: &tempfile::TempDir, name: &str) -> String {
        std::fs::read_to_string(folder.path().join(name)).unwrap_or_default()
    }

    #[test]
    fn each_device_has_its_own_folder_and_table() {
        let of = |name: &str, ms| Timed { device: device(name), ms };
        let folder = written(&[of("x", 1.5), of("y", 2.5), of("x", 3.5)], &[], true);
        assert_eq!(read(&folder, "time.json").matches("\"ms\"").count(), 3);
        assert_eq!(read(&folder, "devices/1/time.json").matches("\"ms\"").count(), 2);
        assert_eq!(read(&folder, "devices/2/time.json").matches("\"ms\"").count(), 1);
        let page = read(&folder, PAGE);
        assert!(page.contains("1.5 ms\n3.5 ms") && page.contains("2.5 ms") && page.contains("devices/2"), "{page}");
    }

    #[test]
    fn a_page_says_which_cells_are_missing_and_one_device_has_its_files_in_place() {
        let one = [Timed { device: device("x"), ms: 1.5 }];
        let folder = written(&one, &[], false);
        assert!(read(&folder, "time.json").contains("1.5") && read(&folder, PAGE).is_empty());
        let missing = ["rooms & more".to_owned()];
        assert!(read(&written(&one, &missing, false), PAGE).contains("rooms &amp; more"));
        let page = read(&written(&one, &missing, true), PAGE);
        assert!(page.contains("<p>all</p>") && page.contains("rooms &amp; more"), "{page}");
    }

    #[test]
    fn of_files_of_one_name_the_first_is_copied_and_others_may_have_to_be_equal() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        for (path, text) in [("a/1", "one"), ("b/1", "other"), ("b/2", "two"), ("c/2", "two")] {
            files::write(&at(path), text.as_bytes()).expect("written");
        }
        copy_files(&[at("a"), at("none"), at("b")], &at("to"), false).expect("copied");
        assert_eq!(["to/1", "to/2"].map(|f| std::fs::read_to_string(at(f)).unwrap_or_default()), ["one", "two"]);
        copy_files(&[at("b"), at("c")], &at("same"), true).expect("equal");
        let refused = copy_files(&[at("a"), at("b")], &at("not"), true).expect_err("not equal").to_string();
        assert!(refused.contains("is not the same as"), "{refused}");
    }
}
