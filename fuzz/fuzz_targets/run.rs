#![no_main]

use ssct_fuzz::{Counting, bounded, entry, prepare};

#[global_allocator]
static MEMORY: Counting = Counting;

libfuzzer_sys::fuzz_target!(init: prepare(), |data: &[u8]| {
    bounded(entry::run, data);
});
