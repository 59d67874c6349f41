//! A window's surface and swapchain: takes an image whose colours are already sRGB-encoded, and shows its bits
//! unchanged.
//!
//! The hardware encodes colours when it draws the image, since the image's format ([`Swapchain::screen_format`]) is an
//! sRGB format. The format of the swapchain itself need not be one.

use ash::vk;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use ssct::gpu::device::{Gpu, vulkan};
use ssct::gpu::frame::{Frame, FrameContext, Mode};
use ssct::gpu::image::Image;
use ssct::gpu::sync::Access;
use ssct_ground::parameter::{Choices, choices};
use ssct_lab::error::{Error, Result};
use std::any::Any;
use std::ffi::CStr;
use std::sync::Arc;

/// How long to wait for an image, in nanoseconds, before the caller gets a chance to handle events.
const ACQUIRE_TIMEOUT_NS: u64 = 1_000_000_000;

choices! {
    /// How images replace one another on the screen.
    pub enum PresentMode {
        /// In order, at the display's pace; every surface has it.
        Fifo = "fifo",
        /// The newest, at the display's pace; rendering does not wait.
        Mailbox = "mailbox",
        /// At once, and it may tear.
        Immediate = "immediate",
    }
}

impl PresentMode {
    /// Returns Vulkan's value for the mode.
    fn vulkan(self) -> vk::PresentModeKHR {
        match self {
            Self::Fifo => vk::PresentModeKHR::FIFO,
            Self::Mailbox => vk::PresentModeKHR::MAILBOX,
            Self::Immediate => vk::PresentModeKHR::IMMEDIATE,
        }
    }

    /// Returns Vulkan's value for the mode; an error that lists the offered modes if the surface does not offer this
    /// one.
    fn choose_offered(self, offered: &[vk::PresentModeKHR]) -> Result<vk::PresentModeKHR> {
        if offered.contains(&self.vulkan()) {
            return Ok(self.vulkan());
        }
        let names: Vec<_> = Self::ALL.iter().filter(|m| offered.contains(&m.vulkan())).map(|m| m.name()).collect();
        Err(Error::usage(format!("this window does not present by {}; it does by: {}", self.name(), names.join(", "))))
    }
}

/// Returns the names of the instance extensions that presenting to a display's windows needs.
///
/// # Errors
/// [`Error::NoWindow`] for a window system that Vulkan doesn't know.
pub fn instance_extensions(display: &impl HasDisplayHandle) -> Result<Vec<&'static CStr>> {
    let unknown = |why: String| Error::NoWindow(format!("the display cannot be drawn to by Vulkan: {why}"));
    let handle = display.display_handle().map_err(|e| unknown(e.to_string()))?;
    let names = ash_window::enumerate_required_extensions(handle.as_raw()).map_err(|e| unknown(e.to_string()))?;
    // SAFETY: the names are static, null-terminated names of ash.
    Ok(names.iter().map(|name| unsafe { CStr::from_ptr(*name) }).collect())
}

/// A window's surface and the images shown on it.
pub struct Swapchain {
    gpu: Gpu,
    surfaces: ash::khr::surface::Instance,
    surface: vk::SurfaceKHR,
    swapchains: ash::khr::swapchain::Device,
    /// The formats of the swapchain's images and of the image to show.
    format: SurfaceFormat,
    present_mode: vk::PresentModeKHR,
    /// Signalled when an acquired image may be written. One semaphore is enough, since every frame is waited for.
    acquired: vk::Semaphore,
    chain: Option<Chain>,
    /// Whether the presentation engine asked for a new swapchain.
    stale: bool,
    /// Keeps the window alive for longer than its surface.
    _window: Arc<dyn Any>,
}

/// A swapchain of one size.
struct Chain {
    handle: vk::SwapchainKHR,
    extent: [u32; 2],
    images: Vec<Image>,
    /// A semaphore for each image, signalled when the image may be shown. It may be used again once the image is
    /// acquired again.
    rendered: Vec<vk::Semaphore>,
}

