//! The integration tests that need a process of their own: they measure its memory, make devices fail, or build what others build.
//! Processes may run beside each other. Tests of other drivers are here, too; `make test-drivers` runs them.

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

/// The variable with the name of the test that a process is for.
const ALONE: &str = "SSCT_TEST_ALONE";

/// Whether the calling test has the process for itself. If not, the test runs in a process of its own before this returns.
///
/// # Panics
/// If it does not pass there.
fn is_alone() -> bool {
    let thread = std::thread::current();
    let name = thread.name().expect("a test's thread has its name");
    if std::env::var_os(ALONE).is_some_and(|alone| alone == name) {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().expect("this program has a path"));
    // What a test says on standard error is shown as it is said.
    command.args([name, "--exact", "--include-ignored", "--nocapture"]).env(ALONE, name).stderr(Stdio::inherit());
    let output = command.output().unwrap_or_else(|e| panic!("{name}: {e}"));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    println!("{said}");
    assert!(output.status.success() && said.contains("1 passed"), "{name} failed in a process of its own");
    false
}
