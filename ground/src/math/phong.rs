//! The Phong lobe of a roughness (docs/definitions.md, "Surfaces"; thesis Eq. 4.5).

pub use super::constants::XI;

/// Exponent α(ϱ) = ln ξ / ln cos(ϱ/2) − 1 for ϱ < π; infinite for a mirror (ϱ ≤ 0).
pub fn exponent(roughness: f64) -> f64 {
    if roughness <= 0.0 { f64::INFINITY } else { XI.ln() / (roughness / 2.0).cos().ln() - 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_match_the_table_of_numerics() {
        // docs/numerics.md, "Gloss": ϱ = 0.05, 0.1, 0.3, 0.6 give 4512, 1127, 124, 30.
        for (r, a) in [(0.05, 4512.0), (0.1, 1127.0), (0.3, 124.0), (0.6, 30.0)] {
            assert!((exponent(r) - a).abs() < 0.5, "{r}: {}", exponent(r));
        }
        assert_eq!(exponent(0.0), f64::INFINITY);
    }
}
