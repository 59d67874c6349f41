//! What a window shows: the state, the panel on it, and the pictures of it. It takes egui's input and
//! draws one image; it knows no window, so that tests drive it as a window would.

use super::against::Against;
use super::fly_camera::{FlyCamera, Motion};
use super::inspect::PickedRay;
use super::panel::{self, Done, Told};
use super::path::PathEditor;
use super::pictures::{Answers, Pictures, Wanted};
use super::reload::{Change, Said};
use super::state::State;
use crate::app::cli::SceneOptions;
use crate::app::resolve;
use crate::error::Result;
use crate::gpu::{Frame, FrameContext, Gpu, Image, ImageDesc, Overlay, Pixels};
use crate::passes::look::{Compare, Look, LookPass};
use crate::scene::{Scene, View, library};
use ash::vk;
use egui::{Context, FullOutput, RawInput};
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

/// Seconds in which the camera crosses the scene, to begin with.
const CROSSING_S: f32 = 8.0;

/// Calls that may come from another thread: something is there to be shown.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Where shaders are watched, and what was said of them.
pub struct Shaders {
    /// The folder.
    pub folder: String,
    /// Changes, as they are compiled.
    pub changes: Receiver<Vec<Change>>,
    /// What was last said of each that changed.
    pub said: Vec<Said>,
}

/// A scene with everything that a user changes while looking at it.
pub struct Viewer {
    /// What the user changed.
    pub state: State,
    /// Key frames.
    pub path: PathEditor,
    pub(super) gpu: Gpu,
    pub(super) scene: Arc<Scene>,
    pub(super) views: Vec<View>,
    /// Of the scene that is loaded, and of the command line.
    pub(super) place: SceneOptions,
    pub(super) given: SceneOptions,
    scenes: Vec<String>,
    pub(super) pictures: Pictures,
    egui: Context,
    overlay: Overlay,
    look: LookPass,
    pub(super) screen: Image,
    shaders: Option<Shaders>,
    pub(super) answers: Option<Answers>,
    pub(super) ray: Option<PickedRay>,
    pub(super) against: Against,
    pub(super) wake: Wake,
    /// What the last call of [`Self::update`] made ready to be drawn.
    triangles: Vec<egui::ClippedPrimitive>,
    textures: egui::TexturesDelta,
    pixels_per_point: f32,
    pub(super) shown: Option<Look>,
    pub(super) frames: u64,
    drawings: u64,
    looking: bool,
}

/// What a frame needs of the window.
pub struct Updated {
    /// For egui-winit: cursor, clipboard.
    pub platform: egui::PlatformOutput,
    /// When to draw again, if nothing happens; `None` for not at all.
    pub again: Option<Duration>,
}

/// What a frame is made from.
pub struct Input {
    /// Of egui: mouse, keys, text, size in points.
    pub egui: RawInput,
    /// Where the keys held ask to fly, and for how long.
    pub motion: Motion,
    /// Since the last frame.
    pub seconds: f32,
    /// Width and height of the window in pixels.
    pub extent: [u32; 2],
}

