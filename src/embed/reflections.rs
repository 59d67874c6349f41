//! The reflections of one view.

use super::camera::ConvertedCamera;
use super::input::BorrowedImages;
use super::{CameraInput, CaptureCubes, Context, FactorInput, ImageInput, MotionInput, NormalInput, Triangles};
use crate::error::{Error, Result};
use crate::gpu::frame::Mode;
use crate::gpu::sync::ImageUse;
use crate::gpu::{Frame, FrameContext, Image, PassTime, Skipped};
use crate::methods::effect::Effect;
use crate::methods::{Input, MethodInfo, Setup, Wants};
use crate::passes::history::SurfaceMotion;
use crate::passes::import::{ForeignImages, ImportPass};
use crate::passes::triangle_scene::TriangleReading;
use crate::passes::{GBuffer, Reflectors};
use ash::vk;
use ssct_ground::parameter::{Choices, Parameter, Preset};
use ssct_ground::scene::ProjectionKind;

/// The description of reflections that are to be made: size, method, inputs and outputs.
#[derive(Clone, Copy)]
pub struct ReflectionsInfo<'a> {
    /// Width and height of the view in pixels.
    pub extent: [u32; 2],
    /// The projection of every frame's camera.
    pub projection: ProjectionKind,
    /// A method of [`methods`](super::methods()).
    pub method: &'a str,
    /// Names and values of parameters, such as `("fade", "off")`; docs/options.md lists them. `preset` is one, too.
    pub parameters: &'a [(&'a str, &'a str)],
    /// Width and height of the faces of the [`CaptureCubes`] of every frame, in texels; `None` without captures.
    pub captures: Option<u32>,
    /// Triangles that are made like those of every frame; `None` without triangles, and for frames with captures.
    pub triangles: Option<&'a Triangles>,
    /// Produces the composite: lit colour plus reflections.
    pub composite: bool,
    /// Produces the reflection alone, for a renderer that adds it up itself.
    pub reflection: bool,
    /// Produces an image of where each ray ended, if the method can.
    pub hits: bool,
    /// Number of frames that may be under way at once.
    pub frames_in_flight: usize,
}

impl Default for ReflectionsInfo<'_> {
    /// Describes `unified` with its published values, for 1 × 1 pixel in perspective, with composite and reflection.
    fn default() -> Self {
        Self {
            extent: [1, 1],
            projection: ProjectionKind::Perspective,
            method: "unified",
            parameters: &[],
            captures: None,
            triangles: None,
            composite: true,
            reflection: true,
            hits: false,
            frames_in_flight: 2,
        }
    }
}

/// The inputs of a frame.
#[derive(Clone, Copy)]
pub struct FrameInput<'a> {
    /// The number of this frame among the frames under way, below [`ReflectionsInfo::frames_in_flight`]. The device
    /// must be done with the frame that was recorded with the same number before.
    pub slot: usize,
    /// The camera that the images were drawn with.
    pub camera: CameraInput,
    /// Depth.
    pub depth: ImageInput,
    /// Normals.
    pub normal: NormalInput,
    /// The share of the light that is reflected.
    pub reflectivity: FactorInput,
    /// Roughness ϱ; 0 is a mirror.
    pub roughness: FactorInput,
    /// The kinds of reflecting surface that the frame may have, which the caller knows from the materials that it drew.
    /// Passes for absent kinds are left out. [`Reflectors::UNKNOWN`] is right for every frame.
    pub reflectors: Reflectors,
    /// Lit colour, linear.
    pub color: ImageInput,
    /// A cube map of the sky's light, in world axes ([`ImageInput::cube`]). A ray gets this light if captures or
    /// triangles say that the ray ends in the sky. Without captures and triangles, rays that leave the screen miss.
    pub sky: Option<ImageInput>,
    /// Images of the scene around places, for rays that the screen loses.
    pub captures: Option<&'a CaptureCubes>,
    /// Triangles of the scene, for rays that the screen loses.
    pub triangles: Option<&'a Triangles>,
    /// The number of the triangle that each pixel shows, counted over all meshes in their order, or `u32::MAX` for
    /// none; R32_UINT. With `None`, some rays hit the very surface that they start from.
    pub triangle_numbers: Option<ImageInput>,
    /// The motion of surfaces since the frame that was recorded before, for the parameter `history`; `None` if the
    /// motion is not known, or if nothing but the camera moved.
    pub motion: Option<MotionInput>,
    /// Whether each pass is timed ([`Reflections::times`]). The passes of a timed frame do not overlap.
    pub timed: bool,
    /// How the caller uses the outputs next.
    pub outputs: ImageUse,
}

