//! Places the things that move before the camera of a film.

use super::VideoStudy;
use crate::scene::Placement;

impl VideoStudy {
    /// Where meshes are placed in a frame.
    pub(super) fn placed(&self, frame: u32) -> Vec<(&str, Placement)> {
        let time_s = frame as f32 / self.frames_per_second;
        let played = self.play.iter().flat_map(|motion| motion.at(time_s));
        let steps = self.step_frames.map_or(frame, |last| frame.min(last));
        let moved = self.moving.iter().map(|name| (name.as_str(), (steps as f32 * self.step_m).into()));
        played.chain(moved).collect()
    }
}
