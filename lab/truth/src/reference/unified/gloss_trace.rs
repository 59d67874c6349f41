//! Twin of the passes "trace/narrow" and "trace/wide", which trace the rays of glossy lobes. A ray is first aimed and
//! then followed, so that a test can follow a ray whose aim differs by a rounding error.

use super::lobe::{Lobe, inverse_sqrt, lattice_point, lobe_direction, lobe_overlap, log_density};
use super::{Gloss, Hit, HitCode};
use glam::{IVec2, Vec2, Vec3, Vec4};
use ssct_ground::math::constants;

// Comments in `shaders-glsl/common/constants.glsl` say what each of these numbers is.
const NARROW_PART: f32 = constants::NARROW_PART as f32;
const NARROW_FOOTPRINTS: f32 = constants::NARROW_FOOTPRINTS as f32;
const WIDE_FOOTPRINTS: f32 = constants::WIDE_FOOTPRINTS as f32;
pub(super) const NEAR_HIT: f32 = constants::NEAR_HIT as f32;
pub(super) const NEAR_MARK: f32 = constants::NEAR_MARK as f32;
const FAR_AWAY: f32 = constants::FAR_AWAY as f32;
pub(super) const FAR_SKY: f32 = constants::FAR_SKY as f32;

/// A ray before it is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AimedRay {
    /// Pixel that the ray begins in.
    pub pixel: IVec2,
    /// Point of the pixel's surface, as [`super::Parameters::view_point`] scales it.
    pub point: Vec3,
    /// Lobe of the pixel.
    pub lobe: Lobe,
    /// The ray's direction, a unit vector in view space.
    pub direction: Vec3,
    /// The density with which the direction was drawn: its logarithm to base 2, plus a bias.
    pub density: f32,
    /// The share of the lobe that the ray stands for.
    pub share: f32,
}

/// Twin of `NeighbourRay`: the result of a ray, as neighbours gather it. All values are 0 without a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NeighbourRay {
    /// Values that the weight of the ray depends on; w is 0 without a ray and negative for a miss. For a narrow lobe,
    /// xyz is the middle of the lobe and w the root of α + 1. For a wide lobe, xyz is the point of the hit, or the
    /// direction of a miss, and w is the density.
    pub key: Vec4,
    /// Colour of the hit, and its fade in the fourth component.
    pub color: Vec4,
}

