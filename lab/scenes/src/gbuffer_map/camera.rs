//! The camera of a map. Its lens comes from an angle, a focal length, an orthographic extent or a matrix; its place
//! comes from points or a matrix.

use super::axes::MapConventions;
use super::depth::{DepthCoding, MapDepth};
use super::files::MapFiles;
use super::keys::MapKeys;
use super::numbers::MapNumbers;
use crate::camera::is_rotation;
use crate::projection::ReadProjection;
use crate::{Camera, FieldOfView, Lens, Projection, ProjectionKind};
use glam::camera::lh::view::look_to_mat4;
use glam::{DMat3, DMat4, DVec4, Mat4};
use ssct_ground::Result;
use ssct_ground::conventions::ClipY;

/// The camera section of a map.
#[derive(Debug, Clone)]
pub(super) struct MapCamera {
    /// The line in which the section begins.
    pub line: usize,
    lens: MapLens,
    aspect: Option<MapNumbers>,
    near: Option<MapNumbers>,
    far: Option<MapNumbers>,
    shift_px: Option<MapNumbers>,
    place: MapPlace,
}

/// The ways in which a map gives the lens. In each, `axis` is 0 for x and 1 for y; `Matrix` is the matrix from view to
/// clip space.
#[derive(Debug, Clone)]
enum MapLens {
    /// An angle of view along an axis of the image; `to_radians` is the factor that converts it to radians.
    Angle {
        axis: usize,
        angle: MapNumbers,
        to_radians: f64,
    },
    /// A focal length and the extent of the sensor along an axis, both in millimetres.
    Focal {
        axis: usize,
        length: MapNumbers,
        sensor: MapNumbers,
    },
    /// The extent of an orthographic image along an axis, in the renderer's unit of length.
    Extent {
        axis: usize,
        extent: MapNumbers,
    },
    Matrix(MapNumbers),
}

/// How much a lens sees along one axis of the image: an angle in radians, or for an orthographic projection metres.
#[derive(Debug, Clone, Copy)]
enum MapOpening {
    Angle(f64),
    Extent(f64),
}

/// The ways in which a map gives the place and the direction of the camera.
#[derive(Debug, Clone)]
enum MapPlace {
    /// The map gives no place, so that world space is view space.
    Origin,
    Points(Box<MapPoints>),
    WorldToView(MapNumbers),
    ViewToWorld(MapNumbers),
}

/// The eye of the camera, and the point or direction that it looks at.
#[derive(Debug, Clone)]
struct MapPoints {
    eye: MapNumbers,
    towards: MapNumbers,
    /// True if `towards` is a point, false if it is a direction.
    is_point: bool,
    /// The direction that is up in the image; without it, the image is upright.
    up: Option<MapNumbers>,
}

/// The keys that give a lens, for errors.
const LENS_WORDS: &str = "fov-y-deg, fov-x-deg, fov-y-rad, fov-x-rad, orthographic-height, orthographic-width, \
                      projection, or focal-length-mm with sensor-width-mm or sensor-height-mm";

