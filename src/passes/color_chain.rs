//! Pre-convolution: the colour's mip chain (thesis §4.2.6). The thesis chose the hardware's linear filter; the
//! alternative is the 7-tap Gaussian of §4.3.2, with a mask (ch. 6) or without. For `unified`, one dispatch makes the
//! coarse levels of the linear filter.

use super::{ColorChain, GBuffer, HiZ, LIT_COLOR};
use crate::error::{Error, Result};
use crate::gpu::programs::{ColorCoarse, ColorFirst, GaussianBlur, GaussianBlurMasked, GaussianBlurMaskedConstants};
use crate::gpu::shader::{BlurBlock, MaskedBlurBlock};
use crate::gpu::{
    ComputePipeline, Frame, Gpu, Image, ImageDesc, ImageSlice, PixelPipeline, Sampled, ShaderStage, Target, image,
};
use ash::vk;
use ssct_ground::parameter::choices;
use ssct_ground::scene::Lens;
use std::ops::Range;

choices! {
    /// How the chain is filtered.
    pub enum ChainFilter {
        /// Each level is a linear blit of the one below: the GPU's own mip generation.
        Hardware = "hardware",
        /// Each level is a 7-tap separable Gaussian of the one below.
        Gaussian = "gaussian",
    }
}

choices! {
    /// The texels that the Gaussian leaves out of a level: the colour of the texel in the middle stands in their place.
    pub enum ChainMask {
        /// Nothing: there is no mask.
        None = "none",
        /// Where nothing stands that a ray could hit: the sky.
        Covered = "covered",
        /// Where another surface stands than in the middle, by its depth.
        Surface = "surface",
    }
}

/// How the levels are made.
enum LevelPipelines {
    /// One blit for each level.
    Blits,
    /// One dispatch for level 1 if the sky is left out, one for the last [`COARSE_LEVELS`] levels, and else blits.
    Coarse(ComputePipeline<ColorFirst<'static>>, ComputePipeline<ColorCoarse<'static>>),
    /// Two passes for each level, and the image between them, which is blurred along x alone.
    Gaussian(PixelPipeline<GaussianBlur<'static>>, Box<Image>),
    /// Two masked passes a level, the image between them, and the tolerance of depths ([`ColorChainPass::masked`]).
    Masked(PixelPipeline<GaussianBlurMasked<'static>>, Box<Image>, f32),
}

/// Number of levels that `color_coarse.comp` makes.
const COARSE_LEVELS: u32 = 7;

/// The pass that makes the levels.
pub struct ColorChainPass(LevelPipelines);

impl ColorChainPass {
    /// Makes the pass for lit colours of a size and format.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        format: vk::Format,
        filter: ChainFilter,
    ) -> Result<Self> {
        Ok(Self(match filter {
            ChainFilter::Hardware => LevelPipelines::Blits,
            ChainFilter::Gaussian => LevelPipelines::Gaussian(
                PixelPipeline::new(gpu, stage, [format], &())?,
                intermediate_image(gpu, stage, extent, format)?,
            ),
        }))
    }

    /// Makes the pass with the masked Gaussian, which [`Self::record_masked`] records; without a mask, the pass of
    /// [`Self::new`]. `tolerance` is the greatest difference of depths in one surface, as a part of the lesser depth.
    pub fn masked(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        filter: ChainFilter,
        (mask, tolerance): (ChainMask, f32),
    ) -> Result<Self> {
        if mask == ChainMask::None {
            return Self::new(gpu, stage, extent, LIT_COLOR, filter);
        }
        let constants = GaussianBlurMaskedConstants { surface: mask == ChainMask::Surface };
        let pipeline = PixelPipeline::new(gpu, stage, [LIT_COLOR], &constants)?;
        Ok(Self(LevelPipelines::Masked(pipeline, intermediate_image(gpu, stage, extent, LIT_COLOR)?, tolerance)))
    }

    /// Makes a pass for the same chain as [`ChainFilter::Hardware`], in fewer passes of a frame.
    pub fn in_few_passes(gpu: &Gpu) -> Result<Self> {
        Ok(Self(LevelPipelines::Coarse(ComputePipeline::new(gpu)?, ComputePipeline::new(gpu)?)))
    }

    /// Records passes "color/1" to the coarsest level, or "color/coarse" for several. All write to the colour image.
    pub fn record<'a>(&self, frame: &mut Frame, gbuffer: &GBuffer<'a>) -> Result<ColorChain<'a>> {
        let chain = gbuffer.color;
        match &self.0 {
            LevelPipelines::Blits => record_blits(frame, chain, 1..chain.levels())?,
            LevelPipelines::Coarse(_, pipeline) => record_levels(frame, chain, 1, pipeline)?,
            LevelPipelines::Gaussian(pipeline, between) => {
                for level in 1..chain.levels() {
                    let levels = [chain.level(level - 1), between.level(level), chain.level(level)];
                    record_gaussian(frame, level, pipeline, levels)?;
                }
            }
            LevelPipelines::Masked(..) => return Err(Error::Usage("a masked chain reads the Hi-Z buffer".into())),
        }
        Ok(ColorChain(chain))
    }

    /// Records the chain as [`Self::record`] does, but with black for the sky in all levels except level 0.
    ///
    /// # Errors
    /// [`Error::Usage`] for a pass that [`Self::in_few_passes`] did not make.
    pub fn record_without_sky<'a>(&self, frame: &mut Frame, gbuffer: &GBuffer<'a>) -> Result<ColorChain<'a>> {
        let chain = gbuffer.color;
        let LevelPipelines::Coarse(first, coarse) = &self.0 else {
            return Err(Error::Usage("a chain without sky is made in few passes".into()));
        };
        if chain.levels() > 1 {
            let (finest, coarser) = (chain.level(0), chain.level(1));
            let [width, height] = coarser.extent();
            frame.compute("color/1", first, &ColorFirst { finest, coarser }, [width, height, 1])?;
        }
        record_levels(frame, chain, 2, coarse)?;
        Ok(ColorChain(chain))
    }

    /// Records the chain. A mask, if the pass has one, comes from `hi_z`, the Hi-Z buffer of the same G-buffer.
    pub fn record_masked<'a>(
        &self,
        frame: &mut Frame,
        gbuffer: &GBuffer<'a>,
        hi_z: HiZ,
        lens: &Lens,
    ) -> Result<ColorChain<'a>> {
        let LevelPipelines::Masked(pipeline, blurred, tolerance) = &self.0 else { return self.record(frame, gbuffer) };
        let chain = gbuffer.color;
        for level in 1..chain.levels() {
            let [below, between, here] = [chain.level(level - 1), blurred.level(level), chain.level(level)];
            let texel_size @ [width, height] = here.extent().map(|side| 1.0 / side as f32);
            let passes = [("h", [width, 0.0], below, between), ("v", [0.0, height], between, here)];
            for (name, direction, from, to) in passes {
                let blur = MaskedBlurBlock {
                    invSize: texel_size,
                    direction,
                    near: lens.near_m,
                    far: lens.far_m,
                    tolerance: *tolerance,
                    ..MaskedBlurBlock::default()
                };
                let program = GaussianBlurMasked {
                    tex: Sampled::trilinear(from),
                    hiZ: Sampled::nearest(hi_z.0.level(level)),
                    blur: &blur,
                };
                frame.pixels(&format!("color/{level}{name}"), pipeline, [Target::overwrite(to)], &program)?;
            }
        }
        Ok(ColorChain(chain))
    }
}

