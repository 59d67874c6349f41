//! Rays of their own for pixels whose neighbours' rays say little of their reflection, followed through the triangles of a scene
//! (docs/unified.md, "More rays where neighbours disagree"). The passes that gather list these pixels, in the buffers of
//! [`lost`](super::lost), whose rays have been followed by then.

use super::lost::{Beyond, LostRays};
use super::tiles::UnifiedSetup;
use super::tracer::{ByTracer, by_tracer};
use super::triangle_scene::{AmongTriangles, with_reading};
use super::{Canvas, GBuffer};
use crate::error::Result;
use crate::gpu::programs::{OwnRays, OwnRaysQueried};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Sampled};

/// What the pass reads, and where it stores.
#[derive(Clone, Copy)]
pub struct OwnRaysInput<'a> {
    /// Depth, normals, materials and lit colour.
    pub gbuffer: GBuffer<'a>,
    /// Where the passes that gather have stored.
    pub canvas: Canvas<'a>,
    /// The sky, and the list.
    pub beyond: Beyond<'a>,
    /// The triangles, where rays go among them.
    pub among: Option<AmongTriangles<'a>>,
}

/// The pipeline, where pixels get rays of their own.
pub struct OwnRaysPass(Option<Pipeline>);

/// The pipeline of either tracer.
type Pipeline = ByTracer<ComputePipeline<OwnRays<'static>>, ComputePipeline<OwnRaysQueried<'static>>>;

impl OwnRaysPass {
    /// Compiles the pipeline for scenes that are read in a way.
    ///
    /// # Errors
    /// [`crate::error::Error::NoDevice`] on a device whose shaders take fewer images or buffers than the program has.
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup) -> Result<Self> {
        let Some(reading) = setup.triangles.filter(|_| setup.own_rays > 0) else { return Ok(Self(None)) };
        let UnifiedSetup { composite, own_rays, .. } = *setup;
        let (beside, orthographic) = (setup.beside(), setup.projection.is_orthographic());
        let constants = with_reading! { OwnRaysConstants of reading, own_rays, composite, beside, orthographic };
        let queried = with_reading! { OwnRaysQueriedConstants of reading, own_rays, composite, beside, orthographic };
        Ok(Self(Some(if reading.queries {
            ByTracer::Query(ComputePipeline::with(gpu, &queried)?)
        } else {
            ByTracer::Tree(ComputePipeline::with(gpu, &constants)?)
        })))
    }

    /// Pass "lost/clear", where pixels get rays of their own: none stands on the list yet.
    pub fn clear(&self, frame: &mut Frame, list: &LostRays) -> Result<()> {
        if self.0.is_some() { list.clear(frame) } else { Ok(()) }
    }

    /// Records one pass over the pixels on the list.
    pub fn record(&self, frame: &mut Frame, name: &str, input: OwnRaysInput, parameters: &UnifiedBlock) -> Result<()> {
        let OwnRaysInput { gbuffer, canvas, beyond, among } = input;
        let Some(((pipeline, among), [color, reflection])) = self.0.as_ref().zip(among).zip(canvas.stored()) else {
            return Ok(());
        };
        let program = by_tracer! { OwnRays or OwnRaysQueried of among,
            unified: parameters,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_buffer: Sampled::nearest(gbuffer.color.level(0)),
            triangle_buffer: beyond.triangle_of(&gbuffer),
            captures: beyond.block,
            environment: beyond.sky,
            lost_counts: beyond.counts,
            doubts: beyond.rays,
            color_image: color.all(),
            reflection_image: reflection.all(),
        };
        pipeline.follow(frame, name, &program, beyond.counts)
    }
}
