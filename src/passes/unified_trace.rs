//! The trace of `unified`: one ray for each mirror pixel, what it sees, and the composite in the same pass, over the tiles of a
//! list or over the whole image. Rays walk over the pyramid, and the triangles that pixels show may confirm their hits; or all rays
//! go among the triangles.

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
    /// The tiles to trace, over a canvas that has begun; or the whole of a canvas that is still empty.
    pub tiles: Tiles<'a>,
    /// The images to draw into.
    pub canvas: Canvas<'a>,
    /// The sky, and the list of rays that the screen lost.
    pub beyond: LostRayBindings<'a>,
    /// The triangles, where rays go among them.
    pub triangle_bindings: Option<TriangleBindings<'a>>,
}

impl UnifiedTracePass {
    /// Makes the pass with an image of the hits or without.
    ///
    /// # Errors
    /// Returns the errors of [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup, hits: bool) -> Result<Self> {
        let [shown, second] = setup.formats();
        let formats = [shown, second, if hits { HITS } else { vk::Format::UNDEFINED }];
        let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
        let UnifiedSetup { followed, composite, .. } = *setup;
        let (orthographic, beside) = (setup.projection.is_orthographic(), setup.beside());
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
    /// write only the pixels of these tiles, so the pass "hits" clears the image of hits first.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        UnifiedTraceInput { gbuffer, pyramid, tiles, canvas, beyond, triangle_bindings }: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
    ) -> Result<Option<Hits<'a>>> {
        let wanted = self.hits.as_ref();
        if self.stage == ShaderStage::Compute && !tiles.whole {
            self.no_hits(frame)?;
        }
        let [first, second] = canvas.targets(*tiles);
        let hits = wanted.map_or(Target::unwanted(), |image| tiles.target_in(image, NO_HIT));
        let program = Mirror {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            screen_resources: beyond.screen_resources(gbuffer, *pyramid),
            color_buffer: Some(Sampled::nearest(gbuffer.color.level(0))),
            lost_ray_resources: beyond.resources(),
            ray_structure: triangle_bindings.and_then(|bindings| bindings.triangles.structure),
            triangle_resources: triangle_bindings.map(|bindings| bindings.resources()),
        };
        self.mirrors.run(frame, "trace/mirrors", (parameters, *tiles), [first, second, hits], &program)?;
        Ok(wanted.map(Hits))
    }

    /// Records pass "hits", which says that no ray begins anywhere, if hits are wanted.
    pub fn no_hits<'a>(&'a self, frame: &mut Frame) -> Result<Option<Hits<'a>>> {
        let Some(hits) = &self.hits else { return Ok(None) };
        frame.clear("hits", hits.all(), NO_HIT)?;
        Ok(Some(Hits(hits)))
    }
}
