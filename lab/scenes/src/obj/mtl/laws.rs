//! The meaning of a material's numbers, which depends on the program that wrote the file.
//!
//! A law is the meaning of the numbers in the files of one program. Wavefront's own law has a colour of highlights
//! (`Ks`) and an exponent (`Ns`). Blender's exporter writes other quantities under these names, and the PBR keys have
//! the meaning of glTF. docs/definitions.md, "Exporters of MTL", has the table and says how each law was found.

use super::{Definition, TRANSPARENCY};
use crate::Material;
use crate::material_terms::{F0, f0_of_ior, roughness_of_exponent, roughness_of_perceptual};
use crate::metallic::{Factors, TexelInputs};
use crate::obj::baked::MaterialReading;
use glam::Vec3;
use ssct_geometry::texture::luminance;

/// The exponent that Blender writes for a perfect mirror: of a roughness r it writes `Ns` = 1000 (1 − r)².
const BLENDER_EXPONENT: f32 = 1000.0;

/// The roughness of Blender's default material.
const BLENDER_ROUGHNESS: f32 = 0.5;

/// The first major version of Blender in which the level of the specular reflection multiplies that of the index of
/// refraction.
const FIRST_BLENDER_WITH_IOR: u32 = 4;

/// The program that wrote an MTL file, if it changes the meaning of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Exporter {
    /// A program whose numbers have Wavefront's meaning, as far as known.
    #[default]
    Unknown,
    /// Blender of this major version. Files that state no version are older than 3.3 and follow another law, and are
    /// read like those of an unknown program.
    Blender(u32),
}

impl Exporter {
    /// Returns the program that a comment such as `# Blender 4.1.0 MTL File` names as the writer of the file; `None`
    /// for a comment that is not Blender's.
    pub(super) fn from_comment(line: &str) -> Option<Self> {
        let rest = line.trim_start_matches('#').trim_start().strip_prefix("Blender ")?;
        let (version, rest) = rest.split_once(' ')?;
        let major = version.split('.').next()?.parse().ok()?;
        rest.contains("MTL File").then_some(Self::Blender(major))
    }
}

/// The law by which a material's numbers are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Law {
    /// Wavefront's law: `Ks` is the reflectivity, and `Ns` the exponent of the lobe, unless a roughness is given.
    #[default]
    Wavefront,
    /// Blender's `Ns`, `Ks`, `Ka` and `Ni`, without PBR keys.
    Blender(u32),
    /// Metalness and roughness. Blender's `Ks` is the level of the specular reflection, and the `Ks` of other programs
    /// is ignored.
    Pbr(Exporter),
}

impl Definition {
    /// Chooses the law (the meaning of the numbers) once all statements of the material were read, and notes warnings
    /// about statements that this law drops.
    pub(super) fn choose_law(&mut self, exporter: Exporter) {
        let has_metalness = self.metalness.is_some() || self.images.metalness.is_some();
        let has_roughness = self.roughness.is_some() || self.images.roughness.is_some();
        let has_specular = self.specular.is_some() || self.images.reflectivity.is_some();
        self.law = match exporter {
            exporter if has_metalness => Law::Pbr(exporter),
            Exporter::Blender(_) if has_roughness => Law::Pbr(exporter),
            Exporter::Blender(major) => Law::Blender(major),
            // A file with a roughness and a specular colour but no metalness is read by Wavefront's law, which uses
            // both.
            Exporter::Unknown if has_roughness && !has_specular => Law::Pbr(exporter),
            Exporter::Unknown => Law::Wavefront,
        };
        if let (Some(place), Exporter::Blender(_)) = (self.transmission.take(), exporter) {
            self.note_dropped_at(&place, TRANSPARENCY);
        }
        let [exponent_image, reflection_image] = [self.exponent_image.take(), self.reflection_image.take()];
        if let Law::Blender(_) = self.law {
            (self.images.roughness, self.images.metalness) = (exponent_image, reflection_image);
            return;
        }
        if let Some(image) = exponent_image {
            self.note_dropped_at(&image.place(), "images of exponents (map_Ns) are not supported and were ignored");
        }
        if let Some(image) = reflection_image {
            self.note_dropped_at(&image.place(), "reflection maps (refl) are not supported and were ignored");
        }
        if let Some(image) = self.images.reflectivity.take_if(|_| self.law == Law::Pbr(Exporter::Unknown)) {
            self.note_dropped_at(
                &image.place(),
                "images of specular colour (map_Ks) do not count beside metalness and roughness",
            );
        }
    }

