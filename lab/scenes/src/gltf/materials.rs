//! Converts metallic-roughness materials to materials of the scene, and computes ("bakes") the scene's images from
//! theirs.
//!
//! | glTF | here |
//! |---|---|
//! | base colour · (1 − metallic) | albedo |
//! | luminance of mix(F0, base colour, metallic), F0 of the index of refraction (0.04 without one) and `KHR_materials_specular` | reflectivity |
//! | roughness | ϱ of [`roughness_of_perceptual`] |
//! | emission e, or the whole albedo of an unlit material | albedo + e, of which the share of e in the luminance is emission |
//! | alpha below the cutoff | a hole |
//!
//! If a material has images, the results are baked texel by texel into images of the size of its largest image.

use super::Notes;
use super::data::{Data, ImageBytes};
use super::document::remedy;
use crate::material_terms::{self, F0, roughness_of_perceptual};
use crate::metallic::{Factors, TexelInputs, bake_texels, grey, white};
use crate::{Encoding, Material, Scene, Texture};
use glam::{DVec4, Vec3};
use gltf::material::AlphaMode;
use gltf::texture::{Info, MagFilter, MinFilter, WrappingMode};
use rayon::prelude::*;
use serde_json::Value;
use ssct_geometry::bounded;
use ssct_geometry::texture::{self, MAX_TEXELS, TexelBudget};
use ssct_ground::Error;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The texture coordinates that a material uses, and their transform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coordinates {
    /// Number of the set, as in `TEXCOORD_0`.
    pub(super) set: u32,
    offset: [f32; 2],
    /// Angle in radians.
    rotation: f32,
    scale: [f32; 2],
    /// True if an image of the material is clamped or mirrored at its borders, and not repeated.
    pub(super) clamps: bool,
    /// True if an image needs the coordinates.
    pub(super) has_images: bool,
}

impl Coordinates {
    /// Scales, rotates and then shifts the texture coordinates of a vertex. The rotation is counter-clockwise as seen
    /// with v downwards. The prose and the test model of the extension `KHR_texture_transform` say so; the example code
    /// in its text has the signs of the opposite direction.
    pub(super) fn transform_uv(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        let [u, v] = [u * self.scale[0], v * self.scale[1]];
        // Adding zero turns −0 into 0, so that welding finds equal bits.
        [cos * u + sin * v + self.offset[0] + 0.0, cos * v - sin * u + self.offset[1] + 0.0]
    }
}

/// How a material uses one of its images.
struct TextureUse<'a> {
    texture: gltf::Texture<'a>,
    coordinates: Coordinates,
}

impl<'a> TextureUse<'a> {
    /// Reads how a material uses any texture but its normal map.
    fn of_info(info: &Info<'a>) -> Self {
        let (set, offset, rotation, scale) = match info.texture_transform() {
            Some(transform) => {
                let set = transform.tex_coord().unwrap_or(info.tex_coord());
                (set, transform.offset(), transform.rotation(), transform.scale())
            }
            None => (info.tex_coord(), [0.0; 2], 0.0, [1.0; 2]),
        };
        Self::new(info.texture(), set, offset, rotation, scale)
    }

    /// Reads how a material uses its normal map.
    fn of_normals(normals: &gltf::material::NormalTexture<'a>) -> Self {
        let transform = normals.extension_value("KHR_texture_transform");
        Self::with_transform(normals.texture(), normals.tex_coord(), transform)
    }

    /// Reads how a material uses the texture `key` of an extension that the crate `gltf` leaves as JSON. Returns `None`
    /// if the extension names no such texture.
    fn of_extension(data: &Data<'a>, extension: &Value, key: &str) -> Option<Self> {
        let info = extension.get(key)?;
        let texture = data.document.textures().nth(usize::try_from(info.get("index")?.as_u64()?).ok()?)?;
        let set = info.get("texCoord").and_then(|set| u32::try_from(set.as_u64()?).ok());
        let transform = info.get("extensions").and_then(|extensions| extensions.get("KHR_texture_transform"));
        Some(Self::with_transform(texture, set.unwrap_or(0), transform))
    }

