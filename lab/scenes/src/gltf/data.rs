//! The data that a document points to: bytes of buffers and images, and numbers of accessors.
//!
//! An accessor is read one element at a time ([`Vectors`], [`Indices`]). If primitives share a large accessor, each
//! reads only the elements that it draws.

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

/// Greatest size, in bytes, of a buffer's file beside the document.
const MAX_FILE_BYTES: u64 = 1 << 32;

/// Greatest number of elements of an accessor that has no bytes in the file, so that its elements are zeros. A short
/// file could otherwise claim any number.
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
    Inside(Cow<'a, [u8]>),
    /// Path of a file.
    File(PathBuf),
}

impl<'a> Data<'a> {
    /// Reads all buffers, and decodes the compressed views. The binary chunk of a `.glb` is buffer 0.
    pub(super) fn new(path: &'a Path, document: &'a Document, mut binary_chunk: Option<Vec<u8>>) -> Result<Self> {
        let mut buffers = Vec::new();
        for (index, buffer) in document.as_json().buffers.iter().enumerate() {
            let bytes = match &buffer.uri {
                Some(uri) => match data_uri_bytes(uri) {
                    Some(bytes) => {
                        bytes.ok_or_else(|| malformed(path, format!("buffer {index} is not valid base64")))?
                    }
                    None => {
                        let file = relative_file(path, uri)
                            .map_err(|message| malformed(path, format!("buffer {index} {message}")))?;
                        bounded::read(&file, "a buffer", MAX_FILE_BYTES)
                            .map_err(|e| malformed(path, format!("buffer {index} cannot be used: {e}")))?
                    }
                },
                None if compression::is_placeholder(buffer) => {
                    buffers.push(Vec::new());
                    continue;
                }
                None => binary_chunk.take().filter(|_| index == 0).ok_or_else(|| {
                    malformed(path, format!("buffer {index} has no address, and the file has no binary chunk for it"))
                })?,
            };
            let stated_bytes = buffer.byte_length.0;
            if stated_bytes > bytes.len() as u64 {
                let message =
                    format!("buffer {index} has {} bytes where the document states {stated_bytes}", bytes.len());
                return Err(malformed(path, message));
            }
            buffers.push(bytes);
        }
        let decoded = decode_views(path, document, &buffers)?;
        Ok(Self { path, document, buffers, decoded })
    }

