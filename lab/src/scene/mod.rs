//! Where scenes come from: scene files ([`scene_file`]), OBJ files ([`obj`]) and the built-in library ([`library`]); all
//! three give the same [`Scene`]. [`path`](mod@path) reads and writes the paths of a camera, [`bvh`] and [`triangles`]
//! trace rays against a scene, [`placement`] finds places for captures, and [`gbuffer_file`] and [`capture_file`] are the
//! files of other renderers.
//!
//! The types themselves are those of [`ssct::scene`], which are here under the same names.

mod bounded;
pub mod bvh;
pub mod capture_file;
mod exr_channels;
pub mod gbuffer_file;
pub mod library;
pub mod obj;
pub mod path;
pub mod pattern;
pub mod placement;
pub mod scene_file;
pub mod texture;
pub mod triangles;

pub use ssct::scene::*;
pub use triangles::Triangles;
