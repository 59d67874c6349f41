//! Draws egui's triangles over an image, by egui-ash-renderer and within a [`Frame`]. The renderer has a pipeline and a
//! descriptor pool of its own.
//!
//! The buffers and textures of the renderer are made here, so that each of them is destroyed before its memory. The
//! allocators that come with the renderer free the memory first, to which the validation layers object.

use ash::vk;
use egui_ash_renderer::allocator::Allocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError, RendererResult};
use ssct::error::{Error, Result};
use ssct::gpu::device::{Gpu, vulkan};
use ssct::gpu::frame::Frame;
use ssct::gpu::image::{Image, ImageDesc, ImageSlice};
use ssct::gpu::memory::{Buffer, MemoryPlace};

/// Draws the triangles into which egui has divided the panel.
pub struct Overlay {
    renderer: Renderer<Memory>,
    /// The pool of the commands that upload textures.
    pool: vk::CommandPool,
    /// Textures that are not drawn any more; they are freed before the next drawing.
    unused: Vec<egui::TextureId>,
    gpu: Gpu,
}

impl Overlay {
    /// Makes an overlay for targets of an sRGB format.
    pub fn new(gpu: &Gpu, format: vk::Format) -> Result<Self> {
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        // `FrameContext` waits for each frame before the next.
        let options = Options { in_flight_frames: 1, srgb_framebuffer: true, ..Options::default() };
        let renderer = Renderer::with_allocator(Memory(gpu.clone()), gpu.raw().clone(), mode, options)
            .map_err(named_error("making its pipeline"))?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.shared().queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the create info is complete; destroyed in `drop`.
        let pool = unsafe { gpu.raw().create_command_pool(&info, None) }.map_err(vulkan("vkCreateCommandPool"))?;
        gpu.name(pool, "overlay textures");
        Ok(Self { renderer, pool, unused: Vec::new(), gpu: gpu.clone() })
    }

    /// Uploads the changes of egui's textures, in submissions of their own, and waits for these.
    pub fn update_textures(&mut self, changes: &mut egui::TexturesDelta) -> Result<()> {
        for id in self.unused.drain(..) {
            self.renderer.free_texture(id).map_err(named_error("freeing a texture"))?;
        }
        let queue = self.gpu.queue()?;
        for (id, delta) in changes.set.drain().flat_map(|(id, deltas)| deltas.into_iter().map(move |d| (id, d))) {
            self.gpu.count_submission();
            self.renderer.set_texture(*queue, self.pool, id, &delta).map_err(named_error("uploading a texture"))?;
        }
        self.unused.extend(changes.free.drain());
        Ok(())
    }

    /// Records the pass "panel", which draws egui's triangles over the content of the target.
    pub fn record(
        &mut self,
        frame: &mut Frame,
        target: ImageSlice,
        pixels_per_point: f32,
        triangles: &[egui::ClippedPrimitive],
    ) -> Result<()> {
        let [width, height] = target.extent();
        frame.overlay("panel", target, |commands| {
            self.renderer
                .cmd_draw(commands, vk::Extent2D { width, height }, pixels_per_point, triangles)
                .map_err(named_error("drawing"))
        })
    }
}

impl Drop for Overlay {
    fn drop(&mut self) {
        // SAFETY: uploads and frames are waited for, so nothing of the pool is under way.
        unsafe { self.gpu.raw().destroy_command_pool(self.pool, None) };
    }
}

/// The allocator that makes the renderer's buffers and textures.
struct Memory(Gpu);

/// A buffer or a texture of the renderer.
enum OverlayResource {
    Buffer(Buffer),
    /// The image is never read: it keeps the texture alive as long as the renderer uses it.
    Image(#[allow(dead_code)] Image),
}

impl Allocator for Memory {
    type Allocation = OverlayResource;

    fn create_buffer(
        &mut self,
        _: &ash::Device,
        size: usize,
        usage: vk::BufferUsageFlags,
    ) -> RendererResult<(vk::Buffer, OverlayResource)> {
        let buffer = Buffer::new(&self.0, "panel", size as u64, usage, MemoryPlace::Upload).map_err(renderer_error)?;
        Ok((buffer.handle(), OverlayResource::Buffer(buffer)))
    }

    fn create_image(
        &mut self,
        _: &ash::Device,
        width: u32,
        height: u32,
    ) -> RendererResult<(vk::Image, OverlayResource)> {
        let image = Image::new(
            &self.0,
            &ImageDesc {
                name: "panel texture",
                // The renderer makes its own view of this format.
                format: vk::Format::R8G8B8A8_SRGB,
                extent: [width, height],
                levels: 1,
                layers: 1,
                usage: vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED,
            },
        )
        .map_err(renderer_error)?;
        Ok((image.handle(), OverlayResource::Image(image)))
    }

    fn destroy_buffer(&mut self, _: &ash::Device, _: vk::Buffer, memory: OverlayResource) -> RendererResult<()> {
        drop(memory);
        Ok(())
    }

    fn destroy_image(&mut self, _: &ash::Device, _: vk::Image, memory: OverlayResource) -> RendererResult<()> {
        drop(memory);
        Ok(())
    }

    fn update_buffer<T: Copy>(
        &mut self,
        _: &ash::Device,
        memory: &mut OverlayResource,
        data: &[T],
    ) -> RendererResult<()> {
        let OverlayResource::Buffer(buffer) = memory else {
            return Err(RendererError::Allocator("a texture is no buffer".into()));
        };
        let size = size_of_val(data);
        let Some(bytes) = buffer.bytes_mut().map_err(renderer_error)?.get_mut(..size) else {
            return Err(RendererError::Allocator(format!("a buffer has no room for {size} bytes")));
        };
        // SAFETY: both are `size` bytes long, and the buffer's bytes do not overlap the data's.
        unsafe { std::ptr::copy_nonoverlapping(data.as_ptr().cast(), bytes.as_mut_ptr(), size) };
        Ok(())
    }
}

/// Turns an error of this program into an error of the renderer.
fn renderer_error(error: Error) -> RendererError {
    match error {
        Error::Vulkan { result, .. } => RendererError::Vulkan(result),
        other => RendererError::Allocator(other.to_string()),
    }
}

/// Returns a function that turns an error of the renderer into an error of this program; `what` says what the renderer
/// did.
fn named_error(what: &'static str) -> impl Fn(RendererError) -> Error {
    move |e| match e {
        RendererError::Vulkan(result) => Error::Vulkan { what: format!("the panel: {what}"), result },
        other => Error::Memory { what: format!("the panel ({what})"), message: other.to_string() },
    }
}