impl MapCamera {
    /// Takes the keys of the section `[camera]`, and checks that they can be given together.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let lens = take_lens(&mut keys)?;
        let place = take_place(&mut keys)?;
        let [aspect, near, far] = ["aspect", "near", "far"].map(|key| keys.numbers(key, 1));
        let [aspect, near, far] = [aspect?, near?, far?];
        let shift_px = keys.numbers("shift-px", 2)?;
        let line = keys.line;
        if !matches!(lens, MapLens::Matrix(_)) {
            for (plane, name) in [(&near, "near"), (&far, "far")] {
                if plane.is_none() {
                    return Err(keys.error(line, format!("{name} is missing: the distance of the {name} plane")));
                }
            }
        } else if let Some(extra) = shift_px.as_ref().or(aspect.as_ref()) {
            return Err(keys.error(extra.line, "a projection says the aspect and the shift itself; leave them out"));
        }
        keys.finish()?;
        Ok(Self { line, lens, aspect, near, far, shift_px, place })
    }

    /// Returns true if the map gives the camera's place.
    pub fn has_place(&self) -> bool {
        !matches!(self.place, MapPlace::Origin)
    }

    /// Returns other readings of the camera, which a map may confuse with the right one: the lens along the other axis,
    /// and the inverse of the matrix of the place. Each comes with a description of the change.
    pub fn other_readings(&self) -> Vec<(&'static str, Self)> {
        let with_lens = |lens: MapLens| Self { lens, ..self.clone() };
        let with_place = |place: MapPlace| Self { place, ..self.clone() };
        let other_lens = match self.lens.clone() {
            MapLens::Angle { axis, angle, to_radians } => {
                let description = ["an angle from top to bottom (fov-y)", "an angle from left to right (fov-x)"][axis];
                Some((description, with_lens(MapLens::Angle { axis: 1 - axis, angle, to_radians })))
            }
            MapLens::Focal { axis, length, sensor } => {
                let description = [
                    "sensor-height-mm in the place of sensor-width-mm",
                    "sensor-width-mm in the place of sensor-height-mm",
                ][axis];
                Some((description, with_lens(MapLens::Focal { axis: 1 - axis, length, sensor })))
            }
            MapLens::Extent { axis, extent } => {
                let description = [
                    "orthographic-height in the place of orthographic-width",
                    "orthographic-width in the place of orthographic-height",
                ][axis];
                Some((description, with_lens(MapLens::Extent { axis: 1 - axis, extent })))
            }
            MapLens::Matrix(_) => None,
        };
        let other_place = match self.place.clone() {
            MapPlace::WorldToView(matrix) => {
                Some(("view-to-world in the place of world-to-view", with_place(MapPlace::ViewToWorld(matrix))))
            }
            MapPlace::ViewToWorld(matrix) => {
                Some(("world-to-view in the place of view-to-world", with_place(MapPlace::WorldToView(matrix))))
            }
            MapPlace::Origin | MapPlace::Points(_) => None,
        };
        other_lens.into_iter().chain(other_place).collect()
    }

    /// Makes the camera of a frame, and returns it with the coding of depth in the files.
    ///
    /// # Errors
    /// [`Error::Malformed`](ssct_ground::Error::Malformed), with the line in the map, for numbers that make no camera;
    /// the errors of [`MapNumbers::get`].
    pub fn get(
        &self,
        conventions: &MapConventions,
        depth: &MapDepth,
        files: &mut MapFiles,
    ) -> Result<(Camera, DepthCoding)> {
        let plane_metres = |plane: &Option<MapNumbers>, files: &mut MapFiles| -> Result<Option<f32>> {
            let distance = plane.as_ref().map(|numbers| numbers.single(files)).transpose()?;
            Ok(distance.map(|distance| (distance * conventions.metres) as f32))
        };
        let [near, far] = [plane_metres(&self.near, files)?, plane_metres(&self.far, files)?];
        let (camera, camera_coding) = match &self.lens {
            MapLens::Matrix(matrix) => camera_of_matrix(matrix, [near, far], conventions, depth, files)?,
            MapLens::Angle { axis, angle, to_radians } => {
                let angle = angle.single(files)? * to_radians;
                self.camera_of_opening(*axis, MapOpening::Angle(angle), [near, far], files)?
            }
            MapLens::Focal { axis, length, sensor } => {
                let angle = 2.0 * (0.5 * sensor.single(files)? / length.single(files)?).atan();
                self.camera_of_opening(*axis, MapOpening::Angle(angle), [near, far], files)?
            }
            MapLens::Extent { axis, extent } => {
                let extent = extent.single(files)? * conventions.metres;
                self.camera_of_opening(*axis, MapOpening::Extent(extent), [near, far], files)?
            }
        };
        let file_coding = depth.coding(camera_coding, conventions.metres);
        let camera = Camera { world_to_view: self.world_to_view(conventions, files)?, ..camera };
        if !camera.is_sound() {
            let (Lens { opening, near_m: near, far_m: far }, aspect) = (camera.lens, camera.aspect);
            let opening = match opening {
                FieldOfView::Angle(fov) => {
                    format!("a field of view of {}°", (fov.to_degrees() * 100.0).round() / 100.0)
                }
                FieldOfView::Height(height) => format!("{height} m"),
            };
            let message = format!(
                "[camera]: {opening} from top to bottom, planes at {near} m and {far} m and an aspect of {aspect} cannot \
                 be used"
            );
            return Err(files.error(self.line, message));
        }
        Ok((camera, file_coding))
    }

    /// Makes a camera that sees `opening` along the axis of the image `axis` (0 is x, 1 is y), with the near and the
    /// far plane `planes`, in metres. Its world space is its view space. Also returns the coding of depth between the
    /// planes.
    fn camera_of_opening(
        &self,
        axis: usize,
        opening: MapOpening,
        planes: [Option<f32>; 2],
        files: &mut MapFiles,
    ) -> Result<(Camera, DepthCoding)> {
        let [width, height] = files.size().map(f64::from);
        let stated_aspect = self.aspect.as_ref().map(|numbers| numbers.single(files)).transpose()?;
        let aspect = stated_aspect.unwrap_or(width * files.pixel_aspect() / height);
        let opening = match opening {
            MapOpening::Angle(angle) if axis == 1 => FieldOfView::Angle(angle as f32),
            MapOpening::Angle(angle) => FieldOfView::Angle((2.0 * ((0.5 * angle).tan() / aspect).atan()) as f32),
            MapOpening::Extent(extent) => {
                FieldOfView::Height((if axis == 1 { extent } else { extent / aspect }) as f32)
            }
        };
        // `take` has made sure that both planes are given.
        let [near_m, far_m] = planes.map(Option::unwrap_or_default);
        let lens = Lens { opening, near_m, far_m };
        let depth_coding = DepthCoding::of_planes(lens.kind(), f64::from(near_m), f64::from(far_m));
        let aspect = aspect as f32;
        let camera = Camera { world_to_view: Mat4::IDENTITY, lens, aspect, near_plane: None, projection: None };
        let Some(shift) = &self.shift_px else { return Ok((camera, depth_coding)) };
        let shift_px = shift.get(files)?;
        let scale_y = match opening {
            FieldOfView::Angle(fov) => 1.0 / f64::from(0.5 * fov).tan(),
            FieldOfView::Height(height) => 2.0 / f64::from(height),
        };
        let projection = Projection {
            kind: lens.kind(),
            scale: [scale_y / f64::from(aspect), scale_y].map(|scale| scale as f32),
            // Pixels with y down become normalised device coordinates with y up.
            shift: [2.0 * shift_px[0] / width, -2.0 * shift_px[1] / height].map(|shift| shift as f32),
            depth: depth_coding.as_f32(),
        };
        Ok((Camera { projection: Some(projection), ..camera }, depth_coding))
    }

    /// Makes the matrix from world to view space, in this program's axes and in metres.
    fn world_to_view(&self, conventions: &MapConventions, files: &mut MapFiles) -> Result<Mat4> {
        let (numbers, is_inverse) = match &self.place {
            MapPlace::Origin => return Ok(Mat4::IDENTITY),
            MapPlace::Points(points) => return matrix_of_points(points, conventions, files),
            MapPlace::WorldToView(numbers) => (numbers, false),
            MapPlace::ViewToWorld(numbers) => (numbers, true),
        };
        let matrix = conventions.matrix(&numbers.get(files)?);
        check_rigid(&matrix).map_err(|why| files.error(numbers.line, format!("{} {why}", numbers.key)))?;
        let matrix = if is_inverse { matrix.inverse() } else { matrix };
        let (view, world) = (DMat4::from_mat3(conventions.view), DMat4::from_mat3(conventions.world));
        let mut world_to_view = view * matrix * world.transpose();
        world_to_view.w_axis = (world_to_view.w_axis.truncate() * conventions.metres).extend(1.0);
        if world_to_view.determinant() < 0.0 {
            let message =
                format!("{} mirrors the world: world or view of [conventions] must be another one", numbers.key);
            return Err(files.error(numbers.line, message));
        }
        Ok(world_to_view.as_mat4())
    }
}

