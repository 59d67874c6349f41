//! A second traversal, which uses a pyramid to find the oracle's hits in a tenth of the steps (docs/numerics.md, "What
//! a robust method does", items 2 to 4). The Monte Carlo reference uses it. The traversal's agreement with
//! [`super::oracle`] is evidence for both; the two share only the set-up of rays and the pixels' blocks, which have
//! tests of their own.
//!
//! At every image size, a cell of level l covers exactly the pixels whose indices, shifted right by l, equal the cell's
//! index. The cell stores the interval of reversed depth from the farthest back to the nearest front of its pixels'
//! blocks. The ray's depth over a cell is an interval, too, whichever way the ray runs. If the two intervals do not
//! meet, the ray passes the whole cell in one step. The bounds stay conservative under rounding because depths and
//! crossings are monotonic expressions that are evaluated at the same boundaries on every level.
//!
//! The parameter s of a ray runs from 0 at its start to 1 at its end ([`Segment`]).

use super::Level;
use super::ray::{Outcome, RaySetup, Segment, Trace};
use super::thickness::{self, DepthBlock, JOINED};
use glam::DVec3;
use ssct_ground::math::OracleVersion;
use ssct_scenes::GBufferData;

/// The pyramid of a G-buffer, over which rays are traced.
#[derive(Debug, Clone)]
pub struct Hierarchy<'a> {
    rays: RaySetup<'a>,
    /// Level 0 has one cell per pixel, the last level has a single cell.
    levels: Vec<Level<DepthBlock>>,
    version: OracleVersion,
}

