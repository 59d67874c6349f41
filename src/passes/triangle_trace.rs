//! Passes that follow the rays of the list ([`lost`](super::lost)) through the triangles of a scene, each ray from the point of its
//! pixel (docs/definitions.md, "Triangles"). The number of rays on the list sizes their dispatches.

use super::lost::LostRayBindings;
use super::tracer::{ByTracer, by_tracer};
use super::triangle_scene::{TriangleBindings, TriangleReading, with_reading};
use super::{Canvas, GBuffer, Hits, unwanted_hits};
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, Sampled, programs};
use ssct_ground::scene::ProjectionKind;

/// The pipelines.
pub struct TriangleTracePass {
    mirrors: Pipeline<programs::TriangleMirrors<'static>, programs::TriangleMirrorsQueried<'static>>,
    narrow: Pipeline<programs::TriangleNarrow<'static>, programs::TriangleNarrowQueried<'static>>,
    wide: Pipeline<programs::TriangleWide<'static>, programs::TriangleWideQueried<'static>>,
    unwanted_hits: Option<Image>,
}

/// The pipeline of either tracer.
type Pipeline<T, Q> = ByTracer<ComputePipeline<T>, ComputePipeline<Q>>;

/// The outputs that are wanted, and the screen's projection.
#[derive(Debug, Clone, Copy, Default)]
pub struct TriangleWants {
    /// The finished image.
    pub composite: bool,
    /// The reflection as an image of its own.
    pub reflection: bool,
    /// Where each ray ended.
    pub hits: bool,
    /// True if the pass stores, for the history, where each ray of a glossy pixel ended.
    pub tells: bool,
    /// The screen's projection.
    pub projection: ProjectionKind,
}

/// The inputs of every pass of this file.
#[derive(Clone, Copy)]
pub struct TriangleInput<'a> {
    /// The parameters of `unified` for the screen.
    pub parameters: &'a UnifiedBlock,
    /// The scene's triangles.
    pub triangle_bindings: TriangleBindings<'a>,
    /// The rays, the camera's axes, and the sky.
    pub beyond: LostRayBindings<'a>,
}

/// Makes the program of a tracer with the bindings that all programs of this file have, and with its own.
macro_rules! follow_program {
    ($tree:ident or $query:ident of $input:expr, $($field:ident: $value:expr),+ $(,)?) => {{
        let TriangleInput { parameters, triangle_bindings, beyond } = $input;
        by_tracer! { $tree or $query of triangle_bindings,
            unified: parameters,
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            lost: beyond.rays,
            $($field: $value),+
        }
    }};
}

/// Compiles the program for the tracer that a reading names.
macro_rules! pipeline {
    ($tree:ident or $query:ident of ($gpu:expr, $reading:expr), $($field:ident),+ $(,)?) => {
        if $reading.queries {
            ByTracer::Query(ComputePipeline::with($gpu, &with_reading! { $query of $reading, $($field),+ })?)
        } else {
            ByTracer::Tree(ComputePipeline::with($gpu, &with_reading! { $tree of $reading, $($field),+ })?)
        }
    };
}

impl TriangleTracePass {
    /// Compiles the pipelines for triangles that are read as `reading` says.
    ///
    /// # Errors
    /// [`crate::error::Error::NoDevice`] on a device whose shaders take fewer buffers than the programs have.
    pub fn new(gpu: &Gpu, reading: TriangleReading, wanted: TriangleWants) -> Result<Self> {
        let TriangleWants { composite, reflection, hits, tells, projection } = wanted;
        let orthographic = projection.is_orthographic();
        Ok(Self {
            mirrors: pipeline! { TriangleMirrorsConstants or TriangleMirrorsQueriedConstants of (gpu, reading),
                composite, reflection, hits, orthographic,
            },
            narrow: pipeline! { TriangleNarrowConstants or TriangleNarrowQueriedConstants of (gpu, reading),
                tells, orthographic,
            },
            wide: pipeline! { TriangleWideConstants or TriangleWideQueriedConstants of (gpu, reading), tells, orthographic },
            unwanted_hits: (!hits).then(|| unwanted_hits(gpu)).transpose()?,
        })
    }

    /// Records pass "triangles/mirrors": finishes the pixels whose mirror rays are on the list.
    pub fn record_mirrors(
        &self,
        frame: &mut Frame,
        input: TriangleInput,
        gbuffer: &GBuffer,
        canvas: Canvas,
        hits: Option<Hits>,
    ) -> Result<()> {
        // An image that is not wanted is not written, but its binding needs some image.
        let stored = canvas.images().next().zip(hits.map(|h| h.0).or(self.unwanted_hits.as_ref()));
        let Some((any, hits)) = stored else { return Ok(()) };
        let program = follow_program! { TriangleMirrors or TriangleMirrorsQueried of input,
            material_buffer: gbuffer.material.all(),
            color_buffer: Sampled::nearest(gbuffer.color.level(0)),
            composite_image: canvas.composite.unwrap_or(any).all(),
            reflection_image: canvas.reflection.unwrap_or(any).all(),
            hits_image: hits.all(),
        };
        self.mirrors.follow(frame, "triangles/mirrors", &program, input.beyond.counts)
    }

    /// Records pass "triangles/narrow": writes into the records what the rays of narrow lobes see.
    pub fn record_narrow(&self, frame: &mut Frame, input: TriangleInput, [records, ends]: [&Image; 2]) -> Result<()> {
        let program = follow_program! { TriangleNarrow or TriangleNarrowQueried of input,
            seen_image: records.all(), ends_image: ends.all(),
        };
        self.narrow.follow(frame, "triangles/narrow", &program, input.beyond.counts)
    }

    /// Records pass "triangles/wide", which does the same for the rays of cells with wide lobes.
    pub fn record_wide(&self, frame: &mut Frame, input: TriangleInput, [place, seen, ends]: [&Image; 3]) -> Result<()> {
        let program = follow_program! { TriangleWide or TriangleWideQueried of input,
            place_image: place.all(), seen_image: seen.all(), ends_image: ends.all(),
        };
        self.wide.follow(frame, "triangles/wide", &program, input.beyond.counts)
    }
}