    /// Reads the transform that `KHR_texture_transform` gives as JSON, if it is there. Its set of coordinates, if it
    /// names one, replaces `set`.
    fn with_transform(texture: gltf::Texture<'a>, set: u32, transform: Option<&Value>) -> Self {
        let member = |key: &str| transform.and_then(|members| members.get(key));
        let pair = |key: &str, default: f32| {
            let number_at = |index: usize| member(key).and_then(|list| list.get(index)?.as_f64());
            [0, 1].map(|index| number_at(index).map_or(default, |value| value as f32))
        };
        let rotation = member("rotation").and_then(Value::as_f64).map_or(0.0, |angle| angle as f32);
        let replacing_set = member("texCoord").and_then(|set| u32::try_from(set.as_u64()?).ok());
        Self::new(texture, replacing_set.unwrap_or(set), pair("offset", 0.0), rotation, pair("scale", 1.0))
    }

    /// Describes the use of a texture with a set of texture coordinates and their transform; `rotation` is in radians.
    fn new(texture: gltf::Texture<'a>, set: u32, offset: [f32; 2], rotation: f32, scale: [f32; 2]) -> Self {
        let sampler = texture.sampler();
        let clamps = [sampler.wrap_s(), sampler.wrap_t()].iter().any(|mode| *mode != WrappingMode::Repeat);
        Self { texture, coordinates: Coordinates { set, offset, rotation, scale, clamps, has_images: true } }
    }

    /// Returns the index of the texture's image; `None`, with a note, if the file has it only in a format that is not
    /// read. Another note is added if the texture asks for its nearest texel, since all textures are filtered.
    fn image(&self, data: &Data, notes: &mut Notes) -> Option<usize> {
        let sampler = self.texture.sampler();
        if sampler.mag_filter() == Some(MagFilter::Nearest) || sampler.min_filter() == Some(MinFilter::Nearest) {
            notes.add("nearest", "images that are not to be filtered (NEAREST) are filtered".to_owned());
        }
        let image = self.texture.source().map(|image| image.index());
        if image.is_none() {
            let texture = data.document.as_json().textures.get(self.texture.index());
            let extension = texture.and_then(|texture| texture.extensions.as_ref()?.others.keys().next());
            let advice = extension.map_or("export the images as PNG, JPEG or WebP", |name| remedy(name));
            let problem =
                "images that are given neither as PNG nor as JPEG or WebP are not supported and were left out";
            notes.add("formats", format!("{problem}; {advice}"));
        }
        image
    }
}

/// Returns the coordinates that all images of a material share: those of its first image in the order base colour,
/// metallic-roughness, normals, emission, specular strength, specular colour. If other images have other coordinates, a
/// note is added.
pub(super) fn shared_coordinates(data: &Data, material: &gltf::Material, notes: &mut Notes) -> Coordinates {
    let pbr = material.pbr_metallic_roughness();
    let images = [pbr.base_color_texture(), pbr.metallic_roughness_texture(), material.emissive_texture()];
    let [base, metallic, emissive] = images.map(|info| info.map(|info| TextureUse::of_info(&info).coordinates));
    let normals = material.normal_texture().map(|normals| TextureUse::of_normals(&normals).coordinates);
    let specular = specular_textures(data, material).map(|texture| texture.map(|texture| texture.coordinates));
    let mut used_coordinates = [base, metallic, normals, emissive].into_iter().chain(specular).flatten();
    let Some(first) = used_coordinates.next() else {
        return Coordinates {
            set: 0,
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            clamps: false,
            has_images: false,
        };
    };
    let mut clamps = first.clamps;
    for other in used_coordinates {
        clamps |= other.clamps;
        if (Coordinates { clamps: first.clamps, ..other }) != first {
            let rule = "a material's images share one set of texture coordinates and one transform";
            notes.add(
                "coordinates",
                format!("{rule}; where they differ, those of the base colour count, or of the material's first image"),
            );
        }
    }
    Coordinates { clamps, ..first }
}

