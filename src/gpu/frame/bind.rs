//! Binds pipelines, and the resources that they read.

use super::{Frame, Resource};
use crate::error::{Error, Result};
use crate::gpu::pipeline::Layout;
use crate::gpu::program::{Program, Sampled};
use crate::gpu::shader::{Binding, BindingKind, Shader};
use ash::vk;

/// Resources and push constants of a pipeline's programs, for a draw or a dispatch.
pub(super) struct ProgramInputs<'a> {
    pub resources: Vec<(Binding, Resource<'a>)>,
    pub push: &'a [u8],
}

impl<'a> ProgramInputs<'a> {
    /// Collects the inputs that a shader reads from the fields of its program.
    ///
    /// # Errors
    /// [`Error::Usage`] if a field that the shader needs is `None`.
    pub fn from_program<P: Program>(shader: &Shader, program: &'a P) -> Result<Self> {
        let resource = |binding: &Binding| {
            let found = program.resource(binding.name).map(|resource| (*binding, resource));
            found.ok_or_else(|| Error::Usage(format!("{}: nothing is given for {}", shader.name, binding.name)))
        };
        let push = if shader.push_constant_size > 0 { program.push() } else { &[] };
        // Images that a compute shader stores to are given as targets (`pixels.rs`), and not as fields.
        let is_stored = |bound: &&Binding| shader.stored.iter().any(|(binding, _)| *binding == bound.binding);
        let read = shader.bindings.iter().filter(|bound| !is_stored(bound));
        Ok(Self { resources: read.map(resource).collect::<Result<_>>()?, push })
    }

    /// Adds the fields of the vertex program. Bindings and push constants that both programs have stay the first one's.
    pub fn with_vertex_program<P: Program>(mut self, vertex: &'a P) -> Result<Self> {
        let other = ProgramInputs::from_program(P::SHADER, vertex)?;
        for (binding, resource) in other.resources {
            if self.resources.iter().all(|(known, _)| known.binding != binding.binding) {
                self.resources.push((binding, resource));
            }
        }
        let push = if self.push.is_empty() { other.push } else { self.push };
        Ok(Self { push, ..self })
    }
}

impl Frame<'_> {
    pub(super) fn bind(&self, pipeline: vk::Pipeline, point: vk::PipelineBindPoint) {
        // SAFETY: the pipeline is alive and fits the point.
        unsafe { self.device().cmd_bind_pipeline(self.context.commands, point, pipeline) };
    }

    /// Binds the resources of a draw or dispatch in a new descriptor set, and pushes its constants.
    pub(super) fn bind_inputs(
        &mut self,
        layout: &Layout,
        point: vk::PipelineBindPoint,
        name: &str,
        inputs: &ProgramInputs,
    ) -> Result<()> {
        let ProgramInputs { resources, push } = inputs;
        // The descriptors of each resource, in lists that the writes below point into.
        let mut images = Vec::with_capacity(resources.len());
        let mut buffers = Vec::with_capacity(resources.len());
        let mut texels = Vec::with_capacity(resources.len());
        let mut structures = Vec::with_capacity(resources.len());
        for (_, resource) in resources {
            let (image, buffer) = self.descriptor(*resource)?;
            images.push(match resource {
                Resource::SampledArray(several) => {
                    let image = |sampled: &Sampled| Ok(self.descriptor(Resource::Sampled(*sampled))?.0);
                    several.iter().map(image).collect::<Result<_>>()?
                }
                _ => vec![image],
            });
            buffers.push([buffer]);
            texels.push(match resource {
                Resource::Texels(texels) => [texels.view()],
                _ => [vk::BufferView::null()],
            });
            structures.push(match resource {
                Resource::Rays(structure) => [structure.handle()],
                _ => [vk::AccelerationStructureKHR::null()],
            });
        }
        let has_bindings = !layout.bindings.is_empty();
        let mut structure_writes: Vec<_> = structures
            .iter()
            .map(|s| vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(s))
            .collect();
        let set = if has_bindings { Some(self.slot().sets.take(layout.set, name)?) } else { None };
        let writes: Vec<_> = resources
            .iter()
            .zip(&mut structure_writes)
            .enumerate()
            .map(|(i, ((binding, _), structure))| {
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set.unwrap_or_default())
                    .dst_binding(binding.binding)
                    .descriptor_type(binding.kind.descriptor_type());
                match binding.kind {
                    BindingKind::SampledImage | BindingKind::StorageImage => write.image_info(&images[i]),
                    BindingKind::StorageTexels => write.texel_buffer_view(&texels[i]),
                    BindingKind::RayStructure => write.descriptor_count(1).push_next(structure),
                    BindingKind::UniformBuffer | BindingKind::StorageBuffer => write.buffer_info(&buffers[i]),
                }
            })
            .collect();
        let commands = self.context.commands;
        // SAFETY: the layout is the bound pipeline's; the resources of the writes outlive the frame's submission; a set
        // belongs to this frame alone until its slot is used again.
        unsafe {
            if let Some(set) = set {
                self.device().update_descriptor_sets(&writes, &[]);
                self.device().cmd_bind_descriptor_sets(commands, point, layout.pipeline, 0, &[set], &[]);
            }
            if !push.is_empty() {
                self.device().cmd_push_constants(commands, layout.pipeline, layout.stages, 0, push);
            }
        }
        Ok(())
    }

    /// Returns two descriptors of a resource, for an image and for a buffer. At least one of them is empty.
    fn descriptor(&mut self, resource: Resource) -> Result<(vk::DescriptorImageInfo, vk::DescriptorBufferInfo)> {
        let (mut image, mut buffer) = (vk::DescriptorImageInfo::default(), vk::DescriptorBufferInfo::default());
        match resource {
            Resource::Sampled(Sampled(slice, sampler)) => {
                image = image
                    .sampler(self.context.gpu.sampler(sampler))
                    .image_view(slice.view())
                    .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
            }
            // `bind_inputs` itself adds the images of an array, the view of texels, and the handle of a ray structure.
            Resource::SampledArray(..) | Resource::Texels(..) | Resource::Rays(..) => {}
            Resource::Storage(slice) | Resource::Loaded(slice) => {
                image = image.image_view(slice.view()).image_layout(vk::ImageLayout::GENERAL);
            }
            Resource::Buffer(b) | Resource::ReadBuffer(b) => {
                buffer = buffer.buffer(b.handle()).range(vk::WHOLE_SIZE);
            }
            Resource::Uniform(bytes) => {
                buffer = self.slot().uniforms.put(bytes)?;
            }
        }
        Ok((image, buffer))
    }
}
