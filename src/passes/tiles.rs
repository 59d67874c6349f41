//! Work over tiles: the lists of them by kind of reflector that the classification writes, and programs that run over
//! the tiles of a list, or over the whole image where that is known to be what the list would cover. Each is there as a
//! fragment program and as a compute program, which make the same images.

use super::LIT_COLOR;
use crate::error::{Error, Result};
use crate::gpu::program::{Compute, Fragment};
use crate::gpu::programs::Tile;
use crate::gpu::shader::{TileListBlock, UnifiedBlock};
use crate::gpu::{Buffer, ComputePipeline, Frame, Gpu, GraphicsPipeline, Image, Target};
use crate::math::OracleVersion;
use crate::math::constants::{LISTS, TILE_SIDE};
use crate::parameter::choices;
use ash::vk;

choices! {
    /// The stage of a device in which a program over tiles runs.
    pub enum TileStage {
        /// Fragment shaders, drawn over tiles as points or over the whole image.
        Fragment = "fragment",
        /// Compute shaders, in workgroups over tiles or over the whole image.
        Compute = "compute",
    }
}

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
    /// Where rays are traced.
    pub trace: TileStage,
    /// Where they are gathered.
    pub resolve: TileStage,
}

impl UnifiedSetup {
    /// Formats of the images that are drawn into, as [`Canvas`](super::Canvas) has them.
    pub fn formats(&self) -> [vk::Format; 2] {
        [LIT_COLOR, if self.beside() { LIT_COLOR } else { vk::Format::UNDEFINED }]
    }

    /// Whether the reflection is wanted beside the composite.
    pub fn beside(&self) -> bool {
        self.composite && self.reflection
    }

    /// Whether what is shown is written by compute programs, so that its images are stored to.
    pub fn stores(&self) -> bool {
        self.trace == TileStage::Compute || self.resolve == TileStage::Compute
    }
}

/// Bytes of the arguments of indirect draws and dispatches over the lists (`parameters.glsl`): a draw for each, and two
/// dispatches.
pub const ARGUMENT_BYTES: u64 = LISTS as u64 * (DRAW_BYTES + 2 * DISPATCH_BYTES);

const DRAW_BYTES: u64 = size_of::<vk::DrawIndirectCommand>() as u64;
const DISPATCH_BYTES: u64 = size_of::<vk::DispatchIndirectCommand>() as u64;

/// Tiles by the kinds of reflector in them, as lists with the arguments of indirect draws and dispatches over each.
#[derive(Clone, Copy)]
pub struct Tiles<'a> {
    /// Nothing was classified: all that reflects is of one kind, and it is drawn over the whole image.
    pub whole: bool,
    /// The lists: for each of them room for every tile's word.
    pub lists: &'a Buffer,
    /// For each tile a bit for each list that it stands on.
    pub listed: &'a Image,
    /// For each list those of a `VkDrawIndirectCommand`; then for each list those of two `VkDispatchIndirectCommand`, over
    /// pixels and over blocks of 2 × 2.
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

/// What a program over tiles works on.
#[derive(Debug, Clone, Copy)]
pub struct Over {
    /// `MIRROR_LIST`, `NARROW_LIST` or `WIDE_LIST`.
    pub list: i32,
    /// Whether the images that it writes have a texel for 2 × 2 pixels.
    pub halved: bool,
}

/// A program that runs over the tiles of a list or over the whole image: `F` in fragment shaders or `C` in compute
/// shaders.
pub struct TiledPipeline<F, C> {
    over: Over,
    made: Made<F, C>,
}

/// The pipelines of the one stage that was chosen.
enum Made<F, C> {
    Fragment { tiles: GraphicsPipeline<F, Tile<'static>>, whole: GraphicsPipeline<F> },
    Compute { tiles: ComputePipeline<C>, whole: ComputePipeline<C> },
}

impl<F: Fragment, C: Compute> TiledPipeline<F, C> {
    /// In fragment shaders, by the program's constants for the tiles (`false`) and for the whole image.
    ///
    /// # Errors
    /// [`Error::NoDevice`] on a device that draws no points of a tile's size.
    fn drawn(
        gpu: &Gpu,
        over: Over,
        formats: impl Fn() -> F::Outputs<vk::Format>,
        constants: impl Fn(bool) -> F::Constants,
    ) -> Result<Self> {
        if gpu.largest_point() < TILE as f32 {
            let (name, largest) = (&gpu.info().name, gpu.largest_point());
            return Err(Error::NoDevice(format!(
                "`unified` draws points of {TILE} pixels; {name} has none above {largest}, but it may run compute \
                 shaders instead: the parameters trace-stage and resolve-stage say so"
            )));
        }
        let tiles = GraphicsPipeline::points(gpu, formats(), &constants(false))?;
        let whole = GraphicsPipeline::fullscreen_with(gpu, formats(), &constants(true))?;
        Ok(Self { over, made: Made::Fragment { tiles, whole } })
    }

    /// In compute shaders, the same.
    fn dispatched(gpu: &Gpu, over: Over, constants: impl Fn(bool) -> C::Constants) -> Result<Self> {
        let tiles = ComputePipeline::with(gpu, &constants(false))?;
        let whole = ComputePipeline::with(gpu, &constants(true))?;
        Ok(Self { over, made: Made::Compute { tiles, whole } })
    }

    /// In a stage. The constants are those for the tiles (`false`) and for the whole image.
    ///
    /// # Errors
    /// [`Error::NoDevice`] for fragment shaders on a device that draws no points of a tile's size, and on one whose
    /// shaders take fewer images than the program has.
    pub fn new(
        gpu: &Gpu,
        (stage, over): (TileStage, Over),
        formats: impl Fn() -> F::Outputs<vk::Format>,
        fragment: impl Fn(bool) -> F::Constants,
        compute: impl Fn(bool) -> C::Constants,
    ) -> Result<Self> {
        match stage {
            TileStage::Fragment => Self::drawn(gpu, over, formats, fragment),
            TileStage::Compute => Self::dispatched(gpu, over, compute),
        }
    }

    /// One pass over the list's tiles, or over the whole image, where every texel is written: the program of the stage
    /// that was chosen.
    pub fn run<'t>(
        &self,
        frame: &mut Frame,
        name: &str,
        (parameters, tiles): (&UnifiedBlock, Tiles),
        fragment: impl FnOnce() -> (F::Outputs<Target<'t>>, F),
        compute: impl FnOnce() -> C,
    ) -> Result<()> {
        let Over { list, halved } = self.over;
        match &self.made {
            Made::Fragment { tiles: pipeline, whole } => {
                let (targets, program) = fragment();
                if tiles.whole {
                    return frame.fullscreen(name, whole, targets, &program);
                }
                let tile_list = TileListBlock { list, halve: i32::from(halved) };
                let vertices = Tile { unified: parameters, Tiles: tiles.lists, tile_list: &tile_list };
                let arguments = (tiles.arguments, DRAW_BYTES * list as u64);
                frame.draw_indirect(name, pipeline, targets, (&program, &vertices), arguments)
            }
            Made::Compute { tiles: pipeline, whole } => {
                if tiles.whole {
                    let [x, y] = parameters.size.map(|side| (side as u32).div_ceil(1 + u32::from(halved)));
                    return frame.compute(name, whole, &compute(), [x, y, 1]);
                }
                let offset = LISTS as u64 * DRAW_BYTES + (2 * list as u64 + u64::from(halved)) * DISPATCH_BYTES;
                frame.compute_indirect(name, pipeline, &compute(), (tiles.arguments, offset))
            }
        }
    }
}
