//! Camera paths: key frames joined by a centripetal Catmull-Rom spline. The spline passes through every key
//! frame and, unlike the uniform variant, has neither cusps nor loops where two key frames are close together.
//! A path comes from key frames or from the views of a scene.

use super::{MAX_COORDINATE_M, Scene};
use crate::error::{Error, Result};
use glam::Vec3;

/// The name of the path through a scene's views.
pub const VIEWS: &str = "views";

/// The greatest time of a key frame, in seconds; differences up to it stay exact enough in f32.
const MAX_TIME_S: f32 = 1e9;

/// A camera position on the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyFrame {
    /// Camera position in world space, in metres.
    pub eye: Vec3,
    /// The world-space point in the middle of the image.
    pub look_at: Vec3,
    /// When the camera is there, in seconds. Either all key frames of a path have a time, or none has.
    pub time_s: Option<f32>,
}

/// A camera path through at least two key frames.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    /// The name that records use.
    pub name: String,
    keys: Vec<KeyFrame>,
    /// The time of each key frame in seconds or, if key frames have no times, the distance travelled so far in metres.
    times: Vec<f32>,
}

/// A fault of key frames: the index of the faulty key frame, if it is a single one, and a sentence.
pub type KeyFault = (Option<usize>, String);

impl CameraPath {
    /// Joins key frames. If they have no times, the camera moves evenly: the time between two key frames is the
    /// distance that its eye and the point it looks at travel.
    ///
    /// # Errors
    /// [`Error::Usage`] for fewer than two key frames, and for one that is not finite, looks at its own eye or repeats
    /// the one before. [`Error::Usage`] also if only some have a time, or if times do not increase.
    pub fn new(name: impl Into<String>, keys: Vec<KeyFrame>) -> Result<Self> {
        let name = name.into();
        Self::through_keys(&name, keys).map_err(|(index, what)| {
            let place = index.map_or_else(String::new, |i| format!("key frame {}: ", i + 1));
            Error::Usage(format!("path {name}: {place}{what}"))
        })
    }

