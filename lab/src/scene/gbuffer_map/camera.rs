//! The camera of a map: its lens from an angle, from a focal length or from a matrix, its place from points or from a
//! matrix.

use super::axes::MapConventions;
use super::depth::{DepthCoding, MapDepth};
use super::files::MapFiles;
use super::keys::MapKeys;
use super::numbers::MapNumbers;
use crate::error::Result;
use crate::scene::camera::ReadProjection;
use crate::scene::{Camera, Lens, Projection};
use glam::camera::lh::view::look_to_mat4;
use glam::{DMat3, DMat4, DVec3, Mat4};

/// What a map says of the camera.
#[derive(Debug, Clone)]
pub(super) struct MapCamera {
    line: usize,
    lens: MapLens,
    aspect: Option<MapNumbers>,
    near: Option<MapNumbers>,
    far: Option<MapNumbers>,
    shift_px: Option<MapNumbers>,
    place: MapPlace,
}

#[derive(Debug, Clone)]
enum MapLens {
    /// An angle of view, in radians once it is multiplied.
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
    Matrix(MapNumbers),
}

#[derive(Debug, Clone)]
enum MapPlace {
    /// Nothing: world space is view space.
    Origin,
    Points(Box<MapPoints>),
    WorldToView(MapNumbers),
    ViewToWorld(MapNumbers),
}

/// A place from which the camera looks to a point or in a direction, upright unless `up` says otherwise.
#[derive(Debug, Clone)]
struct MapPoints {
    eye: MapNumbers,
    towards: MapNumbers,
    is_point: bool,
    up: Option<MapNumbers>,
}

/// The ways to give a lens.
const LENSES: &str = "fov-y-deg, fov-x-deg, fov-y-rad, fov-x-rad, projection, or focal-length-mm with sensor-width-mm \
 or \
                      sensor-height-mm";

/// How far the numbers of a rotation may be from those of an exact one.
const ROTATION_TOLERANCE: f64 = 1e-3;

impl MapCamera {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let lens = lens(&mut keys)?;
        let place = place(&mut keys)?;
        let one = |keys: &mut MapKeys, key| keys.numbers(key, 1);
        let [aspect, near, far] = [one(&mut keys, "aspect")?, one(&mut keys, "near")?, one(&mut keys, "far")?];
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

    /// Whether the map says where the camera stands.
    pub fn has_place(&self) -> bool {
        !matches!(self.place, MapPlace::Origin)
    }

    /// Where it begins in the map.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The camera, and how the files encode depth.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line of what gives no camera; those of attributes.
    pub fn get(
        &self,
        conventions: &MapConventions,
        depth: &MapDepth,
        files: &mut MapFiles,
    ) -> Result<(Camera, DepthCoding)> {
        let plane = |plane: &Option<MapNumbers>, files: &mut MapFiles| -> Result<Option<f32>> {
            let metres = plane.as_ref().map(|p| p.one(files)).transpose()?;
            Ok(metres.map(|v| (v * conventions.metres) as f32))
        };
        let [near, far] = [plane(&self.near, files)?, plane(&self.far, files)?];
        let (camera, coding) = match &self.lens {
            MapLens::Matrix(matrix) => self.by_matrix(matrix, [near, far], conventions, depth, files)?,
            lens => {
                let [near, far] = [near.unwrap_or_default(), far.unwrap_or_default()];
                let camera = self.by_lens(lens, [near, far], files)?;
                (camera, DepthCoding::of_planes(f64::from(near), f64::from(far)))
            }
        };
        let coding = depth.coding(coding, conventions.metres);
        let camera = Camera { world_to_view: self.world_to_view(conventions, files)?, ..camera };
        if !camera.is_sound() {
            let Lens { fov_y_radians: fov, near_m: near, far_m: far } = camera.lens;
            let (degrees, aspect) = ((fov.to_degrees() * 100.0).round() / 100.0, camera.aspect);
            let message = format!(
                "[camera]: a field of view of {degrees}° from top to bottom, planes at {near} m and {far} m and an \
                 aspect of \
                 {aspect} cannot be used"
            );
            return Err(files.error(self.line, message));
        }
        Ok((camera, coding))
    }

