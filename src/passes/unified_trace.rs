//! The trace of `unified`: one ray for each mirror pixel over the pyramid, its hit's colour, and the composite in the
//! same pass, over the tiles of a list or over the whole image.

use super::lost::Beyond;
use super::tiles::{Over, TileStage, TiledPipeline, Tiles, UnifiedSetup, in_either_stage};
use super::{Canvas, GBuffer, HITS, Hits, NO_HIT, Pyramid, unwanted_hits};
use crate::error::Result;
use crate::gpu::programs::{Mirror, MirrorCompute, MirrorComputeConstants, MirrorConstants};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, Sampled, Target};
use crate::math::constants::MIRROR_LIST;
use ash::vk;

/// Pipelines and images of one size.
pub struct UnifiedTracePass {
    stage: TileStage,
    mirrors: TiledPipeline<Mirror<'static>, MirrorCompute<'static>>,
    hits: Option<Image>,
    unwanted_hits: Option<Image>,
}

/// What the pass reads.
#[derive(Clone, Copy)]
pub struct UnifiedTraceInput<'a> {
    /// Normals, materials and lit colour.
    pub gbuffer: GBuffer<'a>,
    /// Blocks to trace.
    pub pyramid: Pyramid<'a>,
    /// Where to trace: over a canvas that has begun, or over the whole of one that holds nothing.
    pub tiles: Tiles<'a>,
    /// Where to draw.
    pub canvas: Canvas<'a>,
    /// The sky, and where rays go that the screen lost.
    pub beyond: Beyond<'a>,
}

impl UnifiedTracePass {
    /// With an image of the hits beside what is drawn, or without.
    ///
    /// # Errors
    /// As [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup, hits: bool) -> Result<Self> {
        let [shown, beside] = setup.formats();
        let formats = || [shown, beside, if hits { HITS } else { vk::Format::UNDEFINED }];
        let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
        let UnifiedSetup { screen, followed, triangles, composite, sky, trace: stage, .. } = *setup;
        let over = Over { list: MIRROR_LIST, halved: false };
        let fragment =
            |whole| MirrorConstants { strip, oracle, hits, whole, screen, followed, triangles, composite, sky };
        let beside = setup.beside();
        let compute = |whole| MirrorComputeConstants {
            strip,
            oracle,
            hits,
            whole,
            screen,
            followed,
            triangles,
            composite,
            sky,
            beside,
        };
        Ok(Self {
            stage,
            mirrors: TiledPipeline::new(gpu, (stage, over), formats, fragment, compute)?,
            hits: hits.then(|| setup.target(gpu, "hits", HITS)).transpose()?,
            unwanted_hits: (!hits).then(|| unwanted_hits(gpu)).transpose()?,
        })
    }

    /// Pass "trace/mirrors". Gives where each ray ended, if that was asked for. In compute shaders over tiles the pass
    /// "hits" goes before it then: no attachment is cleared along with the trace.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        UnifiedTraceInput { gbuffer, pyramid, tiles, canvas, beyond }: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
    ) -> Result<Option<Hits<'a>>> {
        let wanted = self.hits.as_ref();
        if self.stage == TileStage::Compute && !tiles.whole {
            self.no_hits(frame)?;
        }
        let stored = canvas.stored().zip(wanted.or(self.unwanted_hits.as_ref()));
        let Some(([color, reflection], hits)) = stored else { return Ok(wanted.map(Hits)) };
        let targets = || {
            let [composite, reflection] = canvas.targets(*tiles);
            [composite, reflection, wanted.map_or(Target::unwanted(), |image| tiles.target_in(image, NO_HIT))]
        };
        let programs = in_either_stage! {
            Mirror => targets(),
            MirrorCompute over tiles => {
                color_image: color.all(),
                reflection_image: reflection.all(),
                hits_image: hits.all(),
            },
            unified: parameters,
            pyramid: pyramid.0.all(),
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            triangle_buffer: beyond.triangle_of(gbuffer),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_buffer: Sampled::trilinear(gbuffer.color.level(0)),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
        };
        self.mirrors.run(frame, "trace/mirrors", (parameters, *tiles), programs)?;
        Ok(wanted.map(Hits))
    }

    /// Pass "hits", if they were asked for: without mirrors, no ray begins anywhere.
    pub fn no_hits<'a>(&'a self, frame: &mut Frame) -> Result<Option<Hits<'a>>> {
        let Some(hits) = &self.hits else { return Ok(None) };
        frame.clear("hits", hits.all(), NO_HIT)?;
        Ok(Some(Hits(hits)))
    }
}
