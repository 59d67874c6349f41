//! The camera of each frame of a film, and the places of the meshes that move.

use super::VideoStudy;
use ssct_scenes::{Camera, Placement};

/// Number of frames after which the jitter, which shifts the image by parts of a pixel, repeats.
const JITTER_PERIOD: u32 = 8;

impl VideoStudy {
    /// Returns the camera of a frame, for a size in pixels; with the jitter, if the film has one.
    pub(super) fn camera(&self, frame: u32, extent: [u32; 2]) -> Camera {
        let camera = self.camera_without_jitter(frame, extent);
        if self.jitter { camera.jittered(jitter_px(frame), extent) } else { camera }
    }

    /// Returns the camera of a frame without the jitter.
    fn camera_without_jitter(&self, frame: u32, extent: [u32; 2]) -> Camera {
        self.way.view(frame, self.frames, self.frames_per_second).camera(&self.scene, extent)
    }

    /// Returns the names of the meshes that move, each with its placement in a frame: by the motion that is played, by
    /// steps, or with the camera.
    pub(super) fn placements(&self, frame: u32) -> Vec<(&str, Placement)> {
        let time_s = frame as f32 / self.frames_per_second;
        let played = self.play.iter().flat_map(|motion| motion.placements_at(time_s));
        let steps = self.step_frames.map_or(frame, |last| frame.min(last));
        let stepped = self.moving.iter().map(|name| (name.as_str(), (steps as f32 * self.step_m).into()));
        // The size of the image does not matter here.
        let [first, now] = [0, frame].map(|n| self.camera_without_jitter(n, [1, 1]));
        let with_camera = carried_placement(&first, &now);
        let carried = self.held.iter().map(|name| (name.as_str(), with_camera));
        played.chain(stepped).chain(carried).collect()
    }
}

/// Returns the placement of a mesh that the camera carries, where the camera was `first` in the first frame and is
/// `now`.
fn carried_placement(first: &Camera, now: &Camera) -> Placement {
    let first_to_now = now.world_to_view.as_dmat4().inverse() * first.world_to_view.as_dmat4();
    let (_, turn, offset) = first_to_now.to_scale_rotation_translation();
    Placement { turn: turn.as_quat().normalize(), size: 1.0, offset: offset.as_vec3() }
}

/// Returns the jitter of a frame: the shift of its image in pixels, x to the right and y down, each within half a
/// pixel.
fn jitter_px(frame: u32) -> [f32; 2] {
    // Begins with element 1 of the sequence of Halton, since element 0 is the point (0, 0).
    [2, 3].map(|base| radical_inverse(frame % JITTER_PERIOD + 1, base) - 0.5)
}

/// Mirrors the digits of a number, written to a base, at the point: 6 is 110 to the base 2, and becomes 0.011. The
/// results for 0, 1, 2 and so on are one coordinate of the sequence of Halton (1960).
fn radical_inverse(mut number: u32, base: u32) -> f32 {
    let (mut sum, mut place_value) = (0.0, 1.0);
    while number > 0 {
        place_value /= base as f32;
        sum += place_value * (number % base) as f32;
        number /= base;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use ssct_scenes::Lens;

    #[test]
    fn a_mesh_that_the_camera_carries_keeps_its_place_in_the_image() {
        let cameras = [(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO), (Vec3::new(-2.0, 1.0, 0.5), Vec3::new(0.0, 4.0, 1.0))];
        let [first, now] = cameras.map(|(eye, target)| Camera::new(eye, target, Lens::default(), 1.5));
        let placed = carried_placement(&first, &now);
        assert!(placed.is_sound());
        for point in [Vec3::new(0.5, 1.0, 1.0), Vec3::new(-3.0, 0.2, 9.0)] {
            let there = placed.matrix().as_mat4().transform_point3(point);
            let [before, after] = [(first, point), (now, there)].map(|(c, p)| c.world_to_view.transform_point3(p));
            assert!(before.distance(after) < 1e-5, "{before} {after}");
        }
    }

    #[test]
    fn shifted_frames_cover_a_pixel() {
        let shifts: Vec<[f32; 2]> = (0..JITTER_PERIOD).map(jitter_px).collect();
        for axis in [0, 1] {
            let mean: f32 = shifts.iter().map(|shift| shift[axis]).sum::<f32>() / JITTER_PERIOD as f32;
            assert!(mean.abs() < 0.1 && shifts.iter().all(|shift| shift[axis].abs() < 0.5), "{shifts:?}");
        }
        let camera = Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), 2.0);
        let point = Vec3::new(0.3, -0.2, 4.0);
        let [plain, shifted] = [camera, camera.jittered([0.25, -0.5], [200, 100])]
            .map(|camera| camera.view_to_clip_reversed().project_point3(point));
        let moved = (shifted - plain) * Vec3::new(100.0, -50.0, 1.0);
        assert!(moved.distance(Vec3::new(0.25, -0.5, 0.0)) < 1e-3, "{moved}");
    }
}
