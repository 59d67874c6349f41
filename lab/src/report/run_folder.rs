//! The folder of a run: only one run at a time uses it, and its journal says whether the last run in it was finished.

use crate::error::{Error, Result};
use crate::study::cell_list::CellList;
use crate::study::journal::{self, Journal};
use crate::study::merge::{Line, MergeInput};
use crate::study::names::json_text;
use ssct_scenes::inside::PathInFolder;
use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::Path;

/// The name of the journal's file, which has one entry in each line.
pub const JOURNAL: &str = "journal.jsonl";

/// The name of the file with the list of the run's cells.
pub const CELLS: &str = "cells.json";

/// The most samples that all results of a run together may have, if the run is to be read.
const MOST_SAMPLES: u64 = 100_000_000;

/// The last line of the journal once the run is finished.
const FINISHED: &str = "{\"finished\":true}";

/// True if the last line of a folder's journal says that its run was finished; false if there is no journal.
pub fn is_finished(folder: &PathInFolder) -> Result<bool> {
    let text = folder.join(JOURNAL).read()?.unwrap_or_default();
    Ok(String::from_utf8_lossy(&text).lines().next_back() == Some(FINISHED))
}

/// A folder that is reserved for one run while this value lives. However the run ends, the system releases the lock.
pub struct FolderClaim {
    folder: PathInFolder,
    _lock: File,
}

impl FolderClaim {
    /// Makes the folder if it is missing, checks that it can be written into, and locks it.
    ///
    /// # Errors
    /// [`Io`](ssct_ground::Error::Io) for a folder that cannot be made or written into, [`Error::Busy`] if another run has it.
    pub fn new(folder: &Path) -> Result<Self> {
        let inside = PathInFolder::folder(folder);
        inside.make()?;
        inside.check_writable()?;
        let lock = open_for_locking(folder).map_err(|e| Error::io("open", folder, e))?;
        match lock.try_lock() {
            // On a file system without locks, nothing keeps two runs apart.
            Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => {}
            Err(TryLockError::Error(e)) => return Err(Error::io("lock", folder, e)),
            Err(TryLockError::WouldBlock) => return Err(Error::Busy { folder: folder.to_owned() }),
            Ok(()) => {}
        }
        Ok(Self { folder: inside, _lock: lock })
    }

    /// Opens the folder's journal. If `resume` is true, the journal continues after the entries that the folder has;
    /// otherwise it begins anew.
    ///
    /// # Errors
    /// [`Error::Unfinished`] if it would begin anew over a run that was not finished, [`Io`](ssct_ground::Error::Io) for a file
    /// that cannot be read or written.
    pub fn journal(&self, resume: bool) -> Result<Journal> {
        let place = self.folder.join(JOURNAL);
        let text = place.read()?.unwrap_or_default();
        // A run that was killed while it wrote left a line without an end. This line is dropped.
        let length = text.iter().rposition(|b| *b == b'\n').map_or(0, |end| end + 1);
        let text = String::from_utf8_lossy(&text[..length]).into_owned();
        let unfinished = text.lines().next_back().is_some_and(|last| last != FINISHED);
        if !resume && unfinished {
            return Err(Error::Unfinished { folder: self.folder.path(), journal: place.path() });
        }
        if resume { self.continued_journal(length, &text) } else { self.new_journal() }
    }

    /// Makes a journal that begins anew, whatever the folder has.
    pub fn new_journal(&self) -> Result<Journal> {
        self.continued_journal(0, "")
    }

    /// Makes a journal that goes on after the first `bytes` bytes of its file, whose text is `known`. What follows them
    /// in the file is cut off.
    fn continued_journal(&self, bytes: usize, known: &str) -> Result<Journal> {
        let place = self.folder.join(JOURNAL);
        let mut file = place.append()?;
        file.set_len(bytes as u64).map_err(|e| Error::io("write", place.path(), e))?;
        let path = place.path();
        let sink =
            move |line: &str| file.write_all(format!("{line}\n").as_bytes()).map_err(|e| Error::io("write", &path, e));
        Ok(Journal::resume(known.lines(), Some(Box::new(sink))))
    }

    /// Writes the list of the run's cells.
    pub fn write_list(&self, cells: &CellList) -> Result<()> {
        let text = serde_json::to_string_pretty(cells)
            .map_err(|e| Error::io("write", self.folder.join(CELLS).path(), e.into()))?;
        Ok(self.folder.join(CELLS).write(json_text(&format!("{text}\n")).as_bytes())?)
    }

    /// Notes that the run is finished, so that the next run may begin anew.
    pub fn finish(&self) -> Result<()> {
        let place = self.folder.join(JOURNAL);
        let line = format!("{FINISHED}\n");
        place.append()?.write_all(line.as_bytes()).map_err(|e| Error::io("write", place.path(), e))
    }
}

