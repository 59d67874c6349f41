//! The bytes that a document points to: buffers, images, and the accessors of numbers.

use crate::error::{Error, Result};
use crate::scene::bounded;
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, Semantic};
use percent_encoding::percent_decode_str;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The largest file beside the document that is read, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 32;

/// Base64 with or without its padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A document with the bytes of its buffers.
pub(super) struct Data<'a> {
    pub(super) path: &'a Path,
    pub(super) document: &'a Document,
    buffers: Vec<Vec<u8>>,
}

/// Where the bytes of an image are.
pub(super) enum ImageBytes<'a> {
    /// Within the document or one of its buffers.
    Here(Cow<'a, [u8]>),
    /// In a file.
    File(PathBuf),
}

impl<'a> Data<'a> {
    /// Reads all buffers.
    pub(super) fn new(path: &'a Path, document: &'a Document, mut blob: Option<Vec<u8>>) -> Result<Self> {
        let mut buffers = Vec::new();
        for (i, buffer) in document.as_json().buffers.iter().enumerate() {
            let bytes = match &buffer.uri {
                Some(uri) => match inline(uri) {
                    Some(bytes) => bytes.ok_or_else(|| malformed(path, format!("buffer {i} is not valid base64")))?,
                    None => bounded::read(&beside(path, uri), "a buffer", MAX_FILE_BYTES)
                        .map_err(|e| malformed(path, format!("buffer {i} cannot be used: {e}")))?,
                },
                None => blob.take().filter(|_| i == 0).ok_or_else(|| {
                    malformed(path, format!("buffer {i} has no address, and the file has no binary chunk for it"))
                })?,
            };
            let stated = buffer.byte_length.0;
            if stated > bytes.len() as u64 {
                let message = format!("buffer {i} has {} bytes where the document states {stated}", bytes.len());
                return Err(malformed(path, message));
            }
            buffers.push(bytes);
        }
        Ok(Self { path, document, buffers })
    }

