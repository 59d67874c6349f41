//! The targets that a pass draws into, their content when the pass begins, and dynamic rendering around its draws.

use super::Frame;
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::sync::Access;
use ash::vk;

/// A colour or depth attachment.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// `None` for an output that nobody wants.
    slice: Option<ImageSlice<'a>>,
    load: Load,
}

/// What an attachment holds when a pass begins.
#[derive(Clone, Copy, PartialEq)]
enum Load {
    /// Undefined content.
    Lost,
    /// One value. A stencil beside a depth is kept.
    Cleared([f32; 4]),
    /// The content from before the pass.
    Kept,
    /// A cleared stencil; the depth is lost.
    Unmarked,
}

impl<'a> Target<'a> {
    /// A target whose texels are all written; its old content is lost.
    pub fn overwrite(slice: ImageSlice<'a>) -> Self {
        Self { slice: Some(slice), load: Load::Lost }
    }

    /// Stands for the target of an output that nobody wants; its format in the pipeline is UNDEFINED.
    pub fn unwanted() -> Self {
        Self { slice: None, load: Load::Lost }
    }

    /// A target that is cleared first. For depth, the first component of `value` counts, and a stencil is kept.
    pub fn cleared(slice: ImageSlice<'a>, value: [f32; 4]) -> Self {
        Self { slice: Some(slice), load: Load::Cleared(value) }
    }

    /// A depth target with stencil, to be marked anew; its depth is lost.
    pub(super) fn unmarked(slice: ImageSlice<'a>) -> Self {
        Self { slice: Some(slice), load: Load::Unmarked }
    }

    /// A target whose texels stay as they are, except those that are written.
    pub fn kept(slice: ImageSlice<'a>) -> Self {
        Self { slice: Some(slice), load: Load::Kept }
    }
}

impl<'a> Target<'a> {
    /// The image; `None` for an output that nobody wants.
    pub(super) fn slice(&self) -> Option<ImageSlice<'a>> {
        self.slice
    }
}

impl Load {
    /// What Vulkan does with the attachment when rendering begins.
    fn op(self) -> vk::AttachmentLoadOp {
        match self {
            Self::Lost | Self::Unmarked => vk::AttachmentLoadOp::DONT_CARE,
            Self::Cleared(_) => vk::AttachmentLoadOp::CLEAR,
            Self::Kept => vk::AttachmentLoadOp::LOAD,
        }
    }

    /// The value that a cleared attachment gets; zeros otherwise.
    fn value(self) -> [f32; 4] {
        if let Self::Cleared(value) = self { value } else { [0.0; 4] }
    }
}

/// Where clip space lies on a target.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum View {
    /// Clip space covers the target, y down.
    Down,
    /// Clip space covers the target, y up.
    Up,
    /// Clip space covers twice the target's width and height, so that a triangle over half of clip space covers the
    /// target and is cut by no edge of the screen. Drivers that clip (lavapipe) cut a triangle that reaches beyond the
    /// screen in two, and shade the blocks of 2 x 2 pixels along the cut twice.
    Twice,
}

impl View {
    /// The viewport for a target of a size in pixels.
    fn viewport(self, width: f32, height: f32) -> vk::Viewport {
        let (y, width, height) = match self {
            Self::Down => (0.0, width, height),
            Self::Up => (height, width, -height),
            Self::Twice => (0.0, 2.0 * width, 2.0 * height),
        };
        vk::Viewport { x: 0.0, y, width, height, min_depth: 0.0, max_depth: 1.0 }
    }
}

impl Frame<'_> {
    /// Makes the targets ready, and calls `draw` inside dynamic rendering with the viewport of `view`.
    pub(super) fn rendering(
        &mut self,
        targets: &[Target],
        depth: Option<Target>,
        view: View,
        draw: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        // Pipelines have no target for unwanted outputs at the end (`SharedPipeline::graphics`).
        let count = targets.iter().rposition(|target| target.slice.is_some()).map_or(0, |last| last + 1);
        let targets = &targets[..count];
        for slice in targets.iter().filter_map(|target| target.slice) {
            self.use_image(slice, Access::ColorAttachment);
        }
        let stencil_view = |t: &Target| t.slice.and_then(|slice| slice.stencil_view());
        if let Some(slice) = depth.and_then(|depth| depth.slice) {
            let with_stencil = slice.stencil_view().is_some();
            let access = if with_stencil { Access::DepthStencilAttachment } else { Access::DepthAttachment };
            self.use_image(slice, access);
        }
        self.flush();
        let attachment = |t: &Target, layout| {
            let Some(slice) = t.slice else { return vk::RenderingAttachmentInfo::default() };
            vk::RenderingAttachmentInfo::default()
                .image_view(slice.stencil_view().unwrap_or(slice.view()))
                .image_layout(layout)
                .load_op(t.load.op())
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let color = |t: &Target| {
            let clear = vk::ClearValue { color: vk::ClearColorValue { float32: t.load.value() } };
            attachment(t, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL).clear_value(clear)
        };
        let depth_value =
            |depth: f32| vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } };
        let colors: Vec<_> = targets.iter().map(color).collect();
        let stencil_attachment = depth.filter(|t| stencil_view(t).is_some()).map(|t| {
            let op = if t.load == Load::Unmarked { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
            let layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
            attachment(&t, layout).load_op(op).clear_value(depth_value(0.0))
        });
        let depth_attachment = depth.map(|t| {
            let layout = match stencil_attachment {
                Some(_) => vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                None => vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL,
            };
            attachment(&t, layout).clear_value(depth_value(t.load.value()[0]))
        });
        let mut slices = targets.iter().chain(depth.iter()).filter_map(|t| t.slice);
        let [width, height] = slices.next().map_or([1, 1], |slice| slice.extent());
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth_attachment {
            info = info.depth_attachment(depth);
        }
        if let Some(stencil) = &stencil_attachment {
            info = info.stencil_attachment(stencil);
        }
        let viewport = view.viewport(width as f32, height as f32);
        let commands = self.context.commands;
        // SAFETY: the barriers above set the layouts, and rendering ends below whatever `draw` returns.
        unsafe {
            self.device().cmd_begin_rendering(commands, &info);
            self.device().cmd_set_viewport(commands, 0, &[viewport]);
            self.device().cmd_set_scissor(commands, 0, &[area]);
        }
        let drawn = draw(self);
        // SAFETY: rendering was begun above.
        unsafe { self.device().cmd_end_rendering(commands) };
        drawn
    }
}
