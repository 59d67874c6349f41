//! A second traversal, which uses a pyramid to find the oracle's hits in a tenth of the steps (docs/numerics.md, "What a robust
//! method does", items 2 to 4). The Monte Carlo reference uses it. The traversal's agreement with [`super::oracle`] is evidence
//! for both; the two share only the set-up of rays and the pixels' blocks, which have tests of their own.
//!
//! At every image size, a cell of level l covers exactly the pixels whose indices, shifted right by l, equal the cell's index.
//! The cell stores the interval from the farthest back to the nearest front of their blocks. The ray's depth over a cell is an
//! interval too, whichever way the ray runs. If the two intervals do not meet, the ray passes the whole cell in one step. The
//! bounds stay conservative under rounding because depths and crossings are monotonic expressions that are evaluated at the
//! same boundaries on every level.

use super::Level;
use super::ray::{Outcome, RaySetup, Segment, Trace};
use super::thickness::{self, DepthBlock, JOINED};
use glam::DVec3;
use ssct_ground::math::OracleVersion;
use ssct_scenes::GBufferData;

/// The pyramid of a G-buffer.
#[derive(Debug, Clone)]
pub struct Hierarchy<'a> {
    rays: RaySetup<'a>,
    /// Level 0 has one cell per pixel, the last level has a single cell.
    levels: Vec<Level<DepthBlock>>,
    version: OracleVersion,
}

impl<'a> Hierarchy<'a> {
    /// Builds the pyramid. Traversals follow version 1 of the oracle.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        let levels = std::iter::successors(Some(thickness::blocks(gbuffer)), coarser).collect();
        Self { rays: RaySetup::new(gbuffer), levels, version: OracleVersion::V1 }
    }

    /// Makes traversals follow a version of the oracle.
    pub fn of_version(self, version: OracleVersion) -> Self {
        Self { version, ..self }
    }

    /// The set-up of rays for the same G-buffer.
    pub fn rays(&self) -> &RaySetup<'a> {
        &self.rays
    }

    /// Traces the mirror ray of a pixel.
    pub fn trace(&self, x: u32, y: u32) -> Trace {
        self.rays.mirror(x, y).map_or(Trace::NO_RAY, |direction| self.trace_direction(x, y, direction))
    }

    /// Traces a ray from a pixel's centre, at the pixel's own depth, along a view-space direction of any
    /// length.
    pub fn trace_direction(&self, x: u32, y: u32, direction: DVec3) -> Trace {
        self.rays.segment(x, y, direction).map_or(Trace::NO_RAY, |segment| self.trace_segment(&segment))
    }

    /// Traces a segment that begins on the screen, from cell to cell. The walk goes down a level where the ray may meet a
    /// block, and up a level where the ray left the parent cell.
    pub fn trace_segment(&self, segment: &Segment) -> Trace {
        let sides = [self.levels[0].width, self.levels[0].height];
        let mut lanes = [0, 1].map(|axis| AxisWalk::new(segment, axis, sides[axis]));
        let mut steps = 0;
        // The starting pixel itself is not tested.
        let mut entry = lanes[0].exit(0).min(lanes[1].exit(0));
        if entry >= 1.0 {
            return self.miss(&lanes, segment, 1.0, steps);
        }
        for lane in &mut lanes {
            lane.advance(entry);
        }
        let start = entry;
        let mut level = 0;
        loop {
            let Some(cell) = self.cell(&lanes, level) else {
                return self.miss(&lanes, segment, entry, steps);
            };
            steps += 1;
            let exit = lanes[0].exit(level).min(lanes[1].exit(level));
            let (near, far) = {
                let (a, b) = (segment.depth_at(entry), segment.depth_at(exit.min(1.0)));
                if a > b { (a, b) } else { (b, a) }
            };
            // In version 2, the surface in the first pixel may be the one that the ray is leaving.
            let (is_second, is_first) = (self.version == OracleVersion::V2, entry == start);
            let leaves = is_second && is_first && self.inward(&lanes, segment) < 0.0;
            if far <= cell.front && near >= cell.back && !leaves {
                if level > 0 {
                    level -= 1;
                    continue;
                }
                if is_second && !is_first && self.is_behind(&lanes, segment, entry, cell) {
                    return Trace { outcome: Outcome::Miss { reason: segment.end, behind: true }, steps };
                }
                return Trace { outcome: hit(segment, &lanes, cell.front, [entry, exit.min(1.0)], [near, far]), steps };
            }
            if exit >= 1.0 {
                return self.miss(&lanes, segment, 1.0, steps);
            }
            let parent = lanes.map(|lane| lane.pixel >> (level + 1));
            for lane in &mut lanes {
                lane.advance(exit);
            }
            entry = exit;
            let left_parent = parent != lanes.map(|lane| lane.pixel >> (level + 1));
            if left_parent && level + 1 < self.levels.len() {
                level += 1;
            }
        }
    }

    /// The cell that contains the current pixel; `None` off screen.
    fn cell(&self, lanes: &[AxisWalk; 2], level: usize) -> Option<DepthBlock> {
        let [x, y] = lanes.map(|lane| u32::try_from(lane.pixel).ok());
        let (x, y, finest) = (x?, y?, &self.levels[0]);
        (x < finest.width && y < finest.height).then(|| {
            let cells = &self.levels[level];
            cells.texels[(y >> level) as usize * cells.width as usize + (x >> level) as usize]
        })
    }

    /// The cosine of the angle between a ray and the reversed normal of the current pixel; negative if the ray runs along the
    /// normal.
    fn inward(&self, lanes: &[AxisWalk; 2], segment: &Segment) -> f64 {
        let [x, y] = lanes.map(|lane| lane.pixel as u32);
        segment.direction.dot(-self.rays.normal(x, y).unwrap_or(DVec3::ZERO))
    }

    /// Whether a ray that enters a pixel's block at `entry` comes from behind it (`oracle`, version 2).
    fn is_behind(&self, lanes: &[AxisWalk; 2], segment: &Segment, entry: f64, block: DepthBlock) -> bool {
        let depth = segment.depth_at(entry);
        let before = self.cell(&lanes.map(|lane| lane.before(entry)), 0).unwrap_or(DepthBlock::EMPTY);
        let is_torn = block.front - before.front > JOINED * (block.thickness() + before.thickness());
        let is_deep = block.front - depth > self.inward(lanes, segment).max(0.0) * block.thickness();
        depth < block.front && (depth < before.front || is_torn && is_deep)
    }

    /// The result for a ray that ends at `end`, in the pixel where the ray is just before its end.
    fn miss(&self, lanes: &[AxisWalk; 2], segment: &Segment, end: f64, steps: u32) -> Trace {
        let before = lanes.map(|lane| lane.before(end));
        let behind = self.cell(&before, 0).is_some_and(|b| b.front >= b.back && segment.depth_at(end) < b.back);
        Trace { outcome: Outcome::Miss { reason: segment.end, behind }, steps }
    }
}

