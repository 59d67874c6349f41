//! Twin of the passes "resolve/narrow" and "cells", which make the reflection of each pixel or cell from the rays
//! around it.
//!
//! The pixels or cells of a block of 2 × 2 exchange loaded values by derivatives: value ± derivative is the neighbour's
//! value up to its last bits. The twin uses the same subtraction and addition ([`ray_from_neighbour`]), so that the
//! results do not differ.

use super::gloss_trace::{FAR_SKY, NEAR_HIT, NEAR_MARK, NeighbourRay};
use super::lobe::{LEAST_WEIGHT, LOG2_E, Lobe, inverse_sqrt, log_cos, log_density};
use super::{Gloss, half, sound};
use crate::reference::Level;
use glam::{IVec2, Vec3, Vec4};
use ssct_ground::math::constants;

/// Greatest weight by which the closest cells count more than once.
const CONTACT_WEIGHT: f32 = constants::CONTACT_WEIGHT as f32;
/// Distance of the nearest hit, in pixel widths, from which on the closest cells count only once.
const CONTACT_END: f32 = constants::CONTACT_END as f32;

/// Twin of `RaySum`: weighted sums over rays.
#[derive(Default)]
struct RaySum {
    /// Weighted sum of the colours of hits, with their fades in the fourth component.
    color: Vec4,
    /// Sum of the weights of all rays.
    weight: f32,
    /// Sum of the weights of the rays that hit.
    hits: f32,
}

impl RaySum {
    /// Twin of `AddRay`: adds a ray with a weight. The weight of a miss counts, but its colour does not.
    fn add_ray(&mut self, weight: f32, is_hit: bool, color: Vec4) {
        let hit_weight = if is_hit { weight } else { 0.0 };
        self.weight += weight;
        self.color += hit_weight * color;
        self.hits += hit_weight;
    }

    /// Twin of `ReflectionFromSum`: returns the mean colour, with the mean fade of the hits in the fourth component. A
    /// ray that missed counts as black. With `lowers_fade`, it leaves the colour of the hits unchanged and
    /// lowers the fade instead.
    fn reflection(&self, lowers_fade: bool) -> Vec4 {
        if self.hits <= 0.0 {
            return Vec4::ZERO;
        }
        let reflection = (self.color.truncate() / self.weight).extend(self.color.w / self.hits);
        if !lowers_fade {
            return reflection;
        }
        let fade = half(self.color.w / self.weight);
        if fade > 0.0 { (reflection.truncate() * (reflection.w / fade)).extend(fade) } else { Vec4::ZERO }
    }
}

/// Twin of `RayFromNeighbourX` and `RayFromNeighbourY`: returns the ray `other` of the neighbouring pixel or cell,
/// rounded as the exchange by derivatives with the ray `own` rounds it.
fn ray_from_neighbour(own: NeighbourRay, other: NeighbourRay) -> NeighbourRay {
    NeighbourRay { key: own.key + (other.key - own.key), color: own.color + (other.color - own.color) }
}

/// Twin of `DirectionOutOfBlock`: returns the direction, 1 or −1 along each axis, from a pixel or cell to the outside
/// of its block of 2 × 2.
pub(super) fn direction_out_of_block(pixel: IVec2) -> IVec2 {
    2 * (pixel & 1) - 1
}

/// The reflection of a cell, with the surface that reflects.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResolvedCell {
    /// Linear colour of the reflection, with its fade in the fourth component.
    pub reflection: Vec4,
    /// Normal, and z as scaled by [`super::Parameters::view_point`]; all 0 for no surface.
    pub surface: Vec4,
}

/// Twin of `GatherPoint`: the point and lobe of a cell that gathers rays.
struct GatherPoint {
    /// Point of the surface, as [`super::Parameters::view_point`] scales it.
    point: Vec3,
    /// Lobe at the point.
    lobe: Lobe,
    /// [`log_density`] in the middle of the lobe.
    peak: f32,
}

/// Twin of `CellSum`: the rays that a cell gathers.
struct CellSum {
    /// Sums over the rays of all 5 × 5 cells.
    rays: RaySum,
    /// Sum of the colours of the rays of the closest 3 × 3 cells, weighted by closeness as well, with the sum of these
    /// weights in the fourth component.
    closest: Vec4,
    /// Least squared distance from the cell's point to a hit of the closest cells' rays.
    nearest: f32,
}

impl CellSum {
    /// Twin of `WeightedSum`: returns the sum of all rays, in which the colours of the closest cells count once more by
    /// a weight. Weights and fades stay as they are.
    fn with_closest(self, weight: f32) -> RaySum {
        let Self { rays, closest, .. } = self;
        let weighted = rays.color.truncate().extend(rays.weight) + weight * closest;
        let color = weighted.truncate() * (rays.weight / weighted.w.max(1e-30));
        RaySum { color: color.extend(rays.color.w), ..rays }
    }
}

