//! A method and every parameter that it reads. The rows are the flags of the command line, so that a new
//! flag is a new row.

use super::shared::{PanelData, dot, heading};
use crate::app::view::state::{SWITCHED_ON, Side, State};
use crate::methods::thesis::{self, Variant};
use crate::methods::{METHODS, MethodInfo, Preset, Tuning};
use crate::scene::Camera;
use clap::ArgAction;
use egui::{Color32, ComboBox, DragValue, Grid, RichText, Ui};

/// What marks a value that is the published one.
pub const PUBLISHED: Color32 = Color32::from_rgb(110, 190, 120);

/// Whether a method reads a flag. Of a flag or a method that is not listed here it is assumed.
pub fn reads(method: &MethodInfo, flag: &str) -> bool {
    match flag {
        "resolution-scale" | "fallback" => method.is_screen_space(),
        "split" => method.is_screen_space(),
        "preset" => ["ssct", "hzct", "sslr", "linear", "poster"].contains(&method.name),
        "iterations" | "start-level" | "cone-samples" => ["ssct", "hzct"].contains(&method.name),
        "chain-filter" => ["ssct", "hzct", "ssr-fast"].contains(&method.name),
        "march-stride" => ["ssct", "linear", "poster"].contains(&method.name),
        "oracle" => method.name == "unified",
        "march" => method.name == "linear",
        "poster-filter" => method.name == "poster",
        "pixel-step" => ["ssr", "ssr-fast"].contains(&method.name),
        "distance-blur" => method.name == "ssr-fast",
        "billboard-order" | "billboard-occlusion" => method.name == "billboard",
        "planar-variant" | "planar-planes" => method.name == "planar",
        // SSLR keeps no hit whose distance from the border could be known.
        "fade" => method.is_screen_space() && method.name != "sslr",
        _ => true,
    }
}

/// A side: its method, and the rows of it.
pub fn side(ui: &mut Ui, state: &mut State, index: usize, told: &PanelData) {
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
                if let Some(flag) = argument.get_long().filter(|flag| reads(side.method, flag)) {
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
fn option(ui: &mut Ui, side: &mut Side, argument: &clap::Arg, flag: &str, told: &PanelData) {
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
        number(ui, side, flag, default.as_deref(), &mut now, told);
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

/// A number: the flag's own default or the preset's, or what replaces it.
fn number(ui: &mut Ui, side: &Side, flag: &str, default: Option<&str>, now: &mut Option<String>, told: &PanelData) {
    let base = default.and_then(|d| d.parse().ok()).or_else(|| published(side.setup.preset, flag, told));
    ui.horizontal(|ui| {
        let Some(base) = base else {
            let mut text = now.clone().unwrap_or_default();
            let edit = egui::TextEdit::singleline(&mut text).desired_width(60.0).hint_text("default");
            if ui.add(edit).changed() {
                *now = (!text.is_empty()).then_some(text);
            }
            return;
        };
        let is_whole = base.fract() == 0.0;
        let mut value = now.as_ref().and_then(|v| v.parse().ok()).unwrap_or(base);
        let speed = if is_whole { 0.2 } else { base.abs().max(1e-4) * 0.02 };
        let drag = DragValue::new(&mut value).range(0.0..=f64::INFINITY).speed(speed);
        if ui.add(drag.max_decimals(if is_whole { 0 } else { 5 })).changed() {
            *now = Some(format!("{value}"));
        }
        if now.is_some() && ui.small_button("back").on_hover_text("to the default").clicked() {
            *now = None;
        }
        if let Some(n) = published(Preset::Published, flag, told) {
            ui.label(RichText::new(format!("published {n}")).weak().small());
        }
    });
}

/// The number that a preset has for a flag.
fn published(preset: Preset, flag: &str, told: &PanelData) -> Option<f64> {
    let variant = Variant { preset, tuning: Tuning::default(), fallback: true, fade: true };
    let camera: &Camera = &told.camera;
    let block = thesis::parameters(&variant, camera, told.extent, crate::gpu::image::full_chain(told.extent));
    Some(match flag {
        "iterations" => f64::from(block.iterations),
        "start-level" => f64::from(block.start_level),
        "cone-samples" => f64::from(block.cone_samples),
        // The decimal that is printed, not its nearest binary fraction.
        "march-stride" => block.linear_march_stride.to_string().parse().ok()?,
        // Schmidt's listing 4.
        "pixel-step" => 1.0,
        _ => return None,
    })
}
