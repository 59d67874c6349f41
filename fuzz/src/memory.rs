//! An allocator that counts, so that the memory that an input takes can be limited.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The bytes of memory that any input may take, and the bytes that each of its bytes may take in addition: the
/// most that a byte of a compressed image unpacks to (8 KiB), in the few copies that exist during a conversion.
const BOUND: (usize, usize) = (64 << 20, 128 << 10);

/// The system's allocator; the binary must make it the global one.
pub struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static TOTAL: AtomicUsize = AtomicUsize::new(0);

/// Bytes that are allocated now.
pub fn live() -> usize {
    LIVE.load(Relaxed)
}

/// Bytes that were ever allocated, those that were freed since among them. The tests share this file and ask for it; fuzzing does not.
#[allow(dead_code)]
pub fn allocated() -> usize {
    TOTAL.load(Relaxed)
}

fn more(bytes: usize) {
    TOTAL.fetch_add(bytes, Relaxed);
    PEAK.fetch_max(LIVE.fetch_add(bytes, Relaxed) + bytes, Relaxed);
}

// SAFETY: every call is passed unchanged to the system's allocator, whose answer is returned unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller upholds the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller upholds the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller upholds the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        more(size);
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller upholds the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Runs an entry on an input and returns its result. Panics if it takes more memory than an input of that
/// length may; memory taken by other threads counts as well.
pub fn bounded<T>(entry: impl FnOnce(&[u8]) -> T, data: &[u8]) -> T {
    let before = live();
    PEAK.store(before, Relaxed);
    let made = entry(data);
    let taken = PEAK.load(Relaxed).saturating_sub(before);
    let bound = BOUND.0 + BOUND.1 * data.len();
    assert!(taken <= bound, "{} bytes of input took {taken} bytes of memory, more than {bound}", data.len());
    made
}
