//! An allocator that counts, so that an execution's memory can be held to a bound.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// What any input may take, in bytes, and what each of its bytes may take beyond that: the most that a byte
/// of a compressed image unpacks to (8 KiB), in the few copies that a conversion has at once.
const BOUND: (usize, usize) = (64 << 20, 128 << 10);

/// The system's allocator; the binary must make it the global one.
pub struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// Bytes that are allocated now.
pub fn live() -> usize {
    LIVE.load(Relaxed)
}

fn more(bytes: usize) {
    PEAK.fetch_max(LIVE.fetch_add(bytes, Relaxed) + bytes, Relaxed);
}

// SAFETY: every call goes to the system's allocator as it came, and its answer goes back as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller keeps to `alloc`'s contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller keeps to `alloc_zeroed`'s contract.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps to `dealloc`'s contract.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        more(size);
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps to `realloc`'s contract.
        unsafe { System.realloc(at, layout, size) }
    }
}

/// Runs an entry on an input, and panics if it takes more memory than so long an input may. Other threads'
/// memory counts as well. Gives what the entry gives.
pub fn bounded<T>(entry: impl FnOnce(&[u8]) -> T, data: &[u8]) -> T {
    let before = live();
    PEAK.store(before, Relaxed);
    let made = entry(data);
    let taken = PEAK.load(Relaxed).saturating_sub(before);
    let bound = BOUND.0 + BOUND.1 * data.len();
    assert!(taken <= bound, "{} bytes of input took {taken} bytes of memory, more than {bound}", data.len());
    made
}
