//! Boxes of triangles, and hierarchies over them that the crate obvhs builds: for trees that shaders walk, and for
//! tests that compare this walk with one of their own.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::cwbvh::CwBvh;
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

/// How far boxes extend beyond their triangles, as a share of the greatest coordinate from the scene's middle. For rays
/// that begin about as far from the middle, the slab test in f32 errs by a few units of 6e-8.
const PADDING: f32 = 4e-6;

/// The most triangles of a leaf, for which compressed nodes have room.
pub const MAX_LEAF_TRIANGLES: u32 = 3;

/// A triangle's enlarged box.
pub struct PaddedBox(pub Aabb);

impl Boundable for PaddedBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// Triangles that have an area, measured from the middle of the bounds of all triangles.
pub struct PaddedTriangles {
    /// The middle from which boxes are measured, so that a scene far from the origin loses no precision.
    pub middle: DVec3,
    /// The numbers of the triangles that have an area. A triangle without an area is never hit, and many points in one place would
    /// make a deep hierarchy of equal boxes.
    pub with_area: Vec<u32>,
    /// The boxes of the triangles in `with_area`, in the same order.
    pub boxes: Vec<PaddedBox>,
}

impl PaddedTriangles {
    /// Makes the boxes of `count` triangles; `corners` returns the corners of the triangle of a number, in metres.
    pub fn new(count: usize, corners: impl Fn(usize) -> [DVec3; 3]) -> Self {
        let (middle, extent) = middle_and_extent(|| (0..count).flat_map(&corners));
        Self::around(middle, extent, count, corners)
    }

    /// Makes the boxes of triangles of a larger scene; `extent` is the scene's greatest coordinate from its `middle`.
    pub fn around(middle: DVec3, extent: f64, count: usize, corners: impl Fn(usize) -> [DVec3; 3]) -> Self {
        let padding = Vec3A::splat(PADDING * extent as f32);
        let has_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a) != DVec3::ZERO;
        let with_area: Vec<u32> = (0..count as u32).filter(|i| has_area(corners(*i as usize))).collect();
        let padded = |&i: &u32| {
            let [a, b, c] = corners(i as usize).map(|v| (v - middle).as_vec3a());
            // Vectors are passed as arrays, since obvhs may use another version of glam than this crate.
            let [low, high] = [a.min(b).min(c) - padding, a.max(b).max(c) + padding].map(|corner| corner.to_array());
            PaddedBox(Aabb::new(low.into(), high.into()))
        };
        let boxes = with_area.iter().map(padded).collect();
        Self { middle, with_area, boxes }
    }
}

/// Returns the middle of the bounds of some points, and how far the bounds reach from it along an axis; zeros for no points.
pub fn middle_and_extent<Points: Iterator<Item = DVec3>>(points: impl Fn() -> Points) -> (DVec3, f64) {
    let [low, high] = [points().reduce(DVec3::min), points().reduce(DVec3::max)].map(Option::unwrap_or_default);
    let middle = 0.5 * (low + high);
    (middle, (high - middle).max_element())
}

/// Builds a binary hierarchy of any number of levels by PLOC, which merges near boxes, and reinsertion.
pub fn build_ploc(padded: &[PaddedBox]) -> Bvh2 {
    let params = BvhBuildParams::medium_build();
    let indices = (0..padded.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(padded.len()).build(
        params.ploc_search_distance,
        padded,
        indices,
        params.sort_precision,
        params.search_depth_threshold,
    );
    // A deeper hierarchy is not optimized, since the optimizer's stack has only as many places as the default depth.
    if binary.depth(0) < binary.max_depth {
        ReinsertionOptimizer::default().run(&mut binary, params.reinsertion_batch_ratio, None);
    }
    binary
}

/// Returns how many nodes lie on the longest way from the root of a hierarchy to a leaf, counted level by level.
pub fn levels(boxes: &CwBvh) -> u32 {
    let (mut level, mut levels) = (vec![0], 0);
    while !level.is_empty() {
        levels += 1;
        let children = |&node: &u32| {
            let node = &boxes.nodes[node as usize];
            let is_inner = |child: &usize| !node.is_child_empty(*child) && !node.is_leaf(*child);
            (0..8).filter(is_inner).map(|child| node.child_node_index(child)).collect::<Vec<_>>()
        };
        level = level.iter().flat_map(children).collect();
    }
    levels
}
