//! Shards: the cells of a study divided among machines that know nothing of each other (docs/many-machines.md,
//! "Shards"). The shard of a cell follows from the setups of all cells and from their predicted costs, and not from the
//! order of the cells, the device or the machine, so that every machine divides a study in the same way.

use crate::reference::partial_sums::LEAF;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// One of several shards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// The number of this shard, from 1 to `of`.
    pub index: u32,
    /// How many shards there are.
    pub of: u32,
}

/// The greatest number of shards that a study can be divided into.
const MOST: u32 = 1_000_000;

impl FromStr for Shard {
    type Err = String;

    /// Reads `3/8`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is no shard; write it as 3/8, the third of eight");
        let (index, of) = text.split_once('/').ok_or_else(wrong)?;
        match (index.trim().parse(), of.trim().parse()) {
            (Ok(index), Ok(of)) if (1..=of).contains(&index) && of <= MOST => Ok(Self { index, of }),
            (Ok(index), Ok(of)) if of <= MOST => {
                let index: u32 = index;
                Err(format!("there is no shard {index} of {of}: shards are counted from 1 to their number"))
            }
            (Ok(_), Ok(_)) => Err(format!("{text:?} has more than {MOST} shards")),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

/// What has to be known of a cell to divide a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Share {
    /// A digest of the cell's setup, as [`super::journal::setup_digest`] makes it. Cells of one setup are one cell.
    pub setup: String,
    /// The predicted cost of the cell, ≥ 0, in seconds or in any other unit.
    pub cost: f64,
}

/// The shard that runs each cell, counted from 1, in the order of the cells.
///
/// The dearest cell goes first, and each goes to the shard that has least to do until then, of several to the one with
/// the fewest cells, of these to the first. Cells of equal cost are dealt in the order of their digests (the rule
/// "longest processing time first": Graham 1969).
pub fn owners(cells: &[Share], of: u32) -> Vec<u32> {
    let unique: BTreeMap<&str, f64> = cells.iter().map(|c| (c.setup.as_str(), c.cost)).collect();
    let mut order: Vec<(&str, f64)> = unique.into_iter().collect();
    // The sort is stable: cells of equal cost stay in the order of their digests.
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    // The cost and the number of the cells of each shard. More shards than there are cells never get one.
    let mut loads = vec![(0.0_f64, 0_u32); order.len().min(of.max(1) as usize)];
    let mut owner = BTreeMap::new();
    for (setup, cost) in order {
        let shards = loads.iter_mut().zip(1_u32..);
        let least =
            shards.min_by(|((load, cells), _), ((other, others), _)| load.total_cmp(other).then(cells.cmp(others)));
        let Some(((load, cells), shard)) = least else { continue };
        *load += cost;
        *cells += 1;
        owner.insert(setup, shard);
    }
    cells.iter().map(|c| owner[c.setup.as_str()]).collect()
}

/// The shard of a cell if its digest alone decided. Plans compare [`owners`] with this division.
pub fn owner_by_digest(setup: &str, of: u32) -> u32 {
    let number = u64::from_str_radix(setup.get(..16).unwrap_or(setup), 16).unwrap_or(0);
    (number % u64::from(of.max(1))) as u32 + 1
}

/// A cell whose rays are divided.
#[derive(Debug, Clone, PartialEq)]
pub struct RayShare {
    /// A digest of the cell's setup.
    pub setup: String,
    /// The predicted cost of all rays of the cell.
    pub cost: f64,
    /// Rays a pixel.
    pub rays: u32,
}

/// The rays that one shard takes: cells by their places, each with the numbers of its rays, in whole groups ([`LEAF`]).
pub type RaysOfShard = Vec<(usize, Range<u32>)>;

/// The rays that each shard takes. The cells are put in the order of their digests, and the sequence of all their rays
/// is cut wherever a shard has its share of the cost, so that each shard has few cells.
pub fn rays_of_shards(cells: &[RayShare], of: u32) -> Vec<RaysOfShard> {
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by(|a, b| cells[*a].setup.cmp(&cells[*b].setup));
    order.dedup_by(|a, b| cells[*a].setup == cells[*b].setup);
    let total: f64 = order.iter().map(|n| cells[*n].cost).sum();
    // If no cell has a cost, each costs as much as it has rays.
    let cost = |n: usize| if total > 0.0 { cells[n].cost } else { f64::from(cells[n].rays) };
    let total: f64 = order.iter().map(|n| cost(*n)).sum();
    let mut shards = vec![Vec::new(); of.max(1) as usize];
    let mut before = 0.0;
    for n in order {
        let groups = cells[n].rays.div_ceil(LEAF);
        for group in 0..groups {
            let each = cost(n) / f64::from(groups);
            let middle = before + (f64::from(group) + 0.5) * each;
            let shard = ((middle / total * f64::from(of)) as usize).min(shards.len() - 1);
            let rays = group * LEAF..((group + 1) * LEAF).min(cells[n].rays);
            let taken: &mut RaysOfShard = &mut shards[shard];
            match taken.last_mut() {
                Some((cell, last)) if *cell == n => last.end = rays.end,
                _ => taken.push((n, rays)),
            }
        }
        before += cost(n);
    }
    shards
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::journal::setup_digest;
    use proptest::prelude::*;
    use serde_json::json;

    fn shares(costs: &[u32]) -> Vec<Share> {
        let share =
            |(n, cost): (usize, &u32)| Share { setup: setup_digest(&json!(["cell", n])), cost: f64::from(*cost) };
        costs.iter().enumerate().map(share).collect()
    }

    #[test]
    fn a_shard_is_written_as_it_is_read() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, of: 8 }));
        assert_eq!(Shard { index: 3, of: 8 }.to_string(), "3/8");
        for wrong in ["0/8", "9/8", "1/0", "1", "a/b", "-1/2", "1/2/3", "1/1000001"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_dearest_goes_first_and_to_the_shard_that_has_least() {
        // By hand: 8 | 7; then 6 goes to the second shard: 8 | 13; 5 to the first: 13 | 13; and 4 to the first: 17 |
        // 13.
        let owner = owners(&shares(&[4, 5, 6, 7, 8]), 2);
        let load =
            |shard| -> u32 { [4, 5, 6, 7, 8].iter().zip(&owner).filter(|(_, o)| **o == shard).map(|(c, _)| c).sum() };
        assert_eq!((load(1), load(2)), (17, 13));
        assert_eq!(owner[4], 1);
        let digest = setup_digest(&json!("a"));
        assert!((1..=7).contains(&owner_by_digest(&digest, 7)) && owner_by_digest(&digest, 1) == 1);
    }

    proptest! {
        /// Every cell has one owner, for every number of shards and every order of the cells; and no shard has more
        /// than a bounded cost.
        #[test]
        fn every_cell_has_one_owner_whatever_their_order(
            costs in proptest::collection::vec(1_u32..1000, 1..60),
            of in 1_u32..80,
            turn in 0_usize..60,
        ) {
            let cells = shares(&costs);
            let owner = owners(&cells, of);
            prop_assert!(owner.iter().all(|o| (1..=of).contains(o)));
            let mut turned = cells.clone();
            turned.rotate_left(turn % cells.len());
            turned.reverse();
            let owner_of_turned = owners(&turned, of);
            for (cell, own) in cells.iter().zip(&owner) {
                let at = turned.iter().position(|c| c == cell).unwrap();
                prop_assert_eq!(*own, owner_of_turned[at]);
            }
            // No shard has more than the mean cost and that of one cell on top of it.
            let (total, greatest) = (costs.iter().sum::<u32>(), *costs.iter().max().unwrap());
            for shard in 1..=of {
                let load: u32 = costs.iter().zip(&owner).filter(|(_, o)| **o == shard).map(|(c, _)| *c).sum();
                prop_assert!(f64::from(load) <= f64::from(total) / f64::from(of) + f64::from(greatest));
            }
        }
    }

    #[test]
    fn cells_that_cost_nothing_are_dealt_in_turn() {
        let owner = owners(&shares(&[0; 7]), 3);
        let count = |shard| owner.iter().filter(|o| **o == shard).count();
        assert_eq!([1, 2, 3].map(count), [3, 2, 2]);
    }

    #[test]
    fn every_ray_is_in_one_shard_and_shares_are_even() {
        let digest = |n: usize| setup_digest(&json!(["cell", n]));
        let cell = |(n, (cost, rays)): (usize, &(f64, u32))| RayShare { setup: digest(n), cost: *cost, rays: *rays };
        let cells: Vec<_> = [(8.0, 1024), (1.0, 1000), (4.0, 64), (3.0, 512)].iter().enumerate().map(cell).collect();
        for of in [1, 2, 3, 7, 100] {
            let shards = rays_of_shards(&cells, of);
            let mut all: RaysOfShard = shards.iter().flatten().cloned().collect();
            all.sort_by_key(|(cell, rays)| (*cell, rays.start));
            for (n, cell) in cells.iter().enumerate() {
                let of: Vec<_> = all.iter().filter(|(m, _)| *m == n).map(|(_, rays)| rays.clone()).collect();
                assert!(of.windows(2).all(|w| w[0].end == w[1].start && w[0].end.is_multiple_of(LEAF)));
                assert_eq!((of.first().map(|r| r.start), of.last().map(|r| r.end)), (Some(0), Some(cell.rays)));
            }
            let load = |shard: &RaysOfShard| -> f64 {
                shard.iter().map(|(n, r)| cells[*n].cost * r.len() as f64 / f64::from(cells[*n].rays)).sum()
            };
            // The dearest group, of the third cell, costs 4.
            assert!(shards.iter().map(load).fold(0.0, f64::max) <= 16.0 / f64::from(of) + 4.1);
        }
        let free: Vec<_> = cells.iter().map(|c| RayShare { cost: 0.0, ..c.clone() }).collect();
        assert!(rays_of_shards(&free, 3).iter().all(|shard| !shard.is_empty()));
        assert_eq!(rays_of_shards(&[], 2), [vec![], vec![]]);
    }

    #[test]
    fn two_cells_of_one_setup_have_one_owner() {
        let mut cells = shares(&[1, 1, 1]);
        cells.push(cells[0].clone());
        let owner = owners(&cells, 3);
        assert_eq!(owner[0], owner[3]);
        assert_eq!(owner[..3].iter().collect::<std::collections::BTreeSet<_>>().len(), 3);
    }
}
