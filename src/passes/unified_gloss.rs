//! The glossy path of `unified`: rays interleaved over blocks of pixels, and every pixel's reflection
//! gathered from its neighbours' hits (NUMERICS, "Gloss"). A ray a pixel for narrow lobes, one for four
//! pixels for wide ones; which of the two a pixel is says its roughness alone.

use super::{GBuffer, Pyramid, Reflection};
use crate::error::Result;
use crate::gpu::shader::{
    UNIFIED_GLOSS_COARSE_COMP, UNIFIED_GLOSS_FINE_FRAG, UNIFIED_GLOSS_RESOLVE_FRAG, UnifiedBlock,
};
use crate::gpu::{ComputePipeline, Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Target};
use ash::vk;

const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The coarsest level of the colour that a ray's footprint can ask for: a texel of 32 pixels.
const COARSEST_COLOR: u32 = 5;

/// Pipelines and images of one size.
pub struct UnifiedGlossPass {
    fine: GraphicsPipeline,
    coarse: ComputePipeline,
    resolve: GraphicsPipeline,
    /// Where each ray ended, and what it saw; a ray a pixel, then a ray for four.
    fine_seen: [Image; 2],
    coarse_seen: [Image; 2],
    reflection: Image,
    composite: Image,
}

/// What the pass made.
#[derive(Clone, Copy)]
pub struct Glossy<'a> {
    /// Reflection colour and fade.
    pub reflection: Reflection<'a>,
    /// The finished image, linear.
    pub composite: &'a Image,
}

impl UnifiedGlossPass {
    /// For images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |name, format, extent, usage| {
            let usage = usage | U::SAMPLED | U::TRANSFER_SRC;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        let half = extent.map(|n| n.div_ceil(2));
        Ok(Self {
            fine: GraphicsPipeline::fullscreen(gpu, &UNIFIED_GLOSS_FINE_FRAG, &[PLACE, COLOR])?,
            coarse: ComputePipeline::new(gpu, &UNIFIED_GLOSS_COARSE_COMP)?,
            resolve: GraphicsPipeline::fullscreen(gpu, &UNIFIED_GLOSS_RESOLVE_FRAG, &[COLOR, COLOR])?,
            fine_seen: [
                image("fine place", PLACE, extent, U::COLOR_ATTACHMENT)?,
                image("fine color", COLOR, extent, U::COLOR_ATTACHMENT)?,
            ],
            coarse_seen: [
                image("coarse place", PLACE, half, U::STORAGE)?,
                image("coarse color", COLOR, half, U::STORAGE)?,
            ],
            reflection: image("reflection", COLOR, extent, U::COLOR_ATTACHMENT)?,
            composite: image("composite", COLOR, extent, U::COLOR_ATTACHMENT)?,
        })
    }

    /// Passes "color/1" …, "trace fine", "trace coarse" and "resolve"; of the traces, those that
    /// `lobes` needs.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        pyramid: Pyramid,
        parameters: &UnifiedBlock,
        lobes: Lobes,
    ) -> Result<Glossy<'a>> {
        let color = gbuffer.color;
        for level in 1..color.levels().min(COARSEST_COLOR + 1) {
            frame.blit(&format!("color/{level}"), color.level(level - 1), color.level(level))?;
        }
        let block = ("unified", Resource::Uniform(bytemuck::bytes_of(parameters)));
        let traced = [
            block,
            ("pyramid", Resource::nearest(pyramid.0.all())),
            ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
            ("material_buffer", Resource::nearest(gbuffer.material.all())),
            ("color_buffer", Resource::trilinear(color.all())),
        ];
        let [fine, coarse] = [&self.fine_seen, &self.coarse_seen];
        if lobes.narrow {
            let targets = [0, 1].map(|i| Target::overwrite(fine[i].all()));
            frame.fullscreen("trace fine", &self.fine, &targets, &traced, &[])?;
        }
        if lobes.wide {
            let stored = [
                ("place_image", Resource::Storage(coarse[0].all())),
                ("seen_image", Resource::Storage(coarse[1].all())),
            ];
            let resources: Vec<_> = traced.into_iter().chain(stored).collect();
            let [width, height] = coarse[0].extent();
            // A workgroup of 256 threads has 16 × 16 cells.
            let threads = [width.div_ceil(16) * 256, height.div_ceil(16), 1];
            frame.compute("trace coarse", &self.coarse, &resources, &[], threads)?;
        }
        let targets = [&self.reflection, &self.composite].map(|i| Target::overwrite(i.all()));
        frame.fullscreen(
            "resolve",
            &self.resolve,
            &targets,
            &[
                block,
                ("depth_buffer", Resource::nearest(gbuffer.depth.all())),
                ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
                ("material_buffer", Resource::nearest(gbuffer.material.all())),
                ("color_buffer", Resource::nearest(color.level(0))),
                ("fine_place", Resource::nearest(fine[0].all())),
                ("fine_color", Resource::nearest(fine[1].all())),
                ("coarse_place", Resource::nearest(coarse[0].all())),
                ("coarse_color", Resource::nearest(coarse[1].all())),
            ],
            &[],
        )?;
        Ok(Glossy { reflection: Reflection(&self.reflection), composite: &self.composite })
    }
}

/// Which lobes a frame may show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lobes {
    /// Roughness up to [`COARSE_ABOVE`], mirrors too.
    pub narrow: bool,
    /// Roughness above it.
    pub wide: bool,
}

/// Roughness from which on rays are traced at half resolution (`shaders-glsl/unified/gloss.glsl`).
pub const COARSE_ABOVE: f32 = 0.2;

impl Lobes {
    /// Of some roughness values.
    pub fn of(roughness: impl IntoIterator<Item = f32>) -> Self {
        roughness.into_iter().fold(Self { narrow: false, wide: false }, |lobes, r| Self {
            narrow: lobes.narrow || r <= COARSE_ABOVE,
            wide: lobes.wide || r > COARSE_ABOVE,
        })
    }
}
