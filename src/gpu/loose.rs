//! Programs that are known only at run time: a user's shaders. The resources of such a program are matched to its
//! reflected bindings when a pass is recorded, and the Rust compiler checks nothing.

use super::device::Gpu;
use super::frame::{Frame, Resource, Target};
use super::interface::Interface;
use super::memory::Buffer;
use super::pipeline::{SharedPipeline, Stages};
use super::program::Program;
use super::programs::FullscreenUv;
use super::shader::{Binding, BindingKind, Shader};
use crate::error::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// A compute or fragment program, and its pipeline.
pub struct LooseProgram {
    shader: &'static Shader,
    pipeline: Arc<SharedPipeline>,
    /// Keeps the device until the pipeline is gone.
    _gpu: Gpu,
}

/// The size of a dispatch.
#[derive(Clone, Copy)]
pub enum DispatchSize<'a> {
    /// The number of threads along each axis, rounded up to whole workgroups.
    Threads([u32; 3]),
    /// The number of workgroups along each axis.
    Workgroups([u32; 3]),
    /// The number of workgroups is in the first three words of a buffer.
    Indirect(&'a Buffer),
}

/// Makes a shader of SPIR-V code, which lives until the process ends. Its `name` must differ from every other shader's.
///
/// # Errors
/// [`Error::Usage`] for a binding of a kind that is not known here.
pub fn make_shader(name: String, spirv: Vec<u8>, interface: &Interface) -> Result<&'static Shader> {
    let name: &'static str = name.leak();
    let kind = |kind: &str| match kind {
        "SampledImage" => Ok(BindingKind::SampledImage),
        "StorageImage" => Ok(BindingKind::StorageImage),
        "StorageTexels" => Ok(BindingKind::StorageTexels),
        "UniformBuffer" => Ok(BindingKind::UniformBuffer),
        "StorageBuffer" => Ok(BindingKind::StorageBuffer),
        other => Err(Error::Usage(format!("{name}: a binding of kind {other}"))),
    };
    let bindings = interface.bindings.iter().map(|b| {
        let name: &'static str = b.name.clone().leak();
        Ok(Binding { name, binding: b.binding, kind: kind(b.kind)?, count: b.count })
    });
    let bindings = bindings.collect::<Result<Vec<_>>>()?.leak();
    Ok(Box::leak(Box::new(Shader {
        name,
        file: name,
        defines: &[],
        spirv: spirv.leak(),
        push_constant_size: interface.push.as_ref().map_or(0, |p| p.size),
        local_size: interface.local_size,
        bindings,
        stored: &[],
    })))
}

impl LooseProgram {
    /// Makes a fragment program over whole targets of some formats. The input at location 0 is texture coordinates.
    pub fn fragment(
        gpu: &Gpu,
        shader: &'static Shader,
        constants: &[(u32, u32)],
        targets: &[vk::Format],
    ) -> Result<Self> {
        let stages = Stages { vertex: FullscreenUv::SHADER, fragment: shader, constants };
        let pipeline = SharedPipeline::whole_targets(gpu, &stages, targets)?;
        Ok(Self { shader, pipeline, _gpu: gpu.clone() })
    }

    /// Makes a compute program.
    pub fn compute(gpu: &Gpu, shader: &'static Shader, constants: &[(u32, u32)]) -> Result<Self> {
        let pipeline = SharedPipeline::compute(gpu, shader, constants.to_vec())?;
        Ok(Self { shader, pipeline, _gpu: gpu.clone() })
    }

    /// The bindings of the program. The program's resources are given in the order of these bindings.
    pub fn bindings(&self) -> &'static [Binding] {
        self.shader.bindings
    }
}

impl Frame<'_> {
    /// Records a pass of a fragment program over whole targets, all of one size.
    pub fn draw_loose(
        &mut self,
        name: &str,
        program: &LooseProgram,
        targets: &[Target],
        resources: Vec<Resource>,
        push: &[u8],
    ) -> Result<()> {
        self.shade_loose(name, &program.pipeline, targets, (program.shader.bindings, resources, push))
    }

    /// Records a pass of a compute program.
    pub fn dispatch_loose(
        &mut self,
        name: &str,
        program: &LooseProgram,
        resources: Vec<Resource>,
        push: &[u8],
        dispatch_size: DispatchSize,
    ) -> Result<()> {
        self.compute_loose(name, &program.pipeline, (program.shader.bindings, resources, push), dispatch_size)
    }
}
