//! The trace of `unified`: one ray for each mirror pixel over the pyramid, its hit's colour, and the
//! composite in the same pass, over the tiles of a list or over the whole image. What does not reflect
//! is copied.

use super::{Canvas, GBuffer, HITS, Hits, Pyramid, TileList, Tiles};
use crate::error::{Error, Result};
use crate::gpu::shader::{
    TileListBlock, UNIFIED_MIRROR_FRAG, UNIFIED_MIRROR_HITS_FRAG, UNIFIED_MIRROR_WHOLE_FRAG, UNIFIED_TILE_VERT,
    UnifiedBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, Resource, Target};
use ash::vk;

const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Pixels along a side of a tile: `TILE` of `tiles.glsl`.
const TILE: f32 = 8.0;

/// Pipeline and images of one size.
pub struct UnifiedTracePass {
    /// Over the tiles of a list.
    mirror: GraphicsPipeline,
    /// Over the whole image, for one of several lists.
    everywhere: GraphicsPipeline,
    /// Over the whole image, for all that reflects, without hits.
    whole: Option<GraphicsPipeline>,
    hits: Option<Image>,
}

/// What the pass reads.
#[derive(Clone, Copy)]
pub struct UnifiedTraceInput<'a> {
    /// Normals, materials and lit colour.
    pub gbuffer: GBuffer<'a>,
    /// Blocks to trace.
    pub pyramid: Pyramid<'a>,
    /// Where to trace; everywhere if `None`.
    pub tiles: Option<Tiles<'a>>,
    /// Where to draw.
    pub canvas: Canvas<'a>,
}

impl UnifiedTracePass {
    /// For images of a size in pixels. `reflection` says whether the canvases will have one; `hits`, which
    /// need it, asks for them beside the image.
    ///
    /// # Errors
    /// [`Error::NoDevice`] on a device that draws no points of a tile's size.
    pub fn new(gpu: &Gpu, extent: [u32; 2], reflection: bool, hits: bool) -> Result<Self> {
        if gpu.largest_point() < TILE {
            let (name, largest) = (&gpu.info().name, gpu.largest_point());
            return Err(Error::NoDevice(format!(
                "`unified` draws points of {TILE} pixels; {name} has none above {largest}"
            )));
        }
        let (shader, formats) = if hits {
            (&UNIFIED_MIRROR_HITS_FRAG, &[COLOR, COLOR, HITS][..])
        } else {
            (&UNIFIED_MIRROR_FRAG, &[COLOR; 2][..1 + usize::from(reflection)])
        };
        Ok(Self {
            mirror: GraphicsPipeline::points(gpu, &UNIFIED_TILE_VERT, shader, formats)?,
            everywhere: GraphicsPipeline::fullscreen(gpu, shader, formats)?,
            whole: (!hits)
                .then(|| GraphicsPipeline::fullscreen(gpu, &UNIFIED_MIRROR_WHOLE_FRAG, formats))
                .transpose()?,
            hits: hits.then(|| Image::target(gpu, "hits", HITS, extent)).transpose()?,
        })
    }

    /// Passes "composite", which takes the lit colour over, and "trace/mirrors"; where all that reflects
    /// is to be traced, the single pass "trace+composite". Gives where each ray ended, if that was asked
    /// for.
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        input: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
    ) -> Result<Option<Hits<'a>>> {
        let (gbuffer, canvas) = (&input.gbuffer, input.canvas);
        let mut resources = vec![
            ("unified", Resource::Uniform(bytemuck::bytes_of(parameters))),
            ("pyramid", Resource::Loaded(input.pyramid.0.all())),
            ("normal_buffer", Resource::nearest(gbuffer.normal.all())),
            ("material_buffer", Resource::nearest(gbuffer.material.all())),
            ("color_buffer", Resource::trilinear(gbuffer.color.level(0))),
        ];
        let hits = self.hits.as_ref();
        if let (None, Some(whole)) = (input.tiles, &self.whole) {
            let targets: Vec<_> = canvas.images().map(|i| Target::overwrite(i.all())).collect();
            frame.fullscreen("trace+composite", whole, &targets, &resources, &[])?;
            return Ok(None);
        }
        let (color, composite) = (gbuffer.color, canvas.composite);
        if color.format() == composite.format() {
            frame.copy("composite", color.level(0), composite.all())?;
        } else {
            // A blit converts: the precision study hands over 32-bit floats.
            frame.blit("composite", color.level(0), composite.all())?;
        }
        let mut targets = vec![Target::kept(canvas.composite.all())];
        targets.extend(canvas.reflection.map(|i| Target::cleared(i.all(), [0.0; 4])));
        targets.extend(hits.map(|h| Target::cleared(h.all(), [-1.0, -1.0, -1.0, 0.0])));
        let (name, list) = ("trace/mirrors", TileList::Mirrors);
        let push = TileListBlock { list: list as i32 };
        let push = bytemuck::bytes_of(&push);
        match input.tiles {
            Some(tiles) => {
                resources.push(("Tiles", Resource::ReadBuffer(tiles.lists)));
                let arguments = (tiles.arguments, list.arguments_offset());
                frame.draw_indirect(name, &self.mirror, &targets, &resources, push, arguments)?;
            }
            None => frame.fullscreen(name, &self.everywhere, &targets, &resources, push)?,
        }
        Ok(hits.map(Hits))
    }
}
