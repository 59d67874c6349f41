//! The trace of `unified`: one ray for each mirror pixel over the pyramid, its hit's colour, and the composite in the
//! same pass, over the tiles of a list or over the whole image.

use super::lost::Beyond;
use super::tiles::{TiledPipeline, Tiles, UnifiedSetup};
use super::{Canvas, GBuffer, HITS, Hits, NO_HIT, Pyramid};
use crate::error::Result;
use crate::gpu::programs::{Mirror, MirrorConstants};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, Sampled, Target};
use crate::math::constants::MIRROR_LIST;
use ash::vk;

/// Pipelines and images of one size.
pub struct UnifiedTracePass {
    mirrors: TiledPipeline<Mirror<'static>>,
    hits: Option<Image>,
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
        let UnifiedSetup { followed, composite, sky, .. } = *setup;
        let constants = |whole| MirrorConstants { strip, oracle, hits, whole, followed, composite, sky };
        let target = if followed { super::stored_target } else { Image::target };
        Ok(Self {
            mirrors: TiledPipeline::new(gpu, MIRROR_LIST, formats, constants)?,
            hits: hits.then(|| target(gpu, "hits", HITS, setup.extent)).transpose()?,
        })
    }

    /// Pass "trace/mirrors". Gives where each ray ended, if that was asked for.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        UnifiedTraceInput { gbuffer, pyramid, tiles, canvas, beyond }: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
    ) -> Result<Option<Hits<'a>>> {
        let hits = self.hits.as_ref();
        let [composite, reflection] = canvas.targets(*tiles);
        let targets = [composite, reflection, hits.map_or(Target::unwanted(), |image| tiles.target_in(image, NO_HIT))];
        let mirror = Mirror {
            unified: parameters,
            pyramid: pyramid.0.all(),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_buffer: Sampled::trilinear(gbuffer.color.level(0)),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
        };
        self.mirrors.draw(frame, "trace/mirrors", targets, &mirror, (parameters, *tiles, false))?;
        Ok(hits.map(Hits))
    }

    /// Pass "hits", if they were asked for: without mirrors, no ray begins anywhere.
    pub fn no_hits<'a>(&'a self, frame: &mut Frame) -> Result<Option<Hits<'a>>> {
        let Some(hits) = &self.hits else { return Ok(None) };
        frame.clear("hits", hits.all(), NO_HIT)?;
        Ok(Some(Hits(hits)))
    }
}
