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
use crate::parameter::{Choices, Parameter, Preset};
use crate::passes::history::SurfaceMotion;
use crate::passes::import::{ForeignImages, ImportPass};
use crate::passes::triangle_scene::TriangleReading;
use crate::passes::{GBuffer, Reflectors};
use crate::scene::ProjectionKind;
use ash::vk;

/// What is to be reflected, and how.
#[derive(Clone, Copy)]
pub struct ReflectionsInfo<'a> {
    /// Width and height of the view in pixels.
    pub extent: [u32; 2],
    /// The projection of every frame's camera.
    pub projection: ProjectionKind,
    /// A method of [`methods`](super::methods()).
    pub method: &'a str,
    /// Parameters by name, with their values as text, as docs/options.md lists them: `("fade", "off")`. `preset` is one of
    /// them.
    pub parameters: &'a [(&'a str, &'a str)],
    /// Width and height of the faces of the [`CaptureCubes`] that every frame is given; `None` for frames without.
    pub captures: Option<u32>,
    /// Triangles like those that every frame is given; `None` for frames without. Not with captures.
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
    /// `unified` with its published values, at 1 × 1 pixel, seen in perspective; composite and reflection.
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

/// What a frame shows, and where from.
#[derive(Clone, Copy)]
pub struct FrameInput<'a> {
    /// Which of the frames under way this is, below [`ReflectionsInfo::frames_in_flight`]: what was recorded with the same
    /// number before is done.
    pub slot: usize,
    /// Where the images were seen from.
    pub camera: CameraInput,
    /// Depth.
    pub depth: ImageInput,
    /// Normals.
    pub normal: NormalInput,
    /// What share of the light is reflected.
    pub reflectivity: FactorInput,
    /// Roughness ϱ; 0 is a mirror.
    pub roughness: FactorInput,
    /// What reflects, where you know it of the materials that you drew; [`Reflectors::UNKNOWN`] is always right. What is
    /// known not to be there costs nothing.
    pub reflectors: Reflectors,
    /// Lit colour, linear.
    pub color: ImageInput,
    /// A cube map of what is seen where nothing stands, in world axes ([`ImageInput::cube`]): the light of rays of which captures or
    /// triangles say that they end there. Without either, nobody knows where a ray goes that leaves the screen, and it misses.
    pub sky: Option<ImageInput>,
    /// Images of the scene around places, for rays that the screen loses.
    pub captures: Option<&'a CaptureCubes>,
    /// Triangles of the scene, for rays that the screen loses.
    pub triangles: Option<&'a Triangles>,
    /// Which of the triangles each pixel shows: its number, counted over all meshes in their order, or `u32::MAX` for none;
    /// R32_UINT. Without it, some rays meet the surface that they begin on.
    pub triangle_numbers: Option<ImageInput>,
    /// How surfaces moved since the frame that was recorded before, for the parameter `history`; `None` where it is not
    /// known, or nothing but the camera moved.
    pub motion: Option<MotionInput>,
    /// Whether each pass is timed ([`Reflections::times`]). Passes do not overlap then.
    pub timed: bool,
    /// How the caller uses the outputs next.
    pub outputs: ImageUse,
}

/// An image that was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputImage {
    /// The image. It stays the crate's, until [`Reflections`] are resized or dropped.
    pub image: vk::Image,
    /// A view of its first level.
    pub view: vk::ImageView,
    /// Its format.
    pub format: vk::Format,
    /// Width and height in pixels.
    pub extent: [u32; 2],
}

/// What was recorded.
#[derive(Debug, Clone)]
pub struct Recorded {
    /// Lit colour with what is reflected in it, linear, RGBA16F. `None` if it was not asked for.
    pub composite: Option<OutputImage>,
    /// Reflection in rgb, before reflectivity, and in a how sure it is: 0 for what the method knows nothing of, less than
    /// 1 where it fades out. RGBA16F. `None` if it was not asked for, or nothing reflects.
    pub reflection: Option<OutputImage>,
    /// Where each ray ended: texture coordinates, standard depth, and how it ended (`PATH_*` of
    /// `shaders-glsl/common/constants.glsl`). RGBA32F. `None` if it was not asked for, or the method does not say it.
    pub hits: Option<OutputImage>,
    /// The passes that were recorded, in order.
    pub passes: Vec<String>,
    /// The passes that this frame does without, and why.
    pub skipped: Vec<Skipped>,
}

/// What one view needs to be reflected in every frame: pipelines, images and uniform memory. Views are apart from each
/// other, and may be recorded by different threads.
pub struct Reflections {
    frames: FrameContext,
    import: ImportPass,
    effect: Effect,
    method: &'static MethodInfo,
    setup: Setup,
    wants: Wants,
    beyond: WorldInput,
}

/// What frames are given of the world beyond the screen.
#[derive(Clone, Copy, PartialEq, Eq)]
enum WorldInput {
    Nothing,
    /// Captures with faces of so many texels a side.
    Captures(u32),
    /// Triangles that are read so.
    Triangles(TriangleReading),
}

