//! The poster's cone march through the pre-filtered G-buffer.

use super::{FilteredGBuffer, GBuffer, Hits, PosterFilter, Reflection, TracedImages, camera_block};
use crate::error::Result;
use crate::gpu::programs::{ConeMarchMip, ConeMarchMipConstants, ConeMarchVolume, ConeMarchVolumeConstants};
use crate::gpu::shader::PosterBlock;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Sampled};
use crate::scene::Camera;

/// Pipeline and images of one size.
pub struct ConeMarchPass {
    march: March,
    images: TracedImages,
}

/// Through which kind of images.
enum March {
    Mip(GraphicsPipeline<ConeMarchMip<'static>>),
    Volume(GraphicsPipeline<ConeMarchVolume<'static>>),
}

impl ConeMarchPass {
    /// With an image of the hits, or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], filter: PosterFilter, hits: bool) -> Result<Self> {
        let formats = TracedImages::formats(hits);
        let march = match filter {
            PosterFilter::Mip => {
                March::Mip(GraphicsPipeline::fullscreen_with(gpu, formats, &ConeMarchMipConstants { hits })?)
            }
            PosterFilter::Volume => {
                March::Volume(GraphicsPipeline::fullscreen_with(gpu, formats, &ConeMarchVolumeConstants { hits })?)
            }
        };
        Ok(Self { march, images: TracedImages::new(gpu, extent, hits)? })
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
        let camera = &camera_block(camera, self.images.extent());
        let normal_buffer = Sampled::nearest(gbuffer.normal.all());
        let material_buffer = Sampled::nearest(gbuffer.material.all());
        let filtered_depth = Sampled::trilinear(filtered.depth.all());
        let filtered_normal = Sampled::trilinear(filtered.normal.all());
        let filtered_color = Sampled::trilinear(filtered.color.all());
        let (name, targets, poster) = ("cone march", self.images.targets(), parameters);
        match &self.march {
            March::Mip(pipeline) => frame.fullscreen(
                name,
                pipeline,
                targets,
                &ConeMarchMip {
                    camera,
                    normal_buffer,
                    material_buffer,
                    filtered_depth,
                    filtered_normal,
                    filtered_color,
                    poster,
                },
            )?,
            March::Volume(pipeline) => frame.fullscreen(
                name,
                pipeline,
                targets,
                &ConeMarchVolume {
                    camera,
                    normal_buffer,
                    material_buffer,
                    filtered_depth,
                    filtered_normal,
                    filtered_color,
                    poster,
                },
            )?,
        }
        Ok(self.images.traced())
    }
}
