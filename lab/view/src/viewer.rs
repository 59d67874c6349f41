//! The content of a window: the state, the panel that changes the state, and the pictures that the state asks for. The
//! viewer takes egui's input and draws one image. It does not depend on a window, so that tests can drive it.

mod act;

use super::captures::CaptureEditor;
use super::fly_camera::{FlyCamera, FlyMotion};
use super::panel::{self, PanelActions, PanelData};
use super::path::PathEditor;
use super::pictures::{FrameAnalysis, FrameRequest, Pictures};
use super::reference_command::reference_command;
use super::reference_error::ReferenceComparison;
use super::reload::{ShaderChange, ShaderStatus};
use super::state::State;
use crate::presentation::Overlay;
use ash::vk;
use egui::{Context, FullOutput, RawInput};
use ssct::gpu::{Frame, FrameContext, Gpu, Image, ImageDesc, Pixels};
use ssct::passes::look::{Compare, LookPass, PictureDisplay};
use ssct_lab::app::cli::SceneOptions;
use ssct_lab::app::resolve;
use ssct_lab::error::Result;
use ssct_lab::study::inspect::PickedRay;
use ssct_lab::study::pixel::PixelReport;
use ssct_scenes::{Capture, Scene, View, library};
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

/// The number of seconds in which the camera crosses the scene at its initial speed.
const CROSSING_S: f32 = 8.0;

/// A callback for other threads; it makes the window draw again.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// The watched shaders and their status.
pub struct Shaders {
    /// The folder.
    pub folder: String,
    /// Receives the shaders that were compiled after a change.
    pub changes: Receiver<Vec<ShaderChange>>,
    /// The last status of each shader that has changed.
    pub statuses: Vec<ShaderStatus>,
}

/// A scene with everything that a user can change while looking at it.
pub struct Viewer {
    /// The state, which the user changes.
    pub state: State,
    /// The camera key frames.
    pub path: PathEditor,
    /// The editor of the captures, with the user's changes.
    pub captures: CaptureEditor,
    pub(super) gpu: Gpu,
    pub(super) scene: Arc<Scene>,
    pub(super) views: Vec<View>,
    /// The options that select the shown scene.
    pub(super) place: SceneOptions,
    /// The options of the command line, which select the first scene.
    pub(super) first_place: SceneOptions,
    /// The names of all scenes that the user can choose.
    scenes: Vec<String>,
    /// Says why the scene that the user chose last could not be loaded.
    pub(super) scene_fault: Option<String>,
    pub(super) pictures: Pictures,
    egui: Context,
    /// Draws the panel.
    overlay: Overlay,
    /// Draws the pictures.
    look: LookPass,
    /// The image into which pictures and panel are drawn.
    pub(super) screen: Image,
    shaders: Option<Shaders>,
    pub(super) analysis: Option<FrameAnalysis>,
    pub(super) ray: Option<PickedRay>,
    /// The report on the picked pixel.
    pub(super) pixel: Option<PixelReport>,
    pub(super) reference_error: ReferenceComparison,
    pub(super) wake: Wake,
    /// The triangles that the last call of [`Self::update`] prepared.
    triangles: Vec<egui::ClippedPrimitive>,
    /// The changes of egui's textures since the last drawing.
    textures: egui::TexturesDelta,
    pixels_per_point: f32,
    /// How and where the pictures are drawn; `None` before the first frame.
    pub(super) display: Option<PictureDisplay>,
    /// Number of frames rendered.
    pub(super) frames: u64,
    /// Number of times that panel and pictures were drawn.
    drawings: u64,
    /// Whether the mouse turns the camera.
    looking: bool,
}

/// The requests of a round of the viewer to the window.
pub struct ViewerOutput {
    /// Cursor and clipboard, for egui-winit.
    pub platform: egui::PlatformOutput,
    /// The time until the next drawing if there is no input; `None` for no further drawing.
    pub again: Option<Duration>,
}

/// The input of a round of the viewer.
pub struct ViewerInput {
    /// Mouse, keys, text and the size in points, for egui.
    pub egui: RawInput,
    /// The motion that the pressed keys ask for.
    pub motion: FlyMotion,
    /// Seconds since the last frame.
    pub seconds: f32,
    /// Width and height of the window in pixels.
    pub extent: [u32; 2],
}

