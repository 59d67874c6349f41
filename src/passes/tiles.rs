//! Work over tiles: the lists of tiles that the classification writes, one for each kind of reflector, and programs that run over
//! the tiles of a list. A program runs over the whole image if the list is known to cover all of it. Each program exists for
//! fragment shaders and for compute shaders, and makes the same images in both.

use super::LIT_COLOR;
use super::triangle_scene::TriangleReading;
use crate::error::{Error, Result};
use crate::gpu::program::{Compute, Fragment};
use crate::gpu::programs::Tile;
use crate::gpu::shader::{TileListBlock, UnifiedBlock};
use crate::gpu::{Buffer, ComputePipeline, Frame, Gpu, GraphicsPipeline, Image, ShaderStage, Target};
use ash::vk;
use ssct_ground::math::OracleVersion;
use ssct_ground::math::constants::{LISTS, TILE_SIDE};
use ssct_ground::scene::ProjectionKind;

/// Pixels along a side of a tile.
pub const TILE: u32 = TILE_SIDE as u32;

/// Tiles along each side of an image of a size in pixels.
pub fn count(extent: [u32; 2]) -> [u32; 2] {
    extent.map(|side| side.div_ceil(TILE))
}

/// The setup that the passes of `unified` are made for.
#[derive(Debug, Clone, Copy)]
pub struct UnifiedSetup {
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// The projection of the camera.
    pub projection: ProjectionKind,
    /// Log2 of the columns to a strip of the pyramid's image (`passes::pyramid::strip`).
    pub strip: u32,
    /// The version of the oracle whose hits the passes find.
    pub oracle: OracleVersion,
    /// Whether another reflection shows where this one misses.
    pub over: bool,
    /// Whether the composite is wanted.
    pub composite: bool,
    /// Whether the reflection is wanted as an image of its own. Composite or reflection is wanted, or both.
    pub reflection: bool,
    /// Whether rays walk over the screen. If not, all of them go among the triangles at once, and there is no pyramid.
    pub screen: bool,
    /// Whether rays that the screen loses go on, in captures or among triangles.
    pub followed: bool,
    /// How shaders read the triangles, if rays go on among them from the point of their pixel.
    pub triangles: Option<TriangleReading>,
    /// Number of own rays of a pixel with a lobe whose neighbours disagree, among the triangles or on the screen; 0 if rays go on
    /// in captures.
    pub own_rays: i32,
    /// Whether a history asks where rays ended.
    pub tells: bool,
    /// The stage that traces rays.
    pub trace: ShaderStage,
    /// The stage that gathers what the rays saw.
    pub resolve: ShaderStage,
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

    /// Makes an image that the passes write. Compute programs can store to it if any of the passes is a compute program.
    pub(crate) fn target(&self, gpu: &Gpu, name: &str, format: vk::Format) -> Result<Image> {
        let stores = self.followed || self.own_rays > 0 || [self.trace, self.resolve].contains(&ShaderStage::Compute);
        let stage = if stores { ShaderStage::Compute } else { ShaderStage::Fragment };
        Image::target_in(gpu, stage, name, format, self.extent)
    }
}

/// Bytes of the arguments of indirect draws and dispatches over the lists (`parameters.glsl`): one draw and two dispatches for each
/// list.
pub const ARGUMENT_BYTES: u64 = LISTS as u64 * (DRAW_BYTES + 2 * DISPATCH_BYTES);

const DRAW_BYTES: u64 = size_of::<vk::DrawIndirectCommand>() as u64;
const DISPATCH_BYTES: u64 = size_of::<vk::DispatchIndirectCommand>() as u64;

