//! Triangles of a renderer that passes meshes with colours and textures, but no scene with lights. The colour of a hit
//! is the light that the mesh emits at that place.

use super::triangle_scene::{
    TEXELS, TriangleBuffers, TriangleGeometry, TriangleImages, TriangleReading, TriangleTable, VECTORS,
    buffer_and_staging,
};
use crate::error::Result;
use crate::gpu::sync::Access;
use crate::gpu::{Buffer, Frame, Gpu};
use ssct_ground::math::constants::{MAP_LEVELS, TREE_DEPTH};
use ssct_ground::math::{linear_to_srgb, srgb_to_linear};
use ssct_ground::scene::tree::{Tree, TriangleRecords};
use ssct_ground::scene::{Encoding, Material, Texture};

/// The triangles in device memory, and staging buffers, from which a frame of the caller copies them.
pub struct UnlitTriangles {
    geometry: TriangleGeometry,
    images: TriangleImages,
    table: TriangleTable,
    /// Kept as long as the triangles, since it is not known here when the device has read these buffers.
    staging: [Buffer; 3],
}

impl UnlitTriangles {
    /// Makes the buffers, and staging buffers with their content, which [`Self::record`] copies. The materials' albedo
    /// maps are indices into `textures`.
    ///
    /// # Errors
    /// [`crate::error::Error::Memory`] without memory.
    pub fn new(
        gpu: &Gpu,
        tree: &Tree,
        records: &TriangleRecords,
        materials: &[Material],
        textures: &[Texture],
    ) -> Result<Self> {
        let vectors = TriangleGeometry::vectors(tree, records);
        let (geometry, geometry_staging) =
            buffer_and_staging(gpu, "triangles", bytemuck::cast_slice(&vectors), VECTORS)?;
        let (words, maps) = TriangleImages::words(textures.iter().map(|texture| (texture, mip_levels(texture))));
        let (images, image_staging) = buffer_and_staging(gpu, "textures", bytemuck::cast_slice(&words), TEXELS)?;
        let images = TriangleImages::from_buffer(maps, images);
        let rows = images.rows(materials);
        let (table, table_staging) = buffer_and_staging(gpu, "colours", bytemuck::cast_slice(&rows), VECTORS)?;
        Ok(Self {
            geometry: TriangleGeometry::from_buffer(tree, records, geometry),
            images,
            table: TriangleTable(table),
            staging: [geometry_staging, image_staging, table_staging],
        })
    }

    /// Records the passes "triangles/upload", which copy the three buffers to the device.
    pub fn record(&self, frame: &mut Frame) -> Result<()> {
        let TriangleBuffers { geometry, images, table, .. } = self.buffers();
        for (from, to) in self.staging.iter().zip([geometry, images, table]) {
            frame.copy_buffer("triangles/upload", from, to.buffer(), Access::ComputeStorageRead)?;
        }
        Ok(())
    }

    /// Returns how shaders read the triangles. The stack of a walk has room for a tree of any depth, since more
    /// triangles may replace these.
    pub fn reading(&self) -> TriangleReading {
        TriangleReading { unlit: true, walk_room: TREE_DEPTH, ..self.geometry.reading(&self.images, 0) }
    }

    /// Returns the buffers that passes bind.
    pub fn buffers(&self) -> TriangleBuffers<'_> {
        self.geometry.buffers(&self.images, &self.table)
    }
}

/// Returns the texels of each level of a texture, from the finest to a single texel, packed by [`words`]. A texel is
/// the mean, in linear light, of 2 × 2 texels of the level before; the last texels of an odd side are left out.
fn mip_levels(texture: &Texture) -> Vec<Vec<u32>> {
    let is_srgb = texture.encoding == Encoding::Srgb;
    let decoded = |value: f32| if is_srgb { srgb_to_linear(value) } else { value };
    let encoded = |light: f32| if is_srgb { linear_to_srgb(light) } else { light };
    let light_of_byte: [f32; 256] = std::array::from_fn(|byte| decoded(byte as f32 / 255.0));
    let mut size = [texture.width as usize, texture.height as usize];
    let mut finest: Vec<[u8; 4]> = texture.rgba.as_chunks::<4>().0.to_vec();
    let mut levels = vec![words(&finest)];
    while size != [1, 1] && levels.len() < MAP_LEVELS as usize {
        let coarse = size.map(|side| (side / 2).max(1));
        let texel = |x: usize, y: usize| finest[y.min(size[1] - 1) * size[0] + x.min(size[0] - 1)];
        let next: Vec<[u8; 4]> = (0..coarse[0] * coarse[1])
            .map(|index| {
                let (x, y) = (2 * (index % coarse[0]), 2 * (index / coarse[0]));
                let four = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
                std::array::from_fn(|channel| {
                    let sum: f32 = four.iter().map(|bytes| light_of_byte[usize::from(bytes[channel])]).sum();
                    (255.0 * encoded(0.25 * sum)).round() as u8
                })
            })
            .collect();
        levels.push(words(&next));
        (finest, size) = (next, coarse);
    }
    levels
}

/// Packs texels into words, with red in the lowest byte and alpha in the highest.
fn words(texels: &[[u8; 4]]) -> Vec<u32> {
    texels.iter().map(|texel| u32::from_le_bytes(*texel)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture([width, height]: [u32; 2], encoding: Encoding, grey: &[u8]) -> Texture {
        let rgba = grey.iter().flat_map(|v| [*v, *v, *v, 255]).collect();
        Texture { name: String::new(), width, height, rgba, encoding }
    }

    #[test]
    fn a_level_is_the_mean_of_light_over_the_one_before() {
        let level_bytes = |encoding| {
            let levels = mip_levels(&texture([4, 2], encoding, &[0, 255, 10, 10, 255, 0, 10, 10]));
            levels
                .iter()
                .map(|level| level.iter().map(|word| word.to_le_bytes()[0]).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        };
        // Half of all light is 188 of 255 in sRGB.
        assert_eq!(level_bytes(Encoding::Linear)[1..], [vec![128, 10], vec![69]]);
        assert_eq!(level_bytes(Encoding::Srgb)[1], [188, 10]);
        let odd = mip_levels(&texture([3, 1], Encoding::Linear, &[0, 100, 255]));
        assert_eq!(odd.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1]);
        assert_eq!(odd[1][0].to_le_bytes(), [50, 50, 50, 255]);
    }
}
