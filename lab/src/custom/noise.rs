//! Makes blue noise by void and cluster (Ulichney 1993): a tile of ranks in which the texels below any threshold are
//! spread evenly.

use ssct_ground::math::random::Stream;

/// Texels along a side of the tile.
pub const RANKS_ACROSS: usize = 64;

/// Standard deviation of the Gaussian that says how crowded a place is, in texels.
const SIGMA: f64 = 1.9;

/// Makes a tile of ranks, row by row: the bytes from 0 to 255, each as often as any other. The tile repeats without
/// seams.
pub fn tile() -> Vec<u8> {
    let texels = RANKS_ACROSS * RANKS_ACROSS;
    let kernel: Vec<f64> = (0..texels)
        .map(|texel| {
            let wrapped = |d: usize| d.min(RANKS_ACROSS - d) as f64;
            let (x, y) = (wrapped(texel % RANKS_ACROSS), wrapped(texel / RANKS_ACROSS));
            (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp()
        })
        .collect();
    let mut tile = Pattern { kernel, set: vec![false; texels], energy: vec![0.0; texels] };
    // The pattern begins with a tenth of the texels, at random places.
    let (random, mut drawn) = (Stream::new(1, 0), 0);
    while tile.count() < texels / 10 {
        tile.change((random.uniform(drawn) * texels as f64) as usize % texels, true);
        drawn += 1;
    }
    // The most crowded set texel moves to the emptiest place, again and again, until that is its own place.
    loop {
        let crowded = tile.extreme(true);
        tile.change(crowded, false);
        let void = tile.extreme(false);
        tile.change(void, true);
        if void == crowded {
            break;
        }
    }
    let mut rank = vec![0_usize; texels];
    let first = tile.count();
    // The set texels get the lower ranks. They are taken away one by one, the most crowded first, which gets the
    // highest of these ranks.
    let mut thinned = Pattern { kernel: tile.kernel.clone(), set: tile.set.clone(), energy: tile.energy.clone() };
    for n in (0..first).rev() {
        let crowded = thinned.extreme(true);
        thinned.change(crowded, false);
        rank[crowded] = n;
    }
    // The other texels get the higher ranks. They are filled one by one, the emptiest place first, which gets the
    // lowest of these ranks.
    for n in first..texels {
        let void = tile.extreme(false);
        tile.change(void, true);
        rank[void] = n;
    }
    rank.into_iter().map(|n| (n * 256 / texels) as u8).collect()
}

/// The texels that are set, and how crowded each place is by set texels.
struct Pattern {
    /// By how much a set texel at the origin crowds each place.
    kernel: Vec<f64>,
    /// True for each texel that is set.
    set: Vec<bool>,
    /// How crowded each place is.
    energy: Vec<f64>,
}

impl Pattern {
    /// The number of set texels.
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
        for (place, energy) in self.energy.iter_mut().enumerate() {
            let dx = (place % RANKS_ACROSS + RANKS_ACROSS - texel % RANKS_ACROSS) % RANKS_ACROSS;
            let dy = (place / RANKS_ACROSS + RANKS_ACROSS - texel / RANKS_ACROSS) % RANKS_ACROSS;
            *energy += sign * self.kernel[dy * RANKS_ACROSS + dx];
        }
    }

    /// Returns the most crowded of the set texels if `set` is true, or else the emptiest of the unset texels.
    fn extreme(&self, set: bool) -> usize {
        let places = (0..self.set.len()).filter(|place| self.set[*place] == set);
        let energy = |place: &usize| if set { -self.energy[*place] } else { self.energy[*place] };
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
