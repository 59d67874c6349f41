//! The pictures of a case: the finished image with the true reflection, and one with the reflection by each variant.

use super::cases::Complaint;
use super::frames::SeenFrame;
use crate::study::exhibit::{Content, ExtraFile};
use glam::Vec3;
use ssct_ground::math::display_byte;
use ssct_truth::metrics::flicker::finite_or_black;
use ssct_truth::metrics::video::Film;

/// The folder of the pictures.
pub const FOLDER: &str = "pictures";

/// The name that stands for a method in the file of the true reflection's picture.
pub const TRUTH: &str = "truth";

/// Frames of a film that are shown per second.
const FRAMES_PER_SECOND: f32 = 6.0;

/// Returns the path of a case's picture in the folder of the run; `method` is a variant's name, or [`TRUTH`].
pub fn file(complaint: &Complaint, method: &str) -> String {
    let file_name_part = |text: &str| -> String {
        text.chars().filter(|c| *c != ',').map(|c| if c.is_alphanumeric() { c } else { '-' }).collect()
    };
    let ending = if complaint.is_film { "webp" } else { "png" };
    format!("{FOLDER}/{}-{}.{ending}", file_name_part(complaint.name), file_name_part(method))
}

/// Makes the picture files of a case: one of the true reflection, and one of each variant. `names` are the names of the
/// variants.
pub fn files(complaint: &Complaint, names: &[String], frames: &[SeenFrame]) -> Vec<ExtraFile> {
    let truth = frames.iter().map(|seen| picture(seen, &seen.truth)).collect();
    let variant_pictures =
        |variant: usize| frames.iter().map(|seen| picture(seen, &seen.reflections[variant])).collect();
    let extra_file =
        |name: &str, pictures| ExtraFile { path: file(complaint, name), content: content(complaint, pictures) };
    let methods = names.iter().enumerate().map(|(variant, name)| extra_file(name, variant_pictures(variant)));
    std::iter::once(extra_file(TRUTH, truth)).chain(methods).collect()
}

/// A picture: width and height, and three bytes a pixel.
type Picture = ([u32; 2], Vec<u8>);

/// Makes the finished picture of a frame: its lit colour, plus reflectivity times a reflection, without a fade.
fn picture(seen: &SeenFrame, reflection: &[Vec3]) -> Picture {
    let reflectivity = |i: usize| if seen.screen.reflects(i) { seen.screen.reflectivity[i] } else { 0.0 };
    let colors = seen.screen.color.iter().zip(reflection).enumerate();
    let bytes = colors
        .flat_map(|(i, (lit, color))| (*lit + reflectivity(i) * finite_or_black(*color)).to_array().map(display_byte));
    ([seen.screen.width, seen.screen.height], bytes.collect())
}

/// Makes the content of a file from the pictures of a case's frames: a film, or one picture with all of them side by
/// side.
fn content(complaint: &Complaint, pictures: Vec<Picture>) -> Content {
    let [width, height] = [0, 1].map(|axis| pictures.iter().map(|(extent, _)| extent[axis]).max().unwrap_or(1));
    if complaint.is_film {
        let frames = pictures.iter().map(|picture| enlarged(picture, [width, height])).collect();
        return Content::Film(Film { width, height, frames }, FRAMES_PER_SECOND);
    }
    let whole_width = pictures.iter().map(|(extent, _)| extent[0]).sum();
    let mut bytes = Vec::new();
    for y in 0..height {
        for (extent, picture_bytes) in &pictures {
            let row_bytes = 3 * extent[0] as usize;
            // Below a picture that is less high than others it is white, since black means a missing reflection.
            let white = vec![255; row_bytes];
            bytes.extend(picture_bytes.get(y as usize * row_bytes..(y as usize + 1) * row_bytes).unwrap_or(&white));
        }
    }
    Content::Picture([whole_width, height], bytes)
}

/// Scales a picture to another width and height, without a filter: each pixel copies one pixel of the picture.
fn enlarged((extent, bytes): &Picture, [width, height]: [u32; 2]) -> Vec<u8> {
    let texel = |x: u32, y: u32| {
        let index = (y * extent[1] / height * extent[0] + x * extent[0] / width) as usize;
        [0, 1, 2].map(|channel| bytes[3 * index + channel])
    };
    (0..height).flat_map(|y| (0..width).flat_map(move |x| texel(x, y))).collect()
}