/// An image that the crate made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputImage {
    /// The image. The crate owns it, and keeps it until the [`Reflections`] are resized or dropped.
    pub image: vk::Image,
    /// A view of the image's first level.
    pub view: vk::ImageView,
    /// The image's format.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub extent: [u32; 2],
}

/// The outputs and passes of a recorded frame.
#[derive(Debug, Clone)]
pub struct Recorded {
    /// Lit colour plus reflections, linear, RGBA16F. `None` if [`ReflectionsInfo::composite`] is false.
    pub composite: Option<OutputImage>,
    /// The reflection in rgb, before reflectivity, and its fade in alpha: 0 where the method has no reflection, less
    /// than 1 where the reflection fades out. RGBA16F. `None` if the caller wants none, or if nothing reflects.
    pub reflection: Option<OutputImage>,
    /// The place where each ray ended: texture coordinates, standard depth, and a code that says how the ray ended
    /// (`PATH_*` of `shaders-glsl/common/constants.glsl`). RGBA32F. `None` without [`ReflectionsInfo::hits`], or if the
    /// method does not tell where rays end.
    pub hits: Option<OutputImage>,
    /// The passes that were recorded, in order.
    pub passes: Vec<String>,
    /// The passes that this frame leaves out, and why.
    pub skipped: Vec<Skipped>,
}

/// Pipelines, images and memory for the reflections of one view. Different threads may record different views.
pub struct Reflections {
    frames: FrameContext,
    import: ImportPass,
    effect: Effect,
    method: &'static MethodInfo,
    setup: Setup,
    wants: Wants,
    world_input: WorldInput,
}

/// The kind of images or triangles beyond the screen that frames are given.
#[derive(Clone, Copy, PartialEq, Eq)]
enum WorldInput {
    Nothing,
    /// Captures, with the side of their faces in texels.
    Captures(u32),
    /// Triangles, with how shaders read them.
    Triangles(TriangleReading),
}

impl WorldInput {
    /// Returns the kind of input that frames are given. Fails if they are given captures and triangles together.
    fn from_inputs(captures: Option<u32>, triangles: Option<&Triangles>) -> Result<Self> {
        match (captures, triangles) {
            (None, None) => Ok(Self::Nothing),
            (Some(side), None) => Ok(Self::Captures(side)),
            (None, Some(triangles)) => Ok(Self::Triangles(triangles.reading())),
            (Some(_), Some(_)) => Err(Error::Usage(
                "captures and triangles are given: the rays that the screen loses go on in one of them".into(),
            )),
        }
    }

    /// Returns whether passes made for `self` can read the input of a frame. The number of triangles may differ.
    fn takes(self, frame_input: Self) -> bool {
        match (self, frame_input) {
            (Self::Triangles(own), Self::Triangles(other)) => own == TriangleReading { count: own.count, ..other },
            (own, other) => own == other,
        }
    }

    /// Names the input for an error.
    fn describe(self) -> String {
        match self {
            Self::Nothing => "nothing".into(),
            Self::Captures(side) => format!("captures with faces of {side} texels a side"),
            Self::Triangles(TriangleReading { count, geometry_texels, .. }) => {
                let kind = if geometry_texels { "texel" } else { "storage" };
                format!("triangles, {count} of them, which the device reads from {kind} buffers")
            }
        }
    }
}

impl Reflections {
    /// Makes all that the frames of a view need. Nothing is submitted.
    ///
    /// # Errors
    /// [`Error::Usage`] for an unknown method or parameter, a wrong value or size, or a method that needs the scene,
    /// lacks its captures or does not take the projection. [`Error::Memory`] and [`Error::Vulkan`] from the device.
    pub fn new(context: &Context, info: &ReflectionsInfo) -> Result<Self> {
        let method = super::method(info.method)?;
        let mut setup = Setup::new(info.extent).seen_by(info.projection);
        for (name, value) in info.parameters {
            set_parameter(&mut setup, method, name, value)?;
        }
        let gpu = &context.gpu;
        let wants = Wants { hits: info.hits, reflection: info.reflection, composite: info.composite };
        if wants == Wants::default() {
            return Err(Error::Usage("no output is asked for: composite, reflection and hits are off".into()));
        }
        let mut frames = FrameContext::for_caller(gpu, info.frames_in_flight)?;
        let import = ImportPass::new(gpu, info.extent)?;
        let world_input = WorldInput::from_inputs(info.captures, info.triangles)?;
        let effect = make_effect(&mut frames, method, &setup, wants, world_input)?;
        Ok(Self { frames, import, effect, method, setup, wants, world_input })
    }