/// Makes the image between the two passes of a Gaussian, with a full mip chain.
fn intermediate_image(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], format: vk::Format) -> Result<Box<Image>> {
    use vk::ImageUsageFlags as U;
    let (levels, usage) = (image::full_chain(extent), stage.target_usage() | U::SAMPLED);
    let described = ImageDesc { name: "horizontal blur", format, extent, levels, layers: 1, usage };
    Ok(Box::new(Image::new(gpu, &described)?))
}

/// Records blits that make some levels of a chain, each from the next finer level.
fn record_blits(frame: &mut Frame, chain: &Image, mut levels: Range<u32>) -> Result<()> {
    levels.try_for_each(|level| frame.blit(&format!("color/{level}"), chain.level(level - 1), chain.level(level)))
}

/// Records the levels of a chain from level `from` on, as blits. One dispatch makes the last [`COARSE_LEVELS`] levels
/// instead, if these begin at `from` or later and have the one format that the shader writes.
fn record_levels(
    frame: &mut Frame,
    chain: &Image,
    from: u32,
    pipeline: &ComputePipeline<ColorCoarse<'static>>,
) -> Result<()> {
    match chain.levels().checked_sub(COARSE_LEVELS) {
        Some(first) if first >= from && chain.format() == LIT_COLOR => {
            record_blits(frame, chain, from..first)?;
            record_coarse(frame, chain, first, pipeline)
        }
        _ => record_blits(frame, chain, from..chain.levels()),
    }
}

/// Records the last [`COARSE_LEVELS`] levels of a chain, from level `first` on, in one dispatch.
fn record_coarse(
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

/// Records a level as the Gaussian of the next finer level `below`, along x into `between`, then along y into `here`.
fn record_gaussian(
    frame: &mut Frame,
    level: u32,
    pipeline: &PixelPipeline<GaussianBlur<'static>>,
    [below, between, here]: [ImageSlice; 3],
) -> Result<()> {
    let texel_size @ [width, height] = here.extent().map(|side| 1.0 / side as f32);
    for (name, direction, from, to) in [("h", [width, 0.0], below, between), ("v", [0.0, height], between, here)] {
        frame.pixels(
            &format!("color/{level}{name}"),
            pipeline,
            [Target::overwrite(to)],
            &GaussianBlur { tex: Sampled::trilinear(from), blur: &BlurBlock { invSize: texel_size, direction } },
        )?;
    }
    Ok(())
}
