//! Finds the commit that is built, for records, and lists the project's own shaders, which methods from folders may use.

use std::io::Result;
use std::path::Path;

fn main() -> Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=SSCT_COMMIT={}", commit());
    write_shader_table()
}

/// The commit that is built, for records; "unknown" outside a repository, "+" after it for a
/// working tree that differs.
fn commit() -> String {
    let git = |args: &[&str]| {
        // Reading must not write: a status that refreshed the index would have the next build run this again.
        let mut git = std::process::Command::new("git");
        let output = git.arg("--no-optional-locks").args(args).output().ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // The index changes with every commit and checkout; in a worktree it is not under `.git`. The
    // sources decide whether the tree differs.
    for sources in ["src", "truth/src", "../src", "../shaders-glsl", "../build.rs"] {
        println!("cargo:rerun-if-changed={sources}");
    }
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

/// Adds a row for each shader of a folder, whose path below `shaders-glsl` is `place`, with a slash behind it.
fn list(folder: &Path, place: &str, rows: &mut Vec<String>) -> Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = format!("{place}{}", path.file_name().unwrap_or_default().to_string_lossy());
        if path.is_dir() {
            list(&path, &format!("{name}/"), rows)?;
        } else if path.extension().is_some_and(|extension| extension != "md") {
            rows.push(format!("    ({name:?}, include_str!({:?})),\n", path.to_string_lossy()));
        }
    }
    Ok(())
}
