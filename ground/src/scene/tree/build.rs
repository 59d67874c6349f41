//! Builds a [`Tree`] by the crate obvhs: first a binary hierarchy by PLOC with reinsertion, and from it the wide hierarchy.
//!
//! Many triangles in one place make a hierarchy with more levels than a walk has room for. Such a hierarchy is built again by
//! halving lists of triangles, which bounds its levels.

use super::boxes::{MAX_LEAF_TRIANGLES, PaddedBox, PaddedTriangles, build_ploc, levels, middle_and_extent};
use super::{
    BuildTrees, MAX_TRIANGLES, MovingTriangles, NODE_VECTORS, Tree, TriangleRecords, Words, most_levels, triangles,
};
use crate::error::{Error, Result};
use crate::scene::{Mesh, Placement, Scene};
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::{Bvh2Converter, bvh2_to_cwbvh};

impl Tree {
    /// Builds the tree over all triangles of a scene that have an area.
    ///
    /// # Errors
    /// [`Error::Usage`] for a scene with more triangles than have numbers.
    pub fn build(scene: &Scene) -> Result<Self> {
        check_count(scene)?;
        let corners: Vec<[DVec3; 3]> = triangles(scene).map(|(mesh, triangle)| corners_of(mesh, triangle)).collect();
        Ok(Self::over(&corners))
    }

    /// Builds the tree over the triangles of a list, in metres, that have an area.
    pub fn over(corners: &[[DVec3; 3]]) -> Self {
        Self::of_boxes(PaddedTriangles::new(corners.len(), |i| corners[i]))
    }

    /// Builds the tree over boxes: by halving lists if it would otherwise have more levels than [`most_levels`].
    fn of_boxes(PaddedTriangles { middle: origin, with_area, boxes }: PaddedTriangles) -> Self {
        if with_area.is_empty() {
            return Self { origin, ..Self::default() };
        }
        let mut wide = bvh2_to_cwbvh(&build_ploc(&boxes), MAX_LEAF_TRIANGLES, true, false);
        if levels(&wide) > most_levels(with_area.len()) {
            wide = build_balanced(&boxes);
        }
        let words: &[Words] = bytemuck::cast_slice(&wide.nodes);
        debug_assert_eq!(words.len(), NODE_VECTORS * wide.nodes.len());
        let slots = wide.primitive_indices.iter().map(|i| with_area[*i as usize]).collect();
        Self { origin, nodes: words.to_vec(), slots, levels: levels(&wide) }
    }
}

/// Builds the trees over a scene's triangles: one over the standing meshes, and a small one over the moving meshes.
pub struct Trees {
    /// The scene's meshes and materials.
    scene: Scene,
    /// The middle of the scene as it was made, from which both trees measure coordinates.
    middle: DVec3,
    /// The greatest coordinate of the scene from its middle.
    extent: f64,
}

impl Trees {
    /// Copies the meshes and materials of a scene.
    pub fn new(scene: &Scene) -> Self {
        let Scene { name, meshes, materials, .. } = scene;
        let scene =
            Scene { name: name.clone(), meshes: meshes.clone(), materials: materials.clone(), ..Scene::default() };
        let corners = || triangles(&scene).flat_map(|(mesh, triangle)| corners_of(mesh, triangle));
        let (middle, extent) = middle_and_extent(corners);
        Self { middle, extent, scene }
    }

    /// Builds the tree over the triangles of a list. The tree's slots are indices into the list.
    fn build_tree(&self, list: &[[DVec3; 3]]) -> Tree {
        let extent = list.iter().flatten().map(|p| (*p - self.middle).abs().max_element()).fold(self.extent, f64::max);
        Tree::of_boxes(PaddedTriangles::around(self.middle, extent, list.len(), |i| list[i]))
    }
}

impl BuildTrees for Trees {
    fn standing(&self, moving: &[&str]) -> Result<(Tree, TriangleRecords)> {
        check_count(&self.scene)?;
        let is_standing = |(_, (mesh, _)): &(u32, (&Mesh, [u32; 3]))| !moving.contains(&mesh.name.as_str());
        let numbered = (0..).zip(triangles(&self.scene)).filter(is_standing);
        let (numbers, list): (Vec<u32>, Vec<_>) = numbered.map(|(n, (mesh, t))| (n, corners_of(mesh, t))).unzip();
        let mut tree = self.build_tree(&list);
        tree.slots.iter_mut().for_each(|slot| *slot = numbers[*slot as usize]); // an index into `list` before
        let records = TriangleRecords::new(&self.scene, &tree);
        Ok((tree, records))
    }

