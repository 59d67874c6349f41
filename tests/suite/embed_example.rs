//! Runs `examples/embed` as a user starts it.

use crate::common::images::check_composite;
use std::process::Command;

/// The example's composite equals that which the command makes of the G-buffer that the example drew, and the
/// validation layers report nothing. Only here does a program enter by the door that is built apart from the tests.
#[test]
fn the_example_shows_what_the_command_makes_of_its_images() {
    let program = std::env::current_exe().unwrap();
    let program = program.ancestors().nth(2).unwrap().join("examples/embed");
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(&program)
        .args(["out.png", "images"])
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT")
        .current_dir(folder.path())
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !text.contains("VUID") && !text.contains("SYNC-"), "{text}");
    check_composite(folder.path(), [640, 360], &[]);
}
