//! G-buffers as multi-channel OpenEXR files, so that any renderer can provide one.
//!
//! Channels, as 32-bit floats: `R`, `G`, `B` for the linear lit colour; `depth` for the reversed depth after
//! projection; `Z` for the view-space z in metres (0 for sky); `N.X`, `N.Y`, `N.Z` for the view-space normal;
//! `roughness`; `reflectivity`; and, where a surface shows the environment of [`sky`](super::sky), `sky`: 1 there and 0
//! elsewhere (a file without the channel has no such surface, and one of another renderer needs none). Attributes: `viewToClip`, the projection with reversed depth, and OpenEXR's own
//! `worldToCamera`, both as 4×4 matrices in Imath's row-vector order, left-handed, y up, z forward.
//! `fovYRadians`, `aspectRatio`, `nearPlane` and `farPlane` (metres) repeat the projection exactly; if a file
//! lacks them, the projection is taken from its matrix.

use super::{Camera, GBufferData, Lens, Surface, bounded};
use crate::error::{Error, Result};
use exr::compression::Compression;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers, Text, WritableImage, read};
use glam::{Mat4, Vec3};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// The largest side, in pixels, of a G-buffer that can be read.
pub const MAX_SIDE: usize = 16384;

/// The largest G-buffer that can be read, in bytes of its unpacked channels; also the largest file.
pub const MAX_BYTES: u64 = 1 << 32;

/// The channels of any file may unpack to this many bytes; for more, the file must be long enough.
const FREE_BYTES: u64 = 1 << 24;

/// The compressions that a G-buffer may use. All others round values, and a depth rounded to 24 bits is a
/// different depth. (The decoder of B44 also overflows on files that fuzzing finds.)
const LOSSLESS: [Compression; 5] =
    [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ];

/// Encodes a G-buffer as the bytes of a file.
///
/// # Errors
/// [`Error::Malformed`] if the format cannot hold it. `path` is only used to name the file in the error.
pub fn encode(gbuffer: &GBufferData, path: &Path) -> Result<Vec<u8>> {
    let f32s = |values: Vec<f32>| FlatSamples::F32(values);
    let axis = |v: &[Vec3], i: usize| f32s(v.iter().map(|p| p[i]).collect());
    let mut channels = vec![
        ("R", axis(&gbuffer.color, 0)),
        ("G", axis(&gbuffer.color, 1)),
        ("B", axis(&gbuffer.color, 2)),
        ("depth", f32s(gbuffer.depth.clone())),
        ("Z", f32s(gbuffer.depth.iter().map(|d| view_z(*d, &gbuffer.camera.lens)).collect())),
        ("N.X", axis(&gbuffer.normal, 0)),
        ("N.Y", axis(&gbuffer.normal, 1)),
        ("N.Z", axis(&gbuffer.normal, 2)),
        ("roughness", f32s(gbuffer.roughness.clone())),
        ("reflectivity", f32s(gbuffer.reflectivity.clone())),
    ];
    let sky: Vec<f32> = gbuffer.surface.iter().map(|s| f32::from(u8::from(*s == Surface::Sky))).collect();
    if sky.contains(&1.0) {
        channels.push(("sky", f32s(sky)));
    }
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let camera = &gbuffer.camera;
    let mut attributes =
        LayerAttributes { world_to_camera: Some(camera.world_to_view.to_cols_array()), ..LayerAttributes::default() };
    let numbers = [
        ("viewToClip", AttributeValue::Matrix4x4(camera.view_to_clip_reversed().to_cols_array())),
        ("fovYRadians", AttributeValue::F32(camera.lens.fov_y_radians)),
        ("aspectRatio", AttributeValue::F32(camera.aspect)),
        ("nearPlane", AttributeValue::F32(camera.lens.near_m)),
        ("farPlane", AttributeValue::F32(camera.lens.far_m)),
    ];
    attributes.other.extend(numbers.map(|(name, value)| (name.into(), value)));
    let size = (gbuffer.width as usize, gbuffer.height as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        // Blocks are written in order, so that equal images give equal files.
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::malformed(path, None, format!("cannot be encoded as OpenEXR: {e}")))?;
    Ok(bytes.into_inner())
}

/// Reads a G-buffer file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be opened; [`Error::Malformed`] if it is larger than [`MAX_BYTES`] or for
/// the reasons that [`decode`] lists.
pub fn load(path: &Path) -> Result<GBufferData> {
    decode(&bounded::read(path, "a G-buffer", MAX_BYTES)?, path)
}