impl GatherPoint {
    /// Twin of `GatherRay` for wide lobes: adds a ray as a sample of the cell's lobe. With f the lobe's density along
    /// the ray and q the density with which the ray was drawn, its weight is 2 f / (f + q), the balance heuristic.
    /// `closeness` is the ray's weight among the closest cells, and 0 for all other cells.
    fn gather_ray(&self, sum: &mut CellSum, ray: NeighbourRay, closeness: f32) {
        let ended_near = ray.key.w > 0.75 * NEAR_MARK;
        let density = ray.key.w - if ended_near { NEAR_MARK } else { 0.0 };
        if density == 0.0 {
            return;
        }
        // The key of a hit is a place, and that of a miss a direction.
        let key = ray.key.truncate();
        let to_end = if density > 0.0 { key - self.point } else { key };
        let log_cos = log_cos(1.0 - to_end.dot(self.lobe.mirror) * inverse_sqrt(to_end.dot(to_end)));
        let exponent = density.abs() - self.peak - LOG2_E * (self.lobe.power - 1.0) * log_cos;
        let weight = 2.0 / (1.0 + exponent.exp2());
        let is_hit = density > 0.0 && to_end.dot(self.lobe.normal) > 0.0;
        let (weight, color) = (weight.max(LEAST_WEIGHT), ray.color.max(Vec4::ZERO));
        sum.rays.add_ray(weight, is_hit, color);
        if closeness > 0.0 {
            let weighted_color = if is_hit { weight } else { 0.0 } * color.truncate();
            sum.closest += closeness * weighted_color.extend(weight);
            if density > 0.0 {
                sum.nearest = sum.nearest.min(if ended_near { 0.0 } else { to_end.dot(to_end) });
            }
        }
    }
}

