//! The ways in which a film's camera can move.

use glam::{Quat, Vec3};
use ssct_scenes::{CameraPath, View};

/// How the camera moves through a film.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraWay {
    /// Along a path, from its beginning to its end.
    Path(CameraPath),
    /// From a view towards the point that the view looks at, at a person's walking pace. If that would lead past half
    /// of the distance, the camera moves so slowly that it ends there.
    Walk(View),
    /// At rest in a view for a third of the film, then turning quickly to the right, and at rest again.
    Turn(View),
    /// Sideways from a view for a third of the film, then at rest.
    Stop(View),
    /// At rest in a view for the whole film.
    Rest(View),
}

/// Speed of [`CameraWay::Walk`], in metres a second.
const WALK_M_PER_S: f32 = 1.4;
/// Speed of [`CameraWay::Stop`], in metres a second.
const STOP_M_PER_S: f32 = 1.0;
/// Angle of [`CameraWay::Turn`], in degrees.
const TURN_DEGREES: f32 = 45.0;
/// Duration of [`CameraWay::Turn`], in seconds.
const TURN_S: f32 = 0.2;

impl CameraWay {
    /// Returns the name of the way in records.
    pub fn name(&self) -> &str {
        match self {
            Self::Path(path) => &path.name,
            Self::Walk(_) => "walk",
            Self::Turn(_) => "turn",
            Self::Stop(_) => "stop",
            Self::Rest(_) => "rest",
        }
    }

    /// Returns the view at the beginning of the way; that of a path has the path's name.
    pub fn start(&self) -> View {
        match self {
            Self::Path(path) => {
                let (eye, look_at) = path.eye_and_look_at(0.0);
                View { name: path.name.clone(), eye, look_at, ..View::default() }
            }
            Self::Walk(view) | Self::Turn(view) | Self::Stop(view) | Self::Rest(view) => view.clone(),
        }
    }

    /// Returns the view of a frame, counted from 0, in a film of `frames` frames that is shown at `frames_per_second`.
    pub fn view(&self, frame: u32, frames: u32, frames_per_second: f32) -> View {
        let last_frame = frames.saturating_sub(1).max(1) as f32;
        let seconds_of = |frames: u32| frames as f32 / frames_per_second;
        match self {
            Self::Path(path) => {
                let (eye, look_at) = path.eye_and_look_at(frame as f32 / last_frame);
                View { eye, look_at, ..self.start() }
            }
            Self::Walk(view) => {
                let ahead = view.look_at - view.eye;
                let walk_m = (WALK_M_PER_S * last_frame / frames_per_second).min(0.5 * ahead.length());
                let step = ahead.normalize_or_zero() * (walk_m * frame as f32 / last_frame);
                View { eye: view.eye + step, look_at: view.look_at + step, ..view.clone() }
            }
            Self::Turn(view) => {
                let share = seconds_of(frame.saturating_sub(frames / 3)) / TURN_S;
                let turn = Quat::from_rotation_y(TURN_DEGREES.to_radians() * share.min(1.0));
                View { look_at: view.eye + turn * (view.look_at - view.eye), ..view.clone() }
            }
            Self::Stop(view) => {
                let right = Vec3::Y.cross(view.look_at - view.eye).normalize_or_zero();
                let step = right * (STOP_M_PER_S * seconds_of(frame.min(frames / 3)));
                View { eye: view.eye + step, look_at: view.look_at + step, ..view.clone() }
            }
            Self::Rest(view) => view.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a view that looks along z at a point 2 m ahead.
    fn view() -> View {
        View { eye: Vec3::new(1.0, 1.5, 0.0), look_at: Vec3::new(1.0, 1.5, 2.0), ..View::default() }
    }

    #[test]
    fn a_walk_leads_ahead_and_ends_at_half_of_the_distance_at_most() {
        let far = View { look_at: Vec3::new(1.0, 1.5, 100.0), ..view() };
        let last = |way: CameraWay| way.view(59, 60, 30.0);
        let walked = last(CameraWay::Walk(far.clone())).eye - far.eye;
        assert!((walked - Vec3::Z * WALK_M_PER_S * 59.0 / 30.0).length() < 1e-4, "{walked}");
        let near = last(CameraWay::Walk(view()));
        assert!((near.eye - Vec3::new(1.0, 1.5, 1.0)).length() < 1e-5 && near.look_at.z == 3.0, "{near:?}");
        assert_eq!(CameraWay::Walk(view()).view(0, 60, 30.0), view());
    }

    #[test]
    fn a_stop_moves_aside_for_a_third_of_the_film_and_rests() {
        let way = CameraWay::Stop(view());
        let moved = |frame| way.view(frame, 60, 30.0).eye - view().eye;
        assert_eq!(moved(0), Vec3::ZERO);
        assert!((moved(10) - Vec3::X / 3.0).length() < 1e-5, "{}", moved(10));
        assert!((moved(20) - Vec3::X * 2.0 / 3.0).length() < 1e-5 && moved(59) == moved(20), "{}", moved(59));
    }

    #[test]
    fn a_turn_rests_turns_to_the_right_and_rests() {
        let way = CameraWay::Turn(view());
        let ahead = |frame| (way.view(frame, 60, 30.0).look_at - view().eye).normalize();
        assert_eq!(ahead(20), ahead(0));
        // Three frames at 30 a second make half of the turn.
        let half = ahead(23);
        assert!((half.angle_between(Vec3::Z).to_degrees() - 22.5).abs() < 0.01 && half.x > 0.0, "{half}");
        assert!((ahead(26).angle_between(Vec3::Z).to_degrees() - 45.0).abs() < 0.01);
        assert_eq!(ahead(26), ahead(59));
    }
}
