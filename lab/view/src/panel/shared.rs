//! The data that the parts of the panel display, the actions that they return, and small widgets that they share.

use crate::history::History;
use crate::input::Action;
use crate::pictures::{FrameAnalysis, ImageInfo};
use crate::reference_error::ReferenceComparison;
use crate::reload::ShaderStatus;
use egui::{Color32, Rect, RichText, Sense, Ui};
use ssct_lab::study::inspect::PickedRay;
use ssct_lab::study::pixel::PixelReport;
use ssct_scenes::{Capture, View};

/// The data that the panel displays.
pub struct PanelData<'a> {
    /// Names of all scenes.
    pub scenes: &'a [String],
    /// Says why the scene that the user chose last could not be loaded.
    pub scene_fault: Option<&'a str>,
    /// Views of the scene.
    pub views: &'a [View],
    /// Pass times of the shown methods.
    pub histories: Vec<&'a History>,
    /// The captures in which rays of the first method go on.
    pub captures: &'a [Capture],
    /// The images that the first method made.
    pub images: &'a [ImageInfo],
    /// The analysis of the frame at rest, if there is one.
    pub analysis: Option<&'a FrameAnalysis>,
    /// The picked ray.
    pub ray: Option<&'a PickedRay>,
    /// The report on the picked pixel.
    pub pixel: Option<&'a PixelReport>,
    /// The error against a cached reference.
    pub reference_error: &'a ReferenceComparison,
    /// The command that would make the missing reference.
    pub reference_command: &'a str,
    /// Width and height of the pictures, in pixels.
    pub extent: [u32; 2],
    /// The folder whose shaders are watched, and the status of each shader that has changed.
    pub shaders: Option<(&'a str, &'a [ShaderStatus])>,
    /// Frames rendered, drawings of the panel, and submissions to the device.
    pub counts: [u64; 3],
    /// Whether nothing remains to be rendered.
    pub idle: bool,
}

/// Actions of the user that are more than a change of the state.
#[derive(Debug, Default)]
pub struct PanelActions {
    /// The area of the pictures, in points.
    pub area: Option<Rect>,
    /// Whether the mouse turns the camera.
    pub looking: bool,
    /// The action of a button of the panel, if a key has the same action.
    pub action: Option<Action>,
    /// Whether the range of the shown picture must be set to that of its numbers.
    pub fit_range: bool,
}

/// Draws a small filled circle.
pub fn dot(ui: &mut Ui, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, color);
}

/// Draws the heading of a section of the panel.
pub fn heading(ui: &mut Ui, text: impl Into<String>) {
    ui.add_space(6.0);
    ui.label(RichText::new(text).strong());
}

/// Draws the first row of a table: the titles of its columns.
pub fn header_row(ui: &mut Ui, titles: &[&str]) {
    for title in titles {
        ui.label(RichText::new(*title).weak());
    }
    ui.end_row();
}