impl Gloss<'_> {
    /// Twin of the pass "resolve/narrow": returns the reflection and the composite of a pixel, from the rays of the 3 ×
    /// 3 pixels around it. `None` for a pixel that has no ray.
    pub fn resolve_narrow(&self, rays: &Level<NeighbourRay>, pixel: IVec2) -> Option<(Vec4, Vec3)> {
        let load_neighbour_ray = |texel: IVec2| {
            let texel = texel.clamp(IVec2::ZERO, self.traversal.parameters.size - 1).as_uvec2();
            if self.is_narrow(texel.as_ivec2()) { rays.at_clamped(texel.x, texel.y) } else { NeighbourRay::default() }
        };
        let load_pixel_ray = |texel: IVec2| {
            let is_inside = texel.cmplt(self.traversal.parameters.size).all();
            if is_inside { load_neighbour_ray(texel) } else { NeighbourRay::unpack_record([0; 4]) }
        };
        // The other pixels of the block of 2 × 2: the one beside the pixel along x, and the one along y.
        let (pixel_x, pixel_y) = (IVec2::new(pixel.x ^ 1, pixel.y), IVec2::new(pixel.x, pixel.y ^ 1));
        let [outwards, outwards_x, outwards_y] = [pixel, pixel_x, pixel_y].map(direction_out_of_block);
        let own_ray = load_pixel_ray(pixel);
        if own_ray.key.w == 0.0 {
            return None;
        }
        let ray_from_neighbour_x =
            |texel: IVec2| ray_from_neighbour(load_pixel_ray(texel), load_pixel_ray(IVec2::new(texel.x ^ 1, texel.y)));
        let ray_outside_x = |texel: IVec2, outwards: IVec2| load_neighbour_ray(texel + IVec2::new(outwards.x, 0));
        let ray_outside_y = |texel: IVec2, outwards: IVec2| load_neighbour_ray(texel + IVec2::new(0, outwards.y));
        let mut sum = RaySum::default();
        sum.add_ray(1.0, own_ray.key.w > 0.0, own_ray.color);
        // Three rays of the block, two from beside the block, two from above or below it, and one from its corner.
        for ray in [
            ray_from_neighbour_x(pixel),
            ray_from_neighbour(own_ray, load_pixel_ray(pixel_y)),
            ray_from_neighbour(ray_from_neighbour_x(pixel), ray_from_neighbour_x(pixel_y)),
            ray_outside_x(pixel, outwards),
            ray_from_neighbour(ray_outside_x(pixel, outwards), ray_outside_x(pixel_y, outwards_y)),
            ray_outside_y(pixel, outwards),
            ray_from_neighbour(ray_outside_y(pixel, outwards), ray_outside_y(pixel_x, outwards_x)),
            load_neighbour_ray(pixel + outwards),
        ] {
            // The key's w is the root of α + 1, so that the product is a power between those of both lobes. The weight
            // is the root of the overlap of the lobes.
            let power = (own_ray.key.w * ray.key.w).abs();
            let chord = (own_ray.key - ray.key).truncate();
            let root_overlap = (-0.125 * LOG2_E * power * chord.dot(chord)).exp2();
            let weight = if ray.key.w != 0.0 { root_overlap.max(LEAST_WEIGHT) } else { 0.0 };
            sum.add_ray(weight, ray.key.w > 0.0, ray.color.max(Vec4::ZERO));
        }
        let reflection = sum.reflection(self.is_over);
        Some(self.composite_pixel(pixel, reflection))
    }

    /// Twin of the pass "cells": returns the reflection of a cell, from the rays of the 5 × 5 cells around it. All is 0
    /// for a cell without a wide lobe.
    pub fn resolve_cell(&self, rays: &Level<NeighbourRay>, cell: IVec2) -> ResolvedCell {
        let Some(pixel) = self.wide_pixel(cell) else { return ResolvedCell::default() };
        let point = self.traversal.parameters.view_point(pixel.as_vec2() + 0.5, self.depth(pixel));
        let parameters = &self.traversal.parameters;
        let lobe = Lobe::new(parameters.view_direction(point), self.normal(pixel), self.roughness(pixel));
        let centre = GatherPoint { point, lobe, peak: log_density(lobe.power, 0.0) };
        let neighbour = IVec2::new(cell.x, cell.y ^ 1);
        let [above, middle, below] = [-1, 0, 1].map(|y| self.row(rays, cell, y));
        // The rows between those that are read come from the block's other cell along y.
        let exchanged_row = |own: [NeighbourRay; 5], y| {
            let other = self.row(rays, neighbour, y);
            std::array::from_fn(|i| ray_from_neighbour(own[i], other[i]))
        };
        let mut sum = CellSum { rays: RaySum::default(), closest: Vec4::ZERO, nearest: FAR_SKY * FAR_SKY };
        // The rows lie from two cells inwards to two cells outwards, and so do the rays in a row.
        const CLOSENESS: [f32; 5] = [0.0, 0.5, 1.0, 0.5, 0.0];
        let rows = [above, exchanged_row(middle, 0), middle, exchanged_row(above, -1), below];
        for (row, row_closeness) in rows.into_iter().zip(CLOSENESS) {
            for (ray, ray_closeness) in row.into_iter().zip(CLOSENESS) {
                centre.gather_ray(&mut sum, ray, row_closeness * ray_closeness);
            }
        }
        // The closest cells count more where their rays hit something near, and for smaller roughness.
        let pixel_width =
            2.0 * parameters.pixel_to_view.y * if parameters.kind.is_orthographic() { 1.0 } else { point.z };
        let nearest_px = sum.nearest.sqrt() / pixel_width;
        let nearness = ((CONTACT_END - nearest_px) / (CONTACT_END - NEAR_HIT)).clamp(0.0, 1.0);
        let smoothness = 1.0 - self.roughness(pixel);
        let rays = sum.with_closest(CONTACT_WEIGHT * smoothness * smoothness * nearness);
        let z = if parameters.kind.is_orthographic() { 1.0 } else { point.z.min(super::GREATEST) };
        ResolvedCell { reflection: rays.reflection(self.is_over), surface: lobe.normal.extend(z) }
    }

    /// Returns the five rays of a row of cells, from two cells inwards of `cell` in its block of 2 × 2 to two cells
    /// outwards. The row lies `2 y` cells outwards of `cell`, for y = −1, 0 or 1. Every other ray comes from the
    /// block's other cell along x.
    fn row(&self, rays: &Level<NeighbourRay>, cell: IVec2, y: i32) -> [NeighbourRay; 5] {
        let load_cell_ray = |cell: IVec2, x: i32| {
            let texel = cell + 2 * direction_out_of_block(cell) * IVec2::new(x, y);
            let texel = texel.clamp(IVec2::ZERO, self.last_cell());
            if self.is_drawn(texel) { rays.at_clamped(texel.x as u32, texel.y as u32) } else { NeighbourRay::default() }
        };
        let neighbour = IVec2::new(cell.x ^ 1, cell.y);
        let [inner, middle, outer] = [-1, 0, 1].map(|x| load_cell_ray(cell, x));
        [
            inner,
            ray_from_neighbour(middle, load_cell_ray(neighbour, 0)),
            middle,
            ray_from_neighbour(inner, load_cell_ray(neighbour, -1)),
            outer,
        ]
    }

    /// Returns a pixel's reflection (colour, and fade in the fourth component) in the range that 16-bit floats store,
    /// and the composite: lit colour + reflectivity · fade · reflection.
    pub(super) fn composite_pixel(&self, pixel: IVec2, reflection: Vec4) -> (Vec4, Vec3) {
        let shown_reflection = reflection.truncate().map(sound).extend(sound(reflection.w).min(1.0));
        let index = self.traversal.gbuffer.index(pixel.x as u32, pixel.y as u32);
        let (color, reflectivity) = (self.traversal.gbuffer.color[index], self.traversal.gbuffer.reflectivity[index]);
        (
            shown_reflection,
            (color + reflectivity * shown_reflection.w * shown_reflection.truncate()).min(Vec3::splat(super::GREATEST)),
        )
    }
}
