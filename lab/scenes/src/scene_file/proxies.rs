//! Reads the sections of a scene file that define probes, impostors and area lights ([`crate::proxies`]).

use crate::source_text::SourceText;
use crate::{Aabb, AreaLight, AreaShape, Encoding, Impostor, Probe, Texture, obj};
use glam::Vec3;
use serde::Deserialize;
use ssct_geometry::texture;
use ssct_ground::Result;
use std::path::Path;
use toml::Spanned;

/// Greatest cosine of the angle between the two half vectors of a rectangle, which must be orthogonal.
const MOST_COSINE: f32 = 1e-3;

/// A `[[probe]]` section: a position, and the corners of the box for the correction of parallax.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProbeSection {
    name: String,
    position: Spanned<[f32; 3]>,
    min: Spanned<[f32; 3]>,
    max: Spanned<[f32; 3]>,
}

/// An `[[impostor]]` section.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ImpostorSection {
    /// Name of the impostor; the default is the file name.
    name: Option<String>,
    file: Spanned<String>,
    centre: Spanned<[f32; 3]>,
    half_u: Spanned<[f32; 3]>,
    half_v: Spanned<[f32; 3]>,
}

/// The shape of an area light.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum AreaKind {
    Sphere,
    Capsule,
    Rectangle,
    Cuboid,
    Cylinder,
}

/// An `[[area_light]]` section; its kind decides which other keys it has.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AreaLightSection {
    kind: AreaKind,
    radiance: Spanned<[f32; 3]>,
    centre: Option<Spanned<[f32; 3]>>,
    radius: Option<Spanned<f32>>,
    a: Option<Spanned<[f32; 3]>>,
    b: Option<Spanned<[f32; 3]>>,
    half_u: Option<Spanned<[f32; 3]>>,
    half_v: Option<Spanned<[f32; 3]>>,
    half_w: Option<Spanned<f32>>,
}

impl SourceText<'_> {
    /// Returns a position as the file states it. Its place, which is multiplied by `scale`, must not be too far from the
    /// origin; `key` is its name in errors.
    fn stated_place(&self, key: &str, value: &Spanned<[f32; 3]>, scale: f32) -> Result<Vec3> {
        self.place(key, value, scale)?;
        self.vector(key, value)
    }

    /// Reads and checks a probe, whose position must lie in its box. The places of all sections, multiplied by `scale`,
    /// must not be too far from the origin.
    pub(super) fn probe(&self, section: &ProbeSection, scale: f32) -> Result<Probe> {
        let min = self.stated_place("min", &section.min, scale)?;
        let max = self.stated_place("max", &section.max, scale)?;
        if !min.cmplt(max).all() {
            return Err(self.error(section.max.span(), "max must be greater than min along every axis"));
        }
        let position = self.stated_place("position", &section.position, scale)?;
        if !(position.cmpge(min).all() && position.cmple(max).all()) {
            return Err(self.error(section.position.span(), "position must lie between min and max"));
        }
        Ok(Probe { name: section.name.clone(), position, bounds: Aabb { min, max } })
    }

    /// Reads an impostor and its image. The impostor's texture index is 0; the caller sets it.
    pub(super) fn impostor(&self, section: &ImpostorSection, scale: f32) -> Result<(Impostor, Texture)> {
        let centre = self.stated_place("centre", &section.centre, scale)?;
        let [half_u, half_v] = self.half_vectors(&section.half_u, &section.half_v)?;
        let name = section.file.get_ref();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let Some(path) = obj::resolve(folder, name) else {
            return Err(self.error(section.file.span(), format!("there is no file {name:?}")));
        };
        let texture = texture::decode(&path, Encoding::Srgb)?;
        let name = section.name.clone().unwrap_or_else(|| texture.name.clone());
        Ok((Impostor { name, centre, half_u, half_v, texture: 0 }, texture))
    }

    /// Reads and checks an area light, which must have the keys of its kind and no others.
    pub(super) fn area_light(&self, section: &Spanned<AreaLightSection>, scale: f32) -> Result<AreaLight> {
        let AreaLightSection { kind, radiance, centre, radius, a, b, half_u, half_v, half_w } = section.get_ref();
        let span = radiance.span();
        let radiance = self.vector("radiance", radiance)?;
        if radiance.min_element() < 0.0 {
            return Err(self.error(span, format!("radiance must not be negative, but is {radiance}")));
        }
        let shape = match (kind, centre, radius, [a, b], [half_u, half_v], half_w) {
            (AreaKind::Sphere, Some(centre), Some(radius), [None, None], [None, None], None) => AreaShape::Sphere {
                centre: self.stated_place("centre", centre, scale)?,
                radius: self.positive("radius", radius)?,
            },
            (AreaKind::Capsule | AreaKind::Cylinder, None, Some(radius), [Some(a), Some(b)], [None, None], None) => {
                let [a, b] = [self.stated_place("a", a, scale)?, self.stated_place("b", b, scale)?];
                let radius = self.positive("radius", radius)?;
                match kind {
                    AreaKind::Cylinder => AreaShape::Cylinder { a, b, radius },
                    _ => AreaShape::Capsule { a, b, radius },
                }
            }
            (AreaKind::Cuboid, Some(centre), None, [None, None], [Some(half_u), Some(half_v)], Some(half_w)) => {
                let centre = self.stated_place("centre", centre, scale)?;
                let [half_u, half_v] = self.half_vectors(half_u, half_v)?;
                AreaShape::Cuboid { centre, half_u, half_v, half_w: self.positive("half_w", half_w)? }
            }
            (AreaKind::Rectangle, Some(centre), None, [None, None], [Some(half_u), Some(half_v)], None) => {
                let centre = self.stated_place("centre", centre, scale)?;
                let [half_u, half_v] = self.half_vectors(half_u, half_v)?;
                AreaShape::Rectangle { centre, half_u, half_v }
            }
            _ => {
                let keys = match kind {
                    AreaKind::Sphere => "a sphere has a centre and a radius",
                    AreaKind::Capsule => "a capsule has a, b and a radius",
                    AreaKind::Rectangle => "a rectangle has a centre, half_u and half_v",
                    AreaKind::Cuboid => "a cuboid has a centre, half_u, half_v and the length half_w",
                    AreaKind::Cylinder => "a cylinder has a, b and a radius",
                };
                return Err(self.error(section.span(), format!("{keys} beside its radiance, and no other key")));
            }
        };
        Ok(AreaLight { shape, radiance })
    }

    /// Reads the two half vectors of a rectangle (from its centre to the middles of two edges), which must not be zero
    /// and must be orthogonal.
    fn half_vectors(&self, half_u: &Spanned<[f32; 3]>, half_v: &Spanned<[f32; 3]>) -> Result<[Vec3; 2]> {
        let (u, v) = (self.vector("half_u", half_u)?, self.vector("half_v", half_v)?);
        for (key, vector, stated) in [("half_u", u, half_u), ("half_v", v, half_v)] {
            if vector.try_normalize().is_none() {
                return Err(self.error(stated.span(), format!("{key} must not be zero")));
            }
        }
        if u.normalize().dot(v.normalize()).abs() > MOST_COSINE {
            return Err(self.error(half_v.span(), "half_u and half_v must stand at right angles"));
        }
        Ok([u, v])
    }
}