    fn by_lens(&self, lens: &MapLens, [near_m, far_m]: [f32; 2], files: &mut MapFiles) -> Result<Camera> {
        let [width, height] = files.size().map(f64::from);
        let aspect = self.aspect.as_ref().map(|a| a.one(files)).transpose()?.map_or(width / height, |a| a);
        let (axis, angle) = match lens {
            MapLens::Focal { axis, length, sensor } => {
                (*axis, 2.0 * (0.5 * sensor.one(files)? / length.one(files)?).atan())
            }
            MapLens::Angle { axis, angle, to_radians } => (*axis, angle.one(files)? * to_radians),
            MapLens::Matrix(_) => (1, 0.0),
        };
        let fov = if axis == 1 { angle } else { 2.0 * ((0.5 * angle).tan() / aspect).atan() };
        let lens = Lens { fov_y_radians: fov as f32, near_m, far_m };
        let aspect = aspect as f32;
        let camera = Camera { world_to_view: Mat4::IDENTITY, lens, aspect, near_plane: None, projection: None };
        let Some(shift) = &self.shift_px else { return Ok(camera) };
        let shift = shift.get(files)?;
        let up = 1.0 / f64::from(0.5 * lens.fov_y_radians).tan();
        let DepthCoding { a, b } = DepthCoding::of_planes(f64::from(near_m), f64::from(far_m));
        let projection = Projection {
            scale: [up / f64::from(aspect), up].map(|v| v as f32),
            shift: [2.0 * shift[0] / width, -2.0 * shift[1] / height].map(|v| v as f32),
            depth: [a as f32, b as f32],
        };
        Ok(Camera { projection: Some(projection), ..camera })
    }

    fn by_matrix(
        &self,
        matrix: &MapNumbers,
        [near, far]: [Option<f32>; 2],
        conventions: &MapConventions,
        depth: &MapDepth,
        files: &mut MapFiles,
    ) -> Result<(Camera, DepthCoding)> {
        let wrong = |why: &str| format!("[camera]: projection {why}");
        let numbers = matrix.get(files)?;
        let mut clip = conventions.matrix(&numbers) * DMat4::from_mat3(conventions.view.transpose());
        if depth.is_minus_one_to_one() {
            // (z + w) / 2 in the place of z.
            clip = DMat4::from_cols_array(&[
                1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5, 1.0,
            ]) * clip;
        }
        let read = ReadProjection::new(&clip.as_mat4(), conventions.clip_y_is_up)
            .map_err(|why| files.error(matrix.line, wrong(why)))?;
        let turned = |message: &str| Err(files.error(matrix.line, wrong(message)));
        if read.turn.z < 0.0 {
            return turned("looks backwards: view of [conventions] is another one, or matrices are in the other order");
        }
        if read.turn.x < 0.0 {
            return turned("mirrors the image from left to right: view of [conventions] is another one");
        }
        if read.turn.y < 0.0 {
            return turned("has the image upside down: clip-y or view of [conventions] is another one");
        }
        if depth.is_reversed().is_some_and(|is| is != read.is_reversed) {
            let given = if read.is_reversed { "reversed" } else { "standard" };
            return turned(&format!("gives {given} depth, and kind of [depth] says otherwise"));
        }
        let metres = conventions.metres;
        let own_near = (f64::from(read.near) * metres) as f32;
        let own_far = (f64::from(read.far) * metres) as f32;
        let lens = Lens {
            fov_y_radians: 2.0 * (1.0 / read.projection.scale[1]).atan(),
            near_m: near.unwrap_or(own_near),
            far_m: far.unwrap_or(own_far),
        };
        if !lens.far_m.is_finite() {
            return turned("has its far plane at infinity: say far, beyond which everything counts as sky");
        }
        let [a, b] = read.projection.depth.map(f64::from);
        let coding = DepthCoding { a, b: b * metres };
        let ours = if near.or(far).is_some() {
            DepthCoding::of_planes(f64::from(lens.near_m), f64::from(lens.far_m))
        } else {
            coding
        };
        let projection = Projection { depth: [ours.a as f32, ours.b as f32], ..read.projection };
        let aspect = projection.scale[1] / projection.scale[0];
        let camera =
            Camera { world_to_view: Mat4::IDENTITY, lens, aspect, near_plane: None, projection: Some(projection) };
        Ok((camera, coding))
    }

