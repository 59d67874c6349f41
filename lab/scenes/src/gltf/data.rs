//! The bytes that a document points to: buffers, images, and the accessors of numbers.
//!
//! An accessor is read one element at a time ([`Vectors`], [`Indices`]). Primitives that share a large accessor then read only
//! the elements that they draw.

use super::compression;
use crate::obj::resolve;
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::accessor::{DataType, Dimensions};
use gltf::json::accessor::IndexComponentType;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::validation::Checked;
use gltf::{Accessor, Document, Semantic};
use percent_encoding::percent_decode_str;
use ssct_geometry::bounded;
use ssct_ground::{Error, Result};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Greatest size, in bytes, of a file beside the document that is read.
const MAX_FILE_BYTES: u64 = 1 << 32;

/// Greatest number of elements of indices or positions that may have no bytes in the file.
const MAX_ZEROS: usize = 1 << 20;

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
    /// The decoded bytes of compressed views, by the view's index.
    decoded: HashMap<usize, Vec<u8>>,
}

/// Location of an image's bytes.
pub(super) enum ImageBytes<'a> {
    /// Bytes within the document or one of its buffers.
    Here(Cow<'a, [u8]>),
    /// Path of a file.
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
                    None => {
                        let file = relative_file(path, uri).map_err(|m| malformed(path, format!("buffer {i} {m}")))?;
                        bounded::read(&file, "a buffer", MAX_FILE_BYTES)
                            .map_err(|e| malformed(path, format!("buffer {i} cannot be used: {e}")))?
                    }
                },
                None if compression::is_placeholder(buffer) => {
                    buffers.push(Vec::new());
                    continue;
                }
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
        let decoded = decoded(path, document, &buffers)?;
        Ok(Self { path, document, buffers, decoded })
    }

    /// An error about the file.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        malformed(self.path, message)
    }

    /// The bytes of a buffer view.
    fn view(&self, index: usize) -> Result<&[u8]> {
        if let Some(bytes) = self.decoded.get(&index) {
            return Ok(bytes);
        }
        let outside = || self.error(format!("buffer view {index} leaves its buffer"));
        let view = self.document.as_json().buffer_views.get(index).ok_or_else(outside)?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(outside)?;
        let start = view.byte_offset.map_or(0, |o| o.0);
        let end = start.checked_add(view.byte_length.0).ok_or_else(outside)?;
        let [start, end] = [start, end].map(|v| usize::try_from(v).unwrap_or(usize::MAX));
        buffer.get(start..end).ok_or_else(outside)
    }

    /// The location of an image's bytes, and the image's name in messages.
    pub(super) fn image(&self, index: usize) -> Result<(String, ImageBytes<'_>)> {
        let Some(image) = self.document.as_json().images.get(index) else {
            return Err(self.error(format!("there is no image {index}")));
        };
        let name = |fallback: String| image.name.as_deref().map_or(fallback, bounded::printable_name);
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
                let file = relative_file(self.path, uri).map_err(|m| self.error(format!("image {index} {m}")))?;
                (bounded::printable_name(&percent_decode_str(uri).decode_utf8_lossy()), ImageBytes::File(file))
            }
        })
    }

    /// The vectors of an accessor.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the accessor has not `N` components, or leaves its buffer.
    pub(super) fn vectors<const N: usize>(&self, accessor: &Accessor, semantic: &Semantic) -> Result<Vectors<'_, N>> {
        let dimensions = accessor.dimensions();
        let wanted = [Dimensions::Scalar, Dimensions::Vec2, Dimensions::Vec3, Dimensions::Vec4];
        if wanted.get(N - 1) != Some(&dimensions) {
            let what = semantic.to_string();
            return Err(self.error(format!("accessor {} of {what} must have {N} components", accessor.index())));
        }
        self.numbers(accessor)
    }

    /// The matrices of an accessor, column by column.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the accessor has no matrices of 4 × 4 floats, or leaves its buffer.
    pub(super) fn matrices(&self, accessor: &Accessor) -> Result<Vectors<'_, 16>> {
        if accessor.dimensions() != Dimensions::Mat4 || accessor.data_type() != DataType::F32 {
            let index = accessor.index();
            return Err(self.error(format!("accessor {index} of inverse bind matrices must have 4x4 floats")));
        }
        self.numbers(accessor)
    }

    /// The numbers of an accessor, whose elements have `N` numbers each.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the accessor leaves its buffer, has other elements, or claims more than [`MAX_ZEROS`]
    /// elements without bytes.
    pub(super) fn floats<const N: usize>(&self, accessor: &Accessor) -> Result<Vectors<'_, N>> {
        let numbers = self.numbers(accessor)?;
        if accessor.dimensions().multiplicity() != N {
            return Err(self.error(format!("accessor {} must have {N} components", accessor.index())));
        }
        self.check_claim(accessor.index(), &numbers.elements)?;
        Ok(numbers)
    }

    /// The elements of an accessor as vectors of `N` numbers; the caller checks that each element has `N` numbers.
    fn numbers<const N: usize>(&self, accessor: &Accessor) -> Result<Vectors<'_, N>> {
        let (data_type, normalized) = (accessor.data_type(), accessor.normalized());
        Ok(Vectors { elements: self.elements(accessor)?, data_type, normalized })
    }

    /// The indices of an accessor.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the accessor has no unsigned integers, leaves its buffer, or claims more than
    /// [`MAX_ZEROS`] elements without bytes.
    pub(super) fn indices(&self, accessor: &Accessor) -> Result<Indices<'_>> {
        let integer = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !integer {
            return Err(self.error(format!("accessor {} of indices must have unsigned integers", accessor.index())));
        }
        let elements = self.elements(accessor)?;
        self.check_claim(accessor.index(), &elements)?;
        Ok(Indices(elements))
    }

    /// Checks that the accessor of an index claims no huge number of elements without bytes in the file, which are
    /// zeros.
    ///
    /// # Errors
    /// [`Error::Malformed`] for more than [`MAX_ZEROS`] elements without bytes.
    pub(super) fn check_claim(&self, index: usize, elements: &Elements) -> Result<()> {
        if elements.base.is_none() && elements.count > MAX_ZEROS {
            let count = elements.count;
            return Err(
                self.error(format!("accessor {index} has {count} elements without bytes, more than {MAX_ZEROS}"))
            );
        }
        Ok(())
    }

    /// The elements of an accessor, which all lie within its view.
    fn elements(&self, accessor: &Accessor) -> Result<Elements<'_>> {
        let index = accessor.index();
        let json = &self.document.as_json().accessors[index];
        let size = accessor.size();
        let outside = || self.error(format!("accessor {index} leaves its buffer view"));
        let count = usize::try_from(json.count.0).map_err(|_| outside())?;
        let base = match json.buffer_view {
            Some(view) => {
                let views = &self.document.as_json().buffer_views;
                let stride = views.get(view.value()).and_then(|v| v.byte_stride).map_or(size, |s| s.0.max(1));
                let start = json.byte_offset.map_or(0, |o| o.0);
                Some(Strided::new(self.view(view.value())?, start, stride, size, count).ok_or_else(outside)?)
            }
            None => None,
        };
        let changed = match &json.sparse {
            Some(sparse) => self.changed(sparse, (index, count, size))?,
            None => Vec::new(),
        };
        Ok(Elements { base, size, count, changed })
    }

    /// The elements that a sparse accessor changes, in the order of their indices, each as its index and its bytes. The
    /// accessor has the index `index` and `count` elements of `size` bytes.
    fn changed(&self, sparse: &Sparse, (index, count, size): (usize, usize, usize)) -> Result<Vec<(usize, &[u8])>> {
        let outside = || self.error(format!("accessor {index}: its sparse elements leave their buffer view"));
        let many = usize::try_from(sparse.count.0).map_err(|_| outside())?;
        let Checked::Valid(IndexComponentType(kind)) = sparse.indices.component_type else { return Err(outside()) };
        let strided = |view: usize, start: u64, size: usize| -> Result<Strided<'_>> {
            Strided::new(self.view(view)?, start, size, size, many).ok_or_else(outside)
        };
        let indices = strided(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, kind.size())?;
        let values = strided(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, size)?;
        let pair = |k: usize| {
            let element = little_endian(indices.get(k)) as usize;
            if element < count { Ok((element, values.get(k))) } else { Err(outside()) }
        };
        let mut changed = (0..many).map(pair).collect::<Result<Vec<_>>>()?;
        // The elements should be in order already. If an element is changed twice, the last change counts.
        changed.sort_by_key(|(element, _)| *element);
        Ok(changed)
    }
}