impl WorldInput {
    fn of(captures: Option<u32>, triangles: Option<&Triangles>) -> Result<Self> {
        match (captures, triangles) {
            (None, None) => Ok(Self::Nothing),
            (Some(side), None) => Ok(Self::Captures(side)),
            (None, Some(triangles)) => Ok(Self::Triangles(triangles.reading())),
            (Some(_), Some(_)) => Err(Error::Usage(
                "captures and triangles are given: the rays that the screen loses go on in one of them".into(),
            )),
        }
    }

    /// Whether passes that were made for this may be given that: as many triangles as the caller likes, since their number
    /// decides nothing once the passes are made.
    fn takes(self, given: Self) -> bool {
        match (self, given) {
            (Self::Triangles(made), Self::Triangles(given)) => made == TriangleReading { count: made.count, ..given },
            (made, given) => made == given,
        }
    }

    fn describe(self) -> String {
        match self {
            Self::Nothing => "nothing".into(),
            Self::Captures(side) => format!("captures with faces of {side} texels a side"),
            Self::Triangles(TriangleReading { count, geometry_texels, .. }) => {
                let way = if geometry_texels { "texel" } else { "storage" };
                format!("triangles, {count} of them, which the device reads from {way} buffers")
            }
        }
    }
}

impl Reflections {
    /// Makes all that the frames of a view need. Nothing is submitted.
    ///
    /// # Errors
    /// [`Error::Usage`] for a method, a parameter, a value or a size that there is not, a method that needs the scene
    /// or captures that are not given, or one that does not take the projection; [`Error::Memory`] and [`Error::Vulkan`] from the device.
    pub fn new(context: &Context, info: &ReflectionsInfo) -> Result<Self> {
        let method = super::method(info.method)?;
        let mut setup = Setup::new(info.extent).seen_by(info.projection);
        for (name, value) in info.parameters {
            set(&mut setup, method, name, value)?;
        }
        let gpu = &context.gpu;
        let wants = Wants { hits: info.hits, reflection: info.reflection, composite: info.composite };
        if wants == Wants::default() {
            return Err(Error::Usage("no output is asked for: composite, reflection and hits are off".into()));
        }
        let mut frames = FrameContext::in_others(gpu, info.frames_in_flight)?;
        let import = ImportPass::new(gpu, info.extent)?;
        let beyond = WorldInput::of(info.captures, info.triangles)?;
        let effect = effect(&mut frames, method, &setup, wants, beyond)?;
        Ok(Self { frames, import, effect, method, setup, wants, beyond })
    }

    /// Makes images of another size. The device is done with every frame that was recorded.
    ///
    /// # Errors
    /// Errors of [`Self::new`]; the old size stays then.
    pub fn resize(&mut self, extent: [u32; 2]) -> Result<()> {
        let setup = self.setup.at(extent);
        let import = ImportPass::new(self.frames.gpu(), extent)?;
        let effect = effect(&mut self.frames, self.method, &setup, self.wants, self.beyond)?;
        (self.setup, self.import, self.effect) = (setup, import, effect);
        Ok(())
    }

    /// Width and height in pixels.
    pub fn extent(&self) -> [u32; 2] {
        self.setup.extent
    }

    /// Forgets the frames that the parameter `history` averages, so that the next one stands alone: after a cut, and after
    /// a command buffer that was thrown away.
    pub fn restart_history(&self) {
        self.effect.restart_history();
    }

