//! Shards divide the cells of a study among machines that do not communicate (docs/many-machines.md, "Shards"). The
//! shard of a cell follows from the setups of all cells, and not from their order, the device or the machine, so that
//! every machine divides a study in the same way.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::str::FromStr;

/// One of the shards into which a study is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// The number of this shard, from 1 to `count`.
    pub index: u32,
    /// The number of shards.
    #[serde(rename = "of")]
    pub count: u32,
}

/// The greatest number of shards that a study can be divided into.
const MOST: u32 = 1_000_000;

impl FromStr for Shard {
    type Err = String;

    /// Reads a shard such as `3/8`, the third of eight.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is no shard; write it as 3/8, the third of eight");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        match (index.trim().parse(), count.trim().parse()) {
            (Ok(index), Ok(count)) if (1..=count).contains(&index) && count <= MOST => Ok(Self { index, count }),
            (Ok(index), Ok(count)) if count <= MOST => {
                let index: u32 = index;
                Err(format!("there is no shard {index} of {count}: shards are counted from 1 to their number"))
            }
            (Ok(_), Ok(_)) => Err(format!("{text:?} has more than {MOST} shards")),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Returns the number of the shard that each cell belongs to, from 1 to `count`. `setups` has the digest of each cell's
/// setup ([`super::journal::setup_digest`]). The distinct digests are sorted, and dealt to the shards in turn, so that
/// cells with the same setup belong to the same shard.
pub fn owners(setups: &[String], count: u32) -> Vec<u32> {
    let distinct_setups: BTreeSet<&str> = setups.iter().map(String::as_str).collect();
    let shard_of: BTreeMap<&str, u32> = distinct_setups.into_iter().zip((1..=count.max(1)).cycle()).collect();
    setups.iter().map(|setup| shard_of[setup.as_str()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::journal::setup_digest;
    use proptest::prelude::*;
    use serde_json::json;

    /// Makes the digests of the setups of some cells, which all differ.
    fn setups(cells: usize) -> Vec<String> {
        (0..cells).map(|n| setup_digest(&json!(["cell", n]))).collect()
    }

    #[test]
    fn a_shard_is_written_as_it_is_read() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
        assert_eq!(Shard { index: 3, count: 8 }.to_string(), "3/8");
        for wrong in ["0/8", "9/8", "1/0", "1", "a/b", "-1/2", "1/2/3", "1/1000001"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    proptest! {
        /// Tests that a cell belongs to the same shard in every order of the cells, and that the numbers of cells of
        /// two shards differ by one at most.
        #[test]
        fn every_cell_has_one_owner_whatever_their_order(
            cells in 1_usize..60,
            count in 1_u32..80,
            turn in 0_usize..60,
        ) {
            let cells = setups(cells);
            let owner = owners(&cells, count);
            let mut turned = cells.clone();
            turned.rotate_left(turn % cells.len());
            turned.reverse();
            let owner_of_turned = owners(&turned, count);
            for (cell, shard) in cells.iter().zip(&owner) {
                let index = turned.iter().position(|c| c == cell).unwrap();
                prop_assert_eq!(*shard, owner_of_turned[index]);
            }
            let counts: Vec<_> = (1..=count).map(|shard| owner.iter().filter(|o| **o == shard).count()).collect();
            prop_assert_eq!(counts.iter().sum::<usize>(), cells.len());
            prop_assert!(counts.iter().max().unwrap() - counts.iter().min().unwrap() <= 1);
        }
    }

    #[test]
    fn two_cells_of_one_setup_have_one_owner() {
        let mut cells = setups(3);
        cells.push(cells[0].clone());
        let owner = owners(&cells, 3);
        assert_eq!(owner[0], owner[3]);
        assert_eq!(owner[..3].iter().collect::<BTreeSet<_>>().len(), 3);
    }
}
