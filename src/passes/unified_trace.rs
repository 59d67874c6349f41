//! The trace of `unified`: one ray for each mirror pixel over the pyramid, its hit's colour, and the
//! composite in the same pass, over the tiles of a list or over the whole image. What does not reflect
//! is copied.

use super::{GBuffer, Hits, Pyramid, Reflection, TileList, Tiles};
use crate::error::{Error, Result};
use crate::gpu::shader::{
    TileListBlock, UNIFIED_MIRROR_FRAG, UNIFIED_MIRROR_HITS_FRAG, UNIFIED_MIRROR_WHOLE_FRAG, UNIFIED_TILE_VERT,
    UnifiedBlock,
};
use crate::gpu::{Frame, Gpu, GraphicsPipeline, Image, ImageDesc, Resource, Target};
use ash::vk;

const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const HITS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

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
    reflection: Image,
    composite: Image,
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
}

/// What the pass made.
#[derive(Clone, Copy)]
pub struct Traced<'a> {
    /// Reflection colour and fade.
    pub reflection: Reflection<'a>,
    /// The finished image, linear.
    pub composite: &'a Image,
    /// Where each ray ended, if asked for.
    pub hits: Option<Hits<'a>>,
}

impl UnifiedTracePass {
    /// For images of a size in pixels; `hits` asks for them beside the image.
    ///
    /// # Errors
    /// [`Error::NoDevice`] on a device that draws no points of a tile's size.
    pub fn new(gpu: &Gpu, extent: [u32; 2], hits: bool) -> Result<Self> {
        if gpu.largest_point() < TILE {
            let (name, largest) = (&gpu.info().name, gpu.largest_point());
            return Err(Error::NoDevice(format!(
                "`unified` draws points of {TILE} pixels; {name} has none above {largest}"
            )));
        }
        use vk::ImageUsageFlags as U;
        let image = |name, format| {
            let usage = U::COLOR_ATTACHMENT | U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
            Image::new(gpu, &ImageDesc { name, format, extent, levels: 1, layers: 1, usage })
        };
        let (shader, formats) = if hits {
            (&UNIFIED_MIRROR_HITS_FRAG, &[COLOR, COLOR, HITS][..])
        } else {
            (&UNIFIED_MIRROR_FRAG, &[COLOR, COLOR][..])
        };
        Ok(Self {
            mirror: GraphicsPipeline::points(gpu, &UNIFIED_TILE_VERT, shader, formats)?,
            everywhere: GraphicsPipeline::fullscreen(gpu, shader, formats)?,
            whole: (!hits)
                .then(|| GraphicsPipeline::fullscreen(gpu, &UNIFIED_MIRROR_WHOLE_FRAG, formats))
                .transpose()?,
            reflection: image("reflection", COLOR)?,
            composite: image("composite", COLOR)?,
            hits: hits.then(|| image("hits", HITS)).transpose()?,
        })
    }

    /// Passes "composite", which takes the lit colour over, and one of "trace/…" for each list. At least
    /// one list is needed. One list everywhere is a single pass,
    /// "trace+composite".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        input: &UnifiedTraceInput,
        parameters: &UnifiedBlock,
        lists: &[TileList],
    ) -> Result<Traced<'a>> {
        let mut resources = vec![
            ("unified", Resource::Uniform(bytemuck::bytes_of(parameters))),
            ("pyramid", Resource::Loaded(input.pyramid.0.all())),
            ("normal_buffer", Resource::nearest(input.gbuffer.normal.all())),
            ("material_buffer", Resource::nearest(input.gbuffer.material.all())),
            ("color_buffer", Resource::trilinear(input.gbuffer.color.level(0))),
        ];
        let traced = Traced {
            reflection: Reflection(&self.reflection),
            composite: &self.composite,
            hits: self.hits.as_ref().map(Hits),
        };
        if let (None, [_], Some(whole)) = (input.tiles, lists, &self.whole) {
            let targets = [&self.reflection, &self.composite].map(|i| Target::overwrite(i.all()));
            frame.fullscreen("trace+composite", whole, &targets, &resources, &[])?;
            return Ok(traced);
        }
        resources.extend(input.tiles.map(|tiles| ("Tiles", Resource::ReadBuffer(tiles.lists))));
        frame.copy("composite", input.gbuffer.color.level(0), self.composite.all())?;
        for (n, list) in lists.iter().enumerate() {
            let cleared = |image: &'a Image, value| {
                if n == 0 { Target::cleared(image.all(), value) } else { Target::kept(image.all()) }
            };
            let mut targets = vec![cleared(&self.reflection, [0.0; 4]), Target::kept(self.composite.all())];
            targets.extend(self.hits.as_ref().map(|h| cleared(h, [-1.0, -1.0, -1.0, 0.0])));
            let push = TileListBlock { list: *list as i32 };
            let push = bytemuck::bytes_of(&push);
            match input.tiles {
                Some(tiles) => {
                    let arguments = (tiles.arguments, list.arguments_offset());
                    frame.draw_indirect(pass_name(*list), &self.mirror, &targets, &resources, push, arguments)?;
                }
                None => frame.fullscreen(pass_name(*list), &self.everywhere, &targets, &resources, push)?,
            }
        }
        Ok(traced)
    }
}

fn pass_name(list: TileList) -> &'static str {
    match list {
        TileList::Mirrors => "trace/mirrors",
        TileList::Glossy => "trace/glossy",
    }
}
