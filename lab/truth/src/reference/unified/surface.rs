//! Twin of `unified/surface.glsl`: which pixels a ray can have seen around its hit, and the sky that the screen
//! shows to a ray.

use super::{Block, Code, Hit, Ray, Traversal, dot};
use crate::math::constants::{STANDS_ABOVE, STANDS_BEFORE, STANDS_BESIDE};
use glam::{IVec2, Vec3, Vec3Swizzles};

/// `Seeing`: the surface that reflects, its ray, and the pixel that the ray hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seeing {
    point: Vec3,
    normal: Vec3,
    direction: Vec3,
    sizes: [f32; 2],
    width: f32,
    own: f32,
    is_its: bool,
}

impl Traversal<'_> {
    /// A pixel's depth; that of an empty block for sky.
    pub(super) fn front(&self, pixel: IVec2) -> f32 {
        self.block(pixel).front
    }

    /// `SeeingFrom`: a ray along a direction from a point of a surface with a normal, which hit a pixel.
    pub(super) fn seeing(&self, [point, normal, direction]: [Vec3; 3], pixel: IVec2, texel: f32) -> Seeing {
        let sizes = [normal, direction].map(|v| dot(v, v).sqrt());
        let (width, own) = (2.0 * self.parameters.pixel_to_view.y * texel, self.front(pixel));
        let from = Seeing { point, normal, direction, sizes, width, own, is_its: false };
        let there = self.parameters.view_point(pixel.as_vec2() + 0.5, own.max(0.0));
        Seeing { is_its: own >= 0.0 && !self.is_above(&from, there), ..from }
    }

    /// `WidthAt`.
    fn width_at(&self, from: &Seeing, z: f32) -> f32 {
        from.width * if self.parameters.kind.is_orthographic() { 1.0 } else { z }
    }

    /// `IsAbove`: whether a place is nothing of the surface that reflects, nor of what is below it.
    fn is_above(&self, from: &Seeing, there: Vec3) -> bool {
        dot(from.normal, there - from.point) > STANDS_ABOVE as f32 * self.width_at(from, there.z) * from.sizes[0]
    }

    /// `IsSeen`: whether a ray can have seen what a pixel shows in the middle of a texel.
    pub(super) fn is_seen(&self, from: &Seeing, pixel: IVec2) -> bool {
        let (p, depth) = (&self.parameters, self.front(pixel));
        let scale = if p.kind.is_orthographic() { p.depth_offset } else { from.own + p.depth_offset };
        let apart = STANDS_BEFORE as f32 * from.width * scale;
        let there = p.view_point(pixel.as_vec2() + 0.5, depth.max(0.0));
        let (away, direction) = (there - from.point, from.direction);
        let beside = STANDS_BESIDE as f32 * self.width_at(from, there.z) * from.sizes[1];
        let off = away.yzx() * direction.zxy() - away.zxy() * direction.yzx();
        let is_beside = dot(off, off) > beside * beside;
        let is_seen = from.own >= 0.0 && self.is_above(from, there) && !(depth > from.own + apart && is_beside);
        (depth < 0.0 || is_seen) && !(from.is_its && depth < from.own - apart)
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