    /// Makes an error about the glTF file.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        malformed(self.path, message)
    }

    /// Returns the bytes of a buffer view, decoded if the view is compressed.
    fn view(&self, index: usize) -> Result<&[u8]> {
        if let Some(bytes) = self.decoded.get(&index) {
            return Ok(bytes);
        }
        let outside = || self.error(format!("buffer view {index} leaves its buffer"));
        let view = self.document.as_json().buffer_views.get(index).ok_or_else(outside)?;
        let buffer = self.buffers.get(view.buffer.value()).ok_or_else(outside)?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let end = start.checked_add(view.byte_length.0).ok_or_else(outside)?;
        let [start, end] = [start, end].map(|offset| usize::try_from(offset).unwrap_or(usize::MAX));
        buffer.get(start..end).ok_or_else(outside)
    }

    /// Returns the name of an image for messages, and where its bytes are.
    pub(super) fn image(&self, index: usize) -> Result<(String, ImageBytes<'_>)> {
        let Some(image) = self.document.as_json().images.get(index) else {
            return Err(self.error(format!("there is no image {index}")));
        };
        let name_or = |fallback: String| image.name.as_deref().map_or(fallback, bounded::printable_name);
        if let Some(view) = image.buffer_view {
            return Ok((name_or(format!("image {index}")), ImageBytes::Inside(self.view(view.value())?.into())));
        }
        let Some(uri) = &image.uri else {
            return Err(self.error(format!("image {index} has neither an address nor a buffer view")));
        };
        Ok(match data_uri_bytes(uri) {
            Some(bytes) => {
                let bytes = bytes.ok_or_else(|| self.error(format!("image {index} is not valid base64")))?;
                (name_or(format!("image {index}")), ImageBytes::Inside(bytes.into()))
            }
            None => {
                let file =
                    relative_file(self.path, uri).map_err(|message| self.error(format!("image {index} {message}")))?;
                (bounded::printable_name(&percent_decode_str(uri).decode_utf8_lossy()), ImageBytes::File(file))
            }
        })
    }

    /// Returns the vectors of an accessor. `semantic` names their purpose in errors.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the elements of the accessor do not have `N` components, or leave its buffer.
    pub(super) fn vectors<const N: usize>(&self, accessor: &Accessor, semantic: &Semantic) -> Result<Vectors<'_, N>> {
        let dimensions = accessor.dimensions();
        let dimensions_by_count = [Dimensions::Scalar, Dimensions::Vec2, Dimensions::Vec3, Dimensions::Vec4];
        if dimensions_by_count.get(N - 1) != Some(&dimensions) {
            let semantic = semantic.to_string();
            return Err(self.error(format!("accessor {} of {semantic} must have {N} components", accessor.index())));
        }
        self.numbers(accessor)
    }

    /// Returns the matrices of an accessor, each with its 16 numbers column by column.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the elements of the accessor are not matrices of 4 × 4 floats, or leave its buffer.
    pub(super) fn matrices(&self, accessor: &Accessor) -> Result<Vectors<'_, 16>> {
        if accessor.dimensions() != Dimensions::Mat4 || accessor.data_type() != DataType::F32 {
            let index = accessor.index();
            return Err(self.error(format!("accessor {index} of inverse bind matrices must have 4x4 floats")));
        }
        self.numbers(accessor)
    }

    /// Returns the numbers of an accessor whose elements have `N` numbers each, of any shape.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the accessor leaves its buffer, if its elements do not have `N` numbers, or if it claims
    /// more than [`MAX_ZEROS`] elements without bytes.
    pub(super) fn floats<const N: usize>(&self, accessor: &Accessor) -> Result<Vectors<'_, N>> {
        let numbers = self.numbers(accessor)?;
        if accessor.dimensions().multiplicity() != N {
            return Err(self.error(format!("accessor {} must have {N} components", accessor.index())));
        }
        self.check_claim(accessor.index(), &numbers.elements)?;
        Ok(numbers)
    }

    /// Returns the elements of an accessor as vectors of `N` numbers; the caller checks that each element has `N`
    /// numbers.
    fn numbers<const N: usize>(&self, accessor: &Accessor) -> Result<Vectors<'_, N>> {
        let (data_type, normalized) = (accessor.data_type(), accessor.normalized());
        Ok(Vectors { elements: self.elements(accessor)?, data_type, normalized })
    }

    /// Returns the indices of an accessor.
    ///
    /// # Errors
    /// [`Error::Malformed`] if the accessor does not have unsigned integers, leaves its buffer, or claims more than
    /// [`MAX_ZEROS`] elements without bytes.
    pub(super) fn indices(&self, accessor: &Accessor) -> Result<Indices<'_>> {
        let is_unsigned = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !is_unsigned {
            return Err(self.error(format!("accessor {} of indices must have unsigned integers", accessor.index())));
        }
        let elements = self.elements(accessor)?;
        self.check_claim(accessor.index(), &elements)?;
        Ok(Indices { elements })
    }

    /// Checks that an accessor claims no huge number of elements without bytes in the file, which are zeros. `index` is
    /// the accessor's index, and `elements` are its elements.
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

    /// Returns the elements of an accessor, after a check that all of them lie within its view.
    fn elements(&self, accessor: &Accessor) -> Result<Elements<'_>> {
        let index = accessor.index();
        let json = &self.document.as_json().accessors[index];
        let element_bytes = accessor.size();
        let outside = || self.error(format!("accessor {index} leaves its buffer view"));
        let count = usize::try_from(json.count.0).map_err(|_| outside())?;
        let base = match json.buffer_view {
            Some(view) => {
                let views = &self.document.as_json().buffer_views;
                let stride = views
                    .get(view.value())
                    .and_then(|view| view.byte_stride)
                    .map_or(element_bytes, |bytes| bytes.0.max(1));
                let start = json.byte_offset.map_or(0, |offset| offset.0);
                Some(Strided::new(self.view(view.value())?, start, stride, element_bytes, count).ok_or_else(outside)?)
            }
            None => None,
        };
        let changed = match &json.sparse {
            Some(sparse) => self.sparse_changes(sparse, index, count, element_bytes)?,
            None => Vec::new(),
        };
        Ok(Elements { base, element_bytes, count, changed })
    }

    /// Returns the elements that a sparse accessor changes, each as its index and its bytes, in the order of their
    /// indices. The accessor has the index `index` and `count` elements of `element_bytes` bytes.
    fn sparse_changes(
        &self,
        sparse: &Sparse,
        index: usize,
        count: usize,
        element_bytes: usize,
    ) -> Result<Vec<(usize, &[u8])>> {
        let outside = || self.error(format!("accessor {index}: its sparse elements leave their buffer view"));
        let changed_count = usize::try_from(sparse.count.0).map_err(|_| outside())?;
        let Checked::Valid(IndexComponentType(index_type)) = sparse.indices.component_type else {
            return Err(outside());
        };
        let strided = |view: usize, start: u64, size: usize| -> Result<Strided<'_>> {
            Strided::new(self.view(view)?, start, size, size, changed_count).ok_or_else(outside)
        };
        let indices = strided(sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0, index_type.size())?;
        let values = strided(sparse.values.buffer_view.value(), sparse.values.byte_offset.0, element_bytes)?;
        let change_at = |change: usize| {
            let element = little_endian(indices.get(change)) as usize;
            if element < count { Ok((element, values.get(change))) } else { Err(outside()) }
        };
        let mut changed = (0..changed_count).map(change_at).collect::<Result<Vec<_>>>()?;
        // A valid file has them in order already. The sort keeps the order of two changes of one element, of which the
        // last counts.
        changed.sort_by_key(|(element, _)| *element);
        Ok(changed)
    }
}

