//! Converts materials of base colour, metalness and roughness, as in glTF and in the PBR keys of MTL files, to this
//! program's materials: their factors, and their images texel by texel.
//!
//! The albedo is the base colour times 1 − metalness, plus the emission. The reflectivity is the luminance of mix(F0,
//! base colour, metalness) (docs/definitions.md, "glTF").

use super::material_terms;
use glam::{DVec2, DVec4, Vec3};
use ssct_geometry::texture::{self, Encoding, Texture, luminance};
use ssct_ground::math;
use std::borrow::Borrow;

/// The factors of a material on which its colours depend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Factors {
    /// Linear base colour, 0…1.
    pub(super) base: Vec3,
    /// Metalness, 0…1.
    pub(super) metallic: f32,
    /// Linear emission, at least 0.
    pub(super) emission: Vec3,
    /// Reflection at normal incidence of the part that is not metal, before the factor `specular`; values above 1 count
    /// as 1.
    pub(super) f0: Vec3,
    /// Factor on `f0`, 0…1.
    pub(super) specular: f32,
    /// Whether the surface shows its base colour alone.
    pub(super) unlit: bool,
}

/// The decoded values of a material's images at one texel; 1 for an image that the material lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TexelInputs {
    base: Vec3,
    metallic: f32,
    emission: Vec3,
    /// Factor on the strength of the specular reflection of the part that is not metal.
    specular: f32,
    /// Colour of this reflection.
    tint: Vec3,
}

impl Default for TexelInputs {
    fn default() -> Self {
        Self { base: Vec3::ONE, metallic: 1.0, emission: Vec3::ONE, specular: 1.0, tint: Vec3::ONE }
    }
}

impl TexelInputs {
    /// Makes the values of a texel for a material without images of the specular reflection.
    pub(super) fn new(base: DVec4, metallic: f64, emission: DVec4) -> Self {
        Self { base: rgb(base), metallic: metallic as f32, emission: rgb(emission), ..Self::default() }
    }

    /// Sets the factors on the reflection of the part that is not metal: its strength and its colour.
    pub(super) fn with_specular(self, specular: f64, tint: DVec4) -> Self {
        Self { specular: specular as f32, tint: rgb(tint), ..self }
    }
}

impl Factors {
    /// Returns the sum of albedo and emission, at most 1, and the share of its luminance that is emission.
    pub(super) fn colour(&self, texel: &TexelInputs) -> (Vec3, f32) {
        let base = texel.base * self.base;
        if self.unlit {
            return (base, 1.0);
        }
        let albedo = base * (1.0 - texel.metallic * self.metallic);
        let emitted = texel.emission * self.emission;
        let emission_share = luminance(emitted) / luminance(albedo + emitted);
        ((albedo + emitted).min(Vec3::ONE), if emission_share.is_finite() { emission_share } else { 0.0 })
    }

    /// Returns the reflectivity at a texel, 0…1.
    pub(super) fn reflectivity(&self, texel: &TexelInputs) -> f32 {
        let f0 = (self.f0 * texel.tint).min(Vec3::ONE) * self.specular * texel.specular;
        material_terms::reflectivity(texel.base * self.base, texel.metallic * self.metallic, f0)
    }

    /// Returns the bytes of a texel for an image of [`Self::colour`]: the colour as sRGB, and the share of emission in
    /// alpha.
    pub(super) fn albedo_texel(&self, texel: &TexelInputs) -> [u8; 4] {
        let (colour, emission_share) = self.colour(texel);
        let [r, g, b] = colour.to_array().map(math::display_byte);
        [r, g, b, byte(emission_share)]
    }
}

/// Makes an image as wide and as high as the widest and the highest input. The function `texel` computes the bytes of a
/// texel from the values of all inputs at its place; a missing input is white.
pub(super) fn bake_texels<T: Borrow<Texture>, const N: usize>(
    inputs: &[Option<T>; N],
    encoding: Encoding,
    texel: impl Fn([DVec4; N]) -> [u8; 4],
) -> Texture {
    let inputs = inputs.each_ref().map(|input| input.as_ref().map(Borrow::<Texture>::borrow));
    let images = || inputs.iter().flatten();
    let width = images().map(|image| image.width).max().unwrap_or(1);
    let height = images().map(|image| image.height).max().unwrap_or(1);
    let name = images().next().map_or_else(String::new, |image| image.name.clone());
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let uv = DVec2::new((f64::from(x) + 0.5) / f64::from(width), (f64::from(y) + 0.5) / f64::from(height));
            let value_at_uv = |image: Option<&Texture>| image.map_or(DVec4::ONE, |image| texture::bilinear(image, uv));
            rgba.extend(texel(inputs.map(value_at_uv)));
        }
    }
    Texture { name, width, height, rgba, encoding }
}

/// Makes a white image of one texel.
pub(super) fn white() -> Texture {
    Texture { name: "white".into(), width: 1, height: 1, rgba: vec![255; 4], encoding: Encoding::Srgb }
}

/// Returns the colour of a texel, without its alpha.
fn rgb(texel: DVec4) -> Vec3 {
    texel.truncate().as_vec3()
}

/// Converts a number from 0 to 1 to the nearest byte from 0 to 255.
fn byte(unit: f32) -> u8 {
    (unit.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Makes the bytes of an opaque grey texel from a number from 0 to 1.
pub(super) fn grey(unit: f32) -> [u8; 4] {
    let value = byte(unit);
    [value, value, value, 255]
}
