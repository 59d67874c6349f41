//! Drawing over tiles: the lists of them by kind of reflector that the classification writes, and passes
//! that are drawn over a list where only parts of an image need them.

use crate::error::{Error, Result};
use crate::gpu::shader::{Shader, TileListBlock, UNIFIED_TILE_VERT};
use crate::gpu::{Buffer, Frame, Gpu, GraphicsPipeline, Image, Resource, Target};
use ash::vk;

/// Pixels along a side of a tile: `TILE` of `tiles.glsl`.
pub const TILE: u32 = 16;

/// Lists that the classification writes: `LISTS` of `tiles.glsl`.
pub const LISTS: u64 = 3;

/// Tiles along each side of an image of a size in pixels.
pub fn count(extent: [u32; 2]) -> [u32; 2] {
    extent.map(|side| side.div_ceil(TILE))
}

/// Tiles by the kinds of reflector in them, as lists with the arguments of an indirect draw over each
/// (`shaders-glsl/unified/tiles.glsl`).
#[derive(Clone, Copy)]
pub struct Tiles<'a> {
    /// The lists: for each of them room for every tile's word.
    pub lists: &'a Buffer,
    /// For each tile a bit for each list that it stands on.
    pub listed: &'a Image,
    /// For each list those of a `VkDrawIndirectCommand`.
    pub arguments: &'a Buffer,
}

/// A list of [`Tiles`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TileList {
    /// Tiles with mirrors.
    Mirrors = 0,
    /// Tiles with narrow lobes.
    Narrow = 1,
    /// Tiles with wide lobes.
    Wide = 2,
}

/// A fragment shader that is drawn over the tiles of a list, and one that is drawn over the whole image
/// where that is known to be what the list would cover.
pub struct TiledPipeline {
    list: TileList,
    tiles: GraphicsPipeline,
    /// None for a pass that has tiles always.
    whole: Option<GraphicsPipeline>,
}

/// What [`TiledPipeline::draw`] draws into.
#[derive(Clone, Copy)]
pub struct TiledTarget<'a> {
    /// The image.
    pub image: &'a Image,
    /// What it holds where no tile is drawn; `None`: what it held.
    pub elsewhere: Option<[f32; 4]>,
}

impl TiledPipeline {
    /// From the shaders of both ways to draw; they have the same bindings, and the same specialization constants
    /// (of [`GraphicsPipeline::fullscreen_with`]).
    ///
    /// # Errors
    /// [`Error::NoDevice`] on a device that draws no points of a tile's size.
    pub fn new(
        gpu: &Gpu,
        list: TileList,
        tiles: &'static Shader,
        whole: Option<&'static Shader>,
        formats: &[vk::Format],
        constants: &[i32],
    ) -> Result<Self> {
        if gpu.largest_point() < TILE as f32 {
            let (name, largest) = (&gpu.info().name, gpu.largest_point());
            return Err(Error::NoDevice(format!(
                "`unified` draws points of {TILE} pixels; {name} has none above {largest}"
            )));
        }
        Ok(Self {
            list,
            tiles: GraphicsPipeline::points(gpu, &UNIFIED_TILE_VERT, tiles, formats, constants)?,
            whole: whole
                .map(|shader| GraphicsPipeline::fullscreen_with(gpu, shader, formats, constants))
                .transpose()?,
        })
    }

    /// One pass, over the list's tiles; without them over the whole image, where every texel is written.
    /// `halved` says that the targets have a texel for 2 x 2 pixels.
    ///
    /// # Errors
    /// [`Error::Usage`] for a pass that has tiles always, without them.
    pub fn draw(
        &self,
        frame: &mut Frame,
        name: &str,
        targets: &[TiledTarget],
        resources: &[(&str, Resource)],
        tiles: Option<Tiles>,
        halved: bool,
    ) -> Result<()> {
        if let (None, Some(whole)) = (tiles, &self.whole) {
            let targets: Vec<_> = targets.iter().map(|t| Target::overwrite(t.image.all())).collect();
            return frame.fullscreen(name, whole, &targets, resources, &[]);
        }
        let tiles = tiles.ok_or_else(|| Error::Usage(format!("{name} is drawn over tiles only, and has none")))?;
        let push = TileListBlock { list: self.list as i32, halve: i32::from(halved) };
        let targets: Vec<_> = targets
            .iter()
            .map(|t| t.elsewhere.map_or(Target::kept(t.image.all()), |value| Target::cleared(t.image.all(), value)))
            .collect();
        let resources: Vec<_> =
            resources.iter().copied().chain([("Tiles", Resource::ReadBuffer(tiles.lists))]).collect();
        let arguments = (tiles.arguments, size_of::<vk::DrawIndirectCommand>() as u64 * self.list as u64);
        frame.draw_indirect(name, &self.tiles, &targets, &resources, bytemuck::bytes_of(&push), arguments)
    }
}
