//! Makes the maps of materials: images that are used unchanged, and images that are baked from several, like those of
//! glTF.

use crate::material_terms::roughness_of_perceptual;
use crate::metallic::{Factors, TexelInputs, bake_texels, grey};
use crate::{Encoding, Material, Texture};
use glam::{DVec4, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// A material as the conventions of the program that wrote its numbers give it.
#[derive(Debug, Clone)]
pub(super) struct MaterialReading {
    /// The material without its name, surface and images.
    pub material: Material,
    /// The factors from which images are baked.
    pub factors: Factors,
    /// Whether the material has metalness, so that its images change its reflection as in glTF.
    pub is_metallic: bool,
    /// The factor on the perceptual roughness that the image of the roughness holds.
    pub roughness_factor: f32,
}

/// The index of an image in the list of the images that were read.
type ImageId = usize;

/// The recipe of an image of the scene: the read images that it is made from, and the factors. Materials with equal
/// recipes share the image. `Plain` is an image that is used unchanged, and `level` is an image of the specular level.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ImageRecipe {
    Plain(ImageId),
    Albedo { base: Option<ImageId>, metalness: Option<ImageId>, emission: Option<ImageId>, factors: Factors },
    Reflectivity { base: Option<ImageId>, metalness: Option<ImageId>, level: Option<ImageId>, factors: Factors },
    Roughness { image: ImageId, factor: f32 },
}

/// The images that were read, and the images that the scene's materials need.
pub(super) struct Textures {
    /// The images that were read; `None` for an image without a file and without a replacement.
    read_images: Vec<Option<Texture>>,
    /// The images to make, each listed once.
    recipes: Vec<ImageRecipe>,
    /// Index of each recipe in `recipes`. The key is its text in the format of `Debug`, since floats cannot be hashed.
    recipe_index: HashMap<String, usize>,
}

impl Textures {
    /// Takes the images that were read; no material has asked for one yet.
    pub(super) fn new(read_images: Vec<Option<Texture>>) -> Self {
        Self { read_images, recipes: Vec::new(), recipe_index: HashMap::new() }
    }

    /// Returns true if an image was read or replaced.
    pub(super) fn has_image(&self, image: ImageId) -> bool {
        self.read_images[image].is_some()
    }

    /// Returns the index of a recipe among the images to make, to which it is added if it is new.
    fn add(&mut self, recipe: ImageRecipe) -> usize {
        *self.recipe_index.entry(format!("{recipe:?}")).or_insert_with(|| {
            self.recipes.push(recipe);
            self.recipes.len() - 1
        })
    }

    /// Gives a material its maps, as indices into the images of [`Textures::finish`]. `images` are indices of images
    /// that were read, in the order of [`MaterialImages`](super::images::MaterialImages). A baked map includes the
    /// material's number, which then becomes 1.
    pub(super) fn set_maps(
        &mut self,
        material: &mut Material,
        reading: Option<&MaterialReading>,
        images: [Option<ImageId>; 7],
    ) {
        let [base, normal, mask, reflectivity, emission, roughness, metalness] = images;
        let is_metallic = reading.is_some_and(|reading| reading.is_metallic);
        let emits = reading.is_some_and(|reading| reading.factors.emission != Vec3::ZERO);
        let is_baked = metalness.is_some() || (emits && (base.is_some() || emission.is_some()));
        let mut add_plain = |image: Option<ImageId>| image.map(|image| self.add(ImageRecipe::Plain(image)));
        let plain_images = [base.filter(|_| !is_baked), normal, mask, reflectivity.filter(|_| !is_metallic)];
        [material.albedo_map, material.normal_map, material.alpha_mask, material.reflectivity_map] =
            plain_images.map(&mut add_plain);
        let Some(MaterialReading { factors, roughness_factor, .. }) = reading.cloned() else { return };
        if is_baked {
            let emission = emission.filter(|_| emits);
            (material.albedo, material.emission) = (Vec3::ONE, if emits { 1.0 } else { 0.0 });
            material.albedo_map = Some(self.add(ImageRecipe::Albedo { base, metalness, emission, factors }));
        }
        if let Some(image) = roughness {
            material.roughness = 1.0;
            material.roughness_map = Some(self.add(ImageRecipe::Roughness { image, factor: roughness_factor }));
        }
        let is_tinted = factors.metallic > 0.0 && (base.is_some() || metalness.is_some());
        if is_metallic && (is_tinted || reflectivity.is_some()) {
            material.reflectivity = 1.0;
            // By these conventions, the image of the reflectivity holds the level of the specular reflection.
            let level = reflectivity;
            material.reflectivity_map = Some(self.add(ImageRecipe::Reflectivity { base, metalness, level, factors }));
        }
    }

    /// Makes the images. They will follow the scene's `first_index` other images, so that `first_index` is added to all
    /// indices of maps in `materials`. Images that were read only for baking are dropped.
    pub(super) fn finish(self, first_index: usize, materials: &mut [Material]) -> Vec<Texture> {
        for material in materials {
            let Material { albedo_map, normal_map, alpha_mask, reflectivity_map, roughness_map, .. } = material;
            let maps = [albedo_map, normal_map, alpha_mask, reflectivity_map, roughness_map];
            maps.into_iter().flatten().for_each(|index| *index += first_index);
        }
        let Self { mut read_images, recipes, .. } = self;
        let baked: Vec<Option<Texture>> = recipes.par_iter().map(|recipe| bake(recipe, &read_images)).collect();
        let finished = |(recipe, baked): (ImageRecipe, Option<Texture>)| match recipe {
            ImageRecipe::Plain(image) => read_images[image].take(),
            _ => baked,
        };
        recipes.into_iter().zip(baked).filter_map(finished).collect()
    }
}

/// Bakes an image from the images that were read; `None` for an image that is used unchanged.
fn bake(recipe: &ImageRecipe, read_images: &[Option<Texture>]) -> Option<Texture> {
    let input = |image: Option<ImageId>| read_images[image?].as_ref();
    // A number is read from red, since a grey image has it in every channel.
    Some(match *recipe {
        ImageRecipe::Plain(_) => return None,
        ImageRecipe::Albedo { base, metalness, emission, factors } => {
            bake_texels(&[base, metalness, emission].map(input), Encoding::Srgb, |[base, metalness, emission]| {
                factors.albedo_texel(&TexelInputs::new(base, metalness.x, emission))
            })
        }
        ImageRecipe::Reflectivity { base, metalness, level, factors } => {
            bake_texels(&[base, metalness, level].map(input), Encoding::Linear, |[base, metalness, level]| {
                let inputs = TexelInputs::new(base, metalness.x, DVec4::ONE).with_specular(level.x, DVec4::ONE);
                grey(factors.reflectivity(&inputs))
            })
        }
        ImageRecipe::Roughness { image, factor } => bake_texels(&[input(Some(image))], Encoding::Linear, |[texel]| {
            grey(roughness_of_perceptual(factor * texel.x as f32))
        }),
    })
}
