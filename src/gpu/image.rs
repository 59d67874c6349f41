//! Images with one view per mip level (or slice of a volume), and one view over all of them.

mod levels;
mod pool;
mod slice;

pub use levels::{full_chain, level_extent};
pub use pool::ImagePool;
pub(super) use pool::Loan;
pub use slice::ImageSlice;

use super::device::{Gpu, vulkan};
use super::memory::{self, Allocation, MemoryPlace};
use super::pixels::ShaderStage;
use super::sync::{State, TrackedState};
use crate::error::{Error, Result};
use ash::vk;
use std::ops::Deref;
use std::sync::Arc;

/// The description of an image that is to be made.
#[derive(Debug, Clone, Copy)]
pub struct ImageDesc<'a> {
    /// Name for debuggers and errors.
    pub name: &'a str,
    /// Texel format.
    pub format: vk::Format,
    /// Width and height of level 0 in texels.
    pub extent: [u32; 2],
    /// Number of mip levels; level n is max(1, extent >> n).
    pub levels: u32,
    /// 6 for a cube map, more for an array ([`Image::array`], [`Image::cubes`]), else 1.
    pub layers: u32,
    /// Uses of the image.
    pub usage: vk::ImageUsageFlags,
}

/// Whether a depth format has a stencil beside it.
pub(crate) fn has_stencil(format: vk::Format) -> bool {
    format == vk::Format::D32_SFLOAT_S8_UINT
}

/// A handle to an image with its memory and views. Clones are handles to the same image, and the last handle destroys it.
#[derive(Clone)]
pub struct Image {
    name: String,
    shared: Arc<OwnedImage>,
}

/// An image with its memory and views.
pub struct OwnedImage {
    /// Name for debuggers. An image of a pool keeps the name that the first effect gave it.
    name: String,
    gpu: Gpu,
    handle: vk::Image,
    allocation: Option<Allocation>,
    level_views: Vec<vk::ImageView>,
    whole_view: vk::ImageView,
    /// All levels but the finest; null for fewer than three.
    coarse_view: vk::ImageView,
    /// The faces of a cube map as an array of images; null for other images.
    faces_view: vk::ImageView,
    /// Depth and stencil together, where there is a stencil: the other views see the depth alone.
    stencil_view: vk::ImageView,
    format: vk::Format,
    extent: [u32; 2],
    /// Number of slices of a volume, each with a view to render into; for other images 1, without such a view.
    depth: u32,
    slice_views: Vec<vk::ImageView>,
    layers: u32,
    states: Vec<TrackedState>,
    /// Whether the caller or the swapchain owns the Vulkan image and its views, so that they are not destroyed here.
    borrowed: bool,
    /// The part of a caller's image that this object stands for.
    part: Option<vk::ImageSubresourceRange>,
}

/// What the layers or slices of an image are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// One layer, or the six faces of a cube map.
    Flat,
    /// Layers are images of one size.
    Array,
    /// Layers are cube maps, six faces each.
    Cubes,
    /// The slices of a volume, by their number.
    Volume(u32),
}

impl<'a> ImageDesc<'a> {
    /// Describes an image of one level and one layer.
    pub fn one_level(name: &'a str, format: vk::Format, extent: [u32; 2], usage: vk::ImageUsageFlags) -> Self {
        Self { name, format, extent, levels: 1, layers: 1, usage }
    }

    /// The longest side that the image may have. Limits of viewports and framebuffers hold for images drawn into.
    fn max_side(&self, gpu: &Gpu) -> u32 {
        use vk::ImageUsageFlags as U;
        let is_drawn = self.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT);
        if is_drawn { gpu.max_image_size() } else { gpu.shared().limits.max_image_dimension2_d }
    }
}

