//! Decodes buffer views that are compressed with `EXT_meshopt_compression` or `KHR_meshopt_compression`, by the crate
//! `meshopt`.

use gltf::json::buffer::{Buffer, View};
use serde::Deserialize;
use serde_json::Value;
use ssct_geometry::bounded;

/// The two names of the extension. The second extension has the same members as the first, and more versions of the
/// codecs.
pub(super) const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Greatest number of bytes that one compressed byte may unpack to. A block of 256 equal vertices has one byte for each
/// four bytes of a vertex, so that one byte unpacks to 1024; the rest is a margin.
const MOST_UNPACKED_PER_BYTE: u64 = 2048;

/// Number of bytes that any view, however short, may unpack to.
const FREE_BYTES: u64 = 1 << 16;

/// Where the compressed bytes of a view are, and how they are compressed. The fields are the members of the extension.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compressed {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

/// Returns how a buffer view is compressed; `None` for an uncompressed view.
///
/// # Errors
/// A clause that names the member that is wrong.
pub(super) fn compression_of(view: &View) -> Result<Option<Compressed>, String> {
    let extensions = view.extensions.as_ref().map(|extensions| &extensions.others);
    let Some(extension) = extensions.and_then(|members| NAMES.iter().find_map(|name| members.get(*name))) else {
        return Ok(None);
    };
    Compressed::deserialize(extension).map(Some).map_err(|e| format!("its compression is not one of meshopt: {e}"))
}

/// Returns true if a buffer has no bytes of its own, because all of its views are compressed.
pub(super) fn is_placeholder(buffer: &Buffer) -> bool {
    let extensions = buffer.extensions.as_ref().map(|extensions| &extensions.others);
    let is_fallback = |extension: &Value| extension.get("fallback") == Some(&Value::Bool(true));
    extensions.is_some_and(|members| NAMES.iter().any(|name| members.get(*name).is_some_and(is_fallback)))
}

impl Compressed {
    /// Decodes the compressed bytes of the view to its own bytes.
    ///
    /// # Errors
    /// A clause if members contradict each other or the format, or if the bytes are not in the format of meshopt.
    pub(super) fn decode(&self, encoded: &[u8]) -> Result<Vec<u8>, String> {
        let Self { byte_stride: stride, count, .. } = *self;
        let unpacked_bytes = (stride as u64).saturating_mul(count as u64);
        if unpacked_bytes > FREE_BYTES + MOST_UNPACKED_PER_BYTE * encoded.len() as u64 {
            return Err(format!("{} bytes cannot hold {count} elements of {stride} bytes", encoded.len()));
        }
        let damaged = |_| "its compressed bytes are damaged".to_owned();
        match (self.mode.as_str(), stride) {
            ("ATTRIBUTES", 4..=256) if stride % 4 == 0 => {
                let mut words = decode_vertices(encoded, count, stride / 4).map_err(damaged)?;
                self.unfilter(&mut words)?;
                Ok(bytemuck::cast_slice(&words).to_vec())
            }
            // The decoder accepts only whole triangles, so that the count must be a multiple of three.
            ("TRIANGLES", 2 | 4) if count % 3 == 0 => {
                Ok(index_bytes(stride, &meshopt::decode_index_buffer::<u32>(encoded, count).map_err(damaged)?))
            }
            ("INDICES", 2 | 4) => {
                Ok(index_bytes(stride, &meshopt::decode_index_sequence::<u32>(encoded, count).map_err(damaged)?))
            }
            (mode, _) => Err(format!(
                "{} with {count} elements of {stride} bytes is no mode of meshopt",
                bounded::printable_name(mode)
            )),
        }
    }

    /// Applies the filter that the extension names, in place. `words` are the decoded elements, as 32-bit words.
    fn unfilter(&self, words: &mut [u32]) -> Result<(), String> {
        let filter = self.filter.as_deref().unwrap_or("NONE");
        match (filter, self.byte_stride) {
            ("NONE", _) => {}
            ("OCTAHEDRAL", 4) => meshopt::decode_filter_oct(bytemuck::cast_slice_mut::<u32, [i8; 4]>(words)),
            ("OCTAHEDRAL", 8) => meshopt::decode_filter_oct(bytemuck::cast_slice_mut::<u32, [i16; 4]>(words)),
            ("QUATERNION", 8) => meshopt::decode_filter_quat(bytemuck::cast_slice_mut::<u32, [i16; 4]>(words)),
            ("EXPONENTIAL", _) => meshopt::decode_filter_exp(bytemuck::cast_slice_mut::<u32, [u32; 1]>(words)),
            ("COLOR", 4) => meshopt::decode_filter_color(bytemuck::cast_slice_mut::<u32, [i8; 4]>(words)),
            ("COLOR", 8) => meshopt::decode_filter_color(bytemuck::cast_slice_mut::<u32, [i16; 4]>(words)),
            (filter, stride) => {
                let filter = bounded::printable_name(filter);
                return Err(format!("the filter {filter} is none of meshopt for elements of {stride} bytes"));
            }
        }
        Ok(())
    }
}

/// Returns the bytes of indices, with `stride` bytes (2 or 4) for each, the lowest byte first.
fn index_bytes(stride: usize, indices: &[u32]) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

/// An element of `N` 32-bit words.
#[derive(Clone)]
struct Element<const N: usize>([u32; N]);

impl<const N: usize> Default for Element<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

/// Decodes `count` elements of `N` words, and returns the words of all elements, one after another.
fn decode_elements<const N: usize>(encoded: &[u8], count: usize) -> meshopt::Result<Vec<u32>> {
    let elements = meshopt::decode_vertex_buffer::<Element<N>>(encoded, count)?;
    Ok(elements.into_iter().flat_map(|element| element.0).collect())
}

/// Decodes `count` elements of `words_each` 32-bit words, 1 to 64. The macro writes a case for each size, since the
/// crate takes the size from a type.
fn decode_vertices(encoded: &[u8], count: usize, words_each: usize) -> meshopt::Result<Vec<u32>> {
    macro_rules! decode_by_size {
        ($($size:literal)*) => {
            match words_each {
                $($size => decode_elements::<$size>(encoded, count),)*
                _ => unreachable!("the caller checks the stride"),
            }
        };
    }
    decode_by_size!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
                    33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}
