//! A camera that flies through the scene: the mouse turns it and keys move it. The module does arithmetic only and
//! needs no window.
//!
//! Like a view, the camera is stored as an eye and a point that it looks at. As long as the camera has not left a view,
//! the picture is therefore exactly that of `ssct render`.

use glam::{Vec2, Vec3};
use ssct_scenes::{Camera, Lens, View};
use std::f32::consts::FRAC_PI_2;

/// The angle by which a mouse motion of one pixel turns the camera.
const RADIANS_PER_PIXEL: f32 = 0.003;
/// The greatest angle above or below the horizon. Straight up and down are excluded, because a heading has no meaning
/// there.
const MAX_PITCH_RADIANS: f32 = FRAC_PI_2 - 0.02;
/// The factor by which the "fast" key raises the speed.
const FAST: f32 = 5.0;
/// The factor by which one notch of the wheel raises the speed.
const SPEED_STEP: f32 = 1.25;

/// The position, direction and speed of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlyCamera {
    eye: Vec3,
    look_at: Vec3,
    speed_m_per_s: f32,
}

/// The direction in which the pressed keys move the camera.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FlyMotion {
    /// x is to the right, y upwards in the world, and z forwards; each component is −1, 0 or 1.
    pub direction: Vec3,
    /// Whether the "fast" key is pressed.
    pub fast: bool,
}

impl FlyMotion {
    /// Returns whether any key moves the camera.
    pub fn is_moving(&self) -> bool {
        self.direction != Vec3::ZERO
    }
}

impl FlyCamera {
    /// Makes a camera at a view.
    pub fn new(view: &View, speed_m_per_s: f32) -> Self {
        Self { eye: view.eye, look_at: view.look_at, speed_m_per_s }
    }

    /// Returns the eye and the point that it looks at.
    pub fn place(&self) -> (Vec3, Vec3) {
        (self.eye, self.look_at)
    }

    /// Moves the camera to an eye and a point that it looks at, and keeps its speed.
    pub fn put(&mut self, (eye, look_at): (Vec3, Vec3)) {
        *self = Self { eye, look_at, ..*self };
    }

    /// Returns the speed in metres per second without the "fast" key.
    pub fn speed_m_per_s(&self) -> f32 {
        self.speed_m_per_s
    }

    /// Moves the camera to a view, and keeps its speed.
    pub fn jump(&mut self, view: &View) {
        *self = Self::new(view, self.speed_m_per_s);
    }

    /// Returns this camera with a lens, for rendering; `aspect` is width over height.
    pub fn camera(&self, lens: Lens, aspect: f32) -> Camera {
        Camera::new(self.eye, self.look_at, lens, aspect)
    }

    /// Turns the camera by a mouse motion in pixels; +x is to the right and +y downwards.
    pub fn turn(&mut self, pixels: Vec2) {
        let (forward, distance) = (self.forward(), self.eye.distance(self.look_at));
        let yaw = forward.x.atan2(forward.z) + pixels.x * RADIANS_PER_PIXEL;
        let pitch = (forward.y.clamp(-1.0, 1.0).asin() - pixels.y * RADIANS_PER_PIXEL)
            .clamp(-MAX_PITCH_RADIANS, MAX_PITCH_RADIANS);
        let turned = Vec3::new(yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos());
        self.look_at = self.eye + turned * distance.max(1.0);
    }

    /// Moves the camera for a time; returns whether it moved.
    pub fn fly(&mut self, motion: FlyMotion, seconds: f32) -> bool {
        let forward = self.forward();
        let right = Vec3::Y.cross(forward).normalize_or(Vec3::X);
        let direction = right * motion.direction.x + Vec3::Y * motion.direction.y + forward * motion.direction.z;
        let speed = self.speed_m_per_s * if motion.fast { FAST } else { 1.0 };
        let step = direction.normalize_or_zero() * speed * seconds;
        self.eye += step;
        self.look_at += step;
        step != Vec3::ZERO
    }

    /// Makes the camera faster (positive) or slower by notches of the wheel.
    pub fn change_speed(&mut self, notches: f32) {
        self.speed_m_per_s = (self.speed_m_per_s * SPEED_STEP.powf(notches)).clamp(1e-3, 1e5);
    }

