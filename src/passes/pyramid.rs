//! Makes the pyramid of front and back depths that rays walk over (docs/numerics.md, "What a robust method does", item
//! 2), all levels in one dispatch. CPU twin: `reference::unified`.

use super::{GBuffer, Pyramid};
use crate::error::Result;
use crate::gpu::program::Program;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{ComputePipeline, Frame, Gpu, Image, ImageDesc, Pixels, Sampled, programs};
use ash::vk;
use ssct_ground::math::constants::PYRAMID_TILE_SIDE;
use ssct_ground::scene::ProjectionKind;

/// Side, in pixels, of the square that one workgroup of the shader makes.
const TILE: u32 = PYRAMID_TILE_SIDE as u32;

/// The coarsest level that is ever made: cells of 64 × 64 pixels. Coarser levels gain nothing (docs/unified.md).
pub const COARSEST: u32 = TILE.ilog2();

/// Pipeline and image of one size.
pub struct PyramidPass {
    pipeline: ComputePipeline<programs::Pyramid<'static>>,
    image: Image,
    label: &'static str,
}

/// Returns the coarsest level of the pyramid of an image: the first level of a single cell, but at most [`COARSEST`].
pub fn top_level(extent: [u32; 2]) -> u32 {
    extent[0].max(extent[1]).next_power_of_two().ilog2().min(COARSEST)
}

/// Returns width and height of level 0: whole cells of the coarsest level, so that every level halves exactly.
pub fn padded(extent: [u32; 2]) -> [u32; 2] {
    extent.map(|side| side.next_multiple_of(1 << top_level(extent)))
}

/// Returns log2 of the columns in a strip of the image (`pyramid.glsl`): the greatest of 0 to 2 with which no side of
/// the image is longer than 8192 texels, some devices' limit. If there is none, the one whose longer side is shortest.
pub fn strip(extent: [u32; 2]) -> u32 {
    let longer_side = |strip: &u32| size(extent, *strip).into_iter().max();
    let fitting = (0..=2).rev().find(|strip| longer_side(strip) <= Some(8192));
    fitting.or_else(|| (0..=2).min_by_key(longer_side)).unwrap_or(0)
}

/// Returns width and height of the image. Each row holds one strip of 2^`strip` columns of a level. Level n begins at
/// row strips − (strips ≫ n) (`pyramid.glsl`), so that the height is the coarsest level's first row plus its strips.
pub fn size(extent: [u32; 2], strip: u32) -> [u32; 2] {
    let [width, height] = padded(extent);
    let top = top_level(extent);
    let strips = (2 * width) >> strip;
    [height << strip, strips - (strips >> top) + (width >> top).div_ceil(1 << strip)]
}

/// Returns the levels of a pyramid that was read back, finest first: front and back of each cell that has a pixel of
/// the picture, whose width and height are `extent`.
///
/// # Panics
/// If the image is smaller than [`size`] says for the picture.
pub fn levels(image: &Pixels, extent: [u32; 2]) -> Vec<Pixels> {
    let strip = strip(extent);
    let strips = (2 * padded(extent)[0]) >> strip;
    let level = |n: u32| {
        let [width, height] = extent.map(|side| side.div_ceil(1 << n));
        let first_row = strips - (strips >> n);
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texel = |(x, y): (u32, u32)| image.texel((y << strip) | (x % (1 << strip)), (x >> strip) + first_row);
        Pixels { width, height, channels: 2, values: cells.flat_map(texel).copied().collect() }
    };
    (0..=top_level(extent)).map(level).collect()
}

impl PyramidPass {
    /// Makes the pass for perspective images of a size in pixels.
    pub fn new(gpu: &Gpu, extent: [u32; 2]) -> Result<Self> {
        Self::for_projection(gpu, extent, ProjectionKind::Perspective)
    }