impl<'a> Hierarchy<'a> {
    /// Builds the pyramid of a G-buffer. Rays hit by version 1 of the oracle until [`Self::of_version`] says otherwise.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        let levels = std::iter::successors(Some(thickness::blocks(gbuffer)), coarser).collect();
        Self { rays: RaySetup::new(gbuffer), levels, version: OracleVersion::V1 }
    }

    /// Returns the same pyramid, over which rays hit by the rules of the given version of the oracle.
    pub fn of_version(self, version: OracleVersion) -> Self {
        Self { version, ..self }
    }

    /// Returns the set-up of rays for the same G-buffer.
    pub fn rays(&self) -> &RaySetup<'a> {
        &self.rays
    }

    /// Traces the mirror ray of the pixel (x, y).
    pub fn trace(&self, x: u32, y: u32) -> Trace {
        self.rays.mirror(x, y).map_or(Trace::NO_RAY, |direction| self.trace_direction(x, y, direction))
    }

    /// Traces a ray from the centre of the pixel (x, y), at the pixel's own depth, along a view-space direction of any
    /// length.
    pub fn trace_direction(&self, x: u32, y: u32, direction: DVec3) -> Trace {
        self.rays.segment(x, y, direction).map_or(Trace::NO_RAY, |segment| self.trace_segment(&segment))
    }

    /// Traces a segment that begins on the screen, from cell to cell. The walk goes down a level where the ray may meet
    /// a block, and up a level where the ray left the parent cell.
    pub fn trace_segment(&self, segment: &Segment) -> Trace {
        let sides = [self.levels[0].width, self.levels[0].height];
        // The walks along x and along y; their pixels are the column and the row in which the ray is.
        let mut walks = [0, 1].map(|axis| AxisWalk::new(segment, axis, sides[axis]));
        let mut steps = 0;
        // The parameter s of the ray where it enters the current cell. The starting pixel is left without being tested.
        let mut entry = walks[0].exit(0).min(walks[1].exit(0));
        if entry >= 1.0 {
            return self.miss(&walks, segment, 1.0, steps);
        }
        for walk in &mut walks {
            walk.advance(entry);
        }
        let first_entry = entry;
        let mut level = 0;
        loop {
            let Some(cell) = self.cell(&walks, level) else {
                return self.miss(&walks, segment, entry, steps);
            };
            steps += 1;
            let exit = walks[0].exit(level).min(walks[1].exit(level));
            // The ray's reversed depths over the cell; the greater one is nearer.
            let (near, far) = {
                let (at_entry, at_exit) = (segment.depth_at(entry), segment.depth_at(exit.min(1.0)));
                if at_entry > at_exit { (at_entry, at_exit) } else { (at_exit, at_entry) }
            };
            // Version 2 lets the ray pass the first pixel, if that may show the surface that the ray is leaving.
            let (is_version_2, is_first) = (self.version == OracleVersion::V2, entry == first_entry);
            let leaves_surface = is_version_2 && is_first && self.inward_cosine(&walks, segment) < 0.0;
            if far <= cell.front && near >= cell.back && !leaves_surface {
                if level > 0 {
                    level -= 1;
                    continue;
                }
                if is_version_2 && !is_first && self.is_behind(&walks, segment, entry, cell) {
                    return Trace { outcome: Outcome::Miss { reason: segment.end, behind: true }, steps };
                }
                return Trace { outcome: hit(segment, &walks, cell.front, [entry, exit.min(1.0)], [near, far]), steps };
            }
            if exit >= 1.0 {
                return self.miss(&walks, segment, 1.0, steps);
            }
            let parent = walks.map(|walk| walk.pixel >> (level + 1));
            for walk in &mut walks {
                walk.advance(exit);
            }
            entry = exit;
            let left_parent = parent != walks.map(|walk| walk.pixel >> (level + 1));
            if left_parent && level + 1 < self.levels.len() {
                level += 1;
            }
        }
    }

    /// Returns the depth interval of the cell of a level that contains the current pixel; `None` off screen.
    fn cell(&self, walks: &[AxisWalk; 2], level: usize) -> Option<DepthBlock> {
        let [x, y] = walks.map(|walk| u32::try_from(walk.pixel).ok());
        let (x, y, finest) = (x?, y?, &self.levels[0]);
        (x < finest.width && y < finest.height).then(|| {
            let cells = &self.levels[level];
            cells.texels[(y >> level) as usize * cells.width as usize + (x >> level) as usize]
        })
    }

    /// Returns the cosine of the angle between a ray and the reversed normal of the current pixel. The cosine is
    /// negative if the ray runs away from the surface, and 0 without a normal.
    fn inward_cosine(&self, walks: &[AxisWalk; 2], segment: &Segment) -> f64 {
        let [x, y] = walks.map(|walk| walk.pixel as u32);
        segment.direction.dot(-self.rays.normal(x, y).unwrap_or(DVec3::ZERO))
    }

    /// Returns whether a ray that enters the current pixel at s = `entry` comes from behind the pixel's block, by
    /// version 2 of the oracle ([`super::oracle`]). It does if it was behind the front of the previous pixel's block.
    /// At an edge between two surfaces, it also does if it is deeper in the block than the thickness times the cosine
    /// between ray and reversed normal.
    fn is_behind(&self, walks: &[AxisWalk; 2], segment: &Segment, entry: f64, block: DepthBlock) -> bool {
        let entry_depth = segment.depth_at(entry);
        let previous = self.cell(&walks.map(|walk| walk.just_before(entry)), 0).unwrap_or(DepthBlock::EMPTY);
        let is_edge = block.front - previous.front > JOINED * (block.thickness() + previous.thickness());
        let is_deep = block.front - entry_depth > self.inward_cosine(walks, segment).max(0.0) * block.thickness();
        entry_depth < block.front && (entry_depth < previous.front || (is_edge && is_deep))
    }

    /// Returns the miss of a ray that ends at the parameter s. The reason is the frustum's side at which the segment
    /// ends. The flag `behind` is set if the ray ends behind the block of the pixel in which it is just before s.
    fn miss(&self, walks: &[AxisWalk; 2], segment: &Segment, s: f64, steps: u32) -> Trace {
        let last = walks.map(|walk| walk.just_before(s));
        let behind =
            self.cell(&last, 0).is_some_and(|block| block.front >= block.back && segment.depth_at(s) < block.back);
        Trace { outcome: Outcome::Miss { reason: segment.end, behind }, steps }
    }
}

/// Returns the next coarser level, with half the width and height, rounded up; `None` if the level has a single cell.
fn coarser(finer: &Level<DepthBlock>) -> Option<Level<DepthBlock>> {
    let half = |side: u32| side.div_ceil(2);
    (finer.width > 1 || finer.height > 1).then(|| {
        Level::from_fn(half(finer.width), half(finer.height), |x, y| {
            // At an odd edge the same block counts twice, which does not change the union.
            let blocks = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| finer.at_clamped(2 * x + dx, 2 * y + dy));
            blocks.into_iter().fold(DepthBlock::EMPTY, DepthBlock::union)
        })
    })
}