impl Image {
    /// Makes an image; its content is undefined.
    ///
    /// # Errors
    /// [`Error::Usage`] for a size of 0 or beyond the device's limit; [`Error::Memory`] without memory.
    pub fn new(gpu: &Gpu, desc: &ImageDesc) -> Result<Self> {
        let [width, height] = desc.extent;
        let limit = desc.max_side(gpu);
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(Error::Usage(format!(
                "{}: an image of {width}x{height} is impossible: each side must be 1 to {limit} on {}",
                desc.name,
                gpu.info().name
            )));
        }
        Self::make(gpu, desc, Kind::Flat)
    }

    /// Makes an array of [`ImageDesc::layers`] images, which shaders see as a whole.
    ///
    /// # Errors
    /// Errors of [`Self::new`], and [`Error::Usage`] for more layers than the device has.
    pub fn array(gpu: &Gpu, desc: &ImageDesc) -> Result<Self> {
        Self::layered(gpu, desc, Kind::Array)
    }

    /// Makes an array of cube maps, six of [`ImageDesc::layers`] each, which shaders see as a whole.
    ///
    /// # Errors
    /// Errors of [`Self::array`].
    pub fn cubes(gpu: &Gpu, desc: &ImageDesc) -> Result<Self> {
        assert!(desc.layers > 0 && desc.layers.is_multiple_of(6), "{}: a cube has six faces", desc.name);
        Self::layered(gpu, desc, Kind::Cubes)
    }

    /// Checks the size, and makes an image whose layers are images or cube maps.
    fn layered(gpu: &Gpu, desc: &ImageDesc, kind: Kind) -> Result<Self> {
        let ([width, height], limit, layers) = (desc.extent, desc.max_side(gpu), gpu.max_image_layers());
        if width == 0 || height == 0 || width > limit || height > limit || desc.layers > layers {
            return Err(Error::Usage(format!(
                "{}: an array of {} images of {width}x{height} is impossible: each side must be 1 to {limit}, and \
                 there can be {layers} of them, on {}",
                desc.name,
                desc.layers,
                gpu.info().name
            )));
        }
        Self::make(gpu, desc, kind)
    }

    /// Makes a volume of one level and one layer, which is sampled as a whole, and drawn and copied slice by slice.
    ///
    /// # Errors
    /// Errors of [`Self::new`], with the limit of volumes.
    pub fn volume(gpu: &Gpu, desc: &ImageDesc, depth: u32) -> Result<Self> {
        assert_eq!((desc.levels, desc.layers), (1, 1), "{}: a volume has one level and one layer", desc.name);
        let [width, height] = desc.extent;
        let limit = gpu.max_volume_size().min(gpu.max_image_size());
        if [width, height, depth].iter().any(|side| *side == 0 || *side > limit) {
            return Err(Error::Usage(format!(
                "{}: a volume of {width}x{height}x{depth} is impossible: each side must be 1 to {limit} on {}",
                desc.name,
                gpu.info().name
            )));
        }
        Self::make(gpu, desc, Kind::Volume(depth))
    }

    /// Makes an image whose size was checked, or takes it from the pool of the device's handle, if there is one.
    fn make(gpu: &Gpu, desc: &ImageDesc, kind: Kind) -> Result<Self> {
        match &gpu.loan {
            Some(loan) => loan.take(kind, desc, || Ok(Self::owning(OwnedImage::make(&gpu.unpooled(), desc, kind)?))),
            None => Ok(Self::owning(OwnedImage::make(gpu, desc, kind)?)),
        }
    }

    /// Makes the first handle to an image.
    fn owning(image: OwnedImage) -> Self {
        Self { name: image.name.clone(), shared: Arc::new(image) }
    }

    /// Another handle to the image, with another name.
    fn renamed(&self, name: &str) -> Self {
        Self { name: name.to_owned(), shared: Arc::clone(&self.shared) }
    }

    /// Makes an image of one level that is drawn into, read by shaders, and copied.
    pub fn target(gpu: &Gpu, name: &str, format: vk::Format, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        // Every device can store to these formats, and on some devices a load costs less than a sample.
        let is_loaded = [vk::Format::R16G16B16A16_SFLOAT, vk::Format::R32G32B32A32_UINT].contains(&format);
        let usage = if is_loaded { usage | U::STORAGE } else { usage };
        Self::new(gpu, &ImageDesc::one_level(name, format, extent, usage))
    }

    /// Makes an image like that of [`Self::target`], which programs of a shader stage write.
    pub fn target_in(gpu: &Gpu, stage: ShaderStage, name: &str, format: vk::Format, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        if stage == ShaderStage::Fragment {
            return Self::target(gpu, name, format, extent);
        }
        let usage = stage.target_usage() | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        Self::new(gpu, &ImageDesc::one_level(name, format, extent, usage))
    }

    /// Wraps an image of a swapchain, which has one level and no views, and which the swapchain destroys.
    pub fn of_swapchain(gpu: &Gpu, handle: vk::Image, format: vk::Format, extent: [u32; 2]) -> Self {
        gpu.name(handle, "swapchain");
        Self::owning(OwnedImage::bare(gpu, "swapchain", handle, (format, extent)))
    }

    /// Wraps one level, with one layer or the six of a cube, of a caller's image. Image and view must outlive this object.
    pub fn borrowed(
        gpu: &Gpu,
        name: &str,
        (handle, view): (vk::Image, vk::ImageView),
        part: vk::ImageSubresourceRange,
        (format, extent): (vk::Format, [u32; 2]),
    ) -> Self {
        let mut image = OwnedImage::bare(gpu, name, handle, (format, extent));
        (image.whole_view, image.part) = (view, Some(part));
        if part.layer_count == 6 {
            image.faces_view = view;
        }
        Self::owning(image)
    }

    /// Notes that the presentation engine handed the image over to a submission that waits for it at some stages.
    pub fn acquired(&self, wait_stages: vk::PipelineStageFlags2) {
        for state in &self.states {
            state.set(State::acquired(wait_stages));
        }
    }

    /// Width and height of level 0.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }

    /// Texel format.
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Number of mip levels.
    pub fn levels(&self) -> u32 {
        self.states.len() as u32
    }

    /// Slices of a volume; else 1.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Array layers: 6 for a cube map.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// The name that the image was made with.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One mip level.
    pub fn level(&self, level: u32) -> ImageSlice<'_> {
        assert!(level < self.levels(), "{} has {} levels, not {level}", self.name, self.levels());
        ImageSlice { image: self, base: level, count: 1, slice: None, by_face: false }
    }

    /// One slice of a volume.
    pub fn slice(&self, slice: u32) -> ImageSlice<'_> {
        assert!((slice as usize) < self.slice_views.len(), "{} has no slice {slice}", self.name);
        ImageSlice { image: self, base: 0, count: 1, slice: Some(slice), by_face: false }
    }

    /// Returns the parts that are read back one by one: the slices of a volume, else the mip levels.
    pub fn parts(&self) -> Vec<ImageSlice<'_>> {
        match self.slice_views.len() as u32 {
            0 => (0..self.levels()).map(|level| self.level(level)).collect(),
            slices => (0..slices).map(|slice| self.slice(slice)).collect(),
        }
    }

    /// All mip levels.
    pub fn all(&self) -> ImageSlice<'_> {
        ImageSlice { image: self, base: 0, count: self.levels(), slice: None, by_face: false }
    }

    /// All mip levels but the finest, if there are any.
    pub fn coarse(&self) -> Option<ImageSlice<'_>> {
        (self.levels() > 1).then(|| ImageSlice { base: 1, count: self.levels() - 1, ..self.all() })
    }

    /// All mip levels of a cube map, whose faces shaders see as an array of six images.
    pub fn faces(&self) -> ImageSlice<'_> {
        assert!(self.faces_view != vk::ImageView::null(), "{} is no cube map that shaders see", self.name);
        ImageSlice { by_face: true, ..self.all() }
    }

    /// The handle, for code that makes its own views.
    pub fn handle(&self) -> vk::Image {
        self.handle
    }
}

