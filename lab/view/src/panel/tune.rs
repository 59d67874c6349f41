//! Lets the user choose scene, view, methods and materials; [`super::options`] draws the options of the methods.

use super::options::{PUBLISHED, draw_side};
use super::shared::{PanelData, dot, heading};
use crate::state::State;
use egui::{ComboBox, Grid, RichText, Slider, Ui};
use ssct::passes::look::Compare;

/// Draws this part of the panel: the rows for scene, view, methods and materials.
pub fn show(ui: &mut Ui, state: &mut State, data: &PanelData) {
    draw_place(ui, state, data);
    heading(ui, "Compare");
    ui.horizontal(|ui| {
        for (compare, text) in
            [(Compare::One, "one method"), (Compare::Split, "side by side"), (Compare::Difference, "difference")]
        {
            ui.selectable_value(&mut state.compare, compare, text);
        }
    });
    match state.compare {
        Compare::One => {}
        Compare::Split => drop(ui.add(Slider::new(&mut state.split, 0.0..=1.0).text("split"))),
        Compare::Difference => {
            ui.add(Slider::new(&mut state.gain, 1.0..=64.0).logarithmic(true).text("gain"));
        }
    }
    for i in 0..state.rendered().len() {
        draw_side(ui, state, i);
    }
    draw_materials(ui, state);
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        dot(ui, PUBLISHED);
        ui.label(RichText::new("the published value").weak().small());
    });
}

/// Draws the rows for scene, view and speed.
fn draw_place(ui: &mut Ui, state: &mut State, data: &PanelData) {
    Grid::new("place").num_columns(2).show(ui, |ui| {
        ui.label("scene");
        ComboBox::from_id_salt("scene").selected_text(&state.scene).show_ui(ui, |ui| {
            for name in data.scenes {
                ui.selectable_value(&mut state.scene, name.clone(), name);
            }
        });
        ui.end_row();
        if let Some(fault) = data.scene_fault {
            ui.label("");
            ui.colored_label(ui.visuals().error_fg_color, fault);
            ui.end_row();
        }
        ui.label("view");
        let moved = if state.moved { " (moved)" } else { "" };
        let mut chosen = None;
        ui.horizontal(|ui| {
            let text = format!("{}{moved}", state.view.name);
            ComboBox::from_id_salt("view").selected_text(text).show_ui(ui, |ui| {
                for (i, view) in data.views.iter().enumerate() {
                    if ui.selectable_label(view.name == state.view.name, format!("{}  {}", i + 1, view.name)).clicked()
                    {
                        chosen = Some(view);
                    }
                }
            });
            if state.moved && ui.small_button("back").clicked() {
                let view = state.view.clone();
                state.show_view(&view);
            }
        });
        if let Some(view) = chosen {
            state.show_view(view);
        }
        ui.end_row();
        ui.label("speed").on_hover_text("Speed of flying; the wheel changes it.");
        ui.label(format!("{:.2} m/s", state.camera.speed_m_per_s()));
        ui.end_row();
    });
}

/// Draws the sliders that replace the materials' roughness and normal deviation, or scale their reflectivity.
fn draw_materials(ui: &mut Ui, state: &mut State) {
    heading(ui, "Materials");
    let globals = &mut state.globals;
    for (name, value) in [("roughness", &mut globals.roughness), ("normal deviation", &mut globals.normal_deviation)] {
        ui.horizontal(|ui| {
            // A material keeps its own value if there is no number to replace it.
            let mut keeps_own = value.is_none();
            let mut number = value.unwrap_or(0.0);
            let slider = ui.add_enabled(!keeps_own, Slider::new(&mut number, 0.0..=1.0).text(name));
            ui.checkbox(&mut keeps_own, "own").on_hover_text("each material keeps its own");
            if slider.changed() || keeps_own != value.is_none() {
                *value = (!keeps_own).then_some(number);
            }
        });
    }
    ui.add(Slider::new(&mut globals.reflectivity, 0.0..=1.0).text("reflectivity, a factor"));
}
