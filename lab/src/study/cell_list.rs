//! The cells of a run: all that the whole study has, and those that this run measures. It lies beside the journal, so
//! that shards can be put together by whoever does not know the command (docs/many-machines.md, "Shards").

use super::journal::setup_digest;
use super::record::Provenance;
use super::shard::{Shard, Share, owners};
use crate::gpu::DeviceInfo;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a run is of, and its cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellList {
    /// "error", "stress", "time", …
    pub kind: String,
    /// The version of docs/definitions.md that figures are of.
    pub definitions: u32,
    /// Of the program.
    pub version: String,
    /// Of its source.
    pub commit: String,
    /// The command of the whole study, as a page shows it.
    pub command: String,
    /// Which part of it this run is; null for the whole.
    pub shard: Option<Shard>,
    /// What the files of the run need to know that no cell says.
    pub settings: Value,
    /// Name and digest of each scene.
    pub scenes: Vec<(String, String)>,
    /// The devices that cells were measured on.
    pub devices: Vec<DeviceInfo>,
    /// Every cell of the whole study, in the order of its records.
    pub cells: Vec<ListedCell>,
}

/// A cell of the study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedCell {
    /// What people call it.
    pub name: String,
    /// A digest of all that it depends on but device and program.
    pub setup: String,
    /// Whether this run measures it.
    pub own: bool,
    /// Where the journal keeps its results.
    pub results: Vec<ListedResult>,
}

/// A result in the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedResult {
    /// Which of the devices, counted from 0.
    pub device: usize,
    /// Its key, or what the keys of its samples begin with.
    pub key: String,
    /// What the result is of, where the journal does not say it.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub of: Value,
}

/// A cell before it is known who runs it.
pub struct PlannedCell {
    /// What people call it.
    pub name: String,
    /// All that it depends on but device and program.
    pub setup: Value,
    /// What it is predicted to cost.
    pub cost: f64,
    /// Where the journal will keep its results: keys, and what they are of.
    pub results: Vec<(String, Value)>,
}

impl PlannedCell {
    /// A cell with one result.
    pub fn new(name: String, setup: Value, cost: f64, key: String) -> Self {
        Self { name, setup, cost, results: vec![(key, Value::Null)] }
    }

    /// What dividing needs of it.
    pub fn share(&self) -> Share {
        Share { setup: setup_digest(&self.setup), cost: self.cost }
    }
}

/// What a list is of, but for its cells.
pub struct CellListHead {
    /// "error", "stress", "time", …
    pub kind: &'static str,
    /// The version of docs/definitions.md that figures are of.
    pub definitions: u32,
    /// The command of the whole study.
    pub command: String,
    /// Which part of it this run is.
    pub shard: Option<Shard>,
    /// What the files of the run need to know that no cell says.
    pub settings: Value,
    /// Name and digest of each scene.
    pub scenes: Vec<(String, String)>,
}

impl CellList {
    /// The list of this program on a device.
    pub fn new(head: CellListHead, device: &DeviceInfo, cells: Vec<PlannedCell>) -> Self {
        let CellListHead { kind, definitions, command, shard, settings, scenes } = head;
        let shares: Vec<Share> = cells.iter().map(PlannedCell::share).collect();
        let owner = shard.map(|shard| owners(&shares, shard.of));
        let is_own = |n: usize| shard.zip(owner.as_ref()).is_none_or(|(shard, owner)| owner[n] == shard.index);
        let listed = cells.into_iter().zip(shares).enumerate().map(|(n, (cell, share))| {
            let result = |(key, of)| ListedResult { device: 0, key, of };
            let results = if is_own(n) { cell.results.into_iter().map(result).collect() } else { Vec::new() };
            ListedCell { name: cell.name, setup: share.setup, own: is_own(n), results }
        });
        Self {
            kind: kind.to_owned(),
            definitions,
            version: Provenance::VERSION.to_owned(),
            commit: Provenance::COMMIT.to_owned(),
            command,
            shard,
            settings,
            scenes,
            devices: vec![device.clone()],
            cells: listed.collect(),
        }
    }

    /// Whether this run measures a cell, by its place in the list.
    pub fn owns(&self, cell: usize) -> bool {
        self.cells.get(cell).is_some_and(|c| c.own)
    }

    /// How many cells this run measures.
    pub fn owned(&self) -> usize {
        self.cells.iter().filter(|c| c.own).count()
    }

    /// What this run and another must have in common to be of one study, each with its name; in this order they are
    /// compared.
    pub fn in_common(&self) -> [(&'static str, String); 6] {
        let scenes: Vec<String> = self.scenes.iter().map(|(name, digest)| format!("{name} {digest}")).collect();
        [
            ("kind", self.kind.clone()),
            ("version", self.version.clone()),
            ("commit", self.commit.clone()),
            ("version of the definitions", self.definitions.to_string()),
            ("list of scenes", scenes.join(", ")),
            ("choice of settings", self.settings.to_string()),
        ]
    }
}
