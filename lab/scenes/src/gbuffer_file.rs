//! G-buffers as multi-channel OpenEXR files, so that any renderer can provide one.
//!
//! Channels, as 32-bit floats:
//!
//! - `R`, `G`, `B`: the linear lit colour;
//! - `depth`: the reversed depth after projection;
//! - `Z`: the view-space z in metres, 0 for sky;
//! - `N.X`, `N.Y`, `N.Z`: the view-space normal;
//! - `roughness` and `reflectivity`;
//! - `sky`, which may be missing: 1 where a surface shows the environment of [`sky`](super::sky), and 0 elsewhere.
//!
//! Attributes: `viewToClip`, the projection with reversed depth, and OpenEXR's own `worldToCamera` are 4×4 matrices in
//! Imath's row-vector order, left-handed, with y up and z forward. The numbers `fovYRadians` or, for an orthographic
//! projection, `orthographicHeight` (metres), `aspectRatio`, `nearPlane` and `farPlane` (metres) repeat the projection
//! exactly. They may also be 64-bit floats or integers. If a file lacks them, the projection is taken from its matrix.
//! Without `aspectRatio`, the aspect is that of the image, whose pixels have OpenEXR's own `pixelAspectRatio`.

use super::exr_channels::{self, ExrChannels, check_values, components, vector_channels};
pub use super::exr_channels::{MAX_BYTES, MAX_SIDE, check_claims};
use super::projection::ReadProjection;
use super::{Camera, FieldOfView, GBufferData, Lens, Projection, ProjectionKind};
use exr::meta::attribute::AttributeValue;
use exr::meta::header::LayerAttributes;
use exr::prelude::Text;
use glam::{Mat4, Vec3};
use ssct_geometry::bounded;
use ssct_ground::{Error, Result};
use std::path::Path;

/// Surfaces nearer than the near plane by at most this share of its distance count as on the plane. The share is twice
/// the rounding of a 16-bit float.
pub(super) const NEAR_TOLERANCE: f64 = 1.0 / 1024.0;

/// Greatest share by which the aspect of a projection may differ from that of an image whose pixels are not square.
const ASPECT_TOLERANCE: f32 = 0.01;

/// Encodes a G-buffer as the bytes of a file.
///
/// # Errors
/// [`Error::Malformed`] if the format cannot hold the G-buffer. `path` is only used to name the file in the error.
pub fn encode(gbuffer: &GBufferData, path: &Path) -> Result<Vec<u8>> {
    let mut channels = vec![
        ("depth", gbuffer.depth.clone()),
        ("Z", gbuffer.depth.iter().map(|depth| view_z(*depth, &gbuffer.camera.lens)).collect()),
        ("roughness", gbuffer.roughness.clone()),
        ("reflectivity", gbuffer.reflectivity.clone()),
    ];
    channels.extend(vector_channels(["R", "G", "B"], &gbuffer.color));
    channels.extend(vector_channels(["N.X", "N.Y", "N.Z"], &gbuffer.normal));
    channels.extend(exr_channels::sky_channel(&gbuffer.surface));
    let camera = &gbuffer.camera;
    let mut attributes =
        LayerAttributes { world_to_camera: Some(camera.world_to_view.to_cols_array()), ..LayerAttributes::default() };
    let opening = match camera.lens.opening {
        FieldOfView::Angle(fov) => ("fovYRadians", AttributeValue::F32(fov)),
        FieldOfView::Height(height) => ("orthographicHeight", AttributeValue::F32(height)),
    };
    let matrix = ("viewToClip", AttributeValue::Matrix4x4(camera.view_to_clip_reversed().to_cols_array()));
    let numbers = [
        opening,
        ("aspectRatio", AttributeValue::F32(camera.aspect)),
        ("nearPlane", AttributeValue::F32(camera.lens.near_m)),
        ("farPlane", AttributeValue::F32(camera.lens.far_m)),
    ];
    // A projection that is known by its matrix alone is written as the matrix alone, so that it is read back unchanged.
    let numbers = numbers.into_iter().filter(|_| camera.projection.is_none());
    attributes.other.extend(std::iter::once(matrix).chain(numbers).map(|(name, value)| (name.into(), value)));
    exr_channels::encode([gbuffer.width, gbuffer.height], attributes, channels, path)
}

