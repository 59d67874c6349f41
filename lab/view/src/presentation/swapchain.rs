//! A window's surface and swapchain: takes an image that is sRGB-encoded already, and shows its bits.
//!
//! The hardware encodes colours once, when an image is drawn, since the format of the image ([`Swapchain::screen_format`]) is an sRGB
//! format. The swapchain's own format need not be one.

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

/// How long to wait for an image before the caller gets a chance to handle events.
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
    /// The mode in Vulkan's terms.
    fn vulkan(self) -> vk::PresentModeKHR {
        match self {
            Self::Fifo => vk::PresentModeKHR::FIFO,
            Self::Mailbox => vk::PresentModeKHR::MAILBOX,
            Self::Immediate => vk::PresentModeKHR::IMMEDIATE,
        }
    }

    /// The mode in Vulkan's terms, if it is among those that a surface offers.
    fn among(self, offered: &[vk::PresentModeKHR]) -> Result<vk::PresentModeKHR> {
        if offered.contains(&self.vulkan()) {
            return Ok(self.vulkan());
        }
        let there: Vec<_> = Self::ALL.iter().filter(|m| offered.contains(&m.vulkan())).map(|m| m.name()).collect();
        Err(Error::usage(format!("this window does not present by {}; it does by: {}", self.name(), there.join(", "))))
    }
}

/// The instance extensions that presenting to a display's windows needs.
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
    format: SurfaceFormat,
    present_mode: vk::PresentModeKHR,
    /// Signalled when an acquired image may be written. One semaphore is enough, since every frame is waited for.
    acquired: vk::Semaphore,
    chain: Option<Chain>,
    /// Whether the presentation engine asked for another chain.
    stale: bool,
    /// Keeps the window alive for longer than its surface.
    _window: Arc<dyn Any>,
}

/// A swapchain of one size.
struct Chain {
    handle: vk::SwapchainKHR,
    extent: [u32; 2],
    images: Vec<Image>,
    /// For each image, signalled when it may be shown; free again when that image is acquired again.
    rendered: Vec<vk::Semaphore>,
}

/// A format of a surface, with our sRGB format that encodes colours for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct SurfaceFormat {
    shown: vk::SurfaceFormatKHR,
    /// The sRGB format with the same bits, which images to be shown have.
    encoded: vk::Format,
}