/// A format of a surface, with the sRGB format of the images that are copied to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct SurfaceFormat {
    /// The format of the swapchain's images.
    shown: vk::SurfaceFormatKHR,
    /// The sRGB format with the same bits, in which images to be shown are drawn.
    encoded: vk::Format,
}

impl Swapchain {
    /// Makes a surface for a window, on a device that was opened with [`instance_extensions`]. The first
    /// [`Self::prepare`] makes the images.
    ///
    /// # Errors
    /// [`Error::NoWindow`] if the device cannot present to the window, and [`Usage`](ssct::Error::Usage) for a mode
    /// that the surface lacks.
    pub fn new<W>(gpu: &Gpu, window: &Arc<W>, mode: PresentMode) -> Result<Self>
    where
        W: HasWindowHandle + HasDisplayHandle + 'static,
    {
        let shared = gpu.shared();
        let lost = |e: raw_window_handle::HandleError| Error::NoWindow(format!("the window has no handle: {e}"));
        let display = window.display_handle().map_err(lost)?.as_raw();
        let handle = window.window_handle().map_err(lost)?.as_raw();
        // SAFETY: both handles are the window's, which lives longer than the surface, and so does the instance, by
        // `gpu`. The surface is destroyed in `drop`.
        let surface = unsafe { ash_window::create_surface(&shared.entry, &shared.instance, display, handle, None) }
            .map_err(vulkan("creating the window's surface"))?;
        let mut swapchain = Self {
            gpu: gpu.clone(),
            surfaces: ash::khr::surface::Instance::new(&shared.entry, &shared.instance),
            surface,
            swapchains: ash::khr::swapchain::Device::new(&shared.instance, &shared.device),
            format: SurfaceFormat { shown: vk::SurfaceFormatKHR::default(), encoded: vk::Format::UNDEFINED },
            present_mode: vk::PresentModeKHR::FIFO,
            acquired: vk::Semaphore::null(),
            chain: None,
            stale: false,
            _window: window.clone(),
        };
        swapchain.choose_format_and_mode(mode)?;
        swapchain.acquired = make_semaphore(gpu, "acquired")?;
        Ok(swapchain)
    }

    /// Prepares for a window of a size in pixels: makes a new swapchain if the size changed or the presentation engine
    /// asked for one. Returns the size to render; `None` while the window is minimised, so that nothing can be shown.
    pub fn prepare(&mut self, window: [u32; 2]) -> Result<Option<[u32; 2]>> {
        let capabilities = self.capabilities()?;
        let extent = surface_extent(&capabilities, window);
        if extent.contains(&0) {
            return Ok(None);
        }
        if self.stale || self.chain.as_ref().is_none_or(|c| c.extent != extent) {
            self.rebuild(&capabilities, extent)?;
        }
        Ok(Some(extent))
    }

    /// Returns the format of the images that [`Self::present`] takes.
    pub fn screen_format(&self) -> vk::Format {
        self.format.encoded
    }

    /// Records the drawing of the image `screen` by `record`, and shows it, in one submission. The image has
    /// [`Self::screen_format`] and the size that [`Self::prepare`] returned. Returns false if the image was not shown,
    /// because the window changed in the meantime or is hidden. The caller then calls [`Self::prepare`] and draws
    /// again.
    ///
    /// # Errors
    /// Any Vulkan failure; the swapchain must then be dropped.
    pub fn present(
        &mut self,
        context: &mut FrameContext,
        screen: &Image,
        record: impl FnOnce(&mut Frame) -> ssct::Result<()>,
    ) -> Result<bool> {
        let Some(chain) = &self.chain else { return Ok(false) };
        // SAFETY: the semaphore is unsignalled, since the submission that waited for it is done.
        let acquired = unsafe {
            self.swapchains.acquire_next_image(chain.handle, ACQUIRE_TIMEOUT_NS, self.acquired, vk::Fence::null())
        };
        let (index, suboptimal) = match acquired {
            Ok(index_and_suboptimal) => index_and_suboptimal,
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(false),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                return Ok(false);
            }
            Err(e) => return Err(vulkan("vkAcquireNextImageKHR")(e).into()),
        };
        let (target, rendered) = (&chain.images[index as usize], chain.rendered[index as usize]);
        let wait_stages = Access::TransferWrite.info().stages;
        target.acquired(wait_stages);
        let mut frame = context.begin(Mode::Plain)?;
        record(&mut frame)?;
        frame.copy("present", screen.all(), target.all())?;
        frame.make_ready(target.all(), Access::Present);
        frame.finish_presenting(self.acquired, wait_stages, rendered)?;

