//! The glossy path of `unified`: rays interleaved over blocks of pixels, and every pixel's reflection gathered from its
//! neighbours' hits (docs/numerics.md, "Gloss"). A pixel's roughness alone decides whether its lobe is narrow, with a
//! ray of its own, or wide, with a ray for 2 × 2 pixels.

use super::lost::{ENDS, LostRayBindings};
use super::tiles::{TileRange, TiledCompute, TiledPipeline, Tiles, UnifiedSetup, in_either_stage};
use super::tracer::{ByTracer, by_tracer};
use super::triangle_scene::{TriangleBindings, with_reading};
use super::{Canvas, GBuffer, LIT_COLOR, Pyramid};
use crate::error::Result;
use crate::gpu::programs::{
    Cells, CellsCompute, CellsComputeConstants, CellsConstants, ResolveNarrow, ResolveNarrowCompute,
    ResolveNarrowComputeConstants, ResolveNarrowConstants, ResolveWide, ResolveWideCompute,
    ResolveWideComputeConstants, ResolveWideConstants, TraceNarrow, TraceNarrowAmongTriangles, TraceNarrowCompute,
    TraceNarrowComputeConstants, TraceNarrowConfirmed, TraceNarrowConfirmedCompute, TraceNarrowConstants,
    TraceNarrowQueried, TraceWide, TraceWideAmongTriangles, TraceWideCompute, TraceWideComputeConstants,
    TraceWideConfirmed, TraceWideConfirmedCompute, TraceWideConstants, TraceWideQueried,
};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, Sampled};
use ash::vk;
use ssct_ground::math::constants::{NARROW_LIST, WIDE_LIST};

const RECORD: vk::Format = vk::Format::R32G32B32A32_UINT;
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Pipelines and images of one size.
pub struct UnifiedGlossPass {
    trace_narrow: NarrowTraces,
    resolve_narrow: TiledPipeline<ResolveNarrow<'static>, ResolveNarrowCompute<'static>>,
    trace_wide: WideTraces,
    cells: TiledPipeline<Cells<'static>, CellsCompute<'static>>,
    resolve_wide: TiledPipeline<ResolveWide<'static>, ResolveWideCompute<'static>>,
    between: BetweenPasses,
}

/// The programs that trace narrow lobes, one for each way to find where a ray ends: on the screen, on the screen with triangles that
/// confirm its hits, or among the triangles alone. Mirrors have the same three.
enum NarrowTraces {
    Screen(TiledPipeline<TraceNarrow<'static>, TraceNarrowCompute<'static>>),
    Confirmed(TiledPipeline<TraceNarrowConfirmed<'static>, TraceNarrowConfirmedCompute<'static>>),
    Triangles(ByTracer<TiledCompute<TraceNarrowAmongTriangles<'static>>, TiledCompute<TraceNarrowQueried<'static>>>),
}

/// The programs that trace wide lobes, one for each of the same three ways.
enum WideTraces {
    Screen(TiledPipeline<TraceWide<'static>, TraceWideCompute<'static>>),
    Confirmed(TiledPipeline<TraceWideConfirmed<'static>, TraceWideConfirmedCompute<'static>>),
    Triangles(ByTracer<TiledCompute<TraceWideAmongTriangles<'static>>, TiledCompute<TraceWideQueried<'static>>>),
}

/// The images that the passes hand each other. Their content is undefined where no tile is drawn.
pub struct BetweenPasses {
    /// The ray of each pixel with a narrow lobe: `RayRecord` of `gloss.glsl`, packed.
    pub records: Image,
    /// Where the ray of each cell of 2 × 2 pixels ended: a point or a direction, and the density of the ray.
    pub place: Image,
    /// What the ray of each cell saw.
    pub seen: Image,
    /// Each cell's reflection.
    pub cell_reflection: Image,
    /// The normal and depth of the surface that a cell's reflection belongs to.
    pub cell_surface: Image,
    /// Where each ray ended ([`ENDS`]); a single texel if nobody asks.
    pub ends: Image,
}

/// The inputs of the passes, and the images that they draw into.
#[derive(Clone, Copy)]
pub struct UnifiedGlossInput<'a> {
    /// Normals, materials and lit colour with its chain.
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