/// Makes the camera of a matrix from view to clip space. Its planes are those of the matrix, unless `near` or `far`, in
/// metres, replaces them. Also returns the coding of depth in the files, which is that of the matrix.
fn camera_of_matrix(
    matrix: &MapNumbers,
    [near, far]: [Option<f32>; 2],
    conventions: &MapConventions,
    depth: &MapDepth,
    files: &mut MapFiles,
) -> Result<(Camera, DepthCoding)> {
    let message_about = |reason: &str| format!("[camera]: projection {reason}");
    let numbers = matrix.get(files)?;
    let mut clip = conventions.matrix(&numbers) * DMat4::from_mat3(conventions.view.transpose());
    if depth.is_minus_one_to_one() {
        // The clip-space z is replaced by (z + w) / 2, which turns −1…1 into 0…1.
        clip = DMat4::from_cols(DVec4::X, DVec4::Y, 0.5 * DVec4::Z, DVec4::new(0.0, 0.0, 0.5, 1.0)) * clip;
    }
    let parsed = ReadProjection::new(&clip.as_mat4(), conventions.clip_y == ClipY::Up)
        .map_err(|reason| files.error(matrix.line, message_about(reason)))?;
    let refused = |reason: &str| Err(files.error(matrix.line, message_about(reason)));
    if parsed.axis_signs.z < 0.0 {
        return refused(
            "looks backwards: view of [conventions] must be another one, or matrices are in the other order",
        );
    }
    if parsed.axis_signs.x < 0.0 {
        return refused("mirrors the image from left to right: view of [conventions] must be another one");
    }
    if parsed.axis_signs.y < 0.0 {
        return refused("has the image upside down: clip-y or view of [conventions] must be another one");
    }
    if depth.is_reversed().is_some_and(|is_reversed| is_reversed != parsed.is_reversed) {
        let found = if parsed.is_reversed { "reversed" } else { "standard" };
        return refused(&format!("gives {found} depth, and kind of [depth] says otherwise"));
    }
    let metres = conventions.metres;
    let matrix_near_m = (f64::from(parsed.near) * metres) as f32;
    let matrix_far_m = (f64::from(parsed.far) * metres) as f32;
    let (kind, [depth_offset, depth_factor]) = (parsed.projection.kind, parsed.projection.depth.map(f64::from));
    // Depth is offset + factor / z in a perspective, and offset + factor · z in an orthographic projection. The numbers
    // are converted from the renderer's unit of length to metres.
    let (scale, depth_factor) = match kind {
        ProjectionKind::Perspective => (parsed.projection.scale, depth_factor * metres),
        ProjectionKind::Orthographic => {
            (parsed.projection.scale.map(|scale| (f64::from(scale) / metres) as f32), depth_factor / metres)
        }
    };
    let projection_in_metres = Projection { scale, ..parsed.projection };
    let lens = Lens {
        opening: projection_in_metres.opening(),
        near_m: near.unwrap_or(matrix_near_m),
        far_m: far.unwrap_or(matrix_far_m),
    };
    if !lens.far_m.is_finite() {
        return refused("has its far plane at infinity: say far, beyond which everything counts as sky");
    }
    let file_coding = DepthCoding { kind, numbers: [depth_offset, depth_factor] };
    let camera_coding = if near.or(far).is_some() {
        DepthCoding::of_planes(kind, f64::from(lens.near_m), f64::from(lens.far_m))
    } else {
        file_coding
    };
    let projection = Projection { depth: camera_coding.as_f32(), ..projection_in_metres };
    let aspect = projection.scale[1] / projection.scale[0];
    let camera = Camera { world_to_view: Mat4::IDENTITY, lens, aspect, near_plane: None, projection: Some(projection) };
    Ok((camera, file_coding))
}