    /// Makes a path as [`Self::new`] does. An error has the index of the faulty key frame beside the sentence.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn through_keys(name: &str, keys: Vec<KeyFrame>) -> std::result::Result<Self, KeyFault> {
        if keys.len() < 2 {
            return Err((None, format!("a path needs at least two key frames, not {}", keys.len())));
        }
        for (n, key) in keys.iter().enumerate() {
            let fault = |what: &str| Err((Some(n), what.to_owned()));
            if !(key.eye.is_finite() && key.look_at.is_finite() && key.time_s.is_none_or(f32::is_finite)) {
                return fault("every number must be finite");
            }
            if key.eye.abs().max(key.look_at.abs()).max_element() > MAX_COORDINATE_M {
                return fault("it lies more than 1e8 m from the origin");
            }
            if key.time_s.is_some_and(|t| t.abs() > MAX_TIME_S) {
                return fault("its time lies more than 1e9 s from 0");
            }
            if (key.look_at - key.eye).try_normalize().is_none() {
                return fault("it looks at its own eye; look_at must be another point");
            }
            if key.time_s.is_some() != keys[0].time_s.is_some() {
                return fault("either every key frame has a time, or none has");
            }
            let Some(before) = n.checked_sub(1).map(|n| keys[n]) else { continue };
            if distance(&before, key) == 0.0 {
                return fault("it repeats the key frame before it");
            }
            if let (Some(before), Some(time)) = (before.time_s, key.time_s)
                && time <= before
            {
                return Err((Some(n), format!("its time must be after {before}, but is {time}")));
            }
        }
        let times = keys.iter().enumerate().scan(0.0, |travelled, (n, key)| {
            *travelled += n.checked_sub(1).map_or(0.0, |before| distance(&keys[before], key));
            Some(key.time_s.unwrap_or(*travelled))
        });
        Ok(Self { name: name.to_owned(), times: times.collect(), keys })
    }

    /// The path through a scene's views in their order.
    ///
    /// # Errors
    /// [`Error::Usage`] if the scene has fewer than two different views.
    pub fn through_views(scene: &Scene) -> Result<Self> {
        let mut keys: Vec<KeyFrame> =
            scene.views.iter().map(|v| KeyFrame { eye: v.eye, look_at: v.look_at, time_s: None }).collect();
        keys.dedup();
        if keys.len() < 2 {
            let name = &scene.name;
            return Err(Error::Usage(format!("scene {name} has no two different views, which a path needs")));
        }
        Self::new(VIEWS, keys)
    }

    /// The key frames.
    pub fn keys(&self) -> &[KeyFrame] {
        &self.keys
    }

    /// Scales all coordinates about the origin.
    pub fn scale(&mut self, factor: f32) {
        for key in &mut self.keys {
            key.eye *= factor;
            key.look_at *= factor;
        }
        if self.keys[0].time_s.is_none() {
            self.times.iter_mut().for_each(|t| *t *= factor);
        }
    }

    /// Moves every key frame.
    pub fn translate(&mut self, offset: Vec3) {
        for key in &mut self.keys {
            key.eye += offset;
            key.look_at += offset;
        }
    }

    /// Returns eye and look-at point after a share of the path's time, 0 (first key frame) to 1 (last).
    pub fn eye_and_look_at(&self, share: f32) -> (Vec3, Vec3) {
        let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
        let time = first + share.clamp(0.0, 1.0) * (last - first);
        let segment = self.times.partition_point(|t| *t <= time).clamp(1, self.keys.len() - 1) - 1;
        let share_of_segment = share_of(time, self.times[segment], self.times[segment + 1]);
        let points = self.points_around(segment);
        let knots = knots(&points);
        let t = knots[1] + share_of_segment * (knots[2] - knots[1]);
        (spline(points.map(|(eye, _)| eye), knots, t), spline(points.map(|(_, look_at)| look_at), knots, t))
    }

    /// Returns eye and look-at point of the key frames at both ends of segment n, and of one before and one after
    /// these. At an end of the path, where there is none, the other end of the segment is mirrored.
    fn points_around(&self, n: usize) -> [(Vec3, Vec3); 4] {
        let key = |n: usize| (self.keys[n].eye, self.keys[n].look_at);
        let mirrored = |(centre_eye, centre_look_at): (Vec3, Vec3), (eye, look_at): (Vec3, Vec3)| {
            (2.0 * centre_eye - eye, 2.0 * centre_look_at - look_at)
        };
        let (from, to) = (key(n), key(n + 1));
        let before = n.checked_sub(1).map_or_else(|| mirrored(from, to), key);
        let after = if n + 2 < self.keys.len() { key(n + 2) } else { mirrored(to, from) };
        [before, from, to, after]
    }
}

/// The distance between two key frames. Eye and look-at point count as one point with six coordinates, so that
/// a camera that only turns moves as well.
fn distance(a: &KeyFrame, b: &KeyFrame) -> f32 {
    (a.eye.distance_squared(b.eye) + a.look_at.distance_squared(b.look_at)).sqrt()
}

/// Returns the position of `t` between `from` and `to` as a share. The share is 0 if both ends are equal, as rounding
/// makes them if a short distance follows a long one.
fn share_of(t: f32, from: f32, to: f32) -> f32 {
    if to > from { (t - from) / (to - from) } else { 0.0 }
}

/// Returns the knots of the centripetal spline through four points, each an eye and a look-at point. The step from knot
/// to knot is the square root of the [`distance`] between the points.
fn knots(points: &[(Vec3, Vec3); 4]) -> [f32; 4] {
    let mut knots = [0.0; 4];
    for n in 1..4 {
        let ((eye_a, look_a), (eye_b, look_b)) = (points[n - 1], points[n]);
        knots[n] = knots[n - 1] + (eye_a.distance_squared(eye_b) + look_a.distance_squared(look_b)).sqrt().sqrt();
    }
    knots
}