impl UnifiedGlossPass {
    /// # Errors
    /// Returns the errors of [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |name, format, extent| {
            let usage = U::COLOR_ATTACHMENT | U::STORAGE | U::SAMPLED | U::TRANSFER_SRC;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
        let UnifiedSetup { over, composite, screen, followed, triangles, own_rays, tells, trace, resolve, .. } = *setup;
        let (formats, beside) = (|| setup.formats(), setup.beside());
        let orthographic = setup.projection.is_orthographic();
        let narrow = TileRange { list: NARROW_LIST, halved: false };
        let [pixels, halves] = [false, true].map(|halved| TileRange { list: WIDE_LIST, halved });
        let cells = setup.extent.map(|n| n.div_ceil(2));
        Ok(Self {
            trace_narrow: match triangles {
                None => NarrowTraces::Screen(TiledPipeline::new(
                    gpu,
                    (trace, narrow),
                    || [RECORD],
                    |_| TraceNarrowConstants { strip, oracle, followed, tells, orthographic },
                    |whole| TraceNarrowComputeConstants { strip, oracle, whole, followed, tells, orthographic },
                )?),
                Some(reading) if screen => {
                    let fragment = |_| {
                        with_reading! { TraceNarrowConfirmedConstants of reading,
                            strip, oracle, followed, tells, own_rays, orthographic,
                        }
                    };
                    let compute = |whole| {
                        with_reading! { TraceNarrowConfirmedComputeConstants of reading,
                            strip, oracle, whole, followed, tells, own_rays, orthographic,
                        }
                    };
                    let pipeline = TiledPipeline::new(gpu, (trace, narrow), || [RECORD], fragment, compute)?;
                    NarrowTraces::Confirmed(pipeline)
                }
                Some(reading) if reading.queries => {
                    let constants = |whole| with_reading! { TraceNarrowQueriedConstants of reading, whole, own_rays, tells, orthographic };
                    NarrowTraces::Triangles(ByTracer::Query(TiledCompute::new(gpu, narrow, constants)?))
                }
                Some(reading) => NarrowTraces::Triangles(ByTracer::Tree(TiledCompute::new(gpu, narrow, |whole| {
                    with_reading! { TraceNarrowAmongTrianglesConstants of reading, whole, own_rays, tells, orthographic }
                })?)),
            },
            resolve_narrow: TiledPipeline::new(
                gpu,
                (resolve, narrow),
                formats,
                |whole| ResolveNarrowConstants { over, whole, composite, own_rays, orthographic },
                |whole| ResolveNarrowComputeConstants { over, whole, composite, own_rays, beside, orthographic },
            )?,
            trace_wide: match triangles {
                None => WideTraces::Screen(TiledPipeline::new(
                    gpu,
                    (trace, halves),
                    || [PLACE, LIT_COLOR],
                    |_| TraceWideConstants { strip, oracle, followed, tells, orthographic },
                    |whole| TraceWideComputeConstants { strip, oracle, whole, followed, tells, orthographic },
                )?),
                Some(reading) if screen => {
                    let fragment = |_| {
                        with_reading! { TraceWideConfirmedConstants of reading,
                            strip, oracle, followed, tells, orthographic,
                        }
                    };
                    let compute = |whole| {
                        with_reading! { TraceWideConfirmedComputeConstants of reading,
                            strip, oracle, whole, followed, tells, orthographic,
                        }
                    };
                    let formats = || [PLACE, LIT_COLOR];
                    WideTraces::Confirmed(TiledPipeline::new(gpu, (trace, halves), formats, fragment, compute)?)
                }
                Some(reading) if reading.queries => {
                    let constants =
                        |whole| with_reading! { TraceWideQueriedConstants of reading, whole, tells, orthographic };
                    WideTraces::Triangles(ByTracer::Query(TiledCompute::new(gpu, halves, constants)?))
                }
                Some(reading) => WideTraces::Triangles(ByTracer::Tree(TiledCompute::new(gpu, halves, |whole| {
                    with_reading! { TraceWideAmongTrianglesConstants of reading, whole, tells, orthographic }
                })?)),
            },
            cells: TiledPipeline::new(
                gpu,
                (resolve, halves),
                || [LIT_COLOR; 2],
                |whole| CellsConstants { strip, screen, over, whole, own_rays, orthographic },
                |whole| CellsComputeConstants { strip, screen, over, whole, own_rays, orthographic },
            )?,
            resolve_wide: TiledPipeline::new(
                gpu,
                (resolve, pixels),
                formats,
                |whole| ResolveWideConstants { strip, screen, over, whole, composite, own_rays, orthographic },
                |whole| ResolveWideComputeConstants {
                    strip,
                    screen,
                    over,
                    whole,
                    composite,
                    own_rays,
                    beside,
                    orthographic,
                },
            )?,
            between: BetweenPasses {
                records: image("seen", RECORD, setup.extent)?,
                place: image("seen place", PLACE, cells)?,
                seen: image("seen color", LIT_COLOR, cells)?,
                cell_reflection: image("cell reflection", LIT_COLOR, cells)?,
                cell_surface: image("cell surface", LIT_COLOR, cells)?,
                ends: image("ends", ENDS, if tells { setup.extent } else { [1, 1] })?,
            },
        })
    }

    /// The images that the passes hand each other, for other passes and for tests that read them.
    pub fn between(&self) -> &BetweenPasses {
        &self.between
    }

    /// Records pass "trace/narrow": a ray for each pixel with a narrow lobe.
    pub fn trace_narrow(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        let UnifiedGlossInput { gbuffer, pyramid, tiles, beyond, triangle_bindings, .. } = input;
        let records = &self.between.records;
        match (&self.trace_narrow, triangle_bindings) {
            (NarrowTraces::Screen(pipeline), _) => {
                let programs = in_either_stage! {
                    TraceNarrow => [tiles.target(records)],
                    TraceNarrowCompute over tiles => { record_image: records.all() },
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer: gbuffer.color.level(0),
                    color_chain: gbuffer.coarse_colors(),
                    captures: beyond.block,
                    environment: beyond.sky,
                    ends_image: self.between.ends.all(),
                    lost_counts: beyond.counts,
                    lost: beyond.rays,
                };
                pipeline.run(frame, "trace/narrow", (parameters, *tiles), programs)
            }
            // This program binds no colour chain, since none is made if hits are shaded as triangles.
            (NarrowTraces::Confirmed(pipeline), Some(triangle_bindings)) => {
                let programs = in_either_stage! {
                    TraceNarrowConfirmed => [tiles.target(records)],
                    TraceNarrowConfirmedCompute over tiles => { record_image: records.all() },
                    triangle_bindings: *triangle_bindings,
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    triangle_buffer: beyond.triangle_of(gbuffer),
                    captures: beyond.block,
                    environment: beyond.sky,
                    ends_image: self.between.ends.all(),
                    lost_counts: beyond.counts,
                    lost: beyond.rays,
                };
                pipeline.run(frame, "trace/narrow", (parameters, *tiles), programs)
            }
            (NarrowTraces::Triangles(pipeline), Some(triangle_bindings)) => {
                let program = by_tracer! { TraceNarrowAmongTriangles or TraceNarrowQueried of *triangle_bindings,
                    Tiles: tiles.lists,
                    Counts: tiles.arguments,
                    record_image: records.all(),
                    unified: parameters,
                    depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    triangle_buffer: beyond.triangle_of(gbuffer),
                    captures: beyond.block,
                    environment: beyond.sky,
                    ends_image: self.between.ends.all(),
                };
                pipeline.run(frame, "trace/narrow", (parameters, *tiles), &program)
            }
            _ => Ok(()),
        }
    }

    /// Records pass "resolve/narrow": each pixel's reflection from the rays of the 3 × 3 pixels around it.
    pub fn resolve_narrow(
        &self,
        frame: &mut Frame,
        input: &UnifiedGlossInput,
        parameters: &UnifiedBlock,
    ) -> Result<()> {
        let UnifiedGlossInput { gbuffer, tiles, canvas, beyond, .. } = input;
        let Some([color, reflection]) = canvas.stored() else { return Ok(()) };
        let programs = in_either_stage! {
            ResolveNarrow => canvas.targets(*tiles),
            ResolveNarrowCompute over tiles => { color_image: color.all(), reflection_image: reflection.all() },
            unified: parameters,
            material_buffer: gbuffer.material.all(),
            color_buffer: gbuffer.color.level(0),
            seen_image: self.between.records.all(),
            lost_counts: beyond.counts,
            doubts: beyond.rays,
        };
        self.resolve_narrow.run(frame, "resolve/narrow", (parameters, *tiles), programs)
    }

    /// Records pass "trace/wide": a ray for each cell with a wide lobe.
    pub fn trace_wide(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        let UnifiedGlossInput { gbuffer, pyramid, tiles, beyond, triangle_bindings, .. } = input;
        let BetweenPasses { place, seen, .. } = &self.between;
        match (&self.trace_wide, triangle_bindings) {
            (WideTraces::Screen(pipeline), _) => {
                let programs = in_either_stage! {
                    TraceWide => [place, seen].map(|image| tiles.target(image)),
                    TraceWideCompute over tiles => { place_image: place.all(), seen_image: seen.all() },
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer: gbuffer.color.level(0),
                    color_chain: gbuffer.coarse_colors(),
                    captures: beyond.block,
                    environment: beyond.sky,
                    ends_image: self.between.ends.all(),
                    lost_counts: beyond.counts,
                    lost: beyond.rays,
                };
                pipeline.run(frame, "trace/wide", (parameters, *tiles), programs)
            }
            (WideTraces::Confirmed(pipeline), Some(triangle_bindings)) => {
                let programs = in_either_stage! {
                    TraceWideConfirmed => [place, seen].map(|image| tiles.target(image)),
                    TraceWideConfirmedCompute over tiles => { place_image: place.all(), seen_image: seen.all() },
                    triangle_bindings: *triangle_bindings,
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    triangle_buffer: beyond.triangle_of(gbuffer),
                    captures: beyond.block,
                    environment: beyond.sky,
                    ends_image: self.between.ends.all(),
                    lost_counts: beyond.counts,
                    lost: beyond.rays,
                };
                pipeline.run(frame, "trace/wide", (parameters, *tiles), programs)
            }
            (WideTraces::Triangles(pipeline), Some(triangle_bindings)) => {
                let program = by_tracer! { TraceWideAmongTriangles or TraceWideQueried of *triangle_bindings,
                    Tiles: tiles.lists,
                    Counts: tiles.arguments,
                    place_image: place.all(), seen_image: seen.all(),
                    unified: parameters,
                    depth_buffer: Sampled::nearest(gbuffer.depth.all()),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    triangle_buffer: beyond.triangle_of(gbuffer),
                    captures: beyond.block,
                    environment: beyond.sky,
                    ends_image: self.between.ends.all(),
                };
                pipeline.run(frame, "trace/wide", (parameters, *tiles), &program)
            }
            _ => Ok(()),
        }
    }

    /// Records passes "cells" and "resolve/wide": each cell's reflection from the rays of the 5 × 5 cells around it, and each
    /// pixel's reflection between the cells around it.
    pub fn resolve_wide(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        self.cells(frame, input, parameters)?;
        let UnifiedGlossInput { gbuffer, pyramid, tiles, canvas, beyond, .. } = input;
        let BetweenPasses { cell_reflection, cell_surface, .. } = &self.between;
        let Some([color, reflection]) = canvas.stored() else { return Ok(()) };
        let programs = in_either_stage! {
            ResolveWide => canvas.targets(*tiles),
            ResolveWideCompute over tiles => { color_image: color.all(), reflection_image: reflection.all() },
            unified: parameters,
            pyramid: pyramid.0.all(),
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_buffer: gbuffer.color.level(0),
            cell_reflection: cell_reflection.all(),
            cell_surface: cell_surface.all(),
            listed_image: tiles.listed.all(),
            lost_counts: beyond.counts,
            doubts: beyond.rays,
        };
        self.resolve_wide.run(frame, "resolve/wide", (parameters, *tiles), programs)
    }

    fn cells(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        let UnifiedGlossInput { gbuffer, pyramid, tiles, .. } = input;
        let BetweenPasses { place, seen, cell_reflection, cell_surface, .. } = &self.between;
        let programs = in_either_stage! {
            Cells => [cell_reflection, cell_surface].map(|image| tiles.target(image)),
            CellsCompute over tiles => { reflection_image: cell_reflection.all(), surface_image: cell_surface.all() },
            unified: parameters,
            pyramid: pyramid.0.all(),
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            place_image: place.all(),
            seen_image: seen.all(),
            listed_image: tiles.listed.all(),
        };
        self.cells.run(frame, "cells", (parameters, *tiles), programs)
    }
}
