//! Drawing over tiles: the lists of them by kind of reflector that the classification writes, and programs that are
//! drawn over the tiles of a list, or over the whole image where that is known to be what the list would cover.

use super::LIT_COLOR;
use crate::error::{Error, Result};
use crate::gpu::program::Fragment;
use crate::gpu::programs::Tile;
use crate::gpu::shader::{TileListBlock, UnifiedBlock};
use crate::gpu::{Buffer, Frame, Gpu, GraphicsPipeline, Image, Target};
use crate::math::OracleVersion;
use crate::math::constants::TILE_SIDE;
use ash::vk;

/// Pixels along a side of a tile.
pub const TILE: u32 = TILE_SIDE as u32;

/// Tiles along each side of an image of a size in pixels.
pub fn count(extent: [u32; 2]) -> [u32; 2] {
    extent.map(|side| side.div_ceil(TILE))
}

/// What the passes of `unified` are made for.
#[derive(Debug, Clone, Copy)]
pub struct UnifiedSetup {
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// Log2 of the columns to a strip of the pyramid's image (`passes::pyramid::strip`).
    pub strip: u32,
    /// Which version of the oracle says what is hit.
    pub oracle: OracleVersion,
    /// Whether another reflection shows where this one misses.
    pub over: bool,
    /// Whether the composite is wanted.
    pub composite: bool,
    /// Whether the reflection is wanted as an image of its own. One of the two is.
    pub reflection: bool,
    /// Whether rays that the screen loses go on in captures.
    pub followed: bool,
    /// Whether the sky is looked up along rays, where it is known.
    pub sky: bool,
}

impl UnifiedSetup {
    /// Formats of the images that are drawn into, as [`Canvas`](super::Canvas) has them.
    pub fn formats(&self) -> [vk::Format; 2] {
        let both = self.composite && self.reflection;
        [LIT_COLOR, if both { LIT_COLOR } else { vk::Format::UNDEFINED }]
    }
}

/// Tiles by the kinds of reflector in them, as lists with the arguments of an indirect draw over each.
#[derive(Clone, Copy)]
pub struct Tiles<'a> {
    /// Nothing was classified: all that reflects is of one kind, and it is drawn over the whole image.
    pub whole: bool,
    /// The lists: for each of them room for every tile's word.
    pub lists: &'a Buffer,
    /// For each tile a bit for each list that it stands on.
    pub listed: &'a Image,
    /// For each list those of a `VkDrawIndirectCommand`.
    pub arguments: &'a Buffer,
}

impl Tiles<'_> {
    /// A target that keeps what it holds where no tile is drawn; drawn over whole, it held nothing.
    pub fn target<'i>(&self, image: &'i Image) -> Target<'i> {
        if self.whole { Target::overwrite(image.all()) } else { Target::kept(image.all()) }
    }

    /// A target that holds a value where no tile is drawn.
    pub fn target_in<'i>(&self, image: &'i Image, elsewhere: [f32; 4]) -> Target<'i> {
        if self.whole { Target::overwrite(image.all()) } else { Target::cleared(image.all(), elsewhere) }
    }
}

/// A fragment program that is drawn over the tiles of a list or over the whole image.
pub struct TiledPipeline<F> {
    list: i32,
    tiles: GraphicsPipeline<F, Tile<'static>>,
    whole: GraphicsPipeline<F>,
}

impl<F: Fragment> TiledPipeline<F> {
    /// For a list, `MIRROR_LIST`, `NARROW_LIST` or `WIDE_LIST`, by the program's constants for the tiles and for the
    /// whole image.
    ///
    /// # Errors
    /// [`Error::NoDevice`] on a device that draws no points of a tile's size.
    pub fn new(
        gpu: &Gpu,
        list: i32,
        formats: impl Fn() -> F::Outputs<vk::Format>,
        constants: impl Fn(bool) -> F::Constants,
    ) -> Result<Self> {
        if gpu.largest_point() < TILE as f32 {
            let (name, largest) = (&gpu.info().name, gpu.largest_point());
            return Err(Error::NoDevice(format!(
                "`unified` draws points of {TILE} pixels; {name} has none above {largest}"
            )));
        }
        Ok(Self {
            list,
            tiles: GraphicsPipeline::points(gpu, formats(), &constants(false))?,
            whole: GraphicsPipeline::fullscreen_with(gpu, formats(), &constants(true))?,
        })
    }

    /// One pass over the list's tiles, or over the whole image, where every texel is written. `halved` says that the
    /// targets have a texel for 2 × 2 pixels.
    pub fn draw(
        &self,
        frame: &mut Frame,
        name: &str,
        targets: F::Outputs<Target>,
        program: &F,
        (parameters, tiles, halved): (&UnifiedBlock, Tiles, bool),
    ) -> Result<()> {
        if tiles.whole {
            return frame.fullscreen(name, &self.whole, targets, program);
        }
        let tile_list = TileListBlock { list: self.list, halve: i32::from(halved) };
        let vertices = Tile { unified: parameters, Tiles: tiles.lists, tile_list: &tile_list };
        let arguments = (tiles.arguments, size_of::<vk::DrawIndirectCommand>() as u64 * self.list as u64);
        frame.draw_indirect(name, &self.tiles, targets, (program, &vertices), arguments)
    }
}
