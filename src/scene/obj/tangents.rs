//! Tangents by MikkTSpace, the convention that normal maps are baked with.

use super::polygons::Triangle;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::Vec3;

/// Sets the tangents of triangles that have normals and matching winding. Where the texture
/// coordinates say nothing, a tangent is any unit vector orthogonal to the normal.
pub(super) fn generate(triangles: &mut [Triangle]) {
    let textured = triangles.iter().flatten().any(|v| v.uv != [0.0; 2]);
    // The error type has no values.
    if textured && generate_tangents(&mut Triangles(triangles)).is_err() {
        return;
    }
    for vertex in triangles.iter_mut().flatten() {
        let normal = Vec3::from(vertex.normal);
        let [x, y, z, sign] = vertex.tangent;
        let along = Vec3::new(x, y, z).reject_from_normalized(normal);
        // A tangent along the normal says nothing; what rounding leaves of it least of all.
        let unit = along.try_normalize().filter(|_| along.length() > 1e-2);
        let tangent = unit.unwrap_or_else(|| normal.any_orthonormal_vector());
        // Adding zero makes −0 equal 0 bit by bit, for welding.
        vertex.tangent = (tangent + Vec3::ZERO).extend(if sign < 0.0 { -1.0 } else { 1.0 }).to_array();
    }
}

struct Triangles<'a>(&'a mut [Triangle]);

impl Geometry for Triangles<'_> {
    fn num_faces(&self) -> usize {
        self.0.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.0[face][corner].position
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.0[face][corner].normal
    }

    /// With v upwards, so that the bitangent runs along a normal map's green axis.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let [u, v] = self.0[face][corner].uv;
        [u, -v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.0[face][corner].tangent = space.map_or([0.0; 4], |s| s.tangent_encoded());
    }
}
