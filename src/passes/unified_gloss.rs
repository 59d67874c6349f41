//! The glossy passes of `unified`: the directions of a pattern are dealt out to neighbouring pixels, and every pixel
//! gathers its reflection from its neighbours' rays (docs/numerics.md, "Gloss"). A pixel's roughness alone decides
//! whether its lobe is narrow, with one ray a pixel, or wide, with one ray for 2 × 2 pixels.

use super::lost::{ENDS, LostRayBindings};
use super::tiles::{TileRange, TiledPipeline, Tiles, UnifiedSetup};
use super::triangle_scene::TriangleBindings;
use super::{Canvas, GBuffer, LIT_COLOR, Pyramid};
use crate::error::Result;
use crate::gpu::programs::{
    Cells, CellsConstants, ResolveNarrow, ResolveNarrowConstants, ResolveWide, ResolveWideConstants, TraceNarrow,
    TraceNarrowConstants, TraceWide, TraceWideConstants,
};
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Frame, Gpu, Image, ImageDesc, Sampled};
use ash::vk;
use ssct_ground::math::constants::{NARROW_LIST, WIDE_LIST};

const RECORD: vk::Format = vk::Format::R32G32B32A32_UINT;
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Pipelines and images of one size.
pub struct UnifiedGlossPass {
    trace_narrow: TiledPipeline<TraceNarrow<'static>>,
    resolve_narrow: TiledPipeline<ResolveNarrow<'static>>,
    trace_wide: TiledPipeline<TraceWide<'static>>,
    cells: TiledPipeline<Cells<'static>>,
    resolve_wide: TiledPipeline<ResolveWide<'static>>,
    images: GlossImages,
}

/// The images that one pass writes and another reads. Their content is undefined where no tile is drawn.
pub struct GlossImages {
    /// The ray of each pixel with a narrow lobe: `RayRecord` of `gloss.glsl`, packed.
    pub records: Image,
    /// Where the ray of each cell of 2 × 2 pixels ended (a point, or a direction for a miss), and the ray's density.
    pub place: Image,
    /// The lit colour that the ray of each cell saw, with its fade.
    pub seen: Image,
    /// The reflection of each cell, with its fade.
    pub cell_reflection: Image,
    /// The normal and depth of the surface that a cell's reflection belongs to.
    pub cell_surface: Image,
    /// Where each ray ended ([`ENDS`]), for a history; a single texel without a history.
    pub ends: Image,
}

/// The inputs of the passes, and the images that they draw into.
#[derive(Clone, Copy)]
pub struct UnifiedGlossInput<'a> {
    /// Normals, materials and lit colour with its chain.
    pub gbuffer: GBuffer<'a>,
    /// The pyramid that rays walk over.
    pub pyramid: Pyramid<'a>,
    /// The tiles to draw, over what [`Canvas::begin`] drew; or the whole image, over a canvas without content.
    pub tiles: Tiles<'a>,
    /// The images to draw into.
    pub canvas: Canvas<'a>,
    /// The sky, and the list of rays that the screen lost.
    pub lost_rays: LostRayBindings<'a>,
    /// The triangles, if rays are traced among them.
    pub triangle_bindings: Option<TriangleBindings<'a>>,
}

