//! Passes that follow the rays that the screen lost ([`lost`](super::lost)) through the captures of a scene (docs/definitions.md,
//! "Images"). The number of rays on the list sizes their dispatches.

use super::lost::LostRayBindings;
use super::{Canvas, Captures, GBuffer, Hits, Reflection, unwanted_hits};
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, Sampled, programs};
use ssct_ground::scene::ProjectionKind;

/// The pipelines.
pub struct FollowPass {
    begin: ComputePipeline<programs::BeginInCaptures<'static>>,
    mirrors: ComputePipeline<programs::FollowMirrors<'static>>,
    narrow: ComputePipeline<programs::FollowNarrow<'static>>,
    wide: ComputePipeline<programs::FollowWide<'static>>,
    unwanted_hits: Option<Image>,
}

/// The outputs that are wanted, and where rays begin.
#[derive(Debug, Clone, Copy, Default)]
pub struct FollowWants {
    /// Whether another reflection shows where no image shows the end of a ray.
    pub over: bool,
    /// The finished image.
    pub composite: bool,
    /// The reflection as an image of its own.
    pub reflection: bool,
    /// Where each ray ended.
    pub hits: bool,
    /// Where each ray of a glossy pixel ended, for a history.
    pub stores_ends: bool,
    /// Whether rays begin only where the reflection in front leaves something uncovered.
    pub behind: bool,
    /// The screen's projection.
    pub projection: ProjectionKind,
}

/// The inputs of every pass of this file.
#[derive(Clone, Copy)]
pub struct FollowInput<'a> {
    /// The captures in which rays go on.
    pub captures: Captures<'a>,
    /// The rays, the camera among the captures, and the sky.
    pub beyond: LostRayBindings<'a>,
}

impl FollowPass {
    /// Compiles the pipelines, for faces whose pyramids have strips of 2^`strip` columns.
    pub fn new(gpu: &Gpu, strip: u32, wanted: FollowWants) -> Result<Self> {
        let strip = strip as i32;
        let FollowWants { over, composite, reflection, hits, stores_ends, behind, projection } = wanted;
        let begin = programs::BeginInCapturesConstants { behind, orthographic: projection.is_orthographic() };
        let mirrors = programs::FollowMirrorsConstants { strip, over, composite, reflection, hits };
        Ok(Self {
            begin: ComputePipeline::with(gpu, &begin)?,
            mirrors: ComputePipeline::with(gpu, &mirrors)?,
            narrow: ComputePipeline::with(gpu, &programs::FollowNarrowConstants { strip, over, stores_ends })?,
            wide: ComputePipeline::with(gpu, &programs::FollowWideConstants { strip, over, stores_ends })?,
            unwanted_hits: (!hits).then(|| unwanted_hits(gpu)).transpose()?,
        })
    }

    /// Records pass "begin": puts the ray of every pixel that reflects on the list, from where it begins.
    pub fn record_begin(
        &self,
        frame: &mut Frame,
        beyond: LostRayBindings,
        gbuffer: &GBuffer,
        in_front: Option<Reflection>,
        parameters: &UnifiedBlock,
    ) -> Result<()> {
        let [width, height] = gbuffer.depth.extent();
        let program = programs::BeginInCaptures {
            unified: parameters,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            reflection_buffer: Sampled::nearest(in_front.map_or(gbuffer.color.level(0), |r| r.0.all())),
            lost_ray_resources: beyond.resources(),
        };
        frame.compute("begin", &self.begin, &program, [width, height, 1])
    }

    /// Records pass "follow/mirrors": finishes the pixels whose mirror rays the screen lost.
    pub fn record_mirrors(
        &self,
        frame: &mut Frame,
        FollowInput { captures, beyond }: FollowInput,
        gbuffer: &GBuffer,
        canvas: Canvas,
        hits: Option<Hits>,
    ) -> Result<()> {
        // An image that is not wanted is not written, but its binding needs some image.
        let stored = canvas.images().next().zip(hits.map(|h| h.0).or(self.unwanted_hits.as_ref()));
        let Some((any, hits)) = stored else { return Ok(()) };
        let program = programs::FollowMirrors {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            color_buffer: Sampled::nearest(gbuffer.color.level(0)),
            composite_image: canvas.composite.unwrap_or(any).all(),
            reflection_image: canvas.reflection.unwrap_or(any).all(),
            hits_image: hits.all(),
            lost_ray_resources: beyond.resources(),
        };
        frame.compute_indirect("follow/mirrors", &self.mirrors, &program, (beyond.counts, 0))
    }

    /// Records pass "follow/narrow", which writes into the records what the rays of narrow lobes see after the screen lost them.
    pub fn record_narrow(
        &self,
        frame: &mut Frame,
        FollowInput { captures, beyond }: FollowInput,
        [records, ends]: [&Image; 2],
    ) -> Result<()> {
        let program = programs::FollowNarrow {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            seen_image: records.all(),
            ends_image: ends.all(),
            lost_ray_resources: beyond.resources(),
        };
        frame.compute_indirect("follow/narrow", &self.narrow, &program, (beyond.counts, 0))
    }

    /// Records pass "follow/wide", which stores where the rays of cells with wide lobes end, and what they see there,
    /// after the screen lost them.
    pub fn record_wide(
        &self,
        frame: &mut Frame,
        FollowInput { captures, beyond }: FollowInput,
        [place, seen, ends]: [&Image; 3],
    ) -> Result<()> {
        let program = programs::FollowWide {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            place_image: place.all(),
            seen_image: seen.all(),
            ends_image: ends.all(),
            lost_ray_resources: beyond.resources(),
        };
        frame.compute_indirect("follow/wide", &self.wide, &program, (beyond.counts, 0))
    }
}
