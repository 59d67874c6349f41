//! egui's triangles over an image, through egui-ash-renderer and within a [`Frame`]. Its pipeline,
//! descriptor pool and textures are its own; its memory comes from the device's allocator.

use super::device::{Gpu, vulkan};
use super::frame::Frame;
use super::image::ImageSlice;
use crate::error::{Error, Result};
use ash::vk;
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError};

/// Draws what egui tessellated.
pub struct Overlay {
    renderer: Renderer<GpuAllocator>,
    /// For the uploads of textures.
    pool: vk::CommandPool,
    /// Not drawn any more; freed before the next drawing.
    unused: Vec<egui::TextureId>,
    gpu: Gpu,
}

impl Overlay {
    /// For targets of an sRGB format.
    pub fn new(gpu: &Gpu, format: vk::Format) -> Result<Self> {
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        // One frame at a time is under way (`FrameContext`).
        let options = Options { in_flight_frames: 1, srgb_framebuffer: true, ..Options::default() };
        let renderer = Renderer::with_gpu_allocator(gpu.share_allocator(), gpu.raw().clone(), mode, options)
            .map_err(failed("making its pipeline"))?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.shared().queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the create info is complete; destroyed in `drop`.
        let pool = unsafe { gpu.raw().create_command_pool(&info, None) }.map_err(vulkan("vkCreateCommandPool"))?;
        gpu.name(pool, "overlay textures");
        Ok(Self { renderer, pool, unused: Vec::new(), gpu: gpu.clone() })
    }

    /// Uploads what changed of egui's textures, in submissions of their own, which are waited for.
    pub fn update_textures(&mut self, changes: &mut egui::TexturesDelta) -> Result<()> {
        for id in self.unused.drain(..) {
            self.renderer.free_texture(id).map_err(failed("freeing a texture"))?;
        }
        let queue = self.gpu.queue();
        for (id, delta) in changes.set.drain().flat_map(|(id, deltas)| deltas.into_iter().map(move |d| (id, d))) {
            self.gpu.count_submission();
            self.renderer.set_texture(*queue, self.pool, id, &delta).map_err(failed("uploading a texture"))?;
        }
        self.unused.extend(changes.free.drain());
        Ok(())
    }

    /// Pass "panel": draws over what the target holds.
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
                .map_err(failed("drawing"))
        })
    }
}

impl Drop for Overlay {
    fn drop(&mut self) {
        // SAFETY: uploads and frames are waited for, so nothing of the pool is under way.
        unsafe { self.gpu.raw().destroy_command_pool(self.pool, None) };
    }
}

fn failed(what: &'static str) -> impl Fn(RendererError) -> Error {
    move |e| match e {
        RendererError::Vulkan(result) => Error::Vulkan { what: format!("the panel: {what}"), result },
        other => Error::Memory { what: format!("the panel ({what})"), message: other.to_string() },
    }
}
