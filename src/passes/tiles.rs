//! Work over tiles: the lists of tiles that the classification writes, one for each kind of reflector, and programs
//! over the tiles of a list. Such a program runs over the whole image if the list is known to cover it. Each program
//! that walks over the screen has permutations for fragment and for compute shaders, which make the same images.

use super::LIT_COLOR;
use super::triangle_scene::TriangleReading;
use crate::error::{Error, Result};
use crate::gpu::program::{InEitherStage, PermutationChoice, RaySource};
use crate::gpu::programs::{Tile, TriangleConstants};
use crate::gpu::shader::{TileListBlock, UnifiedBlock};
use crate::gpu::{Buffer, Frame, Gpu, GraphicsPipeline, Image, ShaderStage, StoringPipeline, Target};
use ash::vk;
use ssct_ground::math::OracleVersion;
use ssct_ground::math::constants::{LISTS, TILE_SIDE};
use ssct_ground::scene::ProjectionKind;

/// Pixels along a side of a tile.
pub const TILE: u32 = TILE_SIDE as u32;

/// Returns the number of tiles along each side of an image of a size in pixels.
pub fn count(extent: [u32; 2]) -> [u32; 2] {
    extent.map(|side| side.div_ceil(TILE))
}

/// What the passes of `unified` are made for.
#[derive(Debug, Clone, Copy)]
pub struct UnifiedSetup {
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// The projection of the camera.
    pub projection: ProjectionKind,
    /// Log2 of the columns in a strip of the pyramid's image (`passes::pyramid::strip`).
    pub strip: u32,
    /// The version of the oracle whose hits the passes find.
    pub oracle: OracleVersion,
    /// Whether another reflection shows where this one misses.
    pub over_fallback: bool,
    /// Whether the composite is wanted.
    pub composite: bool,
    /// Whether the reflection is wanted as an image of its own. Composite or reflection is wanted, or both.
    pub reflection: bool,
    /// Whether rays walk over the screen. If not, all of them go among the triangles at once, and there is no pyramid.
    pub walks_screen: bool,
    /// Whether rays that the screen loses go on, in captures or among triangles.
    pub follows_lost_rays: bool,
    /// How shaders read the triangles, if rays are traced among them.
    pub triangles: Option<TriangleReading>,
    /// Number of own rays of a glossy pixel in doubt; 0 if rays go on in captures.
    pub own_rays: i32,
    /// Whether a history asks where rays ended.
    pub stores_ends: bool,
    /// The shader stage of the passes that trace rays.
    pub trace_stage: ShaderStage,
    /// The shader stage of the passes that gather what the rays saw.
    pub resolve_stage: ShaderStage,
}

impl UnifiedSetup {
    /// Returns the formats of the images of a [`Canvas`](super::Canvas), in the order of the shaders' outputs.
    pub fn formats(&self) -> [vk::Format; 2] {
        [LIT_COLOR, if self.wants_both() { LIT_COLOR } else { vk::Format::UNDEFINED }]
    }

    /// Returns the permutation of the programs that trace, by where rays end: on the screen, there if triangles confirm
    /// it, or among the triangles. If no ray walks over the screen, only compute shaders trace.
    pub fn trace_permutation(&self) -> PermutationChoice {
        match self.triangles {
            None => PermutationChoice { stage: self.trace_stage, rays: Some(RaySource::Screen) },
            Some(_) if self.walks_screen => {
                PermutationChoice { stage: self.trace_stage, rays: Some(RaySource::Confirmed) }
            }
            Some(reading) => PermutationChoice::compute(reading.ray_source()),
        }
    }

    /// Returns the specialization constants of programs that trace rays among the triangles.
    pub fn triangle_constants(&self) -> TriangleConstants {
        self.triangles.map_or_else(TriangleConstants::default, |reading| reading.constants())
    }

    /// Whether both the composite and the reflection are wanted.
    pub fn wants_both(&self) -> bool {
        self.composite && self.reflection
    }

    /// Makes an image that the passes write, and that compute programs can store to if any of the passes is one.
    pub(crate) fn target(&self, gpu: &Gpu, name: &str, format: vk::Format) -> Result<Image> {
        let is_any_compute = [self.trace_stage, self.resolve_stage].contains(&ShaderStage::Compute);
        let stores = self.follows_lost_rays || self.own_rays > 0 || is_any_compute;
        let stage = if stores { ShaderStage::Compute } else { ShaderStage::Fragment };
        Image::target_in(gpu, stage, name, format, self.extent)
    }
}

/// Bytes of the arguments for the lists (`parameters.glsl`): one indirect draw and two indirect dispatches a list.
pub const ARGUMENT_BYTES: u64 = LISTS as u64 * (DRAW_BYTES + 2 * DISPATCH_BYTES);

