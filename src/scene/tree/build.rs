//! Builds a [`Tree`] by the crate obvhs: a binary hierarchy by PLOC with reinsertion, and from it the wide one.
//!
//! A hierarchy with more levels than a walk has room for, as many triangles in
//! one place make it, is built again by halving lists of triangles, which bounds its levels.

use super::boxes::{LEAF, Padded, PaddedTriangles, by_neighbours, levels};
use super::{MAX_TRIANGLES, NODE_WORDS, Tree, Words, triangles};
use crate::error::{Error, Result};
use crate::math::constants::TREE_DEPTH;
use crate::scene::Scene;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;

impl Tree {
    /// The hierarchy over all triangles of a scene that have an area.
    ///
    /// # Errors
    /// [`Error::Usage`] for a scene with more triangles than have numbers.
    pub fn build(scene: &Scene) -> Result<Self> {
        let count = scene.triangle_count();
        if count > MAX_TRIANGLES {
            let name = &scene.name;
            return Err(Error::Usage(format!(
                "scene {name} has {count} triangles; rays are followed through at most {MAX_TRIANGLES}"
            )));
        }
        let corners: Vec<[DVec3; 3]> = triangles(scene)
            .map(|(mesh, t)| t.map(|i| Vec3::from(mesh.vertices[i as usize].position).as_dvec3()))
            .collect();
        Ok(Self::over(&corners))
    }

    /// The hierarchy over triangles in metres that have an area.
    pub fn over(corners: &[[DVec3; 3]]) -> Self {
        let PaddedTriangles { middle: origin, with_area, boxes } = PaddedTriangles::new(corners.len(), |i| corners[i]);
        if with_area.is_empty() {
            return Self { origin, ..Self::default() };
        }
        let mut wide = bvh2_to_cwbvh(&by_neighbours(&boxes), LEAF, true, false);
        if levels(&wide) > TREE_DEPTH as u32 {
            wide = bvh2_to_cwbvh(&by_halves(&boxes), LEAF, true, false);
        }
        let words: &[Words] = bytemuck::cast_slice(&wide.nodes);
        debug_assert_eq!(words.len(), NODE_WORDS * wide.nodes.len());
        let slots = wide.primitive_indices.iter().map(|i| with_area[*i as usize]).collect();
        Self { origin, nodes: words.to_vec(), slots, levels: levels(&wide) }
    }
}

/// A binary hierarchy with as few levels as there can be: each list of boxes is cut in half along the axis in which its
/// middles lie farthest apart.
fn by_halves(padded: &[Padded]) -> Bvh2 {
    let mut indices: Vec<u32> = (0..padded.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut work = vec![(0_usize, 0..padded.len())];
    while let Some((node, range)) = work.pop() {
        let list = &mut indices[range.clone()];
        let aabb = list.iter().fold(Aabb::INVALID, |all, &i| all.union(&padded[i as usize].0));
        if list.len() == 1 {
            nodes[node] = Bvh2Node::new(aabb, 1, range.start as u32);
            continue;
        }
        let middle = |i: &u32| Vec3A::from(padded[*i as usize].0.center().to_array());
        let (low, high) = list
            .iter()
            .map(middle)
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let axis = (high - low).max_position();
        let half = list.len() / 2;
        list.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b)));
        let first = nodes.len();
        nodes[node] = Bvh2Node::new(aabb, 0, first as u32);
        nodes.extend([Bvh2Node::default(), Bvh2Node::default()]);
        work.push((first, range.start..range.start + half));
        work.push((first + 1, range.start + half..range.end));
    }
    Bvh2 { nodes, primitive_indices: indices, ..Bvh2::default() }
}