    fn moving(&self, placed: &[(&str, Placement)]) -> Result<MovingTriangles> {
        let mut part = Scene { materials: self.scene.materials.clone(), ..Scene::default() };
        let mut numbers = Vec::new();
        let mut first = 0;
        for mesh in &self.scene.meshes {
            let end = first + mesh.indices.len() as u32 / 3;
            if let Some((_, placement)) = placed.iter().find(|(name, _)| *name == mesh.name) {
                let mut mesh = mesh.clone();
                mesh.place(placement);
                part.meshes.push(mesh);
                numbers.extend(first..end);
            }
            first = end;
        }
        let list: Vec<_> = triangles(&part).map(|(mesh, triangle)| corners_of(mesh, triangle)).collect();
        let mut tree = self.build_tree(&list);
        let mut records = TriangleRecords::new(&part, &tree);
        records.renumber(&numbers);
        tree.slots.iter_mut().for_each(|slot| *slot = numbers[*slot as usize]); // an index into `list` before
        Ok(MovingTriangles { tree, records, numbers })
    }
}

/// The corners of a triangle of a mesh in the world, in metres.
fn corners_of(mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|i| Vec3::from(mesh.vertices[i as usize].position).as_dvec3())
}

/// Refuses a scene with more triangles than have numbers.
fn check_count(scene: &Scene) -> Result<()> {
    let count = scene.triangle_count();
    if count > MAX_TRIANGLES {
        let name = &scene.name;
        return Err(Error::Usage(format!(
            "scene {name} has {count} triangles; rays are followed through at most {MAX_TRIANGLES}"
        )));
    }
    Ok(())
}

/// Builds a hierarchy with few levels. Each list of boxes is cut in half along the axis in which the middles of its boxes lie
/// farthest apart. Counts of boxes, and not areas, decide which boxes become one node of eight children.
fn build_balanced(padded: &[PaddedBox]) -> CwBvh {
    let mut indices: Vec<u32> = (0..padded.len() as u32).collect();
    // Two copies of the hierarchy: one with its boxes, and one with boxes whose areas are the counts.
    let mut nodes = [vec![Bvh2Node::default()], vec![Bvh2Node::default()]];
    let mut work = vec![(0_usize, 0..padded.len())];
    while let Some((node, range)) = work.pop() {
        let list = &mut indices[range.clone()];
        let aabb = list.iter().fold(Aabb::INVALID, |all, &i| all.union(&padded[i as usize].0));
        let counted = Aabb::new(Vec3A::ZERO, Vec3A::new(list.len() as f32, 1.0, 0.0));
        let first = nodes[0].len();
        // Sets the node in both copies: a leaf of `count` boxes, or, for 0, the parent of two nodes from `first` on.
        let mut set = |count: u32, first: usize| {
            for (nodes, aabb) in nodes.iter_mut().zip([aabb, counted]) {
                nodes[node] = Bvh2Node::new(aabb, count, first as u32);
                nodes.resize(nodes.len() + if count == 0 { 2 } else { 0 }, Bvh2Node::default());
            }
        };
        if list.len() == 1 {
            set(1, range.start);
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
        set(0, first);
        work.push((first, range.start..range.start + half));
        work.push((first + 1, range.start + half..range.end));
    }
    let [binary, counted] = nodes.map(|nodes| Bvh2 { nodes, primitive_indices: indices.clone(), ..Bvh2::default() });
    let mut by_counts = Bvh2Converter::new(&counted, false, false);
    by_counts.calculate_cost(MAX_LEAF_TRIANGLES);
    let mut converter = Bvh2Converter::new(&binary, true, false);
    converter.decisions = by_counts.decisions; // which boxes share a node
    converter.convert_to_cwbvh();
    let Bvh2Converter { nodes, primitive_indices, .. } = converter;
    CwBvh { nodes, primitive_indices, total_aabb: *binary.nodes[0].aabb(), ..CwBvh::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of a scene: some in one place, some on a line and some anywhere, of any size.
    fn boxes(count: usize) -> Vec<PaddedBox> {
        let unit = |n: usize, k: usize| ((n * 7919 + k * 104_729) % 1009) as f32 / 1009.0;
        let place = |n: usize| match n % 3 {
            0 => Vec3A::ZERO,
            1 => Vec3A::new(unit(n, 1).exp2(), 0.0, 0.0),
            _ => Vec3A::new(unit(n, 2), unit(n, 3), unit(n, 4)),
        };
        let size = |n: usize| 10.0_f32.powf(-4.0 * unit(n, 5));
        (0..count).map(|n| PaddedBox(Aabb::new(place(n) - size(n), place(n) + size(n)))).collect()
    }

    #[test]
    fn halves_bound_the_levels_of_trees_of_any_number_of_triangles() {
        for count in (1..=700).chain([1023, 1024, 1025, 4095, 4097, 8082, 32_769, 100_000]) {
            let wide = build_balanced(&boxes(count));
            assert!(levels(&wide) < most_levels(count), "{count} boxes: {} levels", levels(&wide));
            let mut found: Vec<u32> = wide.primitive_indices.clone();
            found.sort_unstable();
            assert!(found.into_iter().eq(0..count as u32), "{count}");
        }
    }
}
