//! Twin of `unified/surface.glsl`: which pixels show the surface that reflects, and the sky that the screen shows to a ray.

use super::{Block, Hit, HitCode, Ray, Traversal, dot};
use glam::{IVec2, Vec3};
use ssct_ground::math::constants::STANDS_ABOVE;

impl Traversal<'_> {
    /// `OffsetToPixel`: the offset from a point to the surface of a pixel at its middle, divided by z in a perspective. `depth`
    /// is the pixel's depth.
    fn offset_to_pixel(&self, point: Vec3, pixel: IVec2, depth: f32) -> Vec3 {
        let (p, position) = (&self.parameters, pixel.as_vec2() + 0.5);
        if p.kind.is_orthographic() {
            return p.view_point(position, depth) - point;
        }
        p.view_ray(position) - (depth + p.depth_offset) * point
    }

    /// `ShowsReflector`: whether a pixel lies at most [`STANDS_ABOVE`] pixel widths above the plane through a point of the reflecting
    /// surface, whose normal may have any length. Both sides of the comparison are divided by the depth.
    pub(super) fn shows_reflector(&self, [point, normal]: [Vec3; 2], pixel: IVec2) -> bool {
        // An empty block, which shows sky, has a depth below 0.
        let depth = self.block(pixel).front;
        let height = STANDS_ABOVE as f32 * (2.0 * self.parameters.pixel_to_view.y) * dot(normal, normal).sqrt();
        depth >= 0.0 && dot(normal, self.offset_to_pixel(point, pixel, depth)) <= height
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
