//! The set of places where a ray can end if its coordinates are known only up to rounding. A traversal that ends at one
//! of these places does not contradict the oracle.

use super::{AxisWalk, Hierarchy, hit};
use crate::reference::ray::{Outcome, Segment};
use crate::reference::thickness::DepthBlock;

impl Hierarchy<'_> {
    /// Returns all ends, by version 1 of the oracle, of a ray whose crossings of pixel boundaries are known only up to
    /// a relative error of `rounding` in s. An end is the place of a hit, as in
    /// [`Trace::position_px`](crate::reference::Trace::position_px), or `None` for a miss.
    ///
    /// Where the intervals of the next crossings in x and in y overlap, the ray passes a corner. The ray may then enter
    /// the diagonal pixel directly, or touch one of the two pixels beside the corner and hit its block. Each corner is
    /// decided independently, so that a path may combine decisions that no single straight line takes. If no intervals
    /// overlap, the only end is the oracle's.
    pub fn possible_ends(&self, segment: &Segment, rounding: f64) -> Vec<Option<[f64; 2]>> {
        let sides = [self.levels[0].width, self.levels[0].height];
        let mut walks = [0, 1].map(|axis| AxisWalk::new(segment, axis, sides[axis]));
        let mut ends = Vec::new();
        // The block of the current pixel; none for the starting pixel, which is not tested.
        let mut block = None;
        let mut entry = 0.0;
        loop {
            let crossings = [0, 1].map(|axis| walks[axis].exit(0));
            let exit = crossings[0].min(crossings[1]);
            if let Some(end) = block.and_then(|block| meets(segment, &walks, block, [entry, exit.min(1.0)])) {
                ends.push(Some(end));
                return ends;
            }
            if exit >= 1.0 {
                ends.push(None);
                return ends;
            }
            let s_error = rounding * exit;
            if exit + s_error >= 1.0 {
                ends.push(None);
            }
            // The axes whose next boundary may be the first that the ray crosses; both do at a corner.
            let is_next = crossings.map(|crossing| crossing - exit <= s_error);
            if is_next == [true; 2] {
                for axis in 0..2 {
                    let mut beside_corner = walks;
                    beside_corner[axis].pixel += beside_corner[axis].direction;
                    let s_range = [exit - s_error, (exit + s_error).min(1.0)];
                    match self.cell(&beside_corner, 0) {
                        Some(block) => ends.extend(meets(segment, &beside_corner, block, s_range).map(Some)),
                        None => ends.push(None),
                    }
                }
            }
            for (walk, _) in walks.iter_mut().zip(is_next).filter(|(_, is_next)| *is_next) {
                walk.pixel += walk.direction;
            }
            entry = exit;
            block = self.cell(&walks, 0);
            if block.is_none() {
                ends.push(None);
                return ends;
            }
        }
    }
}

/// Returns the place, in pixels, where a ray hits the block of the current pixel; `None` if it does not hit. The ray is
/// in the pixel from s = `entry` to s = `exit`.
fn meets(segment: &Segment, walks: &[AxisWalk; 2], block: DepthBlock, [entry, exit]: [f64; 2]) -> Option<[f64; 2]> {
    let (at_entry, at_exit) = (segment.depth_at(entry), segment.depth_at(exit));
    let (near, far) = (at_entry.max(at_exit), at_entry.min(at_exit));
    let is_met = far <= block.front && near >= block.back;
    match hit(segment, walks, block.front, [entry, exit], [near, far]) {
        Outcome::Hit { position, .. } if is_met => Some([position.x, position.y]),
        _ => None,
    }
}
