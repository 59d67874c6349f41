//! The glossy path of `unified`: rays interleaved over blocks of pixels, and every pixel's reflection
//! gathered from its neighbours' hits (NUMERICS, "Gloss"). A ray a pixel for narrow lobes, one for four
//! pixels for wide ones; which of the two a pixel is says its roughness alone.

use super::tiles::{TileList, TiledPipeline, TiledTarget, Tiles};
use super::{Canvas, GBuffer, LIT_COLOR, Pyramid};
use crate::error::Result;
use crate::gpu::shader::{
    Shader, UNIFIED_GLOSS_CELLS_ANY_NORMALS_FRAG, UNIFIED_GLOSS_CELLS_FRAG, UNIFIED_GLOSS_CELLS_WHOLE_FRAG,
    UNIFIED_GLOSS_NARROW_ANY_NORMALS_FRAG, UNIFIED_GLOSS_NARROW_FRAG, UNIFIED_GLOSS_RESOLVE_ANY_NORMALS_FRAG,
    UNIFIED_GLOSS_RESOLVE_FRAG, UNIFIED_GLOSS_RESOLVE_NARROW_FRAG, UNIFIED_GLOSS_RESOLVE_NARROW_WHOLE_FRAG,
    UNIFIED_GLOSS_RESOLVE_WHOLE_FRAG, UNIFIED_GLOSS_WIDE_ANY_NORMALS_FRAG, UNIFIED_GLOSS_WIDE_FRAG, UnifiedBlock,
};
use crate::gpu::{Frame, Gpu, Image, ImageDesc, Resource};
use ash::vk;

const RECORD: vk::Format = vk::Format::R32G32B32A32_UINT;
const PLACE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The shaders of a pass over tiles and over the whole image.
type Shaders = (&'static Shader, Option<&'static Shader>);

/// Of each pass, for normals of the G-buffer's own format, in the order of [`UnifiedGlossPass`].
const SHADERS: [Shaders; 5] = [
    (&UNIFIED_GLOSS_NARROW_FRAG, Some(&UNIFIED_GLOSS_NARROW_FRAG)),
    (&UNIFIED_GLOSS_RESOLVE_NARROW_FRAG, Some(&UNIFIED_GLOSS_RESOLVE_NARROW_WHOLE_FRAG)),
    (&UNIFIED_GLOSS_WIDE_FRAG, Some(&UNIFIED_GLOSS_WIDE_FRAG)),
    (&UNIFIED_GLOSS_CELLS_FRAG, Some(&UNIFIED_GLOSS_CELLS_WHOLE_FRAG)),
    (&UNIFIED_GLOSS_RESOLVE_FRAG, Some(&UNIFIED_GLOSS_RESOLVE_WHOLE_FRAG)),
];

/// As [`SHADERS`], for normals of any format, over tiles alone.
const SHADERS_ANY_NORMALS: [Shaders; 5] = [
    (&UNIFIED_GLOSS_NARROW_ANY_NORMALS_FRAG, None),
    (&UNIFIED_GLOSS_RESOLVE_NARROW_FRAG, None),
    (&UNIFIED_GLOSS_WIDE_ANY_NORMALS_FRAG, None),
    (&UNIFIED_GLOSS_CELLS_ANY_NORMALS_FRAG, None),
    (&UNIFIED_GLOSS_RESOLVE_ANY_NORMALS_FRAG, None),
];

/// Pipelines and images of one size.
pub struct UnifiedGlossPass {
    narrow: TiledPipeline,
    resolve_narrow: TiledPipeline,
    wide: TiledPipeline,
    cells: TiledPipeline,
    resolve: TiledPipeline,
    any_normals: bool,
    /// What each pixel's ray saw: `gloss_record.glsl`.
    records: Image,
    /// Where the ray of each cell of 2 × 2 pixels ended, and what it saw.
    seen: [Image; 2],
    /// Each cell's reflection, and the surface that it is of.
    resolved: [Image; 2],
}

