//! The interface of `ssct` for C: a shared and a static library, and the header `include/ssct.h`, which cbindgen writes
//! from these files. Comments on public items are written for readers of the header. The top of the header states, for
//! all functions, what a caller must uphold.

#![allow(clippy::missing_safety_doc, reason = "the header's top states what callers uphold, for all functions")]

// The modules stand in the order of the header. Blank lines keep them apart, since rustfmt sorts neighbouring lines.
mod border;

mod context;

mod image;

mod reflections;

mod captures;

mod triangles;

mod memory;

mod live;

mod vulkan;

#[cfg(test)]
mod tests;
