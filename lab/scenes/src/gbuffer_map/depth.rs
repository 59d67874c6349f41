//! The depth of a map: converts the depth buffers of engines, and distances, to reversed depth between the camera's
//! planes.

use super::files::MapFiles;
use super::keys::MapKeys;
use super::source::{MapPlanes, MapSource, SourceRules};
use crate::gbuffer_file::NEAR_TOLERANCE;
use crate::{Camera, ProjectionKind};
use glam::DVec3;
use ssct_ground::Result;
use ssct_ground::conventions::ClipDepth;

/// Reversed depth as a function of view-space z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DepthCoding {
    pub kind: ProjectionKind,
    /// The two numbers of [`ProjectionKind::reversed_depth`].
    pub numbers: [f64; 2],
}

impl DepthCoding {
    /// Makes the coding between a near and a far plane, in metres; the far plane of a perspective may be infinite.
    pub fn of_planes(kind: ProjectionKind, near: f64, far: f64) -> Self {
        Self { kind, numbers: kind.reversed_depth(near, far) }
    }

    /// Returns the numbers as the field `depth` of a [`Projection`](crate::Projection).
    pub fn as_f32(self) -> [f32; 2] {
        self.numbers.map(|number| number as f32)
    }

    /// Returns the view-space z, in metres, of a reversed depth.
    fn view_z(self, reversed: f64) -> f64 {
        self.kind.z_at(self.numbers, reversed)
    }
}

/// The kinds of depth that a channel may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum DepthKind {
    /// The depth of clip space.
    Clip(ClipDepth),
    /// The view-space z.
    ViewZ,
    /// Distance from the camera along the ray of sight.
    Distance,
    /// Distance along the ray of sight from the point where this ray crosses the near plane.
    DistanceFromNear,
}

/// Every kind, with its word in maps.
const KINDS: [(&str, DepthKind); 6] = [
    ("reversed", DepthKind::Clip(ClipDepth::Reversed)),
    ("standard", DepthKind::Clip(ClipDepth::Standard)),
    ("minus-one-to-one", DepthKind::Clip(ClipDepth::MinusOneToOne)),
    ("view-z", DepthKind::ViewZ),
    ("distance", DepthKind::Distance),
    ("distance-from-near", DepthKind::DistanceFromNear),
];

impl DepthKind {
    /// Returns true if the values are lengths, and not depths of clip space.
    fn is_linear(self) -> bool {
        matches!(self, Self::ViewZ | Self::Distance | Self::DistanceFromNear)
    }
}

/// The depth section of a map.
#[derive(Debug, Clone)]
pub(super) struct MapDepth {
    source: MapSource,
    kind: DepthKind,
    /// Distances of the near and the far plane of the depth buffer, if they differ from the camera's, in the renderer's
    /// unit of length.
    near: Option<f64>,
    far: Option<f64>,
    /// The stored value at which, or beyond which towards the far plane, a pixel counts as sky.
    sky_beyond: Option<f64>,
    /// A stored value that stands for sky.
    sky_value: Option<f64>,
}

