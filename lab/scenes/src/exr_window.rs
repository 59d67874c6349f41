//! The part of an OpenEXR image that its display window shows. The data window, whose pixels are stored, may be larger,
//! for example if it has overscan.

use exr::math::Vec2;
use exr::meta::attribute::IntegerBounds;
use exr::meta::header::Header;

/// Where the image lies within the pixels of a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImageWindow {
    /// Width of the part in pixels.
    stored_width: usize,
    /// Index of the first stored column and row that are shown.
    first: [usize; 2],
    /// Width and height of the image.
    pub(super) size: [usize; 2],
}

impl ImageWindow {
    /// Finds the image within a part. The first corner and the size of the stored pixels and of the display window are
    /// given in pixels of the file's plane.
    ///
    /// # Errors
    /// A message about a part whose pixels do not cover the display window.
    pub(super) fn new(
        stored_corner: Vec2<i32>,
        stored_size: Vec2<usize>,
        window: IntegerBounds,
    ) -> std::result::Result<Self, String> {
        // The first shown pixel along one axis, counted from the first stored one; `None` if the stored pixels do not
        // cover the window.
        let first_shown = |stored_start: i32, stored_count: usize, window_start: i32, window_count: usize| {
            let first = usize::try_from(i64::from(window_start) - i64::from(stored_start)).ok()?;
            (first.checked_add(window_count)? <= stored_count && window_count > 0).then_some(first)
        };
        let first_column = first_shown(stored_corner.x(), stored_size.x(), window.position.x(), window.size.x());
        let first_row = first_shown(stored_corner.y(), stored_size.y(), window.position.y(), window.size.y());
        match first_column.zip(first_row) {
            Some((x, y)) => {
                Ok(Self { stored_width: stored_size.x(), first: [x, y], size: [window.size.x(), window.size.y()] })
            }
            None => Err(format!(
                "it has {}x{} pixels from {}, {} on, and its image has {}x{} from {}, {} on; only whole images can be read",
                stored_size.0,
                stored_size.1,
                stored_corner.0,
                stored_corner.1,
                window.size.0,
                window.size.1,
                window.position.0,
                window.position.1
            )),
        }
    }

    /// Finds the image within the part that a header describes.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub(super) fn of_header(header: &Header) -> std::result::Result<Self, String> {
        let position = header.own_attributes.layer_position;
        Self::new(position, header.layer_size, header.shared_attributes.display_window)
    }

    /// Crops the values of a channel, stored row by row, to the image. If there are fewer values than the image needs,
    /// they are returned unchanged.
    pub(super) fn crop(&self, values: Vec<f32>) -> Vec<f32> {
        let Self { stored_width, first: [first_column, first_row], size: [width, height] } = *self;
        let is_whole = [first_column, first_row] == [0, 0] && width == stored_width && width * height == values.len();
        if is_whole || stored_width == 0 || values.len() < stored_width * (first_row + height) {
            return values;
        }
        let rows = values.chunks_exact(stored_width).skip(first_row).take(height);
        rows.flat_map(|row| &row[first_column..first_column + width]).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_part_covers_its_image() {
        let window = IntegerBounds { position: Vec2(0, 0), size: Vec2(2, 1) };
        let shown = ImageWindow::new(Vec2(-1, -1), Vec2(4, 3), window).unwrap();
        assert_eq!(shown.crop((0..12).map(|v| v as f32).collect()), [5.0, 6.0]);
        let whole = ImageWindow::new(Vec2(0, 0), Vec2(2, 1), window).unwrap();
        assert_eq!(whole.crop(vec![1.0, 2.0]), [1.0, 2.0]);
    }

    #[test]
    fn a_part_that_lacks_pixels_is_refused() {
        let window = IntegerBounds { position: Vec2(0, 0), size: Vec2(2, 2) };
        for (corner, size) in [(Vec2(1, 0), Vec2(2, 2)), (Vec2(0, 0), Vec2(2, 1)), (Vec2(i32::MIN, 0), Vec2(9, 9))] {
            let message = ImageWindow::new(corner, size, window).unwrap_err();
            assert!(message.ends_with("only whole images can be read"), "{message}");
        }
    }
}