/// Makes the matrix from world to view space of a camera that looks from a point to another point or in a direction.
fn matrix_of_points(points: &MapPoints, conventions: &MapConventions, files: &mut MapFiles) -> Result<Mat4> {
    let vector = |numbers: &MapNumbers, files: &mut MapFiles| -> Result<[f64; 3]> {
        let numbers = numbers.get(files)?;
        Ok([numbers[0], numbers[1], numbers[2]])
    };
    let MapPoints { eye, towards, is_point, up } = points;
    let position = conventions.place(vector(eye, files)?);
    let target = vector(towards, files)?;
    let direction = if *is_point { conventions.place(target) - position } else { conventions.direction(target) };
    let up = up.as_ref().map(|up| vector(up, files)).transpose()?.map(|up| conventions.direction(up));
    let forward = direction.normalize_or_zero();
    let looks_along_up = up.is_some_and(|up| forward.cross(up.normalize_or_zero()).length() < 1e-6);
    if direction.length() < 1e-6 || looks_along_up {
        let message = format!("{} gives no direction of view, or one along up", towards.key);
        return Err(files.error(towards.line, message));
    }
    Ok(match up {
        None => Camera::new(position.as_vec3(), (position + direction).as_vec3(), Lens::default(), 1.0).world_to_view,
        Some(up) => look_to_mat4(position.as_vec3(), forward.as_vec3(), up.normalize().as_vec3()),
    })
}

