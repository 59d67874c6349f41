//! The glossy path of `unified`: rays interleaved over blocks of pixels, and every pixel's reflection
//! gathered from its neighbours' hits (NUMERICS, "Gloss"). A ray a pixel for narrow lobes, one for four
//! pixels for wide ones; which of the two a pixel is says its roughness alone.

use super::{GBuffer, Pyramid, Reflection};
use crate::error::Result;
use crate::gpu::shader::{
    UNIFIED_GLOSS_CELLS_FRAG, UNIFIED_GLOSS_NARROW_FRAG, UNIFIED_GLOSS_RESOLVE_BOTH_FRAG,
    UNIFIED_GLOSS_RESOLVE_NARROW_FRAG, UNIFIED_GLOSS_RESOLVE_WIDE_FRAG, UNIFIED_GLOSS_WIDE_FRAG, UnifiedBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Target};
use ash::vk;

const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Pipelines and images of one size.
pub struct UnifiedGlossPass {
    narrow: GraphicsPipeline,
    wide: GraphicsPipeline,
    cells: GraphicsPipeline,
    /// For narrow lobes, for wide ones, and for both.
    resolve: [GraphicsPipeline; 3],
    /// Where each pixel's ray ended, and what it saw.
    seen: [Image; 2],
    /// The same of each cell of 2 × 2 pixels.
    cells_seen: [Image; 2],
    /// Each cell's reflection, and the surface that it is of.
    resolved: [Image; 2],
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
        let image = |name, format, extent| {
            let usage = U::COLOR_ATTACHMENT | U::STORAGE | U::SAMPLED | U::TRANSFER_SRC;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        let pipeline = |shader, formats: [vk::Format; 2]| GraphicsPipeline::fullscreen(gpu, shader, &formats);
        let cells = extent.map(|n| n.div_ceil(2));
        Ok(Self {
            narrow: pipeline(&UNIFIED_GLOSS_NARROW_FRAG, [PLACE, COLOR])?,
            wide: pipeline(&UNIFIED_GLOSS_WIDE_FRAG, [PLACE, COLOR])?,
            cells: pipeline(&UNIFIED_GLOSS_CELLS_FRAG, [COLOR; 2])?,
            resolve: [
                pipeline(&UNIFIED_GLOSS_RESOLVE_NARROW_FRAG, [COLOR; 2])?,
                pipeline(&UNIFIED_GLOSS_RESOLVE_WIDE_FRAG, [COLOR; 2])?,
                pipeline(&UNIFIED_GLOSS_RESOLVE_BOTH_FRAG, [COLOR; 2])?,
            ],
            seen: [image("seen place", PLACE, extent)?, image("seen color", COLOR, extent)?],
            cells_seen: [image("cells seen place", PLACE, cells)?, image("cells seen color", COLOR, cells)?],
            resolved: [image("cell reflection", COLOR, cells)?, image("cell surface", COLOR, cells)?],
            reflection: image("reflection", COLOR, extent)?,
            composite: image("composite", COLOR, extent)?,
        })
    }

    /// Passes "color/1" …, "trace/narrow", "trace/wide", "cells" and "resolve"; of the middle ones those
    /// that the frame's materials need.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        pyramid: Pyramid,
        parameters: &UnifiedBlock,
    ) -> Result<Glossy<'a>> {
        let color = gbuffer.color;
        for level in 1..color.levels() {
            frame.blit(&format!("color/{level}"), color.level(level - 1), color.level(level))?;
        }
        let block = ("unified", Resource::Uniform(bytemuck::bytes_of(parameters)));
        let depth = ("depth_buffer", Resource::nearest(gbuffer.depth.all()));
        let normal = ("normal_buffer", Resource::nearest(gbuffer.normal.all()));
        let material = ("material_buffer", Resource::nearest(gbuffer.material.all()));
        let pyramid = ("pyramid", Resource::Loaded(pyramid.0.all()));
        let traced = [block, pyramid, normal, material, ("color_buffer", Resource::trilinear(color.all()))];
        let loaded = |name, image: &'a Image| (name, Resource::Loaded(image.all()));
        let into = |images: &'a [Image; 2]| [0, 1].map(|i| Target::overwrite(images[i].all()));
        let reflectors = gbuffer.reflectors;

        let narrow = reflectors.mirrors || reflectors.narrow;
        let mut resolved = vec![block, depth, normal, material, ("color_buffer", Resource::nearest(color.level(0)))];
        if narrow {
            frame.fullscreen("trace/narrow", &self.narrow, &into(&self.seen), &traced, &[])?;
            resolved.extend([loaded("place_image", &self.seen[0]), loaded("seen_image", &self.seen[1])]);
        } else {
            frame.skip("trace/narrow", "no material that is drawn has a narrow lobe");
        }
        if reflectors.wide {
            let places = loaded("place_image", &self.cells_seen[0]);
            let colors = loaded("seen_image", &self.cells_seen[1]);
            let resources: Vec<_> = traced.into_iter().chain([depth]).collect();
            frame.fullscreen("trace/wide", &self.wide, &into(&self.cells_seen), &resources, &[])?;
            let resources = [block, depth, normal, material, places, colors];
            frame.fullscreen("cells", &self.cells, &into(&self.resolved), &resources, &[])?;
            resolved.push(loaded("cell_reflection", &self.resolved[0]));
            resolved.push(loaded("cell_surface", &self.resolved[1]));
        } else {
            for pass in ["trace/wide", "cells"] {
                frame.skip(pass, "no material that is drawn has a wide lobe");
            }
        }
        let [only_narrow, only_wide, both] = &self.resolve;
        let resolve = match (narrow, reflectors.wide) {
            (true, true) => both,
            (_, false) => only_narrow,
            (false, true) => only_wide,
        };
        let targets = [&self.reflection, &self.composite].map(|i| Target::overwrite(i.all()));
        frame.fullscreen("resolve", resolve, &targets, &resolved, &[])?;
        Ok(Glossy { reflection: Reflection(&self.reflection), composite: &self.composite })
    }
}