    /// Makes images of another size. The device must be done with every frame that was recorded.
    ///
    /// # Errors
    /// Errors of [`Self::new`]; the old size stays then.
    pub fn resize(&mut self, extent: [u32; 2]) -> Result<()> {
        let setup = self.setup.with_extent(extent);
        let import = ImportPass::new(self.frames.gpu(), extent)?;
        let effect = make_effect(&mut self.frames, self.method, &setup, self.wants, self.world_input)?;
        (self.setup, self.import, self.effect) = (setup, import, effect);
        Ok(())
    }

    /// Width and height in pixels.
    pub fn extent(&self) -> [u32; 2] {
        self.setup.extent
    }

    /// Forgets the frames that the parameter `history` averages, so that the next frame stands alone. Call it after a
    /// cut, and after a command buffer was thrown away.
    pub fn restart_history(&self) {
        self.effect.restart_history();
    }

    /// Records a frame's reflections into a command buffer. Nothing is submitted, and nothing waits. Once every slot
    /// was recorded once, nothing is allocated on the device.
    ///
    /// # Errors
    /// [`Error::Usage`] with the input that is wrong, and why; nothing is recorded then. [`Error::Memory`] or
    /// [`Error::Vulkan`] from the device: throw the command buffer away then.
    ///
    /// # Safety
    /// - The command buffer is recording, outside rendering, for a queue of the context's family.
    /// - The handles of the inputs belong to the context's device, are as their fields describe them, and live until the device is
    ///   done. The commands that write the images were submitted before.
    /// - The frame that was recorded with the same slot before is no longer under way.
    /// - Frames of this object, and the faces of the captures that they see, are submitted in the order in which they
    ///   were recorded, to one queue. A command buffer is submitted once, or thrown away before another is recorded.
    pub unsafe fn record(&mut self, commands: vk::CommandBuffer, input: &FrameInput) -> Result<Recorded> {
        let converted = self.check(input)?;
        let captures = input.captures.map(CaptureCubes::images).transpose()?;
        let triangles = input.triangles.map(Triangles::buffers).transpose()?;
        let gpu = self.frames.gpu().clone();
        let mut borrowed = BorrowedImages::default();
        let depth = borrowed.add(&gpu, "depth", &input.depth)?;
        let normal = borrowed.add(&gpu, "normal", &input.normal.image)?;
        let reflectivity = input.reflectivity.borrow(&mut borrowed, &gpu, "reflectivity")?;
        let roughness = input.roughness.borrow(&mut borrowed, &gpu, "roughness")?;
        let color = borrowed.add(&gpu, "color", &input.color)?;
        let sky = input.sky.map(|sky| borrowed.add(&gpu, "sky", &sky)).transpose()?;
        let numbers = input.triangle_numbers.map(|n| borrowed.add(&gpu, "triangle_numbers", &n)).transpose()?;
        let motion = input.motion.map(|m| Ok::<_, Error>((m, borrowed.add(&gpu, "motion", &m.image)?))).transpose()?;
        let mode = if input.timed { Mode::Timed } else { Mode::Plain };
        // SAFETY: the caller keeps to the contract of this function.
        let mut frame = unsafe { self.frames.begin_in(commands, input.slot, mode) }?;
        borrowed.begin(&mut frame);
        let (encoding, to_view) = input.normal.code_and_matrix(&converted);
        let foreign = ForeignImages {
            depth: borrowed.image(depth),
            to_reversed: converted.to_reversed,
            normal: Some((borrowed.image(normal), encoding, to_view)),
            material: [reflectivity, roughness].map(|factor| factor.to_factor(&borrowed)),
            color: borrowed.image(color),
            reflectors: input.reflectors,
            leaves_sky_out: false,
        };
        let imported = self.import.record(&mut frame, &foreign, &converted.camera)?;
        let gbuffer = GBuffer { triangle: numbers.map(|numbers| borrowed.image(numbers)), ..imported };
        frame.begin_effect();
        let effect_input = Input {
            sky: sky.map(|sky| borrowed.image(sky)),
            captures: captures.map(|images| images.captures()),
            triangles,
            motion: motion.map(|(MotionInput { scale, jittered, .. }, image)| SurfaceMotion {
                image: borrowed.image(image),
                scale,
                shifted: jittered,
            }),
            ..Input::of_screen(gbuffer, &converted.camera)
        };
        let output = self.effect.record(&mut frame, &effect_input)?;
        let hand_over = |frame: &mut Frame, image: &Image| {
            frame.hand_over(image, input.outputs);
            OutputImage {
                image: image.handle(),
                view: image.level(0).view(),
                format: image.format(),
                extent: image.extent(),
            }
        };
        let composite = self.wants.composite.then(|| hand_over(&mut frame, output.composite));
        let reflection = output.traced.reflection.filter(|_| self.wants.reflection).map(|r| hand_over(&mut frame, r.0));
        let hits = output.traced.hits.filter(|_| self.wants.hits).map(|h| hand_over(&mut frame, h.0));
        borrowed.end(&mut frame);
        let report = frame.end()?;
        Ok(Recorded { composite, reflection, hits, passes: report.recorded, skipped: report.skipped })
    }

