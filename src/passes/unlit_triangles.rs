//! Triangles of a renderer that hands over meshes and colours, and no scene with images and lights: what a ray meets has its
//! mesh's colour.

use super::triangle_scene::{
    TEXELS, TriangleBuffers, TriangleGeometry, TriangleImages, TriangleReading, TriangleTable, VECTORS, WHITE_WORDS,
    staged,
};
use crate::error::Result;
use crate::gpu::sync::Access;
use crate::gpu::{Buffer, Frame, Gpu};
use crate::scene::Material;
use crate::scene::tree::{Tree, TriangleRecords};

/// The triangles in device memory, and what is copied there by a frame of the caller's.
pub struct UnlitTriangles {
    geometry: TriangleGeometry,
    images: TriangleImages,
    table: TriangleTable,
    /// Kept for as long as the device may read it, which is not known here.
    staging: [Buffer; 3],
}

impl UnlitTriangles {
    /// Makes the buffers. They have no content yet.
    ///
    /// # Errors
    /// [`crate::error::Error::Memory`] without memory.
    pub fn new(gpu: &Gpu, tree: &Tree, records: &TriangleRecords, materials: &[Material]) -> Result<Self> {
        let vectors = TriangleGeometry::vectors(tree, records);
        let (of_geometry, geometry) = staged(gpu, "triangles", bytemuck::cast_slice(&vectors), VECTORS)?;
        let (of_images, images) = staged(gpu, "no images", bytemuck::cast_slice(&WHITE_WORDS), TEXELS)?;
        let images = TriangleImages::white(images);
        let (of_table, table) = staged(gpu, "colours", bytemuck::cast_slice(&images.rows(materials)), VECTORS)?;
        Ok(Self {
            geometry: TriangleGeometry::of(tree, records, geometry),
            images,
            table: TriangleTable(table),
            staging: [of_geometry, of_images, of_table],
        })
    }

    /// Pass "triangles/upload": copies everything to the device.
    pub fn record(&self, frame: &mut Frame) -> Result<()> {
        let TriangleBuffers { geometry, images, table, .. } = self.bound();
        for (from, to) in self.staging.iter().zip([geometry, images, table]) {
            frame.copy_buffer("triangles/upload", from, to.buffer(), Access::ComputeStorageRead)?;
        }
        Ok(())
    }

    /// How the device reads them.
    pub fn reading(&self) -> TriangleReading {
        self.geometry.reading(&self.images, 0)
    }

    /// The buffers that passes bind.
    pub fn bound(&self) -> TriangleBuffers<'_> {
        self.geometry.bound(&self.images, &self.table)
    }
}