impl Deref for Image {
    type Target = OwnedImage;

    fn deref(&self) -> &OwnedImage {
        &self.shared
    }
}

impl OwnedImage {
    /// Makes an image of a checked size, with its memory and its views.
    fn make(gpu: &Gpu, desc: &ImageDesc, kind: Kind) -> Result<Self> {
        use vk::{ImageCreateFlags as F, ImageViewType as V};
        let [width, height] = desc.extent;
        let (depth, slices) = if let Kind::Volume(depth) = kind { (depth, depth) } else { (1, 0) };
        let (image_type, flags, view_type) = match (kind, desc.layers) {
            (Kind::Volume(_), _) => (vk::ImageType::TYPE_3D, F::TYPE_2D_ARRAY_COMPATIBLE, V::TYPE_3D),
            (Kind::Cubes, _) => (vk::ImageType::TYPE_2D, F::CUBE_COMPATIBLE, V::CUBE_ARRAY),
            (Kind::Array, _) => (vk::ImageType::TYPE_2D, F::empty(), V::TYPE_2D_ARRAY),
            (Kind::Flat, 6) => (vk::ImageType::TYPE_2D, F::CUBE_COMPATIBLE, V::CUBE),
            (Kind::Flat, _) => (vk::ImageType::TYPE_2D, F::empty(), V::TYPE_2D),
        };
        let info = vk::ImageCreateInfo::default()
            .flags(flags)
            .image_type(image_type)
            .format(desc.format)
            .extent(vk::Extent3D { width, height, depth })
            .mip_levels(desc.levels)
            .array_layers(desc.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the create info is complete; the handle is destroyed in `drop`.
        let handle = unsafe { gpu.raw().create_image(&info, None) }
            .map_err(vulkan(format!("vkCreateImage for {}", desc.name)))?;
        gpu.name(handle, desc.name);
        let mut image = Self::bare(gpu, desc.name, handle, (desc.format, desc.extent));
        (image.depth, image.layers, image.borrowed) = (depth, desc.layers, false);
        image.states = (0..desc.levels).map(|_| TrackedState::default()).collect();
        // SAFETY: the handle was just made.
        let requirements = unsafe { gpu.raw().get_image_memory_requirements(handle) };
        let allocation = memory::allocate(gpu, desc.name, requirements, MemoryPlace::Device, false)?;
        // SAFETY: the memory fits the requirements and is freed after the image.
        let bound = unsafe { gpu.raw().bind_image_memory(handle, allocation.memory(), allocation.offset()) };
        // The image frees its memory even if the binding failed.
        image.allocation = Some(allocation);
        bound.map_err(vulkan(format!("vkBindImageMemory for {}", desc.name)))?;
        let view_usages = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        if desc.usage.intersects(view_usages) {
            // A shader that reads an image with depth and stencil sees the depth alone.
            let shown = |image: &Self, range| vk::ImageSubresourceRange { aspect_mask: image.shown_aspect(), ..range };
            image.whole_view = image.view(view_type, shown(&image, image.range(0, desc.levels)))?;
            if desc.levels > 2 {
                image.coarse_view = image.view(view_type, shown(&image, image.range(1, desc.levels - 1)))?;
            }
            if view_type == V::CUBE {
                image.faces_view = image.view(V::TYPE_2D_ARRAY, shown(&image, image.range(0, desc.levels)))?;
            }
            for level in 0..desc.levels {
                image.level_views.push(image.view(view_type, shown(&image, image.range(level, 1)))?);
            }
            for slice in 0..slices {
                // A slice of a volume is a layer of its 2D views.
                let range = vk::ImageSubresourceRange { base_array_layer: slice, layer_count: 1, ..image.range(0, 1) };
                image.slice_views.push(image.view(V::TYPE_2D, range)?);
            }
            if has_stencil(desc.format) {
                image.stencil_view = image.view(V::TYPE_2D, image.range(0, 1))?;
            }
        }
        Ok(image)
    }

    /// Wraps a Vulkan image without views. The image counts as borrowed, and is not destroyed here.
    fn bare(gpu: &Gpu, name: &str, handle: vk::Image, (format, extent): (vk::Format, [u32; 2])) -> Self {
        Self {
            gpu: gpu.clone(),
            handle,
            allocation: None,
            level_views: Vec::new(),
            whole_view: vk::ImageView::null(),
            coarse_view: vk::ImageView::null(),
            faces_view: vk::ImageView::null(),
            stencil_view: vk::ImageView::null(),
            format,
            extent,
            depth: 1,
            slice_views: Vec::new(),
            layers: 1,
            states: vec![TrackedState::default()],
            name: name.to_owned(),
            borrowed: true,
            part: None,
        }
    }

    /// Makes a view of some levels and layers, which debuggers show by a name of its own.
    fn view(&self, kind: vk::ImageViewType, range: vk::ImageSubresourceRange) -> Result<vk::ImageView> {
        let info = vk::ImageViewCreateInfo::default()
            .image(self.handle)
            .view_type(kind)
            .format(self.format)
            .subresource_range(range);
        // SAFETY: the image is bound; the view is destroyed in `drop`.
        let view = unsafe { self.gpu.raw().create_image_view(&info, None) }
            .map_err(vulkan(format!("vkCreateImageView for {}", self.name)))?;
        let (level, layer) = (range.base_mip_level, range.base_array_layer);
        self.gpu.name(view, &format!("{} levels {level}+{} from layer {layer}", self.name, range.level_count));
        Ok(view)
    }

    /// The aspects of the image's format: depth, depth and stencil, or colour.
    pub(crate) fn aspect(&self) -> vk::ImageAspectFlags {
        match self.format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            f if has_stencil(f) => vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL,
            _ => vk::ImageAspectFlags::COLOR,
        }
    }

