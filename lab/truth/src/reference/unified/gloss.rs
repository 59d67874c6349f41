//! Data that the twins of the glossy passes share: the G-buffer and the colour chain as the shaders load them. The
//! module also tests which pixels and cells have a narrow or a wide lobe, or are drawn.

use super::gloss_trace::cell_pixel;
use super::{Hit, Traversal};
use crate::reference::Level;
use glam::{IVec2, Vec2, Vec3};
use ssct_ground::math::constants;
use ssct_scenes::GBufferData;

/// Roughness above which a lobe is wide.
const WIDE_ABOVE: f32 = constants::WIDE_ABOVE as f32;
/// Cells of 2 × 2 pixels along a side of a tile.
const TILE_CELLS: i32 = constants::TILE_SIDE / 2;

/// The glossy passes of one G-buffer. Normals, materials and colours of the G-buffer must be rounded to 16-bit floats,
/// since the shaders load them in this format.
#[derive(Debug, Clone)]
pub struct Gloss<'a> {
    /// Traversal of the same G-buffer, which follows the rays.
    pub(super) traversal: &'a Traversal<'a>,
    /// The lit colour with its coarser levels.
    chain: &'a [Level<Vec3>],
    /// The border fade's I_start and I_end (thesis, Eq. 4.7); `None` for no fade.
    fade: Option<[f32; 2]>,
    /// Whether another reflection shows where this one misses.
    pub(super) is_over: bool,
    /// For each cell of 2 × 2 pixels, the pixel that its ray begins in.
    wide: Level<Option<IVec2>>,
    /// For each tile, whether it has a pixel with a wide lobe.
    wide_tiles: Level<bool>,
}

impl<'a> Gloss<'a> {
    /// Makes the twin of the glossy passes over a traversal. The caller computes `chain`, the lit colour with its
    /// coarser levels; the twin does not filter them. `fade` is I_start and I_end of the border fade, and `is_over`
    /// says whether another reflection shows where this one misses.
    pub fn new(traversal: &'a Traversal, chain: &'a [Level<Vec3>], fade: Option<[f32; 2]>, is_over: bool) -> Self {
        let size = traversal.parameters.size;
        // Numbers of cells and of tiles along each axis.
        let [cells, tiles] = [2, 2 * TILE_CELLS].map(|side| ((size + side - 1) / side).as_uvec2());
        let empty = Level { width: 1, height: 1, texels: vec![None] };
        let wide_tiles = Level { width: 1, height: 1, texels: vec![false] };
        let mut gloss = Self { traversal, chain, fade, is_over, wide: empty, wide_tiles };
        gloss.wide = Level::from_fn(cells.x, cells.y, |x, y| {
            let cell = IVec2::new(x as i32, y as i32);
            // The lowest bits of the pixel that stands for the cell. The cell's four pixels are tried from it on.
            let first_bits = cell_pixel(cell) & 1;
            let pixels = (0_i32..4).map(|i| (2 * cell + (IVec2::new(i & 1, i >> 1) ^ first_bits)).min(size - 1));
            pixels.into_iter().find(|pixel| gloss.is_wide(*pixel))
        });
        let is_listed = |x: u32, y: u32| {
            let first_pixel = IVec2::new(x as i32, y as i32) * (2 * TILE_CELLS);
            let end_pixel = (first_pixel + 2 * TILE_CELLS).min(size);
            (first_pixel.y..end_pixel.y)
                .any(|y| (first_pixel.x..end_pixel.x).any(|x| gloss.is_on_list(IVec2::new(x, y), true)))
        };
        gloss.wide_tiles = Level::from_fn(tiles.x, tiles.y, is_listed);
        gloss
    }

    /// Returns the index of a pixel in the G-buffer.
    fn index(&self, pixel: IVec2) -> usize {
        self.traversal.gbuffer.index(pixel.x as u32, pixel.y as u32)
    }

    /// Twin of `TileListOf`: returns whether the material of a pixel, which may be sky, reflects with a wide lobe
    /// (`is_wide`) or with a narrow one (not `is_wide`).
    fn is_on_list(&self, pixel: IVec2, is_wide: bool) -> bool {
        let (gbuffer, index) = (self.traversal.gbuffer, self.index(pixel));
        let roughness = gbuffer.roughness[index];
        gbuffer.reflectivity[index] > GBufferData::REFLECTS_ABOVE
            && roughness > 0.0
            && (roughness > WIDE_ABOVE) == is_wide
    }