    /// Records a frame's reflections into a command buffer: no submission, no waiting, and, once all frames under way have
    /// been recorded once, no allocation on the device.
    ///
    /// # Errors
    /// [`Error::Usage`] with the input that is wrong, and why; nothing is recorded then. [`Error::Memory`] or
    /// [`Error::Vulkan`] from the device: throw the command buffer away then.
    ///
    /// # Safety
    /// - The command buffer is recording, outside rendering, for a queue of the context's family.
    /// - The handles of the inputs are the context's device's, are what they say they are, and live until the device is
    ///   done; the images hold what the caller submitted before.
    /// - What was recorded with the same slot before is no longer under way.
    /// - Frames of this object are submitted in the order in which they were recorded, to one queue, and so are the
    ///   captures' that they see. A command buffer is submitted once, or recorded and thrown away before another is.
    pub unsafe fn record(&mut self, commands: vk::CommandBuffer, input: &FrameInput) -> Result<Recorded> {
        let taken = self.check(input)?;
        let captures = input.captures.map(CaptureCubes::images).transpose()?;
        let triangles = input.triangles.map(Triangles::bound).transpose()?;
        let gpu = self.frames.gpu().clone();
        let mut borrowed = BorrowedImages::default();
        let depth = borrowed.take(&gpu, "depth", &input.depth)?;
        let normal = borrowed.take(&gpu, "normal", &input.normal.image)?;
        let reflectivity = input.reflectivity.take(&mut borrowed, &gpu, "reflectivity")?;
        let roughness = input.roughness.take(&mut borrowed, &gpu, "roughness")?;
        let color = borrowed.take(&gpu, "color", &input.color)?;
        let sky = input.sky.map(|sky| borrowed.take(&gpu, "sky", &sky)).transpose()?;
        let numbers = input.triangle_numbers.map(|n| borrowed.take(&gpu, "triangle_numbers", &n)).transpose()?;
        let motion = input.motion.map(|m| Ok::<_, Error>((m, borrowed.take(&gpu, "motion", &m.image)?))).transpose()?;
        let mode = if input.timed { Mode::Timed } else { Mode::Plain };
        // SAFETY: by the contract.
        let mut frame = unsafe { self.frames.begin_in(commands, input.slot, mode) }?;
        borrowed.begin(&mut frame);
        let (kind, to_view) = input.normal.kind(&taken);
        let foreign = ForeignImages {
            depth: borrowed.image(depth),
            to_reversed: taken.to_reversed,
            normal: Some((borrowed.image(normal), kind, to_view)),
            material: [reflectivity, roughness].map(|factor| factor.to_factor(&borrowed)),
            color: borrowed.image(color),
            reflectors: input.reflectors,
            leaves_sky_out: false,
        };
        let imported = self.import.record(&mut frame, &foreign, &taken.camera)?;
        let gbuffer = GBuffer { triangle: numbers.map(|numbers| borrowed.image(numbers)), ..imported };
        frame.begin_effect();
        let seen = Input {
            sky: sky.map(|sky| borrowed.image(sky)),
            captures: captures.map(|images| images.captures()),
            triangles,
            motion: motion.map(|(MotionInput { scale, jittered, .. }, image)| SurfaceMotion {
                image: borrowed.image(image),
                scale,
                shifted: jittered,
            }),
            ..Input::of_screen(gbuffer, &taken.camera)
        };
        let output = self.effect.record(&mut frame, &seen)?;
        let give = |frame: &mut Frame, image: &Image| {
            frame.hand_over(image, input.outputs);
            OutputImage {
                image: image.handle(),
                view: image.level(0).view(),
                format: image.format(),
                extent: image.extent(),
            }
        };
        let composite = self.wants.composite.then(|| give(&mut frame, output.composite));
        let reflection = output.traced.reflection.filter(|_| self.wants.reflection).map(|r| give(&mut frame, r.0));
        let hits = output.traced.hits.map(|h| give(&mut frame, h.0));
        borrowed.end(&mut frame);
        let report = frame.end()?;
        Ok(Recorded { composite, reflection, hits, passes: report.recorded, skipped: report.skipped })
    }

    /// How long each pass of the last frame of a slot took; empty if it was not timed.
    ///
    /// # Errors
    /// [`Error::Usage`] for a slot that there is not; [`Error::Vulkan`] with `NOT_READY` if the device is not done with
    /// the frame yet.
    pub fn times(&self, slot: usize) -> Result<Vec<PassTime>> {
        self.frames.times(slot)
    }

    /// What is wrong with an input, if anything; else the camera.
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
        let given = WorldInput::of(input.captures.map(|c| c.extent()[0]), input.triangles)?;
        if !self.beyond.takes(given) {
            return Err(Error::Usage(format!(
                "the frame is given {}, and the reflections were made for {}: ReflectionsInfo says what frames have",
                given.describe(),
                self.beyond.describe()
            )));
        }
        let taken = input.camera.take()?;
        taken
            .camera
            .check_kind(self.setup.projection)
            .map_err(|e| Error::Usage(format!("{e}: see ReflectionsInfo.projection")))?;
        Ok(taken)
    }
}

fn effect(
    frames: &mut FrameContext,
    method: &MethodInfo,
    setup: &Setup,
    wants: Wants,
    beyond: WorldInput,
) -> Result<Effect> {
    match beyond {
        WorldInput::Captures(side) => Effect::for_captures(frames, method, setup, wants, [side; 2]),
        WorldInput::Triangles(reading) => Effect::for_triangles(frames, method, setup, wants, reading),
        WorldInput::Nothing => Effect::new(frames, method, setup, wants, None),
    }
}

/// Gives a parameter of a method, or of what surrounds every method, its value.
fn set(setup: &mut Setup, method: &MethodInfo, name: &str, value: &str) -> Result<()> {
    if name == "preset" {
        let preset = [Preset::Published, Preset::Author].into_iter().find(|p| p.name() == value);
        let refused = || Error::Usage(format!("preset is {value:?}; it takes published or author"));
        setup.values.preset = preset.ok_or_else(refused)?;
        return Ok(());
    }
    let rows: Vec<Parameter> = method.reads();
    let row = rows.iter().find(|row| row.name == name || row.typed_name() == name).ok_or_else(|| {
        let names: Vec<_> = rows.iter().map(Parameter::typed_name).collect();
        Error::Usage(format!("{} has no parameter {name:?}; it has: {}", method.name, names.join(", ")))
    })?;
    setup.values.set(row, row.parse(value)?);
    Ok(())
}

const _: () = {
    const fn is_send<T: Send>() {}
    is_send::<Reflections>();
    is_send::<CaptureCubes>();
    is_send::<Triangles>();
};
