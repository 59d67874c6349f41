//! The references with which the results of the GPU's passes are compared: readable code on the CPU that shares nothing
//! with the GPU's code. Nothing here imports `gpu`, `passes` or `methods`, so that agreement is evidence.
//!
//! [`oracle`] finds what a ray hits in a G-buffer, [`hierarchy`] finds the same hits faster, and [`screen`] averages
//! the oracle's rays over glossy lobes. [`images`] follows rays that the screen loses in captures of the scene
//! ([`capture_data`]). [`world`] averages rays among the scene's triangles (docs/definitions.md, "Oracle" and "Image
//! error"), and [`paths`] traces light paths of several bounces. [`pixel`] computes the references of one pixel.
//! [`hi_z`], [`hi_z_ray_trace`], [`visibility`] and [`unified`] are CPU twins of GPU passes.

pub mod capture_data;
pub mod first_hits;
pub mod floor;
pub mod hi_z;
pub mod hi_z_ray_trace;
pub mod hierarchy;
pub mod images;
pub mod kept_samples;
pub mod lobe;
pub mod oracle;
pub mod partial_sums;
pub mod paths;
pub mod pixel;
pub mod ray;
pub mod screen;
pub mod surface;
pub mod surface_color;
pub mod thickness;
pub mod triangles;
pub mod unified;
pub mod visibility;
pub mod world;
pub mod world_hits;
pub mod world_part;

pub use capture_data::CaptureData;
pub use hierarchy::Hierarchy;
pub use images::ImageOracle;
pub use oracle::Oracle;
pub use ray::{MissReason, Outcome, Trace};
pub use screen::ScreenReference;

/// One level of a chain of images; rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Level<T> {
    /// Width in texels, ≥ 1.
    pub width: u32,
    /// Height in texels, ≥ 1.
    pub height: u32,
    /// `width · height` texels.
    pub texels: Vec<T>,
}

impl<T: Copy> Level<T> {
    /// Makes a level of `width` by `height` texels by evaluating `texel` at each (x, y), row by row.
    pub fn from_fn(width: u32, height: u32, mut texel: impl FnMut(u32, u32) -> T) -> Self {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { width, height, texels }
    }

    /// Returns the texel at (x, y), or beyond the right or lower edge the nearest texel at that edge.
    pub fn at_clamped(&self, x: u32, y: u32) -> T {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// Returns the width and height of the next coarser level: half those of this level, rounded down, but at least 1.
    /// `None` if this level has a single texel.
    pub fn coarser(&self) -> Option<(u32, u32)> {
        (self.width > 1 || self.height > 1).then_some(((self.width / 2).max(1), (self.height / 2).max(1)))
    }
}

#[cfg(test)]
pub(crate) mod testing;
