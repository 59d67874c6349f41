//! Passes of pipelines whose bindings are looked up by name: for passes that do not use the programs' types yet.

use super::bind::Given;
use super::draw::Vertices;
use super::{Frame, Resource, Target};
use crate::error::Result;
use crate::gpu::image::ImageSlice;
use crate::gpu::memory::Buffer;
use crate::gpu::named::{NamedComputePipeline, NamedGraphicsPipeline};
use crate::gpu::pipeline::Layout;
use crate::gpu::program::Sampled;

impl<'a> Resource<'a> {
    /// Fetched, or sampled at the nearest texel.
    pub fn nearest(slice: ImageSlice<'a>) -> Self {
        Self::Sampled(Sampled::nearest(slice))
    }

    /// Sampled with trilinear filtering.
    pub fn trilinear(slice: ImageSlice<'a>) -> Self {
        Self::Sampled(Sampled::trilinear(slice))
    }
}

fn given<'a>(layout: &Layout, name: &str, resources: &[(&str, Resource<'a>)], push: &'a [u8]) -> Given<'a> {
    assert_eq!(push.len(), layout.push_size as usize, "push constants of {name}");
    assert_eq!(resources.len(), layout.bindings.len(), "bindings of {name}: {:?}", layout.bindings);
    let found = resources.iter().map(|(binding_name, resource)| {
        let binding = layout.bindings.iter().copied().find(|b| b.name == *binding_name);
        let Some(binding) = binding else { panic!("{name} has no binding {binding_name:?}: {:?}", layout.bindings) };
        (binding, *resource)
    });
    Given { resources: found.collect(), push }
}

impl Frame<'_> {
    /// As [`Self::fullscreen`].
    pub fn fullscreen_named(
        &mut self,
        name: &str,
        pipeline: &NamedGraphicsPipeline,
        targets: &[Target],
        resources: &[(&str, Resource)],
        push: &[u8],
    ) -> Result<()> {
        let given = given(&pipeline.0.layout, name, resources, push);
        self.shade(name, &pipeline.0, (targets, None), &given, Vertices::Triangle)
    }

    /// As [`Self::draw_indirect`].
    pub fn draw_indirect_named(
        &mut self,
        name: &str,
        pipeline: &NamedGraphicsPipeline,
        targets: &[Target],
        resources: &[(&str, Resource)],
        push: &[u8],
        (arguments, offset): (&Buffer, u64),
    ) -> Result<()> {
        let given = given(&pipeline.0.layout, name, resources, push);
        self.shade(name, &pipeline.0, (targets, None), &given, Vertices::Said(arguments, offset))
    }

    /// As [`Self::compute`].
    pub fn compute_named(
        &mut self,
        name: &str,
        pipeline: &NamedComputePipeline,
        resources: &[(&str, Resource)],
        push: &[u8],
        threads: [u32; 3],
    ) -> Result<()> {
        let given = given(&pipeline.0.layout, name, resources, push);
        self.dispatch(name, &pipeline.0, &given, threads)
    }
}
