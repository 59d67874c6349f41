//! The poster's cone march through the pre-filtered G-buffer.

use super::traced::TracedPass;
use super::{FilteredGBuffer, GBuffer, Hits, PosterFilter, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::programs::{ConeMarchMip, ConeMarchMipConstants, ConeMarchVolume, ConeMarchVolumeConstants};
use crate::gpu::shader::PosterBlock;
use crate::gpu::{Frame, Gpu, Sampled};
use crate::scene::Camera;

/// Pipeline and images of one size, by the kind of images that it goes through.
pub enum ConeMarchPass {
    /// Through mip chains.
    Mip(TracedPass<ConeMarchMip<'static>>),
    /// Through volumes.
    Volume(TracedPass<ConeMarchVolume<'static>>),
}

impl ConeMarchPass {
    /// With an image of the hits, or without.
    pub fn new(gpu: &Gpu, extent: [u32; 2], filter: PosterFilter, hits: bool) -> Result<Self> {
        Ok(match filter {
            PosterFilter::Mip | PosterFilter::EdgeAware => {
                Self::Mip(TracedPass::new(gpu, extent, &ConeMarchMipConstants { hits }, hits)?)
            }
            PosterFilter::Volume => {
                Self::Volume(TracedPass::new(gpu, extent, &ConeMarchVolumeConstants { hits }, hits)?)
            }
        })
    }

    /// Pass "cone march".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        filtered: FilteredGBuffer,
        camera: &Camera,
        poster: &PosterBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let camera = &camera_block(camera, gbuffer.depth.extent());
        let normal_buffer = Sampled::nearest(gbuffer.normal.all());
        let material_buffer = Sampled::nearest(gbuffer.material.all());
        let filtered_depth = Sampled::trilinear(filtered.depth.all());
        let filtered_normal = Sampled::trilinear(filtered.normal.all());
        let filtered_color = Sampled::trilinear(filtered.color.all());
        // Two types with the same fields, as they are two programs.
        macro_rules! march {
            ($pass:expr, $program:ident) => {{
                $pass.draw(
                    frame,
                    "cone march",
                    &$program {
                        camera,
                        normal_buffer,
                        material_buffer,
                        filtered_depth,
                        filtered_normal,
                        filtered_color,
                        poster,
                    },
                )?;
                Ok($pass.traced())
            }};
        }
        match self {
            Self::Mip(pass) => march!(pass, ConeMarchMip),
            Self::Volume(pass) => march!(pass, ConeMarchVolume),
        }
    }
}
