//! Textures of a scene with their mip levels, and the table of its materials, as programs among triangles read them.

use super::{TEXEL_BYTES, TEXELS, texel_buffer, upload_vectors};
use crate::error::Result;
use crate::gpu::sync::Access;
use crate::gpu::{Buffer, FrameContext, Gpu, Image, TexelBuffer};
use ash::vk;
use ssct_ground::math::constants::{
    ALBEDO_SHIFT, MAP_LEVELS, MAP_SRGB, MASK_SHIFT, MATERIAL_SINGLE_SIDED, MATERIAL_SKY, NORMAL_SHIFT,
};
use ssct_ground::scene::tree::Words;
use ssct_ground::scene::{Encoding, Material, Surface, Texture};

/// The images of a scene's materials.
pub struct TriangleImages {
    /// In the order of the scene's images.
    maps: Vec<Map>,
    pub(super) buffer: TexelBuffer,
}

/// Where an image lies among the words of all images.
#[derive(Debug, Clone, Copy)]
pub(in crate::passes) struct Map {
    /// The index of the first of the words that say where the image's levels begin.
    place: u32,
    /// Width in the lower half, and height in the upper half.
    size: u32,
    /// The number of levels in the bits `MAP_LEVELS`, and the bit `MAP_SRGB`.
    levels_and_encoding: u32,
}

impl Map {
    /// Describes an image; `place` is the index of the first of the words that say where its levels begin.
    fn new(place: u32, [width, height]: [u32; 2], levels: u32, encoding: Encoding) -> Self {
        let srgb = if encoding == Encoding::Srgb { MAP_SRGB } else { 0 };
        Self { place, size: width | height << 16, levels_and_encoding: levels | srgb }
    }
}

/// The image that stands for a map that a material lacks: one white texel, at the beginning of all words.
const WHITE: Map = Map { place: 0, size: 1 | 1 << 16, levels_and_encoding: 1 };

/// The words of [`WHITE`]: the index of the word where its one level begins, and then the one texel.
const WHITE_WORDS: [u32; 2] = [1, u32::MAX];

/// The materials of a view, as shaders look them up.
pub struct TriangleTable(pub(in crate::passes) TexelBuffer);

/// The layout of all images as words: first the words of [`WHITE`], then where each level begins, then the texels.
struct Layout {
    /// All words that stand before the texels: those of [`WHITE`], and where each level begins.
    words: Vec<u32>,
    maps: Vec<Map>,
    /// Where the texels end.
    end: u32,
}

impl Layout {
    /// Lays out images, each given by its width and height, its encoding, and the number of texels of each level.
    fn for_images(images: impl Iterator<Item = ([u32; 2], Encoding, Vec<u32>)>) -> Self {
        let images: Vec<_> = images.collect();
        let mut words = WHITE_WORDS.to_vec();
        let mut maps = Vec::with_capacity(images.len());
        let mut end = (words.len() + images.iter().map(|(.., texels)| texels.len()).sum::<usize>()) as u32;
        for (extent, encoding, texels) in images {
            maps.push(Map::new(words.len() as u32, extent, texels.len() as u32, encoding));
            for count in texels {
                words.push(end);
                end += count;
            }
        }
        Self { words, maps, end }
    }
}

impl TriangleImages {
    /// Copies all levels of some images into one buffer, after the words that say where each level begins.
    ///
    /// # Errors
    /// [`crate::error::Error::Memory`] without memory.
    pub fn new(context: &mut FrameContext, images: &[(&Image, Encoding)]) -> Result<Self> {
        let gpu: Gpu = context.gpu().clone();
        let levels = |image: &Image| image.levels().min(MAP_LEVELS);
        let texels = |image: &Image, level: u32| image.level(level).extent().into_iter().product();
        let described = images.iter().map(|(image, encoding)| {
            let texels = (0..levels(image)).map(|level| texels(image, level)).collect();
            (image.extent(), *encoding, texels)
        });
        let Layout { words, maps, end } = Layout::for_images(described);
        let buffer = texel_buffer(&gpu, "texels of materials", TEXEL_BYTES * u64::from(end))?;
        let bytes = bytemuck::cast_slice(&words);
        let staging = Buffer::upload(&gpu, "staging", bytes, vk::BufferUsageFlags::TRANSFER_SRC)?;
        context.once(|frame| frame.copy_buffer("upload", &staging, &buffer, Access::ComputeStorageRead))?;
        for ((image, _), map) in images.iter().zip(&maps) {
            context.once(|frame| {
                for level in 0..levels(image) {
                    let first = u64::from(words[(map.place + level) as usize]);
                    frame.copy_to_buffer("texels", image.level(level), &buffer, TEXEL_BYTES * first)?;
                }
                frame.make_ready(image.all(), Access::FragmentSampled);
                Ok(())
            })?;
        }
        let (format, texel_bytes) = TEXELS;
        Ok(Self { maps, buffer: TexelBuffer::new(buffer, format, texel_bytes)? })
    }

    /// Returns the words of some textures, each given with the texels of its levels, and the map of each texture. The
    /// words that say where each level begins come before all texels, as in the buffer of [`Self::new`].
    pub(in crate::passes) fn words<'a>(
        textures: impl Iterator<Item = (&'a Texture, Vec<Vec<u32>>)>,
    ) -> (Vec<u32>, Vec<Map>) {
        let textures: Vec<_> = textures.collect();
        let described = textures.iter().map(|(texture, levels)| {
            let texels = levels.iter().map(|level| level.len() as u32).collect();
            ([texture.width, texture.height], texture.encoding, texels)
        });
        let Layout { mut words, maps, .. } = Layout::for_images(described);
        words.extend(textures.iter().flat_map(|(_, levels)| levels.iter().flatten()));
        (words, maps)
    }

    /// Makes the images from a buffer that holds their words, and from their maps.
    pub(in crate::passes) fn from_buffer(maps: Vec<Map>, buffer: TexelBuffer) -> Self {
        Self { maps, buffer }
    }

    /// Makes the table of a view's materials.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn table(&self, context: &mut FrameContext, materials: &[Material]) -> Result<TriangleTable> {
        Ok(TriangleTable(upload_vectors(context, "materials", &self.rows(materials))?))
    }

    /// Returns the rows of the table: three vectors for each material (`Material` in `triangles/scene.glsl`).
    pub(in crate::passes) fn rows(&self, materials: &[Material]) -> Vec<Words> {
        let map = |image: Option<usize>| image.map_or(WHITE, |i| self.maps[i]);
        let rows = |m: &Material| {
            let (albedo, normal, mask) = (map(m.albedo_map), map(m.normal_map), map(m.alpha_mask));
            let properties = [(m.surface == Surface::Sky, MATERIAL_SKY), (m.single_sided, MATERIAL_SINGLE_SIDED)];
            let bits = properties.into_iter().filter(|(has, _)| *has).fold(0, |bits, (_, bit)| bits | bit);
            let maps = [(albedo, ALBEDO_SHIFT), (normal, NORMAL_SHIFT), (mask, MASK_SHIFT)];
            let bits = maps.into_iter().fold(bits, |bits, (map, shift)| bits | map.levels_and_encoding << shift);
            let deviation = if m.normal_map.is_some() { m.normal_deviation } else { 0.0 };
            let [r, g, b] = m.albedo.to_array();
            [
                [r, g, b, m.emission].map(f32::to_bits),
                [albedo.place, albedo.size, normal.place, normal.size],
                [bits, deviation.to_bits(), mask.place, mask.size],
            ]
        };
        materials.iter().flat_map(rows).collect()
    }
}