/// An image of the scene, described by the images of the file and the factors from which it is baked. Materials with
/// equal descriptions share the image.
#[derive(Debug, Clone, PartialEq)]
enum Baked {
    /// The base colour, unchanged.
    Plain { base: ImageId },
    /// Albedo, and in alpha the share of it that is emission.
    Albedo { base: Option<ImageId>, metallic: Option<ImageId>, emission: Option<ImageId>, factors: Factors },
    /// Reflectivity, in red.
    Reflectivity {
        base: Option<ImageId>,
        metallic: Option<ImageId>,
        /// The images of `KHR_materials_specular`: strength, in alpha, and colour.
        specular: [Option<ImageId>; 2],
        factors: Factors,
    },
    /// Roughness ϱ, from the green channel of the metallic-roughness image times a factor.
    Roughness { metallic: ImageId, factor: f32 },
    /// An alpha mask, which is one half where alpha times the factor equals the cutoff.
    Mask { base: Option<ImageId>, factor: f32, cutoff: f32 },
    /// A normal map whose slopes are multiplied by `scale`.
    Normals { normals: ImageId, scale: f32 },
}

/// The index of an image in the file.
type ImageId = usize;

/// The images of the scene that materials need, each listed once.
#[derive(Default)]
struct BakedImages {
    list: Vec<Baked>,
    /// Index of each image in the list. The key is the image's text in the format of `Debug`, since floats cannot be
    /// hashed.
    index: HashMap<String, usize>,
}

impl BakedImages {
    /// Returns the index of an image in the list, to which it is added if it is new.
    fn add(&mut self, description: Baked) -> usize {
        *self.index.entry(format!("{description:?}")).or_insert_with(|| {
            self.list.push(description);
            self.list.len() - 1
        })
    }
}

impl Baked {
    /// Returns the images of the file that this image is baked from.
    fn images(&self) -> Vec<ImageId> {
        match self {
            Self::Plain { base } => vec![*base],
            Self::Albedo { base, metallic, emission, .. } => {
                [base, metallic, emission].into_iter().copied().flatten().collect()
            }
            Self::Reflectivity { base, metallic, specular, .. } => {
                [base, metallic].into_iter().chain(specular).copied().flatten().collect()
            }
            Self::Roughness { metallic, .. } => vec![*metallic],
            Self::Mask { base, .. } => base.iter().copied().collect(),
            Self::Normals { normals, .. } => vec![*normals],
        }
    }
}

/// Adds the materials in use to the scene, in order, and bakes the images that they need. `used` has indices of the
/// file's materials, with `None` for the default material. No image gets more than `max_side` texels along a side.
pub(super) fn attach(data: &Data, used: &[Option<usize>], max_side: u32, scene: &mut Scene, notes: &mut Notes) {
    let mut baked_images = BakedImages::default();
    for index in used {
        let material = match index {
            Some(index) => data.document.materials().nth(*index),
            None => None,
        };
        scene.materials.push(match material {
            Some(material) => convert(data, &material, &mut baked_images, notes),
            None => default_material(),
        });
    }
    let baked = baked_images.list;
    let baker = Baker::new(data, max_side, &baked);
    let progress_bar = bounded::image_bar(baked.len());
    let textures = baked.par_iter().map(|description| {
        let texture = baker.bake(description);
        progress_bar.inc(1);
        texture
    });
    scene.textures = textures.collect();
    progress_bar.finish_and_clear();
    for (image, sentence) in baker.problems.into_inner().unwrap_or_else(PoisonError::into_inner) {
        notes.add(&format!("image {image}"), sentence);
    }
}

