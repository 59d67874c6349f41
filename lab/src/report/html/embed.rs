//! Pictures inside the page: a file on disk becomes a data URI.

use crate::error::{Error, Result};
use crate::report::images::Rgb;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::{RgbImage, imageops};
use ssct_scenes::inside::PathInFolder;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

/// Quality of the page's JPEGs, from 0 to 100: differences between methods stay visible, and a picture takes about an
/// eighth of the bytes of its PNG.
pub const JPEG_QUALITY: u8 = 80;

/// A picture as the page holds it.
pub struct EmbeddedPicture {
    /// `data:image/…;base64,…`.
    pub uri: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// The folder of a page's pictures. Pages that are written again and again as they grow embed each picture once.
pub struct PictureFolder {
    place: PathInFolder,
    embedded: RefCell<BTreeMap<String, Rc<EmbeddedPicture>>>,
}

impl PictureFolder {
    /// Takes the folder at `path`, of which no picture is embedded yet. Its pictures must not change afterwards.
    pub fn new(path: &Path) -> Self {
        Self { place: PathInFolder::folder(path), embedded: RefCell::default() }
    }

    /// The folder.
    pub fn place(&self) -> &PathInFolder {
        &self.place
    }

    /// Embeds the picture at the path `file` in the folder, unless it is embedded already. A picture wider than `widest`
    /// pixels is scaled down.
    pub(super) fn embed(&self, file: &str, widest: u32) -> Result<Rc<EmbeddedPicture>> {
        if let Some(known) = self.embedded.borrow().get(file) {
            return Ok(Rc::clone(known));
        }
        let embedded = Rc::new(embed(&self.place.join(file), widest)?);
        self.embedded.borrow_mut().insert(file.to_owned(), Rc::clone(&embedded));
        Ok(embedded)
    }
}

/// Embeds a PNG file as a JPEG, or unchanged if the JPEG is no smaller. A picture wider than `widest` pixels is scaled
/// down and is always a JPEG.
pub fn embed(place: &PathInFolder, widest: u32) -> Result<EmbeddedPicture> {
    let png = place.bytes()?;
    let wrong = |e: image::ImageError| Error::io("read", place.path(), std::io::Error::other(e));
    let pixels = image::load_from_memory(&png).map_err(wrong)?.into_rgb8();
    if pixels.width() > widest {
        let height = (u64::from(pixels.height()) * u64::from(widest) / u64::from(pixels.width())).max(1) as u32;
        return jpeg(&imageops::resize(&pixels, widest, height, imageops::FilterType::Triangle)).map_err(wrong);
    }
    let as_jpeg = jpeg(&pixels).map_err(wrong)?;
    let png_uri = uri("png", &png);
    Ok(if png_uri.len() <= as_jpeg.uri.len() { EmbeddedPicture { uri: png_uri, ..as_jpeg } } else { as_jpeg })
}

/// Embeds a picture that lies in memory, and not in a file, as a JPEG.
pub fn data_uri(picture: &Rgb) -> Result<EmbeddedPicture> {
    let wrong = |what: &str| Error::usage(format!("a picture of {}x{}: {what}", picture.width, picture.height));
    let pixels = RgbImage::from_raw(picture.width, picture.height, picture.bytes.clone());
    jpeg(&pixels.ok_or_else(|| wrong("its bytes don't fit"))?).map_err(|e| wrong(&e.to_string()))
}

/// Returns the data URI of an SVG drawing, which is embedded unchanged. The text of the drawing states its size.
pub fn svg_uri(svg: &[u8]) -> String {
    uri("svg+xml", svg)
}

/// Encodes a picture as a JPEG in a data URI.
fn jpeg(pixels: &RgbImage) -> image::ImageResult<EmbeddedPicture> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY).encode_image(pixels)?;
    Ok(EmbeddedPicture { uri: uri("jpeg", &bytes), width: pixels.width(), height: pixels.height() })
}

/// Returns the data URI of an image file; `kind` is its format, as in the type `image/png`.
fn uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:image/{kind};base64,{}", STANDARD.encode(bytes))
}