impl Viewer {
    /// Uploads a scene. `place` says where scenes and lenses come from; `screen_format` is sRGB.
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
            // What moves by itself would be drawn again and again.
            style.animation_time = 0.0;
            style.visuals.weak_text_color = Some(egui::Color32::from_gray(150));
            style.visuals.override_text_color = Some(egui::Color32::from_gray(220));
            style.visuals.text_cursor.blink = false;
        });
        egui.set_theme(egui::Theme::Dark);
        Ok(Self {
            views: views(&scene, &place)?,
            pictures: Pictures::new(gpu, &scene)?,
            overlay: Overlay::new(gpu, screen_format)?,
            look: LookPass::new(gpu, screen_format)?,
            screen: screen(gpu, screen_format, [1, 1])?,
            scene: Arc::new(scene),
            gpu: gpu.clone(),
            state,
            path: PathEditor::default(),
            given: place.clone(),
            place,
            scenes,
            egui,
            shaders: None,
            answers: None,
            ray: None,
            against: Against::default(),
            wake,
            triangles: Vec::new(),
            textures: egui::TexturesDelta::default(),
            pixels_per_point: 1.0,
            shown: None,
            frames: 0,
            drawings: 0,
            looking: false,
        })
    }

    /// A camera at a view, with a speed that fits the scene.
    pub fn camera(scene: &Scene, view: &View) -> FlyCamera {
        let bounds = scene.bounds();
        let diagonal_m = bounds.min.distance(bounds.max);
        FlyCamera::new(view, if diagonal_m.is_finite() { (diagonal_m / CROSSING_S).max(0.01) } else { 1.0 })
    }

    /// Watches shaders from now on.
    pub fn watch(&mut self, shaders: Shaders) {
        self.shaders = Some(shaders);
    }

    /// egui's context, which egui-winit needs too.
    pub fn egui(&self) -> &Context {
        &self.egui
    }

    /// Whether the mouse turns the camera.
    pub fn is_looking(&self) -> bool {
        self.looking
    }

    /// The scene's views.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Frames rendered so far, and drawings of panel and picture.
    pub fn counts(&self) -> [u64; 2] {
        [self.frames, self.drawings]
    }

    /// Whether something is still being worked out that will be shown.
    pub fn is_waiting(&self) -> bool {
        self.against.is_waiting()
    }

    /// Makes the next frame be rendered, whatever it is.
    pub fn invalidate(&mut self) {
        self.pictures.invalidate();
    }

    /// One round: takes the input, renders if what is seen changed, asks the frame at rest if it did not,
    /// and makes the screen's drawing ready.
    pub fn update(&mut self, input: Input) -> Result<Updated> {
        self.move_camera(&input);
        self.take_shaders();
        self.against.poll();
        let (output, done) = self.run_panel(input.egui);
        self.looking = done.looking;
        let active = self.follow(&done, input.extent, output.pixels_per_point)?;
        self.textures.append(output.textures_delta);
        self.triangles = self.egui.tessellate(output.shapes, output.pixels_per_point);
        self.pixels_per_point = output.pixels_per_point;
        let delay = output.viewport_output.values().map(|v| v.repaint_delay).min().unwrap_or(Duration::MAX);
        let goes_on = active || self.path.playing().is_some() || input.motion.is_moving();
        let again = if goes_on { Some(Duration::ZERO) } else { Some(delay).filter(|d| *d != Duration::MAX) };
        Ok(Updated { platform: output.platform_output, again })
    }

    /// Draws what the last [`Self::update`] made ready: `present` gets the screen's image and what
    /// records its drawing.
    pub fn draw<R>(
        &mut self,
        present: impl FnOnce(&mut FrameContext, &Image, &mut dyn FnMut(&mut Frame) -> Result<()>) -> Result<R>,
    ) -> Result<Option<R>> {
        let Self { pictures, look, shown, overlay, screen, triangles, textures, pixels_per_point, .. } = self;
        let (Some(shown), Some((stage, kept, _))) = (shown, pictures.parts()) else { return Ok(None) };
        self.drawings += 1;
        overlay.update_textures(textures)?;
        let mut record = |frame: &mut Frame| {
            look.record(frame, screen, shown, kept)?;
            overlay.record(frame, screen.all(), *pixels_per_point, triangles)
        };
        present(&mut stage.context, screen, &mut record).map(Some)
    }

    /// The screen as it was last drawn, decoded to linear.
    pub fn read_screen(&mut self) -> Result<Pixels> {
        self.pictures.stage.context.read(self.screen.all())
    }

    /// The first picture alone, linear and without panel.
    pub fn read_picture(&mut self) -> Result<Option<Pixels>> {
        let Some((stage, [first, _], _)) = self.pictures.parts() else { return Ok(None) };
        stage.context.read(first.all()).map(Some)
    }

    /// What is seen, for a title.
    pub fn title(&self) -> String {
        let s = &self.state;
        let moved = if s.moved { " (moved)" } else { "" };
        let against = match s.compare {
            Compare::One => String::new(),
            Compare::Split | Compare::Difference => format!(" | {}", s.sides[1].method.name),
        };
        let roughness = s.globals.roughness.map(|r| format!(", roughness {r:.1}")).unwrap_or_default();
        let ms = self.pictures.shown(0).map_or(0.0, |p| p.history.total().median_ms);
        let method = s.sides[0].method.name;
        format!("{}, view {}{moved} — {method}{against}{roughness} — {ms:.2} ms", self.scene.name, s.view.name)
    }

    /// What the first method made in the last frame.
    #[cfg(test)]
    pub fn images(&self) -> Vec<super::pictures::ImageInfo> {
        self.pictures.shown(0).map(|s| s.images.clone()).unwrap_or_default()
    }

    /// The passes that the first method recorded in the last frame.
    #[cfg(test)]
    pub fn passes(&self) -> Vec<String> {
        self.pictures.shown(0).map(|s| s.history.recorded.clone()).unwrap_or_default()
    }

    /// The ray that is drawn.
    #[cfg(test)]
    pub fn ray(&self) -> Option<&PickedRay> {
        self.ray.as_ref()
    }

    /// The frame at rest on the host, if it was asked.
    #[cfg(test)]
    pub fn inspection(&self) -> Option<&super::inspect::Inspection> {
        self.answers.as_ref()?.inspection.as_ref()
    }

    /// What was last said of each shader that changed.
    #[cfg(test)]
    pub fn said_of_shaders(&self) -> Vec<Said> {
        self.shaders.as_ref().map(|s| s.said.clone()).unwrap_or_default()
    }

    fn move_camera(&mut self, input: &Input) {
        if input.motion.is_moving() {
            self.state.steer(|camera| camera.fly(input.motion, input.seconds));
        }
        if let Some(place) = self.path.advance(input.seconds) {
            self.state.steer(|camera| {
                camera.put(place);
                true
            });
        }
    }

    /// Takes the shaders that were compiled; one whose pipeline can't be made is not taken.
    fn take_shaders(&mut self) {
        let Some(shaders) = &mut self.shaders else { return };
        for (shader, made) in shaders.changes.try_iter().flatten() {
            let replaced = &self.gpu.shared().replaced_shaders;
            let said = made.and_then(|code| {
                let before = replaced.set(shader, Some(code));
                let tried = self.pictures.try_pipelines();
                tried.and_then(|()| LookPass::new(&self.gpu, self.screen.format())).map_err(|e| {
                    replaced.set(shader, before);
                    e.to_string()
                })
            });
            let said = said.map(|look| {
                self.look = look;
                self.pictures.discard_pipelines();
            });
            shaders.said.retain(|(name, _)| *name != shader.name);
            shaders.said.insert(0, (shader.name, said));
        }
    }

    fn run_panel(&mut self, input: RawInput) -> (FullOutput, Done) {
        let is_idle = !self.pictures.is_other(&self.wanted(self.area())) && !self.asks();
        let Self { state, path, pictures, egui, .. } = self;
        let command = reference_command(state, self.shown.map_or([1, 1], |l| [l.area[2], l.area[3]]));
        let told = Told {
            scenes: &self.scenes,
            views: &self.views,
            histories: [0, 1].iter().filter_map(|i| pictures.shown(*i)).map(|s| &s.history).collect(),
            images: pictures.shown(0).map_or(&[], |s| &s.images),
            answers: self.answers.as_ref(),
            ray: self.ray.as_ref(),
            against: &self.against,
            reference_command: &command,
            extent: self.shown.map_or([1, 1], |l| [l.area[2], l.area[3]]),
            shaders: self.shaders.as_ref().map(|s| (&s.folder[..], &s.said[..])),
            counts: [self.frames, self.drawings, self.gpu.submissions()],
            idle: is_idle,
        };
        let mut done = Done::default();
        let output = egui.run_ui(input, |ui| done = panel::show(ui, state, path, &told));
        (output, done)
    }

    pub(super) fn wanted(&self, extent: [u32; 2]) -> Wanted {
        self.state.wanted(&self.scene, extent)
    }

    fn area(&self) -> [u32; 2] {
        self.shown.map_or([1, 1], |l| [l.area[2], l.area[3]])
    }
}