/// Reads the factors of a material, limited to their ranges. `KHR_materials_specular` changes the reflection of the
/// part of a surface that is not metal.
fn factors(material: &gltf::Material) -> Factors {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    // KHR_materials_ior gives the index 0 a meaning: everything is reflected (F0 = 1), as the formula yields.
    let ior = material.ior().filter(|ior| ior.is_finite() && *ior >= 0.0);
    let emissive_strength = material.emissive_strength().unwrap_or(1.0).max(0.0);
    let specular = material.extension_value("KHR_materials_specular");
    let number_or_one = |value: Option<&Value>| value.and_then(Value::as_f64).map_or(1.0, |number| number as f32);
    let specular_weight = number_or_one(specular.and_then(|members| members.get("specularFactor"))).clamp(0.0, 1.0);
    let tint_list = specular.and_then(|members| members.get("specularColorFactor"));
    let tint_channel = |channel: usize| number_or_one(tint_list.and_then(|list| list.get(channel))).clamp(0.0, 1e6);
    let tint = Vec3::from([0, 1, 2].map(tint_channel));
    Factors {
        base: Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE),
        metallic: pbr.metallic_factor().clamp(0.0, 1.0),
        emission: (Vec3::from(material.emissive_factor()) * emissive_strength).clamp(Vec3::ZERO, Vec3::splat(1e6)),
        f0: tint * ior.map_or(F0, material_terms::f0_of_ior),
        specular: specular_weight,
        unlit: material.unlit(),
    }
}

/// Adds a note about each factor outside 0…1. Such a factor counts as the nearer bound.
fn note_factors_out_of_range(material: &gltf::Material, notes: &mut Notes) {
    let pbr = material.pbr_metallic_roughness();
    let colour_factors = pbr.base_color_factor().map(|value| ("baseColorFactor", value));
    let other_factors = [("metallicFactor", pbr.metallic_factor()), ("roughnessFactor", pbr.roughness_factor())];
    for (name, value) in colour_factors.into_iter().chain(other_factors) {
        if (0.0..=1.0).contains(&value) {
            continue;
        }
        let place = material.index().map_or_else(String::new, |index| format!("materials[{index}]"));
        let nearest = value.clamp(0.0, 1.0);
        let sentence =
            format!("{place}.pbrMetallicRoughness.{name}: {value} lies outside 0 to 1 and counts as {nearest}");
        notes.add(&format!("{place} {name}"), sentence);
    }
}

/// Returns the textures of `KHR_materials_specular`: strength and colour.
fn specular_textures<'a>(data: &Data<'a>, material: &gltf::Material) -> [Option<TextureUse<'a>>; 2] {
    let specular = material.extension_value("KHR_materials_specular");
    ["specularTexture", "specularColorTexture"].map(|key| TextureUse::of_extension(data, specular?, key))
}

/// Returns the material of primitives that name none (glTF 2.0, 3.7.2.1): a rough white metal.
fn default_material() -> Material {
    Material {
        name: "default".into(),
        albedo: Vec3::ZERO,
        roughness: roughness_of_perceptual(1.0),
        ..Material::default()
    }
}

