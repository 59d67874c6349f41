//! Reads whole OpenEXR files of other renderers: every part, with its channels and attributes. Parts may have scan
//! lines or tiles of 16-bit or 32-bit floats or of unsigned integers. A part with several resolutions is read at the
//! largest one.

use super::exr_channels::{check_claims, check_compression, rounds_values, unreadable_error};
use super::exr_window::ImageWindow;
use exr::compression::Compression;
use exr::image::{FlatSamples, Layer};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers, read};
use ssct_ground::{Error, Result};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

/// A part of a file.
pub(super) struct ExrPart {
    /// Name of the part; a file of one part may have none.
    pub name: Option<String>,
    /// Name of the view that the part shows, such as "left" for the left eye; files without views have none.
    pub view: Option<String>,
    /// Names of the views that share the part (OpenEXR's attribute `multiView`), the default one first. A part of one
    /// view has none.
    pub shared_by: Vec<String>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Channels by name.
    pub channels: BTreeMap<String, ExrChannel>,
    /// Attributes of the part, by their names in the file.
    pub attributes: BTreeMap<String, AttributeValue>,
}

/// A channel of a part.
pub(super) struct ExrChannel {
    /// Values row by row, from the top of the file.
    pub values: Vec<f32>,
    /// The compression of the part, if it rounded the values.
    pub rounded_by: Option<Compression>,
}

/// Decodes the bytes of a file to its parts. Errors name the file by `path`.
///
/// # Errors
/// [`Error::Malformed`] if the bytes are not an OpenEXR image, or if the image claims more than [`check_claims`]
/// allows. This error is also returned if a part has a compression that is not supported, deep data, or only a piece of
/// the image.
pub(super) fn decode(bytes: &[u8], path: &Path) -> Result<Vec<ExrPart>> {
    let malformed = |message: String| Error::malformed(path, None, message);
    let unreadable = |e: exr::error::Error| unreadable_error(path, bytes, &e);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
    let is_small = check_claims(&meta, bytes.len(), path, "the image")?;
    for header in &meta.headers {
        check_part(header).map_err(malformed)?;
    }
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let reader = if is_small { reader.non_parallel() } else { reader };
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(unreadable)?;
    image.layer_data.into_iter().map(|layer| part_of_layer(layer, &image.attributes).map_err(malformed)).collect()
}

/// Checks the compression of a part, and that the part covers the whole image.
///
/// # Errors
/// A message that says why the part cannot be used.
fn check_part(header: &Header) -> std::result::Result<(), String> {
    check_compression(header)?;
    ImageWindow::of_header(header).map(drop)
}

/// Makes a part from a decoded layer and the attributes that all layers of the file share. The pixels are cropped to
/// the display window.
///
/// # Errors
/// A message about a layer that does not cover the display window.
fn part_of_layer(
    layer: Layer<exr::image::AnyChannels<FlatSamples>>,
    image_attributes: &ImageAttributes,
) -> std::result::Result<ExrPart, String> {
    let compression = layer.encoding.compression;
    let window = ImageWindow::new(layer.attributes.layer_position, layer.size, image_attributes.display_window)?;
    let named_channel = |channel: exr::image::AnyChannel<FlatSamples>| {
        let name = channel.name.to_string();
        let sample_type = match channel.sample_data {
            FlatSamples::F16(_) => SampleType::F16,
            FlatSamples::F32(_) => SampleType::F32,
            FlatSamples::U32(_) => SampleType::U32,
        };
        let is_rounded = rounds_values(compression, &name, sample_type);
        let values = match channel.sample_data {
            FlatSamples::F32(values) => values,
            other => other.values_as_f32().collect(),
        };
        (name, ExrChannel { values: window.crop(values), rounded_by: is_rounded.then_some(compression) })
    };
    let LayerAttributes { view_name, multi_view_names, .. } = &layer.attributes;
    let shared_by = multi_view_names.iter().flatten().filter(|_| view_name.is_none());
    Ok(ExrPart {
        view: view_name.as_ref().map(ToString::to_string),
        shared_by: shared_by.map(ToString::to_string).collect(),
        name: layer.attributes.layer_name.as_ref().map(ToString::to_string),
        size: window.size.map(|side| side as u32),
        channels: layer.channel_data.list.into_iter().map(named_channel).collect(),
        attributes: named_attributes(layer.attributes, image_attributes),
    })
}

/// Returns the attributes of a layer and of its image by their names. The crate has fields for the attributes that the
/// format defines. Among these, only the attributes of a camera are included.
fn named_attributes(layer: LayerAttributes, image: &ImageAttributes) -> BTreeMap<String, AttributeValue> {
    use AttributeValue::{F32, Matrix4x4};
    let camera_attributes = [
        ("worldToCamera", layer.world_to_camera.map(Matrix4x4)),
        ("worldToNDC", layer.world_to_normalized_device.map(Matrix4x4)),
        ("near", layer.near_clip_plane.map(F32)),
        ("far", layer.far_clip_plane.map(F32)),
        ("fieldOfViewHorizontal", layer.horizontal_field_of_view.map(F32)),
        ("fieldOfViewVertical", layer.vertical_field_of_view.map(F32)),
        ("focus", layer.focus.map(F32)),
        ("pixelAspectRatio", Some(F32(image.pixel_aspect))),
        ("screenWindowWidth", Some(F32(layer.screen_window_width))),
    ];
    let camera_attributes = camera_attributes.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?)));
    let others = layer.other.into_iter().chain(image.other.clone());
    camera_attributes.chain(others.map(|(name, value)| (name.to_string(), value))).collect()
}
