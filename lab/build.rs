//! Finds the commit that is built, for records.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=SSCT_COMMIT={}", commit());
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
