//! Frames of the window as an animated GIF: pictures for a page. Pixels that stay as they were are left
//! out of the later frames, which keeps the file small.

use crate::error::{Error, Result};
use crate::gpu::Pixels;
use crate::report::files;
use crate::report::images::display;
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbaImage};
use std::path::Path;

/// How far two bytes may differ to be the same to the eye.
const SAME: u8 = 3;
/// Of the quantisation, from 1 (best) to 30.
const SPEED: i32 = 10;

/// An animation that grows frame by frame.
pub struct Animation {
    delay_ms: u32,
    frames: Vec<RgbaImage>,
    /// What the frames so far leave on the screen, in RGBA bytes.
    seen: Vec<u8>,
}

impl Animation {
    /// An empty one, of so many milliseconds a frame.
    pub fn new(delay_ms: u32) -> Self {
        Self { delay_ms, frames: Vec::new(), seen: Vec::new() }
    }

    /// Adds a screen. All must be of one size, else it is an error.
    pub fn add(&mut self, screen: &Pixels) -> Result<()> {
        let rgb = display(screen);
        let is_first = self.frames.is_empty();
        if is_first {
            self.seen = vec![0; 4 * rgb.bytes.len() / 3];
        }
        if self.seen.len() != 4 * rgb.bytes.len() / 3 {
            return Err(Error::Usage("the window changed its size during the animation".into()));
        }
        let mut rgba = vec![0; self.seen.len()];
        let texels = rgb.bytes.chunks_exact(3).zip(self.seen.chunks_exact_mut(4)).zip(rgba.chunks_exact_mut(4));
        for ((now, seen), out) in texels {
            if is_first || now.iter().zip(&*seen).any(|(a, b)| a.abs_diff(*b) > SAME) {
                out.copy_from_slice(&[now[0], now[1], now[2], 255]);
                seen.copy_from_slice(out);
            }
        }
        let image = RgbaImage::from_raw(rgb.width, rgb.height, rgba)
            .ok_or_else(|| Error::Usage("an animation's frame has no pixels".into()))?;
        self.frames.push(image);
        Ok(())
    }

    /// Writes the file, which repeats without an end.
    pub fn write(self, path: &Path) -> Result<()> {
        let failed = |e: image::ImageError| Error::io("encode", path, std::io::Error::other(e));
        let mut bytes = Vec::new();
        let mut encoder = GifEncoder::new_with_speed(&mut bytes, SPEED);
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        let delay = Delay::from_numer_denom_ms(self.delay_ms, 1);
        for image in self.frames {
            encoder.encode_frame(Frame::from_parts(image, 0, 0, delay)).map_err(failed)?;
        }
        // The end of the file is written with the encoder's.
        drop(encoder);
        files::write(path, &bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    #[test]
    fn frames_are_what_was_added() {
        let screen = |bright: usize| Pixels {
            width: 4,
            height: 2,
            channels: 4,
            values: (0..8).flat_map(|i| if i == bright { [1.0; 4] } else { [0.0, 0.0, 0.2, 1.0] }).collect(),
        };
        let mut animation = Animation::new(50);
        for i in 0..3 {
            animation.add(&screen(i)).unwrap();
        }
        assert!(animation.add(&Pixels { width: 1, height: 1, channels: 4, values: vec![0.0; 4] }).is_err());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        animation.write(&path).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let frames = image::codecs::gif::GifDecoder::new(file).unwrap().into_frames().collect_frames().unwrap();
        assert_eq!(frames.len(), 3);
        for (n, frame) in frames.iter().enumerate() {
            let bright = frame.buffer().pixels().map(|p| p.0[0] > 200).collect::<Vec<_>>();
            assert_eq!(bright, (0..8).map(|i| i == n).collect::<Vec<_>>(), "frame {n}");
        }
    }
}
