//! Pipelines of programs that are told apart at run time, and bound by names that are looked up: for passes that do
//! not use the programs' types yet.

use super::device::Gpu;
use super::pipeline::{Compute, Geometry, Graphics, Stages};
use super::program::Program;
use super::programs::Fullscreen;
use super::shader::Shader;
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// A graphics pipeline of any programs.
pub struct NamedGraphicsPipeline(pub(crate) Graphics);

/// A compute pipeline of any program.
pub struct NamedComputePipeline(pub(crate) Arc<Compute>);

fn entries(constants: &[i32]) -> Vec<(u32, u32)> {
    (0..).zip(constants.iter().map(|v| v.cast_unsigned())).collect()
}

impl NamedGraphicsPipeline {
    /// A fragment shader over the whole of its targets, with values of its specialization constants 0, 1 and so on.
    pub fn fullscreen_with(
        gpu: &Gpu,
        fragment: &'static Shader,
        targets: &[vk::Format],
        constants: &[i32],
    ) -> Result<Self> {
        let stages = Stages { vertex: Fullscreen::SHADER, fragment, constants: &entries(constants) };
        Graphics::new(gpu, stages, Geometry::Triangles(None), targets, None).map(Self)
    }

    /// Points, that is squares of pixels, which a vertex shader makes from nothing but their number.
    pub fn points(
        gpu: &Gpu,
        vertex: &'static Shader,
        fragment: &'static Shader,
        targets: &[vk::Format],
        constants: &[i32],
    ) -> Result<Self> {
        let stages = Stages { vertex, fragment, constants: &entries(constants) };
        Graphics::new(gpu, stages, Geometry::Points, targets, None).map(Self)
    }
}

impl NamedComputePipeline {
    /// The pipeline of a compute shader.
    pub fn new(gpu: &Gpu, shader: &'static Shader) -> Result<Self> {
        Self::with(gpu, shader, &[])
    }

    /// The same with values of the shader's specialization constants 0, 1 and so on.
    pub fn with(gpu: &Gpu, shader: &'static Shader, constants: &[i32]) -> Result<Self> {
        Compute::shared(gpu, shader, entries(constants)).map(Self)
    }

    /// Threads of a workgroup.
    pub fn local_size(&self) -> [u32; 3] {
        self.0.local_size
    }
}
