//! The mirrors of `unified`: one pass traces a ray for each mirror pixel, shades what it sees, and composites, over the
//! tiles of a list or over the whole image. Rays walk over the pyramid, and the triangles that pixels show may confirm
//! their hits; or all rays are traced among the triangles.

use super::lost::LostRayBindings;
use super::tiles::{TileRange, TiledPipeline, Tiles, UnifiedSetup};
use super::triangle_scene::TriangleBindings;
use super::{Canvas, GBuffer, HITS, Hits, NO_HIT, Pyramid};
use crate::error::Result;
use crate::gpu::programs::{Mirror, MirrorConstants};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, Sampled, ShaderStage, Target};
use ash::vk;
use ssct_ground::math::constants::MIRROR_LIST;

/// Pipelines and images of one size.
pub struct UnifiedTracePass {
    stage: ShaderStage,
    mirrors: TiledPipeline<Mirror<'static>>,
    hits: Option<Image>,
}

/// The inputs of the pass, and the images that it draws into.
#[derive(Clone, Copy)]
pub struct UnifiedTraceInput<'a> {
    /// Normals, materials and lit colour.
    pub gbuffer: GBuffer<'a>,
    /// The pyramid that rays walk over.
    pub pyramid: Pyramid<'a>,
    /// The tiles to draw, over what [`Canvas::begin`] drew; or the whole image, over a canvas without content.
    pub tiles: Tiles<'a>,
    /// The images to draw into.
    pub canvas: Canvas<'a>,
    /// The sky, and the list of rays that the screen lost.
    pub lost_rays: LostRayBindings<'a>,
    /// The triangles, if rays are traced among them.
    pub triangle_bindings: Option<TriangleBindings<'a>>,
}

impl UnifiedTracePass {
    /// Makes the pass. `hits` asks for an image of the hits.
    ///
    /// # Errors
    /// Errors of [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup, hits: bool) -> Result<Self> {
        let [first, second] = setup.formats();
        let formats = [first, second, if hits { HITS } else { vk::Format::UNDEFINED }];
        let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
        let UnifiedSetup { follows_lost_rays: followed, composite, .. } = *setup;
        let (orthographic, beside) = (setup.projection.is_orthographic(), setup.wants_both());
        let triangle_constants = setup.triangle_constants();
        let constants = |whole| MirrorConstants {
            strip,
            oracle,
            hits,
            whole,
            followed,
            composite,
            beside,
            orthographic,
            triangle_constants,
        };
        let (range, permutation) = (TileRange { list: MIRROR_LIST, halved: false }, setup.trace_permutation());
        Ok(Self {
            stage: permutation.stage,
            mirrors: TiledPipeline::new(gpu, range, permutation, formats, constants)?,
            hits: hits.then(|| setup.target(gpu, "hits", HITS)).transpose()?,
        })
    }

    /// Records pass "trace/mirrors", and returns where each ray ended, if hits are wanted. Compute shaders over tiles
    /// write the pixels of these tiles alone, so that pass "hits" clears the image of hits first.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        UnifiedTraceInput { gbuffer, pyramid, tiles, canvas, lost_rays, triangle_bindings }: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
    ) -> Result<Option<Hits<'a>>> {
        if self.stage == ShaderStage::Compute && !tiles.whole {
            self.clear_hits(frame)?;
        }
        let [first, second] = canvas.targets(*tiles);
        let hits = self.hits.as_ref().map_or(Target::unwanted(), |image| tiles.target_in(image, NO_HIT));
        let program = Mirror {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            screen_resources: lost_rays.screen_resources(gbuffer, *pyramid),
            color_buffer: Some(Sampled::nearest(gbuffer.color.level(0))),
            lost_ray_resources: lost_rays.resources(),
            ray_structure: triangle_bindings.and_then(|bindings| bindings.triangles.structure),
            triangle_resources: triangle_bindings.map(|bindings| bindings.resources()),
        };
        self.mirrors.run(frame, "trace/mirrors", (parameters, *tiles), [first, second, hits], &program)?;
        Ok(self.hits.as_ref().map(Hits))
    }

    /// Records pass "hits" if hits are wanted: fills their image with [`NO_HIT`].
    pub fn clear_hits<'a>(&'a self, frame: &mut Frame) -> Result<Option<Hits<'a>>> {
        let Some(hits) = &self.hits else { return Ok(None) };
        frame.clear("hits", hits.all(), NO_HIT)?;
        Ok(Some(Hits(hits)))
    }
}
