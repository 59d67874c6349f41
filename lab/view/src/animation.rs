//! Writes frames of the window as an animated GIF for a web page. In later frames, pixels that do not change are
//! transparent, which keeps the file small.

use ssct::gpu::Pixels;
use ssct_lab::error::{Error, Result};
use ssct_lab::report::files;
use ssct_lab::report::images::display;
use std::path::Path;

/// The greatest difference between two bytes of a colour that counts as invisible.
const INVISIBLE: u8 = 3;
/// The speed of the colour quantisation, from 1 (best quality) to 30.
const SPEED: i32 = 10;

/// An animation that grows frame by frame.
pub struct Animation {
    delay_ms: u16,
    size: [u16; 2],
    /// RGBA bytes; unchanged pixels are transparent.
    frames: Vec<Vec<u8>>,
    /// The RGBA bytes that the frames so far leave on the screen.
    seen: Vec<u8>,
}

impl Animation {
    /// Makes an animation without frames; each frame will be shown for `delay_ms` milliseconds.
    pub fn new(delay_ms: u16) -> Self {
        Self { delay_ms, size: [0; 2], frames: Vec::new(), seen: Vec::new() }
    }

    /// Adds the picture of the screen as a frame.
    ///
    /// # Errors
    /// [`Usage`](ssct::Error::Usage) if the frame's size differs from that of the first frame, or is above 65535 pixels
    /// a side.
    pub fn add(&mut self, screen: &Pixels) -> Result<()> {
        let rgb = display(screen);
        let is_first = self.frames.is_empty();
        let size = [rgb.width, rgb.height].map(u16::try_from);
        let [Ok(width), Ok(height)] = size else {
            return Err(Error::usage("an animation has at most 65535 pixels a side".into()));
        };
        if is_first {
            self.size = [width, height];
            self.seen = vec![0; 4 * rgb.bytes.len() / 3];
        }
        if self.size != [width, height] {
            return Err(Error::usage("the window changed its size during the animation".into()));
        }
        let mut rgba = vec![0; self.seen.len()];
        let texels = rgb.bytes.chunks_exact(3).zip(self.seen.chunks_exact_mut(4)).zip(rgba.chunks_exact_mut(4));
        // The texel of the screen, what the frames so far show there, and the texel of the frame that is added.
        for ((current, seen), added) in texels {
            if is_first || current.iter().zip(&*seen).any(|(a, b)| a.abs_diff(*b) > INVISIBLE) {
                added.copy_from_slice(&[current[0], current[1], current[2], 255]);
                seen.copy_from_slice(added);
            }
        }
        self.frames.push(rgba);
        Ok(())
    }

    /// Writes the animation to a file; it repeats forever.
    pub fn write(self, path: &Path) -> Result<()> {
        let failed = |e: gif::EncodingError| Error::io("encode", path, std::io::Error::other(e));
        let mut bytes = Vec::new();
        let mut encoder = gif::Encoder::new(&mut bytes, self.size[0], self.size[1], &[]).map_err(failed)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        for mut rgba in self.frames {
            let mut frame = gif::Frame::from_rgba_speed(self.size[0], self.size[1], &mut rgba, SPEED);
            // Transparent pixels keep the previous frame's colour.
            frame.dispose = gif::DisposalMethod::Keep;
            // GIF counts hundredths of a second.
            frame.delay = self.delay_ms.div_ceil(10);
            encoder.write_frame(&frame).map_err(failed)?;
        }
        // Dropping the encoder writes the end of the file.
        drop(encoder);
        Ok(files::write(path, &bytes)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    #[test]
    fn written_frames_equal_the_added_ones() {
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
            // A pixel that did not change must still be blue, and not show the background.
            for (i, pixel) in frame.buffer().pixels().enumerate() {
                let [red, _, blue, alpha] = pixel.0;
                assert!((red > 200) == (i == n) && blue > 100 && alpha == 255, "frame {n}, pixel {i}: {pixel:?}");
            }
        }
    }
}
