//! Inputs that are common to the passes that trace rays over the screen and to those that follow lost rays: the list of
//! lost rays, the camera among the captures, and the sky.

use super::tiles::{self, TILE};
use super::{Captures, GBuffer, Pyramid, stored_target};
use crate::error::Result;
use crate::gpu::memory::MemoryPlace;
use crate::gpu::programs::{LostRayResources, ScreenResources};
use crate::gpu::shader::CaptureBlock;
use crate::gpu::{Buffer, Frame, Gpu, Image, ImageDesc, ImageSlice, Sampled};
use ash::vk;
use glam::Vec3;
use ssct_ground::math::constants::NO_TRIANGLE;
use ssct_ground::scene::{Camera, ProjectionKind};

/// Bytes of a ray in the list (`LostRay` of `shaders-glsl/captures/lost.glsl`).
const RAY_BYTES: u64 = 48;

/// Bytes of a pixel in doubt in the list (`Doubt` of `shaders-glsl/triangles/doubt.glsl`).
const DOUBT_BYTES: u64 = 16;

/// The kind of entries that a list has room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListContent {
    /// Nothing: no ray is followed beyond the screen.
    Nothing,
    /// Pixels in doubt, which get own rays ([`own_rays`](super::own_rays)).
    Pixels,
    /// Rays that the screen lost; once these have been followed, pixels in doubt.
    Rays,
}

/// The buffers of the list of lost rays, and images that are bound in place of missing ones.
pub struct LostRays {
    counts: Buffer,
    rays: Buffer,
    /// A black cube map, bound if there is no sky.
    no_sky: Image,
    /// An image of one texel, `NO_TRIANGLE`, bound if the G-buffer has no triangle numbers.
    no_triangle: Image,
}

/// The list, the camera and the sky as a frame's passes bind them.
#[derive(Clone, Copy)]
pub struct LostRayBindings<'a> {
    /// The camera among the captures.
    pub block: &'a CaptureBlock,
    /// The faces of the sky's cube map in world axes.
    pub sky: Sampled<'a>,
    /// The arguments of an indirect dispatch over the list, then the length of the list.
    pub counts: &'a Buffer,
    /// The entries of the list: lost rays, or pixels in doubt.
    pub rays: &'a Buffer,
    /// An image of one texel, bound if the G-buffer has no triangle numbers.
    no_triangle: &'a Image,
}

impl<'a> LostRayBindings<'a> {
    /// Returns the bindings that are common to all programs that write or read the list of rays.
    pub(super) fn resources(&self) -> LostRayResources<'a> {
        LostRayResources { captures: self.block, environment: self.sky, lost_counts: self.counts, lost: self.rays }
    }

    /// Returns the bindings that are common to all programs that trace rays from the pixels of the screen.
    pub(super) fn screen_resources<'i>(&self, gbuffer: &GBuffer<'i>, pyramid: Pyramid<'i>) -> ScreenResources<'i>
    where
        'a: 'i,
    {
        ScreenResources {
            pyramid: pyramid.0.all(),
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            normal_buffer: gbuffer.normal.all(),
            material_buffer: gbuffer.material.all(),
            color_texels: gbuffer.color.level(0),
            triangle_buffer: self.triangle_numbers(gbuffer),
        }
    }

    /// Returns the image of the triangles that pixels show, or an image of one texel if they are not known.
    fn triangle_numbers<'i>(&self, gbuffer: &GBuffer<'i>) -> ImageSlice<'i>
    where
        'a: 'i,
    {
        gbuffer.triangle.unwrap_or(self.no_triangle).all()
    }
}

