//! Waits for something that another process or thread does. How long it takes is never judged: a limit here only ends a
//! test that would not end by itself, and says what hung.

use std::time::{Duration, Instant};

/// How long a test waits before it says that something hangs: far longer than anything takes on a machine that many share.
const HANG_LIMIT: Duration = Duration::from_secs(30 * 60);

/// Waits until `is_so` returns true, asking every few milliseconds. Panics with the sentence `what`, which says what
/// hangs, if that takes longer than [`HANG_LIMIT`].
pub fn wait_until(what: impl Fn() -> String, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < HANG_LIMIT, "hangs for {} minutes: {}", HANG_LIMIT.as_secs() / 60, what());
        std::thread::sleep(Duration::from_millis(5));
    }
}
