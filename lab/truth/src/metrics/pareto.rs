//! The Pareto front of run time and error.

/// Indices, in order of time, of the points (time, error) that no other point beats. A point beats another if
/// it is no slower, no worse, and better in at least one of the two. Points that are not finite are never on
/// the front.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let exact = |(cost, error): &(f64, f64)| MeasuredPoint { least: *cost, most: *cost, error: *error };
    front_of_measured(&points.iter().map(exact).collect::<Vec<_>>())
}

/// A time that is known as an interval, and an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredPoint {
    /// The least that the time may be.
    pub least: f64,
    /// The most that it may be.
    pub most: f64,
    /// The error.
    pub error: f64,
}

impl MeasuredPoint {
    /// Whether this one keeps the other off the front: it may be as fast and has no greater error, and it is surely faster or
    /// has the smaller error.
    fn beats(&self, other: &Self) -> bool {
        let may_be_as_fast = self.least <= other.most;
        may_be_as_fast && self.error <= other.error && (self.most < other.least || self.error < other.error)
    }
}

/// Indices, in order of time, of the points that no other point beats where times are known as intervals: of two copies of
/// one thing neither beats the other. Points that are not finite are never on the front.
pub fn front_of_measured(points: &[MeasuredPoint]) -> Vec<usize> {
    let finite = |p: &MeasuredPoint| p.least.is_finite() && p.most.is_finite() && p.error.is_finite();
    let mut front: Vec<usize> = (0..points.len())
        .filter(|i| finite(&points[*i]) && !points.iter().any(|p| finite(p) && p.beats(&points[*i])))
        .collect();
    front.sort_by(|a, b| points[*a].least.total_cmp(&points[*b].least));
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_the_front_and_noise_gives_no_place_on_it() {
        let timed = |time: f64, noise: f64, error| MeasuredPoint { least: time - noise, most: time + noise, error };
        // Two copies, one of them faster by noise alone.
        assert_eq!(front_of_measured(&[timed(1.0, 0.1, 0.5), timed(1.1, 0.1, 0.5)]), [0, 1]);
        // The second is faster by noise alone and clearly worse; the third is clearly faster.
        assert_eq!(front_of_measured(&[timed(1.0, 0.1, 0.5), timed(0.9, 0.1, 0.6), timed(0.5, 0.1, 0.6)]), [2, 0]);
        // Neither copy is on the front if something beats them.
        assert_eq!(front_of_measured(&[timed(2.0, 0.1, 0.5), timed(2.1, 0.1, 0.5), timed(1.0, 0.1, 0.5)]), [2]);
        assert_eq!(front_of_measured(&[timed(f64::NAN, 0.0, 0.1), timed(1.0, 0.0, f64::INFINITY)]), [0; 0]);
        // Without noise it is the front of points.
        let exact = [(3.0, 1.0), (1.0, 3.0), (2.0, 2.0), (2.5, 2.0), (3.0, 3.0)];
        let points: Vec<_> = exact.iter().map(|(time, error)| timed(*time, 0.0, *error)).collect();
        assert_eq!(front_of_measured(&points), front(&exact));
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points =
            [(3.0, 1.0), (1.0, 3.0), (2.0, 2.0), (2.5, 2.0), (3.0, 3.0), (f64::NAN, 0.0), (0.5, f64::INFINITY)];
        assert_eq!(front(&points), [1, 2, 0]);
        assert_eq!(front(&[(1.0, 1.0), (1.0, 1.0)]), [0, 1], "equal points don't beat each other");
        assert_eq!(front(&[]), [0; 0]);
    }
}
