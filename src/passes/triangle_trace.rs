//! Passes that follow the rays of the list ([`lost`](super::lost)) among the triangles of a scene, each from the point
//! of its pixel (docs/definitions.md, "Triangles"). The number of rays on the list sizes the dispatches.

use super::lost::LostRayBindings;
use super::triangle_scene::{TriangleBindings, TriangleReading};
use super::{Canvas, GBuffer, Hits, unwanted_hits};
use crate::error::Result;
use crate::gpu::programs::{
    TriangleMirrors, TriangleMirrorsConstants, TriangleNarrow, TriangleNarrowConstants, TriangleWide,
    TriangleWideConstants,
};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, Sampled};
use ssct_ground::scene::ProjectionKind;

/// The pipelines.
pub struct TriangleTracePass {
    mirrors: ComputePipeline<TriangleMirrors<'static>>,
    narrow: ComputePipeline<TriangleNarrow<'static>>,
    wide: ComputePipeline<TriangleWide<'static>>,
    unwanted_hits: Option<Image>,
}

/// The variant of the passes: which outputs are wanted, and the screen's projection.
#[derive(Debug, Clone, Copy, Default)]
pub struct TriangleWants {
    /// Whether the finished image is wanted.
    pub composite: bool,
    /// Whether the reflection is wanted as an image of its own.
    pub reflection: bool,
    /// Whether the image of hits is wanted, which says where each mirror ray ended.
    pub hits: bool,
    /// Whether the passes store, for a history, where each ray of a glossy pixel ended.
    pub stores_ends: bool,
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
    /// The list of rays, the camera's axes, and the sky.
    pub lost_rays: LostRayBindings<'a>,
}

impl TriangleTracePass {
    /// Compiles the pipelines for triangles that are read as `reading` says.
    ///
    /// # Errors
    /// [`crate::error::Error::NoDevice`] on a device whose shaders take fewer buffers than the programs have.
    pub fn new(gpu: &Gpu, reading: TriangleReading, wanted: TriangleWants) -> Result<Self> {
        let TriangleWants { composite, reflection, hits, stores_ends, projection } = wanted;
        let (orthographic, triangle_constants) = (projection.is_orthographic(), reading.constants());
        let mirrors = TriangleMirrorsConstants { composite, reflection, hits, orthographic, triangle_constants };
        let narrow = TriangleNarrowConstants { stores_ends, orthographic, triangle_constants };
        let wide = TriangleWideConstants { stores_ends, orthographic, triangle_constants };
        let rays = reading.ray_source();
        Ok(Self {
            mirrors: ComputePipeline::for_rays(gpu, rays, &mirrors)?,
            narrow: ComputePipeline::for_rays(gpu, rays, &narrow)?,
            wide: ComputePipeline::for_rays(gpu, rays, &wide)?,
            unwanted_hits: (!hits).then(|| unwanted_hits(gpu)).transpose()?,
        })
    }

    /// Records pass "triangles/mirrors", which follows the mirror rays on the list and finishes their pixels.
    pub fn record_mirrors(
        &self,
        frame: &mut Frame,
        input: TriangleInput,
        gbuffer: &GBuffer,
        canvas: Canvas,
        hits: Option<Hits>,
    ) -> Result<()> {
        // An image that is not wanted is not written, but its binding needs some image.
        let Some(any) = canvas.images().next() else { return Ok(()) };
        let Some(hits) = hits.map(|hits| hits.0).or(self.unwanted_hits.as_ref()) else { return Ok(()) };
        let TriangleInput { parameters, triangle_bindings, lost_rays } = input;
        let program = TriangleMirrors {
            unified: parameters,
            lost_ray_resources: lost_rays.resources(),
            ray_structure: triangle_bindings.triangles.structure,
            triangle_resources: triangle_bindings.resources(),
            material_buffer: gbuffer.material.all(),
            color_buffer: Sampled::nearest(gbuffer.color.level(0)),
            composite_image: canvas.composite.unwrap_or(any).all(),
            reflection_image: canvas.reflection.unwrap_or(any).all(),
            hits_image: hits.all(),
        };
        frame.compute_indirect("triangles/mirrors", &self.mirrors, &program, (lost_rays.counts, 0))
    }

    /// Records pass "triangles/narrow", which follows the rays of narrow lobes. It writes to `records` what they see,
    /// and for a history to `ends` where they end.
    pub fn record_narrow(&self, frame: &mut Frame, input: TriangleInput, [records, ends]: [&Image; 2]) -> Result<()> {
        let TriangleInput { parameters, triangle_bindings, lost_rays } = input;
        let program = TriangleNarrow {
            unified: parameters,
            lost_ray_resources: lost_rays.resources(),
            ray_structure: triangle_bindings.triangles.structure,
            triangle_resources: triangle_bindings.resources(),
            seen_image: records.all(),
            ends_image: ends.all(),
        };
        frame.compute_indirect("triangles/narrow", &self.narrow, &program, (lost_rays.counts, 0))
    }

    /// Records pass "triangles/wide", which follows the rays of cells with wide lobes. It writes to `seen` what they
    /// see, and to `place`, and for a history to `ends`, where they end.
    pub fn record_wide(&self, frame: &mut Frame, input: TriangleInput, [place, seen, ends]: [&Image; 3]) -> Result<()> {
        let TriangleInput { parameters, triangle_bindings, lost_rays } = input;
        let program = TriangleWide {
            unified: parameters,
            lost_ray_resources: lost_rays.resources(),
            ray_structure: triangle_bindings.triangles.structure,
            triangle_resources: triangle_bindings.resources(),
            place_image: place.all(),
            seen_image: seen.all(),
            ends_image: ends.all(),
        };
        frame.compute_indirect("triangles/wide", &self.wide, &program, (lost_rays.counts, 0))
    }
}
