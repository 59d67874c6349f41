//! Trace and resolve of `stochastic`: a ray for each pixel, drawn from its lobe, and what pixels make of the rays around
//! them (Stachowiak 2015).

use super::lost::Beyond;
use super::{GBuffer, HITS, HiZ, Hits, LIT_COLOR, Pyramid, Reflection, stored_target};
use crate::error::Result;
use crate::gpu::programs::{
    StochasticExact, StochasticExactConstants, StochasticResolve, StochasticResolveConstants, StochasticThesis,
    StochasticThesisConstants,
};
use crate::gpu::shader::{StochasticBlock, ThesisBlock, UnifiedBlock};
use crate::gpu::{ComputePipeline, Frame, Gpu, GraphicsPipeline, Image, Sampled, Target};
use crate::math::OracleVersion;
use ash::vk;

/// The hit's place and the density of its direction: points need all the digits that there are.
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// What rays are walked over.
#[derive(Clone, Copy)]
pub enum WalkedOver<'a> {
    /// The pyramid of `unified`.
    Pyramid(Pyramid<'a>),
    /// The thesis's Hi-Z buffer, as `ssct` walks.
    HiZ(HiZ<'a>, &'a ThesisBlock),
}

/// How rays are walked.
#[derive(Debug, Clone, Copy)]
pub enum WalkKind {
    /// Over a pyramid with strips of 2^n columns, by a version of the oracle.
    Exact(u32, OracleVersion),
    /// As `ssct` walks.
    Thesis,
}

/// What is shown, and beside what.
#[derive(Debug, Clone, Copy)]
pub struct StochasticShown {
    /// Another reflection shows where this one misses.
    pub over: bool,
    /// The sky is looked up along rays, where it is known.
    pub sky: bool,
    /// An image of the hits of mirrors is wanted.
    pub hits: bool,
}

enum Trace {
    Exact(GraphicsPipeline<StochasticExact<'static>>),
    Thesis(GraphicsPipeline<StochasticThesis<'static>>),
}

/// Pipelines and images of one size.
pub struct StochasticPass {
    trace: Trace,
    resolve: ComputePipeline<StochasticResolve<'static>>,
    place: Image,
    seen: Image,
    hits: Option<Image>,
    sum: Image,
    weight: Image,
    reflection: Image,
    distance: Image,
}

impl StochasticPass {
    /// For images of a size in pixels.
    ///
    /// # Errors
    /// Those of the device.
    pub fn new(gpu: &Gpu, extent: [u32; 2], walk: WalkKind, shown: StochasticShown) -> Result<Self> {
        let StochasticShown { over, sky, hits } = shown;
        let formats = [PLACE, LIT_COLOR, if hits { HITS } else { vk::Format::UNDEFINED }];
        let image = |name, format| Image::target(gpu, name, format, extent);
        let stored = |name, format| stored_target(gpu, name, format, extent);
        let trace = match walk {
            WalkKind::Exact(strip, oracle) => {
                let (strip, oracle) = (strip as i32, u32::from(oracle) as i32);
                let constants = StochasticExactConstants { strip, oracle, followed: false, sky, hits };
                Trace::Exact(GraphicsPipeline::fullscreen_with(gpu, formats, &constants)?)
            }
            WalkKind::Thesis => {
                let constants = StochasticThesisConstants { fallback: true, sky, hits };
                Trace::Thesis(GraphicsPipeline::fullscreen_with(gpu, formats, &constants)?)
            }
        };
        Ok(Self {
            trace,
            resolve: ComputePipeline::with(gpu, &StochasticResolveConstants { over })?,
            place: image("ray ends", PLACE)?,
            seen: image("ray colours", LIT_COLOR)?,
            hits: hits.then(|| image("hits", HITS)).transpose()?,
            sum: stored("ray sums", vk::Format::R32G32B32A32_SFLOAT)?,
            weight: stored("ray weights", vk::Format::R32G32B32A32_SFLOAT)?,
            reflection: stored("reflection", LIT_COLOR)?,
            distance: stored("reflected distance", vk::Format::R32_SFLOAT)?,
        })
    }

    /// Passes "trace" and "resolve" of one turn: a ray for each pixel, and its sum with those of the turns before.
    ///
    /// # Errors
    /// Those of the device.
    pub fn record(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        over: WalkedOver,
        beyond: Beyond,
        (unified, stochastic): (&UnifiedBlock, &StochasticBlock),
    ) -> Result<()> {
        let color_buffer = Sampled::trilinear(gbuffer.color.level(0));
        let hits = self.hits.as_ref().map_or(Target::unwanted(), |image| Target::overwrite(image.all()));
        let targets = [Target::overwrite(self.place.all()), Target::overwrite(self.seen.all()), hits];
        match (&self.trace, over) {
            (Trace::Exact(pipeline), WalkedOver::Pyramid(pyramid)) => {
                let program = StochasticExact {
                    unified,
                    pyramid: pyramid.0.all(),
                    normal_buffer: gbuffer.normal.all(),
                    material_buffer: gbuffer.material.all(),
                    color_buffer,
                    captures: beyond.block,
                    environment: beyond.sky,
                    stochastic,
                };
                frame.fullscreen("trace", pipeline, targets, &program)?;
            }
            (Trace::Thesis(pipeline), WalkedOver::HiZ(hi_z, thesis)) => {
                let program = StochasticThesis {
                    thesis,
                    hiZBuffer: Sampled::nearest(hi_z.0.all()),
                    normalBuffer: Sampled::nearest(gbuffer.normal.all()),
                    materialBuffer: Sampled::nearest(gbuffer.material.all()),
                    color_buffer,
                    unified,
                    captures: beyond.block,
                    environment: beyond.sky,
                    stochastic,
                };
                frame.fullscreen("trace", pipeline, targets, &program)?;
            }
            _ => unreachable!("a pass walks over what it was made for"),
        }
        let resolve = StochasticResolve {
            unified,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: Sampled::nearest(gbuffer.normal.all()),
            material_buffer: Sampled::nearest(gbuffer.material.all()),
            place_buffer: Sampled::nearest(self.place.all()),
            seen_buffer: Sampled::nearest(self.seen.all()),
            sum_image: self.sum.all(),
            weight_image: self.weight.all(),
            reflection_image: self.reflection.all(),
            distance_image: self.distance.all(),
            stochastic,
        };
        let [width, height] = gbuffer.depth.extent();
        frame.compute("resolve", &self.resolve, &resolve, [width, height, 1])
    }

    /// What the last turn made: the reflection, how far away it is (in units of [`unit`](super::lost::unit)), and where
    /// the rays of mirrors ended.
    pub fn made(&self) -> (Reflection<'_>, &Image, Option<Hits<'_>>) {
        (Reflection(&self.reflection), &self.distance, self.hits.as_ref().map(Hits))
    }
}
