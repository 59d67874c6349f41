//! The colour of the surface that a ray hits on the screen (docs/definitions.md, "Image error"), in f64: of the four pixels
//! around the hit, those count that show the surface of the pixel that was hit.

use super::surface::sky_color;
use crate::math::constants::{IN_PLANE, LEAST_FACING, ROUNDING};
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
        let is_far = apart.abs() > plane.off;
        (depth > 0.0) == (plane.depth > 0.0) && g.surface[pixel] == g.surface[hit] && !is_far
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
    let corners = [(left, top, 1.0 - fx, 1.0 - fy), (right, top, fx, 1.0 - fy), (left, bottom, 1.0 - fx, fy), (right, bottom, fx, fy)];
    corners.map(|(x, y, wx, wy)| (gbuffer.index(x, y), wx * wy))
}