/// Decodes the compressed views; the keys of the result are indices of views.
fn decoded(path: &Path, document: &Document, buffers: &[Vec<u8>]) -> Result<HashMap<usize, Vec<u8>>> {
    let mut decoded = HashMap::new();
    for (index, view) in document.as_json().buffer_views.iter().enumerate() {
        let wrong = |message: String| malformed(path, format!("buffer view {index}: {message}"));
        let Some(compressed) = compression::compressed(view).map_err(wrong)? else { continue };
        let compression::Compressed { buffer, byte_offset, byte_length, .. } = compressed;
        let end = byte_offset.checked_add(byte_length);
        let bytes = buffers.get(buffer).zip(end).and_then(|(bytes, end)| bytes.get(byte_offset..end));
        let bytes = bytes.ok_or_else(|| wrong("its compressed bytes leave their buffer".to_owned()))?;
        let unpacked = compressed.decode(bytes).map_err(wrong)?;
        if (unpacked.len() as u64) < view.byte_length.0 {
            let message = format!("has {} bytes where the document states {}", unpacked.len(), view.byte_length.0);
            return Err(wrong(message));
        }
        decoded.insert(index, unpacked);
    }
    Ok(decoded)
}

/// Elements of one size at equal distances.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    /// `count` elements of `size` bytes that begin every `stride` bytes from `start` on; `None` if the last one exceeds
    /// `bytes`.
    fn new(bytes: &'a [u8], start: u64, stride: usize, size: usize, count: usize) -> Option<Self> {
        let bytes = bytes.get(usize::try_from(start).ok()?..)?;
        let end = match count.checked_sub(1) {
            Some(last) => last.checked_mul(stride)?.checked_add(size)?,
            None => 0,
        };
        (end <= bytes.len()).then_some(Self { bytes, stride, size })
    }

    /// The bytes of element `k`.
    fn get(&self, k: usize) -> &'a [u8] {
        &self.bytes[k * self.stride..][..self.size]
    }
}