/// Reads a G-buffer file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be opened; [`Error::Malformed`] if it is larger than [`MAX_BYTES`] or for
/// the reasons that [`decode`] lists.
pub fn load(path: &Path) -> Result<GBufferData> {
    decode(&bounded::read(path, "a G-buffer", MAX_BYTES)?, path)
}

/// Decodes the bytes of a G-buffer file. Errors name the file by `path`.
///
/// # Errors
/// [`Error::Malformed`] if the bytes are not an OpenEXR image, or if the image is larger than [`MAX_SIDE`] or
/// [`MAX_BYTES`]. This error is also returned if the file claims more pixels than its bytes can hold, has only a piece
/// of an image, uses a lossy compression, or lacks a channel or the projection. Pixels that are not square and do not
/// fit the projection give this error, too. For a value that is not finite or out of range, and for a `Z` above 0 in
/// front of the near plane, the error names the first pixel of the channel that has one.
pub fn decode(bytes: &[u8], path: &Path) -> Result<GBufferData> {
    let mut file = ExrChannels::decode(bytes, path, "the G-buffer")?;
    let malformed = |message: String| Error::malformed(path, None, message);
    let (width, height) = (file.width, file.height);
    let pixel_aspect = file.pixel_aspect;
    let aspect = pixel_aspect * width as f32 / height.max(1) as f32;
    let camera = read_camera(&file.attributes, aspect).map_err(malformed)?;
    // Files of this program state square pixels whatever their projection, so that square pixels contradict nothing.
    if pixel_aspect != 1.0 && (camera.aspect / aspect - 1.0).abs() > ASPECT_TOLERANCE {
        return Err(malformed(format!(
            "by pixelAspectRatio {pixel_aspect} the image is {aspect} times as wide as high, but by its projection {} \
             times",
            camera.aspect
        )));
    }
    let check_channel = |channel: &str, allowed: &str, values: &[f32], is_allowed: fn(f32) -> bool| {
        check_values(path, (width, "pixel"), channel, allowed, values, is_allowed)
    };
    let (depth, z) = (file.take("depth"), file.take("Z"));
    let depth = match (depth, z) {
        (Some(depth), _) => {
            check_channel("depth", "a number from 0 to 1", &depth, is_zero_to_one)?;
            depth
        }
        (None, Some(z)) => {
            check_channel("Z", "a number from 0 on, in metres", &z, |z| z >= 0.0)?;
            let near_m = camera.lens.near_m;
            let nearest_allowed_m = f64::from(near_m) * (1.0 - NEAR_TOLERANCE);
            let allowed = format!("0, which is sky, or at least {near_m}, the distance of the near plane in metres");
            let is_allowed = |z: f32| z == 0.0 || f64::from(z) >= nearest_allowed_m;
            check_values(path, (width, "pixel"), "Z", &allowed, &z, is_allowed)?;
            // Rounding may put a surface on the near plane in front of it, where its depth would be that of sky.
            let not_before_near = |z: f32| if z > 0.0 { z.max(near_m) } else { z };
            let depth_of_z = |z: &f32| match reversed_depth(not_before_near(*z), &camera.lens) {
                // The depth may be NaN for planes at the limits of floats.
                depth if depth > 0.0 => depth.min(1.0),
                _ => 0.0,
            };
            z.iter().map(depth_of_z).collect()
        }
        (None, None) => return Err(malformed("channels depth and Z are both missing".into())),
    };
    let surface = file.take_surfaces();
    let color = file.vectors(["R", "G", "B"])?;
    let normal = file.vectors(["N.X", "N.Y", "N.Z"])?;
    let roughness = file.required("roughness")?;
    let reflectivity = file.required("reflectivity")?;
    for (component, [color_channel, normal_channel]) in
        [["R", "N.X"], ["G", "N.Y"], ["B", "N.Z"]].into_iter().enumerate()
    {
        let is_color = |value: f32| value.is_finite() && value >= 0.0;
        check_channel(color_channel, "a finite number from 0 on", &components(&color, component), is_color)?;
        check_channel(normal_channel, "a finite number", &components(&normal, component), f32::is_finite)?;
    }
    check_channel("roughness", "a number from 0 to 1", &roughness, is_zero_to_one)?;
    check_channel("reflectivity", "a number from 0 to 1", &reflectivity, is_zero_to_one)?;
    Ok(GBufferData { width, height, camera, depth, normal, reflectivity, roughness, color, surface })
}

