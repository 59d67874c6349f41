//! The trace of `unified`: one ray for each mirror pixel, what it sees, and the composite in the same pass, over the tiles of a
//! list or over the whole image. Rays walk over the pyramid, and the triangles that pixels show may confirm their hits; or all rays
//! go among the triangles.

use super::lost::LostRayBindings;
use super::tiles::{TileRange, TiledCompute, TiledPipeline, Tiles, UnifiedSetup, in_either_stage};
use super::tracer::{ByTracer, by_tracer};
use super::triangle_scene::{TriangleBindings, with_reading};
use super::{Canvas, GBuffer, HITS, Hits, NO_HIT, Pyramid, unwanted_hits};
use crate::error::Result;
use crate::gpu::programs::{
    Mirror, MirrorAmongTriangles, MirrorCompute, MirrorComputeConstants, MirrorConfirmed, MirrorConfirmedCompute,
    MirrorConstants, MirrorQueried,
};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, Sampled, ShaderStage, Target};
use ash::vk;
use ssct_ground::math::constants::MIRROR_LIST;

/// Pipelines and images of one size.
pub struct UnifiedTracePass {
    stage: ShaderStage,
    mirrors: Mirrors,
    hits: Option<Image>,
    unwanted_hits: Option<Image>,
}

/// The programs, one for each way to find where a ray ends.
enum Mirrors {
    /// On the screen alone, or on the screen and in captures.
    Screen(TiledPipeline<Mirror<'static>, MirrorCompute<'static>>),
    /// On the screen, with triangles that confirm the hits.
    Confirmed(TiledPipeline<MirrorConfirmed<'static>, MirrorConfirmedCompute<'static>>),
    /// Among the triangles alone.
    Triangles(ByTracer<TiledCompute<MirrorAmongTriangles<'static>>, TiledCompute<MirrorQueried<'static>>>),
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
        let [shown, beside] = setup.formats();
        let formats = || [shown, beside, if hits { HITS } else { vk::Format::UNDEFINED }];
        let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
        let UnifiedSetup { followed, triangles, composite, trace, .. } = *setup;
        let orthographic = setup.projection.is_orthographic();
        let range = TileRange { list: MIRROR_LIST, halved: false };
        let beside = setup.beside();
        let (stage, mirrors) = match triangles {
            None => {
                let fragment =
                    |whole| MirrorConstants { strip, oracle, hits, whole, followed, composite, orthographic };
                let compute = |whole| MirrorComputeConstants {
                    strip,
                    oracle,
                    hits,
                    whole,
                    followed,
                    composite,
                    beside,
                    orthographic,
                };
                (trace, Mirrors::Screen(TiledPipeline::new(gpu, (trace, range), formats, fragment, compute)?))
            }
            Some(reading) if setup.screen => {
                let fragment = |whole| {
                    with_reading! { MirrorConfirmedConstants of reading,
                        strip, oracle, hits, whole, followed, composite, orthographic,
                    }
                };
                let compute = |whole| {
                    with_reading! { MirrorConfirmedComputeConstants of reading,
                        strip, oracle, hits, whole, followed, composite, beside, orthographic,
                    }
                };
                (trace, Mirrors::Confirmed(TiledPipeline::new(gpu, (trace, range), formats, fragment, compute)?))
            }
            Some(reading) => {
                let tree = |whole| {
                    with_reading! { MirrorAmongTrianglesConstants of reading,
                        hits, whole, composite, beside, orthographic,
                    }
                };
                let queried = |whole| {
                    with_reading! { MirrorQueriedConstants of reading, hits, whole, composite, beside, orthographic }
                };
                let pipelines = if reading.queries {
                    ByTracer::Query(TiledCompute::new(gpu, range, queried)?)
                } else {
                    ByTracer::Tree(TiledCompute::new(gpu, range, tree)?)
                };
                (ShaderStage::Compute, Mirrors::Triangles(pipelines))
            }
        };
        Ok(Self {
            stage,
            mirrors,
            hits: hits.then(|| setup.target(gpu, "hits", HITS)).transpose()?,
            unwanted_hits: (!hits).then(|| unwanted_hits(gpu)).transpose()?,
        })
    }

    /// Records pass "trace/mirrors", and returns where each ray ended, if hits are wanted. In compute shaders over tiles the pass
    /// "hits" comes before it, since no attachment is cleared along with the trace.
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
        let stored = canvas.stored().zip(wanted.or(self.unwanted_hits.as_ref()));
        let Some(([color, reflection], hits)) = stored else { return Ok(wanted.map(Hits)) };
        let targets = || {
            let [composite, reflection] = canvas.targets(*tiles);
            [composite, reflection, wanted.map_or(Target::unwanted(), |image| tiles.target_in(image, NO_HIT))]
        };
        let name = "trace/mirrors";
        match (&self.mirrors, triangle_bindings) {
            (Mirrors::Screen(pipeline), _) => {
                let programs = in_either_stage! {
                    Mirror => targets(),
                    MirrorCompute over tiles => {
                        color_image: color.all(),
                        reflection_image: reflection.all(),
                        hits_image: hits.all(),
                    },
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer: gbuffer.color.level(0),
                    captures: beyond.block,
                    environment: beyond.sky,
                    lost_counts: beyond.counts,
                    lost: beyond.rays,
                };
                pipeline.run(frame, name, (parameters, *tiles), programs)?;
            }
            (Mirrors::Confirmed(pipeline), Some(triangle_bindings)) => {
                let programs = in_either_stage! {
                    MirrorConfirmed => targets(),
                    MirrorConfirmedCompute over tiles => {
                        color_image: color.all(),
                        reflection_image: reflection.all(),
                        hits_image: hits.all(),
                    },
                    triangle_bindings: *triangle_bindings,
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer: Sampled::nearest(gbuffer.color.level(0)),
                    triangle_buffer: beyond.triangle_of(gbuffer),
                    captures: beyond.block,
                    environment: beyond.sky,
                    lost_counts: beyond.counts,
                    lost: beyond.rays,
                };
                pipeline.run(frame, name, (parameters, *tiles), programs)?;
            }
            (Mirrors::Triangles(pipeline), Some(triangle_bindings)) => {
                let program = by_tracer! { MirrorAmongTriangles or MirrorQueried of *triangle_bindings,
                    Tiles: tiles.lists,
                    Counts: tiles.arguments,
                    color_image: color.all(),
                    reflection_image: reflection.all(),
                    hits_image: hits.all(),
                    unified: parameters,
                    depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer: Sampled::nearest(gbuffer.color.level(0)),
                    triangle_buffer: beyond.triangle_of(gbuffer),
                    captures: beyond.block,
                    environment: beyond.sky,
                };
                pipeline.run(frame, name, (parameters, *tiles), &program)?;
            }
            _ => {}
        }
        Ok(wanted.map(Hits))
    }

    /// Records pass "hits", which says that no ray begins anywhere, if hits are wanted.
    pub fn no_hits<'a>(&'a self, frame: &mut Frame) -> Result<Option<Hits<'a>>> {
        let Some(hits) = &self.hits else { return Ok(None) };
        frame.clear("hits", hits.all(), NO_HIT)?;
        Ok(Some(Hits(hits)))
    }
}
