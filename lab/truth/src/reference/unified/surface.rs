//! Twin of `unified/surface.glsl` and of `GoesFar`: which pixels show the surface that a ray hit, and the sky that the
//! screen shows to a ray.

use super::{Block, Code, Hit, Ray, Traversal, dot};
use crate::math::constants::{IN_PLANE, LEAST_FACING, ROUNDING, SAME_NORMAL};
use glam::{IVec2, Vec2, Vec3};

const DEPTH_ERROR: f32 = 4.0 * ROUNDING as f32;

/// `Plane`: the plane in which a pixel's surface lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pixel: Vec2,
    depth: f32,
    slope: Vec2,
    off: f32,
    normal: Vec3,
    squared: f32,
}

impl Traversal<'_> {
    /// `PlaneOf` a pixel.
    pub(super) fn plane(&self, pixel: IVec2) -> Plane {
        let (p, depth, normal) = (&self.parameters, self.block(pixel).front, self.normal(pixel));
        let is_linear = p.kind.is_orthographic();
        let (view, _) = self.pixel_point(pixel);
        let sight = view.extend(1.0);
        let size = (dot(normal, normal) * dot(sight, sight)).sqrt();
        let (facing, least) = (dot(normal, sight), LEAST_FACING as f32 * size);
        let facing = if facing < 0.0 { facing.min(-least) } else { facing.max(least) };
        let rate = if is_linear { p.depth_offset } else { depth + p.depth_offset } / facing;
        let slope = rate * (2.0 * p.pixel_to_view * Vec2::new(normal.x, -normal.y));
        let off = rate.abs() * (size * (IN_PLANE as f32 * 2.0 * p.pixel_to_view.y));
        let squared = (SAME_NORMAL as f32 * SAME_NORMAL as f32) * dot(normal, normal);
        Plane { pixel: pixel.as_vec2(), depth, slope, off, normal, squared }
    }

    /// `IsOn`: whether a pixel shows the surface of a plane.
    pub(super) fn is_on(&self, plane: &Plane, pixel: IVec2, texel: f32) -> bool {
        let depth = self.block(pixel).front;
        let across = plane.slope * (pixel.as_vec2() - plane.pixel);
        let apart = (depth - plane.depth) - (across.x + across.y);
        let normal = self.normal(pixel);
        let along = dot(plane.normal, normal);
        let turned = along * along - plane.squared * dot(normal, normal);
        let is_other = apart.abs() > plane.off * texel + DEPTH_ERROR || along < 0.0 || turned < 0.0;
        if plane.depth < 0.0 { depth < 0.0 } else { depth >= 0.0 && !is_other }
    }

    /// `GoesFar`, and what is asked after it: where a ray that hit nothing went beyond the far plane, if the pixel there shows sky.
    pub(super) fn ends_on_sky(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let size = self.parameters.size;
        let position = (ray.start + ray.end * ray.rate.truncate()).clamp(Vec2::ZERO, size.as_vec2());
        let pixel = position.as_ivec2().min(size - 1);
        let side = IVec2::new(i32::from(ray.inverse.x > 0.0), i32::from(ray.inverse.y > 0.0)) * size;
        let sides = (side.as_vec2() - ray.start) * ray.inverse;
        let is_far = ray.rate.z < 0.0 && ray.end < sides.x.min(sides.y);
        let shows = !self.is_followed && hit.code == Code::Nothing && is_far && self.block(pixel) == Block::EMPTY;
        shows.then_some(Hit { pixel, position, ..*hit })
    }
}