impl UnifiedGlossPass {
    /// Makes pipelines and images. The passes "trace/wide" and "cells" write images of half the size, with a texel for
    /// each cell. The errors are those of [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, setup: &UnifiedSetup) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |name, format, extent| {
            let usage = U::COLOR_ATTACHMENT | U::STORAGE | U::SAMPLED | U::TRANSFER_SRC;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        let (strip, oracle) = (setup.strip as i32, u32::from(setup.oracle) as i32);
        let UnifiedSetup { over_fallback: over, composite, own_rays, stores_ends, .. } = *setup;
        let (screen, followed) = (setup.walks_screen, setup.follows_lost_rays);
        let (formats, beside) = (setup.formats(), setup.wants_both());
        let (orthographic, triangle_constants) = (setup.projection.is_orthographic(), setup.triangle_constants());
        let narrow = TileRange { list: NARROW_LIST, halved: false };
        let [pixels, halves] = [false, true].map(|halved| TileRange { list: WIDE_LIST, halved });
        let (trace, resolve) = (setup.trace_permutation(), setup.resolve_stage.into());
        let cells = setup.extent.map(|n| n.div_ceil(2));
        Ok(Self {
            trace_narrow: TiledPipeline::new(gpu, narrow, trace, [RECORD], |whole| TraceNarrowConstants {
                strip,
                oracle,
                whole,
                followed,
                stores_ends,
                own_rays,
                orthographic,
                triangle_constants,
            })?,
            resolve_narrow: TiledPipeline::new(gpu, narrow, resolve, formats, |whole| ResolveNarrowConstants {
                over,
                whole,
                composite,
                own_rays,
                beside,
                orthographic,
            })?,
            trace_wide: TiledPipeline::new(gpu, halves, trace, [PLACE, LIT_COLOR], |whole| TraceWideConstants {
                strip,
                oracle,
                whole,
                followed,
                stores_ends,
                orthographic,
                triangle_constants,
            })?,
            cells: TiledPipeline::new(gpu, halves, resolve, [LIT_COLOR; 2], |whole| CellsConstants {
                strip,
                screen,
                over,
                whole,
                own_rays,
                orthographic,
            })?,
            resolve_wide: TiledPipeline::new(gpu, pixels, resolve, formats, |whole| ResolveWideConstants {
                strip,
                screen,
                over,
                whole,
                composite,
                own_rays,
                beside,
                orthographic,
            })?,
            images: GlossImages {
                records: image("seen", RECORD, setup.extent)?,
                place: image("seen place", PLACE, cells)?,
                seen: image("seen color", LIT_COLOR, cells)?,
                cell_reflection: image("cell reflection", LIT_COLOR, cells)?,
                cell_surface: image("cell surface", LIT_COLOR, cells)?,
                ends: image("ends", ENDS, if stores_ends { setup.extent } else { [1, 1] })?,
            },
        })
    }

    /// The images between the passes, for the passes that follow lost rays and for tests.
    pub fn images(&self) -> &GlossImages {
        &self.images
    }

    /// Records pass "trace/narrow", which traces one ray for each pixel with a narrow lobe.
    pub fn trace_narrow(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        let UnifiedGlossInput { gbuffer, pyramid, tiles, lost_rays, triangle_bindings, .. } = input;
        let program = TraceNarrow {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            screen_resources: lost_rays.screen_resources(gbuffer, *pyramid),
            color_chain: Some(gbuffer.coarse_colors()),
            lost_ray_resources: lost_rays.resources(),
            ends_image: self.images.ends.all(),
            ray_structure: triangle_bindings.and_then(|bindings| bindings.triangles.structure),
            triangle_resources: triangle_bindings.map(|bindings| bindings.resources()),
        };
        let targets = [tiles.target(&self.images.records)];
        self.trace_narrow.run(frame, "trace/narrow", (parameters, *tiles), targets, &program)
    }

    /// Records pass "resolve/narrow", which makes each pixel's reflection from the rays of the 3 × 3 pixels around it.
    pub fn resolve_narrow(
        &self,
        frame: &mut Frame,
        input: &UnifiedGlossInput,
        parameters: &UnifiedBlock,
    ) -> Result<()> {
        let UnifiedGlossInput { gbuffer, tiles, canvas, lost_rays, .. } = input;
        let program = ResolveNarrow {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            material_buffer: gbuffer.material.all(),
            color_texels: gbuffer.color.level(0),
            seen_image: self.images.records.all(),
            lost_counts: lost_rays.counts,
            doubts: lost_rays.rays,
        };
        let targets = canvas.targets(*tiles);
        self.resolve_narrow.run(frame, "resolve/narrow", (parameters, *tiles), targets, &program)
    }

    /// Records pass "trace/wide", which traces one ray for each cell with a wide lobe.
    pub fn trace_wide(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        let UnifiedGlossInput { gbuffer, pyramid, tiles, lost_rays, triangle_bindings, .. } = input;
        let GlossImages { place, seen, .. } = &self.images;
        let program = TraceWide {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            screen_resources: lost_rays.screen_resources(gbuffer, *pyramid),
            color_chain: Some(gbuffer.coarse_colors()),
            lost_ray_resources: lost_rays.resources(),
            ends_image: self.images.ends.all(),
            ray_structure: triangle_bindings.and_then(|bindings| bindings.triangles.structure),
            triangle_resources: triangle_bindings.map(|bindings| bindings.resources()),
        };
        let targets = [place, seen].map(|image| tiles.target(image));
        self.trace_wide.run(frame, "trace/wide", (parameters, *tiles), targets, &program)
    }

    /// Records passes "cells" and "resolve/wide", the second of which interpolates each pixel's reflection between the
    /// reflections of the four cells around it.
    pub fn resolve_wide(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        self.record_cells(frame, input, parameters)?;
        let UnifiedGlossInput { gbuffer, pyramid, tiles, canvas, lost_rays, .. } = input;
        let GlossImages { cell_reflection, cell_surface, .. } = &self.images;
        let program = ResolveWide {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            pyramid: pyramid.0.all(),
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_texels: gbuffer.color.level(0),
            cell_reflection: cell_reflection.all(),
            cell_surface: cell_surface.all(),
            listed_image: tiles.listed.all(),
            lost_counts: lost_rays.counts,
            doubts: lost_rays.rays,
        };
        let targets = canvas.targets(*tiles);
        self.resolve_wide.run(frame, "resolve/wide", (parameters, *tiles), targets, &program)
    }

    /// Records pass "cells", which makes each cell's reflection from the rays of the 5 × 5 cells around it.
    fn record_cells(&self, frame: &mut Frame, input: &UnifiedGlossInput, parameters: &UnifiedBlock) -> Result<()> {
        let UnifiedGlossInput { gbuffer, pyramid, tiles, .. } = input;
        let GlossImages { place, seen, cell_reflection, cell_surface, .. } = &self.images;
        let program = Cells {
            unified: parameters,
            Tiles: Some(tiles.lists),
            Counts: Some(tiles.arguments),
            pyramid: pyramid.0.all(),
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            place_image: place.all(),
            seen_image: seen.all(),
            listed_image: tiles.listed.all(),
        };
        let targets = [cell_reflection, cell_surface].map(|image| tiles.target(image));
        self.cells.run(frame, "cells", (parameters, *tiles), targets, &program)
    }
}
