//! Finds the commit that is built, for records, and lists the project's own shaders, which methods from folders may use.

use std::io::Result;
use std::path::Path;

fn main() -> Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=SSCT_COMMIT={}", commit());
    write_shader_table()
}

/// Returns the short hash of the commit that is built, for records, with a "+" behind it if tracked files differ from
/// the commit. Returns "unknown" outside a repository.
fn commit() -> String {
    // Runs git with arguments; returns what it prints, or `None` if it fails.
    let git = |args: &[&str]| {
        // Without this option `git status` may rewrite the index, after which the next build would run this script
        // again.
        let mut git = std::process::Command::new("git");
        let output = git.arg("--no-optional-locks").args(args).output().ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // Changed sources decide whether the hash gets a "+".
    for sources in
        ["src", "geometry/src", "scenes/src", "truth/src", "../ground/src", "../src", "../shaders-glsl", "../build.rs"]
    {
        println!("cargo:rerun-if-changed={sources}");
    }
    // Each commit and checkout changes the index. Git says where it lies, which in a worktree is not under `.git`.
    for file in ["HEAD", "index"].iter().filter_map(|f| git(&["rev-parse", "--path-format=absolute", "--git-path", f]))
    {
        println!("cargo:rerun-if-changed={file}");
    }
    match git(&["rev-parse", "--short=10", "HEAD"]) {
        None => "unknown".into(),
        Some(commit) => match git(&["status", "--porcelain", "--untracked-files=no"]) {
            Some(changes) if changes.is_empty() => commit,
            _ => commit + "+",
        },
    }
}

/// Writes the table `SHADERS`: the path of each file below `shaders-glsl` that a shader is made of, and its text.
fn write_shader_table() -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-glsl").canonicalize()?;
    let mut rows = Vec::new();
    list(&folder, "", &mut rows)?;
    rows.sort();
    let table = format!("static SHADERS: [(&str, &str); {}] = [\n{}];\n", rows.len(), rows.concat());
    let output = std::env::var_os("OUT_DIR").unwrap_or_default();
    std::fs::write(Path::new(&output).join("built_in_shaders.rs"), table)
}

/// Adds a row of the table for each file in a folder and its subfolders, except pages (`.md`). `prefix` is the folder's
/// path below `shaders-glsl`, with a slash at its end; it is empty for `shaders-glsl` itself.
fn list(folder: &Path, prefix: &str, rows: &mut Vec<String>) -> Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = format!("{prefix}{}", path.file_name().unwrap_or_default().to_string_lossy());
        if path.is_dir() {
            list(&path, &format!("{name}/"), rows)?;
        } else if path.extension().is_some_and(|extension| extension != "md") {
            rows.push(format!("    ({name:?}, include_str!({:?})),\n", path.to_string_lossy()));
        }
    }
    Ok(())
}
