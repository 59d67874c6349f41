//! Images of the scene around places, from another renderer.

use super::input::BorrowedImages;
use super::{CameraInput, Context, ImageInput};
use crate::error::{Error, Result};
use crate::gpu::FrameContext;
use crate::gpu::frame::Mode;
use crate::methods::capture::{CaptureImages, FaceKeeper};
use crate::passes::Reflectors;
use crate::passes::import::{Factor, ForeignImages, ImportPass};
use ash::vk;
use glam::Vec3;
use ssct_ground::conventions::ClipY;
use ssct_ground::scene::Aabb;
use ssct_ground::scene::capture::{MAX_CAPTURES, MAX_RESOLUTION};

/// The description of capture cubes that are to be made.
#[derive(Debug, Clone, Copy)]
pub struct CaptureCubesInfo<'a> {
    /// The places of the captures in world space, 1 to 8.
    pub places: &'a [[f32; 3]],
    /// Width and height of each face in texels, 1 to 4096.
    pub side: u32,
    /// The projection that all faces were drawn with. Its angle of view is a quarter turn, and its numbers have the
    /// order of those of [`CameraInput::view_to_clip`].
    pub view_to_clip: [f32; 16],
    /// The place of a face's top in clip space.
    pub clip_y: ClipY,
    /// A box in world space outside of which nothing stands, so that rays that leave it end in the sky: its least and
    /// its greatest corner. `None` if there is no such box.
    pub bounds: Option<[[f32; 3]; 2]>,
    /// How many frames that renew faces may be under way at once.
    pub frames_in_flight: usize,
}

/// A face of a capture.
#[derive(Debug, Clone, Copy)]
pub struct CaptureFaceInput {
    /// The capture's number, from 0.
    pub capture: usize,
    /// The face's number, 0 to 5: +x −x +y −y +z −z. Faces are turned as in a cube map of Vulkan in world directions.
    pub face: usize,
    /// The colour of the surfaces in the face, linear, in light that does not depend on the viewer.
    pub color: ImageInput,
    /// The depth of the face.
    pub depth: ImageInput,
}

/// Cubes of images of the scene around places, in which `unified` and `captures` follow the rays that the screen loses.
/// The caller draws the faces, and hands over each face at least once, and again whenever it likes.
pub struct CaptureCubes {
    frames: FrameContext,
    import: ImportPass,
    keep: FaceKeeper,
    images: CaptureImages,
    camera: super::camera::ConvertedCamera,
    /// A bit for each face that was handed over: bit 6 · capture + face.
    given_faces: u64,
}

impl CaptureCubes {
    /// Makes the images; they have no content yet.
    ///
    /// # Errors
    /// [`Error::Usage`] for a wrong number of places, side, projection or bounds; [`Error::Memory`].
    pub fn new(context: &Context, info: &CaptureCubesInfo) -> Result<Self> {
        let count = info.places.len();
        if count == 0 || count > MAX_CAPTURES {
            return Err(Error::Usage(format!("there are {count} captures; there must be 1 to {MAX_CAPTURES}")));
        }
        if info.side == 0 || info.side > MAX_RESOLUTION {
            return Err(Error::Usage(format!(
                "a face has {} texels a side; it must have 1 to {MAX_RESOLUTION}",
                info.side
            )));
        }
        let places: Vec<Vec3> = info.places.iter().map(|place| Vec3::from(*place)).collect();
        if places.iter().any(|place| !place.is_finite()) {
            return Err(Error::Usage("a capture's place has numbers that are not finite".into()));
        }
        let bounds = info.bounds.map_or(Some(Aabb::ALL), Aabb::between).ok_or_else(|| {
            Error::Usage(
                "the captures' bounds are not the least and the greatest corner of a box, of finite numbers".into(),
            )
        })?;
        let identity = glam::Mat4::IDENTITY.to_cols_array();
        let input = CameraInput { world_to_view: identity, view_to_clip: info.view_to_clip, clip_y: info.clip_y };
        let camera = input.converted()?;
        let projection = camera.camera.view_to_clip_reversed();
        let is_quarter_turn = [projection.x_axis.x, projection.y_axis.y].iter().all(|scale| (scale - 1.0).abs() < 1e-5);
        let is_shifted = projection.z_axis.x != 0.0 || projection.z_axis.y != 0.0;
        if camera.camera.kind().is_orthographic() || !is_quarter_turn || is_shifted {
            return Err(Error::Usage("the captures' view_to_clip is not that of a quarter turn".into()));
        }
        let (gpu, extent) = (&context.gpu, [info.side; 2]);
        Ok(Self {
            frames: FrameContext::for_caller(gpu, info.frames_in_flight)?,
            import: ImportPass::new(gpu, extent)?.labelled("capture/import"),
            keep: FaceKeeper::new(gpu, extent)?,
            images: CaptureImages::of_camera(gpu, places, info.side, &camera.camera)?.with_bounds(bounds),
            camera,
            given_faces: 0,
        })
    }

    /// Records the commands that copy a face into the captures. Submit them before the frames that are to see the face.
    /// `slot` numbers the faces that are under way, as [`FrameInput::slot`](super::FrameInput::slot) does frames.
    ///
    /// # Errors
    /// [`Error::Usage`] with what is wrong with an input; nothing is recorded then.
    ///
    /// # Safety
    /// The contract is that of [`Reflections::record`](super::Reflections::record).
    pub unsafe fn record_face(
        &mut self,
        commands: vk::CommandBuffer,
        slot: usize,
        input: &CaptureFaceInput,
    ) -> Result<()> {
        let CaptureFaceInput { capture, face, color, depth } = input;
        let captures = self.images.count();
        if *capture >= captures || *face >= 6 {
            return Err(Error::Usage(format!(
                "there is no face {face} of capture {capture}: CaptureCubesInfo::places has {captures}, with 6 faces each"
            )));
        }
        let number = (6 * capture + face) as u32;
        let extent = Some(self.images.extent());
        color.check("color", extent)?;
        depth.check("depth", extent)?;
        let gpu = self.frames.gpu().clone();
        let mut borrowed = BorrowedImages::default();
        let color = borrowed.add(&gpu, "color", color)?;
        let depth = borrowed.add(&gpu, "depth", depth)?;
        // SAFETY: the caller keeps to the contract of this function.
        let mut frame = unsafe { self.frames.begin_in(commands, slot, Mode::Plain) }?;
        borrowed.begin(&mut frame);
        let foreign = ForeignImages {
            depth: borrowed.image(depth),
            to_reversed: self.camera.to_reversed,
            normal: None,
            material: [Factor::Constant(0.0); 2],
            color: borrowed.image(color),
            reflectors: Reflectors::default(),
            leaves_sky_out: true,
        };
        let gbuffer = self.import.record(&mut frame, &foreign, &self.camera.camera)?;
        self.images.take_face(&mut frame, &self.keep, &gbuffer, number)?;
        borrowed.end(&mut frame);
        frame.end()?;
        self.given_faces |= 1 << number;
        Ok(())
    }

    /// Returns the captures in the form in which methods read them. Fails if a face was never handed over.
    pub(super) fn images(&self) -> Result<&CaptureImages> {
        match (0..self.images.faces()).find(|number| self.given_faces >> number & 1 == 0) {
            None => Ok(&self.images),
            Some(number) => {
                Err(Error::Usage(format!("face {} of capture {} was never handed over", number % 6, number / 6)))
            }
        }
    }

    /// Width and height of a face in texels.
    pub(super) fn extent(&self) -> [u32; 2] {
        self.images.extent()
    }
}
