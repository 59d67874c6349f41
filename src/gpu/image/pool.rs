//! Images shared by effects that run in turn, so that many methods together need only the memory of the largest one.

use super::{Image, ImageDesc, Kind};
use crate::error::Result;
use crate::gpu::Gpu;
use std::sync::{Arc, Mutex, PoisonError};

/// Images that several effects write and read within a frame; no content has to survive the frame. An effect takes each
/// image of the pool at most once, and another effect takes the same images again. So frames of these effects must not
/// run at the same time, and a frame's images are lost when another effect runs. Clones are handles to the same images.
#[derive(Clone, Default)]
pub struct ImagePool(Arc<Mutex<Vec<(Key, Image)>>>);

/// The properties of an image without its name: kind, format, extent, levels, layers and usage.
type Key = (Kind, ash::vk::Format, [u32; 2], u32, u32, ash::vk::ImageUsageFlags);

/// The images that one effect has taken from a pool, as indices.
#[derive(Clone)]
pub(in crate::gpu) struct Loan {
    pool: ImagePool,
    taken: Arc<Mutex<Vec<usize>>>,
}

impl Loan {
    /// Returns an image of the pool that fits a description and that the effect has not taken yet, under the
    /// description's name. If there is none, `make` makes it.
    pub(super) fn take(&self, kind: Kind, desc: &ImageDesc, make: impl FnOnce() -> Result<Image>) -> Result<Image> {
        let key = (kind, desc.format, desc.extent, desc.levels, desc.layers, desc.usage);
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let mut images = self.pool.0.lock().unwrap_or_else(PoisonError::into_inner);
        let free = images.iter().enumerate().position(|(n, (known, _))| *known == key && !taken.contains(&n));
        if free.is_none() {
            images.push((key, make()?));
        }
        let index = free.unwrap_or(images.len() - 1);
        taken.push(index);
        let (_, image) = &images[index];
        Ok(image.renamed(desc.name))
    }
}

impl Gpu {
    /// Returns a handle to the same device for one effect, whose images are taken from the pool.
    pub(in crate::gpu) fn pooled(&self, pool: &ImagePool) -> Self {
        let mut gpu = self.clone();
        gpu.loan = Some(Loan { pool: pool.clone(), taken: Arc::default() });
        gpu
    }

    /// Returns a handle to the same device that makes every image anew.
    pub(super) fn unpooled(&self) -> Self {
        let mut gpu = self.clone();
        gpu.loan = None;
        gpu
    }
}
