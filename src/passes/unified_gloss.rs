//! The glossy path of `unified`: rays interleaved over blocks of pixels, and every pixel's reflection
//! gathered from its neighbours' hits (NUMERICS, "Gloss"). A ray a pixel for narrow lobes, one for four
//! pixels for wide ones; which of the two a pixel is says its roughness alone.

use super::{GBuffer, Pyramid, Reflection};
use crate::error::Result;
use crate::gpu::shader::{
    UNIFIED_GLOSS_CELLS_COMP, UNIFIED_GLOSS_COARSE_COMP, UNIFIED_GLOSS_FINE_FRAG, UNIFIED_GLOSS_RESOLVE_COMP,
    UnifiedBlock,
};
use crate::gpu::{ComputePipeline, Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Target};
use ash::vk;

const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Roughness above which rays are traced at half resolution (`shaders-glsl/unified/gloss.glsl`).
pub const COARSE_ABOVE: f32 = 0.2;

/// Pipelines and images of one size.
pub struct UnifiedGlossPass {
    fine: GraphicsPipeline,
    coarse: ComputePipeline,
    cells: ComputePipeline,
    resolve: ComputePipeline,
    /// Where each pixel's ray ended, and what it saw.
    fine_seen: [Image; 2],
    /// The same of each cell of 2 × 2 pixels.
    coarse_seen: [Image; 2],
    /// Each cell's reflection, and the surface that it is of.
    resolved: [Image; 2],
    reflection: Image,
    composite: Image,
}

/// Which lobes a frame may show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lobes {
    /// Roughness up to [`COARSE_ABOVE`], mirrors too.
    pub narrow: bool,
    /// Roughness above it.
    pub wide: bool,
}

impl Lobes {
    /// Of some roughness values.
    pub fn of(roughness: impl IntoIterator<Item = f32>) -> Self {
        roughness.into_iter().fold(Self { narrow: false, wide: false }, |lobes, r| Self {
            narrow: lobes.narrow || r <= COARSE_ABOVE,
            wide: lobes.wide || r > COARSE_ABOVE,
        })
    }
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
        let cells = extent.map(|n| n.div_ceil(2));
        Ok(Self {
            fine: GraphicsPipeline::fullscreen(gpu, &UNIFIED_GLOSS_FINE_FRAG, &[PLACE, COLOR])?,
            coarse: ComputePipeline::new(gpu, &UNIFIED_GLOSS_COARSE_COMP)?,
            cells: ComputePipeline::new(gpu, &UNIFIED_GLOSS_CELLS_COMP)?,
            resolve: ComputePipeline::new(gpu, &UNIFIED_GLOSS_RESOLVE_COMP)?,
            fine_seen: [
                image("fine place", PLACE, extent, U::COLOR_ATTACHMENT | U::STORAGE)?,
                image("fine color", COLOR, extent, U::COLOR_ATTACHMENT | U::STORAGE)?,
            ],
            coarse_seen: [
                image("coarse place", PLACE, cells, U::STORAGE)?,
                image("coarse color", COLOR, cells, U::STORAGE)?,
            ],
            resolved: [
                image("cell reflection", COLOR, cells, U::STORAGE)?,
                image("cell surface", COLOR, cells, U::STORAGE)?,
            ],
            reflection: image("reflection", COLOR, extent, U::STORAGE)?,
            composite: image("composite", COLOR, extent, U::STORAGE)?,
        })
    }

    /// Passes "color/1" …, "trace fine", "trace coarse", "cells" and "resolve"; of the middle ones those
    /// that `lobes` needs.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        pyramid: Pyramid,
        parameters: &UnifiedBlock,
        lobes: Lobes,
    ) -> Result<Glossy<'a>> {
        let color = gbuffer.color;
        for level in 1..color.levels() {
            frame.blit(&format!("color/{level}"), color.level(level - 1), color.level(level))?;
        }
        let block = ("unified", Resource::Uniform(bytemuck::bytes_of(parameters)));
        let depth = ("depth_buffer", Resource::nearest(gbuffer.depth.all()));
        let normal = ("normal_buffer", Resource::nearest(gbuffer.normal.all()));
        let material = ("material_buffer", Resource::nearest(gbuffer.material.all()));
        let storage = |name, image: &'a Image| (name, Resource::Storage(image.all()));
        let pyramid = ("pyramid", Resource::nearest(pyramid.0.all()));
        let traced = [block, pyramid, normal, material, ("color_buffer", Resource::trilinear(color.all()))];

        if lobes.narrow {
            let targets = [0, 1].map(|i| Target::overwrite(self.fine_seen[i].all()));
            frame.fullscreen("trace fine", &self.fine, &targets, &traced, &[])?;
        }
        let places = storage("place_image", &self.coarse_seen[0]);
        let colors = storage("seen_image", &self.coarse_seen[1]);
        let cell_reflection = storage("cell_reflection", &self.resolved[0]);
        let cell_surface = storage("cell_surface", &self.resolved[1]);
        if lobes.wide {
            let [width, height] = self.resolved[0].extent();
            let resources: Vec<_> = traced.into_iter().chain([depth, places, colors]).collect();
            frame.compute("trace coarse", &self.coarse, &resources, &[], [width, height, 1])?;
            let resources = [block, depth, normal, material, places, colors, cell_reflection, cell_surface];
            frame.compute("cells", &self.cells, &resources, &[], [width, height, 1])?;
        }
        let [width, height] = self.reflection.extent();
        frame.compute(
            "resolve",
            &self.resolve,
            &[
                block,
                depth,
                normal,
                material,
                ("color_buffer", Resource::nearest(color.level(0))),
                storage("fine_place", &self.fine_seen[0]),
                storage("fine_color", &self.fine_seen[1]),
                cell_reflection,
                cell_surface,
                storage("reflection_image", &self.reflection),
                storage("composite_image", &self.composite),
            ],
            &[],
            [width, height, 1],
        )?;
        Ok(Glossy { reflection: Reflection(&self.reflection), composite: &self.composite })
    }
}