impl MapDepth {
    /// Takes the keys of the section `[depth]`, and checks that they can be given together.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let kind = keys.required_word("kind", &KINDS)?;
        let source = MapSource::take(&mut keys, SourceRules::EXACT)?;
        let near = keys.number("near", false)?;
        let far = keys.number("far", true)?;
        let sky_beyond = keys.number("sky-beyond", false)?;
        let sky_value = keys.number("sky-value", true)?;
        if kind.is_linear() && near.or(far).is_some() {
            return Err(keys.error(keys.line, "view-z and distances have no near and far; those are the camera's"));
        }
        if let Some((near, far)) = near.zip(far) {
            if !(near > 0.0 && far > near) {
                let message = format!("near must be above 0 and far above near, not {near} and {far}");
                return Err(keys.error(keys.line, message));
            }
        } else if near.or(far).is_some() {
            return Err(keys.error(keys.line, "near and far go together; far = inf is one at infinity"));
        }
        keys.finish()?;
        Ok(Self { source, kind, near, far, sky_beyond, sky_value })
    }

    /// Returns the other kinds of depth, each with its word in maps: kinds that are lengths if this kind is one, else
    /// kinds of clip space.
    pub fn other_kinds(&self) -> impl Iterator<Item = (&'static str, DepthKind)> + use<> {
        let own_kind = self.kind;
        KINDS.into_iter().filter(move |(_, kind)| *kind != own_kind && kind.is_linear() == own_kind.is_linear())
    }

    /// Returns this section with another kind of depth for the same channel.
    pub fn with_kind(&self, kind: DepthKind) -> Self {
        Self { kind, ..self.clone() }
    }

    /// Returns true if the depth buffer runs from −1 at the near plane to 1 at the far plane.
    pub fn is_minus_one_to_one(&self) -> bool {
        self.kind == DepthKind::Clip(ClipDepth::MinusOneToOne)
    }

    /// Returns whether the depth buffer is reversed; `None` for lengths.
    pub fn is_reversed(&self) -> Option<bool> {
        match self.kind {
            DepthKind::Clip(ClipDepth::Reversed) => Some(true),
            DepthKind::Clip(ClipDepth::Standard | ClipDepth::MinusOneToOne) => Some(false),
            DepthKind::ViewZ | DepthKind::Distance | DepthKind::DistanceFromNear => None,
        }
    }

    /// Returns the coding of depth in the files: between the planes of `[depth]` if that section has planes, else
    /// `camera_coding`. `metres` is the length of the renderer's unit.
    pub fn coding(&self, camera_coding: DepthCoding, metres: f64) -> DepthCoding {
        match self.near.zip(self.far) {
            Some((near, far)) => DepthCoding::of_planes(camera_coding.kind, near * metres, far * metres),
            None => camera_coding,
        }
    }

    /// Reads the channel of the depth.
    ///
    /// # Errors
    /// The errors of [`MapSource::read`].
    pub fn read<'a>(&'a self, files: &mut MapFiles<'a>) -> Result<MapPlanes<'a>> {
        self.source.read(files)
    }

    /// Converts the channel `planes`, whose depth has `coding`, to the camera's reversed depth of every pixel; sky gets
    /// 0. `metres` is the length of the renderer's unit, and `size` the width and height of the image.
    ///
    /// # Errors
    /// [`Error::Malformed`](ssct_ground::Error::Malformed) for the first pixel whose depth is out of range or nearer
    /// than the near plane.
    pub fn to_reversed(
        &self,
        planes: &MapPlanes,
        camera: &Camera,
        coding: DepthCoding,
        metres: f64,
        size: [u32; 2],
    ) -> Result<Vec<f32>> {
        let (near, far) = (f64::from(camera.lens.near_m), f64::from(camera.lens.far_m));
        // Depth that is coded between the camera's own planes needs no conversion.
        let is_camera_coding = match camera.projection {
            Some(projection) => coding.as_f32() == projection.depth,
            None => coding == DepthCoding::of_planes(camera.kind(), near, far),
        };
        let reversed_depth_of_z = |z: f64| match camera.projection {
            _ if z >= far => 0.0,
            Some(projection) => projection.kind.depth_at(projection.depth.map(f64::from), z),
            None if camera.kind().is_orthographic() => (far - z) / (far - near),
            None => near * (far - z) / (z * (far - near)),
        };
        let sight_ray_of = sight_rays(camera, size);
        let is_too_near = |z: f64| z.is_nan() || z < near * (1.0 - NEAR_TOLERANCE);
        // The camera's reversed depth of a pixel, counted row by row.
        let convert = |pixel: usize| -> Result<f32> {
            let raw = planes.raw(0, pixel);
            let value = planes.value(0, pixel);
            if self.is_sky(raw) {
                return Ok(0.0);
            }
            let refused = |must: &str| Err(planes.error(pixel, value, must));
            let reversed = match self.kind {
                DepthKind::Clip(ClipDepth::Reversed) => value,
                DepthKind::Clip(ClipDepth::Standard) => 1.0 - value,
                DepthKind::Clip(ClipDepth::MinusOneToOne) => 0.5 - 0.5 * value,
                DepthKind::ViewZ | DepthKind::Distance | DepthKind::DistanceFromNear => {
                    let ray_length = if self.kind == DepthKind::ViewZ { 1.0 } else { sight_ray_of(pixel).length() };
                    let start_z = if self.kind == DepthKind::DistanceFromNear { near } else { 0.0 };
                    let z = start_z + value * metres / ray_length;
                    if is_too_near(z) {
                        return refused("not be nearer than the near plane, unless sky-value says that it is sky");
                    }
                    return Ok(reversed_depth_of_z(z).clamp(0.0, 1.0) as f32);
                }
            };
            if !(0.0..=1.0).contains(&reversed) {
                let range = if self.is_minus_one_to_one() { "lie in -1 to 1" } else { "lie in 0 to 1" };
                return refused(range);
            }
            if is_camera_coding {
                return Ok(reversed as f32);
            }
            let z = coding.view_z(reversed);
            if is_too_near(z) {
                return refused("not be nearer than the near plane of [camera]");
            }
            Ok(reversed_depth_of_z(z).clamp(0.0, 1.0) as f32)
        };
        (0..size[0] as usize * size[1] as usize).map(convert).collect()
    }

    /// Returns true if a value of the file stands for sky.
    fn is_sky(&self, raw: f64) -> bool {
        // Pixels are 32-bit floats. A limit such as 0.05 equals pixels of that value only if it is rounded, too.
        let rounded_to_f32 = |number: f64| f64::from(number as f32);
        let is_beyond = match (self.kind, self.sky_beyond.map(rounded_to_f32)) {
            (DepthKind::Clip(ClipDepth::Reversed), limit) => raw <= limit.unwrap_or(0.0),
            (DepthKind::Clip(ClipDepth::Standard | ClipDepth::MinusOneToOne), limit) => raw >= limit.unwrap_or(1.0),
            (_, Some(limit)) => raw.abs() >= limit.abs(),
            // Infinite distances of either sign are sky; `to_reversed` makes sky of finite ones beyond the far plane.
            (_, None) => raw.is_infinite(),
        };
        is_beyond || self.sky_value.is_some_and(|sky| raw == rounded_to_f32(sky))
    }
}

/// Returns a function that gives the view-space ray of sight through the centre of a pixel, with z = 1. The function
/// takes the number of the pixel, row by row.
fn sight_rays(camera: &Camera, [width, height]: [u32; 2]) -> impl Fn(usize) -> DVec3 {
    let (kind, clip) = (camera.kind(), camera.view_to_clip_reversed().as_dmat4());
    move |pixel| {
        if kind.is_orthographic() {
            return DVec3::Z;
        }
        let ndc = super::pixel_ndc([width, height], pixel);
        DVec3::new((ndc.x - clip.z_axis.x) / clip.x_axis.x, (ndc.y - clip.z_axis.y) / clip.y_axis.y, 1.0)
    }
}
