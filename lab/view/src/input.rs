//! The actions of keys. A key is named by its position on a US keyboard.

use super::fly_camera::FlyMotion;
use glam::Vec3;
use std::collections::HashSet;
use winit::keyboard::KeyCode;

/// An action that a key performs once each time it is pressed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Closes the window.
    Quit,
    /// Switches to the next method.
    NextMethod,
    /// Switches between one method, both side by side, and their difference.
    NextCompare,
    /// Adds tenths to the roughness of all materials.
    Roughness(f32),
    /// Jumps to a view, counted from 0.
    View(usize),
    /// Shows or hides the panel.
    Panel,
    /// Opens the next part of the panel.
    NextTab,
    /// Records a key frame.
    RecordKey,
    /// Starts or stops playing the key frames.
    Play,
    /// Adds a capture at the eye.
    AddCapture,
    /// Moves the selected capture to the eye.
    MoveCapture,
    /// Removes the selected capture.
    RemoveCapture,
}

/// Returns the action of a key when it is pressed, with or without a shift key; `None` if it has none.
pub fn action_of_key(code: KeyCode, shift: bool) -> Option<Action> {
    use KeyCode as K;
    const DIGITS: [KeyCode; 9] =
        [K::Digit1, K::Digit2, K::Digit3, K::Digit4, K::Digit5, K::Digit6, K::Digit7, K::Digit8, K::Digit9];
    match code {
        K::Escape => Some(Action::Quit),
        K::KeyM => Some(Action::NextMethod),
        K::KeyC => Some(Action::NextCompare),
        K::KeyR => Some(Action::Roughness(if shift { -1.0 } else { 1.0 })),
        K::F1 => Some(Action::Panel),
        K::F2 => Some(Action::NextTab),
        K::KeyK => Some(Action::RecordKey),
        K::KeyP => Some(Action::Play),
        K::KeyN => Some(Action::AddCapture),
        K::KeyB => Some(Action::MoveCapture),
        K::Delete => Some(Action::RemoveCapture),
        _ => DIGITS.iter().position(|d| *d == code).map(Action::View),
    }
}

/// Returns whether one of the pressed keys is a shift key.
pub fn is_shift_pressed(keys: &HashSet<KeyCode>) -> bool {
    keys.contains(&KeyCode::ShiftLeft) || keys.contains(&KeyCode::ShiftRight)
}

/// Returns the motion of the camera that the pressed keys ask for. Opposite keys cancel each other.
pub fn motion_of_keys(keys: &HashSet<KeyCode>) -> FlyMotion {
    let axis = |plus, minus| f32::from(keys.contains(&plus)) - f32::from(keys.contains(&minus));
    let direction = Vec3::new(
        axis(KeyCode::KeyD, KeyCode::KeyA),
        axis(KeyCode::KeyE, KeyCode::KeyQ),
        axis(KeyCode::KeyW, KeyCode::KeyS),
    );
    FlyMotion { direction, fast: is_shift_pressed(keys) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_do_what_the_help_says() {
        assert_eq!(action_of_key(KeyCode::KeyR, false), Some(Action::Roughness(1.0)));
        assert_eq!(action_of_key(KeyCode::KeyR, true), Some(Action::Roughness(-1.0)));
        assert_eq!(action_of_key(KeyCode::Digit1, false), Some(Action::View(0)));
        assert_eq!(action_of_key(KeyCode::Digit9, false), Some(Action::View(8)));
        assert_eq!(action_of_key(KeyCode::F1, false), Some(Action::Panel));
        assert_eq!(action_of_key(KeyCode::KeyN, false), Some(Action::AddCapture));
        assert_eq!(action_of_key(KeyCode::KeyW, false), None);
    }

    #[test]
    fn opposite_keys_cancel_and_shift_is_fast() {
        let motion_of = |keys: &[KeyCode]| motion_of_keys(&keys.iter().copied().collect());
        assert!(!motion_of(&[KeyCode::KeyW, KeyCode::KeyS]).is_moving());
        let motion = motion_of(&[KeyCode::KeyA, KeyCode::KeyE, KeyCode::ShiftLeft]);
        assert_eq!((motion.direction, motion.fast), (Vec3::new(-1.0, 1.0, 0.0), true));
    }
}
