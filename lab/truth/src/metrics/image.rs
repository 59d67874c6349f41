//! Differences of linear images over the pixels of a mask (docs/definitions.md, "Image error").

use super::rmse;

/// A linear image: [red, green, blue] for each pixel, rows from the top.
pub type LinearPixels<'a> = &'a [[f32; 3]];

/// Returns the root of the mean squared difference over the three channels of the mask's pixels: 0 if the mask is
/// empty, and NaN if a compared value is NaN.
///
/// # Panics
/// If the images and the mask differ in length.
pub fn masked_rmse(reference: LinearPixels, test: LinearPixels, mask: &[bool]) -> f64 {
    rmse(select(reference, mask).as_flattened(), select(test, mask).as_flattened())
}

/// Returns the mean squared difference, divided by the mean squared value of the reference, over the three channels of
/// the mask's pixels. `None` if the reference is black in all of them.
///
/// # Panics
/// If the images and the mask differ in length.
pub fn masked_relative_mse(reference: LinearPixels, test: LinearPixels, mask: &[bool]) -> Option<f64> {
    let (reference, test) = (select(reference, mask), select(test, mask));
    let square = |v: f32| f64::from(v).powi(2);
    let reference_energy: f64 = reference.as_flattened().iter().map(|v| square(*v)).sum();
    let value_count = reference.len() as f64 * 3.0;
    (reference_energy != 0.0)
        .then(|| rmse(reference.as_flattened(), test.as_flattened()).powi(2) * value_count / reference_energy)
}

/// Returns the error of each pixel: the root of the mean squared difference over its three channels, and 0 outside the
/// mask. The root mean square of the map over the mask is [`masked_rmse`].
///
/// # Panics
/// If the images and the mask differ in length.
pub fn error_map(reference: LinearPixels, test: LinearPixels, mask: &[bool]) -> Vec<f32> {
    check_size(reference, test.len());
    check_size(test, mask.len());
    let pairs = reference.iter().zip(test).zip(mask);
    pairs.map(|((a, b), masked)| if *masked { rmse(a, b) as f32 } else { 0.0 }).collect()
}

/// Returns the pixels of an image that belong to a mask, in order.
fn select(image: LinearPixels, mask: &[bool]) -> Vec<[f32; 3]> {
    check_size(image, mask.len());
    image.iter().zip(mask).filter(|(_, masked)| **masked).map(|(rgb, _)| *rgb).collect()
}

/// Panics unless the image has `pixels` pixels.
fn check_size(image: LinearPixels, pixels: usize) {
    assert_eq!(image.len(), pixels, "images and masks must have equal sizes");
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: [[f32; 3]; 3] = [[1.0, 0.0, 2.0], [0.5, 0.5, 0.5], [3.0, 0.0, 0.0]];
    const TEST: [[f32; 3]; 3] = [[1.0, 3.0, 2.0], [9.0, 9.0, 9.0], [3.0, 4.0, 0.0]];
    const MASK: [bool; 3] = [true, false, true];

    #[test]
    fn errors_are_those_of_a_hand_computation() {
        // Differences in the mask: 0, 3, 0 and 0, 4, 0.
        assert!((masked_rmse(&REFERENCE, &TEST, &MASK) - (25.0_f64 / 6.0).sqrt()).abs() < 1e-12);
        // The squares of the reference add up to 1 + 4 + 9.
        let relative = masked_relative_mse(&REFERENCE, &TEST, &MASK).expect("not black");
        assert!((relative - 25.0 / 14.0).abs() < 1e-12);
        let map = error_map(&REFERENCE, &TEST, &MASK);
        assert!((map[0] - 3_f32.sqrt()).abs() < 1e-6 && map[1] == 0.0 && (map[2] - 4.0 / 3_f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn an_empty_mask_and_a_black_reference_have_no_relative_error() {
        assert_eq!(masked_rmse(&REFERENCE, &TEST, &[false; 3]), 0.0);
        assert_eq!(masked_relative_mse(&REFERENCE, &TEST, &[false; 3]), None);
        assert_eq!(masked_relative_mse(&[[0.0; 3]], &[[1.0; 3]], &[true]), None);
        assert!(masked_rmse(&REFERENCE, &[[f32::NAN; 3]; 3], &MASK).is_nan());
    }
}
