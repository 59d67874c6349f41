//! SSLR's second stage: the chains of the ray trace colour and of its mask (thesis §4.3.2), by the
//! mask-weighted Gaussian, or by the hardware's filter, as in the author's program.

use super::RayTraceColor;
use crate::error::Result;
use crate::gpu::shader::BlurBlock;
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Sampled, Target, image, programs};
use crate::parameter::choices;
use ash::vk;

choices! {
    /// How both chains are filtered.
    pub enum MaskFilter {
        /// 7-tap separable Gaussian; where the mask is 0 the central pixel is read instead.
        Weighted = "weighted",
        /// The GPU's own mip generation; the mask has no say.
        Hardware = "hardware",
    }
}

/// Pipeline and the images between the two directions of the Gaussian.
pub struct MaskChainPass {
    gaussian: Option<Gaussian>,
}

struct Gaussian {
    pipeline: GraphicsPipeline<programs::SslrBlur<'static>>,
    color: Image,
    mask: Image,
}

impl MaskChainPass {
    /// For ray trace colours of a size in pixels and the formats of their images.
    pub fn new(gpu: &Gpu, extent: [u32; 2], formats: [vk::Format; 2], filter: MaskFilter) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        if filter == MaskFilter::Hardware {
            return Ok(Self { gaussian: None });
        }
        let (levels, usage) = (image::full_chain(extent), U::COLOR_ATTACHMENT | U::SAMPLED);
        let image = |name, format| Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage });
        let gaussian = Gaussian {
            pipeline: GraphicsPipeline::fullscreen(gpu, formats)?,
            color: image("horizontal blur of the color", formats[0])?,
            mask: image("horizontal blur of the mask", formats[1])?,
        };
        Ok(Self { gaussian: Some(gaussian) })
    }

    /// Passes "blur/1" to the coarsest level, written into the images themselves.
    pub fn record<'a>(&self, frame: &mut Frame, traced: RayTraceColor<'a>) -> Result<RayTraceColor<'a>> {
        let RayTraceColor { color, mask } = traced;
        for level in 1..color.levels() {
            let below = [color.level(level - 1), mask.level(level - 1)];
            let here = [color.level(level), mask.level(level)];
            let Some(gaussian) = &self.gaussian else {
                frame.blit(&format!("blur/{level} color"), below[0], here[0])?;
                frame.blit(&format!("blur/{level} mask"), below[1], here[1])?;
                continue;
            };
            let between = [gaussian.color.level(level), gaussian.mask.level(level)];
            let [w, h] = here[0].extent().map(|v| 1.0 / v as f32);
            for (name, direction, from, to) in [("h", [w, 0.0], below, between), ("v", [0.0, h], between, here)] {
                frame.fullscreen(
                    &format!("blur/{level}{name}"),
                    &gaussian.pipeline,
                    to.map(Target::overwrite),
                    &programs::SslrBlur {
                        tex: Sampled::trilinear(from[0]),
                        mask: Sampled::trilinear(from[1]),
                        blur: &BlurBlock { invSize: [w, h], direction },
                    },
                )?;
            }
        }
        Ok(traced)
    }
}
