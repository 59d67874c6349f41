//! The cone as an isosceles triangle with its in-circles (thesis §4.2.8, Eq. 4.6, Alg. 5): the CPU
//! twin of `shaders-glsl/thesis/cone_trace.glsl`.

/// Base a of the triangle of height h and half angle θ (Eq. 4.6).
pub fn isosceles_triangle_base(h: f64, theta: f64) -> f64 {
    2.0 * h * theta.tan()
}

/// Radius r of the in-circle of a triangle with height h and base a (Eq. 4.6).
pub fn isosceles_triangle_in_radius(h: f64, a: f64) -> f64 {
    a * ((a * a + 4.0 * h * h).sqrt() - a) / (4.0 * h)
}

/// A circle inscribed in the cone. Both lengths are in the unit of the ray's length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Distance of the centre from the cone's apex.
    pub distance: f64,
    /// Radius.
    pub radius: f64,
}

/// The first `count` circles of a cone of half angle `theta`, in radians, that ends at distance `h` (Alg. 5), from the
/// hit towards the apex. With `lengthened` the height first grows by the triangle's base, as in the author's program.
pub fn circles(h: f64, theta: f64, count: usize, lengthened: bool) -> Vec<Circle> {
    let mut h = if lengthened { h + isosceles_triangle_base(h, theta) } else { h };
    (0..count)
        .map(|_| {
            let radius = isosceles_triangle_in_radius(h, isosceles_triangle_base(h, theta));
            let circle = Circle { distance: h - radius, radius };
            h -= 2.0 * radius;
            circle
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_touch_the_sides_and_each_other() {
        for theta in [0.01_f64, 0.05, 0.3, 0.7] {
            let found = circles(0.6, theta, 7, false);
            assert!((found[0].distance + found[0].radius - 0.6).abs() < 1e-12, "the first touches the base");
            for pair in found.windows(2) {
                // In closed form r = distance · sin θ, and each circle is (1−s)/(1+s) of the last.
                let s = theta.sin();
                assert!((pair[0].radius - pair[0].distance * s).abs() < 1e-12);
                assert!((pair[1].radius / pair[0].radius - (1.0 - s) / (1.0 + s)).abs() < 1e-9);
                assert!((pair[0].distance - pair[0].radius - pair[1].distance - pair[1].radius).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn an_equilateral_triangle_has_the_known_in_radius() {
        // Side 2, height √3: r = 1/√3.
        let h = 3_f64.sqrt();
        assert!((isosceles_triangle_in_radius(h, 2.0) - 1.0 / h).abs() < 1e-12);
    }
}
