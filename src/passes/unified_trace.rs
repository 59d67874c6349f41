//! The trace of `unified`: one ray a pixel over the pyramid, its hit's colour, and the composite.

use super::{GBuffer, Hits, Pyramid, Reflection};
use crate::error::Result;
use crate::gpu::shader::{UNIFIED_MIRROR_FRAG, UNIFIED_MIRROR_HITS_FRAG, UnifiedBlock};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Target};
use ash::vk;

const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const HITS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Pipeline and images of one size.
pub struct UnifiedTracePass {
    mirror: GraphicsPipeline,
    reflection: Image,
    composite: Image,
    hits: Option<Image>,
}

/// What the pass made.
#[derive(Clone, Copy)]
pub struct Traced<'a> {
    /// Reflection colour and fade.
    pub reflection: Reflection<'a>,
    /// The finished image, linear.
    pub composite: &'a Image,
    /// Where each ray ended, if asked for.
    pub hits: Option<Hits<'a>>,
}

impl UnifiedTracePass {
    /// For images of a size in pixels; `hits` asks for them beside the image.
    pub fn new(gpu: &Gpu, extent: [u32; 2], hits: bool) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |name, format| {
            let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        Ok(Self {
            mirror: if hits {
                GraphicsPipeline::fullscreen(gpu, &UNIFIED_MIRROR_HITS_FRAG, &[COLOR, COLOR, HITS])?
            } else {
                GraphicsPipeline::fullscreen(gpu, &UNIFIED_MIRROR_FRAG, &[COLOR, COLOR])?
            },
            reflection: image("reflection", COLOR)?,
            composite: image("composite", COLOR)?,
            hits: hits.then(|| image("hits", HITS)).transpose()?,
        })
    }

    /// Pass "trace".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        pyramid: Pyramid,
        parameters: &UnifiedBlock,
    ) -> Result<Traced<'a>> {
        let images = [Some(&self.reflection), Some(&self.composite), self.hits.as_ref()];
        let targets: Vec<_> = images.into_iter().flatten().map(|i| Target::overwrite(i.all())).collect();
        frame.fullscreen(
            "trace",
            &self.mirror,
            &targets,
            &[
                ("unified", Resource::Uniform(bytemuck::bytes_of(parameters))),
                ("pyramid", Resource::nearest(pyramid.0.all())),
                ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
                ("material_buffer", Resource::nearest(gbuffer.material.all())),
                ("color_buffer", Resource::trilinear(gbuffer.color.level(0))),
            ],
            &[],
        )?;
        Ok(Traced {
            reflection: Reflection(&self.reflection),
            composite: &self.composite,
            hits: self.hits.as_ref().map(Hits),
        })
    }
}
