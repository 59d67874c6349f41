//! ꟻLIP between display images (Andersson et al. 2020, "ꟻLIP: A Difference Evaluator for Alternating
//! Images"), by NVIDIA's own implementation.

/// The ꟻLIP error of each pixel, from 0 (equal) to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct FlipMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` errors, rows from the top.
    pub errors: Vec<f32>,
}

impl FlipMap {
    /// Returns the errors of the display image `test` compared with `reference`: 3 · width · height sRGB bytes each,
    /// rows from the top. The viewing distance is ꟻLIP's default, at which a pixel spans 1/67 of a degree (a 4K display
    /// 0.7 m wide, 0.7 m away).
    ///
    /// # Panics
    /// If an image has another size than stated.
    pub fn new(reference: &[u8], test: &[u8], width: u32, height: u32) -> Self {
        let byte_count = 3 * width as usize * height as usize;
        assert!(reference.len() == byte_count && test.len() == byte_count, "both images must have the stated size");
        let image = |bytes| nv_flip::FlipImageRgb8::with_data(width, height, bytes);
        let map = nv_flip::flip(image(reference), image(test), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
        Self { width, height, errors: map.to_vec() }
    }

    /// Returns the mean error over all pixels, the single number that ꟻLIP's authors recommend; 0 if there are no
    /// pixels.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.errors.iter().map(|e| f64::from(*e)).sum();
        sum / self.errors.len().max(1) as f64
    }

    /// Returns the map as a picture in the "magma" colours of ꟻLIP's own tool: 3 · width · height bytes, rows from the
    /// top.
    pub fn picture(&self) -> Vec<u8> {
        let map = nv_flip::FlipImageFloat::with_data(self.width, self.height, &self.errors);
        map.apply_color_lut(&nv_flip::magma_lut()).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns an image of 32 × 24 pixels of one colour, as sRGB bytes.
    fn flat_image(color: [u8; 3]) -> Vec<u8> {
        color.repeat(32 * 24)
    }

    #[test]
    fn equal_images_have_no_error() {
        let image: Vec<u8> = (0..32 * 24 * 3).map(|i| (i * 37 % 251) as u8).collect();
        assert_eq!(FlipMap::new(&image, &image, 32, 24).mean(), 0.0);
    }

    #[test]
    fn flat_colours_have_the_error_of_the_papers_formula() {
        // Flat images have no features, and no filter changes them, so that the error is the colour term alone: the
        // HyAB distance in Hunt-adjusted L*a*b* to the power 0.7. Up to 0.4 of its greatest value it is mapped to
        // 0…0.95, and beyond to 0.95…1. The distance of black and white is 100. The greatest distance is that of green
        // and blue, whose L*a*b* values are (87.735, −86.183, 83.180) and (32.297, 79.188, −107.860). Hunt's adjustment
        // scales a* and b* by L*/100.
        let hyab = |a: [f64; 3], b: [f64; 3]| {
            let hunt = |c: [f64; 3], i: usize| c[0] / 100.0 * c[i];
            (a[0] - b[0]).abs() + (hunt(a, 1) - hunt(b, 1)).hypot(hunt(a, 2) - hunt(b, 2))
        };
        let greatest_error = hyab([87.735, -86.183, 83.180], [32.297, 79.188, -107.860]).powf(0.7);
        let expected = |distance: f64| {
            let (color_error, knee) = (distance.powf(0.7), 0.4 * greatest_error);
            if color_error < knee {
                0.95 * color_error / knee
            } else {
                0.95 + 0.05 * (color_error - knee) / (greatest_error - knee)
            }
        };
        let mean_error = FlipMap::new(&flat_image([0; 3]), &flat_image([255; 3]), 32, 24).mean();
        assert!((mean_error - expected(100.0)).abs() < 1e-4, "{mean_error} {}", expected(100.0));
        assert!((0.967..0.968).contains(&mean_error));
        // sRGB 119 has L* = 50.034, which is below the knee.
        let mean_error = FlipMap::new(&flat_image([119; 3]), &flat_image([0; 3]), 32, 24).mean();
        assert!((mean_error - expected(50.034)).abs() < 1e-3, "{mean_error} {}", expected(50.034));
    }

    #[test]
    fn the_map_locates_the_error_and_the_picture_has_its_size() {
        let mut test = flat_image([128; 3]);
        for y in 0..24 {
            test[3 * (y * 32 + 31)..3 * (y * 32 + 32)].fill(255);
        }
        let map = FlipMap::new(&flat_image([128; 3]), &test, 32, 24);
        assert!(map.errors[31] > 0.5 && map.errors[0] < 1e-6);
        assert_eq!(map.picture().len(), 32 * 24 * 3);
    }
}