/// Checks that a matrix is a rotation, with or without a mirroring, and a translation.
///
/// # Errors
/// The reason why the matrix is something else, as the end of a sentence.
fn check_rigid(matrix: &DMat4) -> std::result::Result<(), &'static str> {
    if matrix.row(3) != DVec4::W {
        return Err("is no rotation and translation: is it in the other order (matrices of [conventions])?");
    }
    if !is_rotation(&DMat3::from_mat4(*matrix)) {
        return Err("has a scale or a skew: a camera has neither");
    }
    Ok(())
}

/// Takes the keys of the lens. The section must have exactly one of them, or two for a focal length.
fn take_lens(keys: &mut MapKeys) -> Result<MapLens> {
    const LENS_KEYS: [&str; 8] = [
        "fov-y-deg",
        "fov-x-deg",
        "fov-y-rad",
        "fov-x-rad",
        "orthographic-height",
        "orthographic-width",
        "focal-length-mm",
        "projection",
    ];
    let lens_count = LENS_KEYS.iter().filter(|key| keys.has(key)).count();
    if lens_count != 1 {
        let how_many = if lens_count == 0 { "no lens is given" } else { "more than one lens is given" };
        return Err(keys.error(keys.line, format!("{how_many}: say one of {LENS_WORDS}")));
    }
    let degrees = 1_f64.to_radians();
    let angles = [("fov-y-deg", 1, degrees), ("fov-x-deg", 0, degrees), ("fov-y-rad", 1, 1.0), ("fov-x-rad", 0, 1.0)];
    let mut lens = None;
    // The keys of all lenses are taken, so that an error about an unknown key names them all.
    for (key, axis, to_radians) in angles {
        if let Some(angle) = keys.numbers(key, 1)? {
            lens = Some(MapLens::Angle { axis, angle, to_radians });
        }
    }
    for (key, axis) in [("orthographic-height", 1), ("orthographic-width", 0)] {
        if let Some(extent) = keys.numbers(key, 1)? {
            lens = Some(MapLens::Extent { axis, extent });
        }
    }
    if let Some(matrix) = keys.numbers("projection", 16)? {
        lens = Some(MapLens::Matrix(matrix));
    }
    let length = keys.numbers("focal-length-mm", 1)?;
    let [width, height] = ["sensor-width-mm", "sensor-height-mm"].map(|key| keys.numbers(key, 1));
    match (lens, length, width?, height?) {
        (Some(lens), None, None, None) => Ok(lens),
        (None, Some(length), Some(sensor), None) => Ok(MapLens::Focal { axis: 0, length, sensor }),
        (None, Some(length), None, Some(sensor)) => Ok(MapLens::Focal { axis: 1, length, sensor }),
        _ => Err(keys.error(keys.line, "focal-length-mm goes with one of sensor-width-mm and sensor-height-mm")),
    }
}

/// Takes the keys of the camera's place: one matrix, or points and directions, or nothing.
fn take_place(keys: &mut MapKeys) -> Result<MapPlace> {
    let world_to_view = keys.numbers("world-to-view", 16)?;
    let view_to_world = keys.numbers("view-to-world", 16)?;
    let [eye, look_at, forward, up] = ["eye", "look-at", "forward", "up"].map(|key| keys.numbers(key, 3));
    let [eye, look_at, forward, up] = [eye?, look_at?, forward?, up?];
    let points = |eye, towards, is_point, up| MapPlace::Points(Box::new(MapPoints { eye, towards, is_point, up }));
    match (world_to_view, view_to_world, eye, look_at, forward) {
        (Some(matrix), None, None, None, None) if up.is_none() => Ok(MapPlace::WorldToView(matrix)),
        (None, Some(matrix), None, None, None) if up.is_none() => Ok(MapPlace::ViewToWorld(matrix)),
        (None, None, Some(eye), Some(towards), None) => Ok(points(eye, towards, true, up)),
        (None, None, Some(eye), None, Some(towards)) => Ok(points(eye, towards, false, up)),
        (None, None, None, None, None) if up.is_none() => Ok(MapPlace::Origin),
        _ => {
            let message =
                "the camera's place is world-to-view, or view-to-world, or eye with look-at or forward (and up)";
            Err(keys.error(keys.line, message))
        }
    }
}
