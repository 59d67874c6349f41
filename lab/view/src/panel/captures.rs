//! Shows the captures of the scene and their places, and lets the user move, add, remove and save them.

use super::shared::{PanelActions, PanelData, heading};
use crate::captures::CaptureEditor;
use crate::cubes::{CubeImage, CubePart};
use crate::input::Action;
use crate::state::{InnerImage, State};
use egui::{Grid, RichText, Ui};

/// Draws this part of the panel: the list of captures with its buttons, and the file in which they are saved.
pub fn show(ui: &mut Ui, state: &mut State, editor: &mut CaptureEditor, data: &PanelData, actions: &mut PanelActions) {
    ui.label("Cubes of images in which rays go on that the screen loses. The method's option captures turns them on.");
    let captures = editor.list.as_deref().unwrap_or(data.captures);
    heading(ui, if editor.list.is_some() { "Captures, changed" } else { "Captures of the scene" });
    if captures.is_empty() {
        ui.label(RichText::new("none are shown").weak());
    }
    let mut selected = editor.selected;
    Grid::new("captures").num_columns(4).striped(true).show(ui, |ui| {
        for (k, capture) in captures.iter().enumerate() {
            ui.radio_value(&mut selected, k, (k + 1).to_string());
            let p = capture.position;
            ui.label(format!("{:.2}, {:.2}, {:.2}", p.x, p.y, p.z))
                .on_hover_text(format!("near plane {} m, {1}×{1} texels a face", capture.near_m, capture.resolution));
            if ui.small_button("go").on_hover_text("the camera goes there").clicked() {
                let (eye, look_at) = state.camera.place();
                state.put_camera((p, p + (look_at - eye)));
            }
            if ui.small_button("look").on_hover_text("shows its images instead of the finished image").clicked() {
                let name = CubeImage { capture: k, part: CubePart::Color }.name();
                state.inside = Some(InnerImage { name, level: 0 });
                state.tone.range = [0.0, 1.0];
            }
            ui.end_row();
        }
    });
    let has_any = !captures.is_empty();
    editor.selected = selected;
    ui.horizontal_wrapped(|ui| {
        for (text, action, is_possible) in [
            ("add at the eye (N)", Action::AddCapture, true),
            ("move to the eye (B)", Action::MoveCapture, has_any),
            ("remove (Delete)", Action::RemoveCapture, has_any),
        ] {
            if ui.add_enabled(is_possible, egui::Button::new(text)).clicked() {
                actions.action = Some(action);
            }
        }
        if ui.add_enabled(editor.list.is_some(), egui::Button::new("back to the scene's")).clicked() {
            editor.forget();
        }
    });
    if state.inside.as_ref().is_some_and(|i| CubeImage::find(&i.name).is_some())
        && ui.button("back to the finished image").clicked()
    {
        state.inside = None;
    }
    heading(ui, "Scene file");
    ui.horizontal(|ui| {
        ui.add(egui::TextEdit::singleline(&mut editor.file).desired_width(200.0));
        if ui.add_enabled(has_any, egui::Button::new("save")).clicked() {
            editor.save(data.captures);
        }
    });
    ui.label(RichText::new(&editor.message).weak());
    ui.label(RichText::new("[[capture]] tables; all else in the file stays as it is").weak().small());
}
