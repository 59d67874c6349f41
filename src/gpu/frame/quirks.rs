//! Workarounds for bugs of drivers and layers, apart from the rest of the frame. Each file names the bug, the
//! versions that have it, and how to tell when the workaround can go.

pub(super) mod settle;
