//! The thesis's Hi-Z ray tracing on the CPU, step by step (§4.2.7: Alg. 2, Alg. 4 and its listing): the twin of
//! `shaders-glsl/thesis/hi_z_ray_trace.glsl`. It has the same 32-bit floats and the same departures from the thesis.
//! Unlike the shader, it also records the cells and levels that a ray visited.

use super::Level;
use super::hi_z::MinMax;
use glam::{Vec2, Vec3, Vec3Swizzles};
use ssct_scenes::Camera;

/// The parameters of the traversal that a preset of `methods::thesis` sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HiZConstants {
    /// The level at which the traversal begins.
    pub start_level: u32,
    /// Greatest number of iterations.
    pub iterations: u32,
    /// How far a ray is pushed past a cell boundary, in pixels, so that it lies in the next cell.
    pub cross_offset: f32,
}

/// One iteration of the traversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The level that was read.
    pub level: u32,
    /// The cell in which the ray was.
    pub cell: Vec2,
    /// The number of cells of that level.
    pub cell_count: Vec2,
    /// The minimum depth of the cell.
    pub minimum_plane: f32,
    /// Whether the ray crossed the cell's boundary before it reached the minimum depth. If so, the walk goes up a
    /// level, otherwise down.
    pub crossed: bool,
    /// The ray's position after the step: texture coordinates and standard depth.
    pub ray: Vec3,
}

/// How a traversal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The traversal went below level 0, which is a hit.
    Hit,
    /// The ray left the screen, which is a miss.
    LeftScreen,
    /// The traversal ran out of iterations, which the thesis treats as a hit.
    Exhausted,
}

/// The traversal of one ray. Positions are texture coordinates and standard depth.
#[derive(Debug, Clone, PartialEq)]
pub struct HiZTrace {
    /// The position of the pixel at which the ray begins.
    pub from: Vec3,
    /// The position where the ray left its first cell.
    pub entered: Vec3,
    /// Every iteration, in order.
    pub steps: Vec<Step>,
    /// How the traversal ended.
    pub end: End,
}

impl HiZTrace {
    /// Returns the last position of the ray: texture coordinates and standard depth.
    pub fn last(&self) -> Vec3 {
        self.steps.last().map_or(self.entered, |s| s.ray)
    }
}

/// Returns, by Alg. 2 of the thesis, the reflection vector V_ss of a pixel at P_ss, both in texture coordinates and
/// standard depth. `normal` is the pixel's unit normal in view space, and `offset` is the algorithm's ε in metres.
pub fn reflection_ray(camera: &Camera, p_ss: Vec3, normal: Vec3, offset: f32) -> Vec3 {
    // Inverted in f64 and rounded once, like the matrices that the shader receives.
    let projection = camera.view_to_clip().as_dmat4();
    let (project, unproject) = (projection.as_mat4(), projection.inverse().as_mat4());
    let clip_to_uv_scale = Vec2::new(0.5, -0.5);
    let p_vs = unproject.project_point3(((p_ss.xy() - 0.5) / clip_to_uv_scale).extend(p_ss.z));
    let r_vs = p_vs.normalize().reflect(normal);
    let o_ps = project.project_point3(p_vs + r_vs * offset);
    (o_ps.xy() * clip_to_uv_scale + 0.5).extend(o_ps.z) - p_ss
}

