//! Shows a method, and every parameter that it reads as a row with a control. The rows are made from the parameters'
//! tables.

use super::shared::{dot, heading};
use crate::state::{Side, State};
use egui::{Color32, ComboBox, DragValue, Grid, RichText, Ui};
use ssct::methods::{self, MethodInfo};
use ssct_ground::parameter::{Choices, Domain, Parameter, Preset, Value};

/// The colour that marks a published value.
pub const PUBLISHED: Color32 = Color32::from_rgb(110, 190, 120);

/// Returns the text about a method: its summary, its source, and what it needs of a scene, separated by `between`.
fn describe_method(info: &MethodInfo, between: &str) -> String {
    let needs: Vec<&str> = info.needs.iter().map(|need| need.words()).collect();
    let needs = if needs.is_empty() { String::new() } else { format!("{between}needs {}", needs.join(", ")) };
    format!("{}{between}{}{needs}", info.summary, info.source)
}

/// Draws the rows of side `index` (0 or 1): its method, and a row for each option of the method.
pub fn draw_side(ui: &mut Ui, state: &mut State, index: usize) {
    let title = if state.rendered().len() == 1 { "Method" } else { ["Left method", "Right method"][index] };
    heading(ui, title);
    ui.push_id(("side", index), |ui| {
        let mut chosen = None;
        let method = state.sides[index].method;
        ComboBox::from_id_salt("method").width(140.0).selected_text(method.name).show_ui(ui, |ui| {
            for info in methods::all() {
                let about = describe_method(info, "\n");
                if ui.selectable_label(info.name == method.name, info.name).on_hover_text(about).clicked() {
                    chosen = Some(info);
                }
            }
        });
        if let Some(info) = chosen {
            state.choose(index, info);
        }
        ui.label(RichText::new(describe_method(method, "; ")).weak().small());
        let side = &mut state.sides[index];
        let rows = side.method.read_parameters();
        Grid::new("options").num_columns(3).show(ui, |ui| {
            if rows.iter().any(|row| row.author != row.published) {
                draw_preset(ui, side);
                ui.end_row();
            }
            for row in &rows {
                draw_option(ui, side, row);
                ui.end_row();
            }
        });
        if let Some(fault) = &side.fault {
            ui.colored_label(ui.visuals().error_fg_color, fault);
        }
    });
}

/// Draws the row of the preset: a list of the presets, and a dot if the published one is chosen.
fn draw_preset(ui: &mut Ui, side: &mut Side) {
    ui.label("preset").on_hover_text("Whose constants a published method uses.");
    let (before, mut chosen) = (side.setup.values.preset, side.setup.values.preset);
    ComboBox::from_id_salt("preset").selected_text(chosen.name()).show_ui(ui, |ui| {
        for (preset, choice) in Preset::ALL.iter().zip(Preset::CHOICES) {
            ui.selectable_value(&mut chosen, *preset, choice.name).on_hover_text(choice.help);
        }
    });
    if chosen == Preset::default() {
        dot(ui, PUBLISHED);
    }
    if chosen != before {
        side.set("preset", (chosen != Preset::default()).then(|| chosen.name().to_owned()));
    }
}

/// Draws the row of a parameter: its name, its control, and a dot if it has the published value or else a button back
/// to that value.
fn draw_option(ui: &mut Ui, side: &mut Side, row: &Parameter) {
    let name = row.typed_name();
    ui.label(name.replace('-', " ")).on_hover_text(describe_parameter(row));
    let before = side.setup.values.value(row);
    // The value that the parameter has if the option is not set.
    let default = row.preset_value(side.setup.values.preset);
    let mut value = before;
    match (&row.domain, &mut value) {
        (Domain::Switch, Value::Switch(on)) => drop(ui.checkbox(on, "")),
        (Domain::Choices(_) | Domain::ChoicesOrCount(..) | Domain::Numbers(_), value) => draw_choices(ui, row, value),
        (Domain::Count(least, most), Value::Count(n)) => {
            ui.add(DragValue::new(n).range(*least..=*most).speed(0.2));
        }
        (Domain::Number { least, most, .. }, Value::Number(n)) => {
            let speed = f64::from(n.abs().max(1e-4)) * 0.02;
            ui.add(DragValue::new(n).range(*least..=*most).speed(speed).max_decimals(6));
        }
        _ => {}
    }
    if value == row.published {
        dot(ui, PUBLISHED);
    } else if ui.small_button("back").on_hover_text(format!("to the published value, {}", row.published)).clicked() {
        value = row.published;
    }
    if value != before && row.domain.has(value) {
        side.set(&name, (value != default).then(|| value.to_string()));
    }
}

/// Draws a list from which one of a parameter's few values is chosen.
fn draw_choices(ui: &mut Ui, row: &Parameter, chosen: &mut Value) {
    let help = |value: &Value| match &row.domain {
        Domain::Choices(choices) | Domain::ChoicesOrCount(choices, ..) => {
            choices.iter().find(|choice| Value::Choice(choice.name) == *value).map_or("", |choice| choice.help)
        }
        _ => "",
    };
    ComboBox::from_id_salt(row.name).selected_text(chosen.to_string()).show_ui(ui, |ui| {
        for value in row.domain.all_if_few().unwrap_or_default() {
            ui.selectable_value(chosen, value, value.to_string()).on_hover_text(help(&value).trim());
        }
    });
}

/// Returns the text about a parameter: its help, its unit, the values of both presets, and their source.
fn describe_parameter(row: &Parameter) -> String {
    let unit = if row.unit.is_empty() { String::new() } else { format!(" In {}.", row.unit) };
    let author = if row.author == row.published { String::new() } else { format!("; author: {}", row.author) };
    format!("{}{unit}\nPublished: {}{author}\nSource: {}", row.help, row.published, row.source)
}
