//! Directions of the Phong lobe (docs/definitions.md, "Surfaces").

use glam::DVec3;

/// Samples a unit direction of the lobe cos^α around the unit vector `axis`, where α is `exponent`. Its density is (α +
/// 1)/2π · cos^α (thesis Eq. 4.5 with arccos, ξ = 1 − u₀). `u` are two random numbers from 0 to 1. For an infinite
/// exponent the result is `axis` itself.
pub fn lobe_direction(axis: DVec3, exponent: f64, u: [f64; 2]) -> DVec3 {
    if exponent.is_infinite() {
        return axis;
    }
    // Computing from ln cos θ stays exact where cos θ is near 1: sin² θ = 1 − cos² θ = −(e^(2 ln cos θ) − 1).
    let ln_cos = (-u[0]).ln_1p() / (exponent + 1.0);
    let (cos, sin) = (ln_cos.exp(), (-(2.0 * ln_cos).exp_m1()).max(0.0).sqrt());
    let (sin_phi, cos_phi) = (std::f64::consts::TAU * u[1]).sin_cos();
    let (x, y) = axis.any_orthonormal_pair();
    (sin * cos_phi * x + sin * sin_phi * y + cos * axis).normalize()
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
            let (n, stream) = (20_000, Stream::new(1, 0));
            let inside = (0..n)
                .filter(|&i| {
                    let d = lobe_direction(axis, exponent, [stream.uniform(2 * i), stream.uniform(2 * i + 1)]);
                    assert!((d.length() - 1.0).abs() < 1e-12);
                    d.cross(axis).length().atan2(d.dot(axis)) < roughness / 2.0
                })
                .count() as f64;
            let share = 1.0 - phong::XI;
            let deviation = (share * phong::XI / n as f64).sqrt();
            assert!((inside / n as f64 - share).abs() < 4.0 * deviation, "{roughness}: {}", inside / n as f64);
        }
        assert_eq!(lobe_direction(axis, f64::INFINITY, [0.5, 0.5]), axis);
    }
}
