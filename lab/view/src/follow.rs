//! Updates the viewer after the panel has changed the state. A frame is rendered if the request changed, and otherwise
//! the frame at rest is analysed. The picked ray, the range of numbers and the screen are updated, too.

use super::captures::CaptureEditor;
use super::panel::PanelActions;
use super::pictures::{FrameAnalysis, FrameRequest, Pictures};
use super::reference_error::ComparisonRequest;
use super::state::{STEPS, Tab};
use super::viewer::{Viewer, new_screen, scene_name, views_with_lens};
use ssct::methods::Setup;
use ssct::passes::Content;
use ssct::passes::look::PictureDisplay;
use ssct_lab::app::cli::SceneOptions;
use ssct_lab::app::resolve;
use ssct_lab::error::{Error, Result};
use ssct_lab::study::pixel::{self, MethodImages, PixelMethod, PixelReport};
use ssct_truth::reference::surface::World;
use std::path::PathBuf;
use std::sync::Arc;

impl Viewer {
    /// Updates pictures and screen to match the state; returns whether there was anything to do. `extent` is the
    /// window's size in pixels, and a point of the panel has `pixels_per_point` pixels.
    pub(super) fn follow(&mut self, actions: &PanelActions, extent: [u32; 2], pixels_per_point: f32) -> Result<bool> {
        let shown = scene_name(&self.place);
        if self.state.scene != shown {
            self.scene_fault = self.load_scene().err().map(|e| e.to_string());
            if self.scene_fault.is_some() {
                self.state.scene = shown;
            }
        }
        if self.screen.extent() != extent {
            self.screen = new_screen(&self.gpu, self.screen.format(), extent)?;
        }
        // The rectangle of the pictures: left, top, width and height in pixels.
        let area = actions.area.map_or([0, 0, extent[0], extent[1]], |a| pixels(a, extent, pixels_per_point));
        let request = self.frame_request([area[2], area[3]]);
        let mut has_work = true;
        if self.pictures.needs_rendering(&request) {
            self.pictures.render(&request)?;
            self.frames += 1;
            (self.analysis, self.ray, self.pixel) = (None, None, None);
            self.reference_error.forget();
        } else if self.needs_analysis() {
            let analysis = self.pictures.analyse()?;
            if self.state.tab == Tab::Live {
                self.compare_with_reference(&request, &analysis);
            }
            self.analysis = Some(analysis);
        } else {
            has_work = false;
        }
        has_work |= self.pick();
        if actions.fit_range {
            self.fit_range()?;
            has_work = true;
        }
        let content = self.pictures.shown(0).map(|s| s.content);
        self.display = Some(PictureDisplay {
            area,
            compare: self.state.compare,
            split: self.state.split,
            gain: self.state.gain,
            tone: self.state.shown_tone(content.unwrap_or(Content::Color)),
            lens: self.pictures.shown(0).and_then(|s| s.lens).unwrap_or(request.camera.lens),
        });
        Ok(has_work)
    }

    /// Returns whether the frame at rest must be analysed, because the picture or the open part of the panel shows the
    /// results.
    pub(super) fn needs_analysis(&self) -> bool {
        let shows_steps = self.state.inside.as_ref().is_some_and(|i| i.name == STEPS);
        let shows_results = shows_steps || matches!(self.state.tab, Tab::Live | Tab::Ray);
        let lacks_reference =
            self.state.tab == Tab::Live && !self.reference_error.is_waiting() && self.reference_error.outcome.is_none();
        shows_results && (self.analysis.is_none() || lacks_reference)
    }

    /// Traces the ray of the picked pixel, if the panel shows it, and explains the pixel. Returns whether the ray
    /// changed.
    fn pick(&mut self) -> bool {
        let picked = self.state.picked.filter(|_| self.state.tab == Tab::Ray);
        let inspection = self.analysis.as_ref().and_then(|a| a.inspection.as_ref());
        let (Some(pixel), Some(inspection)) = (picked, inspection) else { return false };
        if self.ray.as_ref().is_some_and(|r| r.pixel == pixel) {
            return false;
        }
        self.ray = inspection.pick(pixel);
        self.pixel = self.explain(pixel);
        self.ray.is_some()
    }

