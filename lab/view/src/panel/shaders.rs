//! Shows the shaders that were reloaded because they changed, with the compiler's messages.

use super::shared::{PanelData, heading};
use egui::{Color32, RichText, Ui};

/// Draws this part of the panel: the watched folder, and the status of each shader that has changed.
pub fn show(ui: &mut Ui, data: &PanelData) {
    let Some((folder, changes)) = data.shaders else {
        ui.label("No shaders are watched: start in the repository, or name their folder with --shaders.");
        return;
    };
    heading(ui, "Watched folder");
    ui.label(RichText::new(folder).monospace());
    heading(ui, "Changes");
    if changes.is_empty() {
        ui.label(RichText::new("none so far; save a shader, and it is compiled").weak());
    }
    for (name, result) in changes {
        match result {
            Ok(()) => ui.colored_label(Color32::from_rgb(110, 190, 120), format!("{name}: compiled and in use")),
            Err(message) => {
                ui.colored_label(ui.visuals().error_fg_color, format!("{name}: the last good one stays in use"));
                ui.label(RichText::new(message).monospace().small())
            }
        };
    }
}
