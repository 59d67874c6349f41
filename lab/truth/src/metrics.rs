//! Measures of the difference between two images, two sets of hits or two sets of times, and the Pareto front of time
//! and error.

pub mod bootstrap;
pub mod flicker;
pub mod flip;
pub mod hits;
pub mod image;
pub mod pareto;
pub mod place;
pub mod verdict;
pub mod video;
pub mod world;

pub use hits::HitAgreement;

/// Returns the root of the mean squared difference between the values of `a` and of `b`, in their unit; 0 without
/// values. Image errors pass the three channels of the compared pixels (docs/definitions.md, "Image error").
///
/// # Panics
/// If the slices differ in length.
pub fn rmse(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len(), "the slices must have equal lengths");
    if a.is_empty() {
        return 0.0;
    }
    let squared_sum: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    (squared_sum / a.len() as f64).sqrt()
}

/// Returns the nearest-rank percentile: the least number of `sorted` such that at least the `share` (0 < share ≤ 1) of
/// all numbers are less or equal. `sorted` must be in ascending order; `None` if it is empty.
pub fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rmse_is_that_of_a_hand_computation() {
        // Differences 0, 3, 4, 0: √(25 / 4).
        assert!((rmse(&[1.0, 0.0, 0.0, 2.0], &[1.0, 3.0, -4.0, 2.0]) - 2.5).abs() < 1e-12);
        assert_eq!(rmse(&[], &[]), 0.0);
        assert!(rmse(&[f32::NAN], &[0.0]).is_nan(), "NaN is not hidden");
    }

    #[test]
    fn percentiles_are_nearest_ranks() {
        let numbers: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!(percentile(&numbers, 0.5), Some(100.0));
        assert_eq!(percentile(&numbers, 0.99), Some(198.0));
        assert_eq!(percentile(&numbers, 1.0), Some(200.0));
        assert_eq!((percentile(&[7.0], 0.01), percentile(&[], 0.5)), (Some(7.0), None));
    }
}