    /// Returns whether a pixel is on the list of narrow lobes.
    pub(super) fn is_narrow(&self, pixel: IVec2) -> bool {
        self.is_on_list(pixel, false)
    }

    /// Returns whether a pixel has a wide lobe and is not sky.
    pub(super) fn is_wide(&self, pixel: IVec2) -> bool {
        self.is_on_list(pixel, true) && self.depth(pixel) > 0.0
    }

    /// Twin of `FindWideCell`: returns the pixel that a cell's ray begins on; `None` if no pixel of the cell has a wide
    /// lobe. Pixels of a cell beyond the image are moved to its edge.
    pub(super) fn wide_pixel(&self, cell: IVec2) -> Option<IVec2> {
        let size = self.traversal.parameters.size;
        if cell.cmple(self.last_cell()).all() {
            return self.wide.at_clamped(cell.x as u32, cell.y as u32);
        }
        // A cell beyond the image, which has no place in `wide`.
        let first_bits = cell_pixel(cell) & 1;
        let mut pixels = (0_i32..4).map(|i| (2 * cell + (IVec2::new(i & 1, i >> 1) ^ first_bits)).min(size - 1));
        pixels.find(|pixel| self.is_wide(*pixel))
    }

    /// Returns the index of the last cell along each axis.
    pub(super) fn last_cell(&self) -> IVec2 {
        (self.traversal.parameters.size - 1) >> 1
    }

    /// Twin of `IsDrawn`: returns whether a cell lies in a tile that has a wide lobe, so that the passes for wide lobes
    /// draw it.
    pub(super) fn is_drawn(&self, cell: IVec2) -> bool {
        let tile = (cell / TILE_CELLS).as_uvec2();
        self.wide_tiles.at_clamped(tile.x, tile.y)
    }

    /// Returns the reversed depth of a pixel in the pyramid; −1 for sky.
    pub(super) fn depth(&self, pixel: IVec2) -> f32 {
        self.traversal.levels[0].at_clamped(pixel.x as u32, pixel.y as u32).front
    }

    /// Returns the normal of a pixel; 0 beyond the right or lower edge of the image.
    pub(super) fn normal(&self, pixel: IVec2) -> Vec3 {
        let is_inside = pixel.cmplt(self.traversal.parameters.size).all();
        if is_inside { self.traversal.gbuffer.normal[self.index(pixel)] } else { Vec3::ZERO }
    }

    /// Returns the roughness ϱ of a pixel, 0…1.
    pub(super) fn roughness(&self, pixel: IVec2) -> f32 {
        self.traversal.gbuffer.roughness[self.index(pixel)]
    }

    /// Twin of `Fade`: returns the border fade of the thesis (Eq. 4.7) at texture coordinates: 1 if there is no fade.
    pub(super) fn fade(&self, uv: Vec2) -> f32 {
        self.fade.map_or(1.0, |[start, end]| {
            let boundary = (uv - 0.5).length() * 2.0;
            1.0 - ((boundary - start) / (end - start)).clamp(0.0, 1.0)
        })
    }

    /// Twin of `LoadHitPixel` and `SampleColorChain`, but without the sky: returns the colour of a hit over a footprint
    /// as wide as the texels of a level, which is rounded. Level 0 takes the hit pixel; other levels blend the four
    /// texels around the hit.
    pub(super) fn sample_hit(&self, hit: &Hit, footprint_level: f32) -> Vec3 {
        let level = (footprint_level + 0.5).min((self.chain.len() - 1) as f32) as usize;
        let image = &self.chain[level];
        if level == 0 {
            return image.at_clamped(hit.pixel.x as u32, hit.pixel.y as u32);
        }
        let texels = IVec2::new(image.width as i32, image.height as i32);
        let texel_position = hit.position * (texels.as_vec2() / self.traversal.parameters.size.as_vec2()) - 0.5;
        let (first_texel, fraction) = (texel_position.floor(), texel_position - texel_position.floor());
        (0..4).fold(Vec3::ZERO, |sum, i| {
            let texel_offset = IVec2::new(i & 1, i >> 1);
            let texel = (first_texel.as_ivec2() + texel_offset).clamp(IVec2::ZERO, texels - 1);
            let weight = Vec2::select(texel_offset.cmpeq(IVec2::ONE), fraction, 1.0 - fraction);
            sum + weight.x * weight.y * image.at_clamped(texel.x as u32, texel.y as u32)
        })
    }
}
