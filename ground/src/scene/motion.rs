//! How objects of a scene move in time: by chains of nodes with key frames, as in animations of glTF files.

use super::{Placement, Scene};
use glam::{DMat4, DQuat, DVec3};
use std::sync::Arc;

/// A motion of a scene: objects that move at the same time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// The name that commands and records use.
    pub name: String,
    /// The objects that move, and how.
    pub movers: Vec<Mover>,
}

/// An object that moves: meshes, and the chain of nodes that carries them.
#[derive(Debug, Clone, PartialEq)]
pub struct Mover {
    /// Names of the object's meshes.
    pub meshes: Vec<String>,
    /// The matrix from the space of the first node to the world.
    pub root: DMat4,
    /// The nodes of the chain, from the root to the meshes.
    pub nodes: Vec<MovingNode>,
    /// The matrix from the meshes' own space to the world before any motion begins.
    pub rest: DMat4,
}

/// A node: its place in its parent's space, and how this place changes.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingNode {
    /// Where the node stands if nothing changes.
    pub rest: Rest,
    /// The key frames of the parts that change.
    pub changes: Changes,
}

/// Key frames of the parts of a node that change.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Changes {
    /// The node's offset.
    pub offset: Option<Arc<Keys<3>>>,
    /// The node's turn, as a quaternion: x, y, z and w.
    pub turn: Option<Arc<Keys<4>>>,
    /// The node's size along each axis.
    pub size: Option<Arc<Keys<3>>>,
}

/// Where a node stands in its parent's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rest {
    /// A matrix, which no key frame changes.
    Matrix(DMat4),
    /// An offset, a turn, and a size along each axis.
    Parts(DVec3, DQuat, DVec3),
}

/// How values between two key frames are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the key frame before.
    Step,
    /// A value that changes evenly; turns go the shorter way.
    Linear,
    /// A cubic spline. Each key frame has three values: the slope before it, the value itself, and the slope after it.
    Cubic,
}

/// Key frames of a vector.
#[derive(Debug, Clone, PartialEq)]
pub struct Keys<const N: usize> {
    times_s: Vec<f32>,
    values: Vec<[f32; N]>,
    interpolation: Interpolation,
}

impl<const N: usize> Keys<N> {
    /// Key frames at times in seconds.
    ///
    /// # Errors
    /// A clause that says what is wrong: no times, times that do not increase, numbers that are not finite, or another number of
    /// values than the key frames need.
    pub fn new(times_s: Vec<f32>, values: Vec<[f32; N]>, interpolation: Interpolation) -> Result<Self, &'static str> {
        let values_per_key = if interpolation == Interpolation::Cubic { 3 } else { 1 };
        let numbers = || times_s.iter().chain(values.iter().flatten());
        if times_s.is_empty() || times_s.len().checked_mul(values_per_key) != Some(values.len()) {
            return Err("does not have as many values as its key frames need");
        }
        if !numbers().all(|v| v.is_finite()) {
            return Err("has numbers that are not finite");
        }
        if times_s.windows(2).any(|pair| pair[1] <= pair[0]) {
            return Err("has times that do not increase");
        }
        Ok(Self { times_s, values, interpolation })
    }

    /// Returns the times of the first and of the last key frame, in seconds.
    fn end_times_s(&self) -> [f32; 2] {
        [self.times_s[0], self.times_s[self.times_s.len() - 1]]
    }

    /// The value at a time. Before the first key frame it is the first value, and after the last key frame the last value.
    fn value_at(&self, time_s: f32) -> [f64; N] {
        let cubic = self.interpolation == Interpolation::Cubic;
        // Parts of a cubic key frame: 0 is the slope before it, 1 the value, and 2 the slope after it.
        let value = |key: usize, part: usize| self.values[if cubic { 3 * key + part } else { key }].map(f64::from);
        let last = self.times_s.len() - 1;
        let passed_keys = self.times_s.partition_point(|t| *t <= time_s);
        let Some(first) = passed_keys.checked_sub(1) else { return value(0, 1) };
        if first == last || self.interpolation == Interpolation::Step {
            return value(first, 1);
        }
        let [begin, end] = [first, first + 1].map(|key| f64::from(self.times_s[key]));
        let s = (f64::from(time_s) - begin) / (end - begin);
        let (from, to) = (value(first, 1), value(first + 1, 1));
        if cubic {
            let (slope_after, slope_before) = (value(first, 2), value(first + 1, 0)); // of glTF's cubic Hermite spline
            let (s2, s3, step) = (s * s, s * s * s, end - begin);
            let spline = |i: usize| {
                (2.0 * s3 - 3.0 * s2 + 1.0) * from[i]
                    + step * (s3 - 2.0 * s2 + s) * slope_after[i]
                    + (3.0 * s2 - 2.0 * s3) * to[i]
                    + step * (s3 - s2) * slope_before[i]
            };
            return std::array::from_fn(spline);
        }
        match (&from[..], &to[..]) {
            // Four numbers are a quaternion.
            (&[x0, y0, z0, w0], &[x1, y1, z1, w1]) => {
                let turn = unit(DQuat::from_xyzw(x0, y0, z0, w0)).slerp(unit(DQuat::from_xyzw(x1, y1, z1, w1)), s);
                let numbers = turn.to_array();
                std::array::from_fn(|i| numbers[i])
            }
            _ => std::array::from_fn(|i| from[i] + s * (to[i] - from[i])),
        }
    }
}

