//! The Hi-Z chain on the CPU (thesis §4.2.4, Alg. 3, Eq. 4.1): the twin of `passes::hi_z` and of
//! `shaders-glsl/thesis/hi_z.frag`. Equal to the bit, as only minima and maxima are taken.

use super::Level;

/// Least and greatest standard depth that a cell has captured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinMax {
    /// Nearest.
    pub min: f32,
    /// Farthest.
    pub max: f32,
}

/// Eq. 4.1: how far right (or down) the second texel lies, for a side of the level below.
pub fn offset(side: u32) -> u32 {
    if side.is_multiple_of(2) { 1 } else { 2 }
}

/// Alg. 3 over a whole level, which must have a coarser one. The thesis does not say what a fetch
/// beyond the edge returns (a side of 1 has one); here, as in the shader, it is the edge's texel.
///
/// Four texels stand for a cell, also where it covers six or nine: the erratum of Alg. 3.
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

/// The whole chain over a level of standard depth, which is its level 0.
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
        // Eq. 4.1 reads texels 0 and 2 of a side of 3: the nearest one, in the middle, is lost.
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
