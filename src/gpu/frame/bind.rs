//! Binding pipelines and what they read.

use super::{Frame, Resource};
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::pipeline::Layout;
use crate::gpu::shader::BindingKind;
use ash::vk;

impl Frame<'_> {
    pub(super) fn bind(&self, pipeline: vk::Pipeline, point: vk::PipelineBindPoint) {
        // SAFETY: the pipeline is alive and fits the point.
        unsafe { self.device().cmd_bind_pipeline(self.context.commands, point, pipeline) };
    }

    /// Pushes constants, and pushes or binds descriptors.
    pub(super) fn push(
        &mut self,
        layout: &Layout,
        point: vk::PipelineBindPoint,
        name: &str,
        resources: &[(&str, Resource)],
        push: &[u8],
    ) -> Result<()> {
        assert_eq!(push.len(), layout.push_size as usize, "push constants of {name}");
        assert_eq!(resources.len(), layout.bindings.len(), "bindings of {name}: {:?}", layout.bindings);
        let mut images = Vec::with_capacity(resources.len());
        let mut buffers = Vec::with_capacity(resources.len());
        let mut kinds = Vec::with_capacity(resources.len());
        for (binding_name, resource) in resources {
            let Some(binding) = layout.binding(binding_name) else {
                panic!("{name} has no binding {binding_name:?}: {:?}", layout.bindings)
            };
            let (image, buffer, kind) = self.descriptor(*resource)?;
            assert_eq!(kind, binding.kind, "binding {binding_name} of {name}");
            let many = match resource {
                Resource::SampledArray(slices, sampler) => {
                    let image = |s: &ImageSlice| Ok(self.descriptor(Resource::Sampled(*s, *sampler))?.0);
                    slices.iter().map(image).collect::<Result<_>>()?
                }
                _ => vec![image],
            };
            assert_eq!(many.len(), binding.count as usize, "binding {binding_name} of {name}");
            images.push(many);
            buffers.push([buffer]);
            kinds.push(binding);
        }
        let set = match &mut self.context.sets {
            Some(sets) if !layout.bindings.is_empty() => Some(sets.take(layout.set, name)?),
            _ => None,
        };
        let writes: Vec<_> = kinds
            .iter()
            .enumerate()
            .map(|(i, b)| {
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set.unwrap_or_default())
                    .dst_binding(b.binding)
                    .descriptor_type(b.kind.descriptor_type());
                match b.kind {
                    BindingKind::SampledImage | BindingKind::StorageImage => write.image_info(&images[i]),
                    BindingKind::UniformBuffer | BindingKind::StorageBuffer => write.buffer_info(&buffers[i]),
                }
            })
            .collect();
        let commands = self.context.commands;
        // SAFETY: the layout is the bound pipeline's; what the writes point to outlives the frame's
        // submission, which the host waits for; a set is this frame's alone.
        unsafe {
            if let Some(set) = set {
                self.device().update_descriptor_sets(&writes, &[]);
                self.device().cmd_bind_descriptor_sets(commands, point, layout.pipeline, 0, &[set], &[]);
            } else if !writes.is_empty() {
                let push = &self.context.gpu.shared().push_descriptor;
                push.cmd_push_descriptor_set(commands, point, layout.pipeline, 0, &writes);
            }
            if !push.is_empty() {
                self.device().cmd_push_constants(commands, layout.pipeline, layout.stages, 0, push);
            }
        }
        Ok(())
    }

    fn descriptor(
        &mut self,
        resource: Resource,
    ) -> Result<(vk::DescriptorImageInfo, vk::DescriptorBufferInfo, BindingKind)> {
        let (mut image, mut buffer) = (vk::DescriptorImageInfo::default(), vk::DescriptorBufferInfo::default());
        let kind = match resource {
            Resource::Sampled(slice, sampler) => {
                image = image
                    .sampler(self.context.gpu.sampler(sampler))
                    .image_view(slice.view())
                    .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
                BindingKind::SampledImage
            }
            // Each of its images is written by itself.
            Resource::SampledArray(..) => BindingKind::SampledImage,
            Resource::Storage(slice) | Resource::Loaded(slice) => {
                image = image.image_view(slice.view()).image_layout(vk::ImageLayout::GENERAL);
                BindingKind::StorageImage
            }
            Resource::Buffer(b) | Resource::ReadBuffer(b) => {
                buffer = buffer.buffer(b.handle()).range(vk::WHOLE_SIZE);
                BindingKind::StorageBuffer
            }
            Resource::Uniform(bytes) => {
                buffer = self.context.uniforms.put(bytes)?;
                BindingKind::UniformBuffer
            }
        };
        Ok((image, buffer, kind))
    }
}
