//! What a map says of surfaces: roughness, reflectivity, colour, and where they show the sky.

use super::files::MapFiles;
use super::keys::MapKeys;
use super::source::{MapPlanes, MapSource, SourceRules};
use crate::error::Result;
use crate::scene::material_terms::{self, roughness_of_alpha, roughness_of_exponent, roughness_of_perceptual};
use crate::scene::{Surface, texture};
use glam::Vec3;
use std::path::Path;

/// Values of materials, which may be constant.
const MATERIAL: SourceRules =
    SourceRules { counts: &[1], may_be_constant: true, may_be_srgb: false, has_offset: true, exact: false };

/// Colours.
const COLOUR: SourceRules =
    SourceRules { counts: &[1, 3], may_be_constant: true, may_be_srgb: true, has_offset: false, exact: false };

/// How far a value from 0 to 1 may lie outside and be clamped: what filters and lossy compressions overshoot by.
const OVERSHOOT: f64 = 0.01;

#[derive(Debug, Clone, Copy, PartialEq)]
enum RoughnessKind {
    Lobe,
    PhongExponent,
    GgxAlpha,
    Perceptual,
    Smoothness,
}

/// What a map says of the roughness.
#[derive(Debug, Clone)]
pub(super) struct MapRoughness {
    source: MapSource,
    kind: RoughnessKind,
}

/// The pixels whose values count, and what an error about one needs.
pub(super) struct MapPixels<'a> {
    pub map: &'a Path,
    pub width: u32,
    /// Reversed depth; 0 is sky.
    pub depth: &'a [f32],
}

impl MapPixels<'_> {
    /// A value for each pixel, `sky` where nothing stands.
    fn each<T: Clone>(&self, sky: T, of: impl Fn(usize) -> Result<T>) -> Result<Vec<T>> {
        let pixel = |(i, depth): (usize, &f32)| if *depth <= 0.0 { Ok(sky.clone()) } else { of(i) };
        self.depth.iter().enumerate().map(pixel).collect()
    }

    /// A value from 0 to 1.
    fn unit(&self, planes: &MapPlanes, plane: usize, i: usize) -> Result<f64> {
        let value = planes.at(plane, i);
        if (-OVERSHOOT..=1.0 + OVERSHOOT).contains(&value) {
            return Ok(value.clamp(0.0, 1.0));
        }
        Err(planes.error(self.map, self.width, i, value, "lie in 0 to 1 (scale and offset can take it there)"))
    }
}

impl MapRoughness {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let kinds = [
            ("lobe", RoughnessKind::Lobe),
            ("phong-exponent", RoughnessKind::PhongExponent),
            ("ggx-alpha", RoughnessKind::GgxAlpha),
            ("perceptual", RoughnessKind::Perceptual),
            ("smoothness", RoughnessKind::Smoothness),
        ];
        let kind = keys.required_word("kind", &kinds)?;
        let source = MapSource::take(&mut keys, MATERIAL)?;
        keys.finish()?;
        Ok(Self { source, kind })
    }

    /// Roughness ϱ of every pixel.
    ///
    /// # Errors
    /// As for [`MapSource::read`]; [`Error::Malformed`](crate::error::Error::Malformed) for a value out of range.
    pub fn read(&self, files: &mut MapFiles, pixels: &MapPixels) -> Result<Vec<f32>> {
        let planes = self.source.read(files)?;
        pixels.each(0.0, |i| {
            if self.kind == RoughnessKind::PhongExponent {
                let exponent = planes.at(0, i);
                if exponent.is_nan() || exponent < 0.0 {
                    return Err(planes.error(pixels.map, pixels.width, i, exponent, "be a number from 0 on"));
                }
                // An exponent of 0 is the widest lobe; an infinite one is a mirror.
                return Ok(if exponent == 0.0 { 1.0 } else { roughness_of_exponent(exponent as f32) });
            }
            let value = pixels.unit(&planes, 0, i)?;
            Ok(match self.kind {
                RoughnessKind::GgxAlpha => roughness_of_alpha(value),
                RoughnessKind::Perceptual => roughness_of_perceptual(value as f32),
                RoughnessKind::Smoothness => roughness_of_perceptual((1.0 - value) as f32),
                RoughnessKind::Lobe | RoughnessKind::PhongExponent => value as f32,
            })
        })
    }
}

/// What a map says of the reflectivity.
#[derive(Debug, Clone)]
pub(super) enum MapReflectivity {
    Given(MapSource),
    /// From metallic, base colour and the reflection of dielectrics along the normal.
    Metallic(Box<MapMetallic>),
}

#[derive(Debug, Clone)]
pub(super) struct MapMetallic {
    metallic: MapSource,
    base: MapSource,
    f0: Option<MapSource>,
}

impl MapReflectivity {
    pub fn given(mut keys: MapKeys) -> Result<Self> {
        let rules = SourceRules { counts: &[1, 3], may_be_srgb: true, ..MATERIAL };
        let source = MapSource::take(&mut keys, rules)?;
        keys.finish()?;
        Ok(Self::Given(source))
    }