/// Lists of tiles by the kinds of reflector in them, with the arguments of indirect draws and dispatches over each list.
#[derive(Clone, Copy)]
pub struct Tiles<'a> {
    /// Whether nothing was classified, since all reflectors are of one kind, and passes draw over the whole image.
    pub whole: bool,
    /// The lists. Each has room for a word of every tile.
    pub lists: &'a Buffer,
    /// A texel for each tile, with a bit for each list that the tile is on.
    pub listed: &'a Image,
    /// A `VkDrawIndirectCommand` for each list; then for each list two `VkDispatchIndirectCommand`, the first over
    /// pixels and the second over blocks of 2 × 2.
    pub arguments: &'a Buffer,
}

impl Tiles<'_> {
    /// Returns a target that keeps its content where no tile is drawn. A pass over the whole image overwrites all of it.
    pub fn target<'i>(&self, image: &'i Image) -> Target<'i> {
        if self.whole { Target::overwrite(image.all()) } else { Target::kept(image.all()) }
    }

    /// Returns a target that is cleared to a value where no tile is drawn.
    pub fn target_in<'i>(&self, image: &'i Image, elsewhere: [f32; 4]) -> Target<'i> {
        if self.whole { Target::overwrite(image.all()) } else { Target::cleared(image.all(), elsewhere) }
    }
}

/// The list that a program runs over, and the size of the images that it writes.
#[derive(Debug, Clone, Copy)]
pub struct TileRange {
    /// `MIRROR_LIST`, `NARROW_LIST` or `WIDE_LIST`.
    pub list: i32,
    /// Whether the images that the program writes have one texel for 2 × 2 pixels.
    pub halved: bool,
}

/// A compute program that runs over the tiles of a list or over the whole image.
pub struct TiledCompute<C> {
    range: TileRange,
    tiles: ComputePipeline<C>,
    whole: ComputePipeline<C>,
}

impl<C: Compute> TiledCompute<C> {
    /// Compiles the program twice. `constants` returns its constants for the tiles (`false`) and for the whole image (`true`).
    ///
    /// # Errors
    /// [`Error::NoDevice`] on a device whose shaders take fewer images or buffers than the program has.
    pub fn new(gpu: &Gpu, range: TileRange, constants: impl Fn(bool) -> C::Constants) -> Result<Self> {
        Ok(Self {
            range,
            tiles: ComputePipeline::with(gpu, &constants(false))?,
            whole: ComputePipeline::with(gpu, &constants(true))?,
        })
    }

    /// Records one pass over the list's tiles, or over the whole image.
    pub fn run(
        &self,
        frame: &mut Frame,
        name: &str,
        (parameters, tiles): (&UnifiedBlock, Tiles),
        program: &C,
    ) -> Result<()> {
        let TileRange { list, halved } = self.range;
        if tiles.whole {
            let [x, y] = parameters.size.map(|side| (side as u32).div_ceil(1 + u32::from(halved)));
            return frame.compute(name, &self.whole, program, [x, y, 1]);
        }
        let offset = LISTS as u64 * DRAW_BYTES + (2 * list as u64 + u64::from(halved)) * DISPATCH_BYTES;
        frame.compute_indirect(name, &self.tiles, program, (tiles.arguments, offset))
    }
}

/// A program that runs over the tiles of a list or over the whole image: `F` in fragment shaders or `C` in compute
/// shaders.
pub struct TiledPipeline<F, C> {
    range: TileRange,
    pipelines: TilePipelines<F, C>,
}

