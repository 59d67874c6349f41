//! A hierarchy of boxes over the triangles of a scene, as shaders walk it (`shaders-glsl/triangles/walk.glsl`), and the
//! records of its triangles, as plain data. Callers may make a [`Tree`] in any way. With the feature `tree`,
//! [`Tree::build`] makes one by the crate obvhs, which is no dependency otherwise.
//!
//! The nodes are the compressed wide nodes of Ylitie, Karras and Laine ("Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs", HPG 2017): eight children in 80 bytes.

#[cfg(feature = "tree")]
pub mod boxes;
#[cfg(feature = "tree")]
mod build;

#[cfg(feature = "tree")]
pub use build::Trees;

use super::{Material, Mesh, Placement, Scene, Vertex};
use crate::error::Result;
use crate::math::constants::{ASKS_MATERIAL, NO_TRIANGLE, TREE_DEPTH};
use glam::{DVec3, Vec2, Vec3};

/// Four words of a record, as shaders load them.
pub type Words = [u32; 4];

/// Number of vectors of four words in a node.
pub const NODE_VECTORS: usize = 5;

/// The most triangles of a scene: numbers of triangles leave the highest bit free, and the greatest means no triangle.
pub const MAX_TRIANGLES: usize = (ASKS_MATERIAL - 1) as usize;

/// The hierarchy of boxes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tree {
    /// The place in the world, in metres, from which all coordinates are measured: the middle of the scene, so that a scene far
    /// from the origin loses no precision.
    pub origin: DVec3,
    /// [`NODE_VECTORS`] vectors for each node, in the layout of [`obvhs`](https://docs.rs/obvhs)'s `CwBvhNode`. The
    /// first node is the root. Empty if no triangle has an area.
    pub nodes: Vec<Words>,
    /// The number of the triangle in each slot that nodes refer to: triangles are counted over all meshes in their order.
    pub slots: Vec<u32>,
    /// Number of nodes on the longest way from the root to a leaf, at most [`most_levels`] for the tree's triangles.
    pub levels: u32,
}

impl Tree {
    /// Whether the tree has at most [`most_levels`] levels, for which walks have room.
    pub fn is_walkable(&self) -> bool {
        self.levels <= most_levels(self.slots.len())
    }

    /// Bytes of nodes and slots.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.slots.as_slice())
    }
}

/// Returns the most levels that a tree over so many triangles may have, for which walks have room. They are six more
/// than in a full tree with eight children a node, which suffices for the built-in scenes and Sponza. A tree that would
/// have more is built by halving lists of its triangles: it has fewer levels, but a ray's walk takes up to twice as long.
pub fn most_levels(triangles: usize) -> u32 {
    let binary = triangles.max(1).next_power_of_two().ilog2();
    (binary.div_ceil(3) + 6).min(TREE_DEPTH as u32)
}

/// The triangles of a scene as shaders read them, in the order of a tree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleRecords {
    /// Three vectors for each slot: the corners of a triangle, measured from the tree's origin. The last word of the first vector
    /// is the triangle's number, with [`ASKS_MATERIAL`] if the material has an alpha mask or is single-sided. The last word of the
    /// second is twice its area.
    pub corners: Vec<Words>,
    /// Four vectors for each triangle, by its number, from which a hit's colour is made (`shaders-glsl/triangles/scene.glsl`). The
    /// last word of the third is the triangle's slot, or [`NO_TRIANGLE`].
    pub attributes: Vec<Words>,
}

impl TriangleRecords {
    /// The records of a scene's triangles.
    pub fn new(scene: &Scene, tree: &Tree) -> Self {
        let mut attributes = Vec::with_capacity(4 * scene.triangle_count());
        let mut corners_and_flags = Vec::with_capacity(scene.triangle_count());
        for (mesh, triangle) in triangles(scene) {
            let vertices = triangle.map(|i| &mesh.vertices[i as usize]);
            attributes.extend(attributes_of(mesh, vertices));
            let material = &scene.materials[mesh.material];
            let flag = if may_reject_hit(material) { ASKS_MATERIAL } else { 0 };
            corners_and_flags.push((vertices.map(|v| from_origin(v, tree.origin)), flag));
        }
        let mut corners = Vec::with_capacity(3 * tree.slots.len());
        for (slot, &triangle) in tree.slots.iter().enumerate() {
            let ([a, b, c], flag) = corners_and_flags[triangle as usize];
            let area = doubled_area([a, b, c].map(Vec3::as_dvec3));
            corners.push(words(a, triangle | flag));
            corners.push(words(b, (area as f32).to_bits()));
            corners.push(words(c, 0));
            attributes[4 * triangle as usize + 2][3] = slot as u32;
        }
        Self { corners, attributes }
    }
}

/// The triangles of meshes that move, in a small tree that is built anew whenever a mesh has moved. A walk goes through this tree
/// and through the tree of standing meshes, and both measure coordinates from the same place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MovingTriangles {
    /// The tree. The tree's slots hold numbers among all triangles of the scene.
    pub tree: Tree,
    /// Corners with numbers among all triangles of the scene; attributes in the order of `numbers`.
    pub records: TriangleRecords,
    /// The numbers of all moving triangles, including those without an area.
    pub numbers: Vec<u32>,
}

/// A builder of the trees over a scene's triangles.
pub trait BuildTrees {
    /// Builds the tree over all meshes except those of some names, with [`most_levels`] at most, and records with the attributes of
    /// all triangles.
    ///
    /// # Errors
    /// [`Usage`](crate::error::Error::Usage) for a scene with more triangles than have numbers.
    fn standing(&self, moving: &[&str]) -> Result<(Tree, TriangleRecords)>;

