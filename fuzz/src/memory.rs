//! An allocator that counts the allocated bytes, so that the memory that an input takes can be limited.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The two terms of the bound of memory in bytes: a constant, and the bytes for each byte of the input. A byte of a
/// compressed image unpacks to 8 KiB at most, of which a few copies exist during a conversion.
const MEMORY_BOUND: (usize, usize) = (64 << 20, 128 << 10);

/// The system's allocator, which also counts. The binary must make it the global allocator.
pub struct Counting;

/// Bytes that are allocated now.
static LIVE: AtomicUsize = AtomicUsize::new(0);
/// The greatest value of [`LIVE`] since [`bounded`] began.
static PEAK: AtomicUsize = AtomicUsize::new(0);
/// Bytes that were allocated since the program began, also those that are freed again.
static TOTAL: AtomicUsize = AtomicUsize::new(0);

/// Returns the number of bytes that are allocated now.
pub fn live() -> usize {
    LIVE.load(Relaxed)
}

/// Returns the number of bytes that were allocated since the program began, also those that are freed again. Only the
/// tests, which include this file, call the function.
#[allow(dead_code)]
pub fn allocated() -> usize {
    TOTAL.load(Relaxed)
}

/// Counts an allocation of `bytes` bytes in all three counters.
fn count_allocation(bytes: usize) {
    TOTAL.fetch_add(bytes, Relaxed);
    PEAK.fetch_max(LIVE.fetch_add(bytes, Relaxed) + bytes, Relaxed);
}

// SAFETY: every call is passed unchanged to the system's allocator, whose answer is returned unchanged.
unsafe impl GlobalAlloc for Counting {
    /// Counts the bytes, and lets the system allocate them.
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count_allocation(layout.size());
        // SAFETY: the caller upholds the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    /// Counts the bytes, and lets the system allocate them as zeros.
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count_allocation(layout.size());
        // SAFETY: the caller upholds the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    /// Takes the bytes off [`LIVE`], and lets the system free them.
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller upholds the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }

    /// Counts the new bytes before the old ones are taken off, since both may exist while the system copies.
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count_allocation(size);
        LIVE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller upholds the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Runs an entry on an input and returns its result. Panics if the entry takes more memory than an input of this length
/// may. Memory that other threads take in the meantime counts, too.
pub fn bounded<T>(entry: impl FnOnce(&[u8]) -> T, data: &[u8]) -> T {
    let live_before = live();
    PEAK.store(live_before, Relaxed);
    let result = entry(data);
    let taken = PEAK.load(Relaxed).saturating_sub(live_before);
    let (constant, per_byte) = MEMORY_BOUND;
    let bound = constant + per_byte * data.len();
    assert!(taken <= bound, "{} bytes of input took {taken} bytes of memory, more than {bound}", data.len());
    result
}