const DRAW_BYTES: u64 = size_of::<vk::DrawIndirectCommand>() as u64;
const DISPATCH_BYTES: u64 = size_of::<vk::DispatchIndirectCommand>() as u64;

/// Lists of tiles by the kinds of reflector in them, with the arguments of indirect draws and dispatches over each list.
#[derive(Clone, Copy)]
pub struct Tiles<'a> {
    /// Whether passes run over the whole image, and nothing was classified, since all reflectors are of one kind.
    pub whole: bool,
    /// The lists, one after the other. Each has room for every tile, with one word for a tile's place.
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

    /// Returns a target that fragment shaders clear to the value `elsewhere` first. Compute shaders clear none.
    pub fn target_in<'i>(&self, image: &'i Image, elsewhere: [f32; 4]) -> Target<'i> {
        if self.whole { Target::overwrite(image.all()) } else { Target::cleared(image.all(), elsewhere) }
    }
}

/// The list that a program runs over, and the resolution of the images that it writes.
#[derive(Debug, Clone, Copy)]
pub struct TileRange {
    /// `MIRROR_LIST`, `NARROW_LIST` or `WIDE_LIST`.
    pub list: i32,
    /// Whether the images that the program writes have one texel for 2 × 2 pixels.
    pub halved: bool,
}

/// A program that runs over the tiles of a list or over the whole image, in the chosen permutation.
pub struct TiledPipeline<P> {
    range: TileRange,
    pipelines: TilePipelines<P>,
}

/// The pipelines of the chosen shader stage: one over the tiles of a list, and one over the whole image.
enum TilePipelines<P> {
    Fragment { tiles: GraphicsPipeline<P, Tile<'static>>, whole: GraphicsPipeline<P> },
    Compute { tiles: StoringPipeline<P>, whole: StoringPipeline<P> },
}

impl<P: InEitherStage> TiledPipeline<P>
where
    P::Outputs<vk::Format>: Copy,
{
    /// Compiles a permutation of the program twice: for tiles and for the whole image. `formats` are the formats of its
    /// targets, and `constants` returns its constants for tiles (`false`) and for the whole image (`true`).
    ///
    /// # Errors
    /// [`Error::NoDevice`] if a fragment shader needs points of a tile's size, which the device does not draw, or if the
    /// program has more images or buffers than the device allows. [`Error::Usage`] for a permutation that is not there.
    pub fn new(
        gpu: &Gpu,
        range: TileRange,
        PermutationChoice { stage, rays }: PermutationChoice,
        formats: P::Outputs<vk::Format>,
        constants: impl Fn(bool) -> P::Constants,
    ) -> Result<Self> {
        let pipelines = match stage {
            ShaderStage::Fragment => {
                check_points(gpu)?;
                TilePipelines::Fragment {
                    tiles: GraphicsPipeline::points(gpu, rays, formats, &constants(false))?,
                    whole: GraphicsPipeline::fullscreen_for_rays(gpu, rays, formats, &constants(true))?,
                }
            }
            ShaderStage::Compute => {
                let tiles = StoringPipeline::new(gpu, rays, &formats, &constants(false))?;
                TilePipelines::Compute { whole: tiles.with_constants(gpu, &constants(true))?, tiles }
            }
        };
        Ok(Self { range, pipelines })
    }

    /// Records the pass `name` over the list's tiles, or over all texels if the list is known to cover the whole image.
    pub fn run(
        &self,
        frame: &mut Frame,
        name: &str,
        (parameters, tiles): (&UnifiedBlock, Tiles),
        targets: P::Outputs<Target>,
        program: &P,
    ) -> Result<()> {
        let TileRange { list, halved } = self.range;
        match &self.pipelines {
            TilePipelines::Fragment { whole, .. } if tiles.whole => frame.fullscreen(name, whole, targets, program),
            TilePipelines::Fragment { tiles: pipeline, .. } => {
                let tile_list = TileListBlock { list, halved: i32::from(halved) };
                let vertices = Tile { unified: parameters, Tiles: tiles.lists, tile_list: &tile_list };
                let arguments = (tiles.arguments, DRAW_BYTES * list as u64);
                frame.draw_indirect(name, pipeline, targets, (program, &vertices), arguments)
            }
            TilePipelines::Compute { whole, .. } if tiles.whole => frame.store(name, whole, targets, program),
            TilePipelines::Compute { tiles: pipeline, .. } => {
                let offset = LISTS as u64 * DRAW_BYTES + (2 * list as u64 + u64::from(halved)) * DISPATCH_BYTES;
                frame.store_indirect(name, pipeline, targets, program, (tiles.arguments, offset))
            }
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