/// Decodes the bytes of a G-buffer file. Errors call the file `path`.
///
/// # Errors
/// [`Error::Malformed`] if the bytes are not an OpenEXR image, if the image is larger than [`MAX_SIDE`] or
/// [`MAX_BYTES`], claims more pixels than that many bytes can hold, uses a lossy compression, or lacks a
/// channel or the projection.
pub fn decode(bytes: &[u8], path: &Path) -> Result<GBufferData> {
    let wrong = |message: String| Error::malformed(path, None, message);
    let unreadable = |e: exr::error::Error| wrong(format!("cannot be read as an OpenEXR image: {e}"));
    // The header is checked before any memory for pixels is allocated.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
    if let Some(size) = meta.headers.iter().map(|h| h.layer_size).find(|s| s.0 > MAX_SIDE || s.1 > MAX_SIDE) {
        return Err(wrong(format!(
            "the G-buffer has {}x{} pixels; at most {MAX_SIDE} on each side are supported",
            size.0, size.1
        )));
    }
    if let Some(lossy) = meta.headers.iter().map(|h| h.compression).find(|c| !LOSSLESS.contains(c)) {
        return Err(wrong(format!(
            "the compression {lossy} loses precision; supported are none, RLE, ZIP, ZIPS and PIZ"
        )));
    }
    let header_bytes = |h: &Header| h.layer_size.area() as u64 * h.channels.list.len() as u64 * size_of::<f32>() as u64;
    let unpacked: u64 = meta.headers.iter().map(header_bytes).fold(0, u64::saturating_add);
    if unpacked > MAX_BYTES || !bounded::may_unpack(bytes.len(), unpacked, FREE_BYTES) {
        let from = bytes.len();
        return Err(wrong(format!("the channels would take {unpacked} bytes, too many for a file of {from} bytes")));
    }
    let read = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    // For small images, threads cost more time than they save.
    let read = if unpacked < FREE_BYTES { read.non_parallel() } else { read };
    let image = read.from_buffered(Cursor::new(bytes)).map_err(unreadable)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.0, layer.size.1);
    let camera = camera(&layer.attributes, width as f32 / height.max(1) as f32).map_err(wrong)?;
    let mut channels: HashMap<String, Vec<f32>> = layer
        .channel_data
        .list
        .into_iter()
        .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()))
        .collect();
    let mut channel = |name: &str| channels.remove(name).filter(|v| v.len() == width * height);
    let missing = |name: &str| wrong(format!("channel {name} is missing"));
    let (depth, z) = (channel("depth"), channel("Z"));
    let depth = match (depth, z) {
        (Some(depth), _) => depth,
        (None, Some(z)) => z.iter().map(|z| reversed_depth(*z, &camera.lens)).collect(),
        (None, None) => return Err(wrong("channels depth and Z are both missing".into())),
    };
    let shows = |sky: &f32| if *sky > 0.5 { Surface::Sky } else { Surface::Lit };
    let surface = channel("sky").map_or(vec![Surface::Lit; depth.len()], |sky| sky.iter().map(shows).collect());
    let mut vectors = |names: [&str; 3]| -> Result<Vec<Vec3>> {
        let [x, y, z] = names.map(|n| channel(n).ok_or_else(|| missing(n)));
        Ok(x?.into_iter().zip(y?).zip(z?).map(|((x, y), z)| Vec3::new(x, y, z)).collect())
    };
    let color = vectors(["R", "G", "B"])?;
    let normal = vectors(["N.X", "N.Y", "N.Z"])?;
    let roughness = channel("roughness").ok_or_else(|| missing("roughness"))?;
    let reflectivity = channel("reflectivity").ok_or_else(|| missing("reflectivity"))?;
    Ok(GBufferData {
        width: width as u32,
        height: height as u32,
        camera,
        depth,
        normal,
        reflectivity,
        roughness,
        color,
        surface,
    })
}

/// The view-space z of a reversed depth; 0 for sky.
fn view_z(depth: f32, lens: &Lens) -> f32 {
    if depth <= 0.0 { 0.0 } else { lens.near_m * lens.far_m / (lens.near_m + depth * (lens.far_m - lens.near_m)) }
}

/// The reversed depth of a view-space z; sky if z is outside the near and far planes.
fn reversed_depth(z: f32, lens: &Lens) -> f32 {
    let inside = z >= lens.near_m && z <= lens.far_m;
    if inside { lens.near_m * (lens.far_m - z) / (z * (lens.far_m - lens.near_m)) } else { 0.0 }
}

/// Reads the camera from a layer's attributes.
fn camera(attributes: &LayerAttributes, aspect: f32) -> std::result::Result<Camera, String> {
    let number = |name: &str| match attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::F32(v)) => Some(*v),
        _ => None,
    };
    let world_to_view = attributes.world_to_camera.map_or(Mat4::IDENTITY, |m| Mat4::from_cols_array(&m));
    let exact = (number("fovYRadians"), number("nearPlane"), number("farPlane"));
    let (lens, aspect) = match (exact, attributes.other.get(&Text::from("viewToClip"))) {
        ((Some(fov_y_radians), Some(near_m), Some(far_m)), _) => {
            (Lens { fov_y_radians, near_m, far_m }, number("aspectRatio").unwrap_or(aspect))
        }
        (_, Some(AttributeValue::Matrix4x4(m))) => from_matrix(&Mat4::from_cols_array(m))?,
        _ => {
            return Err(
                "the projection is missing: neither viewToClip nor fovYRadians, nearPlane and farPlane are given"
                    .into(),
            );
        }
    };
    let made = Camera { world_to_view, lens, aspect, near_plane: None };
    if !made.is_sound() {
        let Lens { fov_y_radians: fov, near_m: near, far_m: far } = lens;
        return Err(format!("a projection with fov {fov}, near {near}, far {far} and aspect {aspect} cannot be used"));
    }
    Ok(made)
}

