//! Twin of `unified/surface.glsl` and of `GoesFar`: which pixels a ray can have seen around its hit, and the sky that the screen
//! shows to a ray.

use super::{Block, Code, Hit, Ray, Traversal, dot};
use crate::math::constants::{STANDS_ABOVE, STANDS_BEFORE};
use glam::{IVec2, Vec3};

/// `Seeing`: the surface that reflects, and the pixel that its ray hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seeing {
    point: Vec3,
    normal: Vec3,
    size: f32,
    own: f32,
}

impl Seeing {
    /// `SeeingFrom`.
    pub(super) fn new(point: Vec3, normal: Vec3, own: f32) -> Self {
        Self { point, normal, size: dot(normal, normal).sqrt(), own }
    }
}

impl Traversal<'_> {
    /// A pixel's depth; that of an empty block for sky.
    pub(super) fn front(&self, pixel: IVec2) -> f32 {
        self.block(pixel).front
    }

    /// `IsSeen`: whether a ray can have seen what a pixel shows in the middle of a texel that is so many pixels wide.
    pub(super) fn is_seen(&self, from: &Seeing, pixel: IVec2, texel: f32) -> bool {
        let (p, depth) = (&self.parameters, self.front(pixel));
        let is_linear = p.kind.is_orthographic();
        let width = 2.0 * p.pixel_to_view.y * texel;
        let before = STANDS_BEFORE as f32 * width;
        let nearest = from.own + if is_linear { before * p.depth_offset } else { (from.own + p.depth_offset) * before };
        let there = p.view_point(pixel.as_vec2() + 0.5, depth.max(0.0));
        let least = STANDS_ABOVE as f32 * width * if is_linear { 1.0 } else { there.z } * from.size;
        let (is_before, is_above) = (depth > nearest, dot(from.normal, there - from.point) > least);
        depth < 0.0 || from.own >= 0.0 && !is_before && is_above
    }

    /// `GoesFar`, and what is asked after it: where a ray that hit nothing went beyond the far plane, if the pixel there shows sky.
    pub(super) fn ends_on_sky(&self, ray: &Ray, hit: &Hit) -> Option<Hit> {
        let size = self.parameters.size;
        let position = (ray.start + ray.end * ray.rate.truncate()).clamp(glam::Vec2::ZERO, size.as_vec2());
        let pixel = position.as_ivec2().min(size - 1);
        let side = IVec2::new(i32::from(ray.inverse.x > 0.0), i32::from(ray.inverse.y > 0.0)) * size;
        let sides = (side.as_vec2() - ray.start) * ray.inverse;
        let is_far = ray.rate.z < 0.0 && ray.end < sides.x.min(sides.y);
        let shows = !self.is_followed && hit.code == Code::Nothing && is_far && self.block(pixel) == Block::EMPTY;
        shows.then_some(Hit { pixel, position, ..*hit })
    }
}