/// The bytes of an accessor's elements: the bytes of its view, or else zeros, with some elements changed.
pub(super) struct Elements<'a> {
    base: Option<Strided<'a>>,
    size: usize,
    count: usize,
    /// Indices and bytes of the changed elements, sorted by index.
    changed: Vec<(usize, &'a [u8])>,
}

impl<'a> Elements<'a> {
    /// The bytes of element `k`: its last change, else its bytes in the view, else zeros. An element has at most 64
    /// bytes, the size of a matrix of floats.
    fn get(&self, k: usize) -> &'a [u8] {
        let behind = self.changed.partition_point(|(element, _)| *element <= k);
        match behind.checked_sub(1).map(|last| self.changed[last]) {
            Some((element, bytes)) if element == k => bytes,
            _ => self.base.as_ref().map_or(&[0; 64][..self.size], |base| base.get(k)),
        }
    }
}

/// The vectors of an accessor.
pub(super) struct Vectors<'a, const N: usize> {
    pub(super) elements: Elements<'a>,
    data_type: DataType,
    normalized: bool,
}

impl<const N: usize> Vectors<'_, N> {
    /// Number of vectors.
    pub(super) fn len(&self) -> usize {
        self.elements.count
    }

    /// A vector; integers are converted to 0…1 or −1…1 if the accessor is normalized.
    pub(super) fn get(&self, k: usize) -> [f32; N] {
        let unit = |value: f32, greatest: f32| if self.normalized { (value / greatest).max(-1.0) } else { value };
        let number = |bytes: &[u8]| -> f32 {
            match *bytes {
                [a] if self.data_type == DataType::I8 => unit(f32::from(a as i8), 127.0),
                [a] => unit(f32::from(a), 255.0),
                [a, b] if self.data_type == DataType::I16 => unit(f32::from(i16::from_le_bytes([a, b])), 32767.0),
                [a, b] => unit(f32::from(u16::from_le_bytes([a, b])), 65535.0),
                [a, b, c, d] if self.data_type == DataType::F32 => f32::from_le_bytes([a, b, c, d]),
                [a, b, c, d] => unit(u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
                _ => 0.0,
            }
        };
        let size = self.data_type.size();
        let element = self.elements.get(k);
        std::array::from_fn(|i| number(&element[i * size..(i + 1) * size]))
    }
}

/// The indices of an accessor.
pub(super) struct Indices<'a>(Elements<'a>);

impl Indices<'_> {
    /// The indices, in the order of the accessor.
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.0.count).map(|k| little_endian(self.0.get(k)))
    }
}

/// The unsigned integer of one to four bytes, the lowest byte first.
fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// An error about the file at `path`, without a line.
fn malformed(path: &Path, message: impl Into<String>) -> Error {
    Error::malformed(path, None, message)
}

/// The bytes of a `data:` address (RFC 2397). The scheme may be written in capitals, and the data may be percent-encoded. The
/// inner `None` stands for invalid data, the outer `None` for other addresses.
fn inline(uri: &str) -> Option<Option<Vec<u8>>> {
    let (scheme, rest) = uri.split_once(':')?;
    if !scheme.trim_start().eq_ignore_ascii_case("data") {
        return None;
    }
    let bytes = rest.split_once(',').and_then(|(kind, data)| {
        let mut data: Vec<u8> = percent_decode_str(data).collect();
        if !kind.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64")) {
            return Some(data);
        }
        data.retain(|byte| !byte.is_ascii_whitespace());
        BASE64.decode(data).ok()
    });
    Some(bytes.filter(|bytes| !bytes.is_empty()))
}

/// The file that an address names, relative to the document's folder. Addresses are percent-encoded; if no file has the
/// decoded name, a file with the name as written is taken.
///
/// # Errors
/// A message for an address of another kind, such as one on the network.
fn relative_file(path: &Path, uri: &str) -> std::result::Result<PathBuf, String> {
    if let Some((scheme, _)) = uri.split_once(':').filter(|(_, rest)| rest.starts_with("//")) {
        return Err(format!("is at an address of the kind {}:, which is not read", bounded::printable_name(scheme)));
    }
    let name = percent_decode_str(uri).decode_utf8_lossy().into_owned();
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = resolve(folder, &name).or_else(|| resolve(folder, uri));
    Ok(found.unwrap_or_else(|| folder.join(name)))
}