impl Viewer {
    /// Makes a viewer and uploads its scene. `place` is the options that selected the scene, `screen_format` an sRGB
    /// format, and other threads call `wake` when they have something to show.
    pub fn new(
        gpu: &Gpu,
        scene: Scene,
        state: State,
        place: SceneOptions,
        screen_format: vk::Format,
        wake: Wake,
    ) -> Result<Self> {
        let mut scenes: Vec<String> = library::names().iter().map(ToString::to_string).collect();
        if !scenes.contains(&state.scene) {
            scenes.insert(0, state.scene.clone());
        }
        let egui = Context::default();
        egui.all_styles_mut(|style| {
            // egui's own animations would cause endless redraws.
            style.animation_time = 0.0;
            style.visuals.weak_text_color = Some(egui::Color32::from_gray(150));
            style.visuals.override_text_color = Some(egui::Color32::from_gray(220));
            style.visuals.text_cursor.blink = false;
        });
        egui.set_theme(egui::Theme::Dark);
        Ok(Self {
            views: views_with_lens(&scene, &place)?,
            pictures: Pictures::new(gpu, &scene)?,
            overlay: Overlay::new(gpu, screen_format)?,
            look: LookPass::new(gpu, screen_format)?,
            screen: new_screen(gpu, screen_format, [1, 1])?,
            scene: Arc::new(scene),
            gpu: gpu.clone(),
            state,
            path: PathEditor::default(),
            captures: CaptureEditor::new(&place.scene, place.scale),
            first_place: place.clone(),
            place,
            scenes,
            scene_fault: None,
            egui,
            shaders: None,
            analysis: None,
            ray: None,
            pixel: None,
            reference_error: ReferenceComparison::default(),
            wake,
            triangles: Vec::new(),
            textures: egui::TexturesDelta::default(),
            pixels_per_point: 1.0,
            display: None,
            frames: 0,
            drawings: 0,
            looking: false,
        })
    }

    /// Returns a camera at a view, with a speed that fits the size of the scene.
    pub fn camera(scene: &Scene, view: &View) -> FlyCamera {
        let bounds = scene.bounds();
        let diagonal_m = bounds.min.distance(bounds.max);
        FlyCamera::new(view, if diagonal_m.is_finite() { (diagonal_m / CROSSING_S).max(0.01) } else { 1.0 })
    }

    /// Watches shaders from now on.
    pub fn watch(&mut self, shaders: Shaders) {
        self.shaders = Some(shaders);
    }

    /// Returns egui's context, which egui-winit needs as well.
    pub fn egui(&self) -> &Context {
        &self.egui
    }

    /// Returns whether the mouse turns the camera.
    pub fn is_looking(&self) -> bool {
        self.looking
    }

    /// Returns the scene's views.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Returns the number of frames rendered, and the number of times that panel and picture were drawn.
    pub fn counts(&self) -> [u64; 2] {
        [self.frames, self.drawings]
    }

    /// Returns whether a computation is running whose result will be shown.
    pub fn is_waiting(&self) -> bool {
        self.reference_error.is_waiting()
    }

    /// Forces the next frame to be rendered, even if nothing changed.
    pub fn invalidate(&mut self) {
        self.pictures.invalidate();
    }

    /// Runs one round: takes the input, renders a frame if the request changed or else analyses the frame at rest, and
    /// prepares the drawing of the screen.
    pub fn update(&mut self, input: ViewerInput) -> Result<ViewerOutput> {
        self.move_camera(&input);
        self.take_shaders();
        self.reference_error.poll();
        let (output, actions) = self.run_panel(input.egui);
        if let Some(action) = actions.action {
            self.act(action);
        }
        self.looking = actions.looking;
        let has_work = self.follow(&actions, input.extent, output.pixels_per_point)?;
        self.textures.append(output.textures_delta);
        self.triangles = self.egui.tessellate(output.shapes, output.pixels_per_point);
        self.pixels_per_point = output.pixels_per_point;
        let delay = output.viewport_output.values().map(|v| v.repaint_delay).min().unwrap_or(Duration::MAX);
        let goes_on = has_work || self.path.playing().is_some() || input.motion.is_moving();
        let again = if goes_on { Some(Duration::ZERO) } else { Some(delay).filter(|d| *d != Duration::MAX) };
        Ok(ViewerOutput { platform: output.platform_output, again })
    }