    /// Returns the unit direction in which the camera looks.
    fn forward(&self) -> Vec3 {
        (self.look_at - self.eye).normalize_or(Vec3::Z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a camera with a speed of 2 m/s.
    fn camera_at(eye: Vec3, look_at: Vec3) -> FlyCamera {
        FlyCamera::new(&View { eye, look_at, ..View::default() }, 2.0)
    }

    /// Returns a motion to the right (x), upwards (y) and forwards (z), without the "fast" key.
    fn towards(x: f32, y: f32, z: f32) -> FlyMotion {
        FlyMotion { direction: Vec3::new(x, y, z), fast: false }
    }

    #[test]
    fn a_camera_that_has_not_moved_equals_the_views_camera() {
        let (eye, look_at, lens) = (Vec3::new(0.1, 1.7, -3.3), Vec3::new(5.1, 0.3, 7.9), Lens::default());
        let mut camera = camera_at(Vec3::ZERO, Vec3::Z);
        camera.jump(&View { eye, look_at, ..View::default() });
        assert_eq!(camera.camera(lens, 1.5), Camera::new(eye, look_at, lens, 1.5));
    }

    #[test]
    fn keys_move_along_the_axes_of_the_view() {
        let mut camera = camera_at(Vec3::ZERO, Vec3::Z);
        assert!(camera.fly(towards(1.0, 0.0, 0.0), 0.5));
        assert!(camera.eye.distance(Vec3::X) < 1e-6, "right is +x when +z is ahead: {}", camera.eye);
        camera.fly(towards(0.0, 1.0, 1.0), 1.0);
        assert!(camera.eye.distance(Vec3::new(1.0, 2_f32.sqrt(), 2_f32.sqrt())) < 1e-5, "{}", camera.eye);
        camera.fly(FlyMotion { direction: Vec3::NEG_Z, fast: true }, 1.0);
        assert!((camera.eye.z - (2_f32.sqrt() - 10.0)).abs() < 1e-5);
        assert!(camera.forward().distance(Vec3::Z) < 1e-6, "flying does not turn");
        assert!(!camera.fly(FlyMotion::default(), 1.0));
    }

    #[test]
    fn what_the_camera_calls_right_is_right_in_the_image() {
        let mut camera = camera_at(Vec3::new(3.0, 1.0, 2.0), Vec3::new(-1.0, 2.0, 5.0));
        let before = camera.camera(Lens::default(), 1.0).world_to_view;
        let eye = camera.eye;
        camera.fly(towards(1.0, 0.0, 0.0), 1.0);
        let step = before.transform_vector3(camera.eye - eye);
        assert!(step.distance(Vec3::new(2.0, 0.0, 0.0)) < 1e-5, "{step}");
    }

    #[test]
    fn the_mouse_to_the_right_turns_right_and_down_looks_down() {
        let mut camera = camera_at(Vec3::ONE, Vec3::ONE + Vec3::Z);
        camera.turn(Vec2::new(FRAC_PI_2 / RADIANS_PER_PIXEL, 0.0));
        assert!(camera.forward().distance(Vec3::X) < 1e-5, "{}", camera.forward());
        camera.turn(Vec2::new(0.0, 100.0));
        assert!(camera.forward().y < 0.0);
        assert_eq!(camera.eye, Vec3::ONE, "turning does not move");
    }

    #[test]
    fn looking_up_stops_short_of_the_pole_and_comes_back() {
        let mut camera = camera_at(Vec3::ZERO, Vec3::new(3.0, 0.0, 4.0));
        camera.turn(Vec2::new(0.0, -1e6));
        assert!(camera.forward().y > 0.999 && camera.forward().is_finite());
        camera.turn(Vec2::new(0.0, MAX_PITCH_RADIANS / RADIANS_PER_PIXEL));
        assert!(camera.forward().distance(Vec3::new(0.6, 0.0, 0.8)) < 1e-3, "{}", camera.forward());
    }

    #[test]
    fn a_view_straight_down_can_be_turned_from() {
        let mut camera = camera_at(Vec3::new(0.0, 9.0, 0.0), Vec3::ZERO);
        camera.turn(Vec2::new(10.0, -10.0));
        assert!(camera.forward().is_finite() && camera.forward().y < -0.99);
        camera.fly(towards(1.0, 0.0, 0.0), 1.0);
        assert!(camera.eye.is_finite());
    }

    #[test]
    fn notches_undo_each_other_and_speed_stays_finite() {
        let mut camera = camera_at(Vec3::ZERO, Vec3::Z);
        camera.change_speed(3.0);
        assert!(camera.speed_m_per_s > 2.0);
        camera.change_speed(-3.0);
        assert!((camera.speed_m_per_s - 2.0).abs() < 1e-5);
        camera.change_speed(1e6);
        assert!(camera.speed_m_per_s.is_finite());
        camera.change_speed(-1e6);
        assert!(camera.speed_m_per_s > 0.0);
    }
}
