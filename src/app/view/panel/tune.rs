//! Scene, view, methods, materials and every parameter. The methods' options are those of the command
//! line, read off its flags, so that a new flag is a new row.

use super::{Told, dot, heading};
use crate::app::view::state::{SWITCHED_ON, Side, State};
use crate::methods::thesis::{self, Variant};
use crate::methods::{METHODS, Preset, Tuning};
use crate::passes::look::Compare;
use crate::scene::Camera;
use clap::ArgAction;
use egui::{Color32, ComboBox, DragValue, Grid, RichText, Slider, Ui};

/// What marks a value that is the published one.
const PUBLISHED: Color32 = Color32::from_rgb(110, 190, 120);

pub fn show(ui: &mut Ui, state: &mut State, told: &Told) {
    place(ui, state, told);
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
        side(ui, state, i, told);
    }
    materials(ui, state);
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        dot(ui, PUBLISHED);
        ui.label(RichText::new("the published value").weak().small());
    });
}

fn place(ui: &mut Ui, state: &mut State, told: &Told) {
    Grid::new("place").num_columns(2).show(ui, |ui| {
        ui.label("scene");
        ComboBox::from_id_salt("scene").selected_text(&state.scene).show_ui(ui, |ui| {
            for name in told.scenes {
                ui.selectable_value(&mut state.scene, name.clone(), name);
            }
        });
        ui.end_row();
        ui.label("view");
        let moved = if state.moved { " (moved)" } else { "" };
        let mut chosen = None;
        ui.horizontal(|ui| {
            let text = format!("{}{moved}", state.view.name);
            ComboBox::from_id_salt("view").selected_text(text).show_ui(ui, |ui| {
                for (i, view) in told.views.iter().enumerate() {
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
        ui.label("speed").on_hover_text("of flying; the wheel changes it");
        ui.label(format!("{:.2} m/s", state.camera.speed_m_per_s()));
        ui.end_row();
    });
}

fn side(ui: &mut Ui, state: &mut State, index: usize, told: &Told) {
    let title = if state.rendered().len() == 1 { "Method" } else { ["Left method", "Right method"][index] };
    heading(ui, title);
    ui.push_id(("side", index), |ui| {
        let mut chosen = None;
        let method = state.sides[index].method;
        ComboBox::from_id_salt("method").width(140.0).selected_text(method.name).show_ui(ui, |ui| {
            for info in METHODS {
                let about = format!("{}\n{}", info.summary, info.source);
                if ui.selectable_label(info.name == method.name, info.name).on_hover_text(about).clicked() {
                    chosen = Some(info);
                }
            }
        });
        if let Some(info) = chosen {
            state.choose(index, info);
        }
        ui.label(RichText::new(format!("{} ({})", method.summary, method.source)).weak().small());
        let side = &mut state.sides[index];
        let command = Side::command();
        Grid::new("options").num_columns(3).show(ui, |ui| {
            for argument in command.get_arguments() {
                if let Some(flag) = argument.get_long() {
                    option(ui, side, argument, flag, told);
                    ui.end_row();
                }
            }
        });
        if let Some(fault) = &side.fault {
            ui.colored_label(ui.visuals().error_fg_color, fault);
        }
    });
}

/// A row: the option's name, its control, and whether its value is the published one.
fn option(ui: &mut Ui, side: &mut Side, argument: &clap::Arg, flag: &str, told: &Told) {
    let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    ui.label(flag.replace('-', " ")).on_hover_text(help);
    let given = side.options.get(flag).cloned();
    let default = argument.get_default_values().first().map(|v| v.to_string_lossy().into_owned());
    let values = argument.get_possible_values();
    let mut now = given.clone();
    if matches!(argument.get_action(), ArgAction::SetTrue) {
        let mut on = given.is_some();
        ui.checkbox(&mut on, "");
        now = on.then(|| SWITCHED_ON.to_owned());
    } else if !values.is_empty() {
        let shown = given.clone().or(default.clone()).unwrap_or_default();
        ComboBox::from_id_salt(flag).selected_text(&shown).show_ui(ui, |ui| {
            for value in &values {
                let about = value.get_help().map(ToString::to_string).unwrap_or_default();
                if ui.selectable_label(value.get_name() == shown, value.get_name()).on_hover_text(about).clicked() {
                    now = Some(value.get_name().to_owned());
                }
            }
        });
    } else {
        number(ui, side, flag, &mut now, told);
    }
    // A flag without a default is a number that replaces the preset's.
    let published = match (&now, &default) {
        (None, Some(_)) => true,
        (Some(now), Some(default)) => now == default,
        (value, None) => match published(Preset::Published, flag, told) {
            Some(n) => value.as_ref().map_or(published(side.setup.preset, flag, told), |v| v.parse().ok()) == Some(n),
            None => value.is_none(),
        },
    };
    if published {
        dot(ui, PUBLISHED);
    }
    if now != given {
        side.set(flag, now);
    }
}

/// A number that replaces the preset's, beside the published one.
fn number(ui: &mut Ui, side: &Side, flag: &str, now: &mut Option<String>, told: &Told) {
    ui.horizontal(|ui| {
        let preset = published(side.setup.preset, flag, told);
        match preset {
            Some(preset) => {
                let is_whole = preset.fract() == 0.0;
                let mut value = now.as_ref().and_then(|v| v.parse().ok()).unwrap_or(preset);
                let speed = if is_whole { 0.2 } else { preset.abs().max(1e-4) * 0.02 };
                let drag = DragValue::new(&mut value).speed(speed).max_decimals(if is_whole { 0 } else { 5 });
                if ui.add(drag).changed() {
                    *now = Some(format!("{value}"));
                }
                if now.is_some() && ui.small_button("preset's").clicked() {
                    *now = None;
                }
                if let Some(n) = published(Preset::Published, flag, told) {
                    ui.label(RichText::new(format!("published {n}")).weak().small());
                }
            }
            None => {
                let mut text = now.clone().unwrap_or_default();
                let edit = egui::TextEdit::singleline(&mut text).desired_width(60.0).hint_text("preset's");
                if ui.add(edit).changed() {
                    *now = (!text.is_empty()).then_some(text);
                }
            }
        }
    });
}

/// The number that a preset of the thesis has for a flag.
fn published(preset: Preset, flag: &str, told: &Told) -> Option<f64> {
    let variant = Variant { preset, tuning: Tuning::default(), fallback: true, fade: true };
    let camera: &Camera = &told.camera;
    let block = thesis::parameters(&variant, camera, told.extent, crate::gpu::image::full_chain(told.extent));
    Some(match flag {
        "iterations" => f64::from(block.iterations),
        "start-level" => f64::from(block.start_level),
        "cone-samples" => f64::from(block.cone_samples),
        // The decimal that is printed, not its nearest binary fraction.
        "march-stride" => block.linear_march_stride.to_string().parse().ok()?,
        _ => return None,
    })
}

fn materials(ui: &mut Ui, state: &mut State) {
    heading(ui, "Materials");
    let globals = &mut state.globals;
    for (name, value) in [("roughness", &mut globals.roughness), ("normal deviation", &mut globals.normal_deviation)] {
        ui.horizontal(|ui| {
            let mut own = value.is_none();
            let mut number = value.unwrap_or(0.0);
            let slider = ui.add_enabled(!own, Slider::new(&mut number, 0.0..=1.0).text(name));
            ui.checkbox(&mut own, "own").on_hover_text("each material keeps its own");
            if slider.changed() || own != value.is_none() {
                *value = (!own).then_some(number);
            }
        });
    }
    ui.add(Slider::new(&mut globals.reflectivity, 0.0..=1.0).text("reflectivity, a factor"));
}