    /// Draws what the last [`Self::update`] prepared. `present` is called with the context of frames, the screen's
    /// image, and a function that records the drawing of this image. Returns its result; `None` if there is nothing to
    /// draw yet.
    pub fn draw<R>(
        &mut self,
        present: impl FnOnce(&mut FrameContext, &Image, &mut dyn FnMut(&mut Frame) -> ssct::Result<()>) -> Result<R>,
    ) -> Result<Option<R>> {
        let Self { pictures, look, display, overlay, screen, triangles, textures, pixels_per_point, .. } = self;
        let (Some(display), Some((stage, kept_images, _))) = (display, pictures.parts()) else { return Ok(None) };
        self.drawings += 1;
        overlay.update_textures(textures)?;
        let mut record = |frame: &mut Frame| {
            look.record(frame, screen, display, kept_images)?;
            overlay.record(frame, screen.all(), *pixels_per_point, triangles)
        };
        present(&mut stage.context, screen, &mut record).map(Some)
    }

    /// Returns the screen as it was last drawn, decoded to linear values.
    pub fn read_screen(&mut self) -> Result<Pixels> {
        Ok(self.pictures.stage.context.read(self.screen.all())?)
    }

    /// Returns the first picture without the panel, linear; `None` before the first frame.
    pub fn read_picture(&mut self) -> Result<Option<Pixels>> {
        let Some((stage, [first, _], _)) = self.pictures.parts() else { return Ok(None) };
        Ok(Some(stage.context.read(first.all())?))
    }

    /// Returns the window's title: scene, view, methods, roughness and the first method's time.
    pub fn title(&self) -> String {
        let state = &self.state;
        let moved = if state.moved { " (moved)" } else { "" };
        let against = match state.compare {
            Compare::One => String::new(),
            Compare::Split | Compare::Difference => format!(" | {}", state.sides[1].method.name),
        };
        let roughness = state.globals.roughness.map(|r| format!(", roughness {r:.1}")).unwrap_or_default();
        let ms = self.pictures.shown(0).map_or(0.0, |p| p.history.total().median_ms);
        let method = state.sides[0].method.name;
        format!("{}, view {}{moved} — {method}{against}{roughness} — {ms:.2} ms", self.scene.name, state.view.name)
    }

    /// Returns the images that the first method made in the last frame.
    #[cfg(test)]
    pub fn images(&self) -> Vec<super::pictures::ImageInfo> {
        self.pictures.shown(0).map(|s| s.images.clone()).unwrap_or_default()
    }

    /// Returns the labels of the passes that the first method recorded in the last frame.
    #[cfg(test)]
    pub fn passes(&self) -> Vec<String> {
        self.pictures.shown(0).map(|s| s.history.recorded.clone()).unwrap_or_default()
    }

    /// Returns the data of the frame at rest that were read back, if it was analysed.
    #[cfg(test)]
    pub fn inspection(&self) -> Option<&ssct_lab::study::inspect::Inspection> {
        self.analysis.as_ref()?.inspection.as_ref()
    }

    /// Returns the last status of each shader that has changed.
    #[cfg(test)]
    pub fn shader_statuses(&self) -> Vec<ShaderStatus> {
        self.shaders.as_ref().map(|s| s.statuses.clone()).unwrap_or_default()
    }

    /// Moves the camera by the pressed keys, and along the key frames that are played.
    fn move_camera(&mut self, input: &ViewerInput) {
        if input.motion.is_moving() {
            self.state.moved |= self.state.camera.fly(input.motion, input.seconds);
        }
        if let Some(place) = self.path.advance(input.seconds) {
            self.state.put_camera(place);
        }
    }

