//! Reads and writes files inside a folder that the user named. The names inside the folder may come from strangers, for
//! example with a shard that somebody else measured. A name that leads out of the folder is refused, whether by `..`,
//! by a root or by a link. Only regular files of bounded size are read, and nothing is written through a link. All
//! files that the laboratory writes are written by this module.

use cap_fs_ext::{FollowSymlinks, OpenOptionsFollowExt, OpenOptionsSyncExt};
use cap_std::ambient_authority;
use cap_std::fs::{Dir, OpenOptions};
use ssct_ground::{Error, Result};
use std::fs::File;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{ErrorKind, Read, Result as IoResult, Write};
use std::path::{Component, Path, PathBuf};

/// Greatest size, in bytes, of a file that [`PathInFolder::read`] reads.
pub const MOST_BYTES: u64 = 1 << 30;

/// A file or a folder inside a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathInFolder {
    /// The folder that the user named, which is trusted.
    root: PathBuf,
    /// The path below `root`, which may come from a stranger; empty for `root` itself.
    name: PathBuf,
}

/// An entry in the list of a folder: a file or a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FolderEntry {
    /// Name of the entry.
    pub name: String,
    /// True if the entry is a regular file.
    pub is_file: bool,
    /// True if the entry is a folder, and no link to one.
    pub is_folder: bool,
}

impl PathInFolder {
    /// Makes the path of a folder that the user named.
    pub fn folder(root: impl AsRef<Path>) -> Self {
        Self { root: root.as_ref().to_owned(), name: PathBuf::new() }
    }

    /// Makes the path of a file that the user named; its root is the folder of the file.
    pub fn file(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref();
        match (path.parent(), path.file_name()) {
            (Some(root), Some(name)) => Self { root: root.to_owned(), name: name.into() },
            _ => Self::folder(path),
        }
    }

    /// Makes the path of a file or folder below this one.
    #[must_use]
    pub fn join(&self, name: impl AsRef<Path>) -> Self {
        // Root and name are kept apart, so that an absolute name cannot replace the root.
        Self { root: self.root.clone(), name: self.name.join(name) }
    }

    /// Returns the path of the file or folder, for messages.
    pub fn path(&self) -> PathBuf {
        if self.name.as_os_str().is_empty() { self.root.clone() } else { self.root.join(&self.name) }
    }