    /// An error about the file.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        malformed(self.path, message)
    }

    /// The bytes of a buffer view.
    fn view(&self, index: usize) -> Result<&[u8]> {
        let outside = || self.error(format!("buffer view {index} leaves its buffer"));
        let view = self.document.as_json().buffer_views.get(index).ok_or_else(outside)?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(outside)?;
        let start = view.byte_offset.map_or(0, |o| o.0);
        let end = start.checked_add(view.byte_length.0).ok_or_else(outside)?;
        let [start, end] = [start, end].map(|v| usize::try_from(v).unwrap_or(usize::MAX));
        buffer.get(start..end).ok_or_else(outside)
    }

    /// Where an image's bytes are, and what messages call it.
    pub(super) fn image(&self, index: usize) -> Result<(String, ImageBytes<'_>)> {
        let Some(image) = self.document.as_json().images.get(index) else {
            return Err(self.error(format!("there is no image {index}")));
        };
        let name = |fallback: String| image.name.clone().unwrap_or(fallback);
        if let Some(view) = image.buffer_view {
            return Ok((name(format!("image {index}")), ImageBytes::Here(self.view(view.value())?.into())));
        }
        let Some(uri) = &image.uri else {
            return Err(self.error(format!("image {index} has neither an address nor a buffer view")));
        };
        Ok(match inline(uri) {
            Some(bytes) => {
                let bytes = bytes.ok_or_else(|| self.error(format!("image {index} is not valid base64")))?;
                (name(format!("image {index}")), ImageBytes::Here(bytes.into()))
            }
            None => {
                (percent_decode_str(uri).decode_utf8_lossy().into_owned(), ImageBytes::File(beside(self.path, uri)))
            }
        })
    }

    /// The vectors of an accessor, with integers brought to 0…1 or −1…1 where the accessor says so.
    pub(super) fn vectors<const N: usize>(&self, accessor: &Accessor, semantic: &Semantic) -> Result<Vec<[f32; N]>> {
        let dimensions = accessor.dimensions();
        if dimensions != [Dimensions::Scalar, Dimensions::Vec2, Dimensions::Vec3, Dimensions::Vec4][N - 1] {
            let what = semantic.to_string();
            return Err(self.error(format!("accessor {} of {what} must have {N} components", accessor.index())));
        }
        let normalized = accessor.normalized();
        let number = |bytes: &[u8]| -> f32 {
            let unit = |value: f32, greatest: f32| if normalized { (value / greatest).max(-1.0) } else { value };
            match *bytes {
                [a] if accessor.data_type() == DataType::I8 => unit(f32::from(a as i8), 127.0),
                [a] => unit(f32::from(a), 255.0),
                [a, b] if accessor.data_type() == DataType::I16 => unit(f32::from(i16::from_le_bytes([a, b])), 32767.0),
                [a, b] => unit(f32::from(u16::from_le_bytes([a, b])), 65535.0),
                [a, b, c, d] if accessor.data_type() == DataType::F32 => f32::from_le_bytes([a, b, c, d]),
                [a, b, c, d] => unit(u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
                _ => 0.0,
            }
        };
        let size = accessor.data_type().size();
        let vector = |element: &[u8]| std::array::from_fn(|k| number(&element[k * size..(k + 1) * size]));
        Ok(self.elements(accessor)?.map(vector).collect())
    }

    /// The indices of an accessor.
    pub(super) fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>> {
        let integer = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !integer {
            return Err(self.error(format!("accessor {} of indices must have unsigned integers", accessor.index())));
        }
        let index = |element: &[u8]| element.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte));
        Ok(self.elements(accessor)?.map(index).collect())
    }

    /// The bytes of each element of an accessor, which all lie within its view.
    fn elements<'b>(&'b self, accessor: &Accessor) -> Result<impl Iterator<Item = &'b [u8]> + use<'b>> {
        let index = accessor.index();
        let json = &self.document.as_json().accessors[index];
        let (Some(view), None) = (json.buffer_view, &json.sparse) else {
            return Err(self.error(format!("accessor {index} is sparse, which is not supported; export without it")));
        };
        let bytes = self.view(view.value())?;
        let size = accessor.size();
        let stride = self.document.as_json().buffer_views[view.value()].byte_stride.map_or(size, |s| s.0.max(1));
        let outside = || self.error(format!("accessor {index} leaves its buffer view"));
        let start = usize::try_from(json.byte_offset.map_or(0, |o| o.0)).map_err(|_| outside())?;
        let count = usize::try_from(json.count.0).map_err(|_| outside())?;
        let end = count.checked_sub(1).map_or(Some(start), |last| {
            last.checked_mul(stride).and_then(|v| v.checked_add(start)).and_then(|v| v.checked_add(size))
        });
        if end.is_none_or(|end| end > bytes.len()) {
            return Err(outside());
        }
        Ok((0..count).map(move |k| &bytes[start + k * stride..][..size]))
    }
}

fn malformed(path: &Path, message: impl Into<String>) -> Error {
    Error::malformed(path, None, message)
}

/// The bytes of a `data:` address in base64; the inner `None` if they are not valid. `None` for other addresses.
fn inline(uri: &str) -> Option<Option<Vec<u8>>> {
    let (_, encoded) = uri.strip_prefix("data:")?.split_once(";base64,").unwrap_or_default();
    Some(BASE64.decode(encoded).ok().filter(|bytes| !bytes.is_empty()))
}

/// The file that an address names, relative to the document's folder.
fn beside(path: &Path, uri: &str) -> PathBuf {
    let name = percent_decode_str(uri).decode_utf8_lossy().into_owned();
    let folder = path.parent().unwrap_or(Path::new(""));
    crate::scene::obj::resolve(folder, &name).unwrap_or_else(|| folder.join(name))
}