    fn world_to_view(&self, conventions: &MapConventions, files: &mut MapFiles) -> Result<Mat4> {
        let three = |numbers: &MapNumbers, files: &mut MapFiles| -> Result<[f64; 3]> {
            let n = numbers.get(files)?;
            Ok([n[0], n[1], n[2]])
        };
        let (numbers, is_inverse) = match &self.place {
            MapPlace::Origin => return Ok(Mat4::IDENTITY),
            MapPlace::Points(points) => {
                let MapPoints { eye, towards, is_point, up } = points.as_ref();
                let at = conventions.place(three(eye, files)?);
                let given = three(towards, files)?;
                let direction = if *is_point { conventions.place(given) - at } else { conventions.direction(given) };
                let up_given = up.as_ref().map(|up| three(up, files)).transpose()?;
                let upwards = up_given.map(|up| conventions.direction(up));
                let sideways = direction.normalize_or_zero().cross(upwards.unwrap_or(DVec3::ONE).normalize_or_zero());
                if direction.length() < 1e-6 || (upwards.is_some() && sideways.length() < 1e-6) {
                    let message = format!("{} gives no direction of view with its upright", towards.key);
                    return Err(files.error(towards.line, message));
                }
                return Ok(match upwards {
                    None => Camera::new(at.as_vec3(), (at + direction).as_vec3(), Lens::default(), 1.0).world_to_view,
                    Some(up) => {
                        let [forward, up] = [direction, up].map(|v| v.normalize().as_vec3());
                        look_to_mat4(at.as_vec3(), forward, up)
                    }
                });
            }
            MapPlace::WorldToView(numbers) => (numbers, false),
            MapPlace::ViewToWorld(numbers) => (numbers, true),
        };
        let matrix = conventions.matrix(&numbers.get(files)?);
        rigid(&matrix).map_err(|why| files.error(numbers.line, format!("{} {why}", numbers.key)))?;
        let matrix = if is_inverse { matrix.inverse() } else { matrix };
        let (view, world) = (DMat4::from_mat3(conventions.view), DMat4::from_mat3(conventions.world));
        let mut ours = view * matrix * world.transpose();
        ours.w_axis = (ours.w_axis.truncate() * conventions.metres).extend(1.0);
        if ours.determinant() < 0.0 {
            let message =
                format!("{}: it mirrors the world: world or view of [conventions] is another one", numbers.key);
            return Err(files.error(numbers.line, message));
        }
        Ok(ours.as_mat4())
    }
}

/// # Errors
/// Why a matrix is no rotation (which may mirror) and translation.
fn rigid(matrix: &DMat4) -> std::result::Result<(), &'static str> {
    let rotation = DMat3::from_mat4(*matrix);
    let off = rotation.transpose() * rotation - DMat3::IDENTITY;
    if matrix.row(3) != glam::DVec4::W {
        return Err("is no rotation and translation: is it in the other order (matrices of [conventions])?");
    }
    if off.to_cols_array().iter().any(|v| v.abs() > ROTATION_TOLERANCE) {
        return Err("has a scale or a skew: a camera has neither");
    }
    Ok(())
}

fn lens(keys: &mut MapKeys) -> Result<MapLens> {
    const WAYS: [&str; 6] = ["fov-y-deg", "fov-x-deg", "fov-y-rad", "fov-x-rad", "focal-length-mm", "projection"];
    let given = WAYS.iter().filter(|way| keys.has_any(&[way])).count();
    if given != 1 {
        let how_many = if given == 0 { "no lens is given" } else { "more than one lens is given" };
        return Err(keys.error(keys.line, format!("{how_many}: say one of {LENSES}")));
    }
    let degrees = 1_f64.to_radians();
    let angles = [("fov-y-deg", 1, degrees), ("fov-x-deg", 0, degrees), ("fov-y-rad", 1, 1.0), ("fov-x-rad", 0, 1.0)];
    let mut found = None;
    // Every key is taken, so that all of them are known.
    for (key, axis, to_radians) in angles {
        if let Some(angle) = keys.numbers(key, 1)? {
            found = Some(MapLens::Angle { axis, angle, to_radians });
        }
    }
    if let Some(matrix) = keys.numbers("projection", 16)? {
        found = Some(MapLens::Matrix(matrix));
    }
    let length = keys.numbers("focal-length-mm", 1)?;
    let [width, height] = ["sensor-width-mm", "sensor-height-mm"].map(|key| keys.numbers(key, 1));
    match (found, length, width?, height?) {
        (Some(found), None, None, None) => Ok(found),
        (None, Some(length), Some(sensor), None) => Ok(MapLens::Focal { axis: 0, length, sensor }),
        (None, Some(length), None, Some(sensor)) => Ok(MapLens::Focal { axis: 1, length, sensor }),
        _ => Err(keys.error(keys.line, "focal-length-mm goes with one of sensor-width-mm and sensor-height-mm")),
    }
}

fn place(keys: &mut MapKeys) -> Result<MapPlace> {
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