impl Gloss<'_> {
    /// Returns the ray of a pixel with a narrow lobe; `None` for any other pixel.
    pub fn aim_narrow(&self, pixel: IVec2) -> Option<AimedRay> {
        let normal = self.normal(pixel);
        if !self.is_narrow(pixel) || self.depth(pixel) <= 0.0 || normal.dot(normal) <= 0.0 {
            return None;
        }
        // The nine rays of the pattern are dealt out to squares of 3 × 3 pixels.
        let point = lattice_point(pixel, 3, 2, Vec2::splat(0.5));
        let pattern_point = Vec2::new(point.x * NARROW_PART, point.y);
        Some(self.aim(pixel, normal, pattern_point, NARROW_FOOTPRINTS, |_| 1.0))
    }

    /// Returns the ray of a cell of 2 × 2 pixels; `None` for a cell in which no pixel has a wide lobe. The more the
    /// lobes of neighbouring cells overlap, the smaller is the share of the lobe that the ray stands for.
    pub fn aim_wide(&self, cell: IVec2) -> Option<AimedRay> {
        let pixel = self.wide_pixel(cell)?;
        // The unit normal of a cell's pixel. Its change is taken within the block of 2 × 2 cells that a device shades
        // together.
        let unit_normal = |cell: IVec2| {
            let normal = self.normal(self.wide_pixel(cell).unwrap_or_else(|| cell_pixel(cell)));
            normal * inverse_sqrt(normal.dot(normal).max(1e-30))
        };
        let first_cell = cell & !1;
        let normal_change_x =
            unit_normal(IVec2::new(first_cell.x + 1, cell.y)) - unit_normal(IVec2::new(first_cell.x, cell.y));
        let normal_change_y =
            unit_normal(IVec2::new(cell.x, first_cell.y + 1)) - unit_normal(IVec2::new(cell.x, first_cell.y));
        // The 25 rays of the pattern are dealt out to squares of 5 × 5 cells. Equal points in adjacent squares have
        // different parities, and so different places in their stratum.
        let parity = cell & 1;
        let stratum = IVec2::new(2 * parity.x + parity.y, 2 * (parity.x ^ parity.y) + parity.x).as_vec2();
        let pattern_point = lattice_point(cell, 5, 7, 0.125 + 0.25 * stratum);
        let shared_part = |power| 0.5 * (lobe_overlap(normal_change_x, power) + lobe_overlap(normal_change_y, power));
        Some(self.aim(pixel, self.normal(pixel), pattern_point, WIDE_FOOTPRINTS, shared_part))
    }

    /// Twin of the first half of `TraceLobeSample`: returns the ray for a pattern point (0…1) in a pixel's lobe.
    /// `shared_part` returns, for a lobe power, the part (0…1) of the lobe that neighbours' lobes share. A lobe that
    /// they share wholly is covered by `footprints` footprints of rays.
    fn aim(
        &self,
        pixel: IVec2,
        normal: Vec3,
        pattern_point: Vec2,
        footprints: f32,
        shared_part: impl Fn(f32) -> f32,
    ) -> AimedRay {
        let point = self.traversal.parameters.view_point(pixel.as_vec2() + 0.5, self.depth(pixel));
        let lobe = Lobe::new(self.traversal.parameters.view_direction(point), normal, self.roughness(pixel));
        let lobe_part = shared_part(lobe.power);
        let share = 1.0 / (1.0 + (footprints - 1.0) * lobe_part);
        let azimuth = std::f32::consts::TAU * pattern_point.y;
        let log_rest = (1.0 - pattern_point.x * lobe_part).log2();
        let cosine_and_sine = Vec2::new(azimuth.cos(), azimuth.sin());
        let direction = lobe_direction(lobe.mirror, lobe.power, log_rest / super::lobe::LOG2_E, cosine_and_sine);
        AimedRay { pixel, point, lobe, direction, density: log_density(lobe.power, log_rest), share }
    }

    /// Twin of the second half of `TraceLobeSample`, with `TraceGlossyRay`. Returns the hit on a surface or on the
    /// screen's sky, and its colour with the fade in the fourth component. `None` for a miss.
    pub fn trace_glossy_ray(&self, aim: &AimedRay) -> Option<(Hit, Vec4)> {
        // A ray below the surface sees nothing.
        if aim.direction.dot(aim.lobe.normal) <= 0.0 {
            return None;
        }
        let [x, y] = aim.pixel.as_uvec2().to_array();
        let ray = self.traversal.ray_along(x, y, aim.direction)?;
        let hit = self.traversal.traverse(&ray);
        let hit =
            self.traversal.leaves_through_far_plane(&ray, &hit).or((hit.code == HitCode::Surface).then_some(hit))?;
        let parameters = &self.traversal.parameters;
        let level = parameters.footprint_level(
            aim.point,
            parameters.view_point(hit.position, hit.depth),
            aim.density,
            aim.share,
        );
        let lit = self.sample_hit(&hit, level);
        Some((hit, lit.map(super::sound).extend(self.fade(hit.position * parameters.pixel_to_clip))))
    }

    /// Traces the ray of a narrow lobe, and returns the result that neighbouring pixels gather, before it is packed.
    pub fn trace_narrow_pixel(&self, aim: &AimedRay) -> NeighbourRay {
        let (power_root, lobe_sample) = (aim.lobe.power.sqrt(), self.trace_glossy_ray(aim));
        let key = aim.lobe.mirror.extend(if lobe_sample.is_some() { power_root } else { -power_root });
        NeighbourRay { key, color: lobe_sample.map_or(Vec4::ZERO, |(_, color)| color) }
    }

    /// Traces the ray of a cell with a wide lobe, and returns the result that neighbouring cells gather. A near hit is
    /// put far away along the ray, so that it counts as a direction. If it is on another surface than the reflector,
    /// its density gets the mark `NEAR_MARK`.
    pub fn trace_wide_cell(&self, aim: &AimedRay) -> NeighbourRay {
        let Some((hit, color)) = self.trace_glossy_ray(aim) else {
            return NeighbourRay { key: aim.direction.extend(-aim.density), color: Vec4::ZERO };
        };
        if hit.code != HitCode::Surface {
            return NeighbourRay { key: (aim.point + FAR_SKY * aim.direction).extend(aim.density), color };
        }
        let end_point = self.traversal.parameters.view_point(hit.position, hit.depth);
        let offset = (hit.position - aim.pixel.as_vec2() - 0.5).abs();
        let is_near = offset.x.max(offset.y) < NEAR_HIT;
        let place = if is_near { aim.point + FAR_AWAY * (end_point - aim.point) } else { end_point };
        let touches = is_near && !self.traversal.shows_reflector([aim.point, aim.lobe.normal], hit.pixel);
        let marked_density = aim.density + if touches { NEAR_MARK } else { 0.0 };
        NeighbourRay { key: place.extend(marked_density), color }
    }
}

