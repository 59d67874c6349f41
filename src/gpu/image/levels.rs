//! The number of mip levels and their sizes.

/// The number of levels of a full mip chain: 1 + floor(log2(max side)).
pub fn full_chain(extent: [u32; 2]) -> u32 {
    extent[0].max(extent[1]).max(1).ilog2() + 1
}

/// Width and height of a mip level: halved, rounded down, at least 1.
pub fn level_extent(extent: [u32; 2], level: u32) -> [u32; 2] {
    [(extent[0] >> level).max(1), (extent[1] >> level).max(1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_have_the_levels_of_the_specification() {
        assert_eq!(full_chain([1, 1]), 1);
        assert_eq!(full_chain([641, 479]), 10);
        assert_eq!(full_chain([1, 512]), 10);
        assert_eq!(level_extent([641, 479], 3), [80, 59]);
        assert_eq!(level_extent([641, 479], 9), [1, 1]);
    }
}
