//! How long a divided study takes: the makespan of its shards, its lower bound, and the effect of slow machines and of
//! failures (docs/many-machines.md, "Plans").

use super::shard::{Share, owner_by_digest, owners};
use crate::math::random::Stream;
use crate::metrics::percentile;
use serde::Serialize;
use std::collections::BTreeMap;

/// The cost of each cell of each shard, in seconds, in the order in which the shard runs its cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    shards: Vec<Vec<f64>>,
}

impl Schedule {
    /// Cells as `--shard` divides them.
    pub fn divided(cells: &[Share], machines: u32) -> Self {
        Self::by(cells, machines, &owners(cells, machines))
    }

    /// Cells that are divided by `costs` instead of their own costs: `--shard` knows only the costs that are part of
    /// the program.
    pub fn divided_by(cells: &[Share], costs: &[Share], machines: u32) -> Self {
        Self::by(cells, machines, &owners(costs, machines))
    }

    /// Cells as their digests alone would divide them.
    pub fn by_digest(cells: &[Share], machines: u32) -> Self {
        let owner: Vec<u32> = cells.iter().map(|c| owner_by_digest(&c.setup, machines)).collect();
        Self::by(cells, machines, &owner)
    }

    fn by(cells: &[Share], machines: u32, owner: &[u32]) -> Self {
        let mut shards = vec![Vec::new(); machines.max(1) as usize];
        for (cell, owner) in unique(cells.iter().zip(owner)) {
            shards[*owner as usize - 1].push(cell.cost);
        }
        Self { shards }
    }

    /// Seconds that each shard takes.
    pub fn loads(&self) -> Vec<f64> {
        self.shards.iter().map(|cells| cells.iter().sum()).collect()
    }

    /// Seconds until the last shard is done.
    pub fn makespan(&self) -> f64 {
        self.loads().into_iter().fold(0.0, f64::max)
    }

    /// The makespan where some machines are slow and some tasks fail, over `runs` simulated runs.
    pub fn simulate(&self, trouble: &Trouble, runs: usize, seed: u64) -> Simulated {
        let shards = self.shards.len();
        let run = |run: usize| {
            let shard = |(n, cells): (usize, &Vec<f64>)| {
                let stream = Stream::new(seed, (run * shards + n) as u64);
                let mut drawn = 0;
                trouble.duration(cells, &mut || {
                    drawn += 1;
                    stream.uniform(drawn)
                })
            };
            self.shards.iter().enumerate().map(shard).fold(0.0, f64::max)
        };
        let mut makespans: Vec<f64> = (0..runs).map(run).collect();
        makespans.sort_by(f64::total_cmp);
        let of = |share| percentile(&makespans, share).unwrap_or(0.0);
        Simulated { runs, median_s: of(0.5), p95_s: of(0.95) }
    }
}

/// The first cell of each setup.
fn unique<'a>(cells: impl Iterator<Item = (&'a Share, &'a u32)>) -> impl Iterator<Item = (&'a Share, &'a u32)> {
    let mut seen = std::collections::BTreeSet::new();
    cells.filter(move |(cell, _)| seen.insert(cell.setup.as_str()))
}

/// Seconds of all cells one after the other, each setup once.
pub fn total_s(cells: &[Share]) -> f64 {
    cells.iter().map(|c| (c.setup.as_str(), c.cost)).collect::<BTreeMap<_, _>>().values().sum()
}

/// The fewest machines that are done as soon as the dearest cell alone is. More machines than these do not help.
pub fn enough(cells: &[Share]) -> u32 {
    let greatest = cells.iter().map(|c| c.cost).fold(0.0, f64::max);
    if greatest <= 0.0 {
        return 1;
    }
    let least = (total_s(cells) / greatest).floor().max(1.0) as u32;
    // A machine for each cell is always enough.
    let most = (cells.len() as u32).max(1);
    let is_enough = |n: &u32| Schedule::divided(cells, *n).makespan() <= greatest * (1.0 + 1e-9);
    (least.min(most)..most).find(is_enough).unwrap_or(most)
}

/// How often machines are slow and tasks fail.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trouble {
    /// The share of tasks whose machine is slow.
    pub stragglers: f64,
    /// The factor by which the tasks on slow machines take longer.
    pub slowdown: f64,
    /// The share of attempts at a task that fail before their end.
    pub failures: f64,
    /// Seconds until a failed task begins again.
    pub restart_s: f64,
}

impl Default for Trouble {
    /// One task of a hundred takes twice as long, and one attempt of a hundred fails and waits two minutes.
    fn default() -> Self {
        Self { stragglers: 0.01, slowdown: 2.0, failures: 0.01, restart_s: 120.0 }
    }
}

