//! Passes that follow the rays that the screen lost ([`lost`](super::lost)) through the captures of a scene
//! (docs/definitions.md, "Images"). The number of rays on the list sizes the dispatches of these passes.

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

/// The variant of the passes: which outputs are wanted, and where rays begin.
#[derive(Debug, Clone, Copy, Default)]
pub struct FollowWants {
    /// Whether another reflection, a fallback, shows where no image shows the end of a ray.
    pub over_fallback: bool,
    /// Whether the finished image is wanted.
    pub composite: bool,
    /// Whether the reflection is wanted as an image of its own.
    pub reflection: bool,
    /// Whether the image of hits is wanted, which says where each ray ended.
    pub hits: bool,
    /// Whether the passes store, for a history, where each ray of a glossy pixel ended.
    pub stores_ends: bool,
    /// Whether the method is a fallback, so that rays begin only where the reflection in front is not opaque.
    pub is_fallback: bool,
    /// The screen's projection.
    pub projection: ProjectionKind,
}

/// The inputs of all passes that follow rays.
#[derive(Clone, Copy)]
pub struct FollowInput<'a> {
    /// The captures in which rays go on.
    pub captures: Captures<'a>,
    /// The list of rays, the camera among the captures, and the sky.
    pub lost_rays: LostRayBindings<'a>,
}

impl FollowPass {
    /// Compiles the pipelines, for faces whose pyramids have strips of 2^`strip` columns.
    pub fn new(gpu: &Gpu, strip: u32, wanted: FollowWants) -> Result<Self> {
        let strip = strip as i32;
        let FollowWants { over_fallback: over, composite, reflection, hits, stores_ends, is_fallback, projection } =
            wanted;
        let begin =
            programs::BeginInCapturesConstants { behind: is_fallback, orthographic: projection.is_orthographic() };
        let mirrors = programs::FollowMirrorsConstants { strip, over, composite, reflection, hits };
        Ok(Self {
            begin: ComputePipeline::with_constants(gpu, &begin)?,
            mirrors: ComputePipeline::with_constants(gpu, &mirrors)?,
            narrow: ComputePipeline::with_constants(
                gpu,
                &programs::FollowNarrowConstants { strip, over, stores_ends },
            )?,
            wide: ComputePipeline::with_constants(gpu, &programs::FollowWideConstants { strip, over, stores_ends })?,
            unwanted_hits: (!hits).then(|| unwanted_hits(gpu)).transpose()?,
        })
    }

    /// Records pass "begin", which puts the mirror ray of every reflecting pixel on the list, from the pixel's point. A
    /// fallback leaves out the pixels in which the reflection `in_front` is opaque; other methods read no such image.
    pub fn record_begin(
        &self,
        frame: &mut Frame,
        lost_rays: LostRayBindings,
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
            lost_ray_resources: lost_rays.resources(),
        };
        frame.compute("begin", &self.begin, &program, [width, height, 1])
    }

    /// Records pass "follow/mirrors", which follows the mirror rays on the list and finishes their pixels.
    pub fn record_mirrors(
        &self,
        frame: &mut Frame,
        FollowInput { captures, lost_rays }: FollowInput,
        gbuffer: &GBuffer,
        canvas: Canvas,
        hits: Option<Hits>,
    ) -> Result<()> {
        // An image that is not wanted is not written, but its binding needs some image.
        let Some(any) = canvas.images().next() else { return Ok(()) };
        let Some(hits) = hits.map(|hits| hits.0).or(self.unwanted_hits.as_ref()) else { return Ok(()) };
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
            lost_ray_resources: lost_rays.resources(),
        };
        frame.compute_indirect("follow/mirrors", &self.mirrors, &program, (lost_rays.counts, 0))
    }

    /// Records pass "follow/narrow", which follows the rays of narrow lobes. It writes to `records` what they see, and
    /// to `ends` where they end, if a history asks for it.
    pub fn record_narrow(
        &self,
        frame: &mut Frame,
        FollowInput { captures, lost_rays }: FollowInput,
        [records, ends]: [&Image; 2],
    ) -> Result<()> {
        let program = programs::FollowNarrow {
            unified: captures.face,
            pyramid: captures.pyramid.all(),
            normal_buffer: captures.normal.all(),
            color_cubes: Sampled::trilinear(captures.color.all()),
            seen_image: records.all(),
            ends_image: ends.all(),
            lost_ray_resources: lost_rays.resources(),
        };
        frame.compute_indirect("follow/narrow", &self.narrow, &program, (lost_rays.counts, 0))
    }

    /// Records pass "follow/wide", which follows the rays of cells with wide lobes. It writes to `seen` what they see,
    /// and to `place`, and for a history to `ends`, where they end.
    pub fn record_wide(
        &self,
        frame: &mut Frame,
        FollowInput { captures, lost_rays }: FollowInput,
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
            lost_ray_resources: lost_rays.resources(),
        };
        frame.compute_indirect("follow/wide", &self.wide, &program, (lost_rays.counts, 0))
    }
}
