//! Makes the Hi-Z buffer (thesis §4.2.4, Alg. 3, Eq. 4.1). Level 0 is the standard depth, and each texel above it the
//! minimum of four texels of the finer level, with their maximum beside it if wanted. CPU twin: `reference::hi_z`.

use super::{GBuffer, HiZ};
use crate::error::Result;
use crate::gpu::shader::HiZBlock;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, PixelPipeline, Sampled, ShaderStage, Target, image, programs};
use ash::vk;

/// Format of the minimum alone.
const MINIMUM: vk::Format = vk::Format::R32_SFLOAT;
/// Format of the minimum in r and the maximum in g.
const BOTH: vk::Format = vk::Format::R32G32_SFLOAT;

/// Pipelines and the chain of one size.
pub struct HiZPass {
    depth: PixelPipeline<programs::Depth<'static>>,
    reduce: PixelPipeline<programs::HiZ<'static>>,
    chain: Image,
}

impl HiZPass {
    /// Makes the pass with a full chain over a size in pixels, with or without maxima.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], maximum: bool) -> Result<Self> {
        Self::with_levels(gpu, stage, extent, image::full_chain(extent), if maximum { BOTH } else { MINIMUM })
    }

    /// Makes the pass with level 0 alone, a buffer of standard depth for marches that read it with a linear filter.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] on a device that can't filter its format.
    pub fn depth_alone(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        gpu.require_linear_filter(MINIMUM)?;
        Self::with_levels(gpu, stage, extent, 1, MINIMUM)
    }

    /// Makes the pass with `levels` levels of [`MINIMUM`] or [`BOTH`].
    fn with_levels(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2], levels: u32, format: vk::Format) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let usage = stage.target_usage() | U::SAMPLED | U::TRANSFER_SRC;
        Ok(Self {
            depth: PixelPipeline::new(gpu, stage, [format], &())?,
            reduce: PixelPipeline::new(gpu, stage, [format], &())?,
            chain: Image::new(gpu, &ImageDesc { name: "hi-z", format, extent, levels, layers: 1, usage })?,
        })
    }

    /// Records passes "depth" and "hi-z/1" to the coarsest level.
    pub fn record<'a>(&'a self, frame: &mut Frame, gbuffer: &GBuffer) -> Result<HiZ<'a>> {
        frame.pixels(
            "depth",
            &self.depth,
            [Target::overwrite(self.chain.level(0))],
            &programs::Depth { depth_buffer: Sampled::nearest(gbuffer.depth.all()) },
        )?;
        for level in 1..self.chain.levels() {
            let below = self.chain.level(level - 1);
            let hiz = HiZBlock { Offset: below.extent().map(offset) };
            frame.pixels(
                &format!("hi-z/{level}"),
                &self.reduce,
                [Target::overwrite(self.chain.level(level))],
                &programs::HiZ { Tex: Sampled::nearest(below), hiz: &hiz },
            )?;
        }
        Ok(self.recorded())
    }

    /// Returns the chain as it was recorded last.
    pub fn recorded(&self) -> HiZ<'_> {
        HiZ(&self.chain)
    }
}

/// Eq. 4.1 of the thesis: the distance between the texels that a level reads in a finer level of `side` texels a side.
pub fn offset(side: u32) -> i32 {
    if side.is_multiple_of(2) { 1 } else { 2 }
}
