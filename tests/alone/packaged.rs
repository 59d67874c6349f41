//! Tests the crate as others get it: packaged, unpacked into an empty folder, and built there without a shader compiler
//! and without a network. Its images must equal, to the bit, those of the crate in this repository.

use crate::common::repository;
use crate::{embedder, is_alone};
use ssct::gpu::programs;
use std::path::Path;
use std::process::{Command, Output};

/// The most that a build from clean may compile: crates, with the embedder's own; lines of the package's Rust; and
/// bytes of its SPIR-V. These three numbers decide how long a build takes on any machine.
const MOST_CRATES: usize = 60;
const MOST_LINES: usize = 26_240;
const MOST_SPIRV_BYTES: usize = 17 << 18;

/// The manifest of a program that depends on the packaged crate and on `ash`, with settings for a quick build.
const MANIFEST: &str = r#"
[package]
name = "embedder"
version = "0.0.0"
edition = "2024"

[dependencies]
ash = "0.38"
ssct = { path = "../ssct-VERSION" }

[patch.crates-io]
ssct-ground = { path = "../ssct-ground-VERSION" }

[profile.dev]
debug = false
incremental = false

[workspace]
"#;

/// The program's source. It writes the embedder's images to the file that its argument names.
const PROGRAM: &str = r#"
mod embedder;

fn main() {
    let path = std::env::args().nth(1).expect("a path");
    std::fs::write(path, embedder::picture().expect("a picture")).expect("a file");
}
"#;

/// Returns a command that runs a program in a folder, without a network. It gets none of the environment variables by
/// which Cargo and `scripts/setup.sh` say where built files and a shader compiler are.
fn command(program: &str, folder: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(folder);
    for (name, _) in std::env::vars_os() {
        let variable = name.to_string_lossy();
        let is_for_cargo = variable.starts_with("CARGO_") && variable != "CARGO_HOME";
        if is_for_cargo || variable.starts_with("SHADERC_") || ["RUSTFLAGS", "VULKAN_SDK"].contains(&&*variable) {
            command.env_remove(name);
        }
    }
    command.env("CARGO_NET_OFFLINE", "true").env("CARGO_TERM_COLOR", "never");
    command
}

/// Runs a command and returns its standard error. Panics unless the command succeeds.
fn succeed(command: &mut Command) -> String {
    let Output { status, stderr, .. } = command.output().unwrap();
    let text = String::from_utf8_lossy(&stderr).into_owned();
    assert!(status.success(), "{command:?}: {text}");
    text
}

/// Counts the lines of Rust files in a folder and in all folders below it.
fn lines_of_rust(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let lines = |path: std::path::PathBuf| match path.extension() {
        _ if path.is_dir() => lines_of_rust(&path),
        Some(extension) if extension == "rs" => std::fs::read_to_string(&path).unwrap().lines().count(),
        _ => 0,
    };
    entries.map(lines).sum()
}

/// Returns the contents of the files in a folder that have an extension (without a dot), sorted by their bytes.
fn contents(folder: &Path, extension: &str) -> Vec<Vec<u8>> {
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let matching = paths.filter(|p| p.extension().is_some_and(|e| e == extension));
    let mut found: Vec<_> = matching.map(|p| std::fs::read(p).unwrap()).collect();
    found.sort();
    found
}

