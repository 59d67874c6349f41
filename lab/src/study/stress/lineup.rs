//! Line-ups: methods that are made once for many cases. A driver takes longer to compile their pipelines than to draw
//! with them, and the pipelines, like the maps that methods capture of a scene, serve other G-buffers and cameras, too.

use crate::error::Result;
use crate::stage::gbuffer::{self, reflection};
use crate::stage::{Shot, Stage};
use glam::Vec3;
use ssct::gpu::frame::Mode;
use ssct::gpu::{FrameContext, FrameReport, Gpu, Pixels};
use ssct::methods::{Effect, Input, MethodInfo, Output, Setup, Wants};
use ssct::passes::GBuffer;
use ssct::passes::gbuffer::DrawnCounts;
use ssct_scenes::{Camera, GBufferData, Material, ProjectionKind, Scene};

/// The images that a method made in a frame, on the host.
pub(super) struct FrameImages {
    pub reflection: Pixels,
    pub composite: Pixels,
    /// Where the rays ended; `None` if the method writes no hits.
    pub hits: Option<Pixels>,
    /// Times of the frame's passes.
    pub report: FrameReport,
}

impl FrameImages {
    /// Reads the images of a frame back; hits are read if the method wrote them.
    fn read(context: &mut FrameContext, report: FrameReport, output: &Output) -> Result<Self> {
        Ok(Self {
            reflection: reflection(context, output)?,
            composite: context.read(output.composite.level(0))?,
            hits: output.traced.hits.map(|h| context.read(h.0.all())).transpose()?,
            report,
        })
    }
}

