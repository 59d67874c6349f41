//! Decides of which files a user's shader may consist: files of the method's folder, files below folders that the user
//! allows, and the project's own shaders. The depth, the number and the size of includes are bounded.

use super::built_in;
use ssct_ground::{Error, Result};
use ssct_scenes::source_text;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The most bytes of a file, and of all includes of a shader together.
pub const MAX_BYTES: u64 = 1 << 24;

/// Greatest depth of includes within includes.
const MOST_DEPTH: usize = 64;

/// Greatest number of includes of a shader; a file that is included twice counts twice.
const MOST_INCLUDES: usize = 4096;

/// Folders that the user allows besides that of the method.
static ALLOWED: OnceLock<Vec<PathBuf>> = OnceLock::new();

/// Allows shaders and includes below some folders. Only the first call has an effect.
pub fn allow(folders: Vec<PathBuf>) {
    ALLOWED.get_or_init(|| folders);
}

/// The includes of one shader, as the compiler asks for them.
pub struct Includes<'a> {
    /// The folder of the method.
    folder: &'a Path,
    /// The folder for includes that are not beside the file that includes them.
    include_folder: &'a Path,
    /// The includes that are being read, the outermost first, each by the compiler's name for it and by its whole path.
    open: Vec<(PathBuf, PathBuf)>,
    /// The size of all includes so far.
    bytes: u64,
    /// The shader and every file that was included.
    files: Vec<PathBuf>,
    /// Paths without a file, at which a file would replace a built-in shader.
    awaited: Vec<PathBuf>,
    /// Why an include was refused, if one was.
    pub refused: Option<String>,
}

impl<'a> Includes<'a> {
    /// Begins the includes of a shader of the method in `folder`.
    pub fn new(folder: &'a Path, include_folder: &'a Path, shader: &Path) -> Self {
        let (open, files) = (Vec::new(), vec![shader.to_owned()]);
        Self { folder, include_folder, open, bytes: 0, files, awaited: Vec::new(), refused: None }
    }

    /// Returns the files on which the shader depends, and the paths at which new files would change it.
    pub fn watched(self) -> Vec<PathBuf> {
        self.files.into_iter().chain(self.awaited).collect()
    }

    /// Returns the path of the include `name`: beside the file `includer`, in the folder for includes, or among the
    /// built-in shaders, in this order. If `includer` is built in, the method's folder is searched in place of the
    /// files beside it.
    fn find(&mut self, name: &str, includer: &Path) -> PathBuf {
        let beside = match built_in::text(includer) {
            Some(_) => self.folder,
            None => includer.parent().unwrap_or(self.include_folder),
        };
        let [beside, in_include_folder] = [beside, self.include_folder].map(|folder| folder.join(name));
        if beside.exists() {
            return beside;
        }
        match built_in::path(name) {
            Some(built_in) if !in_include_folder.exists() => {
                self.awaited.extend([beside, in_include_folder]);
                built_in
            }
            _ => in_include_folder,
        }
    }

    /// Reads the include `name` of the file `includer`; returns its path and its text.
    ///
    /// # Errors
    /// The reason why the include cannot be read, as a part of the compiler's message.
    pub fn read(&mut self, name: &str, includer: &str) -> std::result::Result<(String, String), String> {
        let includer = Path::new(includer);
        let path = self.find(name, includer);
        // Includes that were opened after `includer` have been read to their end.
        while self.open.last().is_some_and(|(last, _)| last != includer) {
            self.open.pop();
        }
        self.check(&path).map_err(|why| self.note_refusal(why))?;
        let text = match built_in::text(&path) {
            Some(text) => text.to_owned(),
            None => source_text::read(&path, "an included file", MAX_BYTES).map_err(|e| e.to_string())?,
        };
        self.bytes += text.len() as u64;
        if self.bytes > MAX_BYTES {
            return Err(self.note_refusal(format!("its includes have more than {MAX_BYTES} bytes together")));
        }
        self.open.push((path.clone(), canonical_path(&path)));
        self.files.push(path.clone());
        Ok((path.to_string_lossy().into_owned(), text))
    }

    /// Keeps the first reason why an include is refused; returns `why`.
    fn note_refusal(&mut self, why: String) -> String {
        self.refused.get_or_insert_with(|| why.clone());
        why
    }

    /// Refuses a file outside of the allowed folders, a file that includes itself, and too many includes.
    fn check(&self, path: &Path) -> std::result::Result<(), String> {
        check_place(path, self.folder)?;
        let canonical = canonical_path(path);
        let open_copies = self.open.iter().filter(|(_, open)| *open == canonical).count();
        // A file may include itself once, since an include guard may leave the second copy empty.
        if open_copies + usize::from(canonical_path(&self.files[0]) == canonical) > 1 {
            return Err(format!("{} includes itself", path.display()));
        }
        if self.open.len() >= MOST_DEPTH {
            return Err(format!("includes stand in more than {MOST_DEPTH} includes"));
        }
        if self.files.len() > MOST_INCLUDES {
            return Err(format!("there are more than {MOST_INCLUDES} includes"));
        }
        Ok(())
    }
}

/// Returns the path of a file from the root of the file system, without links; `path` itself if there is no such file.
fn canonical_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Checks that a shader lies in the method's folder, below a folder that the user allows, or is built in.
pub fn check_shader(path: &Path, folder: &Path) -> Result<()> {
    check_place(path, folder).map_err(|why| Error::malformed(path, None, why))
}

/// Checks that a shader may be read from `path`; the error says why not. A path without a file is no error.
fn check_place(path: &Path, folder: &Path) -> std::result::Result<(), String> {
    if built_in::text(path).is_some() {
        return Ok(());
    }
    // A missing file is reported when it is read.
    let Ok(canonical) = path.canonicalize() else { return Ok(()) };
    let mut allowed = std::iter::once(folder).chain(ALLOWED.get().into_iter().flatten().map(PathBuf::as_path));
    if allowed.any(|folder| folder.canonicalize().is_ok_and(|folder| canonical.starts_with(folder))) {
        return Ok(());
    }
    let folder = folder.display();
    Err(format!("{} is outside of the method's folder {folder}, and no folder above it is allowed", path.display()))
}
