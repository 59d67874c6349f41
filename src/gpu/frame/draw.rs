//! Passes that draw or dispatch: programs over whole targets, indirect draws, meshes, and compute programs.

#[cfg(feature = "reload")]
use super::Resource;
use super::bind::ProgramInputs;
use super::target::View;
use super::{Frame, Target};
use crate::error::Result;
use crate::gpu::image::ImageSlice;
#[cfg(feature = "reload")]
use crate::gpu::loose::DispatchSize;
use crate::gpu::memory::Buffer;
use crate::gpu::pipeline::{ComputePipeline, GraphicsPipeline, SharedPipeline};
use crate::gpu::program::{Compute, Fragment, VertexProgram};
#[cfg(feature = "reload")]
use crate::gpu::shader::Binding;
use crate::gpu::shader::Shader;
use crate::gpu::sync::Access;
use ash::vk;
use std::marker::PhantomData;
use std::sync::Arc;

impl Frame<'_> {
    /// Records a pass of a fragment program over whole targets, all of one size.
    pub fn fullscreen<F: Fragment>(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline<F>,
        targets: F::Outputs<Target>,
        program: &F,
    ) -> Result<()> {
        let targets = (targets.as_ref(), None);
        let inputs = ProgramInputs::from_program(pipeline.fragment, program)?;
        self.shade(name, &pipeline.graphics, targets, &inputs, Vertices::Triangle)
    }

    /// Clears the stencil of a depth target, whose depth is lost, and marks the pixels that a program does not discard.
    pub fn mark<F: Fragment>(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline<F>,
        stencil: ImageSlice,
        program: &F,
    ) -> Result<()> {
        let targets = (&[][..], Some(Target::unmarked(stencil)));
        let inputs = ProgramInputs::from_program(pipeline.fragment, program)?;
        self.shade(name, &pipeline.graphics, targets, &inputs, Vertices::Triangle)
    }

    /// Draws vertices without a vertex buffer. Four words of a buffer, from byte `offset`, are the arguments of an
    /// indirect draw and say how many vertices there are.
    pub fn draw_indirect<F: Fragment, V: VertexProgram>(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline<F, V>,
        targets: F::Outputs<Target>,
        (fragment, vertex): (&F, &V),
        (arguments, offset): (&Buffer, u64),
    ) -> Result<()> {
        let inputs = ProgramInputs::from_program(pipeline.fragment, fragment)?.with_vertex_program(vertex)?;
        let vertices = Vertices::Indirect(arguments, offset);
        self.shade(name, &pipeline.graphics, (targets.as_ref(), None), &inputs, vertices)
    }

    /// Records a pass of one draw, whose vertices the vertex shader makes without a vertex buffer.
    pub(super) fn shade(
        &mut self,
        name: &str,
        pipeline: &Arc<SharedPipeline>,
        (targets, depth): (&[Target], Option<Target>),
        inputs: &ProgramInputs,
        vertices: Vertices,
    ) -> Result<()> {
        if let Vertices::Indirect(arguments, offset) = vertices {
            assert_holds(name, (arguments, offset), u64::from(DRAW_ARGUMENT_BYTES));
        }
        self.note_program(name, pipeline);
        self.pass(name, |frame| {
            frame.prepare(inputs, [Access::FragmentSampled, Access::GraphicsStorageRead, Access::FragmentStorage]);
            if let Vertices::Indirect(arguments, _) = vertices {
                frame.use_buffer(arguments, Access::Indirect);
            }
            let settles = frame.must_settle(&pipeline.settled); // a workaround for a bug of lavapipe
            if settles {
                frame.consume_pushed_values(pipeline, inputs)?;
            }
            let view = if matches!(vertices, Vertices::Triangle) { View::Twice } else { View::Down };
            frame.rendering(targets, depth, view, |frame| {
                frame.bind(pipeline.handle, vk::PipelineBindPoint::GRAPHICS);
                if settles {
                    // SAFETY: a pipeline is bound, and what it reads was pushed.
                    unsafe { frame.device().cmd_draw(frame.context.commands, 0, 1, 0, 0) };
                }
                frame.bind_inputs(&pipeline.layout, vk::PipelineBindPoint::GRAPHICS, pipeline.name, inputs)?;
                let (device, commands) = (frame.device(), frame.context.commands);
                // SAFETY: a pipeline and everything it reads are bound; the indirect arguments lie in their buffer, as was checked.
                unsafe {
                    match vertices {
                        Vertices::Triangle => device.cmd_draw(commands, 3, 1, 0, 0),
                        Vertices::Indirect(arguments, offset) => {
                            device.cmd_draw_indirect(commands, arguments.handle(), offset, 1, DRAW_ARGUMENT_BYTES);
                        }
                    }
                }
                Ok(())
            })
        })
    }

    /// Draws meshes into targets with a depth buffer; `draw` records their draws.
    pub fn raster<F: Fragment, V: VertexProgram>(
        &mut self,
        name: &str,
        pipeline: &GraphicsPipeline<F, V>,
        targets: F::Outputs<Target>,
        depth: Target,
        draw: impl FnOnce(&mut Raster<F, V>) -> Result<()>,
    ) -> Result<()> {
        self.note_program(name, &pipeline.graphics);
        let (fragment, pipeline): (_, &SharedPipeline) = (pipeline.fragment, &pipeline.graphics);
        self.pass(name, |frame| {
            frame.rendering(targets.as_ref(), Some(depth), View::Up, |frame| {
                draw(&mut Raster { frame, pipeline, fragment, is_bound: false, programs: PhantomData })
            })
        })
    }

    /// Dispatches a compute program over `threads` threads (rounded up to whole workgroups).
    pub fn compute<P: Compute>(
        &mut self,
        name: &str,
        pipeline: &ComputePipeline<P>,
        program: &P,
        threads: [u32; 3],
    ) -> Result<()> {
        let [x, y, z] = [0, 1, 2].map(|i| threads[i].div_ceil(pipeline.compute.local_size[i]));
        let inputs = ProgramInputs::from_program(pipeline.shader, program)?;
        self.dispatch(name, &pipeline.compute, &inputs, Workgroups::Counted([x, y, z]))
    }

    /// Dispatches a compute program. Three words of `arguments` from byte `offset` on count workgroups along each axis.
    pub fn compute_indirect<P: Compute>(
        &mut self,
        name: &str,
        pipeline: &ComputePipeline<P>,
        program: &P,
        (arguments, offset): (&Buffer, u64),
    ) -> Result<()> {
        let inputs = ProgramInputs::from_program(pipeline.shader, program)?;
        self.dispatch(name, &pipeline.compute, &inputs, Workgroups::Indirect(arguments, offset))
    }

    /// Records a pass of one dispatch of a compute pipeline.
    pub(super) fn dispatch(
        &mut self,
        name: &str,
        pipeline: &Arc<SharedPipeline>,
        inputs: &ProgramInputs,
        workgroups: Workgroups,
    ) -> Result<()> {
        if let Workgroups::Indirect(arguments, offset) = workgroups {
            assert_holds(name, (arguments, offset), size_of::<vk::DispatchIndirectCommand>() as u64);
        }
        self.note_program(name, pipeline);
        self.pass(name, |frame| {
            frame.prepare(inputs, [Access::ComputeSampled, Access::ComputeStorageRead, Access::ComputeStorage]);
            if let Workgroups::Indirect(arguments, _) = workgroups {
                frame.use_buffer(arguments, Access::Indirect);
            }
            frame.flush();
            frame.bind(pipeline.handle, vk::PipelineBindPoint::COMPUTE);
            frame.bind_inputs(&pipeline.layout, vk::PipelineBindPoint::COMPUTE, pipeline.name, inputs)?;
            frame.settle_compute(pipeline); // a workaround for a bug of lavapipe
            let (device, commands) = (frame.device(), frame.context.commands);
            // SAFETY: a pipeline and everything it reads are bound; the indirect arguments lie in their buffer, as was checked.
            unsafe {
                match workgroups {
                    Workgroups::Counted([x, y, z]) => device.cmd_dispatch(commands, x, y, z),
                    Workgroups::Indirect(arguments, offset) => {
                        device.cmd_dispatch_indirect(commands, arguments.handle(), offset);
                    }
                }
            }
            Ok(())
        })
    }

    /// Records a pass of a fragment program over whole targets. No type checks that the resources fit the bindings.
    #[cfg(feature = "reload")]
    pub(in crate::gpu) fn shade_loose(
        &mut self,
        name: &str,
        pipeline: &Arc<SharedPipeline>,
        targets: &[Target],
        (bindings, resources, push): (&[Binding], Vec<Resource>, &[u8]),
    ) -> Result<()> {
        let inputs = ProgramInputs { resources: bindings.iter().copied().zip(resources).collect(), push };
        self.shade(name, pipeline, (targets, None), &inputs, Vertices::Triangle)
    }

    /// Records a pass of a compute program. No type checks that the resources fit the bindings.
    #[cfg(feature = "reload")]
    pub(in crate::gpu) fn compute_loose(
        &mut self,
        name: &str,
        pipeline: &Arc<SharedPipeline>,
        (bindings, resources, push): (&[Binding], Vec<Resource>, &[u8]),
        dispatch_size: DispatchSize,
    ) -> Result<()> {
        let inputs = ProgramInputs { resources: bindings.iter().copied().zip(resources).collect(), push };
        let local_size = pipeline.local_size;
        let workgroups = match dispatch_size {
            DispatchSize::Threads(threads) => {
                Workgroups::Counted([0, 1, 2].map(|i| threads[i].div_ceil(local_size[i].max(1))))
            }
            DispatchSize::Workgroups(counts) => Workgroups::Counted(counts),
            DispatchSize::Indirect(buffer) => Workgroups::Indirect(buffer, 0),
        };
        self.dispatch(name, pipeline, &inputs, workgroups)
    }

    /// Draws over a target: `draw` records commands inside dynamic rendering, and what these read must be ready.
    pub fn overlay(
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
pub(super) enum Vertices<'a> {
    /// The three vertices of a triangle that covers the targets.
    Triangle,
    /// Reads the draw's arguments from a buffer at a byte offset.
    Indirect(&'a Buffer, u64),
}

/// How many workgroups [`Frame::dispatch`] runs.
#[derive(Clone, Copy)]
pub(super) enum Workgroups<'a> {
    /// The number of workgroups along each axis.
    Counted([u32; 3]),
    /// Reads the numbers from a buffer at a byte offset.
    Indirect(&'a Buffer, u64),
}

/// Panics unless a buffer holds the `bytes` of an indirect command's arguments at an offset.
fn assert_holds(name: &str, (arguments, offset): (&Buffer, u64), bytes: u64) {
    let holds = offset + bytes <= arguments.size() && offset.is_multiple_of(4);
    assert!(holds, "{name}: no arguments at byte {offset} of {}", arguments.size());
}

const DRAW_ARGUMENT_BYTES: u32 = size_of::<vk::DrawIndirectCommand>() as u32;

/// Records the draws of [`Frame::raster`].
pub struct Raster<'f, 'c, F, V> {
    pub(super) frame: &'f mut Frame<'c>,
    pipeline: &'f SharedPipeline,
    /// The fragment program's shader.
    fragment: &'static Shader,
    /// Whether the pipeline is bound. A pass without draws never binds it, because the validation layers report a bound
    /// pipeline that reads vertices and draws none.
    is_bound: bool,
    programs: PhantomData<(F, V)>,
}

impl<F: Fragment, V: VertexProgram> Raster<'_, '_, F, V> {
    /// Binds the resources of the draws that follow. Images must be ready ([`Frame::make_ready`]), since no barrier can
    /// stand inside rendering. Resources that both stages read are taken from the fragment program.
    pub fn bind(
        &mut self,
        fragment: &impl Fragment<Kind = F::Kind>,
        vertex: &impl VertexProgram<Kind = V::Kind>,
    ) -> Result<()> {
        let pipeline = self.pipeline;
        let inputs = ProgramInputs::from_program(self.fragment, fragment)?.with_vertex_program(vertex)?;
        if !self.is_bound {
            self.frame.bind(pipeline.handle, vk::PipelineBindPoint::GRAPHICS);
            self.is_bound = true;
        }
        self.frame.bind_inputs(&pipeline.layout, vk::PipelineBindPoint::GRAPHICS, pipeline.name, &inputs)
    }

    /// Draws indexed triangles as one instance, whose number (`gl_InstanceIndex`) is `instance`.
    pub fn draw(&mut self, vertices: &Buffer, indices: &Buffer, index_count: u32, instance: u32) {
        let commands = self.frame.context.commands;
        // SAFETY: the pipeline is bound with its resources; the buffers hold the indices' range.
        unsafe {
            self.frame.device().cmd_bind_vertex_buffers(commands, 0, &[vertices.handle()], &[0]);
            self.frame.device().cmd_bind_index_buffer(commands, indices.handle(), 0, vk::IndexType::UINT32);
            self.frame.device().cmd_draw_indexed(commands, index_count, 1, 0, 0, instance);
        }
    }
}
