//! Twin of `unified/trace/surface.glsl`: tests which pixels show the surface that reflects, and whether a ray ends in
//! sky that the screen shows.

use super::{Block, Hit, HitCode, Ray, Traversal, dot};
use glam::{IVec2, Vec3};
use ssct_ground::math::constants::STANDS_ABOVE;

impl Traversal<'_> {
    /// Twin of `OffsetToPixel`: returns the view-space offset from a point to the surface in the middle of a pixel of
    /// the given depth. In a perspective the offset is divided by the z of the pixel's surface. Points are scaled as by
    /// [`super::Parameters::view_point`].
    fn offset_to_pixel(&self, point: Vec3, pixel: IVec2, depth: f32) -> Vec3 {
        let (parameters, position) = (&self.parameters, pixel.as_vec2() + 0.5);
        if parameters.kind.is_orthographic() {
            return parameters.view_point(position, depth) - point;
        }
        parameters.view_ray(position) - (depth + parameters.depth_offset) * point
    }

    /// Twin of `ShowsReflector`: returns whether the surface of a pixel lies at most [`STANDS_ABOVE`] pixel widths
    /// above the plane through a point of the reflecting surface. The normal may have any length. In a perspective both
    /// sides of the comparison are divided by z, so that a pixel has one width at any depth.
    pub(super) fn shows_reflector(&self, [point, normal]: [Vec3; 2], pixel: IVec2) -> bool {
        // An empty block, which shows sky, has a depth below 0.
        let depth = self.block(pixel).front;
        let height = STANDS_ABOVE as f32 * (2.0 * self.parameters.pixel_to_view.y) * dot(normal, normal).sqrt();
        depth >= 0.0 && dot(normal, self.offset_to_pixel(point, pixel, depth)) <= height
    }

    /// Twin of `LeavesThroughFarPlane`, with the test that follows it in the shaders. Returns the hit at the place
    /// where a ray that hit nothing goes beyond the far plane, if the pixel there shows sky; `None` otherwise.
    pub(super) fn leaves_through_far_plane(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let size = self.parameters.size;
        let exit_position = (ray.start + ray.end * ray.rate.truncate()).clamp(glam::Vec2::ZERO, size.as_vec2());
        let pixel = exit_position.as_ivec2().min(size - 1);
        let far_corner = IVec2::new(i32::from(ray.inverse.x > 0.0), i32::from(ray.inverse.y > 0.0)) * size;
        let side_s = (far_corner.as_vec2() - ray.start) * ray.inverse;
        let leaves_far = ray.rate.z < 0.0 && ray.end < side_s.x.min(side_s.y);
        let shows_sky =
            !self.is_followed && hit.code == HitCode::Miss && leaves_far && self.block(pixel) == Block::EMPTY;
        shows_sky.then_some(Hit { pixel, position: exit_position, ..*hit })
    }
}