/// The packaged crate builds without a shader compiler and without a network, within the limits above, and draws the
/// same bits. Only this test sees a file that the package lacks, since the repository has them all.
#[test]
fn the_packaged_crate_needs_no_shader_compiler_and_shows_the_same() {
    if !is_alone() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let target = folder.path().join("target");

    // This is the one command here that may use the shader compiler, with the variables of the workspace.
    let mut package = Command::new(repository().join("scripts/package.sh"));
    package.env("CARGO_NET_OFFLINE", "true").env("BUILD", "build --workspace --lib");
    succeed(package.arg("--target-dir").arg(&target));
    let unpacked = |name: &str| {
        let name = format!("{name}-{}", env!("CARGO_PKG_VERSION"));
        let archive = target.join("package").join(format!("{name}.crate"));
        succeed(command("tar", folder.path()).arg("-xzf").arg(&archive));
        folder.path().join(&name)
    };
    let (ground, root) = (unpacked("ssct-ground"), unpacked("ssct"));
    let mut modules: Vec<_> = programs::ALL.iter().map(|s| s.spirv.to_vec()).collect();
    modules.sort();
    assert!(
        contents(&root.join("shaders-spirv"), "spv") == modules,
        "the packaged modules are those that were built in"
    );
    for present in ["LICENSE-APACHE", "LICENSE-MIT", "README.md", "docs/embedding.md", "examples/embed", "shaders-glsl"]
    {
        assert!(root.join(present).exists(), "{present} is packaged");
    }
    for absent in ["benches", "lab", "tests"] {
        assert!(!root.join(absent).exists(), "{absent} is not packaged");
    }

    let program = folder.path().join("embedder");
    std::fs::create_dir_all(program.join("src")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(program.join(name), text).unwrap();
    write("Cargo.toml", &MANIFEST.replace("VERSION", env!("CARGO_PKG_VERSION")));
    write("Cargo.lock", &std::fs::read_to_string(repository().join("Cargo.lock")).unwrap());
    write("src/main.rs", PROGRAM);
    write("src/embedder.rs", include_str!("embedder.rs"));
    let build = || {
        let mut build = command(&cargo, &program);
        build.args(["build", "--target-dir"]).arg(folder.path().join("built"));
        build
    };
    let build_log = succeed(&mut build());
    let crates = build_log.lines().filter(|line| line.trim_start().starts_with("Compiling ")).count();
    let lines = lines_of_rust(&ground.join("src")) + lines_of_rust(&root.join("src"));
    let bytes = modules.iter().map(Vec::len).sum::<usize>();
    println!("the packaged crate was built of {crates} crates, {lines} lines of its own and {bytes} bytes of SPIR-V");
    assert!(crates > 10 && crates <= MOST_CRATES, "{crates} crates: {build_log}");
    assert!(
        lines > 10_000 && lines <= MOST_LINES,
        "{lines} lines of Rust in src and ground/src; MOST_LINES here allows {MOST_LINES}"
    );
    assert!(bytes <= MOST_SPIRV_BYTES, "{bytes} bytes of SPIR-V; MOST_SPIRV_BYTES here allows {MOST_SPIRV_BYTES}");
    assert!(build_log.contains("the shaders are the packaged SPIR-V"), "{build_log}");
    let lock = std::fs::read_to_string(program.join("Cargo.lock")).unwrap();
    assert!(
        lock.contains("name = \"rspirv\"") && !lock.contains("shaderc"),
        "no compiler among the dependencies: {lock}"
    );

    let picture = folder.path().join("picture");
    succeed(command(folder.path().join("built/debug/embedder").to_str().unwrap(), folder.path()).arg(&picture));
    let (theirs, ours) = (std::fs::read(&picture).unwrap(), embedder::picture().unwrap());
    let pixels = (embedder::SIZE[0] * embedder::SIZE[1]) as usize;
    assert_eq!(ours.len(), 2 * pixels * embedder::TEXEL);
    assert!(theirs == ours, "the images differ");
    let reflection = &ours[pixels * embedder::TEXEL..];
    let reflects = reflection.chunks(embedder::TEXEL).filter(|texel| texel.iter().any(|byte| *byte != 0)).count();
    assert!(reflects > pixels / 8, "only {reflects} pixels reflect");

    // A build is refused if the GLSL was changed, or if there is no SPIR-V, as in a checkout.
    let refused = |why: &str| {
        let output = build().output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(why) && text.contains("compile-shaders"), "{text}");
    };
    let constants = root.join("shaders-glsl/common/constants.glsl");
    let text = std::fs::read_to_string(&constants).unwrap();
    std::fs::write(&constants, format!("{text}\n")).unwrap();
    refused("is not what the SPIR-V");
    std::fs::write(&constants, text).unwrap();
    std::fs::remove_dir_all(root.join("shaders-spirv")).unwrap();
    refused("there is no compiled shader");
}
