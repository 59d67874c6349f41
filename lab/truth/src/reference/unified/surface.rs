//! Twin of `unified/surface.glsl`: which pixels a ray can have seen around its hit, and the sky that the screen
//! shows to a ray.

use super::{Block, Hit, HitCode, Ray, Traversal, dot};
use glam::{IVec2, Vec3, Vec3Swizzles};
use ssct_ground::math::constants::{STANDS_ABOVE, STANDS_BEFORE, STANDS_BESIDE};

/// `VisibilityTest`: the surface that reflects, its ray, and the pixel that the ray hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct VisibilityTest {
    point: Vec3,
    normal: Vec3,
    direction: Vec3,
    above: f32,
    beside: f32,
    own: f32,
    apart: f32,
    pub(super) is_reflector: bool,
}

impl Traversal<'_> {
    /// A pixel's depth; for sky, the depth of an empty block.
    pub(super) fn front(&self, pixel: IVec2) -> f32 {
        self.block(pixel).front
    }

    /// `OffsetToPixel`: the offset from a point to the surface of a pixel at its middle, divided by z in a perspective. `depth`
    /// is the pixel's depth.
    fn offset_to_pixel(&self, point: Vec3, pixel: IVec2, depth: f32) -> Vec3 {
        let (p, position) = (&self.parameters, pixel.as_vec2() + 0.5);
        if p.kind.is_orthographic() {
            return p.view_point(position, depth) - point;
        }
        p.view_ray(position) - (depth + p.depth_offset) * point
    }

    /// `MakeVisibilityTest`: the test for a ray that begins at a point of a surface with a normal, goes along a direction, and
    /// hit a pixel.
    pub(super) fn make_visibility_test(&self, [point, normal, direction]: [Vec3; 3], pixel: IVec2) -> VisibilityTest {
        let (p, own) = (&self.parameters, self.front(pixel));
        let width = 2.0 * p.pixel_to_view.y;
        let scale = if p.kind.is_orthographic() { p.depth_offset } else { own + p.depth_offset };
        let above = STANDS_ABOVE as f32 * width * dot(normal, normal).sqrt();
        let across = STANDS_BESIDE as f32 * width;
        let beside = across * across * dot(direction, direction);
        let is_reflector = own >= 0.0 && dot(normal, self.offset_to_pixel(point, pixel, own)) <= above;
        VisibilityTest {
            point,
            normal,
            direction,
            above,
            beside,
            own,
            apart: STANDS_BEFORE as f32 * width * scale,
            is_reflector,
        }
    }

    /// `IsVisibleAlongRay`: whether a ray can have seen the surface in the middle of a pixel.
    pub(super) fn is_visible_along_ray(&self, test: &VisibilityTest, pixel: IVec2) -> bool {
        let depth = self.front(pixel);
        let (away, direction) = (self.offset_to_pixel(test.point, pixel, depth), test.direction);
        let off = away.yzx() * direction.zxy() - away.zxy() * direction.yzx();
        let is_above = dot(test.normal, away) > test.above;
        let is_beside = dot(off, off) > test.beside;
        let is_seen = test.own >= 0.0 && is_above && !(depth > test.own + test.apart && is_beside);
        (depth < 0.0 || is_seen) && !(test.is_reflector && depth < test.own - test.apart)
    }

    /// `LeavesThroughFarPlane`, with the test that follows it in the shaders: the place where a ray that hit nothing went
    /// beyond the far plane, if the pixel there shows sky.
    pub(super) fn leaves_through_far_plane(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let size = self.parameters.size;
        let position = (ray.start + ray.end * ray.rate.truncate()).clamp(glam::Vec2::ZERO, size.as_vec2());
        let pixel = position.as_ivec2().min(size - 1);
        let side = IVec2::new(i32::from(ray.inverse.x > 0.0), i32::from(ray.inverse.y > 0.0)) * size;
        let sides = (side.as_vec2() - ray.start) * ray.inverse;
        let is_far = ray.rate.z < 0.0 && ray.end < sides.x.min(sides.y);
        let shows = !self.is_followed && hit.code == HitCode::Miss && is_far && self.block(pixel) == Block::EMPTY;
        shows.then_some(Hit { pixel, position, ..*hit })
    }
}
