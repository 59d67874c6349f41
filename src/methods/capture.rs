//! Cube maps made at run time: the scene around a place, drawn by the scene passes, or the sky alone;
//! both filtered by roughness. Not part of any frame's time.

use super::SceneInput;
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::sync::Access;
use crate::gpu::{FrameContext, Gpu, Image, ImageDesc, image};
use crate::passes::cube_filter::{CubeFilterPass, FACE_SIZE};
use crate::passes::gbuffer::GBufferPass;
use crate::passes::lighting::LightingPass;
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::scene_data::SceneData;
use crate::passes::{Captures, LIT_COLOR, lost};
use crate::scene::capture::face_camera;
use crate::scene::{Capture, Material};
use ash::vk;
use glam::Vec3;

/// Near plane of the faces of a cube map, in metres.
const NEAR_M: f32 = 0.01;

/// Draws the scene around some places, with its lighting, and filters what was drawn: one map a place.
pub fn capture(context: &mut FrameContext, scene: &SceneInput, places: &[Vec3]) -> Result<Vec<Image>> {
    let gpu: Gpu = context.gpu().clone();
    let gbuffer = GBufferPass::new(&gpu, [FACE_SIZE; 2])?;
    let lighting = LightingPass::new(&gpu)?;
    let filter = CubeFilterPass::new(&gpu)?;
    let source = CubeFilterPass::source(&gpu)?;
    let mut maps = Vec::with_capacity(places.len());
    for place in places {
        for face in 0..6 {
            let camera = face_camera(*place, face, NEAR_M);
            context.once(|frame| {
                gbuffer.record(frame, scene.data, scene.materials, &camera)?;
                let images = gbuffer.gbuffer();
                lighting.record(frame, &images, gbuffer.albedo(), scene.data, &camera)?;
                frame.copy_to_layer("face", images.color.level(0), source.level(0), face as u32)
            })?;
        }
        let map = CubeFilterPass::target(&gpu, "cube map")?;
        context.once(|frame| filter.record(frame, &source, &map))?;
        maps.push(map);
    }
    Ok(maps)
}

/// Captures of a scene with all that rays are followed by in them (docs/definitions.md, "Images").
pub struct CaptureImages {
    pyramid: Image,
    normal: Image,
    color: Image,
    places: Vec<Vec3>,
    face: UnifiedBlock,
    face_unit: f32,
}

impl CaptureImages {
    /// Draws the scene around the places of some captures, at least one and at most `MAX_CAPTURES`, with the size of the
    /// first and the nearest of their near planes.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] for a size that the device does not have.
    pub fn new(context: &mut FrameContext, scene: &SceneInput, taken: &[Capture]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let gpu: Gpu = context.gpu().clone();
        let places: Vec<Vec3> = taken.iter().map(|c| c.position).collect();
        let extent = [taken.first().map_or(1, |c| c.resolution); 2];
        let near_m = taken.iter().map(|c| c.near_m).fold(f32::INFINITY, f32::min);
        let forward = face_camera(Vec3::ZERO, 4, near_m);
        let gbuffer = GBufferPass::new(&gpu, extent)?;
        let lighting = LightingPass::without_sky(&gpu)?;
        let pyramids = PyramidPass::new(&gpu, extent)?;
        let desc = |name, format, extent, levels, usage| ImageDesc {
            name,
            format,
            extent,
            levels,
            layers: 6 * places.len() as u32,
            usage: usage | U::TRANSFER_DST | U::TRANSFER_SRC,
        };
        let rg32 = vk::Format::R32G32_SFLOAT;
        let snorm = vk::Format::R8G8B8A8_SNORM;
        let strips = pyramid::size(extent, pyramid::strip(extent));
        let levels = image::full_chain(extent);
        let pyramid = Image::array(&gpu, &desc("capture pyramids", rg32, strips, 1, U::STORAGE))?;
        let normal = Image::array(&gpu, &desc("capture normals", snorm, extent, 1, U::STORAGE))?;
        let color = Image::cubes(&gpu, &desc("capture colors", LIT_COLOR, extent, levels, U::SAMPLED))?;
        let face = super::unified::parameters(&forward, extent, false);
        for (k, place) in places.iter().enumerate() {
            for f in 0..6 {
                let camera = face_camera(*place, f, near_m);
                let layer = (6 * k + f) as u32;
                context.once(|frame| {
                    gbuffer.record(frame, scene.data, scene.materials, &camera)?;
                    let images = gbuffer.gbuffer();
                    lighting.record(frame, &images, gbuffer.albedo(), scene.data, &camera)?;
                    let blocks = pyramids.record(frame, &images, &face)?;
                    frame.copy_to_layer("pyramid", blocks.0.level(0), pyramid.level(0), layer)?;
                    frame.blit_to_layer("normal", images.normal.level(0), normal.level(0), layer)?;
                    frame.copy_to_layer("color", images.color.level(0), color.level(0), layer)
                })?;
            }
        }
        context.once(|frame| {
            for level in 1..color.levels() {
                frame.blit(&format!("color/{level}"), color.level(level - 1), color.level(level))?;
            }
            frame.make_ready(color.all(), Access::ComputeSampled);
            frame.make_ready(pyramid.all(), Access::ComputeStorageRead);
            frame.make_ready(normal.all(), Access::ComputeStorageRead);
            Ok(())
        })?;
        Ok(Self { pyramid, normal, color, places, face, face_unit: lost::unit(&forward) })
    }

    /// The captures as methods take them.
    pub fn captures(&self) -> Captures<'_> {
        let Self { pyramid, normal, color, places, face, face_unit } = self;
        Captures { pyramid, normal, color, places, face, face_unit: *face_unit }
    }
}

/// Filters the sky: what is seen at infinity, from everywhere the same.
pub fn filtered_sky(context: &mut FrameContext, scene: &SceneData) -> Result<Image> {
    let gpu: Gpu = context.gpu().clone();
    let filter = CubeFilterPass::new(&gpu)?;
    let source = CubeFilterPass::source(&gpu)?;
    let map = CubeFilterPass::target(&gpu, "environment map")?;
    context.once(|frame| {
        frame.blit("sky", scene.sky().level(0), source.level(0))?;
        filter.record(frame, &source, &map)
    })?;
    Ok(map)
}

/// The materials with all that a capture does not show set to nothing: a map stays right while this
/// stays the same.
pub fn captured_of(materials: &[Material]) -> Vec<Material> {
    let bare = |m: &Material| Material { reflectivity: 0.0, reflectivity_map: None, roughness: 0.0, ..m.clone() };
    materials.iter().map(bare).collect()
}