    /// Reads a regular file of at most [`MOST_BYTES`]; `None` if it does not exist.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read, [`Error::Malformed`] if it is no regular file, is too large, or leads
    /// out of the folder.
    pub fn read(&self) -> Result<Option<Vec<u8>>> {
        let Some(file) = self.open()? else { return Ok(None) };
        let mut bytes = Vec::new();
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(|e| self.io_error("read", e))?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(self.malformed(&format!("is too large; at most {MOST_BYTES} bytes are read")));
        }
        Ok(Some(bytes))
    }

    /// Reads a regular file that must exist.
    ///
    /// # Errors
    /// The errors of [`PathInFolder::read`], and [`Error::Io`] if the file does not exist.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        self.read()?.ok_or_else(|| self.io_error("read", ErrorKind::NotFound.into()))
    }

    /// Opens a regular file; `None` if it does not exist.
    ///
    /// # Errors
    /// The errors of [`PathInFolder::read`], except the one for its size.
    pub fn open(&self) -> Result<Option<File>> {
        let opened = self.within(false, |folder, name| {
            // The kind of the file is checked first, since opening a device may have an effect. If a pipe replaces the
            // file after this check, it is opened without waiting for a writer.
            if !folder.metadata(name)?.is_file() {
                return Ok(None);
            }
            folder.open_with(name, OpenOptions::new().read(true).nonblock(true)).map(Some)
        });
        match opened {
            Ok(Some(file)) if file.metadata().is_ok_and(|metadata| metadata.is_file()) => Ok(Some(file.into_std())),
            Ok(_) => Err(self.malformed("is no file; only regular files are read")),
            Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e),
        }
    }

    /// Returns true if this is a regular file that exists and can be opened.
    pub fn is_there(&self) -> bool {
        self.open().is_ok_and(|file| file.is_some())
    }

    /// Lists the files and folders in this folder, sorted by name; the list is empty if the folder does not exist.
    ///
    /// # Errors
    /// [`Error::Io`] if the folder cannot be read, [`Error::Malformed`] if it leads out of its folder. A name
    /// inside it that is no text gives [`Error::Io`].
    pub fn list(&self) -> Result<Vec<FolderEntry>> {
        let read_entries = |folder: &Dir, name: &Path| -> IoResult<Vec<FolderEntry>> {
            let to_entry = |entry: IoResult<cap_std::fs::DirEntry>| {
                let entry = entry?;
                let kind = entry.file_type()?;
                let name = entry.file_name().into_string();
                let name = name.map_err(|name| std::io::Error::other(format!("the name {name:?} is no text")))?;
                Ok(FolderEntry { name, is_file: kind.is_file(), is_folder: kind.is_dir() })
            };
            folder.read_dir(if name.as_os_str().is_empty() { Path::new(".") } else { name })?.map(to_entry).collect()
        };
        match self.within(false, read_entries) {
            Ok(mut entries) => {
                entries.sort_by(|a, b| a.name.cmp(&b.name));
                Ok(entries)
            }
            Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            Err(e) => Err(e),
        }
    }

    /// Writes `bytes` to the file completely or not at all: a temporary file in the same folder is written first, and
    /// then renamed. A missing folder is made. A link with the file's name is replaced, and not followed.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be written, [`Error::Malformed`] if it leads out of the folder.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        let temporary = self.name.with_file_name(temporary_name());
        self.within(true, |folder, name| {
            create_folders(folder, name.parent())?;
            let write_and_rename = || {
                let mut file = folder.open_with(&temporary, OpenOptions::new().write(true).create_new(true))?;
                file.write_all(bytes)?;
                folder.rename(&temporary, folder, name)
            };
            write_and_rename().inspect_err(|_| drop(folder.remove_file(&temporary)))
        })
    }

    /// Opens a file to append to it; a missing file is made.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be written, [`Error::Malformed`] if it is a link or no regular file.
    pub fn append(&self) -> Result<File> {
        let is_link =
            |folder: &Dir, name: &Path| Ok(folder.symlink_metadata(name).is_ok_and(|metadata| metadata.is_symlink()));
        if self.within(true, is_link)? {
            return Err(self.malformed("is a link, which is not followed"));
        }
        let file = self.within(true, |folder, name| {
            let mut options = OpenOptions::new();
            options.create(true).append(true).nonblock(true).follow(FollowSymlinks::No);
            folder.open_with(name, &options)
        })?;
        if !file.metadata().is_ok_and(|metadata| metadata.is_file()) {
            return Err(self.malformed("is no file; only regular files are written"));
        }
        Ok(file.into_std())
    }

    /// Makes the folder, if it does not exist.
    ///
    /// # Errors
    /// [`Error::Io`] if the folder cannot be made, [`Error::Malformed`] if it leads out of its folder.
    pub fn make(&self) -> Result<()> {
        self.within(true, |folder, name| create_folders(folder, Some(name)))
    }

    /// Checks that files can be written into the folder, by making a temporary file there and removing it.
    ///
    /// # Errors
    /// [`Error::Io`] if no file can be written.
    pub fn check_writable(&self) -> Result<()> {
        let outcome = self.join(temporary_name()).within(true, |folder, name| {
            folder.open_with(name, OpenOptions::new().write(true).create_new(true))?;
            folder.remove_file(name)
        });
        outcome.map_err(|e| match e {
            Error::Io { source, .. } => Error::io("write into", self.path(), source),
            other => other,
        })
    }

    /// Calls `act` with the opened root folder and the name below it. If `is_writing` is true, a missing root is made
    /// first, and errors speak of writing, not of reading.
    fn within<T>(&self, is_writing: bool, act: impl FnOnce(&Dir, &Path) -> IoResult<T>) -> Result<T> {
        let stays_inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        if !self.name.components().all(stays_inside) {
            return Err(self.malformed("leads out of its folder"));
        }
        let action = if is_writing { "write" } else { "read" };
        let root = if self.root.as_os_str().is_empty() { Path::new(".") } else { &self.root };
        if is_writing {
            std::fs::create_dir_all(root).map_err(|e| Error::io("create the folder", root, e))?;
        }
        let folder = Dir::open_ambient_dir(root, ambient_authority()).map_err(|e| Error::io(action, root, e))?;
        act(&folder, &self.name).map_err(|e| self.io_error(action, e))
    }

    /// Makes an error about this file or folder from a message.
    fn malformed(&self, message: &str) -> Error {
        Error::malformed(self.path(), None, message)
    }

    /// Makes an error about this file or folder from an error `e` during `action`, such as "read".
    fn io_error(&self, action: &'static str, e: std::io::Error) -> Error {
        // A path that leads out of the folder is refused by the library itself, so that the error has no number of the
        // system.
        if e.kind() == ErrorKind::PermissionDenied && e.raw_os_error().is_none() {
            return self.malformed("is a link that leads out of its folder, which is not followed");
        }
        Error::io(action, self.path(), e)
    }
}

