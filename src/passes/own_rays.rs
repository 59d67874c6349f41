//! Traces own rays for pixels in doubt, whose neighbours' rays say little of their reflection, among the triangles of a
//! scene or over the screen (docs/unified.md, "More rays where neighbours disagree"). The passes that gather list these
//! pixels, in the buffers of [`lost`](super::lost), once the lost rays have been followed.

use super::lost::{LostRayBindings, LostRays};
use super::tiles::UnifiedSetup;
use super::triangle_scene::TriangleBindings;
use super::{Canvas, GBuffer, Pyramid};
use crate::error::Result;
use crate::gpu::program::RaySource;
use crate::gpu::programs::{OwnRays, OwnRaysConstants};
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
    /// The sky, and the list of pixels in doubt.
    pub lost_rays: LostRayBindings<'a>,
    /// The triangles, if rays are traced among them.
    pub triangle_bindings: Option<TriangleBindings<'a>>,
}

/// The pipeline; `None` if no pixel gets rays of its own.
pub struct OwnRaysPass(Option<ComputePipeline<OwnRays<'static>>>);

impl OwnRaysPass {
    /// Compiles the pipeline for rays among triangles, if `setup` has triangles, or else for rays over the screen.
    ///
    /// # Errors
    /// [`crate::error::Error::NoDevice`] on a device whose shaders take fewer images or buffers than the program has.
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup) -> Result<Self> {
        let UnifiedSetup { composite, own_rays, over_fallback: over, .. } = *setup;
        if own_rays == 0 {
            return Ok(Self(None));
        }
        let constants = OwnRaysConstants {
            strip: setup.strip as i32,
            oracle: u32::from(setup.oracle) as i32,
            followed: false,
            over,
            own_rays,
            composite,
            beside: setup.wants_both(),
            orthographic: setup.projection.is_orthographic(),
            triangle_constants: setup.triangle_constants(),
        };
        let rays = setup.triangles.map_or(RaySource::Screen, |reading| reading.ray_source());
        Ok(Self(Some(ComputePipeline::for_rays(gpu, rays, &constants)?)))
    }

    /// Records pass "lost/clear", which empties the list, if pixels get own rays.
    pub fn clear(&self, frame: &mut Frame, list: &LostRays) -> Result<()> {
        if self.0.is_some() { list.clear(frame) } else { Ok(()) }
    }

    /// Records the pass `name`, which traces the own rays of the pixels on the list and stores these pixels anew.
    pub fn record(&self, frame: &mut Frame, name: &str, input: OwnRaysInput, parameters: &UnifiedBlock) -> Result<()> {
        let OwnRaysInput { gbuffer, pyramid, canvas, lost_rays, triangle_bindings } = input;
        let Some((pipeline, [color, reflection])) = self.0.as_ref().zip(canvas.stored()) else { return Ok(()) };
        let program = OwnRays {
            unified: parameters,
            screen_resources: lost_rays.screen_resources(&gbuffer, pyramid),
            color_buffer: Some(Sampled::nearest(gbuffer.color.level(0))),
            color_chain: Some(gbuffer.coarse_colors()),
            captures: lost_rays.block,
            environment: lost_rays.sky,
            lost_counts: lost_rays.counts,
            doubts: lost_rays.rays,
            color_image: color.all(),
            reflection_image: reflection.all(),
            ray_structure: triangle_bindings.and_then(|bindings| bindings.triangles.structure),
            triangle_resources: triangle_bindings.map(|bindings| bindings.resources()),
        };
        frame.compute_indirect(name, pipeline, &program, (lost_rays.counts, 0))
    }
}
