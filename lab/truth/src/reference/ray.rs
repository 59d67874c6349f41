//! Reflection rays in the image, in f64: their set-up and clipping (docs/definitions.md, "Oracle", items 1 and 2;
//! docs/numerics.md, "What a robust method does", item 1), and the ways in which they can end.
//!
//! The oracle and the hierarchical traversal start from the same [`Segment`] and use its expressions to find where a
//! pixel boundary is crossed. Both therefore see the same depths at the same places and can be compared exactly.

use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};
use ssct_scenes::GBufferData;

/// Why a ray hit nothing (docs/definitions.md, "Oracle", item 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MissReason {
    /// The ray left the screen by one of its four sides.
    LeftScreen,
    /// The ray went behind the camera's near plane.
    Near,
    /// The ray went beyond the far plane.
    Far,
    /// There is no ray: the pixel is sky, or its normal or the direction has no length.
    NoRay,
}

/// How a ray ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// The ray hit the block of a pixel.
    Hit {
        /// The index (i, j) of the pixel.
        pixel: [u32; 2],
        /// Pixel x, pixel y (continuous) and reversed depth.
        position: DVec3,
    },
    /// The ray hit nothing.
    Miss {
        /// Why the ray hit nothing.
        reason: MissReason,
        /// Whether the ray ended behind the back of the last pixel's block.
        behind: bool,
    },
}

/// The result of tracing a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trace {
    /// How the ray ended.
    pub outcome: Outcome,
    /// The number of pixels (oracle) or cells (hierarchy) that were examined.
    pub steps: u32,
}

impl Trace {
    /// The result for a pixel without a ray.
    pub const NO_RAY: Self = Self { outcome: Outcome::Miss { reason: MissReason::NoRay, behind: false }, steps: 0 };

    /// Returns the continuous pixel coordinates and the reversed depth of the hit; `None` for a miss.
    pub fn position(&self) -> Option<DVec3> {
        match self.outcome {
            Outcome::Hit { position, .. } => Some(position),
            Outcome::Miss { .. } => None,
        }
    }

    /// Returns the continuous pixel coordinates of the hit, which `metrics::hits` compares; `None` for a miss.
    pub fn position_px(&self) -> Option<[f64; 2]> {
        self.position().map(|p| [p.x, p.y])
    }
}

/// The visible part of a ray: a straight line in (pixel x, pixel y, reversed depth), with a parameter s from 0
/// at the pixel's centre to 1 where it leaves the frustum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The point at s = 0.
    pub start: DVec3,
    /// The vector from the start to the end; zero if the ray leaves the frustum at once.
    pub delta: DVec3,
    /// The ray's unit direction in view space.
    pub direction: DVec3,
    /// The side of the frustum at which the segment ends.
    pub end: MissReason,
}

impl Segment {
    /// Returns the point at the parameter s (0 to 1): pixel x, pixel y and reversed depth.
    pub fn point_at(&self, s: f64) -> DVec3 {
        self.start + s * self.delta
    }

    /// Returns the reversed depth at the parameter s (0 to 1); monotonic in s, even under rounding.
    pub fn depth_at(&self, s: f64) -> f64 {
        self.start.z + s * self.delta.z
    }

    /// Returns the parameter s where the ray crosses the line x = `boundary` (axis 0) or y = `boundary` (axis 1), in
    /// pixels; infinite if the ray does not move along that axis. The result increases with the boundary's distance
    /// from the start, even under rounding.
    pub fn crossing(&self, axis: usize, boundary: i32) -> f64 {
        if self.delta[axis] == 0.0 {
            return f64::INFINITY;
        }
        (f64::from(boundary) - self.start[axis]) / self.delta[axis]
    }
}

/// Computes the rays of a G-buffer.
#[derive(Debug, Clone)]
pub struct RaySetup<'a> {
    /// The G-buffer.
    pub gbuffer: &'a GBufferData,
    view_to_clip: DMat4,
    clip_to_view: DMat4,
}