        let (waits, handles, indices) = ([rendered], [chain.handle], [index]);
        let info = vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&handles).image_indices(&indices);
        // SAFETY: the image is acquired, and the submission that signals the semaphore puts it into the layout to
        // present.
        let presented = unsafe { self.swapchains.queue_present(*self.gpu.queue()?, &info) };
        match presented {
            Ok(also_suboptimal) => {
                self.stale |= suboptimal || also_suboptimal;
                Ok(true)
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                Ok(false)
            }
            Err(e) => Err(vulkan("vkQueuePresentKHR")(e).into()),
        }
    }

    /// Chooses the format and the present mode from those that device and surface have in common.
    fn choose_format_and_mode(&mut self, mode: PresentMode) -> Result<()> {
        let (shared, name) = (self.gpu.shared(), &self.gpu.info().name);
        // SAFETY: the physical device and the surface belong to one instance.
        let (presents, formats, modes) = unsafe {
            let (surfaces, physical) = (&self.surfaces, shared.physical);
            (
                surfaces
                    .get_physical_device_surface_support(physical, shared.queue_family, self.surface)
                    .map_err(vulkan("vkGetPhysicalDeviceSurfaceSupportKHR"))?,
                surfaces
                    .get_physical_device_surface_formats(physical, self.surface)
                    .map_err(vulkan("vkGetPhysicalDeviceSurfaceFormatsKHR"))?,
                surfaces
                    .get_physical_device_surface_present_modes(physical, self.surface)
                    .map_err(vulkan("vkGetPhysicalDeviceSurfacePresentModesKHR"))?,
            )
        };
        if !presents || !self.capabilities()?.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(Error::NoWindow(format!("{name} cannot present to it; another device may")));
        }
        // Whether the device can draw to a format, and blend in it.
        let encodes = |format| {
            // SAFETY: the physical device belongs to the instance.
            let properties = unsafe { shared.instance.get_physical_device_format_properties(shared.physical, format) };
            properties.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND)
        };
        self.format = surface_format(&formats, encodes)
            .ok_or_else(|| Error::NoWindow(format!("{name} has no 8-bit sRGB format for it")))?;
        self.present_mode = mode.choose_offered(&modes)?;
        Ok(())
    }

    /// Returns the present capabilities of the surface, such as its size.
    fn capabilities(&self) -> Result<vk::SurfaceCapabilitiesKHR> {
        // SAFETY: the physical device and the surface belong to one instance.
        let capabilities =
            unsafe { self.surfaces.get_physical_device_surface_capabilities(self.gpu.shared().physical, self.surface) };
        Ok(capabilities.map_err(vulkan("vkGetPhysicalDeviceSurfaceCapabilitiesKHR"))?)
    }

    /// Replaces the swapchain by a new one of a size in pixels.
    fn rebuild(&mut self, capabilities: &vk::SurfaceCapabilitiesKHR, extent: [u32; 2]) -> Result<()> {
        let old = self.chain.take();
        let created =
            self.create_chain(capabilities, extent, old.as_ref().map_or(vk::SwapchainKHR::null(), |c| c.handle));
        self.destroy_chain(old);
        let handle = created?;
        let chain = self.chain.insert(Chain { handle, extent, images: Vec::new(), rendered: Vec::new() });
        // SAFETY: the swapchain has just been made.
        let images =
            unsafe { self.swapchains.get_swapchain_images(handle) }.map_err(vulkan("vkGetSwapchainImagesKHR"))?;
        for image in images {
            chain.images.push(Image::of_swapchain(&self.gpu, image, self.format.shown.format, extent));
            chain.rendered.push(make_semaphore(&self.gpu, "rendered")?);
        }
        self.stale = false;
        Ok(())
    }

    /// Makes a swapchain of a size, which takes the place of the `old` one.
    fn create_chain(
        &self,
        capabilities: &vk::SurfaceCapabilitiesKHR,
        [width, height]: [u32; 2],
        old: vk::SwapchainKHR,
    ) -> Result<vk::SwapchainKHR> {
        // One image more than the presentation engine may hold back, so that one can be written. A maximum of 0 means
        // no limit.
        let max_images = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        // The lowest supported bit is chosen, which is "opaque" if the surface supports this. At least one bit is
        // supported.
        let alphas = capabilities.supported_composite_alpha.as_raw();
        let alpha = vk::CompositeAlphaFlagsKHR::from_raw(alphas & alphas.wrapping_neg());
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.surface)
            .min_image_count((capabilities.min_image_count + 1).min(max_images))
            .image_format(self.format.shown.format)
            .image_color_space(self.format.shown.color_space)
            .image_extent(vk::Extent2D { width, height })
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(alpha)
            .present_mode(self.present_mode)
            .clipped(true)
            .old_swapchain(old);
        // SAFETY: the create info is complete; the old chain, if any, is this surface's.
        Ok(unsafe { self.swapchains.create_swapchain(&info, None) }.map_err(vulkan("vkCreateSwapchainKHR"))?)
    }

    /// Waits until the device is idle, and destroys a swapchain and its semaphores.
    fn destroy_chain(&self, chain: Option<Chain>) {
        let Some(mut chain) = chain else { return };
        let device = self.gpu.raw();
        // The swapchain owns the images, so that the wrappers of their handles are dropped before it is destroyed.
        chain.images.clear();
        let queue = self.gpu.queue();
        // SAFETY: the queue is held while the device is waited for, and nothing uses the chain then.
        unsafe {
            let _ = device.device_wait_idle();
            for semaphore in chain.rendered.drain(..) {
                device.destroy_semaphore(semaphore, None);
            }
            self.swapchains.destroy_swapchain(chain.handle, None);
        }
        drop(queue);
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        let chain = self.chain.take();
        self.destroy_chain(chain);
        // SAFETY: the chain is destroyed, for which the device was idle; null handles are allowed.
        unsafe {
            self.gpu.raw().destroy_semaphore(self.acquired, None);
            self.surfaces.destroy_surface(self.surface, None);
        }
    }
}

