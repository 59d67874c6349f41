//! Works around a bug of lavapipe in Mesa 22.3, which compiles shaders again at every draw and dispatch.
//!
//! If a shader's control flow depends on uniforms, `update_inline_shader_state` (lvp_execute.c) inserts their values
//! into a copy of the shader and compiles the copy: at every draw, even if nothing has changed, and without freeing it.
//! These compilations cost milliseconds and megabytes per frame. At a draw without new uniforms and push constants,
//! lavapipe finds that the copy is no better, and uses one shader from then on. Each pipeline that draws full-screen
//! triangles therefore draws zero vertices once, after another pipeline has consumed the pushed values. A compute
//! pipeline dispatches no workgroups twice instead. This crate's shaders for meshes have no such control flow.
//!
//! This file can go when Mesa 22 need not be supported any more, or when `cargo test --test alone -- soak` passes on
//! Mesa 22 without it. That test checks that resident memory stays flat.

use crate::error::Result;
use crate::gpu::device::Gpu;
use crate::gpu::frame::Frame;
use crate::gpu::frame::bind::ProgramInputs;
use crate::gpu::frame::target::View;
use crate::gpu::pipeline::{GraphicsPipeline, SharedPipeline};
use crate::gpu::programs::Nothing;
use crate::gpu::validation::MESA_22;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The pipeline that consumes pushed values so that they are no longer new.
pub(in crate::gpu::frame) struct Settling(GraphicsPipeline<Nothing>);

impl Settling {
    /// Makes the pipeline if the driver needs it.
    pub fn new(gpu: &Gpu) -> Result<Option<Self>> {
        if !gpu.info().driver.starts_with(MESA_22) {
            return Ok(None);
        }
        Ok(Some(Self(GraphicsPipeline::fullscreen(gpu, [])?)))
    }
}

impl Frame<'_> {
    /// Returns whether a pipeline must be settled now: it is used for the first time, and the driver has the bug of
    /// this file. After this call the pipeline counts as settled. For a graphics pipeline the caller then calls
    /// [`Self::consume_pushed_values`], draws zero vertices, and pushes its values again.
    pub(in crate::gpu::frame) fn must_settle(&mut self, settled: &Arc<AtomicBool>) -> bool {
        let is_new = !settled.load(Ordering::Relaxed) && self.settled.iter().all(|other| !Arc::ptr_eq(other, settled));
        if self.context.settling.is_none() || !is_new {
            return false;
        }
        self.settled.push(Arc::clone(settled));
        true
    }

    /// Pushes the values that a graphics pipeline reads, and lets another pipeline consume them, outside of rendering.
    pub(in crate::gpu::frame) fn consume_pushed_values(
        &mut self,
        pipeline: &SharedPipeline,
        inputs: &ProgramInputs,
    ) -> Result<()> {
        let Some(other) = self.context.settling.as_ref().map(|s| s.0.graphics.handle) else { return Ok(()) };
        self.rendering(&[], None, View::Down, |frame| {
            frame.bind_inputs(&pipeline.layout, vk::PipelineBindPoint::GRAPHICS, pipeline.name, inputs)?;
            frame.bind(other, vk::PipelineBindPoint::GRAPHICS);
            // SAFETY: a pipeline that reads nothing is bound.
            unsafe { frame.device().cmd_draw(frame.context.commands, 0, 1, 0, 0) };
            Ok(())
        })
    }

    /// Makes lavapipe settle on one shader of a compute pipeline, if the pipeline must be settled. The caller has bound
    /// the pipeline and pushed its uniforms and constants. The first dispatch of no workgroups consumes these values.
    /// At the second, lavapipe finds nothing new, and compiles no further copy of the shader from then on.
    pub(in crate::gpu::frame) fn settle_compute(&mut self, pipeline: &SharedPipeline) {
        if !self.must_settle(&pipeline.settled) {
            return;
        }
        for _ in 0..2 {
            self.bind(pipeline.handle, vk::PipelineBindPoint::COMPUTE);
            // SAFETY: the pipeline is bound, and what it reads was pushed.
            unsafe { self.device().cmd_dispatch(self.context.commands, 0, 0, 0) };
        }
    }
}
