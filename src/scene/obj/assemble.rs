//! Meshes from triangles: tangents, splitting in space, welding.

use super::polygons::{Part, Triangle};
use super::tangents;
use crate::scene::{Aabb, Mesh};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// A mesh has no more triangles than this: fine enough for frustum culling, coarse enough for draws.
const MAX_TRIANGLES: usize = 8192;

/// With more groups than this, a file's groups are no use as units of culling (some exporters write
/// one a face); each material's triangles are then pooled and split in space alone.
const MAX_PARTS: usize = 2048;

/// The meshes of a file's parts, with the scene's material index for each.
pub(super) fn meshes(mut parts: Vec<Part>, material_of: impl Fn(&Part) -> usize + Sync) -> Vec<Mesh> {
    if parts.len() > MAX_PARTS {
        parts = pool(parts);
    }
    let meshes_of = |part: Part| {
        let material = material_of(&part);
        let Part { name, mut triangles, .. } = part;
        tangents::generate(&mut triangles);
        let mut chunks = Vec::new();
        split(&mut triangles, &mut chunks);
        let count = chunks.len();
        let names = (1..).map(|i| if count == 1 { name.clone() } else { format!("{name} {i}/{count}") });
        names.zip(chunks).map(|(name, chunk)| weld(name, material, chunk)).collect::<Vec<_>>()
    };
    parts.into_par_iter().flat_map_iter(meshes_of).collect()
}

/// One part a material.
fn pool(parts: Vec<Part>) -> Vec<Part> {
    let mut pooled: Vec<Part> = Vec::new();
    let mut place: HashMap<usize, usize> = HashMap::new();
    for part in parts {
        match place.get(&part.material) {
            Some(&at) => pooled[at].triangles.extend(part.triangles),
            None => {
                place.insert(part.material, pooled.len());
                pooled.push(part);
            }
        }
    }
    pooled
}

/// Halves triangles at the median of their centres along the longest axis until they are few.
fn split<'a>(triangles: &'a mut [Triangle], chunks: &mut Vec<&'a [Triangle]>) {
    if triangles.len() <= MAX_TRIANGLES {
        chunks.push(triangles);
        return;
    }
    let thrice_centre = |t: &Triangle| t.iter().map(|v| Vec3::from(v.position)).sum::<Vec3>();
    let (min, max) = triangles
        .iter()
        .map(thrice_centre)
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), centre| (min.min(centre), max.max(centre)));
    let axis = (max - min).max_position();
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |a, b| thrice_centre(a)[axis].total_cmp(&thrice_centre(b)[axis]));
    let (low, high) = triangles.split_at_mut(middle);
    split(low, chunks);
    split(high, chunks);
}

/// An indexed mesh in which vertices that are equal bit by bit are one.
fn weld(name: String, material: usize, triangles: &[Triangle]) -> Mesh {
    let mut index_of: HashMap<[u32; 12], u32> = HashMap::with_capacity(triangles.len());
    let mut vertices = Vec::new();
    let mut indices = Vec::with_capacity(3 * triangles.len());
    for &vertex in triangles.iter().flatten() {
        // A chunk has at most 3 · MAX_TRIANGLES vertices, which is far below 2³².
        let next = vertices.len() as u32;
        let index = *index_of.entry(bytemuck::cast(vertex)).or_insert_with(|| {
            vertices.push(vertex);
            next
        });
        indices.push(index);
    }
    let bounds = Aabb::of(&vertices);
    Mesh { name, vertices, indices, material, bounds }
}
