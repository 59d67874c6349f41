//! Lets the user choose an intermediate image, its mip level, and the range and exposure with which it is shown.

use super::shared::{PanelActions, PanelData, heading};
use crate::state::{InnerImage, STEPS, State};
use egui::{ComboBox, DragValue, RichText, Slider, Ui};

/// Draws this part of the panel: the list of images, and the level, channel, exposure and range of the image that is
/// shown.
pub fn show(ui: &mut Ui, state: &mut State, data: &PanelData, actions: &mut PanelActions) {
    heading(ui, "Image");
    ui.selectable_value(&mut state.inside, None, "the finished image");
    let chosen = state.inside.as_ref().map(|i| i.name.clone());
    for image in data.images {
        let [width, height] = image.extent;
        let levels = if image.levels > 1 { format!(", {} levels", image.levels) } else { String::new() };
        let text = format!("{}  ({width}×{height}{levels})", image.name);
        if ui.selectable_label(chosen.as_deref() == Some(&image.name), text).clicked() {
            state.inside = Some(InnerImage { name: image.name.clone(), level: 0 });
            state.tone.range = [0.0, 1.0];
        }
    }
    let steps = ui.selectable_label(chosen.as_deref() == Some(STEPS), "steps of the rays  (heat map)");
    if steps.on_hover_text("counted on the CPU when nothing moves, by twins of ssct, hzct and unified").clicked() {
        state.inside = Some(InnerImage { name: STEPS.to_owned(), level: 0 });
        state.tone.range = [0.0, 64.0];
    }
    let Some(inside) = &mut state.inside else { return };
    if inside.name == STEPS && data.analysis.is_some_and(|a| a.steps.is_none()) {
        ui.colored_label(ui.visuals().warn_fg_color, "this method's steps are not counted, or not at this resolution");
    }
    heading(ui, "Level");
    let levels = data.images.iter().find(|i| i.name == inside.name).map_or(1, |i| i.levels);
    // Before the first frame, the number of levels is unknown.
    if !data.images.is_empty() {
        ui.add_enabled(levels > 1, Slider::new(&mut inside.level, 0..=levels - 1).text("mip level"));
    }
    heading(ui, "Shades");
    ui.horizontal(|ui| {
        ui.label("channel");
        let name = |c: Option<u32>| c.map_or("all", |c| ["red", "green", "blue", "alpha"][c as usize % 4]);
        ComboBox::from_id_salt("channel").selected_text(name(state.tone.channel)).show_ui(ui, |ui| {
            for c in [None, Some(0), Some(1), Some(2), Some(3)] {
                ui.selectable_value(&mut state.tone.channel, c, name(c));
            }
        });
    });
    ui.add(Slider::new(&mut state.tone.exposure_stops, -10.0..=10.0).text("exposure, stops"));
    ui.horizontal(|ui| {
        let [low, high] = &mut state.tone.range;
        let speed = f64::from((*high - *low).abs()).max(1e-4) * 0.01;
        ui.label("range");
        ui.add(DragValue::new(low).speed(speed).max_decimals(5));
        ui.label("to");
        ui.add(DragValue::new(high).speed(speed).max_decimals(5));
        actions.fit_range = ui.button("fit").on_hover_text("to the least and greatest number shown").clicked();
        if ui.button("0 to 1").clicked() {
            state.tone.range = [0.0, 1.0];
            state.tone.exposure_stops = 0.0;
        }
    });
    ui.label(RichText::new("numbers of the range are those of the channels, after the exposure").weak().small());
}