/// Decodes the compressed views of a document. The result has the bytes by the index of the view.
fn decode_views(path: &Path, document: &Document, buffers: &[Vec<u8>]) -> Result<HashMap<usize, Vec<u8>>> {
    let mut decoded = HashMap::new();
    for (index, view) in document.as_json().buffer_views.iter().enumerate() {
        let malformed_view = |message: String| malformed(path, format!("buffer view {index}: {message}"));
        let Some(compressed) = compression::compression_of(view).map_err(malformed_view)? else { continue };
        let compression::Compressed { buffer, byte_offset, byte_length, .. } = compressed;
        let end = byte_offset.checked_add(byte_length);
        let compressed_bytes = buffers.get(buffer).zip(end).and_then(|(bytes, end)| bytes.get(byte_offset..end));
        let compressed_bytes =
            compressed_bytes.ok_or_else(|| malformed_view("its compressed bytes leave their buffer".to_owned()))?;
        let unpacked = compressed.decode(compressed_bytes).map_err(malformed_view)?;
        if (unpacked.len() as u64) < view.byte_length.0 {
            let message = format!("has {} bytes where the document states {}", unpacked.len(), view.byte_length.0);
            return Err(malformed_view(message));
        }
        decoded.insert(index, unpacked);
    }
    Ok(decoded)
}

/// Elements of `element_bytes` bytes, of which one begins every `stride` bytes.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    element_bytes: usize,
}

impl<'a> Strided<'a> {
    /// Takes `count` elements of `element_bytes` bytes, of which one begins every `stride` bytes from `start` on;
    /// `None` if the last one exceeds `bytes`.
    fn new(bytes: &'a [u8], start: u64, stride: usize, element_bytes: usize, count: usize) -> Option<Self> {
        let bytes = bytes.get(usize::try_from(start).ok()?..)?;
        let end = match count.checked_sub(1) {
            Some(last) => last.checked_mul(stride)?.checked_add(element_bytes)?,
            None => 0,
        };
        (end <= bytes.len()).then_some(Self { bytes, stride, element_bytes })
    }

    /// Returns the bytes of an element.
    fn get(&self, element: usize) -> &'a [u8] {
        &self.bytes[element * self.stride..][..self.element_bytes]
    }
}

