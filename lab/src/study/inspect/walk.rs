//! The path of a ray through the cells of a Hi-Z chain, as the twin of the traversal walks it.

use glam::{Vec2, Vec3Swizzles};
use ssct_truth::reference::hi_z_ray_trace::{self, HiZTrace};
use ssct_truth::reference::unified::{HitCode, Traversal};

/// A ray's path through the cells of a Hi-Z chain, for any method.
#[derive(Debug, Clone, PartialEq)]
pub struct Walk {
    /// Every visited cell, in order.
    pub cells: Vec<VisitedCell>,
    /// The ray's position in pixels: at its start, then after each step.
    pub way: Vec<Vec2>,
    /// How the path ended.
    pub end: WalkEnd,
    /// The convention of the cells' depths.
    pub depth: &'static str,
}

/// A cell that a ray visited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisitedCell {
    /// Level of the Hi-Z chain; 0 is the pixels.
    pub level: u32,
    /// Column and row of the cell in its level.
    pub place: Vec2,
    /// Top left and bottom right corners of the cell, in pixels.
    pub corners: [Vec2; 2],
    /// The nearest depth in the cell.
    pub nearest: f32,
    /// The ray's depth after the step.
    pub ray: f32,
    /// Whether the ray went on to the next cell. Otherwise it met the content of this cell, and the walk went down a level.
    pub crossed: bool,
}

/// How a ray's path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WalkEnd {
    /// The ray hit a cell of level 0.
    Hit,
    /// The ray left the visible volume.
    Left,
    /// The ray met a block from behind.
    Behind,
    /// The ray ran out of iterations.
    Exhausted,
}

impl Walk {
    /// The last position, in pixels.
    pub fn last(&self) -> Vec2 {
        self.way.last().copied().unwrap_or_default()
    }

    /// The path of the thesis's traversal in an image of `size` pixels.
    pub(super) fn of_thesis(trace: &HiZTrace, size: Vec2) -> Self {
        let cells = trace.steps.iter().map(|s| VisitedCell {
            level: s.level,
            place: s.cell,
            corners: [s.cell, s.cell + 1.0].map(|corner| corner / s.cell_count * size),
            nearest: s.minimum_plane,
            ray: s.ray.z,
            crossed: s.crossed,
        });
        let way = [trace.from, trace.entered].into_iter().chain(trace.steps.iter().map(|s| s.ray));
        Self {
            cells: cells.collect(),
            way: way.map(|place| place.xy() * size).collect(),
            end: match trace.end {
                hi_z_ray_trace::End::Hit => WalkEnd::Hit,
                hi_z_ray_trace::End::LeftScreen => WalkEnd::Left,
                hi_z_ray_trace::End::Exhausted => WalkEnd::Exhausted,
            },
            depth: "standard depth, near is 0",
        }
    }

    /// The path of the traversal of `unified`; `None` if the pixel has no ray.
    pub(super) fn of_unified(traversal: &Traversal, x: u32, y: u32) -> Option<Self> {
        let (ray, _) = traversal.mirror_ray(x, y)?;
        let (mut cells, mut way) = (Vec::new(), vec![ray.point_at(0.0).xy()]);
        let hit = traversal.walk(&ray, |visit| {
            let side = (1 << visit.level) as f32;
            let place = visit.cell.as_vec2();
            // A ray that meets a cell stands at its entry, since the next visited cell is inside; otherwise it stands at the
            // exit.
            let stands = ray.point_at(visit.span[usize::from(!visit.meets)]);
            way.push(stands.xy());
            cells.push(VisitedCell {
                level: visit.level,
                place,
                corners: [place * side, (place + 1.0) * side],
                nearest: visit.block.front,
                ray: stands.z,
                crossed: !visit.meets,
            });
        });
        let end = match hit.code {
            HitCode::Surface => WalkEnd::Hit,
            HitCode::Miss => WalkEnd::Left,
            HitCode::MissBehind => WalkEnd::Behind,
            HitCode::Unfinished => WalkEnd::Exhausted,
        };
        if end == WalkEnd::Hit {
            way.push(hit.position);
        }
        Some(Self { cells, way, end, depth: "reversed depth, near is 1" })
    }
}
