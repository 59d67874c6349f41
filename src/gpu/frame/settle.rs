//! A way around lavapipe of Mesa 22.3.
//!
//! Its `update_inline_shader_state` (lvp_execute.c) copies a shader of which control flow depends on uniforms, puts
//! their values in and compiles the copy: at every draw, although nothing changed, and without ever freeing one. It costs
//! milliseconds and megabytes a frame. Only if at a draw neither uniforms nor push constants are new does it find that
//! the copy is no better, and then keeps to one shader for good. So a pipeline whose vertices its shader makes is once
//! made to draw none, after another took in what was pushed. Meshes and compute shaders here have no such control flow.

use super::Frame;
use super::bind::Given;
use super::target::View;
use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::pipeline::{Graphics, GraphicsPipeline};
use crate::gpu::programs::Nothing;
use ash::vk;
use std::cell::Cell;
use std::rc::Rc;

/// The pipeline that takes in what was pushed.
pub(super) struct Settling(GraphicsPipeline<Nothing>);

impl Settling {
    /// That of a driver that needs it.
    pub fn new(gpu: &Gpu) -> Result<Option<Self>> {
        if !gpu.info().driver.starts_with("llvmpipe Mesa 22.") {
            return Ok(None);
        }
        Ok(Some(Self(GraphicsPipeline::fullscreen(gpu, [])?)))
    }
}

impl Frame<'_> {
    /// Whether a pipeline must be settled now: at its first draw on such a driver. The caller lets it draw nothing
    /// between [`Self::take_in`] and its own push; it counts as settled from the frame's submission on.
    pub(super) fn must_settle(&mut self, settled: &Rc<Cell<bool>>) -> bool {
        let is_new = !settled.get() && self.settled.iter().all(|other| !Rc::ptr_eq(other, settled));
        if self.context.settling.is_none() || !is_new {
            return false;
        }
        self.settled.push(Rc::clone(settled));
        true
    }

    /// Pushes what a graphics pipeline reads and lets another take it in. Outside rendering.
    pub(super) fn take_in(&mut self, pipeline: &Graphics, given: &Given) -> Result<()> {
        let Some(other) = self.context.settling.as_ref().map(|s| s.0.graphics.handle) else { return Ok(()) };
        self.rendering(&[], None, View::Down, |frame| {
            frame.push(&pipeline.layout, vk::PipelineBindPoint::GRAPHICS, pipeline.name, given)?;
            frame.bind(other, vk::PipelineBindPoint::GRAPHICS);
            // SAFETY: a pipeline that reads nothing is bound.
            unsafe { frame.device().cmd_draw(frame.context.commands, 0, 1, 0, 0) };
            Ok(())
        })
    }
}
