//! The poster's cone march through the pre-filtered G-buffer.

use super::{FilteredGBuffer, GBuffer, Hits, PosterFilter, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::shader::{
    POSTER_CONE_MARCH_MIP_FRAG, POSTER_CONE_MARCH_MIP_HITS_FRAG, POSTER_CONE_MARCH_VOLUME_FRAG,
    POSTER_CONE_MARCH_VOLUME_HITS_FRAG, PosterBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Resource, Target};
use crate::scene::Camera;
use ash::vk;

const REFLECTION: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const HITS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Pipeline and images of one size.
pub struct ConeMarchPass {
    pipeline: GraphicsPipeline,
    reflection: Image,
    hits: Option<Image>,
}

impl ConeMarchPass {
    /// With the hits or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], filter: PosterFilter, with_hits: bool) -> Result<Self> {
        let image = |name, format| Image::target(gpu, name, format, extent);
        let shader = match (filter, with_hits) {
            (PosterFilter::Mip, false) => &POSTER_CONE_MARCH_MIP_FRAG,
            (PosterFilter::Mip, true) => &POSTER_CONE_MARCH_MIP_HITS_FRAG,
            (PosterFilter::Volume, false) => &POSTER_CONE_MARCH_VOLUME_FRAG,
            (PosterFilter::Volume, true) => &POSTER_CONE_MARCH_VOLUME_HITS_FRAG,
        };
        let targets = if with_hits { &[REFLECTION, HITS][..] } else { &[REFLECTION] };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, shader, targets)?,
            reflection: image("reflection", REFLECTION)?,
            hits: with_hits.then(|| image("hits", HITS)).transpose()?,
        })
    }

    /// Pass "cone march".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        filtered: FilteredGBuffer,
        camera: &Camera,
        parameters: &PosterBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let block = camera_block(camera, self.reflection.extent());
        let mut targets = vec![Target::overwrite(self.reflection.all())];
        targets.extend(self.hits.as_ref().map(|h| Target::overwrite(h.all())));
        frame.fullscreen(
            "cone march",
            &self.pipeline,
            &targets,
            &[
                ("camera", Resource::Uniform(bytemuck::bytes_of(&block))),
                ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
                ("material_buffer", Resource::nearest(gbuffer.material.all())),
                ("filtered_depth", Resource::trilinear(filtered.depth.all())),
                ("filtered_normal", Resource::trilinear(filtered.normal.all())),
                ("filtered_color", Resource::trilinear(filtered.color.all())),
            ],
            bytemuck::bytes_of(parameters),
        )?;
        Ok((Reflection(&self.reflection), self.hits.as_ref().map(Hits)))
    }
}