/// Evaluates the Catmull-Rom spline between points 1 and 2 at the knot value `t`, by Barry and Goldman's pyramid.
fn spline(p: [Vec3; 4], knots: [f32; 4], t: f32) -> Vec3 {
    let mix = |a: Vec3, b: Vec3, from: usize, to: usize| a.lerp(b, share_of(t, knots[from], knots[to]));
    let a = [mix(p[0], p[1], 0, 1), mix(p[1], p[2], 1, 2), mix(p[2], p[3], 2, 3)];
    let b = [mix(a[0], a[1], 0, 2), mix(a[1], a[2], 1, 3)];
    mix(b[0], b[1], 1, 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn key(eye: [f32; 3], time_s: Option<f32>) -> KeyFrame {
        let eye = Vec3::from(eye);
        KeyFrame { eye, look_at: eye + Vec3::Z, time_s }
    }

    fn path(eyes: &[[f32; 3]]) -> CameraPath {
        CameraPath::new("p", eyes.iter().map(|e| key(*e, None)).collect()).expect("a path")
    }

    #[test]
    fn the_path_passes_its_key_frames_at_their_times() {
        let eyes = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [4.0, 2.0, 1.0]];
        let times = [2.0, 3.0, 7.0];
        let keys = eyes.iter().zip(times).map(|(e, t)| key(*e, Some(t))).collect();
        let timed = CameraPath::new("p", keys).expect("a path");
        for (eye, time) in eyes.iter().zip(times) {
            let (found, look_at) = timed.eye_and_look_at((time - 2.0) / 5.0);
            assert!(found.distance(Vec3::from(*eye)) < 1e-5 && look_at.distance(found + Vec3::Z) < 1e-5, "{found}");
        }
        assert_eq!(timed.eye_and_look_at(-1.0), timed.eye_and_look_at(0.0));
        assert_eq!(timed.eye_and_look_at(2.0), timed.eye_and_look_at(1.0));
        // Without times, the first segment gets its share of the distance: √5 of √5 + √10.
        let share = 5_f32.sqrt() / (5_f32.sqrt() + 10_f32.sqrt());
        assert!(path(&eyes).eye_and_look_at(share).0.distance(Vec3::from(eyes[1])) < 1e-4);
    }

    #[test]
    fn a_straight_path_is_followed_straight_and_evenly() {
        let line = path(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [6.0, 0.0, 0.0], [9.0, 0.0, 0.0]]);
        for n in 0..=20 {
            let share = n as f32 / 20.0;
            assert!(line.eye_and_look_at(share).0.distance(Vec3::new(9.0 * share, 0.0, 0.0)) < 1e-4, "{share}");
        }
    }

    proptest! {
        /// The centripetal spline stays within half a chord's length of the chords between its key frames (Yuksel et
        /// al. 2011); the uniform variant overshoots by the length of the neighbouring segments.
        #[test]
        fn the_spline_does_not_overshoot(points in prop::collection::vec(prop::array::uniform3(-5.0..5.0_f32), 4)) {
            prop_assume!(points.windows(2).all(|p| Vec3::from(p[0]).distance(Vec3::from(p[1])) > 0.05));
            let path = path(&points);
            for n in 0..=60 {
                let eye = path.eye_and_look_at(n as f32 / 60.0).0;
                let near = points.windows(2).map(|p| {
                    let (a, b) = (Vec3::from(p[0]), Vec3::from(p[1]));
                    eye.distance(a.lerp(b, ((eye - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0))) / a.distance(b)
                });
                let nearest = near.fold(f32::INFINITY, f32::min);
                prop_assert!(nearest < 0.5, "{nearest} of a chord away at {n}");
            }
        }
    }
}