/// Makes the folder `name` below `folder`, and all folders between them. No name, or an empty one, means `folder`
/// itself, which exists.
fn create_folders(folder: &Dir, name: Option<&Path>) -> IoResult<()> {
    let Some(name) = name.filter(|name| !name.as_os_str().is_empty()) else { return Ok(()) };
    folder.create_dir_all(name).or_else(|e| match e.kind() {
        // Something that is no folder may have the name, or a link to a folder. Opening it as a folder gives the right
        // error, or none.
        ErrorKind::AlreadyExists => folder.open_dir(name).map(drop),
        _ => Err(e),
    })
}

/// Makes a random name for a temporary file, which no other file is expected to have.
fn temporary_name() -> String {
    format!(".ssct-{:016x}", RandomState::new().build_hasher().finish())
}

impl From<&Path> for PathInFolder {
    fn from(path: &Path) -> Self {
        Self::file(path)
    }
}

impl From<&PathBuf> for PathInFolder {
    fn from(path: &PathBuf) -> Self {
        Self::file(path)
    }
}

impl From<&PathInFolder> for PathInFolder {
    fn from(place: &PathInFolder) -> Self {
        place.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the message of an error; empty if there is no error.
    fn message<T>(outcome: Result<T>) -> String {
        outcome.err().map(|e| e.to_string()).unwrap_or_default()
    }

    /// Returns the names of a folder's entries.
    fn names(folder: &PathInFolder) -> Vec<String> {
        folder.list().expect("a folder").into_iter().map(|entry| entry.name).collect()
    }

    #[test]
    fn files_are_written_whole_and_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let inside = PathInFolder::folder(folder.path()).join("new");
        assert_eq!((names(&inside), inside.join("a").read().expect("none")), (Vec::new(), None));
        for text in ["one", "another"] {
            inside.join("b/a.txt").write(text.as_bytes()).expect("written");
            assert_eq!(inside.join("b").join("a.txt").bytes().expect("there"), text.as_bytes());
        }
        assert_eq!(names(&inside.join("b")), ["a.txt"], "nothing else is left");
        inside
            .join("log")
            .append()
            .and_then(|mut log| log.write_all(b"1").map_err(|e| Error::io("write", "log", e)))
            .expect("1");
        inside
            .join("log")
            .append()
            .and_then(|mut log| log.write_all(b"2").map_err(|e| Error::io("write", "log", e)))
            .expect("2");
        assert_eq!(inside.join("log").bytes().expect("there"), b"12");
        assert!(message(inside.join("b").bytes()).contains("is no file"));
        assert!(message(inside.join("none").bytes()).contains("cannot read"));
        inside.check_writable().expect("it is");
        assert_eq!(names(&inside), ["b", "log"]);
    }

    #[test]
    fn names_that_lead_out_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("outside"), "kept").expect("written");
        let inside = PathInFolder::folder(folder.path().join("in"));
        inside.make().expect("made");
        let absolute = folder.path().join("outside");
        for name in [Path::new("../outside"), Path::new("a/../../outside"), &absolute, Path::new("..")] {
            let place = inside.join(name);
            for outcome in [place.write(b"x"), place.read().map(drop), place.append().map(drop), place.list().map(drop)]
            {
                assert!(message(outcome).contains("leads out of its folder"), "{name:?}");
            }
        }
        assert_eq!(std::fs::read(absolute).expect("there"), b"kept");
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_nowhere_else_and_devices_are_not_opened() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let (root, outside) = (folder.path().join("in"), folder.path().join("outside"));
        std::fs::create_dir(&root).expect("made");
        std::fs::write(&outside, "kept").expect("written");
        let inside = PathInFolder::folder(&root);
        inside.join("own").write(b"own").expect("written");
        for (to, name) in
            [("../outside", "link"), ("..", "folder"), ("/dev/zero", "device"), ("own", "within"), ("none", "broken")]
        {
            symlink(to, root.join(name)).expect("a link");
        }
        for name in ["link", "folder/outside", "device"] {
            assert!(message(inside.join(name).bytes()).contains("leads out of its folder"), "{name}");
        }
        assert_eq!(inside.join("within").bytes().expect("a link that stays"), b"own");
        assert!(message(inside.join("folder/new").write(b"x")).contains("leads out of its folder"));
        for name in ["link", "within", "broken"] {
            let refusal = message(inside.join(name).append());
            assert!(refusal.contains("link"), "{name}: {refusal}");
        }
        // Writing replaces a link by a file.
        inside.join("link").write(b"new").expect("written");
        assert_eq!(
            (std::fs::read(&outside).expect("there"), inside.join("link").bytes().expect("there")),
            (b"kept".to_vec(), b"new".to_vec())
        );
        assert!(!root.join("link").is_symlink() && !folder.path().join("new").exists());
        let listed = inside.list().expect("a folder");
        assert!(
            listed.iter().filter(|entry| entry.is_file).map(|entry| entry.name.as_str()).eq(["link", "own"]),
            "{listed:?}"
        );
    }
}
