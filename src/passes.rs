//! The passes, one file each, and the typed values that flow between them.
//!
//! A pass owns its pipelines and the images that it writes; its `record` takes what the pass reads and returns what the
//! pass wrote. No pass imports a method or another pass, only the types below.

pub mod area_light;
pub mod billboard;
pub mod bump;
pub mod classify;
pub mod color_chain;
pub mod composite;
pub mod cone_march;
pub mod cube_filter;
pub mod dda_trace;
pub mod environment;
pub mod fallback;
pub mod filtered_gbuffer;
pub mod follow;
pub mod gbuffer;
pub mod hi_z;
pub mod history;
pub mod import;
pub mod keep_normal;
pub mod lighting;
pub mod linear_trace;
pub mod look;
pub mod lost;
pub mod mask_chain;
pub mod own_rays;
mod path_code;
pub mod pccm;
pub mod planar;
pub mod pyramid;
pub mod resolution;
pub mod scene_data;
pub mod schmidt_trace;
pub mod sslr_reflection;
pub mod sslr_trace;
pub mod stochastic;
pub mod thesis_trace;
pub mod tiles;
pub mod trace_normals;
pub mod traced;
pub mod triangle_scene;
pub mod triangle_trace;
pub mod unified_gloss;
pub mod unified_trace;
pub mod unlit_triangles;
pub mod visibility;

pub use path_code::PathCode;

use crate::error::Result;
use crate::gpu::programs::LinearConstants;
use crate::gpu::shader::{CameraBlock, UnifiedBlock};
use crate::gpu::{Frame, Gpu, Image, ImageSlice, Sampled, ShaderStage, Target};
use ash::vk;
use glam::Vec3;
use ssct_ground::math::constants;
use ssct_ground::parameter::choices;
use ssct_ground::scene::{Aabb, Camera, ProjectionKind};
use std::cell::Cell;
use std::sync::OnceLock;

/// Format of the lit colour and its chain.
pub const LIT_COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Format of [`Hits`].
pub const HITS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Format of a ray trace colour before it is encoded as sRGB, wide enough that nothing is rounded until then.
pub const UNENCODED_COLOR: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The texel of [`Hits`] for a pixel in which no ray begins.
pub const NO_HIT: [f32; 4] = [-1.0, -1.0, -1.0, 0.0];

/// Format of normals, as `unified` loads them.
pub const NORMAL: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Format of materials: reflectivity and roughness, as `unified` loads them.
pub const MATERIAL: vk::Format = vk::Format::R16G16_SFLOAT;

/// Makes an image of one level that passes can draw into, read, and store to from compute shaders.
pub(crate) fn stored_target(gpu: &Gpu, name: &str, format: vk::Format, extent: [u32; 2]) -> Result<Image> {
    Image::target_in(gpu, ShaderStage::Compute, name, format, extent)
}

/// Makes an image of one texel that is bound in place of the image of hits if nobody wants hits. The program writes
/// nothing to this image, but Vulkan requires the format that the shader names.
fn unwanted_hits(gpu: &Gpu) -> Result<Image> {
    stored_target(gpu, "unwanted hits", HITS, [1, 1])
}

/// The numbers of the linear march that the thesis prints (§4.2.2). Every program that includes `thesis/linear_ray_march.glsl` has
/// them as specialization constants, whose values in the shader are the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarchNumbers {
    /// Steps of the march at most.
    pub linear_march_count: i32,
    /// Factor from the length of one step of the march to the next.
    pub linear_march_increase: f32,
    /// Steps of the binary search at most.
    pub binary_search_count: i32,
    /// Factor from the length of one step of the search to the next.
    pub binary_search_decrease: f32,
    /// How near to a surface the search ends, in standard depth.
    pub depth_delta_epsilon: f32,
}

impl Default for MarchNumbers {
    fn default() -> Self {
        let printed = LinearConstants::default();
        Self {
            linear_march_count: printed.linear_march_count,
            linear_march_increase: printed.linear_march_increase,
            binary_search_count: printed.binary_search_count,
            binary_search_decrease: printed.binary_search_decrease,
            depth_delta_epsilon: printed.depth_delta_epsilon,
        }
    }
}

