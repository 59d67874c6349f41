//! The surfaces of a map: roughness, reflectivity, colour, and the pixels that show the sky.

use super::files::MapFiles;
use super::keys::MapKeys;
use super::source::{MapPlanes, MapSource, SourceRules};
use crate::Surface;
use crate::material_terms::{self, roughness_of_alpha, roughness_of_exponent, roughness_of_perceptual};
use glam::Vec3;
use ssct_geometry::texture;
use ssct_ground::Result;

/// Greatest distance outside 0 to 1 at which a value is clamped and not refused. Filters and lossy compressions
/// overshoot by about as much.
const OVERSHOOT: f64 = 0.01;

/// The kinds of roughness that a channel may have.
#[derive(Debug, Clone, Copy, PartialEq)]
enum RoughnessKind {
    /// The roughness ϱ of this program.
    Lobe,
    PhongExponent,
    GgxAlpha,
    /// The perceptual roughness of glTF.
    Perceptual,
    /// 1 less the perceptual roughness.
    Smoothness,
}

/// The roughness section of a map.
#[derive(Debug, Clone)]
pub(super) struct MapRoughness {
    source: MapSource,
    kind: RoughnessKind,
}

/// Computes a value for each pixel by `value_of`, which takes the index of a pixel. Sky, where the reversed `depth` is
/// 0, gets the value 0.
fn values_or_sky(depth: &[f32], value_of: impl Fn(usize) -> Result<f32>) -> Result<Vec<f32>> {
    let value_or_sky = |(pixel, depth): (usize, &f32)| if *depth <= 0.0 { Ok(0.0) } else { value_of(pixel) };
    depth.iter().enumerate().map(value_or_sky).collect()
}

/// Returns the value of a pixel in one plane, clamped to 0 to 1; an error if it lies outside by more than
/// [`OVERSHOOT`].
fn unit_value(planes: &MapPlanes, plane: usize, pixel: usize) -> Result<f64> {
    let value = planes.value(plane, pixel);
    if (-OVERSHOOT..=1.0 + OVERSHOOT).contains(&value) {
        return Ok(value.clamp(0.0, 1.0));
    }
    Err(planes.error(pixel, value, "lie in 0 to 1 (scale and offset can take it there)"))
}

/// Returns the colour of a pixel, whose components must lie in 0 to 1 like a value of [`unit_value`].
fn unit_colour(planes: &MapPlanes, pixel: usize) -> Result<Vec3> {
    let [r, g, b] = [0, 1, 2].map(|plane| unit_value(planes, plane, pixel));
    Ok(Vec3::new(r? as f32, g? as f32, b? as f32))
}

impl MapRoughness {
    /// Takes the keys of the section `[roughness]`.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let kinds = [
            ("lobe", RoughnessKind::Lobe),
            ("phong-exponent", RoughnessKind::PhongExponent),
            ("ggx-alpha", RoughnessKind::GgxAlpha),
            ("perceptual", RoughnessKind::Perceptual),
            ("smoothness", RoughnessKind::Smoothness),
        ];
        let kind = keys.required_word("kind", &kinds)?;
        let source = MapSource::take(&mut keys, SourceRules::MATERIAL)?;
        keys.finish()?;
        Ok(Self { source, kind })
    }

    /// Reads the roughness ϱ of every pixel; it is 0 where the reversed `depth` is 0 (sky).
    ///
    /// # Errors
    /// The errors of [`MapSource::read`]; [`Error::Malformed`](ssct_ground::Error::Malformed) for a value out of range.
    pub fn read<'a>(&'a self, files: &mut MapFiles<'a>, depth: &[f32]) -> Result<Vec<f32>> {
        let planes = self.source.read(files)?;
        values_or_sky(depth, |pixel| {
            Ok(match self.kind {
                RoughnessKind::Lobe => unit_value(&planes, 0, pixel)? as f32,
                RoughnessKind::GgxAlpha => roughness_of_alpha(unit_value(&planes, 0, pixel)?),
                RoughnessKind::Perceptual => roughness_of_perceptual(unit_value(&planes, 0, pixel)? as f32),
                RoughnessKind::Smoothness => roughness_of_perceptual((1.0 - unit_value(&planes, 0, pixel)?) as f32),
                // An exponent of 0 is the widest lobe; an infinite one is a mirror.
                RoughnessKind::PhongExponent => match planes.value(0, pixel) {
                    0.0 => 1.0,
                    exponent if exponent > 0.0 => roughness_of_exponent(exponent as f32),
                    refused => return Err(planes.error(pixel, refused, "be a number from 0 on")),
                },
            })
        })
    }
}

/// The reflectivity section of a map.
#[derive(Debug, Clone)]
pub(super) enum MapReflectivity {
    /// The reflectivity itself, as a number or a colour.
    Direct(MapSource),
    /// Values from which reflectivity is computed.
    Metallic(Box<MapMetallic>),
}

/// Metalness and base colour, from which reflectivity is computed.
#[derive(Debug, Clone)]
pub(super) struct MapMetallic {
    metallic: MapSource,
    base_color: MapSource,
    /// The reflectivity of dielectrics along the normal; [`material_terms::F0`] if it is missing.
    f0: Option<MapSource>,
}

