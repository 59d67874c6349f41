//! What the passes are held against: readable code on the CPU that shares nothing with the GPU's.
//! Nothing here imports `gpu`, `passes` or `methods`, so that agreement is evidence.
//!
//! [`oracle`] says what a ray meets in a G-buffer, [`hierarchy`] finds the same fast, and [`screen`]
//! averages it over glossy lobes; [`world`] does so against the triangles (DEFINITIONS, "Oracle" and
//! "Image error"). [`hi_z`], [`hi_z_ray_trace`], [`visibility`] and [`unified`] are twins of passes.

pub mod bvh;
pub mod first_hits;
pub mod hi_z;
pub mod hi_z_ray_trace;
pub mod hierarchy;
pub mod lobe;
pub mod oracle;
pub mod random;
pub mod ray;
pub mod screen;
pub mod surface;
pub mod thickness;
pub mod unified;
pub mod visibility;
pub mod world;
pub mod world_hits;
pub mod world_state;

pub use hierarchy::Hierarchy;
pub use oracle::Oracle;
pub use ray::{MissReason, Outcome, Trace};
pub use screen::ScreenReference;

/// One level of a chain: texels in rows from the top.
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
    /// A texel for each (x, y).
    pub fn from_fn(width: u32, height: u32, mut texel: impl FnMut(u32, u32) -> T) -> Self {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { width, height, texels }
    }

    /// The texel at (x, y); beyond the right or lower edge, the edge's.
    pub fn at_clamped(&self, x: u32, y: u32) -> T {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// Width and height of the next coarser level, halved and rounded down, at least 1; `None`
    /// above the level of one texel.
    pub fn coarser(&self) -> Option<(u32, u32)> {
        (self.width > 1 || self.height > 1).then_some(((self.width / 2).max(1), (self.height / 2).max(1)))
    }
}

#[cfg(test)]
pub(crate) mod testing;