    /// Takes newly compiled shaders into use, except those whose pipelines cannot be made, and records their status.
    fn take_shaders(&mut self) {
        let Some(shaders) = &mut self.shaders else { return };
        for (shader, compiled) in shaders.changes.try_iter().flatten() {
            let replaced = &self.gpu.shared().replaced_shaders;
            // The pass that draws the pictures is made at once; the methods' pipelines are only tried. If any of them
            // cannot be made with the new code, the previous code is put back.
            let new_look = compiled.and_then(|code| {
                let previous = replaced.set(shader, Some(code));
                let tried = self.pictures.try_pipelines();
                tried.and_then(|()| Ok(LookPass::new(&self.gpu, self.screen.format())?)).map_err(|e| {
                    replaced.set(shader, previous);
                    e.to_string()
                })
            });
            let status = new_look.map(|look| {
                self.look = look;
                self.pictures.discard_pipelines();
            });
            shaders.statuses.retain(|(name, _)| *name != shader.name);
            shaders.statuses.insert(0, (shader.name, status));
        }
    }

    /// Lays out the panel for egui's input; returns egui's output and the user's actions.
    fn run_panel(&mut self, input: RawInput) -> (FullOutput, PanelActions) {
        let extent = self.picture_extent();
        let is_idle = !self.pictures.needs_rendering(&self.frame_request(extent)) && !self.needs_analysis();
        let Self { state, path, captures, pictures, egui, .. } = self;
        let command = reference_command(state, &self.scene, &self.place, extent);
        let data = PanelData {
            scenes: &self.scenes,
            scene_fault: self.scene_fault.as_deref(),
            views: &self.views,
            histories: [0, 1].iter().filter_map(|i| pictures.shown(*i)).map(|s| &s.history).collect(),
            captures: &pictures.shown(0).map_or(Vec::new(), |s| s.captures()),
            images: pictures.shown(0).map_or(&[], |s| &s.images),
            analysis: self.analysis.as_ref(),
            ray: self.ray.as_ref(),
            pixel: self.pixel.as_ref(),
            reference_error: &self.reference_error,
            reference_command: &command,
            extent,
            shaders: self.shaders.as_ref().map(|s| (&s.folder[..], &s.statuses[..])),
            counts: [self.frames, self.drawings, self.gpu.submissions()],
            idle: is_idle,
        };
        let mut actions = PanelActions::default();
        let output = egui.run_ui(input, |ui| actions = panel::show(ui, state, (path, captures), &data));
        (output, actions)
    }

    /// Returns the request for a frame of the current state and captures, at a size in pixels.
    pub(super) fn frame_request(&self, extent: [u32; 2]) -> FrameRequest {
        FrameRequest { captures: self.captures.list.clone(), ..self.state.frame_request(&self.scene, extent) }
    }

    /// Returns the captures with which a change begins: those that are shown, or else those of the scene.
    pub(super) fn captures_shown(&self) -> Vec<Capture> {
        let shown = self.pictures.shown(0).map_or(Vec::new(), |s| s.captures());
        if shown.is_empty() { self.scene.captures.clone() } else { shown }
    }

    /// Returns the width and height of the pictures in pixels; 1 before the first frame.
    fn picture_extent(&self) -> [u32; 2] {
        self.display.map_or([1, 1], |display| [display.area[2], display.area[3]])
    }
}

/// Returns the name of the scene that the options select; for several files, the first file and an ellipsis.
pub fn scene_name(place: &SceneOptions) -> String {
    match &place.scene[..] {
        [] => "rooms".into(),
        [file] => file.display().to_string(),
        [first, ..] => format!("{} …", first.display()),
    }
}

/// Returns the views of a scene, with the lens of the options if these have one.
pub(super) fn views_with_lens(scene: &Scene, place: &SceneOptions) -> Result<Vec<View>> {
    scene.views.iter().map(|v| resolve::with_lens(scene, v.clone(), place)).collect()
}

/// Makes the image of `extent` pixels into which the window's content is drawn.
pub(super) fn new_screen(gpu: &Gpu, format: vk::Format, extent: [u32; 2]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    Ok(Image::new(gpu, &ImageDesc { name: "screen", format, extent, levels: 1, layers: 1, usage })?)
}
