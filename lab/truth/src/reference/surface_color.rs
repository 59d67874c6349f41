//! The colour of the surface that a ray hits on the screen (docs/definitions.md, "Image error"), in f64: of the four pixels
//! around the hit, those count that show the surface of the pixel that was hit.

use super::surface::sky_color;
use crate::math::constants::{IN_PLANE, LEAST_FACING, ROUNDING, SAME_NORMAL};
use crate::scene::{GBufferData, ProjectionKind, Surface};
use glam::{DVec2, DVec3};

/// By how much depth may be rounded: a rasteriser interpolates it between corners that may lie at the near plane, where it is 1.
const DEPTH_ERROR: f64 = 4.0 * ROUNDING;

/// The colours that a G-buffer's pixels show to rays.
#[derive(Debug, Clone)]
pub struct SurfaceColors<'a> {
    gbuffer: &'a GBufferData,
    kind: ProjectionKind,
    /// What makes the depth of a perspective, plus this, proportional to 1 / z; without perspective, the change of depth with each
    /// metre of z.
    depth_offset: f64,
    /// Half a pixel's width and height, at z = 1 in a perspective.
    pixel_to_view: DVec2,
    /// How far the image is shifted against the axis of the view, in half pixels.
    shift: DVec2,
}

/// The plane in which a pixel's surface lies: depth is linear on it over the image.
#[derive(Debug, Clone, Copy)]
struct Plane {
    pixel: DVec2,
    depth: f64,
    /// The change of depth with each pixel to the right, and with each pixel down.
    slope: DVec2,
    /// By so much the depth of another pixel may differ from the plane's. NaN for a pixel without a normal, which has no plane.
    off: f64,
}

impl<'a> SurfaceColors<'a> {
    /// Reads the projection of a G-buffer.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        let (projection, kind) = (gbuffer.view_to_clip(), gbuffer.camera.kind());
        let size = DVec2::new(f64::from(gbuffer.width), f64::from(gbuffer.height));
        let shift = if kind.is_orthographic() { projection.w_axis } else { projection.z_axis };
        Self {
            gbuffer,
            kind,
            depth_offset: -projection.z_axis.z,
            pixel_to_view: 1.0 / (size * DVec2::new(projection.x_axis.x, projection.y_axis.y)),
            shift: size * shift.truncate().truncate(),
        }
    }

    /// What the screen shows to a ray that ends at a place of a pixel, in continuous pixel coordinates: on a surface that shows the
    /// environment, the environment along the ray's direction in the world; elsewhere the lit colour between the pixels around that
    /// show the same surface, by their bilinear weights.
    pub fn shown(&self, pixel: usize, [x, y]: [f64; 2], towards: DVec3) -> DVec3 {
        let g = self.gbuffer;
        if g.surface[pixel] == Surface::Sky {
            return sky_color(towards);
        }
        let (plane, mut sum, mut counted) = (self.plane(pixel), DVec3::ZERO, 0.0);
        for (index, weight) in around(g, x, y) {
            if index == pixel || self.is_on(plane, index, pixel) {
                sum += weight * g.color[index].as_dvec3();
                counted += weight;
            }
        }
        // A place that rounding puts beside its pixel may have none around it that counts.
        if counted > 0.0 { sum / counted } else { g.color[pixel].as_dvec3() }
    }

    fn place(&self, pixel: usize) -> DVec2 {
        let width = self.gbuffer.width as usize;
        DVec2::new((pixel % width) as f64, (pixel / width) as f64)
    }

    fn plane(&self, pixel: usize) -> Plane {
        let (place, depth) = (self.place(pixel), f64::from(self.gbuffer.depth[pixel]));
        let normal = self.gbuffer.normal[pixel].as_dvec3();
        let size = DVec2::new(f64::from(self.gbuffer.width), f64::from(self.gbuffer.height));
        let centre = (2.0 * place + 1.0 - size) * DVec2::new(1.0, -1.0) - self.shift;
        let is_orthographic = self.kind.is_orthographic();
        let sight = if is_orthographic { DVec3::Z } else { (centre * self.pixel_to_view).extend(1.0) };
        let length = normal.length() * sight.length();
        let least = LEAST_FACING * length;
        let facing = normal.dot(sight);
        let facing = if facing < 0.0 { facing.min(-least) } else { facing.max(least) };
        let rate = if is_orthographic { self.depth_offset } else { depth + self.depth_offset } / facing;
        Plane {
            pixel: place,
            depth,
            slope: rate * 2.0 * self.pixel_to_view * DVec2::new(normal.x, -normal.y),
            off: rate.abs() * length * IN_PLANE * 2.0 * self.pixel_to_view.y + DEPTH_ERROR,
        }
    }

    /// Whether a pixel shows the surface of a plane, which is that of the pixel `hit`.
    fn is_on(&self, plane: Plane, pixel: usize, hit: usize) -> bool {
        let (g, depth) = (self.gbuffer, f64::from(self.gbuffer.depth[pixel]));
        let apart = depth - plane.depth - plane.slope.dot(self.place(pixel) - plane.pixel);
        let [normal, other] = [hit, pixel].map(|i| g.normal[i].as_dvec3());
        let is_turned = normal.dot(other) < SAME_NORMAL * normal.length() * other.length();
        let is_other = apart.abs() > plane.off || is_turned;
        let is_same = if plane.depth > 0.0 { depth > 0.0 && !is_other } else { depth <= 0.0 };
        is_same && g.surface[pixel] == g.surface[hit]
    }
}

