#![no_main]

use ssct_fuzz::{Counting, bounded, entry, in_this_thread};

#[global_allocator]
static MEMORY: Counting = Counting;

libfuzzer_sys::fuzz_target!(init: in_this_thread(), |data: &[u8]| {
    bounded(entry::gbuffer, data);
});
