//! The oracle (docs/definitions.md, "Oracle"): finds what a reflection ray really hits in a G-buffer by examining every
//! pixel on its path, in f64. The code is slow, short and meant to be read.
//!
//! By version 1 a ray hits the first block that it meets. By version 2 it hits a block only if it can have come from in
//! front of the block. A block's thickness is a guess that keeps rays from slipping through surfaces. Where the screen
//! does not show what lies between two pixels, rays of version 1 can hit this guess. In the world these rays pass
//! behind the object, or end on a side of the object that is not visible. The rules of version 2 are:
//!
//! - The block of the first pixel after the start usually belongs to the surface that the ray leaves. Depths one pixel
//!   apart cannot tell whether it does, but the pixel's normal can. A ray that runs along the normal passes as if the
//!   pixel were empty; any other ray hits.
//! - A ray hits any later block if it is in front of the block where it enters the pixel. A ray also hits if it was in
//!   front of the previous pixel's block, and therefore passes between the two fronts. Both fronts must then be close
//!   enough to belong to one surface ([`JOINED`]). Otherwise the ray is at the edge of a visible surface, and hits the
//!   block's side only down to a limited depth. The limit is the thickness times the cosine between the ray and the
//!   reversed normal: the more a ray runs along the surface, the sooner it has passed behind it. In all other cases the
//!   ray is behind what is visible, and misses.

use super::Level;
use super::ray::{Outcome, RaySetup, Segment, Trace};
use super::thickness::{self, DepthBlock, JOINED};
use glam::DVec3;
use ssct_ground::math::OracleVersion;
use ssct_scenes::GBufferData;
use std::ops::ControlFlow;

/// The side from which a ray comes to a block that it meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    /// From in front of the block, which is a hit.
    InFront,
    /// From inside, while it leaves the surface on which it begins; version 2 lets it pass.
    Leaving,
    /// From behind the block, which is a miss in version 2.
    Behind,
}

/// A block that a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Pixel of the block.
    pub pixel: [u32; 2],
    /// Where the ray meets the block: pixel x, pixel y (continuous) and reversed depth.
    pub position: DVec3,
    /// Whether the ray crosses the block's front at the position. Otherwise the ray enters the block by a side or
    /// through the back.
    pub crosses_front: bool,
    /// The side from which the ray comes; only version 2 of the oracle uses it.
    pub approach: Approach,
    /// The number of pixels examined so far.
    pub steps: u32,
}

/// A pixel that a segment passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PassedPixel {
    /// Index of the pixel.
    pub pixel: [i32; 2],
    /// The previous pixel; `None` for the pixel in which the segment begins.
    pub previous: Option<[i32; 2]>,
    /// The segment's parameter s (0 to 1) where it enters the pixel.
    pub entry: f64,
    /// The segment's parameter s where it leaves the pixel, or ends.
    pub exit: f64,
}

/// The oracle of a G-buffer.
#[derive(Debug, Clone)]
pub struct Oracle<'a> {
    /// The set-up of rays.
    pub(super) rays: RaySetup<'a>,
    /// The block of each pixel.
    blocks: Level<DepthBlock>,
    version: OracleVersion,
}

