//! Reflections of pixels with wide lobes, interpolated between the surrounding cells: twin of the pass "resolve/wide".

use super::Gloss;
use super::gather::{ResolvedCell, direction_out_of_block};
use super::gloss_trace::cell_pixel;
use super::lobe::{LEAST_WEIGHT, lobe_overlap, lobe_power};
use crate::reference::Level;
use glam::{IVec2, Vec2, Vec3, Vec4};
use ssct_ground::math::constants;
use ssct_scenes::ProjectionKind;

/// `PLANE_TOLERANCE` of the shader: a cell that lies off the pixel's plane by this share of its depth has half its
/// weight.
const PLANE_TOLERANCE: f32 = constants::VISIBLE_WITHIN as f32;
/// Distance along an axis, in pixels, at which a cell has no weight any more.
const CELL_REACH: f32 = constants::CELL_REACH as f32;

impl Gloss<'_> {
    /// Returns the reflection of a pixel (colour, and fade in the fourth component) and its composite, from the
    /// resolved cells; `None` for a pixel that has no wide lobe.
    pub fn resolve_wide(&self, cells: &Level<ResolvedCell>, pixel: IVec2) -> Option<(Vec4, Vec3)> {
        self.is_wide(pixel).then(|| self.composite_pixel(pixel, self.upsample_cells(cells, pixel)))
    }

    /// Twin of `UpsampleCells`: returns the reflection of a pixel as the mean over the four nearest cells, weighted by
    /// their nearness and by how alike their surfaces are.
    fn upsample_cells(&self, cells: &Level<ResolvedCell>, pixel: IVec2) -> Vec4 {
        let parameters = &self.traversal.parameters;
        let (depth, normal, power) = (self.depth(pixel), self.normal(pixel), lobe_power(self.roughness(pixel)));
        let facing = normal.dot(parameters.view_ray(pixel.as_vec2() + 0.5)) / PLANE_TOLERANCE;
        let facing_change = normal.truncate() * parameters.pixel_to_view * Vec2::new(2.0, -2.0) / PLANE_TOLERANCE;
        let (mut sum, mut weight_sum) = (Vec4::ZERO, 0.0);
        for i in 0_i32..4 {
            let cell: IVec2 = (pixel >> 1) + direction_out_of_block(pixel) * IVec2::new(i & 1, i >> 1);
            let cell = cell.clamp(IVec2::ZERO, self.last_cell());
            let drawn = self.is_drawn(cell).then(|| cells.at_clamped(cell.x as u32, cell.y as u32));
            let ResolvedCell { mut reflection, surface } = drawn.unwrap_or_default();
            let offset = (cell_pixel(cell) - pixel).as_vec2();
            let nearness = CELL_REACH - offset.abs();
            let off_plane = match parameters.kind {
                ProjectionKind::Perspective => {
                    (facing + facing_change.dot(offset)) * (surface.w * (depth + parameters.depth_offset)) - facing
                }
                ProjectionKind::Orthographic => {
                    let cell_depth = self.depth(cell_pixel(cell).min(parameters.size - 1));
                    (facing_change.dot(offset) + facing * (depth - cell_depth) / parameters.depth_offset)
                        / parameters.reach
                }
            };
            let overlap = lobe_overlap(normal - surface.truncate(), power);
            let squared_distance = off_plane * off_plane;
            let likeness = (overlap / (1.0 + squared_distance * squared_distance)).max(LEAST_WEIGHT);
            let weight = if surface.w > 0.0 { nearness.x * nearness.y * likeness } else { 0.0 };
            // If the reflection lies over another one, a cell's colour is weighted by its fade.
            if self.is_over {
                reflection = (reflection.truncate() * reflection.w).extend(reflection.w);
            }
            sum += weight * reflection;
            weight_sum += weight;
        }
        let color_weight = if self.is_over { sum.w } else { weight_sum };
        if color_weight > 0.0 { (sum.truncate() / color_weight).extend(sum.w / weight_sum) } else { Vec4::ZERO }
    }
}
