//! The Pareto front of run time and error.

/// Indices, in order of time, of the points (time, error) that no other point beats. A point beats another if
/// it is no slower, no worse, and better in at least one of the two. Points that are not finite are never on
/// the front.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    let mut front: Vec<usize> = (0..points.len())
        .filter(|i| finite(&points[*i]))
        .filter(|i| !points.iter().any(|p| finite(p) && beats(*p, points[*i])))
        .collect();
    front.sort_by(|a, b| points[*a].0.total_cmp(&points[*b].0));
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points =
            [(3.0, 1.0), (1.0, 3.0), (2.0, 2.0), (2.5, 2.0), (3.0, 3.0), (f64::NAN, 0.0), (0.5, f64::INFINITY)];
        assert_eq!(front(&points), [1, 2, 0]);
        assert_eq!(front(&[(1.0, 1.0), (1.0, 1.0)]), [0, 1], "equal points don't beat each other");
        assert_eq!(front(&[]), [0; 0]);
    }
}