/// Halves a level, rounding its sides up; `None` if the level has a single cell.
fn coarser(below: &Level<DepthBlock>) -> Option<Level<DepthBlock>> {
    let side = |n: u32| n.div_ceil(2);
    (below.width > 1 || below.height > 1).then(|| {
        Level::from_fn(side(below.width), side(below.height), |x, y| {
            // At an odd edge the same block counts twice, which changes nothing.
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| below.at_clamped(2 * x + dx, 2 * y + dy));
            four.into_iter().fold(DepthBlock::EMPTY, DepthBlock::union)
        })
    })
}

/// The hit of a ray in a pixel. The ray's depth is between `far` and `near` from `entry` to `exit`.
fn hit(
    segment: &Segment,
    lanes: &[AxisWalk; 2],
    front: f64,
    [entry, exit]: [f64; 2],
    [near, far]: [f64; 2],
) -> Outcome {
    let s = if far <= front && front <= near && near > far {
        ((front - segment.start.z) / segment.delta.z).max(entry).min(exit)
    } else {
        entry
    };
    Outcome::Hit { pixel: lanes.map(|lane| lane.pixel as u32), position: segment.point_at(s) }
}

/// The walk along one axis; `pixel` is the column (or row) in which the ray is.
#[derive(Debug, Clone, Copy)]
struct AxisWalk<'s> {
    segment: &'s Segment,
    axis: usize,
    /// 1, −1, or 0 if the ray does not move along this axis.
    direction: i32,
    /// The column (or row) in which the ray begins.
    first: i32,
    pixel: i32,
    /// The number of pixels along this axis.
    side: i32,
}

impl<'s> AxisWalk<'s> {
    /// The walk at the start of a segment, along axis 0 (x) or 1 (y) of an image with `side` pixels along this axis.
    fn new(segment: &'s Segment, axis: usize, side: u32) -> Self {
        let delta = segment.delta[axis];
        let first = segment.start[axis].floor() as i32;
        let direction = i32::from(delta > 0.0) - i32::from(delta < 0.0);
        Self { segment, axis, direction, first, pixel: first, side: side as i32 }
    }

    /// The s at which the ray leaves the cell of the given level that contains the current pixel. The last cell may extend
    /// beyond the screen, whose edge then counts, since the ray's end is rounded to it.
    fn exit(&self, level: usize) -> f64 {
        let cell = self.pixel >> level;
        self.crossing(((if self.direction > 0 { cell + 1 } else { cell }) << level).min(self.side))
    }

    /// The s at which the ray crosses the boundary before column (or row) `boundary`.
    fn crossing(&self, boundary: i32) -> f64 {
        self.segment.crossing(self.axis, boundary)
    }

    /// Advances to the pixel in which the ray is from s on, past every boundary that it crosses up to and
    /// including s.
    fn advance(&mut self, s: f64) {
        self.pixel = self.pixel_at(s, |crossing| crossing <= s);
    }

    /// The walk along the axis, at the pixel in which the ray is just before s, past every boundary that it crosses before s.
    fn before(&self, s: f64) -> Self {
        Self { pixel: self.pixel_at(s, |crossing| crossing < s), ..*self }
    }

    /// The pixel behind all boundaries for which `crossed` is true. The position at s gives a first guess; corrections then
    /// make sure that the result does not depend on the rounding of the position.
    fn pixel_at(&self, s: f64, crossed: impl Fn(f64) -> bool) -> i32 {
        if self.direction == 0 {
            return self.first;
        }
        let mut pixel = self.segment.point_at(s)[self.axis].floor() as i32;
        // Offsets from a pixel to the boundary at which the ray leaves it, and to the boundary at which the ray entered.
        let (ahead, behind) = if self.direction > 0 { (1, 0) } else { (0, 1) };
        while crossed(self.crossing(pixel + ahead)) {
            pixel += self.direction;
        }
        while pixel != self.first && !crossed(self.crossing(pixel + behind)) {
            pixel -= self.direction;
        }
        pixel
    }
}

mod ties;

#[cfg(test)]
mod tests;