/// The name of the scene that options name.
pub fn scene_name(place: &SceneOptions) -> String {
    match &place.scene[..] {
        [] => "rooms".into(),
        [one] => one.display().to_string(),
        [first, ..] => format!("{} …", first.display()),
    }
}

/// A scene's views with the lens of the options.
pub(super) fn views(scene: &Scene, place: &SceneOptions) -> Result<Vec<View>> {
    scene.views.iter().map(|v| resolve::with_lens(scene, v.clone(), place)).collect()
}

pub(super) fn screen(gpu: &Gpu, format: vk::Format, extent: [u32; 2]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    Image::new(gpu, &ImageDesc { name: "screen", format, extent, levels: 1, layers: 1, usage })
}

/// The command line that makes the reference of what is seen; it can name a view, not a camera that
/// flew away from one.
fn reference_command(state: &State, [width, height]: [u32; 2]) -> String {
    let (eye, look_at) = state.camera.place();
    let place = if state.moved || state.view.name == "custom" {
        let point = |p: glam::Vec3| format!("{},{},{}", p.x, p.y, p.z);
        format!("--eye {} --look-at {}", point(eye), point(look_at))
    } else {
        format!("--view {}", state.view.name)
    };
    let g = &state.globals;
    let mut factors = String::new();
    for (flag, value) in [("roughness", g.roughness), ("normal-deviation", g.normal_deviation)] {
        if let Some(v) = value {
            factors += &format!(" --{flag} {v}");
        }
    }
    if g.reflectivity != 1.0 {
        factors += &format!(" --reflectivity {}", g.reflectivity);
    }
    if let Some(fallback) = state.sides[0].options.get("fallback") {
        factors += &format!(" --fallback {fallback}");
    }
    let scene = &state.scene;
    format!("ssct render --method reference --scene {scene} {place} --size {width}x{height}{factors} -o truth.png")
}