impl<'a> RaySetup<'a> {
    /// Prepares the rays of a G-buffer: inverts the projection matrix once, for all rays.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        let view_to_clip = gbuffer.view_to_clip();
        Self { gbuffer, view_to_clip, clip_to_view: view_to_clip.inverse() }
    }

    /// Returns the view-space position of the centre of pixel (x, y) at the pixel's own depth; `None` for sky.
    pub fn position(&self, x: u32, y: u32) -> Option<DVec3> {
        let depth = self.gbuffer.depth[self.gbuffer.index(x, y)];
        let centre = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        (depth > 0.0).then(|| self.gbuffer.unproject(centre.x, centre.y, f64::from(depth), &self.clip_to_view))
    }

    /// Returns the unit view-space normal of pixel (x, y); `None` if it has none.
    pub fn normal(&self, x: u32, y: u32) -> Option<DVec3> {
        self.gbuffer.normal[self.gbuffer.index(x, y)].as_dvec3().try_normalize()
    }

    /// Returns the unit direction in view space of the ray of sight through a place on the screen, in continuous pixel
    /// coordinates.
    pub fn camera_ray(&self, x: f64, y: f64) -> DVec3 {
        self.gbuffer.camera.sight(self.gbuffer.unproject(x, y, 0.5, &self.clip_to_view))
    }

    /// Returns the unit mirror direction of pixel (x, y) in view space: the direction of sight, reflected at the unit
    /// normal. `None` for sky and for a pixel without a normal.
    pub fn mirror(&self, x: u32, y: u32) -> Option<DVec3> {
        let incident = self.gbuffer.camera.sight(self.position(x, y)?);
        Some(incident.reflect(self.normal(x, y)?)).filter(|mirror| mirror.is_finite())
    }

    /// Returns the visible part of the ray from the centre of pixel (x, y) along a view-space direction of any length.
    /// `None` for sky and for a direction of length zero.
    pub fn segment(&self, x: u32, y: u32, direction: DVec3) -> Option<Segment> {
        let depth = f64::from(self.gbuffer.depth[self.gbuffer.index(x, y)]);
        let start = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, depth);
        self.visible_segment(start, self.position(x, y)?, direction)
    }

    /// Returns the visible part of the ray from any point in view space; `None` for a direction of length zero, or if
    /// the point is not ahead of the eye of a perspective camera.
    pub fn segment_from(&self, point: DVec3, direction: DVec3) -> Option<Segment> {
        self.visible_segment(self.gbuffer.project(point, &self.view_to_clip)?, point, direction)
    }

    /// Returns the view-space point at continuous pixel coordinates and a reversed depth.
    pub fn unproject(&self, position: DVec3) -> DVec3 {
        self.gbuffer.unproject(position.x, position.y, position.z, &self.clip_to_view)
    }

    /// Returns the continuous pixel coordinates and the reversed depth of a point in view space; `None` if it is not
    /// ahead of the eye.
    pub fn project(&self, point: DVec3) -> Option<DVec3> {
        self.gbuffer.project(point, &self.view_to_clip)
    }

    /// Returns the ray from a point in view space, which projects to `start`, cut where it leaves the frustum. `None`
    /// for a direction of length zero and for rays that are not finite.
    fn visible_segment(&self, start: DVec3, point: DVec3, direction: DVec3) -> Option<Segment> {
        let direction = direction.try_normalize()?;
        let clip_start = self.view_to_clip * point.extend(1.0);
        let clip_direction = self.view_to_clip * direction.extend(0.0);
        let (t, end) = clip(clip_start, clip_direction)?;
        // The difference of the two projected points, rearranged to avoid cancellation:
        // (P + tD).xyz / (P + tD).w − P.xyz / P.w, with P = `clip_start` and D = `clip_direction`.
        let scale = t / (clip_start.w * (clip_start.w + t * clip_direction.w));
        let delta = (clip_direction.xyz() * clip_start.w - clip_start.xyz() * clip_direction.w) * scale;
        let half_size = DVec2::new(f64::from(self.gbuffer.width), f64::from(self.gbuffer.height)) * 0.5;
        let segment = Segment {
            start,
            delta: DVec3::new(half_size.x * delta.x, -half_size.y * delta.y, delta.z),
            direction,
            end,
        };
        segment.delta.is_finite().then_some(segment)
    }
}