/// A quaternion scaled to length 1; the identity for a quaternion of zeros.
fn unit(turn: DQuat) -> DQuat {
    if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY }
}

impl MovingNode {
    /// A node that nothing changes.
    pub fn still(rest: Rest) -> Self {
        Self { rest, changes: Changes::default() }
    }

    /// The times of the first and of the last key frame of each part that changes, in seconds.
    fn end_times_s(&self) -> impl Iterator<Item = f32> {
        let Changes { offset, turn, size } = &self.changes;
        let [offset, size] = [offset, size].map(|part| part.as_ref().map(|keys| keys.end_times_s()));
        let turn = turn.as_ref().map(|keys| keys.end_times_s());
        [offset, size, turn].into_iter().flatten().flatten()
    }

    /// The matrix from the node's space to its parent's at a time.
    fn matrix_at(&self, time_s: f32) -> DMat4 {
        match self.rest {
            Rest::Matrix(matrix) => matrix,
            Rest::Parts(offset, turn, size) => {
                let changed = &self.changes;
                let offset = changed.offset.as_ref().map_or(offset, |keys| DVec3::from_array(keys.value_at(time_s)));
                let turn = changed.turn.as_ref().map_or(turn, |keys| DQuat::from_array(keys.value_at(time_s)));
                let size = changed.size.as_ref().map_or(size, |keys| DVec3::from_array(keys.value_at(time_s)));
                Rest::Parts(offset, turn, size).matrix()
            }
        }
    }
}

impl Rest {
    /// The matrix from the node's space to its parent's.
    pub fn matrix(&self) -> DMat4 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts(offset, turn, size) => DMat4::from_scale_rotation_translation(size, unit(turn), offset),
        }
    }
}

impl Mover {
    /// Whether the meshes have a placement at each of 17 times, evenly spaced from the first key frame to the last.
    pub fn is_placed(&self) -> bool {
        let times = self.nodes.iter().flat_map(MovingNode::end_times_s);
        let (first, last) = times.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), time| (a.min(time), b.max(time)));
        let steps = 16;
        (0..=steps).all(|n| self.placement_at(first + (last - first) * (n as f32 / steps as f32)).is_some())
    }

    /// The placement of the meshes at a time, relative to where they stand in the scene; `None` if no placement fits.
    pub fn placement_at(&self, time_s: f32) -> Option<Placement> {
        let to_world = self.nodes.iter().fold(self.root, |matrix, node| matrix * node.matrix_at(time_s));
        placement(&(to_world * self.rest.inverse()))
    }
}

/// The least factor of an object's size. An object that shrinks to nothing keeps this size, which shows in no pixel, since a
/// placement of size 0 has no inverse.
const LEAST_SIZE: f32 = 1e-6;

/// Returns the placement of a matrix; `None` if its axes differ in length, are not at right angles, or mirror space.
fn placement(matrix: &DMat4) -> Option<Placement> {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|column| column.truncate());
    if columns.iter().all(|column| column.length() < f64::from(LEAST_SIZE)) {
        let placement = Placement { size: LEAST_SIZE, ..Placement::from(matrix.w_axis.truncate().as_vec3()) };
        return placement.is_sound().then_some(placement);
    }
    let size = columns[0].length();
    let is_uniform = columns.iter().all(|c| (c.length() - size).abs() <= 1e-4 * size);
    let is_orthogonal =
        [(0, 1), (1, 2), (2, 0)].iter().all(|(i, j)| columns[*i].dot(columns[*j]).abs() <= 1e-4 * size * size);
    if !(is_uniform && is_orthogonal && size > 0.0 && matrix.determinant() > 0.0) {
        return None;
    }
    let (_, turn, offset) = matrix.to_scale_rotation_translation();
    let placement = Placement { turn: turn.as_quat().normalize(), size: size as f32, offset: offset.as_vec3() };
    placement.is_sound().then_some(placement)
}

impl Motion {
    /// Returns names and placements of moving meshes at a time in seconds; they rest before and after their key frames.
    pub fn placements_at(&self, time_s: f32) -> impl Iterator<Item = (&str, Placement)> {
        self.movers.iter().flat_map(move |mover| {
            let placement = mover.placement_at(time_s).unwrap_or_default();
            mover.meshes.iter().map(move |name| (name.as_str(), placement))
        })
    }

    /// Moves the whole motion by a matrix in world space.
    pub(super) fn transform(&mut self, matrix: &DMat4) {
        for Mover { meshes: _, root, nodes: _, rest } in &mut self.movers {
            *root = *matrix * *root;
            *rest = *matrix * *rest;
        }
    }
}