/// Twin of `CellPixel`: returns the pixel that stands for a cell of 2 × 2: its first or its last, by turns as on a
/// chequerboard.
pub(super) fn cell_pixel(cell: IVec2) -> IVec2 {
    2 * cell + ((cell.x + cell.y) & 1)
}

/// Twin of `EncodeOctahedral`: returns the octahedral coordinates (−1…1) of a direction of any length.
pub fn encode_octahedral(v: Vec3) -> Vec2 {
    let v = v / (v.x.abs() + v.y.abs() + v.z.abs());
    let folded = Vec2::new(1.0 - v.y.abs(), 1.0 - v.x.abs());
    let sign = |source: f32, value: f32| if source >= 0.0 { value } else { -value };
    if v.z >= 0.0 { v.truncate() } else { Vec2::new(sign(v.x, folded.x), sign(v.y, folded.y)) }
}

/// Twin of `DecodeOctahedral`: returns the unit vector of octahedral coordinates, as the inverse of
/// [`encode_octahedral`].
fn decode_octahedral(coordinates: Vec2) -> Vec3 {
    let z = 1.0 - coordinates.x.abs() - coordinates.y.abs();
    let fold = (-z).max(0.0);
    let unfold = |v: f32| v + if v >= 0.0 { -fold } else { fold };
    let v = Vec3::new(unfold(coordinates.x), unfold(coordinates.y), z);
    v * inverse_sqrt(v.dot(v))
}

impl NeighbourRay {
    /// Twin of `PackRecord`: returns the four words of the ray record of a narrow lobe. They are the lobe's middle in
    /// octahedral coordinates of 16 bits, the root of α + 1, and two words for the colour with its fade as 16-bit
    /// floats.
    pub fn pack_record(&self) -> [u32; 4] {
        // The signed integer of 16 bits that stands for a number in −1…1.
        let snorm = |v: f32| u32::from(((v.clamp(-1.0, 1.0) * 32767.0).round() as i16) as u16);
        let half = |v: f32| u32::from(half::f16::from_f32(v).to_bits());
        let mirror = encode_octahedral(self.key.truncate());
        [
            snorm(mirror.x) | snorm(mirror.y) << 16,
            self.key.w.to_bits(),
            half(self.color.x) | half(self.color.y) << 16,
            half(self.color.z) | half(self.color.w) << 16,
        ]
    }

    /// Twin of `UnpackRecord`: returns the ray of a record, as the inverse of [`Self::pack_record`].
    pub fn unpack_record([mirror, power_root, red_green, blue_fade]: [u32; 4]) -> Self {
        let snorm = |v: u32| (f32::from(v as u16 as i16) / 32767.0).clamp(-1.0, 1.0);
        let half = |v: u32| half::f16::from_bits(v as u16).to_f32();
        let mirror = decode_octahedral(Vec2::new(snorm(mirror), snorm(mirror >> 16)));
        Self {
            key: mirror.extend(f32::from_bits(power_root)),
            color: Vec4::new(half(red_green), half(red_green >> 16), half(blue_fade), half(blue_fade >> 16)),
        }
    }
}
