//! Makes cube maps of the scene around a place or of the sky alone, filtered by roughness, and captures, in which rays
//! are followed. No frame's time includes this, unless frames draw captures anew.

use super::SceneInput;
use crate::error::Result;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::sync::Access;
use crate::gpu::{Frame, FrameContext, Gpu, Image, ImageDesc, image};
use crate::passes::cube_filter::{CubeFilterPass, FACE_SIZE};
use crate::passes::gbuffer::{GBufferImages, GBufferPass};
use crate::passes::keep_normal::KeepNormalPass;
use crate::passes::lighting::LightingPass;
use crate::passes::pyramid::{self, PyramidPass};
use crate::passes::scene_data::{DrawingCost, DrawnCaptures, SceneData};
use crate::passes::{Captures, GBuffer, LIT_COLOR, lost};
use ash::vk;
use glam::Vec3;
use ssct_ground::scene::capture::face_camera;
use ssct_ground::scene::{Aabb, Camera, Capture, GBufferData, Material};
use std::cell::Cell;

/// Near plane of the faces of a cube map, in metres.
const NEAR_M: f32 = 0.01;

/// Draws the scene around some places, lit and with the sky, into a cube map for each place, filtered by roughness.
pub fn capture_cube_maps(context: &mut FrameContext, scene: &SceneInput, places: &[Vec3]) -> Result<Vec<Image>> {
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

/// Draws faces of captures by the scene passes, each face into the same images.
pub struct CaptureFacePass {
    gbuffer: GBufferPass,
    lighting: LightingPass,
}

impl CaptureFacePass {
    /// Makes the passes for faces of `side` × `side` texels.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] for a size that the device does not have.
    pub fn new(gpu: &Gpu, side: u32) -> Result<Self> {
        Ok(Self {
            gbuffer: GBufferPass::new(gpu, [side; 2])?.labelled("capture/g-buffer"),
            lighting: LightingPass::without_sky(gpu)?.labelled("capture/lighting"),
        })
    }

    /// Records the passes that draw a face, seen by the camera that [`face_camera`] makes for it. The sky stays black.
    pub fn record(&self, frame: &mut Frame, scene: &SceneInput, camera: &Camera) -> Result<()> {
        self.gbuffer.record(frame, scene.data, scene.materials, camera)?;
        let images = self.gbuffer.gbuffer();
        self.lighting.record(frame, &images, self.gbuffer.albedo(), scene.data, camera)
    }

    /// The pass that holds the images of the face drawn last.
    pub fn drawn(&self) -> &GBufferPass {
        &self.gbuffer
    }
}

/// Returns the near plane, in metres, that the faces of all captures share: the nearest of theirs.
pub fn common_near_m(captures: &[Capture]) -> f32 {
    captures.iter().map(|c| c.near_m).fold(f32::INFINITY, f32::min)
}

fn positions(captures: &[Capture]) -> Vec<Vec3> {
    captures.iter().map(|c| c.position).collect()
}

/// Returns a camera with the projection of the faces of captures, which looks from the origin along +z (face 4).
fn forward_camera(captures: &[Capture]) -> Camera {
    face_camera(Vec3::ZERO, 4, common_near_m(captures))
}

/// The images of captures, in which rays are followed (docs/definitions.md, "Images").
pub struct CaptureImages {
    pyramid: Image,
    normal: Image,
    color: Image,
    /// The places of the captures in the world, in metres.
    places: Vec<Cell<Vec3>>,
    /// The parameters of `unified` for a face, and the metres in one view unit of a face ([`lost::view_unit_m()`]).
    face: UnifiedBlock,
    face_unit: f32,
    /// A box in the world, in metres, outside of which nothing stands: the scene's bounds when a face was last drawn.
    bounds: Cell<Aabb>,
    /// Whether the scene keeps these images too, so that other effects may look into them.
    is_shared: bool,
}

impl CaptureImages {
    /// Makes the images of some captures, from one to `MAX_CAPTURES`, and draws the scene into them. All have the face
    /// size of the first capture, and the nearest of the near planes.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] for a size that the device does not have.
    pub fn new(context: &mut FrameContext, scene: &SceneInput, captures: &[Capture]) -> Result<Self> {
        let passes = FacePasses::new(context.gpu(), captures)?;
        let images = Self::undrawn(context.gpu(), captures)?;
        images.draw(context, scene, &passes)?;
        Ok(images)
    }

    /// Returns captures that this effect neither renews nor moves. The scene keeps the images, and hands them to the
    /// next effect with captures of these places. The second result is the cost of images that were drawn earlier. It
    /// is 0 for images that are drawn here, since the caller measures their cost with its own.
    pub(crate) fn shared(
        context: &mut FrameContext,
        scene: &SceneInput,
        captures: &[Capture],
    ) -> Result<(Self, DrawingCost)> {
        let materials = captured_materials(scene.materials);
        if let Some(drawn) = scene.data.drawn_captures(captures, &materials) {
            let DrawnCaptures { pyramid, normal, color, cost, .. } = drawn;
            let (places, forward) = (positions(captures), forward_camera(captures));
            let images = Self { is_shared: true, ..Self::of_images(places, &forward, [pyramid, normal, color]) };
            return Ok((images.with_bounds(scene.data.bounds()), cost));
        }
        let (drawn, cost) = DrawingCost::measure(context, |context| Self::new(context, scene, captures))?;
        let images = Self { is_shared: true, ..drawn };
        scene.data.keep_captures(DrawnCaptures {
            captures: captures.to_vec(),
            materials,
            pyramid: images.pyramid.clone(),
            normal: images.normal.clone(),
            color: images.color.clone(),
            cost,
        });
        Ok((images, DrawingCost::default()))
    }

    /// Whether other effects may look into these images, so that they must not be drawn again.
    pub(crate) fn is_shared(&self) -> bool {
        self.is_shared
    }

    /// Makes the images without content, which must be drawn before use. All have the face size of the first capture.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn undrawn(gpu: &Gpu, captures: &[Capture]) -> Result<Self> {
        let side = captures.first().map_or(1, |c| c.resolution);
        Self::of_camera(gpu, positions(captures), side, &forward_camera(captures))
    }

    /// Moves a capture to another place. Its faces must be drawn there before rays are followed in it.
    pub fn place_at(&self, capture: usize, place: Vec3) {
        self.places[capture].set(place);
    }

    /// Draws all faces of all captures.
    fn draw(&self, context: &mut FrameContext, scene: &SceneInput, passes: &FacePasses) -> Result<()> {
        // Each face has a frame of its own, so that no frame is long enough for a driver to take it for hung.
        for face in 0..self.faces() {
            context.once(|frame| passes.record(frame, scene, self, face))?;
        }
        self.make_ready(context)
    }

    /// Sets a box in the world, in metres, outside of which nothing stands: a ray lost there ends in the sky. Captures
    /// drawn from a scene have the scene's bounds; others have none without this call.
    pub fn with_bounds(self, bounds: Aabb) -> Self {
        self.bounds.set(bounds);
        self
    }

    /// Makes captures of faces that the caller gives. `face` is called with the number of each capture and of each of
    /// its faces, 0 to 5, and returns the G-buffer that the camera of [`face_camera`] sees.
    ///
    /// # Errors
    /// Errors of [`Self::new`], and what `face` returns.
    pub fn of_faces(
        context: &mut FrameContext,
        captures: &[Capture],
        mut face: impl FnMut(usize, usize) -> Result<GBufferData>,
    ) -> Result<Self> {
        let gpu: Gpu = context.gpu().clone();
        let images = Self::undrawn(&gpu, captures)?;
        let keep = FaceKeeper::new(&gpu, images.extent())?;
        for number in 0..6 * captures.len() {
            let uploaded = GBufferImages::upload(context, &face(number / 6, number % 6)?)?;
            context.once(|frame| images.take_face(frame, &keep, &uploaded.gbuffer(), number as u32))?;
        }
        images.make_ready(context)?;
        Ok(images)
    }

    /// Makes the images without content, for captures at `places`, in world metres, whose faces have `side` texels a
    /// side and the projection of the camera `forward`.
    pub(crate) fn of_camera(gpu: &Gpu, places: Vec<Vec3>, side: u32, forward: &Camera) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let extent = [side; 2];
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
        let images = [
            Image::array(gpu, &desc("capture pyramids", rg32, strips, 1, U::STORAGE))?,
            Image::array(gpu, &desc("capture normals", snorm, extent, 1, U::STORAGE))?,
            Image::cubes(gpu, &desc("capture colors", LIT_COLOR, extent, levels, U::SAMPLED))?,
        ];
        Ok(Self::of_images(places, forward, images))
    }

    /// Makes captures of images that exist: pyramids, normals and colours.
    fn of_images(places: Vec<Vec3>, forward: &Camera, [pyramid, normal, color]: [Image; 3]) -> Self {
        Self {
            face: super::unified::parameters(forward, color.extent(), false),
            face_unit: lost::view_unit_m(forward),
            places: places.into_iter().map(Cell::new).collect(),
            bounds: Cell::new(Aabb::ALL),
            is_shared: false,
            pyramid,
            normal,
            color,
        }
    }

    /// Records the passes that copy a face, number 6 k + f for face f of capture k, into its layer, and make the
    /// pyramid and the mip chain of its colour. No other face changes, since each face has a mip chain of its own.
    pub(crate) fn take_face(&self, frame: &mut Frame, keep: &FaceKeeper, face: &GBuffer, number: u32) -> Result<()> {
        let Self { pyramid, normal, color, .. } = self;
        let face_pyramid = keep.pyramid.record(frame, face, &self.face)?;
        frame.copy_to_layer("capture/keep pyramid", face_pyramid.0.level(0), pyramid.level(0), number)?;
        keep.normal.record(frame, face, normal, number)?;
        frame.copy_to_layer("capture/keep color", face.color.level(0), color.level(0), number)?;
        for level in 1..color.levels() {
            frame.blit_layer("capture/color", color.level(level - 1), color.level(level), number)?;
        }
        Ok(())
    }

    /// Makes the images ready to be read by the passes that follow rays in them.
    fn make_ready(&self, context: &mut FrameContext) -> Result<()> {
        context.once(|frame| {
            frame.make_ready(self.color.all(), Access::ComputeSampled);
            frame.make_ready(self.pyramid.all(), Access::ComputeStorageRead);
            frame.make_ready(self.normal.all(), Access::ComputeStorageRead);
            Ok(())
        })?;
        Ok(())
    }

    /// Returns the number of faces: six for each capture.
    pub fn faces(&self) -> u32 {
        6 * self.places.len() as u32
    }

    /// Returns the number of captures.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// Width and height of a face in texels.
    pub fn extent(&self) -> [u32; 2] {
        self.color.extent()
    }

    /// Returns the captures in the form in which methods read them.
    pub fn captures(&self) -> Captures<'_> {
        let Self { pyramid, normal, color, places, face, face_unit, bounds, .. } = self;
        Captures { pyramid, normal, color, places, face, face_unit: *face_unit, bounds: bounds.get() }
    }
}

