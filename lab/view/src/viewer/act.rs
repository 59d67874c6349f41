//! Performs the actions of keys and of the panel's buttons.

use super::Viewer;
use crate::input::Action;
use crate::state::{State, Tab};
use ssct::methods::setup::CaptureCount;
use ssct_ground::parameter::Field;

impl Viewer {
    /// Performs an action, except for quitting, which is left to the window.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Quit => {}
            Action::NextMethod => self.state.next_method(),
            Action::NextCompare => self.state.next_compare(),
            Action::Roughness(tenths) => self.state.change_roughness(tenths),
            Action::View(index) => {
                if let Some(view) = self.views().get(index).cloned() {
                    self.state.show_view(&view);
                }
            }
            Action::Panel => toggle_panel(&mut self.state),
            Action::NextTab => self.state.tab = self.state.tab.next(),
            Action::RecordKey => self.path.record(&self.state.camera),
            Action::Play => self.path.play_or_stop(),
            Action::AddCapture | Action::MoveCapture | Action::RemoveCapture => self.edit_captures(action),
        }
    }

    /// Adds, moves or removes a capture. Turns captures on for the first method, if the method or its fallback can
    /// follow rays in them; otherwise a message says that it cannot.
    fn edit_captures(&mut self, action: Action) {
        let shown = self.captures_shown();
        let eye = self.state.camera.place().0;
        match action {
            Action::AddCapture => self.captures.add(&shown, eye),
            Action::MoveCapture => self.captures.put(&shown, eye),
            _ => self.captures.remove(&shown),
        }
        let side = &mut self.state.sides[0];
        let effect = side.setup.effect();
        let fallback_takes_captures = effect.fallback.method().is_some_and(|m| m.takes_captures);
        if !side.method.takes_captures && !fallback_takes_captures {
            self.captures.message += &format!("; {} follows no rays in captures", side.method.name);
        } else if effect.captures != CaptureCount::Auto {
            // The value `auto` takes all captures of the list, however many there are.
            side.set("captures", Some(CaptureCount::Auto.value().to_string()));
        }
    }
}

/// Hides the panel, or shows its first part if it is hidden.
fn toggle_panel(state: &mut State) {
    state.tab = if state.tab == Tab::None { Tab::Tune } else { Tab::None };
}