/// Returns true if a value is a number from 0 to 1.
fn is_zero_to_one(value: f32) -> bool {
    (0.0..=1.0).contains(&value)
}

/// Returns the view-space z, in metres, of a reversed depth; 0 for sky.
fn view_z(depth: f32, lens: &Lens) -> f32 {
    let Lens { near_m: near, far_m: far, .. } = *lens;
    match lens.kind() {
        _ if depth <= 0.0 => 0.0,
        ProjectionKind::Perspective => near * far / (near + depth * (far - near)),
        ProjectionKind::Orthographic => far - depth * (far - near),
    }
}

/// Returns the reversed depth of a view-space z in metres. It is 0, the depth of sky, unless z is between the near and
/// the far plane.
pub(super) fn reversed_depth(z: f32, lens: &Lens) -> f32 {
    let Lens { near_m: near, far_m: far, .. } = *lens;
    match lens.kind() {
        _ if !(z >= near && z <= far) => 0.0,
        ProjectionKind::Perspective => near * (far - z) / (z * (far - near)),
        ProjectionKind::Orthographic => (far - z) / (far - near),
    }
}

/// Reads the camera from a layer's attributes. `aspect` is the image's width over its height, and is used if the
/// attributes give no aspect ratio. The error is a message.
fn read_camera(attributes: &LayerAttributes, aspect: f32) -> std::result::Result<Camera, String> {
    let number_of = |name: &str| match attributes.other.get(&Text::from(name)) {
        Some(AttributeValue::F32(value)) => Some(*value),
        // Python's numbers become one of these, and a round number such as a far plane at 1000 an integer.
        Some(AttributeValue::F64(value)) => Some(*value as f32),
        Some(AttributeValue::I32(value)) => Some(*value as f32),
        _ => None,
    };
    let world_to_view = attributes.world_to_camera.map_or(Mat4::IDENTITY, |numbers| Mat4::from_cols_array(&numbers));
    let opening_height = number_of("orthographicHeight").map(FieldOfView::Height);
    let opening = number_of("fovYRadians").map(FieldOfView::Angle).or(opening_height);
    let numbers = (opening, number_of("nearPlane"), number_of("farPlane"));
    let (lens, aspect, projection) = match (numbers, attributes.other.get(&Text::from("viewToClip"))) {
        ((Some(opening), Some(near_m), Some(far_m)), _) => {
            (Lens { opening, near_m, far_m }, number_of("aspectRatio").unwrap_or(aspect), None)
        }
        (_, Some(AttributeValue::Matrix4x4(matrix))) => lens_of_matrix(&Mat4::from_cols_array(matrix))?,
        _ => {
            return Err(
                "the projection is missing: neither viewToClip nor fovYRadians (or orthographicHeight), nearPlane and \
                 farPlane are given"
                    .into(),
            );
        }
    };
    let camera = Camera { world_to_view, lens, aspect, near_plane: None, projection };
    if !camera.is_sound() {
        let Lens { opening, near_m: near, far_m: far } = lens;
        let extent = match opening {
            FieldOfView::Angle(fov) => format!("fov {fov}"),
            FieldOfView::Height(height) => format!("a height of {height} m"),
        };
        return Err(format!("a projection with {extent}, near {near}, far {far} and aspect {aspect} cannot be used"));
    }
    Ok(camera)
}

/// Reads a projection matrix with reversed depth. Returns its lens, its aspect ratio and its numbers as a
/// [`Projection`], or a message if the matrix cannot be used.
fn lens_of_matrix(view_to_clip: &Mat4) -> std::result::Result<(Lens, f32, Option<Projection>), String> {
    let parsed = ReadProjection::new(view_to_clip, true).map_err(|why| format!("viewToClip {why}"))?;
    if parsed.axis_signs != Vec3::ONE || !parsed.is_reversed {
        return Err("viewToClip is not a left-handed projection with reversed depth".into());
    }
    let [scale_x, scale_y] = parsed.projection.scale;
    let far_m = if parsed.far.is_infinite() { INFINITE_FAR_RATIO * parsed.near } else { parsed.far };
    let lens = Lens { opening: parsed.projection.opening(), near_m: parsed.near, far_m };
    Ok((lens, scale_y / scale_x, Some(parsed.projection)))
}