impl Scene {
    /// Moves the meshes to where they stand in a motion at a time in seconds.
    pub fn pose(&mut self, motion: &Motion, time_s: f32) {
        let placed: Vec<(&str, Placement)> = motion.placements_at(time_s).collect();
        self.place_meshes(&placed);
    }

    /// Moves meshes by placements, which are given by the meshes' names.
    pub fn place_meshes(&mut self, placed: &[(&str, Placement)]) {
        for mesh in &mut self.meshes {
            if let Some((_, placement)) = placed.iter().find(|(name, p)| *name == mesh.name && *p != Placement::HERE) {
                mesh.place(placement);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn keys<const N: usize>(times: &[f32], values: &[[f32; N]], interpolation: Interpolation) -> Keys<N> {
        Keys::new(times.to_vec(), values.to_vec(), interpolation).expect("key frames")
    }

    #[test]
    fn values_between_key_frames_follow_the_interpolation() {
        let values = [[0.0, 1.0, 2.0], [4.0, 1.0, 0.0]];
        let linear = keys(&[1.0, 3.0], &values, Interpolation::Linear);
        let step = keys(&[1.0, 3.0], &values, Interpolation::Step);
        assert_eq!([0.0, 1.5, 3.0, 9.0].map(|t| linear.value_at(t)[0]), [0.0, 1.0, 4.0, 4.0]);
        assert_eq!([0.0, 1.5, 3.0].map(|t| step.value_at(t)[0]), [0.0, 0.0, 4.0]);
        // x² from 0 to 2, whose slopes are 0 and 4.
        let square = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0; 3]];
        let cubic = keys(&[0.0, 2.0], &square, Interpolation::Cubic);
        for x in [0.0, 0.3, 1.0, 1.7] {
            assert!((cubic.value_at(x)[0] - f64::from(x * x)).abs() < 1e-6, "{x}");
        }
        // The turn is half of the shorter way round, whatever the sign of the quaternion.
        let half =
            keys(&[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, -1.0, 0.0, 0.0]], Interpolation::Linear).value_at(0.5);
        let turned = DQuat::from_array(half) * DVec3::X;
        assert!(turned.dot(DVec3::X).abs() < 1e-6, "{turned}");
    }

    #[test]
    fn faulty_key_frames_are_refused_with_the_reason() {
        let fault = |times: &[f32], count: usize, interpolation| {
            Keys::new(times.to_vec(), vec![[1.0; 3]; count], interpolation).err()
        };
        assert_eq!(fault(&[0.0, 1.0], 2, Interpolation::Linear), None);
        assert!(fault(&[0.0, 1.0], 2, Interpolation::Cubic).is_some_and(|why| why.contains("as many values")));
        assert!(fault(&[], 0, Interpolation::Step).is_some());
        assert!(fault(&[1.0, 1.0], 2, Interpolation::Step).is_some_and(|why| why.contains("do not increase")));
        assert!(fault(&[f32::NAN], 1, Interpolation::Step).is_some_and(|why| why.contains("finite")));
    }

    #[test]
    fn a_thing_goes_along_with_the_nodes_that_it_hangs_from() {
        // An arm turns about its foot, and an object that the arm holds slides along the arm.
        let turn =
            keys(&[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.5f32.sqrt(), 0.5f32.sqrt()]], Interpolation::Linear);
        let slide = keys(&[0.0, 1.0], &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], Interpolation::Linear);
        let foot = Rest::Parts(DVec3::new(0.0, 0.0, 5.0), DQuat::IDENTITY, DVec3::ONE);
        let held = Rest::Parts(DVec3::X, DQuat::IDENTITY, DVec3::ONE);
        let nodes = vec![
            MovingNode { rest: foot, changes: Changes { turn: Some(Arc::new(turn)), ..Changes::default() } },
            MovingNode { rest: held, changes: Changes { offset: Some(Arc::new(slide)), ..Changes::default() } },
        ];
        let rest = nodes.iter().fold(DMat4::IDENTITY, |m, node| m * node.matrix_at(0.0));
        let mut mover = Mover { meshes: vec!["held".into()], root: DMat4::IDENTITY, nodes, rest };
        assert_eq!(mover.placement_at(0.0), Some(Placement::HERE));
        let there = mover.placement_at(1.0).expect("a placement").place(Vec3::new(1.0, 0.0, 5.0));
        assert!(there.distance(Vec3::new(0.0, 2.0, 5.0)) < 1e-5, "{there}");
        let mut motion = Motion { name: "wave".into(), movers: vec![mover.clone()] };
        motion.transform(&DMat4::from_scale(DVec3::splat(2.0)));
        let there = motion.placements_at(1.0).next().expect("a mesh").1.place(Vec3::new(2.0, 0.0, 10.0));
        assert!(there.distance(Vec3::new(0.0, 4.0, 10.0)) < 1e-5, "{there}");
        mover.nodes[1].changes.size = Some(Arc::new(keys(&[0.0], &[[1.0, 2.0, 1.0]], Interpolation::Step)));
        assert_eq!(mover.placement_at(1.0), None, "a size that differs between axes is no placement");
    }
}
