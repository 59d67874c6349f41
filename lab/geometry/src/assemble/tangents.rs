//! Computes tangents with MikkTSpace, the convention for which normal maps are baked.

use super::Triangle;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::Vec3;

/// Computes the tangents of triangles that have normals and matching winding. Triangles whose texture coordinates are
/// all 0 get arbitrary tangents.
pub(super) fn generate(triangles: &mut [Triangle]) {
    if triangles.iter().flatten().any(|v| v.uv != [0.0; 2]) {
        // A failure, whose reason the call does not give, leaves the tangents unchanged. They are made valid below.
        generate_tangents(&mut Triangles(triangles)).unwrap_or_default();
    }
    make_orthonormal(triangles);
}

/// Makes tangents unit vectors orthogonal to the normals, with a sign of 1 or −1. A vertex without a usable tangent,
/// for example because its texture coordinates are degenerate, gets any unit vector orthogonal to its normal.
pub(super) fn make_orthonormal(triangles: &mut [Triangle]) {
    for vertex in triangles.iter_mut().flatten() {
        let normal = Vec3::from(vertex.normal);
        let [x, y, z, sign] = vertex.tangent;
        let orthogonal = Vec3::new(x, y, z).reject_from_normalized(normal);
        // A tangent almost parallel to the normal is mostly rounding error, so it is discarded.
        let unit = orthogonal.try_normalize().filter(|unit| orthogonal.length() > 1e-2 && unit.is_finite());
        let tangent = unit.unwrap_or_else(|| normal.any_orthonormal_vector());
        // Adding zero turns −0 into 0, so that welding finds equal bits.
        vertex.tangent = (tangent + Vec3::ZERO).extend(if sign < 0.0 { -1.0 } else { 1.0 }).to_array();
    }
}

/// Gives MikkTSpace access to triangles: it reads their vertices and writes their tangents.
struct Triangles<'a>(&'a mut [Triangle]);

impl Geometry for Triangles<'_> {
    /// The number of triangles.
    fn num_faces(&self) -> usize {
        self.0.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    /// The position of a corner (0 to 2) of a triangle.
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.0[face][corner].position
    }

    /// The unit normal at a corner of a triangle.
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.0[face][corner].normal
    }

    /// Texture coordinates with v upwards, so that the bitangent follows a normal map's green axis.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let [u, v] = self.0[face][corner].uv;
        [u, -v]
    }

    /// Stores the tangent of a corner, with the sign of the bitangent as the fourth number, or zeros if there is none.
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.0[face][corner].tangent = space.map_or([0.0; 4], |s| s.tangent_encoded());
    }
}
