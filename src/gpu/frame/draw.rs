//! The passes that draw or dispatch: shaders over whole targets, over as much as a buffer says, over
//! meshes, and compute.

use super::target::View;
use super::{Frame, Resource, Target};
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::memory::Buffer;
use crate::gpu::pipeline::{ComputePipeline, GraphicsPipeline};
use crate::gpu::sync::Access;
use ash::vk;

impl Frame<'_> {
    /// A fragment shader over whole targets, all of one size.
    pub fn fullscreen(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline,
        targets: &[Target],
        resources: &[(&str, Resource)],
        push: &[u8],
    ) -> Result<()> {
        self.shade(name, pipeline, (targets, None), resources, push, Vertices::Triangle)
    }

    /// Clears the stencil of a depth target and marks every pixel that a fragment shader doesn't
    /// discard; its depth is lost.
    pub fn mark(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline,
        stencil: ImageSlice,
        resources: &[(&str, Resource)],
        push: &[u8],
    ) -> Result<()> {
        self.shade(name, pipeline, (&[], Some(Target::unmarked(stencil))), resources, push, Vertices::Triangle)
    }

    /// Vertices without a vertex buffer, as many as four words of a buffer say (the arguments of an
    /// indirect draw), from byte `offset`.
    pub fn draw_indirect(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline,
        targets: &[Target],
        resources: &[(&str, Resource)],
        push: &[u8],
        (arguments, offset): (&Buffer, u64),
    ) -> Result<()> {
        assert!(
            offset + u64::from(INDIRECT_BYTES) <= arguments.size() && offset.is_multiple_of(4),
            "{name}: at {offset}"
        );
        self.shade(name, pipeline, (targets, None), resources, push, Vertices::Said(arguments, offset))
    }

    /// A pass of one draw whose vertices the vertex shader makes.
    fn shade(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline,
        (targets, depth): (&[Target], Option<Target>),
        resources: &[(&str, Resource)],
        push: &[u8],
        vertices: Vertices,
    ) -> Result<()> {
        self.pass(name, |frame| {
            frame.prepare(resources, Access::FragmentSampled, Access::GraphicsStorageRead);
            if let Vertices::Said(arguments, _) = vertices {
                frame.use_buffer(arguments, Access::Indirect);
            }
            let settles = frame.must_settle(&pipeline.settled);
            if settles {
                frame.take_in(pipeline, resources, push)?;
            }
            let view = if matches!(vertices, Vertices::Triangle) { View::Twice } else { View::Down };
            frame.rendering(targets, depth, view, |frame| {
                frame.bind(pipeline.handle, vk::PipelineBindPoint::GRAPHICS);
                if settles {
                    // SAFETY: a pipeline is bound, and what it reads was pushed.
                    unsafe { frame.device().cmd_draw(frame.context.commands, 0, 1, 0, 0) };
                }
                frame.push(&pipeline.layout, vk::PipelineBindPoint::GRAPHICS, pipeline.name, resources, push)?;
                let (device, commands) = (frame.device(), frame.context.commands);
                // SAFETY: a pipeline and everything it reads are bound; the words lie in the buffer.
                unsafe {
                    match vertices {
                        Vertices::Triangle => device.cmd_draw(commands, 3, 1, 0, 0),
                        Vertices::Said(arguments, offset) => {
                            device.cmd_draw_indirect(commands, arguments.handle(), offset, 1, INDIRECT_BYTES);
                        }
                    }
                }
                Ok(())
            })
        })
    }

    /// Meshes into targets with a depth buffer; `draw` records them.
    pub fn raster(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline,
        targets: &[Target],
        depth: Target,
        draw: impl FnOnce(&mut Raster) -> Result<()>,
    ) -> Result<()> {
        self.pass(name, |frame| {
            frame.rendering(targets, Some(depth), View::Up, |frame| {
                frame.bind(pipeline.handle, vk::PipelineBindPoint::GRAPHICS);
                draw(&mut Raster { frame, pipeline })
            })
        })
    }

    /// A compute shader over `threads` threads (rounded up to whole workgroups).
    pub fn compute(
        &mut self,
        name: &str,
        pipeline: &ComputePipeline,
        resources: &[(&str, Resource)],
        push: &[u8],
        threads: [u32; 3],
    ) -> Result<()> {
        self.pass(name, |frame| {
            frame.prepare(resources, Access::ComputeSampled, Access::ComputeStorageRead);
            frame.flush();
            frame.bind(pipeline.handle, vk::PipelineBindPoint::COMPUTE);
            frame.push(&pipeline.layout, vk::PipelineBindPoint::COMPUTE, pipeline.name, resources, push)?;
            let [x, y, z] = [0, 1, 2].map(|i| threads[i].div_ceil(pipeline.local_size[i]));
            // SAFETY: a pipeline and everything it reads are bound.
            unsafe { frame.device().cmd_dispatch(frame.context.commands, x, y, z) };
            Ok(())
        })
    }

    /// Draws over what a target holds, by commands that `draw` records into dynamic rendering; what
    /// they read must be ready.
    #[cfg(feature = "window")]
    pub(in crate::gpu) fn overlay(
        &mut self,
        name: &str,
        slice: ImageSlice,
        draw: impl FnOnce(vk::CommandBuffer) -> Result<()>,
    ) -> Result<()> {
        self.pass(name, |frame| {
            frame.rendering(&[Target::kept(slice)], None, View::Down, |frame| draw(frame.context.commands))
        })
    }
}

/// How many vertices [`Frame::shade`] draws.
#[derive(Clone, Copy)]
enum Vertices<'a> {
    /// The three of a triangle that covers the targets.
    Triangle,
    /// As a buffer says from a byte on.
    Said(&'a Buffer, u64),
}

const INDIRECT_BYTES: u32 = size_of::<vk::DrawIndirectCommand>() as u32;

/// Records the draws of [`Frame::raster`].
pub struct Raster<'f, 'c> {
    pub(super) frame: &'f mut Frame<'c>,
    pub(super) pipeline: &'f GraphicsPipeline,
}

impl Raster<'_, '_> {
    /// Binds resources and constants for the draws that follow. Images must have been made ready
    /// ([`Frame::make_ready`]): no barrier can stand inside rendering.
    pub fn bind(&mut self, resources: &[(&str, Resource)], push: &[u8]) -> Result<()> {
        let p = self.pipeline;
        self.frame.push(&p.layout, vk::PipelineBindPoint::GRAPHICS, p.name, resources, push)
    }

    /// Draws indexed triangles.
    pub fn draw(&mut self, vertices: &Buffer, indices: &Buffer, index_count: u32) {
        let commands = self.frame.context.commands;
        // SAFETY: the pipeline is bound with its resources; the buffers hold the indices' range.
        unsafe {
            self.frame.device().cmd_bind_vertex_buffers(commands, 0, &[vertices.handle()], &[0]);
            self.frame.device().cmd_bind_index_buffer(commands, indices.handle(), 0, vk::IndexType::UINT32);
            self.frame.device().cmd_draw_indexed(commands, index_count, 1, 0, 0, 0);
        }
    }
}