impl<'a> Oracle<'a> {
    /// Makes the oracle of a G-buffer, and computes each pixel's block. Rays hit by version 1 until
    /// [`Self::of_version`] says otherwise.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        Self { rays: RaySetup::new(gbuffer), blocks: thickness::blocks(gbuffer), version: OracleVersion::V1 }
    }

    /// Returns the same oracle, in which rays hit by the rules of the given version.
    pub fn of_version(self, version: OracleVersion) -> Self {
        Self { version, ..self }
    }

    /// Traces the mirror ray of pixel (x, y).
    pub fn trace(&self, x: u32, y: u32) -> Trace {
        self.rays.mirror(x, y).map_or(Trace::NO_RAY, |direction| self.trace_direction(x, y, direction))
    }

    /// Traces a ray from the centre of pixel (x, y), at the pixel's own depth, along a view-space direction of any
    /// length.
    pub fn trace_direction(&self, x: u32, y: u32, direction: DVec3) -> Trace {
        self.rays.segment(x, y, direction).map_or(Trace::NO_RAY, |segment| self.trace_segment(&segment))
    }

    /// Traces a segment that begins on the screen, by docs/definitions.md, "Oracle", item 4.
    pub fn trace_segment(&self, segment: &Segment) -> Trace {
        // Whether a meeting ends the ray, and how.
        let decide = |meeting: Meeting| {
            let Meeting { pixel, position, approach, steps, .. } = meeting;
            let outcome = match approach {
                _ if self.version == OracleVersion::V1 => Outcome::Hit { pixel, position },
                Approach::InFront => Outcome::Hit { pixel, position },
                Approach::Leaving => return ControlFlow::Continue(()),
                Approach::Behind => Outcome::Miss { reason: segment.end, behind: true },
            };
            ControlFlow::Break(Trace { outcome, steps })
        };
        match self.walk(segment, decide) {
            ControlFlow::Break(trace) | ControlFlow::Continue(trace) => trace,
        }
    }

    /// Returns all blocks that a segment meets, in order, as if it passed through each of them. Every version chooses
    /// its hit from these meetings.
    pub fn meetings(&self, segment: &Segment) -> Vec<Meeting> {
        let mut meetings = Vec::new();
        let _: ControlFlow<(), Trace> = self.walk(segment, |meeting| {
            meetings.push(meeting);
            ControlFlow::Continue(())
        });
        meetings
    }

    /// Walks over the pixels after the starting one, and calls `on_meeting` for each block that the ray meets. If that
    /// returns `Break`, the walk ends with its value; a walk that reaches the segment's end returns `Continue` with a
    /// miss.
    fn walk<B>(
        &self,
        segment: &Segment,
        mut on_meeting: impl FnMut(Meeting) -> ControlFlow<B>,
    ) -> ControlFlow<B, Trace> {
        // The last pixel that the segment passes, with its number.
        let mut last_passed = None;
        for (steps, passed) in self.pixels(segment).enumerate() {
            let PassedPixel { pixel, previous, entry, exit } = passed;
            last_passed = Some((steps as u32, passed));
            let (Some(previous), Some(block)) = (previous, self.block(pixel)) else { continue };
            if let Some((s, crosses_front)) = meets(segment, block, entry, exit) {
                let along_normal = self.along_normal(pixel, segment);
                let approach = if steps == 1 && along_normal > 0.0 {
                    Approach::Leaving
                } else if steps > 1 && self.comes_from_behind(segment.depth_at(entry), previous, block, along_normal) {
                    Approach::Behind
                } else {
                    Approach::InFront
                };
                let (pixel, position, steps) = (pixel.map(|p| p as u32), segment.point_at(s), steps as u32);
                on_meeting(Meeting { pixel, position, crosses_front, approach, steps })?;
            }
        }
        let miss = |(steps, passed): (u32, PassedPixel)| self.miss(passed.pixel, segment, passed.exit, steps);
        ControlFlow::Continue(last_passed.map_or(Trace::NO_RAY, miss))
    }

    /// Returns the pixels that a segment passes, in order, from the pixel in which it begins. The walk crosses the
    /// nearer of the next boundaries in x and y; at a corner it goes directly to the diagonal pixel.
    pub(super) fn pixels(&self, segment: &Segment) -> impl Iterator<Item = PassedPixel> {
        let sides = [self.blocks.width, self.blocks.height].map(|side| side as i32);
        let start_pixel = [0, 1].map(|axis| (segment.start[axis].floor() as i32).clamp(0, sides[axis] - 1));
        let exits = |pixel: [i32; 2]| [0, 1].map(|axis| axis_exit(segment, axis, pixel[axis]));
        let passed_pixel = move |pixel: [i32; 2], previous, entry: f64| {
            let [x_exit, y_exit] = exits(pixel);
            PassedPixel { pixel, previous, entry, exit: x_exit.min(y_exit).min(1.0) }
        };
        std::iter::successors(Some(passed_pixel(start_pixel, None, 0.0)), move |PassedPixel { pixel, exit, .. }| {
            let next_exits = exits(*pixel);
            let step = |axis: usize| if segment.delta[axis] > 0.0 { 1 } else { -1 };
            let next_pixel = [0, 1].map(|axis| pixel[axis] + if next_exits[axis] <= *exit { step(axis) } else { 0 });
            let is_inside = [0, 1].into_iter().all(|axis| (0..sides[axis]).contains(&next_pixel[axis]));
            (*exit < 1.0 && is_inside).then(|| passed_pixel(next_pixel, Some(*pixel), *exit))
        })
    }

    /// Returns the cosine of the angle between a ray and a pixel's normal; 0 if there is no normal.
    pub(super) fn along_normal(&self, pixel: [i32; 2], segment: &Segment) -> f64 {
        self.rays.normal(pixel[0] as u32, pixel[1] as u32).map_or(0.0, |n| n.dot(segment.direction))
    }

    /// Returns whether a ray that comes from the pixel `previous` and enters a block's pixel at the reversed depth
    /// `entry_depth` passes behind the block, by the rules of version 2 in the module's description. `along_normal` is
    /// the cosine between the ray and the block's normal, or 0 if there is no normal.
    pub(super) fn comes_from_behind(
        &self,
        entry_depth: f64,
        previous: [i32; 2],
        block: DepthBlock,
        along_normal: f64,
    ) -> bool {
        let previous_block = self.block(previous).unwrap_or(DepthBlock::EMPTY);
        let is_joined = block.front - previous_block.front <= JOINED * (block.thickness() + previous_block.thickness());
        let is_near_front = block.front - entry_depth <= (-along_normal).max(0.0) * block.thickness();
        entry_depth < block.front && (entry_depth < previous_block.front || !(is_joined || is_near_front))
    }

    /// Returns the block of pixel (x, y); `None` off screen.
    pub(super) fn block(&self, [x, y]: [i32; 2]) -> Option<DepthBlock> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        (x < self.blocks.width && y < self.blocks.height).then(|| self.blocks.at_clamped(x, y))
    }

    /// Returns the miss of a ray that ends in a pixel at s = `end_s`. The flag `behind` is set if that end is behind
    /// the pixel's block.
    fn miss(&self, pixel: [i32; 2], segment: &Segment, end_s: f64, steps: u32) -> Trace {
        let block = self.block(pixel).unwrap_or(DepthBlock::EMPTY);
        let behind = block != DepthBlock::EMPTY && segment.depth_at(end_s) < block.back;
        Trace { outcome: Outcome::Miss { reason: segment.end, behind }, steps }
    }
}

/// Returns the segment's parameter s where it leaves the column (axis 0) or row (axis 1) number `pixel`.
fn axis_exit(segment: &Segment, axis: usize, pixel: i32) -> f64 {
    segment.crossing(axis, if segment.delta[axis] > 0.0 { pixel + 1 } else { pixel })
}

/// Returns the parameter s where a ray meets the block of a pixel in which it is from s = `entry` to s = `exit`, and
/// whether it crosses the block's front there. A ray that does not cross the front in the pixel meets the block at its
/// entry. `None` if the ray does not meet the block.
pub(super) fn meets(segment: &Segment, block: DepthBlock, entry: f64, exit: f64) -> Option<(f64, bool)> {
    let (entry_depth, exit_depth) = (segment.depth_at(entry), segment.depth_at(exit));
    if entry_depth.max(exit_depth) < block.back || entry_depth.min(exit_depth) > block.front {
        return None;
    }
    let crosses_front = entry_depth.min(exit_depth) <= block.front && entry_depth.max(exit_depth) >= block.front;
    if crosses_front && segment.delta.z != 0.0 {
        return Some((((block.front - segment.start.z) / segment.delta.z).clamp(entry, exit), true));
    }
    Some((entry, false))
}

#[cfg(test)]
mod tests;
