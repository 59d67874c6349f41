//! Directions of the Phong lobe (docs/definitions.md, "Surfaces").

use glam::DVec3;

/// Samples a unit direction of the lobe cos^α around the unit vector `axis`, where α is `exponent`. Its density is
/// (α + 1)/2π · cos^α (thesis Eq. 4.5 with arccos). `random_pair` has two random numbers from 0 to 1, the first of which
/// is 1 − ξ of the equation. For an infinite exponent the result is `axis` itself.
pub fn lobe_direction(axis: DVec3, exponent: f64, random_pair: [f64; 2]) -> DVec3 {
    if exponent.is_infinite() {
        return axis;
    }
    // Computing from ln cos θ stays exact where cos θ is near 1: sin² θ = 1 − cos² θ = −(e^(2 ln cos θ) − 1).
    let ln_cos = (-random_pair[0]).ln_1p() / (exponent + 1.0);
    let (cos, sin) = (ln_cos.exp(), (-(2.0 * ln_cos).exp_m1()).max(0.0).sqrt());
    let (sin_phi, cos_phi) = (std::f64::consts::TAU * random_pair[1]).sin_cos();
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    (sin * cos_phi * tangent + sin * sin_phi * bitangent + cos * axis).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_ground::math::phong;
    use ssct_ground::math::random::Stream;

    #[test]
    fn the_cone_of_a_roughness_holds_its_share_of_the_lobe() {
        let axis = DVec3::new(0.3, -0.5, 0.7).normalize();
        // The cone of angle `roughness` must hold the share 1 − ξ of the directions.
        for roughness in [0.01, 0.1, 0.6, 1.0] {
            let exponent = phong::exponent(roughness);
            let (count, stream) = (20_000, Stream::new(1, 0));
            let inside = (0..count)
                .filter(|&i| {
                    let direction = lobe_direction(axis, exponent, [stream.uniform(2 * i), stream.uniform(2 * i + 1)]);
                    assert!((direction.length() - 1.0).abs() < 1e-12);
                    direction.cross(axis).length().atan2(direction.dot(axis)) < roughness / 2.0
                })
                .count() as f64;
            let share = 1.0 - phong::XI;
            let standard_deviation = (share * phong::XI / count as f64).sqrt();
            assert!(
                (inside / count as f64 - share).abs() < 4.0 * standard_deviation,
                "{roughness}: {}",
                inside / count as f64
            );
        }
        assert_eq!(lobe_direction(axis, f64::INFINITY, [0.5, 0.5]), axis);
    }
}
