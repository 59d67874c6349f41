//! Copies of files that runs left, into the folder of the merged run.

use super::files;
use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

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
