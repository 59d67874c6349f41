//! Changes from run to run: the total times of each run are compared with those of an earlier run, as `ssct compare` does. The
//! earlier run is the latest one on the same device that timed something in common.

use super::LibraryRun;
use crate::study::compare::{self, Run, TOTAL, TimeComparison, TimeSample};
use std::sync::Arc;

/// A run compared with an earlier one.
#[derive(Debug, Clone, PartialEq)]
pub struct RunChange {
    /// Index of the earlier run in the library.
    pub before: usize,
    /// Index of the later run.
    pub after: usize,
    /// A record for each total that both runs have.
    pub totals: Vec<TimeComparison>,
}

/// The change of each run that has an earlier run to compare with, in the order of the library. `threshold` is the
/// change of a time that counts, as a share, at least 0 and below 1.
pub fn changes(library: &[LibraryRun], threshold: f64) -> Vec<RunChange> {
    let mut found = Vec::new();
    for (after, run) in library.iter().enumerate() {
        let Some(b) = &run.samples else { continue };
        let earlier = library[..after].iter().enumerate().rev();
        let before = earlier.filter_map(|(before, run)| Some((before, run.samples.as_ref()?)));
        let mut same_device = before.filter(|(_, a)| a.device.is_some() && a.device == b.device);
        found.extend(same_device.find_map(|(before, a)| {
            let mut totals = compare::times(a, b, threshold);
            totals.retain(|record| record.only_in.is_none());
            (!totals.is_empty()).then_some(RunChange { before, after, totals })
        }));
    }
    found
}

/// Reduces each frame of a run to one sample: the sum of the counted passes, under the name of the total.
pub fn totals_only(run: Run) -> Run {
    let frame = |rows: &[TimeSample]| {
        let first = rows.iter().find(|row| row.counted)?;
        Some(TimeSample {
            subject: Arc::clone(&first.subject),
            sample: first.sample,
            pass: TOTAL.to_owned(),
            // The comparison would add counted rows up to another total.
            counted: false,
            ms: rows.iter().filter(|row| row.counted).map(|row| row.ms).sum(),
            floors: [first.floors[1]; 2],
        })
    };
    let frames = run.samples.chunk_by(|a, b| a.sample == b.sample && a.subject == b.subject);
    Run { samples: frames.filter_map(frame).collect(), ..run }
}
