//! Installs the library for C and builds `examples/c` as a user does, by pkg-config and by CMake. The example's image
//! must equal, to the bit, what the command makes of the G-buffer that the example drew.

use crate::common::images::check_composite;
use crate::common::repository;
use crate::is_alone;
use ssct::gpu::validation::ALLOWED;
use std::path::Path;
use std::process::Command;

/// Width and height in `examples/c/hall.h`.
const SIZE: [u32; 2] = [800, 450];

/// Runs a command in a folder. Returns its standard output followed by its standard error; panics unless the command
/// succeeds.
#[track_caller]
fn succeed(command: &mut Command, folder: &Path) -> String {
    let output = command.current_dir(folder).output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {text}");
    text
}

/// The example in C, built by pkg-config and by CMake against the installed library, draws what the command makes of
/// its G-buffer. The header, the linker flags and the document's blocks of C reach no Rust compiler, so that only a
/// build as a user does it sees a fault in them.
#[test]
fn the_example_in_c_shows_what_the_command_makes_of_its_images() {
    if !is_alone() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let prefix = folder.join("prefix");
    let mut install = Command::new(repository().join("scripts/install-c.sh"));
    // With all packages selected, crates have the features that they have in this program, and are not compiled again.
    let packages = ["--workspace", "--lib"];
    succeed(install.env("CARGO_NET_OFFLINE", "true").arg(&prefix).args(packages), folder);

    let source = repository().join("examples/c");
    let build = "cc -std=c11 -O2 -Wall -Wextra -Wpedantic -Werror -o hall \"$SOURCE/main.c\" \
                 $(pkg-config --cflags --libs ssct vulkan) -lm";
    let mut shell = Command::new("sh");
    let shell = shell.args(["-ec", build]).env("SOURCE", &source);
    succeed(shell.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")), folder);
    std::fs::create_dir(folder.join("images")).unwrap();
    let mut hall = Command::new(folder.join("hall"));
    let hall = hall.args(["out.ppm", "images"]).env("LD_LIBRARY_PATH", prefix.join("lib"));
    let hall = hall.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation");
    let enables = "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT";
    let hall_output = succeed(hall.env("VK_LAYER_ENABLES", enables), folder);
    // The first line of a validation message has the message's id.
    let is_allowed = |line: &str| ALLOWED.iter().any(|allowed| line.contains(allowed.id));
    let unexpected = hall_output.lines().any(|line| line.contains("Validation") && !is_allowed(line));
    assert!(!hall_output.contains("VUID") && !hall_output.contains("SYNC-") && !unexpected, "{hall_output}");
    assert!(hall_output.contains("import"), "passes are timed: {hall_output}");
    check_composite(folder, SIZE, &["--fade", "off"]);

    // The examples of the documentation must compile, and C++ must accept the header.
    let page = std::fs::read_to_string(repository().join("docs/embedding.md")).unwrap();
    let blocks: Vec<_> = page.split("\n```c\n").skip(1).filter_map(|rest| rest.split("\n```").next()).collect();
    assert_eq!(blocks.len(), 6, "the three steps, motion, triangles, and their textures");
    let shown = format!("#include <ssct.h>\n#include <stdio.h>\n\n{}\n", blocks.join("\n\n"));
    std::fs::write(folder.join("shown.c"), shown).unwrap();
    let mut cc = Command::new("cc");
    let cc = cc.args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "shown.c", "-I"]);
    succeed(cc.arg(prefix.join("include")), folder);
    let mut cpp = Command::new("c++");
    let cpp = cpp.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++"]);
    succeed(cpp.arg(prefix.join("include/ssct.h")), folder);

    let mut configure = Command::new("cmake");
    let configure = configure.arg("-S").arg(&source).args(["-B", "built", "-DCMAKE_BUILD_TYPE=Release"]);
    let mut prefix_option = std::ffi::OsString::from("-DCMAKE_PREFIX_PATH=");
    prefix_option.push(&prefix);
    succeed(configure.arg(prefix_option), folder);
    succeed(Command::new("cmake").args(["--build", "built"]), folder);
    succeed(Command::new(folder.join("built/hall")).arg("again.ppm"), folder);
    let picture = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert!(picture("out.ppm").starts_with(b"P6\n800 450\n255\n"));
    assert!(picture("out.ppm") == picture("again.ppm"), "built by CMake, it shows something else");
}
