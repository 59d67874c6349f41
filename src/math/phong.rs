//! The Phong lobe that a roughness stands for (DEFINITIONS, "Surfaces"; thesis Eq. 4.5).

pub use super::constants::XI;

/// Exponent α(ϱ) = ln ξ / ln cos(ϱ/2) − 1; infinite for a mirror (ϱ ≤ 0). ϱ below π.
pub fn exponent(roughness: f64) -> f64 {
    if roughness <= 0.0 { f64::INFINITY } else { XI.ln() / (roughness / 2.0).cos().ln() - 1.0 }
}

/// The roughness of an exponent α ≥ 0, the inverse of [`exponent`], clamped to 0…1.
pub fn roughness(exponent: f64) -> f64 {
    (2.0 * XI.powf(1.0 / (exponent + 1.0)).acos()).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_those_of_the_notes() {
        // NUMERICS, "Gloss": ϱ = 0.05, 0.1, 0.3, 0.6 give 4512, 1127, 124, 30.
        for (r, a) in [(0.05, 4512.0), (0.1, 1127.0), (0.3, 124.0), (0.6, 30.0)] {
            assert!((exponent(r) - a).abs() < 0.5, "{r}: {}", exponent(r));
        }
        assert_eq!(exponent(0.0), f64::INFINITY);
    }

    #[test]
    fn roughness_inverts_the_exponent() {
        for r in [0.01, 0.1, 0.5, 1.0] {
            assert!((roughness(exponent(r)) - r).abs() < 1e-9);
        }
        assert_eq!(roughness(0.0), 1.0, "a flat lobe is as rough as can be");
    }
}
