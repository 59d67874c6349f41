//! How far two images are apart.

pub mod flip;
pub mod pareto;

/// Root of the mean squared difference over all values (DEFINITIONS, "Image error": the three
/// channels of the pixels compared). Zero for none.
///
/// # Panics
/// If the slices differ in length.
pub fn rmse(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len(), "images of one size are compared");
    if a.is_empty() {
        return 0.0;
    }
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
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
}