/// The passes that make the pyramid and the normals of a capture from the depth and the normals of a face.
pub(crate) struct FaceKeeper {
    pyramid: PyramidPass,
    normal: KeepNormalPass,
}

impl FaceKeeper {
    /// Makes the passes for faces of a size in texels.
    pub(crate) fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        let pyramid = PyramidPass::new(gpu, extent)?.labelled("capture/pyramid");
        Ok(Self { pyramid, normal: KeepNormalPass::new(gpu)? })
    }
}

/// The passes that draw one face of a capture and keep its images.
struct FacePasses {
    scene: CaptureFacePass,
    keep: FaceKeeper,
    near_m: f32,
}

impl FacePasses {
    /// Makes the passes for faces of the first capture's size, and for the nearest of the near planes.
    fn new(gpu: &Gpu, captures: &[Capture]) -> Result<Self> {
        let side = captures.first().map_or(1, |c| c.resolution);
        Ok(Self {
            scene: CaptureFacePass::new(gpu, side)?,
            keep: FaceKeeper::new(gpu, [side; 2])?,
            near_m: common_near_m(captures),
        })
    }

    /// Records the passes that draw a face, number 6 k + f for face f of capture k, and copy it into its layer.
    fn record(&self, frame: &mut Frame, scene: &SceneInput, into: &CaptureImages, number: u32) -> Result<()> {
        let camera = face_camera(into.places[number as usize / 6].get(), number as usize % 6, self.near_m);
        self.scene.record(frame, scene, &camera)?;
        into.bounds.set(scene.data.bounds());
        into.take_face(frame, &self.keep, &self.scene.drawn().gbuffer(), number)
    }
}

