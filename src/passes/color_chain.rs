//! Pre-convolution: the colour's mip chain (thesis §4.2.6), by the hardware's linear filter as the
//! thesis chose, or by the 7-tap Gaussian of §4.3.2 as its alternative. For `unified` the coarse levels of
//! the linear filter are made in one dispatch.

use super::{ColorChain, GBuffer, LIT_COLOR};
use crate::error::Result;
use crate::gpu::programs::{ColorCoarse, GaussianBlur};
use crate::gpu::shader::BlurBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, GraphicsPipeline, Image, ImageDesc, ImageSlice, Sampled, Target, image};
use crate::parameter::choices;
use ash::vk;

choices! {
    /// How the chain is filtered.
    pub enum ChainFilter {
        /// Each level is a linear blit of the one below: the GPU's own mip generation.
        Hardware = "hardware",
        /// Each level is a 7-tap separable Gaussian of the one below.
        Gaussian = "gaussian",
    }
}

/// How the levels are made.
enum Make {
    /// A blit each.
    Blits,
    /// A blit each, the last [`COARSE`] of them in one dispatch.
    Coarse(ComputePipeline<ColorCoarse<'static>>),
    /// Two passes each, with the image between the two directions.
    Gaussian(GraphicsPipeline<GaussianBlur<'static>>, Box<Image>),
}

/// Levels that `color_coarse.comp` makes.
const COARSE: u32 = 7;

/// What makes the levels.
pub struct ColorChainPass(Make);

impl ColorChainPass {
    /// For lit colours of a size and format.
    pub fn new(gpu: &Gpu, extent: [u32; 2], format: vk::Format, filter: ChainFilter) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        Ok(Self(match filter {
            ChainFilter::Hardware => Make::Blits,
            ChainFilter::Gaussian => Make::Gaussian(
                GraphicsPipeline::fullscreen(gpu, [format])?,
                Box::new(Image::new(
                    gpu,
                    &ImageDesc {
                        name: "horizontal blur",
                        format,
                        extent,
                        levels: image::full_chain(extent),
                        layers: 1,
                        usage: U::COLOR_ATTACHMENT | U::SAMPLED,
                    },
                )?),
            ),
        }))
    }

    /// As with [`ChainFilter::Hardware`], in fewer passes.
    pub fn in_few_passes(gpu: &Gpu) -> Result<Self> {
        Ok(Self(Make::Coarse(ComputePipeline::new(gpu)?)))
    }

    /// Passes "color/1" to the coarsest level, or "color/coarse" for several, written into the colour image itself.
    pub fn record<'a>(&self, frame: &mut Frame, gbuffer: &GBuffer<'a>) -> Result<ColorChain<'a>> {
        let chain = gbuffer.color;
        match &self.0 {
            // The shader has one format and one number of levels.
            Make::Coarse(pipeline) if chain.format() == LIT_COLOR && chain.levels() > COARSE => {
                let first = chain.levels() - COARSE;
                blits(frame, chain, first)?;
                coarse(frame, chain, first, pipeline)?;
            }
            Make::Blits | Make::Coarse(_) => blits(frame, chain, chain.levels())?,
            Make::Gaussian(pipeline, between) => {
                for level in 1..chain.levels() {
                    let levels = [chain.level(level - 1), between.level(level), chain.level(level)];
                    gaussian(frame, level, pipeline, levels)?;
                }
            }
        }
        Ok(ColorChain(chain))
    }
}

/// The levels of a chain below one, from level 1 on.
fn blits(frame: &mut Frame, chain: &Image, end: u32) -> Result<()> {
    (1..end).try_for_each(|level| frame.blit(&format!("color/{level}"), chain.level(level - 1), chain.level(level)))
}

/// The levels of a chain from one on, of which there are [`COARSE`].
fn coarse(
    frame: &mut Frame,
    chain: &Image,
    first: u32,
    pipeline: &ComputePipeline<ColorCoarse<'static>>,
) -> Result<()> {
    let level = |n| chain.level(first - 1 + n);
    let program = ColorCoarse {
        level_0: level(0),
        level_1: level(1),
        level_2: level(2),
        level_3: level(3),
        level_4: level(4),
        level_5: level(5),
        level_6: level(6),
        level_7: level(7),
    };
    frame.compute("color/coarse", pipeline, &program, [1; 3])
}

/// A level from the one below it, by way of a third.
fn gaussian(
    frame: &mut Frame,
    level: u32,
    pipeline: &GraphicsPipeline<GaussianBlur<'static>>,
    [below, between, here]: [ImageSlice; 3],
) -> Result<()> {
    let [w, h] = here.extent().map(|v| 1.0 / v as f32);
    for (name, direction, from, to) in [("h", [w, 0.0], below, between), ("v", [0.0, h], between, here)] {
        frame.fullscreen(
            &format!("color/{level}{name}"),
            pipeline,
            [Target::overwrite(to)],
            &GaussianBlur { tex: Sampled::trilinear(from), blur: &BlurBlock { invSize: [w, h], direction } },
        )?;
    }
    Ok(())
}
