//! The CPU twin of `shaders-glsl/triangles/walk.glsl`: the walk of a ray through a tree of triangles, and the test of
//! one triangle, operation for operation in 32-bit floats. Comments in the shader give the reasons of each step.
//!
//! A group of nodes or triangles is two words: the number of the first one, and a mask with a bit for each one that the
//! ray has still to look at.

use glam::Vec3;
use ssct_ground::math::constants::{ASKS_MATERIAL, NEVER, NO_TRIANGLE, ROUNDING, TREE_DEPTH};
use ssct_scenes::tree::{MovingTriangles, NODE_VECTORS, Tree, TriangleRecords, Words};
use std::borrow::Cow;

/// The triangle that a ray meets, with the place of the hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Metres along the ray's unit direction.
    pub t: f32,
    /// Number of the triangle, with the bit `ASKS_MATERIAL` if its material says whether the ray passes; `NO_TRIANGLE`
    /// for none.
    pub id: u32,
    /// Weights of the triangle's second and third corner.
    pub weight: [f32; 2],
}

impl TriangleHit {
    const NO_HIT: Self = Self { t: NEVER as f32, id: NO_TRIANGLE, weight: [0.0; 2] };

    /// Returns the number of the triangle without the bit `ASKS_MATERIAL`; `None` if the ray meets nothing.
    pub fn triangle(&self) -> Option<u32> {
        (self.id != NO_TRIANGLE).then_some(self.id & !ASKS_MATERIAL)
    }
}

/// A ray in the coordinates of a tree.
#[derive(Debug, Clone, Copy)]
pub struct TreeRay {
    /// Start, in metres from the tree's origin.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// The number, in the record, of the triangle that the ray begins on and cannot meet; `NO_TRIANGLE` for none.
    pub own_triangle: u32,
}

/// A scene's triangles, for rays that are traced as in the shaders.
pub struct TriangleWalk<'a> {
    /// [`NODE_VECTORS`] vectors for each node, as in [`Tree::nodes`].
    nodes: Cow<'a, [Words]>,
    /// Number of the root of the tree of moving triangles, which follows the other nodes; `None` without such a tree.
    moving: Option<u32>,
    /// Three vectors for each triangle, as in [`TriangleRecords::corners`].
    corners: Cow<'a, [Words]>,
    /// Greatest absolute value of a corner's coordinates from the tree's origin, in metres.
    extent: f32,
}

/// Returns the scalar product, whose terms are added in the shader's order.
fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Returns the vector product, by the shader's operations.
fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Returns the point whose coordinates are the first three words, as bits of floats.
fn corner(words: &Words) -> Vec3 {
    Vec3::from_array([words[0], words[1], words[2]].map(f32::from_bits))
}

/// Returns byte `i` of a word, counted from the lowest.
fn byte(word: u32, i: u32) -> u32 {
    word >> (8 * i) & 0xff
}

impl<'a> TriangleWalk<'a> {
    /// Prepares walks over a tree and the records of its triangles.
    pub fn new(tree: &'a Tree, records: &'a TriangleRecords) -> Self {
        let (nodes, corners) = (Cow::from(&tree.nodes), Cow::from(&records.corners));
        Self { nodes, moving: None, corners, extent: records.extent_m() }
    }

    /// Appends a tree of moving triangles, which walks then visit, too.
    #[must_use]
    pub fn with_moving(mut self, moving: &MovingTriangles) -> Self {
        let (root, slots) = ((self.nodes.len() / NODE_VECTORS) as u32, (self.corners.len() / 3) as u32);
        self.nodes.to_mut().extend(moving.tree.nodes_after(root, slots));
        self.corners.to_mut().extend_from_slice(&moving.records.corners);
        self.moving = (!moving.tree.nodes.is_empty()).then_some(root);
        self.extent = self.extent.max(moving.records.extent_m());
        self
    }

    /// Returns the nearest triangle that a ray meets, and the greatest number of groups of nodes that were on the
    /// walk's stack.
    pub fn traverse_tree(&self, ray: &TreeRay) -> (TriangleHit, usize) {
        let mut best = TriangleHit::NO_HIT;
        let mut stack: Vec<[u32; 2]> = Vec::with_capacity(TREE_DEPTH as usize);
        let mut most_groups = 0;
        // Components that are nearly 0 get a tiny value, so that the inverse is finite. This changes the test of no
        // box.
        let direction = Vec3::from_array(ray.direction.to_array().map(|d| if d.abs() < 1e-20 { 1e-20 } else { d }));
        let inverse = 1.0 / direction;
        let is_negative = direction.to_array().map(|d| d < 0.0);
        // For each axis along which the ray does not run back, a bit in each byte of the word. An exclusive or with it
        // turns the places of four children into the order in which the ray should look at them.
        let axis_bits = [0x0404_0404, 0x0202_0202, 0x0101_0101];
        let octant = axis_bits
            .iter()
            .zip(is_negative)
            .filter(|(_, runs_back)| !runs_back)
            .fold(0, |octant_bits, (bits, _)| octant_bits | bits);
        // The tree of the triangles that do not move has the first nodes. Without such triangles there is no such tree.
        let has_still_tree = self.moving.map_or(!self.nodes.is_empty(), |root| root > 0);
        // A group of nodes: the first child's number, and a mask. Its upper 8 bits are the children still to be looked
        // at, and its lower 8 bits say which children are nodes. The mask 0x8000_0000 stands for one root alone.
        let mut group = [0, if has_still_tree { 0x8000_0000 } else { 0 }];
        stack.extend(self.moving.map(|root| [root, 0x8000_0000]));
        loop {
            // A group of triangles: the first one's slot, and a mask of the triangles still to be tested.
            let mut leaves = [0; 2];
            if group[1] & 0xff00_0000 != 0 {
                let bits: u32 = group[1];
                let bit = 31 - bits.leading_zeros();
                group[1] &= !(1 << bit);
                if group[1] & 0xff00_0000 != 0 {
                    stack.push(group);
                    most_groups = most_groups.max(stack.len());
                }
                // The child's place in the node; the node's number follows from the count of child nodes at lower
                // places.
                let child = (bit - 24) ^ (octant & 0xff);
                let node = group[0] + (bits & !(0xffff_ffff << child)).count_ones();
                let (inner, hits, bases) =
                    self.intersect_children(node, ray.origin, inverse, is_negative, octant, best.t);
                group = [bases[0], hits & 0xff00_0000 | inner];
                leaves = [bases[1], hits & 0x00ff_ffff];
            }
            while leaves[1] != 0 {
                let bit = 31 - leaves[1].leading_zeros();
                leaves[1] &= !(1 << bit);
                self.update_nearest_hit(ray, (leaves[0] + bit) as usize, &mut best);
            }
            if group[1] & 0xff00_0000 == 0 {
                let Some(next) = stack.pop() else { return (best, most_groups) };
                group = next;
            }
        }
    }

