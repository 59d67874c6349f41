//! Comparison of two images (docs/definitions.md, "Image error").

use super::CompareHead;
use serde::Serialize;
use ssct::gpu::Pixels;
use ssct_ground::math::display_byte;
use ssct_truth::metrics::flip::FlipMap;
use ssct_truth::metrics::image::{error_map, masked_relative_mse, masked_rmse};

/// A linear image, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearImage {
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// `width · height` colours: red, green, blue.
    pub rgb: Vec<[f32; 3]>,
}

/// Difference of two images. A figure is null in JSON if an image has a value that is not a number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageComparison {
    /// Kind of the record, which is `compare-images`, with versions and the names of the images.
    #[serde(flatten)]
    pub head: CompareHead,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Root mean square error of the linear values.
    pub rmse: f64,
    /// Mean square error divided by the mean square of the reference; null if the reference is black.
    pub rel_mse: Option<f64>,
    /// Mean FLIP of the display images, 0…1.
    pub flip: f64,
    /// Greatest RMSE of a pixel, among pixels whose RMSE is a number.
    pub greatest: f32,
    /// Column and row of the pixel with the greatest RMSE, from the top left.
    pub greatest_at: [u32; 2],
    /// RMSE of each pixel.
    #[serde(skip)]
    pub rmse_map: Vec<f32>,
    /// FLIP of each pixel as a picture: 3 bytes a pixel.
    #[serde(skip)]
    pub flip_picture: Vec<u8>,
}

/// Compares an image with a reference, each given with its name; `None` if their sizes differ.
pub fn images(reference: (&str, &LinearImage), test: (&str, &LinearImage)) -> Option<ImageComparison> {
    let ((a_name, a), (b_name, b)) = (reference, test);
    let (width, height) = (a.width, a.height);
    if (width, height) != (b.width, b.height) {
        return None;
    }
    let every_pixel = vec![true; a.rgb.len()];
    let flip = FlipMap::new(&display(&a.rgb), &display(&b.rgb), width, height);
    let rmse_map = error_map(&a.rgb, &b.rgb, &every_pixel);
    let (mut worst_pixel, mut greatest) = (0, 0.0);
    for (pixel, error) in rmse_map.iter().enumerate() {
        if *error > greatest {
            (worst_pixel, greatest) = (pixel, *error);
        }
    }
    Some(ImageComparison {
        head: CompareHead::new("compare-images", a_name, b_name),
        width,
        height,
        rmse: masked_rmse(&a.rgb, &b.rgb, &every_pixel),
        rel_mse: masked_relative_mse(&a.rgb, &b.rgb, &every_pixel),
        flip: flip.mean(),
        greatest,
        greatest_at: [worst_pixel as u32 % width, worst_pixel as u32 / width],
        rmse_map,
        flip_picture: flip.picture(),
    })
}

/// Returns red, green and blue of each pixel of an image.
pub fn rgb(pixels: &Pixels) -> Vec<[f32; 3]> {
    pixels.texels().map(|t| [t[0], t[1], t[2]]).collect()
}

/// Converts linear colours to a display image, 3 bytes a pixel.
pub fn display(color: &[[f32; 3]]) -> Vec<u8> {
    color.iter().flat_map(|c| c.map(display_byte)).collect()
}