/// Makes a semaphore with a debug name, which the caller must destroy.
fn make_semaphore(gpu: &Gpu, name: &str) -> Result<vk::Semaphore> {
    // SAFETY: the create info is complete; the caller destroys the semaphore.
    let semaphore = unsafe { gpu.raw().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
        .map_err(vulkan("vkCreateSemaphore"))?;
    gpu.name(semaphore, name);
    Ok(semaphore)
}

/// Returns the size of a surface's images in pixels: the size that the surface states, or else the window's size within
/// the surface's limits. It is 0 for a minimised window.
fn surface_extent(capabilities: &vk::SurfaceCapabilitiesKHR, window: [u32; 2]) -> [u32; 2] {
    let (stated, min, max) =
        (capabilities.current_extent, capabilities.min_image_extent, capabilities.max_image_extent);
    // Vulkan's value for a surface that leaves its size to the swapchain.
    if stated.width != u32::MAX {
        return [stated.width, stated.height];
    }
    if window.contains(&0) {
        return [0, 0];
    }
    [window[0].min(max.width).max(min.width), window[1].min(max.height).max(min.height)]
}

/// Chooses an offered sRGB format, or else an offered format that has the same bits as an sRGB format. `encodes` says
/// whether the device can draw to an sRGB format, which is a condition in both cases.
fn surface_format(offered: &[vk::SurfaceFormatKHR], encodes: impl Fn(vk::Format) -> bool) -> Option<SurfaceFormat> {
    use vk::Format as F;
    /// Each sRGB format with the format of the same bits.
    const FORMATS: [(F, F); 2] = [(F::B8G8R8A8_SRGB, F::B8G8R8A8_UNORM), (F::R8G8B8A8_SRGB, F::R8G8B8A8_UNORM)];
    let find = |format| {
        offered.iter().copied().find(|o| o.format == format && o.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR)
    };
    let drawable = || FORMATS.into_iter().filter(|(srgb, _)| encodes(*srgb));
    let direct = drawable().find_map(|(srgb, _)| Some(SurfaceFormat { shown: find(srgb)?, encoded: srgb }));
    direct.or_else(|| drawable().find_map(|(srgb, unorm)| Some(SurfaceFormat { shown: find(unorm)?, encoded: srgb })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vk::Format as F;

    /// Returns an offered format in the usual colour space.
    fn offer(format: F) -> vk::SurfaceFormatKHR {
        vk::SurfaceFormatKHR { format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR }
    }

    #[test]
    fn an_srgb_format_is_taken_wherever_it_stands_among_the_offers() {
        let offers = [offer(F::B8G8R8A8_UNORM), offer(F::A2B10G10R10_UNORM_PACK32), offer(F::R8G8B8A8_SRGB)];
        let taken = surface_format(&offers, |_| true).unwrap();
        assert_eq!((taken.shown.format, taken.encoded), (F::R8G8B8A8_SRGB, F::R8G8B8A8_SRGB));
    }

    #[test]
    fn without_an_srgb_format_one_with_the_same_bits_is_taken() {
        let taken = surface_format(&[offer(F::B8G8R8A8_UNORM)], |_| true).unwrap();
        assert_eq!((taken.shown.format, taken.encoded), (F::B8G8R8A8_UNORM, F::B8G8R8A8_SRGB));
        // The device can draw to one of the two sRGB formats alone, which decides.
        let two_orders = [offer(F::B8G8R8A8_UNORM), offer(F::R8G8B8A8_UNORM)];
        let taken = surface_format(&two_orders, |f| f == F::R8G8B8A8_SRGB).unwrap();
        assert_eq!((taken.shown.format, taken.encoded), (F::R8G8B8A8_UNORM, F::R8G8B8A8_SRGB));
    }

    #[test]
    fn a_format_of_another_colour_space_or_depth_or_that_cannot_be_drawn_to_is_not_taken() {
        let wide =
            vk::SurfaceFormatKHR { format: F::B8G8R8A8_SRGB, color_space: vk::ColorSpaceKHR::EXTENDED_SRGB_LINEAR_EXT };
        assert_eq!(surface_format(&[wide, offer(F::R16G16B16A16_SFLOAT)], |_| true), None);
        assert_eq!(surface_format(&[offer(F::B8G8R8A8_SRGB)], |_| false), None);
    }

    #[test]
    fn the_size_is_that_of_the_surface_or_else_that_of_the_window_within_its_limits() {
        let size = |width, height| vk::Extent2D { width, height };
        let mut capabilities = vk::SurfaceCapabilitiesKHR {
            current_extent: size(640, 480),
            min_image_extent: size(1, 1),
            max_image_extent: size(4096, 4096),
            ..Default::default()
        };
        assert_eq!(surface_extent(&capabilities, [10, 10]), [640, 480]);
        capabilities.current_extent = size(u32::MAX, u32::MAX);
        assert_eq!(surface_extent(&capabilities, [10_000, 10]), [4096, 10]);
        assert_eq!(surface_extent(&capabilities, [0, 10]), [0, 0], "minimised");
        capabilities.current_extent = size(0, 0);
        assert_eq!(surface_extent(&capabilities, [640, 480]), [0, 0], "minimised, as Windows says it");
    }

    #[test]
    fn a_mode_that_the_surface_lacks_is_refused_with_those_that_it_has() {
        let offered = [vk::PresentModeKHR::IMMEDIATE, vk::PresentModeKHR::FIFO];
        assert_eq!(PresentMode::Immediate.choose_offered(&offered).unwrap(), vk::PresentModeKHR::IMMEDIATE);
        let error = PresentMode::Mailbox.choose_offered(&offered).unwrap_err().to_string();
        assert!(error.contains("fifo, immediate"), "{error}");
    }
}