/// The lens and aspect ratio of a symmetric perspective matrix with reversed depth.
fn from_matrix(m: &Mat4) -> std::result::Result<(Lens, f32), String> {
    let [x, y, z, w] = m.to_cols_array_2d();
    let perspective = z[3] == 1.0 && w[3] == 0.0 && x[1..] == [0.0; 3] && y[0] == 0.0 && y[2..] == [0.0; 2];
    if !(perspective && z[0] == 0.0 && z[1] == 0.0) {
        return Err("viewToClip is not a symmetric, left-handed perspective with reversed depth".into());
    }
    let lens = Lens { fov_y_radians: 2.0 * (1.0 / y[1]).atan(), near_m: w[2] / (1.0 - z[2]), far_m: -w[2] / z[2] };
    Ok((lens, y[1] / x[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> GBufferData {
        let lens = Lens { fov_y_radians: 1.2, near_m: 0.25, far_m: 50.0 };
        let camera = Camera::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 1.0, 9.0), lens, 1.5);
        let n = 6;
        GBufferData {
            width: 3,
            height: 2,
            camera,
            depth: (0..n).map(|i| i as f32 * 0.15).collect(),
            normal: (0..n).map(|i| Vec3::new(0.0, 0.6, -0.8) * i as f32).collect(),
            reflectivity: vec![0.25; n],
            roughness: vec![0.1; n],
            color: (0..n).map(|i| Vec3::splat(i as f32 / 7.0)).collect(),
            surface: vec![Surface::Lit; n],
        }
    }

    fn written(gbuffer: &GBufferData) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("g.exr");
        std::fs::write(&path, encode(gbuffer, &path).expect("encodes")).expect("writes");
        (folder, path)
    }

    #[test]
    fn a_file_round_trips_every_bit() {
        let gbuffer = sample();
        let (_folder, path) = written(&gbuffer);
        assert!(load(&path).expect("loads") == gbuffer);
    }

    #[test]
    fn surfaces_that_show_the_sky_are_a_channel_only_where_there_are_any() {
        let lit = sample();
        let mut window = sample();
        window.surface[4] = Surface::Sky;
        let has_channel = |gbuffer: &GBufferData| {
            let (_folder, path) = written(gbuffer);
            assert!(load(&path).expect("loads") == *gbuffer);
            let meta = MetaData::read_from_file(&path, false).expect("a header");
            meta.headers[0].channels.list.iter().any(|c| c.name == *"sky")
        };
        assert!(!has_channel(&lit) && has_channel(&window));
    }

    #[test]
    fn the_matrix_alone_and_view_z_alone_are_enough() {
        let gbuffer = sample();
        let (lens, aspect) = from_matrix(&gbuffer.camera.view_to_clip_reversed()).expect("a perspective");
        let expected = gbuffer.camera.lens;
        assert!((lens.near_m - expected.near_m).abs() < 1e-6 && (lens.far_m - expected.far_m).abs() < 1e-3);
        assert!((lens.fov_y_radians - expected.fov_y_radians).abs() < 1e-6 && (aspect - 1.5).abs() < 1e-6);
        for depth in [0.02_f32, 0.3, 0.99] {
            let back = reversed_depth(view_z(depth, &expected), &expected);
            assert!((back - depth).abs() < 1e-6, "{depth} {back}");
        }
        assert_eq!(reversed_depth(0.0, &expected), 0.0, "sky");
        assert!(from_matrix(&gbuffer.camera.view_to_clip().transpose()).is_err());
    }

    #[test]
    fn broken_files_give_errors() {
        let (folder, path) = written(&sample());
        let bytes = std::fs::read(&path).expect("reads");
        for (name, content) in [
            ("empty", &bytes[..0]),
            ("text", b"hello".as_slice()),
            ("half", &bytes[..bytes.len() / 2]),
            ("head", &bytes[..40]),
        ] {
            let broken = folder.path().join(name);
            std::fs::write(&broken, content).expect("writes");
            let error = load(&broken).expect_err(name);
            assert!(matches!(error, Error::Malformed { .. }), "{name}: {error}");
        }
        assert!(matches!(load(Path::new("/nonexistent.exr")), Err(Error::Io { .. })));
    }
}
