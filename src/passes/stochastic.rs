//! Trace and resolve of `stochastic` (Stachowiak 2015): each pixel traces a ray drawn from its lobe, and gathers its
//! reflection from the rays of the pixels around it.

use super::lost::{ENDS, LostRayBindings};
use super::{GBuffer, HITS, HiZ, Hits, LIT_COLOR, MarchNumbers, Pyramid, Reflection, march_constants, stored_target};
use crate::error::Result;
use crate::gpu::program::{Fragment, InEitherStage};
use crate::gpu::programs::{
    StochasticExact, StochasticExactConstants, StochasticResolve, StochasticResolveConstants, StochasticThesis,
    StochasticThesisConstants,
};
use crate::gpu::shader::{StochasticBlock, ThesisBlock, UnifiedBlock};
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, PixelPipeline, Sampled, ShaderStage, Target};
use ash::vk;
use ssct_ground::math::OracleVersion;

/// Format of a ray's end and of the density of its direction. Points need all digits of 32-bit floats.
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Two images with the ray of each pixel: where the ray ended, and the lit colour there.
#[derive(Clone, Copy)]
pub struct Rays<'a> {
    place: &'a Image,
    seen: &'a Image,
}

/// Pass "trace" of one size. Its program `F` is [`StochasticExact`], which walks over the pyramid of `unified`, or
/// [`StochasticThesis`], which walks as `ssct` does.
pub struct StochasticTrace<F> {
    pipeline: PixelPipeline<F>,
    place: Image,
    seen: Image,
    hits: Option<Image>,
}

impl<F: InEitherStage + Fragment<Outputs<vk::Format> = [vk::Format; 3]>> StochasticTrace<F> {
    /// Makes the pass with the constants of its program.
    fn with_constants(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        constants: &F::Constants,
        hits: bool,
    ) -> Result<Self> {
        let formats = [PLACE, LIT_COLOR, if hits { HITS } else { vk::Format::UNDEFINED }];
        let image = |name, format| Image::target_in(gpu, stage, name, format, extent);
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, formats, constants)?,
            place: image("ray ends", PLACE)?,
            seen: image("ray colours", LIT_COLOR)?,
            hits: hits.then(|| image("hits", HITS)).transpose()?,
        })
    }
}

impl<F: InEitherStage + for<'t> Fragment<Outputs<Target<'t>> = [Target<'t>; 3]>> StochasticTrace<F> {
    /// Records pass "trace".
    fn draw(&self, frame: &mut Frame, program: &F) -> Result<()> {
        let hits = self.hits.as_ref().map_or(Target::unwanted(), |image| Target::overwrite(image.all()));
        let targets = [Target::overwrite(self.place.all()), Target::overwrite(self.seen.all()), hits];
        frame.pixels("trace", &self.pipeline, targets, program)
    }
}

impl<F> StochasticTrace<F> {
    /// Returns the rays that were traced last.
    fn rays(&self) -> Rays<'_> {
        Rays { place: &self.place, seen: &self.seen }
    }

    /// Where the rays of mirrors ended, if an image of the hits is made.
    pub fn hits(&self) -> Option<Hits<'_>> {
        self.hits.as_ref().map(Hits)
    }
}

impl StochasticTrace<StochasticExact<'static>> {
    /// Makes the pass for a size and pyramids with strips of 2^`strip` columns. `hits` asks for mirrors' hits.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        strip: u32,
        oracle: OracleVersion,
        hits: bool,
    ) -> Result<Self> {
        let (strip, oracle) = (strip as i32, u32::from(oracle) as i32);
        Self::with_constants(
            gpu,
            stage,
            extent,
            &StochasticExactConstants { strip, oracle, followed: false, hits, orthographic: false },
            hits,
        )
    }

    /// Records pass "trace", which traces a ray for each pixel and returns the rays.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        pyramid: Pyramid,
        lost_rays: LostRayBindings,
        (unified, stochastic): (&UnifiedBlock, &StochasticBlock),
    ) -> Result<Rays<'_>> {
        self.draw(
            frame,
            &StochasticExact {
                unified,
                pyramid: pyramid.0.all(),
                normal_buffer: gbuffer.normal.all(),
                material_buffer: gbuffer.material.all(),
                color_texels: gbuffer.color.level(0),
                captures: lost_rays.block,
                environment: lost_rays.sky,
                stochastic,
            },
        )?;
        Ok(self.rays())
    }
}

