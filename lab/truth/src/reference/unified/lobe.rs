//! Twin of `shaders-glsl/unified/gloss.glsl` and `shaders-glsl/unified/view.glsl`, whose names are kept: lobes, their
//! directions and densities, and points of the image in view space. A lobe is cos^α around the mirror direction.

use super::Parameters;
use glam::{IVec2, Vec2, Vec3};
use ssct_ground::math::constants;
use ssct_scenes::ProjectionKind;

/// The logarithm of e to base 2; `LOG2_E` in the shaders.
pub(super) const LOG2_E: f32 = std::f32::consts::LOG2_E;
/// Least weight of a ray or cell that is gathered.
pub(super) const LEAST_WEIGHT: f32 = constants::LEAST_WEIGHT as f32;
/// Number that is added to logarithms of densities, so that they are positive.
pub(super) const LOG_DENSITY_BIAS: f32 = constants::LOG_DENSITY_BIAS as f32;

/// Twin of `LobePower`: returns α + 1 of a roughness in 0…1.
pub fn lobe_power(roughness: f32) -> f32 {
    // The divisor is −ln cos(ϱ / 2), as a series in (ϱ / 2)².
    let half_squared = 0.25 * roughness * roughness;
    -(constants::XI as f32).ln() / (half_squared * (0.5 + half_squared * (1.0 / 12.0 + half_squared / 45.0))).max(1e-12)
}

/// Twin of `LogCos`: returns ln cos of an angle from x = 1 − cos, by the series of ln(1 − x).
pub(super) fn log_cos(x: f32) -> f32 {
    -x * (1.0 + x * (0.5 + x * (1.0 / 3.0 + x * 0.25)))
}

/// Twin of `LobeDirection`: returns a unit vector at an angle θ to the unit vector `axis`, where ln cos^(α + 1) θ is
/// `log_rest`. `power` is α + 1, and `cosine_and_sine` are those of the angle by which the vector is
/// turned around the axis.
pub(super) fn lobe_direction(axis: Vec3, power: f32, log_rest: f32, cosine_and_sine: Vec2) -> Vec3 {
    // x = ln cos² θ gives sin² θ = 1 − eˣ, which is computed by its series, since cos θ may be near 1.
    let x = 2.0 * log_rest / power;
    let sin_theta = (-x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x / 24.0)))).max(0.0).sqrt();
    let cos_theta = (1.0 - sin_theta * sin_theta).max(0.0).sqrt();
    // Two unit vectors that are perpendicular to the axis and to each other (Duff et al. 2017).
    let sign = if axis.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let tangent = Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    let bitangent = Vec3::new(b, sign + axis.y * axis.y * a, -axis.y);
    axis * cos_theta + sin_theta * (tangent * cosine_and_sine.x + bitangent * cosine_and_sine.y)
}

/// Twin of `LogDensity`: returns the logarithm to base 2 of the density (α + 1) cos^α of a direction, plus
/// [`LOG_DENSITY_BIAS`]. `power` is α + 1, and `log_rest` the logarithm to base 2 of the direction's cos^(α + 1).
pub(super) fn log_density(power: f32, log_rest: f32) -> f32 {
    LOG_DENSITY_BIAS + power.log2() + (power - 1.0) / power * log_rest
}

/// Twin of `LobeOverlap`: returns the overlap (0…1) of two lobes of one power, whose unit normals differ by `chord`.
pub(super) fn lobe_overlap(chord: Vec3, power: f32) -> f32 {
    (-LOG2_E * power * chord.dot(chord)).exp2()
}

/// Twin of `LatticePoint`: returns the point (0…1 in x and y) that a pixel or cell has in the pattern of side × side
/// points. The pattern is the rank-1 lattice with the generator (1, `generator`), and `stratum_place` is the point's
/// place (0…1) in its stratum.
pub(super) fn lattice_point(pixel: IVec2, side: i32, generator: i32, stratum_place: Vec2) -> Vec2 {
    let count = side * side;
    let index = (pixel.x + side * pixel.y) % count;
    (IVec2::new(index, (index * generator) % count).as_vec2() + stratum_place) / count as f32
}