/// Converts a material of the file to one of the scene. The images that it needs are added to `baked`, and its maps are
/// indices into this list. A map replaces the number of the same property, which then becomes 1, since the baked map
/// includes the factor.
fn convert(data: &Data, material: &gltf::Material, baked: &mut BakedImages, notes: &mut Notes) -> Material {
    let pbr = material.pbr_metallic_roughness();
    let factors = factors(material);
    let specular =
        specular_textures(data, material).map(|texture| texture.and_then(|texture| texture.image(data, notes)));
    let mut image = |info: Option<Info>| info.and_then(|info| TextureUse::of_info(&info).image(data, notes));
    let base = image(pbr.base_color_texture());
    let metallic_roughness = image(pbr.metallic_roughness_texture());
    let metallic = metallic_roughness.filter(|_| factors.metallic > 0.0 && !factors.unlit);
    let emission = image(material.emissive_texture()).filter(|_| factors.emission != Vec3::ZERO && !factors.unlit);
    let emits = factors.unlit || factors.emission != Vec3::ZERO;
    if factors.emission.max_element() > 1.0 {
        notes.add("bright", "emission brighter than 1 counts as 1".to_owned());
    }
    note_factors_out_of_range(material, notes);
    let roughness_factor = pbr.roughness_factor().clamp(0.0, 1.0);
    if !factors.unlit && roughness_of_perceptual(roughness_factor) >= 1.0 {
        notes.add("rough", material_terms::TOO_ROUGH.to_owned());
    }
    let normals =
        material.normal_texture().and_then(|map| Some((TextureUse::of_normals(&map).image(data, notes)?, map.scale())));
    if material.alpha_mode() == AlphaMode::Blend {
        notes.add(
            "blend",
            "transparency is not supported; such materials have holes where alpha is below one half".to_owned(),
        );
    }
    let cutoff = match material.alpha_mode() {
        AlphaMode::Opaque => None,
        // No alpha is below a cutoff of 0, not even that of a transparent texel.
        AlphaMode::Mask => Some(material.alpha_cutoff().unwrap_or(0.5)).filter(|cutoff| *cutoff > 0.0),
        AlphaMode::Blend => Some(0.5),
    };
    let mut add = |description: Baked| baked.add(description);
    let (colour, emission_share) = factors.colour(&TexelInputs::default());
    let mut converted = Material {
        name: material.name().map_or_else(|| format!("material {}", material.index().unwrap_or(0)), str::to_owned),
        albedo: colour,
        emission: emission_share,
        reflectivity: if factors.unlit { 0.0 } else { factors.reflectivity(&TexelInputs::default()) },
        roughness: roughness_of_perceptual(roughness_factor),
        single_sided: !material.double_sided(),
        ..Material::default()
    };
    match base {
        // An image of base colour alone is used as it is: the factor multiplies it when it is drawn.
        Some(base) if metallic.is_none() && !emits => {
            converted.albedo = factors.base * (1.0 - factors.metallic);
            converted.albedo_map = Some(add(Baked::Plain { base }));
        }
        _ if base.is_some() || metallic.is_some() || emission.is_some() => {
            converted.albedo = Vec3::ONE;
            converted.emission = if emits { 1.0 } else { 0.0 };
            converted.albedo_map = Some(add(Baked::Albedo { base, metallic, emission, factors }));
        }
        _ => {}
    }
    let reflectivity_varies = factors.metallic > 0.0 && (base.is_some() || metallic.is_some());
    if !factors.unlit && (reflectivity_varies || specular != [None; 2]) {
        converted.reflectivity = 1.0;
        converted.reflectivity_map = Some(add(Baked::Reflectivity { base, metallic, specular, factors }));
    }
    if let Some(metallic) = metallic_roughness.filter(|_| !factors.unlit && roughness_factor > 0.0) {
        converted.roughness = 1.0;
        converted.roughness_map = Some(add(Baked::Roughness { metallic, factor: roughness_factor }));
    }
    let alpha_factor = pbr.base_color_factor()[3].clamp(0.0, 1.0);
    converted.alpha_mask = cutoff
        .filter(|cutoff| base.is_some() || alpha_factor < *cutoff)
        .map(|cutoff| add(Baked::Mask { base, factor: alpha_factor, cutoff: cutoff.max(1e-3) }));
    converted.normal_map = normals.map(|(normals, scale)| add(Baked::Normals { normals, scale }));
    converted
}

/// Decodes images of the file, and bakes images of the scene.
struct Baker<'a> {
    data: &'a Data<'a>,
    /// Greatest number of texels along a side of a decoded image.
    max_side: u32,
    /// Images of the file that would exceed the limit of a scene's texels.
    beyond_limit: HashSet<ImageId>,
    /// One message for each image that cannot be used.
    problems: Mutex<BTreeMap<ImageId, String>>,
}

