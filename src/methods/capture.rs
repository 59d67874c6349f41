//! Cube maps made at run time: the scene around a place, drawn by the scene passes, or the sky alone;
//! both filtered by roughness. Not part of any frame's time.

use super::SceneInput;
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::sync::Access;
use crate::gpu::{Frame, FrameContext, Gpu, Image, ImageDesc, image};
use crate::passes::cube_filter::{CubeFilterPass, FACE_SIZE};
use crate::passes::gbuffer::{GBufferImages, GBufferPass};
use crate::passes::lighting::LightingPass;
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::scene_data::SceneData;
use crate::passes::{Captures, GBuffer, LIT_COLOR, lost};
use crate::scene::capture::face_camera;
use crate::scene::{Camera, Capture, GBufferData, Material};
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

/// Draws faces of captures by the scene passes, one after the other into the same images.
pub struct CaptureFacePass {
    gbuffer: GBufferPass,
    lighting: LightingPass,
}

impl CaptureFacePass {
    /// For faces of some texels a side.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] for a size that the device does not have.
    pub fn new(gpu: &Gpu, side: u32) -> Result<Self> {
        Ok(Self { gbuffer: GBufferPass::new(gpu, [side; 2])?, lighting: LightingPass::without_sky(gpu)? })
    }

    /// Draws what a camera sees ([`face_camera`]), black where it sees the sky.
    pub fn record(&self, frame: &mut Frame, scene: &SceneInput, camera: &Camera) -> Result<()> {
        self.gbuffer.record(frame, scene.data, scene.materials, camera)?;
        let images = self.gbuffer.gbuffer();
        self.lighting.record(frame, &images, self.gbuffer.albedo(), scene.data, camera)
    }

    /// The images that were drawn.
    pub fn drawn(&self) -> &GBufferPass {
        &self.gbuffer
    }
}

/// The near plane of the faces of some captures, which have one in common: the nearest of all.
pub fn common_near_m(captures: &[Capture]) -> f32 {
    captures.iter().map(|c| c.near_m).fold(f32::INFINITY, f32::min)
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
        let gpu: Gpu = context.gpu().clone();
        let made = Self::empty(&gpu, taken)?;
        let near_m = common_near_m(taken);
        let side = made.color.extent()[0];
        let faces = CaptureFacePass::new(&gpu, side)?;
        let pyramids = PyramidPass::new(&gpu, [side; 2])?;
        for (k, capture) in taken.iter().enumerate() {
            for f in 0..6 {
                let camera = face_camera(capture.position, f, near_m);
                context.once(|frame| {
                    faces.record(frame, scene, &camera)?;
                    made.take_face(frame, &pyramids, &faces.drawn().gbuffer(), 6 * k + f)
                })?;
            }
        }
        made.finish(context)?;
        Ok(made)
    }

    /// The same of faces that come from elsewhere: `face` hands over face 0…5 of a capture, as
    /// [`face_camera`] sees it, and is asked for each once.
    ///
    /// # Errors
    /// As for [`Self::new`], and what `face` returns.
    pub fn of_faces(
        context: &mut FrameContext,
        taken: &[Capture],
        mut face: impl FnMut(usize, usize) -> Result<GBufferData>,
    ) -> Result<Self> {
        let gpu: Gpu = context.gpu().clone();
        let made = Self::empty(&gpu, taken)?;
        let pyramids = PyramidPass::new(&gpu, made.color.extent())?;
        for k in 0..taken.len() {
            for f in 0..6 {
                let images = GBufferImages::upload(context, &face(k, f)?)?;
                context.once(|frame| made.take_face(frame, &pyramids, &images.gbuffer(), 6 * k + f))?;
            }
        }
        made.finish(context)?;
        Ok(made)
    }

    /// Images for some captures, without content.
    fn empty(gpu: &Gpu, taken: &[Capture]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let places: Vec<Vec3> = taken.iter().map(|c| c.position).collect();
        let extent = [taken.first().map_or(1, |c| c.resolution); 2];
        let forward = face_camera(Vec3::ZERO, 4, common_near_m(taken));
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
        Ok(Self {
            pyramid: Image::array(gpu, &desc("capture pyramids", rg32, strips, 1, U::STORAGE))?,
            normal: Image::array(gpu, &desc("capture normals", snorm, extent, 1, U::STORAGE))?,
            color: Image::cubes(gpu, &desc("capture colors", LIT_COLOR, extent, levels, U::SAMPLED))?,
            face: super::unified::parameters(&forward, extent, false),
            face_unit: lost::unit(&forward),
            places,
        })
    }

    /// Takes over the images of a face: layer 6 k + f is face f of capture k.
    fn take_face(&self, frame: &mut Frame, pyramids: &PyramidPass, face: &GBuffer, layer: usize) -> Result<()> {
        let layer = layer as u32;
        let blocks = pyramids.record(frame, face, &self.face)?;
        frame.copy_to_layer("pyramid", blocks.0.level(0), self.pyramid.level(0), layer)?;
        frame.blit_to_layer("normal", face.normal.level(0), self.normal.level(0), layer)?;
        frame.copy_to_layer("color", face.color.level(0), self.color.level(0), layer)
    }

    /// Makes the chain of the colour, once all faces are taken.
    fn finish(&self, context: &mut FrameContext) -> Result<()> {
        let Self { pyramid, normal, color, .. } = self;
        context.once(|frame| {
            for level in 1..color.levels() {
                frame.blit(&format!("color/{level}"), color.level(level - 1), color.level(level))?;
            }
            frame.make_ready(color.all(), Access::ComputeSampled);
            frame.make_ready(pyramid.all(), Access::ComputeStorageRead);
            frame.make_ready(normal.all(), Access::ComputeStorageRead);
            Ok(())
        })?;
        Ok(())
    }

    /// How many captures there are.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// Width and height of a face in texels.
    pub fn extent(&self) -> [u32; 2] {
        self.color.extent()
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