impl StochasticTrace<StochasticThesis<'static>> {
    /// Makes the pass for a size in pixels. `hits` asks for an image of mirrors' hits. Rays towards the camera are
    /// marched by the numbers `march`, as `ssct` does: the constant `fallback` is true.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], march: MarchNumbers, hits: bool) -> Result<Self> {
        let constants =
            march_constants!(StochasticThesisConstants { fallback: true, hits, orthographic: false }, march);
        Self::with_constants(gpu, stage, extent, &constants, hits)
    }

    /// Records pass "trace", which traces a ray for each pixel and returns the rays.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        (hi_z, thesis): (HiZ, &ThesisBlock),
        lost_rays: LostRayBindings,
        (unified, stochastic): (&UnifiedBlock, &StochasticBlock),
    ) -> Result<Rays<'_>> {
        self.draw(
            frame,
            &StochasticThesis {
                thesis,
                hiZBuffer: Sampled::nearest(hi_z.0.all()),
                normalBuffer: Sampled::nearest(gbuffer.normal.all()),
                materialBuffer: Sampled::nearest(gbuffer.material.all()),
                color_texels: gbuffer.color.level(0),
                unified,
                captures: lost_rays.block,
                environment: lost_rays.sky,
                stochastic,
            },
        )?;
        Ok(self.rays())
    }
}

/// The pass "resolve", of one size.
pub struct StochasticResolvePass {
    pipeline: ComputePipeline<StochasticResolve<'static>>,
    sum: Image,
    weight: Image,
    reflection: Image,
    ends: Image,
}

impl StochasticResolvePass {
    /// Makes the pass for images of a size in pixels. `over_fallback` says that another reflection shows where this one misses.
    pub fn new(gpu: &Gpu, extent: [u32; 2], over_fallback: bool) -> Result<Self> {
        let constants = StochasticResolveConstants { over: over_fallback, orthographic: false };
        let stored = |name, format| stored_target(gpu, name, format, extent);
        Ok(Self {
            pipeline: ComputePipeline::with_constants(gpu, &constants)?,
            sum: stored("ray sums", vk::Format::R32G32B32A32_SFLOAT)?,
            weight: stored("ray weights", vk::Format::R32G32B32A32_SFLOAT)?,
            reflection: stored("reflection", LIT_COLOR)?,
            ends: stored("ends", ENDS)?,
        })
    }

    /// Records pass "resolve", which adds the rays of one turn to the sums of the turns before it in the frame.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        rays: Rays,
        (unified, stochastic): (&UnifiedBlock, &StochasticBlock),
    ) -> Result<()> {
        let program = StochasticResolve {
            unified,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            place_buffer: Sampled::nearest(rays.place.all()),
            seen_buffer: Sampled::nearest(rays.seen.all()),
            sum_image: self.sum.all(),
            weight_image: self.weight.all(),
            reflection_image: self.reflection.all(),
            ends_image: self.ends.all(),
            stochastic,
        };
        let [width, height] = gbuffer.depth.extent();
        frame.compute("resolve", &self.pipeline, &program, [width, height, 1])
    }

    /// Returns the reflection after the last turn, and the image ([`ENDS`]) of how far away the reflected points are.
    pub fn resolved(&self) -> (Reflection<'_>, &Image) {
        (Reflection(&self.reflection), &self.ends)
    }
}