    pub fn metallic(mut metallic: MapKeys, mut base: MapKeys, f0: Option<MapKeys>) -> Result<Self> {
        let of_f0 = |mut keys: MapKeys| {
            let source = MapSource::take(&mut keys, MATERIAL)?;
            keys.finish().map(|()| source)
        };
        let [m, b] = [MapSource::take(&mut metallic, MATERIAL)?, MapSource::take(&mut base, COLOUR)?];
        metallic.finish()?;
        base.finish()?;
        Ok(Self::Metallic(Box::new(MapMetallic { metallic: m, base: b, f0: f0.map(of_f0).transpose()? })))
    }

    /// Reflectivity of every pixel; a colour counts by its luminance.
    ///
    /// # Errors
    /// As for [`MapSource::read`]; [`Error::Malformed`](crate::error::Error::Malformed) for a value out of range.
    pub fn read(&self, files: &mut MapFiles, pixels: &MapPixels) -> Result<Vec<f32>> {
        match self {
            Self::Given(source) => {
                let planes = source.read(files)?;
                pixels.each(0.0, |i| {
                    Ok(if source.count() == 1 {
                        pixels.unit(&planes, 0, i)? as f32
                    } else {
                        texture::luminance(colour(pixels, &planes, i)?).clamp(0.0, 1.0)
                    })
                })
            }
            Self::Metallic(of) => {
                let MapMetallic { metallic, base, f0 } = of.as_ref();
                let metallic = metallic.read(files)?;
                let base = base.read(files)?;
                let f0 = f0.as_ref().map(|f0| f0.read(files)).transpose()?;
                pixels.each(0.0, |i| {
                    let f0 = f0.as_ref().map(|f0| pixels.unit(f0, 0, i)).transpose()?;
                    let f0 = f0.map_or(material_terms::F0, |f0| f0 as f32);
                    let metallic = pixels.unit(&metallic, 0, i)? as f32;
                    Ok(material_terms::reflectivity(colour(pixels, &base, i)?, metallic, f0))
                })
            }
        }
    }
}

/// A colour whose components lie in 0 to 1.
fn colour(pixels: &MapPixels, planes: &MapPlanes, i: usize) -> Result<Vec3> {
    let [r, g, b] = [0, 1, 2].map(|k| pixels.unit(planes, k, i));
    Ok(Vec3::new(r? as f32, g? as f32, b? as f32))
}

/// A term of the colour: a colour, or the product of two.
#[derive(Debug, Clone)]
pub(super) struct MapColour {
    source: MapSource,
    times: Option<MapSource>,
}

impl MapColour {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let source = MapSource::take(&mut keys, COLOUR)?;
        let factor = |mut keys: MapKeys| {
            let source = MapSource::take(&mut keys, COLOUR)?;
            keys.finish().map(|()| source)
        };
        let times = keys.table("times")?.map(factor).transpose()?;
        keys.finish()?;
        Ok(Self { source, times })
    }

    /// The sum of terms, for every pixel, the sky's too; what is below 0 becomes black.
    ///
    /// # Errors
    /// As for [`MapSource::read`]; [`Error::Malformed`](crate::error::Error::Malformed) for a value that is not finite.
    pub fn read_sum(terms: &[Self], files: &mut MapFiles, map: &Path) -> Result<Vec<Vec3>> {
        let [width, height] = files.size();
        let mut sum = vec![[0.0_f64; 3]; width as usize * height as usize];
        for term in terms {
            let planes = term.source.read(files)?;
            let times = term.times.as_ref().map(|times| times.read(files)).transpose()?;
            for (i, sum) in sum.iter_mut().enumerate() {
                let factors = times.as_ref().map_or([1.0; 3], |times| times.three(i));
                for ((sum, value), factor) in sum.iter_mut().zip(planes.three(i)).zip(factors) {
                    if !(value * factor).is_finite() {
                        return Err(planes.error(map, width, i, value * factor, "be finite"));
                    }
                    *sum += value * factor;
                }
            }
        }
        Ok(sum.into_iter().map(|rgb| Vec3::from(rgb.map(|v| v.max(0.0).min(f64::from(f32::MAX)) as f32))).collect())
    }
}

/// Which surfaces show the environment of [`sky`](crate::scene::sky).
#[derive(Debug, Clone)]
pub(super) struct MapSky(MapSource);

impl MapSky {
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let source = MapSource::take(&mut keys, SourceRules { may_be_constant: false, exact: true, ..MATERIAL })?;
        keys.finish()?;
        Ok(Self(source))
    }

    /// # Errors
    /// As for [`MapSource::read`].
    pub fn read(&self, files: &mut MapFiles, pixels: usize) -> Result<Vec<Surface>> {
        let planes = self.0.read(files)?;
        let shows = |i| if planes.at(0, i) > 0.5 { Surface::Sky } else { Surface::Lit };
        Ok((0..pixels).map(shows).collect())
    }
}
