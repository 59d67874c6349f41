//! The folder of a run: one run at a time, its journal, and whether the last run in it was finished.

use super::files;
use crate::error::{Error, Result};
use crate::study::cell_list::CellList;
use crate::study::journal::{self, Journal};
use crate::study::merge::MergeInput;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The journal's file, one entry a line.
pub const JOURNAL: &str = "journal.jsonl";

/// The file with the list of the run's cells.
pub const CELLS: &str = "cells.json";

/// Its last line once all is done.
const FINISHED: &str = "{\"finished\":true}";

/// Whether the last line of a journal says that its run was finished; false if the journal cannot be read.
pub fn is_finished(journal: &Path) -> bool {
    let text = std::fs::read(journal).unwrap_or_default();
    String::from_utf8_lossy(&text).lines().next_back() == Some(FINISHED)
}

/// A folder that is this run's alone for as long as this lives, however it ends: the system gives the lock
/// back.
pub struct Claim {
    folder: PathBuf,
    _lock: File,
}

impl Claim {
    /// Makes the folder if it is missing, sees whether it can be written into, and locks it.
    ///
    /// # Errors
    /// [`Error::Io`] for a folder that cannot be made or written into, [`Error::Busy`] if another run has it.
    pub fn new(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(|e| Error::io("create the folder", folder, e))?;
        tempfile::Builder::new()
            .prefix(".ssct-")
            .tempfile_in(folder)
            .map_err(|e| Error::io("write into", folder, e))?;
        let lock = lockable(folder).map_err(|e| Error::io("open", folder, e))?;
        match lock.try_lock() {
            // Where a file system has no locks, runs must keep apart by themselves.
            Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => {}
            Err(TryLockError::Error(e)) => return Err(Error::io("lock", folder, e)),
            Err(TryLockError::WouldBlock) => return Err(Error::Busy { folder: folder.to_owned() }),
            Ok(()) => {}
        }
        Ok(Self { folder: folder.to_owned(), _lock: lock })
    }

    /// The folder's journal: with `resume` it goes on from what the folder has, else it begins anew.
    ///
    /// # Errors
    /// [`Error::Unfinished`] if it would begin anew over a run that was not finished, [`Error::Io`] for a file
    /// that cannot be read or written.
    pub fn journal(&self, resume: bool) -> Result<Journal> {
        let path = self.folder.join(JOURNAL);
        let text = journal_bytes(&path)?;
        // A run that was killed while it wrote left a line without an end.
        let whole = text.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        let text = String::from_utf8_lossy(&text[..whole]).into_owned();
        let unfinished = text.lines().next_back().is_some_and(|last| last != FINISHED);
        if !resume && unfinished {
            return Err(Error::Unfinished { folder: self.folder.clone(), journal: path });
        }
        let failed = |e| Error::io("write", &path, e);
        let mut file =
            OpenOptions::new().create(true).append(true).open(&path).map_err(|e| Error::io("write", &path, e))?;
        file.set_len(if resume { whole as u64 } else { 0 }).map_err(failed)?;
        let known = if resume { text.as_str() } else { "" };
        let to = path.clone();
        let sink =
            move |line: &str| file.write_all(format!("{line}\n").as_bytes()).map_err(|e| Error::io("write", &to, e));
        Ok(Journal::resume(known.lines(), Some(Box::new(sink))))
    }

    /// Writes the list of the run's cells.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be written.
    pub fn list(&self, cells: &CellList) -> Result<()> {
        let text =
            serde_json::to_string_pretty(cells).map_err(|e| Error::io("write", self.folder.join(CELLS), e.into()))?;
        files::write(&self.folder.join(CELLS), format!("{text}\n").as_bytes())
    }

    /// Notes that the run is finished, so that the next may begin anew.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be written.
    pub fn finish(&self) -> Result<()> {
        let path = self.folder.join(JOURNAL);
        let mut file = OpenOptions::new().append(true).open(&path).map_err(|e| Error::io("write", &path, e))?;
        file.write_all(format!("{FINISHED}\n").as_bytes()).map_err(|e| Error::io("write", &path, e))
    }
}

/// Reads the folder of a run, which must have ended.
///
/// # Errors
/// [`Error::Busy`] if a run is going on in the folder, [`Error::Io`] for files that cannot be read,
/// [`Error::Malformed`] if the list of cells is missing or cannot be read.
pub fn read(folder: &Path) -> Result<MergeInput> {
    let _lock = match File::open(folder) {
        // Several processes may read at once. Without locks, or where a folder cannot be opened as a file, a run that
        // is going on is not noticed.
        Ok(file) => match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => return Err(Error::Busy { folder: folder.to_owned() }),
            _ => Some(file),
        },
        Err(e) if e.kind() == ErrorKind::NotFound => return Err(Error::io("read", folder, e)),
        Err(_) => None,
    };
    let path = folder.join(CELLS);
    let text = match std::fs::read(&path) {
        Ok(text) => text,
        Err(e) if e.kind() == ErrorKind::NotFound => {
            let what = "does not say which cells it has (no cells.json): it is no folder of a run that can be merged";
            return Err(Error::malformed(folder, None, what));
        }
        Err(e) => return Err(Error::io("read", &path, e)),
    };
    let cells = serde_json::from_slice(&text)
        .map_err(|e| Error::malformed(&path, Some(e.line()), format!("is no list of cells: {e}")))?;
    let bytes = journal_bytes(&folder.join(JOURNAL))?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().filter(|line| journal::key_of(line).is_some()).map(str::to_owned).collect();
    Ok(MergeInput { folder: folder.to_owned(), cells, journal: Journal::resume(text.lines(), None), lines })
}

/// The content of a journal's file; nothing if there is none.
fn journal_bytes(path: &Path) -> Result<Vec<u8>> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(bytes),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(e) => Err(Error::io("read", path, e)),
    }
}

/// What is locked: the folder itself, which leaves nothing behind.
#[cfg(unix)]
fn lockable(folder: &Path) -> std::io::Result<File> {
    File::open(folder)
}

/// What is locked: a file in it, where a folder cannot be.
#[cfg(not(unix))]
fn lockable(folder: &Path) -> std::io::Result<File> {
    OpenOptions::new().create(true).append(true).open(folder.join(".ssct-lock"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_one_runs_and_its_journal_goes_on_from_whole_lines() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("new/folder");
        let claim = Claim::new(&path).expect("free");
        assert!(matches!(Claim::new(&path), Err(Error::Busy { .. })));
        let mut journal = claim.journal(false).expect("empty");
        journal.put("a".into(), &1).expect("written");
        journal.put("b".into(), &2).expect("written");
        drop((journal, claim));

        // Killed in the middle of the third line.
        let file = path.join(JOURNAL);
        let mut text = std::fs::read(&file).expect("there");
        text.extend(b"{\"key\":\"c\",\"val");
        std::fs::write(&file, text).expect("written");
        let claim = Claim::new(&path).expect("free again");
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