/// Follows, by Alg. 4 of the thesis, the ray from P_ss along V_ss over a Hi-Z chain, whose finest level comes first.
/// Both are in texture coordinates and standard depth, and V_ss.z must be above 0.
pub fn trace(chain: &[Level<MinMax>], p_ss: Vec3, v_ss: Vec3, constants: &HiZConstants) -> HiZTrace {
    let resolution = cell_count(chain, 0);
    let sign = Vec2::select(v_ss.xy().cmpge(Vec2::ZERO), Vec2::ONE, Vec2::NEG_ONE);
    let cross_offset = sign * (constants.cross_offset / resolution);
    let cross_step = sign.max(Vec2::ZERO);

    // Eq. 4.4: the ray is parametrised by its depth z.
    let direction = v_ss / v_ss.z;
    let origin = p_ss + direction * -p_ss.z;
    let point_at = |z: f32| origin + direction * z;
    // The point at which the ray leaves a cell of a level with `count` cells, pushed past the boundary.
    let past_boundary = |cell: Vec2, count: Vec2| {
        let boundary_z = ((cell + cross_step) / count + cross_offset - origin.xy()) / direction.xy();
        point_at(boundary_z.min_element())
    };
    let cell_at = |ray: Vec3, count: Vec2| (ray.xy() * count).floor();

    let mut level = constants.start_level as usize;
    let count = cell_count(chain, level);
    let entered = past_boundary(cell_at(p_ss, count), count);
    let (mut ray, mut steps) = (entered, Vec::new());
    let end = loop {
        if steps.len() as u32 >= constants.iterations {
            break End::Exhausted;
        }
        let count = cell_count(chain, level);
        let cell = cell_at(ray, count);
        // The nearest texel, clamped to the edge.
        let minimum_plane = chain[level].at_clamped(cell.x.max(0.0) as u32, cell.y.max(0.0) as u32).min;
        let on_plane = point_at(ray.z.max(minimum_plane));
        let crossed = cell_at(on_plane, count) != cell;
        ray = if crossed { past_boundary(cell, count) } else { on_plane };
        steps.push(Step { level: level as u32, cell, cell_count: count, minimum_plane, crossed, ray });
        let left_screen = ray.xy().cmplt(Vec2::ZERO).any() || ray.xy().cmpgt(Vec2::ONE).any();
        let below_finest = !crossed && level == 0;
        level = if crossed { (level + 1).min(chain.len() - 1) } else { level.saturating_sub(1) };
        // The checks have the shader's order: the loop body tests for the screen's edge, and then the loop's condition
        // tests the level.
        if left_screen {
            break End::LeftScreen;
        }
        if below_finest {
            break End::Hit;
        }
    };
    HiZTrace { from: p_ss, entered, steps, end }
}

/// Returns the numbers of cells of a level across and down.
fn cell_count(chain: &[Level<MinMax>], level: usize) -> Vec2 {
    Vec2::new(chain[level].width as f32, chain[level].height as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::hi_z;

    /// Returns the chain of 16 × 16 depths: 0.9, and from column 12 on a wall at depth 0.5.
    fn wall() -> Vec<Level<MinMax>> {
        hi_z::chain(&Level::from_fn(16, 16, |x, _| if x >= 12 { 0.5 } else { 0.9 }))
    }

    const PUBLISHED: HiZConstants = HiZConstants { start_level: 0, iterations: 1024, cross_offset: 0.5 };

    #[test]
    fn a_ray_meets_the_wall_at_its_depth() {
        // A ray from pixel (2, 8) at depth 0.3, to the right and away: it reaches depth 0.55 at column 12.5.
        let from = Vec3::new(2.5 / 16.0, 8.5 / 16.0, 0.3);
        let to = Vec3::new(12.5 / 16.0, 8.5 / 16.0, 0.55);
        let found = trace(&wall(), from, to - from, &PUBLISHED);
        assert_eq!(found.end, End::Hit);
        let hit = found.last();
        assert!((12.0..=13.0).contains(&(hit.x * 16.0)) && (hit.y * 16.0 - 8.5).abs() < 1e-3, "{hit}");
        assert!(found.steps.iter().any(|s| s.level > 0), "it must take longer steps in between");
        for pair in found.steps.windows(2) {
            let expected = if pair[0].crossed { (pair[0].level + 1).min(4) } else { pair[0].level - 1 };
            assert_eq!(pair[1].level, expected);
        }
    }

    #[test]
    fn a_ray_past_the_wall_leaves_the_screen_or_runs_out_of_iterations() {
        let from = Vec3::new(2.5 / 16.0, 8.5 / 16.0, 0.3);
        let direction = Vec3::new(0.0, 0.4, 0.01);
        assert_eq!(trace(&wall(), from, direction, &PUBLISHED).end, End::LeftScreen);
        let short = trace(&wall(), from, direction, &HiZConstants { iterations: 2, ..PUBLISHED });
        assert_eq!((short.end, short.steps.len()), (End::Exhausted, 2));
    }
}
