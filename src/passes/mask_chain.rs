//! SSLR's second stage, which makes the mip chains of the ray trace colour and of its mask (thesis §4.3.2). The filter
//! is a Gaussian that the mask weighs, or that of the hardware, as in the author's program.

use super::{RayTraceColor, UNENCODED_COLOR};
use crate::error::Result;
use crate::gpu::shader::BlurBlock;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, PixelPipeline, Sampled, ShaderStage, Target, image, programs};
use ash::vk;
use ssct_ground::parameter::choices;

choices! {
    /// How both chains are filtered.
    pub enum MaskFilter {
        /// 7-tap separable Gaussian; where the mask is 0 the central pixel is read instead.
        Weighted = "weighted",
        /// The GPU's own mip generation; the mask has no say.
        Hardware = "hardware",
    }
}

/// The masked Gaussian; `None` for the hardware's filter.
pub struct MaskChainPass {
    gaussian: Option<Gaussian>,
}

/// The program of the masked Gaussian, and the images that are blurred along x alone.
struct Gaussian {
    pipeline: PixelPipeline<programs::SslrBlur<'static>>,
    color: Image,
    mask: Image,
}

impl MaskChainPass {
    /// Makes the pass for ray trace colours of a size in pixels, with the formats of the colour and of the mask.
    pub fn new(
        gpu: &Gpu,
        stage: ShaderStage,
        extent: [u32; 2],
        [color_format, mask_format]: [vk::Format; 2],
        filter: MaskFilter,
    ) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        if filter == MaskFilter::Hardware {
            return Ok(Self { gaussian: None });
        }
        let levels = image::full_chain(extent);
        let image = |name, format, usage| {
            Image::new(gpu, &ImageDesc { name, format, extent, levels, layers: 1, usage: usage | U::SAMPLED })
        };
        // Compute programs store the colour before it is encoded, and another pass encodes it.
        let (written_format, color_usage) = match stage {
            ShaderStage::Fragment => (color_format, U::COLOR_ATTACHMENT),
            ShaderStage::Compute => (UNENCODED_COLOR, U::TRANSFER_DST),
        };
        let gaussian = Gaussian {
            pipeline: PixelPipeline::new(gpu, stage, [written_format, mask_format], &())?,
            color: image("horizontal blur of the color", color_format, color_usage)?,
            mask: image("horizontal blur of the mask", mask_format, stage.target_usage())?,
        };
        Ok(Self { gaussian: Some(gaussian) })
    }

    /// Records passes "blur/1" to the coarsest level, each of which filters a level of both chains into the next level.
    /// In compute shaders, a pass that encodes the colour, such as "blur/1h/encode", follows each pass of the Gaussian.
    pub fn record<'a>(&self, frame: &mut Frame, traced: RayTraceColor<'a>) -> Result<RayTraceColor<'a>> {
        let RayTraceColor { color, mask, .. } = traced;
        for level in 1..color.levels() {
            let below = [color.level(level - 1), mask.level(level - 1)];
            let here = [color.level(level), mask.level(level)];
            let Some(gaussian) = &self.gaussian else {
                frame.blit(&format!("blur/{level} color"), below[0], here[0])?;
                frame.blit(&format!("blur/{level} mask"), below[1], here[1])?;
                continue;
            };
            let between = [gaussian.color.level(level), gaussian.mask.level(level)];
            let texel_size @ [width, height] = here[0].extent().map(|side| 1.0 / side as f32);
            let passes = [("h", [width, 0.0], below, between), ("v", [0.0, height], between, here)];
            for (letter, direction, [from_color, from_mask], [to_color, to_mask]) in passes {
                let name = format!("blur/{level}{letter}");
                let color_target = traced.unencoded.map_or(to_color, |unencoded| unencoded.level(level));
                frame.pixels(
                    &name,
                    &gaussian.pipeline,
                    [color_target, to_mask].map(Target::overwrite),
                    &programs::SslrBlur {
                        tex: Sampled::trilinear(from_color),
                        mask: Sampled::trilinear(from_mask),
                        blur: &BlurBlock { invSize: texel_size, direction },
                    },
                )?;
                traced.encode(frame, &name, to_color)?;
            }
        }
        Ok(traced)
    }
}