/// Makes the constants of a program that includes `thesis/linear_ray_march.glsl`: its own and [`MarchNumbers`].
macro_rules! march_constants {
    ($constants:ident { $($own:ident $(: $value:expr)?),* }, $march:expr) => {{
        let march: $crate::passes::MarchNumbers = $march;
        $constants {
            $($own $(: $value)?,)*
            linear_march_count: march.linear_march_count,
            linear_march_increase: march.linear_march_increase,
            binary_search_count: march.binary_search_count,
            binary_search_decrease: march.binary_search_decrease,
            depth_delta_epsilon: march.depth_delta_epsilon,
        }
    }};
}
use march_constants;

/// The images that the scene passes leave for the methods. All have one size.
#[derive(Clone, Copy)]
pub struct GBuffer<'a> {
    /// Reversed depth (near 1, far 0; 0 is sky), D32.
    pub depth: &'a Image,
    /// View-space unit normal in xyz; zero where nothing stands. The format is [`NORMAL`], the only one that `unified` takes.
    pub normal: &'a Image,
    /// Reflectivity and roughness, in the format [`MATERIAL`].
    pub material: &'a Image,
    /// Lit colour, linear, in level 0 of a full mip chain. RGBA16F.
    pub color: &'a Image,
    /// The number of the triangle that each pixel shows among those of the scene, `NO_TRIANGLE` where nothing stands. R32 uint;
    /// `None` if nobody asked for it.
    pub triangle: Option<&'a Image>,
    /// The kinds of reflecting surface that the frame may have, as known before any pixel is looked at.
    pub reflectors: Reflectors,
}

impl<'a> GBuffer<'a> {
    /// Returns the levels of the colour chain without the finest. An image of one pixel has no coarser levels. Its
    /// depth is bound in their place and is never read, since no ray hits in such an image.
    pub(crate) fn coarse_colors(&self) -> Sampled<'a> {
        self.color.coarse().map_or(Sampled::nearest(self.depth.all()), Sampled::trilinear)
    }
}

/// The kinds of reflecting surface that a frame may have, as its materials tell before any pixel is looked at. Passes for the other
/// kinds are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reflectors {
    /// True if mirrors may occur: surfaces that reflect with roughness 0.
    pub mirrors: bool,
    /// True if gloss with narrow lobes may occur: roughness above 0, up to [`WIDE_ABOVE`].
    pub narrow: bool,
    /// True if gloss with wide lobes may occur: roughness above [`WIDE_ABOVE`].
    pub wide: bool,
    /// True if every lit surface reflects, so that every pixel reflects except those that show the sky.
    pub everywhere: bool,
}

/// Roughness above which `unified` takes a lobe for wide.
pub const WIDE_ABOVE: f32 = constants::WIDE_ABOVE as f32;

impl Reflectors {
    /// Nothing is known of the frame, so that every kind may occur.
    pub const UNKNOWN: Self = Self { mirrors: true, narrow: true, wide: true, everywhere: false };

    /// Returns the kinds that can occur in a frame with these values, 0 to 1, in all pixels; `None` if a value varies.
    pub fn for_constants(reflectivity: Option<f32>, roughness: Option<f32>) -> Self {
        let reflects = reflectivity.is_none_or(|value| f64::from(value) > constants::REFLECTS_ABOVE);
        let may_occur = |is_of_kind: fn(f32) -> bool| reflects && roughness.is_none_or(is_of_kind);
        Self {
            mirrors: may_occur(|roughness| roughness <= 0.0),
            narrow: may_occur(|roughness| roughness > 0.0 && roughness <= WIDE_ABOVE),
            wide: may_occur(|roughness| roughness > WIDE_ABOVE),
            everywhere: reflects && reflectivity.is_some(),
        }
    }

    /// Combines two partial descriptions of a frame: a kind of reflector may occur only if both allow it.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            mirrors: self.mirrors && other.mirrors,
            narrow: self.narrow && other.narrow,
            wide: self.wide && other.wide,
            everywhere: self.everywhere || other.everywhere,
        }
    }

    /// Whether anything may reflect.
    pub fn any(self) -> bool {
        self.mirrors || self.glossy()
    }

    /// Whether anything may be glossy.
    pub fn glossy(self) -> bool {
        self.narrow || self.wide
    }

    /// Returns how many of the three kinds may occur.
    pub fn kinds(self) -> usize {
        [self.mirrors, self.narrow, self.wide].into_iter().filter(|kind| *kind).count()
    }
}

/// The Hi-Z chain of standard depth: the minimum in R, and in G the maximum if it is wanted (R32F or RG32F).
#[derive(Clone, Copy)]
pub struct HiZ<'a>(pub &'a Image);

