//! A way around lavapipe of Mesa 22.3.
//!
//! Its `update_inline_shader_state` (lvp_execute.c) copies a shader of which control flow depends on uniforms, puts
//! their values in and compiles the copy: at every draw, although nothing changed, and without ever freeing the copy
//! before last. It costs milliseconds and megabytes a frame. Only if at a draw neither uniforms nor push constants are
//! new does it find that the copy is no better, and then keeps to one shader for good. So a pipeline is once made to
//! draw no vertices, or to dispatch no workgroups, after another pipeline took in what was pushed.

use super::{Frame, Resource};
use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::memory::{Buffer, Place};
use crate::gpu::pipeline::{ComputePipeline, GraphicsPipeline};
use crate::gpu::shader::{COMMON_NOTHING_COMP, COMMON_NOTHING_FRAG};
use ash::vk;
use std::cell::Cell;

/// The pipelines that take in what was pushed.
pub(super) struct Settling {
    graphics: GraphicsPipeline,
    compute: ComputePipeline,
    /// The arguments of a dispatch of no workgroups. (Said directly, the layers take it for a mistake.)
    no_workgroups: Buffer,
}

impl Settling {
    /// Those of a driver that needs it.
    pub fn new(gpu: &Gpu) -> Result<Option<Self>> {
        if !gpu.info().driver.starts_with("llvmpipe Mesa 22.") {
            return Ok(None);
        }
        let bytes = size_of::<vk::DispatchIndirectCommand>() as u64;
        let mut no_workgroups =
            Buffer::new(gpu, "no workgroups", bytes, vk::BufferUsageFlags::INDIRECT_BUFFER, Place::Upload)?;
        no_workgroups.bytes_mut()?.fill(0);
        Ok(Some(Self {
            graphics: GraphicsPipeline::fullscreen(gpu, &COMMON_NOTHING_FRAG, &[])?,
            compute: ComputePipeline::new(gpu, &COMMON_NOTHING_COMP)?,
            no_workgroups,
        }))
    }
}

impl Frame<'_> {
    /// Whether a pipeline must be settled now: at its first draw on such a driver. The caller lets it draw nothing
    /// between [`Self::take_in`] and its own push.
    pub(super) fn must_settle(&self, settled: &Cell<bool>) -> bool {
        self.context.settling.is_some() && !settled.replace(true)
    }

    /// Pushes what a graphics pipeline reads and lets another take it in. Outside rendering.
    pub(super) fn take_in(
        &mut self,
        pipeline: &GraphicsPipeline,
        resources: &[(&str, Resource)],
        push: &[u8],
    ) -> Result<()> {
        let Some(other) = self.context.settling.as_ref().map(|s| s.graphics.handle) else { return Ok(()) };
        self.rendering(&[], None, false, |frame| {
            frame.push(&pipeline.layout, vk::PipelineBindPoint::GRAPHICS, pipeline.name, resources, push)?;
            frame.bind(other, vk::PipelineBindPoint::GRAPHICS);
            // SAFETY: a pipeline that reads nothing is bound.
            unsafe { frame.device().cmd_draw(frame.context.commands, 0, 1, 0, 0) };
            Ok(())
        })
    }

    /// Pushes what a compute pipeline reads, lets another take it in, and settles it.
    pub(super) fn settle_compute(
        &mut self,
        pipeline: &ComputePipeline,
        resources: &[(&str, Resource)],
        push: &[u8],
    ) -> Result<()> {
        let settling = self.context.settling.as_ref().map(|s| (s.compute.handle, s.no_workgroups.handle()));
        let Some((other, no_workgroups)) = settling else { return Ok(()) };
        self.push(&pipeline.layout, vk::PipelineBindPoint::COMPUTE, pipeline.name, resources, push)?;
        for handle in [other, pipeline.handle] {
            self.bind(handle, vk::PipelineBindPoint::COMPUTE);
            // SAFETY: what the pipeline reads, if anything, was pushed; the host wrote the arguments.
            unsafe { self.device().cmd_dispatch_indirect(self.context.commands, no_workgroups, 0) };
        }
        Ok(())
    }
}