/// Twin of `Lobe`: the lobe of a pixel in view space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// The pixel's normal, as stored.
    pub normal: Vec3,
    /// Middle of the lobe, a unit vector.
    pub mirror: Vec3,
    /// α + 1.
    pub power: f32,
}

impl Lobe {
    /// Twin of `MakeLobe`: returns the lobe at a point, of which only the direction counts. The normal may have any
    /// length.
    pub(super) fn new(point: Vec3, normal: Vec3, roughness: f32) -> Self {
        let direction = point * inverse_sqrt(point.dot(point));
        let mirror = direction - (2.0 * direction.dot(normal) / normal.dot(normal)) * normal;
        Self { normal, mirror, power: lobe_power(roughness) }
    }
}

/// Returns 1 / √value, as `inversesqrt` of GLSL does.
pub(super) fn inverse_sqrt(value: f32) -> f32 {
    1.0 / value.sqrt()
}

impl Parameters {
    /// Twin of `OffAxis`: returns the offset of continuous pixel coordinates from the axis of the view: at z = 1 in a
    /// perspective, else in metres.
    fn off_axis(&self, position: Vec2) -> Vec2 {
        let size = self.size.as_vec2();
        let centred = Vec2::new(2.0 * position.x - size.x, size.y - 2.0 * position.y) - self.shift;
        centred * self.pixel_to_view
    }

    /// Twin of `ViewRay`: returns the view-space direction in which continuous pixel coordinates are seen; z is 1.
    pub(super) fn view_ray(&self, position: Vec2) -> Vec3 {
        if self.kind.is_orthographic() { Vec3::Z } else { self.off_axis(position).extend(1.0) }
    }

    /// Twin of `ViewPoint`: returns the view-space point at continuous pixel coordinates and a reversed depth. An
    /// orthographic point is in metres. In a perspective it is divided by near (1 + k), where k is `depth_offset`.
    pub fn view_point(&self, position: Vec2, depth: f32) -> Vec3 {
        match self.kind {
            ProjectionKind::Perspective => self.view_ray(position) / (depth + self.depth_offset),
            ProjectionKind::Orthographic => {
                self.off_axis(position).extend((self.depth_origin - depth) / self.depth_offset)
            }
        }
    }

    /// Twin of `ViewDirection`: returns the view-space direction, of any length, in which a point is seen.
    pub(super) fn view_direction(&self, point: Vec3) -> Vec3 {
        if self.kind.is_orthographic() { Vec3::Z } else { point }
    }

    /// Twin of `NdcChange`: returns the change of ndc along a view-space vector, from a point that is seen at `ndc`. In
    /// a perspective, this change and that of [`Self::depth_change`] are multiplied by the point's z, which keeps their
    /// ratio.
    pub(super) fn ndc_change(&self, ndc: Vec2, vector: Vec3) -> Vec2 {
        let parallel = self.view_to_clip * vector.truncate();
        if self.kind.is_orthographic() { parallel } else { parallel - ndc * vector.z }
    }

    /// Twin of `DepthChange`: returns the change of reversed depth along a view-space vector with the component `z`,
    /// from a point of the given depth. In a perspective, it is multiplied by the point's z, as in
    /// [`Self::ndc_change`].
    pub(super) fn depth_change(&self, depth: f32, z: f32) -> f32 {
        let slope = if self.kind.is_orthographic() { self.depth_offset } else { depth + self.depth_offset };
        -(slope * z)
    }

    /// Twin of `FootprintLevel`: returns the level of the colour chain whose texels are as wide as the footprint of a
    /// ray from `point` to `end`. `density` is the ray's [`log_density`], and `share` the share of the lobe that it
    /// stands for.
    pub(super) fn footprint_level(&self, point: Vec3, end: Vec3, density: f32, share: f32) -> f32 {
        let to_end = end - point;
        let width_factor = if self.kind.is_orthographic() { 1.0 } else { end.z };
        let half_pixel = width_factor * self.pixel_to_view.y;
        // The logarithm to base 2 of (radius of the footprint / half a pixel)², times the density.
        let log_ratio = (2.0 * share * to_end.dot(to_end) / (half_pixel * half_pixel)).log2();
        (0.5 * (log_ratio - (density - LOG_DENSITY_BIAS))).max(0.0)
    }
}