/// Reversed depths of the nearest front (R) and the farthest back (G) in each cell, all levels in one image. RG32F.
#[derive(Clone, Copy)]
pub struct Pyramid<'a>(pub &'a Image);

/// The images that a method draws into if it composites along the way. At least one of them is wanted.
#[derive(Clone, Copy)]
pub struct Canvas<'a> {
    /// The finished image, linear, where it is wanted. RGBA16F.
    pub composite: Option<&'a Image>,
    /// Reflection colour and fade, where they are wanted as an image of their own. RGBA16F.
    pub reflection: Option<&'a Image>,
}

impl<'a> Canvas<'a> {
    /// The images that are wanted, in the order of the shaders' outputs.
    pub fn images(self) -> impl Iterator<Item = &'a Image> {
        self.composite.into_iter().chain(self.reflection)
    }

    /// Returns the targets of fragment programs over tiles, in the order of their outputs, for up to two images.
    fn targets(self, tiles: tiles::Tiles) -> [Target<'a>; 2] {
        let mut targets = self.images().map(|image| tiles.target(image));
        let mut next = || targets.next().unwrap_or(Target::unwanted());
        [next(), next()]
    }

    /// Returns the two images that compute programs store to, in the order of their bindings; `None` if no image is
    /// wanted. A single image is bound twice, and the program stores to the first binding alone.
    fn stored(self) -> Option<[&'a Image; 2]> {
        let mut images = self.images();
        let first = images.next()?;
        Some([first, images.next().unwrap_or(first)])
    }

    /// Records passes "composite", which copies the lit colour, and "reflection", which clears the reflection.
    pub fn begin(self, frame: &mut Frame, color: &Image) -> Result<()> {
        let color = color.level(0);
        if let Some(composite) = self.composite {
            if color.image().format() == composite.format() {
                frame.copy("composite", color, composite.all())?;
            } else {
                // A blit also converts the format: the precision study hands over 32-bit floats.
                frame.blit("composite", color, composite.all())?;
            }
        }
        match self.reflection {
            Some(reflection) => frame.clear("reflection", reflection.all(), [0.0; 4]),
            None => Ok(()),
        }
    }
}

/// The visibility chain: the share of each cell that the Hi-Z buffer leaves visible, 1 in all of level 0. R8.
#[derive(Clone, Copy)]
pub struct Visibility<'a>(pub &'a Image);

/// Lit colour with its pre-convolved levels. RGBA16F.
#[derive(Clone, Copy)]
pub struct ColorChain<'a>(pub &'a Image);

/// Where each ray ended: texture coordinates, standard depth, and a [`PathCode`]. RGBA32F.
#[derive(Clone, Copy)]
pub struct Hits<'a>(pub &'a Image);

/// Radiance by direction in world axes, with one roughness for each level (`cube_filter::level_roughness`): six faces in Vulkan's
/// order. RGBA16F.
#[derive(Clone, Copy)]
pub struct CubeMap<'a>(pub &'a Image);

/// Captures of a scene: cubes of images, all of one size, each made at a place by the scene passes.
#[derive(Clone, Copy)]
pub struct Captures<'a> {
    /// The [`Pyramid`] of each face: layer 6 k + f is face f of capture k. RG32F.
    pub pyramid: &'a Image,
    /// Normals in the view space of each face, in the same layers as [`Self::pyramid`]. RGBA8 snorm.
    pub normal: &'a Image,
    /// Lit colour with its chain, an array of cube maps: 0 for sky, and in alpha the share that is not sky. RGBA16F.
    pub color: &'a Image,
    /// The places of the captures in the world, in metres. Each frame moves a capture that follows the camera.
    pub places: &'a [Cell<Vec3>],
    /// The parameters of `unified` for a face, which all faces share.
    pub face: &'a UnifiedBlock,
    /// Metres in one view unit of a face ([`lost::view_unit_m()`]).
    pub face_unit: f32,
    /// A box in the world, in metres, outside of which nothing stands.
    pub bounds: Aabb,
}

/// A reflection: in rgb its colour, before fade and reflectivity, and in alpha its fade. A miss is 0. RGBA16F.
#[derive(Clone, Copy)]
pub struct Reflection<'a>(pub &'a Image);