/// The screen-space methods among some methods, made for G-buffers of one size.
pub struct ScreenMethods {
    pub(super) context: FrameContext,
    effects: Vec<(&'static MethodInfo, Effect)>,
}

impl ScreenMethods {
    /// Makes the line-up for a size in pixels; methods that see more than the screen are left out.
    pub fn new(gpu: &Gpu, extent: [u32; 2], methods: &[&'static MethodInfo]) -> Result<Self> {
        let mut context = FrameContext::new(gpu)?;
        let setup = Setup::on_screen(extent);
        let mut effects = Vec::new();
        for method in methods.iter().filter(|m| m.is_screen_space()) {
            effects.push((*method, Effect::new(&mut context, method, &setup, Wants::HITS, None)?));
        }
        Ok(Self { context, effects })
    }

    /// Returns the number of methods.
    pub(super) fn len(&self) -> usize {
        self.effects.len()
    }

    /// Draws one frame of the method with the index `n` on a G-buffer of the line-up's size. Returns the method and its
    /// images.
    pub(super) fn reflect(
        &mut self,
        n: usize,
        gbuffer: &GBuffer,
        camera: &Camera,
    ) -> Result<(&'static MethodInfo, FrameImages)> {
        let (method, effect) = &self.effects[n];
        let mut frame = self.context.begin(Mode::Timed)?;
        frame.begin_effect();
        let output = effect.record(&mut frame, &Input::of_screen(*gbuffer, camera))?;
        let report = frame.finish()?;
        Ok((method, FrameImages::read(&mut self.context, report, &output)?))
    }
}

/// Methods on a scene, for cameras of one size.
pub struct SceneMethods {
    /// Scene that the methods show.
    pub scene: Scene,
    /// Width and height in pixels.
    pub extent: [u32; 2],
    /// Kind of the cameras that the methods are made for, which is that of the scene's first view.
    pub(super) kind: ProjectionKind,
    /// Setup of the methods.
    pub(super) setup: Setup,
    stage: Stage,
    shots: Vec<(&'static MethodInfo, Shot)>,
    /// Counts of what the first shot drew in the last G-buffer.
    drawn: DrawnCounts,
}

impl SceneMethods {
    /// Makes the line-up of some methods, which also write their hits, if they have any.
    pub fn with_hits(gpu: &Gpu, scene: Scene, setup: &Setup, methods: &[&'static MethodInfo]) -> Result<Self> {
        Self::make(gpu, scene, setup, Wants::HITS, methods)
    }

    /// Makes the line-up of some methods, which also write an image of the reflection.
    pub fn new(gpu: &Gpu, scene: Scene, setup: &Setup, methods: &[&'static MethodInfo]) -> Result<Self> {
        Self::make(gpu, scene, setup, Wants::REFLECTION, methods)
    }

    /// Makes the line-up of some methods, which write the images that `wants` names.
    fn make(gpu: &Gpu, scene: Scene, setup: &Setup, wants: Wants, methods: &[&'static MethodInfo]) -> Result<Self> {
        let extent = setup.extent;
        let mut stage = Stage::new(gpu, &scene)?;
        let view = scene.views.first().cloned().unwrap_or_default();
        let camera = view.camera(&scene, extent);
        let materials = scene.materials_in(&view);
        let mut shots = Vec::new();
        for method in methods {
            shots.push((*method, Shot::new(&mut stage, method, setup, wants, camera, materials.clone())?));
        }
        let kind = camera.kind();
        Ok(Self { scene, extent, kind, setup: setup.clone(), stage, shots, drawn: DrawnCounts::default() })
    }

    /// Returns the methods, in order.
    pub(super) fn methods(&self) -> impl Iterator<Item = &'static MethodInfo> {
        self.shots.iter().map(|(method, _)| *method)
    }

    /// Replaces the scene's materials for all methods.
    pub(super) fn set_materials(&mut self, materials: &[Material]) -> Result<()> {
        Ok(self.shots.iter_mut().try_for_each(|(_, shot)| shot.set_materials(&mut self.stage, materials.to_vec()))?)
    }

    /// Moves the captures of every method to places in the scene, in metres.
    pub(super) fn move_captures(&mut self, places: &[Vec3]) -> Result<()> {
        Ok(self.shots.iter_mut().try_for_each(|(_, shot)| shot.move_captures(&mut self.stage, places))?)
    }

    /// Draws the G-buffer of a camera, which the methods then reflect, and reads it back. `None` if there are no
    /// methods.
    pub(super) fn draw(&mut self, camera: Camera) -> Result<Option<GBufferData>> {
        let Some((_, shot)) = self.shots.first_mut() else { return Ok(None) };
        shot.camera = camera;
        self.drawn = self.stage.draw(shot)?;
        Ok(Some(gbuffer::read(&mut self.stage.context, shot)?))
    }

    /// Begins the histories anew, and draws all but the last of the frames that an image of a camera at rest takes, so
    /// that the histories are settled before the camera moves.
    pub(super) fn settle(&mut self, camera: Camera) -> Result<()> {
        for (_, shot) in &mut self.shots {
            shot.camera = camera;
            self.stage.settle(shot)?;
        }
        Ok(())
    }

    /// Draws a frame of each method on the last G-buffer drawn, and returns its images.
    pub(super) fn read_images(&mut self) -> Result<Vec<FrameImages>> {
        self.draw_each(Mode::Timed, FrameImages::read)
    }

    /// Draws a frame of each method on the last G-buffer drawn, and returns its reflection.
    pub(super) fn reflections(&mut self) -> Result<Vec<Pixels>> {
        self.draw_each(Mode::Plain, |context, _, output| Ok(reflection(context, output)?))
    }

    /// Draws a frame of each method on the G-buffer that [`Self::draw`] drew last with the first shot, and returns what
    /// `read` makes of each report and output.
    fn draw_each<T>(
        &mut self,
        mode: Mode,
        read: impl Fn(&mut FrameContext, FrameReport, &Output) -> Result<T>,
    ) -> Result<Vec<T>> {
        let Some((_, first)) = self.shots.first() else { return Ok(Vec::new()) };
        let mut all = Vec::new();
        for (_, shot) in &self.shots {
            let (report, output) = self.stage.output_on(mode, shot, (first, &self.drawn))?;
            all.push(read(&mut self.stage.context, report, &output)?);
        }
        Ok(all)
    }
}
