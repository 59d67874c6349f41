//! Pre-integration: makes the visibility buffer (thesis §4.2.5, Eq. 4.2, listing). CPU twin: `reference::visibility`.

use super::{HiZ, Visibility};
use crate::error::Result;
use crate::gpu::shader::VisibilityBlock;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, PixelPipeline, Sampled, ShaderStage, Target, image, programs};
use ash::vk;
use ssct_ground::scene::Lens;

const FORMAT: vk::Format = vk::Format::R8_UNORM;

/// Pipeline and the chain of one size.
pub struct VisibilityPass {
    pipeline: PixelPipeline<programs::Visibility<'static>>,
    chain: Image,
}

impl VisibilityPass {
    /// Makes the pass with a full chain over a size in pixels.
    pub fn new(gpu: &Gpu, stage: ShaderStage, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let usage = stage.target_usage() | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
        let (format, levels) = (FORMAT, image::full_chain(extent));
        Ok(Self {
            pipeline: PixelPipeline::new(gpu, stage, [format], &())?,
            chain: Image::new(gpu, &ImageDesc { name: "visibility", format, extent, levels, layers: 1, usage })?,
        })
    }

    /// Records pass "visibility/0", which clears level 0 to 1, and a pass for each further level, up to the coarsest.
    pub fn record<'a>(&'a self, frame: &mut Frame, hi_z: HiZ, lens: &Lens) -> Result<Visibility<'a>> {
        frame.clear("visibility/0", self.chain.level(0), [1.0; 4])?;
        let range = VisibilityBlock { near_plane: lens.near_m, far_plane: lens.far_m };
        for level in 1..self.chain.levels() {
            frame.pixels(
                &format!("visibility/{level}"),
                &self.pipeline,
                [Target::overwrite(self.chain.level(level))],
                &programs::Visibility {
                    depthMap: Sampled::nearest(hi_z.0.level(level - 1)),
                    visibilityMap: Sampled::nearest(self.chain.level(level - 1)),
                    range: &range,
                },
            )?;
        }
        Ok(self.recorded())
    }

    /// Returns the chain as it was recorded last.
    pub fn recorded(&self) -> Visibility<'_> {
        Visibility(&self.chain)
    }
}