/// The mip chains of SSLR's ray trace colour and of its mask (thesis §4.3). Level 0 holds what the rays found.
#[derive(Clone, Copy)]
pub struct RayTraceColor<'a> {
    /// Colour, 0 for a miss, and in alpha the ray's length in screen space, at most 1. RGBA8, with sRGB-encoded colour.
    pub color: &'a Image,
    /// 1 where a ray hit, else 0. R8.
    pub mask: &'a Image,
    /// The colour before it is encoded, if compute programs make it, since these cannot store to an sRGB format. The
    /// image has the format [`UNENCODED_COLOR`] and as many levels as `color`.
    pub unencoded: Option<&'a Image>,
}

impl RayTraceColor<'_> {
    /// Records pass "NAME/encode" if a compute program made the colour. The pass encodes a level of the colour into
    /// `to`, the same level of the encoded image.
    fn encode(&self, frame: &mut Frame, name: &str, to: ImageSlice) -> Result<()> {
        let Some(unencoded) = self.unencoded else { return Ok(()) };
        frame.convert(&format!("{name}/encode"), unencoded.level(to.base_level()), to)
    }
}

/// The poster's G-buffer, pre-filtered: mip chains, or volumes whose slices stand for the levels.
#[derive(Clone, Copy)]
pub struct FilteredGBuffer<'a> {
    /// View-space z in metres; the far plane's where nothing stands. R32F.
    pub depth: &'a Image,
    /// View-space normal, averaged without normalising. RGBA16F.
    pub normal: &'a Image,
    /// Lit colour, linear. RGBA16F.
    pub color: &'a Image,
}

choices! {
    /// How the G-buffer is pre-filtered.
    pub enum PosterFilter {
        /// Hardware mip-mapping (the poster's figure 2a).
        Mip = "mip",
        /// A 3D texture whose slices are Gaussian-blurred (figure 2b).
        Volume = "volume",
        /// A mip chain whose texels are means of one surface each: of those below, what lies on others is left out.
        EdgeAware = "edge-aware",
    }
}

/// What an image's numbers mean, for code that displays them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Linear colour.
    Color,
    /// View-space normal.
    Normal,
    /// Reversed depth.
    ReversedDepth,
    /// Standard depth, minimum and maximum.
    StandardDepth,
    /// View-space z in metres.
    LinearDepth,
    /// A [`Pyramid`], all levels in one image, with the width and height of the picture in pixels.
    Pyramid([u32; 2]),
    /// Numbers that are none of the above: places, movements, packed normals.
    Numbers,
    /// Shares 0…1.
    Share,
    /// Reflectivity and roughness.
    Material,
    /// Texture coordinates, depth and path code.
    Hits,
    /// Cells or texels that each pixel's ray looked at, in the first channel.
    Steps,
}

/// Returns a camera's uniform block for images of a size in pixels. Matrices are inverted in f64, then rounded once.
pub fn camera_block(camera: &Camera, extent: [u32; 2]) -> CameraBlock {
    let standard = camera.view_to_clip().as_dmat4();
    let reversed = camera.view_to_clip_reversed().as_dmat4();
    let view = camera.world_to_view.as_dmat4();
    CameraBlock {
        view_to_clip: standard.as_mat4().to_cols_array_2d(),
        clip_to_view: standard.inverse().as_mat4().to_cols_array_2d(),
        view_to_clip_reversed: reversed.as_mat4().to_cols_array_2d(),
        clip_to_view_reversed: reversed.inverse().as_mat4().to_cols_array_2d(),
        world_to_view: view.as_mat4().to_cols_array_2d(),
        view_to_world: view.inverse().as_mat4().to_cols_array_2d(),
        resolution: extent.map(|side| side as f32),
        near_plane: camera.lens.near_m,
        far_plane: camera.lens.far_m,
    }
}

/// One pipeline for each kind of projection, made when a frame first has a camera of that kind.
struct PerProjection<P>([OnceLock<P>; 2]);

impl<P> PerProjection<P> {
    const fn new() -> Self {
        Self([const { OnceLock::new() }; 2])
    }

    /// Returns the pipeline of a kind of projection; `make` makes it at the first call.
    fn get(&self, kind: ProjectionKind, make: impl FnOnce() -> Result<P>) -> Result<&P> {
        let slot = &self.0[usize::from(kind.is_orthographic())];
        if let Some(pipeline) = slot.get() {
            return Ok(pipeline);
        }
        let pipeline = make()?;
        Ok(slot.get_or_init(|| pipeline))
    }
}