    /// The aspect that shaders and copies see: depth without stencil.
    pub(crate) fn shown_aspect(&self) -> vk::ImageAspectFlags {
        self.aspect() & !vk::ImageAspectFlags::STENCIL
    }

    /// Returns all layers of `count` levels from `base` on; for a caller's image, the part that the caller gave.
    pub(crate) fn range(&self, base: u32, count: u32) -> vk::ImageSubresourceRange {
        if let Some(part) = self.part {
            return part;
        }
        vk::ImageSubresourceRange {
            aspect_mask: self.aspect(),
            base_mip_level: base,
            level_count: count,
            base_array_layer: 0,
            // In a volume's barriers, Vulkan counts slices with maintenance9, and one layer without it. `REMAINING_ARRAY_LAYERS`
            // means the whole volume in both cases.
            layer_count: if self.depth > 1 { vk::REMAINING_ARRAY_LAYERS } else { self.layers },
        }
    }
}

impl Drop for OwnedImage {
    fn drop(&mut self) {
        let device = self.gpu.raw();
        if self.borrowed {
            return;
        }
        // SAFETY: submissions are waited for before resources are dropped (`FrameContext`); null is allowed.
        unsafe {
            for view in self.level_views.drain(..).chain(self.slice_views.drain(..)) {
                device.destroy_image_view(view, None);
            }
            device.destroy_image_view(self.whole_view, None);
            device.destroy_image_view(self.coarse_view, None);
            device.destroy_image_view(self.faces_view, None);
            device.destroy_image_view(self.stencil_view, None);
            device.destroy_image(self.handle, None);
        }
        memory::release(&self.gpu, self.allocation.take());
    }
}
