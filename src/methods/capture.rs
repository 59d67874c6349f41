//! Cube maps made at run time: the scene around a place, drawn by the scene passes, or the sky alone;
//! both filtered by roughness; and captures that rays are followed in. Not part of any frame's time, unless captures are
//! renewed in frames ([`Renewal`]).

use super::SceneInput;
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::sync::Access;
use crate::gpu::{Frame, FrameContext, Gpu, Image, ImageDesc, image};
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
use std::cell::Cell;

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
        let passes = FacePasses::new(context.gpu(), taken)?;
        let made = Self::without_content(context.gpu(), taken)?;
        made.draw(context, scene, &passes)?;
        Ok(made)
    }

    /// Draws every face.
    fn draw(&self, context: &mut FrameContext, scene: &SceneInput, passes: &FacePasses) -> Result<()> {
        // A frame for each face, so that none is long enough for a driver to take it for hung.
        for face in 0..self.faces() {
            context.once(|frame| passes.record(frame, scene, self, face))?;
        }
        context.once(|frame| {
            frame.make_ready(self.color.all(), Access::ComputeSampled);
            frame.make_ready(self.pyramid.all(), Access::ComputeStorageRead);
            frame.make_ready(self.normal.all(), Access::ComputeStorageRead);
            Ok(())
        })
    }

    fn without_content(gpu: &Gpu, taken: &[Capture]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let places: Vec<Vec3> = taken.iter().map(|c| c.position).collect();
        let extent = face_extent(taken);
        let forward = face_camera(Vec3::ZERO, 4, near_m(taken));
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

    /// How many faces there are: six of each capture.
    pub fn faces(&self) -> u32 {
        6 * self.places.len() as u32
    }

    /// The captures as methods take them.
    pub fn captures(&self) -> Captures<'_> {
        let Self { pyramid, normal, color, places, face, face_unit } = self;
        Captures { pyramid, normal, color, places, face, face_unit: *face_unit }
    }
}

/// Width and height of the faces of some captures.
fn face_extent(taken: &[Capture]) -> [u32; 2] {
    [taken.first().map_or(1, |c| c.resolution); 2]
}

/// The near plane that the faces of some captures have in common, in metres.
fn near_m(taken: &[Capture]) -> f32 {
    taken.iter().map(|c| c.near_m).fold(f32::INFINITY, f32::min)
}

/// What draws one face of a capture: the scene passes and the pyramid, with the images of one face.
struct FacePasses {
    gbuffer: GBufferPass,
    lighting: LightingPass,
    pyramid: PyramidPass,
    near_m: f32,
}

impl FacePasses {
    fn new(gpu: &Gpu, taken: &[Capture]) -> Result<Self> {
        let extent = face_extent(taken);
        Ok(Self {
            gbuffer: GBufferPass::new(gpu, extent)?.labelled("capture/g-buffer"),
            lighting: LightingPass::without_sky(gpu)?.labelled("capture/lighting"),
            pyramid: PyramidPass::new(gpu, extent)?.labelled("capture/pyramid"),
            near_m: near_m(taken),
        })
    }

    /// Draws a face (face f of capture k is number 6 k + f) and its part of the colour's chain. No other face changes:
    /// the chain is made of each face alone.
    fn record(&self, frame: &mut Frame, scene: &SceneInput, into: &CaptureImages, face: u32) -> Result<()> {
        let CaptureImages { pyramid, normal, color, places, face: block, .. } = into;
        let camera = face_camera(places[face as usize / 6], face as usize % 6, self.near_m);
        self.gbuffer.record(frame, scene.data, scene.materials, &camera)?;
        let images = self.gbuffer.gbuffer();
        self.lighting.record(frame, &images, self.gbuffer.albedo(), scene.data, &camera)?;
        let blocks = self.pyramid.record(frame, &images, block)?;
        frame.copy_to_layer("capture/keep pyramid", blocks.0.level(0), pyramid.level(0), face)?;
        frame.blit_to_layer("capture/keep normal", images.normal.level(0), normal.level(0), face)?;
        frame.copy_to_layer("capture/keep color", images.color.level(0), color.level(0), face)?;
        for level in 1..color.levels() {
            frame.blit_layer("capture/color", color.level(level - 1), color.level(level), face)?;
        }
        Ok(())
    }
}

/// Draws captures again: all of them where they are moved, and while frames are drawn so many faces a frame, in turn over all faces of all captures, so that
/// what moves is seen in them, if late. A face is at most as old as there are faces over those of a frame, rounded up.
pub struct Renewal {
    passes: FacePasses,
    faces_per_frame: u32,
    /// The face that comes next.
    next: Cell<u32>,
}

impl Renewal {
    /// What renews the captures of [`CaptureImages::new`] of the same places, by so many faces a frame, of which none
    /// is renewed twice in one.
    ///
    /// # Errors
    /// Those of the device.
    pub fn new(gpu: &Gpu, taken: &[Capture], faces_per_frame: u32) -> Result<Self> {
        Ok(Self { passes: FacePasses::new(gpu, taken)?, faces_per_frame, next: Cell::new(0) })
    }

    /// Moves captures to other places, as many as there are, and draws all of their faces there. Not part of any frame's
    /// time.
    ///
    /// # Errors
    /// Those of the device.
    pub fn move_to(
        &self,
        context: &mut FrameContext,
        scene: &SceneInput,
        captures: &mut CaptureImages,
        places: &[Vec3],
    ) -> Result<()> {
        assert_eq!(captures.places.len(), places.len(), "as many places as captures");
        captures.places = places.to_vec();
        captures.draw(context, scene, &self.passes)
    }

    /// Passes "capture/…", for each face that it is the turn of: scene passes, pyramid, copies and colour chain.
    /// Draws `scene` as it is now.
    ///
    /// # Errors
    /// Those of the device.
    pub fn record(&self, frame: &mut Frame, scene: &SceneInput, into: &CaptureImages) -> Result<()> {
        let all = into.faces();
        for _ in 0..self.faces_per_frame.min(all) {
            let face = self.next.get() % all;
            self.passes.record(frame, scene, into, face)?;
            self.next.set(face + 1);
        }
        Ok(())
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
