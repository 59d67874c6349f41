//! Films as animated pictures, which repeat without end.

use ssct_truth::metrics::video::Film;
use webp_animation::{Encoder, EncoderOptions, EncodingConfig};

/// Quality of the animated pictures, from 0 to 100.
const QUALITY: f32 = 85.0;

/// Encodes a film as an animated picture (WebP).
///
/// # Errors
/// The encoder's message, as for images that are too large for the format.
pub fn encode_animation(film: &Film, frames_per_second: f32) -> Result<Vec<u8>, String> {
    let message = |e: webp_animation::Error| format!("{e:?}");
    let config = EncodingConfig::new_lossy(QUALITY);
    let options = EncoderOptions { encoding_config: Some(config), ..EncoderOptions::default() };
    let mut encoder = Encoder::new_with_options((film.width, film.height), options).map_err(message)?;
    let time_ms = |n: usize| (1000.0 * n as f32 / frames_per_second).round() as i32;
    for (n, frame) in film.frames.iter().enumerate() {
        let rgba: Vec<u8> = frame.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], 255]).collect();
        encoder.add_frame(&rgba, time_ms(n)).map_err(message)?;
    }
    Ok(encoder.finalize(time_ms(film.frames.len())).map_err(message)?.to_vec())
}
