//! Rays of their own for pixels whose neighbours' rays say little of their reflection, followed through the triangles of a scene or
//! over the screen (docs/unified.md, "More rays where neighbours disagree"). The passes that gather list these pixels, in the
//! buffers of [`lost`](super::lost), after the lost rays have been followed.

use super::lost::{LostRayBindings, LostRays};
use super::tiles::UnifiedSetup;
use super::tracer::{ByTracer, by_tracer};
use super::triangle_scene::{TriangleBindings, with_reading};
use super::{Canvas, GBuffer, Pyramid};
use crate::error::Result;
use crate::gpu::programs::{OwnRays, OwnRaysOnScreen, OwnRaysOnScreenConstants, OwnRaysQueried};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Sampled};

/// The inputs of the pass, and the images that it stores to.
#[derive(Clone, Copy)]
pub struct OwnRaysInput<'a> {
    /// Depth, normals, materials and lit colour with its chain.
    pub gbuffer: GBuffer<'a>,
    /// The pyramid, for rays that walk over the screen alone.
    pub pyramid: Pyramid<'a>,
    /// The images that the passes that gather have stored to.
    pub canvas: Canvas<'a>,
    /// The sky, and the list.
    pub beyond: LostRayBindings<'a>,
    /// The triangles, where rays go among them.
    pub triangle_bindings: Option<TriangleBindings<'a>>,
}

/// The pipeline; `None` if no pixel gets rays of its own.
pub struct OwnRaysPass(Option<Pipeline>);

enum Pipeline {
    Triangles(ByTracer<ComputePipeline<OwnRays<'static>>, ComputePipeline<OwnRaysQueried<'static>>>),
    Screen(ComputePipeline<OwnRaysOnScreen<'static>>),
}

impl OwnRaysPass {
    /// Compiles the pipeline for triangles, read as `setup` says, or for the screen alone.
    ///
    /// # Errors
    /// [`crate::error::Error::NoDevice`] on a device whose shaders take fewer images or buffers than the program has.
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup) -> Result<Self> {
        let UnifiedSetup { composite, own_rays, over, .. } = *setup;
        if own_rays == 0 {
            return Ok(Self(None));
        }
        let (beside, orthographic) = (setup.beside(), setup.projection.is_orthographic());
        let Some(reading) = setup.triangles else {
            let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
            let followed = false;
            let constants =
                OwnRaysOnScreenConstants { strip, oracle, followed, over, own_rays, composite, beside, orthographic };
            return Ok(Self(Some(Pipeline::Screen(ComputePipeline::with(gpu, &constants)?))));
        };
        let constants = with_reading! { OwnRaysConstants of reading, own_rays, composite, beside, orthographic };
        let queried = with_reading! { OwnRaysQueriedConstants of reading, own_rays, composite, beside, orthographic };
        Ok(Self(Some(Pipeline::Triangles(if reading.queries {
            ByTracer::Query(ComputePipeline::with(gpu, &queried)?)
        } else {
            ByTracer::Tree(ComputePipeline::with(gpu, &constants)?)
        }))))
    }

    /// Records pass "lost/clear", which empties the list, if pixels get rays of their own.
    pub fn clear(&self, frame: &mut Frame, list: &LostRays) -> Result<()> {
        if self.0.is_some() { list.clear(frame) } else { Ok(()) }
    }

    /// Records one pass over the pixels on the list.
    pub fn record(&self, frame: &mut Frame, name: &str, input: OwnRaysInput, parameters: &UnifiedBlock) -> Result<()> {
        let OwnRaysInput { gbuffer, pyramid, canvas, beyond, triangle_bindings } = input;
        let Some((pipeline, [color, reflection])) = self.0.as_ref().zip(canvas.stored()) else { return Ok(()) };
        match (pipeline, triangle_bindings) {
            (Pipeline::Screen(pipeline), _) => {
                let program = OwnRaysOnScreen {
                    unified: parameters,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer: gbuffer.color.level(0),
                    color_chain: gbuffer.coarse_colors(),
                    captures: beyond.block,
                    environment: beyond.sky,
                    lost_counts: beyond.counts,
                    doubts: beyond.rays,
                    color_image: color.all(),
                    reflection_image: reflection.all(),
                };
                frame.compute_indirect(name, pipeline, &program, (beyond.counts, 0))
            }
            (Pipeline::Triangles(pipeline), Some(triangle_bindings)) => {
                let program = by_tracer! { OwnRays or OwnRaysQueried of triangle_bindings,
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
            (Pipeline::Triangles(_), None) => Ok(()),
        }
    }
}
