//! The poster's cone march through the pre-filtered G-buffer.

use super::traced::TracedPass;
use super::{FilteredGBuffer, GBuffer, Hits, PosterFilter, Reflection, camera_block};
use crate::error::Result;
use crate::gpu::programs::{ConeMarchMip, ConeMarchMipConstants, ConeMarchVolume, ConeMarchVolumeConstants};
use crate::gpu::shader::PosterBlock;
use crate::gpu::{Frame, Gpu, Sampled, ShaderStage};
use ssct_ground::scene::Camera;

/// The numbers of the march that the poster prints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarchSteps {
    /// Factor from the length of one step of the march to the next.
    pub step_increase: f32,
    /// Steps of the march at most.
    pub step_count: i32,
    /// Steps of the binary search at most.
    pub search_count: i32,
    /// Factor from the length of one step of the search to the next.
    pub search_decrease: f32,
}

/// Pipeline and images of one size, by the kind of filtered images that the march reads.
pub enum ConeMarchPass {
    /// Through mip chains.
    Mip(TracedPass<ConeMarchMip<'static>>),
    /// Through volumes.
    Volume(TracedPass<ConeMarchVolume<'static>>),
}

impl ConeMarchPass {
    /// Makes the pass. `hits` asks for an image of the hits, and `layers` for a march through two layers of depth.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        filter: PosterFilter,
        steps: MarchSteps,
        hits: bool,
        layers: bool,
    ) -> Result<Self> {
        let MarchSteps { step_increase, step_count, search_count, search_decrease } = steps;
        // The two programs have different types with the same fields.
        macro_rules! pass {
            ($constants:ident) => {{
                let constants = $constants { hits, layers, step_increase, step_count, search_count, search_decrease };
                TracedPass::new(gpu, stage, extent, &constants, hits)?
            }};
        }
        Ok(match filter {
            PosterFilter::Mip | PosterFilter::EdgeAware => Self::Mip(pass!(ConeMarchMipConstants)),
            PosterFilter::Volume => Self::Volume(pass!(ConeMarchVolumeConstants)),
        })
    }

    /// Records pass "cone march".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        filtered: FilteredGBuffer,
        second_layer: Option<FilteredGBuffer>,
        camera: &Camera,
        poster: &PosterBlock,
    ) -> Result<(Reflection<'a>, Option<Hits<'a>>)> {
        let camera = &camera_block(camera, gbuffer.depth.extent());
        let normal_buffer = Sampled::nearest(gbuffer.normal.all());
        let material_buffer = Sampled::nearest(gbuffer.material.all());
        let filtered_depth = Sampled::trilinear(filtered.depth.all());
        let filtered_normal = Sampled::trilinear(filtered.normal.all());
        let filtered_color = Sampled::trilinear(filtered.color.all());
        // A program for one layer does not read the bindings of the second.
        let behind = second_layer.unwrap_or(filtered);
        let behind_depth = Sampled::trilinear(behind.depth.all());
        let behind_normal = Sampled::trilinear(behind.normal.all());
        let behind_color = Sampled::trilinear(behind.color.all());
        // The two programs have different types with the same fields.
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
                        behind_depth,
                        behind_normal,
                        behind_color,
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
