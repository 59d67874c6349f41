//! Lets the user record, save, load and play key frames of the camera.

use super::shared::heading;
use crate::path::PathEditor;
use crate::state::State;
use egui::{Grid, RichText, Slider, Ui};
use std::path::Path;

/// Draws this part of the panel: the list of key frames with its buttons, and the file in which they are saved.
pub fn show(ui: &mut Ui, state: &mut State, path: &mut PathEditor) {
    heading(ui, "Key frames");
    ui.horizontal(|ui| {
        if ui.button("record (K)").clicked() {
            path.record(&state.camera);
        }
        let playing = path.playing();
        if ui.button(if playing.is_some() { "stop (P)" } else { "play (P)" }).clicked() {
            path.play_or_stop();
        }
        if let Some(share) = playing {
            ui.label(format!("{:.0} %", share * 100.0));
        }
        if ui.add_enabled(!path.keys.is_empty(), egui::Button::new("clear")).clicked() {
            path.keys.clear();
        }
    });
    ui.add(Slider::new(&mut path.seconds, 1.0..=60.0).text("seconds to play"));
    ui.horizontal(|ui| {
        ui.add(egui::TextEdit::singleline(&mut path.file).desired_width(150.0));
        if ui.button("save").clicked() {
            path.save();
        }
        if ui.button("load").clicked() {
            let file = path.file.clone();
            if let Err(e) = path.load(Path::new(&file)) {
                path.message = e.to_string();
            }
        }
    });
    ui.label(RichText::new(&path.message).weak());
    let mut remove = None;
    Grid::new("keys").num_columns(4).striped(true).show(ui, |ui| {
        for (n, key) in path.keys.iter().enumerate() {
            ui.label((n + 1).to_string());
            let e = key.eye;
            ui.label(format!("{:.2}, {:.2}, {:.2}", e.x, e.y, e.z));
            if ui.small_button("go").clicked() {
                state.put_camera((key.eye, key.look_at));
            }
            if ui.small_button("remove").clicked() {
                remove = Some(n);
            }
            ui.end_row();
        }
    });
    if let Some(n) = remove {
        path.keys.remove(n);
    }
    ui.label(RichText::new("ssct path --path FILE measures along the same file").weak().small());
}