impl Trouble {
    /// How long a shard takes, in seconds. A failed attempt ends at a time that is uniformly distributed over the work
    /// that was left. The cells that were done by then stay in the journal, and the one that was begun begins anew.
    /// `uniform` draws numbers from 0 to 1.
    fn duration(&self, cells: &[f64], uniform: &mut dyn FnMut() -> f64) -> f64 {
        if cells.is_empty() {
            return 0.0;
        }
        let slowdown = if uniform() < self.stragglers { self.slowdown } else { 1.0 };
        let (mut elapsed, mut next) = (0.0, 0);
        loop {
            let left: f64 = cells[next..].iter().sum();
            if uniform() >= self.failures {
                return elapsed + slowdown * left;
            }
            let failed_at = uniform() * left;
            let mut done = 0.0;
            while next < cells.len() && done + cells[next] <= failed_at {
                done += cells[next];
                next += 1;
            }
            elapsed += slowdown * failed_at + self.restart_s;
        }
    }
}

/// Makespans over some simulated runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Simulated {
    /// How many runs were simulated.
    pub runs: usize,
    /// The median of the makespans, in seconds.
    pub median_s: f64,
    /// The 95th percentile of the makespans, in seconds.
    pub p95_s: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(costs: &[f64]) -> Vec<Share> {
        let share = |(n, cost): (usize, &f64)| Share { setup: format!("{n:016x}"), cost: *cost };
        costs.iter().enumerate().map(share).collect()
    }

    #[test]
    fn the_arithmetic_of_a_plan_by_hand() {
        let cells = cells(&[6.0, 5.0, 4.0, 3.0, 2.0]);
        assert_eq!(total_s(&cells), 20.0);
        assert_eq!(Schedule::divided(&cells, 1).makespan(), 20.0);
        // 6 | 5 | 4; then 3 to the third: 6 | 5 | 7; then 2 to the second: 6 | 7 | 7.
        assert_eq!(Schedule::divided(&cells, 3).makespan(), 7.0);
        assert_eq!(Schedule::divided(&cells, 3).loads(), [6.0, 7.0, 7.0]);
        // 6 | 5 | 4 | 3, then 2 to the fourth: no shard takes longer than the dearest cell.
        assert_eq!((enough(&cells), Schedule::divided(&cells, 4).makespan()), (4, 6.0));
        assert_eq!(Schedule::divided(&cells, 1000).makespan(), 6.0);
        // The digests are 0 to 4: of three shards, the first has 0 and 3, the second 1 and 4.
        assert_eq!(Schedule::by_digest(&cells, 3).loads(), [9.0, 7.0, 4.0]);
        // A cell that stands twice is run once.
        let twice = [&cells[..], &cells[..1]].concat();
        assert_eq!((total_s(&twice), Schedule::divided(&twice, 1).makespan()), (20.0, 20.0));
        assert_eq!((enough(&[]), total_s(&[]), Schedule::divided(&[], 3).makespan()), (1, 0.0, 0.0));
    }

    #[test]
    fn without_trouble_a_simulation_is_the_schedule() {
        let none = Trouble { stragglers: 0.0, failures: 0.0, ..Trouble::default() };
        let costs: Vec<f64> = (1..40).map(|n| f64::from(n * n % 17 + 1)).collect();
        for machines in [1, 3, 10, 100] {
            let schedule = Schedule::divided(&cells(&costs), machines);
            let found = schedule.simulate(&none, 50, 7);
            assert_eq!((found.median_s, found.p95_s), (schedule.makespan(), schedule.makespan()), "{machines}");
        }
    }

    #[test]
    fn slow_machines_and_failures_cost_what_they_should() {
        let schedule = Schedule::divided(&cells(&[100.0]), 1);
        let slow = Trouble { stragglers: 1.0, failures: 0.0, ..Trouble::default() };
        assert_eq!(schedule.simulate(&slow, 9, 1).median_s, 200.0);
        // An attempt fails at 30 of 60 seconds: the two cells that were done stay, and the third begins anew.
        let draws = [1.0, 0.0, 0.5, 1.0];
        let mut drawn = draws.into_iter();
        let failing = Trouble { stragglers: 0.0, slowdown: 1.0, failures: 0.5, restart_s: 7.0 };
        let took = failing.duration(&[10.0, 15.0, 20.0, 15.0], &mut || drawn.next().unwrap_or(1.0));
        assert_eq!(took, 30.0 + 7.0 + 35.0);
        // Among a hundred tasks, some are slow in most runs; a single task is hardly ever slow.
        let hundred = Schedule::divided(&cells(&[100.0; 100]), 100);
        assert!(hundred.simulate(&Trouble::default(), 300, 3).median_s > 150.0);
        assert_eq!(schedule.simulate(&Trouble::default(), 300, 3).median_s, 100.0);
        assert_eq!(hundred.simulate(&Trouble::default(), 300, 3), hundred.simulate(&Trouble::default(), 300, 3));
    }
}