    /// Makes the pass for images of a size in pixels and a kind of projection.
    pub fn for_projection(gpu: &Gpu, extent: [u32; 2], kind: ProjectionKind) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let strip = strip(extent);
        let constants = programs::PyramidConstants { strip: strip as i32, orthographic: kind.is_orthographic() };
        let (size, usage) = (size(extent, strip), U::STORAGE | U::SAMPLED | U::TRANSFER_SRC);
        Ok(Self {
            pipeline: ComputePipeline::with_constants(gpu, &constants)?,
            image: Image::new(gpu, &ImageDesc::one_level("pyramid", vk::Format::R32G32_SFLOAT, size, usage))?,
            label: "pyramid",
        })
    }

    /// Returns the pass with another label, for images other than the screen.
    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Records pass "pyramid".
    pub fn record<'a>(
        &'a self,
        frame: &mut Frame,
        gbuffer: &GBuffer,
        parameters: &UnifiedBlock,
    ) -> Result<Pyramid<'a>> {
        let [width, height] = padded(gbuffer.depth.extent());
        let tiles = [width.div_ceil(TILE), height.div_ceil(TILE)];
        let program = programs::Pyramid {
            unified: parameters,
            depth_buffer: Sampled::nearest(gbuffer.depth.all()),
            pyramid: self.image.all(),
        };
        let [group_width, group_height, _] = <programs::Pyramid as Program>::SHADER.local_size;
        let threads = [tiles[0] * group_width, tiles[1] * group_height, 1]; // a workgroup for each tile
        frame.compute(self.label, &self.pipeline, &program, threads)?;
        Ok(self.recorded())
    }

    /// Returns the pyramid as it was recorded last.
    pub fn recorded(&self) -> Pyramid<'_> {
        Pyramid(&self.image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_reach_one_cell_and_halve_exactly() {
        assert_eq!([[1, 1], [2, 1], [3, 5], [64, 64], [65, 1]].map(top_level), [0, 1, 3, 6, 6]);
        assert_eq!([[1, 1], [3, 5], [1920, 1080], [641, 479]].map(padded), [[1, 1], [8, 8], [1920, 1088], [704, 512]]);
    }

    #[test]
    fn levels_are_cut_out_of_their_strips() {
        let extent = [13, 6];
        let ([width, height], strip) = (size(extent, strip(extent)), strip(extent));
        let strips = (2 * padded(extent)[0]) >> strip;
        let mut image = Pixels::zeros([width, height], 2);
        // Every cell holds its level and its place.
        for n in 0..=top_level(extent) {
            let [columns, rows] = padded(extent).map(|side| side >> n);
            for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
                let row = (x >> strip) + strips - (strips >> n);
                let first = 2 * (row * width + ((y << strip) | (x & ((1 << strip) - 1)))) as usize;
                image.values[first..first + 2].copy_from_slice(&[n as f32, (100 * x + y) as f32]);
            }
        }
        let found = levels(&image, extent);
        let sizes: Vec<_> = found.iter().map(|level| [level.width, level.height]).collect();
        assert_eq!(sizes, [[13, 6], [7, 3], [4, 2], [2, 1], [1, 1]]);
        for (n, level) in found.iter().enumerate() {
            for (x, y) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y))) {
                assert_eq!(level.texel(x, y), [n as f32, (100 * x + y) as f32], "level {n}, cell {x}, {y}");
            }
        }
    }

    #[test]
    fn levels_have_room_beside_each_other() {
        for side in 1..=300 {
            for extent in [[side, 1], [side, 300], [1, side], [side, 2100], [side, 5000], [40 * side, 5000]] {
                let ([width, height], strip) = (padded(extent), strip(extent));
                let [image_width, rows] = size(extent, strip);
                let strips = (2 * width) >> strip;
                let first = |level| strips - (strips >> level);
                for level in 0..=top_level(extent) {
                    let next = if level < top_level(extent) { first(level + 1) } else { rows };
                    assert!(first(level) + (width >> level).div_ceil(1 << strip) <= next, "{extent:?}, level {level}");
                }
                assert_eq!(image_width, height << strip, "{extent:?}");
                // Without strips, the image would be as wide as level 0, and twice as high.
                assert!(image_width.max(rows) <= width.max(2 * height).max(8192), "{extent:?}");
            }
        }
        assert_eq!([[960, 540], [1, 2049], [1, 4097], [10240, 4320]].map(strip), [2, 1, 0, 1]);
    }
}
