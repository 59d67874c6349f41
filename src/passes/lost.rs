//! Inputs that the passes that trace the screen share with those that follow rays through captures: the list of rays that the
//! screen lost, the camera among the captures, and the sky.

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

/// Bytes of a pixel in a list (`Doubt` of `shaders-glsl/triangles/doubt.glsl`).
const DOUBT_BYTES: u64 = 16;

/// The kind of elements on a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListContent {
    /// Nothing: no ray is followed beyond the screen.
    Nothing,
    /// Pixels that get rays of their own ([`own_rays`](super::own_rays)).
    Pixels,
    /// Rays that the screen lost; once these have been followed, pixels that get rays of their own.
    Rays,
}

/// The buffers and images with which passes that trace the screen show the sky along a ray, and hand on rays that the screen lost.
pub struct LostRays {
    counts: Buffer,
    rays: Buffer,
    /// A black cube map, bound if there is no sky of a scene.
    no_sky: Image,
    /// An image of one texel, `NO_TRIANGLE`, bound if the G-buffer has no triangle numbers.
    no_triangle: Image,
}

/// The bindings of [`LostRays`] in a frame.
#[derive(Clone, Copy)]
pub struct LostRayBindings<'a> {
    /// The camera among the captures.
    pub block: &'a CaptureBlock,
    /// The faces of the sky's cube map in world axes.
    pub sky: Sampled<'a>,
    /// The number of rays on the list.
    pub counts: &'a Buffer,
    /// The rays.
    pub rays: &'a Buffer,
    /// An image bound if the G-buffer has no triangle numbers.
    no_triangle: &'a Image,
}

impl<'a> LostRayBindings<'a> {
    /// The bindings that are common to all programs that write or read the list of rays.
    pub(super) fn resources(&self) -> LostRayResources<'a> {
        LostRayResources { captures: self.block, environment: self.sky, lost_counts: self.counts, lost: self.rays }
    }

    /// The bindings that are common to all programs that trace rays from the pixels of the screen.
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
            triangle_buffer: self.triangle_of(gbuffer),
        }
    }

    /// The image of the triangles that pixels show.
    fn triangle_of<'i>(&self, gbuffer: &GBuffer<'i>) -> ImageSlice<'i>
    where
        'a: 'i,
    {
        gbuffer.triangle.unwrap_or(self.no_triangle).all()
    }
}

impl LostRays {
    /// Makes the buffers, with room on the list for an element of each pixel.
    pub fn new(gpu: &Gpu, extent: [u32; 2], content: ListContent) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        // Tiles at the border overlap, so that a ray may be on the list twice.
        let tiles: u64 = tiles::count(extent).into_iter().map(u64::from).product();
        let pixels = tiles * u64::from(TILE * TILE);
        // The buffer has room for one element of each kind at least, since shaders declare both.
        let bytes = match content {
            ListContent::Nothing => RAY_BYTES,
            ListContent::Pixels => DOUBT_BYTES * pixels,
            ListContent::Rays => RAY_BYTES * pixels,
        };
        let usage = U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST;
        Ok(Self {
            counts: Buffer::new(gpu, "lost counts", 16, usage, MemoryPlace::Device)?,
            rays: Buffer::new(gpu, "lost rays", bytes, U::STORAGE_BUFFER, MemoryPlace::Device)?,
            no_triangle: stored_target(gpu, "no triangle", vk::Format::R32_UINT, [1, 1])?,
            no_sky: Image::new(
                gpu,
                &ImageDesc {
                    name: "no sky",
                    format: vk::Format::R16G16B16A16_SFLOAT,
                    extent: [1, 1],
                    levels: 1,
                    layers: 6,
                    usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
                },
            )?,
        })
    }

    /// Records pass "lost/clear", which empties the list.
    pub fn clear(&self, frame: &mut Frame) -> Result<()> {
        frame.fill("lost/clear", &self.counts, 0)
    }

    /// Returns the bindings of a pass. Without a scene's sky, the pass "no sky" makes a black one. `wants_triangle` says that rays
    /// begin on triangles that the G-buffer does not know; the pass "no triangle" then tells shaders so.
    pub fn beyond<'a>(
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

/// Fills the uniform block through which shaders read captures and the sky, for one camera. Without captures, their
/// number is 0.
pub fn capture_block(camera: &Camera, captures: Option<&Captures>) -> CaptureBlock {
    let mut block = CaptureBlock::default();
    let mut rotation = camera.world_to_view.as_dmat4().inverse();
    rotation.w_axis = glam::DVec4::W;
    block.view_to_world = rotation.as_mat4().to_cols_array_2d();
    block.view_unit = view_unit_m(camera);
    if let Some(captures) = captures {
        let eye = camera.eye();
        for (place, position) in block.places.iter_mut().zip(captures.places) {
            *place = (position.get() - eye).extend(0.0).to_array();
        }
        block.count = captures.places.len().min(block.places.len()) as i32;
        block.face_unit = captures.face_unit;
        let corner = |corner: Vec3| (corner - eye).extend(0.0).to_array();
        (block.least, block.greatest) = (corner(captures.bounds.min), corner(captures.bounds.max));
    }
    block
}

/// Format of the images that say where the rays of each pixel ended (`shaders-glsl/unified/ends.glsl`): the distance in units of
/// [`view_unit_m()`], as the bits of a float, 0 for none; and the number of a triangle.
pub const ENDS: vk::Format = vk::Format::R32G32_UINT;

/// Metres to one unit of `ViewPoint` (`shaders-glsl/unified/view.glsl`): 1 for an orthographic projection. For a perspective the
/// unit is near (1 + k) with k = near / (far - near), since reversed depth plus k is near (1 + k) / z.
pub fn view_unit_m(camera: &Camera) -> f32 {
    match camera.kind() {
        ProjectionKind::Perspective => camera.view_to_clip_reversed().as_dmat4().w_axis.z as f32,
        ProjectionKind::Orthographic => 1.0,
    }
}
