//! The depth of a map: from the buffers of engines and from distances in metres to reversed depth between the camera's
//! planes.

use super::camera_ray;
use super::files::MapFiles;
use super::keys::MapKeys;
use super::source::{MapPlanes, MapSource, SourceRules};
use crate::error::Result;
use crate::scene::Camera;
use std::path::Path;

/// Reversed depth as a function of view-space z: a + b / z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DepthCoding {
    pub a: f64,
    pub b: f64,
}

impl DepthCoding {
    /// Between a near plane and a far plane, which may be infinite.
    pub fn of_planes(near: f64, far: f64) -> Self {
        if far.is_finite() {
            Self { a: -near / (far - near), b: near * far / (far - near) }
        } else {
            Self { a: 0.0, b: near }
        }
    }

    fn view_z(self, reversed: f64) -> f64 {
        self.b / (reversed - self.a)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum DepthKind {
    Reversed,
    Standard,
    MinusOneToOne,
    ViewZ,
    Distance,
}

/// What a map says of the depth.
#[derive(Debug, Clone)]
pub(super) struct MapDepth {
    source: MapSource,
    kind: DepthKind,
    /// Planes of a depth buffer that differ from those of the camera, in units of the renderer.
    near: Option<f64>,
    far: Option<f64>,
    sky_beyond: Option<f64>,
    sky_value: Option<f64>,
}

/// How much nearer than the near plane a distance may be, as a share of it, and count as on it: twice what a 16-bit
/// float may round by.
const ROUNDED: f64 = 1.0 / 1024.0;

impl MapDepth {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let kinds = [
            ("reversed", DepthKind::Reversed),
            ("standard", DepthKind::Standard),
            ("minus-one-to-one", DepthKind::MinusOneToOne),
            ("view-z", DepthKind::ViewZ),
            ("distance", DepthKind::Distance),
        ];
        let kind = keys.required_word("kind", &kinds)?;
        let rules =
            SourceRules { counts: &[1], may_be_constant: false, may_be_srgb: false, has_offset: true, exact: true };
        let source = MapSource::take(&mut keys, rules)?;
        let near = keys.number("near", false)?;
        let far = keys.number("far", true)?;
        let sky_beyond = keys.number("sky-beyond", false)?;
        let sky_value = keys.number("sky-value", true)?;
        let is_linear = matches!(kind, DepthKind::ViewZ | DepthKind::Distance);
        if is_linear && near.or(far).is_some() {
            return Err(keys.error(keys.line, "view-z and distance have no near and far; those are the camera's"));
        }
        if let Some((near, far)) = near.zip(far) {
            if !(near > 0.0 && far > near) {
                return Err(
                    keys.error(keys.line, format!("near must be above 0 and far above near, not {near} and {far}"))
                );
            }
        } else if near.or(far).is_some() {
            return Err(keys.error(keys.line, "near and far go together; far = inf is one at infinity"));
        }
        keys.finish()?;
        Ok(Self { source, kind, near, far, sky_beyond, sky_value })
    }

    pub fn is_minus_one_to_one(&self) -> bool {
        self.kind == DepthKind::MinusOneToOne
    }

    /// Whether a depth buffer is reversed; none of distances.
    pub fn is_reversed(&self) -> Option<bool> {
        match self.kind {
            DepthKind::Reversed => Some(true),
            DepthKind::Standard | DepthKind::MinusOneToOne => Some(false),
            DepthKind::ViewZ | DepthKind::Distance => None,
        }
    }

    /// How the files encode depth: between planes of its own, if the section has some, else as the camera does.
    pub fn coding(&self, camera: DepthCoding, metres: f64) -> DepthCoding {
        match self.near.zip(self.far) {
            Some((near, far)) => DepthCoding::of_planes(near * metres, far * metres),
            None => camera,
        }
    }

    /// Reads the channel.
    ///
    /// # Errors
    /// As for [`MapSource::read`].
    pub fn read(&self, files: &mut MapFiles) -> Result<MapPlanes<'_>> {
        self.source.read(files)
    }

    /// Reversed depth of every pixel, 0 for sky.
    ///
    /// # Errors
    /// [`Error::Malformed`](crate::error::Error::Malformed) for the first pixel whose depth cannot be.
    pub fn reversed(
        &self,
        planes: &MapPlanes,
        camera: &Camera,
        coding: DepthCoding,
        metres: f64,
        map: &Path,
        [width, height]: [u32; 2],
    ) -> Result<Vec<f32>> {
        let (near, far) = (f64::from(camera.lens.near_m), f64::from(camera.lens.far_m));
        let ours = match camera.projection {
            Some(projection) => {
                let [a, b] = projection.depth.map(f64::from);
                DepthCoding { a, b }
            }
            None => DepthCoding::of_planes(near, far),
        };
        let is_ours = coding == ours;
        let of_z = |z: f64| match camera.projection {
            _ if z >= far => 0.0,
            Some(_) => ours.a + ours.b / z,
            None => near * (far - z) / (z * (far - near)),
        };
        let is_too_near = |z: f64| z.is_nan() || z < near * (1.0 - ROUNDED);
        let pixel = |i: usize| -> Result<f32> {
            let raw = planes.raw(0, i);
            let value = planes.at(0, i);
            if self.is_sky(raw) {
                return Ok(0.0);
            }
            let wrong = |value: f64, must: &str| Err(planes.error(map, width, i, value, must));
            let reversed = match self.kind {
                DepthKind::Reversed => value,
                DepthKind::Standard => 1.0 - value,
                DepthKind::MinusOneToOne => 0.5 - 0.5 * value,
                DepthKind::ViewZ | DepthKind::Distance => {
                    let along = if self.kind == DepthKind::Distance {
                        camera_ray(camera, [width, height], i).length()
                    } else {
                        1.0
                    };
                    let z = value * metres / along;
                    if is_too_near(z) {
                        return wrong(value, "not be nearer than the near plane, unless sky-value says that it is sky");
                    }
                    return Ok(of_z(z).clamp(0.0, 1.0) as f32);
                }
            };
            if !(0.0..=1.0).contains(&reversed) {
                let range = if self.is_minus_one_to_one() { "lie in -1 to 1" } else { "lie in 0 to 1" };
                return wrong(value, range);
            }
            if is_ours {
                return Ok(reversed as f32);
            }
            let z = coding.view_z(reversed);
            if is_too_near(z) {
                return wrong(value, "not be nearer than the near plane of [camera]");
            }
            Ok(of_z(z).clamp(0.0, 1.0) as f32)
        };
        (0..width as usize * height as usize).map(pixel).collect()
    }

    /// Whether a value of the file means that nothing stands there.
    fn is_sky(&self, raw: f64) -> bool {
        let beyond = match (self.kind, self.sky_beyond) {
            (DepthKind::Reversed, limit) => raw <= limit.unwrap_or(0.0),
            (DepthKind::Standard | DepthKind::MinusOneToOne, limit) => raw >= limit.unwrap_or(1.0),
            (DepthKind::ViewZ | DepthKind::Distance, Some(limit)) => raw.abs() >= limit.abs(),
            // Infinite means nothing, and what is beyond the far plane is found by its distance.
            (DepthKind::ViewZ | DepthKind::Distance, None) => raw.is_infinite(),
        };
        beyond || self.sky_value.is_some_and(|sky| raw == sky)
    }
}