/// Returns the hit of a ray in the current pixel, whose block has the given front. The ray is in the pixel from s =
/// `entry` to s = `exit`, and its reversed depth is there between `far` and `near`. The hit lies where the ray crosses
/// the front, or at the entry if the ray does not cross it in the pixel.
fn hit(
    segment: &Segment,
    walks: &[AxisWalk; 2],
    front: f64,
    [entry, exit]: [f64; 2],
    [near, far]: [f64; 2],
) -> Outcome {
    let s = if far <= front && front <= near && near > far {
        ((front - segment.start.z) / segment.delta.z).max(entry).min(exit)
    } else {
        entry
    };
    Outcome::Hit { pixel: walks.map(|walk| walk.pixel as u32), position: segment.point_at(s) }
}

/// The walk of a ray along one axis of the image.
#[derive(Debug, Clone, Copy)]
struct AxisWalk<'s> {
    segment: &'s Segment,
    axis: usize,
    /// 1, −1, or 0 if the ray does not move along this axis.
    direction: i32,
    /// The column (or row) in which the ray begins.
    first: i32,
    /// The column (or row) in which the ray is now.
    pixel: i32,
    /// The number of pixels along this axis.
    side: i32,
}

impl<'s> AxisWalk<'s> {
    /// Begins the walk at the start of a segment, along axis 0 (x) or 1 (y) of an image with `side` pixels along this
    /// axis.
    fn new(segment: &'s Segment, axis: usize, side: u32) -> Self {
        let delta = segment.delta[axis];
        let first = segment.start[axis].floor() as i32;
        let direction = i32::from(delta > 0.0) - i32::from(delta < 0.0);
        Self { segment, axis, direction, first, pixel: first, side: side as i32 }
    }

    /// Returns the ray's parameter s where it leaves the cell of the given level that contains the current pixel. The
    /// last cell may extend beyond the screen. The ray leaves it at the screen's edge, where it also ends but for
    /// rounding.
    fn exit(&self, level: usize) -> f64 {
        let cell = self.pixel >> level;
        let cell_after_boundary = if self.direction > 0 { cell + 1 } else { cell };
        self.crossing((cell_after_boundary << level).min(self.side))
    }

    /// Returns the ray's parameter s where it crosses the boundary before column (or row) `boundary`.
    fn crossing(&self, boundary: i32) -> f64 {
        self.segment.crossing(self.axis, boundary)
    }

    /// Advances to the column (or row) in which the ray is just after the parameter s, past every boundary that it
    /// crosses at s or before.
    fn advance(&mut self, s: f64) {
        self.pixel = self.pixel_at(s, |crossing| crossing <= s);
    }

    /// Returns the walk at the column (or row) in which the ray is just before the parameter s, past every boundary
    /// that it crosses before s.
    fn just_before(&self, s: f64) -> Self {
        Self { pixel: self.pixel_at(s, |crossing| crossing < s), ..*self }
    }

    /// Returns the column (or row) that the ray has reached near the parameter s. `is_crossed` gets the parameter of a
    /// boundary and says whether the ray is past it. The position at s gives a first guess. The two loops correct it,
    /// so that the result does not depend on the rounding of the position.
    fn pixel_at(&self, s: f64, is_crossed: impl Fn(f64) -> bool) -> i32 {
        if self.direction == 0 {
            return self.first;
        }
        let mut pixel = self.segment.point_at(s)[self.axis].floor() as i32;
        // Offsets from a pixel to the boundaries at which the ray leaves it and at which it entered it.
        let (ahead, behind) = if self.direction > 0 { (1, 0) } else { (0, 1) };
        while is_crossed(self.crossing(pixel + ahead)) {
            pixel += self.direction;
        }
        while pixel != self.first && !is_crossed(self.crossing(pixel + behind)) {
            pixel -= self.direction;
        }
        pixel
    }
}

mod ties;

#[cfg(test)]
mod tests;
