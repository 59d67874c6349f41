//! Pre-convolution: the colour's mip chain (thesis §4.2.6), by the hardware's linear filter as the
//! thesis chose, or by the 7-tap Gaussian of §4.3.2 as its alternative.

use super::{ColorChain, GBuffer};
use crate::error::Result;
use crate::gpu::shader::{BlurBlock, THESIS_GAUSSIAN_BLUR_FRAG};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Target, image};
use ash::vk;

/// How the chain is filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChainFilter {
    /// Each level is a linear blit of the one below: the GPU's own mip generation.
    #[default]
    Hardware,
    /// Each level is a 7-tap separable Gaussian of the one below.
    Gaussian,
}

/// Pipeline and the image between the two directions of the Gaussian.
pub struct ColorChainPass {
    gaussian: Option<(GraphicsPipeline, Image)>,
}

impl ColorChainPass {
    /// For lit colours of a size and format.
    pub fn new(gpu: &Gpu, extent: [u32; 2], format: vk::Format, filter: ChainFilter) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let gaussian = match filter {
            ChainFilter::Hardware => None,
            ChainFilter::Gaussian => Some((
                GraphicsPipeline::fullscreen(gpu, &THESIS_GAUSSIAN_BLUR_FRAG, &[format])?,
                Image::new(
                    gpu,
                    &ImageDesc {
                        name: "horizontal blur",
                        format,
                        extent,
                        levels: image::full_chain(extent),
                        layers: 1,
                        usage: U::COLOR_ATTACHMENT | U::SAMPLED,
                    },
                )?,
            )),
        };
        Ok(Self { gaussian })
    }

    /// Passes "color/1" to the coarsest level, written into the colour image itself.
    pub fn record<'a>(&self, frame: &mut Frame, gbuffer: &GBuffer<'a>) -> Result<ColorChain<'a>> {
        let chain = gbuffer.color;
        for level in 1..chain.levels() {
            let (below, here) = (chain.level(level - 1), chain.level(level));
            let Some((pipeline, between)) = &self.gaussian else {
                frame.blit(&format!("color/{level}"), below, here)?;
                continue;
            };
            let between = between.level(level);
            let [w, h] = here.extent().map(|v| 1.0 / v as f32);
            for (name, direction, from, to) in [("h", [w, 0.0], below, between), ("v", [0.0, h], between, here)] {
                frame.fullscreen(
                    &format!("color/{level}{name}"),
                    pipeline,
                    &[Target::overwrite(to)],
                    &[("tex", Resource::trilinear(from))],
                    bytemuck::bytes_of(&BlurBlock { invSize: [w, h], direction }),
                )?;
            }
        }
        Ok(ColorChain(chain))
    }
}
