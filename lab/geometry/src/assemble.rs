//! Makes meshes from the triangles that a loader reads: adds tangents, splits large groups in space, and welds equal
//! vertices.

mod tangents;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ssct_ground::scene::{Aabb, Mesh, Vertex};
use std::collections::HashMap;

/// The corners of a triangle.
pub type Triangle = [Vertex; 3];

/// The triangles of one group that have one material.
#[derive(Debug)]
pub struct MeshPart {
    /// Name of the group or object.
    pub name: String,
    /// Index into the file's materials.
    pub material: usize,
    /// Triangles with unit normals and matching winding.
    pub triangles: Vec<Triangle>,
    /// Whether the file gives the tangents; if not, [`meshes`] computes them.
    pub has_tangents: bool,
}

/// Returns true if the sum of the normals at a triangle's corners is more than 120 degrees away from `face`, the unit
/// normal of its winding. Normals that lean only a little behind the face are common on rounded surfaces.
pub fn normals_point_behind(triangle: &Triangle, face: DVec3) -> bool {
    let normal_sum: DVec3 = triangle.iter().map(|v| Vec3::from(v.normal).as_dvec3()).sum();
    // The cosine of 120 degrees is −0.5.
    normal_sum.dot(face) < -0.5 * normal_sum.length()
}

/// Greatest number of triangles in a mesh: few enough for frustum culling to be useful, and enough to keep draws few.
const MAX_TRIANGLES: usize = 8192;

/// Greatest number of groups that are kept apart. A file with more groups (some exporters write one per face) has
/// groups too small for culling: the triangles of each material are then pooled, and split only in space.
const MAX_PARTS: usize = 2048;

/// Makes the meshes of a file's parts. `material_of` gives the scene's material index of a part. A part with more than
/// `MAX_TRIANGLES` triangles becomes several meshes, whose names are numbered ("wall 1/3").
pub fn meshes(mut parts: Vec<MeshPart>, material_of: impl Fn(&MeshPart) -> usize + Sync) -> Vec<Mesh> {
    if parts.len() > MAX_PARTS {
        parts = pool_by_material(parts);
    }
    let meshes_of_part = |part: MeshPart| {
        let material = material_of(&part);
        let MeshPart { name, mut triangles, has_tangents, .. } = part;
        match has_tangents {
            true => tangents::make_orthonormal(&mut triangles),
            false => tangents::generate(&mut triangles),
        }
        let mut chunks = Vec::new();
        split_in_space(&mut triangles, &mut chunks);
        let count = chunks.len();
        let names = (1..).map(|number| if count == 1 { name.clone() } else { format!("{name} {number}/{count}") });
        names.zip(chunks).map(|(name, chunk)| weld(name, material, chunk)).collect::<Vec<_>>()
    };
    parts.into_par_iter().flat_map_iter(meshes_of_part).collect()
}

/// Merges the parts that agree in material and in `has_tangents` into one part, which has the name of the first one.
fn pool_by_material(parts: Vec<MeshPart>) -> Vec<MeshPart> {
    let mut pooled: Vec<MeshPart> = Vec::new();
    // The index in `pooled` for each pair of material and `has_tangents`.
    let mut index_of_pool: HashMap<(usize, bool), usize> = HashMap::new();
    for part in parts {
        match index_of_pool.get(&(part.material, part.has_tangents)) {
            Some(&index) => pooled[index].triangles.extend(part.triangles),
            None => {
                index_of_pool.insert((part.material, part.has_tangents), pooled.len());
                pooled.push(part);
            }
        }
    }
    pooled
}

/// Splits the triangles at the median of their centres along the longest axis, recursively, until each chunk has at
/// most [`MAX_TRIANGLES`]. The chunks are added to `chunks`.
fn split_in_space<'a>(triangles: &'a mut [Triangle], chunks: &mut Vec<&'a [Triangle]>) {
    if triangles.len() <= MAX_TRIANGLES {
        chunks.push(triangles);
        return;
    }
    // The sum of the corners is three times the centre, and orders triangles in the same way.
    let thrice_centre = |t: &Triangle| t.iter().map(|v| Vec3::from(v.position)).sum::<Vec3>();
    let (min, max) = triangles
        .iter()
        .map(thrice_centre)
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), point| (min.min(point), max.max(point)));
    let axis = (max - min).max_position();
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |a, b| thrice_centre(a)[axis].total_cmp(&thrice_centre(b)[axis]));
    let (low, high) = triangles.split_at_mut(middle);
    split_in_space(low, chunks);
    split_in_space(high, chunks);
}

/// Makes an indexed mesh in which vertices that are equal bit by bit are stored once.
fn weld(name: String, material: usize, triangles: &[Triangle]) -> Mesh {
    // The index in `vertices` for the bits of the twelve numbers of a vertex.
    let mut index_of_vertex: HashMap<[u32; 12], u32> = HashMap::with_capacity(triangles.len());
    let mut vertices = Vec::new();
    let mut indices = Vec::with_capacity(3 * triangles.len());
    for &vertex in triangles.iter().flatten() {
        // A chunk has at most 3 · MAX_TRIANGLES vertices, far fewer than 2³².
        let new_index = vertices.len() as u32;
        let index = *index_of_vertex.entry(bytemuck::cast(vertex)).or_insert_with(|| {
            vertices.push(vertex);
            new_index
        });
        indices.push(index);
    }
    let bounds = Aabb::around(&vertices);
    Mesh { name, vertices, indices, material, bounds }
}
