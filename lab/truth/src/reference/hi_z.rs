//! The Hi-Z chain on the CPU (thesis §4.2.4, Alg. 3, Eq. 4.1): the twin of `passes::hi_z` and
//! `shaders-glsl/thesis/hi_z.frag`. Both agree bit for bit, because only minima and maxima are taken.

use super::Level;

/// The least and the greatest standard depth that a cell of the chain has captured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinMax {
    /// Nearest depth.
    pub min: f32,
    /// Farthest depth.
    pub max: f32,
}

impl MinMax {
    /// A texel of a device's chain; `max` is NaN if the chain keeps no maxima.
    pub fn from_texel(texel: &[f32]) -> Self {
        Self { min: texel[0], max: texel.get(1).copied().unwrap_or(f32::NAN) }
    }
}

/// Eq. 4.1: the offset to the right (or down) of the second texel, for a side of the level below.
pub fn offset(side: u32) -> u32 {
    if side.is_multiple_of(2) { 1 } else { 2 }
}

/// Alg. 3 over a whole level, which must have a coarser one. The thesis does not say what a fetch beyond the
/// edge returns (which occurs for a side of 1); here, as in the shader, it returns the texel at the edge.
///
/// Four texels determine a cell, even if it covers six or nine, which is the erratum of Alg. 3.
pub fn reduce(below: &Level<MinMax>) -> Option<Level<MinMax>> {
    let (width, height) = below.coarser()?;
    let (offset_x, offset_y) = (offset(below.width), offset(below.height));
    Some(Level::from_fn(width, height, |x, y| {
        let (x, y) = (2 * x, 2 * y);
        let read = [(0, 0), (offset_x, 0), (0, offset_y), (offset_x, offset_y)];
        let z = read.map(|(dx, dy)| below.at_clamped(x + dx, y + dy));
        MinMax {
            min: z.map(|z| z.min).into_iter().fold(f32::INFINITY, f32::min),
            max: z.map(|z| z.max).into_iter().fold(f32::NEG_INFINITY, f32::max),
        }
    }))
}

/// The whole chain, whose level 0 is the given standard depth.
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

    /// A level of these standard depths.
    fn depth(width: u32, height: u32, texels: &[f32]) -> Level<f32> {
        Level { width, height, texels: texels.to_vec() }
    }

    #[test]
    fn an_even_level_takes_all_four_texels() {
        let c = chain(&depth(2, 2, &[0.4, 0.3, 0.9, 0.5]));
        assert_eq!(c.len(), 2);
        assert_eq!(c[1].texels, [MinMax { min: 0.3, max: 0.9 }]);
    }

    #[test]
    fn an_odd_level_skips_its_middle_texel() {
        // For a side of 3, Eq. 4.1 reads texels 0 and 2: the nearest texel, in the middle, is lost.
        let c = chain(&depth(3, 1, &[0.4, 0.1, 0.5]));
        assert_eq!(c[1].texels, [MinMax { min: 0.4, max: 0.5 }]);
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
