//! SSLR's first stage: a uniform march, and the colour where it ends (thesis §4.3.1).

use super::{GBuffer, HITS, HiZ, Hits, RayTraceColor};
use crate::error::Result;
use crate::gpu::shader::{THESIS_SSLR_RAY_TRACE_FRAG, THESIS_SSLR_RAY_TRACE_HITS_FRAG, ThesisBlock};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Sampler, Target, image};
use ash::vk;

// The colour is linear here and was a display colour in the author's program: encoded, 8 bits are as
// fine in the dark as they were there.
const COLOR: vk::Format = vk::Format::R8G8B8A8_SRGB;
const MASK: vk::Format = vk::Format::R8_UNORM;

/// Pipeline and images of one size; the images have room for their chains.
pub struct SslrTracePass {
    pipeline: GraphicsPipeline,
    color: Image,
    mask: Image,
    hits: Option<Image>,
}

impl SslrTracePass {
    /// With the hits or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], with_hits: bool) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let image =
            |name, format, levels| Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage });
        let levels = image::full_chain(extent);
        let (shader, targets) = if with_hits {
            (&THESIS_SSLR_RAY_TRACE_HITS_FRAG, &[COLOR, MASK, HITS][..])
        } else {
            (&THESIS_SSLR_RAY_TRACE_FRAG, &[COLOR, MASK][..])
        };
        Ok(Self {
            pipeline: GraphicsPipeline::fullscreen(gpu, shader, targets)?,
            color: image("ray trace color", COLOR, levels)?,
            mask: image("mask", MASK, levels)?,
            hits: with_hits.then(|| image("hits", HITS, 1)).transpose()?,
        })
    }

    /// Formats of colour and mask.
    pub fn formats(&self) -> [vk::Format; 2] {
        [self.color.format(), self.mask.format()]
    }

    /// Pass "ray trace": level 0 of both chains.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        depth: HiZ,
        depth_sampler: Sampler,
        parameters: &ThesisBlock,
    ) -> Result<(RayTraceColor<'a>, Option<Hits<'a>>)> {
        let mut targets = vec![Target::overwrite(self.color.level(0)), Target::overwrite(self.mask.level(0))];
        targets.extend(self.hits.as_ref().map(|h| Target::overwrite(h.all())));
        frame.fullscreen(
            "ray trace",
            &self.pipeline,
            &targets,
            &[
                ("thesis", Resource::Uniform(bytemuck::bytes_of(parameters))),
                ("hiZBuffer", Resource::Sampled(depth.0.level(0), depth_sampler)),
                ("normalBuffer", Resource::nearest(gbuffer.normal.all())),
                ("materialBuffer", Resource::nearest(gbuffer.material.all())),
                ("colorBuffer", Resource::trilinear(gbuffer.color.level(0))),
            ],
            &[],
        )?;
        Ok((RayTraceColor { color: &self.color, mask: &self.mask }, self.hits.as_ref().map(Hits)))
    }
}
