//! The colour that a ray sees where it hits on the screen (docs/definitions.md, "The colour of a hit"), in f64. It is
//! the mean of those of the four pixels around the hit that the ray can have seen.

use super::surface::sky_color;
use glam::{DVec2, DVec3};
use ssct_ground::math::constants::{STANDS_ABOVE, STANDS_BEFORE, STANDS_BESIDE};
use ssct_scenes::{GBufferData, Surface};

/// Computes the colours that a G-buffer's pixels show to rays.
#[derive(Debug, Clone)]
pub struct SurfaceColors<'a> {
    gbuffer: &'a GBufferData,
    is_orthographic: bool,
    /// In a perspective: the number that is added to the depth so that the sum is proportional to 1 / z. In an
    /// orthographic projection: the decrease of depth with each metre of z.
    depth_offset: f64,
    /// In a perspective: z · (depth + `depth_offset`), which is the same for all pixels, in metres. In an orthographic
    /// projection: the depth at z = 0.
    depth_unit: f64,
    /// Half of a pixel's width and height in metres; in a perspective, at z = 1.
    pixel_to_view: DVec2,
    /// Shift of the image against the axis of the view, in half pixels.
    shift: DVec2,
}

/// A reflected ray in view space, with the surface that reflects it.
#[derive(Debug, Clone, Copy)]
pub struct ReflectedRay {
    /// Where the ray begins on the surface, in metres.
    pub point: DVec3,
    /// The surface's unit normal.
    pub normal: DVec3,
    /// The ray's unit direction.
    pub direction: DVec3,
}

impl<'a> SurfaceColors<'a> {
    /// Prepares the colours of a G-buffer, by the numbers of its projection.
    pub fn new(gbuffer: &'a GBufferData) -> Self {
        let (projection, is_orthographic) = (gbuffer.view_to_clip(), gbuffer.camera.kind().is_orthographic());
        let size = DVec2::new(f64::from(gbuffer.width), f64::from(gbuffer.height));
        let shift = if is_orthographic { projection.w_axis } else { projection.z_axis };
        Self {
            gbuffer,
            is_orthographic,
            depth_offset: -projection.z_axis.z,
            depth_unit: projection.w_axis.z,
            pixel_to_view: 1.0 / (size * DVec2::new(projection.x_axis.x, projection.y_axis.y)),
            shift: size * shift.truncate().truncate(),
        }
    }

    /// Returns the linear colour that a ray sees if it ends in a pixel at the place (x, y), in continuous pixel
    /// coordinates. A sky surface shows the environment along the ray's `world_direction`. Elsewhere the lit colour is
    /// interpolated bilinearly between the four pixels around the place that the ray can have seen; if there are none,
    /// the pixel's own colour is used. Without a `ray` all four pixels count.
    pub fn shown(&self, pixel: usize, [x, y]: [f64; 2], world_direction: DVec3, ray: Option<ReflectedRay>) -> DVec3 {
        let gbuffer = self.gbuffer;
        if gbuffer.surface[pixel] == Surface::Sky {
            return sky_color(world_direction);
        }
        let (mut sum, mut weight_sum) = (DVec3::ZERO, 0.0);
        for (index, weight) in bilinear_pixels(gbuffer, x, y) {
            if ray.is_none_or(|ray| self.is_seen(index, pixel, ray)) {
                let shows_sky = gbuffer.surface[index] == Surface::Sky;
                sum += weight * if shows_sky { sky_color(world_direction) } else { gbuffer.color[index].as_dvec3() };
                weight_sum += weight;
            }
        }
        if weight_sum > 0.0 { sum / weight_sum } else { gbuffer.color[pixel].as_dvec3() }
    }

    /// Returns the view-space z of a reversed depth, in metres.
    fn z(&self, depth: f64) -> f64 {
        if self.is_orthographic {
            (self.depth_unit - depth) / self.depth_offset
        } else {
            self.depth_unit / (depth + self.depth_offset)
        }
    }

    /// Returns the view-space point in the middle of a pixel, at a given z, in metres.
    fn point(&self, pixel: usize, z: f64) -> DVec3 {
        let (width, height) = (self.gbuffer.width as usize, self.gbuffer.height as usize);
        let place = DVec2::new((pixel % width) as f64, (pixel / width) as f64);
        let size = DVec2::new(width as f64, height as f64);
        let centred = (2.0 * place + 1.0 - size) * DVec2::new(1.0, -1.0) - self.shift;
        (centred * self.pixel_to_view * if self.is_orthographic { 1.0 } else { z }).extend(z)
    }

