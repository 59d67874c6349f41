//! Makes the triangles of a primitive, placed in the world.

use super::data::Data;
use super::materials::Coordinates;
use super::vertices::{MeshVertices, PlacedMesh, PlacedVertex, PlacedVertices};
use super::{MAX_TRIANGLES, Notes};
use glam::{DVec3, Vec3};
use gltf::Semantic;
use gltf::mesh::{Mode, Primitive};
use ssct_geometry::assemble::{self, MeshPart, Triangle};
use ssct_geometry::bounded;
use ssct_ground::Result;

/// Count of triangles and bounds of all primitives that were read.
pub(super) struct Tally {
    /// Triangles of the file, each counted as often as it is placed.
    pub(super) triangles: usize,
    /// Bounds of the vertices in the world, before rounding to 32-bit floats.
    pub(super) bounds: [DVec3; 2],
}

impl Default for Tally {
    fn default() -> Self {
        Self { triangles: 0, bounds: [DVec3::INFINITY, DVec3::NEG_INFINITY] }
    }
}

/// Makes the triangles of a primitive, placed in the world by `mesh`; `None` if it has none. `material` is the index of
/// the primitive's material among the materials in use, and `coordinates` are the texture coordinates that this
/// material needs.
pub(super) fn mesh_part(
    data: &Data,
    primitive: &Primitive,
    material: usize,
    mesh: &PlacedMesh,
    coordinates: &Coordinates,
    tally: &mut Tally,
    notes: &mut Notes,
) -> Result<Option<MeshPart>> {
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        notes.add("lines", "points and lines are not drawn".to_owned());
        return Ok(None);
    }
    if primitive.get(&Semantic::Colors(0)).is_some() {
        notes.add("colours", "colours of vertices are not supported and were ignored".to_owned());
    }
    let Some(vertices) = MeshVertices::new(data, primitive, mesh, coordinates)? else { return Ok(None) };
    let set = coordinates.set;
    if coordinates.has_images && primitive.get(&Semantic::TexCoords(set)).is_none() {
        let name = bounded::printable_name(mesh.name);
        let sentence =
            format!("mesh {name} lacks the texture coordinates TEXCOORD_{set} of its images; they count as 0");
        notes.add("no set", sentence);
    }
    let indices = match primitive.indices() {
        Some(accessor) => data.indices(&accessor)?.iter().collect(),
        None => (0..vertices.count as u32).collect::<Vec<u32>>(),
    };
    let triangle_indices = triangle_indices(primitive.mode(), &indices);
    tally.triangles += triangle_indices.len();
    if tally.triangles > MAX_TRIANGLES {
        return Err(data.error(format!("places more than {MAX_TRIANGLES} triangles in the world")));
    }
    let mut triangles = Vec::with_capacity(triangle_indices.len());
    let mut placed_vertices = PlacedVertices::new(vertices.count, triangle_indices.len());
    for indices in triangle_indices {
        let mut corners = [PlacedVertex::default(); 3];
        for (corner, index) in corners.iter_mut().zip(indices) {
            *corner = placed_vertices.get(index, || vertices.place(index as usize, notes))?;
            let [min, max] = &mut tally.bounds;
            (*min, *max) = (min.min(corner.position), max.max(corner.position));
        }
        // A transform that mirrors the mesh also reverses the winding of its triangles, so that two corners are
        // swapped.
        let [a, b, c] = corners;
        let wound_corners = if a.mirror_sign < 0.0 { [a, c, b] } else { [a, b, c] };
        match checked_triangle(wound_corners.map(|corner| corner.vertex), notes) {
            Some(triangle) => triangles.push(triangle),
            None => notes.add("area", "triangles without area were left out".to_owned()),
        }
    }
    let is_outside_image = |coordinate: &f32| !(-1e-3..=1.001).contains(coordinate);
    if coordinates.clamps && triangles.iter().flatten().any(|vertex| vertex.uv.iter().any(is_outside_image)) {
        notes.add("clamps", "images that are clamped or mirrored at their border are repeated instead".to_owned());
    }
    let part = MeshPart { name: mesh.name.to_owned(), material, triangles, has_tangents: vertices.has_tangents };
    Ok(Some(part).filter(|part| !part.triangles.is_empty()))
}

/// Returns the three indices of each triangle that a mode (list, strip or fan) makes of `indices`, in the winding of
/// its front.
fn triangle_indices(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            // Every second triangle of a strip has the opposite winding.
            let with_front_winding = |(number, triangle): (usize, &[u32])| {
                let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
                if number % 2 == 0 { [a, b, c] } else { [a, c, b] }
            };
            indices.windows(3).enumerate().map(with_front_winding).collect()
        }
        Mode::TriangleFan => {
            let (Some((first, rest)), 3..) = (indices.split_first(), indices.len()) else { return Vec::new() };
            rest.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect()
        }
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}

/// Returns the triangle with a valid normal at each corner; `None` if twice its area is at most 1e-7 of its longest
/// squared side. The author's normals are kept, even if they lean slightly behind the face, as smooth normals do at
/// silhouettes. Normals that point to the back of the face are reversed, and missing ones become that of the face.
fn checked_triangle(mut triangle: Triangle, notes: &mut Notes) -> Option<Triangle> {
    let position = |i: usize| Vec3::from(triangle[i].position).as_dvec3();
    let edges = [position(1) - position(0), position(2) - position(1), position(0) - position(2)];
    // The length of the cross product is twice the area.
    let cross = edges[0].cross(-edges[2]);
    let longest_squared = edges.iter().map(|edge| edge.length_squared()).fold(0.0, f64::max);
    if cross.length() <= 1e-7 * longest_squared {
        return None;
    }
    let face_normal = cross.normalize();
    let is_behind = assemble::normals_point_behind(&triangle, face_normal);
    if is_behind {
        notes.add("turned", "normals that point to the back of their triangles were turned to its front".to_owned());
    }
    for vertex in &mut triangle {
        let mut normal = Vec3::from(vertex.normal);
        if is_behind {
            normal = -normal;
            vertex.tangent[3] = -vertex.tangent[3];
        }
        let is_sound = normal.is_finite() && normal != Vec3::ZERO;
        // Adding zero turns −0 into 0, so that welding finds equal bits.
        vertex.normal = (if is_sound { normal } else { face_normal.as_vec3() } + Vec3::ZERO).to_array();
    }
    Some(triangle)
}