impl MapReflectivity {
    /// Takes the keys of the section `[reflectivity]`.
    pub fn take_direct(keys: MapKeys) -> Result<Self> {
        let rules = SourceRules { has_offset: true, ..SourceRules::COLOUR };
        Ok(Self::Direct(MapSource::take_section(keys, rules)?))
    }

    /// Takes the keys of the sections `[metallic]`, `[base-color]` and `[f0]`.
    pub fn take_metallic(metallic: MapKeys, base_color: MapKeys, f0: Option<MapKeys>) -> Result<Self> {
        let metallic = MapSource::take_section(metallic, SourceRules::MATERIAL)?;
        let base_color = MapSource::take_section(base_color, SourceRules::COLOUR)?;
        let f0 = f0.map(|keys| MapSource::take_section(keys, SourceRules::MATERIAL)).transpose()?;
        Ok(Self::Metallic(Box::new(MapMetallic { metallic, base_color, f0 })))
    }

    /// Reads the reflectivity of every pixel; it is 0 where the reversed `depth` is 0 (sky). A reflectivity that is
    /// given as a colour becomes its luminance.
    ///
    /// # Errors
    /// The errors of [`MapSource::read`]; [`Error::Malformed`](ssct_ground::Error::Malformed) for a value out of range.
    pub fn read<'a>(&'a self, files: &mut MapFiles<'a>, depth: &[f32]) -> Result<Vec<f32>> {
        match self {
            Self::Direct(source) => {
                let planes = source.read(files)?;
                values_or_sky(depth, |pixel| {
                    Ok(if source.count() == 1 {
                        unit_value(&planes, 0, pixel)? as f32
                    } else {
                        texture::luminance(unit_colour(&planes, pixel)?).clamp(0.0, 1.0)
                    })
                })
            }
            Self::Metallic(sources) => {
                let MapMetallic { metallic, base_color, f0 } = sources.as_ref();
                let metallic = metallic.read(files)?;
                let base_color = base_color.read(files)?;
                let f0 = f0.as_ref().map(|f0| f0.read(files)).transpose()?;
                values_or_sky(depth, |pixel| {
                    let f0 = f0.as_ref().map(|f0| unit_value(f0, 0, pixel)).transpose()?;
                    let f0 = f0.map_or(material_terms::F0, |f0| f0 as f32);
                    let metallic = unit_value(&metallic, 0, pixel)? as f32;
                    Ok(material_terms::reflectivity(unit_colour(&base_color, pixel)?, metallic, Vec3::splat(f0)))
                })
            }
        }
    }
}

/// A term of the lit colour: a colour, or the product of two colours.
#[derive(Debug, Clone)]
pub(super) struct MapColour {
    source: MapSource,
    /// The second factor of a product, by which `source` is multiplied.
    times: Option<MapSource>,
}

impl MapColour {
    /// Takes the keys of a section `[[color]]`.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        let source = MapSource::take(&mut keys, SourceRules::COLOUR)?;
        let times = keys.table("times")?.map(|keys| MapSource::take_section(keys, SourceRules::COLOUR)).transpose()?;
        keys.finish()?;
        Ok(Self { source, times })
    }

    /// Reads the terms, and returns their sum for every pixel, including sky. Components below 0 become 0, and
    /// components above the greatest 32-bit float become that.
    ///
    /// # Errors
    /// The errors of [`MapSource::read`]; [`Error::Malformed`](ssct_ground::Error::Malformed) for a value that is not
    /// finite.
    pub fn read_sum<'a>(terms: &'a [Self], files: &mut MapFiles<'a>) -> Result<Vec<Vec3>> {
        let mut sum = vec![[0.0_f64; 3]; files.pixels()];
        for term in terms {
            let planes = term.source.read(files)?;
            let factor_planes = term.times.as_ref().map(|times| times.read(files)).transpose()?;
            for (pixel, sum) in sum.iter_mut().enumerate() {
                let factors = factor_planes.as_ref().map_or([1.0; 3], |second| second.three(pixel));
                for ((sum, value), factor) in sum.iter_mut().zip(planes.three(pixel)).zip(factors) {
                    if !(value * factor).is_finite() {
                        return Err(planes.error(pixel, value * factor, "be finite"));
                    }
                    *sum += value * factor;
                }
            }
        }
        Ok(sum
            .into_iter()
            .map(|rgb| Vec3::from(rgb.map(|value| value.max(0.0).min(f64::from(f32::MAX)) as f32)))
            .collect())
    }
}

/// The channel that marks the surfaces that show the environment of [`sky`](crate::sky).
#[derive(Debug, Clone)]
pub(super) struct MapSky {
    source: MapSource,
}

impl MapSky {
    /// Takes the keys of the section `[sky]`.
    pub fn take(keys: MapKeys) -> Result<Self> {
        Ok(Self { source: MapSource::take_section(keys, SourceRules::EXACT)? })
    }

    /// Reads the kind of surface of every pixel: sky where the channel is above ½.
    ///
    /// # Errors
    /// The errors of [`MapSource::read`].
    pub fn read<'a>(&'a self, files: &mut MapFiles<'a>) -> Result<Vec<Surface>> {
        let planes = self.source.read(files)?;
        let surface_of = |pixel| if planes.value(0, pixel) > 0.5 { Surface::Sky } else { Surface::Lit };
        Ok((0..files.pixels()).map(surface_of).collect())
    }
}