    /// Returns whether a ray that hit the pixel `hit` can have seen the surface of `pixel`. That surface is not seen if
    /// it stands before the hit on the screen but far beside the ray. The reflecting surface, and everything below it,
    /// is never seen. If the hit pixel shows the reflecting surface, the ray has met an object that stands on it, and
    /// nothing behind the hit is seen. Sky lies behind everything.
    fn is_seen(&self, pixel: usize, hit: usize, ray: ReflectedRay) -> bool {
        let [depth, hit_depth] = [pixel, hit].map(|i| f64::from(self.gbuffer.depth[i]));
        // A ray that ended in sky sees sky alone.
        if hit_depth <= 0.0 {
            return depth <= 0.0;
        }
        let hit_z = self.z(hit_depth);
        let is_reflector = !self.is_above(hit, hit_z, ray);
        if depth <= 0.0 {
            return !is_reflector;
        }
        let z = self.z(depth);
        // By how many metres the pixel's surface lies behind the hit, and the least distance of separate surfaces.
        let (behind, least_gap) = (z - hit_z, STANDS_BEFORE * self.width(z));
        let is_beside =
            (self.point(pixel, z) - ray.point).cross(ray.direction).length() > STANDS_BESIDE * self.width(z);
        self.is_above(pixel, z, ray) && !(behind < -least_gap && is_beside) && !(is_reflector && behind > least_gap)
    }

    /// Returns the width of a pixel at a view-space z, in metres.
    fn width(&self, z: f64) -> f64 {
        2.0 * self.pixel_to_view.y * if self.is_orthographic { 1.0 } else { z }
    }

    /// Returns whether the point of a pixel at a view-space z lies above the reflecting surface, so that a reflected
    /// ray can see it.
    fn is_above(&self, pixel: usize, z: f64, ray: ReflectedRay) -> bool {
        ray.normal.dot(self.point(pixel, z) - ray.point) > STANDS_ABOVE * self.width(z)
    }
}

