//! The thesis's Hi-Z ray tracing (Alg. 2 and 4) on the CPU, in f32 and in the shader's order: the twin
//! of `shaders-glsl/thesis/hi_z_ray_trace.glsl` and `reflection_ray.glsl`. It tells what the shader
//! can't: which cells a ray looked at on which levels, and in how many steps.
//!
//! It is no evidence for the method, whose errata it shares; [`super::oracle`] is.

use super::Level;
use super::hi_z::{MinMax, chain};
use crate::scene::GBufferData;
use glam::{Mat4, Vec2, Vec3, Vec3Swizzles};

/// Those parameters of the thesis's block that the ray trace reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// View to clip, standard depth.
    pub projection: Mat4,
    /// Its inverse.
    pub inverse_projection: Mat4,
    /// ε of Alg. 2, metres.
    pub reflection_offset: f32,
    /// ε of Alg. 6.
    pub view_direction_epsilon: f32,
    /// Pixels that a ray is pushed past a boundary.
    pub cross_offset: f32,
    /// Level that the traversal begins at.
    pub start_level: i32,
    /// Bound of its iterations.
    pub iterations: i32,
}

/// A step of the traversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Level of the cell looked at.
    pub level: u32,
    /// Its column and row.
    pub cell: [i32; 2],
    /// Left, top, right and bottom of the cell in pixels.
    pub bounds: [f32; 4],
    /// The ray before the step: texture coordinates and standard depth.
    pub from: Vec3,
    /// The ray after it.
    pub to: Vec3,
    /// The nearest depth of the cell, standard.
    pub plane: f32,
    /// Whether the ray met the plane and went down a level; else it left the cell and went up.
    pub met: bool,
}

/// How a ray ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The pixel does not reflect.
    NoRay,
    /// Towards the camera: not for the Hi-Z traversal.
    TowardsCamera,
    /// It met a cell of level 0.
    Hit,
    /// It left the screen.
    LeftScreen,
    /// Out of iterations; the thesis takes it for a hit.
    Exhausted,
}

/// A ray's end and the steps up to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Walk {
    /// How it ended.
    pub end: End,
    /// Where: texture coordinates and standard depth.
    pub position: Vec3,
    /// Each step, in order.
    pub steps: Vec<Step>,
}

/// The traversal of one G-buffer.
pub struct HiZWalk<'a> {
    gbuffer: &'a GBufferData,
    parameters: Parameters,
    levels: Vec<Level<MinMax>>,
}

impl<'a> HiZWalk<'a> {
    /// Builds the Hi-Z chain.
    pub fn new(gbuffer: &'a GBufferData, parameters: Parameters) -> Self {
        let depth = Level {
            width: gbuffer.width,
            height: gbuffer.height,
            texels: gbuffer.depth.iter().map(|reversed| 1.0 - reversed).collect(),
        };
        Self { gbuffer, parameters, levels: chain(&depth) }
    }

    /// The mirror ray of a pixel, with its steps.
    pub fn walk(&self, x: u32, y: u32) -> Walk {
        let mut steps = Vec::new();
        let (end, position) = self.trace(x, y, &mut |step| steps.push(step));
        Walk { end, position, steps }
    }

    /// The number of steps of a pixel's mirror ray.
    pub fn steps(&self, x: u32, y: u32) -> u32 {
        let mut count = 0;
        self.trace(x, y, &mut |_| count += 1);
        count
    }

    fn trace(&self, x: u32, y: u32, visit: &mut dyn FnMut(Step)) -> (End, Vec3) {
        let g = self.gbuffer;
        let index = g.index(x, y);
        let normal = g.normal[index];
        if g.reflectivity[index] <= GBufferData::REFLECTS_ABOVE || normal.dot(normal) <= 1e-4 {
            return (End::NoRay, Vec3::NEG_ONE);
        }
        let tex_coord = (Vec2::new(x as f32, y as f32) + 0.5) / self.resolution();
        let p = tex_coord.extend(self.levels[0].at_clamped(x, y).min);
        let v = self.reflection_ray(p, normal.normalize());
        if v.z <= self.parameters.view_direction_epsilon {
            return (End::TowardsCamera, p);
        }
        self.hi_z_ray_trace(p, v, visit)
    }

    fn resolution(&self) -> Vec2 {
        Vec2::new(self.gbuffer.width as f32, self.gbuffer.height as f32)
    }

    /// `ReflectionRay`, Alg. 2.
    fn reflection_ray(&self, p: Vec3, normal: Vec3) -> Vec3 {
        let flip = Vec2::new(2.0, -2.0);
        let view = self.parameters.inverse_projection.project_point3(((p.xy() - 0.5) * flip).extend(p.z));
        let reflection = view.normalize().reflect(normal);
        let offset = self.parameters.projection.project_point3(view + reflection * self.parameters.reflection_offset);
        (offset.xy() / flip + 0.5).extend(offset.z) - p
    }

