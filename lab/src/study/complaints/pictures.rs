//! The pictures of a case: the image with the true reflection, and with the reflection by each method.

use super::cases::Complaint;
use super::frames::SeenFrame;
use crate::study::exhibit::{Content, ExtraFile};
use glam::Vec3;
use ssct_ground::math::display_byte;
use ssct_truth::metrics::flicker::sound;
use ssct_truth::metrics::video::Film;

/// The folder of the pictures.
pub const FOLDER: &str = "pictures";

/// Name of the pictures of the true reflection.
pub const TRUTH: &str = "truth";

/// Frames of a film that are shown per second.
const FRAMES_PER_SECOND: f32 = 6.0;

/// The file of a case's picture by a method, or of the true reflection.
pub fn file(complaint: &Complaint, method: &str) -> String {
    let plain = |text: &str| -> String {
        text.chars().filter(|c| *c != ',').map(|c| if c.is_alphanumeric() { c } else { '-' }).collect()
    };
    let ending = if complaint.is_film { "webp" } else { "png" };
    format!("{FOLDER}/{}-{}.{ending}", plain(complaint.name), plain(method))
}

/// The pictures of the true reflection and of each method, in the order of `names`.
pub fn all(complaint: &Complaint, names: &[String], frames: &[SeenFrame]) -> Vec<ExtraFile> {
    let truth = frames.iter().map(|seen| picture(seen, &seen.truth)).collect();
    let made = |variant: usize| frames.iter().map(|seen| picture(seen, &seen.made[variant])).collect();
    let extra_file =
        |name: &str, pictures| ExtraFile { path: file(complaint, name), content: content(complaint, pictures) };
    let methods = names.iter().enumerate().map(|(n, name)| extra_file(name, made(n)));
    std::iter::once(extra_file(TRUTH, truth)).chain(methods).collect()
}

/// A picture: width and height, and three bytes a pixel.
type Picture = ([u32; 2], Vec<u8>);

/// The finished picture of a frame: its lit colour, plus reflectivity times a reflection that does not fade.
fn picture(seen: &SeenFrame, reflection: &[Vec3]) -> Picture {
    let share = |i: usize| if seen.screen.reflects(i) { seen.screen.reflectivity[i] } else { 0.0 };
    let colors = seen.screen.color.iter().zip(reflection).enumerate();
    let bytes = colors.flat_map(|(i, (lit, color))| (*lit + share(i) * sound(*color)).to_array().map(display_byte));
    ([seen.screen.width, seen.screen.height], bytes.collect())
}

/// The pictures as the content of a file: a film, or one picture with all of them side by side.
fn content(complaint: &Complaint, pictures: Vec<Picture>) -> Content {
    let [width, height] = [0, 1].map(|axis| pictures.iter().map(|(extent, _)| extent[axis]).max().unwrap_or(1));
    if complaint.is_film {
        let frames = pictures.iter().map(|picture| enlarged(picture, [width, height])).collect();
        return Content::Film(Film { width, height, frames }, FRAMES_PER_SECOND);
    }
    let whole = pictures.iter().map(|(extent, _)| extent[0]).sum();
    let mut bytes = Vec::new();
    for y in 0..height {
        for (extent, own) in &pictures {
            let row = 3 * extent[0] as usize;
            // The rest of a column is white, since black means a missing reflection.
            let beside = vec![255; row];
            bytes.extend(own.get(y as usize * row..(y as usize + 1) * row).unwrap_or(&beside));
        }
    }
    Content::Picture([whole, height], bytes)
}

/// A picture scaled to another size by the nearest pixel.
fn enlarged((extent, bytes): &Picture, [width, height]: [u32; 2]) -> Vec<u8> {
    let texel = |x: u32, y: u32| {
        let index = (y * extent[1] / height * extent[0] + x * extent[0] / width) as usize;
        [0, 1, 2].map(|channel| bytes[3 * index + channel])
    };
    (0..height).flat_map(|y| (0..width).flat_map(move |x| texel(x, y))).collect()
}