/// Returns the indices of the four pixels around continuous pixel coordinates, clamped at the border, each with its
/// bilinear weight.
fn bilinear_pixels(gbuffer: &GBufferData, x: f64, y: f64) -> [(usize, f64); 4] {
    // The two pixels around a coordinate, and the share of the second one.
    let neighbours = |coordinate: f64, side: u32| {
        let coordinate = (coordinate - 0.5).clamp(0.0, f64::from(side - 1));
        let low = coordinate.floor() as u32;
        (low, (low + 1).min(side - 1), coordinate - coordinate.floor())
    };
    let (left, right, right_share) = neighbours(x, gbuffer.width);
    let (top, bottom, bottom_share) = neighbours(y, gbuffer.height);
    let corners = [
        (left, top, 1.0 - right_share, 1.0 - bottom_share),
        (right, top, right_share, 1.0 - bottom_share),
        (left, bottom, 1.0 - right_share, bottom_share),
        (right, bottom, right_share, bottom_share),
    ];
    corners.map(|(x, y, weight_x, weight_y)| (gbuffer.index(x, y), weight_x * weight_y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::ray::RaySetup;
    use crate::reference::testing::{flat_wall, floor_and_wall};
    use glam::Vec3;

    /// Returns the G-buffer of a red floor and a blue wall, the number of the floor's first row, and a ray from the
    /// floor's second row towards the wall.
    fn stage() -> (GBufferData, u32, ReflectedRay) {
        let mut gbuffer = floor_and_wall(32, 18);
        for (color, normal) in gbuffer.color.iter_mut().zip(&gbuffer.normal) {
            *color = if *normal == Vec3::Y { Vec3::X } else { Vec3::Z };
        }
        let first_floor_row =
            (0..gbuffer.height).find(|y| gbuffer.normal[gbuffer.index(0, *y)] == Vec3::Y).expect("a floor");
        let point = RaySetup::new(&gbuffer).position(16, first_floor_row + 1).expect("no sky");
        (gbuffer, first_floor_row, ReflectedRay { point, normal: DVec3::Y, direction: DVec3::Z })
    }

    #[test]
    fn the_foot_of_a_wall_has_nothing_of_the_floor_that_reflects_it() {
        let (gbuffer, first_floor_row, ray) = stage();
        let colors = SurfaceColors::new(&gbuffer);
        for x in 0..32 {
            // The places lie in the wall's last row and in the floor's first row.
            for (row, y) in [(first_floor_row - 1, -0.1), (first_floor_row, 0.1)] {
                let (pixel, place) = (gbuffer.index(x, row), [f64::from(x) + 0.8, f64::from(first_floor_row) + y]);
                assert_eq!(colors.shown(pixel, place, DVec3::Z, Some(ray)), DVec3::Z, "{x}, {row}");
                let mixed = colors.shown(pixel, place, DVec3::Z, None);
                assert!(mixed.x > 0.3 && mixed.z > 0.3, "{x}: {mixed} of a ray that nobody knows");
            }
        }
    }

    #[test]
    fn a_hit_on_the_surface_that_reflects_has_its_colour_where_nothing_else_is_around() {
        let (gbuffer, first_floor_row, ray) = stage();
        let shown = SurfaceColors::new(&gbuffer).shown(
            gbuffer.index(5, first_floor_row + 4),
            [5.5, f64::from(first_floor_row) + 4.5],
            DVec3::Z,
            Some(ray),
        );
        assert_eq!(shown, DVec3::X);
    }

    #[test]
    fn colours_go_on_evenly_where_all_can_be_seen() {
        let (mut gbuffer, first_floor_row, ray) = stage();
        for (i, color) in gbuffer.color.iter_mut().enumerate() {
            *color = Vec3::new((i % 32) as f32, (i / 32) as f32, 0.0);
        }
        let colors = SurfaceColors::new(&gbuffer);
        for (x, row) in (1..31).flat_map(|x| (1..first_floor_row - 1).map(move |y| (x, y))) {
            let place = [f64::from(x) + 0.7, f64::from(row) + 0.2];
            let shown = colors.shown(gbuffer.index(x, row), place, DVec3::Z, Some(ray));
            assert!((shown - DVec3::new(place[0] - 0.5, place[1] - 0.5, 0.0)).length() < 1e-9, "({x}, {row}): {shown}");
        }
    }

    /// Returns the G-buffer of two walls side by side, with a pixel of sky in the right one. The left wall, which is
    /// nearer, is red, the right one green, and the sky blue.
    fn near_and_far() -> GBufferData {
        let mut gbuffer = flat_wall(64, 36, 40.0);
        let near = flat_wall(64, 36, 1.0).depth[0];
        for (x, i) in (0..36).flat_map(|y| (0..64).map(move |x| (x, 64 * y + x))) {
            gbuffer.color[i] = if x < 32 { Vec3::X } else { Vec3::Y };
            gbuffer.depth[i] = if x < 32 { near } else { gbuffer.depth[i] };
        }
        let sky = gbuffer.index(40, 0);
        (gbuffer.depth[sky], gbuffer.normal[sky], gbuffer.color[sky]) = (0.0, Vec3::ZERO, Vec3::Z);
        gbuffer
    }

    #[test]
    fn what_stands_before_a_hit_is_part_of_it_only_near_the_ray() {
        let gbuffer = near_and_far();
        let (colors, rays) = (SurfaceColors::new(&gbuffer), RaySetup::new(&gbuffer));
        let [near_point, far_point] = [31, 32].map(|x| rays.position(x, 0).expect("no sky"));
        let shown = |x: u32, place: [f64; 2], point: DVec3| {
            let normal = DVec3::Y;
            let direction = (rays.position(x, 0).expect("no sky") - point).normalize();
            colors.shown(gbuffer.index(x, 0), place, DVec3::Z, Some(ReflectedRay { point, normal, direction }))
        };
        let [start_below, start_aside] = [DVec3::new(0.0, -5.0, -1.0), far_point + DVec3::new(9.0, -20.0, -9.0)];
        let start_passing = near_point + (near_point - far_point).normalize() * 2.0;
        assert_eq!(shown(32, [32.25, 0.5], start_aside), DVec3::Y, "far from the ray it is left out");
        assert!(
            (shown(32, [32.25, 0.5], start_passing) - DVec3::new(0.25, 0.75, 0.0)).length() < 1e-9,
            "near the ray it counts"
        );
        assert!(
            (shown(31, [31.75, 0.5], start_below) - DVec3::new(0.75, 0.25, 0.0)).length() < 1e-9,
            "behind it counts"
        );
        assert!((shown(39, [39.75, 0.5], start_aside) - DVec3::new(0.0, 0.75, 0.25)).length() < 1e-9, "so does sky");
    }
}
