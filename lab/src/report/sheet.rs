//! Sets pictures beside each other, enlarges and frames parts of them, and draws the difference of two.

use super::images::Rgb;
use crate::error::{Error, Result};

/// Pixels between two pictures.
const GAP: u32 = 8;

/// A part of a picture: left, top, width and height as shares of its sides.
pub type Part = [f32; 4];

/// Sets rows of pictures below each other on white; the pictures of a row are aligned at their tops.
pub fn sheet(rows: &[Vec<Rgb>]) -> Rgb {
    let width = |row: &Vec<Rgb>| row.iter().map(|p| p.width + GAP).sum::<u32>().saturating_sub(GAP);
    let height = |row: &Vec<Rgb>| row.iter().map(|p| p.height).max().unwrap_or(0);
    let total = rows.iter().map(|r| height(r) + GAP).sum::<u32>().saturating_sub(GAP);
    let mut sheet = blank(rows.iter().map(width).max().unwrap_or(0), total, 255);
    let mut y = 0;
    for row in rows {
        let mut x = 0;
        for picture in row {
            paste(&mut sheet, picture, x, y);
            x += picture.width + GAP;
        }
        y += height(row) + GAP;
    }
    sheet
}

/// Makes a picture whose bytes all are `value`.
pub(super) fn blank(width: u32, height: u32, value: u8) -> Rgb {
    Rgb { width, height, bytes: vec![value; 3 * width as usize * height as usize] }
}

/// Copies the picture `image` into `onto`, with its left upper pixel at `x`, `y`. It must fit there.
pub(super) fn paste(onto: &mut Rgb, image: &Rgb, x: u32, y: u32) {
    for row in 0..image.height {
        let from = 3 * (row * image.width) as usize;
        let to = 3 * ((y + row) * onto.width + x) as usize;
        let len = 3 * image.width as usize;
        onto.bytes[to..to + len].copy_from_slice(&image.bytes[from..from + len]);
    }
}

/// Returns the pixels of a part of a picture as left, top, width and height: at least one pixel, all inside the
/// picture.
fn pixel_bounds(picture: &Rgb, [x, y, w, h]: Part) -> [u32; 4] {
    let place = |share: f32, side: u32| ((share * side as f32).round() as u32).min(side - 1);
    let (x, y) = (place(x, picture.width), place(y, picture.height));
    let size = |share: f32, side: u32, from: u32| ((share * side as f32).round() as u32).clamp(1, side - from);
    [x, y, size(w, picture.width, x), size(h, picture.height, y)]
}

/// Returns a part of a picture, enlarged by the factor `factor`: each pixel becomes a square, and nothing is
/// interpolated.
pub fn enlarged(picture: &Rgb, part: Part, factor: u32) -> Rgb {
    let [left, top, width, height] = pixel_bounds(picture, part);
    let mut bytes = Vec::with_capacity(3 * (width * height * factor * factor) as usize);
    for y in 0..height * factor {
        for x in 0..width * factor {
            let start = 3 * ((top + y / factor) * picture.width + left + x / factor) as usize;
            bytes.extend_from_slice(&picture.bytes[start..start + 3]);
        }
    }
    Rgb { width: width * factor, height: height * factor, bytes }
}

/// Returns the picture with a red frame along the inner edge of a part.
pub fn framed(picture: &Rgb, part: Part) -> Rgb {
    let [left, top, width, height] = pixel_bounds(picture, part);
    let mut framed = picture.clone();
    for y in top..top + height {
        for x in left..left + width {
            // The frame is two pixels wide and lies inside the part.
            let to_edge = [x - left, y - top, left + width - 1 - x, top + height - 1 - y].into_iter().min();
            if to_edge.is_some_and(|distance| distance < 2) {
                let start = 3 * (y * picture.width + x) as usize;
                framed.bytes[start..start + 3].copy_from_slice(&[230, 30, 30]);
            }
        }
    }
    framed
}

/// Returns the absolute difference of two display images, times a factor and at most 255.
pub fn difference(a: &Rgb, b: &Rgb, factor: u8) -> Result<Rgb> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Error::usage(format!("{}x{} and {}x{} can't be compared", a.width, a.height, b.width, b.height)));
    }
    let bytes = a.bytes.iter().zip(&b.bytes).map(|(a, b)| a.abs_diff(*b).saturating_mul(factor)).collect();
    Ok(Rgb { bytes, ..*a })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a picture in which red counts the columns, and green the rows.
    fn ramp(width: u32, height: u32) -> Rgb {
        let bytes = (0..width * height).flat_map(|n| [(n % width) as u8, (n / width) as u8, 7]).collect();
        Rgb { width, height, bytes }
    }

    /// Returns the colour of the pixel in a column and a row.
    fn pixel(picture: &Rgb, column: u32, row: u32) -> [u8; 3] {
        let first = 3 * (row * picture.width + column) as usize;
        [0, 1, 2].map(|channel| picture.bytes[first + channel])
    }

    #[test]
    fn rows_of_pictures_are_aligned_at_their_tops_with_gaps_between_them() {
        let two_rows = sheet(&[vec![ramp(4, 2), ramp(3, 5)], vec![ramp(2, 2)]]);
        assert_eq!((two_rows.width, two_rows.height), (4 + GAP + 3, 5 + GAP + 2));
        assert_eq!(pixel(&two_rows, 3, 1), [3, 1, 7]);
        assert_eq!(pixel(&two_rows, 3, 2), [255; 3], "below the lower picture");
        assert_eq!(pixel(&two_rows, 4 + GAP + 2, 4), [2, 4, 7]);
        assert_eq!(pixel(&two_rows, 1, 5 + GAP + 1), [1, 1, 7]);
        assert_eq!((sheet(&[]).width, sheet(&[]).height), (0, 0));
    }

    #[test]
    fn parts_are_enlarged_and_framed() {
        let large = enlarged(&ramp(8, 8), [0.5, 0.25, 0.25, 0.5], 3);
        assert_eq!((large.width, large.height), (6, 12));
        assert_eq!((pixel(&large, 2, 0), pixel(&large, 3, 11)), ([4, 2, 7], [5, 5, 7]));
        let framed = framed(&ramp(16, 16), [0.25, 0.25, 0.5, 0.5]);
        let red: [u8; 3] = [230, 30, 30];
        assert_eq!([pixel(&framed, 4, 8), pixel(&framed, 11, 11), pixel(&framed, 8, 8)], [red, red, [8, 8, 7]]);
        assert_eq!(pixel(&framed, 3, 8), [3, 8, 7]);
        // A part that reaches beyond the edge is cut to the pixels that there are.
        assert_eq!(enlarged(&ramp(4, 4), [1.0, 0.9, 0.5, 0.5], 1).bytes, [3, 3, 7]);
    }

    #[test]
    fn the_difference_is_absolute_and_does_not_wrap() {
        let (a, b) = (Rgb { width: 1, height: 1, bytes: vec![10, 200, 3] }, ramp(1, 1));
        assert_eq!(difference(&a, &b, 2).expect("one size").bytes, [20, 255, 8]);
        assert!(difference(&a, &ramp(2, 1), 1).is_err());
    }
}
