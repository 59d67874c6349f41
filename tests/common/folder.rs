//! Runs the command as a user does, in a temporary folder, which is deleted when the test ends.

use image::RgbImage;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;
use tempfile::TempDir;

/// A temporary folder, in which tests run `ssct`.
pub struct Folder(TempDir);

impl Folder {
    /// Makes an empty folder.
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Returns the path of the folder itself.
    pub fn root(&self) -> &Path {
        self.0.path()
    }

    /// Returns the path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root().join(name)
    }

    /// Writes a file in the folder.
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), contents).unwrap();
    }

    /// Writes `boards.scene.toml` into a subfolder: a mirror floor before a wall under the sky, and a view for each
    /// name. Commands take less time for it than for a built-in scene, whose images they make.
    pub fn write_boards(&self, subfolder: &str, views: &[&str]) {
        write_boards(&self.path(subfolder), views);
    }

    /// Reads a file in the folder as text.
    pub fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// Reads an image in the folder as eight-bit RGB.
    pub fn image(&self, name: &str) -> RgbImage {
        image::open(self.path(name)).unwrap().into_rgb8()
    }

    /// Returns the sorted names of all files and folders in a subfolder.
    pub fn list(&self, name: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(name)).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `ssct` in the folder and returns its output. It may fail but must not panic.
    pub fn run(&self, args: &[&str]) -> Output {
        let output = Command::new(env!("CARGO_BIN_EXE_ssct")).args(args).current_dir(self.root()).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(!text.contains("panicked") && !text.contains("RUST_BACKTRACE"), "{args:?}: {text}");
        output
    }

    /// Runs `ssct`, which must succeed, and returns its standard output. Standard error may have no lines but notices
    /// ([`is_notice`]).
    pub fn succeed(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {errors}");
        let warnings: Vec<&str> = errors.lines().filter(|line| !is_notice(line)).collect();
        assert!(warnings.is_empty(), "{args:?}: no terminal, no progress, no warning: {errors}");
        String::from_utf8(output.stdout).unwrap()
    }
}

/// Returns the path of a scene file like that of [`Folder::write_boards`], with the view `ahead`. All tests share it.
pub fn boards() -> &'static str {
    static FILE: LazyLock<String> = LazyLock::new(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boards");
        std::fs::create_dir_all(&folder).unwrap();
        // Another test program may read the files meanwhile, so that each is put in its place whole.
        let own = tempfile::tempdir_in(&folder).unwrap();
        write_boards(own.path(), &["ahead"]);
        for file in ["boards.obj", "boards.scene.toml"] {
            std::fs::rename(own.path().join(file), folder.join(file)).unwrap();
        }
        folder.join("boards.scene.toml").into_os_string().into_string().unwrap()
    });
    &FILE
}

/// Writes a scene file of a floor and a wall, and its mesh, into a folder. `views` are the names of its views, whose
/// cameras stand one behind the other.
fn write_boards(folder: &Path, views: &[&str]) {
    let board = "o floor\nv -9 -1 -9\nv 9 -1 -9\nv 9 -1 9\nv -9 -1 9\nf 4 3 2 1\n\
                 o wall\nv -9 -1 4\nv 9 -1 4\nv 9 3 4\nv -9 3 4\nf 5 8 7 6\n";
    let view =
        |(n, name): (usize, &&str)| format!("[view.{name}]\neye = [0.0, 0.5, -3.{n}]\nlook_at = [0.0, -0.2, 3.0]\n");
    let views: String = views.iter().enumerate().map(view).collect();
    let scene = "name = \"boards\"\n[[mesh]]\nfile = \"boards.obj\"\n[material.default]\nreflectivity = 1.0\n";
    std::fs::write(folder.join("boards.obj"), board).unwrap();
    std::fs::write(folder.join("boards.scene.toml"), format!("{scene}{views}")).unwrap();
}

/// Returns whether a line of standard error only tells which methods are left out of a scene, or that `SSCT_SHADERS`
/// names a folder of shaders.
pub fn is_notice(line: &str) -> bool {
    if line.starts_with("ssct: shaders are compiled from ") {
        return std::env::var_os("SSCT_SHADERS").is_some();
    }
    line.starts_with("ssct: scene ") && line.contains("; left out, as they would show nothing: ")
}
