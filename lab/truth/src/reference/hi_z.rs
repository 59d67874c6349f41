//! The Hi-Z chain on the CPU (thesis §4.2.4, Alg. 3, Eq. 4.1): the twin of `passes::hi_z` and
//! `shaders-glsl/thesis/hi_z.frag`. Twin and shader agree bit for bit, because they only take minima and maxima.

use super::Level;

/// A texel of the chain: the least and the greatest standard depth of its cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinMax {
    /// Nearest depth.
    pub min: f32,
    /// Farthest depth.
    pub max: f32,
}

impl MinMax {
    /// Returns a texel that was read back from a device's chain, given by its one or two channels; `max` is NaN if the
    /// chain keeps no maxima.
    pub fn from_texel(texel: &[f32]) -> Self {
        Self { min: texel[0], max: texel.get(1).copied().unwrap_or(f32::NAN) }
    }
}

/// Returns, by Eq. 4.1 of the thesis, the offset in texels from the first to the second texel that a cell reads along
/// an axis. `side` is the size in texels of the finer level along this axis.
pub fn offset(side: u32) -> u32 {
    if side.is_multiple_of(2) { 1 } else { 2 }
}

/// Makes the next coarser level by Alg. 3 of the thesis; `None` if `finer` has a single texel. The thesis does not say
/// what a fetch beyond the edge returns (which occurs for a side of 1). Here, as in the shader, it returns the texel at
/// the edge.
///
/// Four texels determine a cell, even if it covers six or nine, which is the erratum of Alg. 3.
pub fn reduce(finer: &Level<MinMax>) -> Option<Level<MinMax>> {
    let (width, height) = finer.coarser()?;
    let (offset_x, offset_y) = (offset(finer.width), offset(finer.height));
    Some(Level::from_fn(width, height, |x, y| {
        let (x, y) = (2 * x, 2 * y);
        let offsets = [(0, 0), (offset_x, 0), (0, offset_y), (offset_x, offset_y)];
        let texels = offsets.map(|(dx, dy)| finer.at_clamped(x + dx, y + dy));
        MinMax {
            min: texels.map(|texel| texel.min).into_iter().fold(f32::INFINITY, f32::min),
            max: texels.map(|texel| texel.max).into_iter().fold(f32::NEG_INFINITY, f32::max),
        }
    }))
}

/// Returns the whole chain, down to a single texel; level 0 has the given standard depth as minimum and maximum.
pub fn chain(depth: &Level<f32>) -> Vec<Level<MinMax>> {
    let finest = Level {
        width: depth.width,
        height: depth.height,
        texels: depth.texels.iter().map(|z| MinMax { min: *z, max: *z }).collect(),
    };
    std::iter::successors(Some(finest), reduce).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a level of the given standard depths.
    fn depth(width: u32, height: u32, texels: &[f32]) -> Level<f32> {
        Level { width, height, texels: texels.to_vec() }
    }

    #[test]
    fn an_even_level_takes_all_four_texels() {
        let levels = chain(&depth(2, 2, &[0.4, 0.3, 0.9, 0.5]));
        assert_eq!(levels.len(), 2);
        assert_eq!(levels[1].texels, [MinMax { min: 0.3, max: 0.9 }]);
    }

    #[test]
    fn an_odd_level_skips_its_middle_texel() {
        // For a side of 3, Eq. 4.1 reads texels 0 and 2: the nearest texel, in the middle, is lost.
        let levels = chain(&depth(3, 1, &[0.4, 0.1, 0.5]));
        assert_eq!(levels[1].texels, [MinMax { min: 0.4, max: 0.5 }]);
    }

    #[test]
    fn chains_end_at_one_texel() {
        let sizes =
            |w, h| -> Vec<_> { chain(&Level::from_fn(w, h, |_, _| 0.5)).iter().map(|l| (l.width, l.height)).collect() };
        assert_eq!(sizes(5, 3), [(5, 3), (2, 1), (1, 1)]);
        assert_eq!(sizes(1, 4), [(1, 4), (1, 2), (1, 1)]);
        assert_eq!(sizes(1, 1), [(1, 1)]);
    }
}