    /// Builds the tree over the meshes of some names, each where it stands, with [`most_levels`] at most.
    ///
    /// # Errors
    /// Errors of the builder.
    fn moving(&self, placed: &[(&str, Placement)]) -> Result<MovingTriangles>;
}

impl Tree {
    /// Returns the nodes with raised indices, for a buffer in which `nodes` other nodes and `slots` other slots come first.
    pub fn nodes_after(&self, nodes: u32, slots: u32) -> Vec<Words> {
        let mut raised = self.nodes.clone();
        // The second vector of a node begins with the indices of its first child and of its first slot.
        for vector in raised.iter_mut().skip(1).step_by(NODE_VECTORS) {
            vector[0] = vector[0].wrapping_add(nodes);
            vector[1] = vector[1].wrapping_add(slots);
        }
        raised
    }
}

impl MovingTriangles {
    /// Returns the attributes of the moving triangles for a buffer in which the corners of `slots` other slots come first.
    /// Triangles with consecutive numbers are one run: the run's first number, and its vectors.
    pub fn attributes_after(&self, slots: u32) -> Vec<(u32, Vec<Words>)> {
        let mut runs: Vec<(u32, Vec<Words>)> = Vec::new();
        for (number, attributes) in self.numbers.iter().zip(self.records.attributes.as_chunks::<4>().0) {
            let mut raised = *attributes;
            if raised[2][3] != NO_SLOT {
                raised[2][3] += slots;
            }
            match runs.last_mut() {
                Some((first, run)) if *first + run.len() as u32 / 4 == *number => run.extend(raised),
                _ => runs.push((*number, raised.to_vec())),
            }
        }
        runs
    }
}

impl TriangleRecords {
    /// Replaces the number n of each triangle in `corners` by `numbers[n]`.
    #[cfg(feature = "tree")]
    fn renumber(&mut self, numbers: &[u32]) {
        for first in self.corners.iter_mut().step_by(3) {
            let flag = first[3] & ASKS_MATERIAL;
            first[3] = numbers[(first[3] & !ASKS_MATERIAL) as usize] | flag;
        }
    }

    /// Whether some material has an alpha mask or is single-sided, so that a hit on its triangles may not count.
    pub fn may_reject_hits(&self) -> bool {
        self.corners.iter().step_by(3).any(|[.., number]| number & ASKS_MATERIAL != 0)
    }

    /// Returns the greatest absolute value of a corner's coordinates from the tree's origin, in metres.
    pub fn extent_m(&self) -> f32 {
        let coordinates = self.corners.iter().flat_map(|[x, y, z, _]| [x, y, z]);
        coordinates.map(|bits| f32::from_bits(*bits).abs()).fold(0.0, f32::max)
    }
}

/// Every triangle of a scene, in the order of their numbers: its mesh and the indices of its vertices there.
pub fn triangles(scene: &Scene) -> impl Iterator<Item = (&Mesh, [u32; 3])> {
    scene.meshes.iter().flat_map(|mesh| mesh.indices.as_chunks::<3>().0.iter().map(move |t| (mesh, *t)))
}

/// Whether a hit on a material may not count: where its alpha mask has a hole, or from behind a single-sided surface.
fn may_reject_hit(material: &Material) -> bool {
    material.alpha_mask.is_some() || material.single_sided
}

/// Returns a corner relative to a tree's origin, by a difference in f64.
fn from_origin(vertex: &Vertex, origin: DVec3) -> Vec3 {
    (Vec3::from(vertex.position).as_dvec3() - origin).as_vec3()
}

/// Returns the bits of a vector's coordinates in three words, and a last word.
fn words(v: Vec3, last: u32) -> Words {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), last]
}

/// The word that a record has in place of a slot if its triangle has no area, and thus no slot.
const NO_SLOT: u32 = NO_TRIANGLE;

/// Packs a triangle's normals, material, texture coordinates, repeats and tangents for [`TriangleRecords::attributes`].
fn attributes_of(mesh: &Mesh, vertices: [&Vertex; 3]) -> [Words; 4] {
    let uv = vertices.map(|v| Vec2::from(v.uv));
    // How often a map repeats in a metre along the surface: the square root of area in the map over area in metres.
    let area = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
    let corners = vertices.map(|v| Vec3::from(v.position).as_dvec3());
    let repeats = (f64::from(area) / doubled_area(corners).max(f64::MIN_POSITIVE)).sqrt() as f32;
    let repeats = if repeats.is_finite() { repeats } else { 0.0 };
    let normals = vertices.map(|v| packed_unit_vector(v.normal.into()));
    let tangents = vertices.map(|v| packed_unit_vector(Vec3::from_slice(&v.tangent[..3])));
    let handedness = if vertices[0].tangent[3] < 0.0 { 1 << 31 } else { 0 };
    let bits = f32::to_bits;
    [
        [normals[0], normals[1], normals[2], mesh.material as u32 | handedness],
        [bits(uv[0].x), bits(uv[0].y), bits(uv[1].x), bits(uv[1].y)],
        [bits(uv[2].x), bits(uv[2].y), bits(repeats), NO_SLOT],
        [tangents[0], tangents[1], tangents[2], 0],
    ]
}

fn doubled_area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length()
}

/// Packs a unit vector into three signed numbers of ten bits (`UnpackUnitVector` of `triangles/color.glsl` unpacks it).
fn packed_unit_vector(v: Vec3) -> u32 {
    let ten_bits = |a: f32| ((a.clamp(-1.0, 1.0) * 511.0).round() as i32).cast_unsigned() & 0x3ff;
    ten_bits(v.x) | ten_bits(v.y) << 10 | ten_bits(v.z) << 20
}