    /// Returns the material that the statements describe, by the law that `choose_law` chose.
    pub(in crate::obj) fn reading(&self) -> MaterialReading {
        let factors = Factors {
            base: self.base_colour(),
            metallic: self.metalness_factor(),
            emission: self.emission_factor(),
            f0: Vec3::splat(self.f0()),
            specular: 1.0,
            unlit: false,
        };
        let is_metallic = self.law != Law::Wavefront;
        let (albedo, emission) = factors.colour(&TexelInputs::default());
        let reflectivity = match is_metallic {
            true => factors.reflectivity(&TexelInputs::default()),
            false => self.specular.map_or(1.0, luminance).clamp(0.0, 1.0),
        };
        let roughness = self.lobe_roughness();
        let material = Material { albedo, emission, reflectivity, roughness, ..Material::default() };
        MaterialReading { material, factors, is_metallic, roughness_factor: self.perceptual_roughness().unwrap_or(1.0) }
    }

    /// Returns the linear base colour. Black together with an image counts as white, as exporters mean it.
    fn base_colour(&self) -> Vec3 {
        let base = self.diffuse.unwrap_or(Vec3::ONE).clamp(Vec3::ZERO, Vec3::ONE);
        if base == Vec3::ZERO && self.images.albedo.is_some() { Vec3::ONE } else { base }
    }

    /// Returns the linear emission. Black together with an image counts as white.
    fn emission_factor(&self) -> Vec3 {
        let stated = self.emission.unwrap_or(Vec3::ZERO).clamp(Vec3::ZERO, Vec3::splat(1e6));
        if stated == Vec3::ZERO && self.images.emission.is_some() { Vec3::ONE } else { stated }
    }

    /// Returns the metalness, 0…1. A number of 0 together with an image counts as 1.
    fn metalness_factor(&self) -> f32 {
        let stated = match self.law {
            Law::Wavefront => 0.0,
            // Blender writes the metalness as the ambient colour, but it writes white for a material without metalness,
            // too. The two are told apart by the illumination model, which is 3 or 6 only for metals.
            Law::Blender(_) => {
                self.ambient.filter(|_| matches!(self.model, Some(3 | 6))).map_or(0.0, |ambient| ambient.x)
            }
            Law::Pbr(_) => self.metalness.unwrap_or(0.0),
        };
        if stated == 0.0 && self.images.metalness.is_some() { 1.0 } else { stated.clamp(0.0, 1.0) }
    }

    /// Returns the reflection at normal incidence of the part that is not metal. By Wavefront's law it is 0, and not
    /// used.
    fn f0(&self) -> f32 {
        // Blender writes an index of 1 for materials without an index of refraction.
        let ior = self.ior.filter(|ior| ior.is_finite() && *ior > 1.0);
        let f0_by_ior = ior.map_or(F0, f0_of_ior);
        let has_image = self.images.reflectivity.is_some();
        // The level of the specular reflection is 0.5 by default, with which the factor 2 · level is 1.
        let f0_by_level = |major| {
            let level = self.specular.map_or(if has_image { 1.0 } else { 0.5 }, luminance).max(0.0);
            2.0 * level * if major >= FIRST_BLENDER_WITH_IOR { f0_by_ior } else { F0 }
        };
        match self.law {
            Law::Wavefront => 0.0,
            Law::Blender(major) | Law::Pbr(Exporter::Blender(major)) => f0_by_level(major),
            Law::Pbr(Exporter::Unknown) => f0_by_ior,
        }
    }

    /// Returns the perceptual roughness of glTF, 0…1, or the factor on the image of roughness if there is one. The
    /// result is `None` if the material gives no roughness and the law is not Blender's.
    fn perceptual_roughness(&self) -> Option<f32> {
        if self.images.roughness.is_some() {
            return Some(self.roughness.filter(|roughness| *roughness > 0.0).unwrap_or(1.0).clamp(0.0, 1.0));
        }
        // Blender writes a roughness r as the exponent 1000 (1 − r)².
        let roughness_by_exponent = |exponent: f32| 1.0 - (exponent / BLENDER_EXPONENT).clamp(0.0, 1.0).sqrt();
        match self.law {
            Law::Blender(_) => Some(self.exponent.map_or(BLENDER_ROUGHNESS, roughness_by_exponent)),
            Law::Wavefront | Law::Pbr(_) => self.roughness.map(|roughness| roughness.clamp(0.0, 1.0)),
        }
    }

    /// Returns the roughness ϱ, 0…1, that the numbers give without images.
    fn lobe_roughness(&self) -> f32 {
        match (self.perceptual_roughness(), self.law) {
            (Some(perceptual), _) => roughness_of_perceptual(perceptual),
            (None, Law::Wavefront) => self.exponent.map_or(0.0, roughness_of_exponent),
            (None, _) => self.exponent.map_or(roughness_of_perceptual(1.0), roughness_of_exponent),
        }
    }
}