impl UnifiedGlossPass {
    /// For images of a size in pixels; `reflection` says whether the canvases will have one, `constants` are those
    /// of `parameters.glsl`. With `any_normals`, for studies, normals may have any format, and there must be tiles.
    ///
    /// # Errors
    /// As [`TiledPipeline::new`].
    pub fn new(gpu: &Gpu, extent: [u32; 2], reflection: bool, any_normals: bool, constants: &[i32]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |name, format, extent| {
            let usage = U::COLOR_ATTACHMENT | U::STORAGE | U::SAMPLED | U::TRANSFER_SRC;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        let pipeline = |list, (tiles, whole): Shaders, formats: &[vk::Format]| {
            TiledPipeline::new(gpu, list, tiles, whole, formats, constants)
        };
        let cells_extent = extent.map(|n| n.div_ceil(2));
        let drawn = &[LIT_COLOR; 2][..1 + usize::from(reflection)];
        let [narrow, resolve_narrow, wide, cells, resolve] = if any_normals { SHADERS_ANY_NORMALS } else { SHADERS };
        Ok(Self {
            narrow: pipeline(TileList::Narrow, narrow, &[RECORD])?,
            resolve_narrow: pipeline(TileList::Narrow, resolve_narrow, drawn)?,
            wide: pipeline(TileList::Wide, wide, &[PLACE, LIT_COLOR])?,
            cells: pipeline(TileList::Wide, cells, &[LIT_COLOR; 2])?,
            resolve: pipeline(TileList::Wide, resolve, drawn)?,
            any_normals,
            records: image("seen", RECORD, extent)?,
            seen: [image("seen place", PLACE, cells_extent)?, image("seen color", LIT_COLOR, cells_extent)?],
            resolved: [
                image("cell reflection", LIT_COLOR, cells_extent)?,
                image("cell surface", LIT_COLOR, cells_extent)?,
            ],
        })
    }

    /// What the passes hand each other, for whoever checks one of them by itself: the narrow lobes' rays, the wide
    /// ones' places and colours, and the cells' reflections and surfaces.
    pub fn between(&self) -> [&Image; 5] {
        let ([place, color], [reflection, surface]) = (&self.seen, &self.resolved);
        [&self.records, place, color, reflection, surface]
    }

    /// Passes "trace/narrow" and "resolve/narrow", and "trace/wide", "cells" and "resolve/wide", those that the
    /// frame's materials need. The colour's chain is there. Over `tiles` the canvas has begun; without them
    /// it holds nothing, and all that reflects has lobes of one kind.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        pyramid: Pyramid,
        parameters: &UnifiedBlock,
        canvas: Canvas<'a>,
        tiles: Option<Tiles<'a>>,
    ) -> Result<()> {
        let color = gbuffer.color;
        let block = ("unified", Resource::Uniform(bytemuck::bytes_of(parameters)));
        let normal = ("normal_buffer", gbuffer.unified_normals(self.any_normals));
        let material = ("material_buffer", Resource::Loaded(gbuffer.material.all()));
        let pyramid = ("pyramid", Resource::Loaded(pyramid.0.all()));
        let traced = [block, pyramid, normal, material, ("color_buffer", Resource::trilinear(color.all()))];
        let shown = [block, pyramid, normal, material, ("color_buffer", Resource::nearest(color.level(0)))];
        let loaded = |name, image: &'a Image| (name, Resource::Loaded(image.all()));
        // Where no tile is drawn, images hold anything: neighbours on a listed tile ask for more than they hold.
        let into = |image: &'a Image| TiledTarget { image, elsewhere: None };
        let canvas: Vec<_> = canvas.images().map(into).collect();
        let listed = tiles.map(|t| loaded("listed_image", t.listed));

        if gbuffer.reflectors.narrow {
            self.narrow.draw(frame, "trace/narrow", &[into(&self.records)], &traced, tiles, false)?;
            let [block, _, _, material, color] = shown;
            let resources = [block, material, color, loaded("seen_image", &self.records)];
            self.resolve_narrow.draw(frame, "resolve/narrow", &canvas, &resources, tiles, false)?;
        } else {
            for pass in ["trace/narrow", "resolve/narrow"] {
                frame.skip(pass, "no material that is drawn has a narrow lobe");
            }
        }
        if gbuffer.reflectors.wide {
            self.wide.draw(frame, "trace/wide", &self.seen.each_ref().map(into), &traced, tiles, true)?;
            let seen = [loaded("place_image", &self.seen[0]), loaded("seen_image", &self.seen[1])];
            let resources: Vec<_> = [block, pyramid, normal, material].into_iter().chain(seen).chain(listed).collect();
            self.cells.draw(frame, "cells", &self.resolved.each_ref().map(into), &resources, tiles, true)?;
            let [reflection, surface] = &self.resolved;
            let cells = [loaded("cell_reflection", reflection), loaded("cell_surface", surface)];
            let resources: Vec<_> = shown.into_iter().chain(cells).chain(listed).collect();
            self.resolve.draw(frame, "resolve/wide", &canvas, &resources, tiles, false)?;
        } else {
            for pass in ["trace/wide", "cells", "resolve/wide"] {
                frame.skip(pass, "no material that is drawn has a wide lobe");
            }
        }
        Ok(())
    }
}