/// Draws captures anew: all faces of captures that move, and in each frame a few faces, in turn over all captures. The
/// age of a face in frames is at most the number of all faces over that of faces a frame, rounded up.
pub struct Renewal {
    passes: FacePasses,
    faces_per_frame: u32,
    next_face: Cell<u32>,
}

impl Renewal {
    /// Makes the passes that draw captures anew, `faces_per_frame` faces in each frame, and none twice in a frame.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn new(gpu: &Gpu, captures: &[Capture], faces_per_frame: u32) -> Result<Self> {
        Ok(Self { passes: FacePasses::new(gpu, captures)?, faces_per_frame, next_face: Cell::new(0) })
    }

    /// Moves all captures to `places`, in the same order, and draws all their faces there, outside of any frame's time.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn move_to(
        &self,
        context: &mut FrameContext,
        scene: &SceneInput,
        captures: &CaptureImages,
        places: &[Vec3],
    ) -> Result<()> {
        assert_eq!(captures.places.len(), places.len(), "as many places as captures");
        for (capture, place) in places.iter().enumerate() {
            captures.place_at(capture, *place);
        }
        captures.draw(context, scene, &self.passes)
    }

    /// Records passes "capture/…" for the faces that are next in turn: scene passes, pyramid, copies and colour chain.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn record(&self, frame: &mut Frame, scene: &SceneInput, into: &CaptureImages) -> Result<()> {
        let face_count = into.faces();
        for _ in 0..self.faces_per_frame.min(face_count) {
            let face = self.next_face.get() % face_count;
            self.passes.record(frame, scene, into, face)?;
            self.next_face.set(face + 1);
        }
        Ok(())
    }
}

/// Makes the sky's cube map, filtered by roughness. One map serves all places, since the sky is infinitely far away.
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

/// Returns the materials without what captures do not show. A captured map stays valid while this result is the same.
pub fn captured_materials(materials: &[Material]) -> Vec<Material> {
    let captured = |m: &Material| Material { reflectivity: 0.0, reflectivity_map: None, roughness: 0.0, ..m.clone() };
    materials.iter().map(captured).collect()
}
