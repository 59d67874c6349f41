//! Blue noise, by void and cluster (Ulichney 1993): a tile of ranks in which the texels below any threshold are spread evenly.

use ssct_ground::math::random::Stream;

/// Texels along a side of the tile.
pub const RANKS_ACROSS: usize = 64;

/// Standard deviation of the Gaussian that says how crowded a place is, in texels.
const SIGMA: f64 = 1.9;

/// A tile of ranks as bytes, 0…255, each as often as any other; it repeats without seams.
pub fn tile() -> Vec<u8> {
    let all = RANKS_ACROSS * RANKS_ACROSS;
    let kernel: Vec<f64> = (0..all)
        .map(|k| {
            let wrapped = |d: usize| d.min(RANKS_ACROSS - d) as f64;
            let (x, y) = (wrapped(k % RANKS_ACROSS), wrapped(k / RANKS_ACROSS));
            (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp()
        })
        .collect();
    let mut tile = Pattern { kernel, set: vec![false; all], energy: vec![0.0; all] };
    let (random, mut drawn) = (Stream::new(1, 0), 0);
    while tile.count() < all / 10 {
        tile.change((random.uniform(drawn) * all as f64) as usize % all, true);
        drawn += 1;
    }
    // The most crowded set texel moves to the emptiest place, until it would move back to its own place.
    loop {
        let crowded = tile.extreme(true);
        tile.change(crowded, false);
        let void = tile.extreme(false);
        tile.change(void, true);
        if void == crowded {
            break;
        }
    }
    let mut rank = vec![0_usize; all];
    let first = tile.count();
    // The set texels have the lower ranks: the most crowded texel is taken away first, and has the highest of these
    // ranks.
    let mut thinned = Pattern { kernel: tile.kernel.clone(), set: tile.set.clone(), energy: tile.energy.clone() };
    for n in (0..first).rev() {
        let crowded = thinned.extreme(true);
        thinned.change(crowded, false);
        rank[crowded] = n;
    }
    // The other texels have the higher ranks: the emptiest place is filled first, and has the lowest of these ranks.
    for n in first..all {
        let void = tile.extreme(false);
        tile.change(void, true);
        rank[void] = n;
    }
    rank.into_iter().map(|n| (n * 256 / all) as u8).collect()
}

/// The texels that are set, and how crowded each place is by set texels.
struct Pattern {
    /// By how much a set texel at the origin crowds each place.
    kernel: Vec<f64>,
    set: Vec<bool>,
    /// How crowded each place is.
    energy: Vec<f64>,
}

impl Pattern {
    fn count(&self) -> usize {
        self.set.iter().filter(|set| **set).count()
    }

    /// Sets a texel or takes it away, and updates how crowded each place is.
    fn change(&mut self, texel: usize, set: bool) {
        if self.set[texel] == set {
            return;
        }
        self.set[texel] = set;
        let sign = if set { 1.0 } else { -1.0 };
        for (k, energy) in self.energy.iter_mut().enumerate() {
            let dx = (k % RANKS_ACROSS + RANKS_ACROSS - texel % RANKS_ACROSS) % RANKS_ACROSS;
            let dy = (k / RANKS_ACROSS + RANKS_ACROSS - texel / RANKS_ACROSS) % RANKS_ACROSS;
            *energy += sign * self.kernel[dy * RANKS_ACROSS + dx];
        }
    }

    /// The most crowded of the set texels, or the emptiest of the unset texels.
    fn extreme(&self, set: bool) -> usize {
        let places = (0..self.set.len()).filter(|k| self.set[*k] == set);
        let energy = |k: &usize| if set { -self.energy[*k] } else { self.energy[*k] };
        places.min_by(|a, b| energy(a).total_cmp(&energy(b))).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_differ_more_than_by_chance_and_every_byte_is_as_frequent() {
        let tile = tile();
        let mut count = [0; 256];
        tile.iter().for_each(|v| count[usize::from(*v)] += 1);
        assert!(count.iter().all(|n| *n == RANKS_ACROSS * RANKS_ACROSS / 256), "{count:?}");
        // The mean of 4 × 4 neighbours has a sixteenth of the variance of one texel if the noise is white. Blue noise
        // must have less than a quarter of this sixteenth.
        let variance = |side: usize| {
            let mean = |x: usize, y: usize| {
                let values = (0..side * side).map(|k| {
                    f64::from(tile[(y + k / side) % RANKS_ACROSS * RANKS_ACROSS + (x + k % side) % RANKS_ACROSS])
                });
                values.sum::<f64>() / (side * side) as f64
            };
            let all: Vec<f64> =
                (0..RANKS_ACROSS * RANKS_ACROSS).map(|k| mean(k % RANKS_ACROSS, k / RANKS_ACROSS)).collect();
            all.iter().map(|v| (v - 127.5) * (v - 127.5)).sum::<f64>() / all.len() as f64
        };
        assert!(variance(4) < 0.25 * variance(1) / 16.0, "{} of {}", variance(4), variance(1));
    }
}