    /// How long each pass of the last frame of a slot took, in their order; empty if the frame was not timed.
    ///
    /// # Errors
    /// [`Error::Usage`] for a slot that does not exist; [`Error::Vulkan`] with `NOT_READY` before the frame is done.
    pub fn times(&self, slot: usize) -> Result<Vec<PassTime>> {
        self.frames.times(slot)
    }

    /// Checks the inputs, and returns the converted camera.
    fn check(&self, input: &FrameInput) -> Result<ConvertedCamera> {
        let extent = self.extent();
        if input.timed && !self.frames.gpu().has_timestamps() {
            return Err(Error::Usage("no pass can be timed: the queue family has no timestamps".into()));
        }
        if input.outputs.layout == vk::ImageLayout::UNDEFINED {
            return Err(Error::Usage("the outputs' layout is UNDEFINED: their content would be lost".into()));
        }
        input.depth.check("depth", Some(extent))?;
        input.normal.check(extent)?;
        input.reflectivity.check("reflectivity", extent)?;
        input.roughness.check("roughness", extent)?;
        input.color.check("color", Some(extent))?;
        if let Some(sky) = &input.sky {
            sky.check("sky", None)?;
        }
        if let Some(numbers) = &input.triangle_numbers {
            numbers.check_numbers("triangle_numbers", extent)?;
        }
        if let Some(motion) = &input.motion {
            motion.check(extent)?;
        }
        let frame_input = WorldInput::from_inputs(input.captures.map(|cubes| cubes.extent()[0]), input.triangles)?;
        if !self.world_input.takes(frame_input) {
            return Err(Error::Usage(format!(
                "the frame is given {}, and the reflections were made for {}: ReflectionsInfo says what frames have",
                frame_input.describe(),
                self.world_input.describe()
            )));
        }
        let converted = input.camera.converted()?;
        converted
            .camera
            .check_kind(self.setup.projection)
            .map_err(|e| Error::Usage(format!("{e}: see ReflectionsInfo.projection")))?;
        Ok(converted)
    }
}

/// Makes the effect for frames with captures, with triangles, or without either.
fn make_effect(
    frames: &mut FrameContext,
    method: &MethodInfo,
    setup: &Setup,
    wants: Wants,
    world_input: WorldInput,
) -> Result<Effect> {
    match world_input {
        WorldInput::Captures(side) => Effect::for_captures(frames, method, setup, wants, [side; 2]),
        WorldInput::Triangles(reading) => Effect::for_triangles(frames, method, setup, wants, reading),
        WorldInput::Nothing => Effect::new(frames, method, setup, wants, None),
    }
}

/// Sets the preset, or a parameter that the method or the effect around it reads. Fails for any other name.
fn set_parameter(setup: &mut Setup, method: &MethodInfo, name: &str, value: &str) -> Result<()> {
    if name == "preset" {
        let preset = [Preset::Published, Preset::Author].into_iter().find(|p| p.name() == value);
        let refused = || Error::Usage(format!("preset is {value:?}; it takes published or author"));
        setup.values.preset = preset.ok_or_else(refused)?;
        return Ok(());
    }
    let rows: Vec<Parameter> = method.read_parameters();
    let row = rows.iter().find(|row| row.name == name || row.typed_name() == name).ok_or_else(|| {
        let names: Vec<_> = rows.iter().map(Parameter::typed_name).collect();
        Error::Usage(format!("{} has no parameter {name:?}; it has: {}", method.name, names.join(", ")))
    })?;
    setup.values.set(row, row.parse(value)?);
    Ok(())
}

// These types must stay `Send`, since callers may record in any thread.
const _: () = {
    const fn is_send<T: Send>() {}
    is_send::<Reflections>();
    is_send::<CaptureCubes>();
    is_send::<Triangles>();
};
