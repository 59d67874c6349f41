//! The walk of a ray through the cells of a Hi-Z chain or of a pyramid, cell by cell, by the twin of a method.

use glam::{Vec2, Vec3Swizzles};
use ssct_truth::reference::hi_z_ray_trace::{self, HiZTrace};
use ssct_truth::reference::unified::{HitCode, Traversal};

/// The walk of a ray through the cells of a Hi-Z chain or of a pyramid.
#[derive(Debug, Clone, PartialEq)]
pub struct Walk {
    /// Every visited cell, in order.
    pub cells: Vec<VisitedCell>,
    /// The ray's positions in pixels: first where the walk begins, and then after each step.
    pub positions: Vec<Vec2>,
    /// How the walk ended.
    pub end: WalkEnd,
    /// The convention of the cells' depths.
    pub depth: &'static str,
}

/// A cell that a ray visited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisitedCell {
    /// Level of the cell; level 0 has the pixels.
    pub level: u32,
    /// Column and row of the cell in its level.
    pub place: Vec2,
    /// Top left and bottom right corners of the cell, in pixels.
    pub corners: [Vec2; 2],
    /// The nearest depth in the cell.
    pub nearest: f32,
    /// The ray's depth after the step.
    pub ray: f32,
    /// Whether the ray crossed the cell and went on to the next. Otherwise it met the depths that the cell holds, and
    /// the walk went down a level or ended.
    pub crossed: bool,
}

/// How a walk ended.
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
    /// Returns the last position, in pixels.
    pub fn last(&self) -> Vec2 {
        self.positions.last().copied().unwrap_or_default()
    }

    /// Makes the walk from the trace of the thesis's Hi-Z ray tracing, in an image of `size` pixels.
    pub(super) fn of_thesis(trace: &HiZTrace, size: Vec2) -> Self {
        let cells = trace.steps.iter().map(|step| VisitedCell {
            level: step.level,
            place: step.cell,
            corners: [step.cell, step.cell + 1.0].map(|corner| corner / step.cell_count * size),
            nearest: step.minimum_plane,
            ray: step.ray.z,
            crossed: step.crossed,
        });
        // Positions of the trace are texture coordinates and depth.
        let positions = [trace.from, trace.entered].into_iter().chain(trace.steps.iter().map(|step| step.ray));
        Self {
            cells: cells.collect(),
            positions: positions.map(|position| position.xy() * size).collect(),
            end: match trace.end {
                hi_z_ray_trace::End::Hit => WalkEnd::Hit,
                hi_z_ray_trace::End::LeftScreen => WalkEnd::Left,
                hi_z_ray_trace::End::Exhausted => WalkEnd::Exhausted,
            },
            depth: "standard depth, near is 0",
        }
    }

    /// Walks the mirror ray of the pixel (x, y) by the twin of `unified`; `None` if the pixel has no ray.
    pub(super) fn of_unified(traversal: &Traversal, x: u32, y: u32) -> Option<Self> {
        let (ray, _) = traversal.mirror_ray(x, y)?;
        let (mut cells, mut positions) = (Vec::new(), vec![ray.point_at(0.0).xy()]);
        let hit = traversal.walk(&ray, |visit| {
            let side = (1 << visit.level) as f32;
            let place = visit.cell.as_vec2();
            // `span` has where the ray enters the cell and where it leaves it. A ray that meets the cell stays where it
            // entered, since the next visited cell lies within; otherwise it moves to where it leaves.
            let position = ray.point_at(visit.span[usize::from(!visit.meets)]);
            positions.push(position.xy());
            cells.push(VisitedCell {
                level: visit.level,
                place,
                corners: [place * side, (place + 1.0) * side],
                nearest: visit.block.front,
                ray: position.z,
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
            positions.push(hit.position);
        }
        Some(Self { cells, positions, end, depth: "reversed depth, near is 1" })
    }
}