/// Returns the t at which the clip-space line `start` + t · `direction` leaves the frustum, and the side where it does.
/// `None` if the line leaves by no side, because of NaN.
fn clip(start: DVec4, direction: DVec4) -> Option<(f64, MissReason)> {
    // Each plane has its value at the start and its rate along the direction. Values inside are ≥ 0; depth is reversed.
    let planes = [
        (start.w + start.x, direction.w + direction.x, MissReason::LeftScreen),
        (start.w - start.x, direction.w - direction.x, MissReason::LeftScreen),
        (start.w + start.y, direction.w + direction.y, MissReason::LeftScreen),
        (start.w - start.y, direction.w - direction.y, MissReason::LeftScreen),
        (start.w - start.z, direction.w - direction.z, MissReason::Near),
        (start.z, direction.z, MissReason::Far),
    ];
    // The start is inside by definition; a value below 0 (at the near plane) is a rounding error.
    let planes_ahead = planes.into_iter().filter(|(_, rate, _)| *rate < 0.0);
    planes_ahead.map(|(value, rate, reason)| (value.max(0.0) / -rate, reason)).min_by(|(a, _), (b, _)| a.total_cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{flat_wall, gbuffer_from};
    use glam::Vec3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_segment_is_the_projection_of_the_ray(
            x in 0..16_u32, y in 0..9_u32, z in 0.11..900.0_f64, t in 0.0..1.0_f64,
            direction in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let gbuffer = flat_wall(16, 9, z);
            let setup = RaySetup::new(&gbuffer);
            let direction = DVec3::from(direction);
            prop_assume!(direction.length() > 1e-2);
            let segment = setup.segment(x, y, direction).expect("a ray");
            let size = DVec3::new(16.0, 9.0, 1.0);
            // The end must be on the named side of the frustum and not outside the other sides.
            let end = segment.point_at(1.0) / size;
            prop_assert!(end.cmpge(DVec3::splat(-1e-9)).all() && end.cmple(DVec3::splat(1.0 + 1e-9)).all(), "{end}");
            // Distance from the nearer of the sides 0 and 1.
            let side_distance = |v: f64| v.abs().min((v - 1.0).abs());
            let named_side_distance = match segment.end {
                MissReason::LeftScreen => side_distance(end.x).min(side_distance(end.y)),
                MissReason::Near => (end.z - 1.0).abs(),
                _ => end.z.abs(),
            };
            prop_assert!(named_side_distance < 1e-9, "{segment:?}");
            // A view-space point of the ray that is in the frustum must be on the segment.
            let position = setup.position(x, y).expect("no sky");
            let point = position + direction.normalize() * t * z;
            let projected = gbuffer.project(point, &gbuffer.view_to_clip());
            let is_inside = |p: &DVec3| (*p / size).cmpge(DVec3::ZERO).all() && (*p / size).cmple(DVec3::ONE).all();
            if let Some(place) = projected.filter(is_inside) {
                let (offset, delta) = ((place - segment.start) / size, segment.delta / size);
                let is_on_segment = offset.cross(delta).length() < 1e-9 && offset.dot(delta) >= -1e-9;
                prop_assert!(is_on_segment, "{place} is off {segment:?}");
            }
        }
    }

    #[test]
    fn rays_without_a_direction_are_none() {
        let mut gbuffer = flat_wall(3, 1, 2.0);
        gbuffer.depth[1] = 0.0;
        gbuffer.normal[2] = Vec3::ZERO;
        let setup = RaySetup::new(&gbuffer);
        assert!(setup.mirror(0, 0).is_some());
        assert!(setup.mirror(1, 0).is_none() && setup.segment(1, 0, DVec3::Z).is_none(), "sky");
        assert!(setup.mirror(2, 0).is_none() && setup.segment(2, 0, DVec3::Z).is_some(), "no normal");
        assert!(setup.segment(0, 0, DVec3::ZERO).is_none() && setup.segment(0, 0, DVec3::NAN).is_none());
    }

    #[test]
    fn a_pixel_on_the_near_plane_can_send_its_ray_into_the_scene_but_not_out() {
        let gbuffer = gbuffer_from(1, 1, |_, _| 1.0, |_, _| Vec3::NEG_Z);
        let setup = RaySetup::new(&gbuffer);
        let into = setup.segment(0, 0, DVec3::Z).expect("a ray");
        assert!((into.point_at(1.0).z).abs() < 1e-12 && into.end == MissReason::Far);
        let out = setup.segment(0, 0, DVec3::NEG_Z).expect("a ray");
        assert!(out.delta.length() < 1e-6 && out.end == MissReason::Near);
    }
}
