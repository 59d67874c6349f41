//! Pictures inside the page: a file on disk becomes a data URI.

use crate::error::{Error, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use std::path::Path;

/// Quality of the page's JPEGs, of 100: differences between methods stay visible, and a picture
/// takes about a fifth of its PNG.
pub const JPEG_QUALITY: u8 = 88;

/// A picture as the page holds it.
pub struct Embedded {
    /// `data:image/…;base64,…`.
    pub uri: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// A PNG as a JPEG, or as it is where that is no larger.
pub fn embed(path: &Path) -> Result<Embedded> {
    let png = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let wrong = |e: image::ImageError| Error::io("read", path, std::io::Error::other(e));
    let pixels = image::load_from_memory(&png).map_err(wrong)?.into_rgb8();
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY).encode_image(&pixels).map_err(wrong)?;
    let (kind, bytes) = if png.len() <= jpeg.len() { ("png", png) } else { ("jpeg", jpeg) };
    let uri = format!("data:image/{kind};base64,{}", STANDARD.encode(bytes));
    Ok(Embedded { uri, width: pixels.width(), height: pixels.height() })
}