    /// Intersects the children of a node. `is_negative` says for each axis whether the ray runs back, `octant` is the
    /// word that [`Self::traverse_tree`] makes of it, and `nearest` is the t of the nearest hit so far. Returns a mask
    /// of the children that are nodes, a mask of the children that the ray meets before `nearest`, and the numbers of
    /// the first child node and the first triangle. In the second mask, nodes have the upper 8 bits and triangles the
    /// lower 24.
    fn intersect_children(
        &self,
        node: u32,
        origin: Vec3,
        inverse: Vec3,
        is_negative: [bool; 3],
        octant: u32,
        nearest: f32,
    ) -> (u32, u32, [u32; 2]) {
        let first = NODE_VECTORS * node as usize;
        let [head, kinds, mut sides @ ..]: [Words; NODE_VECTORS] = std::array::from_fn(|i| self.nodes[first + i]);
        // Each axis has the low sides of children 0 to 3 and 4 to 7, then the high sides. The side that the ray meets
        // first is moved to the front.
        for (side, is_negative) in sides.iter_mut().zip(is_negative) {
            if is_negative {
                *side = [side[2], side[3], side[0], side[1]];
            }
        }
        // Boxes are whole numbers of bytes times a power of two, whose exponent is a byte of the head, from the node's
        // corner.
        let scale = Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(byte(head[3], i) << 23)));
        let (step, base) = (scale * inverse, (corner(&head) - origin) * inverse);
        let mut hits = 0;
        for half in 0..2 {
            // A byte for each child: its place in the mask in the lower 5 bits, and its bits in the mask in the upper
            // 3.
            let meta = kinds[2 + half];
            let inner = ((meta & meta << 1 & 0x1010_1010) >> 4) * 0xff;
            let places = (meta ^ octant & inner) & 0x1f1f_1f1f;
            let bits = meta >> 5 & 0x0707_0707;
            for i in 0..4 {
                let planes = |k: usize| Vec3::from_array(sides.map(|side| byte(side[k], i) as f32));
                let (near, far) = (planes(half) * step + base, planes(2 + half) * step + base);
                let entry = near.max_element().max(0.0);
                let exit = far.min_element().min(nearest);
                hits |= if entry <= exit { byte(bits, i) << byte(places, i) } else { 0 };
            }
        }
        (head[3] >> 24, hits, [kinds[0], kinds[1]])
    }

    /// Returns the nearest triangle that a ray meets, found by testing all triangles.
    pub fn nearest_of_all(&self, ray: &TreeRay) -> TriangleHit {
        let mut best = TriangleHit::NO_HIT;
        (0..self.corners.len() / 3).for_each(|slot| self.update_nearest_hit(ray, slot, &mut best));
        best
    }

    /// Tests the triangle of a slot, and makes its hit the best one if the ray meets the triangle and the hit is nearer
    /// than the best one so far. Of equally near hits, the one with the smaller number counts. `walk.glsl` gives the
    /// reason of each test.
    fn update_nearest_hit(&self, ray: &TreeRay, slot: usize, best: &mut TriangleHit) {
        let words = &self.corners[3 * slot..3 * slot + 3];
        let [a, b, c] = [0, 1, 2].map(|k| corner(&words[k]) - ray.origin);
        let direction = ray.direction;
        // The edge functions of the three edges, which have one sign if the ray passes between them.
        let [u, v, w] = [dot(direction, cross(c, b)), dot(direction, cross(a, c)), dot(direction, cross(b, a))];
        let area = u + v + w;
        let inverse = 1.0 / area;
        let scaled_t = u * dot(direction, a) + v * dot(direction, b) + w * dot(direction, c);
        let t = scaled_t * inverse;
        let (id, double_area) = (words[0][3], f32::from_bits(words[1][3]));
        let scaled_distance = if area < 0.0 { -scaled_t } else { scaled_t };
        let is_hit = (u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0)
            && area != 0.0
            && scaled_distance > 12.0 * ROUNDING as f32 * self.extent * double_area
            && id != ray.own_triangle;
        let is_nearer = t < best.t || (t == best.t && id < best.id);
        if is_hit && is_nearer && t > 0.0 {
            *best = TriangleHit { t, id, weight: [v * inverse, w * inverse] };
        }
    }
}

#[cfg(test)]
#[path = "triangles/tests.rs"]
mod tests;