impl<'a> Baker<'a> {
    /// Finds the images that exceed the limit of a scene's texels when they are added up in the order of `baked`,
    /// before any of them is decoded.
    fn new(data: &'a Data<'a>, max_side: u32, baked: &[Baked]) -> Self {
        let mut budget = TexelBudget::default();
        let mut beyond_limit = HashSet::new();
        for image in baked.iter().flat_map(Baked::images) {
            // An image without bytes is reported when it is decoded.
            let Ok((_, source)) = data.image(image) else { continue };
            let dimensions = match &source {
                ImageBytes::Inside(bytes) => texture::dimensions(bytes),
                ImageBytes::File(path) => image::image_dimensions(path).ok(),
            };
            let [width, height] = dimensions.map_or([1; 2], |(width, height)| [width, height]);
            if !budget.admits(width, height, max_side) {
                beyond_limit.insert(image);
            }
        }
        Self { data, max_side, beyond_limit, problems: Mutex::default() }
    }

    /// Decodes an image of the file. If it cannot be used, a message is added, and the result is `None`.
    fn decode(&self, index: ImageId, encoding: Encoding) -> Option<Texture> {
        let problem = match self.data.image(index) {
            Err(Error::Malformed { message, .. }) => message,
            Err(other) => other.to_string(),
            Ok((name, _)) if self.beyond_limit.contains(&index) => {
                format!("image {name} would exceed the {MAX_TEXELS} texels of a scene")
            }
            Ok((name, ImageBytes::File(path))) if !path.is_file() => format!("image {name} is missing"),
            Ok((name, source)) => {
                let decoded = match source {
                    ImageBytes::Inside(bytes) => texture::from_bytes(&bytes, Path::new(&name), encoding),
                    ImageBytes::File(path) => texture::decode(&path, encoding),
                };
                match decoded {
                    Ok(texture) => return Some(texture::shrink_to_side(texture, self.max_side)),
                    Err(error) => format!("image {name} cannot be used ({error})"),
                }
            }
        };
        let mut problems = self.problems.lock().unwrap_or_else(PoisonError::into_inner);
        problems.entry(index).or_insert_with(|| format!("{problem}; the material's factor takes its place"));
        None
    }

    /// Bakes an image of the scene. An image of the file that cannot be used counts as white, or as a flat surface if
    /// it is a normal map.
    fn bake(&self, baked: &Baked) -> Texture {
        let decode = |index: &Option<ImageId>, encoding| index.and_then(|index| self.decode(index, encoding));
        match baked {
            Baked::Plain { base } => self.decode(*base, Encoding::Srgb).unwrap_or_else(white),
            Baked::Albedo { base, metallic, emission, factors } => {
                let inputs = [
                    decode(base, Encoding::Srgb),
                    decode(metallic, Encoding::Linear),
                    decode(emission, Encoding::Srgb),
                ];
                bake_texels(&inputs, Encoding::Srgb, |[base, metallic, emission]| {
                    factors.albedo_texel(&TexelInputs::new(base, metallic.z, emission))
                })
            }
            Baked::Reflectivity { base, metallic, specular: [strength, tint], factors } => {
                let inputs = [
                    decode(base, Encoding::Srgb),
                    decode(metallic, Encoding::Linear),
                    decode(strength, Encoding::Linear),
                    decode(tint, Encoding::Srgb),
                ];
                bake_texels(&inputs, Encoding::Linear, |[base, metallic, strength, tint]| {
                    let inputs = TexelInputs::new(base, metallic.z, DVec4::ONE).with_specular(strength.w, tint);
                    grey(factors.reflectivity(&inputs))
                })
            }
            Baked::Roughness { metallic, factor } => {
                let inputs = [self.decode(*metallic, Encoding::Linear)];
                bake_texels(&inputs, Encoding::Linear, |[metallic]| {
                    grey(roughness_of_perceptual(factor * metallic.y as f32))
                })
            }
            Baked::Mask { base, factor, cutoff } => {
                let inputs = [decode(base, Encoding::Linear)];
                bake_texels(&inputs, Encoding::Linear, |[base]| grey(0.5 * factor * base.w as f32 / cutoff))
            }
            Baked::Normals { normals, scale } => match self.decode(*normals, Encoding::Linear) {
                Some(texture) => texture::scale_normal_map(texture, *scale),
                None => Texture { rgba: vec![128, 128, 255, 255], encoding: Encoding::Linear, ..white() },
            },
        }
    }
}