/// The pipelines of the chosen stage.
enum TilePipelines<F, C> {
    Fragment { tiles: GraphicsPipeline<F, Tile<'static>>, whole: GraphicsPipeline<F> },
    Compute(TiledCompute<C>),
}

impl<F: Fragment, C: Compute> TiledPipeline<F, C> {
    /// Compiles the program of a stage twice. `formats` are the formats of its targets in fragment shaders. `fragment` and
    /// `compute` return its constants for the tiles (`false`) and for the whole image (`true`).
    ///
    /// # Errors
    /// [`Error::NoDevice`] for fragment shaders on a device that draws no points of a tile's size, and on a device whose shaders
    /// take fewer images than the program has.
    pub fn new(
        gpu: &Gpu,
        (stage, range): (ShaderStage, TileRange),
        formats: impl Fn() -> F::Outputs<vk::Format>,
        fragment: impl Fn(bool) -> F::Constants,
        compute: impl Fn(bool) -> C::Constants,
    ) -> Result<Self> {
        let pipelines = match stage {
            ShaderStage::Fragment => {
                check_points(gpu)?;
                TilePipelines::Fragment {
                    tiles: GraphicsPipeline::points(gpu, formats(), &fragment(false))?,
                    whole: GraphicsPipeline::fullscreen_with(gpu, formats(), &fragment(true))?,
                }
            }
            ShaderStage::Compute => TilePipelines::Compute(TiledCompute::new(gpu, range, compute)?),
        };
        Ok(Self { range, pipelines })
    }

    /// Records one pass over the list's tiles, or over the whole image, in which every texel is written. The program of the chosen
    /// stage is filled in (`in_either_stage`) and runs.
    pub fn run<'t>(
        &self,
        frame: &mut Frame,
        name: &str,
        (parameters, tiles): (&UnifiedBlock, Tiles),
        (fragment, compute): (impl FnOnce() -> (F::Outputs<Target<'t>>, F), impl FnOnce() -> C),
    ) -> Result<()> {
        let TileRange { list, halved } = self.range;
        match &self.pipelines {
            TilePipelines::Fragment { tiles: pipeline, whole } => {
                let (targets, program) = fragment();
                if tiles.whole {
                    return frame.fullscreen(name, whole, targets, &program);
                }
                let tile_list = TileListBlock { list, halve: i32::from(halved) };
                let vertices = Tile { unified: parameters, Tiles: tiles.lists, tile_list: &tile_list };
                let arguments = (tiles.arguments, DRAW_BYTES * list as u64);
                frame.draw_indirect(name, pipeline, targets, (&program, &vertices), arguments)
            }
            TilePipelines::Compute(pipelines) => pipelines.run(frame, name, (parameters, tiles), &compute()),
        }
    }
}

/// Refuses a device that draws no points of a tile's size.
fn check_points(gpu: &Gpu) -> Result<()> {
    let (name, largest) = (&gpu.info().name, gpu.largest_point());
    if largest < TILE as f32 {
        return Err(Error::NoDevice(format!(
            "`unified` draws points of {TILE} pixels in fragment shaders; {name} has none above {largest}: set \
             trace-stage and resolve-stage to compute, and it needs none"
        )));
    }
    Ok(())
}

/// Makes the two programs of a pass for [`TiledPipeline::run`]: the fragment program with its targets, and the compute program with
/// the [`Tiles`] that it runs over and the images that it stores to. Bindings that both programs have are written once, after them;
/// `triangle_bindings` gives the bindings of a scene's triangles.
macro_rules! in_either_stage {
    (
        $fragment:ident => $targets:expr,
        $compute:ident over $tiles:ident => { $($stored:ident: $image:expr),+ $(,)? },
        triangle_bindings: $triangle_bindings:expr,
        $($field:ident: $value:expr),+ $(,)?
    ) => {
        (
            || ($targets, $crate::passes::triangle_scene::with_triangles! { $fragment of $triangle_bindings, $($field: $value),+ }),
            || $crate::passes::triangle_scene::with_triangles! { $compute of $triangle_bindings,
                Tiles: $tiles.lists, Counts: $tiles.arguments, $($stored: $image,)+ $($field: $value),+
            },
        )
    };
    (
        $fragment:ident => $targets:expr,
        $compute:ident over $tiles:ident => { $($stored:ident: $image:expr),+ $(,)? },
        $($field:ident: $value:expr),+ $(,)?
    ) => {
        (
            || ($targets, $fragment { $($field: $value),+ }),
            || $compute { Tiles: $tiles.lists, Counts: $tiles.arguments, $($stored: $image,)+ $($field: $value),+ },
        )
    };
}
pub(super) use in_either_stage;