impl LostRays {
    /// Makes the buffers, with room on the list for an entry of every pixel.
    pub fn new(gpu: &Gpu, extent: [u32; 2], content: ListContent) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        // Tiles at the border may overlap, so that a pixel may put two entries on the list.
        let tiles: u64 = tiles::count(extent).into_iter().map(u64::from).product();
        let pixels = tiles * u64::from(TILE * TILE);
        // The buffer has room for at least one entry of each kind, since shaders declare both kinds.
        let bytes = match content {
            ListContent::Nothing => RAY_BYTES,
            ListContent::Pixels => DOUBT_BYTES * pixels,
            ListContent::Rays => RAY_BYTES * pixels,
        };
        let usage = U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST;
        let sky_usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let no_sky = ImageDesc::one_level("no sky", vk::Format::R16G16B16A16_SFLOAT, [1, 1], sky_usage);
        Ok(Self {
            counts: Buffer::new(gpu, "lost counts", 16, usage, MemoryPlace::Device)?,
            rays: Buffer::new(gpu, "lost rays", bytes, U::STORAGE_BUFFER, MemoryPlace::Device)?,
            no_triangle: stored_target(gpu, "no triangle", vk::Format::R32_UINT, [1, 1])?,
            no_sky: Image::new(gpu, &ImageDesc { layers: 6, ..no_sky })?,
        })
    }

    /// Records pass "lost/clear", which empties the list.
    pub fn clear(&self, frame: &mut Frame) -> Result<()> {
        frame.fill("lost/clear", &self.counts, 0)
    }

    /// Returns the bindings of a frame. Without `sky`, the pass "no sky" makes a black one. With `wants_triangle`,
    /// shaders ask for triangle numbers that the G-buffer lacks, and the pass "no triangle" writes that none is known.
    pub fn bindings<'a>(
        &'a self,
        frame: &mut Frame,
        block: &'a CaptureBlock,
        sky: Option<&'a Image>,
        wants_triangle: bool,
    ) -> Result<LostRayBindings<'a>> {
        if sky.is_none() {
            frame.clear("no sky", self.no_sky.all(), [0.0; 4])?;
        }
        if wants_triangle {
            frame.clear("no triangle", self.no_triangle.all(), [f32::from_bits(NO_TRIANGLE); 4])?;
        }
        let sky = Sampled::trilinear(sky.unwrap_or(&self.no_sky).faces());
        Ok(LostRayBindings { block, sky, counts: &self.counts, rays: &self.rays, no_triangle: &self.no_triangle })
    }
}

/// Returns the uniform block by which shaders read captures and the sky, for one camera: directions along the axes of
/// the world, and places in metres from the camera's eye.
pub fn capture_block(camera: &Camera, captures: Option<&Captures>) -> CaptureBlock {
    let mut block = CaptureBlock::default();
    let mut rotation = camera.world_to_view.as_dmat4().inverse();
    rotation.w_axis = glam::DVec4::W;
    block.view_to_world = rotation.as_mat4().to_cols_array_2d();
    block.view_unit = view_unit_m(camera);
    if let Some(captures) = captures {
        let eye = camera.eye();
        for (from_eye, place) in block.places.iter_mut().zip(captures.places) {
            *from_eye = (place.get() - eye).extend(0.0).to_array();
        }
        block.count = captures.places.len().min(block.places.len()) as i32;
        block.face_unit = captures.face_unit;
        let corner = |corner: Vec3| (corner - eye).extend(0.0).to_array();
        (block.least, block.greatest) = (corner(captures.bounds.min), corner(captures.bounds.max));
    }
    block
}

/// Format of the images that say where the rays of each pixel ended (`shaders-glsl/unified/ends.glsl`). R has the
/// distance in view units ([`view_unit_m()`]) as the bits of a float, 0 for a miss, and G the number of the triangle.
pub const ENDS: vk::Format = vk::Format::R32G32_UINT;

/// Returns the metres in one unit of `ViewPoint` (`shaders-glsl/unified/view.glsl`), the view unit: 1 if orthographic,
/// else near (1 + k) with k = near / (far - near), since reversed depth + k is near (1 + k) / z.
pub fn view_unit_m(camera: &Camera) -> f32 {
    match camera.kind() {
        ProjectionKind::Perspective => camera.view_to_clip_reversed().as_dmat4().w_axis.z as f32,
        ProjectionKind::Orthographic => 1.0,
    }
}
