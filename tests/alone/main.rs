//! The integration tests that need a process of their own: they measure its memory, make devices fail, or build the
//! library as its users do. Processes may run beside each other. Tests of other drivers are here, too; `make
//! test-drivers` runs them.

#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../../fuzz/src/memory.rs"]
mod memory;

mod c;
mod compiled;
mod drivers;
mod embedder;
mod faults;
mod fuzz_corpus;
mod many_things;
mod packaged;
mod programs;
mod soak;

use std::process::{Command, Stdio};

#[global_allocator]
static MEMORY: memory::Counting = memory::Counting;

/// The environment variable that tells a process which test it runs alone.
const ALONE: &str = "SSCT_TEST_ALONE";

/// Returns true in the process that runs the calling test alone. In any other process, it runs the test in such a
/// process, waits for it, and returns false.
///
/// # Panics
/// If the test does not pass in that process.
fn is_alone() -> bool {
    let thread = std::thread::current();
    let name = thread.name().expect("a test's thread has its name");
    if std::env::var_os(ALONE).is_some_and(|alone| alone == name) {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().expect("this program has a path"));
    // The test's standard error is passed through at once.
    command.args([name, "--exact", "--include-ignored", "--nocapture"]).env(ALONE, name).stderr(Stdio::inherit());
    let output = command.output().unwrap_or_else(|e| panic!("{name}: {e}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    println!("{text}");
    assert!(output.status.success() && text.contains("1 passed"), "{name} failed in a process of its own");
    false
}