/// The four pixels around continuous pixel coordinates, clamped at the border, with their bilinear weights.
fn around(gbuffer: &GBufferData, x: f64, y: f64) -> [(usize, f64); 4] {
    let axis = |v: f64, side: u32| {
        let v = (v - 0.5).clamp(0.0, f64::from(side - 1));
        let low = v.floor() as u32;
        (low, (low + 1).min(side - 1), v - v.floor())
    };
    let (left, right, fx) = axis(x, gbuffer.width);
    let (top, bottom, fy) = axis(y, gbuffer.height);
    let corners = [
        (left, top, 1.0 - fx, 1.0 - fy),
        (right, top, fx, 1.0 - fy),
        (left, bottom, 1.0 - fx, fy),
        (right, bottom, fx, fy),
    ];
    corners.map(|(x, y, wx, wy)| (gbuffer.index(x, y), wx * wy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{flat, floor_and_wall};
    use glam::Vec3;

    /// The first row of the floor of [`floor_and_wall`].
    fn first_floor_row(g: &GBufferData) -> u32 {
        (0..g.height).find(|y| g.normal[g.index(0, *y)] == Vec3::Y).expect("a floor")
    }

    #[test]
    fn surfaces_that_meet_do_not_mix() {
        let mut g = floor_and_wall(32, 18);
        for (color, normal) in g.color.iter_mut().zip(&g.normal) {
            *color = if *normal == Vec3::Y { Vec3::X } else { Vec3::Z };
        }
        let (colors, foot) = (SurfaceColors::new(&g), first_floor_row(&g));
        for x in 0..32 {
            let shown = |row: u32, y: f64| colors.shown(g.index(x, row), [f64::from(x) + 0.8, y], DVec3::Z);
            assert_eq!(shown(foot - 1, f64::from(foot) - 0.1), DVec3::Z, "the wall at {x}");
            assert_eq!(shown(foot, f64::from(foot) + 0.1), DVec3::X, "the floor at {x}");
        }
    }

    #[test]
    fn a_plane_is_interpolated_at_any_angle() {
        // Colours that are linear over the image stay so, on the wall and on the floor, but where another surface is beside.
        let mut g = floor_and_wall(32, 18);
        for (i, color) in g.color.iter_mut().enumerate() {
            *color = Vec3::new((i % 32) as f32, (i / 32) as f32, 0.0);
        }
        let (colors, foot) = (SurfaceColors::new(&g), first_floor_row(&g));
        for (x, row) in (1..31).flat_map(|x| (1..17).map(move |y| (x, y))).filter(|(_, y)| *y != foot && *y != foot - 1)
        {
            let place = [f64::from(x) + 0.7, f64::from(row) + 0.2];
            let shown = colors.shown(g.index(x, row), place, DVec3::Z);
            assert!((shown - DVec3::new(place[0] - 0.5, place[1] - 0.5, 0.0)).length() < 1e-9, "({x}, {row}): {shown}");
        }
    }

    #[test]
    fn what_stands_before_a_parallel_wall_and_sky_do_not_mix_with_it() {
        // The left half nearer than the right one, with the same normal; one pixel of sky.
        let mut g = flat(4, 2, 4.0);
        let near = flat(4, 2, 3.5).depth[0];
        for y in 0..2 {
            for x in 0..4 {
                let i = g.index(x, y);
                g.color[i] = if x < 2 { Vec3::X } else { Vec3::Y };
                g.depth[i] = if x < 2 { near } else { g.depth[i] };
            }
        }
        let sky = g.index(3, 0);
        (g.depth[sky], g.normal[sky], g.color[sky]) = (0.0, Vec3::ZERO, Vec3::Z);
        let colors = SurfaceColors::new(&g);
        let shown = |x: u32, place: [f64; 2]| colors.shown(g.index(x, 0), place, DVec3::Z);
        assert_eq!(shown(1, [1.9, 0.9]), DVec3::X);
        assert_eq!(shown(2, [2.1, 0.9]), DVec3::Y);
        assert_eq!(shown(2, [2.9, 0.9]), DVec3::Y);
        assert_eq!(shown(3, [3.1, 0.9]), DVec3::Z, "sky is a surface of its own");
    }

    #[test]
    fn without_a_normal_all_around_counts_but_sky() {
        let mut g = flat(3, 1, 4.0);
        for (i, color) in g.color.iter_mut().enumerate() {
            *color = Vec3::splat(i as f32);
        }
        g.normal[1] = Vec3::ZERO;
        g.depth[2] *= 0.5;
        assert_eq!(SurfaceColors::new(&g).shown(1, [1.75, 0.5], DVec3::Z), DVec3::splat(1.25));
        g.depth[2] = 0.0;
        assert_eq!(SurfaceColors::new(&g).shown(1, [1.75, 0.5], DVec3::Z), DVec3::splat(1.0));
    }
}
