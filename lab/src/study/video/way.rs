//! Ways of the camera through a film.

use glam::{Quat, Vec3};
use ssct_scenes::{CameraPath, View};

/// How the camera moves through a film.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraWay {
    /// Along a path, from its beginning to its end.
    Path(CameraPath),
    /// From a view towards the point that it looks at, at a person's walking pace, or slower, so that the camera comes at most
    /// half of the way.
    Walk(View),
    /// At rest in a view for a third of the film, then a quick turn to the right, and at rest again.
    Turn(View),
    /// Sideways from a view for a third of the film, then at rest.
    Stop(View),
    /// At rest in a view for the whole film.
    Rest(View),
}

/// Speed of a walk, in metres a second.
const WALK: f32 = 1.4;
/// Speed of the motion to the side, in metres a second.
const ASIDE: f32 = 1.0;
/// Angle of the turn in degrees, and its duration in seconds.
const TURN: (f32, f32) = (45.0, 0.2);

impl CameraWay {
    /// Name of the way in records.
    pub fn name(&self) -> &str {
        match self {
            Self::Path(path) => &path.name,
            Self::Walk(_) => "walk",
            Self::Turn(_) => "turn",
            Self::Stop(_) => "stop",
            Self::Rest(_) => "rest",
        }
    }

    /// The view at the beginning of the way; a path's view has the path's name.
    pub fn start(&self) -> View {
        match self {
            Self::Path(path) => {
                let (eye, look_at) = path.eye_and_look_at(0.0);
                View { name: path.name.clone(), eye, look_at, ..View::default() }
            }
            Self::Walk(view) | Self::Turn(view) | Self::Stop(view) | Self::Rest(view) => view.clone(),
        }
    }

    /// The view of a frame in a film of `frames` frames, shown at `frames_per_second`.
    pub fn view(&self, frame: u32, frames: u32, frames_per_second: f32) -> View {
        let last = frames.saturating_sub(1).max(1) as f32;
        let of_second = |n: u32| n as f32 / frames_per_second;
        match self {
            Self::Path(path) => {
                let (eye, look_at) = path.eye_and_look_at(frame as f32 / last);
                View { eye, look_at, ..self.start() }
            }
            Self::Walk(view) => {
                let ahead = view.look_at - view.eye;
                let way = (WALK * last / frames_per_second).min(0.5 * ahead.length());
                let step = ahead.normalize_or_zero() * (way * frame as f32 / last);
                View { eye: view.eye + step, look_at: view.look_at + step, ..view.clone() }
            }
            Self::Turn(view) => {
                let (degrees, seconds) = TURN;
                let part = of_second(frame.saturating_sub(frames / 3)) / seconds;
                let turned = Quat::from_rotation_y(degrees.to_radians() * part.min(1.0));
                View { look_at: view.eye + turned * (view.look_at - view.eye), ..view.clone() }
            }
            Self::Stop(view) => {
                let aside = Vec3::Y.cross(view.look_at - view.eye).normalize_or_zero();
                let step = aside * (ASIDE * of_second(frame.min(frames / 3)));
                View { eye: view.eye + step, look_at: view.look_at + step, ..view.clone() }
            }
            Self::Rest(view) => view.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View { eye: Vec3::new(1.0, 1.5, 0.0), look_at: Vec3::new(1.0, 1.5, 2.0), ..View::default() }
    }

    #[test]
    fn who_walks_goes_ahead_and_no_farther_than_half_of_the_way() {
        let far = View { look_at: Vec3::new(1.0, 1.5, 100.0), ..view() };
        let last = |way: CameraWay| way.view(59, 60, 30.0);
        let walked = last(CameraWay::Walk(far.clone())).eye - far.eye;
        assert!((walked - Vec3::Z * WALK * 59.0 / 30.0).length() < 1e-4, "{walked}");
        let near = last(CameraWay::Walk(view()));
        assert!((near.eye - Vec3::new(1.0, 1.5, 1.0)).length() < 1e-5 && near.look_at.z == 3.0, "{near:?}");
        assert_eq!(CameraWay::Walk(view()).view(0, 60, 30.0), view());
    }

    #[test]
    fn who_stops_goes_aside_for_a_third_of_the_film_and_rests() {
        let way = CameraWay::Stop(view());
        let gone = |frame| way.view(frame, 60, 30.0).eye - view().eye;
        assert_eq!(gone(0), Vec3::ZERO);
        assert!((gone(10) - Vec3::X / 3.0).length() < 1e-5, "{}", gone(10));
        assert!((gone(20) - Vec3::X * 2.0 / 3.0).length() < 1e-5 && gone(59) == gone(20), "{}", gone(59));
    }

    #[test]
    fn who_turns_rests_turns_to_the_right_and_rests() {
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
