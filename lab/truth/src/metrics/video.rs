//! The quality of a film compared with a reference film, in just-objectionable differences (JOD), by ColorVideoVDP
//! (Mantiuk et al. 2024, "ColorVideoVDP: A visual difference predictor for image, video and display distortions").

use colorvideovdp::{Color, Cvvdp, DisplayModel, Geometry, Image, Options, Photometry};
use ssct_ground::{Error, Result};

/// The name of the monitor of the metric on which the films are judged. Its light is used (at most 200 cd/m², under the
/// 250 lux of an office), but its pixels span the same angle as in [`FlipMap`](super::flip::FlipMap).
const DISPLAY: &str = "standard_4k";

/// Greatest working memory of the metric, in bytes.
const MEMORY: usize = 8 << 30;

/// A film: display images of one size, 3 · width · height sRGB bytes each, rows from the top.
#[derive(Debug, Clone, Default)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The images in order.
    pub frames: Vec<Vec<u8>>,
}

/// Returns the quality of a film in JOD, compared with a reference of equal length and size: 10 if nobody sees a
/// difference, and one less if 75 % of people prefer the reference.
///
/// # Errors
/// [`Error::Usage`] if the films differ in size or length, or the metric refuses them as too large or too short.
pub fn jod(film: &Film, reference: &Film, frames_per_second: f32) -> Result<f64> {
    let to_usage_error =
        |e: colorvideovdp::Error| Error::Usage(format!("ColorVideoVDP does not compare the films: {e}"));
    let images = |film: &Film| {
        let image = |bytes: &Vec<u8>| {
            let channel_values = bytes.iter().map(|b| f32::from(*b) / 255.0).collect();
            Image::new(film.width as usize, film.height as usize, 3, channel_values)
        };
        film.frames.iter().map(image).collect::<colorvideovdp::Result<Vec<_>>>()
    };
    let compare = || -> colorvideovdp::Result<f64> {
        let monitor = DisplayModel::from_name(DISPLAY)?;
        let pixels = [film.width as usize, film.height as usize];
        let geometry = Geometry::from_ppd(pixels, f64::from(nv_flip::DEFAULT_PIXELS_PER_DEGREE))?;
        let photometry: Photometry = monitor.photometry;
        let display = DisplayModel::new(DISPLAY, photometry, geometry, monitor.color_space)?;
        let metric = Cvvdp::new(display, Options::default().with_memory_limit_bytes(MEMORY))?;
        let quality = metric.predict_video(&images(film)?, &images(reference)?, frames_per_second, Color::Srgb)?;
        Ok(f64::from(quality.jod))
    };
    compare().map_err(to_usage_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a grey film of 12 frames, in which a texture moves by one pixel a frame.
    fn film() -> Film {
        let (width, height) = (64, 48);
        let texel = |frame_index: u32, x: u32, y: u32| (((x + frame_index) * 37 + y * 91) % 200 + 20) as u8;
        let frame = |frame_index| {
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            pixels.flat_map(|(x, y)| [texel(frame_index, x, y); 3]).collect()
        };
        Film { width, height, frames: (0..12).map(frame).collect() }
    }

    /// Returns the film with `change(frame index, pixel index)` added to each byte of the pixel, clamped to 0…255.
    fn with_added(mut film: Film, change: impl Fn(usize, usize) -> i16) -> Film {
        for (frame_index, frame) in film.frames.iter_mut().enumerate() {
            for (i, byte) in frame.iter_mut().enumerate() {
                // A pixel has three bytes.
                *byte = (i16::from(*byte) + change(frame_index, i / 3)).clamp(0, 255) as u8;
            }
        }
        film
    }

    #[test]
    fn a_film_is_worth_most_beside_itself_and_less_the_more_it_differs() {
        let reference = film();
        let quality_jod =
            |change: &dyn Fn(usize, usize) -> i16| jod(&with_added(film(), change), &reference, 30.0).expect("a value");
        assert!((quality_jod(&|_, _| 0) - 10.0).abs() < 1e-3);
        let [weak, strong] = [4, 16].map(|step| quality_jod(&|_, i| if i % 7 < 3 { step } else { 0 }));
        assert!(weak < 10.0 && strong < weak - 0.2, "{weak}, {strong}");
    }

    /// Tests that a difference counts less if it is the same in each frame than if its sign alternates, which no metric
    /// of single images can measure.
    #[test]
    fn what_flickers_is_worth_less_than_what_stands_still() {
        let black = with_added(film(), |_, _| -255);
        let reference = with_added(black, |_, _| 128);
        let quality_jod =
            |change: &dyn Fn(usize) -> i16| jod(&with_added(reference.clone(), |n, _| change(n)), &reference, 30.0);
        let still = quality_jod(&|_| 8).expect("a value");
        let flickering = quality_jod(&|n| if n % 4 < 2 { 8 } else { -8 }).expect("a value");
        assert!(flickering < still - 0.5, "{flickering}, {still}");
    }

    #[test]
    fn films_of_other_lengths_are_refused() {
        let short = Film { frames: film().frames[..3].to_vec(), ..film() };
        let refused = jod(&short, &film(), 30.0).expect_err("another length");
        assert!(refused.to_string().starts_with("ColorVideoVDP does not compare the films"), "{refused}");
    }
}
