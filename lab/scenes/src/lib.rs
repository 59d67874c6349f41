//! Sources of scenes: scene files ([`scene_file`]), OBJ files ([`obj`]), glTF files ([`gltf`]) and the built-in library
//! ([`library`]) all give the same [`Scene`]. [`path`](mod@path) reads and writes the paths of a camera.
//! [`gbuffer_file`] and [`capture_file`] read and write files for other renderers, and [`gbuffer_map`] reads G-buffers
//! in the conventions of other renderers. [`inside`] is the door to files: it writes every file, and reads the folders
//! of runs.
//!
//! The types are those of [`ssct_ground::scene`], re-exported here under the same names.

pub mod capture_file;
mod encoding;
mod exr_channels;
mod exr_parts;
mod exr_window;
mod far_away;
pub mod gbuffer_file;
pub mod gbuffer_map;
pub mod gltf;
pub mod inside;
pub mod library;
pub mod material_terms;
mod metallic;
pub mod obj;
pub mod path;
pub mod scene_file;
pub mod source_text;

pub use ssct_ground::scene::*;

use ssct_ground::{Error, Result};

/// Options that change a scene while its file is loaded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadOptions {
    /// Factor on all coordinates; finite and > 0.
    pub scale: f32,
    /// The greatest side of a material's image in texels, ≥ 1; larger images are shrunk when they are decoded.
    pub texture_side: u32,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { scale: 1.0, texture_side: ssct_geometry::texture::MAX_EXTENT }
    }
}

impl LoadOptions {
    /// Checks that the options are in range.
    ///
    /// # Errors
    /// [`Error::Usage`] for values out of range.
    fn check(&self) -> Result<()> {
        let Self { scale, texture_side } = *self;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(Error::Usage(format!("the scale must be a positive number, not {scale}")));
        }
        if texture_side == 0 {
            return Err(Error::Usage("images need a side of at least one texel".into()));
        }
        Ok(())
    }
}
