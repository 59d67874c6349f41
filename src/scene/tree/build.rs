//! Builds a [`Tree`] by the crate obvhs: a binary hierarchy by PLOC with reinsertion, and from it the wide one.
//!
//! Boxes are enlarged by more than the rounding errors of a walk in f32 (`PADDING`), so that no box hides a triangle that
//! the walk's test of triangles would accept. A hierarchy with more levels than a walk has room for, as many triangles in
//! one place make it, is built again by halving lists of triangles, which bounds its levels.

use super::{MAX_TRIANGLES, NODE_WORDS, Tree, Words, triangles};
use crate::error::{Error, Result};
use crate::math::constants::TREE_DEPTH;
use crate::scene::Scene;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

/// How far boxes extend beyond their triangles, as a share of the greatest coordinate from the scene's middle. The slab
/// test in f32 errs by a few units of 6e-8 for origins about that far from it.
const PADDING: f32 = 4e-6;

/// The most triangles to a leaf: what the compressed nodes have room for.
const LEAF: u32 = 3;

/// A triangle's enlarged box.
struct Padded(Aabb);

impl Boundable for Padded {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

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
        let all = || corners.iter().flatten().copied();
        let [low, high] = [all().reduce(DVec3::min), all().reduce(DVec3::max)].map(Option::unwrap_or_default);
        let origin = 0.5 * (low + high);
        let padding = Vec3A::splat(PADDING * (high - origin).max_element() as f32);
        let has_area = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a) != DVec3::ZERO;
        let with_area: Vec<u32> = (0..corners.len() as u32).filter(|i| has_area(&corners[*i as usize])).collect();
        if with_area.is_empty() {
            return Self { origin, ..Self::default() };
        }
        let padded: Vec<Padded> = with_area
            .iter()
            .map(|&i| {
                let [a, b, c] = corners[i as usize].map(|v| (v - origin).as_vec3a());
                Padded(Aabb::new(a.min(b).min(c) - padding, a.max(b).max(c) + padding))
            })
            .collect();
        let mut wide = bvh2_to_cwbvh(&by_neighbours(&padded), LEAF, true, false);
        if levels(&wide) > TREE_DEPTH as u32 {
            wide = bvh2_to_cwbvh(&by_halves(&padded), LEAF, true, false);
        }
        let words: &[Words] = bytemuck::cast_slice(&wide.nodes);
        debug_assert_eq!(words.len(), NODE_WORDS * wide.nodes.len());
        let slots = wide.primitive_indices.iter().map(|i| with_area[*i as usize]).collect();
        Self { origin, nodes: words.to_vec(), slots, levels: levels(&wide) }
    }
}

/// A binary hierarchy of good quality and of any number of levels.
fn by_neighbours(padded: &[Padded]) -> Bvh2 {
    let params = BvhBuildParams::medium_build();
    let indices = (0..padded.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(padded.len()).build(
        params.ploc_search_distance,
        padded,
        indices,
        params.sort_precision,
        params.search_depth_threshold,
    );
    // The optimizer's stack has as many places as the default depth: a deeper hierarchy stays as it is.
    if binary.depth(0) < binary.max_depth {
        ReinsertionOptimizer::default().run(&mut binary, params.reinsertion_batch_ratio, None);
    }
    binary
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
        let middle = |i: &u32| padded[*i as usize].0.center();
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

/// How many nodes lie on the longest way from the root of a hierarchy to a leaf.
fn levels(boxes: &CwBvh) -> u32 {
    let (mut level, mut levels) = (vec![0], 0);
    while !level.is_empty() {
        levels += 1;
        let children = |&node: &u32| {
            let node = &boxes.nodes[node as usize];
            let inner = |child: &usize| !node.is_child_empty(*child) && !node.is_leaf(*child);
            (0..8).filter(inner).map(|child| node.child_node_index(child)).collect::<Vec<_>>()
        };
        level = level.iter().flat_map(children).collect();
    }
    levels
}
