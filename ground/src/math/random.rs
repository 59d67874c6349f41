//! Counter-based random numbers: each number is a hash of its purpose, so that images do not depend on the
//! number of threads or on the order of pixels.

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number
/// Generators", Fig. 15): a bijection whose every output bit depends on every input bit.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The step between the inputs of [`mix`]: 2⁶⁴ divided by the golden ratio, rounded to an odd number.
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

/// The random numbers for one purpose, given by a seed and an index such as that of a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Stream(u64);

impl Stream {
    /// The stream of a seed and an index. Both are mixed, so that streams of neighbouring indices are unrelated.
    pub fn new(seed: u64, index: u64) -> Self {
        Self(mix(mix(seed.wrapping_add(GOLDEN_GAMMA)).wrapping_add(index.wrapping_mul(GOLDEN_GAMMA))))
    }

    /// The number at a position: 0 ≤ u < 1, in steps of 2⁻⁵³.
    pub fn uniform(&self, position: u64) -> f64 {
        let bits = mix(self.0.wrapping_add(position.wrapping_add(1).wrapping_mul(GOLDEN_GAMMA)));
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_within_and_across_streams() {
        let n = 1 << 16;
        let within: Vec<f64> = (0..n).map(|i| Stream::new(1, 2).uniform(i)).collect();
        let across: Vec<f64> = (0..n).map(|i| Stream::new(1, i).uniform(0)).collect();
        for numbers in [within, across] {
            // χ² over 64 bins has 63 degrees of freedom: mean 63, standard deviation 11.2.
            let mut bins = [0_u32; 64];
            numbers.iter().for_each(|u| bins[(u * 64.0) as usize] += 1);
            let expected = n as f64 / 64.0;
            let chi2: f64 = bins.iter().map(|b| (f64::from(*b) - expected).powi(2) / expected).sum();
            assert!((63.0 - 45.0..63.0 + 45.0).contains(&chi2), "χ² {chi2}");
            // Neighbours are uncorrelated: the mean product has the standard deviation 1 / (12 √n).
            let pairs = numbers.windows(2).map(|p| (p[0] - 0.5) * (p[1] - 0.5)).sum::<f64>() / n as f64;
            assert!(pairs.abs() < 4.0 / (12.0 * (n as f64).sqrt()), "{pairs}");
        }
    }

    #[test]
    fn seeds_and_indices_differ() {
        let first = |seed, index| Stream::new(seed, index).uniform(0);
        assert_ne!(first(0, 0), first(0, 1));
        assert_ne!(first(0, 0), first(1, 0));
        assert_eq!(first(3, 4), first(3, 4));
    }
}