    /// `HiZRayTrace`, Alg. 4.
    fn hi_z_ray_trace(&self, p: Vec3, v: Vec3, visit: &mut dyn FnMut(Step)) -> (End, Vec3) {
        let sign = Vec2::new(if v.x >= 0.0 { 1.0 } else { -1.0 }, if v.y >= 0.0 { 1.0 } else { -1.0 });
        let cross_offset = sign * (self.parameters.cross_offset / self.resolution());
        let cross_step = sign.max(Vec2::ZERO);
        let direction = v / v.z;
        let origin = p + direction * -p.z;
        let boundary = |cell: Vec2, count: Vec2| {
            let delta = ((cell + cross_step) / count + cross_offset - origin.xy()) / direction.xy();
            origin + direction * delta.x.min(delta.y)
        };
        let mut level = self.parameters.start_level;
        let count = self.cell_count(level);
        let mut ray = boundary((p.xy() * count).floor(), count);
        let mut iterations = 0;
        while level >= 0 {
            if iterations >= self.parameters.iterations {
                return (End::Exhausted, ray);
            }
            iterations += 1;
            let count = self.cell_count(level);
            let cell = (ray.xy() * count).floor();
            let plane = self.plane(ray.xy(), level);
            let plane_ray = origin + direction * ray.z.max(plane);
            let met = cell == (plane_ray.xy() * count).floor();
            let (from, looked_at) = (ray, level);
            if met {
                ray = plane_ray;
                level -= 1;
            } else {
                ray = boundary(cell, count);
                level = (level + 1).min(self.levels.len() as i32 - 1);
            }
            let corner = |c: Vec2| c / count * self.resolution();
            let (low, high) = (corner(cell), corner(cell + 1.0));
            visit(Step {
                level: looked_at as u32,
                cell: [cell.x as i32, cell.y as i32],
                bounds: [low.x, low.y, high.x, high.y],
                from,
                to: ray,
                plane,
                met,
            });
            if ray.x < 0.0 || ray.y < 0.0 || ray.x > 1.0 || ray.y > 1.0 {
                return (End::LeftScreen, ray);
            }
        }
        (End::Hit, ray)
    }

    /// `GetCellCount`.
    fn cell_count(&self, level: i32) -> Vec2 {
        (self.resolution() / (level as f32).exp2()).floor().max(Vec2::ONE)
    }

    /// `GetCellMinimumDepthPlane`: the nearest texel of the level.
    fn plane(&self, at: Vec2, level: i32) -> f32 {
        let level = &self.levels[level as usize];
        let texel = |v: f32, side: u32| ((v * side as f32).floor().max(0.0)) as u32;
        level.at_clamped(texel(at.x, level.width), texel(at.y, level.height)).min
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::floor_and_wall;

    fn parameters(g: &GBufferData) -> Parameters {
        let projection = g.camera.view_to_clip();
        Parameters {
            projection,
            inverse_projection: projection.inverse(),
            reflection_offset: g.camera.lens.near_m,
            view_direction_epsilon: 1e-5,
            cross_offset: 0.5,
            start_level: 0,
            iterations: 1024,
        }
    }

    #[test]
    fn a_floor_mirrors_the_wall_where_it_stands() {
        let (width, height) = (64, 36);
        let mut g = floor_and_wall(width, height);
        let walks = HiZWalk::new(&g, parameters(&g));
        assert_eq!(walks.walk(10, 5).end, End::TowardsCamera, "the wall sends its rays back");
        let half_height = (g.camera.lens.fov_y_radians / 2.0).tan();
        for y in 28..33 {
            let walk = walks.walk(32, y);
            assert_eq!(walk.end, End::Hit, "{walk:?}");
            // A floor 1 m below the eye shows what stands 5 m away as if seen from 2 m lower.
            let slope = (1.0 - (2.0 * y as f32 + 1.0) / height as f32) * half_height;
            let expected = (0.5 - (-slope * 5.0 - 2.0) / 5.0 / half_height / 2.0) * height as f32;
            let found = walk.position.y * height as f32;
            assert!((found - expected).abs() < 1.5, "row {y}: {found}, expected {expected}");
            assert_eq!(walks.steps(32, y) as usize, walk.steps.len());
            assert!(walk.steps.windows(2).all(|s| s[0].to == s[1].from), "{walk:?}");
            for s in &walk.steps {
                let at = s.from.xy() * walks.resolution();
                let [left, top, right, bottom] = s.bounds;
                assert!(left <= at.x && at.x <= right && top <= at.y && at.y <= bottom, "{s:?}");
            }
        }
        g.reflectivity.fill(0.0);
        assert_eq!(HiZWalk::new(&g, parameters(&g)).walk(32, 30).end, End::NoRay);
    }
}