impl Swapchain {
    /// A surface for a window on a device that was opened with [`instance_extensions`]. Its images
    /// come with the first [`Self::prepare`].
    ///
    /// # Errors
    /// [`Error::NoWindow`] if the device cannot present to the window, [`Usage`](ssct::Error::Usage) for a mode that the surface lacks.
    pub fn new<W>(gpu: &Gpu, window: &Arc<W>, mode: PresentMode) -> Result<Self>
    where
        W: HasWindowHandle + HasDisplayHandle + 'static,
    {
        let shared = gpu.shared();
        let lost = |e: raw_window_handle::HandleError| Error::NoWindow(format!("the window has no handle: {e}"));
        let display = window.display_handle().map_err(lost)?.as_raw();
        let handle = window.window_handle().map_err(lost)?.as_raw();
        // SAFETY: both handles are the window's, which is kept for longer than the surface; so is
        // the instance, by `gpu`. Destroyed in `drop`.
        let surface = unsafe { ash_window::create_surface(&shared.entry, &shared.instance, display, handle, None) }
            .map_err(vulkan("creating the window's surface"))?;
        let mut made = Self {
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
        made.negotiate(mode)?;
        made.acquired = semaphore(gpu, "acquired")?;
        Ok(made)
    }

    /// Prepares for a window of a size in pixels, with another chain if the size changed or the presentation engine asked for one. Returns
    /// the size to render; `None` while the window is minimised, so that there is nothing to draw to.
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

    /// The format of images that [`Self::present`] takes.
    pub fn screen_format(&self) -> vk::Format {
        self.format.encoded
    }

    /// Shows an image of [`Self::screen_format`] and of the size that [`Self::prepare`] returned, after `record` drew it in the same
    /// submission.
    /// Returns false if the image was neither drawn nor shown, because the window changed in the meantime or is hidden; the caller then
    /// calls [`Self::prepare`] and draws again.
    ///
    /// # Errors
    /// Any Vulkan failure; the swapchain is then fit only to be dropped.
    pub fn present(
        &mut self,
        context: &mut FrameContext,
        screen: &Image,
        record: impl FnOnce(&mut Frame) -> ssct::Result<()>,
    ) -> Result<bool> {
        let Some(chain) = &self.chain else { return Ok(false) };
        // SAFETY: the semaphore is unsignalled, since the submission that waited for it is done.
        let next = unsafe {
            self.swapchains.acquire_next_image(chain.handle, ACQUIRE_TIMEOUT_NS, self.acquired, vk::Fence::null())
        };
        let (index, suboptimal) = match next {
            Ok(next) => next,
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
        // SAFETY: the image is acquired and in the layout to present, by the submission that signals
        // the semaphore.
        let shown = unsafe { self.swapchains.queue_present(*self.gpu.queue()?, &info) };
        match shown {
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

    /// Finds a format and a present mode that device and surface have in common.
    fn negotiate(&mut self, mode: PresentMode) -> Result<()> {
        let (shared, name) = (self.gpu.shared(), &self.gpu.info().name);
        // SAFETY: the physical device and the surface belong to one instance.
        let (presents, formats, modes) = unsafe {
            let (s, physical) = (&self.surfaces, shared.physical);
            (
                s.get_physical_device_surface_support(physical, shared.queue_family, self.surface)
                    .map_err(vulkan("vkGetPhysicalDeviceSurfaceSupportKHR"))?,
                s.get_physical_device_surface_formats(physical, self.surface)
                    .map_err(vulkan("vkGetPhysicalDeviceSurfaceFormatsKHR"))?,
                s.get_physical_device_surface_present_modes(physical, self.surface)
                    .map_err(vulkan("vkGetPhysicalDeviceSurfacePresentModesKHR"))?,
            )
        };
        if !presents || !self.capabilities()?.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(Error::NoWindow(format!("{name} cannot present to it; another device may")));
        }
        let encodes = |format| {
            // SAFETY: the physical device belongs to the instance.
            let p = unsafe { shared.instance.get_physical_device_format_properties(shared.physical, format) };
            p.optimal_tiling_features.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND)
        };
        self.format = surface_format(&formats, encodes)
            .ok_or_else(|| Error::NoWindow(format!("{name} has no 8-bit sRGB format for it")))?;
        self.present_mode = mode.among(&modes)?;
        Ok(())
    }

    fn capabilities(&self) -> Result<vk::SurfaceCapabilitiesKHR> {
        // SAFETY: the physical device and the surface belong to one instance.
        let capabilities =
            unsafe { self.surfaces.get_physical_device_surface_capabilities(self.gpu.shared().physical, self.surface) };
        Ok(capabilities.map_err(vulkan("vkGetPhysicalDeviceSurfaceCapabilitiesKHR"))?)
    }

    /// Replaces the chain.
    fn rebuild(&mut self, capabilities: &vk::SurfaceCapabilitiesKHR, extent: [u32; 2]) -> Result<()> {
        let old = self.chain.take();
        let created =
            self.create_chain(capabilities, extent, old.as_ref().map_or(vk::SwapchainKHR::null(), |c| c.handle));
        self.destroy_chain(old);
        let handle = created?;
        let chain = self.chain.insert(Chain { handle, extent, images: Vec::new(), rendered: Vec::new() });
        // SAFETY: the swapchain was just made.
        let images =
            unsafe { self.swapchains.get_swapchain_images(handle) }.map_err(vulkan("vkGetSwapchainImagesKHR"))?;
        for image in images {
            chain.images.push(Image::of_swapchain(&self.gpu, image, self.format.shown.format, extent));
            chain.rendered.push(semaphore(&self.gpu, "rendered")?);
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
        // One image more than the engine may hold back, so that one can be written.
        let most = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        // The lowest bit is "opaque" where that is supported; one bit always is.
        let alphas = capabilities.supported_composite_alpha.as_raw();
        let alpha = vk::CompositeAlphaFlagsKHR::from_raw(alphas & alphas.wrapping_neg());
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.surface)
            .min_image_count((capabilities.min_image_count + 1).min(most))
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

    /// Destroys a swapchain and its semaphores, after the device has finished.
    fn destroy_chain(&self, chain: Option<Chain>) {
        let Some(mut chain) = chain else { return };
        let device = self.gpu.raw();
        // The swapchain owns the handles, so that they are forgotten before it is destroyed.
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
        // SAFETY: the chain is gone and the device was idle then; null is allowed.
        unsafe {
            self.gpu.raw().destroy_semaphore(self.acquired, None);
            self.surfaces.destroy_surface(self.surface, None);
        }
    }
}

fn semaphore(gpu: &Gpu, name: &str) -> Result<vk::Semaphore> {
    // SAFETY: the create info is complete; whoever keeps the semaphore destroys it.
    let made = unsafe { gpu.raw().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
        .map_err(vulkan("vkCreateSemaphore"))?;
    gpu.name(made, name);
    Ok(made)
}

/// The size of a surface's images: the size that the surface states, or else that of the window within the surface's limits.
fn surface_extent(capabilities: &vk::SurfaceCapabilitiesKHR, window: [u32; 2]) -> [u32; 2] {
    let (now, min, max) = (capabilities.current_extent, capabilities.min_image_extent, capabilities.max_image_extent);
    if now.width != u32::MAX {
        return [now.width, now.height];
    }
    if window.contains(&0) {
        return [0, 0];
    }
    [window[0].min(max.width).max(min.width), window[1].min(max.height).max(min.height)]
}

/// An offered sRGB format, or else an offered format that shares its bits with an sRGB format. In both cases, the device must be able to
/// draw to the sRGB format.
fn surface_format(offered: &[vk::SurfaceFormatKHR], encodes: impl Fn(vk::Format) -> bool) -> Option<SurfaceFormat> {
    use vk::Format as F;
    const PAIRS: [(F, F); 2] = [(F::B8G8R8A8_SRGB, F::B8G8R8A8_UNORM), (F::R8G8B8A8_SRGB, F::R8G8B8A8_UNORM)];
    let offered = |format| {
        offered.iter().copied().find(|o| o.format == format && o.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR)
    };
    let pairs = || PAIRS.into_iter().filter(|(srgb, _)| encodes(*srgb));
    let direct = pairs().find_map(|(srgb, _)| Some(SurfaceFormat { shown: offered(srgb)?, encoded: srgb }));
    direct.or_else(|| pairs().find_map(|(srgb, unorm)| Some(SurfaceFormat { shown: offered(unorm)?, encoded: srgb })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vk::Format as F;

    fn offer(format: F) -> vk::SurfaceFormatKHR {
        vk::SurfaceFormatKHR { format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR }
    }

    #[test]
    fn an_srgb_format_is_taken_wherever_it_stands() {
        let offers = [offer(F::B8G8R8A8_UNORM), offer(F::A2B10G10R10_UNORM_PACK32), offer(F::R8G8B8A8_SRGB)];
        let taken = surface_format(&offers, |_| true).unwrap();
        assert_eq!((taken.shown.format, taken.encoded), (F::R8G8B8A8_SRGB, F::R8G8B8A8_SRGB));
    }

    #[test]
    fn without_one_its_bits_are_copied_in_the_same_order_of_channels() {
        let taken = surface_format(&[offer(F::B8G8R8A8_UNORM)], |_| true).unwrap();
        assert_eq!((taken.shown.format, taken.encoded), (F::B8G8R8A8_UNORM, F::B8G8R8A8_SRGB));
        let both = [offer(F::B8G8R8A8_UNORM), offer(F::R8G8B8A8_UNORM)];
        let taken = surface_format(&both, |f| f == F::R8G8B8A8_SRGB).unwrap();
        assert_eq!((taken.shown.format, taken.encoded), (F::R8G8B8A8_UNORM, F::R8G8B8A8_SRGB));
    }

    #[test]
    fn another_colour_space_or_depth_is_not_taken() {
        let wide =
            vk::SurfaceFormatKHR { format: F::B8G8R8A8_SRGB, color_space: vk::ColorSpaceKHR::EXTENDED_SRGB_LINEAR_EXT };
        assert_eq!(surface_format(&[wide, offer(F::R16G16B16A16_SFLOAT)], |_| true), None);
        assert_eq!(surface_format(&[offer(F::B8G8R8A8_SRGB)], |_| false), None);
    }

    #[test]
    fn the_surface_says_the_size_or_the_window_does() {
        let size = |width, height| vk::Extent2D { width, height };
        let mut c = vk::SurfaceCapabilitiesKHR {
            current_extent: size(640, 480),
            min_image_extent: size(1, 1),
            max_image_extent: size(4096, 4096),
            ..Default::default()
        };
        assert_eq!(surface_extent(&c, [10, 10]), [640, 480]);
        c.current_extent = size(u32::MAX, u32::MAX);
        assert_eq!(surface_extent(&c, [10_000, 10]), [4096, 10]);
        assert_eq!(surface_extent(&c, [0, 10]), [0, 0], "minimised");
        c.current_extent = size(0, 0);
        assert_eq!(surface_extent(&c, [640, 480]), [0, 0], "minimised, as Windows says it");
    }

    #[test]
    fn a_mode_that_is_not_there_is_a_sentence() {
        let offered = [vk::PresentModeKHR::IMMEDIATE, vk::PresentModeKHR::FIFO];
        assert_eq!(PresentMode::Immediate.among(&offered).unwrap(), vk::PresentModeKHR::IMMEDIATE);
        let error = PresentMode::Mailbox.among(&offered).unwrap_err().to_string();
        assert!(error.contains("fifo, immediate"), "{error}");
    }
}
