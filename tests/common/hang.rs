//! Waits for something that another process or thread does. No test judges how long this takes. The limit here only
//! ends a test that hangs, with a message that says what hung.

use std::time::{Duration, Instant};

/// How long a test waits before it fails: far longer than anything takes on a machine that many share.
const HANG_LIMIT: Duration = Duration::from_secs(30 * 60);

/// Waits until `is_so` returns true, asking every 5 milliseconds. Panics after [`HANG_LIMIT`] with the text that `what`
/// returns, which names what hangs.
pub fn wait_until(what: impl Fn() -> String, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < HANG_LIMIT, "hangs for {} minutes: {}", HANG_LIMIT.as_secs() / 60, what());
        std::thread::sleep(Duration::from_millis(5));
    }
}