/// Reads the folder of a run, which must have ended.
///
/// # Errors
/// [`Error::Busy`] if a run is going on in the folder, [`Io`](ssct_ground::Error::Io) for files that cannot be read,
/// [`Malformed`](ssct_ground::Error::Malformed) if the list of cells is missing or cannot be read.
pub fn read(folder: &Path) -> Result<MergeInput> {
    // Opening a pipe in place of a folder would wait for its other end.
    if !std::fs::metadata(folder).map_err(|e| Error::io("read", folder, e))?.is_dir() {
        return Err(Error::malformed(folder, None, "is no folder of a run"));
    }
    let _lock = match File::open(folder) {
        // The shared lock lets several processes read at once. A run that is going on is not noticed on a file system
        // without locks, or where a folder cannot be opened as a file.
        Ok(file) => match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => return Err(Error::Busy { folder: folder.to_owned() }),
            _ => Some(file),
        },
        Err(e) if e.kind() == ErrorKind::NotFound => return Err(Error::io("read", folder, e)),
        Err(_) => None,
    };
    let inside = PathInFolder::folder(folder);
    let Some(text) = inside.join(CELLS).read()? else {
        let what = "does not say which cells it has (no cells.json): it is no folder of a run that can be merged";
        return Err(Error::malformed(folder, None, what));
    };
    let wrong = |e: serde_json::Error| {
        Error::malformed(inside.join(CELLS).path(), Some(e.line()), format!("is no list of cells: {e}"))
    };
    let cells: CellList = serde_json::from_slice(&text).map_err(wrong)?;
    // Each result has as many samples as the settings say, so these settings decide how much would be read.
    let count = ["samples", "frames"].into_iter().filter_map(|name| cells.settings.get(name)?.as_u64()).max();
    let results = cells.cells.iter().map(|cell| cell.results.len() as u64).sum::<u64>().max(1);
    if let Some(count) = count.filter(|count| count.saturating_mul(results) > MOST_SAMPLES) {
        let message = format!(
            "its settings ask for {count} samples of each of {results} result(s); at most {MOST_SAMPLES} in all are read"
        );
        return Err(Error::malformed(inside.join(CELLS).path(), None, message));
    }
    let bytes = inside.join(JOURNAL).read()?.unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    let is_entry = |(_, line): &(usize, &str)| journal::key_of(line).is_some();
    let numbered = text.lines().enumerate().filter(is_entry);
    let lines = numbered.map(|(n, line)| Line { number: n + 1, text: line.to_owned() }).collect();
    Ok(MergeInput { folder: folder.to_owned(), cells, journal: Journal::resume(text.lines(), None), lines })
}

/// Returns the keys of all entries in a folder's journal.
pub fn keys(folder: &PathInFolder) -> Result<BTreeSet<String>> {
    let bytes = folder.join(JOURNAL).read()?.unwrap_or_default();
    Ok(String::from_utf8_lossy(&bytes).lines().filter_map(journal::key_of).collect())
}

/// Opens the folder itself for locking, which leaves no file behind.
#[cfg(unix)]
fn open_for_locking(folder: &Path) -> std::io::Result<File> {
    File::open(folder)
}

/// Opens a file in the folder for locking, since this system cannot lock a folder.
#[cfg(not(unix))]
fn open_for_locking(folder: &Path) -> std::io::Result<File> {
    PathInFolder::folder(folder).join(".ssct-lock").append().map_err(std::io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_at_a_time_has_a_folder_and_its_journal_goes_on_from_whole_lines() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("new/folder");
        let claim = FolderClaim::new(&path).expect("free");
        assert!(matches!(FolderClaim::new(&path), Err(Error::Busy { .. })));
        let mut journal = claim.journal(false).expect("empty");
        journal.put("a".into(), &1).expect("written");
        journal.put("b".into(), &2).expect("written");
        drop((journal, claim));

        // Killed in the middle of the third line.
        let file = path.join(JOURNAL);
        let mut text = std::fs::read(&file).expect("there");
        text.extend(b"{\"key\":\"c\",\"val");
        std::fs::write(&file, text).expect("written");
        let claim = FolderClaim::new(&path).expect("free again");
        let refused = claim.journal(false).err().expect("not over what was measured").to_string();
        assert!(refused.contains("was not finished"), "{refused}");
        let mut journal = claim.journal(true).expect("there");
        assert_eq!((journal.get("a"), journal.get("b"), journal.get::<u32>("c")), (Some(1), Some(2), None));
        journal.put("c".into(), &3).expect("written");
        claim.finish().expect("written");
        assert_eq!(claim.journal(true).expect("there").get("c"), Some(3), "a finished run may be gone on with");
        assert_eq!(claim.journal(false).expect("finished").get::<u32>("a"), None, "or begun anew");
        assert_eq!(std::fs::read_dir(&path).expect("there").count(), 1, "nothing else is left");
    }
}
