//! What a window shows: a scene, a camera that flies through it, and a method that can change.
//! It renders and knows no window; `window` shows what it rendered.

use super::fly_camera::FlyCamera;
use crate::error::Result;
use crate::gpu::frame::Mode;
use crate::gpu::{FrameContext, Gpu, Image};
use crate::methods::{METHODS, MethodInfo, Setup};
use crate::scene::{Scene, View};
use crate::study::{Globals, Shot, Stage, Stats};
use std::collections::VecDeque;

/// Frames that the median in the title is of.
const RECENT_FRAMES: usize = 31;
/// Seconds in which the camera crosses the scene, to begin with.
const CROSSING_S: f32 = 8.0;
/// Step of the global roughness.
const ROUGHNESS_STEP: f32 = 0.1;

/// A scene on a device and everything that a user changes while looking at it.
pub struct Viewer {
    scene: Scene,
    /// The scene's views, with the lens of the command line.
    views: Vec<View>,
    /// The view that the camera came from; its lens and materials hold until the next.
    view: View,
    camera: FlyCamera,
    /// Whether the camera left its view.
    moved: bool,
    method: &'static MethodInfo,
    globals: Globals,
    setup: Setup,
    stage: Stage,
    /// Of the present method and size; made when it is needed.
    shot: Option<Shot>,
    /// Whether the shot has yet to hear of other materials.
    materials_changed: bool,
    /// Effect times of the last frames of this method, size and view, in milliseconds.
    recent_ms: VecDeque<f64>,
}

impl Viewer {
    /// Uploads a scene. `views` are what [`Self::show_view`] counts, each with its lens; `view` is
    /// where the camera starts. The size in `setup` is replaced by each frame's.
    pub fn new(
        gpu: &Gpu,
        scene: Scene,
        views: Vec<View>,
        view: View,
        method: &'static MethodInfo,
        globals: Globals,
        setup: Setup,
    ) -> Result<Self> {
        let bounds = scene.bounds();
        let diagonal_m = bounds.min.distance(bounds.max);
        let speed_m_per_s = if diagonal_m.is_finite() { (diagonal_m / CROSSING_S).max(0.01) } else { 1.0 };
        Ok(Self {
            stage: Stage::new(gpu, &scene)?,
            camera: FlyCamera::new(&view, speed_m_per_s),
            moved: false,
            scene,
            views,
            view,
            method,
            globals,
            setup,
            shot: None,
            materials_changed: false,
            recent_ms: VecDeque::new(),
        })
    }

    /// Renders a frame and hands the finished image, linear, to `show`.
    pub fn draw<R>(
        &mut self,
        extent: [u32; 2],
        show: impl FnOnce(&mut FrameContext, &Image) -> Result<R>,
    ) -> Result<R> {
        if self.setup.extent != extent {
            self.setup.extent = extent;
            self.discard_shot();
        }
        let lens = self.view.lens.unwrap_or(self.scene.lens);
        let camera = self.camera.camera(lens, extent[0] as f32 / extent[1] as f32);
        let materials = || self.globals.materials(&self.scene, &self.view);
        let shot = match &mut self.shot {
            Some(shot) => {
                if self.materials_changed {
                    shot.set_materials(&mut self.stage, materials())?;
                }
                shot
            }
            none => none.insert(Shot::new(&mut self.stage, self.method, &self.setup, camera, materials())?),
        };
        self.materials_changed = false;
        shot.camera = camera;
        let (report, _, output) = self.stage.output_in(Mode::Timed, shot)?;
        if self.recent_ms.len() == RECENT_FRAMES {
            self.recent_ms.pop_front();
        }
        self.recent_ms.push_back(report.passes.iter().filter(|p| p.counted).map(|p| p.ms).sum());
        show(&mut self.stage.context, output.composite)
    }

    /// Changes the camera by a function that says whether it did.
    pub fn steer(&mut self, change: impl FnOnce(&mut FlyCamera) -> bool) -> bool {
        let changed = change(&mut self.camera);
        self.moved |= changed;
        changed
    }

    /// Jumps to a view of the scene, counted from 0; whether there is one.
    pub fn show_view(&mut self, index: usize) -> bool {
        let Some(view) = self.views.get(index) else { return false };
        self.view = view.clone();
        self.camera.jump(view);
        self.moved = false;
        self.recent_ms.clear();
        self.materials_changed = true;
        true
    }

    /// Goes on to the next method of the table.
    pub fn next_method(&mut self) {
        let now = METHODS.iter().position(|m| m.name == self.method.name).unwrap_or(0);
        let after = METHODS.iter().cycle().skip(now + 1).take(METHODS.len());
        // A fallback goes behind screen-space methods only.
        let mut fit = after.filter(|m| self.setup.fallback.is_none() || m.is_screen_space());
        self.method = fit.next().unwrap_or(self.method);
        self.discard_shot();
    }

    /// Makes every material rougher (positive) or smoother by steps. Materials that kept their own
    /// roughness so far all start from 0.
    pub fn change_roughness(&mut self, steps: f32) {
        let now = (self.globals.roughness.unwrap_or(0.0) / ROUGHNESS_STEP).round();
        self.globals.roughness = Some(((now + steps) * ROUGHNESS_STEP).clamp(0.0, 1.0));
        self.materials_changed = true;
    }

    /// What is seen, and how long it takes.
    pub fn title(&self) -> String {
        let samples: Vec<f64> = self.recent_ms.iter().copied().collect();
        let moved = if self.moved { " (moved)" } else { "" };
        let roughness = self.globals.roughness.map(|r| format!(", roughness {r:.1}")).unwrap_or_default();
        let ms = Stats::of(&samples).median_ms;
        format!("{}, view {}{moved} — {}{roughness} — {ms:.2} ms", self.scene.name, self.view.name, self.method.name)
    }

    fn discard_shot(&mut self) {
        self.shot = None;
        self.recent_ms.clear();
    }
}
