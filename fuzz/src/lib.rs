//! What the fuzz targets share with each other and, by its files, with `tests/fuzz_corpus.rs`.

pub mod entry;
mod memory;

pub use memory::{Counting, bounded};

/// Makes rayon run on the calling thread alone: an execution takes less time than waking another.
pub fn in_this_thread() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("the pool is built once");
}
