//! Converts the material terms of other renderers to this program's: roughness so that lobes are equally wide, and
//! reflectivity from metalness and base colour.
//!
//! Most renderers have the lobe of GGX with α = r², where r is the roughness of glTF. Seen along the normal, half
//! vectors within an angle h of the normal reflect the share tan²h / (α² + tan²h) of the light (Walter et al. 2007).
//! Half vectors within h = atan α reflect half of the light, which leaves within 2 atan α of the mirror direction. The
//! lobe of ϱ is cosⁿ around the mirror direction (docs/definitions.md, "Surfaces"), with the share 1 − cosⁿ⁺¹θ within
//! θ. Both lobes have half of their light within the same angle if
//!
//! ```text
//! n + 1 = ln ½ / ln cos(2 atan r²)
//! ```
//!
//! and ϱ = 2 arccos ξ^(1/(n+1)). The widest lobe, ϱ = 1, is reached at r ≈ 0.42; rougher surfaces have ϱ = 1, too.

use glam::Vec3;
use ssct_geometry::texture::luminance;
use ssct_ground::math::constants::XI;
use std::f64::consts::FRAC_PI_2;

/// The reflection at normal incidence of a surface that states no index of refraction, which is that of an index of
/// 1.5.
pub const F0: f32 = 0.04;

/// The warning about surfaces that are rougher than the widest lobe allows.
pub const TOO_ROUGH: &str = "roughness above 0.42 is wider than the widest lobe (ϱ = 1) and counts as that";

/// Returns the reflection at normal incidence, 0…1, of a surface with an index of refraction from 0 on.
pub fn f0_of_ior(ior: f32) -> f32 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

/// Returns the reflectivity, 0…1, of a surface with the linear base colour `base` and the metalness `metallic`, 0…1.
/// The part that is not metal reflects the share `f0` at normal incidence.
pub fn reflectivity(base: Vec3, metallic: f32, f0: Vec3) -> f32 {
    luminance(f0.lerp(base, metallic)).clamp(0.0, 1.0)
}

/// Returns the roughness ϱ = 2 arccos(ξ^(1/(α+1))), 0…1, for the exponent α of a Phong lobe; 0 for α ≤ 0. This
/// inverts α(ϱ) = ln ξ / ln cos(ϱ/2) − 1 (docs/definitions.md, "Surfaces"), with ξ = [`XI`].
pub fn roughness_of_exponent(exponent: f32) -> f32 {
    if exponent > 0.0 { (2.0 * XI.powf(1.0 / (f64::from(exponent) + 1.0)).acos()).clamp(0.0, 1.0) as f32 } else { 0.0 }
}

/// Returns the roughness ϱ, 0…1, for the perceptual roughness r of glTF, 0…1, whose GGX lobe has α = r². The two lobes,
/// seen along the normal, have half of their light within the same angle.
pub fn roughness_of_perceptual(perceptual: f32) -> f32 {
    let r = f64::from(perceptual).clamp(0.0, 1.0);
    roughness_of_alpha(r * r)
}

/// Returns the roughness ϱ, 0…1, whose lobe has half of its light within the same angle as the GGX lobe with the
/// parameter `alpha` ≥ 0, seen along the normal.
pub fn roughness_of_alpha(alpha: f64) -> f32 {
    let half_angle = 2.0 * alpha.atan();
    if half_angle <= 0.0 {
        return 0.0;
    }
    if half_angle >= FRAC_PI_2 {
        return 1.0;
    }
    // The Phong lobe of the exponent n has half of its light within the angle at which the cosine to the n + 1 is ½.
    let exponent_plus_one = 0.5_f64.ln() / half_angle.cos().ln();
    // For tiny angles this cosine of half of ϱ is 1 in 64 bits, which makes a mirror.
    let cosine = XI.powf(1.0 / exponent_plus_one);
    ((2.0 * cosine.min(1.0).acos()) as f32).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_ground::math::phong;

    /// Returns the angle within which half of a lobe's light lies, by numerical integration of its density per solid
    /// angle.
    fn half_angle(density: impl Fn(f64) -> f64) -> f64 {
        let steps = 200_000;
        let angle = |ring: usize| (ring as f64 + 0.5) / steps as f64 * FRAC_PI_2;
        let light_of_ring = |ring: usize| density(angle(ring)) * angle(ring).sin();
        let light: f64 = (0..steps).map(light_of_ring).sum();
        let mut light_so_far = 0.0;
        for ring in 0..steps {
            light_so_far += light_of_ring(ring);
            if light_so_far >= 0.5 * light {
                return angle(ring);
            }
        }
        FRAC_PI_2
    }

    #[test]
    fn the_two_lobes_halve_at_the_same_angle() {
        for r in [0.05_f32, 0.1, 0.2, 0.3, 0.4] {
            let alpha = f64::from(r) * f64::from(r);
            // The light D(h) cos h of half vectors at the angle h leaves at 2 h. Shares are integrated over h, since
            // doubling the angles keeps their order.
            let ggx = |h: f64| {
                let cosine = h.cos();
                let denominator = cosine * cosine * (alpha * alpha - 1.0) + 1.0;
                alpha * alpha / (denominator * denominator) * cosine
            };
            let rho = f64::from(roughness_of_perceptual(r));
            let exponent = XI.ln() / (0.5 * rho).cos().ln() - 1.0;
            let [wanted, got] = [2.0 * half_angle(ggx), half_angle(|angle| angle.cos().powf(exponent))];
            assert!((wanted - got).abs() < 0.01 * wanted + 1e-4, "r {r}: {wanted} {got}");
        }
    }

    #[test]
    fn roughness_rises_from_a_mirror_to_the_widest_lobe() {
        assert_eq!(roughness_of_perceptual(0.0), 0.0);
        // The values in docs/definitions.md, "glTF".
        assert_eq!(
            [0.1, 0.2, 0.3, 0.4].map(|r| (roughness_of_perceptual(r) * 1e3).round()),
            [57.0, 228.0, 511.0, 897.0]
        );
        assert!(
            roughness_of_perceptual(0.423) < 1.0
                && roughness_of_perceptual(0.4235) == 1.0
                && roughness_of_perceptual(1.0) == 1.0
        );
        let steps: Vec<f32> = (0..=40).map(|i| roughness_of_perceptual(i as f32 / 100.0)).collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1] || pair[1] == 0.0), "{steps:?}");
        assert!(steps[40] < 1.0, "{}", steps[40]);
    }

    #[test]
    fn roughness_falls_with_the_exponent() {
        assert_eq!(roughness_of_exponent(0.0), 0.0);
        assert_eq!(roughness_of_exponent(-3.0), 0.0);
        assert_eq!(roughness_of_exponent(1.0), 1.0);
        let rough = roughness_of_exponent(100.0);
        // The inverse function: α(ϱ) = ln ξ / ln cos(ϱ/2) − 1.
        assert!((phong::exponent(rough.into()) - 100.0).abs() < 1e-3, "{rough}");
        assert!(roughness_of_exponent(1000.0) < rough);
    }
}