    /// Returns the report on a pixel of the first method's frame at rest; `None` if the frame was not analysed.
    fn explain(&self, pixel: [u32; 2]) -> Option<PixelReport> {
        let analysis = self.analysis.as_ref()?;
        let (inspection, [reflection, composite]) =
            (analysis.inspection.as_ref()?, analysis.reflection_and_composite.as_ref()?);
        let side = &self.state.sides[0];
        let materials = self.state.globals.materials(&self.scene, &self.state.view);
        let world = World::new(&self.scene, &materials);
        let method = PixelMethod { name: side.method.name, bounces: side.setup.effect().bounces };
        pixel::explain(inspection, MethodImages { reflection, composite }, &world, method, pixel)
    }

    /// Starts to compare the frame at rest with the world reference, on another thread.
    fn compare_with_reference(&mut self, request: &FrameRequest, analysis: &FrameAnalysis) {
        let comparison = ComparisonRequest {
            scene: Arc::clone(&self.scene),
            materials: request.materials.clone(),
            camera: request.camera,
            extent: request.extent,
            effect: request.sides.first().map_or_else(|| Setup::new(request.extent).effect(), |s| s.setup.effect()),
            reflections: analysis.reflections.clone(),
        };
        let wake = Arc::clone(&self.wake);
        self.reference_error.start(comparison, move || wake());
    }

    /// Sets the range of numbers that is shown to the least and the greatest number of the first picture, in the shown
    /// channels.
    fn fit_range(&mut self) -> Result<()> {
        let Some(pixels) = self.read_picture()? else { return Ok(()) };
        let tone = self.state.tone;
        let channels = match tone.channel {
            Some(c) => c as usize..c as usize + 1,
            None => 0..3,
        };
        // The range is that of the numbers after the exposure.
        let factor = tone.exposure_stops.exp2();
        let numbers = pixels.texels().flat_map(|t| t[channels.clone()].iter()).copied().filter(|v| v.is_finite());
        let nothing = (f32::INFINITY, f32::NEG_INFINITY);
        let (least, greatest) = numbers.fold(nothing, |(least, greatest), v| (least.min(v), greatest.max(v)));
        if least <= greatest {
            self.state.tone.range = [least * factor, (greatest * factor).max(least * factor + 1e-6)];
        }
        Ok(())
    }

    /// Loads the scene that the state names, and shows its first view. After an error, the shown scene is as it was.
    fn load_scene(&mut self) -> Result<()> {
        let first_place = self.first_place.clone();
        let place = if self.state.scene == scene_name(&first_place) {
            first_place
        } else {
            // Options that suit the size or the motions of the first scene alone are left out.
            SceneOptions {
                scene: vec![PathBuf::from(&self.state.scene)],
                scale: 1.0,
                time: None,
                motion: None,
                orthographic_height: None,
                near: None,
                far: None,
                ..first_place
            }
        };
        let scene = resolve::scene(&place, "rooms")?;
        let views = views_with_lens(&scene, &place)?;
        let Some(first) = views.first().cloned() else {
            return Err(Error::usage(format!("scene {} has no view", scene.name)));
        };
        // The memory of the old scene is freed before the new one is uploaded.
        self.pictures.discard_pipelines();
        self.pictures = Pictures::new(&self.gpu, &scene)?;
        self.views = views;
        self.state.camera = Self::camera(&scene, &first);
        self.state.show_view(&first);
        self.state.picked = None;
        self.captures = CaptureEditor::new(&place.scene, place.scale);
        (self.analysis, self.ray, self.pixel) = (None, None, None);
        self.scene = Arc::new(scene);
        self.place = place;
        Ok(())
    }
}

/// Returns left, top, width and height in pixels of a rectangle in points, cut to a window of the given size in pixels.
/// The result has at least one pixel.
fn pixels(area: egui::Rect, [width, height]: [u32; 2], pixels_per_point: f32) -> [u32; 4] {
    let to_pixels = |v: f32| (v * pixels_per_point).round().max(0.0) as u32;
    let (left, top) = (to_pixels(area.left()).min(width - 1), to_pixels(area.top()).min(height - 1));
    let (right, bottom) = (to_pixels(area.right()).min(width), to_pixels(area.bottom()).min(height));
    [left, top, right.saturating_sub(left).max(1), bottom.saturating_sub(top).max(1)]
}