/// The bytes of an accessor's elements: those of its view, or zeros if it has none, except for the changed elements.
pub(super) struct Elements<'a> {
    base: Option<Strided<'a>>,
    element_bytes: usize,
    count: usize,
    /// Indices and bytes of the changed elements, sorted by index.
    changed: Vec<(usize, &'a [u8])>,
}

impl<'a> Elements<'a> {
    /// Returns the bytes of an element: those of its last change, else those in the view, else zeros. An element has at
    /// most 64 bytes, the size of a matrix of floats.
    fn get(&self, element: usize) -> &'a [u8] {
        let changes_up_to_element = self.changed.partition_point(|(changed, _)| *changed <= element);
        match changes_up_to_element.checked_sub(1).map(|last| self.changed[last]) {
            Some((changed, bytes)) if changed == element => bytes,
            _ => self.base.as_ref().map_or(&[0; 64][..self.element_bytes], |base| base.get(element)),
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
    /// Returns the number of vectors.
    pub(super) fn len(&self) -> usize {
        self.elements.count
    }

    /// Returns the vector at an index. If the accessor is normalized, integers are converted to 0…1 or −1…1.
    pub(super) fn get(&self, index: usize) -> [f32; N] {
        let normalized = |value: f32, greatest: f32| if self.normalized { (value / greatest).max(-1.0) } else { value };
        let number = |bytes: &[u8]| -> f32 {
            match *bytes {
                [a] if self.data_type == DataType::I8 => normalized(f32::from(a as i8), 127.0),
                [a] => normalized(f32::from(a), 255.0),
                [a, b] if self.data_type == DataType::I16 => normalized(f32::from(i16::from_le_bytes([a, b])), 32767.0),
                [a, b] => normalized(f32::from(u16::from_le_bytes([a, b])), 65535.0),
                [a, b, c, d] if self.data_type == DataType::F32 => f32::from_le_bytes([a, b, c, d]),
                [a, b, c, d] => normalized(u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
                _ => 0.0,
            }
        };
        let number_bytes = self.data_type.size();
        let element = self.elements.get(index);
        std::array::from_fn(|component| number(&element[component * number_bytes..(component + 1) * number_bytes]))
    }
}

/// The indices of an accessor.
pub(super) struct Indices<'a> {
    elements: Elements<'a>,
}

impl Indices<'_> {
    /// Returns the indices, in the order of the accessor.
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.elements.count).map(|index| little_endian(self.elements.get(index)))
    }
}

/// Returns the unsigned integer of one to four bytes, the lowest byte first.
fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// Makes an error about the file at `path`, without a line.
fn malformed(path: &Path, message: impl Into<String>) -> Error {
    Error::malformed(path, None, message)
}

/// Decodes the bytes of a `data:` address (RFC 2397). The scheme may be written in capitals, and the data may be
/// percent-encoded. The result is `None` for other addresses, and `Some(None)` for invalid or empty data.
fn data_uri_bytes(uri: &str) -> Option<Option<Vec<u8>>> {
    let (scheme, rest) = uri.split_once(':')?;
    if !scheme.trim_start().eq_ignore_ascii_case("data") {
        return None;
    }
    let bytes = rest.split_once(',').and_then(|(media_type, data)| {
        let mut data: Vec<u8> = percent_decode_str(data).collect();
        if !media_type.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64")) {
            return Some(data);
        }
        data.retain(|byte| !byte.is_ascii_whitespace());
        BASE64.decode(data).ok()
    });
    Some(bytes.filter(|bytes| !bytes.is_empty()))
}

/// Returns the path of the file that an address names, relative to the folder of the document at `path`. Addresses are
/// percent-encoded; if no file has the decoded name, a file with the name as written is taken.
///
/// # Errors
/// A message for an address that names no file, such as one on the network.
fn relative_file(path: &Path, uri: &str) -> std::result::Result<PathBuf, String> {
    if let Some((scheme, _)) = uri.split_once(':').filter(|(_, rest)| rest.starts_with("//")) {
        return Err(format!("is at an address of the kind {}:, which is not read", bounded::printable_name(scheme)));
    }
    let name = percent_decode_str(uri).decode_utf8_lossy().into_owned();
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = resolve(folder, &name).or_else(|| resolve(folder, uri));
    Ok(found.unwrap_or_else(|| folder.join(name)))
}
