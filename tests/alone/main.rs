//! The integration tests that nothing may run beside, one at a time: they measure the memory of their process, build a
//! crate, or make devices fail. Apart from them, `make test-drivers` runs the tests of other drivers, which may run beside each other.

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

use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static MEMORY: memory::Counting = memory::Counting;

/// To be held by each test while it runs.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}
