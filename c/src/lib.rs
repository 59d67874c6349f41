//! The door of `ssct` for C: a shared and a static library, and the header `include/ssct.h`, which cbindgen writes from
//! these files. Comments on what the header shows are written for whoever reads it there. What a caller must uphold
//! stands once, at the header's top.

#![allow(clippy::missing_safety_doc, reason = "the header's top states what callers uphold, for all functions")]

// In the order of the header, each apart, since rustfmt sorts neighbours.
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