/// Ratio of the far to the near plane of a lens whose far plane is at infinity, for formulas that need a finite one.
/// The door for other renderers (`CameraInput`) uses the same number.
const INFINITE_FAR_RATIO: f32 = 1e7;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surface;
    use exr::meta::MetaData;

    /// Makes a G-buffer of 3 × 2 pixels whose depths, normals and colours differ.
    fn sample() -> GBufferData {
        let lens = Lens::perspective(1.2, 0.25, 50.0);
        let camera = Camera::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 1.0, 9.0), lens, 1.5);
        let count = 6;
        GBufferData {
            width: 3,
            height: 2,
            camera,
            depth: (0..count).map(|i| i as f32 * 0.15).collect(),
            normal: (0..count).map(|i| Vec3::new(0.0, 0.6, -0.8) * i as f32).collect(),
            reflectivity: vec![0.25; count],
            roughness: vec![0.1; count],
            color: (0..count).map(|i| Vec3::splat(i as f32 / 7.0)).collect(),
            surface: vec![Surface::Lit; count],
        }
    }

    /// Writes a G-buffer into a new folder. Returns the folder, which is deleted when it is dropped, and the path of
    /// the file.
    fn write_to_folder(gbuffer: &GBufferData) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("g.exr");
        std::fs::write(&path, encode(gbuffer, &path).expect("encodes")).expect("writes");
        (folder, path)
    }

    #[test]
    fn a_file_round_trips_every_bit() {
        let perspective = sample();
        let mut parallel = sample();
        parallel.camera.lens = Lens::orthographic(7.3, 0.0, 50.0);
        let mut by_numbers = parallel.clone();
        let numbers = crate::Projection {
            kind: ProjectionKind::Orthographic,
            scale: [0.3, 0.5],
            shift: [0.25, -0.125],
            depth: [1.25, -0.0625],
        };
        by_numbers.camera = Camera::of_projection(parallel.camera.world_to_view, numbers);
        for gbuffer in [perspective, parallel, by_numbers] {
            let (_folder, path) = write_to_folder(&gbuffer);
            assert!(load(&path).expect("loads") == gbuffer);
        }
    }

    #[test]
    fn surfaces_that_show_the_sky_are_a_channel_only_where_there_are_any() {
        let lit = sample();
        let mut window = sample();
        window.surface[4] = Surface::Sky;
        let has_channel = |gbuffer: &GBufferData| {
            let (_folder, path) = write_to_folder(gbuffer);
            assert!(load(&path).expect("loads") == *gbuffer);
            let meta = MetaData::read_from_file(&path, false).expect("a header");
            meta.headers[0].channels.list.iter().any(|channel| channel.name == *"sky")
        };
        assert!(!has_channel(&lit) && has_channel(&window));
    }

    #[test]
    fn the_matrix_alone_and_view_z_alone_are_enough() {
        let gbuffer = sample();
        let (lens, aspect, _) = lens_of_matrix(&gbuffer.camera.view_to_clip_reversed()).expect("a perspective");
        let expected = gbuffer.camera.lens;
        let parallel = Lens::orthographic(7.0, 0.5, 50.0);
        assert!((lens.near_m - expected.near_m).abs() < 1e-6 && (lens.far_m - expected.far_m).abs() < 1e-3);
        let [fov, expected_fov] = [lens, expected].map(|lens| lens.fov_y_radians().expect("a perspective"));
        assert!((fov - expected_fov).abs() < 1e-6 && (aspect - 1.5).abs() < 1e-6);
        for depth in [0.02_f32, 0.3, 0.99] {
            for lens in [expected, parallel] {
                let returned = reversed_depth(view_z(depth, &lens), &lens);
                assert!((returned - depth).abs() < 1e-6, "{depth} {returned}");
            }
        }
        assert_eq!(reversed_depth(0.0, &expected), 0.0, "sky");
        assert!(lens_of_matrix(&gbuffer.camera.view_to_clip().transpose()).is_err());
    }

    /// Encodes 3 × 2 pixels with a channel `Z` and no channel `depth`, and with numbers of three types, and decodes
    /// them.
    fn decode_view_z(z: [f32; 6]) -> Result<GBufferData> {
        let path = Path::new("z.exr");
        let numbers = [
            ("fovYRadians", AttributeValue::F64(1.2)),
            ("aspectRatio", AttributeValue::I32(1)),
            ("nearPlane", AttributeValue::F32(0.25)),
            ("farPlane", AttributeValue::I32(50)),
        ];
        let mut attributes = LayerAttributes::default();
        attributes.other.extend(numbers.map(|(name, value)| (Text::from(name), value)));
        let mut channels = vec![("Z", z.to_vec()), ("roughness", vec![0.1; 6]), ("reflectivity", vec![0.5; 6])];
        channels.extend(vector_channels(["R", "G", "B"], &[Vec3::ONE; 6]));
        channels.extend(vector_channels(["N.X", "N.Y", "N.Z"], &[Vec3::NEG_Z; 6]));
        decode(&exr_channels::encode([3, 2], attributes, channels, path)?, path)
    }

    #[test]
    fn numbers_of_the_projection_may_be_integers_and_64_bit_floats() {
        let camera = decode_view_z([2.0; 6]).expect("decodes").camera;
        assert_eq!((camera.lens, camera.aspect), (Lens::perspective(1.2, 0.25, 50.0), 1.0));
    }

    #[test]
    fn view_z_in_front_of_the_near_plane_is_refused_but_for_its_rounding() {
        let depth = decode_view_z([0.0, 60.0, 0.249_9, 0.25, 2.0, 50.0]).expect("decodes").depth;
        assert_eq!([depth[0], depth[1], depth[2], depth[3], depth[5]], [0.0, 0.0, 1.0, 1.0, 0.0]);
        assert!(depth[4] > 0.0 && depth[4] < 1.0, "{}", depth[4]);
        let error = decode_view_z([2.0, 2.0, 2.0, 0.01, 2.0, 2.0]).expect_err("in front of the near plane");
        assert_eq!(
            error.to_string(),
            "z.exr: channel Z is 0.01 at pixel 0, 1; it must be 0, which is sky, or at least 0.25, the distance of the \
             near plane in metres"
        );
    }

    /// Encodes the sample of 3 × 2 pixels with another `pixelAspectRatio`, and decodes it. Its projection has the
    /// aspect 1.5, which it states only if `has_aspect`.
    fn decode_with_pixels(pixel_aspect: f32, has_aspect: bool) -> Result<GBufferData> {
        let path = Path::new("p.exr");
        let mut bytes = encode(&sample(), path)?;
        let offset_of = |bytes: &[u8], attribute: &[u8]| {
            bytes.windows(attribute.len()).position(|window| window == attribute).expect("an attribute")
        };
        // Four bytes with the length of the value follow the name and the type.
        let value_offset = offset_of(&bytes, b"pixelAspectRatio\0float\0") + 23 + 4;
        bytes[value_offset..value_offset + 4].copy_from_slice(&pixel_aspect.to_le_bytes());
        if !has_aspect {
            // The attribute gets a name that nothing reads.
            let name_offset = offset_of(&bytes, b"aspectRatio\0float\0");
            bytes[name_offset] = b'x';
        }
        decode(&bytes, path)
    }

    #[test]
    fn pixels_that_are_not_square_change_the_aspect_or_contradict_it() {
        let aspect =
            |pixel_aspect, has_aspect| decode_with_pixels(pixel_aspect, has_aspect).expect("decodes").camera.aspect;
        assert_eq!([aspect(1.0, true), aspect(1.0, false), aspect(2.0, false)], [1.5, 1.5, 3.0]);
        assert_eq!(
            decode_with_pixels(2.0, true).expect_err("a contradiction").to_string(),
            "p.exr: by pixelAspectRatio 2 the image is 3 times as wide as high, but by its projection 1.5 times"
        );
    }

    #[test]
    fn broken_files_give_errors() {
        let (folder, path) = write_to_folder(&sample());
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
