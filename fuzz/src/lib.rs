//! Code that all fuzz targets share. The tests in `tests/alone` include the files `entry.rs` and `memory.rs`.

pub mod entry;
mod memory;
mod seeds;

pub use memory::{Counting, bounded};

/// Prepares a target: rayon uses only the calling thread, because an input takes less time than waking another thread.
/// If the environment variable `SSCT_FUZZ_SEEDS` names a folder, the function writes the seeds of every target into it
/// instead, and ends the program.
pub fn prepare() {
    if let Some(folder) = std::env::var_os("SSCT_FUZZ_SEEDS") {
        seeds::write_all(folder.as_ref());
        std::process::exit(0);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("the pool is built once");
}
