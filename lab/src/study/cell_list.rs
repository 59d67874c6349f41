//! The list of a run's cells: all cells of the whole study, and which of them this run measures. The list lies beside
//! the journal, so that shards can be merged without their commands (docs/many-machines.md, "Shards").

use super::journal::setup_digest;
use super::record::Provenance;
use super::shard::{Shard, owners};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use ssct::gpu::DeviceInfo;

/// The cells of a run, with everything that must be equal in two runs of one study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellList {
    /// The kind of study: "error", "stress", "time", …
    pub kind: String,
    /// The version of docs/definitions.md that the figures follow.
    pub definitions: u32,
    /// The version of the program.
    pub version: String,
    /// The commit of the program's source.
    pub commit: String,
    /// The command of the whole study, as a page shows it.
    pub command: String,
    /// The shard that this run is; null for the whole study.
    pub shard: Option<Shard>,
    /// Settings that the files of the run depend on, and that are not part of any cell.
    pub settings: Value,
    /// Name and digest of each scene.
    pub scenes: Vec<(String, String)>,
    /// The devices that cells were measured on.
    pub devices: Vec<DeviceInfo>,
    /// Every cell of the whole study, in the order of its records.
    pub cells: Vec<ListedCell>,
}

/// A cell of the study, as the list keeps it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedCell {
    /// The name of the cell, for people.
    pub name: String,
    /// A digest of everything, except the device and the program, that the cell depends on.
    pub setup: String,
    /// Whether this run measures the cell.
    #[serde(rename = "own")]
    pub is_own: bool,
    /// Where the journal keeps the results of the cell.
    pub results: Vec<ListedResult>,
}

/// A result of a cell, which the journal keeps as a whole or as samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedResult {
    /// The device that measures the result, as an index into the list of devices.
    pub device: usize,
    /// The key of the result in the journal; if the journal keeps samples, the common beginning of their keys.
    pub key: String,
    /// The first fields of the result's record, which its samples in the journal lack; null if the journal keeps whole
    /// records.
    #[serde(rename = "of", default, skip_serializing_if = "Value::is_null")]
    pub record_head: Value,
}

/// A cell before the study is divided into shards.
pub struct PlannedCell {
    /// The name of the cell, for people.
    pub name: String,
    /// Everything, except the device and the program, that the cell depends on.
    pub setup: Value,
    /// Where the journal will keep the results: `key` and `record_head` of each [`ListedResult`].
    pub results: Vec<(String, Value)>,
}

impl PlannedCell {
    /// A cell with one result, which the journal keeps as a whole under `key`.
    pub fn new(name: String, setup: Value, key: String) -> Self {
        Self { name, setup, results: vec![(key, Value::Null)] }
    }
}

/// The fields of a [`CellList`], except its cells, that a command decides.
pub struct CellListHead {
    /// The kind of study: "error", "stress", "time", …
    pub kind: &'static str,
    /// The version of docs/definitions.md that the figures follow.
    pub definitions: u32,
    /// The command of the whole study.
    pub command: String,
    /// The shard that this run is; `None` for the whole study.
    pub shard: Option<Shard>,
    /// Settings that the files of the run depend on, and that are not part of any cell.
    pub settings: Value,
    /// Name and digest of each scene.
    pub scenes: Vec<(String, String)>,
}

impl CellList {
    /// Makes the list of a run of this program on a device. The run owns the cells of its shard, or all cells without a
    /// shard.
    pub fn new(head: CellListHead, device: &DeviceInfo, cells: Vec<PlannedCell>) -> Self {
        let CellListHead { kind, definitions, command, shard, settings, scenes } = head;
        let setups: Vec<String> = cells.iter().map(|cell| setup_digest(&cell.setup)).collect();
        let shard_and_owners = shard.map(|shard| (shard, owners(&setups, shard.count)));
        let is_own =
            |index: usize| shard_and_owners.as_ref().is_none_or(|(shard, owners)| owners[index] == shard.index);
        let listed = cells.into_iter().zip(setups).enumerate().map(|(index, (cell, setup))| {
            let result = |(key, record_head)| ListedResult { device: 0, key, record_head };
            let results = if is_own(index) { cell.results.into_iter().map(result).collect() } else { Vec::new() };
            ListedCell { name: cell.name, setup, is_own: is_own(index), results }
        });
        Self {
            kind: kind.to_owned(),
            definitions,
            version: Provenance::VERSION.to_owned(),
            commit: Provenance::commit(),
            command,
            shard,
            settings,
            scenes,
            devices: vec![device.clone()],
            cells: listed.collect(),
        }
    }

    /// Returns the items whose cells this run measures; `items` has an item for each cell, in the list's order.
    pub fn select_own<'a, T>(&'a self, items: &'a [T]) -> impl Iterator<Item = &'a T> {
        items.iter().zip(&self.cells).filter(|(_, cell)| cell.is_own).map(|(item, _)| item)
    }

    /// Returns how many cells this run measures.
    pub fn count_own(&self) -> usize {
        self.cells.iter().filter(|c| c.is_own).count()
    }

    /// Returns names and values of the properties in which two runs of one study must be equal, in the order in which
    /// they are compared.
    pub fn must_agree(&self) -> [(&'static str, String); 6] {
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
