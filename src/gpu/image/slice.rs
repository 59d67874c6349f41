//! Parts of images, as shaders and attachments see them.

use super::{Image, has_stencil, level_extent};
use crate::gpu::sync::TrackedState;
use ash::vk;
use std::ops::Range;

/// A part of an image, as a shader or an attachment sees it: `count` mip levels from `base` on, or a slice of a volume.
/// If `by_face` is set, shaders see the faces of a cube map as an array of images.
#[derive(Clone, Copy)]
pub struct ImageSlice<'a> {
    pub(super) image: &'a Image,
    pub(super) base: u32,
    pub(super) count: u32,
    pub(super) slice: Option<u32>,
    pub(super) by_face: bool,
}

impl<'a> ImageSlice<'a> {
    /// The image.
    pub fn image(&self) -> &'a Image {
        self.image
    }

    /// Returns the part that a compute program stores to: this part itself, or the whole volume in place of one of its
    /// slices, since not every device can store to a view of one slice.
    pub(crate) fn stored(&self) -> Self {
        if self.slice.is_some() { self.image.all() } else { *self }
    }

    /// The first level.
    pub fn base_level(&self) -> u32 {
        self.base
    }

    /// Width and height of the first level.
    pub fn extent(&self) -> [u32; 2] {
        level_extent(self.image.extent, self.base)
    }

    /// Returns which slices of a volume are covered; 0..1 for other images.
    pub(crate) fn slices(&self) -> Range<u32> {
        self.slice.map_or(0..self.image.depth, |slice| slice..slice + 1)
    }

    /// The view through which shaders see this part of the image.
    pub fn view(&self) -> vk::ImageView {
        if self.by_face {
            self.image.faces_view
        } else if let Some(slice) = self.slice {
            self.image.slice_views[slice as usize]
        } else if self.count == self.image.levels() {
            self.image.whole_view
        } else if self.count > 1 {
            // No other range of several levels is ever made.
            self.image.coarse_view
        } else {
            self.image.level_views[self.base as usize]
        }
    }

    /// The view by which a depth target with stencil is attached; `None` for a format without stencil.
    pub(crate) fn stencil_view(&self) -> Option<vk::ImageView> {
        has_stencil(self.image.format).then_some(self.image.stencil_view)
    }

    /// Returns true if something was written to every level. A level whose layout is UNDEFINED counts as not written.
    pub fn is_written(&self) -> bool {
        self.states().all(|(_, state)| state.get().layout() != vk::ImageLayout::UNDEFINED)
    }

    /// Returns the number and the tracked state of each level. The slices of a volume share the state of their level,
    /// since Vulkan has one layout for all of them.
    pub(crate) fn states(&self) -> impl Iterator<Item = (u32, &'a TrackedState)> + use<'a> {
        let (base, count) = (self.base as usize, self.count as usize);
        self.image.states[base..base + count].iter().enumerate().map(move |(i, state)| ((base + i) as u32, state))
    }
}
