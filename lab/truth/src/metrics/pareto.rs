//! The Pareto front of run time and error.

/// Returns the indices, in order of time, of the points (time, error) that no other point beats. A point beats another
/// if it is no slower, has no greater error, and is better in time or error. Points that are not finite are never on
/// the front.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let exact = |(time, error): &(f64, f64)| MeasuredPoint { least: *time, most: *time, error: *error };
    front_of_measured(&points.iter().map(exact).collect::<Vec<_>>())
}

/// A time that is known as an interval, and an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredPoint {
    /// The least possible time.
    pub least: f64,
    /// The greatest possible time.
    pub most: f64,
    /// The error.
    pub error: f64,
}

impl MeasuredPoint {
    /// Returns whether this point keeps `other` off the front. For that, its interval must allow it to be as fast as
    /// `other`, and its error must be no greater. Moreover, it must be certainly faster or have a smaller error.
    fn beats(&self, other: &Self) -> bool {
        let may_be_as_fast = self.least <= other.most;
        may_be_as_fast && self.error <= other.error && (self.most < other.least || self.error < other.error)
    }
}

/// Returns the indices, in order of least time, of the points that no other point beats; times are known as intervals.
/// If the intervals of two points overlap and their errors are equal, neither point beats the other. Points that are
/// not finite are never on the front.
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
        // Two copies of one point, one of them faster by noise alone.
        assert_eq!(front_of_measured(&[timed(1.0, 0.1, 0.5), timed(1.1, 0.1, 0.5)]), [0, 1]);
        // The second is faster by noise alone and clearly worse; the third is clearly faster.
        assert_eq!(front_of_measured(&[timed(1.0, 0.1, 0.5), timed(0.9, 0.1, 0.6), timed(0.5, 0.1, 0.6)]), [2, 0]);
        // Neither copy is on the front if a third point beats both.
        assert_eq!(front_of_measured(&[timed(2.0, 0.1, 0.5), timed(2.1, 0.1, 0.5), timed(1.0, 0.1, 0.5)]), [2]);
        assert_eq!(front_of_measured(&[timed(f64::NAN, 0.0, 0.1), timed(1.0, 0.0, f64::INFINITY)]), [0; 0]);
        // Without noise the front equals the front of exact points.
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
