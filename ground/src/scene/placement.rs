//! Where a moving object stands, relative to where it was made.

use super::Vertex;
use glam::{DMat4, DVec3, Quat, Vec3};

/// A turn and a scaling about the world's origin, followed by an offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The turn, of length 1.
    pub turn: Quat,
    /// Factor of the object's size, above 0.
    pub size: f32,
    /// Offset in metres along the world's axes.
    pub offset: Vec3,
}

impl Default for Placement {
    fn default() -> Self {
        Self::HERE
    }
}

impl From<Vec3> for Placement {
    fn from(offset: Vec3) -> Self {
        Self { offset, ..Self::HERE }
    }
}

impl Placement {
    /// The placement of an object that stands where it was made.
    pub const HERE: Self = Self { turn: Quat::IDENTITY, size: 1.0, offset: Vec3::ZERO };

    /// Whether all numbers are valid: finite, with a turn of length 1 and a size above 0.
    pub fn is_sound(&self) -> bool {
        self.offset.is_finite() && self.turn.is_normalized() && self.size.is_finite() && self.size > 0.0
    }

    /// Whether the placement is an offset alone.
    pub fn is_offset(&self) -> bool {
        self.turn == Quat::IDENTITY && self.size == 1.0
    }

    /// The matrix from where objects were made to where they stand.
    pub fn matrix(&self) -> DMat4 {
        let size = DVec3::splat(self.size.into());
        DMat4::from_scale_rotation_translation(size, self.turn.as_dquat().normalize(), self.offset.as_dvec3())
    }

    /// Returns where a point of the object stands.
    pub fn place(&self, point: Vec3) -> Vec3 {
        if self.is_offset() { point + self.offset } else { self.matrix().transform_point3(point.as_dvec3()).as_vec3() }
    }

    /// Places a vertex: its place, its normal and its tangent.
    pub fn place_vertex(&self, vertex: &mut Vertex) {
        vertex.position = self.place(vertex.position.into()).to_array();
        if !self.is_offset() {
            let [x, y, z, sign] = vertex.tangent;
            vertex.normal = (self.turn * Vec3::from(vertex.normal)).to_array();
            vertex.tangent = (self.turn * Vec3::new(x, y, z)).extend(sign).to_array();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placement_turns_about_the_origin_before_it_moves() {
        let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let placement = Placement { turn, size: 2.0, offset: Vec3::new(0.0, 1.0, 0.0) };
        assert!(placement.is_sound() && !placement.is_offset());
        assert!(placement.place(Vec3::X).distance(Vec3::new(0.0, 1.0, -2.0)) < 1e-6);
        let mut vertex =
            Vertex { position: [1.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0], uv: [0.0; 2], tangent: [0.0, 0.0, 1.0, -1.0] };
        placement.place_vertex(&mut vertex);
        assert!(Vec3::from(vertex.normal).distance(Vec3::NEG_Z) < 1e-6);
        assert!(Vec3::from_slice(&vertex.tangent).distance(Vec3::X) < 1e-6 && vertex.tangent[3] == -1.0);
        let [x, y] = [0.1, 0.7];
        let moved = Placement::from(Vec3::new(x, y, 0.0));
        assert_eq!(moved.place(Vec3::splat(0.3)), Vec3::splat(0.3) + Vec3::new(x, y, 0.0));
        assert!(!Placement { size: 0.0, ..Placement::HERE }.is_sound());
        assert!(!Placement::from(Vec3::NAN).is_sound());
    }
}
